//! What a faulty frame does to the inverse: dead lines, saturated readings, rows without current, and circuits
//! that cannot explain what was read.

mod common;

use common::{Inversion, inversion, inversions, pressed, relative_error};
use taxel::circuit::{Circuit, LinearCircuit};
use taxel::sensor::Topology;
use taxel::solve::{Infeasible, Method, Newton, Stop, method};
use taxel::{Frame, Mark, Sensor, Siemens, Volts};

/// The frame without some lines.
fn without<Q>(frame: &Frame<Q>, rows: &[usize], columns: &[usize]) -> Frame<Q> {
    let mut values = Vec::new();
    for r in (0..frame.rows()).filter(|r| !rows.contains(r)) {
        for c in (0..frame.columns()).filter(|c| !columns.contains(c)) {
            values.push(frame.at(r, c));
        }
    }
    let shape = (frame.rows() - rows.len(), frame.columns() - columns.len());
    Frame::new(shape.0, shape.1, values).unwrap()
}

#[test]
fn dead_lines_are_left_out_as_if_the_sensor_had_none() {
    let (dead_rows, dead_columns) = ([0usize, 5], [3usize]);
    for whole in inversions(30.0) {
        let (rows, columns) = (whole.sensor.rows(), whole.sensor.columns());
        if rows < 7 || columns < 5 {
            continue;
        }
        let truth = pressed(rows, columns, 0.4, 11);
        let smaller = inversion(
            whole.method.name(),
            whole.sensor.readout().topology,
            (rows - 2, columns - 1),
            30.0,
            0.0,
        );
        let part = without(&truth, &dead_rows, &dead_columns);
        let small_volts = smaller.circuit.predict(&part).unwrap();
        let expected = smaller.method.solve(&small_volts).frame;

        // Dead lines read anything; their marks say so.
        let mut volts: Frame<Volts> = Frame::filled(rows, columns, 0.123);
        let mut left = small_volts.values().iter();
        for r in 0..rows {
            for c in 0..columns {
                let at = r * columns + c;
                if dead_rows.contains(&r) || dead_columns.contains(&c) {
                    volts.marks_mut()[at] = Mark::Open;
                } else {
                    volts.values_mut()[at] = *left.next().unwrap();
                }
            }
        }
        let solved = whole.method.solve(&volts);
        assert!(solved.outcome.stop.is_good(), "{}", whole.label);
        for r in 0..rows {
            for c in 0..columns {
                if dead_rows.contains(&r) || dead_columns.contains(&c) {
                    assert_eq!(solved.frame.at(r, c), 0.0, "{}", whole.label);
                    assert_eq!(solved.frame.mark_at(r, c), Mark::Open, "{}", whole.label);
                }
            }
        }
        let found = without(&solved.frame, &dead_rows, &dead_columns);
        assert_eq!(found.values(), expected.values(), "{}", whole.label);
        assert!(relative_error(&found, &part) < 1e-7, "{}", whole.label);
    }
}

#[test]
fn lines_that_die_and_come_back_do_so_within_a_stream() {
    for inversion in inversions(30.0) {
        let (rows, columns) = (inversion.sensor.rows(), inversion.sensor.columns());
        let truth = pressed(rows, columns, 0.4, 12);
        let good = inversion.circuit.predict(&truth).unwrap();
        let mut solver = inversion.method.solver();
        let mut out = Frame::zeros(rows, columns);
        solver.solve_into(&good, &mut out);
        let mut dead = good.clone();
        dead.marks_mut()[..columns].fill(Mark::Open);
        let outcome = solver.solve_into(&dead, &mut out);
        // What the dead row drained is now the others' to explain, which may be impossible; not a panic.
        assert!(
            out.values()[..columns].iter().all(|&g| g == 0.0),
            "{outcome:?}"
        );
        let outcome = solver.solve_into(&good, &mut out);
        assert!(outcome.stop.is_good(), "{}: {outcome:?}", inversion.label);
        assert!(relative_error(&out, &truth) < 1e-7, "{}", inversion.label);
    }
}

