//! A byte changed anywhere: never a panic, never another content without a word, and every chunk that is not hurt
//! comes back.

use std::collections::BTreeSet;
use std::ops::Range;
use std::path::Path;

use taxel::{Counts, Frame};

use super::{about, at, frame};
use crate::error::Error;
use crate::mcap::index::Index;
use crate::mcap::{McapReader, McapWriter, Tare, recover};
use crate::options::ReadOptions;
use crate::source::FrameSource;

const FRAMES: u64 = 20;
const A_CHUNK: u64 = 5;

/// A whole recording of four chunks, with an event and a tare.
fn write(path: &Path) {
    let mut writer = McapWriter::create_at_once(path, &about()).unwrap();
    for number in 0..FRAMES {
        if number == 10 {
            let tare = Tare {
                from_sequence: 10,
                at: at(10),
                unit: "N".to_owned(),
                loads: vec![0.25; 256],
                raw: Vec::new(),
            };
            writer.write_tare(&tare).unwrap();
            writer.write_event("tare", "tare", at(10)).unwrap();
        }
        writer.write_counts(&frame(number), at(number)).unwrap();
        if number % A_CHUNK == A_CHUNK - 1 {
            writer.flush().unwrap();
        }
    }
    writer.finish().unwrap();
}

/// Where the chunks of a whole recording lie, with the frames in each.
fn chunks(path: &Path) -> Vec<(Range<usize>, Vec<u64>)> {
    let mut file = std::fs::File::open(path).unwrap();
    let total = file.metadata().unwrap().len();
    let index = Index::read(&mut file, total).unwrap();
    let place = |n: usize| {
        let chunk = &index.chunks[n];
        let begin = chunk.chunk_start_offset as usize;
        begin..begin + chunk.chunk_length as usize
    };
    let frames = |n: u64| (n * A_CHUNK..(n + 1) * A_CHUNK).collect();
    assert_eq!(index.chunks.len(), 4);
    (0..4).map(|n| (place(n), frames(n as u64))).collect()
}

#[derive(Debug, PartialEq)]
struct Content {
    values: Vec<Vec<f64>>,
    sensor: Option<String>,
    /// Whether a tare is in force at the end.
    is_tared: bool,
}

/// All that is in a recording, and whether it says that this is all.
fn content(path: &Path) -> Result<(Content, bool), Error> {
    let mut options = ReadOptions::new(16, 16);
    options.accept_damage = true;
    let mut reader = McapReader::open(path, options)?;
    let mut next = Frame::<Counts>::zeros(16, 16);
    let mut values = Vec::new();
    while reader.next_into(&mut next)? {
        values.push(next.values().to_vec());
    }
    let found = Content {
        values,
        sensor: reader.sensor_toml().map(str::to_owned),
        is_tared: reader.tare().is_some(),
    };
    Ok((found, reader.integrity().is_whole()))
}

/// A byte changed, at places spread over all of a file: the place, and what it is changed by.
fn changes(length: usize, step: usize) -> impl Iterator<Item = (usize, u8)> {
    let mut state = 7u64;
    (0..length).step_by(step).flat_map(move |at| {
        state = state
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        let random = (state >> 33) as usize;
        [
            (at, 1u8 << (random % 8)),
            (random % length, (random >> 8) as u8 | 1),
        ]
    })
}

#[test]
fn no_changed_byte_changes_what_is_read_without_a_word() {
    let folder = tempfile::tempdir().unwrap();
    let (good, bad) = (
        folder.path().join("good.mcap"),
        folder.path().join("bad.mcap"),
    );
    write(&good);
    let whole = std::fs::read(&good).unwrap();
    let places = chunks(&good);
    let (expected, is_whole) = content(&good).unwrap();
    assert!(is_whole && expected.values.len() as u64 == FRAMES && expected.is_tared);
    let numbers: Vec<Vec<f64>> = (0..FRAMES).map(|n| frame(n).values().to_vec()).collect();
    for (at, by) in changes(whole.len(), 3) {
        let mut bytes = whole.clone();
        bytes[at] ^= by;
        std::fs::write(&bad, &bytes).unwrap();
        let hurt = places.iter().find(|(place, _)| place.contains(&at));
        match content(&bad) {
            Ok((found, is_whole)) => {
                assert!(!is_whole || found == expected, "byte {at} by {by:#x}");
                for (place, frames) in &places {
                    let all = frames
                        .iter()
                        .all(|&n| found.values.contains(&numbers[n as usize]));
                    assert!(
                        all || place.contains(&at),
                        "byte {at} by {by:#x}: {frames:?}"
                    );
                }
                let good = found.values.iter().all(|values| numbers.contains(values));
                assert!(
                    good,
                    "byte {at} by {by:#x}: a frame that was never recorded"
                );
            }
            // Where it is not a chunk that is hurt, it is read on.
            Err(error) => assert!(hurt.is_none() && at < 8, "byte {at} by {by:#x}: {error}"),
        }
    }
}

