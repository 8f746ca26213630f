//! zebris pedcad `.apd`: an INI file with the geometry, the picture of each sensel's largest pressure (`[Data]`) and, where a
//! roll-off was exported, one picture a frame (`[Data0]`, …); −1 is below the threshold. X runs along the lines of a picture.

use std::path::Path;

use super::cells::{Cell, Separator, each_cell, next_cell, number_of};
use super::header::Pairs;
use super::pad::Pad;
use super::text_file::{TextFile, ends_in_point};
use super::units::{length_mm, other_unit, unit_of};
use super::{Beginning, ExportAbout, ParsedFrame, Parser};
use crate::error::Error;

const FORMAT: &str = "zebris .apd";
/// What stands for a pressure too small to be told.
const BELOW_THRESHOLD: f64 = -1.0;

pub(super) fn is_it(beginning: &Beginning) -> bool {
    let mut has = [false; 2];
    for line in beginning.lines(100) {
        has[0] |= line.eq_ignore_ascii_case("[Technical]");
        has[1] |= line.to_lowercase().starts_with("senscountx");
    }
    has == [true; 2]
}

pub(super) fn open(file: &Path) -> Result<(ExportAbout, Box<dyn Parser>), Error> {
    let mut text = TextFile::open(file)?;
    let (mut pairs, mut lines) = (Pairs::default(), Vec::new());
    while text.advance()? && !is_data(text.line()) {
        let words = text.words();
        pairs.add(words.trim(), &['='], text.number());
        lines.push(words.trim().to_owned());
    }
    text.unread();
    let hint = "[Technical] says how large the picture is: SensCountX, SensCountY";
    let size = pairs.count("senscountx").zip(pairs.count("senscounty"));
    let (rows, columns) = size.ok_or_else(|| text.wrong(FORMAT, "its size", hint))?;
    let (unit, known) = unit_of(&text, FORMAT, &pairs, "unitpressure")?;
    let at = text.line_at(pairs.line_of("senscountx"));
    let mut pad = Pad::new((FORMAT, at), (rows, columns), &unit, known)?;
    let unit_mm = distance_unit(&text, &pairs)?;
    let pitch = pairs.positive("ldistx").zip(pairs.positive("ldisty"));
    pad.pitch_mm = pitch.map(|(down, across)| [unit_mm * down, unit_mm * across]);
    pad.area_mm2 = pad.pitch_mm.map(|[down, across]| down * across);
    let mut about = ExportAbout::new(FORMAT, "zebris pedcad", vec![pad]);
    about.header = lines.join("\n");
    let step = pairs.get("timediff").and_then(number_of);
    let unit_secs = time_unit(&text, &pairs)?;
    about.secs_per_frame = step.map(|step| unit_secs * step).filter(|secs| *secs > 0.0);
    let index = |key| pairs.get(key).and_then(|text| text.parse::<u64>().ok());
    about.frames = index("maxidx").and_then(|last| {
        let more = last.checked_sub(index("minidx").unwrap_or(0))?;
        more.checked_add(1)
    });
    let reader = Apd {
        text,
        shape: (rows, columns),
        is_dynamic: pairs.get("maxidx").is_some() || has_frames(file)?,
        is_torn: false,
        row: Vec::new(),
        separator: Separator::Blanks,
    };
    Ok((about, Box::new(reader)))
}

/// Millimetres of the unit of lengths; of a file that names none, one.
fn distance_unit(text: &TextFile, pairs: &Pairs) -> Result<f64, Error> {
    match pairs.get("unitdistance") {
        None => Ok(1.0),
        Some(unit) => length_mm(unit).ok_or_else(|| {
            let line = pairs.line_of("unitdistance");
            other_unit(text, FORMAT, line, unit, "mm, cm or m")
        }),
    }
}

/// Seconds of the unit of times; of a file that names none, a thousandth.
fn time_unit(text: &TextFile, pairs: &Pairs) -> Result<f64, Error> {
    let Some(unit) = pairs.get("unittime") else {
        return Ok(1e-3);
    };
    match unit.to_lowercase().as_str() {
        "ms" | "msec" => Ok(1e-3),
        "s" | "sec" => Ok(1.0),
        _ => {
            let line = pairs.line_of("unittime");
            Err(other_unit(text, FORMAT, line, unit, "ms or s"))
        }
    }
}

/// Whether there is a picture with a number, and so one for each frame.
fn has_frames(file: &Path) -> Result<bool, Error> {
    let mut text = TextFile::open(file)?;
    while text.advance()? {
        if is_data(text.line()) && number(text.line()).is_some() {
            return Ok(true);
        }
    }
    Ok(false)
}

/// Whether a line begins a picture: `[Data]`, the largest of each sensel, or `[Data7]`.
fn is_data(line: &[u8]) -> bool {
    let line = line.trim_ascii();
    line.len() >= 6 && line[..5].eq_ignore_ascii_case(b"[Data") && line.ends_with(b"]")
}

/// The number of a picture; none of `[Data]`.
fn number(line: &[u8]) -> Option<u64> {
    let line = line.trim_ascii();
    std::str::from_utf8(&line[5..line.len() - 1])
        .ok()?
        .parse()
        .ok()
}

