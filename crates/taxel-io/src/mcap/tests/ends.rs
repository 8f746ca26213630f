//! An end that is out of place: whatever was cut out, put in or hung on, the loss is named or every frame is there.

use std::path::Path;

use super::{about, at, frame};
use crate::mcap::{MAGIC, McapReader, McapWriter, PLAIN_END, recover};
use crate::options::ReadOptions;
use crate::source::FrameSource;
use taxel::{Counts, Frame};

const FRAMES: u64 = 12;
/// What the scanner sees of a data section: its end, the footer, and the magic.
const DATA_END: usize = 13;
const FOOTER: usize = 29;

/// A recording of seven chunks, with the place of its data's end.
fn recording(path: &Path) -> (Vec<u8>, usize) {
    let mut writer = McapWriter::create(path, &about()).unwrap();
    for number in 0..FRAMES {
        writer.write_counts(&frame(number), at(number)).unwrap();
        if number % 2 == 1 {
            writer.flush().unwrap();
        }
    }
    writer.finish().unwrap();
    let bytes = std::fs::read(path).unwrap();
    let start = bytes.len() - MAGIC.len() - FOOTER + 9;
    let start = u64::from_le_bytes(bytes[start..start + 8].try_into().unwrap());
    (bytes, start as usize - DATA_END)
}

/// Whether a reader says that nothing is missing, and what it reads.
fn read(path: &Path) -> Option<(Vec<Vec<f64>>, bool)> {
    let mut options = ReadOptions::new(16, 16);
    options.accept_damage = true;
    options.keep_going = true;
    let mut reader = McapReader::open(path, options).ok()?;
    let (mut next, mut values) = (Frame::<Counts>::zeros(16, 16), Vec::new());
    while reader.next_into(&mut next).unwrap() {
        values.push(next.values().to_vec());
    }
    Some((values, reader.integrity().is_whole()))
}

/// The files: what was done, and the bytes.
fn broken(whole: &[u8], data_end: usize) -> Vec<(String, Vec<u8>)> {
    let mut files = vec![
        ("twice".to_owned(), [whole, whole].concat()),
        ("junk behind".to_owned(), [whole, b"\0\0\0\0\0"].concat()),
        (
            "end only".to_owned(),
            [&MAGIC[..], &whole[whole.len() - FOOTER - 8..]].concat(),
        ),
        (
            "plain end only".to_owned(),
            [&MAGIC[..], PLAIN_END].concat(),
        ),
    ];
    let (own_end, footer) = (&whole[data_end..], &whole[whole.len() - FOOTER - 8..]);
    for place in (8..data_end).step_by(29) {
        let (before, behind) = whole.split_at(place);
        let over = &behind[PLAIN_END.len().min(behind.len())..];
        for (what, bytes) in [
            ("cut out up to the end", [before, own_end].concat()),
            ("cut out up to the footer", [before, footer].concat()),
            ("cut out from the header", [&whole[..45], behind].concat()),
            ("an end put in", [before, PLAIN_END, behind].concat()),
            ("an end put over", [before, PLAIN_END, over].concat()),
            ("its own end put in", [before, own_end, behind].concat()),
            ("a footer put in", [before, footer, behind].concat()),
            (
                "a middle cut out",
                [before, &whole[(place + 1500).min(data_end)..]].concat(),
            ),
        ] {
            files.push((format!("{what} at {place}"), bytes));
        }
    }
    files
}

#[test]
fn no_end_out_of_place_hides_a_loss() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let (good, bad, saved) = (path("good.mcap"), path("bad.mcap"), path("saved.mcap"));
    let (whole, data_end) = recording(&good);
    let expected: Vec<Vec<f64>> = (0..FRAMES).map(|n| frame(n).values().to_vec()).collect();
    assert_eq!(read(&good).unwrap(), (expected.clone(), true));
    for (what, bytes) in broken(&whole, data_end) {
        std::fs::write(&bad, &bytes).unwrap();
        let _ = std::fs::remove_file(&saved);
        let recovered = recover(&bad, &saved).unwrap();
        let says_all = recovered.is_all() && recovered.messages > 0;
        match read(&saved) {
            Some((values, _)) => {
                assert_eq!(values.len() as u64, recovered.frames, "{what}");
                assert!(!says_all || values == expected, "{what}: {recovered:?}");
            }
            None => assert!(recovered.messages == 0 && !saved.exists(), "{what}"),
        }
        if let Some((values, is_whole)) = read(&bad) {
            assert!(!is_whole || values == expected, "{what}");
        }
    }
}

#[test]
fn an_end_without_a_checksum_or_an_index_is_one_where_it_is_in_its_place() {
    let folder = tempfile::tempdir().unwrap();
    let (path, saved) = (
        folder.path().join("run.mcap"),
        folder.path().join("saved.mcap"),
    );
    let (mut bytes, data_end) = recording(&path);
    // As a writer leaves it that knows no checksum, and as one that knows no index.
    bytes[data_end + 9..data_end + 13].fill(0);
    let plain = [&bytes[..data_end], PLAIN_END].concat();
    for bytes in [bytes, plain] {
        std::fs::write(&path, bytes).unwrap();
        let recovered = recover(&path, &saved).unwrap();
        assert!(
            recovered.is_all() && recovered.frames == FRAMES,
            "{recovered:?}"
        );
        std::fs::remove_file(&saved).unwrap();
    }
}
