//! Tekscan ASCII: `KEY value` lines, `ASCII_DATA @@`, frames of comma-separated rows with an empty line between them, `@@`.
//!
//! Raw counts come back exactly from calibrated values: one point, P per count = force / (raw sum · sensel area); two points,
//! P = SCALE_FACTOR · raw ^ EXPONENT.

mod first;
mod header;
pub(super) mod keys;
mod scale;

use std::ops::Range;
use std::path::Path;

use super::cells::{Separator, number_and_decimals, number_of, power_of_ten};
use super::header::Pairs;
use super::pad::{Pad, Quantity};
use super::row::Rows;
use super::text_file::TextFile;
use super::units::{millimetres, other_unit, quantity, square_millimetres, unit_of};
use super::{Beginning, ExportAbout, ParsedFrame, Parser};
use crate::error::{Error, ExportError};
use first::{First, first_frame};
use header::{MAX_HEADER, is_data, read_header};
use keys::is_known;
use scale::{MAX_COUNT, raw_scale, saturation};

const FORMAT: &str = "Tekscan ASCII";
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
    beginning.lines(MAX_HEADER as usize).any(is_data)
}

pub(super) fn open(file: &Path) -> Result<(ExportAbout, Box<dyn Parser>), Error> {
    let mut text = TextFile::open(file)?.without_quotes();
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
            check_strangers(&text, &pairs)?;
            ("raw".to_owned(), Quantity::Raw)
        }
        _ => unit_of(&text, FORMAT, &pairs, "units")?,
    };
    let at = text.line_at(pairs.line_of("rows"));
    let mut pad = Pad::new((FORMAT, at), (rows, columns), &unit, known)?;
    if absent.contains(&true) {
        pad.absent = absent;
    }
    set_sides(&text, &pairs, &mut pad)?;
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
    let mut text = TextFile::open(file)?.without_quotes();
    read_header(&mut text)?;
    let reader = Tekscan {
        text,
        rows,
        columns,
        absent: about.pads[0].absent.clone(),
        absent_bits: about.pads[0].absent.iter().map(|&is| bits(is)).collect(),
        is_raw,
        has_unit: pairs.get("units").is_some(),
        has_rows: pairs.count("rows").is_some(),
        lines: Rows::new(FORMAT, separator),
        has_ended: false,
        frames: 0,
        told: about.frames,
    };
    Ok((about, Box::new(reader)))
}

/// Without a unit numbers are raw counts, unless keys that nobody here knows may tell it: one with a unit behind it, or most of them.
fn check_strangers(text: &TextFile, pairs: &Pairs) -> Result<(), Error> {
    let strangers = || {
        pairs
            .all()
            .filter(|(key, ..)| !key.is_empty() && !is_known(key))
    };
    let is_unit = |value: &str| matches!(quantity(value), Some(other) if other != Quantity::Raw);
    let (all, unknown) = (pairs.all().count(), strangers().count());
    let told = strangers().find(|(_, value, _)| is_unit(value));
    let (found, line) = match (told, strangers().next()) {
        (Some((.., line)), _) => ("a unit behind a key that is none of Tekscan's", line),
        (None, Some((.., line))) if 2 * unknown > all => (
            "no unit in the header, of whose keys most are not Tekscan's,",
            line,
        ),
        _ => return Ok(()),
    };
    Err(text.wrong_on(
        line,
        FORMAT,
        found,
        "a line as `UNITS KPa`, or `UNITS raw` of raw counts",
        "nothing is guessed: export it in English, or write that line into the header",
    ))
}

