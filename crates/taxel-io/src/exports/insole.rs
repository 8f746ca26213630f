//! Open insoles (Pressure2Pose, ISCAS 2025) as `.csv`: a line a time, and in the cells `Matrix_0` and `Matrix_1` the picture of each
//! foot, 33 x 15 whole numbers.

use std::fs::File;
use std::path::Path;

use super::cells::number_of;
use super::pad::{Pad, Quantity};
use super::text_file::TextFile;
use super::{Beginning, ExportAbout, ParsedFrame, Parser};
use crate::error::{Error, ExportError};

const FORMAT: &str = "insole .csv";
const ROWS: usize = 33;
const COLUMNS: usize = 15;
/// A time above this is no number of seconds since 1970, but of milliseconds.
const MILLISECONDS: f64 = 1e11;

pub(super) fn is_it(beginning: &Beginning) -> bool {
    let first = beginning.lines(1).next().unwrap_or("");
    first
        .split(',')
        .any(|name| name.trim_matches(['"', ' ']) == "Matrix_0")
}

fn refuse(file: &Path, reason: String, hint: &'static str) -> Error {
    Error::Export(Box::new(ExportError::Json {
        format: FORMAT,
        file: file.to_owned(),
        reason,
        hint,
    }))
}

pub(super) fn open(file: &Path) -> Result<(ExportAbout, Box<dyn Parser>), Error> {
    let failed = |error: csv::Error| {
        let hint = "a table with a line of names, and matrices between quotes";
        refuse(file, error.to_string(), hint)
    };
    let opened = File::open(file).map_err(|source| Error::Open {
        file: file.to_owned(),
        source,
    })?;
    let mut table = csv::ReaderBuilder::new().flexible(true).from_reader(opened);
    let names: Vec<String> = table
        .headers()
        .map_err(failed)?
        .iter()
        .map(|name| name.trim().to_owned())
        .collect();
    let feet = [("Matrix_0", "0"), ("Matrix_1", "1")];
    let place = |name: &str| names.iter().position(|own| own == name);
    let (mut pads, mut places) = (Vec::new(), Vec::new());
    for (name, foot) in feet {
        if let Some(at) = place(name) {
            let mut pad = Pad::new(ROWS, COLUMNS, "raw", Quantity::Raw);
            pad.name = foot.to_owned();
            pads.push(pad);
            places.push(at);
        }
    }
    if let [only] = &mut pads[..] {
        only.name.clear();
    }
    let about = ExportAbout::new(FORMAT, "open insole", pads);
    let reader = Insole {
        text: TextFile::open(file)?,
        time: names
            .iter()
            .position(|name| name.to_lowercase().contains("time")),
        table,
        places,
        record: csv::StringRecord::new(),
        next: 0,
    };
    Ok((about, Box::new(reader)))
}

struct Insole {
    /// The same file, for its name and its size.
    text: TextFile,
    table: csv::Reader<File>,
    time: Option<usize>,
    /// Cells of the feet.
    places: Vec<usize>,
    record: csv::StringRecord,
    /// Which foot of the line comes next.
    next: usize,
}

impl Parser for Insole {
    fn next(&mut self, frame: &mut ParsedFrame) -> Result<bool, Error> {
        if self.next == 0 {
            let read = self.table.read_record(&mut self.record);
            let is_more = read.map_err(|error| {
                let hint = "a table with a line of names, and matrices between quotes";
                refuse(self.text.file(), error.to_string(), hint)
            })?;
            if !is_more {
                return Ok(false);
            }
        }
        let pad = self.next;
        self.next = (self.next + 1) % self.places.len();
        frame.begin(pad, 0);
        let secs = self
            .time
            .and_then(|at| number_of(self.record.get(at)?.trim()));
        frame.secs = secs.map(|time| {
            if time > MILLISECONDS {
                1e-3 * time
            } else {
                time
            }
        });
        let cell = self.record.get(self.places[pad]).unwrap_or("");
        let is_number = |c: char| c.is_ascii_digit() || c == '.' || c == '-';
        let numbers = cell
            .split(|c: char| !is_number(c))
            .filter(|number| !number.is_empty());
        let value = |number: &str| number.parse::<f64>().unwrap_or(f64::NAN);
        frame.values.extend(numbers.map(value));
        let line = self.record.position().map_or(0, csv::Position::line);
        let is_whole = frame.values.iter().all(|value| *value >= 0.0);
        if frame.values.len() == ROWS * COLUMNS && is_whole {
            return Ok(true);
        }
        let found = if is_whole {
            format!(
                "{} numbers in `Matrix_{pad}` of line {line}",
                frame.values.len()
            )
        } else {
            format!("a number below 0, or none, in `Matrix_{pad}` of line {line}")
        };
        let expected = format!("{} of 0 or more", ROWS * COLUMNS);
        let hint = "a picture of 33 x 15; --keep-going leaves its frame out";
        Err(self.text.wrong_at(0, FORMAT, found, expected, hint))
    }

    fn skip_frame(&mut self) -> Result<(), Error> {
        Ok(())
    }

    fn text(&self) -> &TextFile {
        &self.text
    }
}
