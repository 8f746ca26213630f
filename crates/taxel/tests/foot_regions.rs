//! Heel, midfoot, forefoot and toes are found in prints of feet: a mean of 104 people's, and drawn ones.

use taxel::frame::newtons_from_grams;
use taxel::segment::{ContactOptions, FOOT_PARTS, Part, Segmenter, feet};
use taxel::sensor::{Sensor, preset};
use taxel::simulate::{Pattern, PatternKind};
use taxel::{Frame, Newtons};

/// A flat plate of some lines.
fn plate(rows: usize, columns: usize, pitch_mm: f64) -> Sensor {
    let mat = preset("mat-32x32-adg732").unwrap();
    mat.edited(|spec| {
        (spec.array.rows, spec.array.columns) = (rows, columns);
        spec.array.pitch_mm = [pitch_mm; 2];
    })
    .unwrap()
}

fn found(map: &Frame<Newtons>, sensor: &Sensor) -> Option<Vec<Part>> {
    feet(map, &Segmenter::new(sensor), &ContactOptions::default())
}

fn shares(map: &Frame<Newtons>, parts: &[Part]) -> Vec<f64> {
    let sum = |part: &Part| part.taxels.iter().map(|&t| map.values()[t]).sum::<f64>();
    let all: f64 = parts.iter().map(sum).sum();
    parts.iter().map(|part| sum(part) / all).collect()
}

/// The mean print of 104 people, 63 × 27 taxels of 5 mm, in whatever unit; `turn`: rows and columns from the other end.
fn mean_print(text: &str, turn: bool) -> Frame<Newtons> {
    let cells = text.lines().flat_map(|line| line.split(','));
    let mut values: Vec<f64> = cells
        .map(|cell| 0.001 * cell.trim().parse::<f64>().unwrap())
        .collect();
    if turn {
        values.reverse();
    }
    Frame::new(63, 27, values).unwrap()
}

#[test]
fn a_mean_print_of_104_people_is_cut_as_masks_are() {
    let sensor = plate(63, 27, 5.0);
    for text in [
        include_str!("../../../testdata/plantar/MUN104L.csv"),
        include_str!("../../../testdata/plantar/MUN104R.csv"),
    ] {
        let map = mean_print(text, false);
        let parts = found(&map, &sensor).unwrap();
        let names: Vec<&str> = parts.iter().map(|part| part.name.as_str()).collect();
        assert_eq!(names, FOOT_PARTS);
        let shares = shares(&map, &parts);
        println!("{shares:?} {:?}", parts[0].confidence);
        assert!(parts[0].confidence.unwrap() > 0.7);
        // Most of a step is borne by heel and forefoot, little by the midfoot.
        assert!(
            shares[0] > 0.25 && shares[2] > 0.35 && shares[1] < 0.15,
            "{shares:?}"
        );
        let turned = found(&mean_print(text, true), &sensor).unwrap();
        let last = 63 * 27 - 1;
        for (part, turned) in parts.iter().zip(&turned) {
            let mut back: Vec<usize> = turned.taxels.iter().map(|t| last - t).collect();
            let mut taxels = part.taxels.clone();
            back.sort_unstable();
            taxels.sort_unstable();
            let common = taxels
                .iter()
                .filter(|t| back.binary_search(t).is_ok())
                .count();
            assert!(common as f64 > 0.95 * taxels.len() as f64, "{}", part.name);
        }
    }
}

/// Drawn soles on a plate of 5 mm: the heel and the forefoot hold what their pads do.
#[test]
fn drawn_soles_are_cut_where_their_pads_are() {
    let sensor = plate(80, 60, 5.0);
    let (mut prints, mut worst) = (0, 0f64);
    for seed in 1..=20 {
        for soles in [1, 2] {
            let pattern = Pattern::new(PatternKind::Feet { soles });
            let loads = pattern.loads(sensor.array(), seed, 40);
            let values = loads.values().iter().map(|g| newtons_from_grams(*g));
            let map = Frame::new(80, 60, values.collect()).unwrap();
            let parts = found(&map, &sensor).unwrap_or_else(|| panic!("seed {seed}, {soles}"));
            assert_eq!(parts.len(), 4 * soles, "seed {seed}, {soles}");
            if soles == 2 {
                assert_eq!(parts[0].name, "foot 1 heel");
                assert_eq!(parts[7].name, "foot 2 toes");
            }
            prints += soles;
            worst = worst.max(heel_off(&map, &parts, &sensor));
        }
    }
    println!("{prints} prints, heels {worst:.4} off at most");
    assert!(worst < 0.0044, "{worst}");
}

/// By how much the heel's force is off the load on the drawing's heel: all within its length, which ends 68 mm along a print of 258.
fn heel_off(map: &Frame<Newtons>, parts: &[Part], sensor: &Sensor) -> f64 {
    let columns = sensor.columns();
    let sum = |part: &Part| part.taxels.iter().map(|&t| map.values()[t]).sum::<f64>();
    let heels = parts.iter().filter(|part| part.name.ends_with("heel"));
    let heel: f64 = heels.map(sum).sum();
    let rows: Vec<f64> = (0..sensor.rows())
        .map(|row| (0..columns).map(|c| map.values()[row * columns + c]).sum())
        .collect();
    // The drawing's length goes along the rows, in their middle, the heel first.
    let first: f64 = 0.5 * (80.0 * 5.0 - 258.0);
    let end = ((first + 70.0) / 5.0).round() as usize;
    let truth: f64 = rows[..end].iter().sum();
    (heel / truth - 1.0).abs()
}

#[test]
fn what_is_no_foot_is_called_none() {
    let sensor = plate(80, 60, 5.0);
    let map = |name: &str, seed| {
        let loads = Pattern::named(name)
            .unwrap()
            .loads(sensor.array(), seed, 40);
        let values = loads.values().iter().map(|g| newtons_from_grams(*g));
        Frame::new(80, 60, values.collect()).unwrap()
    };
    assert!(found(&Frame::zeros(80, 60), &sensor).is_none());
    assert!(found(&Frame::filled(80, 60, 1.0), &sensor).is_none());
    let blobs = (1..=30).filter(|&seed| found(&map("blobs", seed), &sensor).is_some());
    // Five to twelve contacts anywhere lie like a foot now and then.
    assert!(blobs.count() <= 2);
    let fingers = (1..=10).filter(|&seed| found(&map("fingers", seed), &sensor).is_some());
    assert_eq!(fingers.count(), 0);
    let round = preset("econe").unwrap();
    assert!(found(&Frame::filled(64, 128, 0.1), &round).is_none());
}
