//! Simulated sensors whose film conducts more or less than at their calibration.

use super::*;
use crate::Frame as Scan;
use crate::frame::grams_from_newtons;
use crate::pipeline::Pipeline;
use crate::sensor::{UncertaintySpec, Verdict, preset};
use crate::simulate::{Grams, VirtualSensor, labelled_presses, validation_frames};
use crate::solve::default_method;

/// A calibrated sensor whose stated errors are generous to a simulation, and one that conducts `times` as much.
fn pair(name: &str, times: f64, seed: u64) -> (Sensor, VirtualSensor) {
    let base = preset(name)
        .unwrap()
        .edited(|spec| {
            spec.uncertainty = Some(UncertaintySpec {
                model_share: 0.01,
                model_floor_g: 1.0,
                fit_share: 0.003,
                factor_95: 1.96,
                presses: 100,
                frame_share: None,
                frame_floor_g: None,
                spread_error: None,
                sheet_share: None,
                material_factor: None,
            });
        })
        .unwrap();
    let today = base
        .edited(|spec| spec.material.as_mut().unwrap().factor *= times)
        .unwrap();
    (base, VirtualSensor::new(&today, seed).unwrap())
}

fn pressed(sensor: &VirtualSensor, presses: usize) -> CheckData {
    let data = labelled_presses(sensor, presses);
    CheckData {
        frames: data.frames,
        presses: data.presses,
        ..CheckData::default()
    }
}

/// Mean absolute error over loaded taxels, grams.
fn error_g(sensor: &Sensor, truth: &VirtualSensor) -> f64 {
    let mut pipeline = Pipeline::new(sensor, default_method(sensor).unwrap()).unwrap();
    let mut errors = Vec::new();
    for (counts, loads) in validation_frames(truth, 2) {
        let found: &Scan<crate::Newtons> = pipeline.process(&counts).newtons().unwrap();
        let loads: &Scan<Grams> = &loads;
        let each = found.values().iter().zip(loads.values());
        errors.extend(
            each.filter(|(_, load)| **load > 0.0)
                .map(|(newtons, load)| (grams_from_newtons(*newtons) - load).abs()),
        );
    }
    crate::stats::mean(errors).unwrap()
}

#[test]
fn the_days_scale_is_found_and_written_on_mats_of_sixteen_and_thirty_two_lines() {
    for (name, seeds, most, most_g) in [
        ("mat-16x16-cd4067", 1..=3, 0.0065, 9.6),
        ("mat-32x32-adg732", 1..=1, 0.000_52, 0.14),
    ] {
        for seed in seeds {
            for times in [0.95, 1.0, 1.03] {
                let (base, truth) = pair(name, times, seed);
                let report = check(&base, &pressed(&truth, 12)).unwrap();
                let found = report.conductance_scale.unwrap();
                assert!(
                    (found - times).abs() < most,
                    "{name} {seed}: {found}, {times}"
                );
                let verdict = if times == 1.0 {
                    Verdict::Good
                } else {
                    Verdict::Rescaled
                };
                assert_eq!(report.verdict, verdict, "{name} {seed} {times}: {report}");
                let today = checked(&base, &report, "2026-01-02").unwrap();
                let error = error_g(&today, &truth);
                assert!(error < most_g, "{name} {seed} {times}: {error}");
            }
        }
    }
}

#[test]
fn a_checked_file_is_read_back_and_checked_against_its_calibration_again() {
    let (base, truth) = pair("mat-16x16-cd4067", 1.03, 2);
    let data = pressed(&truth, 8);
    let report = check(&base, &data).unwrap();
    let today = checked(&base, &report, "2026-01-02").unwrap();
    let read = Sensor::from_toml(&today.to_toml()).unwrap();
    assert_eq!(read, today);
    let scale = read.check().unwrap().conductance_scale;
    let (of, before) = (read.material().unwrap(), base.material().unwrap());
    assert_eq!(of.factor, before.factor * scale);
    assert_eq!(read.spec().material, base.spec().material);
    let fit = read.uncertainty().unwrap().fit_share;
    assert_eq!(
        fit,
        0.003f64.hypot(read.check().unwrap().scale_standard_error)
    );
    assert_eq!(check(&read, &data).unwrap(), report);
}

#[test]
fn totals_tell_a_scale_and_an_empty_array_an_offset() {
    let (base, truth) = pair("mat-16x16-cd4067", 1.08, 1);
    let (counts, loads) = &validation_frames(&truth, 1)[0];
    let total: f64 = loads.values().iter().sum();
    let nothing = Scan::<Grams>::zeros(base.rows(), base.columns());
    let mut data = CheckData {
        totals: vec![(vec![counts.clone()], total)],
        empty: (0..8).map(|i| truth.read(&nothing, i).counts).collect(),
        ..CheckData::default()
    };
    let report = check(&base, &data).unwrap();
    // One frame of a floating mat of 10 bits.
    let found = report.conductance_scale.unwrap();
    assert!((found - 1.08).abs() < 0.0265, "{report}");
    // Noise, and what is taken off for it; beside that half of the variance of 1 %, which all taxels share.
    let error = report.scale_standard_error.unwrap();
    assert!((0.021..0.0355).contains(&error), "{error}");
    data.totals.clear();
    let report = check(&base, &data).unwrap();
    assert_eq!(
        (report.scale, report.verdict),
        (None, Verdict::Good),
        "{report}"
    );
    assert!(report.offset_g.unwrap().abs() < 0.5, "{report}");
}

