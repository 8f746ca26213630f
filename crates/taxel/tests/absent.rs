//! Crossings without a taxel, and readings below what a recorder keeps.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use taxel::circuit::{Circuit, LinearCircuit};
use taxel::frame::grams_from_newtons;
use taxel::pipeline::Pipeline;
use taxel::screen::{FrameScreen, LineFaults};
use taxel::sensor::{Population, Topology, preset};
use taxel::simulate::{Pattern, VirtualSensor, calibration_data};
use taxel::solve;
use taxel::uncertainty::StandardErrors;
use taxel::{Counts, Frame, Mark, Sensor, Siemens};

/// A sensor of which some crossings carry no taxel: a random third, and row 1 as a whole.
fn sparse(name: &str, seed: u64) -> Sensor {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let sensor = preset(name).unwrap();
    let mut line = |r| {
        let mut number = |_| f64::from(u8::from(r != 1 && random.random_bool(2.0 / 3.0)));
        (0..sensor.columns()).map(&mut number).collect()
    };
    let lines: Vec<Vec<f64>> = (0..sensor.rows()).map(&mut line).collect();
    sensor
        .edited(|spec| spec.array.population = Some(Population::Each(lines)))
        .unwrap()
}

fn conductances(sensor: &Sensor, seed: u64) -> Frame<Siemens> {
    let mut random = ChaCha8Rng::seed_from_u64(100 + seed);
    let mut siemens = Frame::zeros(sensor.rows(), sensor.columns());
    for (taxel, g) in siemens.values_mut().iter_mut().enumerate() {
        let (pressed, size): (bool, f64) = (random.random_bool(0.3), random.random());
        if !sensor.is_absent(taxel) {
            *g = if pressed { 1e-3 * size } else { 1e-6 };
        }
    }
    siemens
}

/// Newton's method asks for no reading where no taxel is, finds all others, and leaves nothing there.
#[test]
fn whatever_stands_where_no_taxel_is_the_others_are_found() {
    for name in ["mat-16x16-cd4067", "mat-32x32-adg732"] {
        for topology in Topology::ALL {
            let sensor = sparse(name, 7)
                .edited(|spec| {
                    spec.readout.topology = topology;
                    spec.readout.r_feedback_ohms = Some(500.0);
                    spec.readout.r_pull_down_ohms = Some(500.0);
                })
                .unwrap();
            let truth = conductances(&sensor, 7);
            let mut volts = LinearCircuit::from_sensor(&sensor)
                .unwrap()
                .predict(&truth)
                .unwrap();
            sensor.mark_absent(volts.marks_mut());
            let mut random = ChaCha8Rng::seed_from_u64(9);
            let largest = volts
                .values()
                .iter()
                .fold(0f64, |most, v| most.max(v.abs()));
            let there = volts.marks().to_vec();
            for (value, mark) in volts.values_mut().iter_mut().zip(there) {
                if mark == Mark::Absent {
                    *value = largest * (2.0 * random.random::<f64>() - 1.0);
                }
            }
            let solved = solve::method("newton", &sensor).unwrap().solve(&volts);
            assert!(
                solved.outcome.stop.is_good(),
                "{name} {topology:?}: {:?}",
                solved.outcome
            );
            for (taxel, (found, true_g)) in
                solved.frame.values().iter().zip(truth.values()).enumerate()
            {
                assert!(
                    (found - true_g).abs() < 1e-8 * 1e-3 * 100.0,
                    "{name} {topology:?} {taxel}: {found} {true_g}"
                );
                assert_eq!(
                    sensor.is_absent(taxel),
                    solved.frame.marks()[taxel] == Mark::Absent
                );
            }
        }
    }
}

/// The exact method takes what stands there for what the circuit reads there.
#[test]
fn the_exact_method_leaves_nothing_where_no_taxel_is() {
    let sensor = sparse("econe", 3);
    let truth = conductances(&sensor, 3);
    let mut volts = LinearCircuit::from_sensor(&sensor)
        .unwrap()
        .predict(&truth)
        .unwrap();
    sensor.mark_absent(volts.marks_mut());
    let method = solve::default_method(&sensor).unwrap();
    assert_eq!(method.name(), "exact");
    let solved = method.solve(&volts);
    for (taxel, (found, true_g)) in solved.frame.values().iter().zip(truth.values()).enumerate() {
        assert!((found - true_g).abs() < 1e-9, "{taxel}: {found} {true_g}");
        assert!(!sensor.is_absent(taxel) || *found == 0.0);
    }
}

