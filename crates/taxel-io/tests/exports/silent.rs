//! Numbers that a reader could get wrong without a word: each is right, or told.

use taxel_io::exports;

use super::*;

/// A pedar file whose header names the sensors of each foot, and whose lines have these.
fn pedar(insoles: &str, sensors: &[u32]) -> String {
    let cells: String = sensors.iter().map(|one| format!("\t{one}")).collect();
    let values: String = (0..sensors.len())
        .map(|at| format!("\t{}", at + 1))
        .collect();
    format!(
        "file name:  a.sol\nsensor type:  y-1865l\ntotal time [secs]:  0.020\ttime per frame [secs]:  0.01000\npressure values in  kPa\n\nmask definition: \n{insoles}\ntime[secs]{cells}\t\n0.01000{values}\t\n0.02000{values}\t\n"
    )
}

#[test]
fn pedar_sensors_are_of_the_foot_that_the_header_says() {
    let folder = Folder::new();
    let both = "left insole: 1,2,3,\nright insole: 4,5,6,7,\n";
    let file = folder.write("p.asc", pedar(both, &[1, 2, 3, 4, 5, 6, 7]));
    for (foot, sum) in [("left", 6.0), ("right", 22.0)] {
        let named = file.with_file_name(format!("p.asc#{foot}"));
        near(&sums(&named), &[sum, sum], 0.0);
    }
    // One foot alone keeps its side, with its name and without.
    let right = "left insole: \nright insole: 1,2,\n";
    let file = folder.write("p.asc", pedar(right, &[1, 2]));
    near(&sums(&file), &[3.0, 3.0], 0.0);
    near(&sums(&file.with_file_name("p.asc#right")), &[3.0, 3.0], 0.0);
    let error = exports::sensor_of(&file.with_file_name("p.asc#left")).unwrap_err();
    assert!(error.to_string().contains("it has right"), "{error}");
    // Without such lines numbers that begin anew tell it.
    let file = folder.write("p.asc", pedar("", &[1, 2, 1]));
    near(&sums(&file.with_file_name("p.asc#left")), &[3.0, 3.0], 0.0);
    // A mask of another recording.
    let error = error_of(&folder.write("p.asc", pedar(both, &[1, 2, 3, 4, 5])));
    assert!(
        error.contains("5 sensors") && error.contains("the 3 of `left insole:`"),
        "{error}"
    );
}

/// Four sensors of pliance, with the lines of their places and areas.
fn pliance(x: &str, area: &str) -> String {
    format!(
        "file name: a.mat date/time 1\nmat type s1\ntotal times [secs]: 0.08 time per frame [secs]: 0.04 scanning rate [Hz]: 25\npressure values in kPa\n\nelectrical:\ntime[secs] 4 5 6 7\n0.04 10.0 0.0 20.0 5.0\n0.08 10.0 40.0 20.0 5.0\nMPP 10.0 40.0 20.0 5.0\n\nsensor 4 5 6 7\nx[c] {x}\ny[c] 0.3 0.3 1.3 1.3\narea {area}\n"
    )
}

#[test]
fn pliance_sensors_in_one_place_are_refused() {
    let folder = Folder::new();
    let file = folder.write("p.asc", pliance("0.3 0.8 0.3 0.8", "0.5 0.5 0.5 0.5"));
    near(&sums(&file), &[35.0, 75.0], 0.0);
    let error = error_of(&folder.write("p.asc", pliance("0.3 0.3 0.3 0.8", "0.5 0.5 0.5 0.5")));
    assert!(
        error.contains("sensors 4 and 5 both lie at x 0.3 cm, y 0.3 cm")
            && error.contains("line 13"),
        "{error}"
    );
}

/// Forces, pressures and areas of contact are by the area of each.
#[test]
fn pliance_areas_that_differ() {
    let folder = Folder::new();
    let file = folder.write("p.asc", pliance("0.3 0.8 0.3 0.8", "0.5 1.0 0.5 0.5"));
    near(&forces(&file), &[1.75, 5.75], 1e-9);
    let sensor = sensor_of(&file);
    let sensor = Sensor::from_toml(&sensor.to_toml()).unwrap();
    let method = taxel::solve::default_method(&sensor).unwrap();
    let mut pipeline = taxel::pipeline::Pipeline::new(&sensor, method).unwrap();
    let frames = read(&file);
    let result = pipeline.process(&frames[1].frame);
    let loads = result.newtons().unwrap();
    let figures = taxel::metric::FrameFigures::with_threshold(loads, &sensor, 0.0);
    near(&[figures.peak_kilopascals], &[40.0], 1e-9);
    near(&[figures.contact_area_mm2], &[250.0], 1e-9);
}

