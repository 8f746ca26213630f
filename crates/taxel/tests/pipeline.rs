//! One call a frame: loads, marks and outcome of that frame, whatever it holds.

use taxel::pipeline::{Pipeline, Repair};
use taxel::screen::{LineFaults, LineScreen};
use taxel::sensor::{PerLine, preset};
use taxel::simulate::{Grams, Pattern, VirtualSensor};
use taxel::solve::{Stop, default_method};
use taxel::{Counts, Frame, Mark, Sensor};

fn econe(rows: usize, columns: usize) -> Sensor {
    preset("econe")
        .unwrap()
        .edited(|spec| {
            (spec.array.rows, spec.array.columns) = (rows, columns);
            spec.array.geometry = None;
        })
        .unwrap()
}

fn pipeline(sensor: &Sensor) -> Pipeline {
    Pipeline::new(sensor, default_method(sensor).unwrap()).unwrap()
}

/// Counts of one taxel under `load_g`, all others unloaded.
fn lone_press(sensor: &Sensor, taxel: usize, load_g: f64, seed: u64) -> Frame<Counts> {
    let mut loads = Frame::<Grams>::zeros(sensor.rows(), sensor.columns());
    loads.values_mut()[taxel] = load_g;
    let real = VirtualSensor::new(sensor, seed).unwrap();
    real.read(&loads, seed).counts
}

#[test]
fn a_frame_that_nothing_explains_is_zero_and_unresolved() {
    let sensor = econe(12, 12)
        .edited(|spec| {
            spec.readout.r_mux_row_ohms = Some(PerLine::One(70.0));
        })
        .unwrap();
    let mut pipeline = pipeline(&sensor);
    // More current in every row than 70 Ohm let through.
    let result = pipeline.process(&Frame::filled(12, 12, 60_000.0));
    assert!(matches!(result.outcome.stop, Stop::Infeasible(_)));
    assert!(!result.outcome.is_answer());
    for marks in [
        result.siemens.unwrap().marks(),
        result.newtons().unwrap().marks(),
    ] {
        assert!(marks.iter().all(|&mark| mark == Mark::Unresolved));
    }
    assert!(result.newtons().unwrap().values().iter().all(|&v| v == 0.0));
    let figures = taxel::metric::FrameFigures::of(result.newtons().unwrap(), &sensor);
    assert_eq!(figures.measured_share, 0.0);
}

#[test]
fn a_result_stays_what_it_is_however_often_it_is_looked_at() {
    let sensor = econe(16, 16)
        .edited(|spec| {
            spec.screen.repair = true;
            spec.material.as_mut().unwrap().spread = Some([0.03, 0.03, 0.01]);
        })
        .unwrap();
    let real = VirtualSensor::new(&sensor, 4).unwrap();
    let mut pipeline = pipeline(&sensor);
    for t in 0..6 {
        let loads = Pattern::hand().loads(sensor.array(), 4, 60 + t);
        let mut counts = real.read(&loads, t).counts;
        counts.values_mut()[100] = 0.0;
        let first = pipeline.process(&counts);
        let siemens = first.siemens.unwrap().clone();
        let loads = first.newtons().unwrap().clone();
        assert_eq!(siemens.marks(), loads.marks());
        assert_eq!(loads.marks()[100], Mark::Interpolated);
        let again = pipeline.result();
        assert_eq!(again.newtons().unwrap(), &loads);
        assert_eq!(again.siemens.unwrap(), &siemens);
    }
}

#[test]
fn a_line_that_the_sensor_file_declares_stays_so_whatever_a_recording_shows() {
    let sound = preset("mat-16x16-cd4067").unwrap();
    let sensor = sound
        .edited(|spec| spec.screen.dead_rows = vec![3])
        .unwrap();
    let counts = VirtualSensor::new(&sound, 1)
        .unwrap()
        .read(&Frame::zeros(16, 16), 0)
        .counts;
    let mut pipeline = pipeline(&sensor);
    for _ in 0..2 {
        let result = pipeline.process(&counts);
        let marks = result.newtons().unwrap().marks().to_vec();
        for (taxel, mark) in marks.into_iter().enumerate() {
            assert_eq!(mark == Mark::Open, taxel / 16 == 3, "{taxel}: {mark:?}");
        }
        // A live session looks for faulty lines now and then, and here finds none.
        pipeline.set_lines(&LineFaults::default());
    }
}