#[test]
fn every_whole_chunk_is_recovered_from_a_changed_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let (good, bad, saved) = (path("good.mcap"), path("bad.mcap"), path("saved.mcap"));
    write(&good);
    let whole = std::fs::read(&good).unwrap();
    let places = chunks(&good);
    let (expected, _) = content(&good).unwrap();
    let all = recover(&good, &saved).unwrap();
    assert!(all.is_all() && all.frames == FRAMES, "{all:?}");
    assert_eq!(content(&saved).unwrap(), (content(&good).unwrap().0, true));
    for (at, by) in changes(whole.len(), 23) {
        let mut bytes = whole.clone();
        bytes[at] ^= by;
        std::fs::write(&bad, &bytes).unwrap();
        let _ = std::fs::remove_file(&saved);
        let recovered = recover(&bad, &saved).unwrap();
        let (found, is_whole) = content(&saved).unwrap();
        assert!(is_whole || !recovered.is_all());
        assert!(
            !recovered.is_all() || found == expected,
            "byte {at} by {by:#x}: {recovered:?}"
        );
        assert_eq!(found.sensor, expected.sensor, "byte {at} by {by:#x}");
        let kept: BTreeSet<u64> = places
            .iter()
            .filter(|(place, _)| !place.contains(&at))
            .flat_map(|(_, frames)| frames.clone())
            .collect();
        let kept = kept.iter().map(|&n| frame(n).values().to_vec());
        for values in kept {
            assert!(found.values.contains(&values), "byte {at} by {by:#x}");
        }
    }
}

#[test]
fn a_recording_without_a_whole_chunk_is_damaged_and_not_one_of_something_else() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    write(&path);
    let mut bytes = std::fs::read(&path).unwrap();
    for (place, _) in chunks(&path) {
        bytes[place.start + 80] ^= 0x10;
    }
    std::fs::write(&path, &bytes).unwrap();
    let Err(error) = McapReader::open(&path, ReadOptions::new(16, 16)) else {
        panic!("no frame of it is whole");
    };
    assert!(matches!(error, Error::RecordingDamaged { .. }), "{error}");
    let words = error.to_string();
    let expected =
        "4 damaged chunks left out; 20 frames missing that the file says it has; no frame is left";
    assert!(words.contains(expected), "{words}");
}

#[test]
fn frames_behind_a_lost_chunk_keep_their_places() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    write(&path);
    let place = chunks(&path)[1].0.clone();
    let mut bytes = std::fs::read(&path).unwrap();
    bytes[place.start + 80] ^= 0x10;
    std::fs::write(&path, &bytes).unwrap();
    let mut options = ReadOptions::new(16, 16);
    // Without leave, the end tells.
    let mut reader = McapReader::open(&path, options).unwrap();
    let mut next = Frame::<Counts>::zeros(16, 16);
    let mut places = Vec::new();
    let error = loop {
        match reader.next_into(&mut next) {
            Ok(true) => places.push(next.sequence),
            Ok(false) => panic!("it is damaged"),
            Err(error) => break error,
        }
    };
    let expected: Vec<u64> = (0..5).chain(10..20).collect();
    assert_eq!(places, expected);
    assert!(matches!(error, Error::RecordingDamaged { .. }), "{error}");
    let words = error.to_string();
    assert!(
        words.contains("1 damaged chunk left out; 5 frames missing"),
        "{words}"
    );
    // What is lost in the file is no gap of the device.
    options.keep_going = true;
    let mut reader = McapReader::open(&path, options).unwrap();
    while reader.next_into(&mut next).unwrap() {}
    assert!(reader.integrity().gaps.is_none());
    assert_eq!((reader.integrity().damage.frames, reader.skipped()), (5, 1));
    // The index knows where each frame is, and in which place.
    assert!(reader.seek(0.17).unwrap() && reader.next_into(&mut next).unwrap());
    assert_eq!(next.sequence, 17);
    assert_eq!(next.values(), frame(17).values());
}

#[test]
fn a_recording_whose_beginning_is_gone_is_read_without_its_index() {
    let folder = tempfile::tempdir().unwrap();
    let (path, saved) = (
        folder.path().join("run.mcap"),
        folder.path().join("saved.mcap"),
    );
    write(&path);
    let places = chunks(&path);
    let mut bytes = std::fs::read(&path).unwrap();
    // Header, sensor, schemas, channels: all in what is gone. And it was never ended.
    for byte in &mut bytes[8..places[0].0.end] {
        *byte = 0;
    }
    bytes.truncate(places[3].0.start);
    std::fs::write(&path, &bytes).unwrap();
    let recovered = recover(&path, &saved).unwrap();
    assert_eq!(recovered.frames, 10, "{recovered:?}");
    let (found, is_whole) = content(&saved).unwrap();
    assert!(is_whole);
    assert_eq!(found.sensor, Some(about().sensor.to_toml()));
    let expected: Vec<Vec<f64>> = (5..15).map(|n| frame(n).values().to_vec()).collect();
    assert_eq!(found.values, expected);
    // Unrecovered it gives as much.
    let mut reader = McapReader::open_any(&path).unwrap();
    assert_eq!(reader.sensor_toml(), found.sensor.as_deref());
    let mut next = Frame::<Counts>::zeros(16, 16);
    for values in expected {
        assert!(reader.next_into(&mut next).unwrap());
        assert_eq!(next.values(), values);
    }
    assert!(!reader.next_into(&mut next).unwrap());
    assert!(reader.integrity().damage.cut);
}
