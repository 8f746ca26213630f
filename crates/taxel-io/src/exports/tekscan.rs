//! Tekscan ASCII: `KEY value` lines, `ASCII_DATA @@`, frames of comma-separated rows with an empty line between them, `@@`.
//!
//! Raw counts come back exactly from calibrated values: one point, P per count = force / (raw sum · sensel area); two points,
//! P = SCALE_FACTOR · raw ^ EXPONENT.

use std::path::Path;

use super::cells::{Separator, number_and_rest, number_of};
use super::header::Pairs;
use super::pad::{Pad, Quantity, RawScale};
use super::row::Rows;
use super::text_file::TextFile;
use super::units::{millimetres, quantity, square_millimetres, unit_of};
use super::{Beginning, ExportAbout, ParsedFrame, Parser};
use crate::error::{Error, ExportError};

const FORMAT: &str = "Tekscan ASCII";
/// The line behind the header.
const DATA: &str = "ASCII_DATA @@";
/// The largest raw count: eight bits.
const MAX_COUNT: f64 = 255.0;
/// Two scales that differ by less are one, rounded.
const SAME_SCALE: f64 = 0.02;
/// Lines of a header at most: one of a file that is none does not end.
const MAX_HEADER: u64 = 1000;
/// Keys of a header whose values have a unit.
const CALIBRATED: [&str; 4] = [
    "calibration_point_1",
    "saturation_pressure",
    "scale_factor",
    "exponent",
];
/// What spreadsheets close their lines with, by the computer's language.
const PADDING: [char; 3] = [',', ';', '\t'];

pub(super) fn is_it(beginning: &Beginning) -> bool {
    beginning
        .lines(MAX_HEADER as usize)
        .any(|line| line.trim_end_matches(PADDING).trim_end() == DATA)
}

pub(super) fn open(file: &Path) -> Result<(ExportAbout, Box<dyn Parser>), Error> {
    let mut text = TextFile::open(file)?;
    let (pairs, header) = read_header(&mut text)?;
    let First {
        rows,
        columns,
        absent,
        separator,
    } = first_frame(&mut text, &pairs)?;
    let (unit, known) = match pairs.get("units") {
        // A recording that was never calibrated.
        None if !CALIBRATED.iter().any(|key| pairs.get(key).is_some()) => {
            ("raw".to_owned(), Quantity::Raw)
        }
        _ => unit_of(&text, FORMAT, &pairs, "units")?,
    };
    let mut pad = Pad::new(rows, columns, &unit, known);
    pad.absent = if absent.contains(&true) {
        absent
    } else {
        Vec::new()
    };
    let spacing = |key| pairs.get(key).and_then(|text| millimetres(text, None));
    pad.pitch_mm = spacing("row_spacing")
        .zip(spacing("col_spacing"))
        .map(<[f64; 2]>::from);
    let area = pairs.get("sensel_area").and_then(square_millimetres);
    pad.area_mm2 = area.or(pad.pitch_mm.map(|[row, column]| row * column));
    pad.raw = raw_scale(&pairs, &pad);
    pad.saturation = saturation(&pairs, &pad);
    let is_raw = known == Quantity::Raw;
    // In raw counts, whatever the unit of the values.
    let threshold = pairs.positive("noise_threshold");
    pad.threshold = threshold.filter(|_| is_raw || pad.raw.is_some());
    let program = pairs.get("version").unwrap_or("Tekscan").to_owned();
    let mut about = ExportAbout::new(FORMAT, &program, vec![pad]);
    about.header = header;
    about.secs_per_frame = pairs.positive("seconds_per_frame");
    let told = pairs.count("start_frame").zip(pairs.count("end_frame"));
    about.frames = told
        .and_then(|(first, last)| last.checked_sub(first))
        .map(|more| more as u64 + 1);
    let mut text = TextFile::open(file)?;
    read_header(&mut text)?;
    let reader = Tekscan {
        text,
        rows,
        columns,
        absent: about.pads[0].absent.clone(),
        is_raw,
        lines: Rows::new(FORMAT, Separator::One(separator)),
        has_ended: false,
        frames: 0,
        told: about.frames,
    };
    Ok((about, Box::new(reader)))
}

