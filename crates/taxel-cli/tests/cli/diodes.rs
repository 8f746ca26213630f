//! A sensor file with diodes, through the commands that take a sensor.

use crate::run::{Folder, SENSOR};

const CONDUCTANCES: &str = "1e-3,2e-3,1e-6,1e-6,5e-4,1e-6\n1e-6,1e-3,1e-3,1e-6,1e-6,1e-6\n\
    1e-6,1e-6,1e-6,1e-6,1e-6,1e-6\n2e-3,2e-3,2e-3,1e-6,1e-6,1e-3\n";

/// The small sensor, driven by 2 V, with a diode in this place.
fn with_diode(topology: &str, place: &str) -> String {
    let diode = format!("[readout.diode]\nplace = \"{place}\"\npart = \"1N4148\"\n\n[converter]");
    SENSOR
        .replace("tia-grounded-columns", topology)
        .replace(
            "v_test_volts = 0.4",
            "v_test_volts = 2.0\nr_pull_down_ohms = 1000.0",
        )
        .replace("r_feedback_ohms = 2000.0", "r_feedback_ohms = 300.0")
        .replace("[converter]", &diode)
}

#[test]
fn it_is_scanned_and_inverted() {
    for (topology, place, method) in [
        ("tia-grounded-columns", "taxel", "diodes"),
        ("divider-floating", "taxel", "diodes"),
        ("divider-pulled-rows", "driven-line", "newton"),
    ] {
        let folder = Folder::new();
        folder.write("skin.toml", &with_diode(topology, place));
        folder.write("g.csv", CONDUCTANCES);
        folder.good("simulate --sensor skin.toml --conductance g.csv -o v.csv");
        let run = folder.taxel(
            "compensate v.csv --input-unit volts --sensor skin.toml --unit siemens -o again.csv",
        );
        assert_eq!(run.code, Some(0), "{run}");
        assert!(
            run.to_string().contains(&format!("method {method}")),
            "{run}"
        );
        let (given, again) = (folder.numbers("g.csv"), folder.numbers("again.csv"));
        for (given, again) in given.iter().zip(&again) {
            assert!(
                (given - again).abs() < 1e-8 * 2e-3,
                "{topology}: {given} {again}"
            );
        }
    }
}

#[test]
fn presses_calibrate_it() {
    let folder = Folder::new();
    let skin = with_diode("tia-grounded-columns", "taxel");
    folder.write("skin.toml", &skin);
    folder.good(
        "simulate --sensor skin.toml --pattern press --frames 40 --seed 2 --presses p.csv -o p.npy",
    );
    let parts = skin.replace("r_mux_column_ohms = 10.0\nr_mux_row_ohms = 10.0\n", "");
    let (parts, _) = parts.split_once("[material]").unwrap();
    folder.write("parts.toml", parts);
    let run = folder.taxel("calibrate --sensor parts.toml --presses p.csv -o fit.toml");
    assert_eq!(run.code, Some(0), "{run}");
    assert!(
        run.out.contains("readout.diode.saturation_amperes"),
        "{run}"
    );
    assert!(
        run.out.contains("these presses hardly tell diodes' I_s"),
        "{run}"
    );
    let fit = folder.read("fit.toml");
    let number = |key: &str| -> f64 {
        let line = fit.lines().find(|line| line.starts_with(key));
        let line = line.unwrap_or_else(|| panic!("{key} in {fit}"));
        line.split('=').nth(1).unwrap().trim().parse().unwrap()
    };
    assert!(fit.contains("[readout.diode]\nplace = \"taxel\""), "{fit}");
    assert!((number("exponent") / 0.857 - 1.0).abs() < 0.01, "{fit}");
}

#[test]
fn the_budget_tells_what_it_costs() {
    let folder = Folder::new();
    folder.write("skin.toml", &with_diode("tia-grounded-columns", "taxel"));
    let run = folder.taxel("budget skin.toml");
    assert_eq!(run.code, Some(0), "{run}");
    assert!(
        run.out.lines().any(|line| line.starts_with("diodes ")),
        "{run}"
    );
}

#[test]
fn what_fits_nowhere_is_refused_before_any_work() {
    let folder = Folder::new();
    folder.write("g.csv", CONDUCTANCES);
    for (from, to, words) in [
        ("\"taxel\"", "\"row\"", "`readout.diode.place`"),
        ("1N4148", "1N4184", "did you mean `1N4148`?"),
        (
            "part = \"1N4148\"",
            "saturation_amperes = -1.0\nemission = 1.7",
            "saturation_amperes",
        ),
        (
            "part = \"1N4148\"",
            "part = \"BAT54\"\ntemperature_celsius = 300",
            "looks like kelvin",
        ),
        ("\"taxel\"", "\"driven-line\"", "divider-pulled-rows"),
    ] {
        let skin = with_diode("tia-grounded-columns", "taxel").replace(from, to);
        folder.write("skin.toml", &skin);
        let run = folder.taxel("simulate --sensor skin.toml --conductance g.csv -o v.csv");
        assert_eq!(run.code, Some(1), "{run}");
        assert!(run.to_string().contains(words), "{words}\n{run}");
        assert!(!folder.exists("v.csv"), "{words}");
    }
}
