//! Resistance along the lines is found from labelled presses, and undone.

use taxel::Sensor;
use taxel::calibrate::{Calibration, CalibrationOptions, calibrate};
use taxel::frame::grams_from_newtons;
use taxel::pipeline::Pipeline;
use taxel::sensor::{PerLine, ReadoutSpec, Topology, preset};
use taxel::simulate::{
    Imperfections, VirtualSensor, labelled_presses, uniform_levels, validation_frames,
};
use taxel::solve::default_method;

/// A mat of lines that resist so much a pitch, as it is.
fn mat(topology: Topology, size: usize, ohms: Option<f64>) -> Sensor {
    let sensor = preset("econe").unwrap().edited(|spec| {
        (spec.array.rows, spec.array.columns) = (size, size);
        let readout = &mut spec.readout;
        if !topology.is_tia() {
            *readout = ReadoutSpec::new(topology, 3.3);
            readout.r_pull_down_ohms = Some(1000.0);
            spec.converter.inverted = false;
            spec.converter.full_scale_volts = 3.3;
        }
        readout.r_line_row_ohms = ohms.map(PerLine::One);
        readout.r_line_column_ohms = ohms.map(PerLine::One);
        readout.r_mux_column_ohms = Some(PerLine::One(9.3));
        readout.r_mux_row_ohms = Some(PerLine::One(8.1));
        spec.converter.bits = 16;
        spec.converter.noise_counts = Some(3.0);
    });
    sensor.unwrap()
}

/// What its owner knows: no switches, no lines, no law.
fn calibrated(real: &Sensor, truth: &VirtualSensor) -> Calibration {
    let parts = real.edited(|spec| {
        let readout = &mut spec.readout;
        (readout.r_line_row_ohms, readout.r_line_column_ohms) = (None, None);
        (readout.r_mux_row_ohms, readout.r_mux_column_ohms) = (None, None);
        spec.material = None;
    });
    let data = labelled_presses(truth, 50);
    calibrate(
        &parts.unwrap(),
        &data,
        &CalibrationOptions::default(),
        &mut |_, _| (),
    )
    .unwrap()
}

/// Mean absolute error on loaded taxels of frames that were not fitted to, grams.
fn error_g(sensor: &Sensor, truth: &VirtualSensor) -> f64 {
    let mut pipeline = Pipeline::new(sensor, default_method(sensor).unwrap()).unwrap();
    let (mut sum, mut count) = (0.0, 0.0);
    for (counts, loads) in validation_frames(truth, 6) {
        let result = pipeline.process(&counts);
        assert!(result.outcome.stop.is_good(), "{:?}", result.outcome);
        let found = result.newtons().unwrap().values().iter();
        for (found, load) in found.zip(loads.values()).filter(|(_, load)| **load > 0.0) {
            sum += (grams_from_newtons(*found) - load).abs();
            count += 1.0;
        }
    }
    sum / count
}

fn has_lines(found: &Calibration) -> bool {
    let finding = found
        .report
        .findings
        .iter()
        .find(|f| f.name == "line resistance");
    let used = finding.is_some_and(|f| f.used);
    assert_eq!(
        used,
        found.sensor.readout().r_line_row_ohms.is_some(),
        "{}",
        found.report
    );
    used
}

/// Within 1 % of what lines resist, and loads within 1.3 times of what the sensor itself would give.
#[test]
fn what_lines_resist_is_found() {
    for (topology, size, ohms, seed) in [
        (Topology::TiaGroundedColumns, 16, 2.0, 1),
        (Topology::TiaGroundedColumns, 24, 10.0, 2),
        (Topology::DividerGroundedColumns, 16, 5.0, 3),
    ] {
        let real = mat(topology, size, Some(ohms));
        let truth = VirtualSensor::new(&real, seed).unwrap();
        let found = calibrated(&real, &truth);
        assert!(has_lines(&found), "{}", found.report);
        for line in [
            &found.sensor.readout().r_line_row_ohms,
            &found.sensor.readout().r_line_column_ohms,
        ] {
            let found = line.as_ref().unwrap().mean(size);
            assert!((found / ohms - 1.0).abs() < 0.01, "{topology:?}: {found}");
        }
        let (by_fit, by_truth) = (error_g(&found.sensor, &truth), error_g(&real, &truth));
        println!("{topology:?} {size}: {by_fit} g, by the sensor itself {by_truth} g");
        assert!(by_fit < 1.3 * by_truth, "{by_fit} {by_truth}");
    }
}

