//! The sweep along the rows against the one along the columns: another order of elimination, the same network.

use super::*;
use crate::sensor::{Array, ConverterSpec, PerLine, ReadoutSpec, Sensor, SensorSpec, Topology};

const TOPOLOGIES: [Topology; 5] = [
    Topology::TiaGroundedColumns,
    Topology::TiaZeroPotential,
    Topology::DividerGroundedColumns,
    Topology::DividerFloating,
    Topology::DividerVoltageFeedback,
];

fn circuit(topology: Topology, (rows, columns): (usize, usize)) -> LinearCircuit {
    let mut readout = ReadoutSpec::new(topology, 0.4);
    if topology.is_tia() {
        (readout.r_feedback_ohms, readout.open_loop_gain) = (Some(2000.0), Some(1e5));
    } else {
        readout.r_pull_down_ohms = Some(1000.0);
    }
    let each = |lines: usize| PerLine::Each((0..lines).map(|i| 1.0 + i as f64).collect());
    readout.r_mux_column_ohms = Some(each(columns));
    readout.r_mux_row_ohms = Some(PerLine::One(9.0));
    readout.r_line_row_ohms = Some(each(rows));
    readout.r_line_column_ohms = Some(PerLine::One(5.0));
    let array = Array::new(rows, columns);
    let spec = SensorSpec::new(array, readout, ConverterSpec::new(16, 2.2));
    LinearCircuit::from_sensor(&Sensor::try_from(spec).unwrap()).unwrap()
}

/// Of the largest number.
fn apart(one: &[f64], other: &[f64]) -> f64 {
    let most = one
        .iter()
        .fold(0.0, |most: f64, value| most.max(value.abs()));
    let pairs = one.iter().zip(other);
    pairs.fold(0.0, |far: f64, (a, b)| far.max((a - b).abs())) / most
}

#[test]
fn either_way_of_the_sweep_gives_the_same() {
    let mut worst = 0.0f64;
    for topology in TOPOLOGIES {
        for shape in [(5, 9), (9, 5), (7, 7), (1, 6), (6, 1)] {
            let circuit = circuit(topology, shape);
            let lines = circuit.lines().unwrap();
            let taxels = shape.0 * shape.1;
            let siemens: Vec<f64> = (0..taxels)
                .map(|at| {
                    if at * 7 % 5 < 2 {
                        1e-3 / (1.0 + (at % 4) as f64)
                    } else {
                        1e-6
                    }
                })
                .collect();
            let direction: Vec<f64> = (0..taxels).map(|at| 1.0 - (at * 3 % 8) as f64).collect();
            let [one, other] = [false, true].map(|transposed| {
                let arrangement = Arrangement::swept(lines, false, transposed);
                let mut point = LinesPoint::arranged(&circuit, lines, arrangement);
                point.set(&siemens).unwrap();
                let mut found = [(); 3].map(|()| vec![0.0; taxels]);
                point.predict_into(&mut found[0]);
                point.jvp_into(&direction, &mut found[1]);
                point.vjp_into(&direction, &mut found[2]);
                found
            });
            for (one, other) in one.iter().zip(&other) {
                worst = worst.max(apart(one, other));
            }
        }
    }
    assert!(worst < 1.1e-12, "{worst:e}");
}
