//! Fingers, thumb and palm are found in simulated hands, by name, with the forces that the drawing has.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use taxel::frame::newtons_from_grams;
use taxel::segment::{ContactOptions, HAND_PARTS, contacts, hand};
use taxel::sensor::{Geometry, Region, Rings, Sensor, preset};
use taxel::simulate::{Pattern, PatternKind};
use taxel::{Frame, Newtons};

/// A cylinder that lines so far apart close.
fn handle(pitch_mm: f64) -> Sensor {
    preset("econe")
        .unwrap()
        .edited(|spec| {
            spec.array.pitch_mm = [pitch_mm; 2];
            let around = 128.0 * pitch_mm;
            spec.array.geometry = Some(Geometry::cylinder(Rings::Rows, around / PI));
        })
        .unwrap()
}

/// Each finger of a held hand shows its three phalanges, with their forces; a finger that shows fewer stays whole.
#[test]
fn phalanges_are_told_where_a_finger_shows_three() {
    let (mut worst, mut least) = (0f64, 1f64);
    for (pitch_mm, seeds) in [(2.0, 1..=10), (1.4, 11..=20)] {
        let sensor = handle(pitch_mm);
        for seed in seeds {
            let pattern = Pattern::new(PatternKind::Hand {
                frames_per_grip: None,
            });
            let loads = pattern.loads(sensor.array(), seed, 10);
            let values = loads.values().iter().map(|g| newtons_from_grams(*g));
            let map = Frame::new(64, 128, values.collect()).unwrap();
            let mut touched = contacts(&map, &sensor, &ContactOptions::default());
            let found = hand(&touched, &sensor).unwrap().phalanges(&touched);
            assert_eq!(found.len(), 2 + 4 * 3, "seed {seed}");
            let truth = pattern.hand_phalanges(sensor.array(), seed, 10).unwrap();
            let truth = truth.iter().enumerate();
            let truth = sums(&map, truth.filter_map(|(t, part)| Some((t, (*part)?))));
            for part in found.iter().filter(|part| part.name.contains(' ')) {
                let newtons: f64 = part.taxels.iter().map(|&t| map.values()[t]).sum();
                let off = newtons / truth[part.name.as_str()] - 1.0;
                worst = worst.max(off.abs());
                least = least.min(part.confidence.unwrap());
            }
            // Without its last joint the middle finger is one region.
            let middle = found.iter().find(|p| p.name == "middle proximal").unwrap();
            touched.retain(|contact| contact.taxels != middle.taxels);
            if let Some(found) = hand(&touched, &sensor) {
                let names = found.phalanges(&touched);
                assert!(
                    names.iter().any(|part| part.name == "middle"),
                    "seed {seed}"
                );
            }
        }
    }
    println!("phalanges {worst:.4} off at most, confidence {least:.2} at least");
    assert!(worst < 0.023 && least > 0.57);
}

/// How a drawn hand lies: moved round the handle by some columns, with its fingers the other way, as a left hand.
#[derive(Debug, Clone, Copy)]
struct Lies {
    moved: usize,
    reversed: bool,
    left: bool,
}

/// The loads of a held hand, newtons, and which part presses each taxel.
fn drawn(sensor: &Sensor, seed: u64, lies: Lies) -> (Frame<Newtons>, Vec<Option<&'static str>>) {
    let pattern = Pattern::new(PatternKind::Hand {
        frames_per_grip: None,
    });
    let (rows, columns) = (sensor.rows(), sensor.columns());
    let loads = pattern.loads(sensor.array(), seed, 10);
    let parts = pattern.hand_parts(sensor.array(), seed, 10).unwrap();
    let from = |taxel: usize| {
        let (row, column) = (taxel / columns, taxel % columns);
        let row = if lies.left { rows - 1 - row } else { row };
        let column = (column + columns - lies.moved) % columns;
        let column = if lies.reversed {
            columns - 1 - column
        } else {
            column
        };
        row * columns + column
    };
    let values = (0..rows * columns).map(|t| newtons_from_grams(loads.values()[from(t)]));
    let map = Frame::new(rows, columns, values.collect()).unwrap();
    (map, (0..rows * columns).map(|t| parts[from(t)]).collect())
}

fn sums<'a>(
    map: &Frame<Newtons>,
    of: impl Iterator<Item = (usize, &'a str)>,
) -> BTreeMap<&'a str, f64> {
    let mut sums = BTreeMap::new();
    for (taxel, name) in of {
        *sums.entry(name).or_insert(0.0) += map.values()[taxel];
    }
    sums
}

#[test]
fn each_part_of_a_hand_has_its_force() {
    let mut worst = 0f64;
    for (pitch_mm, seeds) in [(2.0, 1..=20), (1.7, 21..=30), (1.4, 31..=40)] {
        let sensor = handle(pitch_mm);
        for seed in seeds {
            for (moved, reversed, left) in [
                (0, false, false),
                (37, true, false),
                (90, false, true),
                (64, true, true),
            ] {
                let lies = Lies {
                    moved,
                    reversed,
                    left,
                };
                let (map, parts) = drawn(&sensor, seed, lies);
                let touched = contacts(&map, &sensor, &ContactOptions::default());
                let found = hand(&touched, &sensor);
                let found = found.unwrap_or_else(|| panic!("no hand of seed {seed}, {lies:?}"));
                let found = found.parts(&touched).into_iter();
                let found: Vec<_> = found.map(|part| part.region(128)).collect();
                let regions = Region::all(&found, &sensor).unwrap();
                let names: Vec<&str> = regions.iter().map(Region::name).collect();
                assert_eq!(names, HAND_PARTS, "seed {seed}, {lies:?}");
                let each = regions
                    .iter()
                    .flat_map(|r| r.taxels().iter().map(|&t| (t, r.name())));
                let found = sums(&map, each);
                let truth = parts.iter().enumerate();
                let truth = sums(&map, truth.filter_map(|(t, part)| Some((t, (*part)?))));
                for (name, newtons) in truth {
                    let off = found[name] / newtons - 1.0;
                    worst = worst.max(off.abs());
                    assert!(off.abs() < 0.05, "seed {seed}, {lies:?}: {name} {off}");
                }
            }
        }
    }
    println!("{worst:.3} off at most");
}

#[test]
fn what_is_no_hand_is_called_none() {
    let sensor = handle(2.0);
    let seen = |map: &Frame<Newtons>| {
        hand(&contacts(map, &sensor, &ContactOptions::default()), &sensor).is_some()
    };
    assert!(!seen(&Frame::zeros(64, 128)));
    assert!(!seen(&Frame::filled(64, 128, 1.0)));
    let grams = |name: &str, seed: u64| {
        let loads = Pattern::named(name)
            .unwrap()
            .loads(sensor.array(), seed, 10);
        Frame::new(64, 128, loads.values().to_vec()).unwrap()
    };
    let hands = (1..=20).filter(|&seed| seen(&grams("blobs", seed))).count();
    assert!(hands <= 1, "{hands} of 20 frames of blobs");
    assert!(!seen(&grams("fingers", 3)));
}
