//! RSscan / Materialise footscan as text: `Frame 0 (0.00 ms)`, rows of tab-separated newtons per sensel, an empty line. An entire
//! plate has no header; one foot has lines of words before its first frame.

use std::path::Path;

use super::cells::{Separator, number_and_rest};
use super::pad::{Pad, Quantity};
use super::row::Rows;
use super::text_file::TextFile;
use super::{Beginning, ExportAbout, ParsedFrame, Parser};
use crate::error::Error;

const FORMAT: &str = "RSscan text";
/// Frames that are looked at for their shape: one of them may be torn.
const LOOKED_AT: usize = 5;
/// Lines before the first frame at most.
const MAX_HEADER: usize = 60;
/// Sensels of the plates, mm along and across; the file does not say it.
const PITCH_MM: [f64; 2] = [7.62, 5.08];

/// Feet of a file at most.
const MAX_FEET: usize = 8;

pub(super) fn is_it(beginning: &Beginning) -> bool {
    let mut lines = beginning.text.lines().take(MAX_HEADER);
    let is_first = |line: &str| frame_line(line.trim().trim_matches('"')).is_some();
    let begins = beginning.lines(MAX_HEADER).find(|line| !line.is_empty());
    if !lines.any(is_first) {
        return false;
    }
    let row = lines.find(|line| !line.trim().is_empty()).unwrap_or("");
    // Commas may be another's: text recordings may have such lines between their frames, but counts have no decimals.
    let is_decimal = || begins.is_some_and(|line| line.contains('.') && is_first(line));
    row.contains(['\t', ';']) || row.contains(',') && row.contains('.') && is_decimal()
}

/// The foot whose frames stand behind a line as `Right foot data`.
fn foot_line(line: &[u8]) -> Option<&'static str> {
    let line = line.trim_ascii();
    let is_it = |side: &str| {
        let side = format!("{side} foot data");
        let begin = line.get(..side.len());
        begin.is_some_and(|begin| begin.eq_ignore_ascii_case(side.as_bytes()))
    };
    // Nearly all lines are numbers.
    let begins = line.first().is_some_and(u8::is_ascii_alphabetic);
    ["left", "right"]
        .into_iter()
        .find(|side| begins && is_it(side))
}

/// Number and milliseconds of a line `Frame 0 (0.00 ms)`.
fn frame_line(line: &str) -> Option<(u64, f64)> {
    let (number, rest) = line
        .trim()
        .trim_end_matches(['\t', ',', ';'])
        .trim_matches('"')
        .strip_prefix("Frame ")?
        .split_once('(')?;
    let (ms, unit) = number_and_rest(rest.trim_end().strip_suffix(')')?)?;
    (unit == "ms").then_some((number.trim().parse().ok()?, ms))
}

pub(super) fn open(file: &Path) -> Result<(ExportAbout, Box<dyn Parser>), Error> {
    let mut text = TextFile::open(file)?;
    let (mut pads, mut feet, mut header) = (Vec::<Pad>::new(), Vec::new(), Vec::new());
    let mut side = "";
    loop {
        let mut own = Vec::new();
        while text.advance()? {
            let words = text.words();
            if frame_line(&words).is_some() {
                break;
            }
            side = foot_line(text.line()).unwrap_or(side);
            own.push(words.trim().to_owned());
        }
        let (rows, columns, separator) = shape(&mut text, told_shape(&own))?;
        let at = (FORMAT, text.place(0));
        let mut pad = Pad::new(at, (rows, columns), "N", Quantity::Force(1.0))?;
        pad.pitch_mm = Some(PITCH_MM);
        pad.area_mm2 = Some(PITCH_MM[0] * PITCH_MM[1]);
        pad.name = if pads.iter().any(|other| other.name == side) {
            format!("{side} {}", pads.len() + 1)
        } else {
            side.to_owned()
        };
        pads.push(pad);
        feet.push((Rows::new(FORMAT, separator), (rows, columns)));
        header.extend(own);
        if !find_foot(&mut text)? {
            break;
        }
        if pads.len() == MAX_FEET {
            let found = format!("foot {}", MAX_FEET + 1);
            let hint = "several recordings in one file; split it";
            return Err(text.wrong_at(0, FORMAT, found, format!("{MAX_FEET} at most"), hint));
        }
    }
    let mut about = ExportAbout::new(FORMAT, "RSscan footscan", pads);
    about.header = header.join("\n").trim().to_owned();
    let reader = RsScan {
        text: TextFile::open(file)?,
        feet,
        foot: 0,
        is_in_header: true,
        has_begun: false,
    };
    Ok((about, Box::new(reader)))
}

