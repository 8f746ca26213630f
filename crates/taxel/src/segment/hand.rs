//! Which contacts are which part of a gripping hand.
//!
//! Four fingers lie side by side around a handle and reach round it one way, the thumb the other; what lies between is the palm.
//! So the contacts are looked at unrolled: cut where the hand leaves the handle free, once with the fingers at either end. The
//! far end is to be four rows as wide as fingers; that end is taken which is more so. A flat map is looked at from its four sides:
//! a mat that is wrapped around a handle and whose file does not say so.

use super::Part;
use super::watershed::Contact;
use crate::Sensor;

/// The parts that a hand is cut into.
pub const HAND_PARTS: [&str; 6] = ["palm", "thumb", "index", "middle", "ring", "little"];

/// From one finger to the next, mm: of a child's hand and of a large man's.
const FINGER_STEP_MM: [f64; 2] = [11.0, 32.0];
/// Contacts of one finger lie within this of each other, mm.
const FINGER_WIDTH_MM: f64 = 9.0;
/// Joints of a finger that press.
const PHALANGES: usize = 3;
/// From the tip inwards.
const PHALANX_NAMES: [&str; PHALANGES] = ["distal", "middle", "proximal"];
/// Nobody has looked at it.
const MAX_CONFIDENCE: f64 = 0.95;
/// From one joint of a finger to the next, mm.
const JOINT_STEP_MM: [f64; 2] = [12.0, 45.0];
/// A hand shows at least so much of its fingers' joints.
const MIN_SCORE: f64 = 0.6;
/// From the thumb's tip to its other joint, mm.
const THUMB_MM: f64 = 35.0;
/// Lines farther apart than this do not tell one finger from the next, mm: three of them are a small man's finger step.
const MAX_PITCH_MM: f64 = 7.0;
/// Fingers begin beyond this share of the hand's length.
const FINGERS_FROM: f64 = 0.45;

/// A hand that was found in the contacts of a map.
#[derive(Debug, Clone, PartialEq)]
pub struct Hand {
    /// Contacts of palm, thumb, index, middle, ring and little finger; a finger's from its tip inwards.
    parts: [Vec<usize>; 6],
    confidence: f64,
    /// Of each finger how sure its contacts are its phalanges, 0 to 1.
    joints: [f64; 4],
}

impl Hand {
    /// How sure it is a hand, and which end of it the fingers are, 0 to 1.
    pub fn confidence(&self) -> f64 {
        self.confidence
    }

    /// Palm, thumb and fingers, as far as there are any. `contacts`: those that it was found in.
    ///
    /// # Panics
    /// Of other contacts.
    pub fn parts(&self, contacts: &[Contact]) -> Vec<Part> {
        let named = HAND_PARTS.iter().zip(&self.parts);
        let named = named.filter(|(_, taken)| !taken.is_empty());
        let part = |(name, taken): (&&str, &Vec<usize>)| {
            Part::new(*name, taxels_of(contacts, taken), Some(self.confidence))
        };
        named.map(part).collect()
    }

    /// The same with each finger cut into its phalanges (`index proximal`, `index middle`, `index distal`), where it shows three
    /// contacts as far apart as joints are; else the finger stays whole.
    ///
    /// # Panics
    /// Of other contacts.
    pub fn phalanges(&self, contacts: &[Contact]) -> Vec<Part> {
        let mut found = Vec::new();
        for part in self.parts(contacts) {
            let finger = HAND_PARTS[2..].iter().position(|name| *name == part.name);
            let shown = finger.filter(|&at| self.joints[at] > 0.0);
            let Some(at) = shown else {
                found.push(part);
                continue;
            };
            let confidence = Some(self.confidence * self.joints[at]);
            for (joint, word) in self.parts[2 + at].iter().zip(PHALANX_NAMES).rev() {
                let name = format!("{} {word}", part.name);
                found.push(Part::new(name, taxels_of(contacts, &[*joint]), confidence));
            }
        }
        found
    }
}

fn taxels_of(contacts: &[Contact], taken: &[usize]) -> Vec<usize> {
    let taxels = taken.iter().flat_map(|&at| contacts[at].taxels.clone());
    taxels.collect()
}

/// A contact, unrolled.
#[derive(Debug, Clone, Copy)]
struct Placed {
    contact: usize,
    /// Along the fingers, mm from the end of the hand.
    reach: f64,
    /// Across them, mm.
    across: f64,
    newtons: f64,
}

