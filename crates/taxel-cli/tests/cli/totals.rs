//! `calibrate --totals`: the load law by what all taxels carry together.

use std::fmt::Write;

use crate::run::{Folder, Run, SENSOR};

const TAXELS: usize = 24;

/// The small sensor's parts list, 30 frames of blobs and 5 of nothing, and a table of their totals.
fn folder() -> Folder {
    let folder = Folder::new();
    let (parts, _) = SENSOR.split_once("[material]").unwrap();
    folder.write("parts.toml", parts);
    folder.good(
        "simulate --sensor sensor.toml --pattern blobs --load-g 20,60,120,200,300,0 --frames 36 --seed 5 --truth truth.csv -o loads.npy",
    );
    folder.write("totals.csv", &table(&totals(&folder, "truth.csv")));
    folder
}

/// What each frame carries in all, grams.
fn totals(folder: &Folder, truth: &str) -> Vec<f64> {
    let loads = folder.numbers(truth);
    loads
        .chunks(TAXELS)
        .map(|frame| frame.iter().sum())
        .collect()
}

/// Six frames of a peak are a group.
fn table(totals: &[f64]) -> String {
    let mut text = "recording,frame,load_g,group\n".to_owned();
    for (frame, load) in totals.iter().enumerate() {
        let _ = writeln!(text, "loads.npy,{frame},{load:.3},{}", frame / 6);
    }
    text
}

#[test]
fn a_law_comes_out_and_sums_other_frames() {
    let folder = folder();
    let run = folder.good("calibrate --sensor parts.toml --totals totals.csv -o fit.toml");
    for words in [
        "material.exponent",
        "30 totals (30 loads",
        "6 frames of the empty sensor",
        "held-out totals (30 of 30; 5 groups, one at a time)",
        "nor single taxels",
    ] {
        assert!(run.out.contains(words), "{words}\n{run}");
    }
    let fit = folder.read("fit.toml");
    for words in ["frame_share", "exponent", "totals.csv", "30 known totals"] {
        assert!(fit.contains(words), "{words}\n{fit}");
    }
    folder.good("simulate --sensor sensor.toml --pattern blobs --load-g 150 --frames 4 --seed 9 --truth new.csv -o new.npy");
    folder.good("compensate new.npy --sensor fit.toml --unit g -o found.csv --figures figures.csv");
    let (found, truth) = (totals(&folder, "found.csv"), totals(&folder, "new.csv"));
    for (found, truth) in found.iter().zip(&truth) {
        assert!((found / truth - 1.0).abs() < 0.005, "{found} {truth}");
    }
    let json = folder.good("calibrate --sensor parts.toml --totals totals.csv --json -o fit.toml");
    let json: serde_json::Value = serde_json::from_str(&json.out).unwrap();
    assert_eq!((&json["totals"], &json["empty"]), (&30.into(), &6.into()));
    assert!(json["held_out_mean_absolute_share"].as_f64().unwrap() < 0.005);
}

#[test]
fn shuffled_totals_are_doubted_and_a_wrong_one_is_named() {
    let folder = folder();
    let good = totals(&folder, "truth.csv");
    let shuffled: Vec<f64> = (0..36)
        .map(|at| {
            if at < 30 {
                good[(at * 7 + 3) % 30]
            } else {
                0.0
            }
        })
        .collect();
    folder.write("bad.csv", &table(&shuffled));
    let run = folder.taxel("calibrate --sensor parts.toml --totals bad.csv -o fit.toml");
    assert_eq!(run.code, Some(3), "{run}");
    assert!(run.err.contains("little was learnt"), "{run}");
    let mut one = good;
    one[8] /= 1000.0;
    folder.write("bad.csv", &table(&one));
    let run = folder.taxel("calibrate --sensor parts.toml --totals bad.csv -o fit.toml");
    assert_eq!(run.code, Some(3), "{run}");
    for words in ["bad.csv, line 10", "are these kg?", "29 totals"] {
        assert!(run.to_string().contains(words), "{words}\n{run}");
    }
}

