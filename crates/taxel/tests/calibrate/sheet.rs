//! Everything fitted together: a continuous sheet is found, and undone; where there is none, none is found; dead rows take no part.

use taxel::calibrate::{Calibration, CalibrationOptions, calibrate};
use taxel::frame::grams_from_newtons;
use taxel::pipeline::Pipeline;
use taxel::sensor::{PerLine, ScreenSpec, Sensor, preset};
use taxel::simulate::{Imperfections, VirtualSensor, calibration_data, validation_frames};
use taxel::solve::default_method;
use taxel::uncertainty::StandardErrors;

/// An array of so many rows and columns with the e-Cone's circuit.
fn nominal((rows, columns): (usize, usize)) -> Sensor {
    preset("econe")
        .unwrap()
        .edited(|spec| (spec.array.rows, spec.array.columns) = (rows, columns))
        .unwrap()
}

/// A sensor that differs from it in this way, and what is found from its presses and uniform loads by one who knows neither
/// switches nor material.
fn calibrated(
    imperfections: &Imperfections,
    shape: (usize, usize),
    seed: u64,
) -> (VirtualSensor, Calibration) {
    calibrated_from(&nominal(shape), imperfections, (seed, 100))
}

/// The same of another nominal sensor, by one who does not know either whether its lines resist.
fn calibrated_from(
    nominal: &Sensor,
    imperfections: &Imperfections,
    (seed, presses): (u64, usize),
) -> (VirtualSensor, Calibration) {
    let truth = VirtualSensor::imperfect(nominal, imperfections, seed).unwrap();
    let parts = nominal
        .edited(|spec| {
            let readout = &mut spec.readout;
            (readout.r_mux_column_ohms, readout.r_mux_row_ohms) = (None, None);
            (readout.r_line_column_ohms, readout.r_line_row_ohms) = (None, None);
            spec.material = None;
            spec.screen = ScreenSpec::default();
        })
        .unwrap();
    let mut data = calibration_data(&truth, presses, &[50.0, 150.0, 300.0], 4);
    let dead = &truth.sensor().screen().dead_rows;
    data.presses.retain(|press| !dead.contains(&press.row));
    let options = CalibrationOptions::default();
    let found = calibrate(&parts, &data, &options, &mut |_, _| {}).unwrap();
    (truth, found)
}

/// Absolute errors of loaded taxels of frames that were not fitted to, grams, and the half-widths of their intervals.
fn errors_g(sensor: &Sensor, truth: &VirtualSensor) -> Vec<(f64, f64)> {
    let mut pipeline = Pipeline::new(sensor, default_method(sensor).unwrap()).unwrap();
    let mut sigma = StandardErrors::new(sensor, None).unwrap();
    let factor_95 = sigma.factor_95();
    let mut errors = Vec::new();
    for (counts, loads) in validation_frames(truth, 6) {
        let result = pipeline.process(&counts);
        assert!(result.outcome.stop.is_good());
        let found = result.newtons().unwrap();
        let mut marks = found.marks().to_vec();
        let of_loads = sigma.of_loads(result.siemens.unwrap(), found.values(), true, &mut marks);
        let sigmas = of_loads.unwrap().values().to_vec();
        let each = found.values().iter().zip(&sigmas).zip(loads.values());
        let loaded = each.filter(|(_, load)| **load > 0.0);
        errors.extend(loaded.map(|((newtons, sigma), &load)| {
            let off = (grams_from_newtons(*newtons) - load).abs();
            (off, factor_95 * grams_from_newtons(*sigma))
        }));
    }
    assert!(errors.len() > 100, "only {} loaded taxels", errors.len());
    errors
}

fn mean(errors: &[(f64, f64)]) -> f64 {
    errors.iter().map(|(off, _)| off).sum::<f64>() / errors.len() as f64
}

/// The share of errors within their intervals.
fn inside(errors: &[(f64, f64)]) -> f64 {
    let inside = errors.iter().filter(|(off, half)| off <= half).count();
    inside as f64 / errors.len() as f64
}

/// An error is no more than 1.3 times what was recorded.
fn holds(what: &str, found: f64, recorded: f64) {
    println!("{what}: {found:.3e}, recorded {recorded:.3e}");
    assert!(
        found <= 1.3 * recorded,
        "{what}: {found}, recorded {recorded}"
    );
}

fn has_sheet(found: &Calibration) -> bool {
    let said = found.report.findings.iter();
    let said = said.filter(|f| f.name == "sheet").any(|f| f.used);
    let written = found.sensor.material().unwrap().sheet.is_some();
    assert_eq!(said, written, "{}", found.report);
    written
}

