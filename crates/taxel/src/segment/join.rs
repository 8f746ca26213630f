//! Parts joined over windows of time: a region keeps its name where what presses moves or is put down anew.
//!
//! A hand's parts have their names by their place in the hand, window by window. From one window to the next the maps are laid on
//! each other, as well as a shift allows: names that disagree with what lies there are doubted, and a window without a hand of its own
//! takes the names of what it was. Contacts are joined where they overlap, or by the nearest centre.

use std::collections::BTreeMap;

use super::shift::Shift;
use super::watershed::{Contact, ContactOptions, Segmenter};
use super::{HAND_PARTS, Part, Window, hand};
use crate::sensor::RegionSpec;
use crate::{Frame, Newtons, Sensor};

/// A hand is one where it shows in windows of this share of the loaded frames.
const MIN_SHOWN: f64 = 0.5;
/// Maps that correlate by more show the same hand in the same pose: then names are to agree.
const SAME_POSE: f64 = 0.8;
/// Confidence of names that a window has from another.
const CARRIED: f64 = 0.8;
/// A contact moves by no more than this from window to window, mm, where it does not overlap with where it was.
const MAX_STEP_MM: f64 = 25.0;

/// The parts of a hand over all windows, as regions that keep their names; of one window without frames. `None` where no hand
/// shows in most of the loaded frames. A contact is pressed above `least_newtons` somewhere in its window's map; `by_phalanges`:
/// fingers are cut into their phalanges where they show them.
pub fn joined_hand(
    windows: &[Window],
    segmenter: &Segmenter,
    least_newtons: f64,
    by_phalanges: bool,
) -> Option<Vec<RegionSpec>> {
    let sensor = segmenter.sensor();
    let seen: Vec<Seen> = windows
        .iter()
        .map(|window| Seen::of(window, segmenter, least_newtons, by_phalanges))
        .collect();
    let frames = |of: &dyn Fn(&Seen) -> bool| -> u64 {
        let each = windows.iter().zip(&seen).filter(|(_, seen)| of(seen));
        each.map(|(window, _)| window.loaded_frames).sum()
    };
    let (shown, all) = (frames(&|seen| !seen.parts.is_empty()), frames(&|_| true));
    if shown == 0 || (shown as f64) < MIN_SHOWN * all as f64 {
        return None;
    }
    let mut parts: Vec<Vec<Part>> = seen.iter().map(|seen| seen.parts.clone()).collect();
    let weight = |at: usize| seen[at].confidence * windows[at].loaded_frames as f64;
    let surest = (0..seen.len()).max_by(|a, b| weight(*a).total_cmp(&weight(*b)))?;
    let forwards = (surest + 1..seen.len()).map(|at| (at - 1, at));
    let backwards = (0..surest).rev().map(|at| (at + 1, at));
    for (from, to) in forwards.chain(backwards) {
        let shift = Shift::between(&windows[from].map, &windows[to].map, sensor);
        let carried = carried(&parts[from], &shift, &seen[to].contacts);
        parts[to] = settle(
            std::mem::take(&mut parts[to]),
            carried,
            &shift,
            &windows[to].map,
        );
    }
    Some(regions(windows, &parts, sensor.columns()))
}

/// What is seen of a window by itself.
struct Seen {
    contacts: Vec<Contact>,
    parts: Vec<Part>,
    confidence: f64,
}

impl Seen {
    fn of(window: &Window, segmenter: &Segmenter, least_newtons: f64, by_phalanges: bool) -> Self {
        let contacts = pressed(window, segmenter, least_newtons);
        let found = hand(&contacts, segmenter.sensor());
        let parts = found.as_ref().map(|found| {
            if by_phalanges {
                found.phalanges(&contacts)
            } else {
                found.parts(&contacts)
            }
        });
        Self {
            parts: parts.unwrap_or_default(),
            confidence: found.map_or(0.0, |found| found.confidence()),
            contacts,
        }
    }
}

