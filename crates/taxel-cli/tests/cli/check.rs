//! `taxel check`: a calibrated sensor and a few known loads in, a verdict and the day's sensor out.

use crate::run::{Folder, SENSOR};

const STATED: &str = "[uncertainty]\nmodel_share = 0.01\nmodel_floor_g = 0.2\nfit_share = 0.003\nfactor_95 = 1.96\npresses = 100\n";

/// Presses on a sensor whose film conducts as `factor` says; its calibration said 8.29e-6.
fn pressed(factor: &str) -> Folder {
    let folder = Folder::new();
    folder.write("today.toml", &SENSOR.replace("8.29e-6", factor));
    folder.write("calibrated.toml", &format!("{SENSOR}\n{STATED}"));
    folder.good(
        "simulate --sensor today.toml --pattern press --frames 10 --seed 8 \
         -o check.txt --presses check.csv",
    );
    folder
}

const CHECK: &str = "check --sensor calibrated.toml --presses check.csv";

#[test]
fn a_sensor_that_has_not_changed_is_good() {
    let folder = pressed("8.29e-6");
    let run = folder.good(CHECK);
    assert!(run.out.starts_with("verdict      good\n"), "{run}");
    assert!(
        run.out.contains("10 of 10 inside: hold, as calibrated"),
        "{run}"
    );
}

#[test]
fn the_days_scale_is_written_and_loads_are_read_by_it() {
    let folder = pressed("8.7045e-6");
    let run = folder.good(&format!("{CHECK} -o rescaled.toml"));
    assert!(run.out.starts_with("verdict      rescaled\n"), "{run}");
    assert!(run.out.contains("conductance  1.05"), "{run}");
    assert!(run.err.ends_with("wrote rescaled.toml\n"), "{run}");
    let text = folder.read("rescaled.toml");
    assert!(
        text.contains("[check]") && text.contains("factor = 0.00000829"),
        "{text}"
    );
    folder.good(
        "simulate --sensor today.toml --pattern blobs --frames 4 --seed 9 --load-g 300 \
         -o validation.txt --truth truth.csv",
    );
    folder.good("compensate validation.txt --sensor rescaled.toml --unit g -o loads.csv");
    let (loads, truth) = (folder.numbers("loads.csv"), folder.numbers("truth.csv"));
    let worst = loads.iter().zip(&truth).map(|(a, b)| (a - b).abs());
    let worst = worst.fold(0.0, f64::max);
    assert!(worst < 0.2, "{worst}");
}

#[test]
fn a_sensor_beyond_any_scale_is_to_be_calibrated_again() {
    let folder = pressed("4.0e-6");
    let run = folder.taxel(&format!("{CHECK} -o rescaled.toml --json"));
    assert!(run.to_string().starts_with("exit code: 3"), "{run}");
    assert!(run.out.contains("\"verdict\": \"recalibrate\""), "{run}");
    assert!(run.err.contains("rescaled.toml is not written"), "{run}");
    assert!(!folder.exists("rescaled.toml"));
}

#[test]
fn what_cannot_be_checked_is_refused() {
    let folder = pressed("8.29e-6");
    insta::assert_snapshot!(folder.taxel("check --sensor calibrated.toml --total 812.5 check.txt"), @r"
    exit code: 2
    ----- stdout -----

    ----- stderr -----
    error: `812.5` is no load above 0 with a unit
    hint: write 812.5N, 640g or 82.9kg
    ");
    folder.write("bare.toml", SENSOR.split("[material]").next().unwrap());
    let run = folder.taxel("check --sensor bare.toml --presses check.csv");
    assert!(run.to_string().starts_with("exit code: 1"), "{run}");
    assert!(run.err.contains("`material` is missing"), "{run}");
}

#[test]
fn unloaded_taxels_alone_tell_no_scale() {
    let folder = pressed("8.29e-6");
    let csv = folder.read("check.csv");
    let mut lines = csv.lines();
    let mut empty = format!("{}\n", lines.next().unwrap());
    for line in lines {
        let (head, _) = line.rsplit_once(',').unwrap();
        // Another taxel than the one that was pressed.
        let mut cells: Vec<String> = head.split(',').map(str::to_owned).collect();
        let row: usize = cells[2].parse().unwrap();
        cells[2] = ((row + 2) % 4).to_string();
        empty.push_str(&format!("{},0\n", cells.join(",")));
    }
    folder.write("empty.csv", &empty);
    let check = "check --sensor calibrated.toml --presses empty.csv";
    let run = folder.good(check);
    assert!(run.out.contains("this tells the offset alone"), "{run}");
    let run = folder.taxel(&format!("{check} -o day.toml"));
    assert!(run.to_string().starts_with("exit code: 1"), "{run}");
    assert!(run.err.contains("no scale was compared"), "{run}");
    assert!(!folder.exists("day.toml"));
}

#[test]
fn errors_of_another_calibration_are_refused() {
    let folder = pressed("8.29e-6");
    let stated = |factor: &str| format!("{SENSOR}\n{STATED}material_factor = {factor}\n");
    folder.write("calibrated.toml", &stated("8.29e-6"));
    folder.good(CHECK);
    folder.write("calibrated.toml", &stated("7.1e-6"));
    let run = folder.taxel(CHECK);
    assert!(run.to_string().starts_with("exit code: 1"), "{run}");
    for words in ["0.0000071", "0.00000829", "another calibration"] {
        assert!(run.err.contains(words), "{words}: {run}");
    }
}

/// The others tell the scale all the same, and the press is named.
#[test]
fn a_press_on_a_dead_line_is_left_out_and_named() {
    let folder = pressed("8.7045e-6");
    let text = folder.read("check.csv");
    let dead = text.lines().nth(1).unwrap().split(',').nth(2).unwrap();
    let on_it = text
        .lines()
        .skip(1)
        .filter(|line| line.split(',').nth(2) == Some(dead))
        .count();
    let sensor = folder.read("calibrated.toml");
    folder.write(
        "calibrated.toml",
        &format!("{sensor}\n[screen]\ndead_rows = [{dead}]\n"),
    );
    let run = folder.taxel(CHECK);
    assert_eq!(run.code, Some(3), "{run}");
    assert!(run.out.contains("conductance  1.0"), "{run}");
    let named = format!("the sensor file declares row {dead} dead");
    assert_eq!(run.out.matches(&named).count(), on_it, "{run}");
}
