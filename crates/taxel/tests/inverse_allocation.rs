//! A stream of frames is solved without allocating.

mod common;

use allocation_counter::measure;
use common::{inversions, pressed, sensor, under_sheet};
use taxel::circuit::{Circuit, LinearCircuit, SensorCircuit};
use taxel::pipeline::Pipeline;
use taxel::sensor::{DiodePlace, DiodeSpec, DynamicSpec, PerLine, Topology, preset};
use taxel::simulate::{Pattern, VirtualSensor};
use taxel::solve::{Method, Solver, method};
use taxel::{Frame, Mark, Volts};

/// Allocations of the second and the third frame by one solver, the third from a cold start.
fn allocations(method: &dyn Method, frames: [&Frame<Volts>; 2]) -> [u64; 2] {
    let mut solver = method.solver();
    let mut out = Frame::zeros(frames[0].rows(), frames[0].columns());
    let mut solve = |frame, solver: &mut dyn Solver| {
        measure(|| {
            solver.solve_into(frame, &mut out);
        })
        .count_total
    };
    solve(frames[0], &mut *solver);
    let warm = solve(frames[1], &mut *solver);
    solver.forget();
    [warm, solve(frames[0], &mut *solver)]
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

/// Counts to loads with all that a sensor file can ask for: screen, inverse, law, creep and hysteresis, spread.
#[test]
fn neither_does_the_whole_pipeline_with_a_material_that_remembers() {
    let mut dynamic = DynamicSpec::new(0.01);
    dynamic.lag_weight = vec![0.08, 0.07];
    dynamic.lag_secs = vec![0.8, 8.0];
    dynamic.play_weight = vec![0.07, 0.07];
    dynamic.play_g = vec![5.0, 15.0];
    let sensor = preset("econe")
        .unwrap()
        .edited(|spec| {
            let material = spec.material.as_mut().unwrap();
            material.spread = Some([0.02, 0.02, 0.005]);
            material.dynamic = Some(dynamic);
        })
        .unwrap();
    let real = VirtualSensor::new(&sensor, 1).unwrap();
    let hand = Pattern::hand();
    let frames: Vec<_> = real
        .recording(&hand, 60..63)
        .map(|(_, reading)| reading.counts)
        .collect();
    let mut pipeline = Pipeline::new(&sensor, method("exact", &sensor).unwrap()).unwrap();
    let mut take = |frame| {
        measure(|| {
            pipeline.process(frame).newtons().unwrap();
        })
        .count_total
    };
    take(&frames[0]);
    assert_eq!([take(&frames[1]), take(&frames[2])], [0, 0]);
}

#[test]
fn neither_does_one_of_lines_that_resist() {
    for (topology, sheet) in [
        (Topology::TiaGroundedColumns, None),
        (Topology::TiaGroundedColumns, Some((10e3, 3.0))),
        (Topology::DividerFloating, None),
    ] {
        let sensor = sensor(topology, 12, 20, 10.0, 0.0)
            .edited(|spec| {
                spec.readout.r_line_row_ohms = Some(PerLine::One(4.0));
                spec.readout.r_line_column_ohms = Some(PerLine::One(2.0));
                spec.converter.noise_counts = Some(2.0);
            })
            .unwrap();
        let sensor = under_sheet(&sensor, sheet);
        let circuit = LinearCircuit::from_sensor(&sensor).unwrap();
        let scan = |seed| circuit.predict(&pressed(12, 20, 0.3, seed)).unwrap();
        let newton = method("newton", &sensor).unwrap();
        let found = allocations(&*newton, [&scan(1), &scan(2)]);
        assert_eq!(found, [0, 0], "{topology:?}, {sheet:?}");
    }
}

#[test]
fn neither_does_one_of_diodes() {
    for (topology, place) in [
        (Topology::TiaGroundedColumns, DiodePlace::Taxel),
        (Topology::TiaZeroPotential, DiodePlace::Taxel),
        (Topology::DividerVoltageFeedback, DiodePlace::Taxel),
        (Topology::DividerPulledRows, DiodePlace::DrivenLine),
    ] {
        let diode = DiodeSpec::new(place, 2.52e-9, 1.752);
        let sensor = sensor(topology, 12, 20, 10.0, 0.0)
            .edited(|spec| {
                spec.readout.v_test_volts = 3.3;
                spec.readout.diode = Some(diode);
            })
            .unwrap();
        let circuit = SensorCircuit::from_sensor(&sensor).unwrap();
        let scan = |seed| circuit.predict(&pressed(12, 20, 0.3, seed)).unwrap();
        let method = method("auto", &sensor).unwrap();
        let found = allocations(&*method, [&scan(1), &scan(2)]);
        assert_eq!(found, [0, 0], "{topology:?}");
    }
}