struct Apd {
    text: TextFile,
    /// Lines of a picture, and numbers on each.
    shape: (usize, usize),
    /// Whether it has a picture for each frame, beside that of the largest pressures.
    is_dynamic: bool,
    /// Whether the last line ends within its numbers.
    is_torn: bool,
    /// The numbers of a line, and what parted those of the one before.
    row: Vec<f64>,
    separator: Separator,
}

/// Whether the last number of a line has fewer decimals than others have at most: some may be lost.
fn is_shorter(line: &[u8], decimals: u8) -> bool {
    let is_part = |byte: &u8| !matches!(byte, b',' | b';' | b'\t' | b' ' | b'=');
    let line = line.trim_ascii_end();
    let digits = line
        .iter()
        .rev()
        .take_while(|byte| byte.is_ascii_digit())
        .count();
    let rest = &line[..line.len() - digits];
    let has_point = digits > 0 && matches!(rest, [.., before, b'.' | b','] if is_part(before));
    let last = line.iter().rev().take_while(|byte| is_part(byte)).count();
    let is_below = is_below(&line[line.len() - last..]);
    !is_below && (ends_in_point(line) || usize::from(decimals) > if has_point { digits } else { 0 })
}

/// Whether a cell says that a pressure is too small to be told.
fn is_below(cell: &[u8]) -> bool {
    matches!(cell, b"-1" | b"-1.0" | b"-1.00")
}

impl Apd {
    /// The same of a line of as many plain numbers as it is to have; false of another, whatever stands in it.
    fn plain_numbers(&mut self, from: usize, values: &mut Vec<f64>, decimals: &mut u8) -> bool {
        let line = self.text.line();
        let separator = self.separator;
        self.row.resize(self.shape.1, 0.0);
        let mut own = 0;
        let (read, next) =
            self.text
                .plain(separator)
                .read(from, &mut self.row, &mut own, |_, cell| is_below(cell));
        if read < self.shape.1 || next_cell(line, next, separator).is_some() {
            return false;
        }
        *decimals = (*decimals).max(own);
        self.is_torn = !self.text.is_closed() && is_shorter(line, *decimals);
        values.extend_from_slice(&self.row);
        true
    }

    /// The numbers of a line, `y=v,v,…` or `v v v`, behind those before.
    fn numbers(&mut self, values: &mut Vec<f64>, decimals: &mut u8) -> Result<(), Error> {
        let before = values.len();
        let line = self.text.line();
        let from = memchr::memchr(b'=', line).map_or(0, |at| at + 1);
        if self.plain_numbers(from, values, decimals) {
            return Ok(());
        }
        let line = self.text.line();
        let numbers = &line[from..];
        self.separator = Separator::of(numbers);
        let mut fault = None;
        each_cell(numbers, self.separator, |_, cell, (at, to)| {
            match cell {
                Cell::Number(value, _) if value == BELOW_THRESHOLD => values.push(0.0),
                Cell::Number(value, own) if value >= 0.0 => {
                    values.push(value);
                    *decimals = (*decimals).max(own);
                    if own > 0 && !self.text.has_one_point(&numbers[at..to]) {
                        fault = Some((at, to));
                    }
                }
                Cell::Empty => {}
                _ => fault = Some((at, to)),
            }
            fault.is_none()
        });
        let found = values.len() - before;
        let is_short = found > 0 && found < self.shape.1;
        self.is_torn = !self.text.is_closed() && (is_short || is_shorter(line, *decimals));
        if let Some((at, to)) = fault {
            self.text.check_point(FORMAT, (from + at, from + to))?;
            let found = format!("`{}`", crate::grid::shortened(&numbers[at..to]));
            let hint = "a reading that is missing or broken";
            let expected = "a number of 0 or more, or -1";
            return Err(self.text.wrong_at(from + at, FORMAT, found, expected, hint));
        }
        if found == 0 || found == self.shape.1 {
            return Ok(());
        }
        let expected = format!("{} of them on a line (SensCountY)", self.shape.1);
        let hint = "a line was torn, or SensCountX and SensCountY are those of another picture";
        let found = format!("{found} numbers");
        Err(self.text.wrong_at(0, FORMAT, found, expected, hint))
    }
}

impl Parser for Apd {
    fn next(&mut self, frame: &mut ParsedFrame) -> Result<bool, Error> {
        loop {
            if !self.text.advance()? {
                return Ok(false);
            }
            let line = self.text.line();
            if is_data(line) && (!self.is_dynamic || number(line).is_some()) {
                break;
            }
        }
        frame.begin(0, 0);
        frame.number = number(self.text.line());
        while self.text.advance()? {
            let line = self.text.line().trim_ascii();
            if line.starts_with(b"[") {
                self.text.unread();
                break;
            }
            self.numbers(&mut frame.values, &mut frame.decimals)?;
        }
        let found = frame.values.len();
        let taxels = self.shape.0 * self.shape.1;
        if found == taxels {
            return Ok(true);
        }
        let hint = "SensCountX times SensCountY numbers are a picture";
        let expected = format!("{taxels} of them");
        Err(self
            .text
            .wrong_at(0, FORMAT, format!("{found} numbers"), expected, hint))
    }

    fn skip_frame(&mut self) -> Result<(), Error> {
        while self.text.advance()? {
            if is_data(self.text.line()) {
                self.text.unread();
                break;
            }
        }
        Ok(())
    }

    fn text(&self) -> &TextFile {
        &self.text
    }

    fn is_cut(&self) -> bool {
        self.is_torn
    }
}
