use super::super::{PatternKind, newtons};
use super::*;
use crate::frame::grams_from_newtons;
use crate::metric::deviations_of_frames;
use crate::pipeline::Pipeline;
use crate::sensor::preset;
use crate::solve::default_method;

fn econe() -> Sensor {
    preset("econe").unwrap()
}

fn error_g(truth: &Sensor, loads: &Frame<Grams>, reading: &SimulatedScan) -> f64 {
    let mut pipeline = Pipeline::new(truth, default_method(truth).unwrap()).unwrap();
    let estimate = pipeline.process(&reading.counts).newtons().unwrap();
    let error = deviations_of_frames(estimate, &newtons(loads), |_, load| load > 0.0);
    crate::frame::grams_from_newtons(error.unwrap().unwrap().mean_absolute)
}

#[test]
fn the_same_seed_reads_the_same_and_any_frame_can_be_made_alone() {
    let sensor = VirtualSensor::imperfect(
        &preset("mat-32x32-adg732").unwrap(),
        &Imperfections::uneven(),
        4,
    )
    .unwrap();
    for name in Pattern::NAMES {
        let pattern = Pattern::named(name).unwrap();
        let run: Vec<_> = sensor.recording(&pattern, 0..8).collect();
        let alone = sensor.recording(&pattern, 5..6).next().unwrap();
        assert_eq!(run[5], alone, "{name}");
        assert_eq!(alone.1.counts.sequence, 5);
        assert_ne!(run[4].1.counts.values(), run[5].1.counts.values(), "{name}");
        let other = VirtualSensor::new(sensor.sensor(), 5).unwrap();
        assert_ne!(
            other.read(&alone.0, 5).counts.values(),
            alone.1.counts.values()
        );
    }
}

#[test]
fn an_unloaded_sensor_reads_its_baseline_and_times_are_multiples_of_the_period() {
    let sensor = VirtualSensor::new(&econe(), 1)
        .unwrap()
        .with_period_secs(0.05);
    let reading = sensor.read(&Frame::zeros(64, 128), 3);
    // 1 µS · 2 kΩ · 0.4 V over 2.2 V / 65535, less a little cross-talk.
    let baseline = 1e-6 * 2000.0 * 0.4 / (2.2 / 65535.0);
    let mean = reading.counts.values().iter().sum::<f64>() / 8192.0;
    assert!((mean - baseline).abs() < 0.1 + 0.002 * baseline, "{mean}");
    assert_eq!(reading.counts.time_secs, Some(0.05 * 3.0));
    assert_eq!(reading.siemens.at(0, 0), 1e-6);
}

#[test]
fn noise_has_the_deviation_it_is_given() {
    for (given, wanted) in [(None, 3.0), (Some(8.0), 8.0)] {
        let truth = econe()
            .edited(|spec| {
                spec.converter.noise_counts = given;
            })
            .unwrap();
        let quiet = {
            let quiet = truth
                .edited(|spec| spec.converter.noise_counts = Some(0.0))
                .unwrap();
            VirtualSensor::new(&quiet, 2).unwrap()
        };
        let sensor = VirtualSensor::new(&truth, 2).unwrap();
        let loads = Frame::filled(64, 128, 10.0);
        let (mut sum, mut squares, mut draws) = (0.0, 0.0, 0.0);
        let still = quiet.read(&loads, 0).counts;
        for frame in 0..13 {
            let counts = sensor.read(&loads, frame).counts;
            for (noisy, still) in counts.values().iter().zip(still.values()) {
                sum += noisy - still;
                squares += (noisy - still).powi(2);
                draws += 1.0;
            }
        }
        let mean: f64 = sum / draws;
        let deviation = (squares / draws - mean * mean).sqrt();
        // The still frame is rounded: the same half count at most everywhere.
        assert!(draws > 1e5 && mean.abs() < 0.6);
        assert!((deviation / wanted - 1.0).abs() < 0.05, "{deviation}");
    }
}

#[test]
fn fewer_bits_have_fewer_counts_of_noise() {
    assert_eq!(default_noise_counts(16), 3.0);
    assert_eq!(default_noise_counts(14), 0.75);
    assert_eq!(default_noise_counts(8), 0.3);
}

#[test]
fn too_much_load_stands_at_the_ceiling() {
    let sensor = VirtualSensor::new(&econe(), 3).unwrap();
    let mut loads = Frame::zeros(64, 128);
    loads.values_mut()[700] = 5000.0;
    let counts = sensor.read(&loads, 0).counts;
    assert_eq!(counts.values()[700], 65535.0);
    let most = |count: &f64| *count <= 65535.0 && *count >= 0.0 && count.fract() == 0.0;
    assert!(counts.values().iter().all(most));
}

