//! The scan against ngspice's answers: 17 circuits by others, 38 by the netlists of this crate.

mod golden;

use taxel::circuit::{Circuit, LinearCircuit};

/// ngspice models an open switch as 1e12 Ω to the multiplexer's common pin, the scan as a leak to ground: the
/// answers differ by that much where a taxel of 1 µS reads alone.
const AGREEMENT: f64 = 1e-5;

#[test]
fn every_kept_answer_of_ngspice_is_predicted() {
    let cases = golden::cases();
    assert!(cases.len() >= 55, "only {} cases", cases.len());
    for case in cases {
        let circuit = LinearCircuit::from_sensor(&case.sensor).unwrap();
        let volts = circuit.predict(&case.conductance).unwrap();
        for &(row, column, expected) in &case.v_out {
            let found = volts.at(row, column);
            assert!(
                (found - expected).abs() <= AGREEMENT * expected.abs(),
                "{} ({row}, {column}): {found} against {expected}",
                case.name
            );
        }
    }
}
