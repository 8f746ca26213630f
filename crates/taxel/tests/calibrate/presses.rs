//! Calibration of simulated sensors: what was drawn is found, what was not drawn is not, and bad data is named.

use taxel::calibrate::{CalibrationData, CalibrationOptions, PressLabel, calibrate};
use taxel::frame::grams_from_newtons;
use taxel::pipeline::Pipeline;
use taxel::sensor::{Bend, PerLine, ScreenSpec, Sensor, preset};
use taxel::simulate::{
    Imperfections, VirtualSensor, calibration_data, labelled_presses, validation_frames,
};
use taxel::solve::default_method;
use taxel::{Error, Frame};

/// A 16×24 array with the e-Cone's circuit.
fn nominal() -> Sensor {
    preset("econe")
        .unwrap()
        .edited(|spec| {
            spec.array.rows = 16;
            spec.array.columns = 24;
            spec.readout.r_mux_column_ohms = Some(PerLine::One(12.0));
            spec.readout.r_mux_row_ohms = Some(PerLine::One(9.0));
        })
        .unwrap()
}

/// What its owner knows: neither switches nor material.
fn parts_list(truth: &Sensor) -> Sensor {
    truth
        .edited(|spec| {
            spec.readout = nominal().spec().readout.clone();
            spec.readout.r_mux_column_ohms = None;
            spec.readout.r_mux_row_ohms = None;
            spec.converter = nominal().converter().clone();
            spec.material = None;
            spec.screen = ScreenSpec::default();
        })
        .unwrap()
}

/// Mean absolute error over loaded taxels of frames that were not fitted to, grams.
fn error_over_frames(calibrated: &Sensor, truth: &VirtualSensor) -> f64 {
    let mut pipeline = Pipeline::new(calibrated, default_method(calibrated).unwrap()).unwrap();
    let (mut sum, mut count) = (0.0, 0);
    for (counts, loads) in validation_frames(truth, 6) {
        let result = pipeline.process(&counts);
        assert!(result.outcome.stop.is_good());
        let found = result.newtons().unwrap();
        for (newtons, &load) in found.values().iter().zip(loads.values()) {
            if load > 0.0 {
                sum += (grams_from_newtons(*newtons) - load).abs();
                count += 1;
            }
        }
    }
    assert!(count > 100, "only {count} loaded taxels");
    sum / f64::from(count)
}

/// An error is no more than 1.3 times what was recorded.
fn holds(what: &str, found: f64, recorded: f64) {
    println!("{what}: {found:.3e}, recorded {recorded:.3e}");
    assert!(
        found <= 1.3 * recorded,
        "{what}: {found}, recorded {recorded}"
    );
}

fn fit(sensor: &Sensor, data: &CalibrationData) -> Result<taxel::calibrate::Calibration, Error> {
    calibrate(sensor, data, &CalibrationOptions::default(), &mut |_, _| {})
}

#[test]
fn switches_and_law_come_out_of_presses_from_any_start() {
    let truth = VirtualSensor::new(&nominal(), 5).unwrap();
    let data = labelled_presses(&truth, 90);
    let mut answers = Vec::new();
    for start in [None, Some(1.0), Some(100.0)] {
        let sensor = parts_list(truth.sensor())
            .edited(|spec| {
                spec.readout.r_mux_column_ohms = start.map(PerLine::One);
                spec.readout.r_mux_row_ohms = start.map(PerLine::One);
            })
            .unwrap();
        let found = fit(&sensor, &data).unwrap();
        let readout = found.sensor.readout();
        answers.push([
            readout.r_mux_column_ohms.as_ref().unwrap().at(0),
            readout.r_mux_row_ohms.as_ref().unwrap().at(0),
        ]);
        let error = error_over_frames(&found.sensor, &truth);
        holds("presses, grams", error, 0.0316);
        assert!(
            found
                .report
                .findings
                .iter()
                .all(|f| !f.used || f.name == "presses"),
            "{}",
            found.report
        );
        // What a fit says of itself is about what frames it never saw say of it.
        let held_out = found.report.held_out_mean_absolute_g.unwrap();
        holds("presses, held-out grams", held_out, 0.0357);
    }
    for [column, row] in answers {
        holds("a column's switch, ohms", (column - 12.0).abs(), 0.0099);
        holds("a row's switch, ohms", (row - 9.0).abs(), 0.0061);
    }
}

#[test]
fn uneven_switches_and_material_come_out_of_uniform_loads() {
    let mut imperfections = Imperfections::default();
    imperfections.mux_sd = 0.1;
    imperfections.gain_sd = 0.1;
    let truth = VirtualSensor::imperfect(&nominal(), &imperfections, 11).unwrap();
    let data = calibration_data(&truth, 90, &[50.0, 150.0, 300.0], 4);
    let found = fit(&parts_list(truth.sensor()), &data).unwrap();
    let error = error_over_frames(&found.sensor, &truth);
    holds("uniform loads, grams", error, 0.0364);
    let list = |sensor: &Sensor| match &sensor.readout().r_mux_column_ohms {
        Some(PerLine::Each(values)) => values.clone(),
        other => panic!("one per column, not {other:?}"),
    };
    let (found, drawn) = (list(&found.sensor), list(truth.sensor()));
    let off = found.iter().zip(&drawn).map(|(a, b)| (a / b - 1.0).abs());
    holds(
        "the worst column's switch",
        off.fold(0.0, f64::max),
        1.96e-3,
    );
}

