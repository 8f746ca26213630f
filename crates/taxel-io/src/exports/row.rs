//! A row of a frame: so many numbers on a line.

use super::cells::{Cell, Separator, next_cell};
use super::text_file::TextFile;
use crate::error::Error;

/// How the lines of a frame are written.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rows {
    /// The format, for messages.
    pub(super) format: &'static str,
    /// What parts the numbers.
    pub(super) separator: Separator,
    /// Cells that stand before the numbers.
    pub(super) skipped: usize,
}

impl Rows {
    /// Numbers and nothing else.
    pub(super) fn new(format: &'static str, separator: Separator) -> Self {
        Self {
            format,
            separator,
            skipped: 0,
        }
    }

    /// Reads the numbers of the line read last into `out`, and the most decimals of any.
    pub(super) fn read(
        &self,
        text: &TextFile,
        out: &mut [f64],
        decimals: &mut u8,
    ) -> Result<(), Error> {
        self.read_with(text, out, decimals, |_, _| false)
    }

    /// The same where a word may stand in the place of a number, or nothing, if `is_word` says so of its place and its bytes; it leaves 0.
    pub(super) fn read_with(
        &self,
        text: &TextFile,
        out: &mut [f64],
        decimals: &mut u8,
        is_word: impl Fn(usize, &[u8]) -> bool,
    ) -> Result<(), Error> {
        let line = text.line();
        let plain = text.plain(self.separator);
        let mut fault = None;
        let (mut cell, mut found, mut at) = (0, 0, 0);
        loop {
            if let Some(place) = usize::checked_sub(cell, self.skipped)
                && let Some(out) = out.get_mut(place..)
            {
                let is_word = |own: usize, word: &[u8]| is_word(place + own, word);
                let (read, next) = plain.read(at, out, decimals, is_word);
                (cell, found, at) = (cell + read, found + read, next);
            }
            let Some((content, (from, to), next)) = next_cell(line, at, self.separator) else {
                break;
            };
            (cell, at) = (cell + 1, next);
            let Some(place) = usize::checked_sub(cell, self.skipped + 1) else {
                continue;
            };
            let Some(number) = out.get_mut(place) else {
                // What pads a line is no number.
                found += usize::from(content != Cell::Empty);
                continue;
            };
            found += 1;
            match content {
                Cell::Number(value, own)
                    if value >= 0.0 && (own == 0 || text.has_one_point(&line[from..to])) =>
                {
                    *number = value;
                    *decimals = (*decimals).max(own);
                }
                Cell::Number(value, _) if value >= 0.0 => {
                    fault = Some((place, from, to));
                    break;
                }
                _ if is_word(place, &line[from..to]) => *number = 0.0,
                _ => {
                    fault = Some((place, from, to));
                    break;
                }
            }
        }
        if let Some((place, from, to)) = fault {
            return Err(self.broken(text, (place, out.len()), (from, to)));
        }
        // What closes a line closes its last cell: one that is empty is not seen.
        let is_closed = matches!(self.separator, Separator::One(one) if line.ends_with(&[one]));
        if is_closed && found + 1 == out.len() && is_word(found, b"") {
            out[found] = 0.0;
            found += 1;
        }
        if found == out.len() {
            return Ok(());
        }
        Err(text.wrong_at(
            0,
            self.format,
            format!("{found} values"),
            format!("{} of them", out.len()),
            "a line was torn or lost, or the shape that the header says is another; --keep-going leaves the frame out",
        ))
    }

    /// That bytes `from..to` of the line, the value at a place of so many, are no number that may stand there.
    fn broken(
        &self,
        text: &TextFile,
        (place, count): (usize, usize),
        (from, to): (usize, usize),
    ) -> Error {
        if let Err(mixed) = text.check_point(self.format, (from, to)) {
            return mixed;
        }
        let cell = crate::grid::shortened(&text.line()[from..to]);
        text.wrong_at(
            from,
            self.format,
            format!("value {} of {count} is `{cell}`", place + 1),
            "a number of 0 or more",
            "a reading that is missing or broken; --keep-going leaves its frame out",
        )
    }
}

/// The time that the line read last begins with, and its numbers into `out`, and their most decimals, where these are plain and
/// nothing else stands in it. `None` of every other line; `out` may have lost what it held then.
pub(super) fn timed_row(
    text: &TextFile,
    separator: Separator,
    out: &mut [f64],
    decimals: &mut u8,
) -> Option<f64> {
    let line = text.line();
    let (Cell::Number(secs, own), (from, to), next) = next_cell(line, 0, separator)? else {
        return None;
    };
    if own > 0 && !text.has_one_point(&line[from..to]) {
        return None;
    }
    // What stands before decimals is known by now.
    let (read, at) = text
        .plain(separator)
        .read(next, out, decimals, |_, _| false);
    let is_all = read == out.len() && next_cell(line, at, separator).is_none();
    is_all.then_some(secs)
}
