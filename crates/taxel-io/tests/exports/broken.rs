//! Files that are cut, torn, doubled or of two minds: told with place and both numbers, and nothing lost in silence.

use proptest::prelude::*;
use taxel_io::exports;

use super::*;

/// A cut with a piece of it replaced.
fn altered(folder: &Folder, name: &str, from: &str, to: &str) -> PathBuf {
    let bytes = std::fs::read(cut(name)).unwrap();
    let text: String = bytes.iter().map(|&byte| char::from(byte)).collect();
    assert!(text.contains(from), "{from}");
    let text = text.replacen(from, to, 1);
    let bytes: Vec<u8> = text.chars().map(|c| c as u8).collect();
    folder.write(name, bytes)
}

/// What is said of a file whose header cannot be.
fn refused(file: &Path) -> String {
    exports::sensor_of(file).unwrap_err().to_string()
}

/// A file, what is replaced in its header by what, and what the error says.
type Header = (
    &'static str,
    &'static str,
    &'static str,
    &'static [&'static str],
);

const HEADERS: [Header; 9] = [
    (
        "fscan.asf",
        "ROWS 60",
        "ROWS 61",
        &["60 rows in the first frame", "expected 61"],
    ),
    (
        "fscan.asf",
        "COLS 21",
        "COLS 22",
        &["21 values", "line 32", "expected 22"],
    ),
    (
        "fscan.asf",
        "UNITS KPa",
        "UNITS KPz",
        &["unknown unit `KPz`", "line 26", "expected one of kPa"],
    ),
    (
        "pedar.asc",
        "in  kPa",
        "in  furlongs",
        &["unknown unit `furlongs`", "line 4"],
    ),
    (
        "zebris.txt",
        "Units\tN/cm^2",
        "Units\tN/ell^2",
        &["unknown unit `N/ell^2`"],
    ),
    (
        "zebris.txt",
        "Lines\t56",
        "Lines\t57",
        &["56 rows", "expected 57"],
    ),
    (
        "xsensor.csv",
        "Units:,mmHg",
        "Units:,mmXy",
        &["unknown unit `mmXy`", "line 3"],
    ),
    (
        "emed.lst",
        "Matrix: 64x95",
        "Matrix: 64x80",
        &["`81", "a row number from 1 to 80"],
    ),
    (
        "pliance.asc",
        "area   0.5428   0.5428",
        "area   0.5428",
        &["812 numbers"],
    ),
];

#[test]
fn headers_that_cannot_be_are_told_with_place_and_both_numbers() {
    let folder = Folder::new();
    for (name, from, to, says) in HEADERS {
        let error = refused(&altered(&folder, name, from, to));
        for part in says {
            assert!(error.contains(part), "{part}: {error}");
        }
        assert!(error.contains("hint: "), "{error}");
    }
}

/// A file and its sensor, what is replaced by what, how many frames are left, and what the error says.
type Broken = (
    &'static str,
    &'static str,
    &'static str,
    &'static str,
    usize,
    &'static str,
);

const BROKEN: [Broken; 9] = [
    ("fscan.asf", "", ",380,", ",x,", 2, "is `x`"),
    ("fscan.asf", "", ",380,", ",-380,", 2, "is `-380`"),
    ("fscan.asf", "", ",380,", ",", 2, "value 20 of 21 is `B`"),
    ("fscan.asf", "", ",380,", ",380,1,", 2, "22 values"),
    (
        "iscan.csv",
        "",
        ",38,50,",
        ",38,51,",
        2,
        "add up to 311 raw counts, and the file itself says 310",
    ),
    (
        "emed.lst",
        "",
        "\t195.00\t",
        "\t295.00\t",
        2,
        "the cells of row 50 add up to 23.000 N",
    ),
    ("rsscan.txt", "", "\t8.3\t", "\t8.\t3\t", 1, "64 values"),
    (
        "pedar.asc",
        "#left",
        "105.000",
        "1O5.000",
        3,
        "is `1O5.000`",
    ),
    (
        "xsensor.csv",
        "#left",
        "1409.44,1553.27",
        "1409.44,nan",
        1,
        "is `nan`",
    ),
];

/// One frame is broken: it is told, and left out where that was asked for, and no other is lost.
#[test]
fn a_broken_frame_is_told_and_can_be_left_out() {
    let folder = Folder::new();
    for (name, pad, from, to, frames, says) in BROKEN {
        let file = altered(&folder, name, from, to);
        let named = file.with_file_name(format!("{name}{pad}"));
        let sensor = sensor_of(&named);
        let stopped = read_with(&named, &sensor, false);
        let error = stopped
            .error
            .map(|error| error.to_string())
            .unwrap_or_default();
        assert!(
            error.contains(says) && error.contains("line "),
            "{name} {says}: {error}"
        );
        let kept = read_with(&named, &sensor, true);
        assert!(kept.error.is_none());
        assert_eq!(
            (kept.frames.len(), kept.left_out.len()),
            (frames, 1),
            "{name} {says}"
        );
        assert!(kept.left_out[0].1.contains(says));
    }
}

