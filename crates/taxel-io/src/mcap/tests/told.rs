//! What a recording tells beside its frames: losses, tares, numbers.

use std::path::Path;
use std::time::SystemTime;

use taxel::{Counts, Frame, Newtons};

use super::{about, at, frame};
use crate::mcap::{Losses, McapReader, McapWriter, Tare};
use crate::options::ReadOptions;
use crate::source::FrameSource;

fn tare(from: u64, newtons: f64) -> Tare {
    Tare {
        from_sequence: from,
        at: at(from),
        unit: "N".to_owned(),
        loads: vec![newtons; 256],
        raw: vec![2.0 * newtons; 256],
    }
}

fn reader(path: &Path) -> McapReader {
    McapReader::open(path, ReadOptions::new(16, 16)).unwrap()
}

/// The wall clock of a computer that reads a sensor without one of its own was set back, twice; a device that began anew is no such
/// thing.
#[test]
fn times_that_go_back_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    let mut writer = McapWriter::create(&path, &about()).unwrap();
    let frames = [
        (7, 50),
        (8, 51),
        (9, 20),
        (10, 20),
        (11, 19),
        (0, 3),
        (1, 4),
    ];
    for (number, secs) in frames {
        let mut frame = frame(number);
        frame.time_secs = None;
        writer.write_counts(&frame, at(secs)).unwrap();
    }
    writer.finish().unwrap();
    let mut reader = reader(&path);
    let mut next = Frame::<Counts>::zeros(16, 16);
    while reader.next_into(&mut next).unwrap() {}
    let integrity = reader.integrity();
    assert_eq!(integrity.times.repeated, 2);
    assert!(!integrity.is_whole());
    assert_eq!(
        integrity.words(),
        [
            "the device's frame numbers began anew once",
            "2 frames are no later than the one before them",
        ]
    );
}

#[test]
fn gaps_restarts_and_counted_losses_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    let mut writer = McapWriter::create(&path, &about()).unwrap();
    for (place, number) in [100, 101, 105, 106, 0, 1, 3].into_iter().enumerate() {
        let mut frame = frame(number);
        frame.time_secs = Some(place as f64);
        writer.write_counts(&frame, at(place as u64)).unwrap();
        if place == 4 {
            let losses = |lost, corrupt| Losses {
                lost,
                corrupt,
                ..Losses::default()
            };
            writer.set_losses(losses(3, 0));
            writer.flush().unwrap();
            writer.set_losses(losses(4, 9));
        }
    }
    writer.finish().unwrap();
    let mut reader = reader(&path);
    let mut next = Frame::<Counts>::zeros(16, 16);
    let mut numbers = Vec::new();
    while reader.next_into(&mut next).unwrap() {
        numbers.push((next.sequence, reader.device_number().unwrap()));
    }
    let expected: Vec<(u64, u32)> = (0..).zip([100, 101, 105, 106, 0, 1, 3]).collect();
    assert_eq!(numbers, expected);
    let integrity = reader.integrity();
    assert_eq!((integrity.gaps.missing, integrity.gaps.restarts), (4, 1));
    assert_eq!(integrity.gaps.first, Some((101, 3)));
    assert_eq!((integrity.losses.lost, integrity.losses.corrupt), (4, 9));
    assert_eq!(
        integrity.words(),
        [
            "4 of the device's frame numbers missing in 2 places, the first 3 after number 101",
            "the device's frame numbers began anew once",
            "while it was recorded: 9 packets or lines came broken",
        ]
    );
}

#[test]
fn a_tare_holds_from_its_frame_on_until_it_is_undone() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    let mut writer = McapWriter::create(&path, &about()).unwrap();
    for number in 0..40 {
        match number {
            10 => writer.write_tare(&tare(10, 0.5)).unwrap(),
            20 => writer.write_tare(&tare(20, 0.7)).unwrap(),
            30 => writer.write_tare(&Tare::undone(30, at(30))).unwrap(),
            _ => {}
        }
        writer.write_counts(&frame(number), at(number)).unwrap();
    }
    writer.finish().unwrap();
    let force = |reader: &McapReader| reader.tare().map(|tare| tare.loads[0]);
    let expected = |place: u64| match place {
        0..10 => None,
        10..20 => Some(0.5),
        20..30 => Some(0.7),
        _ => None,
    };
    let mut reader = reader(&path);
    let mut next = Frame::<Counts>::zeros(16, 16);
    for place in 0..40 {
        assert!(reader.next_into(&mut next).unwrap());
        assert_eq!(force(&reader), expected(place), "frame {place}");
    }
    // And wherever one goes.
    for place in [25, 5, 39, 10, 19] {
        assert!(reader.seek(0.01 * place as f64).unwrap());
        assert!(reader.next_into(&mut next).unwrap());
        assert_eq!((next.sequence, force(&reader)), (place, expected(place)));
    }
}

