//! Load patterns: what presses on the array, in grams per taxel.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::person::{Person, frames_per_trial};
use super::{Grams, Purpose, below, drawing, generator};
use crate::Frame;
use crate::frame::grams_from_newtons;
use crate::sensor::Array;

/// The highest load a pattern puts on a taxel unless it is told otherwise, grams.
pub const DEFAULT_PEAK_G: f64 = 600.0;

/// What presses.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum PatternKind {
    /// A hand gripping a cylinder: four fingers of three pads, thumb, palm.
    Hand {
        /// Frames from one grip to the next: rest, squeeze, hold with a slight tremor, release. `None`: held all
        /// the time.
        frames_per_grip: Option<u64>,
    },
    /// A person who grips a cylinder as strongly as they can, every 20 s: strength, tremor, fatigue and the share of each finger by
    /// the seed. Drawn for 100 frames a second.
    Grip {
        /// How long they hold, seconds; above 8 s the pause after it stays 12 s long.
        hold_secs: f64,
    },
    /// A hand as [`Self::Hand`] that lets go and grips anew elsewhere, and slides while it holds.
    Regrip {
        /// Frames from one grip to the next.
        frames_per_grip: u64,
        /// How far it slides during each hold at most, mm; less where the array has no room.
        slide_mm: f64,
    },
    /// Finger tips, each with a slow rhythm of its own.
    Fingers {
        /// 1 to 5.
        tips: usize,
    },
    /// Soles of a standing person who sways a little.
    Feet {
        /// 1 or 2.
        soles: usize,
    },
    /// The peak load on every taxel.
    Uniform,
    /// Loaded taxels here and there, each frame others.
    Random {
        /// Share of the taxels that are loaded, 0 to 1.
        share: f64,
        /// The lightest load, grams; the heaviest is the peak.
        least_g: f64,
    },
    /// Smooth contacts with sharp edges (Gaussians cut off at two standard deviations), each frame others.
    Blobs {
        /// The fewest in a frame.
        least: usize,
        /// The most in a frame.
        most: usize,
    },
    /// One taxel with nothing around it among random contacts: see [`labelled_press`].
    Press,
}

/// A load pattern of a given height.
///
/// Drawings (hand, fingers, feet) have their natural size where the array is large enough, and are reduced where it
/// is not; their length goes along the array's longer side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pattern {
    /// What presses.
    pub kind: PatternKind,
    /// The load that no taxel exceeds, grams. `None`: what the natural pressure of the drawing puts on a taxel's
    /// cell (pitch × pitch), up to 600 g; 600 g for patterns that are no drawing.
    pub peak_g: Option<f64>,
}

impl Pattern {
    /// The names that [`Self::named`] knows.
    pub const NAMES: [&str; 9] = [
        "hand", "grip", "regrip", "fingers", "feet", "uniform", "random", "blobs", "press",
    ];

    /// A pattern of its natural height.
    pub fn new(kind: PatternKind) -> Self {
        Self { kind, peak_g: None }
    }

    /// A hand that grips every 160 frames; from frame 48 to 119 it holds.
    pub fn hand() -> Self {
        Self::new(PatternKind::Hand {
            frames_per_grip: Some(160),
        })
    }

    /// Of a person who grips: frames from the beginning of one trial to that of the next. The first of them is without load.
    pub fn frames_per_trial(&self) -> Option<u64> {
        match self.kind {
            PatternKind::Grip { hold_secs } => Some(frames_per_trial(hold_secs)),
            _ => None,
        }
    }

    /// By name, with the usual choices: 5 finger tips, two feet, a twentieth of the taxels at random, 5 to 12 blobs.
    pub fn named(name: &str) -> Option<Self> {
        Some(match name {
            "hand" => Self::hand(),
            "grip" => Self::new(PatternKind::Grip { hold_secs: 8.0 }),
            "regrip" => Self::new(PatternKind::Regrip {
                frames_per_grip: 160,
                slide_mm: 12.0,
            }),
            "fingers" => Self::new(PatternKind::Fingers { tips: 5 }),
            "feet" => Self::new(PatternKind::Feet { soles: 2 }),
            "uniform" => Self::new(PatternKind::Uniform),
            "random" => Self::new(PatternKind::Random {
                share: 0.05,
                least_g: 5.0,
            }),
            "blobs" => Self::new(PatternKind::Blobs { least: 5, most: 12 }),
            "press" => Self::new(PatternKind::Press),
            _ => return None,
        })
    }

