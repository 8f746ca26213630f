//! A column that comes and goes: uniform loads tell it, and a calibration does without what it reads when it is out.

use taxel::calibrate::{CalibrationOptions, calibrate};
use taxel::frame::grams_from_newtons;
use taxel::pipeline::Pipeline;
use taxel::sensor::{Topology, preset};
use taxel::simulate::{
    Imperfections, VirtualSensor, labelled_presses, uniform_levels, validation_frames,
};
use taxel::solve::default_method;

#[test]
fn a_column_that_is_out_under_some_even_loads_spoils_no_gain() {
    let nominal = preset("econe").unwrap().edited(|spec| {
        (spec.array.rows, spec.array.columns) = (16, 16);
        spec.array.geometry = None;
        spec.readout.topology = Topology::TiaZeroPotential;
    });
    let nominal = nominal.unwrap();
    let parts = nominal.edited(|spec| spec.material = None).unwrap();
    let mut judged = 0;
    for seed in 1..=4 {
        let real = VirtualSensor::imperfect(&nominal, &Imperfections::uneven(), seed).unwrap();
        let column = real.sensor().screen().flickering_columns[0];
        let mut data = labelled_presses(&real, 80);
        data.uniform = uniform_levels(&real, &[50.0, 150.0, 300.0], 3);
        let sound_row = (real.sensor().screen().dead_rows[0] + 5) % 16;
        let reads = data
            .uniform
            .iter()
            .map(|(frame, _)| frame.at(sound_row, column));
        let out = reads.filter(|counts| *counts < 100.0).count();
        if out == 0 || out == data.uniform.len() {
            continue;
        }
        judged += 1;
        let fit = calibrate(
            &parts,
            &data,
            &CalibrationOptions::default(),
            &mut |_, _| {},
        )
        .unwrap();
        assert_eq!(
            fit.sensor.screen().flickering_columns,
            [column],
            "seed {seed}"
        );
        let mut pipeline =
            Pipeline::new(&fit.sensor, default_method(&fit.sensor).unwrap()).unwrap();
        let (mut sum, mut count) = (0.0, 0);
        for (counts, loads) in validation_frames(&real, 6) {
            let found = pipeline.process(&counts);
            let found = found.newtons().unwrap();
            for (taxel, &load) in loads.values().iter().enumerate() {
                let is_sound = found.marks()[taxel].is_measured() && taxel % 16 != column;
                if is_sound && load > 0.0 {
                    sum += (grams_from_newtons(found.values()[taxel]) - load).abs();
                    count += 1;
                }
            }
        }
        let error = sum / f64::from(count);
        assert!(error < 0.1, "seed {seed}: {error}");
    }
    assert!(judged >= 2, "{judged}");
}
