//! Recordings made of recordings: loads beside their counts, what is whole of a damaged one, one sent again.

use taxel::{Counts, Frame, Newtons};
use taxel_io::{FrameSource, LoadsReader, McapReader, ReadOptions, Tare};

use crate::recordings::{at, counts, write};
use crate::run::Folder;

/// A recording of three frames with a gap, an event and a tare; and what `compensate` writes of it, in one file and in
/// several, the tare taken off or left on.
fn compensated() -> Folder {
    let folder = Folder::new();
    let counts = counts(&folder);
    let path = folder.path("run.mcap");
    write(&path, &counts, &[5, 6, 9], |place, writer| {
        let tare = Tare {
            from_sequence: 6,
            at: at(0.01),
            unit: "N".to_owned(),
            loads: vec![0.5; 24],
            raw: vec![0.25; 24],
        };
        if place == 1 {
            writer.write_tare(&tare).unwrap();
            writer.write_event("mark", "now", at(0.01)).unwrap();
        }
    });
    for words in [
        "-o loads.mcap",
        "-o plain.mcap --no-tare",
        "--unit N -o loads.csv",
        "--unit N --no-tare -o plain.csv",
    ] {
        let run = folder.taxel(&format!("compensate run.mcap {words}"));
        // A number of the device is missing.
        assert_eq!(run.code, Some(3), "{run}");
    }
    folder
}

#[test]
fn compensated_loads_are_written_with_counts_and_marks_in_one_recording() {
    let folder = compensated();
    assert!(!folder.exists("plain.marks.mcap"));
    let options = ReadOptions::new(4, 6);
    let mut original = McapReader::open(folder.path("run.mcap"), options).unwrap();
    let mut copy = McapReader::open(folder.path("loads.mcap"), options).unwrap();
    let mut loads = LoadsReader::open(folder.path("loads.mcap"), options).unwrap();
    assert_eq!(copy.sensor_toml(), original.sensor_toml());
    let (mut a, mut b) = (Frame::<Counts>::zeros(4, 6), Frame::<Counts>::zeros(4, 6));
    let mut found = Frame::<Newtons>::zeros(4, 6);
    let (newtons, marks) = (
        folder.numbers("loads.csv"),
        folder.numbers("loads.marks.csv"),
    );
    for place in 0..3 {
        assert!(original.next_into(&mut a).unwrap() && copy.next_into(&mut b).unwrap());
        assert_eq!((a.values(), a.time_secs), (b.values(), b.time_secs));
        assert_eq!(copy.device_number(), original.device_number());
        assert_eq!(copy.host_time(), original.host_time());
        assert_eq!(copy.tare(), original.tare());
        assert!(loads.next_into(&mut found).unwrap());
        for taxel in 0..24 {
            let expected = newtons[24 * place + taxel];
            assert_eq!(found.values()[taxel], f64::from(expected as f32));
            let code = f64::from(found.marks()[taxel].code());
            assert_eq!(code, marks[24 * place + taxel]);
        }
    }
    assert!(!loads.next_into(&mut found).unwrap());
    assert_eq!(copy.take_events(), original.take_events());
}

#[test]
fn a_recording_with_loads_is_read_as_any_other_and_its_loads_as_they_stand_in_it() {
    let folder = compensated();
    for name in ["loads", "plain"] {
        folder.taxel(&format!("compensate {name}.mcap --unit N -o again.csv"));
        assert_eq!(
            folder.read("again.csv"),
            folder.read(&format!("{name}.csv"))
        );
    }
    for words in ["info loads.mcap", "convert loads.mcap -o again.txt"] {
        let run = folder.taxel(words);
        assert_eq!(run.code, Some(3), "{run}");
    }
    folder.good("plot loads.mcap -o a.svg");
    let info = folder.good("info loads.mcap --values --json");
    let json: serde_json::Value = serde_json::from_str(&info.out).unwrap();
    assert_eq!(json["frames"], 3);
    folder.good("plot loads.mcap --values -o b.svg");
    for words in ["info run.mcap --values", "plot run.mcap --values -o c.svg"] {
        let run = folder.fails(words);
        assert!(run.err.contains("no loads in run.mcap"), "{run}");
    }
    for words in [
        "compensate run.mcap --input-unit volts -o v.csv",
        "calibrate --series run.mcap --loads loads.mcap -o c.toml",
    ] {
        let run = folder.fails(words);
        assert!(run.err.contains("hint: "), "{run}");
        assert_eq!(run.code, Some(2), "{run}");
    }
}