/// The hand in the contacts of a map; `None` where there are no four fingers side by side, and of lines too far apart to show them.
pub fn hand(contacts: &[Contact], sensor: &Sensor) -> Option<Hand> {
    if sensor
        .array()
        .pitch_mm
        .iter()
        .any(|pitch| *pitch > MAX_PITCH_MM)
    {
        return None;
    }
    let ways = if sensor.handle().is_some() {
        let placed = unrolled(contacts, sensor)?;
        vec![placed.clone(), turned(&placed)]
    } else {
        let sides = [0, 1].map(|axis| flat(contacts, sensor, axis));
        sides
            .into_iter()
            .flat_map(|p| [p.clone(), turned(&p)])
            .collect()
    };
    let mut found: Vec<_> = ways
        .iter()
        .filter_map(|placed| fingers(placed).map(|(rows, score)| (placed, rows, score)))
        .collect();
    found.sort_by(|a, b| b.2.total_cmp(&a.2));
    let second = found.get(1).map_or(0.0, |(_, _, score)| *score);
    let (placed, rows, score) = found.into_iter().next()?;
    let margin = (score - second).clamp(0.0, 1.0);
    let parts = parts(placed, &rows);
    let joints = [0, 1, 2, 3].map(|finger| {
        let at = |contact: usize| placed.iter().find(|p| p.contact == contact);
        let reaches = parts[2 + finger].iter().filter_map(|&c| at(c));
        joints_confidence(&reaches.map(|p| p.reach).collect::<Vec<_>>())
    });
    Some(Hand {
        parts,
        confidence: ((0.5 + 0.5 * margin) * score).min(MAX_CONFIDENCE),
        joints,
    })
}

fn turned(placed: &[Placed]) -> Vec<Placed> {
    let length = placed.iter().map(|p| p.reach).fold(0.0, f64::max);
    let from_the_end = |p: &Placed| Placed {
        reach: length - p.reach,
        ..*p
    };
    placed.iter().map(from_the_end).collect()
}

/// Contacts of a flat map with the fingers along an axis: 0 across the rows, 1 across the columns.
fn flat(contacts: &[Contact], sensor: &Sensor, axis: usize) -> Vec<Placed> {
    let place = |contact: &Contact| sensor.place_mm(contact.summit);
    let first = contacts
        .iter()
        .map(|c| place(c)[axis])
        .fold(f64::INFINITY, f64::min);
    let each = contacts.iter().enumerate();
    each.map(|(at, contact)| Placed {
        contact: at,
        reach: place(contact)[axis] - first,
        across: place(contact)[1 - axis],
        newtons: contact.newtons,
    })
    .collect()
}

/// Contacts round the handle from where the hand leaves it free, mm.
fn unrolled(contacts: &[Contact], sensor: &Sensor) -> Option<Vec<Placed>> {
    let handle = sensor.handle()?;
    let lines = handle.angles.len();
    let mut is_touched = vec![false; lines];
    for taxel in contacts.iter().flat_map(|contact| &contact.taxels) {
        is_touched[handle.ring_and_line(*taxel).1] = true;
    }
    // A hand that reaches all around has no end to begin at.
    let first = after_longest_gap(&is_touched)?;
    let pitch = handle.pitch_round_mm;
    Some(
        contacts
            .iter()
            .enumerate()
            .map(|(at, contact)| {
                let (ring, line) = handle.ring_and_line(contact.summit);
                Placed {
                    contact: at,
                    reach: ((line + lines - first) % lines) as f64 * pitch,
                    across: ring as f64 * handle.step_mm,
                    newtons: contact.newtons,
                }
            })
            .collect(),
    )
}

/// The first touched line after the longest run of lines that are not.
fn after_longest_gap(is_touched: &[bool]) -> Option<usize> {
    let lines = is_touched.len();
    let first = is_touched.iter().position(|&touched| touched)?;
    let (mut best, mut gap) = ((0, first), 0);
    for step in 1..=lines {
        let line = (first + step) % lines;
        if is_touched[line] {
            if gap > best.0 {
                best = (gap, line);
            }
            gap = 0;
        } else {
            gap += 1;
        }
    }
    (best.0 > 0).then_some(best.1)
}

