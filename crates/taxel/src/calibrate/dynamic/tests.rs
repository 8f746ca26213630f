use super::*;
use crate::circuit::{Circuit, Converter, LinearCircuit};
use crate::frame::grams_from_newtons;
use crate::pipeline::Pipeline;
use crate::sensor::preset;
use crate::simulate::Pattern;

fn law() -> DynamicLaw {
    DynamicLaw {
        lags: vec![(0.08, 0.8), (0.07, 8.0), (0.07, 80.0)],
        plays: vec![(0.07, 5.0), (0.07, 15.0), (0.07, 40.0)],
        period_secs: 0.1,
    }
}

/// The sensor, times, counts, loads.
type Recorded = (Sensor, Vec<f64>, Vec<Frame<Counts>>, Vec<Frame<Grams>>);

/// A small sensor whose material remembers, and a recording of it: blobs that wander, grow and go.
fn remembering(seed: u64, frames: usize) -> Recorded {
    let sensor = preset("econe")
        .unwrap()
        .edited(|spec| {
            (spec.array.rows, spec.array.columns) = (12, 12);
        })
        .unwrap();
    let pattern = Pattern::named("blobs").unwrap().with_peak_g(200.0);
    let secs: Vec<f64> = (0..frames).map(|n| 0.1 * n as f64).collect();
    // A pattern's frames are drawn one by one; joined by straight lines they are a movement. The last two rows stay free.
    let (between, shapes) = (40, frames / 40 + 2);
    let shape = |k: usize| match k {
        0 => Frame::<Grams>::zeros(12, 12),
        k => {
            let mut loads = pattern.loads(sensor.array(), seed, k as u64);
            loads.values_mut()[120..].fill(0.0);
            loads
        }
    };
    let shapes: Vec<_> = (0..shapes).map(shape).collect();
    let loads: Vec<Frame<Grams>> = (0..frames)
        .map(|n| {
            let (k, part) = (n / between, (n % between) as f64 / between as f64);
            // Rests between movements, so that creep is seen on its own.
            let part = (2.0 * part).min(1.0);
            shapes[k].map(|i, a| a + part * (shapes[k + 1].values()[i] - a))
        })
        .collect();
    let power = LoadLaw::from_sensor(&sensor).unwrap();
    let acting: Vec<Vec<f64>> = (0..144)
        .map(|taxel| {
            law().acting(
                &secs,
                &loads.iter().map(|f| f.values()[taxel]).collect::<Vec<_>>(),
            )
        })
        .collect();
    let circuit = LinearCircuit::from_sensor(&sensor).unwrap();
    let converter = Converter::from_sensor(&sensor);
    let counts = (0..frames)
        .map(|n| {
            let siemens = Frame::<Grams>::zeros(12, 12)
                .map(|taxel, _| power.siemens_from_grams(taxel, acting[taxel][n]));
            let mut counts = converter.counts_from_volts(&circuit.predict(&siemens).unwrap());
            counts.time_secs = Some(secs[n]);
            counts
        })
        .collect();
    (sensor, secs, counts, loads)
}

/// Mean absolute error over loaded taxels, grams.
fn error(sensor: &Sensor, counts: &[Frame<Counts>], loads: &[Frame<Grams>]) -> f64 {
    let mut pipeline = Pipeline::new(sensor, default_method(sensor).unwrap()).unwrap();
    let (mut sum, mut number) = (0.0, 0.0);
    for (counts, loads) in counts.iter().zip(loads) {
        let found = pipeline.process(counts).newtons().unwrap().clone();
        // Asked twice, it says the same.
        assert_eq!(
            found.values(),
            pipeline.result().newtons().unwrap().values()
        );
        for (found, &load) in found.values().iter().zip(loads.values()) {
            if load > 0.0 {
                sum += (grams_from_newtons(*found) - load).abs();
                number += 1.0;
            }
        }
    }
    sum / number
}

#[test]
fn a_material_that_remembers_is_found_and_undone() {
    let (truth, secs, counts, loads) = remembering(3, 600);
    let parts = truth
        .edited(|spec| {
            spec.material = None;
            spec.readout.r_mux_column_ohms = Some(crate::sensor::PerLine::One(5.0));
            spec.readout.r_mux_row_ohms = Some(crate::sensor::PerLine::One(5.0));
        })
        .unwrap();
    let series = LoadSeries {
        secs: &secs,
        frames: &counts,
        loads: &loads,
    };
    let found = fit_dynamic(&parts, &series, 3, 3, &mut |_, _| {}).unwrap();
    assert!(found.taxels >= 10);
    let (_, _, other_counts, other_loads) = remembering(8, 600);
    let dynamic = error(&found.sensor, &other_counts, &other_loads);
    let fixed = error(&found.best_static, &other_counts, &other_loads);
    assert!(
        dynamic < 0.1 * fixed,
        "{dynamic} g with memory, {fixed} g without"
    );
    // What was found survives its file.
    let again = Sensor::from_toml(&found.sensor.to_toml()).unwrap();
    assert_eq!(again, found.sensor);
}

#[test]
fn a_frame_that_nothing_explains_leaves_no_memory() {
    let (mut sensor, _, counts, _) = remembering(3, 80);
    sensor = sensor
        .edited(|spec| {
            spec.readout.r_mux_column_ohms = Some(crate::sensor::PerLine::One(70.0));
            spec.readout.r_mux_row_ohms = Some(crate::sensor::PerLine::One(70.0));
            spec.material.as_mut().unwrap().dynamic = Some(law().to_spec());
        })
        .unwrap();
    // More current in every row than 70 Ohm let through.
    let mut impossible = Frame::<Counts>::filled(12, 12, 60_000.0);
    impossible.time_secs = Some(7.85);
    let last = |hurt: bool| {
        let mut pipeline = Pipeline::new(&sensor, default_method(&sensor).unwrap()).unwrap();
        for frame in &counts[..79] {
            pipeline.process(frame);
        }
        if hurt {
            let outcome = pipeline.process(&impossible).outcome;
            assert!(
                matches!(outcome.stop, crate::solve::Stop::Infeasible(_)),
                "{outcome:?}"
            );
        }
        let result = pipeline.process(&counts[79]);
        result.newtons().unwrap().values().to_vec()
    };
    let (whole, hurt) = (last(false), last(true));
    let most = whole.iter().copied().fold(0.0, f64::max);
    assert!(most > 0.1, "{most}");
    for (a, b) in whole.iter().zip(&hurt) {
        assert!((a - b).abs() < 0.01 * most, "{a} {b}");
    }
}

#[test]
fn series_that_cannot_be_fitted_are_refused() {
    let (sensor, secs, counts, loads) = remembering(3, 60);
    let fit = |secs: &[f64], frames: &[Frame<Counts>], loads: &[Frame<Grams>]| {
        let series = LoadSeries {
            secs,
            frames,
            loads,
        };
        fit_dynamic(&sensor, &series, 3, 3, &mut |_, _| {})
            .unwrap_err()
            .to_string()
    };
    assert!(fit(&secs[..20], &counts[..20], &loads[..20]).contains("50 or more"));
    assert!(fit(&secs, &counts, &loads[..59]).contains("59 frames of loads"));
    let mut backwards = secs.clone();
    backwards[30] = 0.0;
    assert!(fit(&backwards, &counts, &loads).contains("frame 30"));
    backwards[30] = f64::NAN;
    assert!(fit(&backwards, &counts, &loads).contains("frame 30"));
    let empty = vec![Frame::zeros(12, 12); 60];
    assert!(fit(&secs, &counts, &empty).contains("0 taxels of the series are ever loaded"));
}