#[test]
fn files_that_end_early_say_so() {
    let folder = Folder::new();
    let bytes = std::fs::read(cut("fscan.asf")).unwrap();
    let cut_at = |share: usize| folder.write("fscan.asf", &bytes[..bytes.len() * share / 100]);
    // In the middle of the third frame.
    let file = cut_at(90);
    let sensor = sensor_of(&file);
    let outcome = read_with(&file, &sensor, true);
    assert_eq!((outcome.frames.len(), outcome.left_out.len()), (2, 1));
    let missing = outcome.missing.join("; ");
    assert!(
        missing.contains("the end of the file is missing"),
        "{missing}"
    );
    // Between two frames: nothing is broken, and one frame is missing.
    let text = String::from_utf8(bytes.clone()).unwrap();
    let third = text.find("Frame 3").unwrap();
    let file = folder.write("fscan.asf", &bytes[..third]);
    let outcome = read_with(&file, &sensor, false);
    let missing = outcome.missing.join("; ");
    assert!(outcome.error.is_none() && outcome.frames.len() == 2);
    assert!(
        missing.contains("1 frame missing that the file says it has"),
        "{missing}"
    );
    // In the header.
    let error = refused(&folder.write("fscan.asf", &text[..text.find("ASCII").unwrap() + 13]));
    assert!(error.contains("expected a line `Frame 1`"), "{error}");
}

#[test]
fn frames_that_are_missing_or_come_twice_are_counted() {
    let folder = Folder::new();
    let file = altered(&folder, "iscan.csv", "Frame 2,", "Frame 5,");
    let outcome = read_with(&file, &sensor_of(&file), false);
    let missing = outcome.missing.join("; ");
    assert!(
        missing.contains("3 of the device's frame numbers missing after number 1"),
        "{missing}"
    );
    assert!(missing.contains("began anew once"), "{missing}");
    assert_eq!(outcome.frames.len(), 3);
}

/// The header's calibration is another's: the pressures are as they are, and no raw counts are invented.
#[test]
fn a_calibration_that_is_not_that_of_the_values_gives_no_counts() {
    let folder = Folder::new();
    let point = altered(&folder, "fscan.asf", "75.0001 (Kgs)", "61.3 (Kgs)");
    // The largest value tells the scale as well.
    let (_, survey) = exports::survey(&point).unwrap().unwrap();
    assert_eq!(survey.has_raw, Some(true));
    let text = std::fs::read_to_string(&point).unwrap();
    let file = folder.write(
        "both.asf",
        text.replace("SATURATION_PRESSURE", "SATURATION"),
    );
    let (_, survey) = exports::survey(&file).unwrap().unwrap();
    assert_eq!(survey.has_raw, Some(false));
    near(&sums(&file), &[35389.0, 35819.0, 34574.0], 0.0);
    let named = file.with_file_name("both.asf#raw");
    let outcome = read_with(&named, &sensor_of(&named), false);
    let error = outcome.error.unwrap().to_string();
    assert!(
        error.contains("raw counts by the file's own calibration, expected a whole number"),
        "{error}"
    );
}

proptest! {
    /// Bytes lost, doubled or changed anywhere: no panic, and what is given is what was there, or is told.
    #[test]
    fn any_damage_is_an_error_or_a_frame(
        which in 0..8usize,
        at in 0.0..1.0f64,
        lost in 0..40usize,
        added in proptest::collection::vec(any::<u8>(), 0..20),
    ) {
        let names = ["fscan.asf", "iscan.csv", "pedar.asc", "pliance.asc", "emed.lst", "xsensor.csv", "rsscan.txt", "zebris.txt"];
        let name = names[which];
        let mut bytes = std::fs::read(cut(name)).unwrap();
        let from = (at * bytes.len() as f64) as usize;
        let to = (from + lost).min(bytes.len());
        bytes.splice(from..to, added);
        let folder = Folder::new();
        let file = folder.write(name, &bytes);
        let named = match name {
            "pedar.asc" | "xsensor.csv" => file.with_file_name(format!("{name}#left")),
            _ => file,
        };
        if let Ok(Some(spec)) = exports::sensor_of(&named)
            && let Ok(sensor) = Sensor::try_from(spec)
        {
            let outcome = read_with(&named, &sensor, true);
            prop_assert!(outcome.frames.len() <= 5, "{}", outcome.frames.len());
            for read in &outcome.frames {
                prop_assert!(read.frame.values().iter().all(|count| *count >= 0.0 && count.is_finite()));
            }
        }
    }
}