/// Goes before the line that begins the next foot; false at the end.
fn find_foot(text: &mut TextFile) -> Result<bool, Error> {
    while text.advance()? {
        if foot_line(text.line()).is_some() {
            text.unread();
            return Ok(true);
        }
    }
    Ok(false)
}

/// Rows and columns that a header says, each where it does: `Rectangle height`, `Rectangle width`.
fn told_shape(header: &[String]) -> [Option<usize>; 2] {
    ["height", "width"].map(|side| {
        header.iter().find_map(|line| {
            let line = line.to_lowercase();
            // A height alone is a person's.
            let said = line.trim().strip_prefix("rectangle")?;
            let said = said.trim_start().strip_prefix(side)?;
            let is_between = |c: char| c == ':' || c == ';' || c == ',' || c.is_whitespace();
            let word = said.trim_matches(is_between).split(is_between).next()?;
            word.parse().ok().filter(|count| *count > 0)
        })
    })
}

/// Rows and columns of the first frames, whose first line comes next: those that the header says, or that most of them have.
fn shape(
    text: &mut TextFile,
    [told_rows, told_columns]: [Option<usize>; 2],
) -> Result<(usize, usize, Separator), Error> {
    let mut found = Vec::new();
    while found.len() < LOOKED_AT {
        if let Some(shape) = frame_shape(text)? {
            found.push(shape);
        }
        if !next_frame(text)? {
            break;
        }
    }
    if found.is_empty() {
        return Err(text.wrong(FORMAT, "rows of a frame", "the first frame is empty"));
    }
    let fits = |told: Option<usize>, own: usize| told.is_none_or(|told| told == own);
    let as_told = found
        .iter()
        .find(|(rows, columns, _)| fits(told_rows, *rows) && fits(told_columns, *columns));
    // Of as many the larger one: what is torn is smaller.
    let alike = |shape: &&(usize, usize, Separator)| {
        let count = found.iter().filter(|own| own == shape).count();
        (count, shape.0 * shape.1)
    };
    let most = found.iter().max_by_key(alike);
    let is_told = told_rows.is_some() || told_columns.is_some();
    match (as_told.filter(|_| is_told), most) {
        (Some(shape), _) => Ok(*shape),
        (None, Some(&(rows, columns, _))) if is_told => {
            let side = |told: Option<usize>, own: usize| told.unwrap_or(own);
            let [high, wide] = [side(told_rows, rows), side(told_columns, columns)];
            let expected = format!("{high} rows x {wide} columns (Rectangle height, width)");
            let hint = "the header says so; a line was lost, or the header is of another recording";
            let found = format!("frames of {rows} rows x {columns} columns");
            Err(text.wrong_at(0, FORMAT, found, expected, hint))
        }
        (None, most) => Ok(*most.unwrap_or(&found[0])),
    }
}

/// Rows and columns of the frame whose first line comes next; `None` of one without.
fn frame_shape(text: &mut TextFile) -> Result<Option<(usize, usize, Separator)>, Error> {
    let (mut rows, mut columns, mut separator) = (0, 0, Separator::One(b'\t'));
    while text.advance()? {
        if is_between(text.line()) {
            text.unread();
            break;
        }
        if rows == 0 {
            separator = Separator::of(text.line());
            columns = super::cells::each_cell(text.line(), separator, |_, _, _| true);
        }
        rows += 1;
    }
    Ok((rows * columns > 0).then_some((rows, columns, separator)))
}