#[test]
fn emed_rows_add_up_to_their_forces() {
    let folder = Folder::new();
    let page = |row: &str| {
        format!(
            "\tMatrix: 3x2\n\tSensor area: 0.25 cm2\n\tPict-No.: 1\n\n\t1\t2\t3\tForce\n{row}\n2\t5\t0\t0\t0.13\nForce\t0.38\t0.5\t0\t0.88\n"
        )
    };
    near(
        &sums(&folder.write("e.lst", page("1\t10\t20\t0\t0.75"))),
        &[35.0],
        0.0,
    );
    // A cell that its picture's sum hardly shows.
    let error = error_of(&folder.write("e.lst", page("1\t10\t21\t0\t0.75")));
    assert!(
        error.contains("row 1 add up to 0.775 N") && error.contains("line 6"),
        "{error}"
    );
}

const FRAMES: &str = "\nASCII_DATA @@\n\nFrame 1, 0.5\n1,2\n\nFrame 2, 1.5\n3,4\n\n@@\n";

#[test]
fn tekscan_units_of_other_languages() {
    let folder = Folder::new();
    let german = "ZEILEN 1\nSPALTEN 2\nZEILENABSTAND 5 mm\nSPALTENABSTAND 5 mm\nEINHEITEN KPa";
    let file = folder.write("a.asf", format!("{german}{FRAMES}"));
    assert_eq!(spec_of(&file).exported.unwrap().unit, "KPa");
    near(&forces(&file), &[0.075, 0.175], 1e-9);
    for (header, says) in [
        ("ROWS 1\nCOLS 2\nENHETER: KPa", "a unit behind a key"),
        ("RADER 1\nKOLONNER 2\nBILDER 2", "most are not Tekscan's"),
    ] {
        let error = error_of(&folder.write("a.asf", format!("{header}{FRAMES}")));
        assert!(error.contains(says) && error.contains("line "), "{error}");
    }
}

#[test]
fn tekscan_lengths_without_a_unit_that_is_known() {
    let folder = Folder::new();
    for spacing in ["127 mils", "1.27"] {
        let header = format!("COL_SPACING 5 mm\nROW_SPACING {spacing}\nUNITS KPa");
        let error = error_of(&folder.write("a.asf", format!("{header}{FRAMES}")));
        let found = format!("unknown unit `{spacing}`");
        assert!(
            error.contains(&found) && error.contains("line 2"),
            "{error}"
        );
    }
}

#[test]
fn times_that_go_back_are_told() {
    let folder = Folder::new();
    let text = format!("UNITS raw{FRAMES}");
    assert_eq!(missing_of(&folder.write("a.csv", &text)), "");
    let missing = missing_of(&folder.write("a.csv", text.replace("1.5\n", "0.4\n")));
    assert_eq!(missing, "1 frame is no later than the one before it");
}

#[test]
fn averaged_raw_counts_add_up_but_for_their_digits() {
    let folder = Folder::new();
    let of = |sum: &str, rows: &str| {
        let text =
            format!("UNITS raw\nASCII_DATA @@\n\nFrame 1, 0,, x,,,Raw Sum=,,{sum}\n{rows}\n\n@@\n");
        folder.write("a.csv", text)
    };
    for (sum, rows) in [
        ("16", "0,5.4\n7.3,3.6"),
        ("0.6", "0.1,0\n0.2,0.3"),
        ("7", "3,4\n0,0"),
    ] {
        assert_eq!(read(&of(sum, rows)).len(), 1, "{sum}");
    }
    for (sum, rows) in [
        ("18", "0,5.4\n7.3,3.6"),
        ("0.9", "0.1,0\n0.2,0.3"),
        ("8", "3,4\n0,0"),
    ] {
        assert!(error_of(&of(sum, rows)).contains("add up to"), "{sum}");
    }
}

#[test]
fn insoles_with_dates_and_times() {
    let folder = Folder::new();
    let cells = vec!["1"; 495].join(", ");
    let text = |times: [&str; 2]| {
        let lines = times.map(|time| format!("{time},\"[{cells}]\"\n"));
        format!("Timestamp,Matrix_0\n{}", lines.concat())
    };
    for times in [
        ["2025-01-02 10:00:00.000", "2025-01-02 10:00:00.020"],
        ["2025-12-31T23:59:59.990Z", "2026-01-01T00:00:00.010Z"],
        ["10:00:00.000", "10:00:00.020"],
    ] {
        let frames = read(&folder.write("i.csv", text(times)));
        let secs = |at: usize| frames[at].frame.time_secs.unwrap();
        near(&[secs(1) - secs(0)], &[0.02], 1e-6);
    }
    let error = error_of(&folder.write("i.csv", text(["now", "then"])));
    assert!(
        error.contains("a time of 3 characters") && error.contains("line 2"),
        "{error}"
    );
}
