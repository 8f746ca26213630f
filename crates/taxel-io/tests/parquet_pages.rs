//! Pages of a Parquet table whose headers were changed: an error, never a panic.
#![cfg(feature = "parquet")]

use std::fs;
use std::path::Path;
use std::sync::Arc;

use parquet::basic::Encoding;
use parquet::data_type::Int64Type;
use parquet::file::properties::{WriterProperties, WriterVersion};
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::parser::parse_message_type;
use taxel::Counts;
use taxel_io::{FrameSource, ReadOptions, open_counts};

/// What pandas makes of a column of lists.
const LISTS: &str = "message schema { optional group counts (LIST) { repeated group list { optional int64 element; } } }";
/// The same beside a column that has no levels.
const NUMBERED: &str = "message schema { required int64 sequence; optional group counts (LIST) { repeated group list { optional int64 element; } } }";

/// A frame of four numbers, not packed, its page behind the file's first four bytes (with `NUMBERED`, that of its number).
fn written(schema: &str, version: WriterVersion, has_dictionary: bool) -> Vec<u8> {
    let schema = Arc::new(parse_message_type(schema).unwrap());
    let properties = WriterProperties::builder()
        .set_writer_version(version)
        .set_dictionary_enabled(has_dictionary)
        .set_encoding(Encoding::PLAIN)
        .build();
    let mut bytes = Vec::new();
    let mut writer =
        SerializedFileWriter::new(&mut bytes, schema.clone(), Arc::new(properties)).unwrap();
    let mut group = writer.next_row_group().unwrap();
    while let Some(mut column) = group.next_column().unwrap() {
        let typed = column.typed::<Int64Type>();
        if typed.get_descriptor().max_rep_level() == 0 {
            typed.write_batch(&[5], None, None).unwrap();
        } else {
            let (definition, repetition) = ([3; 4], [0, 1, 1, 1]);
            typed
                .write_batch(&[1, 2, 3, 4], Some(&definition), Some(&repetition))
                .unwrap();
        }
        column.close().unwrap();
    }
    group.close().unwrap();
    writer.close().unwrap();
    bytes
}

/// Frames read, and the error behind them.
fn read(bytes: &[u8]) -> (usize, Option<String>) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.parquet");
    fs::write(&path, bytes).unwrap();
    let source = open_counts(Path::new(&path), ReadOptions::new(2, 2)).unwrap();
    let mut frames = 0;
    for frame in FrameSource::<Counts>::frames(source) {
        match frame {
            Ok(frame) => assert_eq!(frame.values(), [1.0, 2.0, 3.0, 4.0]),
            Err(error) => return (frames, Some(error.to_string())),
        }
        frames += 1;
    }
    (frames, None)
}

/// Changes the bytes `from` where they stand, which is once.
fn changed(bytes: &[u8], from: &[u8], to: &[u8]) -> Vec<u8> {
    assert_eq!(from.len(), to.len());
    let mut places = (0..=bytes.len() - from.len()).filter(|&at| bytes[at..].starts_with(from));
    let at = places.next().expect("they stand there");
    assert_eq!(places.next(), None, "they stand there once");
    let mut changed = bytes.to_vec();
    changed[at..at + to.len()].copy_from_slice(to);
    changed
}

fn assert_refused(bytes: &[u8], words: &str) {
    let (frames, error) = read(bytes);
    let error = error.expect("an error");
    assert_eq!(frames, 0);
    assert!(error.starts_with("cannot read frame 0 of "), "{error}");
    assert!(error.contains(words), "{error}");
}

/// A field of a page's header is `0x15` and its number, twice as large; encodings are PLAIN 0, RLE 3, BIT_PACKED 4,
/// RLE_DICTIONARY 8. Here: how the numbers, the definition and the repetition levels are written.
fn encodings(numbers: u8, definition: u8, repetition: u8) -> [u8; 6] {
    [
        0x15,
        2 * numbers,
        0x15,
        2 * definition,
        0x15,
        2 * repetition,
    ]
}

#[test]
fn numbers_that_refer_to_a_dictionary_that_is_not_there_are_refused() {
    let whole = written(LISTS, WriterVersion::PARQUET_1_0, false);
    assert_eq!(read(&whole), (1, None));
    for (coded, name) in [(2, "PLAIN_DICTIONARY"), (8, "RLE_DICTIONARY")] {
        let broken = changed(&whole, &encodings(0, 3, 3), &encodings(coded, 3, 3));
        assert_refused(
            &broken,
            &format!("numbers written as {name}, but no dictionary before them"),
        );
    }
    let with = written(LISTS, WriterVersion::PARQUET_1_0, true);
    assert_eq!(read(&with), (1, None));
}

#[test]
fn levels_of_a_page_that_are_packed_otherwise_are_refused_where_there_are_levels() {
    let whole = written(LISTS, WriterVersion::PARQUET_1_0, false);
    for (definition, repetition) in [(4, 3), (3, 4), (4, 4)] {
        let other = encodings(0, definition, repetition);
        let broken = changed(&whole, &encodings(0, 3, 3), &other);
        assert_refused(&broken, "levels written as BIT_PACKED, expected RLE");
    }
    // parquet-mr says that of columns that have none; the first page here is of such a one.
    let mut whole = written(NUMBERED, WriterVersion::PARQUET_1_0, false);
    let at = (0..whole.len()).find(|&at| whole[at..].starts_with(&encodings(0, 3, 3)));
    let at = at.unwrap();
    whole[at..at + 6].copy_from_slice(&encodings(0, 4, 4));
    assert_eq!(read(&whole), (1, None));
}

#[test]
fn levels_longer_than_their_page_are_refused() {
    let whole = written(LISTS, WriterVersion::PARQUET_2_0, false);
    assert_eq!(read(&whole), (1, None));
    // Behind the magic the header: the kind of page, its length unpacked and packed, here in a byte each.
    let length = whole[7] / 2;
    assert_eq!(whole[4..10], [0x15, 6, 0x15, 2 * length, 0x15, 2 * length]);
    // Four numbers, none empty, one row, PLAIN; then the lengths of the definition and the repetition levels.
    let numbers = [0x15, 8, 0x15, 0, 0x15, 2, 0x15, 0, 0x15];
    let at = (0..40).find(|&at| whole[at..].starts_with(&numbers));
    let at = at.expect("the header of a second kind of page") + numbers.len();
    assert_eq!(whole[at + 1], 0x15);
    // The crate believes a page that is not packed how long it would be unpacked.
    let mut broken = whole.clone();
    broken[7] = 2 * 63;
    for (definition, repetition) in [(60, whole[at + 2] / 2), (whole[at] / 2, 60), (30, 30)] {
        assert!(definition + repetition > length);
        broken[at] = 2 * definition;
        broken[at + 2] = 2 * repetition;
        let words = format!(
            "levels of {} bytes in a page of {length}",
            definition + repetition
        );
        assert_refused(&broken, &words);
    }
}