#[test]
fn spread_carry_over_and_exponents_are_found_and_undone() {
    let mut imperfections = Imperfections::default();
    imperfections.mux_sd = 0.05;
    imperfections.gain_sd = 0.1;
    imperfections.exponent_sd = 0.04;
    imperfections.spread = Some([0.06, 0.05, 0.003]);
    imperfections.carry_over = 0.01;
    // Large enough that most presses have nothing near them.
    let large = nominal()
        .edited(|spec| {
            (spec.array.rows, spec.array.columns) = (40, 60);
        })
        .unwrap();
    let truth = VirtualSensor::imperfect(&large, &imperfections, 23).unwrap();
    let data = calibration_data(&truth, 120, &[50.0, 150.0, 300.0], 4);
    let found = fit(&parts_list(truth.sensor()), &data).unwrap();
    let used = |name: &str| {
        found
            .report
            .findings
            .iter()
            .any(|f| f.name == name && f.used)
    };
    assert!(
        used("spread") && used("exponent per taxel") && used("memory of the scan"),
        "{}",
        found.report
    );
    let material = found.sensor.material().unwrap();
    let [row, column, _] = material.spread.unwrap();
    holds("the spread along a column", (row - 0.06).abs(), 8.1e-6);
    holds("the spread along a row", (column - 0.05).abs(), 2.28e-5);
    let carry_over = found.sensor.converter().carry_over;
    holds("the carry-over", (carry_over - 0.01).abs(), 3.25e-5);
    let error = error_over_frames(&found.sensor, &truth);
    holds("spread, carry-over, exponents, grams", error, 0.0679);
}

#[test]
fn a_law_that_is_no_power_law_is_bent_with_all_else_fitted_again() {
    let bent = nominal().edited(|spec| {
        let material = spec.material.as_mut().unwrap();
        material.bend = Some(Bend::new(
            vec![1.0, 3.0, 5.0, 7.0],
            vec![0.3, 0.0, -0.25, 0.15],
        ));
    });
    let mut imperfections = Imperfections::default();
    imperfections.mux_sd = 0.05;
    imperfections.gain_sd = 0.1;
    let truth = VirtualSensor::imperfect(&bent.unwrap(), &imperfections, 5).unwrap();
    let data = calibration_data(&truth, 80, &[50.0, 150.0, 300.0], 4);
    let found = fit(&parts_list(truth.sensor()), &data).unwrap();
    assert_eq!(found.report.law, "spline", "{}", found.report);
    let by_power = found.report.laws.iter().find(|(law, _)| law == "power");
    assert!(by_power.unwrap().1 > 5.0, "{}", found.report);
    let error = error_over_frames(&found.sensor, &truth);
    holds("a bent law, grams", error, 0.0841);
}

#[test]
fn the_fitted_sensor_survives_its_file() {
    let truth = VirtualSensor::new(&nominal(), 6).unwrap();
    let found = fit(&parts_list(truth.sensor()), &labelled_presses(&truth, 60)).unwrap();
    let again = Sensor::from_toml(&found.sensor.to_toml()).unwrap();
    assert_eq!(again, found.sensor);
    assert_eq!(again.provenance().unwrap().presses, 60);
}

#[test]
fn presses_on_dead_lines_are_left_out_unless_they_are_many() {
    let truth = VirtualSensor::new(&nominal(), 7).unwrap();
    let data = labelled_presses(&truth, 30);
    let sensor = parts_list(truth.sensor());
    let one = vec![data.presses[0].row];
    let dead = sensor.edited(|spec| spec.screen.dead_rows = one).unwrap();
    let left_out = fit(&dead, &data).unwrap().report.left_out;
    let on_it = data
        .presses
        .iter()
        .filter(|p| p.row == data.presses[0].row)
        .count();
    let named = left_out
        .iter()
        .filter(|why| why.ends_with("is dead"))
        .count();
    assert_eq!((named, on_it > 0), (on_it, true), "{left_out:?}");
    let half = (0..8).collect();
    let dead = sensor.edited(|spec| spec.screen.dead_rows = half).unwrap();
    let error = fit(&dead, &data).unwrap_err();
    assert!(matches!(error, Error::PressOnDeadLine { .. }), "{error}");
}

#[test]
fn bad_data_is_named() {
    let truth = VirtualSensor::new(&nominal(), 7).unwrap();
    let data = labelled_presses(&truth, 30);
    let sensor = parts_list(truth.sensor());
    let outside = PressLabel {
        row: 16,
        ..data.presses[0]
    };
    let error = fit(
        &sensor,
        &CalibrationData {
            presses: vec![outside],
            ..data.clone()
        },
    )
    .unwrap_err();
    assert!(
        matches!(
            error,
            Error::PressOutside {
                row: 16,
                rows: 16,
                ..
            }
        ),
        "{error}"
    );
    let few = CalibrationData {
        presses: data.presses[..4].to_vec(),
        ..data.clone()
    };
    let error = fit(&sensor, &few).unwrap_err();
    assert!(
        matches!(error, Error::TooFewPresses { found: 4, .. }),
        "{error}"
    );
    let mut small = data.clone();
    small.frames[0] = Frame::zeros(4, 4);
    assert!(matches!(
        fit(&sensor, &small).unwrap_err(),
        Error::Shape { .. }
    ));
    let mut negative = data.clone();
    negative.presses[0].load_g = -1.0;
    assert!(matches!(
        fit(&sensor, &negative).unwrap_err(),
        Error::PressLoad { .. }
    ));
    let silent = CalibrationData {
        frames: data.frames.iter().map(|f| f.map(|_, _| 24.0)).collect(),
        ..data
    };
    let error = fit(&sensor, &silent).unwrap_err();
    assert!(error.to_string().contains("hint:"), "{error}");
}