fn with_floor(sensor: &Sensor, count: f64) -> Sensor {
    sensor
        .edited(|spec| spec.converter.floor_count = Some(count))
        .unwrap()
}

/// Mean absolute error over loaded taxels in grams, and frames without an answer.
fn error(read_as: &Sensor, truth: &VirtualSensor, frames: u64) -> (f64, usize) {
    let mut pipeline = Pipeline::new(read_as, solve::default_method(read_as).unwrap()).unwrap();
    let (mut sum, mut count, mut unanswered) = (0.0, 0.0, 0);
    for (loads, scan) in truth.recording(&Pattern::hand(), 80..80 + frames) {
        let result = pipeline.process(&scan.counts);
        unanswered += usize::from(!result.outcome.is_answer());
        let found = result.newtons().unwrap();
        for (taxel, &load) in loads.values().iter().enumerate() {
            if truth.sensor().is_absent(taxel) {
                assert_eq!(load, 0.0);
                assert_eq!(found.values()[taxel], 0.0);
                assert_eq!(
                    found.marks()[taxel] == Mark::Absent,
                    read_as.is_absent(taxel)
                );
            } else if load > 0.0 {
                sum += (grams_from_newtons(found.values()[taxel]) - load).abs();
                count += 1.0;
            }
        }
    }
    (sum / count, unanswered)
}

#[test]
fn bounds_are_told_to_the_inverse() {
    for seed in [1, 2, 3] {
        let sensor = with_floor(&sparse("mat-16x16-cd4067", seed), 31.0);
        let truth = VirtualSensor::new(&sensor, seed).unwrap();
        let (told, unanswered) = error(&sensor, &truth, 5);
        assert_eq!(unanswered, 0, "seed {seed}");
        assert!(told < 3.0, "seed {seed}: {told} g");
    }
}

/// An upper bound is marked, stands at what an unloaded taxel conducts, and has no error bound; the others have one.
#[test]
fn readings_below_the_floor_are_upper_bounds() {
    let sensor = with_floor(&preset("mat-32x32-adg732").unwrap(), 100.0);
    let truth = VirtualSensor::new(&sensor, 5).unwrap();
    let (_, scan) = truth.recording(&Pattern::hand(), 80..81).next().unwrap();
    let mut pipeline = Pipeline::new(&sensor, solve::default_method(&sensor).unwrap()).unwrap();
    let result = pipeline.process(&scan.counts);
    assert!(result.outcome.is_answer(), "{:?}", result.outcome);
    let siemens = result.siemens.unwrap();
    let loads = result.newtons().unwrap();
    let mut marks = siemens.marks().to_vec();
    let mut errors = StandardErrors::new(&sensor, None).unwrap();
    let errors = errors.of_siemens(siemens, true, &mut marks);
    let unloaded = sensor.material().unwrap().g_zero_siemens;
    for (taxel, mark) in siemens.marks().iter().enumerate() {
        let below = scan.counts.values()[taxel] <= 100.0;
        assert_eq!(*mark == Mark::BelowFloor, below, "{taxel}: {mark:?}");
        assert_eq!(errors.values()[taxel].is_infinite(), below, "{taxel}");
        if below {
            assert_eq!(scan.counts.values()[taxel], 0.0);
            assert_eq!(siemens.values()[taxel], unloaded);
            assert!(loads.values()[taxel].abs() < 1e-12, "{taxel}");
        }
    }
}

/// With a floor of nothing, only zeros are bounds.
#[test]
fn methods_that_need_every_reading_are_refused_with_a_floor() {
    let sensor = with_floor(&preset("econe").unwrap(), 0.0);
    assert_eq!(solve::default_method(&sensor).unwrap().name(), "newton");
    let refused = solve::method("exact", &sensor).err().unwrap().to_string();
    assert!(refused.contains("converter.floor_count"), "{refused}");
}

