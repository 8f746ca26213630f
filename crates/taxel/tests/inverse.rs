//! The inverse undoes the scan: every topology, shape and method, and the acceptance figures.

mod common;

use common::{
    Inversion, farthest, inversion, inversions, largest, methods, pressed, relative_error, sensor,
};
use proptest::prelude::*;
use taxel::circuit::{Circuit, LinearCircuit};
use taxel::sensor::Topology;
use taxel::solve::{Exact, Method, Stop, default_method};
use taxel::{Frame, Siemens};

/// Solves a scan of `truth` without noise; the error over the largest conductance.
fn round_trip(inversion: &Inversion, truth: &Frame<Siemens>) -> f64 {
    let volts = inversion.circuit.predict(truth).unwrap();
    let solved = inversion.method.solve(&volts);
    assert!(
        solved.outcome.stop.is_good(),
        "{}: {:?}",
        inversion.label,
        solved.outcome
    );
    relative_error(&solved.frame, truth)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn solving_a_scan_gives_its_conductances(
        seed in any::<u64>(),
        fraction in 0.0..1.0f64,
        r_mux in prop::sample::select(vec![0.5, 5.0, 70.0, 150.0]),
    ) {
        for inversion in inversions(r_mux) {
            let (rows, columns) = (inversion.sensor.rows(), inversion.sensor.columns());
            let error = round_trip(&inversion, &pressed(rows, columns, fraction, seed));
            prop_assert!(error < 1e-7, "{}: error {error:e}", inversion.label);
        }
    }

    #[test]
    fn a_warm_start_gives_the_answer_of_a_cold_one(seed in any::<u64>()) {
        for inversion in inversions(70.0) {
            let (rows, columns) = (inversion.sensor.rows(), inversion.sensor.columns());
            let before = inversion.circuit.predict(&pressed(rows, columns, 0.4, !seed)).unwrap();
            let truth = pressed(rows, columns, 0.4, seed);
            let volts = inversion.circuit.predict(&truth).unwrap();
            let mut solver = inversion.method.solver();
            let mut warm = Frame::zeros(rows, columns);
            solver.solve_into(&before, &mut warm);
            let outcome = solver.solve_into(&volts, &mut warm);
            prop_assert!(outcome.stop.is_good(), "{}: {outcome:?}", inversion.label);
            let cold = inversion.method.solve(&volts).frame;
            let apart = relative_error(&warm, &cold);
            prop_assert!(apart < 1e-7, "{}: {apart:e} apart", inversion.label);
        }
    }

    #[test]
    fn the_same_solver_gives_the_same_bits(seed in any::<u64>()) {
        for inversion in inversions(70.0) {
            let (rows, columns) = (inversion.sensor.rows(), inversion.sensor.columns());
            let volts = inversion.circuit.predict(&pressed(rows, columns, 0.4, seed)).unwrap();
            let mut solver = inversion.method.solver();
            let (mut first, mut second) = (Frame::zeros(rows, columns), Frame::zeros(rows, columns));
            let one = solver.solve_into(&volts, &mut first);
            solver.forget();
            let two = solver.solve_into(&volts, &mut second);
            prop_assert_eq!(&first, &second, "{}", inversion.label);
            prop_assert_eq!(one, two, "{}", inversion.label);
            prop_assert_eq!(&first, &inversion.method.solve(&volts).frame, "{}", inversion.label);
        }
    }
}

/// A few presses on lines that float: unpressed lines hang on microsiemens, and the first step ends where the derivative
/// is all but singular. Newton's method crept on from there, through all its rounds.
#[test]
fn sparse_frames_on_floating_lines_are_inverted() {
    for (shape, seeds) in [
        ((12, 5), [528, 818]),
        ((5, 12), [50, 204]),
        ((8, 8), [60, 259]),
    ] {
        let inversion = inversion("newton", Topology::DividerFloating, shape, 70.0, 0.0);
        for seed in (0..100).chain(seeds) {
            let error = round_trip(&inversion, &pressed(shape.0, shape.1, 0.1, seed));
            assert!(error < 1e-7, "{shape:?}, seed {seed}: {error:e}");
        }
    }
}

#[test]
fn the_e_cone_is_inverted_to_1e_8_at_every_switch_resistance() {
    let truth = pressed(64, 128, 0.3, 1);
    for r_mux in [5.0, 10.0, 70.0, 100.0] {
        let sensor = sensor(Topology::TiaGroundedColumns, 64, 128, r_mux, 0.0);
        assert_eq!(default_method(&sensor).unwrap().name(), "exact");
        for name in methods(Topology::TiaGroundedColumns) {
            let inversion = inversion(name, Topology::TiaGroundedColumns, (64, 128), r_mux, 0.0);
            let error = round_trip(&inversion, &truth);
            assert!(error < 1e-8, "{}: error {error:e}", inversion.label);
        }
    }
}

#[test]
fn a_fully_pressed_e_cone_is_inverted_to_1e_8() {
    let truth = pressed(64, 128, 1.0, 1);
    for r_mux in [10.0, 70.0, 100.0] {
        let inversion = inversion("exact", Topology::TiaGroundedColumns, (64, 128), r_mux, 0.0);
        let error = round_trip(&inversion, &truth);
        assert!(error < 1e-8, "{}: error {error:e}", inversion.label);
    }
}

