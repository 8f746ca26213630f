//! What the first frame tells: its shape, where there are sensels, and what parts its numbers.

use super::super::cells::Separator;
use super::super::header::Pairs;
use super::super::text_file::TextFile;
use super::{
    FORMAT, PADDING, begins_frame, find_frame, is_between, is_blank, more_rows, skip_to_frame,
};
use crate::error::Error;
use crate::source::MAX_TAXELS;

/// What the first frame tells.
pub(super) struct First {
    pub(super) rows: usize,
    pub(super) columns: usize,
    /// Of every crossing, whether there is no sensel.
    pub(super) absent: Vec<bool>,
    pub(super) separator: Separator,
}

/// Whether a cell says that there is no sensel: `B`, or nothing.
pub(super) fn is_absent(cell: &[u8]) -> bool {
    let cell = cell.trim_ascii();
    let cell = cell.strip_prefix(b"\"").unwrap_or(cell);
    matches!(cell.strip_suffix(b"\"").unwrap_or(cell), b"B" | b"b" | b"")
}

/// Shape and mask of the first frame that is as the header says; where the header says both sides, one that is torn is passed over
/// here and told when it is read.
pub(super) fn first_frame(text: &mut TextFile, pairs: &Pairs) -> Result<First, Error> {
    let hint = "there is nothing behind the header";
    if !find_frame(text)? {
        return Err(text.wrong(FORMAT, "a line `Frame 1`", hint));
    }
    let first = whole_shape(text, pairs);
    let is_told = pairs.count("rows").is_some() && pairs.count("cols").is_some();
    match first {
        Err(torn) if is_told => {
            let mut next = || {
                if begins_frame(text.line()) {
                    text.unread();
                }
                skip_to_frame(text)?;
                text.advance()?;
                whole_shape(text, pairs)
            };
            next().map_err(|_| torn)
        }
        first => first,
    }
}

/// The same of a frame that has no more rows than the header says.
fn whole_shape(text: &mut TextFile, pairs: &Pairs) -> Result<First, Error> {
    let first = frame_shape(text, pairs)?;
    let is_told = pairs.count("rows") == Some(first.rows);
    if is_told && first.absent.len() <= MAX_TAXELS && more_rows(text)? {
        let hint = "the header says so (ROWS); a line comes twice, or its header is of another";
        let expected = format!("{} of them", first.rows);
        return Err(text.wrong_at(0, FORMAT, "more rows in the first frame", expected, hint));
    }
    Ok(first)
}

fn frame_shape(text: &mut TextFile, pairs: &Pairs) -> Result<First, Error> {
    let mut absent = Vec::new();
    let mut separator = Separator::One(b',');
    let told = pairs.count("rows");
    let (mut rows, mut columns) = (0, pairs.count("cols").unwrap_or(0));
    while rows < told.unwrap_or(usize::MAX) && text.advance()? {
        if told.is_some() && is_blank(text.line()) {
            continue;
        }
        if is_between(text.line()) {
            break;
        }
        let line = text.words();
        if rows == 0 {
            separator = separator_of(text.line());
        }
        let cells: Vec<&str> = match separator {
            Separator::Blanks => line.split_whitespace().collect(),
            // Of a known number of cells the last may be empty.
            Separator::One(one) if columns > 0 => line.split(char::from(one)).collect(),
            Separator::One(one) => {
                let line = line.trim_end_matches(PADDING);
                line.split(char::from(one)).collect()
            }
        };
        if columns == 0 {
            columns = cells.len();
        }
        if cells.len() < columns {
            let hint = "the header's COLS is another, or a line is torn";
            let found = format!("{} values", cells.len());
            return Err(text.wrong_at(0, FORMAT, found, format!("{columns} of them"), hint));
        }
        let cells = cells.iter().take(columns);
        absent.extend(cells.map(|cell| is_absent(cell.as_bytes())));
        rows += 1;
        if absent.len() > MAX_TAXELS {
            // More than any sensor has: their size is refused.
            break;
        }
    }
    match told {
        Some(told) if told != rows && absent.len() <= MAX_TAXELS => {
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

/// What parts the cells of a row; of one cell, whatever parts those of a table.
fn separator_of(line: &[u8]) -> Separator {
    match Separator::of(line) {
        Separator::Blanks if !line.trim_ascii().contains(&b' ') => Separator::One(b','),
        separator => separator,
    }
}
