//! Open insoles (Pressure2Pose, ISCAS 2025) as `.csv`: a line a time, and in the cells `Matrix_0` and `Matrix_1` the picture of each
//! foot, 33 x 15 whole numbers.

use std::fs::File;
use std::path::Path;

use super::cells::number_of;
use super::clock::{secs_of_date, secs_of_day};
use super::pad::{Pad, Quantity};
use super::text_file::{TextFile, text_of};
use super::{Beginning, ExportAbout, ParsedFrame, Parser};
use crate::error::{Error, ExportError};

const FORMAT: &str = "insole .csv";
const ROWS: usize = 33;
const COLUMNS: usize = 15;
/// Columns of the feet.
const FEET: [(&str, &str); 2] = [("Matrix_0", "0"), ("Matrix_1", "1")];
/// Units of times since 1970 by their size: from so many on, of so many seconds each.
const SINCE_1970: [(f64, f64); 3] = [(1e17, 1e-9), (1e14, 1e-6), (1e11, 1e-3)];
/// Words for a time.
const TIME: [&str; 3] = ["time", "timestamp", "t"];
/// Words behind `frame` that leave it a frame's number.
const NUMBER: [&str; 7] = ["number", "no", "nr", "num", "id", "index", "idx"];

pub(super) fn is_it(beginning: &Beginning) -> bool {
    delimiter(beginning.lines(1).next().unwrap_or("")).is_some()
}

/// What parts the cells of a table with such a line of names; `None` where it names no foot.
fn delimiter(names: &str) -> Option<u8> {
    let is_foot = |name: &str| FEET.iter().any(|(foot, _)| name.eq_ignore_ascii_case(foot));
    b",;\t".iter().copied().find(|&one| {
        let mut names = names.split(char::from(one));
        names.any(|name| is_foot(name.trim_matches(['"', ' '])))
    })
}

/// The words of a column's name, in small letters.
fn words_of(name: &str) -> Vec<String> {
    let words = name.split(|c: char| !c.is_alphanumeric());
    let words = words.filter(|word| !word.is_empty());
    words.map(str::to_lowercase).collect()
}

/// Seconds of a unit that the last word of a column's name may be.
fn unit_secs(word: &str) -> Option<f64> {
    Some(match word {
        "s" | "sec" | "secs" | "second" | "seconds" => 1.0,
        "ms" | "msec" | "millis" | "millisecond" | "milliseconds" => 1e-3,
        "us" | "µs" | "μs" | "usec" | "micros" | "microsecond" | "microseconds" => 1e-6,
        "ns" | "nsec" | "nanos" | "nanosecond" | "nanoseconds" => 1e-9,
        _ => return None,
    })
}

/// The column of times, and seconds of its unit where its name says it. One that is called so and nothing else goes first.
fn time_column(names: &[String]) -> Option<(usize, Option<f64>)> {
    let is_time = |word: Option<&String>| word.is_some_and(|word| TIME.contains(&word.as_str()));
    let of = |(at, name): (usize, &String)| {
        let mut words = words_of(name);
        let unit = words.last().and_then(|word| unit_secs(word));
        if unit.is_some() {
            words.pop();
        }
        let is_it = is_time(words.first()) || is_time(words.last());
        is_it.then_some((words.len(), at, unit))
    };
    let found = names.iter().enumerate().filter_map(of);
    let found = found.min_by_key(|(words, at, _)| (*words, *at));
    found.map(|(_, at, unit)| (at, unit))
}

/// The column of the frames' numbers.
fn number_column(names: &[String]) -> Option<usize> {
    names.iter().position(|name| {
        let words = words_of(name);
        words.first().is_some_and(|word| word == "frame")
            && words[1..]
                .iter()
                .all(|word| NUMBER.contains(&word.as_str()))
    })
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
    let mut text = TextFile::open(file)?;
    text.advance()?;
    let mut table = csv::ReaderBuilder::new()
        .flexible(true)
        .delimiter(delimiter(text.words().trim()).unwrap_or(b','))
        .from_reader(opened);
    let names: Vec<String> = table
        .byte_headers()
        .map_err(failed)?
        .iter()
        .map(|name| {
            text_of(name)
                .trim_start_matches('\u{feff}')
                .trim()
                .to_owned()
        })
        .collect();
    let place = |name: &str| names.iter().position(|own| own.eq_ignore_ascii_case(name));
    let (mut pads, mut places) = (Vec::new(), Vec::new());
    for (name, foot) in FEET {
        if let Some(at) = place(name) {
            let in_file = (FORMAT, text.place(0));
            let mut pad = Pad::new(in_file, (ROWS, COLUMNS), "raw", Quantity::Raw)?;
            pad.name = foot.to_owned();
            pads.push(pad);
            places.push((at, name));
        }
    }
    if let [only] = &mut pads[..] {
        only.name.clear();
    }
    let about = ExportAbout::new(FORMAT, "open insole", pads);
    let reader = Insole {
        text,
        time: time_column(&names),
        number: number_column(&names),
        table,
        places,
        record: csv::ByteRecord::new(),
        next: 0,
        pad: 0,
    };
    Ok((about, Box::new(reader)))
}

