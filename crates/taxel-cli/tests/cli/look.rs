//! `taxel info`, `plot`, `netlist`, `bench`: looking at recordings, sensors and machines.

use std::fs;

use crate::run::{Folder, SENSOR};
use crate::simulate::CONDUCTANCES;

fn recorded() -> Folder {
    let folder = Folder::new();
    folder.good(
        "simulate --sensor sensor.toml --pattern blobs --frames 12 --seed 4 --load-g 200 \
         -o recording.txt --truth truth.csv",
    );
    folder
}

#[test]
#[expect(clippy::too_many_lines, reason = "a table of cases")]
fn info_with_a_sensor_screens_the_recording() {
    insta::assert_snapshot!(recorded().taxel("info recording.txt --sensor sensor.toml"), @r"
    exit code: 0
    ----- stdout -----
    recording.txt  1557 bytes
    12 frames of 4 rows x 6 columns
    values 18 to 17422, mean 8268.138889
    baseline 27.2 counts, noise 0.52 counts
    outliers 0.00 % (0 readings)
    no line fault
    ----- stderr -----
    ");
    insta::assert_snapshot!(recorded().taxel("info recording.txt --sensor sensor.toml --json"), @r#"
    exit code: 0
    ----- stdout -----
    {
      "file": "recording.txt",
      "bytes": 1557,
      "sensor": "sensor.toml",
      "rows": 4,
      "columns": 6,
      "frames": 12,
      "lines": 48,
      "least": 18.0,
      "most": 17422.0,
      "mean": 8268.138888888889,
      "assumed_bits": null,
      "duration_secs": null,
      "frames_per_second": [time],
      "baseline_counts": 27.2,
      "noise_counts": 0.5189107764769602,
      "outlier_share": 0.0,
      "marks": {
        "good": 288
      },
      "outside_mask_share": null,
      "faulty_lines": [],
      "events": [],
      "skipped_frames": 0,
      "skipped": [],
      "integrity": {
        "damage": {
          "chunks": 0,
          "frames": 0,
          "surplus": 0,
          "records": 0,
          "bytes": 0,
          "checksum": false,
          "cut": false
        },
        "gaps": {
          "missing": 0,
          "places": 0,
          "first": null,
          "restarts": 0
        },
        "times": {
          "missing": 0,
          "places": 0,
          "first": null,
          "repeated": 0
        },
        "losses": {
          "lost": 0,
          "corrupt": 0,
          "restarts": 0,
          "outages": 0,
          "skipped": 0,
          "left_out": 0,
          "other_senders": 0
        }
      },
      "missing": []
    }
    ----- stderr -----
    "#);
}

#[test]
fn info_without_a_sensor_says_what_the_file_tells() {
    let folder = recorded();
    insta::assert_snapshot!(folder.taxel("info recording.txt"), @r"
    exit code: 0
    ----- stdout -----
    recording.txt  1557 bytes
    48 lines of 6 columns; how many make a frame is not in the file
    hint: give --rows or --sensor, to have it screened
    values 18 to 17422, mean 8268.138889
    converter of 16 bits assumed; a sensor file would say
    ----- stderr -----
    ");
    insta::assert_snapshot!(folder.taxel("info truth.csv --values --rows 4"), @r"
    exit code: 0
    ----- stdout -----
    truth.csv  4934 bytes
    12 frames of 4 rows x 6 columns
    values 0 to 194.36967544951042, mean 83.153037
    ----- stderr -----
    ");
    folder
        .good("simulate --sensor sensor.toml --pattern hand --frames 3 --period 0.1 -o timed.csv");
    insta::assert_snapshot!(folder.taxel("info timed.csv"), @r"
    exit code: 0
    ----- stdout -----
    timed.csv  268 bytes
    3 frames of 4 rows x 6 columns
    values 18 to 30, mean 23.694444
    converter of 8 bits assumed; a sensor file would say
    [time] s, [time] frames/s
    baseline 23.9 counts, noise 4.15 counts
    outliers 0.00 % (0 readings)
    no line fault
    ----- stderr -----
    ");
    folder.good("simulate --sensor sensor.toml --pattern hand --frames 3 -o array.npy");
    insta::assert_snapshot!(folder.taxel("info array.npy"), @r"
    exit code: 0
    ----- stdout -----
    array.npy  336 bytes
    3 frames of 4 rows x 6 columns
    values 18 to 30, mean 23.694444
    converter of 8 bits assumed; a sensor file would say
    baseline 23.9 counts, noise 4.15 counts
    outliers 0.00 % (0 readings)
    no line fault
    ----- stderr -----
    ");
}

#[test]
fn info_reads_a_pipe_once() {
    let folder = recorded();
    let run = folder.taxel_with("info - --sensor sensor.toml", &folder.read("recording.txt"));
    let of_file = folder.taxel("info recording.txt --sensor sensor.toml");
    assert_eq!(run.code, Some(0), "{run}");
    let rest = |text: &str| text.split_once('\n').unwrap().1.to_owned();
    assert_eq!(rest(&run.out), rest(&of_file.out));
}

#[test]
fn info_exits_3_when_frames_are_left_out() {
    let folder = recorded();
    folder.write(
        "cut.txt",
        &(folder.read("recording.txt") + "1,2,3,4,5,6,\n"),
    );
    let run = folder.taxel("info cut.txt --sensor sensor.toml --keep-going");
    insta::assert_snapshot!(run, @r"
    exit code: 3
    ----- stdout -----
    cut.txt  1570 bytes
    12 frames of 4 rows x 6 columns
    values 18 to 17422, mean 8268.138889
    1 frames left out
    baseline 27.2 counts, noise 0.52 counts
    outliers 0.00 % (0 readings)
    no line fault
    ----- stderr -----
    warning: frame 12 left out: frame 12 is cut short at cut.txt, line 50, column 1: 1 whole lines found, 4 expected
    hint: the recording stopped inside a frame
    ");
}

#[test]
fn pictures_of_frames_and_of_values_over_frames() {
    let folder = recorded();
    let plot = |words: &str| {
        let run = folder.good(&format!("plot {words}"));
        assert!(run.err.starts_with("wrote p."), "{run}");
    };
    plot("recording.txt --sensor sensor.toml -o p.png");
    assert!(
        fs::read(folder.path("p.png"))
            .unwrap()
            .starts_with(b"\x89PNG")
    );
    let svg = |words: &str| {
        plot(&format!("{words} -o p.svg"));
        folder.read("p.svg")
    };
    let both = svg("recording.txt --sensor sensor.toml --frame 3");
    assert!(both.contains("frame 3, as read") && both.contains("frame 3, cross-talk removed"));
    let raw = svg("recording.txt --sensor sensor.toml --frame 3 --raw --unit volts");
    assert!(raw.contains("voltage") && !raw.contains("cross-talk"));
    let sheet = svg("recording.txt --sensor sensor.toml --frames 2..=5 --interpolation nearest");
    assert!(sheet.contains("frame 5") && !sheet.contains("frame 6"));
    let pairs = svg("recording.txt --sensor sensor.toml --frames 2..4 --before-after --unit N");
    assert!(pairs.contains("load (") && pairs.contains("frame 3, as read"));
    let taxel = svg("recording.txt --sensor sensor.toml --taxel 1,2 --taxel 3,3");
    assert!(taxel.contains("row 1, column 2") && taxel.contains("row 3, column 3"));
    assert!(svg("recording.txt --sensor sensor.toml --row 1").contains("row 1"));
    assert!(svg("recording.txt --sensor sensor.toml --column 5 --raw").contains("column 5"));
    let values = svg("truth.csv --values --rows 4 --unit g");
    assert!(values.contains("load (g)") || values.contains("load"));
}

#[test]
fn plot_refuses_what_is_not_there() {
    let folder = recorded();
    let sensor = "plot recording.txt --sensor sensor.toml";
    insta::assert_snapshot!(folder.taxel(&format!("{sensor} --frame 12 -o p.png")), @r"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: --frame: frame 12 of recording.txt, but it has 12 frames
    hint: frames are counted from 0
    ");
    insta::assert_snapshot!(folder.taxel(&format!("{sensor} --taxel 4,0 -o p.png")), @r"
    exit code: 2
    ----- stdout -----

    ----- stderr -----
    error: --taxel: row 4, column 0 is outside of the array of 4 rows x 6 columns
    hint: rows and columns are counted from 0
    ");
    insta::assert_snapshot!(folder.taxel(&format!("{sensor} -o p.jpg")), @r"
    exit code: 2
    ----- stdout -----

    ----- stderr -----
    error: no picture format has the extension `jpg`
    hint: known are png, svg, pdf, gif
    ");
    insta::assert_snapshot!(folder.taxel("plot truth.csv --values -o p.png"), @r"
    exit code: 2
    ----- stdout -----

    ----- stderr -----
    error: truth.csv does not say how many rows a frame has
    hint: give --sensor or --rows
    ");
}

#[test]
fn a_netlist_of_one_taxel_and_of_a_scan() {
    let folder = recorded();
    folder.write("g.csv", CONDUCTANCES);
    let run = folder.good("netlist --sensor sensor.toml --conductance g.csv --taxel 1,1");
    assert!(run.out.contains("Rt1_1 col1 row1 1000"), "{run}");
    let run = folder.taxel("netlist --sensor sensor.toml --scan recording.txt --frame 2 -o n.cir");
    insta::assert_snapshot!(run, @r"
    exit code: 0
    ----- stdout -----

    ----- stderr -----
    wrote n.cir
    ");
    let text = folder.read("n.cir");
    assert!(text.contains("Rt3_5") && text.contains("*#"), "{text}");
    let run = folder.taxel("netlist --sensor sensor.toml --taxel 4,0");
    insta::assert_snapshot!(run, @r"
    exit code: 2
    ----- stdout -----

    ----- stderr -----
    error: --taxel: row 4, column 0 is outside of the array of 4 rows x 6 columns
    hint: rows and columns are counted from 0
    ");
}

#[test]
fn bench_gives_the_keys_that_scripts_read() {
    let folder = Folder::new();
    let run = folder.good("bench --sensor sensor.toml --json");
    for key in ["sensor", "rows", "columns", "method", "frames_per_second"] {
        assert!(run.out.contains(&format!("\"{key}\": ")), "{run}");
    }
    for key in ["scan_us", "inverse_cold_us", "inverse_warm_us"] {
        assert!(
            run.out.contains(&format!("\"{key}\": {{\n    \"min\": ")),
            "{run}"
        );
    }
    folder.write(
        "unknown.toml",
        &SENSOR.replace("r_mux_row_ohms = 10.0\n", ""),
    );
    insta::assert_snapshot!(folder.taxel("bench --sensor unknown.toml"), @r"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: unknown.toml: sensor file: `readout.r_mux_row_ohms` is missing
    hint: calibrate the sensor, or take the switch's on-resistance from its data sheet
    ");
}

#[test]
#[ignore = "fits a whole e-Cone: half a minute without optimisation"]
fn demo_shows_the_whole_chain_and_leaves_a_picture() {
    let folder = Folder::new();
    let run = folder.good("demo");
    for word in [
        "screened: column",
        "calibrated: readout.",
        "raw",
        "one curve",
        "exact",
    ] {
        assert!(run.out.contains(word), "{run}");
    }
    let picture = fs::read(folder.path("taxel-demo.png")).unwrap();
    assert!(picture.starts_with(b"\x89PNG"));
}
