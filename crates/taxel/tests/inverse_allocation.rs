//! A stream of frames is solved without allocating.

mod common;

use allocation_counter::measure;
use common::{inversions, pressed, sensor};
use taxel::circuit::{Circuit, LinearCircuit};
use taxel::sensor::Topology;
use taxel::solve::{Method, method};
use taxel::{Frame, Mark, Volts};

/// Allocations of the second and the third frame on one scratch, the third from a cold start.
fn allocations(method: &dyn Method, frames: [&Frame<Volts>; 2]) -> [u64; 2] {
    let mut scratch = method.scratch();
    let mut out = Frame::zeros(frames[0].rows(), frames[0].columns());
    let mut solve = |frame, scratch: &mut _| {
        measure(|| {
            method.solve_into(frame, &mut out, scratch);
        })
        .count_total
    };
    solve(frames[0], &mut scratch);
    let warm = solve(frames[1], &mut scratch);
    scratch.forget();
    [warm, solve(frames[0], &mut scratch)]
}

#[test]
fn a_frame_allocates_nothing_after_the_first() {
    for r_mux in [5.0, 150.0] {
        for inversion in inversions(r_mux) {
            let (rows, columns) = (inversion.sensor.rows(), inversion.sensor.columns());
            let scan = |seed| {
                let truth = pressed(rows, columns, 0.9, seed);
                inversion.circuit.predict(&truth).unwrap()
            };
            let found = allocations(&*inversion.method, [&scan(1), &scan(2)]);
            assert_eq!(found, [0, 0], "{}", inversion.label);
            let raw = method("raw", &inversion.sensor).unwrap();
            assert_eq!(allocations(&*raw, [&scan(1), &scan(2)]), [0, 0]);
        }
    }
}

#[test]
fn neither_does_one_of_the_size_of_the_e_cone_with_dead_lines() {
    for (name, r_mux) in [("exact", 10.0), ("exact", 70.0), ("newton", 10.0)] {
        let sensor = sensor(Topology::TiaGroundedColumns, 64, 128, r_mux, 0.0);
        let circuit = LinearCircuit::from_sensor(&sensor).unwrap();
        let scan = |seed| {
            let mut truth = pressed(64, 128, 0.3, seed);
            truth.values_mut()[5 * 128..6 * 128].fill(0.0);
            let mut volts = circuit.predict(&truth).unwrap();
            volts.marks_mut()[5 * 128..6 * 128].fill(Mark::Open);
            volts
        };
        let method = method(name, &sensor).unwrap();
        let found = allocations(&*method, [&scan(1), &scan(2)]);
        assert_eq!(found, [0, 0], "{name} at {r_mux} Ohm");
    }
}
