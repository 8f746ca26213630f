//! What is written comes back, whatever happens to the file.

mod damage;
mod ends;
mod told;

use std::path::Path;
use std::time::{Duration, SystemTime};

use taxel::metric::FrameFigures;
use taxel::{Counts, Frame, Newtons};

use super::tail::Tail;
use super::write::{About, McapWriter};
use crate::error::Error;
use crate::mcap::{LoadsReader, McapReader, Recovered, recover};
use crate::options::ReadOptions;
use crate::source::FrameSource;
use taxel::Mark;
use taxel::sensor::preset;

fn about() -> About {
    About {
        sensor: preset("mat-16x16-cd4067").unwrap(),
        program: "taxel test".to_owned(),
        source: "sim:mat-16x16-cd4067".to_owned(),
    }
}

fn frame(number: u64) -> Frame<Counts> {
    let values = (0..256u64).map(|i| ((i * 37 + number * 101) % 1024) as f64);
    let mut frame = Frame::new(16, 16, values.collect()).unwrap();
    frame.sequence = number;
    frame.time_secs = Some(5.0 + 0.01 * number as f64);
    frame
}

fn at(number: u64) -> SystemTime {
    SystemTime::UNIX_EPOCH + Duration::from_millis(1_795_000_000_000 + 10 * number)
}

fn read(path: &Path) -> (Vec<Frame<Counts>>, Option<Error>) {
    let mut reader = McapReader::open(path, ReadOptions::new(16, 16)).unwrap();
    let mut frames = Vec::new();
    let mut next = Frame::zeros(16, 16);
    loop {
        match reader.next_into(&mut next) {
            Ok(true) => frames.push(next.clone()),
            Ok(false) => return (frames, None),
            Err(error) => return (frames, Some(error)),
        }
    }
}

fn loads(number: u64) -> Frame<Newtons> {
    let values = (0..256u64).map(|i| 0.25 * (i * number) as f64);
    let mut loads = Frame::<Newtons>::new(16, 16, values.collect()).unwrap();
    loads.marks_mut()[3] = Mark::Stuck;
    loads
}

#[test]
fn loads_come_back_with_their_marks() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    let mut writer = McapWriter::create(&path, &about()).unwrap();
    for number in 0..40 {
        writer.write_counts(&frame(number), at(number)).unwrap();
        writer.write_loads(&loads(number), at(number)).unwrap();
    }
    writer.finish().unwrap();
    let mut found = Frame::<Newtons>::zeros(1, 1);
    for transpose in [false, true] {
        let mut options = ReadOptions::new(16, 16);
        options.transpose = transpose;
        let mut reader = LoadsReader::open(&path, options).unwrap();
        for number in 0..40 {
            assert!(reader.next_into(&mut found).unwrap());
            let written = loads(number);
            for place in 0..256 {
                let from = if transpose {
                    16 * (place % 16) + place / 16
                } else {
                    place
                };
                assert_eq!(found.values()[place], written.values()[from]);
                assert_eq!(found.marks()[place], written.marks()[from]);
            }
        }
        assert!(!reader.next_into(&mut found).unwrap());
    }
    // Another shape, and what has none.
    let mut reader = LoadsReader::open(&path, ReadOptions::new(8, 16)).unwrap();
    let error = reader.next_into(&mut found).unwrap_err();
    assert!(matches!(error, Error::FrameShape { .. }), "{error}");
    let bare = folder.path().join("bare.mcap");
    let mut writer = McapWriter::create(&bare, &about()).unwrap();
    writer.write_counts(&frame(0), at(0)).unwrap();
    writer.finish().unwrap();
    let mut reader = LoadsReader::open(&bare, ReadOptions::new(16, 16)).unwrap();
    let error = reader.next_into(&mut found).unwrap_err();
    assert!(matches!(error, Error::NoLoads { .. }), "{error}");
}

#[test]
fn what_is_recorded_comes_back_with_times_events_and_sensor() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    let mut writer = McapWriter::create(&path, &about()).unwrap();
    for number in 0..40 {
        let loads = loads(number);
        writer.write_counts(&frame(number), at(number)).unwrap();
        writer.write_loads(&loads, at(number)).unwrap();
        let figures = FrameFigures::of(&loads, &about().sensor);
        writer.write_figures(&figures, number, at(number)).unwrap();
        if number == 7 {
            writer
                .write_event("mark", "he said \"now\"", at(7))
                .unwrap();
        }
    }
    assert_eq!(writer.frames(), 40);
    writer.finish().unwrap();
    let mut reader = McapReader::open(&path, ReadOptions::new(16, 16)).unwrap();
    assert_eq!(reader.sensor_toml().unwrap(), about().sensor.to_toml());
    assert_eq!(reader.program(), Some("taxel test"));
    let mut found = Frame::zeros(1, 1);
    for number in 0..40 {
        assert!(reader.next_into(&mut found).unwrap());
        assert_eq!(found.values(), frame(number).values());
        assert_eq!(reader.host_time(), at(number));
        let secs = found.time_secs.unwrap();
        assert!((secs - 0.01 * number as f64).abs() < 1e-6);
    }
    assert!(!reader.next_into(&mut found).unwrap());
    let events = reader.take_events();
    assert_eq!(events.len(), 1);
    assert_eq!(events[0].text, "he said \"now\"");
    assert_eq!(events[0].at, at(7));
    assert!((events[0].secs - 0.07).abs() < 1e-9);
    assert!(reader.take_events().is_empty());
    // There and back by the index.
    assert_eq!(reader.extent(), Some((0.39, 40)));
    for number in [25, 0, 39, 7] {
        assert!(reader.seek(0.01 * number as f64).unwrap());
        assert!(reader.next_into(&mut found).unwrap());
        assert_eq!(found.values(), frame(number).values());
        // Of what happened before the place that was sought nothing is told.
        let early = reader
            .take_events()
            .into_iter()
            .any(|event| event.secs < 0.01 * number as f64);
        assert!(!early);
    }
    // Beyond the end there is nothing, however far beyond.
    assert!(reader.seek(1e300).unwrap());
    assert!(!reader.next_into(&mut found).unwrap());
    // Never over an existing file.
    assert!(matches!(
        McapWriter::create(&path, &about()),
        Err(Error::Exists { .. })
    ));
}

