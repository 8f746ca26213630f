//! Contacts drawn in millimetres and laid on an array of any size. The proportions are our own drawing.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use crate::sensor::Array;

/// An elliptic contact.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pad {
    /// Centre, mm along and across the drawing.
    centre: [f64; 2],
    /// Semi-axes, mm along and across.
    half: [f64; 2],
    /// Its highest pressure as a share of the drawing's highest.
    share: f64,
    /// The part of the body it belongs to, for movement.
    pub(super) group: usize,
}

const fn pad(centre: [f64; 2], half: [f64; 2], share: f64, group: usize) -> Pad {
    Pad {
        centre,
        half,
        share,
        group,
    }
}

/// Pads and the rectangle they fill.
#[derive(Debug, Clone)]
pub(super) struct Drawing {
    /// Length and width, mm; the length goes along the array's longer side.
    size: [f64; 2],
    pads: Vec<Pad>,
}

/// Parts of a hand that move on their own: the palm, thumb and four fingers.
pub(super) const HAND_GROUPS: usize = 6;
/// Heel and forefoot.
pub(super) const FOOT_GROUPS: usize = 2;
const THUMB: usize = 5;
/// What a pad of a hand is called: the part of the hand, and of a finger the phalanx.
#[derive(Debug, Clone, Copy)]
pub(super) struct PadNames {
    pub(super) part: &'static str,
    pub(super) phalanx: &'static str,
}

/// Of each pad of [`hand`], in its order.
pub(super) fn hand_pad_names() -> Vec<PadNames> {
    let pad = |part, phalanx| PadNames { part, phalanx };
    let same = |part| pad(part, part);
    let mut names = vec![same("palm"), same("palm"), same("thumb"), same("thumb")];
    for (part, phalanges) in [
        ("index", ["index proximal", "index middle", "index distal"]),
        (
            "middle",
            ["middle proximal", "middle middle", "middle distal"],
        ),
        ("ring", ["ring proximal", "ring middle", "ring distal"]),
        (
            "little",
            ["little proximal", "little middle", "little distal"],
        ),
    ] {
        names.push(same("palm"));
        names.extend(phalanges.map(|phalanx| pad(part, phalanx)));
    }
    names
}

/// A right hand around a cylinder, unrolled: the fingers reach round one way, the thumb the other.
pub(super) fn hand() -> Drawing {
    let mut pads = vec![
        pad([62.0, 28.0], [27.0, 16.0], 0.36, 0), // ball of the thumb
        pad([62.0, 75.0], [30.0, 13.0], 0.32, 0), // the palm's other side
        pad([16.0, 32.0], [12.0, 9.0], 0.90, THUMB),
        pad([40.0, 25.0], [10.0, 7.5], 0.35, THUMB),
    ];
    // Index to little finger: place across, reach, and how hard its tip presses.
    let fingers = [
        (13.0, 0.97, 0.85),
        (35.0, 1.06, 1.0),
        (56.0, 1.0, 0.8),
        (77.0, 0.84, 0.55),
    ];
    for (i, (across, reach, strength)) in fingers.into_iter().enumerate() {
        let at = |along: f64| [100.0 + reach * (along - 100.0), across];
        pads.push(pad([102.0, across], [11.0, 10.0], 0.45 * strength, 0)); // ridge of the palm
        pads.push(pad(at(127.0), [10.5, 8.0], 0.42 * strength, i + 1));
        pads.push(pad(at(152.0), [9.5, 7.5], 0.55 * strength, i + 1));
        pads.push(pad(at(176.0), [10.5, 7.5], strength, i + 1));
    }
    Drawing {
        size: [195.0, 92.0],
        pads,
    }
}

/// The tips of the first `tips` of index, middle, ring, little finger and thumb, put down as on a table; each is its
/// own group.
pub(super) fn finger_tips(tips: usize) -> Drawing {
    let centres = [
        [78.0, 36.0],
        [86.0, 59.0],
        [80.0, 81.0],
        [62.0, 100.0],
        [22.0, 14.0],
    ];
    let pads = centres[..tips.clamp(1, 5)]
        .iter()
        .enumerate()
        .map(|(i, &centre)| {
            let half = if i == 4 { [11.0, 9.0] } else { [9.0, 7.0] };
            pad(centre, half, [0.9, 1.0, 0.85, 0.7, 1.0][i], i)
        })
        .collect();
    Drawing {
        size: [100.0, 112.0],
        pads,
    }
    .cropped()
}

