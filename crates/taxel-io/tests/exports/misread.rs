//! Files that a reader could take for something else: each is read right, or refused, or said to be cut.

use super::*;

const SENSOR: &str = "Rows,2\nColumns,3\nSensel Width (cm),1\nSensel Height (cm),1\nSENSELS\n";

fn xsensor(frames: &[&[(&str, &str)]]) -> String {
    let mut text = "File:,x\nUnits:,mmHg\n\n".to_owned();
    for (number, sensors) in frames.iter().enumerate() {
        text += &format!("FRAME,{}\nTime, 08:21:1{number}.0\n", number + 1);
        for (name, rows) in *sensors {
            text += &format!("SENSOR,{name}\n{SENSOR}{rows}");
        }
    }
    text
}

const ROWS: &str = "1,2,3\n4,5,6\n";

fn tekscan(header: &str, frames: &str) -> String {
    format!("DATA_TYPE MOVIE\nROWS 2\nCOLS 2\n{header}\nASCII_DATA @@\n\n{frames}@@\n")
}

const FRAMES: &str = "Frame 1\n1,2\n3,4\n\nFrame 2\n5,6\n7,8\n\n";

#[test]
fn exponents_in_headers() {
    let folder = Folder::new();
    let header = "UNITS KPa\nSENSEL_AREA 2e-006 m2\nROW_SPACING 1e-003 meters\nCOL_SPACING 2e-003 meters\nSECONDS_PER_FRAME 3.2e-002";
    let file = folder.write("a.asf", tekscan(header, FRAMES));
    near(&forces(&file), &[0.02, 0.052], 1e-12);
    near(&[read(&file)[1].frame.time_secs.unwrap()], &[0.032], 1e-12);
}

/// `1,200` beside `20.5` is no 1.2.
#[test]
fn commas_that_part_thousands() {
    let folder = Folder::new();
    let frame = [("S1", "10.5,11.5,12.5\n20.5,\"1,210\",3.0\n")];
    let file = folder.write("x.csv", xsensor(&[&frame, &frame]));
    let error = error_of(&file);
    assert!(
        error.contains("`\"1,210\"`") && error.contains("expected decimals behind a point"),
        "{error}"
    );
    let frames = "Frame 0 (0.00 ms)\n1.5\t2.5\n1,234\t0\n\nFrame 1 (4.00 ms)\n1\t2\n3\t4\n\n";
    let error = error_of(&folder.write("r.txt", frames));
    assert!(error.contains("`1,234` at"), "{error}");
    // One sign alone is whatever the computer was set to.
    let file = folder.write("c.txt", frames.replace('.', ","));
    near(&sums(&file), &[1.5 + 2.5 + 1.234, 10.0], 1e-9);
}

#[test]
fn xsensor_rows_and_columns_that_are_too_many() {
    let folder = Folder::new();
    for (rows, expected) in [
        ("1,2,3,4\n4,5,6,7\n", "4 values"),
        ("1,2,3\n4,5,6\n7,8,9\n", "expected a line with a key"),
    ] {
        let frame = [("S1", rows)];
        let error = error_of(&folder.write("x.csv", xsensor(&[&frame, &frame])));
        assert!(error.contains(expected), "{error}");
    }
    // What only pads a table is none.
    let frame = [("S1", "1,2,3,,,\n4,5,6,,,\n")];
    near(
        &sums(&folder.write("x.csv", xsensor(&[&frame]))),
        &[21.0],
        0.0,
    );
}

#[test]
fn xsensor_sensors_of_one_name_and_names_with_a_hash() {
    let folder = Folder::new();
    let frame = [("S#1", ROWS), ("S#1", "0,0,0\n0,0,1\n")];
    let file = folder.write("x.csv", xsensor(&[&frame, &frame]));
    near(&sums(&file.with_file_name("x.csv#S#1")), &[21.0, 21.0], 0.0);
    near(&sums(&file.with_file_name("x.csv#S#1 2")), &[1.0, 1.0], 0.0);
}

#[test]
fn xsensor_ends_within_a_frame() {
    let folder = Folder::new();
    let both = [("A", ROWS), ("B", ROWS)];
    let whole = xsensor(&[&both, &both]);
    let cut_at = |end: &str, keep: usize| {
        let at = whole.rfind(end).unwrap() + keep;
        let file = folder.write("x.csv", &whole[..at]);
        missing_of(&file.with_file_name("x.csv#A"))
    };
    assert_eq!(
        missing_of(&folder.write("x.csv", &whole).with_file_name("x.csv#A")),
        ""
    );
    // Before the last sensor, within its lines, and within its last number.
    for (end, keep) in [("SENSOR,B", 0), ("SENSELS", 0), ("4,5,6", 5)] {
        let missing = cut_at(end, keep);
        assert!(
            missing.contains("the end of the file is missing"),
            "{end}: {missing}"
        );
    }
}

