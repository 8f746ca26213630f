//! Presses made one at a time: the minimum is found always, and what they do not tell is said.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use taxel::calibrate::{
    Calibration, CalibrationData, CalibrationOptions, LawChoice, PressLabel, calibrate,
};
use taxel::circuit::Converter;
use taxel::material::LoadLaw;
use taxel::sensor::{PerLine, Sensor, preset};
use taxel::simulate::{Grams, Pattern, VirtualSensor, labelled_presses};
use taxel::solve::default_method;
use taxel::{Counts, Error, Frame};

/// The e-Cone's circuit with other lines and switches, and 3 counts of noise.
fn truth((rows, columns): (usize, usize), (column, row): (f64, f64), seed: u64) -> VirtualSensor {
    let sensor = preset("econe")
        .unwrap()
        .edited(|spec| {
            (spec.array.rows, spec.array.columns) = (rows, columns);
            spec.readout.r_mux_column_ohms = Some(PerLine::One(column));
            spec.readout.r_mux_row_ohms = Some(PerLine::One(row));
            spec.converter.noise_counts = Some(3.0);
        })
        .unwrap();
    VirtualSensor::new(&sensor, seed).unwrap()
}

/// What its owner knows, and perhaps a guess of the switches.
fn parts(truth: &VirtualSensor, guess: Option<f64>) -> Sensor {
    truth
        .sensor()
        .edited(|spec| {
            spec.readout.r_mux_column_ohms = guess.map(PerLine::One);
            spec.readout.r_mux_row_ohms = guess.map(PerLine::One);
            spec.material = None;
        })
        .unwrap()
}

/// Presses of 12 to 600 g with nothing else on the array.
fn alone(truth: &VirtualSensor, count: usize) -> CalibrationData {
    let mut random = ChaCha8Rng::seed_from_u64(truth.seed() + 1000);
    let (rows, columns) = (truth.sensor().rows(), truth.sensor().columns());
    let mut data = CalibrationData::default();
    for frame in 0..count {
        let (row, column) = (
            random.random_range(0..rows),
            random.random_range(0..columns),
        );
        let load_g = random.random_range(12.0..600.0);
        let mut loads = Frame::<Grams>::zeros(rows, columns);
        loads.values_mut()[row * columns + column] = load_g;
        data.frames
            .push(truth.read(&loads, 10_000 + frame as u64).counts);
        data.presses.push(PressLabel {
            frame,
            row,
            column,
            load_g,
        });
    }
    data
}

/// Loads of a frame, grams.
fn read(sensor: &Sensor, counts: &Frame<Counts>) -> Vec<f64> {
    let volts = Converter::from_sensor(sensor).volts_from_counts(counts);
    let solved = default_method(sensor).unwrap().solve(&volts);
    assert!(solved.outcome.stop.is_good(), "{:?}", solved.outcome);
    let law = LoadLaw::from_sensor(sensor).unwrap();
    let siemens = solved.frame.values().iter().enumerate();
    siemens
        .map(|(t, &g)| law.grams_from_siemens(t, g))
        .collect()
}

/// Mean absolute error of the labelled presses, grams.
fn of_labels(sensor: &Sensor, data: &CalibrationData) -> f64 {
    let columns = sensor.columns();
    let errors = data.presses.iter().map(|press| {
        let loads = read(sensor, &data.frames[press.frame]);
        (loads[press.row * columns + press.column] - press.load_g).abs()
    });
    errors.sum::<f64>() / data.presses.len() as f64
}

/// Mean absolute error over the loaded taxels of a gripping hand, grams.
fn of_hand(sensor: &Sensor, truth: &VirtualSensor) -> f64 {
    let hand = Pattern::hand().with_peak_g(600.0);
    let (mut sum, mut count) = (0.0, 0);
    for frame in [50, 80, 110] {
        let loads = hand.loads(truth.sensor().array(), truth.seed(), frame);
        let found = read(sensor, &truth.read(&loads, frame).counts);
        for (found, load) in found
            .iter()
            .zip(loads.values())
            .filter(|(_, load)| **load > 0.0)
        {
            sum += (found - load).abs();
            count += 1;
        }
    }
    sum / f64::from(count)
}

fn fit(sensor: &Sensor, data: &CalibrationData, law: LawChoice) -> Calibration {
    let mut options = CalibrationOptions::default();
    options.law = law;
    options.folds = 3;
    calibrate(sensor, data, &options, &mut |_, _| ()).unwrap()
}