fn read_header(text: &mut TextFile) -> Result<(Pairs, String), Error> {
    let mut pairs = Pairs::default();
    let mut lines = Vec::new();
    let mut is_comment = false;
    while text.advance()? && text.place(0).line <= MAX_HEADER {
        let words = text.words();
        let line = words.trim_end_matches(PADDING).trim();
        if line == DATA {
            return Ok((pairs, lines.join("\n")));
        }
        // The comment itself stands on the lines behind, in any words.
        let is_key = line.split(' ').next().is_some_and(is_key);
        is_comment = line.starts_with("COMMENTS:") || is_comment && !is_key;
        if !is_comment {
            pairs.add(line, &[' ', ':'], text.place(0).line);
        }
        lines.push(line.to_owned());
    }
    let hint = "the header of such an export ends with it";
    Err(text.wrong(FORMAT, format!("`{DATA}`"), hint))
}

/// Whether a word is one of a header's keys.
fn is_key(word: &str) -> bool {
    let is_part = |c: char| c.is_ascii_uppercase() || c.is_ascii_digit() || c == '_';
    word.len() > 3 && word.chars().all(is_part)
}

/// What the first frame tells.
struct First {
    rows: usize,
    columns: usize,
    absent: Vec<bool>,
    separator: u8,
}

/// Shape and mask of the first frame that is as the header says; where the header says both sides, one that is torn is passed over
/// here and told when it is read.
fn first_frame(text: &mut TextFile, pairs: &Pairs) -> Result<First, Error> {
    let hint = "there is nothing behind the header";
    if !find_frame(text)? {
        return Err(text.wrong(FORMAT, "a line `Frame 1`", hint));
    }
    let first = frame_shape(text, pairs);
    let is_told = pairs.count("rows").is_some() && pairs.count("cols").is_some();
    match first {
        Err(torn) if is_told => {
            let mut next = || {
                skip_to_frame(text)?;
                text.advance()?;
                frame_shape(text, pairs)
            };
            next().map_err(|_| torn)
        }
        first => first,
    }
}

fn frame_shape(text: &mut TextFile, pairs: &Pairs) -> Result<First, Error> {
    let mut absent = Vec::new();
    let mut separator = b',';
    let (mut rows, mut columns) = (0, pairs.count("cols").unwrap_or(0));
    while rows < pairs.count("rows").unwrap_or(usize::MAX)
        && text.advance()?
        && !is_between(text.line())
    {
        let line = text.words();
        if rows == 0
            && let Separator::One(found) = Separator::of(text.line())
        {
            separator = found;
        }
        let cells: Vec<&str> = line
            .trim_end_matches(PADDING)
            .split(char::from(separator))
            .map(str::trim)
            .collect();
        if columns == 0 {
            columns = cells.len();
        }
        if cells.len() < columns {
            let hint = "the header's COLS is another, or a line is torn";
            let found = format!("{} values", cells.len());
            return Err(text.wrong_at(0, FORMAT, found, format!("{columns} of them"), hint));
        }
        absent.extend(cells.iter().take(columns).map(|cell| *cell == "B"));
        rows += 1;
    }
    match pairs.count("rows") {
        Some(told) if told != rows => {
            let hint = "the header says so (ROWS); the file is cut, or its header is of another";
            let found = format!("{rows} rows in the first frame");
            Err(text.wrong_at(0, FORMAT, found, format!("{told} of them"), hint))
        }
        _ if rows * columns == 0 => {
            Err(text.wrong(FORMAT, "rows of a frame", "the first frame is empty"))
        }
        _ => Ok(First {
            rows,
            columns,
            absent,
            separator,
        }),
    }
}

/// Whether a line begins a frame; a spreadsheet puts it between quotes.
fn begins_frame(line: &[u8]) -> bool {
    line.starts_with(b"Frame") || line.starts_with(b"\"Frame")
}

/// Whether a line stands between frames.
fn is_between(line: &[u8]) -> bool {
    let is_padding = |byte: &u8| matches!(byte, b',' | b';' | b' ' | b'\t');
    let is_empty = line.iter().all(is_padding);
    is_empty || begins_frame(line) || line.starts_with(b"@@")
}