#[test]
fn compensated_loads_are_written_to_a_table_with_their_counts() {
    let folder = Folder::new();
    folder.good("simulate --sensor sensor.toml --pattern hand --frames 5 -o run.txt");
    let run = folder.good("compensate run.txt --sensor sensor.toml -o loads.parquet");
    assert!(run.err.contains("wrote loads.parquet (N)"), "{run}");
    let bytes = std::fs::read(folder.path("loads.parquet")).unwrap();
    assert!(bytes.starts_with(b"PAR1") && bytes.ends_with(b"PAR1"));
    for name in ["counts", "newtons", "marks", "taxel.sensor_toml"] {
        assert!(
            bytes
                .windows(name.len())
                .any(|part| part == name.as_bytes()),
            "{name}"
        );
    }
    folder.good("compensate run.txt --sensor sensor.toml --unit siemens -o s.csv");
    folder.good("compensate s.csv --sensor sensor.toml --input-unit siemens -o s.parquet");
    // What a recording of loads cannot be.
    for words in [
        "compensate s.csv --sensor sensor.toml --input-unit siemens -o s.mcap",
        "compensate run.txt --sensor sensor.toml --unit kPa -o a.mcap",
        "compensate run.txt --sensor sensor.toml --unit siemens -o a.parquet",
    ] {
        let run = folder.fails(words);
        assert_eq!(run.code, Some(2), "{run}");
    }
    assert!(!folder.exists("s.mcap") && !folder.exists("a.mcap") && !folder.exists("a.parquet"));
}

#[test]
fn a_recording_in_which_nothing_is_whole_is_no_success() {
    let folder = Folder::new();
    let counts = counts(&folder);
    write(&folder.path("run.mcap"), &counts, &[0, 1, 2], |_, _| {});
    let whole = std::fs::read(folder.path("run.mcap")).unwrap();
    // The magic and the end, and nothing between them.
    let bare = [&whole[..8], &whole[whole.len() - 37..]].concat();
    std::fs::write(folder.path("bare.mcap"), bare).unwrap();
    let run = folder.fails("recover bare.mcap -o saved.mcap");
    assert_eq!(run.code, Some(1), "{run}");
    assert!(run.err.contains("holds no frame that is whole"), "{run}");
    assert!(!folder.exists("saved.mcap"));
    // An end that stands in the middle is none.
    let middle = whole.len() / 2;
    let twice = [
        &whole[..middle],
        &whole[whole.len() - 37..],
        &whole[middle..],
    ]
    .concat();
    std::fs::write(folder.path("twice.mcap"), twice).unwrap();
    let run = folder.taxel("recover twice.mcap -o saved.mcap");
    assert_eq!(run.code, Some(3), "{run}");
    assert!(!run.err.contains("nothing was missing"), "{run}");
}

#[test]
fn a_speed_is_a_number_or_max() {
    let folder = Folder::new();
    let counts = counts(&folder);
    write(&folder.path("run.mcap"), &counts, &[0, 1, 2], |_, _| {});
    let bytes = |speed: &str| {
        let run = folder.taxel_bytes(&format!("replay run.mcap --to - --speed {speed}"));
        assert!(run.status.success(), "{speed}");
        run.stdout
    };
    assert!(!bytes("max").is_empty());
    assert_eq!(bytes("max"), bytes("0"));
    for speed in ["fast", "1e9", "1e-300", "inf"] {
        let run = folder.fails(&format!("replay run.mcap --to - --speed {speed}"));
        assert_eq!(run.code, Some(2), "{run}");
        assert!(
            run.err.contains("expected a number from 0.001 to 1000"),
            "{run}"
        );
    }
}