#[test]
fn dead_lines_read_nothing_flickering_ones_sometimes_and_stuck_readings_are_at_an_end() {
    let truth = econe()
        .edited(|spec| {
            spec.screen.dead_rows = vec![11];
            spec.screen.flickering_columns = vec![64];
        })
        .unwrap();
    let faults = ReadingFaults {
        stuck_share: 0.002,
        flicker_share: 0.5,
    };
    let sensor = VirtualSensor::new(&truth, 8).unwrap().with_faults(faults);
    let loads = Frame::filled(64, 128, 50.0);
    let (mut out, mut stuck) = (0, 0);
    for frame in 0..40 {
        let reading = sensor.read(&loads, frame);
        assert!(reading.siemens.values().iter().all(|&g| g > 1e-4));
        let silent = |values: [f64; 3]| values.iter().filter(|&&v| v < 20.0).count() >= 2;
        let row: [f64; 3] = std::array::from_fn(|i| reading.counts.at(11, 20 * i));
        assert!(silent(row));
        let column: [f64; 3] = std::array::from_fn(|i| reading.counts.at(20 * i, 64));
        out += usize::from(silent(column));
        let ceiling = |value: &&f64| **value == 65535.0;
        stuck += reading.counts.values().iter().filter(ceiling).count();
    }
    assert!((10..=30).contains(&out), "{out}");
    // Half of two in a thousand of 40 · 8192.
    assert!((250..=400).contains(&stuck), "{stuck}");
}

#[test]
fn the_true_sensor_recovers_the_loads_to_within_noise() {
    let sensor = econe();
    for (seed, pattern) in [
        (1, Pattern::hand()),
        (2, Pattern::new(PatternKind::Blobs { least: 5, most: 12 })),
        (3, Pattern::named("random").unwrap()),
    ] {
        let loads = pattern.loads(sensor.array(), seed, 80);
        let reading = VirtualSensor::new(&sensor, seed).unwrap().read(&loads, 80);
        let error = error_g(&sensor, &loads, &reading);
        assert!(error < 0.1, "{pattern:?}: {error} g");
    }
}

#[test]
fn the_pipeline_undoes_everything_that_is_in_the_sensor_file() {
    let imperfections = Imperfections {
        dead_rows: 1,
        ..Imperfections::beyond_the_circuit()
    };
    let sensor = VirtualSensor::imperfect(&econe(), &imperfections, 6).unwrap();
    let truth = sensor.sensor();
    let mut loads = Pattern::hand().loads(truth.array(), 6, 80);
    let dead = truth.screen().dead_rows[0];
    // What a cover hands on to or from a dead row cannot be known.
    for row in dead.saturating_sub(4)..(dead + 5).min(64) {
        for column in 0..128 {
            loads.values_mut()[row * 128 + column] = 0.0;
        }
    }
    let reading = sensor.read(&loads, 80);
    let error = error_g(truth, &loads, &reading);
    assert!(error < 0.2, "{error} g");
    // What the owner knows is not enough.
    assert!(error_g(&econe(), &loads, &reading) > 5.0 * error);
}

#[test]
fn a_sensor_without_a_load_law_is_refused() {
    let truth = econe()
        .edited(|spec| {
            spec.material = None;
        })
        .unwrap();
    let error = VirtualSensor::new(&truth, 0).unwrap_err();
    assert!(error.to_string().contains("material"), "{error}");
}

/// A material that creeps reads a held load as heavier than a fresh one, and something of it once it is gone; the law undoes it.
#[test]
fn a_material_that_remembers_is_read_in_order_and_undone() {
    let nominal = preset("mat-32x32-adg732").unwrap();
    let truth = imperfect(&nominal, &Imperfections::creeping(), 1).unwrap();
    let sensor = VirtualSensor::new(&truth, 1).unwrap().with_period_secs(1.0);
    let pressed = |load: f64| Frame::<Grams>::filled(32, 32, load);
    let mut memory = sensor.memory();
    let mut read = |load: f64, frame: u64| {
        let scan = sensor.read_next(&mut memory, &pressed(load), frame);
        (scan.siemens.at(3, 4), scan.counts)
    };
    let mut pipeline = Pipeline::new(&truth, default_method(&truth).unwrap()).unwrap();
    let mut last = 0.0;
    for (frame, load) in [0.0, 200.0, 200.0, 200.0, 200.0, 0.0, 0.0]
        .into_iter()
        .enumerate()
    {
        let (siemens, counts) = read(load, frame as u64);
        if (2..5).contains(&frame) {
            assert!(siemens > 1.001 * last, "creep, frame {frame}");
        }
        last = siemens;
        let found = pipeline.process(&counts);
        let found = grams_from_newtons(found.newtons().unwrap().at(3, 4));
        assert!(
            (found - load).abs() < 0.02 * 200.0,
            "frame {frame}: {found} of {load} g"
        );
    }
    let rested = LoadLaw::from_sensor(&truth)
        .unwrap()
        .siemens_from_grams(3 * 32 + 4, 0.0);
    assert!(last > 1.5 * rested, "what is gone still reads");
    // Pressed by itself and held for two seconds: between a fresh press and one that has crept to the end.
    let alone = sensor.read(&pressed(200.0), 0).siemens.at(3, 4);
    let law = LoadLaw::from_sensor(&truth).unwrap();
    let acting = law.grams_from_siemens(3 * 32 + 4, alone);
    assert!((206.0..218.0).contains(&acting), "{acting}");
}
