//! Netlists run by ngspice give the answers kept in `testdata/ngspice`: `cargo test --test netlist_ngspice -- --ignored`.

mod golden;

use std::process::Command;

use taxel::circuit::netlist::{Selection, netlist, readings};

/// A small case of each topology, every table, and the ones with something extra.
const CASES: [&str; 15] = [
    "tia-grounded-columns-8x8-ron70-gain1e4",
    "tia-grounded-columns-8x8-rv1000",
    "tia-zero-potential-8x8-ron10",
    "divider-grounded-columns-8x8-ron70",
    "divider-floating-8x8-ron70",
    "divider-floating-6x10-per-line",
    "divider-voltage-feedback-8x8-ron70",
    "divider-voltage-feedback-12x5",
    "tia-grounded-columns-1x1",
    "tia-grounded-columns-8x8-sheet",
    "divider-floating-12x5-sheet-strong",
    "line-ends-8x8-pull-downs",
    "line-ends-12x5-shift-register",
    "line-ends-6x10-follower",
    "line-ends-8x8-half-supply-sheet",
];

#[test]
#[ignore = "needs ngspice; `.ci/run` installs it, and runs this"]
fn ngspice_gives_the_kept_answers() {
    let cases = golden::cases();
    for name in CASES {
        let case = cases.iter().find(|case| case.name == name);
        compare(case.expect("the case is in testdata/ngspice"));
    }
}

#[test]
#[ignore = "needs ngspice; `.ci/run` installs it, and runs this"]
fn ngspice_gives_the_kept_answers_of_lines_that_resist() {
    let folder = golden::folder().with_file_name("ngspice-lines");
    for case in golden::cases_in(&folder) {
        compare(&case);
    }
}

#[test]
#[ignore = "needs ngspice; `.ci/run` installs it, and runs this"]
fn ngspice_gives_the_kept_answers_of_diodes() {
    let folder = golden::folder().with_file_name("ngspice-diodes");
    for case in golden::cases_in(&folder) {
        compare(&case);
    }
}

/// There a switch that is off has 1e15 Ohm, and only what insulates lines has 1e12.
fn with_better_switches(text: &str) -> String {
    let line = |line: &str| {
        if line.starts_with("Rleak") {
            format!("{line}\n")
        } else {
            format!("{}\n", line.replace("1e12", "1e15"))
        }
    };
    text.lines().map(line).collect()
}

fn compare(case: &golden::Case) {
    let taxels = case.v_out.iter().map(|&(row, column, _)| (row, column));
    let selection = Selection::Taxels(taxels.collect());
    let mut text = netlist(&case.sensor, &case.conductance, selection).unwrap();
    let readout = &case.sensor.spec().readout;
    if readout.r_line_row_ohms.is_some() || readout.diode.is_some() {
        text = with_better_switches(&text);
    }
    // Leaks of nanoamperes are found to what the simulator's own tolerance is beside the largest currents.
    let largest = case.v_out.iter().fold(0f64, |most, v| most.max(v.2.abs()));
    let beside = if readout.diode.is_some() {
        largest
    } else {
        0.0
    };
    let name = format!("taxel-{}-{}.cir", std::process::id(), case.name);
    let path = std::env::temp_dir().join(name);
    std::fs::write(&path, text).unwrap();
    let output = Command::new("ngspice").arg("-b").arg(&path).output();
    std::fs::remove_file(&path).unwrap();
    let output = output.expect("ngspice is installed");
    let found = readings(&String::from_utf8_lossy(&output.stdout));
    assert_eq!(found.len(), case.v_out.len(), "{}", case.name);
    for (found, kept) in found.iter().zip(&case.v_out) {
        assert_eq!((found.0, found.1), (kept.0, kept.1));
        let difference = (found.2 - kept.2).abs() / kept.2.abs().max(beside);
        assert!(difference < 1e-7, "{}: {found:?} {kept:?}", case.name);
    }
}

#[test]
fn every_case_is_complete() {
    let cases = golden::cases();
    assert!(!cases.is_empty());
    for case in &cases {
        let sign = if case.sensor.readout().has_amplifier() {
            -1.0
        } else {
            1.0
        };
        assert!(!case.v_out.is_empty(), "{}", case.name);
        for &(row, column, v_out) in &case.v_out {
            assert!(row < case.sensor.rows() && column < case.sensor.columns());
            assert!(sign * v_out > 0.0, "{}: {v_out}", case.name);
        }
    }
}