/// Pitch and area of the sensels. A length or an area that the header tells in a unit that nobody here knows is none.
fn set_sides(text: &TextFile, pairs: &Pairs, pad: &mut Pad) -> Result<(), Error> {
    let spacing = |key| {
        let Some(said) = pairs.get(key) else {
            return Ok(None);
        };
        let expected = "a length above 0 with its unit, as `5.08 mm`, `0.127 cm` or `0.025 inches`";
        let unknown = || other_unit(text, FORMAT, pairs.line_of(key), said, expected);
        millimetres(said, None).map(Some).ok_or_else(unknown)
    };
    pad.pitch_mm = spacing("row_spacing")?
        .zip(spacing("col_spacing")?)
        .map(<[f64; 2]>::from);
    pad.area_mm2 = match pairs.get("sensel_area") {
        None => pad.pitch_mm.map(|[row, column]| row * column),
        Some(said) => Some(square_millimetres(said).ok_or_else(|| {
            let line = pairs.line_of("sensel_area");
            let expected = "an area above 0 with its unit, as `25.8 mm2`, `0.25 cm2` or `0.04 in2`";
            other_unit(text, FORMAT, line, said, expected)
        })?),
    };
    Ok(())
}

/// All bits, or none.
fn bits(all: bool) -> u64 {
    u64::from(all).wrapping_neg()
}

/// Whether a line begins a frame; a spreadsheet puts it between quotes.
fn begins_frame(line: &[u8]) -> bool {
    line.starts_with(b"Frame") || line.starts_with(b"\"Frame")
}

/// Whether it does so with a number, and is no sentence behind the last frame.
fn begins_numbered_frame(line: &[u8]) -> bool {
    let number = line.trim_ascii_start().strip_prefix(b"\"").unwrap_or(line);
    let number = number.strip_prefix(b"Frame ").unwrap_or(b"");
    number
        .trim_ascii_start()
        .first()
        .is_some_and(u8::is_ascii_digit)
}

/// Whether a line closes the frames.
fn is_end(line: &[u8]) -> bool {
    line.strip_prefix(b"\"").unwrap_or(line).starts_with(b"@@")
}

/// Whether a line has nothing but what spreadsheets pad it with.
fn is_blank(line: &[u8]) -> bool {
    line.iter()
        .all(|byte| matches!(byte, b',' | b';' | b' ' | b'\t' | b'"'))
}

