//! Calibration on every read-out, and on the mat that most people build: crowded presses, noise, whole counts.

use crate::every_sensor::every_sensor;
use taxel::calibrate::{Calibration, CalibrationData, CalibrationOptions, calibrate};
use taxel::frame::grams_from_newtons;
use taxel::pipeline::Pipeline;
use taxel::sensor::{PerLine, preset};
use taxel::simulate::{Grams, Imperfections, VirtualSensor, labelled_presses, validation_frames};
use taxel::solve::default_method;
use taxel::{Frame, Sensor};

/// A fit error of this many standard errors is none.
const FOUR: f64 = 4.0;

fn parts_list(truth: &Sensor) -> Sensor {
    truth
        .edited(|spec| {
            spec.material = None;
            spec.readout.r_mux_column_ohms = None;
            spec.readout.r_mux_row_ohms = None;
        })
        .unwrap()
}

/// Mean absolute error over loaded taxels of frames that were not fitted to, grams.
fn judged(sensor: &Sensor, truth: &VirtualSensor) -> f64 {
    let mut pipeline = Pipeline::new(sensor, default_method(sensor).unwrap()).unwrap();
    let (mut sum, mut count) = (0.0, 0);
    for (counts, loads) in validation_frames(truth, 4) {
        let result = pipeline.process(&counts);
        assert!(result.outcome.is_answer(), "{:?}", result.outcome);
        let found = result.newtons().unwrap();
        for (newtons, &load) in found.values().iter().zip(loads.values()) {
            if load > 0.0 {
                sum += (grams_from_newtons(*newtons) - load).abs();
                count += 1;
            }
        }
    }
    assert!(count > 40, "only {count} loaded taxels");
    sum / f64::from(count)
}

/// From the parts list of a sensor, by presses on one that was built.
fn by_presses(nominal: &Sensor, real: &VirtualSensor, presses: usize) -> Calibration {
    let data = labelled_presses(real, presses);
    calibrate(
        &parts_list(nominal),
        &data,
        &CalibrationOptions::default(),
        &mut |_, _| {},
    )
    .unwrap()
}

/// The fit, and its error over that of the true parameters.
fn fitted(truth: &Sensor, seed: u64, presses: usize) -> (Calibration, f64) {
    let real = VirtualSensor::new(truth, seed).unwrap();
    let fit = by_presses(truth, &real, presses);
    let ratio = judged(&fit.sensor, &real) / judged(truth, &real);
    (fit, ratio)
}

fn ohms(list: &Option<PerLine>) -> f64 {
    list.as_ref().unwrap().mean(1)
}

/// No number without an error unless it was held, none off by more than four of them, and no doubt.
fn sound(fit: &Calibration, truth: &Sensor, name: &str) {
    assert_eq!(fit.report.doubts, Vec::<String>::new(), "{name}");
    let material = truth.material().unwrap();
    for p in &fit.report.parameters {
        let wanted = match p.name.as_str() {
            // A spline's factor goes with its bends, which the report says.
            "material.factor" if fit.report.law == "power" => material.factor,
            "material.g_zero_siemens" => material.g_zero_siemens,
            "readout.r_mux_column_ohms" => ohms(&truth.readout().r_mux_column_ohms),
            "readout.r_mux_row_ohms" => ohms(&truth.readout().r_mux_row_ohms),
            _ => continue,
        };
        let Some(error) = p.standard_error else {
            assert!(p.held.is_some(), "{name}: {} has no error", p.name);
            continue;
        };
        assert!(
            error.is_finite() && (p.value - wanted).abs() < FOUR * error,
            "{name}: {} is {} ± {error}, not {wanted}",
            p.name,
            p.value
        );
    }
}

#[test]
fn the_mat_that_most_people_build_is_calibrated_to_its_noise() {
    let truth = preset("mat-16x16-cd4067").unwrap();
    for seed in [1, 3, 5] {
        let (fit, ratio) = fitted(&truth, seed, 120);
        sound(&fit, &truth, &format!("seed {seed}"));
        assert!(
            ratio < 1.1,
            "seed {seed}: {ratio:.3} x the error of the truth"
        );
        // Frames that differ by the ghosts of other loads do not tell noise; the simulation has 0.3 counts.
        let noise = fit.sensor.converter().noise_counts.unwrap();
        assert!((0.3..=0.36).contains(&noise), "seed {seed}: {noise} counts");
    }
}

#[test]
fn every_read_out_is_calibrated_to_its_noise() {
    for (name, truth) in every_sensor(&[12], &[12]).into_iter().skip(3) {
        let (fit, ratio) = fitted(&truth, 2, 90);
        sound(&fit, &truth, &name);
        assert!(ratio < 1.1, "{name}: {ratio:.3} x the error of the truth");
    }
}