/// Cut anywhere: what was flushed comes back, and nothing panics.
#[test]
fn a_recording_cut_anywhere_is_recovered_to_its_last_whole_chunk() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    let mut writer = McapWriter::create(&path, &about()).unwrap();
    // How many frames are safe once the file is that long.
    let mut safe = vec![(0, 0)];
    for number in 0..30 {
        writer.write_counts(&frame(number), at(number)).unwrap();
        if number % 5 == 4 {
            writer.flush().unwrap();
            safe.push((writer.bytes(), number + 1));
        }
    }
    writer.finish().unwrap();
    let whole = std::fs::read(&path).unwrap();
    let (cut, saved) = (
        folder.path().join("cut.mcap"),
        folder.path().join("saved.mcap"),
    );
    for length in (8..whole.len()).step_by(97).chain([whole.len()]) {
        std::fs::write(&cut, &whole[..length]).unwrap();
        let _ = std::fs::remove_file(&saved);
        let recovered = recover(&cut, &saved).unwrap();
        let least = safe.iter().rev().find(|(bytes, _)| *bytes <= length as u64);
        let expected = recovered.frames;
        // A chunk may be whole where its index is not; the first frame has one of its own.
        assert!(
            [0, 1, 4, 5].contains(&(expected - least.unwrap().1)),
            "cut at {length}: {expected}"
        );
        if expected > 0 {
            let (frames, error) = read(&saved);
            assert!(error.is_none());
            assert_eq!(frames.len() as u64, expected);
            for (number, found) in frames.iter().enumerate() {
                assert_eq!(found.values(), frame(number as u64).values());
            }
            // Unrecovered, it gives as much, and says that it was cut.
            let (frames, error) = read(&cut);
            assert_eq!(frames.len() as u64, expected);
            let has_end = recovered.was_whole;
            assert_eq!(error.is_none(), has_end, "cut at {length}");
        }
    }
    let _ = std::fs::remove_file(&saved);
    let untouched = recover(&path, &saved).unwrap();
    assert_eq!(
        untouched,
        Recovered {
            messages: 30,
            frames: 30,
            was_whole: true,
            ..Recovered::default()
        }
    );
}

#[test]
fn a_damaged_chunk_costs_its_own_frames() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    let mut writer = McapWriter::create(&path, &about()).unwrap();
    let mut ends = Vec::new();
    for number in 0..30 {
        writer.write_counts(&frame(number), at(number)).unwrap();
        if number % 10 == 9 {
            writer.flush().unwrap();
            ends.push(writer.bytes() as usize);
        }
    }
    writer.finish().unwrap();
    let mut bytes = std::fs::read(&path).unwrap();
    for byte in &mut bytes[ends[0] + 200..ends[0] + 260] {
        *byte ^= 0x5a;
    }
    std::fs::write(&path, bytes).unwrap();
    let saved = folder.path().join("saved.mcap");
    let recovered = recover(&path, &saved).unwrap();
    assert_eq!((recovered.frames, recovered.chunks_lost), (20, 1));
    assert_eq!(read(&saved).0.len(), 20);
}

#[test]
fn a_full_disk_leaves_a_whole_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    let tail = Tail::straight(&path, 12_000).unwrap();
    let mut writer = McapWriter::begin(tail, path.clone(), &about()).unwrap();
    let mut safe = 0;
    let error = (0..1000)
        .find_map(|number| {
            let done = writer.write_counts(&frame(number), at(number));
            let done = done.and_then(|()| match number % 4 {
                3 => writer.flush().map(|()| safe = number + 1),
                _ => Ok(()),
            });
            done.err()
        })
        .expect("the disk was full");
    assert!(matches!(error, Error::Recording { .. }), "{error}");
    assert!(writer.write_counts(&frame(0), at(0)).is_err());
    drop(writer);
    assert!(safe > 0);
    assert!(
        error.to_string().contains(&format!("after {safe} frames")),
        "{error}"
    );
    let (frames, error) = read(&path);
    assert!(error.is_none(), "{error:?}");
    assert_eq!(frames.len() as u64, safe);
}

#[test]
fn other_files_and_other_sensors_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    std::fs::write(&path, b"not a recording at all").unwrap();
    let error = McapReader::open_any(&path).err().unwrap();
    assert!(matches!(error, Error::NotMcap { .. }), "{error}");
    assert!(recover(&path, folder.path().join("x.mcap")).is_err());
    assert!(!folder.path().join("x.mcap").exists());
    std::fs::remove_file(&path).unwrap();
    let mut writer = McapWriter::create(&path, &about()).unwrap();
    let mut half = frame(0);
    half.values_mut()[9] = 0.5;
    assert!(matches!(
        writer.write_counts(&half, at(0)),
        Err(Error::Value { column: 9, .. })
    ));
    writer.write_counts(&frame(0), at(0)).unwrap();
    writer.finish().unwrap();
    let error = McapReader::open(&path, ReadOptions::new(8, 16))
        .err()
        .unwrap();
    assert!(
        error.to_string().contains("16 rows x 16 columns"),
        "{error}"
    );
}
