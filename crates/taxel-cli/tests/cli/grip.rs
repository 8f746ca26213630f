//! Grip sessions in the terminal, and sessions compared.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::operated::Operated;
use crate::run::Folder;

/// As short as a protocol may be.
const SHORT: &str =
    "trials = 1\nhold_secs = 1.5\nplateau_secs = 0.5\nrest_secs = 0\ncountdown_secs = 1\n";

/// One trial, from ready to its verdict.
fn trial(operated: &mut Operated, verdict: &str) {
    operated.answer("Enter starts it", "");
    operated.answer("Enter accepts it", verdict);
}

/// The folder of a person's only session.
fn session(folder: &Folder, person: &str) -> PathBuf {
    let mut found = std::fs::read_dir(folder.path("grips").join(person)).unwrap();
    let session = found.next().unwrap().unwrap().path();
    assert!(found.next().is_none(), "two sessions of {person}");
    session
}

fn json(file: PathBuf) -> Value {
    serde_json::from_str(&std::fs::read_to_string(file).unwrap()).unwrap()
}

/// Both hands' largest forces are those that were pressed.
fn check_truth(results: &Value) {
    assert_eq!(results["is_simulated"], true);
    let hands = results["hands"].as_array().unwrap();
    assert_eq!(hands.len(), 2);
    for hand in hands {
        let trial = &hand["trials"][0];
        let newtons = trial["max"]["newtons"].as_f64().unwrap();
        let truth = trial["true_max_newtons"].as_f64().unwrap();
        let half = trial["max"]["half_width_95_newtons"].as_f64().unwrap();
        // No noise but that of rounding, and one frame in a hundred may be missed on a machine that is busy.
        assert!((newtons - truth).abs() < half.max(0.003 * truth), "{trial}");
    }
}

/// Whoever opens the table alone is told what its intervals know.
fn check_table(session: &Path, results: &Value) {
    let table = std::fs::read_to_string(session.join("results.csv")).unwrap();
    let first = "person,began_secs,hand,force,intervals,simulated,trial,";
    assert!(table.starts_with(first), "{table}");
    assert_eq!(results["intervals"], "noise alone");
    assert!(
        table.contains(",total normal force,noise alone,true,1,"),
        "{table}"
    );
}

/// Waits for the zero that is taken before a later trial, beside the one that was asked for in each run; of these nothing has drifted.
fn zeroed_by_itself(session: &Path) {
    let until = Instant::now() + Duration::from_secs(60);
    loop {
        let record = json(session.join("session.json"));
        let zeros: Vec<f64> = serde_json::from_value(record["zeros_newtons"].clone()).unwrap();
        if zeros.len() >= 3 {
            let is_still = |newtons: &f64| (newtons - zeros[0]).abs() < 0.5;
            assert!(zeros.iter().all(is_still), "{zeros:?}");
            return;
        }
        assert!(Instant::now() < until, "{zeros:?}");
        std::thread::sleep(Duration::from_millis(100));
    }
}

#[test]
fn a_session_with_a_repeat_a_cancel_and_a_crash_ends_in_a_page_and_in_true_numbers() {
    let folder = Folder::new();
    folder.write("short.toml", SHORT);
    let words = "grip sim:sensor.toml?grip&seed=7 --person P1 --protocol short.toml --terminal";
    let mut first = Operated::begin(&folder, words);
    first.answer("takes the zero", "");
    trial(&mut first, "slipped");
    trial(&mut first, "");
    // The left hand's turn: the power fails.
    first.answer("Enter starts it", "");
    first.answer("GRIP", "");
    first.child.kill().unwrap();
    first.child.wait().unwrap();

    let mut again = Operated::begin(&folder, words);
    again.answer("was left unfinished, and goes on", "");
    again.answer("takes the zero", "");
    again.answer("Enter starts it", "");
    again.answer("GRIP", "c");
    zeroed_by_itself(&session(&folder, "P1"));
    trial(&mut again, "");
    let (code, printed, said) = again.end();
    assert_eq!(code, Some(0), "{said}");
    let session = session(&folder, "P1");
    for name in ["page.html", "page.pdf", "results.csv", "results.json"] {
        assert!(printed.contains(name), "{printed}");
        assert!(session.join(name).exists(), "{name}");
    }
    let results = json(session.join("results.json"));
    check_truth(&results);
    check_table(&session, &results);
    let record = json(session.join("session.json"));
    let attempts = record["attempts"].as_array().unwrap();
    let verdicts: Vec<&Value> = attempts.iter().map(|attempt| &attempt["verdict"]).collect();
    assert_eq!(verdicts[0]["repeated"], "slipped");
    assert_eq!(verdicts[1], "accepted");
    assert_eq!(verdicts[2]["repeated"], "cancelled by the operator");
    assert_eq!(verdicts[3], "accepted");
    let page = std::fs::read_to_string(session.join("page.html")).unwrap();
    assert!(page.contains("by itself before each trial"), "{page:.3000}");
    // Every attempt has its recording; so has the one that the crash cut off.
    let recordings = std::fs::read_dir(&session).unwrap();
    let recordings = recordings.filter(|file| {
        let path = file.as_ref().unwrap().path();
        path.extension()
            .is_some_and(|extension| extension == "mcap")
    });
    assert_eq!(recordings.count(), 5);
    // What was held is measured the same by `measure`.
    let recording = session.join(attempts[1]["recording"].as_str().unwrap());
    let measured = folder.good(&format!(
        "measure {} --json --plateau 0.5",
        recording.display()
    ));
    let measured: Value = serde_json::from_str(&measured.out).unwrap();
    let peak = measured["trials"][0]["forces"][0]["peak_n"]["value"].as_f64();
    let said = results["hands"][0]["trials"][0]["max"]["newtons"].as_f64();
    assert!(
        (peak.unwrap() - said.unwrap()).abs() < 1e-9,
        "{peak:?} {said:?}"
    );
}