#[test]
fn a_frame_without_any_live_line_is_all_open() {
    for inversion in inversions(30.0) {
        let mut volts = Frame::zeros(inversion.sensor.rows(), inversion.sensor.columns());
        volts.marks_mut().fill(Mark::Open);
        let solved = inversion.method.solve(&volts);
        assert_eq!(solved.outcome.stop, Stop::Direct, "{}", inversion.label);
        assert!(solved.frame.values().iter().all(|&g| g == 0.0));
        assert!(solved.frame.marks().iter().all(|&mark| mark == Mark::Open));
    }
}

/// Taxels whose reading the converter clips to four fifths.
const CLIPPED: [usize; 4] = [20, 77, 150, 151];

/// Clips the readings of heavily pressed taxels: they keep their mark, become lower bounds, and mislead the
/// others a little.
#[test]
fn a_saturated_reading_is_a_lower_bound() {
    for topology in Topology::ALL {
        for &name in common::methods(topology) {
            let inversion = inversion(name, topology, (16, 16), 10.0, 0.0);
            let fraction = match topology {
                Topology::DividerFloating => 0.05,
                _ => 0.3,
            };
            let mut truth = pressed(16, 16, fraction, 6);
            for taxel in CLIPPED {
                truth.values_mut()[taxel] = 1.0 / 150.0;
            }
            check_saturated(&inversion, &truth);
        }
    }
}

fn check_saturated(inversion: &Inversion, truth: &Frame<Siemens>) {
    let mut volts = inversion.circuit.predict(truth).unwrap();
    for at in CLIPPED {
        volts.values_mut()[at] *= 0.8;
        volts.marks_mut()[at] = Mark::Saturated;
    }
    let solved = inversion.method.solve(&volts);
    assert!(solved.outcome.stop.is_good(), "{}", inversion.label);
    let most = 1.0 / 500.0;
    for (at, (found, true_g)) in solved.frame.values().iter().zip(truth.values()).enumerate() {
        assert_eq!(solved.frame.marks()[at], volts.marks()[at]);
        if volts.marks()[at] == Mark::Saturated {
            assert!(
                found <= true_g,
                "{} taxel {at}: {found} > {true_g}",
                inversion.label
            );
            assert!(
                *found > 0.15 * true_g,
                "{} taxel {at}: {found}",
                inversion.label
            );
        } else {
            // In a divider the row's other readings hang on what the clipped taxel drains: only the other
            // rows are nearly untouched. Where columns float everything hangs together.
            let row = at / 16 * 16..(at / 16 + 1) * 16;
            let clean = volts.marks()[row].iter().all(|&mark| mark == Mark::Good);
            let topology = inversion.sensor.readout().topology;
            let floats = [Topology::DividerFloating, Topology::DividerPulledRows];
            if floats.contains(&topology) || (!clean && !topology.is_tia()) {
                continue;
            }
            let error = (found - true_g).abs();
            assert!(
                error < 0.04 * most,
                "{} taxel {at}: {found} against {true_g}",
                inversion.label
            );
        }
    }
}

#[test]
fn rows_without_current_disturb_nothing() {
    for topology in Topology::ALL {
        for &name in common::methods(topology) {
            let inversion = inversion(name, topology, (12, 20), 30.0, 0.0);
            let mut truth = pressed(12, 20, 0.4, 7);
            for c in 0..20 {
                truth.values_mut()[3 * 20 + c] = 0.0;
                truth.values_mut()[8 * 20 + c] = 0.0;
            }
            let mut volts = inversion.circuit.predict(&truth).unwrap();
            let sign = volts.values()[0].signum();
            for (c, noise) in (0..20).map(|c| (c, 1e-9 * (c % 3) as f64)) {
                volts.values_mut()[3 * 20 + c] = 0.0;
                volts.values_mut()[8 * 20 + c] = -sign * noise;
            }
            let solved = inversion.method.solve(&volts);
            assert!(
                solved.outcome.stop.is_good(),
                "{}: {:?}",
                inversion.label,
                solved.outcome
            );
            let error = relative_error(&solved.frame, &truth);
            assert!(error < 1e-6, "{}: error {error:e}", inversion.label);
        }
    }
}

#[test]
fn a_frame_of_zeros_is_a_frame_of_no_conductance() {
    for inversion in inversions(30.0) {
        let volts = Frame::zeros(inversion.sensor.rows(), inversion.sensor.columns());
        let solved = inversion.method.solve(&volts);
        assert!(solved.outcome.stop.is_good(), "{}", inversion.label);
        assert!(
            solved.frame.values().iter().all(|&g| g == 0.0),
            "{}",
            inversion.label
        );
    }
}

