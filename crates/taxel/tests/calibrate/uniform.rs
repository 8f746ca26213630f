//! Uniform loads alone: law, gains and switches line by line, of mats whose lines and taxels differ by a tenth.

use taxel::calibrate::{CalibrationOptions, UniformCalibration, calibrate_uniform};
use taxel::parallel::Serial;
use taxel::sensor::{DiodePlace, DiodeSpec, PerTaxel, SensorSpec, Topology, preset};
use taxel::simulate::{Imperfections, Pattern, PatternKind, VirtualSensor};
use taxel::{Counts, Error, Frame, Sensor};

const LOADS_G: [f64; 8] = [0.0, 5.0, 10.0, 20.0, 40.0, 80.0, 160.0, 320.0];

fn mat(size: usize, edit: impl FnOnce(&mut SensorSpec)) -> Sensor {
    let edited = preset("mat-16x16-cd4067").unwrap().edited(|spec| {
        (spec.array.rows, spec.array.columns) = (size, size);
        spec.converter.bits = 12;
        edit(spec);
    });
    edited.unwrap()
}

/// Five frames of every load, of a sensor that differs from the file; and that sensor.
fn loaded(nominal: &Sensor, seed: u64) -> (Sensor, Vec<(Frame<Counts>, f64)>) {
    let real = VirtualSensor::imperfect(nominal, &Imperfections::uneven(), seed).unwrap();
    let mut frames = Vec::new();
    for load_g in LOADS_G {
        let uniform = Pattern::new(PatternKind::Uniform).with_peak_g(load_g);
        let five = real.recording(&uniform, 0..5);
        frames.extend(five.map(|(_, reading)| (reading.counts, load_g)));
    }
    (real.sensor().clone(), frames)
}

fn calibrated(
    nominal: &Sensor,
    frames: &[(Frame<Counts>, f64)],
) -> Result<UniformCalibration, Error> {
    let parts = nominal.edited(|spec| spec.material = None)?;
    let options = CalibrationOptions::default();
    calibrate_uniform(&parts, frames, &options, &Serial, &mut |_, _| ())
}

fn gains(sensor: &Sensor) -> Vec<f64> {
    match &sensor.spec().material.as_ref().unwrap().gain {
        Some(PerTaxel::Each(rows)) => rows.concat(),
        other => panic!("{other:?}"),
    }
}

#[test]
fn gains_and_switches_come_out() {
    let diode = DiodeSpec::of_part(DiodePlace::DrivenLine, "1N4148");
    let mats = [
        mat(8, |_| ()),
        mat(8, |spec| {
            spec.readout.topology = Topology::DividerPulledRows;
            spec.readout.diode = Some(diode);
        }),
    ];
    for nominal in mats {
        for seed in 1..=3 {
            let (real, frames) = loaded(&nominal, seed);
            let found = calibrated(&nominal, &frames).unwrap();
            let words = nominal.readout().words();
            assert_eq!(found.report.doubts, Vec::<String>::new(), "{words} {seed}");
            let dead: Vec<usize> = real.screen().dead_rows.clone();
            assert_eq!(found.sensor.screen().dead_rows, dead, "{words} {seed}");
            // Where lines are dead, nothing tells a gain.
            let told = |taxel: &usize| {
                let screen = real.screen();
                !dead.contains(&(taxel / 8)) && !screen.flickering_columns.contains(&(taxel % 8))
            };
            let (ours, truth) = (gains(&found.sensor), gains(&real));
            let ratios: Vec<f64> = (0..64)
                .filter(told)
                .map(|t| (ours[t] / truth[t]).ln())
                .collect();
            let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
            let spread =
                ratios.iter().map(|r| (r - mean).powi(2)).sum::<f64>() / ratios.len() as f64;
            println!("{words} {seed}: gains {:.4}", spread.sqrt());
            assert!(spread.sqrt() < 0.015, "{words} {seed}: {}", spread.sqrt());
            let share = found.report.held_out_array_share.unwrap();
            assert!(share < 0.009, "{words} {seed}: {share}");
        }
    }
}

#[test]
fn loads_that_say_nothing_are_refused_or_doubted() {
    let nominal = mat(8, |_| ());
    let (_, frames) = loaded(&nominal, 1);
    let few: Vec<_> = frames.iter().take(15).cloned().collect();
    let error = calibrated(&nominal, &few).unwrap_err().to_string();
    assert!(
        error.contains("2 uniform loads above nothing are too few"),
        "{error}"
    );
    // Loads that are said to be others: shuffled labels.
    let shuffled: Vec<_> = frames
        .iter()
        .enumerate()
        .map(|(i, (frame, _))| (frame.clone(), LOADS_G[(3 * (i / 5) + 5) % 8]))
        .collect();
    let doubted = calibrated(&nominal, &shuffled);
    assert!(doubted.is_err() || !doubted.unwrap().report.doubts.is_empty());
    let negative: Vec<_> = frames
        .iter()
        .map(|(frame, _)| (frame.clone(), -1.0))
        .collect();
    let error = calibrated(&nominal, &negative).unwrap_err().to_string();
    assert!(error.contains("-1 g"), "{error}");
}