/// The contacts of a window's map, the heaviest first.
fn pressed(window: &Window, segmenter: &Segmenter, least_newtons: f64) -> Vec<Contact> {
    let mut found = segmenter.contacts(&window.map, &ContactOptions::default());
    found.retain(|contact| contact.highest_newtons > least_newtons);
    found
}

/// A window's own names, or those that it has from the window before, where there are none or they contradict what is surer.
fn settle(own: Vec<Part>, carried: Vec<Part>, shift: &Shift, map: &Frame<Newtons>) -> Vec<Part> {
    if own.is_empty() {
        return carried;
    }
    if shift.correlation < SAME_POSE {
        return own;
    }
    let names = |parts: &[Part]| -> BTreeMap<usize, String> {
        let each = parts.iter();
        each.flat_map(|part| part.taxels.iter().map(|&t| (t, part.name.clone())))
            .collect()
    };
    let (before, now) = (names(&carried), names(&own));
    let (mut agreed, mut all) = (0.0, 0.0);
    // The palm is most of a hand's load, and the same whichever way the fingers are counted.
    for (taxel, name) in now.iter().filter(|(_, name)| *name != HAND_PARTS[0]) {
        let load = map.values()[*taxel].max(0.0);
        all += load;
        agreed += if before.get(taxel) == Some(name) {
            load
        } else {
            0.0
        };
    }
    let agreement = if all > 0.0 { agreed / all } else { 1.0 };
    if agreement < 0.5 {
        return carried;
    }
    let doubted = own.into_iter().map(|part| Part {
        confidence: part.confidence.map(|c| c * agreement.sqrt()),
        ..part
    });
    doubted.collect()
}

/// Contacts named by what of another window's parts lies there, once these are shifted.
fn carried(parts: &[Part], shift: &Shift, contacts: &[Contact]) -> Vec<Part> {
    let mut owner: BTreeMap<usize, usize> = BTreeMap::new();
    for (at, part) in parts.iter().enumerate() {
        let moved = part.taxels.iter().filter_map(|&t| shift.moved(t));
        owner.extend(moved.map(|taxel| (taxel, at)));
    }
    let mut found: Vec<Part> = parts
        .iter()
        .map(|part| {
            let confidence = part
                .confidence
                .map(|c| CARRIED * c * shift.correlation.max(0.0));
            Part::new(&part.name, Vec::new(), confidence)
        })
        .collect();
    for contact in contacts {
        let mut over = vec![0usize; parts.len()];
        for taxel in &contact.taxels {
            if let Some(&at) = owner.get(taxel) {
                over[at] += 1;
            }
        }
        let best = (0..over.len()).max_by_key(|&at| over[at]);
        if let Some(best) = best.filter(|&at| over[at] > 0) {
            found[best].taxels.extend(&contact.taxels);
        }
    }
    found.retain(|part| !part.taxels.is_empty());
    found
}

/// Each name's place in every window, the names together; of one window without frames.
fn regions(windows: &[Window], parts: &[Vec<Part>], columns: usize) -> Vec<RegionSpec> {
    let mut names: Vec<&str> = Vec::new();
    for part in parts.iter().flatten() {
        if !names.contains(&part.name.as_str()) {
            names.push(&part.name);
        }
    }
    let rank = |name: &&str| {
        let first = name.split(' ').next().unwrap_or(name);
        HAND_PARTS.iter().position(|part| *part == first)
    };
    names.sort_by_key(rank);
    let mut specs = Vec::new();
    for name in names {
        for (window, parts) in windows.iter().zip(parts) {
            let Some(part) = parts.iter().find(|part| part.name == name) else {
                continue;
            };
            let mut spec = part.region(columns);
            if windows.len() > 1 {
                spec.frames = Some(window.frames);
            }
            specs.push(spec);
        }
    }
    specs
}