/// Goes behind the line that begins the next frame of the same foot; false at its end.
fn next_frame(text: &mut TextFile) -> Result<bool, Error> {
    while text.advance()? {
        if foot_line(text.line()).is_some() {
            text.unread();
            return Ok(false);
        }
        if frame_line(&text.words()).is_some() {
            return Ok(true);
        }
    }
    Ok(false)
}

/// Whether a line stands between frames.
fn is_between(line: &[u8]) -> bool {
    line.iter()
        .all(|byte| matches!(byte, b'\t' | b' ' | b',' | b';'))
        || line
            .strip_prefix(b"\"")
            .unwrap_or(line)
            .starts_with(b"Frame")
        || foot_line(line).is_some()
}

struct RsScan {
    text: TextFile,
    /// Of each foot, how its rows are written, and rows and columns of a frame.
    feet: Vec<(Rows, (usize, usize))>,
    /// Which of them the lines read last are of.
    foot: usize,
    /// Whether those are words before the frames of a foot.
    is_in_header: bool,
    /// Whether a frame was met.
    has_begun: bool,
}

impl RsScan {
    /// Goes to the line that begins the next frame: its number and its milliseconds; `None` at the end.
    fn find(&mut self) -> Result<Option<(u64, f64)>, Error> {
        while self.text.advance()? {
            if let Some(found) = frame_line(&self.text.words()) {
                (self.is_in_header, self.has_begun) = (false, true);
                return Ok(Some(found));
            }
            let line = self.text.line();
            if foot_line(line).is_some() {
                self.foot += usize::from(self.has_begun);
                self.is_in_header = true;
            } else if !self.is_in_header && !is_between(line) {
                return Err(self.text.wrong(
                    FORMAT,
                    "a line `Frame n (t ms)`",
                    "what stands between frames is no line of numbers",
                ));
            } else if line.starts_with(b"Frame") {
                self.is_in_header = false;
            }
        }
        Ok(None)
    }
}

impl Parser for RsScan {
    fn next(&mut self, frame: &mut ParsedFrame) -> Result<bool, Error> {
        let Some((number, ms)) = self.find()? else {
            return Ok(false);
        };
        let (lines, (rows, columns)) = self.feet[self.foot];
        frame.begin(self.foot, rows * columns);
        frame.number = Some(number);
        frame.secs = Some(1e-3 * ms);
        for row in 0..rows {
            let is_there = self.text.advance()?;
            if !is_there || is_between(self.text.line()) {
                if is_there {
                    self.text.unread();
                }
                let found = format!("{row} rows");
                return Err(self.text.cut(FORMAT, found, format!("{rows} of them")));
            }
            let out = &mut frame.values[row * columns..(row + 1) * columns];
            lines.read(&self.text, out, &mut frame.decimals)?;
        }
        if self.text.advance()? {
            if !is_between(self.text.line()) {
                let hint = "a frame has more rows than the others; --keep-going leaves it out";
                let expected = format!("the end of the frame behind {rows} rows");
                return Err(self.text.wrong(FORMAT, expected, hint));
            }
            self.text.unread();
        }
        Ok(true)
    }

    fn skip_frame(&mut self) -> Result<(), Error> {
        while self.text.advance()? {
            let line = self.text.line();
            if frame_line(&self.text.words()).is_some() || foot_line(line).is_some() {
                self.text.unread();
                break;
            }
        }
        Ok(())
    }

    fn text(&self) -> &TextFile {
        &self.text
    }

    fn pad_of_error(&self) -> Option<usize> {
        Some(self.foot)
    }

    fn is_cut(&self) -> bool {
        // The last number may have lost digits.
        !self.text.is_closed()
    }
}
