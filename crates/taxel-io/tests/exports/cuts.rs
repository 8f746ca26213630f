//! Cuts of real exports. What they hold was found by another reader (lines of Python), not by this one.

use taxel::Mark;
use taxel_io::exports::{self, Quantity};

use super::*;

#[test]
fn f_scan_is_read_as_pressures_and_as_the_raw_counts_behind_them() {
    let file = cut("fscan.asf");
    let sensor = sensor_of(&file);
    assert_eq!(
        (sensor.rows(), sensor.columns(), sensor.taxels()),
        (60, 21, 955)
    );
    assert_eq!(sensor.array().pitch_mm, [5.08, 5.08]);
    near(&sums(&file), &[35389.0, 35819.0, 34574.0], 0.0);
    near(
        &forces(&file),
        &[913.2626896, 924.3594416, 892.2304736],
        1e-9,
    );
    let frames = read(&file);
    let times: Vec<_> = frames
        .iter()
        .map(|read| read.frame.time_secs.unwrap())
        .collect();
    near(&times, &[0.0, 0.032, 0.064], 1e-12);
    assert_eq!(largest(&frames[2]), 463.0);
    let absent = frames[0].frame.count(Mark::Absent);
    assert_eq!(absent, 305);

    let raw = file.with_file_name("fscan.asf#raw");
    let sensor = sensor_of(&raw);
    assert_eq!(sensor.max_count(), 255.0);
    let frames = read(&raw);
    // 463 kPa / 5.940115 kPa.
    assert_eq!(largest(&frames[2]), 78.0);
    assert!(
        frames
            .iter()
            .all(|read| read.frame.values().iter().all(|count| count.fract() == 0.0))
    );
    // What was rounded away is there again: 0.1 % here.
    near(&forces(&raw), &[913.2626896, 924.3594416, 892.2304736], 1.0);
    let written = sensor.exported().unwrap();
    assert!((written.threshold.unwrap() - 3.0 * 5.940115).abs() < 1e-5);
    assert!(
        !written.header.as_ref().unwrap().contains("FraserP10"),
        "{written:?}"
    );
}

/// A recording that is to be calibrated again: whoever has a sensor file of the mat gets the counts that its converter gave.
#[test]
fn a_sensor_file_of_ones_own_gets_raw_counts() {
    let file = cut("fscan.asf");
    let own = sensor_of(&file.with_file_name("fscan.asf#raw"));
    let own = own.edited(|spec| spec.exported = None).unwrap();
    let outcome = read_with(&file, &own, false);
    let counts: Vec<f64> = outcome.frames.iter().map(largest).collect();
    assert_eq!(counts, [52.0, 64.0, 78.0]);
}

#[test]
fn i_scan_has_times_of_its_own_and_sums_to_check_by() {
    let file = cut("iscan.csv");
    let (about, survey) = exports::survey(&file).unwrap().unwrap();
    let pad = &about.pads[0];
    assert_eq!((pad.rows, pad.columns, pad.taxels()), (28, 28, 484));
    assert_eq!((pad.quantity, survey.unit_per_count), (Quantity::Raw, None));
    assert_eq!(about.program, "Tekscan Pressure Measurement System 6.10I");
    near(&sums(&file), &[310.0, 307.0, 308.0], 0.0);
    let frames = read(&file);
    let times: Vec<_> = frames.iter().map(|read| read.frame.time_secs).collect();
    assert_eq!(times, [Some(0.0), Some(0.1), Some(0.2)]);
    let numbers: Vec<_> = frames.iter().map(|read| read.number).collect();
    assert_eq!(numbers, [Some(1), Some(2), Some(3)]);
    // They are counts of a sensor that nobody knows.
    assert!(sensor_of(&file).material().is_none());
}

#[test]
fn pedar_is_two_insoles_whose_areas_nobody_knows() {
    let folder = Folder::new();
    let file = whole_pedar(&folder);
    let error = exports::sensor_of(&file).unwrap_err().to_string();
    assert!(
        error.contains("holds 2 sensors: left, right") && error.contains("pedar.asc#left"),
        "{error}"
    );
    for (foot, expected) in [
        ("left", [1980.0, 2020.0, 2002.5, 2035.0]),
        ("right", [2670.0, 2695.0, 2702.5, 2727.5]),
    ] {
        let file = file.with_file_name(format!("pedar.asc#{foot}"));
        let sensor = sensor_of(&file);
        assert_eq!((sensor.rows(), sensor.columns()), (1, 99));
        assert!(sensor.material().is_none());
        near(&sums(&file), &expected, 1e-9);
        let frames = read(&file);
        assert_eq!(frames[3].frame.time_secs, Some(0.04));
    }
    let missing = exports::sensor_of(&file.with_file_name("pedar.asc#heel"));
    let error = missing.unwrap_err().to_string();
    assert!(
        error.contains("no sensor `heel`") && error.contains("left, right"),
        "{error}"
    );
}

