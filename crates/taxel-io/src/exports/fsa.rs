//! FSA / Vista Medical mats as text: a frame of 32 x 64 a line, numbers parted by tabs, or by what a spreadsheet has put for them, and
//! nothing else. Neither times nor a unit stand in it.

use std::path::Path;

use super::cells::{Separator, number_of};
use super::pad::{Pad, Quantity};
use super::row::Rows;
use super::text_file::TextFile;
use super::{Beginning, ExportAbout, ParsedFrame, Parser};
use crate::error::Error;

const FORMAT: &str = "FSA text";
const ROWS: usize = 32;
const COLUMNS: usize = 64;

pub(super) fn is_it(beginning: &Beginning) -> bool {
    let is_frame = |line: &str| {
        ['\t', ';', ' ', ','].iter().any(|one| {
            let cells = line.split(*one).map(str::trim);
            let is_number = |cell: &str| number_of(cell).is_some_and(|number| number >= 0.0);
            cells.clone().count() == ROWS * COLUMNS && cells.clone().all(is_number)
        })
    };
    let mut lines = beginning.lines(usize::MAX).filter(|line| !line.is_empty());
    lines.next().is_some_and(is_frame)
}

pub(super) fn open(file: &Path) -> Result<(ExportAbout, Box<dyn Parser>), Error> {
    let mut text = TextFile::open(file)?;
    let mut separator = Separator::One(b'\t');
    while text.advance()? {
        if !text.line().trim_ascii().is_empty() {
            separator = Separator::of(text.line());
            break;
        }
    }
    let text = TextFile::open(file)?;
    let at = (FORMAT, text.place(0));
    let pad = Pad::new(at, (ROWS, COLUMNS), "raw", Quantity::Raw)?;
    let about = ExportAbout::new(FORMAT, "FSA / Vista Medical", vec![pad]);
    let rows = Rows::new(FORMAT, separator);
    Ok((about, Box::new(Fsa { text, rows })))
}

struct Fsa {
    text: TextFile,
    rows: Rows,
}

impl Parser for Fsa {
    fn next(&mut self, frame: &mut ParsedFrame) -> Result<bool, Error> {
        loop {
            if !self.text.advance()? {
                return Ok(false);
            }
            if !self.text.line().trim_ascii().is_empty() {
                break;
            }
        }
        frame.begin(0, ROWS * COLUMNS);
        let rows = self.rows;
        if !self.text.read_whole(rows.separator, &mut frame.values) {
            rows.read(&self.text, &mut frame.values, &mut frame.decimals)?;
        }
        Ok(true)
    }

    fn skip_frame(&mut self) -> Result<(), Error> {
        // A frame is a line, and it is gone.
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
