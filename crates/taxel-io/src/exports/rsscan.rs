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
/// Lines before the first frame at most.
const MAX_HEADER: usize = 60;
/// Sensels of the plates, mm along and across; the file does not say it.
const PITCH_MM: [f64; 2] = [7.62, 5.08];

pub(super) fn is_it(beginning: &Beginning) -> bool {
    let mut lines = beginning.text.lines().take(MAX_HEADER);
    lines.any(|line| frame_line(line).is_some())
        // Commas would be another's: text recordings may have such lines between their frames.
        && lines
            .find(|line| !line.trim().is_empty())
            .is_some_and(|line| line.contains(['\t', ';']))
}

/// Number and milliseconds of a line `Frame 0 (0.00 ms)`.
fn frame_line(line: &str) -> Option<(u64, f64)> {
    let (number, rest) = line
        .trim()
        .trim_end_matches(['\t', ',', ';'])
        .strip_prefix("Frame ")?
        .split_once('(')?;
    let (ms, unit) = number_and_rest(rest.trim_end().strip_suffix(')')?)?;
    (unit == "ms").then_some((number.trim().parse().ok()?, ms))
}

pub(super) fn open(file: &Path) -> Result<(ExportAbout, Box<dyn Parser>), Error> {
    let mut text = TextFile::open(file)?;
    let mut header = Vec::new();
    while text.advance()? {
        let words = text.words();
        if frame_line(&words).is_some() {
            break;
        }
        header.push(words.trim().to_owned());
    }
    let (rows, columns, separator) = shape(&mut text)?;
    let mut pad = Pad::new(rows, columns, "N", Quantity::Force(1.0));
    pad.pitch_mm = Some(PITCH_MM);
    pad.area_mm2 = Some(PITCH_MM[0] * PITCH_MM[1]);
    let mut about = ExportAbout::new(FORMAT, "RSscan footscan", vec![pad]);
    about.header = header.join("\n").trim().to_owned();
    let reader = RsScan {
        text: TextFile::open(file)?,
        rows: Rows::new(FORMAT, separator),
        shape: (rows, columns),
    };
    Ok((about, Box::new(reader)))
}

/// Rows and columns of the frame whose first line comes next.
fn shape(text: &mut TextFile) -> Result<(usize, usize, Separator), Error> {
    let (mut rows, mut columns, mut separator) = (0, 0, Separator::One(b'\t'));
    while text.advance()? && !is_between(text.line()) {
        if rows == 0 {
            separator = Separator::of(text.line());
            columns = super::cells::each_cell(text.line(), separator, |_, _, _| true);
        }
        rows += 1;
    }
    if rows * columns == 0 {
        return Err(text.wrong(FORMAT, "rows of a frame", "the first frame is empty"));
    }
    Ok((rows, columns, separator))
}

/// Whether a line stands between frames.
fn is_between(line: &[u8]) -> bool {
    line.iter()
        .all(|byte| matches!(byte, b'\t' | b' ' | b',' | b';'))
        || line.starts_with(b"Frame")
}

struct RsScan {
    text: TextFile,
    rows: Rows,
    shape: (usize, usize),
}

impl Parser for RsScan {
    fn next(&mut self, frame: &mut ParsedFrame) -> Result<bool, Error> {
        let (rows, columns) = self.shape;
        let mut is_in_header = self.text.place(0).line == 0;
        let (number, ms) = loop {
            if !self.text.advance()? {
                return Ok(false);
            }
            if let Some(found) = frame_line(&self.text.words()) {
                break found;
            }
            if !is_in_header && !is_between(self.text.line()) {
                return Err(self.text.wrong(
                    FORMAT,
                    "a line `Frame n (t ms)`",
                    "a frame has more lines than the first one",
                ));
            }
            is_in_header &= !self.text.line().starts_with(b"Frame");
        };
        frame.begin(0, rows * columns);
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
            self.rows.read(&self.text, out, &mut frame.decimals)?;
        }
        Ok(true)
    }

    fn skip_frame(&mut self) -> Result<(), Error> {
        while self.text.advance()? {
            if self.text.line().starts_with(b"Frame") {
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
        // The last number may have lost digits.
        !self.text.is_closed()
    }
}