/// One left foot, or a left and a right one side by side; heel and forefoot of each are groups.
pub(super) fn feet(soles: usize) -> Drawing {
    let mut one = vec![
        pad([37.0, 48.0], [31.0, 26.0], 1.0, 0),   // heel
        pad([105.0, 70.0], [44.0, 12.0], 0.18, 0), // outer arch
        pad([222.0, 44.0], [8.0, 6.5], 0.28, 1),
        pad([215.0, 60.0], [8.0, 6.5], 0.22, 1),
        pad([205.0, 74.0], [7.0, 6.0], 0.18, 1),
        pad([192.0, 86.0], [7.0, 6.0], 0.15, 1),
        pad([236.0, 22.0], [17.0, 12.0], 0.62, 1), // big toe
    ];
    let heads = [
        (182.0, 20.0, 0.68),
        (187.0, 38.0, 0.88),
        (183.0, 54.0, 0.8),
        (174.0, 68.0, 0.55),
        (163.0, 81.0, 0.4),
    ];
    for (along, across, share) in heads {
        one.push(pad([along, across], [15.0, 11.0], share, 1)); // heads of the metatarsals
    }
    let width = 95.0;
    let (both, gap) = (soles >= 2, 40.0);
    // Big toes towards the middle: the left foot is the mirrored one.
    let mirrored = one.iter().map(|pad| Pad {
        centre: [pad.centre[0], width - pad.centre[1]],
        ..*pad
    });
    let mut pads: Vec<Pad> = mirrored.collect();
    if both {
        pads.extend(one.iter().map(|pad| Pad {
            centre: [pad.centre[0], pad.centre[1] + width + gap],
            group: pad.group + FOOT_GROUPS,
            ..*pad
        }));
    }
    Drawing {
        size: [258.0, if both { 2.0 * width + gap } else { width }],
        pads,
    }
}

impl Drawing {
    /// The same pads in the smallest rectangle that holds them.
    fn cropped(mut self) -> Self {
        for axis in 0..2 {
            let low = |p: &Pad| p.centre[axis] - p.half[axis];
            let high = |p: &Pad| p.centre[axis] + p.half[axis];
            let least = self.pads.iter().map(low).fold(f64::INFINITY, f64::min);
            let most = self.pads.iter().map(high).fold(0.0, f64::max);
            self.size[axis] = most - least;
            for pad in &mut self.pads {
                pad.centre[axis] -= least;
            }
        }
        self
    }

    /// No two hands are alike: moves each pad by up to 1.5 mm, makes it up to 8 % smaller and up to 15 % weaker.
    pub(super) fn vary(&mut self, random: &mut ChaCha8Rng) {
        for pad in &mut self.pads {
            for axis in 0..2 {
                let half = pad.half[axis];
                pad.half[axis] *= random.random_range(0.92..1.0);
                pad.centre[axis] = (pad.centre[axis] + random.random_range(-1.5..1.5))
                    .clamp(half, (self.size[axis] - half).max(half));
            }
            pad.share *= random.random_range(0.85..1.0);
        }
    }

    /// Lays the drawing on an array, reduced where it does not fit; `place` (0 to 1 twice) says where in the room
    /// that is left. Each pad's pressure is times its group's level, p = share · level · (1 − ρ²)^1.5 inside its
    /// ellipse, and the highest of overlapping pads counts. Row by row, 0 to 1.
    pub(super) fn lay(&self, array: &Array, place: [f64; 2], levels: &[f64]) -> Vec<f64> {
        let laid = self.lay_pads(array, place, levels);
        laid.into_iter().map(|(share, _)| share).collect()
    }

    /// Lengths across the rows' side and the columns' side, how they lie, and by how much the drawing is reduced.
    fn fit(&self, array: &Array) -> ([f64; 2], [usize; 2], f64) {
        let side = [
            array.rows as f64 * array.pitch_mm[0],
            array.columns as f64 * array.pitch_mm[1],
        ];
        // The axis of the array (0: across the rows) that the drawing's length goes along.
        let long = usize::from(side[1] >= side[0]);
        let scale = (side[long] / self.size[0])
            .min(side[1 - long] / self.size[1])
            .min(1.0);
        (side, [long, 1 - long], scale)
    }

    /// How far it can be moved on an array, mm along the drawing and across it.
    pub(super) fn room_mm(&self, array: &Array) -> [f64; 2] {
        let (side, axes, scale) = self.fit(array);
        [0, 1].map(|from| side[axes[from]] - scale * self.size[from])
    }

    /// The same with the pad that counts; of a taxel without a load the first.
    pub(super) fn lay_pads(
        &self,
        array: &Array,
        place: [f64; 2],
        levels: &[f64],
    ) -> Vec<(f64, usize)> {
        let (side, axes, scale) = self.fit(array);
        let mut shares = vec![(0.0, 0); array.rows * array.columns];
        for (number, pad) in self.pads.iter().enumerate() {
            let (mut centre, mut half) = ([0.0; 2], [0.0; 2]);
            for (from, to) in axes.into_iter().enumerate() {
                let room = side[to] - scale * self.size[from];
                centre[to] = scale * pad.centre[from] + room * place[from];
                // A pad between taxels still presses the nearest one.
                half[to] = (scale * pad.half[from]).max(0.75 * array.pitch_mm[to]);
            }
            add_ellipse(
                array,
                centre,
                half,
                (pad.share * levels[pad.group], number),
                &mut shares,
            );
        }
        shares
    }
}

fn add_ellipse(
    array: &Array,
    centre: [f64; 2],
    half: [f64; 2],
    (share, number): (f64, usize),
    shares: &mut [(f64, usize)],
) {
    for (taxel, value) in shares.iter_mut().enumerate() {
        let at = [taxel / array.columns, taxel % array.columns];
        let distance: f64 = (0..2)
            .map(|axis| {
                let here = (at[axis] as f64 + 0.5) * array.pitch_mm[axis];
                ((here - centre[axis]) / half[axis]).powi(2)
            })
            .sum();
        if distance < 1.0 {
            let own = share * (1.0 - distance).powf(1.5);
            if own > value.0 {
                *value = (own, number);
            }
        }
    }
}
