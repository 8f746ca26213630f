//! novel emed `.lst`: a page for each picture, cropped to the rows and columns that were stepped on, which are put back by their
//! numbers; sums of rows and columns beside them.

use std::path::Path;

use super::cells::{Cell, Separator, each_cell, next_cell, number_and_rest};
use super::pad::{Pad, Quantity};
use super::text_file::TextFile;
use super::units::{millimetres, square_millimetres};
use super::zeros::sum_in_order;
use super::{Beginning, ExportAbout, ParsedFrame, Parser};
use crate::error::{Error, ExportError};

const FORMAT: &str = "novel emed";
/// What the line that begins a picture has.
const PICTURE: &str = "Pict-No.:";
const KILOPASCALS: f64 = 1e3;
/// Forces of rows are rounded to so much, newtons.
const ROUNDED_TO: f64 = 0.01;
/// How far a sum may be off what was rounded, in its last digit: half of it, and what sums of halves lose.
const ROUNDING: f64 = 0.51;

pub(super) fn is_it(beginning: &Beginning) -> bool {
    let mut has = [false; 2];
    for line in beginning.lines(200) {
        has[0] |= line.contains("Sensor area:");
        // Summaries may stand before the first picture, pages of them.
        has[1] |= line.contains(PICTURE) || line.contains("Matrix:");
    }
    has == [true; 2]
}

pub(super) fn open(file: &Path) -> Result<(ExportAbout, Box<dyn Parser>), Error> {
    let mut text = TextFile::open(file)?;
    let mut lines = Vec::new();
    let (mut shape, mut area, mut pitch, mut step) = (None, None, None, None);
    let mut shape_line = 0;
    while text.advance()? {
        let words = text.words();
        if words.contains(PICTURE) {
            break;
        }
        let said = |key: &str| words.split_once(key).map(|(_, said)| said.trim_start());
        let first = |said: &str| said.split('\t').next().unwrap_or("").trim().to_owned();
        if shape.is_none() {
            shape = said("Matrix:").and_then(matrix);
            shape_line = text.number();
        }
        area = area.or(said("Sensor area:").and_then(|said| square_millimetres(&first(said))));
        pitch = pitch.or(said("Sensor size:").and_then(|said| sides(&first(said))));
        step = step.or(said("Time/picture:").and_then(milliseconds));
        let line = words.trim_matches(|c: char| c.is_whitespace() || c == '\x0c');
        let is_table = line.starts_with(|c: char| c.is_ascii_digit()) || line.starts_with("Force");
        if !line.is_empty() && !is_table && !lines.iter().any(|own| own == line) {
            lines.push(line.to_owned());
        }
    }
    let hint = "`Matrix: 64x95` says how many columns and rows the plate has";
    let (columns, rows) = shape.ok_or_else(|| text.wrong(FORMAT, "a line with `Matrix:`", hint))?;
    let at = (FORMAT, text.line_at(shape_line));
    let mut pad = Pad::new(at, (rows, columns), "kPa", Quantity::Pressure(KILOPASCALS))?;
    pad.pitch_mm = pitch;
    pad.area_mm2 = area.or(pitch.map(|[down, across]| down * across));
    let newtons_per_unit = pad.newtons_per_unit();
    let mut about = ExportAbout::new(FORMAT, "novel emed", vec![pad]);
    about.header = lines.join("\n");
    about.secs_per_frame = step.map(|ms| 1e-3 * ms);
    let reader = Emed {
        text: TextFile::open(file)?,
        rows,
        columns,
        newtons_per_unit,
        numbers: Vec::new(),
        together: None,
        row: Vec::new(),
    };
    Ok((about, Box::new(reader)))
}

/// Whether a line has such words.
fn has(line: &[u8], words: &str) -> bool {
    memchr::memmem::find(line, words.as_bytes()).is_some()
}

fn ends_in_force(line: &str) -> bool {
    line.trim_end().ends_with("\tForce")
}

/// `10.0 ms`.
fn milliseconds(said: &str) -> Option<f64> {
    let (ms, unit) = number_and_rest(said)?;
    (ms > 0.0 && unit == "ms").then_some(ms)
}

/// `64x95`.
fn matrix(said: &str) -> Option<(usize, usize)> {
    let (columns, rest) = said.split_once('x')?;
    let rows = rest.split(|c: char| !c.is_ascii_digit()).next()?;
    let pair = (columns.trim().parse().ok()?, rows.parse().ok()?);
    (pair.0 > 0 && pair.1 > 0).then_some(pair)
}

/// `0.500x0.500 cm`, mm down and across.
fn sides(said: &str) -> Option<[f64; 2]> {
    let (across, down) = said.split_once('x')?;
    let unit = down.split_whitespace().last()?;
    let down_mm = millimetres(down, None)?;
    Some([down_mm, millimetres(&format!("{across} {unit}"), None)?])
}

