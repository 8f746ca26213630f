//! A line of a table whose cells may stand between quotes, and may go on there over several lines, as arrays are printed.

use std::ops::Range;

use super::super::text_file::TextFile;
use super::FORMAT;
use crate::error::Error;
use crate::words::{no_digits, number};

/// Lines that a cell goes on over at most.
const MAX_LINES: usize = 1000;

/// The cells of one line of the table.
#[derive(Debug, Default)]
pub(super) struct Record {
    bytes: Vec<u8>,
    cells: Vec<Range<usize>>,
    /// The number of the file's line that it begins with.
    line: u64,
}

impl Record {
    /// Reads the next line that is not empty; false at the end, and it is still the one before.
    pub(super) fn read(&mut self, text: &mut TextFile, part: u8) -> Result<bool, Error> {
        loop {
            if !text.advance()? {
                return Ok(false);
            }
            if !text.line().is_empty() {
                break;
            }
        }
        self.line = text.number();
        self.bytes.clear();
        self.cells.clear();
        self.bytes.extend_from_slice(text.line());
        let mut from = 0;
        let mut lines = 1;
        loop {
            match cell(&self.bytes, from, part) {
                Some((cell, next)) => {
                    self.cells.push(cell);
                    match next {
                        Some(next) => from = next,
                        None => return Ok(true),
                    }
                }
                None => {
                    lines += 1;
                    self.read_on(text, part, lines)?;
                }
            }
        }
    }

    /// Takes the next line as well: a quote is still to be closed.
    fn read_on(&mut self, text: &mut TextFile, part: u8, lines: usize) -> Result<(), Error> {
        let unclosed = |text: &TextFile, number| {
            let expected = "a quote that closes the cell";
            let hint = "a quote was lost, or the file is cut; --keep-going leaves the frame out";
            text.wrong_on(number, FORMAT, "a cell without its end", expected, hint)
        };
        if lines > MAX_LINES || !text.advance()? {
            return Err(unclosed(text, self.line));
        }
        if opens_first(text.line(), part) {
            // The line is another's, and is not lost with this one.
            text.unread();
            return Err(unclosed(text, self.line));
        }
        self.bytes.push(b'\n');
        self.bytes.extend_from_slice(text.line());
        Ok(())
    }

    /// The cell at a place, without its quotes; empty where there is none.
    pub(super) fn cell(&self, at: usize) -> &[u8] {
        let cell = self.cells.get(at).cloned();
        cell.map_or(&[], |cell| &self.bytes[cell])
    }

    /// How many there are.
    pub(super) fn len(&self) -> usize {
        self.cells.len()
    }

    /// Whether a quote closes its last cell.
    pub(super) fn is_quoted(&self) -> bool {
        self.bytes.trim_ascii_end().ends_with(b"\"")
    }

    /// The number of the file's line that it begins with.
    pub(super) fn line(&self) -> u64 {
        self.line
    }
}

/// The cell from byte `from` on, without its quotes, and where the next one begins, if there is one; `None` of one whose quote is
/// not closed.
fn cell(bytes: &[u8], from: usize, part: u8) -> Option<(Range<usize>, Option<usize>)> {
    let end_from = |at: usize| memchr::memchr(part, &bytes[at..]).map(|length| at + length);
    let blanks = bytes[from..]
        .iter()
        .take_while(|byte| **byte == b' ')
        .count();
    if bytes.get(from + blanks) != Some(&b'"') {
        let end = end_from(from);
        return Some((from..end.unwrap_or(bytes.len()), end.map(|end| end + 1)));
    }
    let first = from + blanks + 1;
    let mut at = first;
    loop {
        at += memchr::memchr(b'"', &bytes[at..])?;
        // Two stand for one.
        if bytes.get(at + 1) != Some(&b'"') {
            break;
        }
        at += 2;
    }
    let end = end_from(at + 1);
    Some((first..at, end.map(|end| end + 1)))
}

/// Whether the first quote of a line opens a cell: it has a separator before it, and none behind.
fn opens_first(line: &[u8], part: u8) -> bool {
    let Some(at) = memchr::memchr(b'"', line) else {
        return false;
    };
    let is_parted = |byte: Option<&u8>| byte.is_none_or(|byte| *byte == part);
    let before = at.checked_sub(1).and_then(|at| line.get(at));
    before == Some(&part) && !is_parted(line.get(at + 1))
}

/// The numbers of a cell, whatever stands between them; what is none, as `1-2`, is NaN.
pub(super) fn numbers(cell: &[u8], out: &mut Vec<f64>) {
    let is_part =
        |byte: &u8| byte.is_ascii_digit() || matches!(byte, b'.' | b'-' | b'+' | b'e' | b'E');
    let mut at = 0;
    while let Some(skipped) = cell[at..].iter().position(is_part) {
        at += skipped;
        if let Some(bytes) = cell[at..].first_chunk() {
            let word = u64::from_le_bytes(*bytes);
            let bits = no_digits(word).trailing_zeros() & !7;
            let end = at + bits as usize / 8;
            if (8..64).contains(&bits) && !is_part(&cell[end]) {
                out.push(f64::from(number(word << (64 - bits))));
                at = end + 1;
                continue;
            }
        }
        let length = cell[at..].iter().take_while(|byte| is_part(byte)).count();
        let number = std::str::from_utf8(&cell[at..at + length]);
        let number = number.ok().and_then(|number| number.parse().ok());
        out.push(number.unwrap_or(f64::NAN));
        at += length;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn cells_between_quotes_and_without() {
        let line = br#"1,,"a, b","c ""d""", "e",f"#;
        let (mut from, mut found) = (0, Vec::new());
        loop {
            let (range, next) = cell(line, from, b',').unwrap();
            found.push(std::str::from_utf8(&line[range]).unwrap());
            match next {
                Some(next) => from = next,
                None => break,
            }
        }
        assert_eq!(found, ["1", "", "a, b", r#"c ""d"""#, "e", "f"]);
        assert_eq!(cell(br#"1,"[2, 3"#, 2, b','), None);
        assert!(opens_first(br#"1,0.02,"[1, 2]""#, b','));
        assert!(!opens_first(br#" [1 2]]","[[3 4]"#, b','));
    }

    proptest! {
        #[test]
        fn numbers_are_those_of_the_standard_library(cell in "([0-9]{1,9}|[-+.eE0-9]{0,6})([], \n;x]{0,2}([0-9]{1,9}|[-+.eE0-9]{0,6})){0,20}") {
            let is_part = |c: char| c.is_ascii_digit() || "+-.eE".contains(c);
            let words = cell.split(|c| !is_part(c)).filter(|word| !word.is_empty());
            let expected: Vec<f64> = words.map(|word| word.parse().unwrap_or(f64::NAN)).collect();
            let mut found = Vec::new();
            numbers(cell.as_bytes(), &mut found);
            let bits = |all: &[f64]| all.iter().map(|one| one.to_bits()).collect::<Vec<_>>();
            prop_assert_eq!(bits(&found), bits(&expected));
        }
    }
}
