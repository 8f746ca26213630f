//! One frame: scan, derivative, inverse. `cargo bench -p taxel-bench`.

#[path = "../../crates/taxel/tests/common/mod.rs"]
mod common;

use std::hint::black_box;

use common::{inversion, pressed, sensor, stream};
use criterion::{BatchSize, BenchmarkId, Criterion, criterion_group, criterion_main};
use taxel::circuit::{Circuit, LinearCircuit, OperatingPoint};
use taxel::material::{DynamicLaw, HysteresisState};
use taxel::pipeline::Pipeline;
use taxel::sensor::{Topology, preset};
use taxel::simulate::{Pattern, VirtualSensor};
use taxel::solve::{Exact, Method, default_method};
use taxel::{Counts, Frame};

const SIZES: [(usize, usize); 6] = [
    (16, 16),
    (32, 32),
    (64, 128),
    (128, 64),
    (128, 128),
    (256, 256),
];

fn circuit((rows, columns): (usize, usize)) -> LinearCircuit {
    let sensor = sensor(Topology::TiaGroundedColumns, rows, columns, 10.0, 0.0);
    LinearCircuit::from_sensor(&sensor).expect("switches are known")
}

fn forward(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("forward");
    for size in SIZES {
        let name = format!("{}x{}", size.0, size.1);
        let siemens = pressed(size.0, size.1, 0.3, 1);
        let mut point = circuit(size).point();
        let mut volts = vec![0.0; siemens.values().len()];
        group.bench_function(BenchmarkId::new("scan", &name), |bencher| {
            bencher.iter(|| {
                point.set(black_box(siemens.values())).expect("passive");
                point.predict_into(&mut volts);
            });
        });
        let direction = siemens.values().to_vec();
        group.bench_function(BenchmarkId::new("derivative", &name), |bencher| {
            bencher.iter(|| point.jvp_into(black_box(&direction), &mut volts));
        });
        group.bench_function(BenchmarkId::new("adjoint", &name), |bencher| {
            bencher.iter(|| point.vjp_into(black_box(&direction), &mut volts));
        });
    }
    group.finish();
}

fn exact(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("exact");
    for size in SIZES {
        let name = format!("{}x{}", size.0, size.1);
        let circuit = circuit(size);
        let method = Exact::new(&circuit)
            .expect("the e-Cone's")
            .with_tolerance(1e-6);
        let frames = stream(&circuit, &pressed(size.0, size.1, 0.3, 1), 16);
        let mut out = Frame::zeros(size.0, size.1);
        let mut solver = method.solver();
        group.bench_function(BenchmarkId::new("cold", &name), |bencher| {
            bencher.iter(|| {
                solver.forget();
                solver.solve_into(black_box(&frames[0]), &mut out)
            });
        });
        let mut order = (0..16).chain((1..15).rev()).cycle();
        group.bench_function(BenchmarkId::new("warm", &name), |bencher| {
            bencher.iter_batched(
                || order.next().expect("endless"),
                |at| solver.solve_into(black_box(&frames[at]), &mut out),
                BatchSize::PerIteration,
            );
        });
    }
    group.finish();
}

fn newton(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("newton");
    group.sample_size(10);
    let mut cases: Vec<_> = Topology::ALL
        .into_iter()
        .flat_map(|topology| [(topology, (16, 16)), (topology, (32, 32))])
        .collect();
    cases.push((Topology::DividerFloating, (64, 128)));
    for (topology, size) in cases {
        let inversion = inversion("newton", topology, size, 70.0, 0.0);
        let volts = inversion
            .circuit
            .predict(&pressed(size.0, size.1, 0.3, 1))
            .expect("passive");
        let mut out = Frame::zeros(size.0, size.1);
        let mut solver = inversion.method.solver();
        let name = format!("{} {}x{}", topology.name(), size.0, size.1);
        group.bench_function(BenchmarkId::new("cold", name), |bencher| {
            bencher.iter(|| {
                solver.forget();
                solver.solve_into(black_box(&volts), &mut out)
            });
        });
    }
    group.finish();
}