/// A line of few taxels is no dead line, and one of none is none at all.
#[test]
fn the_screen_judges_lines_by_the_taxels_they_have() {
    use taxel::screen::{FrameScreen, LineScreen, ScreenReport};
    for name in ["mat-16x16-cd4067", "econe"] {
        let sensor = sparse(name, 4);
        let truth = VirtualSensor::new(&sensor, 4).unwrap();
        let mut frames: Vec<Frame<Counts>> = truth
            .recording(&Pattern::hand(), 0..60)
            .map(|(_, scan)| scan.counts)
            .collect();
        // Nobody wired those: they read nothing.
        for frame in &mut frames {
            for (taxel, value) in frame.values_mut().iter_mut().enumerate() {
                if sensor.is_absent(taxel) {
                    *value = 0.0;
                }
            }
        }
        let mut lines = LineScreen::from_sensor(&sensor);
        frames
            .iter()
            .for_each(|frame| lines.observe(frame).unwrap());
        let faults = lines.finish();
        assert!(faults.is_empty(), "{name}: {:?}", faults.faults);
        let mut screen = FrameScreen::from_sensor(&sensor);
        screen.set_lines(&faults);
        let mut report = ScreenReport::new(faults);
        for frame in &mut frames {
            screen.mark(frame).unwrap();
            report.add(frame);
        }
        assert_eq!(report.readings, 60 * sensor.taxels() as u64);
        assert_eq!(report.outliers(), 0, "{name}: {report}");
        assert!(!report.to_string().contains("absent"), "{report}");
    }
}

/// Calibration by single presses and by crowded ones, on an array with holes.
#[test]
fn a_calibration_finds_the_circuit_of_an_array_with_holes() {
    use taxel::calibrate::{CalibrationOptions, calibrate};
    let truth = sparse("mat-16x16-cd4067", 5);
    let sensor = VirtualSensor::new(&truth, 5).unwrap();
    let data = calibration_data(&sensor, 60, &[], 0);
    for press in &data.presses {
        assert!(!truth.is_absent(press.row * 16 + press.column));
    }
    let parts = truth
        .edited(|spec| {
            spec.readout.r_mux_column_ohms = None;
            spec.readout.r_mux_row_ohms = None;
            spec.material = None;
        })
        .unwrap();
    let found = calibrate(
        &parts,
        &data,
        &CalibrationOptions::default(),
        &mut |_, _| (),
    )
    .unwrap();
    let (error, _) = error(&found.sensor, &sensor, 4);
    let (best, _) = self::error(&truth, &sensor, 4);
    assert!(error < 1.1 * best, "{error} g, {best} g");
    // A label where no taxel is belongs to something else.
    let mut wrong = data.clone();
    wrong.presses[3].row = 1;
    let error = calibrate(
        &parts,
        &wrong,
        &CalibrationOptions::default(),
        &mut |_, _| (),
    )
    .unwrap_err();
    assert!(error.to_string().contains("there is no taxel"), "{error}");
}

/// Every line's taxels stand in the gaps of its neighbours', as in an insole: what presses beside it is one row away.
#[test]
fn a_line_that_comes_and_goes_is_told_by_taxels_beside_its_gaps() {
    let is_there = |row: usize, column: usize| (row + column).is_multiple_of(2);
    let mat = preset("mat-16x16-cd4067").unwrap();
    let sensor = mat.edited(|spec| {
        let row = |row| {
            (0..16)
                .map(|c| f64::from(u8::from(is_there(row, c))))
                .collect()
        };
        spec.array.population = Some(Population::Each((0..16).map(row).collect()));
        spec.screen.flickering_columns = vec![5];
    });
    let sensor = sensor.unwrap();
    let mut screen = FrameScreen::from_sensor(&sensor);
    screen.set_lines(&LineFaults::from_spec(sensor.screen()));
    // In, out under a load, in, out at the end of a contact that ends before it.
    for (is_in, rows, is_out) in [
        (true, 4..11, false),
        (false, 4..11, true),
        (true, 4..11, false),
        (false, 0..0, false),
    ] {
        let mut frame = Frame::<Counts>::zeros(16, 16);
        for row in rows {
            for column in [3, 4, 5, 6]
                .into_iter()
                .filter(|&c| is_there(row, c) && (is_in || c != 5))
            {
                frame.values_mut()[16 * row + column] = 600.0 + row as f64;
            }
        }
        screen.mark(&mut frame).unwrap();
        let out = frame.count(Mark::Flickering);
        assert_eq!(out, if is_out { 8 } else { 0 });
    }
}
