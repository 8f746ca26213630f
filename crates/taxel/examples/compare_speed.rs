//! One frame of the e-Cone's circuit, forwards and backwards, beside a plain dense nodal solve per taxel and
//! ngspice (where it is installed): `cargo run --release -p taxel --example compare_speed` prints a table.

#[path = "../tests/common/mod.rs"]
mod common;

use std::error::Error;
use std::hint::black_box;
use std::process::Command;
use std::time::Instant;

use common::{nodal_volts, pressed, relative_error, sensor, stream};
use taxel::circuit::netlist::{Selection, netlist};
use taxel::circuit::{LinearCircuit, OperatingPoint};
use taxel::sensor::{Sensor, Topology};
use taxel::solve::{Exact, Method};
use taxel::stats::{Line, median};
use taxel::{Frame, Siemens};

const SIZES: [(usize, usize); 6] = [
    (16, 16),
    (32, 32),
    (64, 128),
    (128, 64),
    (128, 128),
    (256, 256),
];
/// Above this many taxels ngspice takes too long for a comparison.
const NGSPICE_TAXELS: usize = 8192;

/// Seconds: the least and the median of repeated runs.
#[derive(Clone, Copy)]
struct Timing {
    least: f64,
    median: f64,
}

fn time(runs: usize, mut work: impl FnMut()) -> Timing {
    let mut seconds: Vec<f64> = (0..runs)
        .map(|_| {
            let start = Instant::now();
            work();
            start.elapsed().as_secs_f64()
        })
        .collect();
    seconds.sort_by(f64::total_cmp);
    Timing {
        least: seconds[0],
        median: median(seconds.iter().copied()).unwrap_or(f64::NAN),
    }
}

fn micros(timing: Timing) -> String {
    format!("{:.0} ({:.0})", 1e6 * timing.least, 1e6 * timing.median)
}

/// What one size of array takes.
struct Row {
    size: (usize, usize),
    forward: Timing,
    cold: Timing,
    warm: Timing,
    iterations: (u32, u32),
    error: f64,
    dense: f64,
    ngspice: Option<f64>,
}

fn measure(size: (usize, usize)) -> Result<Row, Box<dyn Error>> {
    let sensor = sensor(Topology::TiaGroundedColumns, size.0, size.1, 10.0, 0.0);
    let circuit = LinearCircuit::from_sensor(&sensor)?;
    let siemens = pressed(size.0, size.1, 0.3, 1);
    let taxels = size.0 * size.1;
    let runs = (2_000_000 / taxels).clamp(20, 500);

    let mut point = circuit.point();
    let mut volts = vec![0.0; taxels];
    let forward = time(runs, || {
        point.set(black_box(siemens.values())).expect("passive");
        point.predict_into(&mut volts);
    });

    let method = Exact::new(&circuit)
        .ok_or("the e-Cone's circuit")?
        .with_tolerance(1e-6);
    let frames = stream(&circuit, &siemens, 32);
    let (mut out, mut solver) = (Frame::zeros(size.0, size.1), method.solver());
    let mut iterations = (0, 0);
    let cold = time(runs, || {
        solver.forget();
        iterations.0 = solver.solve_into(&frames[0], &mut out).iterations;
    });
    let error = relative_error(&out, &siemens);
    let mut order = (1..32).chain((0..31).rev()).cycle();
    let warm = time(runs, || {
        let at = order.next().expect("endless");
        iterations.1 = solver.solve_into(&frames[at], &mut out).iterations;
    });

    let mut taxel = 0;
    let per_taxel = time(5, || {
        taxel += 1;
        black_box(nodal_volts(
            &circuit,
            &siemens,
            taxel % size.0,
            taxel % size.1,
        ));
    });
    let ngspice = if taxels <= NGSPICE_TAXELS {
        ngspice(&sensor, &siemens)?
    } else {
        None
    };
    Ok(Row {
        size,
        forward,
        cold,
        warm,
        iterations,
        error,
        dense: per_taxel.least * taxels as f64,
        ngspice,
    })
}

/// Seconds for a frame: the start-up of one taxel, and for the rest what 19 more take. None without ngspice.
fn ngspice(sensor: &Sensor, siemens: &Frame<Siemens>) -> Result<Option<f64>, Box<dyn Error>> {
    if Command::new("ngspice").arg("--version").output().is_err() {
        return Ok(None);
    }
    let taxels: Vec<_> = (0..20)
        .map(|i| (i * 7 % sensor.rows(), i * 11 % sensor.columns()))
        .collect();
    let path = std::env::temp_dir().join(format!("taxel-{}.cir", std::process::id()));
    let run = |count: usize| -> Result<f64, Box<dyn Error>> {
        let selection = Selection::Taxels(taxels[..count].to_vec());
        std::fs::write(&path, netlist(sensor, siemens, selection)?)?;
        let start = Instant::now();
        Command::new("ngspice").arg("-b").arg(&path).output()?;
        Ok(start.elapsed().as_secs_f64())
    };
    run(1)?;
    let (one, twenty) = (run(1)?, run(20)?);
    std::fs::remove_file(&path)?;
    let all = sensor.rows() * sensor.columns();
    Ok(Some(one + (twenty - one) / 19.0 * (all - 1) as f64))
}

/// The exponent of time over taxels, by least squares of the logarithms.
fn exponent(rows: &[Row], seconds: impl Fn(&Row) -> f64) -> f64 {
    let points: Vec<(f64, f64)> = rows
        .iter()
        .map(|row| (((row.size.0 * row.size.1) as f64).ln(), seconds(row).ln()))
        .collect();
    Line::fit(&points).map_or(f64::NAN, |line| line.slope)
}

fn main() -> Result<(), Box<dyn Error>> {
    println!(
        "| rows × columns | forward µs | inverse cold µs | inverse warm µs | rounds cold, warm | largest error | dense nodal s | ngspice s | dense ÷ forward | ngspice ÷ forward | dense ÷ inverse cold |"
    );
    println!("|{}", "---|".repeat(11));
    let mut rows = Vec::new();
    for size in SIZES {
        let row = measure(size)?;
        let or_dash = |value: Option<f64>, digits| {
            value.map_or("–".to_owned(), |value| format!("{value:.digits$}"))
        };
        println!(
            "| {} × {} | {} | {} | {} | {}, {} | {:.0e} | {:.3} | {} | {:.0} | {} | {:.0} |",
            row.size.0,
            row.size.1,
            micros(row.forward),
            micros(row.cold),
            micros(row.warm),
            row.iterations.0,
            row.iterations.1,
            row.error,
            row.dense,
            or_dash(row.ngspice, 2),
            row.dense / row.forward.least,
            or_dash(row.ngspice.map(|s| s / row.forward.least), 0),
            row.dense / row.cold.least,
        );
        rows.push(row);
    }
    println!();
    println!(
        "Growth with the number of taxels n: forward n^{:.2}, inverse cold n^{:.2}, warm n^{:.2}, dense nodal n^{:.2}.",
        exponent(&rows, |row| row.forward.least),
        exponent(&rows, |row| row.cold.least),
        exponent(&rows, |row| row.warm.least),
        exponent(&rows, |row| row.dense),
    );
    Ok(())
}
