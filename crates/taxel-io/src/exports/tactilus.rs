//! Tactilus mats as JSON: rows, columns, and snapshots by number, each a list of readings. The file tells no unit, and of times
//! nothing; what it says of a person is not read.

use std::collections::BTreeMap;
use std::fmt;
use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;

use serde::de::{Error as _, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};

use super::pad::{Pad, Quantity};
use super::text_file::TextFile;
use super::{Beginning, ExportAbout, ParsedFrame, Parser};
use crate::error::{Error, ExportError};

const FORMAT: &str = "Tactilus JSON";
/// Bytes of a file that is held as a whole.
const MAX_BYTES: u64 = 256 << 20;
/// Decimals that a reading keeps.
const DECIMALS: u8 = 6;

#[derive(Deserialize)]
struct Recording {
    tactilus_rows: usize,
    tactilus_columns: usize,
    snapshots: Snapshots,
}

/// Snapshots by their numbers: of a list by their places in it.
struct Snapshots(Vec<(u64, Snapshot)>);

impl<'de> Deserialize<'de> for Snapshots {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(InOrder)
    }
}

/// Takes a list of snapshots, or an object of them by their numbers.
struct InOrder;

impl<'de> Visitor<'de> for InOrder {
    type Value = Snapshots;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a list of snapshots, or an object of them by number")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Snapshots, A::Error> {
        let mut all = Vec::new();
        while let Some(snapshot) = list.next_element()? {
            all.push((all.len() as u64, snapshot));
        }
        Ok(Snapshots(all))
    }

    /// A number that comes twice is told: which of the two is meant, nobody can know.
    fn visit_map<A: MapAccess<'de>>(self, mut object: A) -> Result<Snapshots, A::Error> {
        let mut all = BTreeMap::new();
        while let Some((name, snapshot)) = object.next_entry::<String, Snapshot>()? {
            let Ok(number) = name.parse::<u64>() else {
                return Err(A::Error::custom(format!("snapshot `{name}` has no number")));
            };
            if all.insert(number, snapshot).is_some() {
                return Err(A::Error::custom(format!(
                    "snapshot {number} is there twice"
                )));
            }
        }
        Ok(Snapshots(all.into_iter().collect()))
    }
}

#[derive(Deserialize)]
struct Snapshot {
    tactilus_readings: Vec<Option<f64>>,
}

pub(super) fn is_it(beginning: &Beginning) -> bool {
    beginning.text.trim_start().starts_with('{') && beginning.text.contains("\"tactilus_")
}

pub(super) fn open(file: &Path) -> Result<(ExportAbout, Box<dyn Parser>), Error> {
    let text = TextFile::open(file)?;
    let refuse = |reason: String, hint: &'static str| {
        Error::Export(Box::new(ExportError::Json {
            format: FORMAT,
            file: file.to_owned(),
            reason,
            hint,
        }))
    };
    if let Some(bytes) = text.total().filter(|bytes| *bytes > MAX_BYTES) {
        let reason = format!("{bytes} bytes, at most {MAX_BYTES} are read");
        return Err(refuse(
            reason,
            "a file of JSON is held as a whole; split it",
        ));
    }
    let opened = File::open(file).map_err(|source| Error::Open {
        file: file.to_owned(),
        source,
    })?;
    let mut reader = BufReader::new(opened.take(MAX_BYTES));
    // JSON has no byte-order mark; programs put one before it.
    if let Ok(beginning) = reader.fill_buf()
        && beginning.starts_with(b"\xEF\xBB\xBF")
    {
        reader.consume(3);
    }
    let recording: Recording = serde_json::from_reader(reader).map_err(|error| {
        let hint = "expected tactilus_rows, tactilus_columns and snapshots with tactilus_readings";
        refuse(error.to_string(), hint)
    })?;
    let (rows, columns) = (recording.tactilus_rows, recording.tactilus_columns);
    let at = (FORMAT, text.place(0));
    let pad = Pad::new(at, (rows, columns), "raw", Quantity::Raw)?;
    let Snapshots(snapshots) = recording.snapshots;
    let mut about = ExportAbout::new(FORMAT, "Tactilus", vec![pad]);
    about.frames = Some(snapshots.len() as u64);
    let reader = Tactilus {
        text,
        taxels: rows * columns,
        snapshots: snapshots.into_iter(),
    };
    Ok((about, Box::new(reader)))
}

struct Tactilus {
    text: TextFile,
    taxels: usize,
    snapshots: std::vec::IntoIter<(u64, Snapshot)>,
}

impl Parser for Tactilus {
    fn next(&mut self, frame: &mut ParsedFrame) -> Result<bool, Error> {
        let Some((number, Snapshot { tactilus_readings })) = self.snapshots.next() else {
            return Ok(false);
        };
        frame.begin(0, self.taxels);
        frame.number = Some(number);
        frame.decimals = DECIMALS;
        let found = tactilus_readings.len();
        if found != self.taxels {
            let expected = format!("{} of them", self.taxels);
            let found = format!("snapshot {number} has {found} readings");
            let hint = "rows times columns of the mat";
            return Err(self.text.wrong_at(0, FORMAT, found, expected, hint));
        }
        let is_broken = |reading: &&Option<f64>| reading.is_none_or(|reading| reading < 0.0);
        if let Some(reading) = tactilus_readings.iter().find(is_broken) {
            let reading = reading.map_or_else(|| "null".to_owned(), |reading| reading.to_string());
            let found = format!("snapshot {number} reads {reading}");
            let hint = "a reading that is missing or broken; --keep-going leaves its frame out";
            return Err(self
                .text
                .wrong_at(0, FORMAT, found, "a number of 0 or more", hint));
        }
        let readings = tactilus_readings.into_iter().flatten();
        frame.values.clear();
        frame.values.extend(readings);
        Ok(true)
    }

    fn skip_frame(&mut self) -> Result<(), Error> {
        Ok(())
    }

    fn text(&self) -> &TextFile {
        &self.text
    }
}