#[test]
fn the_minimum_is_found_whatever_the_size_and_the_draw() {
    // Rows, columns; column and row switch, ohms.
    let cases = [
        ((8, 8), (10.0, 10.0)),
        ((16, 16), (6.3, 11.3)),
        ((8, 8), (6.7, 12.3)),
        ((16, 16), (13.0, 6.5)),
        ((12, 20), (4.0, 4.0)),
        ((32, 32), (10.0, 10.0)),
        ((1, 16), (10.0, 10.0)),
        ((24, 8), (10.0, 10.0)),
        ((20, 40), (10.0, 10.0)),
        ((5, 6), (25.0, 15.0)),
    ];
    for (seed, (shape, ohms)) in cases.into_iter().enumerate() {
        let truth = truth(shape, ohms, seed as u64 + 1);
        let data = alone(&truth, 60);
        let found = fit(&parts(&truth, None), &data, LawChoice::Power);
        let (labels, best) = (
            of_labels(&found.sensor, &data),
            of_labels(truth.sensor(), &data),
        );
        assert!(
            labels < 1.2 * best,
            "{shape:?}: {labels} g, the truth {best} g"
        );
        let hand = of_hand(&found.sensor, &truth);
        assert!(
            hand < 1.2 || shape.0 == 1,
            "{shape:?}: a hand to {hand} g\n{}",
            found.report
        );
        let sum = |sensor: &Sensor| {
            let readout = sensor.readout();
            let one = |list: &Option<PerLine>| list.as_ref().unwrap().at(0);
            one(&readout.r_mux_column_ohms) + one(&readout.r_mux_row_ohms)
        };
        let (found_sum, true_sum) = (sum(&found.sensor), sum(truth.sensor()));
        assert!(
            (found_sum / true_sum - 1.0).abs() < 0.1,
            "{shape:?}: {found_sum} Ohm"
        );
    }
}

#[test]
fn from_any_start_and_with_any_law() {
    let truth = truth((16, 16), (10.0, 10.0), 3);
    let data = alone(&truth, 60);
    let best = of_labels(truth.sensor(), &data);
    for guess in [None, Some(1e-3), Some(1.0), Some(60.0)] {
        for law in [
            LawChoice::Auto,
            LawChoice::Power,
            LawChoice::Saturating,
            LawChoice::Spline,
        ] {
            let found = fit(&parts(&truth, guess), &data, law);
            let labels = of_labels(&found.sensor, &data);
            assert!(
                labels < 1.2 * best,
                "{guess:?} {law:?}: {labels} g, the truth {best} g"
            );
            let hand = of_hand(&found.sensor, &truth);
            assert!(hand < 1.2, "{guess:?} {law:?}: {hand} g\n{}", found.report);
            let errors = found.report.parameters.iter();
            assert!(
                errors
                    .clone()
                    .all(|p| p.standard_error.is_some_and(f64::is_finite))
            );
        }
    }
}

#[test]
fn the_error_of_each_number_is_what_it_is_off_by() {
    let mut off = Vec::new();
    for seed in 0..8 {
        let truth = truth((8, 8), (10.0, 10.0), 100 + seed);
        let found = fit(&parts(&truth, None), &alone(&truth, 40), LawChoice::Power);
        for (name, value) in [
            ("readout.r_mux_column_ohms", 10.0),
            ("readout.r_mux_row_ohms", 10.0),
            ("material.factor", 8.29e-6),
            ("material.exponent", 0.857),
            ("material.g_zero_siemens", 1e-6),
        ] {
            let p = found
                .report
                .parameters
                .iter()
                .find(|p| p.name == name)
                .unwrap();
            off.push((p.value - value) / p.standard_error.unwrap());
        }
    }
    let size = (off.iter().map(|x| x * x).sum::<f64>() / off.len() as f64).sqrt();
    assert!(
        (0.4..1.5).contains(&size),
        "{size} standard errors: {off:.1?}"
    );
}

#[test]
fn what_is_not_told_is_said() {
    let truth = truth((8, 8), (10.0, 10.0), 5);
    let found = fit(&parts(&truth, None), &alone(&truth, 30), LawChoice::Power);
    let text = found.report.to_string();
    assert!(text.contains("tell their sum, 20."), "{text}");
    assert!(text.contains("Two presses at once on one row"), "{text}");
    assert!(!text.contains("± 0 "), "{text}");
}

#[test]
fn a_few_crowded_presses_join_in() {
    let truth = truth((16, 16), (13.0, 6.5), 9);
    let mut data = alone(&truth, 40);
    let apart = fit(&parts(&truth, None), &data, LawChoice::Power);
    let crowd = labelled_presses(&truth, 12);
    for (press, frame) in crowd.presses.iter().zip(crowd.frames) {
        data.presses.push(PressLabel {
            frame: data.frames.len(),
            ..*press
        });
        data.frames.push(frame);
    }
    let found = fit(&parts(&truth, None), &data, LawChoice::Power);
    let error = |c: &Calibration| c.report.parameters[0].standard_error.unwrap();
    assert!(error(&found) < 0.3 * error(&apart), "{}", found.report);
    let hand = of_hand(&found.sensor, &truth);
    assert!(hand < 0.2, "{hand} g\n{}", found.report);
}

