//! A sensor file with a table of line ends, through the commands that take a sensor.

use crate::run::{Folder, SENSOR};

/// The small sensor as a mat whose columns a shift register drives, with a pull-down on every row.
fn mat() -> String {
    let (head, tail) = SENSOR.split_once("topology").unwrap();
    let (_, tail) = tail.split_once("\n\n").unwrap();
    let table = "topology = \"line-ends\"\nreads = \"voltage\"\nv_test_volts = 2.0\n\
        driven.selected = { to = \"v_test\", ohms = [45, 44, 46, 45, 47, 45] }\n\
        driven.unselected = { to = \"ground\", ohms = [45, 44, 46, 45, 47, 45] }\n\
        sensed.selected = { to = \"ground\", ohms = 1000.0 }\n\
        sensed.unselected = { to = \"ground\", ohms = 1000.0 }\n";
    format!("{head}{table}\n{}", tail.replace("inverted = true\n", ""))
}

fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("mat.toml", &mat());
    folder
}

const CONDUCTANCES: &str = "1e-3,2e-3,1e-6,1e-6,5e-4,1e-6\n1e-6,1e-3,1e-3,1e-6,1e-6,1e-6\n\
    1e-6,1e-6,1e-6,1e-6,1e-6,1e-6\n2e-3,2e-3,2e-3,1e-6,1e-6,1e-3\n";

#[test]
fn it_is_scanned_and_inverted() {
    let folder = folder();
    folder.write("g.csv", CONDUCTANCES);
    folder.good("simulate --sensor mat.toml --conductance g.csv -o v.csv");
    folder
        .good("compensate v.csv --input-unit volts --sensor mat.toml --unit siemens -o again.csv");
    let (given, again) = (folder.numbers("g.csv"), folder.numbers("again.csv"));
    for (given, again) in given.iter().zip(&again) {
        assert!((given - again).abs() < 1e-6 * 1e-3, "{given} {again}");
    }
}

#[test]
fn the_netlist_has_each_end() {
    let folder = folder();
    folder.write("g.csv", CONDUCTANCES);
    let run = folder.taxel("netlist --sensor mat.toml --conductance g.csv --taxel 1,2");
    assert_eq!(run.code, Some(0), "{run}");
    for line in [
        "Vt drive 0 2",
        "Rds2_0 col2 drive 46",
        "Rdu2_0 col2 0 1e12",
        "Rds3_0 col3 drive 1e12",
        "Rdu3_0 col3 0 45",
        "Rsf1_0 row1 0 1000",
        "Rpin1 row1 out 1",
        "Rpin0 row0 out 1e12",
    ] {
        assert!(run.out.lines().any(|l| l == line), "{line}\n{run}");
    }
}

#[test]
fn calibration_finds_the_law_and_no_switch() {
    let folder = folder();
    folder.good(
        "simulate --sensor mat.toml --pattern press --frames 60 --seed 2 --presses p.csv -o p.txt",
    );
    let parts = mat();
    let (parts, _) = parts.split_once("[material]").unwrap();
    folder.write("parts.toml", parts);
    let run = folder.taxel("calibrate --sensor parts.toml --presses p.csv -o found.toml");
    assert_eq!(run.code, Some(0), "{run}");
    let said = format!("{run}");
    assert!(
        said.contains("material.factor") && !said.contains("r_mux"),
        "{run}"
    );
    let found = folder.read("found.toml");
    assert!(
        !found.contains("r_mux") && found.contains("[readout.driven.selected]"),
        "{found}"
    );
    folder.good("compensate p.txt --sensor found.toml -o loads.csv --standard-error e.csv");
}

#[test]
fn the_budget_says_what_the_table_costs() {
    let folder = folder();
    let run = folder.taxel("budget mat.toml");
    assert_eq!(run.code, Some(0), "{run}");
    assert!(run.out.contains("line-ends (columns v_test 44 to 47 Ω, else ground 44 to 47 Ω; rows ground 1000 Ω, else the same)"), "{run}");
    assert!(
        run.out.contains("\nline ends ") && !run.out.contains("switches"),
        "{run}"
    );
}

#[test]
fn a_table_of_no_board_is_refused_in_words() {
    let folder = Folder::new();
    folder.write(
        "bad.toml",
        &mat().replace("to = \"v_test\"", "to = \"ground\""),
    );
    folder.write("g.csv", CONDUCTANCES);
    insta::assert_snapshot!(folder.taxel("simulate --sensor bad.toml --conductance g.csv"), @r#"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: bad.toml: sensor file: `readout.driven.selected` never leads to V_t at column 0: nothing drives the taxels there
    hint: one end of the selected driven line must be `to = "v_test"`; where it is pulled low against rows held high, write the circuit upside down and record 2^bits - 1 less each count
    "#);
}
