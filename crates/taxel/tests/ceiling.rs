//! Loads that are too large for the converter: their readings are bounds, and no stuck ones, and what stands on their lines
//! is less certain by what they may be.

use taxel::calibrate::{CalibrationData, CalibrationOptions, calibrate};
use taxel::frame::grams_from_newtons;
use taxel::pipeline::Pipeline;
use taxel::sensor::preset;
use taxel::simulate::{
    Grams, ReadingFaults, VirtualSensor, labelled_presses, uniform_levels, validation_frames,
};
use taxel::solve::default_method;
use taxel::uncertainty::StandardErrors;
use taxel::{Frame, Mark, Sensor};

/// A 16 × 16 of the e-Cone's circuit whose converter ends at so many volts: 1.2 V is some 400 g on a taxel.
fn sensor(full_scale_volts: f64) -> Sensor {
    let econe = preset("econe").unwrap();
    econe
        .edited(|spec| {
            (spec.array.rows, spec.array.columns) = (16, 16);
            spec.array.geometry = None;
            spec.converter.full_scale_volts = full_scale_volts;
            spec.converter.noise_counts = Some(3.0);
        })
        .unwrap()
}

fn calibrated(truth: &Sensor, data: &CalibrationData) -> (Sensor, Vec<String>) {
    let parts = truth.edited(|spec| spec.material = None).unwrap();
    let options = CalibrationOptions::default();
    let fit = calibrate(&parts, data, &options, &mut |_, _| {}).unwrap();
    (fit.sensor, fit.report.warnings)
}

fn one_press(sensor: &Sensor, load_g: f64) -> Frame<Grams> {
    let mut loads = Frame::zeros(sensor.rows(), sensor.columns());
    loads.values_mut()[5 * sensor.columns() + 9] = load_g;
    loads
}

#[test]
fn a_lone_press_at_the_ceiling_is_a_bound_where_labels_reach_it() {
    let truth = sensor(1.2);
    for seed in [1, 2, 3] {
        let real = VirtualSensor::new(&truth, seed).unwrap();
        let (found, warnings) = calibrated(&truth, &labelled_presses(&real, 80));
        assert!(found.screen().ceiling_is_load, "seed {seed}");
        assert!(!found.screen().repair, "seed {seed}");
        assert!(
            warnings.iter().any(|w| w.contains("converter's ceiling")),
            "{warnings:?}"
        );
        let mut pipeline = Pipeline::new(&found, default_method(&found).unwrap()).unwrap();
        let result = pipeline.process(&real.read(&one_press(&truth, 560.0), 0).counts);
        let loads = result.newtons().unwrap();
        assert_eq!(loads.mark_at(5, 9), Mark::Saturated);
        let least_g = grams_from_newtons(loads.at(5, 9));
        assert!((300.0..560.0).contains(&least_g), "{least_g}");
    }
}

#[test]
fn readings_stuck_at_the_ceiling_are_stuck_where_no_load_reaches_it() {
    let truth = sensor(3.3);
    for seed in [1, 2, 3] {
        let mut faults = ReadingFaults::default();
        faults.stuck_share = 0.002;
        let real = VirtualSensor::new(&truth, seed)
            .unwrap()
            .with_faults(faults);
        let (found, _) = calibrated(&truth, &labelled_presses(&real, 80));
        assert!(!found.screen().ceiling_is_load, "seed {seed}");
        assert!(found.screen().repair, "seed {seed}");
    }
}

/// Of the taxels that are not at the ceiling themselves, in frames where others are.
#[test]
fn intervals_hold_beside_readings_at_the_ceiling() {
    let truth = sensor(1.2);
    let (mut inside, mut all) = (0, 0);
    for seed in [1, 2, 3] {
        let real = VirtualSensor::new(&truth, seed).unwrap();
        let mut data = labelled_presses(&real, 80);
        data.uniform = uniform_levels(&real, &[50.0, 150.0, 300.0], 3);
        let (found, _) = calibrated(&truth, &data);
        let mut pipeline = Pipeline::new(&found, default_method(&found).unwrap()).unwrap();
        let mut errors = StandardErrors::new(&found, None).unwrap();
        for (counts, loads) in validation_frames(&real, 6) {
            let result = pipeline.process(&counts);
            let newtons = result.newtons().unwrap().clone();
            if !newtons.marks().contains(&Mark::Saturated) {
                continue;
            }
            let siemens = result.siemens.unwrap().clone();
            let mut marks = newtons.marks().to_vec();
            let sigma = errors
                .of_loads(&siemens, newtons.values(), true, &mut marks)
                .unwrap()
                .clone();
            let half = errors.factor_95();
            for taxel in 0..newtons.values().len() {
                if newtons.marks()[taxel] == Mark::Saturated || loads.values()[taxel] == 0.0 {
                    continue;
                }
                let off = grams_from_newtons(newtons.values()[taxel]) - loads.values()[taxel];
                all += 1;
                inside += i32::from(off.abs() <= half * grams_from_newtons(sigma.values()[taxel]));
            }
        }
    }
    assert!(all > 300, "{all}");
    assert!(100 * inside >= 95 * all, "{inside} of {all}");
}
