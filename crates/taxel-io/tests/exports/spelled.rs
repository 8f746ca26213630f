//! One recording, spelled in every way that programs and spreadsheets have.

use super::*;

const TEKSCAN: &str = "DATA_TYPE MOVIE\nROWS 2\nCOLS 3\nSENSEL_AREA 100 mm2\nSECONDS_PER_FRAME 0.5\nUNITS KPa\nSTART_FRAME 1\nEND_FRAME 2\nASCII_DATA @@\n\nFrame 1\n1,2,3\n4,5,6\n\nFrame 2\n10,0,0\n0,0,0\n\n@@\n";

/// Header lines with something else behind their keys.
fn keys(with: &str) -> String {
    let (header, frames) = TEKSCAN.split_once("ASCII").unwrap();
    let lines = header
        .lines()
        .map(|line| line.replacen(' ', with, 1) + "\n");
    lines.collect::<String>() + "ASCII" + frames
}

fn quoted() -> String {
    let quote = |line: &str| {
        if line.starts_with(|c: char| c.is_alphabetic() || c == '@') {
            format!("\"{line}\"\n")
        } else {
            format!("{line}\n")
        }
    };
    TEKSCAN.lines().map(quote).collect()
}

#[test]
fn tekscan_however_it_is_spelled() {
    let folder = Folder::new();
    let blanks = TEKSCAN.replace("1,2,3", "1 2 3").replace("4,5,6", "4 5 6");
    let blanks = blanks
        .replace("10,0,0", "10 0 0")
        .replace("\n0,0,0", "\n0 0 0");
    for (name, text) in [
        ("plain.asf", TEKSCAN.to_owned()),
        ("tab.asf", keys("\t")),
        ("comma.csv", keys(",")),
        ("semicolon.csv", keys(";")),
        ("colon.asf", keys(": ")),
        ("equal.asf", keys(" = ")),
        ("double.asf", TEKSCAN.replace('\n', "\n\n")),
        ("returns.asf", TEKSCAN.replace('\n', "\r\r\n")),
        ("return.asf", TEKSCAN.replace('\n', "\r")),
        (
            "small.asf",
            TEKSCAN
                .replace("ASCII_DATA", "ascii_data")
                .replace("UNITS", "units"),
        ),
        ("quoted.csv", quoted()),
        ("blanks.asf", blanks),
        ("behind.asf", format!("{TEKSCAN}Total frames: 2\n1,2,3\n")),
    ] {
        let file = folder.write(name, text);
        assert!(exports::is_export(&file), "{name}");
        near(&sums(&file), &[21.0, 10.0], 0.0);
        near(&forces(&file), &[2.1, 1.0], 1e-9);
        near(&[read(&file)[1].frame.time_secs.unwrap()], &[0.5], 0.0);
        assert_eq!(spec_of(&file).exported.unwrap().unit, "KPa", "{name}");
    }
}

/// A second recording behind the first is neither a frame of it nor nothing.
#[test]
fn tekscan_files_of_two_recordings_are_told() {
    let folder = Folder::new();
    let error = error_of(&folder.write("a.asf", TEKSCAN.repeat(2)));
    assert!(
        error.contains("expected nothing behind the closing line"),
        "{error}"
    );
}

#[test]
fn cells_without_a_sensel() {
    let folder = Folder::new();
    for (one, two) in [
        ("b,2,3\n4,5,b", "b,0,0\n0,0,b"),
        (",2,3\n4,5,", ",0,0\n0,0,"),
    ] {
        let text = TEKSCAN
            .replace("1,2,3\n4,5,6", one)
            .replace("10,0,0\n0,0,0", two);
        let file = folder.write("a.asf", text);
        near(&sums(&file), &[14.0, 0.0], 0.0);
        let marks = read(&file)[1].frame.marks().to_vec();
        assert_eq!(
            (marks[0], marks[5]),
            (taxel::Mark::Absent, taxel::Mark::Absent)
        );
        assert_eq!(sensor_of(&file).taxels(), 4);
    }
    // A cell that is empty in a later frame alone was lost.
    let file = folder.write("a.asf", TEKSCAN.replace("10,0,0", "10,,0"));
    assert!(
        error_of(&file).contains("value 2 of 3 is ``"),
        "{}",
        error_of(&file)
    );
}

#[test]
fn xsensor_with_semicolons_and_decimal_commas() {
    let folder = Folder::new();
    let text = "File:;\"C:\\Users\\Anna\\walk.XSN\"\n\nUnits:;mmHg\n\nThreshold:;51.72\n\nFRAME;1464\nTime; 08:21:17.982\n\nSENSOR;LX100:36.36.02 S0240\nRows;2\nColumns;3\nSensel Width (cm);1.27\nSensel Height (cm);1.27\nEst. Load (N);21.5\nSENSELS\n100.5;200;300\n0;0;400\n";
    for text in [text.to_owned(), text.replace('.', ",")] {
        let file = folder.write("x.csv", text);
        near(&sums(&file), &[1000.5], 1e-9);
        near(&spec_of(&file).array.pitch_mm, &[12.7, 12.7], 1e-9);
        near(&[read(&file)[0].reference_newtons.unwrap()], &[21.5], 1e-9);
        let exported = spec_of(&file).exported.unwrap();
        assert_eq!(exported.threshold, Some(51.72));
        assert!(!exported.header.unwrap().contains("Anna"));
    }
    // Behind a comma a semicolon is part of the value.
    let commas = text
        .replace(';', ",")
        .replace("SENSOR,LX100", "SENSOR,LX100; ");
    near(&sums(&folder.write("x.csv", commas)), &[1000.5], 1e-9);
}