#[test]
fn pliance_lies_where_its_file_says_and_has_its_forces() {
    let file = cut("pliance.asc");
    let sensor = sensor_of(&file);
    assert_eq!(
        (sensor.rows(), sensor.columns(), sensor.taxels()),
        (29, 28, 812)
    );
    near(&sensor.array().pitch_mm, &[10.28, 5.28], 1e-9);
    near(&[sensor.array().taxel_area_mm2], &[54.28], 1e-9);
    near(&sums(&file), &[4245.002, 4248.335, 4241.669], 1e-6);
    near(&forces(&file), &[230.418709, 230.599624, 230.237793], 1e-5);
    let frames = read(&file);
    let told: Vec<_> = frames
        .iter()
        .map(|read| read.reference_newtons.unwrap())
        .collect();
    assert_eq!(told, [230.410, 230.591, 230.229]);
    // Its own centre of pressure: x = 14.784 cm - 9.609, y = 29.812 cm - 6.849, from the other corner.
    let frame = &frames[1].frame;
    let mean = |of: &dyn Fn(usize) -> f64| {
        let weighed = frame
            .values()
            .iter()
            .enumerate()
            .map(|(at, count)| count * of(at));
        weighed.sum::<f64>() / sum(&frames[1])
    };
    let x_cm = mean(&|at| 0.264 + 0.528 * (at % 28) as f64);
    let y_cm = mean(&|at| 29.298 - 1.028 * (at / 28) as f64);
    near(&[x_cm, y_cm], &[14.784 - 9.609, 29.812 - 6.849], 2e-3);
}

#[test]
fn emed_is_put_back_on_its_plate() {
    let file = cut("emed.lst");
    let sensor = sensor_of(&file);
    assert_eq!((sensor.rows(), sensor.columns()), (95, 64));
    near(&sums(&file), &[32695.0, 32745.0, 32665.0], 0.0);
    near(&forces(&file), &[817.375, 818.625, 816.625], 1e-9);
    let frames = read(&file);
    let told: Vec<_> = frames
        .iter()
        .map(|read| read.reference_newtons.unwrap())
        .collect();
    assert_eq!(told, [817.38, 818.63, 816.63]);
    let loaded = |read: &Read| {
        let each = read
            .frame
            .values()
            .iter()
            .enumerate()
            .filter(|(_, count)| **count > 0.0);
        let rows: Vec<usize> = each.map(|(at, _)| at / 64).collect();
        (rows[0], rows[rows.len() - 1])
    };
    // Rows 30 to 83 of the file, from 1.
    let (first, last) = loaded(&frames[0]);
    assert!(first >= 29 && last <= 82, "{first} {last}");
    assert_eq!(frames[1].number, Some(62));
    assert!((frames[1].frame.time_secs.unwrap() - 0.01).abs() < 1e-12);
}

#[test]
fn xsensor_is_two_insoles_and_no_group_is_one() {
    let file = cut("xsensor.csv");
    let left = file.with_file_name("xsensor.csv#left");
    near(&sums(&left), &[43730.17, 43629.93], 1e-6);
    near(
        &sums(&file.with_file_name("xsensor.csv#right")),
        &[0.0, 0.0],
        0.0,
    );
    let frames = read(&left);
    let told: Vec<_> = frames
        .iter()
        .map(|read| read.reference_newtons.unwrap())
        .collect();
    assert_eq!(told, [432.1, 431.11]);
    let ratios: Vec<f64> = forces(&left)
        .iter()
        .zip(&told)
        .map(|(own, told)| told / own)
        .collect();
    // The file's pitch is rounded: 0.86 cm for 0.8609.
    near(&ratios, &[1.0021, 1.0021], 1e-4);
    let secs = frames[1].frame.time_secs.unwrap() - frames[0].frame.time_secs.unwrap();
    near(&[secs], &[0.013], 1e-9);
    let exported = spec_of(&left).exported.unwrap();
    assert_eq!(
        (exported.unit.as_str(), exported.threshold),
        ("mmHg", Some(51.72))
    );
}

#[test]
fn rsscan_is_newtons_a_sensel() {
    let file = cut("rsscan.txt");
    let sensor = sensor_of(&file);
    assert_eq!((sensor.rows(), sensor.columns()), (20, 63));
    near(&sums(&file), &[163.1, 162.9], 1e-9);
    near(&forces(&file), &[163.1, 162.9], 1e-9);
    let frames = read(&file);
    assert_eq!(frames[1].number, Some(127));
    near(&[frames[1].frame.time_secs.unwrap()], &[1.00794], 1e-12);
}

#[test]
fn zebris_has_the_forces_of_both_feet() {
    let file = cut("zebris.txt");
    let sensor = sensor_of(&file);
    assert_eq!((sensor.rows(), sensor.columns()), (56, 128));
    near(&sums(&file), &[972.5, 887.0], 1e-9);
    near(&forces(&file), &[696.856545, 635.590494], 1e-6);
    let frames = read(&file);
    let told: Vec<_> = frames
        .iter()
        .map(|read| read.reference_newtons.unwrap())
        .collect();
    near(&told, &[697.1, 635.8], 1e-9);
    let header = spec_of(&file).exported.unwrap().header.unwrap();
    assert!(
        !header.contains("nor, mal") && header.contains("Frequency,Hz"),
        "{header}"
    );
}

/// Presses kept as lines of numbers, arrays and recordings are nobody's export.
#[test]
fn own_recordings_are_no_exports() {
    let folder = Folder::new();
    for (name, text) in [
        ("a.csv", "time_secs=0\n1,2,3\n4,5,6\n"),
        ("b.txt", "1,2,3,\n4,5,6,\n"),
        (
            "c.csv",
            "recording,frame,row,column,load_g\na.csv,0,1,2,100\n",
        ),
        ("d.csv", "frame,time\n0,1\n"),
        ("e.txt", "Frame rates of 30 Hz\n1\t2\n"),
        ("f.json", "{\"rows\": 3}"),
        ("g.txt", ""),
    ] {
        let file = folder.write(name, text);
        assert!(!exports::is_export(&file), "{name}");
        assert!(exports::sensor_of(&file).unwrap().is_none(), "{name}");
    }
    assert!(!exports::is_export(folder.0.path()));
}
