//! What `calibrate --totals` does on simulated sensors: held-out error, error of new totals, exponent, intervals that hold.
//!
//!     cargo run --release -p taxel --example known_totals -- 1,2,3
//!
//! Blobs of known total load on sensors drawn from the model, noise of half a count; the fit knows the circuit alone. `uneven`: every
//! switch and taxel differs by a tenth, a row is dead; the circuit is known, as after an earlier calibration, or as the parts list
//! has it.
//! New totals are of 40 other frames, each summed as `compensate --figures` sums it.

use std::env;

use taxel::calibrate::{CalibrationOptions, TotalLoad, TotalsReport, calibrate_totals};
use taxel::frame::grams_from_newtons;
use taxel::parallel::Serial;
use taxel::pipeline::{Pipeline, Repair};
use taxel::sensor::{Population, SensorSpec, preset};
use taxel::simulate::{Imperfections, Pattern, PatternKind, ReadingFaults, VirtualSensor};
use taxel::solve::default_method;
use taxel::uncertainty::{Bias, FigureErrors, NoiseBias};
use taxel::{Frame, Grams, Sensor};

/// Peaks of the blobs, grams a taxel, and frames of each.
const PEAKS_G: [f64; 5] = [50.0, 100.0, 200.0, 300.0, 400.0];
const FRAMES: usize = 8;
const EMPTY: usize = 5;
const NEW: u64 = 40;

fn main() {
    let words: Vec<String> = env::args().skip(1).collect();
    let seeds = words.first().map_or("1,2,3", String::as_str);
    let seeds: Vec<u64> = seeds
        .split(',')
        .map(|s| s.parse().expect("a seed"))
        .collect();
    println!(
        "| Sensor | Drawn | Seed | Held out, g | % | New totals, g | % | Bias, % | Exponent | True | In 95 % interval |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|");
    for (name, sensor) in sensors() {
        for (drawn, imperfections, is_known) in [
            ("as the file", Imperfections::default(), true),
            ("uneven, circuit known", uneven(), true),
            ("uneven, parts list", uneven(), false),
        ] {
            for &seed in &seeds {
                let real = VirtualSensor::imperfect(&sensor, &imperfections, seed)
                    .expect("a sensor that can be drawn");
                let circuit = if is_known { real.sensor() } else { &sensor };
                line(name, drawn, circuit, &real);
            }
        }
    }
}

/// Switches and taxels that differ by a tenth, and a dead row; no reading is stuck, and no line comes and goes.
fn uneven() -> Imperfections {
    let mut uneven = Imperfections::uneven();
    uneven.flickering_columns = 0;
    uneven.faults = ReadingFaults::default();
    uneven
}

/// Presets with half a count of noise, and a sole cut from one.
fn sensors() -> Vec<(&'static str, Sensor)> {
    let noisy = |name: &str, edit: &dyn Fn(&mut SensorSpec)| {
        let noisy = preset(name).and_then(|sensor| {
            sensor.edited(|spec| {
                spec.converter.noise_counts = Some(0.5);
                edit(spec);
            })
        });
        noisy.expect("a preset")
    };
    let mat = "mat-16x16-cd4067";
    vec![
        ("mat-16x16-cd4067", noisy(mat, &|_| ())),
        (
            "mat-16x16-cd4067, 12 bits",
            noisy(mat, &|spec| spec.converter.bits = 12),
        ),
        ("mat-32x32-adg732", noisy("mat-32x32-adg732", &|_| ())),
        ("insole 32x10, 253 taxels", noisy(mat, &insole)),
        ("econe", noisy("econe", &|_| ())),
    ]
}

/// A sole of 253 taxels in 32 × 10 crossings, 12 bits.
fn insole(spec: &mut SensorSpec) {
    (spec.array.rows, spec.array.columns) = (32, 10);
    spec.converter.bits = 12;
    let mut places: Vec<(f64, usize, usize)> = Vec::new();
    for row in 0..32 {
        for column in 0..10 {
            let (y, x) = ((row as f64 - 15.5) / 16.0, (column as f64 - 4.5) / 5.0);
            places.push((y.powi(4) + x * x * (1.0 + 0.4 * y), row, column));
        }
    }
    places.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut lines = vec![vec![0.0; 10]; 32];
    for (_, row, column) in &places[..253] {
        lines[*row][*column] = 1.0;
    }
    spec.array.population = Some(Population::Each(lines));
}