#[test]
fn loads_are_not_cut_off_at_zero_so_that_noise_sums_to_nothing() {
    let sensor = preset("mat-16x16-cd4067").unwrap();
    for seed in 0..3 {
        let real = VirtualSensor::new(&sensor, seed).unwrap();
        let mut pipeline = pipeline(&sensor);
        let (mut sum, mut of_absolutes) = (0.0, 0.0);
        for t in 0..40 {
            let empty = Frame::<Grams>::zeros(16, 16);
            let counts = real.read(&empty, t).counts;
            let result = pipeline.process(&counts);
            let loads = result.newtons().unwrap().values();
            sum += loads.iter().sum::<f64>();
            of_absolutes += loads.iter().map(|load| load.abs()).sum::<f64>();
        }
        assert!(
            sum.abs() < 0.3 * of_absolutes,
            "{seed}: {sum} of {of_absolutes}"
        );
    }
}

#[test]
fn a_pulled_cable_is_nothing_measured() {
    let sensor = econe(64, 128);
    let mut pipeline = pipeline(&sensor);
    pipeline.set_repair(Repair::Everything);
    let real = VirtualSensor::new(&sensor, 1).unwrap();
    for t in 0..3 {
        let empty = Frame::<Grams>::zeros(64, 128);
        pipeline.process(&real.read(&empty, t).counts);
    }
    let result = pipeline.process(&Frame::zeros(64, 128));
    let loads = result.newtons().unwrap();
    assert_eq!(loads.count(Mark::Stuck), 64 * 128);
    assert!(loads.values().iter().all(|&load| load == 0.0));
    assert_eq!(taxel::metric::measured_share(loads), 0.0);
}

#[test]
fn a_press_beyond_the_converter_is_a_lower_bound_also_when_it_stands_there_all_along() {
    for (name, taxel) in [("econe", 1000), ("mat-32x32-adg732", 500)] {
        let sensor = preset(name).unwrap();
        let mut sensor = sensor;
        // A converter that ends early.
        sensor = sensor
            .edited(|spec| {
                spec.converter.full_scale_volts /= 20.0;
            })
            .unwrap();
        let frames: Vec<_> = (0..6)
            .map(|seed| lone_press(&sensor, taxel, 900.0, seed))
            .collect();
        assert!(frames[0].values()[taxel] >= sensor.max_count());
        let mut lines = LineScreen::from_sensor(&sensor);
        for frame in &frames {
            lines.observe(frame).unwrap();
        }
        let faults = lines.finish();
        assert_eq!(faults.held_at_ceiling, [taxel], "{name}");
        let mut known = pipeline(&sensor);
        known.set_lines(&faults);
        let mut live = pipeline(&sensor);
        for (t, frame) in frames.iter().enumerate() {
            let result = known.process(frame);
            let loads = result.newtons().unwrap();
            assert_eq!(loads.marks()[taxel], Mark::Saturated, "{name} {t}");
            assert!(loads.values()[taxel] > 0.1, "{name} {t}");
            // Without a first pass the third frame tells.
            let mark = live.process(frame).siemens.unwrap().marks()[taxel];
            assert_eq!(mark == Mark::Saturated, t >= 2, "{name} {t}: {mark:?}");
        }
    }
}

#[test]
fn strips_read_as_well_as_any_other_array() {
    for (rows, columns) in [(1, 64), (64, 1), (1, 8), (2, 40)] {
        let sensor = econe(rows, columns);
        for seed in 0..3 {
            let real = VirtualSensor::new(&sensor, seed).unwrap();
            let pattern = Pattern::named("random").unwrap();
            let frames: Vec<_> = (0..30)
                .map(|t| {
                    let loads = pattern.loads(sensor.array(), seed, t);
                    (real.read(&loads, t).counts, loads)
                })
                .collect();
            let mut lines = LineScreen::from_sensor(&sensor);
            for (counts, _) in &frames {
                lines.observe(counts).unwrap();
            }
            let faults = lines.finish();
            assert!(faults.is_empty(), "{rows} x {columns}: {:?}", faults.faults);
            let mut pipeline = pipeline(&sensor);
            pipeline.set_lines(&faults);
            for (counts, truth) in &frames {
                let result = pipeline.process(counts);
                for (load, truth) in result
                    .newtons()
                    .unwrap()
                    .values()
                    .iter()
                    .zip(truth.values())
                {
                    let error = taxel::frame::grams_from_newtons(*load) - truth;
                    assert!(error.abs() < 2.0, "{rows} x {columns} {seed}: {error} g");
                }
            }
        }
    }
}