/// Every number says where it comes from, all of it, and the sheet comes from the frames.
fn tells_where_it_comes_from(found: &Calibration) {
    let beliefs = &found.report.beliefs;
    for belief in beliefs {
        let sum: f64 = belief.told_by.iter().map(|part| part.1).sum();
        assert!((sum - 1.0).abs() < 1e-9, "{belief}");
        assert!(belief.told_by.iter().all(|part| part.1 >= 0.0), "{belief}");
    }
    let sheet = beliefs
        .iter()
        .find(|belief| belief.name == "sheet")
        .unwrap();
    let believed = sheet.told_by.iter().find(|part| part.0 == "beliefs");
    assert!(
        !sheet.untold && believed.is_none_or(|part| part.1 < 0.05),
        "{sheet}"
    );
    assert!(
        (sheet.after.0 - 1e6 / 12e3).abs() < 4.0 * sheet.after.1,
        "{sheet}"
    );
}

#[test]
fn a_sheet_is_found_and_undone() {
    for (seed, recorded) in [(31, 0.2500), (33, 0.0833)] {
        let (truth, found) = calibrated(&Imperfections::under_a_sheet(), (24, 24), seed);
        assert!(has_sheet(&found), "{}", found.report);
        tells_where_it_comes_from(&found);
        let errors = errors_g(&found.sensor, &truth);
        let error = mean(&errors);
        let cut = found
            .sensor
            .edited(|spec| spec.material.as_mut().unwrap().sheet = None)
            .unwrap();
        let without = mean(&errors_g(&cut, &truth));
        println!("without the sheet: {without} g");
        holds("under a sheet, grams", error, recorded);
        assert!(60.0 * error < without, "{error} {without}");
        assert!(inside(&errors) >= 0.92, "{}", inside(&errors));
    }
}

/// Uniform loads tell a film from lines that resist; mats of 16 × 16 by the lines alone end at 6 to 8 g.
#[test]
fn a_sheet_is_found_beside_lines_that_resist() {
    let lines = nominal((12, 12)).edited(|spec| {
        spec.readout.r_line_row_ohms = Some(PerLine::One(3.0));
        spec.readout.r_line_column_ohms = Some(PerLine::One(3.0));
    });
    let under_a_sheet = Imperfections::under_a_sheet();
    let (truth, found) = calibrated_from(&lines.unwrap(), &under_a_sheet, (31, 50));
    assert!(has_sheet(&found), "{}", found.report);
    tells_where_it_comes_from(&found);
    let means = |sensor: &Sensor| {
        let readout = sensor.readout();
        let sides = [&readout.r_line_row_ohms, &readout.r_line_column_ohms];
        sides.map(|side| side.as_ref().unwrap().mean(12))
    };
    let [rows, columns] = means(&found.sensor);
    let [true_rows, true_columns] = means(truth.sensor());
    holds("rows, relative", (rows / true_rows - 1.0).abs(), 0.0441);
    holds(
        "columns, relative",
        (columns / true_columns - 1.0).abs(),
        0.0457,
    );
    let errors = errors_g(&found.sensor, &truth);
    holds(
        "under a sheet, lines that resist, grams",
        mean(&errors),
        1.686,
    );
    assert!(inside(&errors) >= 0.92, "{}", inside(&errors));
}

#[test]
fn where_there_is_no_sheet_none_is_found() {
    let (truth, found) = calibrated(&Imperfections::beyond_the_circuit(), (24, 24), 31);
    assert!(!has_sheet(&found), "{}", found.report);
    let errors = errors_g(&found.sensor, &truth);
    holds("without a sheet, grams", mean(&errors), 0.0781);
    assert!(inside(&errors) >= 0.92, "{}", inside(&errors));
}

/// A row that is dead under every uniform load tells nothing, and takes nothing that the mean of all rows is off by.
#[test]
fn dead_rows_are_rows_as_usual() {
    let mut imperfections = Imperfections::beyond_the_circuit();
    imperfections.dead_rows = 2;
    let (truth, found) = calibrated(&imperfections, (24, 24), 31);
    let rows = |sensor: &Sensor| sensor.readout().r_mux_row_ohms.clone().unwrap();
    let (ours, true_ohms) = (rows(&found.sensor), rows(truth.sensor()));
    let dead = &truth.sensor().screen().dead_rows;
    assert_eq!((dead.len(), &found.sensor.screen().dead_rows), (2, dead));
    let live: Vec<usize> = (0..24).filter(|row| !dead.contains(row)).collect();
    let mean = |all: &PerLine| live.iter().map(|&row| all.at(row)).sum::<f64>() / 22.0;
    let usual = mean(&ours);
    for &row in dead {
        let off = ours.at(row) / usual - 1.0;
        assert!(off.abs() < 1e-4, "row {row}: {} of {usual}", ours.at(row));
    }
    // Rows and what the amplifier's finite gain lets through are one sum.
    let amplifier = |sensor: &Sensor| {
        let readout = sensor.readout();
        readout.r_feedback_ohms().unwrap() / (1.0 + readout.open_loop_gain().unwrap())
    };
    let true_mean = mean(&true_ohms) + amplifier(truth.sensor()) - amplifier(&found.sensor);
    let off = (usual / true_mean - 1.0).abs();
    holds("mean resistance of the live rows, relative", off, 7.58e-3);
}