fn line(name: &str, drawn: &str, circuit: &Sensor, real: &VirtualSensor) {
    let parts = circuit
        .edited(|spec| spec.material = None)
        .expect("a parts list");
    let totals = totals(real);
    let options = CalibrationOptions::default();
    let found = calibrate_totals(&parts, &totals, &options, &Serial, &mut |_, _| ());
    let found = match found {
        Ok(found) => found,
        Err(error) => {
            println!("| {name} | {drawn} | {} | {error} |", real.seed());
            return;
        }
    };
    let new = new_totals(&found.sensor, real);
    let mean = |each: &dyn Fn(&(f64, f64, bool)) -> f64| {
        new.iter().map(each).sum::<f64>() / new.len() as f64
    };
    let TotalsReport {
        held_out_mean_absolute_g,
        held_out_mean_absolute_share,
        doubts,
        parameters,
        left_out,
        ..
    } = &found.report;
    println!(
        "| {name} | {drawn} | {} | {:.1} | {:.2} | {:.1} | {:.2} | {:+.2} | {} | {:.3} | {} of {} | {}",
        real.seed(),
        held_out_mean_absolute_g.unwrap_or(f64::NAN),
        100.0 * held_out_mean_absolute_share.unwrap_or(f64::NAN),
        mean(&|(says, load, _)| (says - load).abs()),
        100.0 * mean(&|(says, load, _)| (says / load - 1.0).abs()),
        100.0 * mean(&|(says, load, _)| says / load - 1.0),
        parameters[1]
            .to_string()
            .replace("material.exponent = ", ""),
        exponent(real.sensor()),
        new.iter().filter(|(_, _, inside)| *inside).count(),
        new.len(),
        match left_out.len() {
            0 => doubts.join("; "),
            out => format!("{out} frames left out; {}", doubts.join("; ")),
        },
    );
}

/// The mean exponent.
fn exponent(sensor: &Sensor) -> f64 {
    let taxels = sensor.rows() * sensor.columns();
    let material = sensor.material().expect("a law");
    let each = (0..taxels).map(|taxel| material.exponent(taxel));
    each.sum::<f64>() / taxels as f64
}

fn blobs(peak_g: f64) -> Pattern {
    Pattern::new(PatternKind::Blobs { least: 2, most: 6 }).with_peak_g(peak_g)
}

fn sum(loads: &Frame<Grams>) -> f64 {
    loads.values().iter().sum()
}

fn totals(real: &VirtualSensor) -> Vec<TotalLoad> {
    let array = real.sensor().array();
    let mut totals = Vec::new();
    for (level, peak_g) in PEAKS_G.into_iter().enumerate() {
        for frame in 0..FRAMES {
            let frame = (level * FRAMES + frame) as u64;
            let loads = blobs(peak_g).loads(array, real.seed(), frame);
            totals.push(TotalLoad {
                frame: real.read(&loads, frame).counts,
                load_g: sum(&loads),
                // Without one, every frame would be a load of its own.
                group: Some(format!("peak {peak_g}")),
            });
        }
    }
    for frame in 0..EMPTY as u64 {
        let loads = Frame::<Grams>::zeros(array.rows, array.columns);
        totals.push(TotalLoad {
            frame: real.read(&loads, 900 + frame).counts,
            load_g: 0.0,
            group: None,
        });
    }
    totals
}

/// What a calibrated sensor sums other frames to, their true totals, and whether the stated interval holds them.
fn new_totals(sensor: &Sensor, real: &VirtualSensor) -> Vec<(f64, f64, bool)> {
    let pipeline = || {
        let method = default_method(sensor).expect("a method");
        let mut pipeline = Pipeline::new(sensor, method).expect("a law");
        pipeline.set_repair(Repair::Everything);
        pipeline
    };
    let mut own = pipeline();
    let mut bias = NoiseBias::new(sensor, pipeline(), None);
    let mut errors = FigureErrors::new(sensor, None).expect("a law");
    let mut found = Vec::new();
    for frame in 1000..1000 + NEW {
        let peak_g = 60.0 + 320.0 * (frame - 1000) as f64 / NEW as f64;
        let loads = blobs(peak_g).loads(real.sensor().array(), real.seed(), frame);
        own.begin_anew();
        let result = own.process(&real.read(&loads, frame).counts);
        if !result.outcome.is_answer() {
            continue;
        }
        let newtons = result.loads.expect("a law");
        let added = bias.as_mut().and_then(|bias| {
            bias.begin_anew();
            bias.of(result.volts, newtons)
        });
        errors.set_bias(added);
        let taken = added.map_or(0.0, Bias::of_sum);
        let force = newtons.values().iter().sum::<f64>() - taken;
        let siemens = result.siemens.expect("solved");
        let error = errors.of(siemens, newtons, true).total_force_newtons;
        let (says, load) = (grams_from_newtons(force), sum(&loads));
        let half = grams_from_newtons(error.half_width_95);
        found.push((says, load, (says - load).abs() <= half));
    }
    found
}
