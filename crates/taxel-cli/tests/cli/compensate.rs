//! `taxel compensate` where all is well, and where frames are lost on the way.

use crate::run::{Folder, SENSOR, numbers};

/// A folder with a recording of blobs and its loads.
pub fn recorded() -> Folder {
    let folder = Folder::new();
    folder.good(
        "simulate --sensor sensor.toml --pattern blobs --frames 6 --seed 2 --load-g 300 \
         -o recording.txt --truth truth.csv",
    );
    folder
}

#[test]
fn counts_become_the_loads_behind_them() {
    let folder = recorded();
    let run = folder.taxel("compensate recording.txt --sensor sensor.toml --unit g -o loads.csv");
    insta::assert_snapshot!(run, @r"
    exit code: 0
    ----- stdout -----

    ----- stderr -----
    6 frames of 4 rows x 6 columns, method exact, [time] s, [time] frames/s
    all 6 frames converged
    taxels by mark (code): 144 good (0)
    wrote loads.csv (g)
    wrote loads.marks.csv (marks)
    ");
    let (loads, truth) = (folder.numbers("loads.csv"), folder.numbers("truth.csv"));
    assert_eq!(loads.len(), truth.len());
    for (load, truth) in loads.iter().zip(&truth) {
        assert!((load - truth).abs() < 0.5, "{load} {truth}");
    }
    assert_eq!(folder.read("loads.csv").lines().count(), 6 * 4);
    assert!(
        folder
            .numbers("loads.marks.csv")
            .iter()
            .all(|&mark| mark == 0.0)
    );
}

#[test]
fn units_are_multiples_of_each_other() {
    let folder = recorded();
    let largest = |unit: &str| {
        folder.good(&format!(
            "compensate recording.txt --sensor sensor.toml --unit {unit} -o out.csv"
        ));
        folder
            .numbers("out.csv")
            .into_iter()
            .fold(f64::MIN, f64::max)
    };
    let (grams, newtons) = (largest("g"), largest("N"));
    assert!((newtons / grams / 9.80665e-3 - 1.0).abs() < 1e-12);
    // 5 mm² a taxel, which is more than lines 2 mm apart leave it.
    assert!((largest("kPa") / newtons / 200.0 - 1.0).abs() < 1e-12);
    assert!((largest("MPa") / newtons / 0.2 - 1.0).abs() < 1e-12);
    assert!(largest("siemens") < 0.01);
    assert!(largest("volts") < 0.01);
    for command in ["compensate", "plot"] {
        for (unit, warns) in [("kPa", true), ("N", false)] {
            let file = if command == "plot" {
                "out.svg"
            } else {
                "out.csv"
            };
            let run = folder.good(&format!(
                "{command} recording.txt --sensor sensor.toml --unit {unit} -o {file}"
            ));
            assert_eq!(
                run.err.contains("pressures are 20 % too low"),
                warns,
                "{run}"
            );
        }
    }
}

#[test]
fn stages_can_be_done_one_by_one() {
    let folder = recorded();
    folder.good("compensate recording.txt --sensor sensor.toml --unit volts -o v.csv");
    folder.good("compensate v.csv --input-unit volts --sensor sensor.toml --unit siemens -o g.npy");
    folder.good("compensate g.npy --input-unit siemens --sensor sensor.toml --unit g -o a.csv");
    folder.good("compensate recording.txt --sensor sensor.toml --unit g -o b.csv");
    let (a, b) = (folder.numbers("a.csv"), folder.numbers("b.csv"));
    // Counts are solved to a tenth of what rounding hides, volts to 1e-9; measured: 1.2e-4 g of 211 g.
    for (a, b) in a.iter().zip(&b) {
        assert!((a - b).abs() < 1.5e-4, "{a} {b}");
    }
}

#[test]
fn without_a_file_numbers_go_to_standard_output_and_marks_where_asked() {
    let folder = recorded();
    let run = folder.good("compensate recording.txt --sensor sensor.toml --marks m.npy");
    assert_eq!(numbers(&run.out).len(), 6 * 24);
    assert!(run.err.contains("wrote m.npy (marks)"), "{run}");
    // The same from a pipe.
    let text = folder.read("recording.txt");
    let piped = folder.taxel_with("compensate - --sensor sensor.toml", &text);
    assert_eq!(piped.code, Some(0));
    assert_eq!(piped.out, run.out);
}

#[test]
fn a_summary_for_scripts() {
    let folder = recorded();
    let run = folder
        .taxel("compensate recording.txt --sensor sensor.toml -o loads.csv --json --method raw");
    insta::assert_snapshot!(run, @r#"
    exit code: 0
    ----- stdout -----
    {
      "recording": "recording.txt",
      "sensor": "sensor.toml",
      "rows": 4,
      "columns": 6,
      "unit": "g",
      "method": "raw",
      "seconds": [time],
      "frames_per_second": [time],
      "frames": 6,
      "stops": {
        "direct": 6
      },
      "ambiguous_frames": 0,
      "unsolved": [],
      "skipped_frames": 0,
      "skipped": [],
      "missing": [],
      "measured_share": 1.0,
      "loads_below_nothing": false,
      "marks": {
        "good": 144
      },
      "mark_codes": {
        "0": "good",
        "1": "open",
        "2": "saturated",
        "3": "stuck",
        "4": "spike",
        "5": "flickering",
        "6": "shorted",
        "7": "interpolated",
        "8": "unresolved",
        "9": "unfamiliar",
        "10": "absent",
        "11": "below-floor"
      },
      "faulty_lines": [],
      "output": "loads.csv",
      "marks_output": "loads.marks.csv",
      "standard_error_output": null,
      "interval_output": null,
      "figures_output": null
    }
    ----- stderr -----
    "#);
    let both = folder.taxel("compensate recording.txt --sensor sensor.toml -o - --json");
    assert_eq!(both.code, Some(2), "{both}");
}

#[test]
fn standard_errors_are_those_of_the_noise() {
    let folder = recorded();
    let run = folder.good(
        "compensate recording.txt --sensor sensor.toml --unit siemens -o g.csv --standard-error e.csv",
    );
    assert!(run.err.contains("standard errors from"), "{run}");
    let errors = folder.numbers("e.csv");
    assert_eq!(errors.len(), 6 * 24);
    assert!(
        errors.iter().all(|&e| (1e-9..1e-5).contains(&e)),
        "{errors:?}"
    );
}

#[test]
fn a_sensor_that_cannot_resolve_anything_says_so() {
    let folder = recorded();
    folder.write(
        "noisy.toml",
        &SENSOR.replace("inverted", "noise_counts = 20000.0\ninverted"),
    );
    folder.good(
        "compensate recording.txt --sensor noisy.toml --unit g -o l.csv --standard-error e.csv",
    );
    assert!(folder.numbers("l.marks.csv").contains(&8.0));
}

#[test]
fn a_swapped_recording_is_read_with_transpose() {
    let folder = recorded();
    let text = folder.read("recording.txt");
    let lines: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
    let mut swapped = String::new();
    for frame in lines.chunks(4) {
        for column in 0..6 {
            let cells: Vec<&str> = frame.iter().map(|row| row[column]).collect();
            swapped += &format!("{},\n", cells.join(","));
        }
    }
    folder.write("swapped.txt", &swapped);
    folder.good("compensate recording.txt --sensor sensor.toml -o a.csv");
    folder.good("compensate swapped.txt --sensor sensor.toml -o b.csv --transpose");
    assert_eq!(folder.read("a.csv"), folder.read("b.csv"));
}

#[test]
fn a_preset_is_a_sensor() {
    let folder = Folder::new();
    folder.good("simulate --sensor mat-16x16-cd4067 --pattern fingers -o f.npy");
    let run = folder.taxel("compensate f.npy --sensor mat-16x16-cd4067 -o loads.npz");
    assert_eq!(run.code, Some(0), "{run}");
    assert!(folder.exists("loads.npz") && folder.exists("loads.marks.csv"));
}

#[test]
fn gains_in_a_file_beside_the_sensor_are_read_in() {
    let folder = recorded();
    folder.write(
        "double.toml",
        &SENSOR.replace("exponent", "gain = \"gain.csv\"\nexponent"),
    );
    folder.write("gain.csv", &"2,2,2,2,2,2\n".repeat(4));
    folder.good("compensate recording.txt --sensor double.toml --unit siemens -o g.csv");
    folder.good("compensate recording.txt --sensor double.toml -o half.csv");
    folder.good("compensate recording.txt --sensor sensor.toml -o whole.csv");
    let largest = |name| folder.numbers(name).into_iter().fold(0.0, f64::max);
    // G − g_zero = gain · factor · load^exponent.
    let expected = 2f64.powf(-1.0 / 0.857);
    assert!((largest("half.csv") / largest("whole.csv") / expected - 1.0).abs() < 1e-9);
    folder.write("gain.csv", &"2,2,2,2,2,2\n".repeat(5));
    let run = folder.taxel("compensate recording.txt --sensor double.toml -o half.csv");
    insta::assert_snapshot!(run, @r"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: gain.csv: 5 lines or more, but the array has 4 rows
    hint: a file of per-taxel numbers has one line per row
    ");
}

#[test]
fn keep_going_leaves_out_what_cannot_be_read_and_exits_3() {
    let folder = recorded();
    let text = folder.read("recording.txt");
    let mut lines: Vec<&str> = text.lines().collect();
    lines[9] = "1,2,three,4,5,6,";
    lines.pop();
    folder.write("broken.txt", &(lines.join("\n") + "\n"));
    let run = folder.taxel("compensate broken.txt --sensor sensor.toml -o l.csv --keep-going");
    insta::assert_snapshot!(run, @r"
    exit code: 3
    ----- stdout -----

    ----- stderr -----
    warning: frame 2 left out: not a number at broken.txt, line 10, column 5: value 3 of 6 is `three`
    hint: a line is broken, or this is no recording
    warning: frame 5 left out: frame 5 is cut short at broken.txt, line 24, column 1: 3 whole lines found, 4 expected
    hint: the recording stopped inside a frame
    4 frames of 4 rows x 6 columns, method exact, [time] s, [time] frames/s
    all 4 frames converged
    2 frames left out
    taxels by mark (code): 96 good (0)
    wrote l.csv (g)
    wrote l.marks.csv (marks)
    ");
    assert_eq!(folder.read("l.csv").lines().count(), 4 * 4);
}

#[test]
fn a_frame_that_no_circuit_explains_is_written_as_0_and_exits_3() {
    let folder = recorded();
    folder.good("compensate recording.txt --sensor sensor.toml --unit volts -o v.csv");
    folder.write(
        "wrong.toml",
        &SENSOR.replace("_ohms = 10.0", "_ohms = 4000.0"),
    );
    let run = folder
        .taxel("compensate v.csv --input-unit volts --sensor wrong.toml --unit siemens -o g.csv");
    insta::assert_snapshot!(run, @r"
    exit code: 3
    ----- stdout -----

    ----- stderr -----
    warning: frame 0: infeasible: no conductances explain this frame: r_mux_row_ohms (with r_feedback_ohms/(1 + open_loop_gain) or r_pull_down_ohms) is 4000.0200 Ohm, but row 0 allows less than 559.8522 Ohm
    hint: r_mux_row_ohms (with r_feedback_ohms/(1 + open_loop_gain) or r_pull_down_ohms) is too large, or v_test_volts, the feedback or pull-down resistor, or full_scale_volts is wrong; calibrate the sensor
    warning: frame 1: infeasible: no conductances explain this frame: r_mux_row_ohms (with r_feedback_ohms/(1 + open_loop_gain) or r_pull_down_ohms) is 4000.0200 Ohm, but row 0 allows less than 713.7282 Ohm
    hint: r_mux_row_ohms (with r_feedback_ohms/(1 + open_loop_gain) or r_pull_down_ohms) is too large, or v_test_volts, the feedback or pull-down resistor, or full_scale_volts is wrong; calibrate the sensor
    warning: frame 2: infeasible: no conductances explain this frame: r_mux_row_ohms (with r_feedback_ohms/(1 + open_loop_gain) or r_pull_down_ohms) is 4000.0200 Ohm, but row 0 allows less than 384.1116 Ohm
    hint: r_mux_row_ohms (with r_feedback_ohms/(1 + open_loop_gain) or r_pull_down_ohms) is too large, or v_test_volts, the feedback or pull-down resistor, or full_scale_volts is wrong; calibrate the sensor
    warning: frame 3: infeasible: no conductances explain this frame: r_mux_row_ohms (with r_feedback_ohms/(1 + open_loop_gain) or r_pull_down_ohms) is 4000.0200 Ohm, but row 0 allows less than 574.3576 Ohm
    hint: r_mux_row_ohms (with r_feedback_ohms/(1 + open_loop_gain) or r_pull_down_ohms) is too large, or v_test_volts, the feedback or pull-down resistor, or full_scale_volts is wrong; calibrate the sensor
    warning: frame 4: infeasible: no conductances explain this frame: r_mux_row_ohms (with r_feedback_ohms/(1 + open_loop_gain) or r_pull_down_ohms) is 4000.0200 Ohm, but row 0 allows less than 349.8851 Ohm
    hint: r_mux_row_ohms (with r_feedback_ohms/(1 + open_loop_gain) or r_pull_down_ohms) is too large, or v_test_volts, the feedback or pull-down resistor, or full_scale_volts is wrong; calibrate the sensor
    warning: frame 5: infeasible: no conductances explain this frame: r_mux_row_ohms (with r_feedback_ohms/(1 + open_loop_gain) or r_pull_down_ohms) is 4000.0200 Ohm, but row 0 allows less than 450.0429 Ohm
    hint: r_mux_row_ohms (with r_feedback_ohms/(1 + open_loop_gain) or r_pull_down_ohms) is too large, or v_test_volts, the feedback or pull-down resistor, or full_scale_volts is wrong; calibrate the sensor
    6 frames of 4 rows x 6 columns, method exact, [time] s, [time] frames/s
    inverse: 6 infeasible
    6 frames without an answer
    no taxel of any frame was measured
    hint: does the sensor file belong to this recording? (`converter.inverted`, `bits`, `full_scale_volts`; rows and columns swapped?)
    taxels by mark (code): 144 unresolved (8)
    wrote g.csv (siemens)
    wrote g.marks.csv (marks)
    ");
    let (values, marks) = (folder.numbers("g.csv"), folder.numbers("g.marks.csv"));
    assert_eq!(values.len(), 6 * 24);
    for frame in 0..6 {
        let range = frame * 24..(frame + 1) * 24;
        let zero = values[range.clone()].iter().all(|&g| g == 0.0);
        let unresolved = marks[range].iter().all(|&mark| mark == 8.0);
        assert_eq!(zero, unresolved);
    }
}

#[test]
fn lines_that_the_sensor_file_calls_dead_are_marked_and_repaired_on_request() {
    let folder = recorded();
    folder.write(
        "dead.toml",
        &(SENSOR.to_owned() + "\n[screen]\ndead_rows = [1]\n"),
    );
    let run = folder.taxel("compensate recording.txt --sensor dead.toml -o l.csv");
    insta::assert_snapshot!(run, @r"
    exit code: 0
    ----- stdout -----

    ----- stderr -----
    faulty line: row 1 is dead: the sensor file says so
    6 frames of 4 rows x 6 columns, method exact, [time] s, [time] frames/s
    all 6 frames converged
    75.0 % of the area measured; the rest is missing from sums
    taxels by mark (code): 108 good (0), 36 open (1)
    wrote l.csv (g)
    wrote l.marks.csv (marks)
    ");
    let marks = folder.numbers("l.marks.csv");
    assert!(marks[6..12].iter().all(|&mark| mark == 1.0));
    assert!(
        folder.numbers("l.csv")[6..12]
            .iter()
            .all(|&load| load == 0.0)
    );
    folder.good("compensate recording.txt --sensor dead.toml -o l.csv --repair");
    assert!(
        folder.numbers("l.marks.csv")[6..12]
            .iter()
            .all(|&mark| mark == 7.0)
    );
}

#[test]
fn units_only_go_forwards() {
    let folder = Folder::new();
    let run = folder
        .taxel("compensate g.csv --input-unit siemens --sensor sensor.toml --unit volts -o v.csv");
    insta::assert_snapshot!(run, @r"
    exit code: 2
    ----- stdout -----

    ----- stderr -----
    error: --unit volts comes before or at the input's unit
    hint: counts become volts, volts siemens, siemens loads; `taxel simulate --conductance` goes back
    ");
}

#[test]
#[cfg(unix)]
fn a_reader_that_has_seen_enough_is_no_error() {
    let folder = Folder::new();
    folder.good("simulate --sensor econe --pattern hand --frames 20 -o hand.txt");
    let script = format!(
        "{} compensate hand.txt --sensor econe --method raw | head -n 1 >/dev/null; exit ${{PIPESTATUS[0]}}",
        env!("CARGO_BIN_EXE_taxel")
    );
    let status = std::process::Command::new("bash")
        .args(["-c", &script])
        .current_dir(folder.path(""))
        .stderr(std::process::Stdio::null())
        .status()
        .unwrap();
    assert_eq!(status.code(), Some(0));
}

/// A taxel pressed beyond the converter in every frame, and a dead line: nothing bounds these from above, or at all.
#[test]
fn what_nothing_bounds_has_an_infinite_standard_error_from_the_first_frame_on() {
    let folder = Folder::new();
    let mut frame = String::new();
    for row in 0..4 {
        let counts = (0..6).map(|column| match (row, column) {
            (1, 2) => "65535".to_owned(),
            _ => (30 + row + column).to_string(),
        });
        frame += &(counts.collect::<Vec<_>>().join(",") + "\n");
    }
    folder.write("run.txt", &frame.repeat(3));
    folder.write(
        "dead.toml",
        &format!("{SENSOR}\n[screen]\ndead_rows = [3]\n"),
    );
    for file in ["se.csv", "se.npy", "se.npz"] {
        let words =
            format!("compensate run.txt --sensor dead.toml -o a.csv --standard-error {file}");
        let run = folder.good(&words);
        assert!(run.err.contains("3 saturated (2)"), "{run}");
        std::fs::remove_file(folder.path("a.csv")).unwrap();
    }
    let text = folder.read("se.csv");
    for (line, text) in text.lines().enumerate() {
        let unbounded: Vec<bool> = text.split(',').map(|number| number == "inf").collect();
        let expected: Vec<bool> = (0..6)
            .map(|column| line % 4 == 3 || (line % 4, column) == (1, 2))
            .collect();
        assert_eq!(unbounded, expected, "line {line}: {text}");
    }
    // No load is ever infinite, and the file is not taken for one of loads.
    let run = folder.fails("plot se.csv --sensor dead.toml --values -o a.png");
    assert!(run.err.contains("not a finite number"), "{run}");
}

#[test]
fn loads_below_nothing_are_told_with_the_key_to_look_at() {
    let folder = recorded();
    folder.write(
        "wrong.toml",
        &SENSOR.replace("inverted = true", "inverted = false"),
    );
    let run = folder.taxel("compensate recording.txt --sensor wrong.toml -o a.csv");
    assert_eq!(run.code, Some(3), "{run}");
    assert!(
        run.err.contains("nearly all loads lie below nothing"),
        "{run}"
    );
    assert!(run.err.contains("converter.inverted"), "{run}");
    folder
        .good("simulate --sensor sensor.toml --pattern uniform --load-g 0 --frames 6 -o empty.txt");
    folder.good("compensate empty.txt --sensor sensor.toml -o b.csv");
}