#[test]
fn what_cannot_be_begun_says_why() {
    let folder = Folder::new();
    folder.write("fast.toml", "hold_secs = 0.5\n");
    folder.write("typo.toml", "hold = 8\n");
    folder.write(
        "bare.toml",
        &crate::run::SENSOR[..crate::run::SENSOR.find("[material]").unwrap()],
    );
    for (words, code, says) in [
        (
            "--protocol fast.toml",
            2,
            "fast.toml: hold_secs is 0.5, expected 1 to 120",
        ),
        ("--protocol typo.toml", 2, "unknown field `hold`"),
        ("--protocol none.toml", 1, "none.toml"),
        (
            "--person J.Doe",
            2,
            "--person: the id has a '.', expected letters, digits, - and _",
        ),
        ("--terminal", 2, "--person"),
        (
            "--sensor bare.toml --person P1 --terminal",
            2,
            "has no load law",
        ),
    ] {
        let run = folder.taxel(&format!("grip sim:sensor.toml?grip {words}"));
        assert_eq!(run.code, Some(code), "{words}: {run}");
        assert!(run.err.contains(says), "{words}: {run}");
    }
    let ended = folder.taxel("grip sim:sensor.toml?grip --person P2 --terminal");
    assert_eq!(ended.code, Some(3), "{ended}");
    assert!(ended.err.contains("standard input has ended"), "{ended}");
    assert_eq!(
        json(session(&folder, "P2").join("session.json"))["is_finished"],
        false
    );
}

/// Newtons of seven persons in two sessions.
const GRIPS: [[f64; 2]; 7] = [
    [77.1, 79.4],
    [102.5, 98.0],
    [64.2, 66.9],
    [88.8, 85.1],
    [120.3, 118.8],
    [71.7, 75.5],
    [95.0, 93.2],
];

/// A line a person and session.
fn long_table() -> String {
    let mut table = "person,hand,session,newtons\n".to_owned();
    for (number, grips) in GRIPS.iter().enumerate() {
        for (session, newtons) in grips.iter().enumerate() {
            writeln!(table, "S{number},right,{},{newtons}", session + 1).unwrap();
        }
    }
    table
}

/// A finished session, as `grip` leaves one.
fn finished(
    folder: &Folder,
    template: &Value,
    results: &Value,
    person: &str,
    day: u64,
    newtons: f64,
) {
    let (mut record, mut results) = (template.clone(), results.clone());
    for file in [&mut record, &mut results] {
        file["person"] = person.into();
        file["began_secs"] = (86_400 * day).into();
    }
    for hand in results["hands"].as_array_mut().unwrap() {
        hand["mean"]["newtons"] = newtons.into();
    }
    let place = folder.path(&format!("study/{person}/{day}"));
    std::fs::create_dir_all(&place).unwrap();
    std::fs::write(place.join("session.json"), record.to_string()).unwrap();
    std::fs::write(place.join("results.json"), results.to_string()).unwrap();
}

#[test]
fn sessions_are_compared() {
    let folder = Folder::new();
    folder.write("short.toml", &format!("{SHORT}hands = [\"right\"]\n"));
    let mut one = Operated::begin(
        &folder,
        "grip sim:sensor.toml?grip --person P1 --protocol short.toml --terminal",
    );
    one.answer("takes the zero", "");
    trial(&mut one, "");
    assert_eq!(one.end().0, Some(0));
    let done = session(&folder, "P1");
    let (record, results) = (
        json(done.join("session.json")),
        json(done.join("results.json")),
    );
    for (number, grips) in GRIPS.iter().enumerate() {
        for (session, newtons) in grips.iter().enumerate() {
            finished(
                &folder,
                &record,
                &results,
                &format!("S{number}"),
                20_000 + session as u64,
                *newtons,
            );
        }
    }
    // The intraclass correlations are pingouin's of the same numbers.
    let run = folder.good("grip compare study -o retest.pdf");
    for words in [
        "0.986 (0.922 to 0.998)",
        "0.984 (0.909 to 0.997)",
        "−0.39",
        "Simulated data",
    ] {
        assert!(run.out.contains(words), "{words}: {run}");
    }
    assert!(
        std::fs::read(folder.path("retest.pdf"))
            .unwrap()
            .starts_with(b"%PDF")
    );
    folder.good("grip compare study -o retest.csv");
    assert_eq!(folder.read("retest.csv"), long_table());
    // One that is not finished is named, and the exit code says so.
    std::fs::remove_file(folder.path("study/S3/20001/results.json")).unwrap();
    let run = folder.taxel("grip compare study");
    assert_eq!(run.code, Some(3), "{run}");
    assert!(
        run.out.contains("is not finished") && run.out.contains("right hand: S3"),
        "{run}"
    );
    let nothing = folder.taxel("grip compare grips");
    assert_eq!(nothing.code, Some(2), "{nothing}");
    assert!(
        nothing.err.contains("0 persons have 2 sessions"),
        "{nothing}"
    );
    let nowhere = folder.taxel("grip compare nowhere -o x.docx");
    assert_eq!(nowhere.code, Some(2), "{nowhere}");
}