    /// The same pattern with another height, grams.
    pub fn with_peak_g(mut self, peak_g: f64) -> Self {
        self.peak_g = Some(peak_g);
        self
    }

    /// The load that no taxel of this array exceeds, grams.
    ///
    /// Natural pressures at the peak: 400 kPa for a firm grip, 250 kPa for finger tips, 210 kPa for bare feet. They
    /// are our choice, such that the sums are what people do: on the e-Cone about 430 N summed around the cylinder
    /// (1,570 taxels above 1 g), 5 to 18 N a finger tip, and 310 to 370 N, half of 70 kg, on one sole. A drawing that
    /// had to be reduced sums to less.
    pub fn peak_of(&self, array: &Array) -> f64 {
        let natural_kilopascals = match self.kind {
            PatternKind::Hand { .. } | PatternKind::Grip { .. } | PatternKind::Regrip { .. } => {
                400.0
            }
            PatternKind::Fingers { .. } => 250.0,
            PatternKind::Feet { .. } => 210.0,
            _ => f64::INFINITY,
        };
        let cell_mm2 = array.pitch_mm[0] * array.pitch_mm[1];
        self.peak_g.unwrap_or_else(|| {
            grams_from_newtons(natural_kilopascals * cell_mm2 / 1000.0).min(DEFAULT_PEAK_G)
        })
    }

    /// The loads of frame `frame`, grams, all of them from 0 to the peak. Its sequence number is `frame`.
    pub fn loads(&self, array: &Array, seed: u64, frame: u64) -> Frame<Grams> {
        let peak = self.peak_of(array);
        let shape = &mut generator(seed, Purpose::Shape, 0);
        let contacts = &mut generator(seed, Purpose::Contacts, frame);
        if let Some(hand) = self.drawn_hand(array, seed, frame) {
            let shares = hand.drawing.lay(array, hand.place, &hand.levels);
            return frame_of(array, peak, shares, frame);
        }
        let shares = match self.kind {
            PatternKind::Hand { .. } | PatternKind::Grip { .. } | PatternKind::Regrip { .. } => {
                unreachable!("a hand was drawn")
            }
            PatternKind::Fingers { tips } => {
                let levels = rhythm(shape, 5, 0.3, frame);
                let place = [shape.random(), shape.random()];
                drawing::finger_tips(tips).lay(array, place, &levels)
            }
            PatternKind::Feet { soles } => {
                let levels = rhythm(shape, 2 * drawing::FOOT_GROUPS, 0.9, frame);
                let mut drawing = drawing::feet(soles);
                drawing.vary(shape);
                drawing.lay(array, [0.5; 2], &levels)
            }
            PatternKind::Uniform => vec![1.0; array.rows * array.columns],
            PatternKind::Random { share, least_g } => {
                random(array, contacts, share, least_g / peak)
            }
            PatternKind::Blobs { least, most } => blobs(array, contacts, least, most),
            PatternKind::Press => return labelled_press(array, peak, seed, frame).loads,
        };
        frame_of(array, peak, shares, frame)
    }
}

impl Pattern {
    /// Which part of a hand presses each taxel in a frame: `palm`, `thumb`, `index`, `middle`, `ring`, `little`, or none; `None` of
    /// other patterns. What [`crate::segment::hand`] is held against.
    pub fn hand_parts(
        &self,
        array: &Array,
        seed: u64,
        frame: u64,
    ) -> Option<Vec<Option<&'static str>>> {
        self.hand_pads(array, seed, frame, |pad| pad.part)
    }

    /// The same by phalanges: `index proximal`, `index middle`, `index distal`, …, and `palm` and `thumb` as they are.
    pub fn hand_phalanges(
        &self,
        array: &Array,
        seed: u64,
        frame: u64,
    ) -> Option<Vec<Option<&'static str>>> {
        self.hand_pads(array, seed, frame, |pad| pad.phalanx)
    }

    fn hand_pads(
        &self,
        array: &Array,
        seed: u64,
        frame: u64,
        name: impl Fn(drawing::PadNames) -> &'static str,
    ) -> Option<Vec<Option<&'static str>>> {
        let hand = self.drawn_hand(array, seed, frame)?;
        let laid = hand.drawing.lay_pads(array, hand.place, &hand.levels);
        let names = drawing::hand_pad_names();
        let name = |(share, pad): (f64, usize)| (share > 0.0).then(|| name(names[pad]));
        Some(laid.into_iter().map(name).collect())
    }

    /// The hand of a frame, of patterns that draw one.
    fn drawn_hand(&self, array: &Array, seed: u64, frame: u64) -> Option<DrawnHand> {
        let shape = &mut generator(seed, Purpose::Shape, 0);
        match self.kind {
            PatternKind::Hand { frames_per_grip } => Some(hand(shape, frames_per_grip, frame)),
            PatternKind::Grip { hold_secs } => Some(person(shape, seed, frame, hold_secs)),
            PatternKind::Regrip {
                frames_per_grip,
                slide_mm,
            } => {
                let mut drawn = hand(shape, Some(frames_per_grip), frame);
                let grips = frame as f64 / frames_per_grip.max(1) as f64;
                let room = drawn.drawing.room_mm(array);
                drawn.place = slid(seed, grips, room, slide_mm);
                Some(drawn)
            }
            _ => None,
        }
    }
}