#[test]
fn what_needs_presses_is_refused() {
    let folder = folder();
    let run =
        folder.taxel("calibrate --sensor parts.toml --totals totals.csv --per-line -o fit.toml");
    insta::assert_snapshot!(run, @r"
    exit code: 2
    ----- stdout -----

    ----- stderr -----
    error: --per-line needs --presses: known totals do not tell the circuit, nor single taxels
    hint: leave it out, or label single presses
    ");
    for other in ["--presses", "--equilibration", "--pairs"] {
        let run = folder.taxel(&format!(
            "calibrate --sensor parts.toml --totals totals.csv {other} totals.csv -o fit.toml"
        ));
        assert_eq!(run.code, Some(2), "{run}");
        assert!(run.err.contains("cannot be used with"), "{run}");
    }
    let run = folder.taxel("calibrate --sensor parts.toml --totals totals.csv -o totals.toml");
    assert_eq!(run.code, Some(0), "{run}");
    let run =
        folder.fails("calibrate --sensor parts.toml --totals totals.csv --law spline -o fit.toml");
    assert!(run.err.contains("not fitted to totals"), "{run}");
    let unknown = folder
        .read("parts.toml")
        .replace("r_mux_row_ohms = 10.0\n", "");
    folder.write("unknown.toml", &unknown);
    let run = folder.fails("calibrate --sensor unknown.toml --totals totals.csv -o fit.toml");
    assert!(run.err.contains("r_mux_row_ohms"), "{run}");
    assert!(!folder.exists("fit.toml"));
}

/// Calibrates by another table of the folder's recording, which must write nothing.
fn refused(folder: &Folder, text: &str) -> Run {
    folder.write("bad.csv", text);
    let run = folder.taxel("calibrate --sensor parts.toml --totals bad.csv -o fit.toml");
    assert!(!folder.exists("fit.toml"), "{run}");
    run
}

#[test]
fn broken_tables_are_named_line_by_line() {
    let folder = folder();
    insta::assert_snapshot!(folder.taxel("calibrate --sensor parts.toml --totals none.csv -o fit.toml"), @r"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: cannot open none.csv: No such file or directory (os error 2)
    hint: check the name, and that you may read it
    ");
    insta::assert_snapshot!(refused(&folder, "recording,frame,load_g\nnone.npy,0,100\n"), @r"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: cannot open none.npy: No such file or directory (os error 2)
    hint: check the name, and that you may read it
    ");
    insta::assert_snapshot!(refused(&folder, "recording,frame,load_g\nloads.npy,0,100\nloads.npy,36,100\n"), @r"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: bad.csv, line 3: frame 36 of loads.npy, but it has 36 frames
    hint: frames are counted from 0
    ");
    insta::assert_snapshot!(refused(&folder, "recording,frame,load_g\nloads.npy,0,-3\n"), @r"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: negative load_g at bad.csv, line 2, column 13: -3, at least 0 expected
    hint: subtract no tare from a labelled load
    ");
    insta::assert_snapshot!(refused(&folder, "recording,frame,load_g\nloads.npy,0,NaN\n"), @r"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: `load_g` is `NaN` at bad.csv, line 2, column 13, but must be a finite number
    hint: a decimal point, no unit: the unit is in the column's name
    ");
}

#[test]
fn tables_that_tell_no_law_are_refused() {
    let folder = folder();
    insta::assert_snapshot!(refused(&folder, "recording,frame,load_g\nloads.npy,0,100\nloads.npy,0,120\n"), @r"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: bad.csv, lines 2 and 3: frame 0 carries 100 g and 120 g in all
    hint: a frame has one total load: remove the wrong line
    ");
    insta::assert_snapshot!(refused(&folder, "recording,frame,load_g\nloads.npy,30,0\nloads.npy,31,0\n"), @r"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: bad.csv: these totals tell no law: none of 2 totals is above 0 g
    hint: frames of the empty sensor tell what unloaded taxels conduct, and no law: put something of known weight on it
    ");
    insta::assert_snapshot!(refused(&folder, "recording,frame,total_g\nloads.npy,0,100\n"), @r"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: unknown column `total_g` at bad.csv, line 1, column 1
    hint: the columns are recording, frame, load_g, group, replicate, note
    ");
    insta::assert_snapshot!(refused(&folder, "recording,frame,load_g\nloads.npy,30,500\nloads.npy,31,700\nloads.npy,32,0\n"), @r"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: bad.csv: these totals tell no law: no power law makes these totals of what the taxels conduct: loaded frames conduct no more than empty ones
    hint: check that totals and frames are in the same order, topology, v_test_volts, resistors and `converter.inverted`
    ");
}
