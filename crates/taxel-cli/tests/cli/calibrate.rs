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
        run.out.contains(
            "held-out presses (60 of 60 presses; 5 folds, split by press; each judged by a fit"
        ),
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
    let worst = loads.iter().zip(&truth).map(|(a, b)| (a - b).abs());
    let worst = worst.fold(0.0, f64::max);
    assert!(worst < 0.14, "{worst}");
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
fn residuals_of_held_out_presses_are_written_and_drawn() {
    let folder = pressed(40);
    let run = folder.good(
        "calibrate --sensor parts.toml --presses experiments.csv -o c.toml --law power --residuals r.csv --picture p.svg",
    );
    assert!(run.err.contains("wrote r.csv\nwrote p.svg\n"), "{run}");
    let text = folder.read("r.csv");
    let mut lines = text.lines();
    assert_eq!(
        lines.next(),
        Some(
            "recording,frame,row,column,load_g,estimate_g,residual_g,standard_error_g,half_width_95_g,held_out"
        )
    );
    let rows: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
    let number = |cell: &str| cell.parse::<f64>().unwrap();
    let held_out: Vec<_> = rows.iter().filter(|row| row[9] == "yes").collect();
    assert_eq!((held_out.len(), rows.len()), (40, 80));
    let labels = folder.read("experiments.csv");
    for row in &held_out {
        // The table's own label, found by its frame.
        let label = labels.lines().nth(1 + row[1].parse::<usize>().unwrap());
        let label: Vec<&str> = label.unwrap().split(',').collect();
        assert_eq!(row[2..4], label[2..4]);
        assert!((number(row[4]) - number(label[4])).abs() < 1e-9);
        assert!((number(row[5]) - number(row[4]) - number(row[6])).abs() < 2e-4);
    }
    // As many as the stated factor holds by its making: 95 % of 41.
    let inside = held_out
        .iter()
        .filter(|row| number(row[6]).abs() <= number(row[8]));
    assert!(inside.count() >= 38, "{text}");
    let picture = folder.read("p.svg");
    for said in [
        "What presses read",
        "held-out presses are outside",
        "Gain of each taxel",
        "load (g)",
    ] {
        assert!(picture.contains(said), "{said}");
    }
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

    Usage: taxel calibrate --output <FILE> --sensor <FILE|PRESET> --presses <FILE>

    For more information, try '--help'.
    ");
}

/// Presses made one at a time on the little sensor, one a taxel, and the parts list.
fn alone() -> (Folder, Vec<String>) {
    let folder = pressed(1);
    let (rows, columns) = (4, 6);
    let mut siemens = String::new();
    let mut table = vec!["recording,frame,row,column,load_g".to_owned()];
    for frame in 0..rows * columns {
        let load = 20.0 + 24.0 * f64::from((frame * 7) % (rows * columns));
        for row in 0..rows {
            let cell = |column| {
                if row * columns + column == frame {
                    (1e-6 + 8.29e-6 * load.powf(0.857)).to_string()
                } else {
                    "1e-6".to_owned()
                }
            };
            let line: Vec<String> = (0..columns).map(cell).collect();
            siemens.push_str(&(line.join(",") + "\n"));
        }
        let (row, column) = (frame / columns, frame % columns);
        table.push(format!("alone.txt,{frame},{row},{column},{load}"));
    }
    folder.write("siemens.csv", &siemens);
    folder
        .good("simulate --sensor sensor.toml --conductance siemens.csv --unit counts -o alone.txt");
    let mut noise = Noise(7);
    let counts: Vec<String> = folder
        .read("alone.txt")
        .lines()
        .map(|line| {
            let cells = line.split_inclusive(',').map(|cell| {
                match cell.trim_end_matches(',').trim().parse::<f64>() {
                    Ok(count) => format!("{},", (count + noise.next(3.0)).round().max(0.0)),
                    Err(_) => cell.to_owned(),
                }
            });
            cells.collect()
        })
        .collect();
    folder.write("alone.txt", &(counts.join("\n") + "\n"));
    (folder, table)
}

/// Nearly normal numbers by seed: twelve uniform ones of a linear congruence (Knuth's MMIX) less six.
struct Noise(u64);

impl Noise {
    fn next(&mut self, standard_deviation: f64) -> f64 {
        let uniform = (0..12).map(|_| {
            self.0 = self
                .0
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (self.0 >> 11) as f64 / (1u64 << 53) as f64
        });
        standard_deviation * (uniform.sum::<f64>() - 6.0)
    }
}

#[test]
fn presses_made_one_at_a_time_make_a_sensor_for_crowded_frames() {
    let (folder, table) = alone();
    folder.write("alone.csv", &(table.join("\n") + "\n"));
    let run = folder.good("calibrate --sensor parts.toml --presses alone.csv -o c.toml");
    assert!(run.out.contains("24 presses made one at a time"), "{run}");
    assert!(run.out.contains("tell their sum"), "{run}");
    folder.good(
        "simulate --sensor sensor.toml --pattern blobs --frames 4 --seed 9 --load-g 300 \
         -o validation.txt --truth truth.csv",
    );
    folder.good("compensate validation.txt --sensor c.toml --unit g -o loads.csv");
    let (loads, truth) = (folder.numbers("loads.csv"), folder.numbers("truth.csv"));
    let off: f64 = loads.iter().zip(&truth).map(|(a, b)| (a - b).abs()).sum();
    let off = off / loads.len() as f64;
    assert!(off < 0.35, "{off}");
}