/// Where a hand lies that grips elsewhere every time and slides while it holds: 0 to 1 along and across the room that it has, mm.
fn slid(seed: u64, grips: f64, room_mm: [f64; 2], slide_mm: f64) -> [f64; 2] {
    let random = &mut generator(seed, Purpose::Contacts, grips as u64);
    let place: [f64; 2] = std::array::from_fn(|_| random.random_range(0.1..0.9));
    let way = random.random_range(0.0..std::f64::consts::TAU);
    // It slides while it holds: see `grip`.
    let slid_mm = slide_mm * ((grips.fract() - 0.3) / 0.45).clamp(0.0, 1.0);
    let by = [way.cos(), way.sin()];
    std::array::from_fn(|axis| {
        let by = by[axis] * slid_mm / room_mm[axis].max(1.0);
        (place[axis] + by).clamp(0.0, 1.0)
    })
}

fn frame_of(array: &Array, peak: f64, shares: Vec<f64>, frame: u64) -> Frame<Grams> {
    let load = |(taxel, share): (usize, f64)| {
        if array.is_absent(taxel / array.columns, taxel % array.columns) {
            0.0
        } else {
            peak * share
        }
    };
    let loads = shares.into_iter().enumerate().map(load).collect();
    let mut loads = Frame::new(array.rows, array.columns, loads).expect("one share per taxel");
    loads.sequence = frame;
    loads
}

/// A slow wave of each group, from `least` to 1: periods of 40 to 120 frames.
fn rhythm(random: &mut ChaCha8Rng, groups: usize, least: f64, frame: u64) -> Vec<f64> {
    (0..groups)
        .map(|_| {
            let (start, period) = (random.random::<f64>(), random.random_range(40.0..120.0));
            let turns = start + frame as f64 / period;
            least + (1.0 - least) * 0.5 * (1.0 + (std::f64::consts::TAU * turns).cos())
        })
        .collect()
}

/// A hand in one frame.
struct DrawnHand {
    drawing: drawing::Drawing,
    place: [f64; 2],
    levels: Vec<f64>,
}

fn hand(shape: &mut ChaCha8Rng, frames_per_grip: Option<u64>, frame: u64) -> DrawnHand {
    let mut hand = drawing::hand();
    hand.vary(shape);
    let place = [
        shape.random_range(0.25..0.75),
        shape.random_range(0.25..0.75),
    ];
    // Steady force is unsteady by a few hundredths, slowly (the whole hand) and faster (each finger).
    let slow = rhythm(shape, 1, 0.96, frame);
    let levels: Vec<f64> = (0..drawing::HAND_GROUPS)
        .map(|_| {
            let late = shape.random_range(0.0..0.02);
            let period = shape.random_range(2.3..7.0);
            let turns = shape.random::<f64>() + frame as f64 / period;
            let tremor = 0.99 + 0.01 * (std::f64::consts::TAU * turns).sin();
            let grip = match frames_per_grip {
                Some(frames) => grip(frame as f64 / frames.max(1) as f64 - late),
                None => 1.0,
            };
            grip * slow[0] * tremor
        })
        .collect();
    DrawnHand {
        drawing: hand,
        place,
        levels,
    }
}

/// The hand of a person who grips, in one frame.
fn person(shape: &mut ChaCha8Rng, seed: u64, frame: u64, hold_secs: f64) -> DrawnHand {
    let mut drawing = drawing::hand();
    drawing.vary(shape);
    let place = [
        shape.random_range(0.25..0.75),
        shape.random_range(0.25..0.75),
    ];
    DrawnHand {
        drawing,
        place,
        levels: Person::draw(shape).levels(seed, frame, hold_secs),
    }
}

