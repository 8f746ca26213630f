//! The whole chain on every shipped preset and every read-out, by seeds: presses, a fit that knows the parts list alone,
//! then loads of a hand, fingers and feet, beside what the true parameters give. One line a sensor and seed, as CSV.
//!
//! `cargo run --release -p taxel --example every_preset -- [SIZES [BITS [SEEDS]]]`, lists with commas.

#[path = "../tests/every_sensor/mod.rs"]
mod every_sensor;

use std::time::Instant;

use every_sensor::every_sensor;
use taxel::calibrate::{CalibrationOptions, calibrate};
use taxel::circuit::{Circuit, Converter, LinearCircuit, ROUNDING_COUNTS};
use taxel::frame::grams_from_newtons;
use taxel::material::LoadLaw;
use taxel::pipeline::Pipeline;
use taxel::screen::LineScreen;
use taxel::simulate::{Grams, Pattern, VirtualSensor, default_noise_counts, labelled_presses};
use taxel::solve::default_method;
use taxel::uncertainty::standard_errors;
use taxel::{Counts, Error, Frame, Mark, Sensor, Siemens};

const PATTERNS: [&str; 3] = ["hand", "fingers", "feet"];
/// Frames of each pattern, and the first of them: where the hand holds.
const FRAMES: u64 = 8;
const FIRST: u64 = 60;
const PRESSES: usize = 120;

/// Sums over the taxels that carry a load, and over all.
#[derive(Default)]
struct Score {
    error_g: f64,
    loaded: f64,
    faults: usize,
    marked: usize,
    /// Of all taxels, and of the loaded ones.
    covered: [f64; 2],
    judged: [f64; 2],
}

fn numbers<T: std::str::FromStr + Clone>(text: Option<String>, usual: &[T]) -> Vec<T> {
    match text {
        Some(text) => text.split(',').filter_map(|n| n.parse().ok()).collect(),
        None => usual.to_vec(),
    }
}

fn main() -> Result<(), Error> {
    let mut arguments = std::env::args().skip(1);
    let sizes = numbers(arguments.next(), &[8, 16, 32, 64]);
    let bits = numbers(arguments.next(), &[10, 12, 14, 16]);
    let seeds = numbers(arguments.next(), &(1..=10).collect::<Vec<u64>>());
    println!(
        "sensor,seed,fit,seconds,error_fitted_g,error_true_g,ratio,coverage_percent,judged,coverage_loaded_percent,judged_loaded,line_faults,readings_marked"
    );
    for (name, sensor) in every_sensor(&sizes, &bits) {
        for &seed in &seeds {
            println!("{name},{seed},{}", line(&sensor, seed)?);
        }
    }
    Ok(())
}

fn line(truth: &Sensor, seed: u64) -> Result<String, Error> {
    let real = VirtualSensor::new(truth, seed)?;
    let parts = truth
        .edited(|spec| {
            spec.material = None;
            spec.readout.r_mux_column_ohms = None;
            spec.readout.r_mux_row_ohms = None;
        })
        .unwrap();
    let presses = labelled_presses(&real, PRESSES);
    let begun = Instant::now();
    let fit = calibrate(
        &parts,
        &presses,
        &CalibrationOptions::default(),
        &mut |_, _| (),
    );
    let seconds = begun.elapsed().as_secs_f64();
    let recordings: Vec<_> = PATTERNS.iter().map(|name| record(&real, name)).collect();
    let with_truth = score(truth, &recordings)?;
    let best = with_truth.error_g / with_truth.loaded;
    let [(coverage, judged), (coverage_loaded, judged_loaded)] = [0, 1].map(|of| {
        let judged = with_truth.judged[of];
        (100.0 * with_truth.covered[of] / judged, judged)
    });
    let (word, fitted) = match &fit {
        Ok(fit) => {
            let report = &fit.report;
            let sound = report.doubts.is_empty() && report.suspects.is_empty();
            let word = if sound { "good" } else { "doubted" };
            (word, score(&fit.sensor, &recordings)?)
        }
        Err(_) => ("refused", Score::default()),
    };
    let error = fitted.error_g / fitted.loaded;
    Ok(format!(
        "{word},{seconds:.1},{error:.3},{best:.3},{:.2},{coverage:.1},{judged},{coverage_loaded:.1},{judged_loaded},{},{}",
        error / best,
        with_truth.faults + fitted.faults,
        with_truth.marked + fitted.marked
    ))
}

type Recording = Vec<(Frame<Counts>, Frame<Grams>)>;

fn record(real: &VirtualSensor, pattern: &str) -> Recording {
    let pattern = Pattern::named(pattern).expect("a known pattern");
    let array = real.sensor().array();
    (FIRST..FIRST + FRAMES)
        .map(|t| {
            let loads = pattern.loads(array, real.seed(), t);
            (real.read(&loads, t).counts, loads)
        })
        .collect()
}

fn score(sensor: &Sensor, recordings: &[Recording]) -> Result<Score, Error> {
    let mut score = Score::default();
    for recording in recordings {
        let mut lines = LineScreen::from_sensor(sensor);
        for (counts, _) in recording {
            lines.observe(counts)?;
        }
        let faults = lines.finish().with_declared(sensor.screen());
        score.faults += faults.faults.len();
        let mut pipeline = Pipeline::new(sensor, default_method(sensor)?)?;
        pipeline.set_lines(&faults);
        for (number, (counts, truth)) in recording.iter().enumerate() {
            let result = pipeline.process(counts);
            let loads = result.newtons()?;
            let lost = |mark: &&Mark| !matches!(mark, Mark::Good | Mark::Saturated);
            score.marked += loads.marks().iter().filter(lost).count();
            let pairs = loads.values().iter().zip(truth.values());
            for (load, &truth) in pairs.filter(|(_, truth)| **truth > 0.0) {
                score.error_g += (grams_from_newtons(*load) - truth).abs();
                score.loaded += 1.0;
            }
            // The dense derivative of a large array takes seconds.
            if number == 0 && truth.values().len() <= 1024 {
                cover(sensor, result.siemens.expect("solved"), truth, &mut score)?;
            }
        }
    }
    Ok(score)
}

/// How many conductances lie within 1.96 standard errors of what the truth gives.
fn cover(
    sensor: &Sensor,
    found: &Frame<Siemens>,
    truth: &Frame<Grams>,
    score: &mut Score,
) -> Result<(), Error> {
    let law = LoadLaw::from_sensor(sensor)?;
    let converter = Converter::from_sensor(sensor);
    let noise = default_noise_counts(sensor.converter().bits).hypot(ROUNDING_COUNTS);
    let circuit = LinearCircuit::from_sensor(sensor)?;
    let sigma = noise * converter.lsb_volts();
    let Ok((errors, _)) = standard_errors(&mut *circuit.operating_point(), found.values(), sigma)
    else {
        return Ok(());
    };
    for (taxel, error) in errors.into_iter().enumerate() {
        if found.marks()[taxel] == Mark::Good && error.is_finite() {
            let load = truth.values()[taxel];
            let wanted = law.siemens_from_grams(taxel, load);
            let within = (found.values()[taxel] - wanted).abs() <= 1.96 * error;
            for of in 0..=usize::from(load > 0.0) {
                score.judged[of] += 1.0;
                score.covered[of] += f64::from(u8::from(within));
            }
        }
    }
    Ok(())
}
