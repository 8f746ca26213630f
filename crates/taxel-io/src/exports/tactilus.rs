//! Tactilus mats as JSON: rows, columns, and snapshots by number, each a list of readings. The file tells no unit, and of times
//! nothing; what it says of a person is not read. It is read twice, one snapshot at a time: rows and columns may stand behind them.

mod scanner;

use std::path::Path;

use serde::Deserialize;
use serde::de::IgnoredAny;

use super::cells::Separator;
use super::pad::{Pad, Quantity};
use super::plain::PlainLine;
use super::text_file::TextFile;
use super::{Beginning, ExportAbout, ParsedFrame, Parser};
use crate::error::{Error, ExportError};
use scanner::{Fault, MAX_VALUE, Scanner};

const FORMAT: &str = "Tactilus JSON";
/// Decimals that a reading keeps.
const DECIMALS: u8 = 6;
/// Snapshots whose places are held, where they do not stand in the order of their numbers.
const MAX_PLACES: usize = 1 << 20;
/// What a snapshot nearly always begins with.
const READINGS: &[u8] = b"\"tactilus_readings\"";
const HINT: &str = "expected tactilus_rows, tactilus_columns and snapshots with tactilus_readings";

#[derive(Deserialize)]
struct Snapshot {
    tactilus_readings: Vec<Option<f64>>,
}

pub(super) fn is_it(beginning: &Beginning) -> bool {
    beginning.text.trim_start().starts_with('{') && beginning.text.contains("\"tactilus_")
}

/// Snapshots: a list, or an object of them by their numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
    List,
    Object,
}

impl Kind {
    fn closes(self) -> u8 {
        match self {
            Self::List => b']',
            Self::Object => b'}',
        }
    }
}

/// What stands in a file, but for the snapshots themselves.
#[derive(Debug, Default)]
struct Outline {
    rows: Option<usize>,
    columns: Option<usize>,
    /// How the snapshots stand in it, and where their first byte is.
    snapshots: Option<(Kind, u64)>,
    /// How many there are; the last one may be cut.
    count: u64,
    /// Number and place of each, in the order of their numbers; empty where they stand in it.
    places: Vec<(u64, u64)>,
    /// Whether it ends within its snapshots.
    is_cut: bool,
}

pub(super) fn open(file: &Path) -> Result<(ExportAbout, Box<dyn Parser>), Error> {
    let text = TextFile::open(file)?;
    let told = |fault: Fault| refuse(&text, fault);
    let opened = || Scanner::open(file).map_err(Fault::Io);
    let outline = opened()
        .and_then(|mut scanner| Outline::of(&mut scanner))
        .map_err(told)?;
    let outline = outline.map_err(|reason| json(&text, reason))?;
    let missing = |key: &str| json(&text, format!("no `{key}`"));
    let rows = outline.rows.ok_or_else(|| missing("tactilus_rows"))?;
    let columns = outline.columns.ok_or_else(|| missing("tactilus_columns"))?;
    let (kind, begins) = outline.snapshots.ok_or_else(|| missing("snapshots"))?;
    let at = (FORMAT, text.place(0));
    let pad = Pad::new(at, (rows, columns), "raw", Quantity::Raw)?;
    let mut about = ExportAbout::new(FORMAT, "Tactilus", vec![pad]);
    about.frames = (!outline.is_cut).then_some(outline.count);
    let mut scanner = opened().map_err(told)?;
    scanner
        .go_to(begins)
        .map_err(|error| told(Fault::Io(error)))?;
    let reader = Tactilus {
        scanner,
        taxels: rows * columns,
        kind,
        places: outline.places.into_iter(),
        count: outline.count,
        read: 0,
        is_cut: outline.is_cut,
        text,
    };
    Ok((about, Box::new(reader)))
}

fn json(text: &TextFile, reason: String) -> Error {
    Error::Export(Box::new(ExportError::Json {
        format: FORMAT,
        file: text.file().to_owned(),
        reason,
        hint: HINT,
    }))
}

fn refuse(text: &TextFile, fault: Fault) -> Error {
    match fault {
        Fault::Io(source) => Error::Read {
            file: text.file().to_owned(),
            bytes: 0,
            source,
        },
        Fault::End => json(text, "it ends before it is closed".to_owned()),
        Fault::Other { at, expected } => json(text, format!("no {expected} at byte {}", at + 1)),
        Fault::Long { at } => {
            let reason = format!("what begins at byte {} is above {MAX_VALUE} bytes", at + 1);
            json(text, reason)
        }
    }
}

impl Outline {
    /// Goes through a file; what is whole of one that was cut is read. `Ok(Err(…))`: it is JSON, and has not what it should.
    fn of(scanner: &mut Scanner) -> Result<Result<Self, String>, Fault> {
        let mut outline = Self::default();
        match outline.take_all(scanner) {
            Ok(found) => Ok(found.map(|()| outline)),
            Err(Fault::End) if outline.snapshots.is_some() => {
                outline.is_cut = true;
                Ok(Ok(outline))
            }
            Err(fault) => Err(fault),
        }
    }

