//! Recordings that `taxel evaluate --live` makes.

use super::Report;
use crate::run::Folder;
#[cfg(unix)]
use crate::run::Run;

/// A plan of a loop that nobody has recorded yet.
fn unmade() -> Folder {
    let folder = Folder::new();
    folder.write(
        "t.csv",
        "recording,row,column,load_g,experiment\n9.mcap,1,1,0,a\nsub/10.mcap,1,1,100,a\n8.mcap,1,1,50,a\n7.mcap,1,1,0,a\n",
    );
    folder.plan(
        "live_frames = 3\n[[experiment]]\nkind = \"hysteresis\"\nname = \"one loop\"\ntrials = \"t.csv\"\nvalue = \"counts\"\n",
    );
    folder
}

const LIVE: &str = "evaluate plan.toml --live sim:sensor.toml?hand --json";
const MADE: [&str; 4] = ["9.mcap", "sub/10.mcap", "8.mcap", "7.mcap"];

#[test]
fn recordings_are_made_in_the_order_of_the_table_and_kept() {
    let folder = unmade();
    let run = folder.taxel_with(LIVE, "\n\n\n\n");
    assert_eq!(run.code, Some(0), "{run}");
    let told: Vec<&str> = run.err.lines().filter(|l| l.starts_with('[')).collect();
    assert_eq!(
        told,
        [
            "[1/4] one loop: take everything off, then Enter",
            "[2/4] one loop: press row 1, column 1 with 100 g, then Enter",
            "[3/4] one loop: press row 1, column 1 with 50 g, then Enter",
            "[4/4] one loop: take everything off, then Enter",
        ]
    );
    assert!(run.err.contains("4 recordings made"), "{run}");
    let report = Report(serde_json::from_str(&run.out).unwrap());
    assert_eq!(report.number((0, 0), 0, "loops"), 1.0);
    let bytes = || MADE.map(|name| std::fs::read(folder.path(name)).unwrap());
    let before = bytes();
    for name in MADE {
        folder.good(&format!("convert {name} -o {name}.txt"));
        assert!(folder.numbers(&format!("{name}.txt")).len() >= 3 * 24);
    }
    // Nothing is made twice, and nobody is asked.
    let again = folder.taxel_with(LIVE, "");
    assert_eq!(again.code, Some(0), "{again}");
    assert!(again.err.starts_with("0 recordings made"), "{again}");
    assert_eq!(again.out, run.out);
    assert!(before == bytes());
}

#[test]
fn what_was_recorded_before_nobody_pressed_enter_is_kept() {
    let folder = unmade();
    let run = folder.taxel_with(LIVE, "\n\n");
    insta::assert_snapshot!(without_frames(&run.err), @r"
    4 recordings to make; Enter begins one, Ctrl-C ends: what was recorded is kept
    [1/4] one loop: take everything off, then Enter
    [2/4] one loop: press row 1, column 1 with 100 g, then Enter
    [3/4] one loop: press row 1, column 1 with 50 g, then Enter
    error: nobody can press Enter: standard input has ended
    hint: run it in a terminal; what was recorded is kept, and a next run goes on from there
    ");
    assert_eq!(run.code, Some(2), "{run}");
    assert_eq!(
        MADE.map(|name| folder.exists(name)),
        [true, true, false, false]
    );
    assert!(!folder.names().iter().any(|name| name.contains("partial")));
    let bytes = std::fs::read(folder.path("9.mcap")).unwrap();
    let run = folder.taxel_with(LIVE, "\n\n");
    assert_eq!(run.code, Some(0), "{run}");
    assert!(run.err.contains("2 recordings made"), "{run}");
    assert!(bytes == std::fs::read(folder.path("9.mcap")).unwrap());
}

/// Messages without how many frames a fast source gave.
fn without_frames(err: &str) -> String {
    let lines = err.lines().filter(|line| !line.contains(" frames in "));
    lines.collect::<Vec<_>>().join("\n")
}

#[test]
fn a_frame_that_a_trial_asks_for_is_recorded() {
    let folder = unmade();
    folder.write(
        "t.csv",
        "recording,frame,total_g,x_mm,y_mm\na.mcap,7,100,3,4.5\n",
    );
    folder.plan(
        "live_frames = 2\n[[experiment]]\nkind = \"accuracy\"\nname = \"a\"\ntrials = \"t.csv\"\n",
    );
    let run = folder.taxel_with(LIVE, "\n");
    assert_eq!(run.code, Some(0), "{run}");
    assert!(
        run.err
            .contains("[1/1] a: press at x 3 mm, y 4.5 mm, 100 g in all, then Enter"),
        "{run}"
    );
}

#[test]
fn what_cannot_be_measured_live_is_refused() {
    let folder = unmade();
    for (address, says) in [
        ("file:r.mcap", "is a recording, not a live sensor"),
        ("stdin:", "both the sensor and the Enter key"),
        ("nonsense", "is not a source"),
    ] {
        let run = folder.taxel(&format!("evaluate plan.toml --live {address}"));
        assert_eq!(run.code, Some(2), "{run}");
        assert!(run.err.contains(says), "{run}");
    }
    folder.write("t.csv", "recording,row,column,load_g\nr.npy,1,1,0\n");
    let run = folder.taxel(LIVE);
    assert_eq!(run.code, Some(2), "{run}");
    assert!(
        run.err
            .contains("r.npy does not exist, and what is measured is recorded as .mcap"),
        "{run}"
    );
}

#[cfg(unix)]
#[test]
fn ctrl_c_ends_the_wait_for_enter() {
    use std::io::{BufRead, BufReader};
    use std::process::Command;

    let folder = unmade();
    let mut child = folder.spawn(LIVE);
    // Standard input stays open: nobody presses Enter, and nobody has gone.
    let input = child.stdin.take();
    let mut err = BufReader::new(child.stderr.take().unwrap());
    let mut line = String::new();
    while !line.starts_with("[1/4]") {
        line.clear();
        assert!(
            err.read_line(&mut line).unwrap() > 0,
            "it ended without asking"
        );
    }
    let pid = child.id().to_string();
    assert!(
        Command::new("kill")
            .args(["-INT", &pid])
            .status()
            .unwrap()
            .success()
    );
    let mut words = String::new();
    std::io::Read::read_to_string(&mut err, &mut words).unwrap();
    let run = Run::from(child.wait_with_output().unwrap());
    drop(input);
    assert_eq!(run.code, Some(2), "{run}");
    assert!(
        words.starts_with("error: ended by Ctrl-C\nhint: what was recorded is kept"),
        "{words}"
    );
}
