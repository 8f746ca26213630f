//! Estimates beside known loads.

use std::fmt::Write;

use super::{conductances, near, siemens};
use crate::run::Folder;

/// Six frames of three loads each in one row and one more, with their places and totals; the loads as values too.
pub(super) fn presses(folder: &Folder) {
    let mut table = "recording,frame,row,column,load_g,total_g,x_mm,y_mm\n".to_owned();
    let (mut frames, mut truth) = (Vec::new(), Vec::new());
    for frame in 0..6usize {
        let scale = 40.0 * (frame + 1) as f64;
        let loads: [(usize, usize, f64); 4] = [
            (1, 1, scale),
            (1, 3, 2.0 * scale),
            (1, 4, scale),
            (3, 3, scale),
        ];
        let total: f64 = loads.iter().map(|l| l.2).sum();
        let centre = |of: &dyn Fn(&(usize, usize, f64)) -> f64| {
            2.0 * loads.iter().map(|l| of(l) * l.2).sum::<f64>() / total
        };
        let (x, y) = (centre(&|l| l.1 as f64), centre(&|l| l.0 as f64));
        writeln!(
            table,
            "presses.txt,{frame},1,3,{},{total},{x},{y}",
            2.0 * scale
        )
        .unwrap();
        frames.push(loads.map(|(r, c, load)| (r, c, siemens(load))).to_vec());
        truth.push(loads.to_vec());
    }
    folder.scan("sensor.toml", "presses.txt", &frames);
    folder.write("t.csv", &table);
    folder.write("truth.csv", &conductances(&truth, 0.0));
}

#[test]
fn the_exact_inverse_has_no_error_and_the_raw_reading_has_one() {
    let folder = Folder::new();
    presses(&folder);
    folder.plan(
        "[[experiment]]\nkind = \"accuracy\"\nname = \"presses\"\ntrials = \"t.csv\"\nranges_g = [0, 300]\n\
         [[experiment]]\nkind = \"accuracy\"\nname = \"frames\"\nrecording = \"presses.txt\"\n\
         truth_g = \"truth.csv\"\nframes_per_experiment = 2\nranges_g = [0, 300]\n",
    );
    let report = folder.evaluated();
    // Taxel, by load, total, place.
    for (table, tolerance) in [(0, 0.02), (2, 0.1)] {
        let (bias, low, high, experiments) = report.estimate((0, table), 1, "bias");
        assert_eq!(experiments, 6);
        assert!(low <= bias && bias <= high);
        for column in ["mean absolute", "root mean square", "95th percentile"] {
            near(report.number((0, table), 1, column), 0.0, tolerance);
        }
        let raw = report.estimate((0, table), 0, "bias");
        assert!(raw.2 < -1.0, "{raw:?}");
    }
    near(report.number((0, 3), 1, "mean"), 0.0, 1e-3);
    assert!(report.number((0, 3), 0, "mean") > 2e-3);
    let names: Vec<&str> = report.table(0, 1)["rows"]
        .as_array()
        .unwrap()
        .iter()
        .map(|row| row[0].as_str().unwrap())
        .collect();
    assert_eq!(
        names,
        [
            "raw, 0 to 300 g",
            "raw, from 300 g",
            "auto, 0 to 300 g",
            "auto, from 300 g"
        ]
    );
    // Loads of 80, 160, 240 g; 320, 400, 480 g.
    assert_eq!(report.number((0, 1), 0, "readings"), 3.0);
    assert!(report.number((0, 1), 0, "bias") > report.number((0, 1), 1, "bias"));
    // Whole frames: four loaded taxels in six frames, of which two are one experiment.
    assert_eq!(report.number((1, 0), 1, "readings"), 24.0);
    let (error, _, _, experiments) = report.estimate((1, 0), 1, "mean absolute");
    assert_eq!(experiments, 3);
    near(error, 0.0, 0.02);
    near(report.number((1, 2), 1, "mean absolute"), 0.0, 0.1);
    near(report.number((1, 3), 1, "mean"), 0.0, 1e-3);
    // Rounding is all that is off, and the intervals are by rounding; raw readings have none.
    assert_eq!(report.cell((1, 4), 0, ""), "auto, loaded taxels");
    assert_eq!(report.number((1, 4), 0, "readings"), 24.0);
    assert_eq!(report.estimate((1, 4), 0, "inside, %").3, 3);
    assert!(report.estimate((1, 4), 0, "inside, %").0 >= 90.0);
    assert_eq!(report.number((1, 4), 2, "readings"), 6.0);
    near(report.number((1, 5), 1, "largest ghost, g"), 0.0, 0.05);
    near(report.number((1, 5), 1, "index"), 0.0, 1e-4);
    near(report.number((1, 5), 1, "of the worst taxel"), 0.0, 1e-3);
    let ghost = |row| report.number((1, 5), row, "largest ghost, g");
    assert!(ghost(0) > 10.0 * ghost(1), "{} {}", ghost(0), ghost(1));
}

#[test]
fn a_table_may_mix_lines_about_taxels_and_about_the_whole() {
    let folder = Folder::new();
    presses(&folder);
    folder.write(
        "t.csv",
        "recording,frame,row,column,load_g,total_g\npresses.txt,0,1,3,80,\npresses.txt,1,,,,400\n",
    );
    folder.plan("[[experiment]]\nkind = \"accuracy\"\nname = \"a\"\ntrials = \"t.csv\"\n");
    let report = folder.evaluated();
    near(report.number((0, 0), 1, "mean absolute"), 0.0, 0.02);
    near(report.number((0, 1), 1, "mean absolute"), 0.0, 0.1);
    assert_eq!(report.number((0, 0), 1, "readings"), 1.0);
}

#[test]
fn loads_outside_of_their_intervals_are_counted() {
    let folder = Folder::new();
    presses(&folder);
    // 80, 160, 240 g stand there; the third line is wrong.
    folder.write(
        "t.csv",
        "recording,frame,row,column,load_g,total_g\npresses.txt,0,1,3,80,\npresses.txt,1,1,3,160,\n\
         presses.txt,2,1,3,245,\npresses.txt,3,,,,900\n",
    );
    folder.plan("[[experiment]]\nkind = \"accuracy\"\nname = \"a\"\ntrials = \"t.csv\"\n");
    let report = folder.evaluated();
    let held = (0, 2);
    assert_eq!(report.cell(held, 0, ""), "auto, taxel");
    near(report.estimate(held, 0, "inside, %").0, 200.0 / 3.0, 1e-9);
    // 4 × 160 g and 2 times 160 g: 800 g, not 900.
    assert_eq!(report.cell(held, 1, ""), "auto, whole array");
    near(report.number(held, 1, "inside, %"), 0.0, 1e-9);
}