/// Whether a line stands between frames.
fn is_between(line: &[u8]) -> bool {
    is_blank(line) || begins_frame(line) || is_end(line)
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

/// Goes on before the line that begins the next frame or closes them, or at the end.
fn skip_to_frame(text: &mut TextFile) -> Result<(), Error> {
    while text.advance()? {
        if begins_frame(text.line()) || is_end(text.line()) {
            text.unread();
            break;
        }
    }
    Ok(())
}

/// Whether another row stands behind those of a frame, which is then the line read last.
fn more_rows(text: &mut TextFile) -> Result<bool, Error> {
    while text.advance()? {
        if is_blank(text.line()) {
            continue;
        }
        if is_between(text.line()) {
            text.unread();
            return Ok(false);
        }
        return Ok(true);
    }
    Ok(false)
}

struct Tekscan {
    text: TextFile,
    rows: usize,
    columns: usize,
    absent: Vec<bool>,
    /// All bits of a number that may not be there, none of any other.
    absent_bits: Vec<u64>,
    is_raw: bool,
    /// Whether the header tells a unit.
    has_unit: bool,
    /// Whether the header tells how many rows a frame has: a blank line is none of them then.
    has_rows: bool,
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
    fn begin(&self, frame: &mut ParsedFrame) -> Result<Option<(f64, u8)>, Error> {
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
        Ok(behind.iter().find_map(|cell| number_and_decimals(cell)))
    }

    /// No cell that the first frame has as none may hold a value.
    fn check_absent(&self, row: &[f64], own: Range<usize>) -> Result<(), Error> {
        let Some(absent) = self.absent_bits.get(own) else {
            return Ok(());
        };
        let pairs = || row.iter().zip(absent);
        // All of them at first, several at once: hardly a row has one.
        if pairs().fold(0, |any, (value, bits)| any | value.to_bits() & bits) == 0 {
            return Ok(());
        }
        let Some(at) = pairs().position(|(value, bits)| *bits > 0 && *value > 0.0) else {
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

    /// Raw counts add up to what the frame's line says; those that were averaged do but for the digits that were not written.
    fn check_sum(&self, frame: &ParsedFrame, told: Option<(f64, u8)>) -> Result<(), Error> {
        let Some((expected, decimals)) = told.filter(|_| self.is_raw) else {
            return Ok(());
        };
        let found: f64 = frame.values.iter().sum();
        let allowed = if frame.decimals == 0 {
            0.0
        } else {
            let loaded = frame.values.iter().filter(|value| **value > 0.0).count();
            // Cells are rounded; sums may be cut off.
            0.5 * loaded as f64 / power_of_ten(frame.decimals) + 1.0 / power_of_ten(decimals)
        };
        if (found - expected).abs() <= allowed {
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

    /// Raw counts are of eight bits: what is more has another unit than the header tells.
    fn check_range(&self, row: &[f64]) -> Result<(), Error> {
        let is_above = |value: &f64| *value > MAX_COUNT;
        if !self.is_raw || !row.iter().fold(false, |any, value| any | is_above(value)) {
            return Ok(());
        }
        let value = row.iter().copied().find(is_above).unwrap_or(0.0);
        Err(Error::Export(Box::new(ExportError::RawRange {
            format: FORMAT,
            at: self.text.place(0),
            value,
            largest: MAX_COUNT,
            said: if self.has_unit {
                "though the header says that they are raw (UNITS)"
            } else {
                "in a file whose header tells no unit (UNITS)"
            },
        })))
    }

    /// Goes to the line that begins the next frame; false at the end. What stands behind the closing line is no frame.
    fn find(&mut self) -> Result<bool, Error> {
        while self.text.advance()? {
            let line = self.text.line();
            let (expected, hint) = if self.has_ended {
                if !begins_numbered_frame(line) {
                    continue;
                }
                let hint = "several recordings in one file; split it, each with its own header";
                ("nothing behind the closing line `@@`", hint)
            } else if is_end(line) {
                self.has_ended = true;
                continue;
            } else if begins_frame(line) {
                return Ok(true);
            } else if is_blank(line) {
                continue;
            } else {
                let hint = "a frame has more lines than the header says";
                ("a line `Frame n` or the end, `@@`", hint)
            };
            return Err(self.text.wrong(FORMAT, expected, hint));
        }
        Ok(false)
    }

    /// No further row stands behind those of a frame: which of them is one too many, nobody can know.
    fn check_end(&mut self) -> Result<(), Error> {
        if !more_rows(&mut self.text)? {
            return Ok(());
        }
        let hint = "a frame has more lines than the header says; --keep-going leaves it out";
        Err(self
            .text
            .wrong(FORMAT, "a line `Frame n` or the end, `@@`", hint))
    }

    /// Goes to the next row of a frame; false where the frame ends before it.
    fn find_row(&mut self) -> Result<bool, Error> {
        while self.text.advance()? {
            let line = self.text.line();
            if self.has_rows && is_blank(line) {
                continue;
            }
            if is_between(line) {
                // What begins the next frame is no line of this one.
                self.text.unread();
                return Ok(false);
            }
            return Ok(true);
        }
        Ok(false)
    }
}

impl Parser for Tekscan {
    fn next(&mut self, frame: &mut ParsedFrame) -> Result<bool, Error> {
        if !self.find()? {
            return Ok(false);
        }
        let columns = self.columns;
        frame.begin(0, self.rows * columns);
        self.frames += 1;
        let told = self.begin(frame)?;
        let mut beyond = Ok(());
        for row in 0..self.rows {
            if !self.find_row()? {
                let expected = format!("{} of them", self.rows);
                return Err(self.text.cut(FORMAT, format!("{row} rows"), expected));
            }
            let own = row * columns..(row + 1) * columns;
            let absent = self.absent.get(own.clone());
            let is_absent = |place: usize, word: &[u8]| {
                first::is_absent(word) && absent.is_some_and(|absent| absent[place])
            };
            let out = &mut frame.values[own.clone()];
            let lines = self.lines;
            lines.read_with(&self.text, out, &mut frame.decimals, is_absent)?;
            self.check_absent(out, own)?;
            beyond = beyond.and_then(|()| self.check_range(out));
        }
        self.check_end()?;
        // A frame that is broken is that alone, and no other unit.
        self.check_sum(frame, told)?;
        beyond.map(|()| true)
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
