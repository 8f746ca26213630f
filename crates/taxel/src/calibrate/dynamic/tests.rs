use proptest::prelude::*;

use super::*;
use crate::calibrate::LoadLaw;
use crate::circuit::{Circuit, Converter, LinearCircuit};
use crate::frame::grams_from_newtons;
use crate::pipeline::Pipeline;
use crate::sensor::preset;
use crate::simulate::{Grams, Pattern};
use crate::solve::default_method;
use crate::{Counts, Frame, Sensor};

fn law() -> DynamicLaw {
    DynamicLaw {
        lags: vec![(0.08, 0.8), (0.07, 8.0), (0.07, 80.0)],
        plays: vec![(0.07, 5.0), (0.07, 15.0), (0.07, 40.0)],
        period_secs: 0.1,
    }
}

/// Time, load, conductance of one taxel, from an independent implementation (numpy) of the same equations; its
/// parameters are those of [`law`] with g_zero 1 µS, factor 8.6 µS, exponent 0.806.
fn golden() -> Vec<[f64; 3]> {
    let text = include_str!("golden.csv");
    let lines = text
        .lines()
        .filter(|line| line.starts_with(|c: char| c.is_ascii_digit()));
    let number = |cell: &str| cell.trim().parse().unwrap();
    lines
        .map(|line| {
            let cells: Vec<f64> = line.split(',').take(3).map(number).collect();
            [cells[0], cells[1], cells[2]]
        })
        .collect()
}

#[test]
fn another_implementation_gives_the_same_both_ways() {
    let rows = golden();
    assert!(rows.len() >= 50);
    let power = LoadLaw::power(1e-6, 8.6e-6, 0.806);
    let secs: Vec<f64> = rows.iter().map(|row| row[0]).collect();
    let loads: Vec<f64> = rows.iter().map(|row| row[1]).collect();
    for (row, acting) in rows.iter().zip(law().acting(&secs, &loads)) {
        let siemens = power.siemens_from_grams(0, acting);
        assert!((siemens / row[2] - 1.0).abs() < 1e-10, "{row:?}: {siemens}");
    }
    let mut memory = Memory::new(&law(), 1);
    for row in &rows {
        let mut grams = [power.grams_from_siemens(0, row[2])];
        memory.loads_from_acting(Some(row[0]), &mut grams, |_| false);
        assert!((grams[0] - row[1]).abs() < 1e-7, "{row:?}: {grams:?}");
    }
}

fn histories() -> impl Strategy<Value = Vec<(f64, f64)>> {
    // Time steps of very different length, loads that jump, rest and stay.
    let load = prop_oneof![Just(0.0), Just(120.0), 0.0..400.0f64];
    prop::collection::vec(
        (
            prop_oneof![1e-6..1e-4f64, 0.01..0.2f64, 1.0..300.0f64],
            load,
        ),
        1..60,
    )
}

proptest! {
    #[test]
    fn the_inverse_undoes_the_law_for_any_history(history in histories(), count in 0usize..=4) {
        let mut law = law();
        law.lags.truncate(count);
        law.plays.truncate(4 - count);
        let mut now = 0.0;
        // From rest: the first frame is unloaded, or what is remembered would depend on what came before.
        let (mut secs, mut loads) = (vec![0.0], vec![0.0]);
        for (step, load) in history {
            now += step;
            secs.push(now);
            loads.push(load);
        }
        let mut memory = Memory::new(&law, 300);
        for ((&now, &load), acting) in secs.iter().zip(&loads).zip(law.acting(&secs, &loads)) {
            let mut grams = vec![acting; 300];
            memory.loads_from_acting(Some(now), &mut grams, |_| false);
            prop_assert!(grams.iter().all(|g| (g - load).abs() < 1e-7 * (1.0 + load)), "{} {load}", grams[0]);
        }
    }

    #[test]
    fn more_acting_load_is_never_less_load(history in histories(), more in 0.0..50.0f64) {
        let mut memory = Memory::new(&law(), 2);
        let mut now = 0.0;
        for (step, load) in &history {
            now += step;
            let mut grams = [*load, *load];
            memory.loads_from_acting(Some(now), &mut grams, |_| false);
        }
        let (_, load) = history[history.len() - 1];
        let mut grams = [load, load + more];
        memory.loads_from_acting(Some(now + 0.1), &mut grams, |_| false);
        prop_assert!(grams[1] >= grams[0]);
    }
}

#[test]
fn a_lost_taxel_carries_what_it_carried_and_time_backwards_begins_anew() {
    let mut memory = Memory::new(&law(), 2);
    for n in 0..20 {
        let mut grams = [100.0, 100.0];
        memory.loads_from_acting(Some(0.1 * f64::from(n)), &mut grams, |_| false);
    }
    let mut grams = [100.0, f64::NAN];
    memory.loads_from_acting(Some(2.0), &mut grams, |taxel| taxel == 1);
    assert!((grams[0] - grams[1]).abs() < 1.0, "{grams:?}");
    let mut grams = [100.0, 100.0];
    memory.loads_from_acting(None, &mut grams, |_| false);
    assert!(
        (grams[0] - grams[1]).abs() < 1.0 && grams[1].is_finite(),
        "{grams:?}"
    );
    let mut fresh = Memory::new(&law(), 2);
    let (mut a, mut b) = ([50.0, 80.0], [50.0, 80.0]);
    memory.loads_from_acting(Some(0.0), &mut a, |_| false);
    fresh.loads_from_acting(Some(0.0), &mut b, |_| false);
    assert_eq!(a, b);
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
    let series = Series {
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
        let series = Series {
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
