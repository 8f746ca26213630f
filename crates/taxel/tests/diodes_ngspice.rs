//! Diodes in taxels and in driven lines: the scan against ngspice's answers, and those undone.

#[allow(dead_code, reason = "other tests use the rest")]
mod golden;

use taxel::circuit::{Circuit, SensorCircuit};
use taxel::{Frame, Volts};

fn cases() -> Vec<golden::Case> {
    let cases = golden::cases_in(&golden::folder().with_file_name("ngspice-diodes"));
    assert_eq!(cases.len(), 9);
    cases
}

#[test]
fn every_kept_answer_of_ngspice_is_predicted() {
    let mut worst = 0f64;
    for case in cases() {
        let circuit = SensorCircuit::from_sensor(&case.sensor).unwrap();
        let volts = circuit.predict(&case.conductance).unwrap();
        let largest = case.v_out.iter().fold(0f64, |most, v| most.max(v.2.abs()));
        let off = case
            .v_out
            .iter()
            .map(|&(row, column, expected)| (volts.at(row, column) - expected).abs() / largest);
        let off = off.fold(0.0, f64::max);
        println!("{:<55} {off:.1e}", case.name);
        worst = worst.max(off);
    }
    assert!(worst < 5.5e-7, "{worst:e}");
}

#[test]
fn what_ngspice_reads_is_undone() {
    let mut worst = [0f64; 2];
    for case in cases() {
        let mut volts: Frame<Volts> = case.conductance.map(|_, _| 0.0);
        for &(row, column, read) in &case.v_out {
            volts.values_mut()[row * case.sensor.columns() + column] = read;
        }
        let solved = taxel::solve::default_method(&case.sensor)
            .unwrap()
            .solve(&volts);
        let largest = case
            .conductance
            .values()
            .iter()
            .copied()
            .fold(0.0, f64::max);
        let off = solved.frame.values().iter().zip(case.conductance.values());
        let off = off.fold(0f64, |most, (a, b)| most.max((a - b).abs())) / largest;
        println!("{:<55} {:?} {off:.1e}", case.name, solved.outcome);
        assert!(solved.outcome.is_answer(), "{}", case.name);
        let at = usize::from(case.name.contains("driven-line"));
        worst[at] = worst[at].max(off);
    }
    assert!(worst[0] < 2.2e-7 && worst[1] < 3.4e-6, "{worst:?}");
}