#[test]
fn xsensor_hours_before_and_after_noon() {
    let folder = Folder::new();
    let frame = [("S1", ROWS)];
    let text = xsensor(&[&frame, &frame])
        .replace("08:21:10.0", "12:59:59.0 PM")
        .replace("08:21:11.0", "1:00:00.0 PM");
    let frames = read(&folder.write("x.csv", text));
    let secs = |at: usize| frames[at].frame.time_secs.unwrap();
    near(&[secs(1) - secs(0)], &[1.0], 1e-9);
}

/// The last number may have lost digits.
#[test]
fn a_last_line_without_its_end_is_told() {
    let folder = Folder::new();
    let text = "Frame 0 (0.00 ms)\n1\t2\n3\t4\n\nFrame 1 (4.00 ms)\n1\t2\n3\t412";
    assert!(missing_of(&folder.write("r.txt", text)).contains("the end of the file is missing"));
    assert_eq!(missing_of(&folder.write("r.txt", format!("{text}\n"))), "");
    let line = vec!["7"; 32 * 64].join("\t");
    assert!(
        missing_of(&folder.write("f.txt", format!("{line}\n{line}")))
            .contains("the end of the file is missing")
    );
    // What stands behind the frames of this one says where its sensors lie.
    let whole = latin(&cut("pliance.asc"));
    let at = whole.find("x[c]").unwrap();
    assert!(
        missing_of(&folder.write("p.asc", &whole[..at])).contains("the end of the file is missing")
    );
}

#[test]
fn zebris_rows_lie_by_their_numbers() {
    let folder = Folder::new();
    let text = latin(&cut("zebris.txt"));
    for (own, other) in [("\ny4\t", "\ny5\t"), ("\ny1\t", "\ny57\t")] {
        let error = error_of(&folder.write("z.txt", text.replace(own, other)));
        assert!(error.contains("expected each of the rows y"), "{error}");
    }
    // From the last row to the first, it is the same picture.
    let expected = read(&folder.write("z.txt", &text));
    let (mut turned, mut rows) = (String::new(), Vec::new());
    for line in text.split_inclusive('\n') {
        if line.starts_with('y') {
            rows.push(line);
            continue;
        }
        rows.drain(..).rev().for_each(|row| turned += row);
        turned += line;
    }
    let found = read(&folder.write("z.txt", turned));
    assert_eq!(found.len(), expected.len());
    for (found, expected) in found.iter().zip(&expected) {
        assert_eq!(found.frame.values(), expected.frame.values());
    }
}

#[test]
fn tekscan_masks_times_and_scales() {
    let folder = Folder::new();
    let masked = "Frame 1\nB,2\n3,4\n\nFrame 2\n5,6\n7,8\n\n";
    let file = folder.write("m.asf", tekscan("UNITS raw", masked));
    let error = error_of(&file);
    assert!(
        error.contains("value 1 of 2 is 5") && error.contains("first frame has `B`"),
        "{error}"
    );
    // A comma for the point, in a line that commas part.
    let times = FRAMES
        .replace("Frame 1", "Frame 1, 0,0,,")
        .replace("Frame 2", "Frame 2, 0,1,,");
    let file = folder.write("t.csv", tekscan("UNITS raw", &times));
    near(&[read(&file)[1].frame.time_secs.unwrap()], &[0.1], 1e-12);
    // The point of another calibration: the largest value tells the scale.
    let header = "UNITS KPa\nSENSEL_AREA 100 mm2\nCALIBRATION_POINT_1 10 (N) 30 (Raw Sum)\nSATURATION_PRESSURE 255 KPa";
    let frames = "Frame 1\n1.00,2.00\n3.00,4.00\n\nFrame 2\n5.00,6.00\n7.00,8.00\n\n";
    let file = folder.write("s.asf", tekscan(header, frames));
    near(&sums(&file.with_file_name("s.asf#raw")), &[10.0, 26.0], 0.0);
    let frame = &read(&file)[1].frame;
    assert!(frame.marks().iter().all(|mark| *mark == taxel::Mark::Good));
    // One torn frame costs no other, with names of frames between quotes as well.
    let torn = "\"Frame 1\"\n1,2\n3,4\n\n\"Frame 2\"\n5\n7,8\n\n\"Frame 3\"\n5,6\n7,8\n\n";
    let file = folder.write("q.asf", tekscan("UNITS raw", torn));
    let sensor = Sensor::try_from(spec_of(&file)).unwrap();
    assert_eq!(read_with(&file, &sensor, true).frames.len(), 2);
}

