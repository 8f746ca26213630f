//! The quick scheme for grounded columns against Newton's method on all lines at once.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::circuit::diode::taxel::Currents;
use crate::sensor::{DiodeSpec, Topology, preset};

fn sensor(topology: Topology, (rows, columns): (usize, usize), diode: DiodeSpec) -> Sensor {
    let edit = |spec: &mut crate::sensor::SensorSpec| {
        (spec.array.rows, spec.array.columns) = (rows, columns);
        spec.readout.topology = topology;
        spec.readout.v_test_volts = 2.0;
        spec.readout.r_pull_down_ohms = Some(1000.0);
        spec.readout.diode = Some(diode);
    };
    preset("econe").unwrap().edited(edit).unwrap()
}

/// A third of the taxels between 500 Ω and 3 kΩ, the others about 1 µS.
fn pressed(taxels: usize, random: &mut ChaCha8Rng) -> Vec<f64> {
    let one = |_| match random.random::<f64>() {
        x if x < 0.33 => 1.0 / (500.0 + 2500.0 * random.random::<f64>()),
        _ => 1e-6 * (0.5 + random.random::<f64>()),
    };
    (0..taxels).map(one).collect()
}

#[test]
fn rows_one_by_one_find_what_all_lines_at_once_do() {
    let silicon = DiodeSpec::new(DiodePlace::Taxel, 2.52e-9, 1.752);
    let schottky = DiodeSpec::new(DiodePlace::Taxel, 2e-7, 1.05);
    let mut worst = 0f64;
    for (diode, shape) in [
        (&silicon, (5, 7)),
        (&schottky, (9, 6)),
        (&schottky, (16, 16)),
    ] {
        for topology in [
            Topology::TiaGroundedColumns,
            Topology::TiaZeroPotential,
            Topology::DividerGroundedColumns,
        ] {
            for seed in 1..=3 {
                let mut random = ChaCha8Rng::seed_from_u64(seed);
                let sensor = sensor(topology, shape, diode.clone());
                let circuit = DiodeCircuit::from_sensor(&sensor).unwrap().unwrap();
                let siemens = pressed(shape.0 * shape.1, &mut random);
                let paths = circuit.paths();
                let both =
                    [Currents::new(&paths), Currents::by_all_lines(&paths)].map(|mut way| {
                        way.set(&paths, &siemens, false);
                        way.solve_own(&paths, &siemens);
                        way.row_volts
                    });
                let largest = both[1].iter().fold(0f64, |most, v| most.max(v.abs()));
                let apart = both[0].iter().zip(&both[1]);
                let apart = apart.fold(0f64, |most, (a, b)| most.max((a - b).abs())) / largest;
                worst = worst.max(apart);
            }
        }
    }
    // What rows that float low leak less into columns is left out.
    assert!(worst < 8e-7, "{worst:e}");
}
