//! Scan and inverse of lines that resist: time, rounds, and how many frames with noise find an answer.
//!
//!     cargo run --release -p taxel --example lines_speed [COUNTS OF NOISE]
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::time::Instant;
use taxel::circuit::{Circuit, Converter, LinearCircuit, OperatingPoint};
use taxel::sensor::{Array, ConverterSpec, PerLine, ReadoutSpec, SensorSpec, Topology};
use taxel::simulate::{Pattern, PatternKind};
use taxel::solve::{Method, Newton, method};
use taxel::{Frame, Sensor, Siemens};

fn sensor(topology: Topology, rows: usize, columns: usize, ohms: [f64; 2]) -> Sensor {
    let amplifies = topology.is_tia();
    let mut readout = ReadoutSpec::new(topology, if amplifies { 0.4 } else { 3.3 });
    if amplifies {
        readout.r_feedback_ohms = Some(2000.0);
        readout.open_loop_gain = Some(1e5);
    } else {
        readout.r_pull_down_ohms = Some(1000.0);
    }
    let switch = if amplifies { 10.0 } else { 70.0 };
    readout.r_mux_column_ohms = Some(PerLine::One(switch));
    readout.r_mux_row_ohms = Some(PerLine::One(switch));
    readout.r_line_row_ohms = Some(PerLine::One(ohms[0]));
    readout.r_line_column_ohms = Some(PerLine::One(ohms[1]));
    let mut converter = ConverterSpec::new(16, if amplifies { 2.2 } else { 3.3 });
    converter.inverted = amplifies;
    converter.noise_counts = Some(3.0);
    Sensor::try_from(SensorSpec::new(
        Array::new(rows, columns),
        readout,
        converter,
    ))
    .unwrap()
}

/// Conductances of 1 µS and, where something presses, of up to 2 mS.
fn frames(sensor: &Sensor, count: u64) -> Vec<Frame<Siemens>> {
    let pattern = Pattern::new(PatternKind::Blobs { least: 3, most: 8 });
    let of = |k: u64| {
        let loads = pattern.loads(sensor.array(), 11, 40 + k);
        let most = loads.values().iter().copied().fold(1.0, f64::max);
        loads.map(|_, load| 1e-6 + 1.5e-3 * load / most)
    };
    (0..count).map(of).collect()
}

fn least<T>(times: usize, mut run: impl FnMut() -> T) -> f64 {
    let one = |_| {
        let start = Instant::now();
        std::hint::black_box(run());
        start.elapsed().as_secs_f64() * 1e3
    };
    (0..times).map(one).fold(f64::INFINITY, f64::min)
}

fn main() {
    println!("scan and derivative, ms");
    for (rows, columns) in [(16, 16), (32, 32), (64, 64), (64, 128), (128, 128)] {
        for ohms in [[2.0, 2.0], [2.0, 0.0], [0.0, 2.0]] {
            let sensor = sensor(Topology::TiaGroundedColumns, rows, columns, ohms);
            let circuit = LinearCircuit::from_sensor(&sensor).unwrap();
            let g = &frames(&sensor, 1)[0];
            let mut point = circuit.point();
            let mut volts = vec![0.0; g.values().len()];
            let scan = least(10, || {
                point.set(g.values()).unwrap();
                point.predict_into(&mut volts);
            });
            point.jvp_into(g.values(), &mut volts);
            let jvp = least(5, || point.jvp_into(g.values(), &mut volts));
            let both = least(5, || {
                point.set(g.values()).unwrap();
                point.jvp_into(g.values(), &mut volts);
            });
            println!(
                "{rows} x {columns}, {ohms:?} Ohm: scan {scan:.3}, potentials {:.3}, J v {jvp:.3}",
                both - jvp - scan
            );
        }
    }
    println!("inverse: rounds; ms cold and in a stream; error of the largest");
    for (rows, columns, ohms) in [
        (16, 16, 2.0),
        (32, 32, 2.0),
        (32, 32, 10.0),
        (32, 32, 50.0),
        (64, 128, 2.0),
        (64, 128, 10.0),
    ] {
        inverse(rows, columns, ohms);
    }
    println!("with 3 counts of noise: frames with an answer");
    for topology in Topology::ALL
        .into_iter()
        .filter(|t| *t != Topology::LineEnds)
    {
        for (size, count) in [(16, 20), (32, 4)] {
            for ohms in [2.0, 10.0, 50.0] {
                with_noise(topology, size, ohms, count);
            }
        }
    }
}