/// A spreadsheet of a language with decimal commas parts cells with semicolons.
#[test]
fn tekscan_saved_again_with_semicolons_and_tabs() {
    let folder = Folder::new();
    let header = "ROWS 2\nCOLS 2\nUNITS KPa\nSENSEL_AREA 25,8 mm2";
    let frames = "Frame 1; 0,5;;\nB;2,5\n3,25;4\n;\nFrame 2; 1;;\nB;6\n7;8\n;\n";
    for (separator, name) in [(";", "s.csv"), ("\t", "t.csv")] {
        let text = format!("{header}\nASCII_DATA @@;\n\n{frames}@@;\n").replace(';', separator);
        let file = folder.write(name, text);
        near(&sums(&file), &[9.75, 21.0], 1e-9);
        let frames = read(&file);
        near(&[frames[0].frame.time_secs.unwrap()], &[0.5], 0.0);
        assert_eq!(frames[0].frame.marks()[0], taxel::Mark::Absent);
        near(&[spec_of(&file).array.taxel_area_mm2], &[25.8], 0.0);
    }
}

#[test]
fn tekscan_without_its_last_line_and_with_a_torn_first_frame() {
    let folder = Folder::new();
    let told = "UNITS raw\nSTART_FRAME 1\nEND_FRAME 2";
    let text = tekscan(told, FRAMES).replace("@@\n", "");
    let text = text.replace("ASCII_DATA ", "ASCII_DATA @@\n");
    // All frames are there that the header says.
    near(&sums(&folder.write("a.asf", &text)), &[10.0, 26.0], 0.0);
    let fewer = text.replace("END_FRAME 2", "END_FRAME 3");
    let missing = missing_of(&folder.write("b.asf", fewer));
    assert!(
        missing.contains("the end of the file is missing"),
        "{missing}"
    );
    let file = folder.write("c.asf", text.replace("3,4\n", "3\n"));
    let sensor = sensor_of(&file);
    let kept = read_with(&file, &sensor, true);
    assert_eq!((kept.frames.len(), kept.left_out.len()), (1, 1));
    let error = read_with(&file, &sensor, false).error.unwrap().to_string();
    assert!(error.contains("1 values"), "{error}");
}

#[test]
fn no_unit_is_guessed() {
    let folder = Folder::new();
    for (name, unit, other) in [
        (
            "pedar.asc",
            "pressure values in  kPa",
            "Druckwerte in N/cm2",
        ),
        (
            "pliance.asc",
            "pressure values in kPa",
            "Druckwerte in N/cm2",
        ),
        ("zebris.txt", "Units\tN/cm^2", "Einheit\tN/cm^2"),
        ("fscan.asf", "UNITS KPa", "UNIT KPa"),
    ] {
        let text = latin(&cut(name));
        assert!(text.contains(unit), "{name}");
        let file = folder.write(name, text.replace(unit, other));
        let error = exports::about(&file).map(|_| ()).unwrap_err().to_string();
        assert!(error.contains("no unit in the header"), "{name}: {error}");
    }
}

/// What was never calibrated has no unit to tell.
#[test]
fn tekscan_without_a_calibration_is_raw() {
    let folder = Folder::new();
    let file = folder.write("a.asf", tekscan("NOISE_THRESHOLD 0", FRAMES));
    assert_eq!(spec_of(&file).exported.unwrap().unit, "raw");
    near(&sums(&file), &[10.0, 26.0], 0.0);
}

/// A sensor file of one's own is about a converter: raw counts are those, averaged or not, and pressures are none.
#[test]
fn counts_for_a_sensor_of_one_s_own() {
    let folder = Folder::new();
    let mut spec = spec_of(&folder.write("own.asf", tekscan("UNITS raw", FRAMES)));
    spec.exported = None;
    let sensor = Sensor::try_from(spec).unwrap();
    let frames = FRAMES.replace("3,4", "3.5,4");
    let file = folder.write("raw.asf", tekscan("UNITS raw", &frames));
    let outcome = read_with(&file, &sensor, false);
    near(outcome.frames[0].frame.values(), &[1.0, 2.0, 3.5, 4.0], 0.0);
    let file = folder.write("kpa.asf", tekscan("UNITS KPa", &frames));
    let error = open_counts(&file, ReadOptions::of(&sensor))
        .err()
        .expect("pressures are no counts")
        .to_string();
    assert!(
        error.contains("holds KPa, calibrated by its program"),
        "{error}"
    );
}