#[test]
fn a_wrong_label_is_named_with_what_the_others_say() {
    let truth = truth((16, 16), (10.0, 10.0), 12);
    let data = alone(&truth, 40);
    let right = data.presses[11].load_g;
    for (factor, unit) in [(1e-3, Some("kg")), (1e3, Some("mg")), (1.4, None)] {
        let mut wrong = data.clone();
        wrong.presses[11].load_g *= factor;
        let found = fit(&parts(&truth, None), &wrong, LawChoice::Power);
        let suspects = &found.report.suspects;
        assert_eq!(suspects.len(), 1, "{factor}: {suspects:?}");
        assert_eq!(
            (suspects[0].press, suspects[0].unit()),
            (11, unit),
            "{factor}"
        );
        assert!(
            (suspects[0].says_g / right - 1.0).abs() < 0.05,
            "{suspects:?}"
        );
        assert!(suspects[0].left_out && found.report.presses == 39);
        let hand = of_hand(&found.sensor, &truth);
        assert!(hand < 1.2, "{factor}: {hand} g");
    }
    let found = fit(&parts(&truth, None), &data, LawChoice::Power);
    assert_eq!(found.report.suspects, [], "a sound set");
}

#[test]
fn a_press_that_reads_nothing_is_named_and_left_out() {
    for seed in [12, 13, 14] {
        let truth = truth((16, 16), (10.0, 10.0), seed);
        let data = alone(&truth, 40);
        let sound = fit(&parts(&truth, None), &data, LawChoice::Power);
        let mut silent = data.clone();
        // A dead taxel, or a press that missed it: of the heavier ones, which noise cannot hide.
        let heavy = data.presses.iter().filter(|press| press.load_g > 100.0);
        let missed: Vec<usize> = heavy.take(3).map(|press| press.frame).collect();
        let nothing = Frame::<Grams>::zeros(16, 16);
        for &frame in &missed {
            silent.frames[frame] = truth.read(&nothing, 20_000 + frame as u64).counts;
        }
        let found = fit(&parts(&truth, None), &silent, LawChoice::Power);
        let named: Vec<usize> = found.report.suspects.iter().map(|s| s.press).collect();
        assert_eq!(named, missed, "seed {seed}: {}", found.report);
        assert!(found.report.suspects.iter().all(|s| s.left_out));
        // Three presses fewer, and nothing else.
        let (with, without) = (
            of_hand(&found.sensor, &truth),
            of_hand(&sound.sensor, &truth),
        );
        assert!(
            with < 1.3 * without + 0.3,
            "seed {seed}: {with} g, {without} g"
        );
    }
}

#[test]
fn a_label_said_ten_times_is_one_label_and_two_loads_are_none() {
    let truth = truth((8, 8), (10.0, 10.0), 6);
    let data = alone(&truth, 30);
    let once = fit(&parts(&truth, None), &data, LawChoice::Power);
    let mut often = data.clone();
    often.presses = data.presses.iter().flat_map(|p| [*p; 10]).collect();
    let again = fit(&parts(&truth, None), &often, LawChoice::Power);
    assert_eq!(again.report.parameters, once.report.parameters);
    assert!(
        again
            .report
            .to_string()
            .contains("270 labels repeat another"),
        "{}",
        again.report
    );
    let mut two = data;
    let mut other = two.presses[3];
    other.load_g *= 2.0;
    two.presses.push(other);
    let error = calibrate(
        &parts(&truth, None),
        &two,
        &CalibrationOptions::default(),
        &mut |_, _| (),
    );
    assert!(matches!(error, Err(Error::PressTwice { .. })), "{error:?}");
}

#[test]
fn units_of_all_labels_and_one_load_for_all_are_doubted() {
    let truth = truth((8, 8), (10.0, 10.0), 7);
    let data = alone(&truth, 30);
    for (factor, unit) in [(1e-3, "kg"), (1e3, "mg")] {
        let mut all = data.clone();
        all.presses.iter_mut().for_each(|p| p.load_g *= factor);
        let found = fit(&parts(&truth, None), &all, LawChoice::Auto);
        let doubts = found.report.doubts.join("\n");
        assert!(doubts.contains(&format!("are these {unit}?")), "{doubts}");
    }
    let mut one = data;
    one.presses.iter_mut().for_each(|p| p.load_g = 100.0);
    let error = calibrate(
        &parts(&truth, None),
        &one,
        &CalibrationOptions::default(),
        &mut |_, _| (),
    );
    assert!(matches!(error, Err(Error::OneLoad { .. })), "{error:?}");
}

#[test]
fn gain_and_source_stay_within_belief() {
    let truth = truth((8, 8), (10.0, 10.0), 8);
    let mut options = CalibrationOptions::default();
    options.law = LawChoice::Power;
    options.open_loop_gain = true;
    options.r_source = true;
    options.folds = 2;
    let data = alone(&truth, 30);
    let found = calibrate(&parts(&truth, None), &data, &options, &mut |_, _| ()).unwrap();
    let gain = found.sensor.readout().open_loop_gain().unwrap();
    assert!((1e3..1e7).contains(&gain), "{gain}");
    let errors = found.report.parameters.iter();
    assert!(
        errors
            .clone()
            .all(|p| p.standard_error.is_some_and(f64::is_finite)),
        "{}",
        found.report
    );
}