#[test]
fn more_rows_than_columns_and_the_largest_array_are_inverted() {
    for shape in [(128, 64), (256, 256), (256, 3), (3, 256)] {
        let truth = pressed(shape.0, shape.1, 0.3, 2);
        let inversion = inversion("exact", Topology::TiaGroundedColumns, shape, 10.0, 0.0);
        let error = round_trip(&inversion, &truth);
        assert!(error < 1e-8, "{}: error {error:e}", inversion.label);
    }
}

#[test]
fn every_topology_is_inverted_to_1e_6_at_70_ohm() {
    for topology in Topology::ALL {
        for lines in [16, 32] {
            for seed in 1..=3 {
                let truth = pressed(lines, lines, 0.3, seed);
                for r_source in [0.0, 1000.0] {
                    if r_source > 0.0 && topology == Topology::DividerGroundedColumns {
                        continue; // next test
                    }
                    let inversion = inversion("newton", topology, (lines, lines), 70.0, r_source);
                    let error = round_trip(&inversion, &truth);
                    assert!(error < 1e-6, "{}: error {error:e}", inversion.label);
                }
            }
        }
    }
}

/// Behind 1 kΩ, with 1 kΩ to ground and every other column at 70 Ω, a reading falls again as two taxels of a
/// row are pressed harder: frames have several answers. What is given must explain the frame, and a wrong
/// one must not pass for the only one.
#[test]
fn a_grounded_divider_behind_a_source_resistor_is_right_or_says_that_it_is_ambiguous() {
    let topology = Topology::DividerGroundedColumns;
    let mut right = 0;
    for lines in [16, 32] {
        let inversion = inversion("newton", topology, (lines, lines), 70.0, 1000.0);
        for (seed, fraction) in (1..=4).flat_map(|s| [(s, 0.005), (s, 0.02), (s, 0.3)]) {
            let truth = pressed(lines, lines, fraction, seed);
            let volts = inversion.circuit.predict(&truth).unwrap();
            let solved = inversion.method.solve(&volts);
            assert!(solved.outcome.stop.is_good());
            let again = inversion.circuit.predict(&solved.frame).unwrap();
            let misfit = farthest(again.values(), volts.values());
            assert!(misfit < 1e-6 * largest(volts.values()), "misfit {misfit:e}");
            let error = relative_error(&solved.frame, &truth);
            assert!(
                error < 1e-6 || solved.outcome.ambiguous,
                "{lines}x{lines}, {fraction} pressed, seed {seed}: error {error:e} passes for an answer"
            );
            right += u32::from(error < 1e-6);
        }
    }
    assert!(right >= 12, "only {right} of 24 are right");
}

#[test]
fn a_floating_mat_of_64_by_128_converges() {
    for fraction in [0.3, 1.0] {
        let inversion = inversion("newton", Topology::DividerFloating, (64, 128), 70.0, 0.0);
        let error = round_trip(&inversion, &pressed(64, 128, fraction, 1));
        assert!(error < 1e-6, "{}: error {error:e}", inversion.label);
    }
}

#[test]
fn unequal_switches_are_no_obstacle() {
    let mut sensor = sensor(Topology::TiaGroundedColumns, 24, 40, 10.0, 0.0);
    let unequal = |lines: usize| {
        let each = (0..lines).map(|i| 5.0 + (i * 7 % 11) as f64).collect();
        Some(taxel::sensor::PerLine::Each(each))
    };
    sensor = sensor
        .edited(|spec| {
            spec.readout.r_mux_column_ohms = unequal(40);
            spec.readout.r_mux_row_ohms = unequal(24);
        })
        .unwrap();
    let truth = pressed(24, 40, 0.3, 4);
    let volts = LinearCircuit::from_sensor(&sensor)
        .unwrap()
        .predict(&truth)
        .unwrap();
    let solved = default_method(&sensor).unwrap().solve(&volts);
    assert_eq!(solved.outcome.stop, Stop::Converged);
    assert!(relative_error(&solved.frame, &truth) < 1e-8);
}

/// What `with_tolerance` promises, over streams of frames and at every strength of cross-talk.
#[test]
fn a_looser_tolerance_is_kept_warm_and_cold() {
    for r_mux in [2.0, 10.0, 30.0, 70.0, 150.0] {
        for (shape, fraction) in [((16, 16), 0.3), ((40, 60), 0.5), ((64, 128), 0.3)] {
            let sensor = sensor(Topology::TiaGroundedColumns, shape.0, shape.1, r_mux, 0.0);
            let circuit = LinearCircuit::from_sensor(&sensor).unwrap();
            let (loose, tight) = (Exact::new(&circuit).unwrap(), Exact::new(&circuit).unwrap());
            let loose = loose.with_tolerance(1e-6);
            let (mut warm, mut cold) = (loose.solver(), loose.solver());
            let mut out = Frame::zeros(shape.0, shape.1);
            for volts in common::stream(&circuit, &pressed(shape.0, shape.1, fraction, 3), 6) {
                let truth = tight.solve(&volts).frame;
                for solver in [&mut warm, &mut cold] {
                    let outcome = solver.solve_into(&volts, &mut out);
                    assert!(outcome.stop.is_good());
                    let error = relative_error(&out, &truth);
                    assert!(
                        error < 1e-6,
                        "{r_mux} Ohm, {shape:?}: {error:e}, {outcome:?}"
                    );
                }
                cold.forget();
            }
        }
    }
}
