//! Open insoles (Pressure2Pose, ISCAS 2025) as `.csv`: a line a time, and in the cells `Matrix_0` and `Matrix_1` the picture of each
//! foot, 33 x 15 whole numbers.

mod record;

use std::path::Path;

use super::cells::number_of;
use super::clock::{secs_of_date, secs_of_day};
use super::pad::{Pad, Quantity};
use super::text_file::{TextFile, text_of};
use super::{Beginning, ExportAbout, ParsedFrame, Parser};
use crate::error::Error;
use record::Record;

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

pub(super) fn open(file: &Path) -> Result<(ExportAbout, Box<dyn Parser>), Error> {
    let mut text = TextFile::open(file)?;
    text.advance()?;
    let part = delimiter(text.words().trim()).unwrap_or(b',');
    text.unread();
    let mut record = Record::default();
    record.read(&mut text, part)?;
    let name = |at| text_of(record.cell(at)).trim().to_owned();
    let names: Vec<String> = (0..record.len()).map(name).collect();
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
        part,
        places,
        record,
        next: 0,
        pad: None,
    };
    Ok((about, Box::new(reader)))
}

struct Insole {
    text: TextFile,
    /// What parts the cells of a line.
    part: u8,
    /// Its cell of times, and seconds of their unit where it is told.
    time: Option<(usize, Option<f64>)>,
    /// Its cell of frame numbers.
    number: Option<usize>,
    /// Cells of the feet, and their names.
    places: Vec<(usize, &'static str)>,
    record: Record,
    /// Which foot of the line comes next, and which was read last; `None` where the line has failed, which is of both.
    next: usize,
    pad: Option<usize>,
}

impl Insole {
    /// The number in a cell of the line.
    fn number(&self, at: usize) -> Option<f64> {
        number_of(text_of(self.record.cell(at)).trim())
    }

    /// Seconds of the line: a number, a date and a time, or a time of the day. A cell without any has none.
    fn secs(&self) -> Result<Option<f64>, Error> {
        let Some((at, unit)) = self.time else {
            return Ok(None);
        };
        let cell = text_of(self.record.cell(at));
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
        let line = self.record.line();
        self.text.wrong_on(line, FORMAT, found, expected, hint)
    }
}

impl Parser for Insole {
    fn next(&mut self, frame: &mut ParsedFrame) -> Result<bool, Error> {
        if self.next == 0 {
            self.pad = None;
            if !self.record.read(&mut self.text, self.part)? {
                return Ok(false);
            }
        }
        let pad = self.next;
        self.next = (self.next + 1) % self.places.len();
        self.pad = Some(pad);
        frame.begin(pad, 0);
        frame.secs = self.secs()?;
        let number = self.number.and_then(|at| self.number(at));
        let is_count = |number: &f64| number.fract() == 0.0 && *number >= 0.0;
        frame.number = number.filter(is_count).map(|number| number as u64);
        let (at, name) = self.places[pad];
        record::numbers(self.record.cell(at), &mut frame.values);
        let is_whole = frame
            .values
            .iter()
            .all(|value| (0.0..f64::INFINITY).contains(value));
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
        self.pad
    }

    fn is_cut(&self) -> bool {
        // The last number may have lost digits, but for those between quotes.
        !self.text.is_closed() && !self.record.is_quoted()
    }
}
