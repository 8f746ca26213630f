//! The scan and its derivative, for every topology and shape: Kirchhoff, finite differences, adjoint, Rayleigh.

mod common;

use common::tables::any_table;
use common::{farthest, largest, nodal_volts, pressed, sensor, under_sheet};
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use taxel::circuit::{Circuit, LinearCircuit, OperatingPoint};
use taxel::sensor::{LineEnd, PerLine, Sensor, Topology};
use taxel::{Frame, Siemens};

fn any_sensor() -> impl Strategy<Value = (Sensor, u64)> {
    (
        prop::sample::select(Topology::ALL.to_vec()),
        1usize..12,
        1usize..12,
        prop::sample::select(vec![0.5, 5.0, 70.0, 470.0]),
        prop::sample::select(vec![0.0, 1000.0]),
        any::<bool>(),
        any::<u64>(),
    )
        .prop_map(
            |(topology, rows, columns, r_mux, r_source, mismatch, seed)| {
                let mut sensor = sensor(topology, rows, columns, r_mux, r_source);
                if mismatch {
                    let mut random = ChaCha8Rng::seed_from_u64(seed);
                    let mut lines = |n: usize| {
                        let list = (0..n)
                            .map(|_| r_mux * random.random_range(0.5..1.5))
                            .collect();
                        Some(PerLine::Each(list))
                    };
                    sensor = sensor
                        .edited(|spec| {
                            spec.readout.r_mux_column_ohms = lines(columns);
                            spec.readout.r_mux_row_ohms = lines(rows);
                        })
                        .unwrap();
                }
                (sensor, seed)
            },
        )
}

/// The same, and tables of line ends, most of them under a continuous sheet.
fn any_sheet() -> impl Strategy<Value = (Sensor, u64)> {
    let sheet = prop::sample::select(vec![
        None,
        Some((10e3, 4.0)),
        Some((2e3, 1.0)),
        Some((500.0, 0.1)),
        Some((20e3, 0.0)),
    ]);
    let lines = prop::sample::select(vec![
        None,
        Some([2.0, 10.0]),
        Some([0.0, 50.0]),
        Some([5.0, 0.0]),
    ]);
    (any_sensor(), any::<bool>(), sheet, lines).prop_map(|((sensor, seed), table, sheet, lines)| {
        let sensor = match lines {
            Some(ohms) => along_lines(&sensor, ohms, seed),
            None if table => any_table(sensor.rows(), sensor.columns(), seed),
            None => sensor,
        };
        (under_sheet(&sensor, sheet), seed)
    })
}

/// The same sensor with lines that resist about so much a pitch, rows and columns: each its own, some nothing (under a sheet 1e-5 Ω
/// at least, as the sweep takes it), ending anywhere.
fn along_lines(sensor: &Sensor, ohms: [f64; 2], seed: u64) -> Sensor {
    let mut random = ChaCha8Rng::seed_from_u64(seed ^ 0x11ae5);
    let mut each = |lines: usize, ohms: f64| {
        let one =
            |_| ohms * f64::from(random.random_range(0..4u32)) * random.random_range(0.1..1.0);
        Some(PerLine::Each((0..lines).map(one).collect()))
    };
    let (rows, columns) = (
        each(sensor.rows(), ohms[0]),
        each(sensor.columns(), ohms[1]),
    );
    let end = |at: u64| {
        if seed >> at & 1 == 0 {
            LineEnd::First
        } else {
            LineEnd::Last
        }
    };
    sensor
        .edited(|spec| {
            let readout = &mut spec.readout;
            (readout.r_line_row_ohms, readout.r_line_column_ohms) = (rows, columns);
            (readout.row_end, readout.column_end) = (end(3), end(4));
        })
        .unwrap()
}

fn random_direction(len: usize, seed: u64) -> Vec<f64> {
    let mut random = ChaCha8Rng::seed_from_u64(seed ^ 0x5eed);
    (0..len).map(|_| random.random_range(-1.0..1.0)).collect()
}