#[test]
fn figures_keep_every_digit_and_are_json_whatever_they_are() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    let mut writer = McapWriter::create(&path, &about()).unwrap();
    writer.write_counts(&frame(0), at(0)).unwrap();
    let loads = Frame::<Newtons>::zeros(16, 16);
    let mut figures = taxel::metric::FrameFigures::of(&loads, &about().sensor);
    figures.total_force_newtons = 1.234_567_890_123e-6;
    figures.peak_kilopascals = f64::NAN;
    writer
        .write_figures(&figures, 0, SystemTime::now())
        .unwrap();
    writer.finish().unwrap();
    let messages = mcap::MessageStream::new(&std::fs::read(&path).unwrap())
        .unwrap()
        .map(Result::unwrap)
        .filter(|message| message.channel.topic == "/taxel/figures")
        .map(|message| serde_json::from_slice::<serde_json::Value>(&message.data).unwrap())
        .collect::<Vec<_>>();
    assert_eq!(messages[0]["total_force_newtons"], 1.234_567_890_123e-6);
    assert!(messages[0]["peak_kilopascals"].is_null());
}

#[test]
fn a_file_renamed_while_it_is_written_is_made_whole_and_another_of_its_name_left_alone() {
    let folder = tempfile::tempdir().unwrap();
    let (path, moved) = (
        folder.path().join("run.mcap"),
        folder.path().join("moved.mcap"),
    );
    let tail = crate::mcap::tail::Tail::straight(&path, 12_000).unwrap();
    let mut writer = McapWriter::begin(tail, path.clone(), &about()).unwrap();
    writer.write_counts(&frame(0), at(0)).unwrap();
    std::fs::rename(&path, &moved).unwrap();
    std::fs::write(&path, vec![b'x'; 100_000]).unwrap();
    let failed = (1..1000).any(|number| {
        let written = writer.write_counts(&frame(number), at(number));
        written.and_then(|()| writer.flush()).is_err()
    });
    assert!(failed);
    drop(writer);
    assert_eq!(std::fs::read(&path).unwrap(), vec![b'x'; 100_000]);
    let mut reader = reader(&moved);
    let mut next = Frame::<Counts>::zeros(16, 16);
    while reader.next_into(&mut next).unwrap() {}
    assert!(reader.integrity().is_whole());
}

#[test]
fn a_recording_has_its_name_from_its_first_frame_on_and_takes_it_from_nobody() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    let mut writer = McapWriter::create(&path, &about()).unwrap();
    writer.write_event("mark", "before", at(0)).unwrap();
    writer.write_tare(&tare(0, 0.5)).unwrap();
    assert!(!path.exists());
    writer.write_counts(&frame(0), at(0)).unwrap();
    // As another program finds it, were this one killed now.
    let mut first = McapReader::open_any(&path).unwrap();
    let mut next = Frame::<Counts>::zeros(16, 16);
    assert!(first.next_into(&mut next).unwrap());
    assert_eq!(first.sensor_toml().unwrap(), about().sensor.to_toml());
    writer.finish().unwrap();
    // Without a frame nothing is left, whether it is ended or let go.
    let none = folder.path().join("none.mcap");
    let empty = || McapWriter::create(&none, &about()).unwrap();
    empty().finish().unwrap();
    drop(empty());
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    // A name that was taken meanwhile is left to who has it.
    let mut late = empty();
    std::fs::write(&none, "mine").unwrap();
    let error = late.write_counts(&frame(0), at(0)).unwrap_err();
    assert!(matches!(error, crate::Error::Exists { .. }), "{error}");
    assert_eq!(late.frames(), 0);
    drop(late);
    assert_eq!(std::fs::read(&none).unwrap(), b"mine");
}