struct Emed {
    text: TextFile,
    rows: usize,
    columns: usize,
    newtons_per_unit: Option<f64>,
    /// The columns of the page, from 0.
    numbers: Vec<usize>,
    /// The first of them, where they follow each other.
    together: Option<usize>,
    /// The numbers of a row.
    row: Vec<f64>,
}

impl Emed {
    /// The number of the picture that the line read last begins.
    fn picture(&self) -> Option<u64> {
        if !has(self.text.line(), PICTURE) {
            return None;
        }
        let words = self.text.words();
        let (_, said) = words.split_once(PICTURE)?;
        number_and_rest(said).map(|(number, _)| number as u64)
    }

    /// Goes to the line that begins a picture: its number; `None` at the end. A page of one that has lost this line is told.
    fn find_picture(&mut self) -> Result<Option<u64>, Error> {
        let (mut is_page, mut is_summary) = (false, false);
        while self.text.advance()? {
            if let Some(number) = self.picture() {
                return Ok(Some(number));
            }
            let line = self.text.line();
            is_page |= has(line, "MV over frames");
            is_summary |= has(line, "MVP") || has(line, "MPP");
            let is_table = matches!(line, [b'0'..=b'9' | b'\t', ..]);
            if is_page && !is_summary && is_table && ends_in_force(&self.text.words()) {
                let expected = format!("a line with `{PICTURE}`");
                let hint = "it stands above each picture, and was torn or lost";
                return Err(self.text.wrong(FORMAT, expected, hint));
            }
        }
        Ok(None)
    }

    /// The line of column numbers.
    fn read_columns(&mut self) -> Result<(), Error> {
        while self.text.advance()? {
            let words = self.text.words();
            if words.trim().is_empty() {
                continue;
            }
            let cells = words.split_whitespace().filter(|cell| *cell != "Force");
            let numbers: Option<Vec<usize>> = cells
                .map(|cell| self.place_of(cell, self.columns))
                .collect();
            if let Some(numbers) = numbers.filter(|numbers| !numbers.is_empty()) {
                let follow = numbers.windows(2).all(|pair| pair[0] + 1 == pair[1]);
                self.together = follow.then(|| numbers[0]);
                self.numbers = numbers;
                return Ok(());
            }
            break;
        }
        let hint = "the numbers of the columns stand above a picture";
        let expected = format!("column numbers from 1 to {}", self.columns);
        Err(self.text.wrong(FORMAT, expected, hint))
    }

    /// The place from 0 of a line that is numbered from 1.
    fn place_of(&self, cell: &str, lines: usize) -> Option<usize> {
        let number: usize = cell.parse().ok()?;
        (1..=lines).contains(&number).then(|| number - 1)
    }

    /// The rows of a page, into the frame; the force in all that stands below.
    fn read_rows(&mut self, frame: &mut ParsedFrame) -> Result<Option<f64>, Error> {
        loop {
            if !self.text.advance()? {
                return Err(self.cut());
            }
            let line = self.text.line().trim_ascii_end();
            let Some(tab) = memchr::memchr(b'\t', line) else {
                return Err(self.cut());
            };
            let name = line[..tab].trim_ascii();
            let cells = &line[tab + 1..];
            if name == b"Force" {
                return Ok(last_number(cells));
            }
            let row = std::str::from_utf8(name)
                .ok()
                .and_then(|name| self.place_of(name, self.rows));
            let Some(row) = row else {
                let expected = format!("a row number from 1 to {}, or `Force`", self.rows);
                return Err(self.text.wrong(FORMAT, expected, "a line was torn"));
            };
            self.read_row(frame, row, tab + 1)?;
        }
    }

    /// A row of as many plain numbers as there are columns, and its force behind them; `None` of another, whatever stands in it.
    fn plain_row(&mut self, frame: &mut ParsedFrame, row: usize, from: usize) -> Option<[f64; 2]> {
        let separator = Separator::One(b'\t');
        let columns = self.numbers.len();
        let places = &mut frame.values[row * self.columns..][..self.columns];
        self.row.resize(columns, 0.0);
        let out = match self.together {
            // Whatever else stands in the line is read once more, or is an error.
            Some(first) => &mut places[first..first + columns],
            None => &mut self.row[..],
        };
        let plain = self.text.plain(separator);
        let (read, next) = plain.read(from, out, &mut frame.decimals, |_, _| false);
        let Some((Cell::Number(told, _), ..)) = next_cell(self.text.line(), next, separator) else {
            return None;
        };
        if read < columns {
            return None;
        }
        let sum = sum_in_order(out);
        if self.together.is_none() {
            for (&column, &value) in self.numbers.iter().zip(&self.row) {
                places[column] = value;
            }
        }
        Some([sum, told])
    }