/// Goes to the line that begins the next frame; false at the end.
fn find_frame(text: &mut TextFile) -> Result<bool, Error> {
    while text.advance()? {
        let line = text.line();
        if begins_frame(line) {
            return Ok(true);
        }
        if !is_between(line) {
            return Err(text.wrong(
                FORMAT,
                "a line `Frame n` or the end, `@@`",
                "a frame has more lines than the header says",
            ));
        }
    }
    Ok(false)
}

/// Goes on before the line that begins the next frame, or at the end.
fn skip_to_frame(text: &mut TextFile) -> Result<(), Error> {
    while text.advance()? {
        if begins_frame(text.line()) {
            text.unread();
            break;
        }
    }
    Ok(())
}

/// How raw counts became pressures, as the header says it.
fn raw_scale(pairs: &Pairs, pad: &Pad) -> Option<RawScale> {
    let scaled = |factor: f64, exponent: f64| {
        Some(RawScale {
            factor,
            exponent,
            max_count: MAX_COUNT,
        })
    };
    let Quantity::Pressure(pascals) = pad.quantity else {
        return None;
    };
    // By the largest value, which has the unit with it: of both ways.
    let top = pairs.get("saturation_pressure").and_then(number_and_rest);
    let top = top.and_then(|(value, unit)| match quantity(unit) {
        Some(Quantity::Pressure(own)) => Some(value * own / pascals),
        _ => None,
    });
    if let Some(exponent) = pairs.positive("exponent") {
        // In the unit of the calibration, which the largest value tells.
        let factor = top.map(|top| top / MAX_COUNT.powf(exponent));
        return scaled(factor.or(pairs.positive("scale_factor"))?, exponent);
    }
    let by_point = || {
        let point = pairs.get("calibration_point_1")?;
        let (force, rest) = number_and_rest(point)?;
        let (unit, rest) = rest.strip_prefix('(')?.split_once(')')?;
        let (raw_sum, _) = number_and_rest(rest)?;
        let Some(Quantity::Force(newtons)) = quantity(unit) else {
            return None;
        };
        let square_metres = pad.area_mm2? * 1e-6;
        Some(force * newtons / (raw_sum * square_metres * pascals)).filter(|factor| *factor > 0.0)
    };
    let by_top = top.map(|top| top / MAX_COUNT);
    // The point is the measurement; where both are told and are not one scale, it is of another calibration than the values.
    let point =
        by_point().filter(|point| by_top.is_none_or(|top| (point / top - 1.0).abs() < SAME_SCALE));
    scaled(point.or(by_top)?, 1.0)
}

/// Where values say only that there was more, in the file's unit.
fn saturation(pairs: &Pairs, pad: &Pad) -> Option<f64> {
    match (pad.quantity, pad.raw) {
        (Quantity::Raw, _) => Some(MAX_COUNT),
        (_, Some(raw)) => {
            // As values are written: rounded.
            let top = raw.factor * MAX_COUNT.powf(raw.exponent);
            let below = raw.factor * (MAX_COUNT - 1.0).powf(raw.exponent);
            Some(0.5 * (top + below))
        }
        _ => pairs.positive("saturation_pressure"),
    }
}

struct Tekscan {
    text: TextFile,
    rows: usize,
    columns: usize,
    absent: Vec<bool>,
    is_raw: bool,
    /// How a row is written.
    lines: Rows,
    /// Whether the line that closes the file was met.
    has_ended: bool,
    /// Frames that were met, and how many the header says.
    frames: u64,
    told: Option<u64>,
}