/// A sensor whose rows and columns were calibrated to other resistances than its frame was made with.
fn mistaken(topology: Topology, column_ohms: f64, row_ohms: f64) -> (Sensor, Frame<Volts>) {
    let mut sensor = common::sensor(topology, 24, 32, 10.0, 0.0);
    let circuit = LinearCircuit::from_sensor(&sensor).unwrap();
    let volts = circuit.predict(&pressed(24, 32, 0.6, 9)).unwrap();
    sensor = sensor
        .edited(|spec| {
            spec.readout.r_mux_column_ohms = Some(taxel::sensor::PerLine::One(column_ohms));
            spec.readout.r_mux_row_ohms = Some(taxel::sensor::PerLine::One(row_ohms));
        })
        .unwrap();
    (sensor, volts)
}

fn infeasible(method: &dyn Method, volts: &Frame<Volts>) -> Infeasible {
    let solved = method.solve(volts);
    assert!(solved.frame.values().iter().all(|g| g.is_finite()));
    match solved.outcome.stop {
        Stop::Infeasible(infeasible) => infeasible,
        stop => panic!("{}: {stop:?}, not infeasible", method.name()),
    }
}

/// Every row: 0.4 V through all columns at once cannot lift it above 0.4 V.
#[test]
fn a_row_resistance_that_is_too_large_is_named() {
    for topology in [
        Topology::TiaGroundedColumns,
        Topology::DividerGroundedColumns,
    ] {
        for &name in common::methods(topology) {
            let (sensor, volts) = mistaken(topology, 10.0, 10.0);
            let solved = method(name, &sensor).unwrap().solve(&volts);
            assert!(
                solved.outcome.stop.is_good(),
                "{name}: {:?}",
                solved.outcome
            );
            for row_ohms in [400.0, 2000.0] {
                let (sensor, volts) = mistaken(topology, 10.0, row_ohms);
                let found = infeasible(&*method(name, &sensor).unwrap(), &volts);
                assert!(found.number.starts_with("r_mux_row_ohms"), "{found}");
                assert!(found.line.starts_with("row "), "{found}");
                assert!(found.limit_ohms < found.ohms, "{found}");
            }
        }
    }
}

/// Up to about 400 Ω, this frame still has an answer, with ever larger negative conductances.
#[test]
fn a_column_resistance_that_is_too_large_is_named() {
    for column_ohms in [500.0, 1000.0, 5000.0] {
        let (sensor, volts) = mistaken(Topology::TiaGroundedColumns, column_ohms, 10.0);
        let found = infeasible(&*method("exact", &sensor).unwrap(), &volts);
        assert_eq!(found.number, "r_mux_column_ohms", "{found}");
        assert!(found.line.starts_with("column "), "{found}");
        assert!((found.ohms - column_ohms).abs() < 1e-9, "{found}");
        assert!(
            found.limit_ohms > 300.0 && found.limit_ohms < 450.0,
            "{found}"
        );
    }
}

#[test]
fn a_divider_that_reads_more_than_its_path_lets_through_is_named() {
    for topology in [
        Topology::DividerGroundedColumns,
        Topology::DividerFloating,
        Topology::DividerVoltageFeedback,
    ] {
        let mut sensor = common::sensor(topology, 8, 8, 10.0, 0.0);
        let circuit = LinearCircuit::from_sensor(&sensor).unwrap();
        let mut truth = Frame::filled(8, 8, 1e-6);
        truth.values_mut()[19] = 1.0 / 100.0;
        let volts = circuit.predict(&truth).unwrap();
        sensor = sensor
            .edited(|spec| {
                spec.readout.r_mux_row_ohms = Some(taxel::sensor::PerLine::One(400.0));
            })
            .unwrap();
        let newton = Newton::new(LinearCircuit::from_sensor(&sensor).unwrap());
        let found = infeasible(&newton, &volts);
        assert!(found.number.contains("r_mux_row_ohms"), "{found}");
        assert!(found.line.contains("row 2"), "{found}");
        assert!(found.limit_ohms < found.ohms, "{found}");
        assert!(found.to_string().contains("hint:"), "{found}");
    }
}