fn predict(circuit: &LinearCircuit, siemens: &Frame<Siemens>) -> Vec<f64> {
    circuit.predict(siemens).unwrap().values().to_vec()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn the_scan_obeys_kirchhoff((sensor, seed) in any_sheet()) {
        let circuit = LinearCircuit::from_sensor(&sensor).unwrap();
        let siemens = pressed(sensor.rows(), sensor.columns(), 0.6, seed);
        let volts = predict(&circuit, &siemens);
        for row in 0..sensor.rows() {
            for column in 0..sensor.columns() {
                let (expected, _) = nodal_volts(&circuit, &siemens, row, column);
                let found = volts[row * sensor.columns() + column];
                // Of a sheet over some lines that resist and some that do not, those are given 1e-5 Ω.
                let off = if circuit.lines().is_some() && circuit.sheet().is_some() { 1e-5 } else { 1e-8 };
                prop_assert!((found - expected).abs() <= off * expected.abs().max(1e-3),
                    "taxel ({row}, {column}): {found} against {expected}");
            }
        }
    }

    #[test]
    fn the_derivative_error_falls_at_second_order((sensor, seed) in any_sheet()) {
        let circuit = LinearCircuit::from_sensor(&sensor).unwrap();
        let siemens = pressed(sensor.rows(), sensor.columns(), 0.6, seed);
        let taxels = siemens.values().len();
        let direction: Vec<f64> = random_direction(taxels, seed).iter().zip(siemens.values())
            .map(|(x, g)| x * g).collect();
        let mut point = circuit.point();
        point.set(siemens.values()).unwrap();
        let mut slope = vec![0.0; taxels];
        point.jvp_into(&direction, &mut slope);
        let base = predict(&circuit, &siemens);
        let error = |step: f64| {
            let moved = siemens.map(|i, g| g + step * direction[i]);
            let found: Vec<f64> = predict(&circuit, &moved).iter().zip(&base).zip(&slope)
                .map(|((a, b), s)| a - b - step * s).collect();
            largest(&found)
        };
        let (coarse, fine) = (error(0.1), error(0.05));
        // Halving the step quarters the error (third-order terms aside), unless it is rounding already.
        prop_assert!(fine < 0.35 * coarse || coarse < 1e-9 * largest(&base),
            "error {coarse:e} fell only to {fine:e}");
    }

    #[test]
    fn the_adjoint_is_the_transpose((sensor, seed) in any_sheet()) {
        let circuit = LinearCircuit::from_sensor(&sensor).unwrap();
        let siemens = pressed(sensor.rows(), sensor.columns(), 0.6, seed);
        let taxels = siemens.values().len();
        let (v, w) = (random_direction(taxels, seed), random_direction(taxels, !seed));
        let mut point = circuit.point();
        point.set(siemens.values()).unwrap();
        let (mut forward, mut adjoint) = (vec![0.0; taxels], vec![0.0; taxels]);
        point.jvp_into(&v, &mut forward);
        point.vjp_into(&w, &mut adjoint);
        let left: f64 = forward.iter().zip(&w).map(|(a, b)| a * b).sum();
        let right: f64 = adjoint.iter().zip(&v).map(|(a, b)| a * b).sum();
        let scale: f64 = forward.iter().zip(&w).map(|(a, b)| (a * b).abs()).sum();
        prop_assert!((left - right).abs() <= 1e-9 * scale, "{left} against {right}");
    }

    /// Rayleigh: between the driven line and the sensed one, more conductance never lowers the current
    /// when nothing but these two lines is held.
    #[test]
    fn more_conductance_never_lowers_a_floating_reading((sensor, seed) in any_sensor()) {
        let floating = common::sensor(Topology::DividerFloating, 2, 2, 70.0, 0.0);
        let sensor = sensor
            .edited(|spec| spec.readout = floating.spec().readout.clone())
            .unwrap();
        let circuit = LinearCircuit::from_sensor(&sensor).unwrap();
        let siemens = pressed(sensor.rows(), sensor.columns(), 0.6, seed);
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let more = siemens.map(|_, g| g * (1.0 + random.random::<f64>()));
        for (less, more) in predict(&circuit, &siemens).iter().zip(predict(&circuit, &more)) {
            prop_assert!(more >= less - 1e-12 * less.abs());
        }
    }

    /// The same for the taxel's own reading in every topology.
    #[test]
    fn pressing_a_taxel_never_lowers_its_own_reading((sensor, seed) in any_sensor()) {
        let circuit = LinearCircuit::from_sensor(&sensor).unwrap();
        let siemens = pressed(sensor.rows(), sensor.columns(), 0.6, seed);
        let taxel = (seed as usize) % siemens.values().len();
        let mut more = siemens.clone();
        more.values_mut()[taxel] *= 2.0;
        let (less, more) = (predict(&circuit, &siemens)[taxel], predict(&circuit, &more)[taxel]);
        prop_assert!(more.abs() >= less.abs() * (1.0 - 1e-12), "{less} fell to {more}");
    }
}

#[test]
fn lines_without_any_conductance_read_nothing() {
    for topology in Topology::ALL {
        let sensor = sensor(topology, 5, 7, 70.0, 0.0);
        let circuit = LinearCircuit::from_sensor(&sensor).unwrap();
        let mut siemens = pressed(5, 7, 0.7, 3);
        for c in 0..7 {
            siemens.values_mut()[2 * 7 + c] = 0.0;
        }
        for r in 0..5 {
            siemens.values_mut()[r * 7 + 4] = 0.0;
        }
        let volts = predict(&circuit, &siemens);
        for (i, &v) in volts.iter().enumerate() {
            let (row, column) = (i / 7, i % 7);
            let (expected, _) = nodal_volts(&circuit, &siemens, row, column);
            assert!(
                (v - expected).abs() < 1e-6,
                "{topology:?} ({row}, {column}): {v} against {expected}"
            );
        }
    }
}