/// One grip over a phase of 0 to 1: rest, squeeze (0.08 to 0.28), hold, release (0.75 to 0.88), rest.
fn grip(phase: f64) -> f64 {
    let phase = phase.rem_euclid(1.0);
    let smooth = |x: f64| {
        let x = x.clamp(0.0, 1.0);
        x * x * (3.0 - 2.0 * x)
    };
    smooth((phase - 0.08) / 0.2) * (1.0 - smooth((phase - 0.75) / 0.13))
}

fn random(array: &Array, random: &mut ChaCha8Rng, share: f64, least: f64) -> Vec<f64> {
    let least = least.clamp(0.0, 1.0);
    (0..array.rows * array.columns)
        .map(|_| {
            let (chosen, height): (f64, f64) = (random.random(), random.random());
            if chosen < share {
                least + (1.0 - least) * height
            } else {
                0.0
            }
        })
        .collect()
}

fn blobs(array: &Array, random: &mut ChaCha8Rng, least: usize, most: usize) -> Vec<f64> {
    let mut shares = vec![0.0f64; array.rows * array.columns];
    let widest = (0.14 * array.rows.min(array.columns) as f64).max(2.5);
    for _ in 0..least + below(random, most.saturating_sub(least) + 1) {
        let centre = [
            random.random_range(0.0..array.rows as f64),
            random.random_range(0.0..array.columns as f64),
        ];
        let half = [
            random.random_range(1.5..widest),
            random.random_range(1.5..widest),
        ];
        let height = random.random_range(0.1..1.0);
        for (taxel, share) in shares.iter_mut().enumerate() {
            let away = [
                (taxel / array.columns) as f64 + 0.5 - centre[0],
                (taxel % array.columns) as f64 + 0.5 - centre[1],
            ];
            let distance = (away[0] / half[0]).powi(2) + (away[1] / half[1]).powi(2);
            if distance < 1.0 {
                *share = share.max(height * (-2.0 * distance).exp());
            }
        }
    }
    shares
}

/// Loads of which one is known: what a calibration press looks like.
#[derive(Debug, Clone, PartialEq)]
pub struct LabelledPress {
    /// All loads, grams.
    pub loads: Frame<Grams>,
    /// Row of the labelled taxel, from 0.
    pub row: usize,
    /// Column of the labelled taxel, from 0.
    pub column: usize,
    /// Its load, grams: from a fiftieth of the peak to the peak, all alike.
    pub load_g: f64,
}

/// One taxel of a known load, nothing on the two taxels around it in every direction, and 5 to 12 smooth contacts
/// elsewhere.
pub fn labelled_press(array: &Array, peak_g: f64, seed: u64, frame: u64) -> LabelledPress {
    let lines = [array.rows, array.columns].map(|lines| (0..lines).collect::<Vec<_>>());
    press_among(array, peak_g, seed, frame, &lines)
}

/// Crossings drawn before one without a taxel is taken: where all lines given have hardly any.
const MAX_DRAWS: usize = 100_000;

/// The same on one of the `lines` (rows, columns) given.
pub(super) fn press_among(
    array: &Array,
    peak_g: f64,
    seed: u64,
    frame: u64,
    lines: &[Vec<usize>; 2],
) -> LabelledPress {
    let random = &mut generator(seed, Purpose::Press, frame);
    let mut crossing = || {
        lines
            .each_ref()
            .map(|lines| lines[below(random, lines.len())])
    };
    let mut place = crossing();
    for _ in 0..MAX_DRAWS {
        if !array.is_absent(place[0], place[1]) {
            break;
        }
        place = crossing();
    }
    let [row, column] = place;
    let load_g = peak_g * random.random_range(0.02..1.0);
    let mut loads = frame_of(array, peak_g, blobs(array, random, 5, 12), frame);
    for (taxel, load) in loads.values_mut().iter_mut().enumerate() {
        let away = [
            (taxel / array.columns).abs_diff(row),
            (taxel % array.columns).abs_diff(column),
        ];
        match away {
            [0, 0] => *load = load_g,
            [0..=2, 0..=2] => *load = 0.0,
            _ => {}
        }
    }
    LabelledPress {
        loads,
        row,
        column,
        load_g,
    }
}

#[cfg(test)]
mod tests;
