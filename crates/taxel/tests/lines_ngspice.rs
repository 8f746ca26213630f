//! Lines that resist: the scan against ngspice's answers, and against itself in other forms.

#[allow(dead_code, reason = "other tests use the rest")]
mod golden;

use taxel::circuit::{Circuit, LinearCircuit};

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