/// Where the fast iteration gives up and the square root takes over.
fn strong_cross_talk(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("70 Ohm 64x128");
    group.sample_size(20);
    for name in ["exact", "newton"] {
        let inversion = inversion(name, Topology::TiaGroundedColumns, (64, 128), 70.0, 0.0);
        let volts = inversion
            .circuit
            .predict(&pressed(64, 128, 0.3, 1))
            .expect("passive");
        let mut out = Frame::zeros(64, 128);
        let mut solver = inversion.method.solver();
        group.bench_function(name, |bencher| {
            bencher.iter(|| {
                solver.forget();
                solver.solve_into(black_box(&volts), &mut out)
            });
        });
    }
    group.finish();
}

/// What creep and hysteresis add to a frame: three lags and three plays.
fn dynamic(criterion: &mut Criterion) {
    let law = DynamicLaw {
        lags: vec![(0.08, 0.8), (0.07, 8.0), (0.07, 80.0)],
        plays: vec![(0.07, 5.0), (0.07, 15.0), (0.07, 40.0)],
        period_secs: 0.01,
    };
    let mut memory = HysteresisState::new(&law, 64 * 128);
    // Acting loads that rise and fall, so that plays move both ways.
    let acting = |frame: usize| -> Vec<f64> {
        let phase = |taxel: usize| 0.05 * frame as f64 + 0.01 * taxel as f64;
        (0..64 * 128)
            .map(|taxel| 100.0 + 100.0 * phase(taxel).sin())
            .collect()
    };
    let frames: Vec<_> = (0..126).map(acting).collect();
    let mut grams = frames[0].clone();
    let mut order = (0..126).cycle();
    criterion.bench_function("dynamic/64x128", |bencher| {
        bencher.iter(|| {
            grams.copy_from_slice(&frames[order.next().expect("endless")]);
            memory.loads_from_acting(None, black_box(&mut grams), |_| false);
        });
    });
}

/// The whole way from counts to newtons: a hand, and a cable that was pulled while it gripped, every reading of which is
/// stuck at one end or the other. Screening it must not cost what a frame does many times over.
fn pulled_cable(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("pipeline");
    for name in ["econe", "mat-32x32-adg732", "mat-16x16-cd4067"] {
        let sensor = preset(name).expect("shipped");
        let real = VirtualSensor::new(&sensor, 1).expect("a whole sensor");
        let hand: Vec<Frame<Counts>> = (60..76)
            .map(|t| {
                let loads = Pattern::hand().loads(sensor.array(), 1, t);
                real.read(&loads, t).counts
            })
            .collect();
        let end = |count: fn(usize, f64) -> f64| {
            let mut frame = Frame::<Counts>::zeros(sensor.rows(), sensor.columns());
            for (taxel, value) in frame.values_mut().iter_mut().enumerate() {
                *value = count(taxel, sensor.max_count());
            }
            vec![frame; 16]
        };
        let cases = [
            ("a hand", hand),
            ("all at zero", end(|_, _| 0.0)),
            ("all at the ceiling", end(|_, most| most)),
            (
                "one end or the other",
                end(|taxel, most| most * (taxel % 2) as f64),
            ),
        ];
        for (what, frames) in cases {
            let method = default_method(&sensor).expect("switches are known");
            let mut pipeline = Pipeline::new(&sensor, method).expect("a whole sensor");
            let mut order = (0..16).cycle();
            group.bench_function(BenchmarkId::new(name, what), |bencher| {
                bencher.iter(|| {
                    let frame = &frames[order.next().expect("endless")];
                    black_box(
                        pipeline
                            .process(black_box(frame))
                            .siemens
                            .map(Frame::values),
                    );
                });
            });
        }
    }
    group.finish();
}

criterion_group!(
    benches,
    dynamic,
    forward,
    exact,
    newton,
    strong_cross_talk,
    pulled_cable
);
criterion_main!(benches);