    fn take_all(&mut self, scanner: &mut Scanner) -> Result<Result<(), String>, Fault> {
        scanner.pass(b'{', "`{`")?;
        let mut has_one = false;
        while scanner.next_entry(b'}', has_one)? {
            has_one = true;
            let key = scanner.key()?;
            let twice = match key.as_slice() {
                b"tactilus_rows" => replace_count(scanner, &mut self.rows)?,
                b"tactilus_columns" => replace_count(scanner, &mut self.columns)?,
                b"snapshots" if self.snapshots.is_some() => true,
                b"snapshots" => {
                    if let Err(reason) = self.take_snapshots(scanner)? {
                        return Ok(Err(reason));
                    }
                    false
                }
                _ => {
                    scanner.skip_value()?;
                    false
                }
            };
            if twice {
                let key = String::from_utf8_lossy(&key);
                return Ok(Err(format!("`{key}` is there twice")));
            }
        }
        match scanner.peek()? {
            Some(_) => Err(scanner.other("end of the file")),
            None => Ok(Ok(())),
        }
    }

    /// Goes through the snapshots, without a look at what is in them.
    fn take_snapshots(&mut self, scanner: &mut Scanner) -> Result<Result<(), String>, Fault> {
        let kind = match scanner.peek()? {
            Some(b'[') => Kind::List,
            Some(b'{') => Kind::Object,
            Some(_) => return Err(scanner.other("list or object of snapshots")),
            None => return Err(Fault::End),
        };
        scanner.pass(if kind == Kind::List { b'[' } else { b'{' }, "snapshots")?;
        self.snapshots = Some((kind, scanner.at()));
        let mut last = None;
        while scanner.next_entry(kind.closes(), self.count > 0)? {
            if kind == Kind::Object {
                let number = match number_of(scanner)? {
                    Ok(number) => number,
                    Err(reason) => return Ok(Err(reason)),
                };
                if last.is_some_and(|last| number <= last) && self.places.is_empty() {
                    return self.take_places(scanner);
                }
                last = Some(number);
            }
            self.count += 1;
            scanner.skip_value()?;
        }
        Ok(Ok(()))
    }

    /// The same where they do not stand in the order of their numbers: where each stands is held. A number that comes twice is
    /// told: which of the two is meant, nobody can know.
    fn take_places(&mut self, scanner: &mut Scanner) -> Result<Result<(), String>, Fault> {
        let begins = self.snapshots.map_or(0, |(_, begins)| begins);
        scanner.go_to(begins).map_err(Fault::Io)?;
        let found = self.find_places(scanner);
        self.places.sort_unstable();
        self.count = self.places.len() as u64;
        let twice = self.places.windows(2).find(|pair| pair[0].0 == pair[1].0);
        match (twice, found) {
            (Some(pair), _) => Ok(Err(format!("snapshot {} is there twice", pair[0].0))),
            (None, found) => found,
        }
    }

    fn find_places(&mut self, scanner: &mut Scanner) -> Result<Result<(), String>, Fault> {
        while scanner.next_entry(b'}', !self.places.is_empty())? {
            let number = match number_of(scanner)? {
                Ok(number) => number,
                Err(reason) => return Ok(Err(reason)),
            };
            if self.places.len() == MAX_PLACES {
                let reason = format!("above {MAX_PLACES} snapshots, which do not stand in order");
                return Ok(Err(reason));
            }
            self.places.push((number, scanner.at()));
            scanner.skip_value()?;
        }
        Ok(Ok(()))
    }
}

/// Reads a count of rows or columns; whether there was one.
fn replace_count(scanner: &mut Scanner, count: &mut Option<usize>) -> Result<bool, Fault> {
    let at = scanner.at();
    let told = serde_json::from_slice::<usize>(scanner.value()?);
    let expected = "whole number of rows or columns";
    let told = told.map_err(|_| Fault::Other { at, expected })?;
    Ok(count.replace(told).is_some())
}

/// The number of a snapshot, which is its key.
fn number_of(scanner: &mut Scanner) -> Result<Result<u64, String>, Fault> {
    let key = scanner.key()?;
    let number = std::str::from_utf8(&key)
        .ok()
        .and_then(|key| key.parse().ok());
    Ok(number.ok_or_else(|| {
        let key = String::from_utf8_lossy(&key);
        format!("snapshot `{}` has no number", key.escape_debug())
    }))
}

struct Tactilus {
    /// The same file, for its name and its size.
    text: TextFile,
    scanner: Scanner,
    taxels: usize,
    kind: Kind,
    /// Numbers and places of the snapshots, where they do not stand in order.
    places: std::vec::IntoIter<(u64, u64)>,
    count: u64,
    /// How many were read.
    read: u64,
    is_cut: bool,
}

