//! `taxel calibrate`: the parts list and presses in, the sensor out.

use crate::run::{Folder, SENSOR};

/// The sensor as its owner knows it, and labelled presses on one whose numbers are those of `SENSOR`.
pub(crate) fn pressed(presses: usize) -> Folder {
    let folder = Folder::new();
    folder.good(&format!(
        "simulate --sensor sensor.toml --pattern press --frames {presses} --seed 8 \
         -o calibration.txt --presses experiments.csv"
    ));
    let parts: Vec<&str> = SENSOR
        .lines()
        .filter(|line| !line.contains("_mux_"))
        .collect();
    let parts = parts.join("\n");
    folder.write("parts.toml", parts.split("[material]").next().unwrap());
    folder
}

#[test]
fn presses_make_a_sensor_that_gives_the_loads_of_other_frames() {
    let folder = pressed(60);
    let run = folder.good(
        "calibrate --sensor parts.toml --presses experiments.csv -o calibrated.toml --law power",
    );
    assert!(
        run.out.contains("held-out presses (60 presses, 5 folds"),
        "{run}"
    );
    assert!(run.err.ends_with("wrote calibrated.toml\n"), "{run}");
    let text = folder.read("calibrated.toml");
    assert!(
        text.contains("[provenance]") && text.contains("experiments.csv"),
        "{text}"
    );
    folder.good(
        "simulate --sensor sensor.toml --pattern blobs --frames 4 --seed 9 --load-g 300 \
         -o validation.txt --truth truth.csv",
    );
    folder.good("compensate validation.txt --sensor calibrated.toml --unit g -o loads.csv");
    let (loads, truth) = (folder.numbers("loads.csv"), folder.numbers("truth.csv"));
    for (load, truth) in loads.iter().zip(&truth) {
        assert!((load - truth).abs() < 2.0, "{load} {truth}");
    }
}

#[test]
fn a_report_for_scripts() {
    let folder = pressed(40);
    let run = folder.good(
        "calibrate --sensor parts.toml --presses experiments.csv -o c.toml --law power --json",
    );
    assert!(run.out.contains("\"held_out_mean_absolute_g\": "), "{run}");
}

#[test]
fn presses_that_cannot_be_used_are_refused_with_their_place() {
    let folder = pressed(6);
    let calibrate = "calibrate --sensor parts.toml -o c.toml --presses";
    let table = |lines: &str| {
        folder.write(
            "bad.csv",
            &format!("recording,frame,row,column,load_g\n{lines}"),
        );
        folder.taxel(&format!("{calibrate} bad.csv"))
    };
    insta::assert_snapshot!(table("calibration.txt,0,4,0,100\n"), @r"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: taxel outside the array at bad.csv, line 2, column 19: `4,0` is row 4, column 0, but the array has 4 rows x 6 columns, counted from 0
    hint: check the label, `labels` under [array] in the sensor file, and which sensor this is
    ");
    insta::assert_snapshot!(table("calibration.txt,0,0,0,-5\n"), @r"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: negative load_g at bad.csv, line 2, column 23: -5, at least 0 expected
    hint: subtract no tare from a labelled load
    ");
    insta::assert_snapshot!(table("calibration.txt,0,1,1,100\ncalibration.txt,6,1,1,100\n"), @r"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: bad.csv, line 3: frame 6 of calibration.txt, but it has 6 frames
    hint: frames are counted from 0
    ");
    insta::assert_snapshot!(table("nowhere.txt,0,1,1,100\n"), @r"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: cannot open nowhere.txt: No such file or directory (os error 2)
    hint: check the name, and that you may read it
    ");
    insta::assert_snapshot!(table(""), @r"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: no press in bad.csv: 0 found, at least 1 expected
    hint: the file is empty or holds blank lines only; was the recording ever started?
    ");
    assert!(!folder.exists("c.toml"));
}

#[test]
fn a_label_outside_the_array_is_refused() {
    let folder = pressed(6);
    folder.write(
        "labels.csv",
        "recording,frame,taxel,load_g\ncalibration.txt,0,G1,100\n",
    );
    let run = folder.taxel("calibrate --sensor parts.toml --presses labels.csv -o c.toml");
    insta::assert_snapshot!(run, @r"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: taxel outside the array at labels.csv, line 2, column 19: `G1` is row 1, column 6, but the array has 4 rows x 6 columns, counted from 0
    hint: check the label, `labels` under [array] in the sensor file, and which sensor this is
    ");
}

#[test]
fn too_few_presses_are_no_calibration() {
    let folder = pressed(3);
    let run = folder.taxel("calibrate --sensor parts.toml --presses experiments.csv -o c.toml");
    insta::assert_snapshot!(run, @r"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: experiments.csv: 3 readable presses of 3 given, but a calibration needs at least 8
    hint: label more presses, spread over the array and the range of loads
    ");
    assert!(!folder.exists("c.toml"));
}

#[test]
fn a_press_on_a_line_declared_dead_is_refused() {
    let folder = pressed(6);
    let parts = folder.read("parts.toml");
    folder.write("dead.toml", &(parts + "\n[screen]\ndead_columns = [3]\n"));
    folder.write(
        "bad.csv",
        "recording,frame,row,column,load_g\ncalibration.txt,0,1,1,50\ncalibration.txt,1,2,3,50\n",
    );
    let run = folder.taxel("calibrate --sensor dead.toml --presses bad.csv -o c.toml");
    insta::assert_snapshot!(run, @r"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: bad.csv, line 3: a press on row 2, column 3, but the sensor file declares column 3 dead
    hint: take the press out, or the line out of [screen] in the sensor file
    ");
}

#[test]
fn presses_are_asked_for() {
    let run = Folder::new().taxel("calibrate --sensor sensor.toml -o c.toml");
    insta::assert_snapshot!(run, @r"
    exit code: 2
    ----- stdout -----

    ----- stderr -----
    error: the following required arguments were not provided:
      --presses <FILE>

    Usage: taxel calibrate --sensor <FILE|PRESET> --output <FILE> --presses <FILE>

    For more information, try '--help'.
    ");
}
