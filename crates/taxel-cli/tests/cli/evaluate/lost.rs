//! Frames that are left out: exit code 3.

use super::{Pressed, REST, Report, conductances, near};
use crate::run::Folder;

#[test]
fn frames_that_cannot_be_read_are_left_out_and_told() {
    let folder = Folder::new();
    let frames: Vec<Pressed> = (0..4)
        .map(|i| vec![(1, 2, 1e-4 * f64::from(i + 1))])
        .collect();
    folder.scan("sensor.toml", "whole.txt", &frames);
    let whole = folder.read("whole.txt");
    let mut lines: Vec<&str> = whole.lines().collect();
    lines[4] = "24,x,24,24,24,24,";
    folder.write("hurt.txt", &lines.join("\n"));
    folder.write(
        "t.csv",
        "recording,frame,row,column,load_g\nhurt.txt,0,1,2,10\nhurt.txt,2,1,2,30\nhurt.txt,3,1,2,40\n",
    );
    folder.plan(
        "[[experiment]]\nkind = \"response\"\nname = \"r\"\ntrials = \"t.csv\"\nvalue = \"siemens\"\n",
    );
    let run = folder.taxel("evaluate plan.toml --json");
    assert_eq!(run.code, Some(3), "{run}");
    assert!(run.err.contains("frame 1 left out"), "{run}");
    let report = Report(serde_json::from_str(&run.out).unwrap());
    assert!(report.paragraphs(0).contains("1 frames could not be read"));
    // The others keep their numbers.
    for (row, wanted) in [(0, 1e-4), (1, 3e-4), (2, 4e-4)] {
        near(report.number((0, 1), row, "mean"), wanted, 1e-7);
    }
    // The loads of the frame that is missing are passed over too.
    let truth: Vec<Pressed> = (0..4)
        .map(|i| {
            vec![(
                1,
                2,
                ((1e-4 * f64::from(i + 1) - REST) / 8.29e-6).powf(1.0 / 0.857),
            )]
        })
        .collect();
    folder.write("truth.csv", &conductances(&truth, 0.0));
    folder.plan(
        "[[experiment]]\nkind = \"accuracy\"\nname = \"a\"\nrecording = \"hurt.txt\"\ntruth_g = \"truth.csv\"\n",
    );
    let run = folder.taxel("evaluate plan.toml --json");
    assert_eq!(run.code, Some(3), "{run}");
    let report = Report(serde_json::from_str(&run.out).unwrap());
    assert_eq!(report.number((0, 0), 1, "readings"), 3.0);
    near(report.number((0, 0), 1, "95th percentile"), 0.0, 0.05);
}

#[test]
fn frames_that_no_conductances_explain_are_told() {
    let folder = Folder::new();
    folder.scan(
        "sensor.toml",
        "r.txt",
        &[(0..24).map(|i| (i / 6, i % 6, 1e-3)).collect()],
    );
    folder.other_sensor(
        "sensor.toml",
        "r_mux_row_ohms = 10.0",
        "r_mux_row_ohms = 2000.0",
    );
    folder.write("t.csv", "recording,row,column\nr.txt,1,1\n");
    folder.plan("[[experiment]]\nkind = \"repeatability\"\nname = \"r\"\ntrials = \"t.csv\"\n");
    // Counts are what they are.
    folder.good("evaluate plan.toml");
    let plan = folder.read("plan.toml");
    folder.write("plan.toml", &(plan + "value = \"siemens\"\n"));
    // Nothing is left to evaluate.
    let run = folder.taxel("evaluate plan.toml");
    assert_eq!(run.code, Some(1), "{run}");
    assert!(run.err.contains("its 0 readings are not enough"), "{run}");
    assert!(run.err.contains("1 frame was left out"), "{run}");
}

/// A frame that no conductances explain is in no figure: its zeros were never measured.
#[test]
fn frames_without_an_answer_are_in_no_figure() {
    let folder = Folder::new();
    let light = || vec![(1, 1, 1e-4)];
    folder.scan(
        "sensor.toml",
        "r.txt",
        &[
            light(),
            (0..24).map(|i| (i / 6, i % 6, 1e-3)).collect(),
            light(),
        ],
    );
    folder.other_sensor(
        "sensor.toml",
        "r_mux_row_ohms = 10.0",
        "r_mux_row_ohms = 2000.0",
    );
    folder.write("t.csv", "recording,row,column\nr.txt,1,1\n");
    let plan = "[[experiment]]\nkind = \"repeatability\"\nname = \"r\"\ntrials = \"t.csv\"\n";
    folder.plan(plan);
    let run = folder.good("evaluate plan.toml --json");
    let report = Report(serde_json::from_str(&run.out).unwrap());
    assert_eq!(report.number((0, 0), 0, "readings"), 3.0);
    folder.plan(&format!("{plan}value = \"siemens\"\n"));
    let run = folder.taxel("evaluate plan.toml --json");
    assert_eq!(run.code, Some(3), "{run}");
    let report = Report(serde_json::from_str(&run.out).unwrap());
    assert!(
        report.paragraphs(0).contains("1 frames could not be read"),
        "{run}"
    );
    assert_eq!(report.number((0, 0), 0, "readings"), 2.0, "{run}");
    // Both are the same press: with the zeros of the third the mean would be a third less.
    assert!(report.number((0, 0), 0, "CV, %") < 0.1, "{run}");
}

/// A row without an answer is no measurement, whether the sensor file knows of it or not: it is named, and no sum expects what
/// stands on it.
#[test]
fn what_stands_on_a_dead_row_is_in_no_figure() {
    let folder = Folder::new();
    folder.good(
        "simulate --sensor econe --pattern blobs --frames 8 --seed 3 --truth truth.npy --truth-sensor sensor.toml -o whole.txt",
    );
    let sensor = folder.read("sensor.toml");
    folder.write("dead.toml", &(sensor + "\n[screen]\ndead_rows = [30]\n"));
    folder.good("simulate --sensor dead.toml --pattern blobs --frames 8 --seed 3 -o dead.txt");
    let totals = ["whole.txt", "dead.txt"].map(|recording| {
        folder.plan(&format!(
            "[[experiment]]\nkind = \"accuracy\"\nname = \"a\"\nrecording = \"{recording}\"\ntruth_g = \"truth.npy\"\n"
        ));
        let run = folder.good("evaluate plan.toml --json");
        let report = Report(serde_json::from_str(&run.out).unwrap());
        let told = "dead.txt: row 30 is dead";
        let is_dead = recording == "dead.txt";
        assert_eq!(report.paragraphs(0).contains(told), is_dead, "{run}");
        assert_eq!(run.err.contains(told), is_dead, "{run}");
        let unmeasured = report.paragraphs(0).contains("was measured is in no figure");
        assert_eq!(unmeasured, is_dead, "{run}");
        report.number((0, 1), 1, "mean absolute")
    });
    println!("{totals:?}");
    assert!(totals[1] < 1.3 * totals[0], "{totals:?}");
}