#[test]
fn a_label_in_kilograms_is_named_by_its_line_and_left_out() {
    let (folder, mut table) = alone();
    let line = &mut table[12];
    let load = line.rsplit(',').next().unwrap().parse::<f64>().unwrap();
    *line = line.replace(&format!(",{load}"), &format!(",{}", load / 1000.0));
    folder.write("kg.csv", &(table.join("\n") + "\n"));
    let run = folder.taxel("calibrate --sensor parts.toml --presses kg.csv -o c.toml");
    assert_eq!(run.code, Some(3), "{run}");
    assert!(run.err.contains("kg.csv, line 13: "), "{run}");
    assert!(run.err.contains("are these kg?"), "{run}");
    assert!(folder.exists("c.toml"));
}

#[test]
fn two_loads_for_one_press_are_refused_with_both_lines() {
    let (folder, mut table) = alone();
    let twice = table[3].rsplit_once(',').unwrap().0.to_owned() + ",99";
    table.push(twice);
    folder.write("two.csv", &(table.join("\n") + "\n"));
    let run = folder.taxel("calibrate --sensor parts.toml --presses two.csv -o c.toml");
    assert_eq!(run.code, Some(1), "{run}");
    assert!(
        run.err
            .contains("two.csv, lines 4 and 26: row 0, column 2 of frame 2"),
        "{run}"
    );
    assert!(!folder.exists("c.toml"));
}

#[test]
fn a_sensor_file_whose_knots_do_not_ascend_is_refused() {
    let folder = pressed(1);
    let bent =
        format!("{SENSOR}\n[material.bend]\nln_load_g = [3.0, 3.0]\nln_siemens = [0.0, 1.0]\n");
    folder.write("bend.toml", &bent);
    let run = folder.taxel("compensate calibration.txt --sensor bend.toml -o x.csv");
    assert_eq!(run.code, Some(1), "{run}");
    assert!(
        run.err
            .contains("`material.bend.ln_load_g`: knot 1 is at 3, the one before at 3"),
        "{run}"
    );
}

/// Pairs of a power law, one a line.
fn pairs() -> Vec<String> {
    let pair = |i: i32| {
        let load = 20.0 * f64::from(i);
        format!("{},{load}", 1e-6 + 8e-6 * load.powf(0.85))
    };
    let head = "conductance_siemens,load_g".to_owned();
    std::iter::once(head).chain((1..27).map(pair)).collect()
}

#[test]
fn pairs_with_their_columns_swapped_are_refused() {
    let folder = pressed(1);
    let swapped = |line: String| match line.split_once(',') {
        Some((siemens, load)) if !line.starts_with('c') => format!("{load},{siemens}"),
        _ => line,
    };
    let table: Vec<String> = pairs().into_iter().map(swapped).collect();
    folder.write("pairs.csv", &(table.join("\n") + "\n"));
    let run = folder.fails("calibrate --sensor parts.toml --pairs pairs.csv -o p.toml");
    assert!(run.err.contains("swapped"), "{run}");
    assert!(!folder.exists("p.toml"));
}

#[test]
fn pairs_give_their_numbers_with_errors_and_an_absurd_one_is_named() {
    let folder = pressed(1);
    let mut table = pairs();
    folder.write("pairs.csv", &(table.join("\n") + "\n"));
    let run = folder.good("calibrate --sensor parts.toml --pairs pairs.csv -o p.toml");
    assert!(
        run.out.contains("material.exponent") && run.out.contains('±'),
        "{run}"
    );
    for absurd in ["100,600", "300,0.001"] {
        table[7] = absurd.to_owned();
        folder.write("pairs.csv", &(table.join("\n") + "\n"));
        let run = folder.taxel("calibrate --sensor parts.toml --pairs pairs.csv -o q.toml");
        assert_eq!(run.code, Some(3), "{run}");
        assert!(run.err.contains("pairs.csv, line 8: "), "{run}");
        let exponent = |file: &str| {
            let text = folder.read(file);
            let line = text
                .lines()
                .find(|l| l.starts_with("exponent"))
                .unwrap()
                .to_owned();
            line.split('=')
                .nth(1)
                .unwrap()
                .trim()
                .parse::<f64>()
                .unwrap()
        };
        assert!((exponent("q.toml") - exponent("p.toml")).abs() < 0.01);
    }
}

#[test]
fn the_parts_list_comes_from_the_recordings_where_none_is_given() {
    let folder = pressed(40);
    folder.good("convert calibration.txt --sensor parts.toml -o calibration.mcap");
    let table = folder.read("experiments.csv");
    folder.write(
        "recorded.csv",
        &table.replace("calibration.txt", "calibration.mcap"),
    );
    let given = "calibrate --sensor parts.toml --presses recorded.csv -o a.toml --law power";
    folder.good(given);
    let run = folder.good("calibrate --presses recorded.csv -o b.toml --law power");
    assert!(run.err.contains("as calibration.mcap carries it"), "{run}");
    assert_eq!(folder.read("a.toml"), folder.read("b.toml"));
    // Text carries none; and two recordings may carry two.
    let run = folder.fails("calibrate --presses experiments.csv -o c.toml");
    assert!(run.err.contains("calibration.txt names no sensor"), "{run}");
    let other = folder
        .read("parts.toml")
        .replace("open_loop_gain = 1e5", "open_loop_gain = 2e5");
    folder.write("other.toml", &other);
    folder.good("convert calibration.txt --sensor other.toml -o other.mcap");
    let (head, rows) = table.split_once('\n').unwrap();
    let more = rows.replace("calibration.txt", "other.mcap");
    let both = format!(
        "{head}\n{}{more}",
        rows.replace("calibration.txt", "calibration.mcap")
    );
    folder.write("both.csv", &both);
    let run = folder.fails("calibrate --presses both.csv -o c.toml");
    assert!(run.err.contains("carry different sensors"), "{run}");
    assert!(!folder.exists("c.toml"));
}
