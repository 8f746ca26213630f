//! Forces of named regions: in everything that a plan reads, and beside known ones.

use std::fmt::Write;

use super::accuracy::presses;
use super::near;
use crate::run::{Folder, SENSOR};

/// Newtons of a gram-force.
const N: f64 = 9.80665e-3;

const HALVES: &str = "[[region]]\nname = \"left\"\nboxes = [[0, 3, 0, 2]]\n[[region]]\nname = \"right\"\nboxes = [[0, 3, 3, 5]]\n";

/// Frames of 40 g to 240 g on the left, and four times that on the right.
fn pressed() -> Folder {
    let folder = Folder::new();
    presses(&folder);
    folder.write("halves.toml", HALVES);
    folder.plan(
        "[[experiment]]\nkind = \"accuracy\"\nname = \"presses\"\ntrials = \"t.csv\"\n\
         [[experiment]]\nkind = \"accuracy\"\nname = \"frames\"\nrecording = \"presses.txt\"\n\
         truth_g = \"truth.csv\"\n",
    );
    folder
}

#[test]
fn every_region_has_its_force_with_its_interval() {
    let folder = pressed();
    let plain = folder.good("evaluate plan.toml");
    assert!(!plain.out.contains("Force of regions"), "{}", plain.out);
    let run = folder.good("evaluate plan.toml --regions halves.toml --json");
    let report = super::Report(serde_json::from_str(&run.out).unwrap());
    // Presses, frames, regions of each, data.
    for table in 0..2 {
        for (row, grams, share) in [(0, 140.0, 20.0), (1, 560.0, 80.0)] {
            let (force, low, high, experiments) = report.estimate((2, table), row, "force, N");
            near(force, N * grams, 1e-3);
            assert!(low < force && force < high);
            assert_eq!(experiments, 6);
            near(report.number((2, table), row, "of all, %"), share, 0.01);
            let half = report.number((2, table), row, "± of a frame, N");
            assert!(half > 0.0 && half < 0.01, "{half}");
        }
    }
    assert!(report.paragraphs(2).contains("knows of noise alone"));
    // Of frames whose loads are all known, what each region should carry.
    let known = report.table(1, 1);
    assert_eq!(known["caption"], "Load on the region, g");
    let names: Vec<_> = known["rows"].as_array().unwrap().iter().collect();
    assert_eq!(names.len(), 4);
    assert_eq!(names[3][0], "auto, right");
    near(report.number((1, 1), 3, "mean absolute"), 0.0, 0.1);
    assert!(report.number((1, 1), 1, "bias") < -1.0);
}

#[test]
fn regions_come_from_the_plan_and_the_sensor_file_too_and_stand_in_every_report() {
    let folder = pressed();
    let by_option = folder.good("evaluate plan.toml --regions halves.toml");
    folder.good("report plan.toml --regions halves.toml -o r.html");
    let page = folder.read("r.html");
    assert!(page.contains("<h2>Regions</h2>") && page.contains("halves.toml"));
    let plan = folder.read("plan.toml");
    folder.write(
        "plan.toml",
        &plan.replacen("resamples", "regions = \"halves.toml\"\nresamples", 1),
    );
    let regions = |text: &str| {
        let from = text.find("Regions\n=").unwrap();
        let to = text.find("Data\n=").unwrap();
        text[from..to].to_owned()
    };
    assert_eq!(
        regions(&folder.good("evaluate plan.toml").out),
        regions(&by_option.out)
    );
    folder.write("plan.toml", &plan);
    folder.write("sensor.toml", &format!("{SENSOR}{HALVES}"));
    assert_eq!(
        regions(&folder.good("evaluate plan.toml").out),
        regions(&by_option.out)
    );
}

#[test]
fn a_region_is_looked_at_in_place_of_a_taxel() {
    let folder = pressed();
    let mut table = "recording,frame,region,load_g\n".to_owned();
    for frame in 0..6 {
        let load = 40 * (frame + 1);
        writeln!(table, "presses.txt,{frame},left,{load}").unwrap();
        writeln!(table, "presses.txt,{frame},right,{}", 4 * load).unwrap();
    }
    folder.write("t.csv", &table);
    folder.plan(
        "regions = \"halves.toml\"\n[[experiment]]\nkind = \"accuracy\"\nname = \"x\"\ntrials = \"t.csv\"\n\
         [[experiment]]\nkind = \"response\"\nvalue = \"grams\"\nname = \"y\"\ntrials = \"t.csv\"\n",
    );
    let report = folder.evaluated();
    assert_eq!(report.table(0, 0)["caption"], "Load on the region, g: all");
    assert_eq!(report.table(0, 0)["rows"][2][0], "auto, left");
    near(report.number((0, 0), 2, "mean absolute"), 0.0, 0.1);
    near(report.number((0, 0), 3, "mean absolute"), 0.0, 0.2);
    assert_eq!(report.table(0, 1)["rows"][0][0], "auto, region");
    near(report.number((1, 0), 0, "sensitivity"), 1.0, 1e-3);
}

#[test]
fn regions_that_are_not_there_or_not_to_be_read_so_are_refused() {
    let folder = pressed();
    let plan = |kind: &str| {
        folder.plan(&format!(
            "regions = \"halves.toml\"\n[[experiment]]\nkind = \"{kind}\"\nname = \"x\"\ntrials = \"t.csv\"\n"
        ));
        folder.fails("evaluate plan.toml").err
    };
    folder.write(
        "t.csv",
        "recording,frame,region,load_g\npresses.txt,0,middle,4\n",
    );
    let error = plan("accuracy");
    assert!(
        error.contains("t.csv, line 2: no region is called middle; there are: left, right"),
        "{error}"
    );
    folder.write(
        "t.csv",
        "recording,frame,region,load_g\npresses.txt,0,left,4\n",
    );
    let error = plan("response");
    assert!(error.contains("value = \"grams\""), "{error}");
    folder.write(
        "t.csv",
        "recording,frame,region,taxel,load_g\npresses.txt,0,left,A1,4\n",
    );
    let error = plan("accuracy");
    assert!(error.contains("nothing beside a taxel"), "{error}");
}