    fn read_row(&mut self, frame: &mut ParsedFrame, row: usize, from: usize) -> Result<(), Error> {
        if let Some([sum, told]) = self.plain_row(frame, row, from) {
            return self.check_row(frame, row, sum, Some(told));
        }
        let cells = &self.text.line()[from..];
        let (mut found, mut sum, mut told) = (0, 0.0, None);
        let mut fault = None;
        each_cell(cells, Separator::One(b'\t'), |at, cell, place| {
            // The last one is the row's force.
            let Some(&column) = self.numbers.get(at) else {
                if let Cell::Number(force, _) = cell {
                    told = Some(force);
                }
                return false;
            };
            match cell {
                Cell::Number(_, 1..) if !self.text.has_one_point(&cells[place.0..place.1]) => {
                    fault = Some((at, place));
                }
                Cell::Number(value, own) if value >= 0.0 => {
                    frame.values[row * self.columns + column] = value;
                    frame.decimals = frame.decimals.max(own);
                    found += 1;
                    sum += value;
                }
                _ => fault = Some((at, place)),
            }
            fault.is_none()
        });
        if let Some((at, (begin, to))) = fault {
            self.text.check_point(FORMAT, (from + begin, from + to))?;
            let found = format!(
                "value {} is `{}`",
                at + 1,
                crate::grid::shortened(&cells[begin..to])
            );
            let hint = "a reading that is missing or broken; --keep-going leaves its frame out";
            return Err(self.text.wrong_at(
                from + begin,
                FORMAT,
                found,
                "a number of 0 or more",
                hint,
            ));
        }
        if found == self.numbers.len() {
            return self.check_row(frame, row, sum, told);
        }
        let expected = format!("{} of them", self.numbers.len());
        let hint = "one for each column of the page; a line was torn";
        Err(self
            .text
            .wrong_at(0, FORMAT, format!("{found} values"), expected, hint))
    }

    /// A row's cells, those of the page or of all pages of the picture, add up to the force that stands behind them, but for its
    /// rounding.
    fn check_row(
        &self,
        frame: &ParsedFrame,
        row: usize,
        sum: f64,
        told: Option<f64>,
    ) -> Result<(), Error> {
        let Some((expected, per_unit)) = told.zip(self.newtons_per_unit) else {
            return Ok(());
        };
        let fits = |sum: f64| (per_unit * sum - expected).abs() <= ROUNDING * ROUNDED_TO;
        let all = || sum_in_order(&frame.values[row * self.columns..][..self.columns]);
        if fits(sum) || fits(all()) {
            return Ok(());
        }
        let found = per_unit * sum;
        let found = format!("the cells of row {} add up to {found:.3} N", row + 1);
        let expected = format!("the row's own force, {expected} N");
        let hint = "a number of it was changed or lost; --keep-going leaves the picture out";
        Err(self.text.wrong_at(0, FORMAT, found, expected, hint))
    }

    fn cut(&self) -> Error {
        let expected = "a line `Force` below the rows";
        self.text
            .cut(FORMAT, "a page without its last line", expected)
    }

    fn check_sum(&self, frame: &ParsedFrame, told: Option<f64>) -> Result<(), Error> {
        let Some((expected, per_unit)) = told.zip(self.newtons_per_unit) else {
            return Ok(());
        };
        let found = per_unit * sum_in_order(&frame.values);
        if (found - expected).abs() <= ROUNDED_TO * (1.0 + 0.5 * self.rows as f64) {
            return Ok(());
        }
        Err(Error::Export(Box::new(ExportError::Sum {
            format: FORMAT,
            at: self.text.place(0),
            found: (100.0 * found).round() / 100.0,
            expected,
            unit: "N",
        })))
    }
}

fn last_number(cells: &[u8]) -> Option<f64> {
    let mut last = None;
    each_cell(cells, Separator::One(b'\t'), |_, cell, _| {
        if let Cell::Number(value, _) = cell {
            last = Some(value);
        }
        true
    });
    last
}

impl Parser for Emed {
    fn next(&mut self, frame: &mut ParsedFrame) -> Result<bool, Error> {
        let mut picture = None;
        let mut told: Option<f64> = None;
        // A picture that is too wide for a page goes on on the next one.
        loop {
            let number = self.find_picture()?;
            match (picture, number) {
                (None, None) => return Ok(false),
                (Some(own), Some(number)) if number != own => {
                    self.text.unread();
                    break;
                }
                (Some(_), None) => break,
                (None, Some(number)) => {
                    frame.begin(0, self.rows * self.columns);
                    frame.number = Some(number);
                    picture = Some(number);
                }
                (Some(_), Some(_)) => {}
            }
            self.read_columns()?;
            let force = self.read_rows(frame)?;
            told = Some(told.unwrap_or(0.0) + force.unwrap_or(f64::NAN));
        }
        let told = told.filter(|force| force.is_finite());
        self.check_sum(frame, told)?;
        frame.reference_newtons = told;
        Ok(true)
    }

    fn skip_frame(&mut self) -> Result<(), Error> {
        while self.text.advance()? {
            if self.picture().is_some() {
                self.text.unread();
                break;
            }
        }
        Ok(())
    }

    fn text(&self) -> &TextFile {
        &self.text
    }
}
