//! Small tables with a header line: columns by name in any order, cells with their place.

use std::io::Read;
use std::path::{Path, PathBuf};

use csv::ByteRecord;

use crate::error::{Error, Place, TableError};
use crate::grid::shortened;
use crate::source::open_input;

/// The most bytes a table may have; it is held whole.
const TABLE_BYTES: u64 = 8 << 20;
/// The most lines a table may have: what is made of a line takes thirty times the shortest line's bytes, and memory is to
/// stay below 256 MiB.
const TABLE_LINES: usize = 1 << 18;
/// The most columns a table may have: ten times those that are known, and room for empty ones of a spreadsheet.
const TABLE_COLUMNS: usize = 256;

/// A table in memory.
pub(crate) struct Table {
    file: PathBuf,
    text: Vec<u8>,
    header: Vec<String>,
}

/// A line of it.
pub(crate) struct Row<'a> {
    table: &'a Table,
    record: &'a ByteRecord,
    /// Byte of the file at which it begins.
    start: usize,
    /// Its line, from 1.
    pub(crate) line: u64,
}

impl Table {
    /// Reads a table all of whose columns are `known`.
    pub(crate) fn open(path: &Path, known: &[&'static str]) -> Result<Self, Error> {
        let (input, _) = open_input(path)?;
        Self::read(input, path, known)
    }

    /// Reads a table of any columns.
    pub(crate) fn open_any(path: &Path) -> Result<Self, Error> {
        Self::text(open_input(path)?.0, path)
    }

    pub(crate) fn read(
        input: impl Read,
        path: &Path,
        known: &[&'static str],
    ) -> Result<Self, Error> {
        let table = Self::text(input, path)?;
        table.check_names(known)?;
        Ok(table)
    }

    fn text(input: impl Read, path: &Path) -> Result<Self, Error> {
        let file = path.to_owned();
        let mut text = Vec::new();
        if let Err(source) = input.take(TABLE_BYTES + 1).read_to_end(&mut text) {
            let bytes = text.len() as u64;
            return Err(Error::Read {
                file,
                bytes,
                source,
            });
        }
        if text.len() as u64 > TABLE_BYTES {
            let found = text.len() as u64;
            return Err(TableError::TooLong {
                file,
                found,
                what: "bytes",
                limit: TABLE_BYTES,
            }
            .into());
        }
        if text.starts_with(b"\xEF\xBB\xBF") {
            text.drain(..3);
        }
        let mut table = Self {
            file,
            text,
            header: Vec::new(),
        };
        let mut header = ByteRecord::new();
        match table.reader().read_byte_record(&mut header) {
            Ok(true) => {}
            _ => return Err(table.empty("header")),
        }
        if header.len() > TABLE_COLUMNS {
            return Err(table.too_long(header.len(), "columns", TABLE_COLUMNS));
        }
        table.header = header.iter().map(name_of).collect();
        Ok(table)
    }

    fn too_long(&self, found: usize, what: &'static str, limit: usize) -> Error {
        TableError::TooLong {
            file: self.file.clone(),
            found: found as u64,
            what,
            limit: limit as u64,
        }
        .into()
    }

    fn reader(&self) -> csv::Reader<&[u8]> {
        csv::ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .from_reader(&self.text)
    }

    fn empty(&self, what: &'static str) -> Error {
        let file = self.file.clone();
        Error::Empty {
            file,
            what,
            found: 0,
        }
    }

    fn header_place(&self) -> Place {
        let blank = |b: &&u8| matches!(**b, b'\n' | b'\r');
        let before = self.text.iter().take_while(blank);
        Place {
            file: self.file.clone(),
            line: 1 + before.filter(|b| **b == b'\n').count() as u64,
            column: 1,
        }
    }

    fn check_names(&self, known: &[&'static str]) -> Result<(), Error> {
        let strange = |name: &&String| !name.is_empty() && !known.contains(&name.as_str());
        let Some(name) = self.header.iter().find(strange) else {
            return Ok(());
        };
        let hint = if self.header.len() == 1 && name.contains([';', '\t']) {
            "cells are separated by commas".to_owned()
        } else {
            match nearest(name, known.iter().copied()) {
                Some(near) => format!("did you mean `{near}`?"),
                None => format!("the columns are {}", known.join(", ")),
            }
        };
        let (at, found) = (self.header_place(), shortened(name.as_bytes()));
        Err(TableError::UnknownColumn { at, found, hint }.into())
    }

    /// The place of a column in each line, where it exists.
    pub(crate) fn find(&self, name: &str) -> Option<usize> {
        self.header.iter().position(|header| header == name)
    }

    /// The place of a column in each line.
    pub(crate) fn need(&self, name: &'static str, all: &'static str) -> Result<usize, Error> {
        let missing = || TableError::MissingColumn {
            at: self.header_place(),
            missing: name,
            found: shortened_list(&self.header),
            hint: format!("the header must have {all}"),
        };
        Ok(self.find(name).ok_or_else(missing)?)
    }

    /// Calls `each` with every line that is not blank, and gives what it made.
    pub(crate) fn rows<T>(
        &self,
        what: &'static str,
        mut each: impl FnMut(&Row<'_>) -> Result<T, Error>,
    ) -> Result<Vec<T>, Error> {
        let mut reader = self.reader();
        let mut record = ByteRecord::new();
        let (mut counted, mut line) = (0, 1u64);
        let mut out = Vec::new();
        let mut header = true;
        // Reading bytes from memory with any number of cells a line cannot fail.
        while let Ok(true) = reader.read_byte_record(&mut record) {
            if std::mem::take(&mut header) {
                continue;
            }
            let mut start = record.position().map_or(0, |p| p.byte() as usize);
            while matches!(self.text.get(start), Some(b'\n' | b'\r')) {
                start += 1;
            }
            line += memchr::memchr_iter(b'\n', &self.text[counted..start]).count() as u64;
            counted = start;
            if record.iter().all(|cell| cell.trim_ascii().is_empty()) {
                continue;
            }
            let row = Row {
                table: self,
                record: &record,
                start,
                line,
            };
            row.check_length()?;
            if out.len() == TABLE_LINES {
                return Err(self.too_long(TABLE_LINES + 1, "lines or more", TABLE_LINES));
            }
            out.push(each(&row)?);
        }
        if out.is_empty() {
            return Err(self.empty(what));
        }
        Ok(out)
    }
}

impl Row<'_> {
    fn check_length(&self) -> Result<(), Error> {
        let (found, expected) = (self.record.len(), self.table.header.len());
        let spare = self.record.iter().skip(expected);
        if found >= expected && spare.into_iter().all(|cell| cell.trim_ascii().is_empty()) {
            return Ok(());
        }
        Err(TableError::Shape {
            at: self.place(0),
            found: found as u64,
            expected: expected as u64,
        }
        .into())
    }

    /// Where a cell begins.
    pub(crate) fn place(&self, cell: usize) -> Place {
        let mut quoted = false;
        let mut cells = 0;
        let (mut line, mut column) = (self.line, 1);
        for byte in &self.table.text[self.start..] {
            if cells == cell {
                break;
            }
            column += 1;
            match byte {
                b'"' => quoted = !quoted,
                b',' if !quoted => cells += 1,
                b'\n' => (line, column) = (line + 1, 1),
                _ => {}
            }
        }
        let file = self.table.file.clone();
        Place { file, line, column }
    }

    /// A cell's text, without the space around it.
    pub(crate) fn text(&self, cell: usize) -> Result<&str, Error> {
        let bytes = self.record.get(cell).unwrap_or_default();
        let text = std::str::from_utf8(bytes).map_err(|_| TableError::NotText {
            at: self.place(cell),
            cell: cell + 1,
        })?;
        Ok(text.trim())
    }

    /// A cell's text, where its column exists and it is not empty.
    pub(crate) fn optional(&self, cell: Option<usize>) -> Result<Option<&str>, Error> {
        let text = cell.map(|cell| self.text(cell)).transpose()?;
        Ok(text.filter(|text| !text.is_empty()))
    }

    /// The error that a cell is not `expected`.
    pub(crate) fn wrong(
        &self,
        cell: usize,
        column: &'static str,
        expected: &'static str,
        hint: &'static str,
    ) -> Error {
        let bytes = self.record.get(cell).unwrap_or_default();
        let found = shortened(bytes.trim_ascii());
        TableError::Cell {
            at: self.place(cell),
            column,
            found,
            expected,
            hint,
        }
        .into()
    }

    /// A whole number, 0 and up.
    pub(crate) fn index(&self, cell: usize, column: &'static str) -> Result<usize, Error> {
        self.text(cell)?
            .parse()
            .map_err(|_| self.wrong(cell, column, "a whole number", "it counts from 0"))
    }

    /// A finite number.
    pub(crate) fn number(&self, cell: usize, column: &'static str) -> Result<f64, Error> {
        let value = fast_float2::parse::<f64, _>(self.text(cell)?.as_bytes());
        value.ok().filter(|value| value.is_finite()).ok_or_else(|| {
            let hint = "a decimal point, no unit: the unit is in the column's name";
            self.wrong(cell, column, "a finite number", hint)
        })
    }

    /// A finite number, 0 and up.
    pub(crate) fn amount(&self, cell: usize, column: &'static str) -> Result<f64, Error> {
        let value = self.number(cell, column)?;
        if value < 0.0 {
            return Err(Error::Negative {
                at: self.place(cell),
                what: column,
                found: value,
                hint: "subtract no tare from a labelled load",
            });
        }
        Ok(value)
    }
}

fn name_of(cell: &[u8]) -> String {
    String::from_utf8_lossy(cell).trim().to_ascii_lowercase()
}

fn shortened_list(names: &[String]) -> String {
    shortened(names.join(",").as_bytes())
}

/// The known name that is most like `name`, if any is like it.
pub(crate) fn nearest(
    name: &str,
    known: impl Iterator<Item = &'static str>,
) -> Option<&'static str> {
    known
        .map(|candidate| (strsim::jaro_winkler(name, candidate), candidate))
        .filter(|(likeness, _)| *likeness > 0.8)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, candidate)| candidate)
}
