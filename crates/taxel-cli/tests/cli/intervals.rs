//! `taxel compensate --interval` and `--parts`: what loads are uncertain by, as far as the sensor file tells.

use crate::compensate::recorded;
use crate::run::{Folder, SENSOR};

/// What a calibration would write of a sensor whose loads are off by 2 % and 0.3 g.
const UNCERTAINTY: &str = "
[uncertainty]
model_share = 0.02
model_floor_g = 0.3
fit_share = 0.01
factor_95 = 2.5
presses = 40
";

/// Of 6 frames, one value for each taxel.
fn six_frames(folder: &Folder, name: &str) -> Vec<f64> {
    let values = folder.numbers(name);
    assert_eq!(
        (values.len(), folder.read(name).lines().count()),
        (6 * 24, 6 * 4),
        "{name}"
    );
    values
}

/// The heaviest load beside a taxel of six frames of 4 rows of 6.
fn heaviest_near(loads: &[f64], at: usize) -> f64 {
    let (frame, row, column) = (at / 24, at / 6 % 4, at % 6);
    let near = |i: &usize| {
        let (r, c) = (i / 6 % 4, i % 6);
        *i != at && i / 24 == frame && r.abs_diff(row) <= 1 && c.abs_diff(column) <= 1
    };
    (0..loads.len())
        .filter(near)
        .fold(0f64, |most, i| most.max(loads[i].abs()))
}

#[test]
fn standard_errors_are_the_sum_of_their_parts_and_intervals_a_multiple_of_them() {
    let folder = recorded();
    folder.write("told.toml", &format!("{SENSOR}{UNCERTAINTY}"));
    let run = folder.good(
        "compensate recording.txt --sensor told.toml --unit g -o loads.csv --standard-error se.csv \
         --interval half.csv --parts",
    );
    assert!(!run.err.contains("noise alone"), "{run}");
    let of = |name| six_frames(&folder, name);
    let (loads, sigma, half) = (of("loads.csv"), of("se.csv"), of("half.csv"));
    let (noise, fit, model) = (of("se.noise.csv"), of("se.fit.csv"), of("se.model.csv"));
    let same = |a: f64, b: f64| assert!((a - b).abs() <= 1e-12 * b.abs(), "{a} {b}");
    for i in 0..loads.len() {
        assert!(noise[i] > 0.0);
        same(fit[i], 0.01 * loads[i].abs());
        let share = 0.02 * loads[i].abs().max(0.05 * heaviest_near(&loads, i));
        same(model[i], (0.3f64.powi(2) + share.powi(2)).sqrt());
        same(
            sigma[i].powi(2),
            noise[i].powi(2) + fit[i].powi(2) + model[i].powi(2),
        );
        same(half[i], 2.5 * sigma[i]);
    }
    // In another unit all of it is the same multiple; an interval alone needs no file of standard errors.
    folder.good(
        "compensate recording.txt --sensor told.toml --unit N -o n.csv --interval n-half.csv",
    );
    for (newtons, grams) in of("n-half.csv").into_iter().zip(half) {
        same(newtons, 9.80665e-3 * grams);
    }
}

#[test]
fn a_sensor_that_tells_no_more_than_noise_says_so() {
    let folder = recorded();
    let run = folder.good(
        "compensate recording.txt --sensor sensor.toml -o loads.csv --standard-error se.csv --interval half.csv --parts",
    );
    assert!(
        run.err
            .contains("standard errors are of noise alone: the sensor file has no [uncertainty]"),
        "{run}"
    );
    let of = |name| six_frames(&folder, name);
    assert_eq!(of("se.csv"), of("se.noise.csv"));
    for name in ["se.fit.csv", "se.model.csv"] {
        assert!(of(name).iter().all(|&part| part == 0.0), "{name}");
    }
    for (half, sigma) in of("half.csv").iter().zip(of("se.csv")) {
        assert!((half / sigma - 1.96).abs() < 1e-12, "{half} {sigma}");
    }
    let run = folder.fails("compensate recording.txt --sensor sensor.toml -o l.csv --parts");
    assert_eq!(run.code, Some(2), "{run}");
    assert!(run.err.contains("--standard-error"), "{run}");
    let run = folder.fails(
        "compensate recording.txt --sensor sensor.toml -o l.csv --interval h.csv --method raw",
    );
    assert!(run.err.contains("standard errors need an inverse"), "{run}");
}

/// Of a saturated reading and a dead line; what is known of the model does not bound them.
#[test]
fn what_nothing_bounds_has_an_infinite_interval_and_noise() {
    let folder = Folder::new();
    let mut frame = vec![vec!["40"; 6]; 4];
    frame[1][2] = "65535";
    let lines = frame.iter().map(|line| line.join(",") + "\n");
    folder.write("run.txt", &lines.collect::<String>());
    let dead = format!("{SENSOR}{UNCERTAINTY}\n[screen]\ndead_rows = [3]\n");
    folder.write("dead.toml", &dead);
    folder.good(
        "compensate run.txt --sensor dead.toml -o l.csv --standard-error se.csv --interval half.csv --parts",
    );
    for name in ["se.csv", "half.csv", "se.noise.csv"] {
        let text = folder.read(name);
        for (row, line) in text.lines().enumerate() {
            for (column, number) in line.split(',').enumerate() {
                let unbounded = row == 3 || (row, column) == (1, 2);
                assert_eq!(number == "inf", unbounded, "{name}: {text}");
            }
        }
    }
    for name in ["se.fit.csv", "se.model.csv"] {
        assert!(
            folder.numbers(name).iter().all(|part| part.is_finite()),
            "{name}"
        );
    }
}
