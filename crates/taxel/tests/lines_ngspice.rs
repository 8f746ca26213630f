//! Lines that resist: the scan against ngspice's answers, and against itself in other forms.

#[allow(dead_code, reason = "other tests use the rest")]
mod golden;

use taxel::circuit::{Circuit, LinearCircuit};
use taxel::solve::{Method, Newton};
use taxel::{Frame, Volts};

#[test]
fn every_kept_answer_of_ngspice_is_predicted() {
    let folder = golden::folder().with_file_name("ngspice-lines");
    let cases = golden::cases_in(&folder);
    assert_eq!(cases.len(), 21);
    let mut worst: f64 = 0.0;
    for case in cases {
        let circuit = LinearCircuit::from_sensor(&case.sensor).unwrap();
        let volts = circuit.predict(&case.conductance).unwrap();
        for &(row, column, expected) in &case.v_out {
            let off = (volts.at(row, column) / expected - 1.0).abs();
            assert!(off <= 3e-8, "{} ({row}, {column}): {off:e}", case.name);
            worst = worst.max(off);
        }
    }
    println!("worst: {worst:e}");
}

#[test]
fn what_ngspice_reads_is_undone() {
    let folder = golden::folder().with_file_name("ngspice-lines");
    let (mut worst, mut rounds): (f64, u32) = (0.0, 0);
    for case in golden::cases_in(&folder) {
        let circuit = LinearCircuit::from_sensor(&case.sensor).unwrap();
        let mut volts: Frame<Volts> = case.conductance.map(|_, _| 0.0);
        for &(row, column, read) in &case.v_out {
            volts.values_mut()[row * case.sensor.columns() + column] = read;
        }
        let solved = Newton::new(circuit).solve(&volts);
        let largest = case
            .conductance
            .values()
            .iter()
            .copied()
            .fold(0.0, f64::max);
        let off = solved.frame.values().iter().zip(case.conductance.values());
        let off = off.fold(0f64, |most, (a, b)| most.max((a - b).abs())) / largest;
        println!("{:<45} {:?} {off:.1e}", case.name, solved.outcome);
        (worst, rounds) = (worst.max(off), rounds.max(solved.outcome.iterations));
    }
    assert!(worst <= 2e-7, "{worst:e}");
}