impl Tekscan {
    /// Its number, its seconds and its sum, of the line that begins a frame.
    fn begin(&self, frame: &mut ParsedFrame) -> Result<Option<f64>, Error> {
        let words = self.text.words();
        let separator = match self.lines.separator {
            Separator::One(separator) => char::from(separator),
            Separator::Blanks => ',',
        };
        let cells: Vec<&str> = words
            .split(separator)
            .map(|cell| cell.trim().trim_matches('"'))
            .collect();
        let number = cells[0].trim_start_matches("Frame").trim();
        frame.number = Some(number.parse().map_err(|_| {
            self.text
                .wrong(FORMAT, "a line `Frame n`", "its number is broken")
        })?);
        let second = cells.get(1).copied().unwrap_or("");
        let third = cells.get(2).copied().unwrap_or("");
        let is_whole = |cell: &str| !cell.is_empty() && cell.bytes().all(|b| b.is_ascii_digit());
        frame.secs = match second.strip_prefix("timestamp") {
            Some(milliseconds) => number_of(milliseconds.trim()).map(|ms| 1e-3 * ms),
            // Decimals behind a comma, which parts the cells of this line as well.
            None if is_whole(second) && is_whole(third) => number_of(&format!("{second}.{third}")),
            None => number_of(second),
        };
        let sum = cells.iter().position(|cell| cell.starts_with("Raw Sum"));
        let behind = sum.map_or(&[][..], |sum| &cells[sum + 1..]);
        Ok(behind.iter().find_map(|cell| number_of(cell)))
    }

    /// No cell that the first frame has as none may hold a value.
    fn check_absent(&self, row: &[f64], absent: &[bool]) -> Result<(), Error> {
        let is_told = |(value, absent): (&f64, &bool)| *absent && *value > 0.0;
        let Some(at) = row.iter().zip(absent).position(is_told) else {
            return Ok(());
        };
        Err(self.text.wrong_at(
            0,
            FORMAT,
            format!("value {} of {} is {}", at + 1, row.len(), row[at]),
            "`B` or 0, since the first frame has `B` there",
            "the frame is of another sensor or another mask; --keep-going leaves it out",
        ))
    }

    fn check_sum(&self, frame: &ParsedFrame, told: Option<f64>) -> Result<(), Error> {
        let Some(expected) = told.filter(|_| self.is_raw) else {
            return Ok(());
        };
        let found: f64 = frame.values.iter().sum();
        if found == expected {
            return Ok(());
        }
        Err(Error::Export(Box::new(ExportError::Sum {
            format: FORMAT,
            at: self.text.place(0),
            found,
            expected,
            unit: "raw counts",
        })))
    }
}

impl Parser for Tekscan {
    fn next(&mut self, frame: &mut ParsedFrame) -> Result<bool, Error> {
        loop {
            if !self.text.advance()? {
                return Ok(false);
            }
            let line = self.text.line();
            self.has_ended |= line.starts_with(b"@@");
            if begins_frame(line) {
                break;
            }
            if !is_between(line) {
                return Err(self.text.wrong(
                    FORMAT,
                    "a line `Frame n` or the end, `@@`",
                    "a frame has more lines than the header says",
                ));
            }
        }
        let columns = self.columns;
        frame.begin(0, self.rows * columns);
        self.frames += 1;
        let told = self.begin(frame)?;
        for row in 0..self.rows {
            let is_there = self.text.advance()?;
            if !is_there || is_between(self.text.line()) {
                // What begins the next frame is no line of this one.
                if is_there {
                    self.text.unread();
                }
                let expected = format!("{} of them", self.rows);
                return Err(self.text.cut(FORMAT, format!("{row} rows"), expected));
            }
            let absent = self.absent.get(row * columns..(row + 1) * columns);
            let is_absent = |place: usize, word: &[u8]| {
                word.trim_ascii() == b"B" && absent.is_some_and(|absent| absent[place])
            };
            let out = &mut frame.values[row * columns..(row + 1) * columns];
            let lines = self.lines;
            lines.read_with(&self.text, out, &mut frame.decimals, is_absent)?;
            if let Some(absent) = absent {
                self.check_absent(out, absent)?;
            }
        }
        self.check_sum(frame, told)?;
        Ok(true)
    }

    fn skip_frame(&mut self) -> Result<(), Error> {
        skip_to_frame(&mut self.text)
    }

    fn text(&self) -> &TextFile {
        &self.text
    }

    fn is_cut(&self) -> bool {
        // Some programs leave the closing line out.
        !self.has_ended && (self.told != Some(self.frames) || !self.text.is_closed())
    }
}