/// Contacts over all windows as regions `contact 1`, `contact 2`, …, that of the largest impulse first, `most` of them at the most, each
/// pressed above `least_newtons` somewhere in its map; of one window without frames.
pub fn joined_contacts(
    windows: &[Window],
    segmenter: &Segmenter,
    least_newtons: f64,
    most: usize,
) -> Vec<RegionSpec> {
    let sensor = segmenter.sensor();
    let mut tracks: Vec<Track> = Vec::new();
    for (at, window) in windows.iter().enumerate() {
        let found = pressed(window, segmenter, least_newtons);
        extend(&mut tracks, at, window, found, sensor);
    }
    tracks.sort_by(|a, b| b.impulse.total_cmp(&a.impulse));
    tracks.truncate(most);
    let mut specs = Vec::new();
    for (number, track) in tracks.iter().enumerate() {
        for (at, contact) in &track.places {
            let name = format!("contact {}", number + 1);
            let confidence = (windows.len() > 1).then_some(track.confidence);
            let mut spec =
                Part::new(name, contact.taxels.clone(), confidence).region(sensor.columns());
            if windows.len() > 1 {
                spec.frames = Some(windows[*at].frames);
            }
            specs.push(spec);
        }
    }
    specs
}

/// A contact through windows of time.
struct Track {
    places: Vec<(usize, Contact)>,
    /// Newtons times frames.
    impulse: f64,
    /// The least share that it had in common with where it was, or, farther off, how near it was.
    confidence: f64,
}

/// Gives each contact of a window to the track that it goes on, the best pair first; the others begin one.
fn extend(
    tracks: &mut Vec<Track>,
    at: usize,
    window: &Window,
    found: Vec<Contact>,
    sensor: &Sensor,
) {
    let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
    for (track, known) in tracks.iter().enumerate() {
        let Some((_, last)) = known.places.last() else {
            continue;
        };
        for (contact, now) in found.iter().enumerate() {
            let likeness = likeness(last, now, sensor);
            if likeness > 0.0 {
                pairs.push((likeness, track, contact));
            }
        }
    }
    pairs.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut is_taken = vec![false; found.len()];
    let mut goes_on = vec![false; tracks.len()];
    let mut taken: Vec<(usize, usize, f64)> = Vec::new();
    for (likeness, track, contact) in pairs {
        if !is_taken[contact] && !goes_on[track] {
            (is_taken[contact], goes_on[track]) = (true, true);
            taken.push((contact, track, likeness));
        }
    }
    for (number, contact) in found.into_iter().enumerate() {
        let impulse = contact.newtons * window.loaded_frames as f64;
        match taken.iter().find(|(taken, ..)| *taken == number) {
            Some((_, track, likeness)) => {
                let track = &mut tracks[*track];
                track.places.push((at, contact));
                track.impulse += impulse;
                track.confidence = track.confidence.min(*likeness);
            }
            None => tracks.push(Track {
                places: vec![(at, contact)],
                impulse,
                confidence: 1.0,
            }),
        }
    }
}

/// How much two contacts are one that moved, 0 to 1: by the taxels in common, from a half on; without any by how near their
/// summits are, to a half.
fn likeness(a: &Contact, b: &Contact, sensor: &Sensor) -> f64 {
    let common = b
        .taxels
        .iter()
        .filter(|t| a.taxels.binary_search(t).is_ok())
        .count();
    if common > 0 {
        return 0.5 + 0.5 * common as f64 / a.taxels.len().min(b.taxels.len()) as f64;
    }
    let apart = apart_mm(a.summit, b.summit, sensor);
    (0.5 - 0.5 * apart / MAX_STEP_MM).max(0.0)
}

fn apart_mm(a: usize, b: usize, sensor: &Sensor) -> f64 {
    match sensor.handle() {
        Some(handle) => {
            let [a, b] = [a, b].map(|taxel| handle.point_mm(taxel));
            (0..3)
                .map(|axis| (a[axis] - b[axis]).powi(2))
                .sum::<f64>()
                .sqrt()
        }
        None => {
            let [a, b] = [a, b].map(|taxel| sensor.place_mm(taxel));
            (a[0] - b[0]).hypot(a[1] - b[1])
        }
    }
}