/// What spreadsheets call Unicode text.
#[test]
fn two_bytes_a_character_are_told() {
    let folder = Folder::new();
    let text = tekscan("UNITS raw", FRAMES);
    let mut bytes = vec![0xFF, 0xFE];
    bytes.extend(text.encode_utf16().flat_map(u16::to_le_bytes));
    let error = error_of(&folder.write("u.txt", bytes));
    assert!(
        error.contains("(UTF-16)") && error.contains("hint: save it as"),
        "{error}"
    );
}

/// Recordings of one's own, with lines between their frames.
#[test]
fn own_text_is_no_export() {
    let folder = Folder::new();
    let file = folder.write(
        "own.csv",
        "# mine\nFrame 0 (0 ms)\n1,2\n3,4\n\nFrame 1 (10 ms)\n1,2\n3,4\n",
    );
    assert!(!exports::is_export(&file));
}

#[test]
fn apd_below_its_threshold_and_pictures_that_are_missing() {
    let folder = Folder::new();
    let head = "[General]\nUnitPressure=N/cm2\n[Technical]\nSensCountX=1\nSensCountY=2\nLDistX=5\nLDistY=5\nMinIdx=0\nMaxIdx=2\n";
    let file = folder.write(
        "a.apd",
        format!("{head}[Data]\n1\t2\n[Data0]\n-1\t2\n[Data1]\n1\t1\n"),
    );
    let missing = missing_of(&file);
    assert!(
        missing.contains("1 of the frames") || missing.contains("1 frame"),
        "{missing}"
    );
    let file = folder.write("b.apd", format!("{head}[Data]\n1\t2\n[Data0]\n-28.5\t2\n"));
    assert!(error_of(&file).contains("`-28.5`"));
}

#[test]
fn tactilus_readings_that_are_null_cost_their_frame_alone() {
    let folder = Folder::new();
    let file = folder.write(
        "t.json",
        r#"{"tactilus_rows":1,"tactilus_columns":2,"snapshots":{"0":{"tactilus_readings":[1,2]},"1":{"tactilus_readings":[null,2]}}}"#,
    );
    assert!(error_of(&file).contains("snapshot 1 reads null"));
}

/// pedar and pliance number no frames; their times say what is missing and what comes twice.
#[test]
fn lines_that_are_missing_or_come_twice_are_told_by_their_times() {
    let folder = Folder::new();
    for name in ["pedar.asc", "pliance.asc"] {
        let whole = latin(&cut(name));
        let lines: Vec<&str> = whole.lines().collect();
        let named_sensors = lines.iter().position(|line| line.starts_with("time[secs]"));
        let first = named_sensors.unwrap() + 1;
        let named = if name.starts_with("pedar") {
            "#left"
        } else {
            ""
        };
        let missing_with = |lines: Vec<&str>| {
            let file = folder.write(name, lines.join("\r\n"));
            missing_of(Path::new(&format!("{}{named}", file.display())))
        };
        let told = missing_with(lines.clone());
        assert!(
            !told.contains("times") && !told.contains("no later"),
            "{name}: {told}"
        );
        let mut without = lines.clone();
        without.remove(first + 1);
        let told = missing_with(without);
        assert!(
            told.contains("1 of the frames missing by their times after frame 0"),
            "{name}: {told}"
        );
        let mut twice = lines.clone();
        twice.insert(first + 1, lines[first]);
        let told = missing_with(twice);
        assert!(
            told.contains("1 frame is no later than the one before it"),
            "{name}: {told}"
        );
    }
}

#[test]
fn more_frames_than_the_header_says_are_told() {
    let folder = Folder::new();
    let file = |end: u32| {
        let header = format!("START_FRAME 1\nEND_FRAME {end}\nUNITS RAW");
        folder.write("a.asf", tekscan(&header, FRAMES))
    };
    assert_eq!(missing_of(&file(2)), "");
    assert!(missing_of(&file(1)).contains("1 frame more than the file says it has"));
    assert!(missing_of(&file(3)).contains("1 frame missing that the file says it has"));
}

#[test]
fn snapshots_of_json_that_come_twice_or_have_no_number_are_refused() {
    let folder = Folder::new();
    let json = |names: [&str; 2]| {
        let snapshot = |name| format!("\"{name}\": {{\"tactilus_readings\": [1, 2, 3, 4]}}");
        let snapshots = names.map(snapshot).join(", ");
        let text = format!(
            "{{\"tactilus_rows\": 2, \"tactilus_columns\": 2, \"snapshots\": {{{snapshots}}}}}"
        );
        folder.write("t.json", text)
    };
    assert_eq!(sums(&json(["4", "3"])).len(), 2);
    let error = error_of(&json(["3", "3"]));
    assert!(error.contains("snapshot 3 is there twice"), "{error}");
    let error = error_of(&json(["3", "last"]));
    assert!(error.contains("snapshot `last` has no number"), "{error}");
}
