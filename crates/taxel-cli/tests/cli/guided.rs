//! Guided calibrations in the terminal.

use std::path::PathBuf;

use serde_json::Value;

use crate::operated::Operated;
use crate::run::Folder;

/// The folders of all calibrations, in order.
fn calibrations(folder: &Folder) -> Vec<PathBuf> {
    let found = std::fs::read_dir(folder.path("calibrations")).unwrap();
    let mut found: Vec<PathBuf> = found.map(|entry| entry.unwrap().path()).collect();
    found.sort();
    found
}

fn record(calibration: &std::path::Path) -> Value {
    let text = std::fs::read_to_string(calibration.join("session.json")).unwrap();
    serde_json::from_str(&text).unwrap()
}

/// The seventh press lands beside at first, and is moved; after nine the power fails; the eleventh is made with a weight that is not
/// what it says, and is asked for again.
#[test]
fn a_simulated_mat_is_calibrated_through_a_crash_to_a_certificate_and_the_same_from_its_tables() {
    let folder = Folder::new();
    let words = "calibrate --live sim:sensor.toml?fps=50 --terminal --weights 50,200,500 -o calibrated.toml";
    let mut first = Operated::begin(&folder, words);
    first.answer("take everything off", "finish");
    first.answer("not done: 0 presses were taken", "");
    first.hear("is pressed most, not");
    first.hear("taken: press 9");
    first.child.kill().unwrap();
    first.child.wait().unwrap();

    let mut again = Operated::begin(&folder, words);
    again.hear("was left unfinished, and goes on");
    again.answer("take everything off", "");
    again.hear("held-out presses are");
    again.hear("the first time it said");
    again.answer("taken: press", "finish");
    let (code, printed, said) = again.end();
    assert_eq!(code, Some(0), "{said}");
    let all = calibrations(&folder);
    let [calibration] = &all[..] else {
        panic!("{all:?}");
    };
    for name in [
        "certificate.html",
        "certificate.pdf",
        "sensor.toml",
        "parts.toml",
        "presses.csv",
        "residuals.csv",
    ] {
        assert!(printed.contains(name), "{printed}");
        assert!(calibration.join(name).exists(), "{name}");
    }
    let record = record(calibration);
    assert_eq!(record["is_finished"], true);
    let presses = record["presses"].as_array().unwrap();
    assert!(presses.len() >= 11);
    // The frames of every press are kept, and each can be looked at.
    let kept = presses[0]["file"]
        .as_str()
        .unwrap()
        .replace(".npy", ".mcap");
    let told = folder.good(&format!("info {}", calibration.join(kept).display()));
    assert!(told.out.contains("4 rows x 6 columns"), "{told}");
    let page = std::fs::read_to_string(calibration.join("certificate.html")).unwrap();
    assert!(page.contains("Simulated data") && page.contains("Held-out presses by load"));
    check_same(&folder, calibration);
}

/// From the tables that were written `calibrate` finds the same sensor.
fn check_same(folder: &Folder, calibration: &std::path::Path) {
    let place = calibration.display();
    folder.good(&format!(
        "calibrate --sensor {place}/parts.toml --presses {place}/presses.csv -o again.toml --certificate again.pdf"
    ));
    let without_names = |name: &str| {
        let text = std::fs::read_to_string(folder.path(name)).unwrap();
        let lines = text.lines().filter(|line| !line.starts_with("data = "));
        lines.map(str::to_owned).collect::<Vec<_>>()
    };
    assert_eq!(
        without_names("calibrated.toml"),
        without_names("again.toml")
    );
    let certificate = std::fs::read(folder.path("again.pdf")).unwrap();
    let certificate = String::from_utf8_lossy(&certificate);
    let all = certificate.matches("/Type/Page").count();
    let sheets = all - certificate.matches("/Type/Pages").count();
    assert_eq!(sheets, 1, "a certificate is one sheet");
    // The true sensor's law, which the parts list does not know.
    let found = std::fs::read_to_string(folder.path("calibrated.toml")).unwrap();
    let number = |key: &str| -> f64 {
        let line = found.lines().find(|line| line.starts_with(key)).unwrap();
        line.split('=').nth(1).unwrap().trim().parse().unwrap()
    };
    assert!((number("exponent") / 0.857 - 1.0).abs() < 0.01, "{found}");
    assert!((number("factor") / 8.29e-6 - 1.0).abs() < 0.05, "{found}");
}

/// Even loads of a hundredth of the heaviest press: each taxel rises by less than what is taken for a press.
#[test]
fn even_loads_far_lighter_than_the_presses_are_seen_and_tell_how_taxels_differ() {
    let folder = Folder::new();
    let words = "calibrate --live sim:sensor.toml?fps=50 --terminal --weights 50,200,500 --even-weights 5,20 -o calibrated.toml";
    let mut guided = Operated::begin(&folder, words);
    guided.answer("take everything off", "");
    guided.hear("load the whole sensor evenly, 5 g on each taxel");
    guided.hear("load the whole sensor evenly, 20 g on each taxel");
    guided.answer("taken: press 10", "finish");
    let (code, _, said) = guided.end();
    assert!(matches!(code, Some(0 | 3)), "{said}");
    let calibration = &calibrations(&folder)[0];
    let record = record(calibration);
    let presses = record["presses"].as_array().unwrap().iter();
    let even = presses.filter(|press| press["taxel"].is_null());
    let even: Vec<f64> = even
        .map(|press| press["load_g"].as_f64().unwrap())
        .collect();
    assert_eq!(even, [5.0, 20.0]);
    let table = std::fs::read_to_string(calibration.join("even.csv")).unwrap();
    assert_eq!(table.lines().count(), 3, "{table}");
}

#[test]
fn what_cannot_be_calibrated_is_said_before_anything_begins() {
    let folder = Folder::new();
    let live = "calibrate --sensor sensor.toml -o calibrated.toml --terminal";
    for (words, says) in [
        (
            format!("{live} --live serial:/dev/ttyNONE"),
            "--weights 50,100,200,500",
        ),
        (
            format!("{live} --live sim:sensor.toml --weights 100,100"),
            "tell no load law",
        ),
        (
            format!("{live} --live sim:sensor.toml --weights 100,-5"),
            "-5",
        ),
        (
            format!("{live} --live sim:sensor.toml --presses p.csv"),
            "cannot be used with",
        ),
        (format!("{live} --weights 50,100"), "--live"),
        (
            format!("{live} --live sim:sensor.toml --folder sensor.toml"),
            "sensor.toml",
        ),
    ] {
        let told = folder.taxel(&words);
        assert_ne!(told.code, Some(0), "{words}: {told}");
        assert!(told.err.contains(says), "{words}: {told}");
        assert!(!folder.path("calibrated.toml").exists());
    }
    assert!(!folder.path("calibrations").exists());
}
