//! Tactilus mats as JSON: rows, columns, and snapshots by number, each a list of readings. The file tells no unit, and of times
//! nothing; what it says of a person is not read.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

use serde::Deserialize;

use super::pad::{Pad, Quantity};
use super::text_file::TextFile;
use super::{Beginning, ExportAbout, ParsedFrame, Parser};
use crate::error::{Error, ExportError};
use crate::source::MAX_TAXELS;

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

#[derive(Deserialize)]
#[serde(untagged)]
enum Snapshots {
    Named(BTreeMap<String, Snapshot>),
    Listed(Vec<Snapshot>),
}

impl Snapshots {
    /// By their numbers; the name of one that has none.
    fn in_order(self) -> Result<Vec<(u64, Snapshot)>, String> {
        match self {
            Self::Listed(list) => Ok((0..).zip(list).collect()),
            Self::Named(named) => {
                let number = |(name, one): (String, Snapshot)| match name.parse() {
                    Ok(number) => Ok((number, one)),
                    Err(_) => Err(name),
                };
                let mut all: Vec<(u64, Snapshot)> =
                    named.into_iter().map(number).collect::<Result<_, _>>()?;
                all.sort_by_key(|(number, _)| *number);
                Ok(all)
            }
        }
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
    let reader = BufReader::new(opened.take(MAX_BYTES));
    let recording: Recording = serde_json::from_reader(reader).map_err(|error| {
        let hint = "expected tactilus_rows, tactilus_columns and snapshots with tactilus_readings";
        refuse(error.to_string(), hint)
    })?;
    let (rows, columns) = (recording.tactilus_rows, recording.tactilus_columns);
    if !(1..=MAX_TAXELS).contains(&rows.saturating_mul(columns)) {
        let reason = format!("{rows} rows x {columns} columns");
        return Err(refuse(
            reason,
            "tactilus_rows and tactilus_columns say how large the mat is",
        ));
    }
    let snapshots = recording
        .snapshots
        .in_order()
        .map_err(|name| refuse(format!("snapshot `{name}`"), "snapshots are numbered"))?;
    let pad = Pad::new(rows, columns, "raw", Quantity::Raw);
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