struct Insole {
    /// The same file, for its name and its size.
    text: TextFile,
    table: csv::Reader<File>,
    /// Its cell of times, and seconds of their unit where it is told.
    time: Option<(usize, Option<f64>)>,
    /// Its cell of frame numbers.
    number: Option<usize>,
    /// Cells of the feet, and their names.
    places: Vec<(usize, &'static str)>,
    record: csv::ByteRecord,
    /// Which foot of the line comes next, and which was read last.
    next: usize,
    pad: usize,
}

impl Insole {
    /// The number in a cell of the line.
    fn number(&self, at: usize) -> Option<f64> {
        number_of(text_of(self.record.get(at)?).trim())
    }

    /// Seconds of the line: a number, a date and a time, or a time of the day. A cell without any has none.
    fn secs(&self) -> Result<Option<f64>, Error> {
        let Some((at, unit)) = self.time else {
            return Ok(None);
        };
        let cell = text_of(self.record.get(at).unwrap_or(b""));
        let cell = cell.trim();
        if cell.is_empty() {
            return Ok(None);
        }
        let Some(time) = number_of(cell) else {
            let secs = secs_of_date(cell).or_else(|| secs_of_day(cell));
            return secs.map(Some).ok_or_else(|| {
                let found = format!("a time of {} characters", cell.chars().count());
                let expected = "a number, or a date and a time as `2025-01-02 10:00:00.000`";
                self.wrong(found, expected, "write times so, or leave the cell empty")
            });
        };
        let by_size = || {
            let unit = SINCE_1970.iter().find(|(least, _)| time > *least);
            unit.map_or(1.0, |(_, secs)| *secs)
        };
        Ok(Some(time * unit.unwrap_or_else(by_size)))
    }

    /// That the line read last has something else than is expected.
    fn wrong(&self, found: String, expected: impl Into<String>, hint: &'static str) -> Error {
        let line = self.record.position().map_or(0, csv::Position::line);
        Error::Export(Box::new(ExportError::Line {
            format: FORMAT,
            at: self.text.line_at(line),
            found,
            expected: expected.into(),
            hint,
        }))
    }
}

impl Parser for Insole {
    fn next(&mut self, frame: &mut ParsedFrame) -> Result<bool, Error> {
        if self.next == 0 {
            let read = self.table.read_byte_record(&mut self.record);
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
        self.pad = pad;
        frame.begin(pad, 0);
        frame.secs = self.secs()?;
        let number = self.number.and_then(|at| self.number(at));
        let is_count = |number: &f64| number.fract() == 0.0 && *number >= 0.0;
        frame.number = number.filter(is_count).map(|number| number as u64);
        let (at, name) = self.places[pad];
        let cell = text_of(self.record.get(at).unwrap_or(b""));
        let is_number = |c: char| c.is_ascii_digit() || matches!(c, '.' | '-' | '+' | 'e' | 'E');
        let numbers = cell
            .split(|c: char| !is_number(c))
            .filter(|number| !number.is_empty());
        let value = |number: &str| number.parse::<f64>().unwrap_or(f64::NAN);
        frame.values.extend(numbers.map(value));
        let is_whole = frame.values.iter().all(|value| *value >= 0.0);
        if frame.values.len() == ROWS * COLUMNS && is_whole {
            return Ok(true);
        }
        let found = if is_whole {
            format!("{} numbers in `{name}`", frame.values.len())
        } else {
            format!("a number below 0, or none, in `{name}`")
        };
        let expected = format!("{} of 0 or more", ROWS * COLUMNS);
        let hint = "a picture of 33 x 15; --keep-going leaves its frame out";
        Err(self.wrong(found, expected, hint))
    }

    fn skip_frame(&mut self) -> Result<(), Error> {
        Ok(())
    }

    fn text(&self) -> &TextFile {
        &self.text
    }

    fn pad_of_error(&self) -> Option<usize> {
        Some(self.pad)
    }
}
