//! Which presses tell most: those that `PressPlan` chooses one after the other, beside as many on taxels and with loads drawn by chance,
//! alone or among other things. Sensors whose switches and taxels differ by a tenth, known by their parts lists; the error is that of
//! loads of other contacts. One line a sensor, seed, way and number of presses, as CSV.
//!
//! `cargo run --release -p taxel --example guided_presses -- [PRESETS [SEEDS]]`, lists with commas.

use std::time::Instant;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use taxel::calibrate::{
    CalibrationData, CalibrationOptions, MadePress, PressLabel, PressPlan, calibrate,
};
use taxel::frame::grams_from_newtons;
use taxel::pipeline::Pipeline;
use taxel::sensor::preset;
use taxel::simulate::{Imperfections, ReadingFaults, VirtualSensor, validation_frames};
use taxel::solve::default_method;
use taxel::{Error, Frame, Sensor};

const LOADS_G: [f64; 4] = [50.0, 100.0, 200.0, 500.0];
const COUNTS: [usize; 3] = [12, 20, 36];
/// A fit so often while presses are chosen.
const REFIT: usize = 4;
/// Presses among the same other things.
const RUN: usize = 4;
const FRAMES: usize = 8;

/// How presses are chosen.
#[derive(Clone, Copy, PartialEq, Debug)]
enum Way {
    Guided,
    Alone,
    AmongOthers,
}

fn main() -> Result<(), Error> {
    let mut arguments = std::env::args().skip(1);
    let presets = arguments.next();
    let presets = presets.unwrap_or_else(|| "mat-16x16-cd4067".to_owned());
    let seeds = arguments.next().unwrap_or_else(|| "1,2,3".to_owned());
    println!("sensor,seed,way,presses,held_out_g,error_g,seconds");
    for name in presets.split(',') {
        for seed in seeds.split(',').filter_map(|seed| seed.parse().ok()) {
            for way in [Way::Guided, Way::Alone, Way::AmongOthers] {
                run(name, seed, way)?;
            }
        }
    }
    Ok(())
}

fn run(name: &str, seed: u64, way: Way) -> Result<(), Error> {
    let nominal = preset(name)?;
    let mut uneven = Imperfections::uneven();
    // Broken lines are found by watching, not by pressing.
    (uneven.dead_rows, uneven.flickering_columns) = (0, 0);
    uneven.faults = ReadingFaults::default();
    let truth = VirtualSensor::imperfect(&nominal, &uneven, seed)?;
    let parts = nominal.edited(|spec| {
        spec.material = None;
        spec.uncertainty = None;
    })?;
    let plan = PressPlan::new(&parts, &LOADS_G)?;
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut data = CalibrationData::default();
    let mut made: Vec<MadePress> = Vec::new();
    let mut fitted: Option<Sensor> = None;
    let mut others: Vec<(usize, usize, f64)> = Vec::new();
    for count in 1..=COUNTS[COUNTS.len() - 1] {
        let press = match way {
            Way::Guided => {
                let places: Vec<_> = others.iter().map(|other| (other.0, other.1)).collect();
                plan.next(&made, &[], fitted.as_ref(), &places).press
            }
            _ => by_chance(&truth, &mut random, way),
        };
        // Guided, they lie for some presses; else they are laid anew for each.
        let run = made
            .iter()
            .rev()
            .take_while(|press| press.is_among_others)
            .count();
        if others.is_empty() || way != Way::Guided || run % RUN == RUN - 1 {
            others = other_things(&truth, &mut random);
        }
        add(&truth, press, &others, &mut data);
        made.push(press);
        let is_told = COUNTS.contains(&count);
        let is_refitted = way == Way::Guided && count >= 8 && count % REFIT == 0;
        if !is_told && !is_refitted {
            continue;
        }
        let begun = Instant::now();
        let options = CalibrationOptions::default();
        let found = calibrate(&parts, &data, &options, &mut |_, _| {});
        if is_told {
            let seconds = begun.elapsed().as_secs_f64();
            let (held_out, error) = match &found {
                Ok(found) => (
                    found.report.held_out_mean_absolute_g.unwrap_or(f64::NAN),
                    error_g(&found.sensor, &truth)?,
                ),
                Err(why) => {
                    eprintln!("{name},{seed},{way:?},{count}: {why}");
                    (f64::NAN, f64::NAN)
                }
            };
            println!("{name},{seed},{way:?},{count},{held_out:.3},{error:.3},{seconds:.1}");
        }
        fitted = found.ok().map(|found| found.sensor).or(fitted);
    }
    Ok(())
}

fn by_chance(truth: &VirtualSensor, random: &mut ChaCha8Rng, way: Way) -> MadePress {
    let sensor = truth.sensor();
    let line = |random: &mut ChaCha8Rng, lines: usize, dead: &[usize]| loop {
        let line = random.random_range(0..lines);
        if !dead.contains(&line) {
            return line;
        }
    };
    MadePress {
        row: line(random, sensor.rows(), &sensor.screen().dead_rows),
        column: line(random, sensor.columns(), &sensor.screen().dead_columns),
        load_g: LOADS_G[random.random_range(0..LOADS_G.len())],
        is_among_others: way == Way::AmongOthers,
    }
}

/// Six taxels with up to the heaviest load.
fn other_things(truth: &VirtualSensor, random: &mut ChaCha8Rng) -> Vec<(usize, usize, f64)> {
    let (rows, columns) = (truth.sensor().rows(), truth.sensor().columns());
    let thing = |random: &mut ChaCha8Rng| {
        let load_g = LOADS_G[3] * random.random_range(0.4..1.0);
        (
            random.random_range(0..rows),
            random.random_range(0..columns),
            load_g,
        )
    };
    (0..6).map(|_| thing(random)).collect()
}

/// Makes the press.
fn add(
    truth: &VirtualSensor,
    press: MadePress,
    others: &[(usize, usize, f64)],
    data: &mut CalibrationData,
) {
    let sensor = truth.sensor();
    let (rows, columns) = (sensor.rows(), sensor.columns());
    let mut loads = Frame::zeros(rows, columns);
    if press.is_among_others {
        for (row, column, load_g) in others {
            loads.values_mut()[row * columns + column] = *load_g;
        }
    }
    loads.values_mut()[press.row * columns + press.column] = press.load_g;
    let frame = data.frames.len();
    data.frames.push(truth.read(&loads, frame as u64).counts);
    data.presses.push(PressLabel {
        frame,
        row: press.row,
        column: press.column,
        load_g: press.load_g,
    });
}

/// Mean absolute error of loads of smooth contacts, over loaded taxels on sound lines.
fn error_g(fitted: &Sensor, truth: &VirtualSensor) -> Result<f64, Error> {
    let screen = truth.sensor().screen();
    let columns = fitted.columns();
    let mut pipeline = Pipeline::new(fitted, default_method(fitted)?)?;
    let (mut sum, mut taxels) = (0.0, 0.0);
    for (counts, loads) in validation_frames(truth, FRAMES) {
        let Some(found) = pipeline.process(&counts).loads else {
            continue;
        };
        for (taxel, (found, load)) in found.values().iter().zip(loads.values()).enumerate() {
            let is_dead = screen.dead_rows.contains(&(taxel / columns))
                || screen.dead_columns.contains(&(taxel % columns));
            if *load > 0.0 && !is_dead {
                sum += (grams_from_newtons(*found) - load).abs();
                taxels += 1.0;
            }
        }
    }
    Ok(sum / taxels)
}
