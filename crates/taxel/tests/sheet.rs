//! A continuous sheet: every method inverts its scan, cold and warm, with lines missing, without allocating.

mod common;

use allocation_counter::measure;
use common::{SHAPES, methods, pressed, relative_error, sensor, under_sheet};
use taxel::circuit::{Circuit, LinearCircuit};
use taxel::material::{LoadLaw, Sheet};
use taxel::sensor::{PerLine, Sensor, Topology, preset};
use taxel::simulate::{Pattern, PatternKind};
use taxel::solve::{Exact, Method, method};
use taxel::{Frame, Mark};

/// R_s and α of sheets from hardly there to one that carries as much as the taxels.
const SHEETS: [(f64, f64); 4] = [(50e3, 3.0), (20e3, 4.0), (8e3, 2.0), (6e3, 1.0)];

fn round_trip(sensor: &Sensor, name: &str, truth: &Frame<taxel::Siemens>) -> (f64, u32) {
    let volts = LinearCircuit::from_sensor(sensor)
        .unwrap()
        .predict(truth)
        .unwrap();
    let solved = method(name, sensor).unwrap().solve(&volts);
    let outcome = solved.outcome;
    assert!(outcome.stop.is_good(), "{name}: {outcome:?}");
    (relative_error(&solved.frame, truth), outcome.iterations)
}

#[test]
fn every_read_out_and_shape_is_inverted() {
    for topology in Topology::ALL {
        for (rows, columns) in SHAPES {
            for (i, sheet) in SHEETS.into_iter().enumerate() {
                let plain = sensor(topology, rows, columns, 30.0, 0.0);
                let sheet = under_sheet(&plain, Some(sheet));
                for name in methods(topology) {
                    let truth = pressed(rows, columns, 0.5, i as u64);
                    let (error, _) = round_trip(&sheet, name, &truth);
                    assert!(
                        error < 1e-7,
                        "{name} {topology:?} {rows}x{columns}: {error:e}"
                    );
                }
            }
        }
    }
}

#[test]
fn the_e_cone_is_inverted_from_weak_sheets_to_strong_ones() {
    for r_mux in [5.0, 10.0, 70.0] {
        for (i, sheet) in SHEETS.into_iter().enumerate() {
            let plain = sensor(Topology::TiaGroundedColumns, 64, 128, r_mux, 0.0);
            let truth = pressed(64, 128, 0.3, i as u64);
            let (error, rounds) = round_trip(&under_sheet(&plain, Some(sheet)), "exact", &truth);
            println!("{r_mux} Ohm, {sheet:?}: {error:e} in {rounds} rounds");
            assert!(
                error < 1e-8,
                "{r_mux} Ohm, {sheet:?}: {error:e} in {rounds} rounds"
            );
        }
    }
}

/// Noise puts taxels that nothing presses below 0: past them nothing flows, whatever they read. Taken to hang on them, couplings
/// went a fourteenth of their way each round, and a frame of a real film ended without an answer.
#[test]
fn taxels_below_zero_cost_no_rounds() {
    let plain = sensor(Topology::TiaGroundedColumns, 64, 128, 8.0, 0.0);
    let sensor = under_sheet(&plain, Some((7.8e3, 4.3)));
    for seed in [1, 2, 3] {
        let mut truth = pressed(64, 128, 1.0, seed);
        for (row, values) in truth.values_mut().chunks_exact_mut(128).enumerate() {
            // Two rows of four are not pressed: noise of both signs, that hardly leaves them a sum.
            let is_above = |j: usize| (j / (row % 4 - 1)).is_multiple_of(2);
            if row % 4 > 1 {
                let each = values.iter_mut().enumerate();
                each.for_each(|(j, value)| *value = if is_above(j) { 2e-6 } else { -1.98e-6 });
            }
        }
        let (error, rounds) = round_trip(&sensor, "exact", &truth);
        println!("{seed}: {error:e} in {rounds} rounds");
        assert!(
            error < 1e-9 && rounds <= 11,
            "{seed}: {error:e} in {rounds} rounds"
        );
    }
}

/// In a stream that hardly moves the iteration may believe to have arrived before it has.
#[test]
fn a_steady_stream_is_inverted_as_well_as_its_first_frame() {
    let sensor = preset("econe").unwrap().edited(|spec| {
        spec.readout.r_mux_row_ohms = Some(PerLine::One(5.0));
        spec.readout.r_mux_column_ohms = Some(PerLine::One(5.0));
    });
    let sensor = sensor.unwrap();
    let circuit = LinearCircuit::from_sensor(&sensor).unwrap();
    let circuit = circuit.with_sheet(Some(Sheet::new(40e3, 3.0)));
    let law = LoadLaw::from_sensor(&sensor).unwrap();
    let pattern = Pattern::new(PatternKind::Fingers { tips: 5 });
    let mut solver = Exact::new(&circuit).unwrap().solver();
    let mut found = Frame::zeros(64, 128);
    for frame in 100..106 {
        let loads = pattern.loads(sensor.array(), 3, frame);
        let truth = loads.map(|taxel, grams| law.siemens_from_grams(taxel, grams));
        let outcome = solver.solve_into(&circuit.predict(&truth).unwrap(), &mut found);
        assert!(outcome.stop.is_good(), "{outcome:?}");
        let error = relative_error(&found, &truth);
        println!("{frame}: {error:e} in {} rounds", outcome.iterations);
        assert!(error < 1e-9, "{frame}: {error:e}");
    }
}

#[test]
fn a_missing_line_cuts_the_sheet_and_nothing_is_allocated() {
    let plain = sensor(Topology::TiaGroundedColumns, 24, 40, 10.0, 0.0);
    let sensor = under_sheet(&plain, Some((10e3, 3.0)));
    let circuit = LinearCircuit::from_sensor(&sensor).unwrap();
    let scan = |seed| {
        let mut truth = pressed(24, 40, 0.5, seed);
        truth.values_mut()[5 * 40..6 * 40].fill(0.0);
        let mut volts = circuit.predict(&truth).unwrap();
        volts.marks_mut()[5 * 40..6 * 40].fill(Mark::Open);
        (truth, volts)
    };
    for name in ["exact", "newton"] {
        let mut solver = method(name, &sensor).unwrap().solver();
        let mut found = Frame::zeros(24, 40);
        solver.solve_into(&scan(1).1, &mut found);
        for seed in [2, 3] {
            let (truth, volts) = scan(seed);
            let mut good = false;
            let allocated = measure(|| {
                good = solver.solve_into(&volts, &mut found).stop.is_good();
            });
            assert!(good && relative_error(&found, &truth) < 1e-8, "{name}");
            assert_eq!(allocated.count_total, 0, "{name}");
            solver.forget();
        }
    }
}
