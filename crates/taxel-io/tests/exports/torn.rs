//! Lines that come twice or are torn where nothing else tells it: no frame of them is given as if it were whole.

use super::{Folder, cut, latin, missing_of, read, read_with, sensor_of, sum};
use std::path::{Path, PathBuf};

/// A cut with its lines changed.
fn changed(folder: &Folder, name: &str, change: impl Fn(&mut Vec<String>)) -> PathBuf {
    let text = latin(&cut(name)).replace("\r\n", "\n");
    let mut lines: Vec<String> = text.split('\n').map(str::to_owned).collect();
    change(&mut lines);
    let bytes: Vec<u8> = lines.join("\n").chars().map(|c| c as u8).collect();
    folder.write(name, bytes)
}

/// What is given of a file without what is broken in it is of the whole one; how many frames.
fn given_of(file: &Path, whole: &Path) -> usize {
    let sums: Vec<f64> = read(whole).iter().map(sum).collect();
    let outcome = read_with(file, &sensor_of(whole), true);
    for frame in &outcome.frames {
        assert!(sums.contains(&sum(frame)), "{}", file.display());
    }
    let told = outcome.left_out.len() + outcome.missing.len();
    assert!(told > 0 || outcome.frames.len() == sums.len());
    outcome.frames.len()
}

#[test]
fn a_row_that_comes_twice_costs_its_own_frame() {
    let folder = Folder::new();
    for (name, pad, first, rows) in [
        ("fscan.asf", "", "Frame 1", 60),
        ("iscan.csv", "", "Frame 1", 28),
        ("xsensor.csv", "#left", "SENSELS", 31),
    ] {
        let with_pad = |file: PathBuf| PathBuf::from(format!("{}{pad}", file.display()));
        let whole = with_pad(cut(name));
        let frames = read(&whole).len();
        for row in [2, rows / 2, rows] {
            let file = changed(&folder, name, |lines| {
                let begins = lines.iter().position(|line| line.starts_with(first));
                let mut rows = (begins.unwrap() + 1..lines.len())
                    .filter(|&at| lines[at].starts_with(|c: char| c.is_ascii_alphanumeric()));
                let at = rows.nth(row - 1).unwrap();
                lines.insert(at, lines[at].clone());
            });
            let file = with_pad(file);
            assert_eq!(given_of(&file, &whole), frames - 1, "{name}, row {row}");
            // The mask is that of a frame that is whole.
            assert_eq!(sensor_of(&file).taxels(), sensor_of(&whole).taxels());
        }
    }
}

#[test]
fn a_frame_whose_sensor_is_torn_is_told_wherever_it_stands() {
    let folder = Folder::new();
    let frame = |number: u32| {
        format!(
            "Frame: {number}\nTime: \"10:07:0{number}.0\"\nSensor: \"LX\"\nRows: 1\nColumns: 2\nSensels:\n{number} 2.5\n\n"
        )
    };
    let text = format!("Units: N/cm2\n\n{}{}{}", frame(1), frame(2), frame(3));
    let whole = folder.write("whole.txt", &text);
    for torn in 1..=3 {
        let before = format!("0{torn}.0\"\n");
        let file = folder.write("x.txt", text.replace(&before, before.trim_end()));
        let outcome = read_with(&file, &sensor_of(&whole), true);
        let kept: Vec<_> = outcome.frames.iter().map(|read| read.number).collect();
        let expected: Vec<_> = (1..=3).filter(|own| *own != torn).map(Some).collect();
        assert_eq!(kept, expected);
        let told = [
            outcome.missing,
            outcome.left_out.into_iter().map(|left| left.1).collect(),
        ];
        let is_told = |words: &String| {
            words.contains("a frame without a sensor") || words.contains("the end of the file")
        };
        assert!(told.concat().iter().any(is_told), "{torn}: {told:?}");
    }
}

#[test]
fn a_picture_without_its_number_is_told() {
    let folder = Folder::new();
    for lost in 0..3 {
        let file = changed(&folder, "emed.lst", |lines| {
            let is_it = |line: &&mut String| line.contains("Pict-No.:");
            let line = lines.iter_mut().filter(is_it).nth(lost).unwrap();
            line.clear();
        });
        let outcome = read_with(&file, &sensor_of(&cut("emed.lst")), true);
        // The picture before it may have gone on there, and is left out as well.
        let told = (outcome.frames.len(), outcome.left_out.len());
        assert_eq!(told, (2 - lost.min(1), 1), "{lost}");
    }
    // Summaries have a table, and no picture.
    let file = changed(&folder, "emed.lst", |lines| {
        let begins = lines.iter().position(|line| line.contains("Pict-No.:"));
        let page = lines[..begins.unwrap() + 12].to_vec();
        lines.push("\u{c}".to_owned());
        lines.extend(page.iter().map(|line| line.replace("Pict-No.: 61", "MVP")));
    });
    assert_eq!(read(&file).len(), 3);
}

#[test]
fn the_names_of_sensors_may_come_twice() {
    let folder = Folder::new();
    let whole: Vec<f64> = read(&cut("pliance.asc")).iter().map(sum).collect();
    let file = changed(&folder, "pliance.asc", |lines| {
        let names = lines.iter().position(|line| line.starts_with("time[secs]"));
        lines.insert(names.unwrap(), lines[names.unwrap()].clone());
    });
    let found: Vec<f64> = read(&file).iter().map(sum).collect();
    assert_eq!(found, whole);
}

#[test]
fn a_file_without_a_frame_is_no_whole_one() {
    let folder = Folder::new();
    let text = "frame,Matrix_0\n";
    assert!(missing_of(&folder.write("i.csv", text)).contains("the end of the file is missing"));
}

#[test]
fn a_last_number_with_fewer_decimals_has_lost_some() {
    let folder = Folder::new();
    let head = "[General]\nUnitPressure=N/cm2\n[Technical]\nSensCountX=2\nSensCountY=2\nLDistX=5\nLDistY=5\n[Data]\n";
    for (end, is_told) in [
        ("10.25", false),
        ("10.2", true),
        ("10.", true),
        ("10", true),
        ("1", true),
        ("-1", false),
        ("10.25\n", false),
        ("1\n", false),
        ("10,25", false),
        ("10,2", true),
    ] {
        let first = if end.contains(',') { "0,25" } else { "0.25" };
        let file = folder.write("a.apd", format!("{head}-1\t{first}\n4\t{end}"));
        assert_eq!(!missing_of(&file).is_empty(), is_told, "{end}");
    }
}