/// Loads of a law that no circuit can read: every label belongs to another press.
#[test]
fn labels_of_other_presses_are_refused() {
    let truth = preset("mat-16x16-cd4067").unwrap();
    let real = VirtualSensor::new(&truth, 4).unwrap();
    let mut data = labelled_presses(&real, 60);
    let loads: Vec<f64> = data.presses.iter().map(|p| p.load_g).collect();
    for (i, press) in data.presses.iter_mut().enumerate() {
        press.load_g = loads[(i * 7 + 23) % loads.len()];
    }
    let refused = calibrate(
        &parts_list(&truth),
        &data,
        &CalibrationOptions::default(),
        &mut |_, _| {},
    );
    let told = refused.expect_err("nothing to learn").to_string();
    assert!(
        told.contains("labels") || told.contains("guessing"),
        "{told}"
    );
}

/// On this mat noise alone moves a press among others by half its load and more, and another by nothing.
#[test]
fn noise_accuses_no_label() {
    let (name, truth) = every_sensor(&[8], &[10])
        .into_iter()
        .find(|(name, _)| name.starts_with("divider-floating"))
        .unwrap();
    for seed in 1..=4 {
        let (fit, ratio) = fitted(&truth, seed, 120);
        assert_eq!(fit.report.suspects, [], "{name}, seed {seed}");
        assert!(ratio < 1.1, "{name}, seed {seed}: {ratio:.3}");
    }
}

/// Labelled presses, and two uniform loads of 20 frames each.
fn with_levels(real: &VirtualSensor) -> CalibrationData {
    let mut data = labelled_presses(real, 120);
    let (rows, columns) = (real.sensor().rows(), real.sensor().columns());
    for load_g in [100.0, 300.0] {
        let loads = Frame::<Grams>::filled(rows, columns, load_g);
        let first = 10_000 + load_g as u64;
        let frames = (first..first + 20).map(|frame| (real.read(&loads, frame).counts, load_g));
        data.uniform.extend(frames);
    }
    data
}

/// A source resistor that is not there, and a floating mat whose uniform frames are hard to invert: the search that uniform
/// loads take part in ended at 10 g, and at no fit.
#[test]
fn uniform_loads_never_make_a_fit_worse() {
    let mut source = CalibrationOptions::default();
    source.r_source = true;
    for (name, options, limit, is_without) in [
        ("mat-32x32-adg732", &source, 1.1, false),
        (
            "mat-16x16-cd4067",
            &CalibrationOptions::default(),
            1.1,
            false,
        ),
        ("mat-16x16-cd4067", &source, 1.1, true),
    ] {
        let truth = preset(name).unwrap();
        let real = VirtualSensor::new(&truth, 1).unwrap();
        let data = with_levels(&real);
        let fit = calibrate(&parts_list(&truth), &data, options, &mut |_, _| {}).unwrap();
        let ratio = judged(&fit.sensor, &real) / judged(&truth, &real);
        assert!(
            ratio < limit,
            "{name}: {ratio:.3} x the error of the truth\n{}",
            fit.report
        );
        let warnings = fit.report.warnings.join("\n");
        let left_out = warnings.contains("took no part in the fit");
        assert_eq!(left_out, is_without, "{name}: {warnings}");
    }
}

#[test]
fn a_gain_is_not_looked_for_where_there_is_no_amplifier() {
    let truth = preset("mat-16x16-cd4067").unwrap();
    let real = VirtualSensor::new(&truth, 1).unwrap();
    let mut options = CalibrationOptions::default();
    options.open_loop_gain = true;
    let data = labelled_presses(&real, 60);
    let fit = calibrate(&parts_list(&truth), &data, &options, &mut |_, _| {}).unwrap();
    let names: Vec<&str> = fit
        .report
        .parameters
        .iter()
        .map(|p| p.name.as_str())
        .collect();
    assert!(!names.contains(&"readout.open_loop_gain"), "{names:?}");
    let warnings = fit.report.warnings.join("\n");
    assert!(warnings.contains("has no amplifier"), "{warnings}");
}

/// Nothing says what unloaded taxels of such a mat read, and a line of taxels that no reading tells of must not make the others vague.
#[test]
fn a_mat_of_floating_lines_with_faulty_ones_is_calibrated_by_presses_alone() {
    let truth = preset("mat-16x16-cd4067").unwrap();
    let mut faulty = Imperfections::default();
    (faulty.dead_rows, faulty.flickering_columns) = (1, 1);
    for seed in [1, 2, 3] {
        let real = VirtualSensor::imperfect(&truth, &faulty, seed).unwrap();
        let fit = by_presses(&truth, &real, 80);
        let (screen, wanted) = (fit.sensor.screen(), real.sensor().screen());
        assert_eq!(screen.dead_rows, wanted.dead_rows, "seed {seed}");
        assert_eq!(
            screen.flickering_columns, wanted.flickering_columns,
            "seed {seed}"
        );
        let held_out = fit.report.held_out_mean_absolute_g.unwrap();
        assert!(held_out < 5.0, "seed {seed}: {held_out} g");
    }
}
