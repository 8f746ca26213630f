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
    assert!(!run.err.contains("noise only"), "{run}");
    let of = |name| six_frames(&folder, name);
    let (loads, sigma, half) = (of("loads.csv"), of("se.csv"), of("half.csv"));
    let (noise, fit, model) = (of("se.noise.csv"), of("se.fit.csv"), of("se.model.csv"));
    let same = |a: f64, b: f64| assert!((a - b).abs() <= 1e-12 * b.abs(), "{a} {b}");
    for i in 0..loads.len() {
        assert!(noise[i] > 0.0);
        same(fit[i], 0.01 * loads[i].abs());
        let beside = 0.06 * 0.02f64.hypot(0.01) * heaviest_near(&loads, i);
        let share = beside.max(0.02 * loads[i].abs());
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

/// The columns of a table of figures, by their names.
fn figures(folder: &Folder, name: &str) -> std::collections::BTreeMap<String, Vec<f64>> {
    let text = folder.read(name);
    let mut lines = text.lines().map(|line| line.split(','));
    let mut table: Vec<(String, Vec<f64>)> = lines
        .next()
        .unwrap()
        .map(|name| (name.to_owned(), Vec::new()))
        .collect();
    for line in lines {
        for ((_, values), cell) in table.iter_mut().zip(line) {
            values.push(cell.parse().unwrap_or(f64::NAN));
        }
    }
    table.into_iter().collect()
}

#[test]
fn figures_have_intervals_that_count_what_is_shared_once() {
    let folder = recorded();
    let shared = format!("{SENSOR}{UNCERTAINTY}frame_share = 0.015\nframe_floor_g = 0.1\n");
    folder.write("told.toml", &shared);
    let run = folder.good(
        "compensate recording.txt --sensor told.toml --unit g -o loads.csv --figures figures.csv \
         --standard-error se.csv --interval half.csv --parts --json",
    );
    let json: serde_json::Value = serde_json::from_str(&run.out).unwrap();
    assert_eq!(json["interval_output"], "half.csv");
    assert_eq!(json["figures_output"], "figures.csv");
    assert_eq!(
        json["parts_output"],
        serde_json::json!(["se.noise.csv", "se.fit.csv", "se.model.csv"])
    );
    let table = figures(&folder, "figures.csv");
    let (loads, own) = (
        six_frames(&folder, "loads.csv"),
        0.02f64.powi(2) - 0.015f64.powi(2),
    );
    let same = |a: f64, b: f64| assert!((a - b).abs() <= 1e-9 * b.abs(), "{a} {b}");
    let mut heaviest = 0.0;
    for (frame, loads) in loads.chunks(24).enumerate() {
        let of = |name: &str| table[name][frame];
        let total: f64 = loads.iter().sum();
        same(of("total_force_g"), total);
        same(of("total_force_fit_g"), 0.01 * total.abs());
        let each = loads.iter();
        let each: f64 = each.map(|g| own * g * g + 0.3f64.powi(2) - 0.01).sum();
        let model = (0.015 * total).powi(2) + (24.0f64 * 0.1).powi(2) + each;
        same(of("total_force_model_g"), model.sqrt());
        let parts = ["noise", "fit", "model"].map(|part| of(&format!("total_force_{part}_g")));
        let sigma = parts.iter().map(|part| part * part).sum::<f64>().sqrt();
        same(of("total_force_half_width_95_g"), 2.5 * sigma);
        assert_eq!(of("centre_row_fit_mm"), 0.0);
        assert_eq!(of("measured_share"), 1.0);
        heaviest = f64::max(heaviest, total);
    }
    let told = json["heaviest_frame"]["total_force"]["value"].as_f64();
    same(told.unwrap(), heaviest);
    let run = folder.good(
        "compensate recording.txt --sensor told.toml -o l.csv --figures f.csv --standard-error e.csv --parts",
    );
    for said in [
        ", the heaviest: total force ",
        "wrote f.csv (figures)",
        "wrote e.noise.csv (standard errors, noise)",
    ] {
        assert!(run.err.contains(said), "{said}: {run}");
    }
    let run = folder.fails(
        "compensate recording.txt --sensor told.toml --unit siemens -o l.csv --figures f.csv",
    );
    assert!(run.err.contains("figures are sums of loads"), "{run}");
}

#[test]
fn a_sensor_that_tells_no_more_than_noise_says_so() {
    let folder = recorded();
    let run = folder.good(
        "compensate recording.txt --sensor sensor.toml -o loads.csv --standard-error se.csv --interval half.csv --parts",
    );
    assert!(
        run.err
            .contains("noise only: the sensor file has no [uncertainty]"),
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

#[test]
fn a_series_takes_the_intervals_of_the_law_before_off() {
    let folder = Folder::new();
    let large = SENSOR
        .replace("rows = 4", "rows = 12")
        .replace("columns = 6", "columns = 12");
    folder.write("told.toml", &format!("{large}{UNCERTAINTY}"));
    folder.good("simulate --sensor told.toml --pattern fingers --frames 60 --period 0.1 -o run.csv --truth g.csv");
    let run = folder.good(
        "calibrate --sensor told.toml --series run.csv --loads g.csv --period 0.1 --lags 1 --plays 0 -o d.toml",
    );
    assert!(run.err.contains("the law before"), "{run}");
    assert!(!folder.read("d.toml").contains("[uncertainty]"));
    let run =
        folder.good("compensate run.csv --sensor d.toml --unit g -o loads.csv --interval half.csv");
    assert!(run.err.contains("noise only"), "{run}");
}