/// Four rows of contacts at the far end, each from its tip inwards, and how much they are fingers, 0 to 1.
fn fingers(placed: &[Placed]) -> Option<(Vec<Vec<usize>>, f64)> {
    let length = placed.iter().map(|p| p.reach).fold(0.0, f64::max);
    let mut far: Vec<usize> = (0..placed.len())
        .filter(|&p| placed[p].reach > FINGERS_FROM * length)
        .collect();
    far.sort_by(|a, b| placed[*a].across.total_cmp(&placed[*b].across));
    let rows = four_rows(placed, &far)?;
    let middle = |row: &[usize]| {
        let sum: f64 = row.iter().map(|&p| placed[p].across).sum();
        sum / row.len() as f64
    };
    let middles: Vec<f64> = rows.iter().map(|row| middle(row)).collect();
    let is_step =
        |pair: &[f64]| (FINGER_STEP_MM[0]..FINGER_STEP_MM[1]).contains(&(pair[1] - pair[0]));
    let is_narrow = |row: &Vec<usize>| {
        let at = middle(row);
        row.iter()
            .all(|&p| (placed[p].across - at).abs() < FINGER_WIDTH_MM)
    };
    if !middles.windows(2).all(is_step) || !rows.iter().all(is_narrow) {
        return None;
    }
    let is_joint = |pair: &[usize]| {
        (JOINT_STEP_MM[0]..JOINT_STEP_MM[1])
            .contains(&(placed[pair[0]].reach - placed[pair[1]].reach))
    };
    // Of each row the share of its joints that lie as those of a finger do; a finger that presses by its tip alone has none.
    let joints = rows.iter().map(|row| {
        let right = row.windows(2).filter(|pair| is_joint(pair)).count();
        right.min(PHALANGES - 1) as f64 / (PHALANGES - 1) as f64
    });
    let score = joints.sum::<f64>() / 4.0;
    (score >= MIN_SCORE).then_some((rows, score))
}

/// Cut at the three widest gaps across the fingers; each row from its tip inwards.
fn four_rows(placed: &[Placed], far: &[usize]) -> Option<Vec<Vec<usize>>> {
    if far.len() < 4 {
        return None;
    }
    let gap = |at: usize| placed[far[at + 1]].across - placed[far[at]].across;
    let mut cuts: Vec<usize> = (0..far.len() - 1).collect();
    cuts.sort_by(|a, b| gap(*b).total_cmp(&gap(*a)));
    cuts.truncate(3);
    cuts.sort_unstable();
    let mut rows = Vec::new();
    let mut from = 0;
    for cut in cuts.into_iter().map(|cut| cut + 1).chain([far.len()]) {
        let mut row = far[from..cut].to_vec();
        row.sort_by(|a, b| placed[*b].reach.total_cmp(&placed[*a].reach));
        rows.push(row);
        from = cut;
    }
    Some(rows)
}

/// How sure contacts of a finger are its three phalanges, from 0 to 1, by where they lie, mm, the tip first: the steps between them
/// are alike, the outer one the shorter by a little. None where there are not three.
fn joints_confidence(reaches: &[f64]) -> f64 {
    let [tip, middle, base] = reaches else {
        return 0.0;
    };
    let steps = [tip - middle, middle - base];
    let is_joint = |step: &f64| (JOINT_STEP_MM[0]..JOINT_STEP_MM[1]).contains(step);
    if !steps.iter().all(is_joint) {
        return 0.0;
    }
    let [outer, inner] = steps;
    (outer.min(inner) / outer.max(inner)).clamp(0.0, 1.0)
}

/// Contacts of palm, thumb, index, middle, ring and little finger.
fn parts(placed: &[Placed], rows: &[Vec<usize>]) -> [Vec<usize>; 6] {
    let mut taken: [Vec<usize>; 6] = Default::default();
    let is_finger = |p: usize| {
        rows.iter()
            .any(|row| row.iter().take(PHALANGES).any(|&q| q == p))
    };
    // Whatever is no finger is palm, but for the end that lies farthest from the fingers, with what is next to it.
    let rest: Vec<usize> = (0..placed.len()).filter(|&p| !is_finger(p)).collect();
    let tip = rest
        .iter()
        .copied()
        .min_by(|a, b| placed[*a].reach.total_cmp(&placed[*b].reach));
    let is_thumb = |p: usize| {
        tip.is_some_and(|tip| {
            let heaviest = rest.iter().map(|&q| placed[q].newtons).fold(0.0, f64::max);
            let near =
                (placed[p].reach - placed[tip].reach).hypot(placed[p].across - placed[tip].across);
            p == tip || (near < THUMB_MM && placed[p].newtons < 0.5 * heaviest)
        })
    };
    for &p in &rest {
        taken[usize::from(is_thumb(p))].push(placed[p].contact);
    }
    // The index finger is the one on the thumb's side.
    let across = |row: &[usize]| placed[row[0]].across;
    let is_reversed = tip.is_some_and(|tip| {
        let off = |row: &[usize]| (across(row) - placed[tip].across).abs();
        off(&rows[3]) < off(&rows[0])
    });
    for (at, row) in rows.iter().enumerate() {
        let finger = if is_reversed { 3 - at } else { at };
        let joints = row.iter().take(PHALANGES);
        taken[2 + finger] = joints.map(|&p| placed[p].contact).collect();
    }
    taken
}