/// Without stated errors one total tells no error of its scale: a hundredth of the load is another array all the same.
#[test]
fn a_total_that_never_stood_on_the_array_is_not_good() {
    let (base, truth) = pair("mat-32x32-adg732", 1.0, 1);
    let silent = base.edited(|spec| spec.uncertainty = None).unwrap();
    let (counts, loads) = &validation_frames(&truth, 1)[0];
    let total: f64 = loads.values().iter().sum();
    let says = |total_g: f64| {
        let data = CheckData {
            totals: vec![(vec![counts.clone()], total_g)],
            ..CheckData::default()
        };
        check(&silent, &data).unwrap()
    };
    let there = says(total);
    assert_eq!(there.verdict, Verdict::Good, "{there}");
    assert_eq!(there.scale_standard_error, None);
    let nowhere = says(100.0 * total);
    assert_eq!(nowhere.verdict, Verdict::Recalibrate, "{nowhere}");
    assert!(
        nowhere.reasons[0].contains("stand on the array"),
        "{nowhere}"
    );
}

/// Part of a total stands where nothing is measured: what the rest carries tells no scale, and none is made up. Where nothing stands
/// beside what is not measured, nothing is missing.
#[test]
fn a_total_part_of_which_is_hidden_tells_no_scale() {
    let (base, truth) = pair("mat-16x16-cd4067", 1.08, 1);
    let (counts, loads) = &validation_frames(&truth, 1)[0];
    let total: f64 = loads.values().iter().sum();
    let of_row = |row: usize| -> f64 { loads.values()[row * 16..][..16].iter().sum() };
    let data = CheckData {
        totals: vec![(vec![counts.clone()], total)],
        ..CheckData::default()
    };
    let without = |row: usize| {
        let base = base
            .edited(|spec| spec.screen.dead_rows = vec![row])
            .unwrap();
        check(&base, &data).unwrap()
    };
    let most = (0..16)
        .max_by(|a, b| of_row(*a).total_cmp(&of_row(*b)))
        .unwrap();
    let report = without(most);
    assert_eq!(
        (report.scale, report.verdict, report.left_out.len()),
        (None, Verdict::Recalibrate, 1),
        "{report}"
    );
    let far = (0..16usize)
        .find(|&row| (row.saturating_sub(1)..=(row + 1).min(15)).all(|row| of_row(row) == 0.0));
    let report = without(far.expect("blobs leave rows alone"));
    assert!(
        (report.conductance_scale.unwrap() - 1.08).abs() < 0.0265,
        "{report}"
    );
    assert!(report.left_out.is_empty(), "{report}");
}

#[test]
fn labels_that_contradict_each_other_are_named_and_few_presses_tell_little() {
    let (base, truth) = pair("mat-16x16-cd4067", 1.0, 3);
    let mut data = pressed(&truth, 10);
    for press in data.presses.iter_mut().step_by(2) {
        press.load_g *= 1.5;
    }
    let report = check(&base, &data).unwrap();
    assert_eq!(report.verdict, Verdict::Recalibrate, "{report}");
    let mut one = pressed(&truth, 10);
    one.presses[4].load_g *= 2.0;
    let report = check(&base, &one).unwrap();
    assert_eq!(report.verdict, Verdict::Good, "{report}");
    let named: Vec<usize> = report.contradictions.iter().map(|c| c.press).collect();
    assert_eq!(named, [4]);
    let report = check(&base, &pressed(&truth, 2)).unwrap();
    assert_eq!(report.verdict, Verdict::Good, "{report}");
    assert!(
        report
            .notes
            .iter()
            .any(|note| note.contains("gross change")),
        "{report}"
    );
    assert!(matches!(
        check(&base, &CheckData::default()),
        Err(Error::NothingToCheck)
    ));
}

#[test]
fn a_law_that_a_program_moves_leaves_a_file_that_can_be_read() {
    let (base, _) = pair("mat-16x16-cd4067", 1.0, 1);
    let factor = base.material().unwrap().factor;
    let tied = base
        .edited(|spec| spec.uncertainty.as_mut().unwrap().material_factor = Some(factor))
        .unwrap();
    assert!(tied.to_toml().contains("material_factor"));
    assert_eq!(Sensor::from_toml(&tied.to_toml()).unwrap(), tied);
    let moved = tied
        .edited(|spec| spec.material.as_mut().unwrap().factor *= 1.5)
        .unwrap();
    let read = Sensor::from_toml(&moved.to_toml()).unwrap();
    assert_eq!(read.uncertainty().unwrap().material_factor, None);
    let other = tied
        .to_toml()
        .replace("material_factor = ", "material_factor = 1");
    let error = Sensor::from_toml(&other);
    assert!(
        matches!(error, Err(Error::OtherUncertainty { .. })),
        "{error:?}"
    );
}