#[test]
fn where_lines_do_not_resist_nothing_is_found_and_nothing_lost() {
    let real = mat(Topology::TiaGroundedColumns, 16, None);
    let truth = VirtualSensor::new(&real, 4).unwrap();
    let found = calibrated(&real, &truth);
    assert!(!has_lines(&found), "{}", found.report);
    let says = found.report.to_string();
    assert!(says.contains("looked for, not found"), "{says}");
    let (by_fit, by_truth) = (error_g(&found.sensor, &truth), error_g(&real, &truth));
    assert!(by_fit < 1.3 * by_truth, "{by_fit} {by_truth}");
}

/// Switches, lines and taxels that differ by a tenth, spread, saturation, an offset, memory, and three uniform loads: without lines
/// 5 to 7 g.
#[test]
fn what_lines_resist_is_found_beside_all_else_and_line_by_line() {
    let nominal = preset("mat-32x32-adg732").unwrap().edited(|spec| {
        (spec.array.rows, spec.array.columns) = (16, 16);
        spec.readout.r_line_row_ohms = Some(PerLine::One(3.0));
        spec.readout.r_line_column_ohms = Some(PerLine::One(3.0));
    });
    let beyond = Imperfections::beyond_the_circuit();
    let truth = VirtualSensor::imperfect(&nominal.unwrap(), &beyond, 4).unwrap();
    let parts = truth.sensor().edited(|spec| {
        let readout = &mut spec.readout;
        (readout.r_line_row_ohms, readout.r_line_column_ohms) = (None, None);
        let usual = || Some(PerLine::One(4.0));
        (readout.r_mux_row_ohms, readout.r_mux_column_ohms) = (usual(), usual());
        spec.converter.offset_volts = 0.0;
        spec.converter.carry_over = 0.0;
        spec.material = None;
    });
    let mut data = labelled_presses(&truth, 60);
    data.uniform = uniform_levels(&truth, &[50.0, 150.0, 400.0], 4);
    let found = calibrate(
        &parts.unwrap(),
        &data,
        &CalibrationOptions::default(),
        &mut |_, _| (),
    );
    let found = found.unwrap();
    assert!(has_lines(&found), "{}", found.report);
    let error = error_g(&found.sensor, &truth);
    assert!(error < 0.6, "{error} g\n{}", found.report);
    let list = |sensor: &Sensor| {
        let lines = sensor.readout().r_line_column_ohms.clone().unwrap();
        (0..16).map(|line| lines.at(line)).collect::<Vec<f64>>()
    };
    // Lines that differ by a tenth are told apart: what is left of the differences is less than they are.
    let (drawn, told) = (list(truth.sensor()), list(&found.sensor));
    let differ = |list: &[f64], from: &[f64]| {
        let off = list.iter().zip(from).map(|(a, b)| (a / b).ln());
        taxel::stats::standard_deviation(&off.collect::<Vec<f64>>()).unwrap()
    };
    let (left, drawn_by) = (differ(&told, &drawn), differ(&drawn, &[3.0; 16]));
    println!("columns differ by {drawn_by}, {left} of it left");
    assert!(drawn_by > 0.1 && left < 0.0106, "{left} {drawn_by}");
}

/// Copper has some 0.05 Ω a pitch: 6.4 Ω along a row of the e-Cone. A file whose every other number is true and that leaves it out is
/// grams wrong.
#[test]
fn copper_counts_on_the_econe() {
    let mut errors = [[0.0; 3]; 2];
    for seed in 1..=3 {
        let econe = |ohms| {
            let square = mat(Topology::TiaGroundedColumns, 64, ohms);
            square.edited(|spec| spec.array.columns = 128).unwrap()
        };
        let real = econe(Some(0.05));
        let truth = VirtualSensor::new(&real, seed).unwrap();
        for (of, sensor) in errors.iter_mut().zip([real, econe(None)]) {
            of[seed as usize - 1] = error_g(&sensor, &truth);
        }
    }
    println!("with it {:?} g, without it {:?} g", errors[0], errors[1]);
    assert!(errors[0].iter().all(|g| *g < 0.045), "{errors:?}");
    assert!(errors[1].iter().all(|g| *g > 3.1), "{errors:?}");
}