impl Tactilus {
    /// Goes before the next snapshot: its number.
    fn find(&mut self) -> Result<u64, Fault> {
        if let Some((number, place)) = self.places.next() {
            self.scanner.go_to(place).map_err(Fault::Io)?;
            return Ok(number);
        }
        self.scanner.next_entry(self.kind.closes(), self.read > 0)?;
        match self.kind {
            Kind::List => Ok(self.read),
            Kind::Object => number_of(&mut self.scanner)?
                .map_err(|_| self.scanner.other("number of a snapshot")),
        }
    }

    /// That a snapshot is no list of readings, and why.
    fn broken(&self, number: u64, reason: &str) -> Error {
        let found = format!("snapshot {number} is broken: {reason}");
        let expected = "an object with a list of numbers, `tactilus_readings`";
        let hint = "--keep-going leaves its frame out";
        self.text.wrong_at(0, FORMAT, found, expected, hint)
    }

    /// Readings of a snapshot, into a frame.
    fn take(
        text: &TextFile,
        frame: &mut ParsedFrame,
        number: u64,
        readings: &[Option<f64>],
    ) -> Result<(), Error> {
        let is_broken = |reading: &&Option<f64>| reading.is_none_or(|reading| reading < 0.0);
        if let Some(reading) = readings.iter().find(is_broken) {
            let reading = reading.map_or_else(|| "null".to_owned(), |reading| reading.to_string());
            let found = format!("snapshot {number} reads {reading}");
            let hint = "a reading that is missing or broken; --keep-going leaves its frame out";
            return Err(text.wrong_at(0, FORMAT, found, "a number of 0 or more", hint));
        }
        frame.values.clear();
        frame.values.extend(readings.iter().flatten());
        Ok(())
    }
}

/// Reads a snapshot of `length` bytes of nothing but plain numbers, of which there are as many as places; false of every other,
/// whatever is in it. `text` goes on behind it.
fn plain_snapshot(text: &[u8], length: usize, out: &mut [f64]) -> bool {
    let Some(from) = list_of(&text[..length]) else {
        return false;
    };
    let Some(count) = memchr::memchr(b']', &text[from..length]) else {
        return false;
    };
    let numbers = PlainLine {
        text: &text[from..],
        length: count,
        separator: Separator::One(b','),
        point: Some(b'.'),
    };
    let (read, at) = numbers.read(0, out, &mut 0, |_, _| false);
    // A comma that closes a list is none of JSON.
    if read < out.len() || at != count || text[from..from + count].ends_with(b",") {
        return false;
    }
    // Whatever stands behind them is to be JSON, and no other list of them.
    let behind = &text[from + count + 1..length];
    let rest = [b"{\"\":0", behind].concat();
    memchr::memmem::find(behind, READINGS).is_none()
        && serde_json::from_slice::<IgnoredAny>(&rest).is_ok()
}

/// Where the numbers begin of a snapshot that begins with them.
fn list_of(text: &[u8]) -> Option<usize> {
    let mut rest = text;
    for word in [b"{", READINGS, b":", b"["] {
        rest = rest.trim_ascii_start().strip_prefix(word)?;
    }
    Some(text.len() - rest.len())
}

impl Parser for Tactilus {
    fn next(&mut self, frame: &mut ParsedFrame) -> Result<bool, Error> {
        if self.read == self.count {
            return Ok(false);
        }
        let found = self.find();
        self.read += 1;
        let (number, fault) = match found {
            Ok(number) => (number, None),
            Err(fault) => (self.read, Some(fault)),
        };
        frame.begin(0, self.taxels);
        frame.number = Some(number);
        frame.decimals = DECIMALS;
        let snapshot = match fault {
            Some(fault) => Err(fault),
            None => self.scanner.value(),
        };
        let snapshot = match snapshot {
            Ok(snapshot) => snapshot,
            // The last one, of a file that was cut.
            Err(Fault::End) => {
                let found = format!("snapshot {number} without its end");
                let expected = format!("{} readings", self.taxels);
                return Err(self.text.cut(FORMAT, found, expected));
            }
            Err(fault) => return Err(refuse(&self.text, fault)),
        };
        let length = snapshot.len();
        let text = self.scanner.value_on(length);
        if plain_snapshot(text, length, &mut frame.values) {
            return Ok(true);
        }
        let readings = serde_json::from_slice::<Snapshot>(&text[..length]);
        let readings = match readings {
            Ok(snapshot) => snapshot.tactilus_readings,
            Err(error) => return Err(self.broken(number, &error.to_string())),
        };
        let found = readings.len();
        if found != self.taxels {
            let expected = format!("{} of them", self.taxels);
            let found = format!("snapshot {number} has {found} readings");
            let hint = "rows times columns of the mat";
            return Err(self.text.wrong_at(0, FORMAT, found, expected, hint));
        }
        Self::take(&self.text, frame, number, &readings)?;
        Ok(true)
    }

    fn skip_frame(&mut self) -> Result<(), Error> {
        Ok(())
    }

    fn text(&self) -> &TextFile {
        &self.text
    }

    fn is_cut(&self) -> bool {
        self.is_cut
    }
}