fn insole(names: &str, lines: &[&str]) -> String {
    let matrix = |first: u32| {
        let cells = (0..495).map(|at| {
            if at == 0 {
                first.to_string()
            } else {
                "0".to_owned()
            }
        });
        format!("\"[{}]\"", cells.collect::<Vec<_>>().join(", "))
    };
    let lines = lines.iter().map(|line| {
        line.replace("LEFT", &matrix(7))
            .replace("RIGHT", &matrix(9))
    });
    format!("{names}\n{}\n", lines.collect::<Vec<_>>().join("\n"))
}

/// The distance of two lines, seconds.
fn step(folder: &Folder, name: &str, times: [&str; 2]) -> f64 {
    let lines = times.map(|time| format!("{time},LEFT"));
    let text = insole(&format!("{name},Matrix_0"), &[&lines[0], &lines[1]]);
    let file = folder.write("i.csv", text);
    let secs = |at: usize| read(&file)[at].frame.time_secs.unwrap();
    secs(1) - secs(0)
}

#[test]
fn insoles_tell_the_unit_of_their_times() {
    let folder = Folder::new();
    for (name, times, secs) in [
        ("time_s", ["10", "10.5"], 0.5),
        ("time_ms", ["1000", "1010"], 0.01),
        ("timestamp_us", ["1000", "2000"], 1e-3),
        ("time (ns)", ["1000000", "2000000"], 1e-3),
        ("Timestamp", ["1727034929.5", "1727034930.0"], 0.5),
        ("Timestamp", ["1727034929500", "1727034930000"], 0.5),
        ("Timestamp", ["1727034929500000", "1727034930000000"], 0.5),
        (
            "Timestamp",
            ["1727034929500000000", "1727034930000000000"],
            0.5,
        ),
        ("recording time", ["1", "3"], 2.0),
        ("t", ["1", "3"], 2.0),
    ] {
        near(&[step(&folder, name, times)], &[secs], 1e-5 * secs.max(0.1));
    }
    // What only sounds like it is no time.
    let text = insole(
        "times_pressed,Matrix_0,Timestamp",
        &["5,LEFT,20", "5,LEFT,21"],
    );
    let file = folder.write("i.csv", text);
    near(&[read(&file)[1].frame.time_secs.unwrap()], &[21.0], 0.0);
}

#[test]
fn insoles_number_their_frames_and_lose_one_foot_alone() {
    let folder = Folder::new();
    let lines = [
        "1,0,LEFT,RIGHT",
        "2,1,LEFT,",
        "3,2,LEFT,RIGHT",
        "4,5,LEFT,RIGHT",
    ];
    let file = folder.write("i.csv", insole("time,Frame,Matrix_0,Matrix_1", &lines));
    let left = file.with_file_name("i.csv#0");
    let outcome = read_with(&left, &sensor_of(&left), false);
    assert!(outcome.error.is_none(), "{:?}", outcome.error);
    assert_eq!(
        (outcome.frames.len(), outcome.frames[3].number),
        (4, Some(5))
    );
    let missing = outcome.missing.join("; ");
    assert!(
        missing.contains("2 of the device's frame numbers missing after number 2"),
        "{missing}"
    );
    let right = file.with_file_name("i.csv#1");
    let outcome = read_with(&right, &sensor_of(&right), true);
    assert_eq!((outcome.frames.len(), outcome.left_out.len()), (3, 1));
    assert!(outcome.left_out[0].1.contains("0 numbers in `Matrix_1` at"));
}

#[test]
fn insoles_of_one_foot_and_of_another_code_page() {
    let folder = Folder::new();
    let text = insole("time,Matrix_1,note", &["1,RIGHT,mu\u{df}"]);
    let latin: Vec<u8> = text.chars().map(|c| c as u8).collect();
    let file = folder.write("i.csv", latin);
    near(&sums(&file), &[9.0], 0.0);
}

#[test]
fn tactilus_behind_a_byte_order_mark() {
    let folder = Folder::new();
    let text = "\u{feff}{\"tactilus_rows\":1,\"tactilus_columns\":2,\"snapshots\":{\"0\":{\"tactilus_readings\":[1,2]}}}";
    near(&sums(&folder.write("t.json", text)), &[3.0], 0.0);
}

/// Archives and sheets are no text, and what to do is said.
#[test]
fn packed_files_are_told_in_words() {
    let folder = Folder::new();
    for (name, bytes, says) in [
        (
            "a.asf.gz",
            &b"\x1F\x8B\x08\0\0"[..],
            ["packed by gzip", "unpack it"],
        ),
        ("a.xlsx", b"PK\x03\x04\0\0", ["(.xlsx)", "as text or CSV"]),
        (
            "a.xls",
            b"\xD0\xCF\x11\xE0\xA1\xB1\x1A\xE1",
            ["old sheet (.xls)", "as text or CSV"],
        ),
    ] {
        let error = exports::sensor_of(&folder.write(name, bytes))
            .unwrap_err()
            .to_string();
        assert!(
            says.iter().all(|part| error.contains(part)),
            "{name}: {error}"
        );
    }
}
