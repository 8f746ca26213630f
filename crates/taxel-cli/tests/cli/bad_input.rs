//! Input that is wrong: what, where, both numbers, and a hint; and nothing written.

use crate::run::{Folder, Run, SENSOR};

/// One good frame of a 4 × 6 array.
const FRAME: &str =
    "24,25,26,27,28,29,\n34,35,36,37,38,39,\n44,45,46,47,48,49,\n54,55,56,57,58,59,\n";

fn compensate(text: &str) -> Run {
    let folder = Folder::new();
    folder.write("r.txt", text);
    let run = folder.taxel("compensate r.txt --sensor sensor.toml -o loads.csv");
    assert_eq!(
        folder.names(),
        ["r.txt", "sensor.toml"],
        "nothing is written"
    );
    run
}

#[test]
fn a_truncated_frame() {
    insta::assert_snapshot!(compensate(&format!("{FRAME}24,25,26,27,28,29,\n34,35")), @r"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: frame 1 is cut short at r.txt, line 6, column 1: 1 whole lines found, 4 expected
    hint: the recording stopped inside a frame; `--keep-going` leaves its frame out
    ");
    insta::assert_snapshot!(compensate(&format!("{FRAME}24,25,26,27,28,29,\n")), @r"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: frame 1 is cut short at r.txt, line 6, column 1: 1 whole lines found, 4 expected
    hint: the recording stopped inside a frame; `--keep-going` leaves its frame out
    ");
}

#[test]
fn another_sensors_shape_and_a_swapped_one() {
    insta::assert_snapshot!(compensate("1,2,3,\n4,5,6,\n"), @r"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: wrong number of values at r.txt, line 1, column 1: 3 found, 6 expected
    hint: the recording is of another sensor; check rows and columns in the sensor file
    ");
    insta::assert_snapshot!(compensate(&"1,2,3,4,\n".repeat(6)), @r"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: wrong number of values at r.txt, line 1, column 1: 4 found, 6 expected
    hint: rows and columns are swapped in this file; read it with `--transpose`
    ");
}

#[test]
fn words_nan_negative_and_too_large_counts() {
    insta::assert_snapshot!(compensate(&FRAME.replace("36", "open")), @r"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: not a number at r.txt, line 2, column 7: value 3 of 6 is `open`
    hint: a line is broken, or this is no recording; `--keep-going` leaves its frame out
    ");
    insta::assert_snapshot!(compensate(&FRAME.replace("36", "NaN")), @r"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: not a finite number at r.txt, line 2, column 7: value 3 of 6 is `NaN`
    hint: a reading that is missing or broken; `--keep-going` leaves its frame out
    ");
    insta::assert_snapshot!(compensate(&FRAME.replace("36", "-36")), @r"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: negative count at r.txt, line 2, column 7: -36, at least 0 expected
    hint: counts are what the converter gives, 0 and up; loads and volts are read as values
    ");
    insta::assert_snapshot!(compensate(&FRAME.replace("36", "70000")), @r"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: count above the converter's range at r.txt, line 2, column 7: 70000, at most 65535 expected
    hint: check `bits` under [converter] in the sensor file, or the recording is broken there
    ");
}

#[test]
fn an_empty_file_and_none() {
    insta::assert_snapshot!(compensate(""), @r"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: no frame in r.txt: 0 found, at least 1 expected
    hint: the file is empty or holds blank lines only; was the recording ever started?
    ");
    let folder = Folder::new();
    insta::assert_snapshot!(folder.taxel("compensate r.txt --sensor sensor.toml"), @r"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: cannot open r.txt: No such file or directory (os error 2)
    hint: check the name, and that you may read it
    ");
    insta::assert_snapshot!(folder.taxel("compensate r.xyz --sensor sensor.toml"), @"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: cannot tell the format of r.xyz from `.xyz`
    hint: recordings end in .txt, .csv, .npy, .npz, .mcap or .parquet
    ");
}

fn with_sensor(from: &str, to: &str) -> Run {
    let folder = Folder::new();
    assert!(SENSOR.contains(from));
    folder.write("bad.toml", &SENSOR.replace(from, to));
    folder.write("r.txt", FRAME);
    folder.taxel("compensate r.txt --sensor bad.toml -o loads.csv")
}

#[test]
fn an_unknown_key_and_an_unknown_topology() {
    insta::assert_snapshot!(with_sensor("r_mux_row_ohms", "r_mux_rows_ohms"), @r"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: bad.toml: sensor file, line 16: unknown key `r_mux_rows_ohms` in [readout]
    hint: did you mean `r_mux_row_ohms`? (known: topology, v_test_volts, r_feedback_ohms, open_loop_gain, r_mux_column_ohms, r_mux_row_ohms, r_source_ohms, r_line_row_ohms, r_line_column_ohms, row_end, column_end, r_pull_down_ohms, reads, driven, sensed, diode)
    ");
    insta::assert_snapshot!(with_sensor("tia-grounded-columns", "tia-grounded-column"), @r"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: bad.toml: sensor file: unknown topology `tia-grounded-column`
    hint: did you mean `tia-grounded-columns`? (known: tia-grounded-columns, tia-zero-potential, divider-grounded-columns, divider-floating, divider-voltage-feedback, divider-pulled-rows, line-ends)
    ");
}

#[test]
fn resistances_that_cannot_be() {
    insta::assert_snapshot!(with_sensor("r_feedback_ohms = 2000.0", "r_feedback_ohms = -2000.0"), @r"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: bad.toml: sensor file: `readout.r_feedback_ohms` is -2000, but must be a finite number above 0
    hint: the amplifier's feedback resistor
    ");
    insta::assert_snapshot!(with_sensor("r_mux_row_ohms = 10.0", "r_mux_row_ohms = 0.0"), @r"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: bad.toml: sensor file: `readout.r_mux_row_ohms` is 0, but must be a finite number above 0
    hint: a switch's on-resistance; a CD74HC4067 has 70, an ADG732 has 4; without the key, a calibration finds it
    ");
    insta::assert_snapshot!(with_sensor("r_mux_row_ohms = 10.0", "r_mux_row_ohms = [9.0, 10.0]"), @r"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: bad.toml: sensor file: `readout.r_mux_row_ohms` has 2 numbers, but the array has 4 rows
    hint: give one number for all, or one per row
    ");
}

#[test]
fn a_sheet_and_an_uncertainty_that_cannot_be() {
    let sheet = |ohms: &str, factor: &str| {
        let table =
            format!("\n[material.sheet]\nresistance_ohms = {ohms}\ncontact_factor = {factor}\n");
        with_sensor("exponent = 0.857\n", &format!("exponent = 0.857\n{table}"))
    };
    insta::assert_snapshot!(sheet("0.0", "3.0"), @r"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: bad.toml: sensor file: `material.sheet.resistance_ohms` is 0, but must be a finite number above 0
    hint: ohms of film between two neighbours; leave out [material.sheet] where it is cut between taxels
    ");
    insta::assert_snapshot!(sheet("12e3", "-1.0"), @r"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: bad.toml: sensor file: `material.sheet.contact_factor` is -1, but must be 0 or more
    hint: how much of a taxel's own resistance is in the way of what flows sideways; 1 to 5 is usual
    ");
    let uncertainty = |share: &str, factor: &str| {
        let table = format!(
            "\n[uncertainty]\nmodel_share = {share}\nmodel_floor_g = 0.1\nfit_share = 0.01\nfactor_95 = {factor}\npresses = 40\n"
        );
        with_sensor("exponent = 0.857\n", &format!("exponent = 0.857\n{table}"))
    };
    insta::assert_snapshot!(uncertainty("-0.1", "1.96"), @r"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: bad.toml: sensor file: `uncertainty.model_share` is -0.1, but must be 0 or more
    hint: a calibration writes it: calibrate again, or leave [uncertainty] out
    ");
    insta::assert_snapshot!(uncertainty("0.1", "0.0"), @r"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: bad.toml: sensor file: `uncertainty.factor_95` is 0, but must be a finite number above 0
    hint: 1.96 for a normal distribution
    ");
    let misspelt = with_sensor(
        "exponent = 0.857\n",
        "exponent = 0.857\n\n[material.sheet]\nresistance = 12e3\n",
    );
    insta::assert_snapshot!(misspelt, @r"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: bad.toml: sensor file, line 29: unknown key `resistance` in [material.sheet]
    hint: did you mean `resistance_ohms`? (known: resistance_ohms, contact_factor)
    ");
}

#[test]
fn a_word_for_a_number_and_a_file_that_is_missing() {
    insta::assert_snapshot!(with_sensor("bits = 16", "bits = sixteen"), @r"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: bad.toml: sensor file: TOML parse error at line 19, column 8
       |
    19 | bits = sixteen
       |        ^^^^^^^
    string values must be quoted, expected literal string
    ");
    insta::assert_snapshot!(with_sensor("exponent", "gain = \"nowhere.csv\"\nexponent"), @r"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: cannot open nowhere.csv: No such file or directory (os error 2)
    hint: check the name, and that you may read it
    ");
}

#[test]
fn a_sensor_that_is_not_there() {
    let folder = Folder::new();
    insta::assert_snapshot!(folder.taxel("bench --sensor ekone"), @r"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: no preset sensor is called `ekone`
    hint: did you mean `econe`? (known: econe, mat-16x16-cd4067, mat-32x32-adg732)
    ");
    insta::assert_snapshot!(folder.taxel("bench --sensor my/sensor.toml"), @r"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: cannot open my/sensor.toml: No such file or directory (os error 2)
    hint: a sensor is a file, or one of the presets econe, mat-16x16-cd4067, mat-32x32-adg732
    ");
}

#[test]
fn a_sensor_without_what_the_unit_needs() {
    let folder = Folder::new();
    let head = SENSOR.split("[material]").next().unwrap();
    folder.write("no-law.toml", head);
    folder.write("r.txt", FRAME);
    insta::assert_snapshot!(folder.taxel("compensate r.txt --sensor no-law.toml --unit g"), @r"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: no-law.toml: sensor file: `material` is missing
    hint: a load law makes loads of conductances; `taxel calibrate` finds one, `--unit siemens` does without
    ");
    let run = folder.taxel("compensate r.txt --sensor no-law.toml --unit siemens");
    assert_eq!(run.code, Some(0), "{run}");
    folder.write(
        "zero.toml",
        &SENSOR.replace("tia-grounded-columns", "tia-zero-potential"),
    );
    let run = folder.taxel("compensate r.txt --sensor zero.toml --method exact");
    insta::assert_snapshot!(run, @r"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: zero.toml: no method `exact` for this sensor
    hint: `exact` needs topology `tia-grounded-columns`, or a table of line ends that says the same, with r_source_ohms = 0, lines without resistance, no diodes and every reading, no converter.floor_count; `newton` does the rest of linear circuits
    ");
}

#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_is_told() {
    let folder = Folder::new();
    folder.write("r.txt", FRAME);
    insta::assert_snapshot!(folder.taxel("compensate r.txt --sensor sensor.toml -o /dev/full"), @r"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: cannot finish /dev/full after 0 bytes: No space left on device (os error 28); nothing is kept
    hint: make room, or check what reads the other end, then run again
    ");
    let run = folder.taxel("netlist --sensor sensor.toml -o /dev/full");
    assert_eq!(run.code, Some(1), "{run}");
}

/// A limit on the size of files stands for a disk that fills: what was written is kept apart, the old file is
/// as it was.
#[test]
#[cfg(target_os = "linux")]
fn a_disk_that_fills_leaves_the_old_file_untouched() {
    let folder = Folder::new();
    folder.good("simulate --sensor econe --pattern blobs --frames 4 -o r.txt");
    folder.write("loads.csv", "the old file\n");
    let script = format!(
        "trap '' XFSZ; ulimit -f 40; exec {} compensate r.txt --sensor econe -o loads.csv",
        env!("CARGO_BIN_EXE_taxel")
    );
    let output = std::process::Command::new("bash")
        .args(["-c", &script])
        .current_dir(folder.path(""))
        .output()
        .unwrap();
    let run = Run::from(output);
    assert_eq!(run.code, Some(1), "{run}");
    assert!(
        run.err.contains("error: cannot finish loads.csv after "),
        "{run}"
    );
    assert!(
        run.err
            .contains("loads.csv.partial, an older file is untouched\nhint: "),
        "{run}"
    );
    assert_eq!(folder.read("loads.csv"), "the old file\n");
    assert!(folder.exists("loads.csv.partial"));
    assert!(folder.names().iter().all(|name| !name.starts_with('.')));
}

#[test]
fn a_long_line_of_a_sensor_file_is_quoted_in_part() {
    let folder = Folder::new();
    let cells = "1.0, ".repeat(100_000);
    folder.write("s.toml", &format!("format = 1\ngain = [{cells} x]\n"));
    let run = folder.fails("budget s.toml");
    assert!(run.err.len() < 2000, "{} bytes", run.err.len());
}

#[test]
fn a_speed_at_which_nothing_would_ever_be_sent_is_refused() {
    let folder = Folder::new();
    folder.write("r.txt", "1,2,3,4,\n");
    for speed in ["5e-324", "1e9", "NaN", "-1"] {
        let words = format!("replay r.txt --sensor econe --to - --speed={speed}");
        assert_eq!(folder.fails(&words).code, Some(2), "{speed}");
    }
}

/// What to type is said where it helps, by verbs that have it.
#[test]
fn no_option_is_advised_that_does_not_help() {
    let folder = Folder::new();
    folder.write("words.txt", &"1,2,x,4,5,6,\n".repeat(8));
    let run = folder.fails("info words.txt --sensor sensor.toml");
    assert!(run.err.contains("--keep-going"), "{run}");
    let run = folder.fails("plot words.txt --sensor sensor.toml -o a.png");
    assert!(!run.err.contains("--keep-going"), "{run}");
    folder.write("semicolons.txt", &"1;2;3;4;5;6\n".repeat(8));
    let run = folder.fails("info semicolons.txt --sensor sensor.toml");
    assert!(
        run.err.contains("commas") && !run.err.contains("--keep-going"),
        "{run}"
    );
    folder
        .good("simulate --sensor sensor.toml --pattern press --frames 3 --presses p.csv -o r.mcap");
    let run = folder.fails("replay r.mcap --to udp:127.0.0.1:nowhere");
    assert!(
        run.err.contains("--to udp:127.0.0.1:nowhere") && !run.err.contains("--listen"),
        "{run}"
    );
    let run = folder.fails("compensate r.mcap --input-unit volts -o out.csv");
    assert!(run.err.contains("leave `--input-unit` out"), "{run}");
}