#[test]
fn the_largest_array_solves_in_both_orientations() {
    for (rows, columns) in [(256, 256), (256, 3), (3, 256), (1, 256), (256, 1)] {
        for topology in Topology::ALL {
            let sensor = sensor(topology, rows, columns, 10.0, 0.0);
            let circuit = LinearCircuit::from_sensor(&sensor).unwrap();
            let siemens = pressed(rows, columns, 0.3, 5);
            let volts = predict(&circuit, &siemens);
            let (row, column) = (rows / 2, columns / 3);
            let (expected, _) = nodal_volts(&circuit, &siemens, row, column);
            let found = volts[row * columns + column];
            assert!(
                (found - expected).abs() < 1e-8 * expected.abs().max(1e-6),
                "{topology:?}"
            );
        }
    }
}

#[test]
fn an_active_network_is_refused() {
    let sensor = sensor(Topology::TiaGroundedColumns, 4, 4, 10.0, 0.0);
    let circuit = LinearCircuit::from_sensor(&sensor).unwrap();
    assert!(circuit.predict(&Frame::filled(4, 4, -1.0)).is_err());
}

#[test]
fn node_currents_sum_to_nil() {
    let sensor = sensor(Topology::TiaGroundedColumns, 6, 9, 10.0, 0.0);
    let circuit = LinearCircuit::from_sensor(&sensor).unwrap();
    let siemens = pressed(6, 9, 0.5, 8);
    let (_, nodes) = nodal_volts(&circuit, &siemens, 2, 3);
    for r in 0..6 {
        let end = if r == 2 {
            circuit.ends().row_selected[r]
        } else {
            circuit.ends().row_unselected[r]
        };
        let current: f64 = (0..9)
            .map(|c| siemens.at(r, c) * (nodes[6 + c] - nodes[r]))
            .sum();
        assert!((current - end * nodes[r]).abs() < 1e-15);
    }
    assert!(farthest(&nodes, &[0.0; 15]) < 0.4);
}

/// Lines that resist on both sides, on one alone, and lines of which some do not.
fn resisting(plain: &Sensor) -> [Sensor; 4] {
    let one = PerLine::One;
    let mixed = |lines: usize| {
        let ohms = |line: usize| [0.0, 3.0, 8.0][line % 3];
        PerLine::Each((0..lines).map(ohms).collect())
    };
    let sides = [
        (one(4.0), one(9.0)),
        (one(4.0), one(0.0)),
        (one(0.0), one(9.0)),
        (mixed(plain.rows()), mixed(plain.columns())),
    ];
    sides.map(|(row, column)| {
        let with_lines = plain.edited(|spec| {
            spec.readout.r_line_row_ohms = Some(row);
            spec.readout.r_line_column_ohms = Some(column);
        });
        with_lines.unwrap()
    })
}

/// J v against central differences, and w·(J v) against (Jᵀ w)·v.
#[test]
fn the_derivative_along_lines_is_the_slope_and_the_adjoint_its_transpose() {
    let siemens = pressed(9, 14, 0.5, 5);
    let (v, w) = (random_direction(9 * 14, 5), random_direction(9 * 14, 6));
    let v: Vec<f64> = v.iter().zip(siemens.values()).map(|(v, g)| v * g).collect();
    let (mut worst_slope, mut worst_adjoint) = (0f64, 0f64);
    for topology in Topology::ALL {
        for sensor in resisting(&sensor(topology, 9, 14, 10.0, 0.0)) {
            let circuit = LinearCircuit::from_sensor(&sensor).unwrap();
            let mut point = circuit.point();
            point.set(siemens.values()).unwrap();
            let (mut forward, mut adjoint) = (vec![0.0; 9 * 14], vec![0.0; 9 * 14]);
            point.jvp_into(&v, &mut forward);
            point.vjp_into(&w, &mut adjoint);
            let step = 1e-4;
            let [up, down] = [step, -step]
                .map(|step| predict(&circuit, &siemens.map(|taxel, g| g + step * v[taxel])));
            let slopes = up
                .iter()
                .zip(&down)
                .map(|(up, down)| (up - down) / (2.0 * step));
            let slopes: Vec<f64> = slopes.collect();
            worst_slope = worst_slope.max(farthest(&slopes, &forward) / largest(&forward));
            let products =
                |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).collect::<Vec<f64>>();
            let (left, right) = (products(&forward, &w), products(&adjoint, &v));
            let size: f64 = left.iter().map(|product| product.abs()).sum();
            let off = (left.iter().sum::<f64>() - right.iter().sum::<f64>()).abs() / size;
            worst_adjoint = worst_adjoint.max(off);
        }
    }
    println!("slopes {worst_slope:e}, adjoint {worst_adjoint:e}");
    assert!(worst_slope < 3.9e-9, "{worst_slope:e}");
    assert!(worst_adjoint < 1e-15, "{worst_adjoint:e}");
}