fn inverse(rows: usize, columns: usize, ohms: f64) {
    let sensor = sensor(Topology::TiaGroundedColumns, rows, columns, [ohms, ohms]);
    let circuit = LinearCircuit::from_sensor(&sensor).unwrap();
    for exact in [true, false] {
        let frames = frames(&sensor, 6);
        let newton: Box<dyn Method> = if exact {
            Box::new(Newton::new(circuit.clone()))
        } else {
            method("newton", &sensor).unwrap()
        };
        let mut solver = newton.solver();
        let mut out = Frame::zeros(rows, columns);
        let (mut cold, mut warm, mut worst): (Vec<f64>, Vec<f64>, f64) =
            (Vec::new(), Vec::new(), 0.0);
        let mut rounds = Vec::new();
        for g in &frames {
            let volts = circuit.predict(g).unwrap();
            solver.forget();
            let start = Instant::now();
            let outcome = solver.solve_into(&volts, &mut out);
            cold.push(start.elapsed().as_secs_f64() * 1e3);
            rounds.push(if outcome.stop.is_good() {
                outcome.iterations as i32
            } else {
                -1
            });
            let most = g.values().iter().copied().fold(0.0, f64::max);
            for (a, b) in out.values().iter().zip(g.values()) {
                worst = worst.max((a - b).abs() / most);
            }
            // A stream whose loads grow by 2 % a frame.
            let mut grown = g.clone();
            for _ in 0..4 {
                grown = grown.map(|_, g| g * 1.02);
                let volts = circuit.predict(&grown).unwrap();
                let start = Instant::now();
                let _ = solver.solve_into(&volts, &mut out);
                warm.push(start.elapsed().as_secs_f64() * 1e3);
            }
        }
        let middle = |list: &mut Vec<f64>| {
            list.sort_by(f64::total_cmp);
            list[list.len() / 2]
        };
        println!(
            "{rows} x {columns}, {ohms} Ohm, {}: rounds {rounds:?}, cold {:.1}, stream {:.1}, error {worst:.1e}",
            if exact { "to 1e-9" } else { "to 0.1 noise" },
            middle(&mut cold),
            middle(&mut warm)
        );
    }
}

fn with_noise(topology: Topology, size: usize, ohms: f64, count: u64) {
    let sensor = sensor(topology, size, size, [ohms, ohms]);
    let circuit = LinearCircuit::from_sensor(&sensor).unwrap();
    let newton = method("newton", &sensor).unwrap();
    let converter = Converter::from_sensor(&sensor);
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let (mut good, mut rounds) = (0, 0);
    for g in frames(&sensor, count) {
        let volts = circuit.predict(&g).unwrap();
        let sigma = 3.0 * converter.lsb_volts();
        let noisy = volts.map(|_, v| v + sigma * taxel_noise(&mut random));
        let outcome = newton.solve(&noisy).outcome;
        good += u32::from(outcome.stop.is_good());
        rounds = rounds.max(outcome.iterations);
    }
    println!(
        "{} {size} x {size}, {ohms} Ohm: {good} of {count}, at most {rounds} rounds",
        topology.name()
    );
}

fn taxel_noise(random: &mut ChaCha8Rng) -> f64 {
    use rand::RngExt;
    let (a, b): (f64, f64) = (random.random::<f64>().max(1e-300), random.random());
    (-2.0 * a.ln()).sqrt() * (std::f64::consts::TAU * b).cos()
}
