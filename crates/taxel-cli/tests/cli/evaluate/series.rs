//! `taxel calibrate --series`: a material that remembers, found again, and judged by `taxel evaluate`.

use serde_json::Value;

use super::{Pressed, conductances, near, siemens};
use crate::run::{Folder, SENSOR};

/// Loads over time on half of the taxels, none on the others, and what a material with one lag makes of them.
fn series(folder: &Folder, weight: f64, tau_secs: f64, period: f64) {
    let frames = 160;
    let mut scanned: Vec<Pressed> = vec![Vec::new(); frames];
    let mut loads: Vec<Pressed> = vec![Vec::new(); frames];
    for taxel in 0..12usize {
        let (row, column) = (taxel / 3, 2 * (taxel % 3) + taxel / 3 % 2);
        let load = |frame: usize| match (frame + 7 * taxel) % 60 {
            _ if frame < 5 => 0.0,
            part if part < 35 => 60.0 + 15.0 * taxel as f64 + (part as f64),
            _ => 0.0,
        };
        // What lags behind: τ·ds/dt = F − s, the load straight between frames, in small steps.
        let mut lag = 0.0;
        for frame in 0..frames {
            if frame > 0 {
                let (from, to) = (load(frame - 1), load(frame));
                let steps = 1000;
                for step in 0..steps {
                    let at = from + (to - from) * (f64::from(step) + 0.5) / f64::from(steps);
                    let keep = (-period / f64::from(steps) / tau_secs).exp();
                    lag = keep * lag + (1.0 - keep) * at;
                }
            }
            let acting = load(frame) + weight * lag;
            scanned[frame].push((row, column, siemens(acting)));
            loads[frame].push((row, column, load(frame)));
        }
    }
    folder.scan("sensor.toml", "series.txt", &scanned);
    folder.write("loads.csv", &conductances(&loads, 0.0));
    let without = SENSOR.split("[material]").next().unwrap();
    folder.write("parts.toml", without);
}

#[test]
fn a_series_gives_the_creep_that_it_was_given() {
    let folder = Folder::new();
    series(&folder, 0.2, 3.0, 0.25);
    let calibrate = "calibrate --sensor parts.toml --series series.txt --loads loads.csv --period 0.25 --lags 1 --plays 0 -o c.toml";
    let run = folder.good(&format!("{calibrate} --json --static-output static.toml"));
    let report: Value = serde_json::from_str(&run.out).unwrap();
    assert_eq!(report["frames"], 160);
    assert_eq!(report["taxels_fitted"], 12);
    let parameters = report["parameters"].as_array().unwrap();
    let found = |name: &str| {
        let one = parameters.iter().find(|p| p["name"] == name);
        one.unwrap_or_else(|| panic!("{parameters:?}"))["value"]
            .as_f64()
            .unwrap()
    };
    near(found("lag weight 1"), 0.2, 0.01);
    near(found("lag, s 1"), 3.0, 0.15);
    near(found("exponent"), 0.857, 0.005);
    // With what it found, the loads of the series come back; with the best law without memory they do not.
    folder.plan("");
    let plan = |sensor: &str| {
        folder.write(
            "plan.toml",
            &format!(
                "format = 1\nsensor = \"{sensor}\"\nframes_per_second = 4\nresamples = 100\n\
                 [[experiment]]\nkind = \"accuracy\"\nname = \"a\"\nrecording = \"series.txt\"\n\
                 truth_g = \"loads.csv\"\nframes_per_experiment = 40\nmethods = [\"auto\"]\n"
            ),
        );
        folder.evaluated().number((0, 0), 0, "mean absolute")
    };
    let (with, without) = (plan("c.toml"), plan("static.toml"));
    assert!(with < 0.3, "{with}");
    assert!(without > 10.0 * with, "{without} {with}");
    let text = folder.good(calibrate);
    assert!(
        text.out.contains("160 frames, 39.8 s, 12 taxels fitted"),
        "{text}"
    );
}

#[test]
fn series_that_cannot_be_used_are_refused() {
    let folder = Folder::new();
    series(&folder, 0.2, 3.0, 0.25);
    let calibrate = "calibrate --sensor parts.toml --series series.txt -o c.toml";
    let no_period = folder.fails(&format!("{calibrate} --loads loads.csv"));
    insta::assert_snapshot!(no_period, @r"
    exit code: 2
    ----- stdout -----

    ----- stderr -----
    error: series.txt tells no times, and creep is about time
    hint: --period takes the seconds between two frames
    ");
    let no_loads = folder.fails(&format!("{calibrate} --period 0.25"));
    assert_eq!(no_loads.code, Some(2));
    assert!(no_loads.err.contains("--loads <FILE>"), "{no_loads}");
    let text = folder.read("loads.csv");
    let some: Vec<&str> = text.lines().take(4 * 100).collect();
    folder.write("short.csv", &(some.join("\n") + "\n"));
    let shorter = folder.fails(&format!("{calibrate} --loads short.csv --period 0.25"));
    insta::assert_snapshot!(shorter, @r"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: series.txt: the series has 160 frames, 100 frames of loads and 160 times, needs as many of each and 50 or more
    hint: one frame of known loads for each frame of counts
    ");
    for period in ["0", "-1"] {
        let run = folder.fails(&format!("{calibrate} --loads loads.csv --period={period}"));
        assert!(
            run.err.contains("period") || run.err.contains("time"),
            "{run}"
        );
    }
    assert!(!folder.exists("c.toml"));
}
