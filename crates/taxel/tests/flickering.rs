//! A column that comes and goes, and single readings that are stuck: uniform loads tell them, and a calibration does without.

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
        // An unloaded taxel reads 16 counts, hardly more than one whose line is out.
        spec.converter.full_scale_volts = 3.3;
    });
    let nominal = nominal.unwrap();
    let parts = nominal.edited(|spec| spec.material = None).unwrap();
    for seed in [2, 3, 22] {
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
        assert!(out > 0 && out < data.uniform.len(), "seed {seed}");
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
                // A reading that is stuck at 0 cannot be told from one that is hardly more.
                let is_sound = found.marks()[taxel].is_measured()
                    && taxel % 16 != column
                    && counts.values()[taxel] > 0.0;
                if is_sound && load > 0.0 {
                    sum += (grams_from_newtons(found.values()[taxel]) - load).abs();
                    count += 1;
                }
            }
        }
        let error = sum / f64::from(count);
        assert!(error < 0.1, "seed {seed}: {error}");
    }
}
