//! Lines of numbers: what the text protocols share.

use taxel::{Counts, Frame};

use super::{Expected, Fault, Tally};

/// Bytes to lines. A line longer than any of a frame is passed over.
#[derive(Debug)]
pub(super) struct LineBuffer {
    line: Vec<u8>,
    longest: usize,
    overlong: bool,
    /// The stream may have begun inside a line.
    whole: bool,
}

impl LineBuffer {
    /// Lines of at most this many numbers.
    pub fn new(numbers: usize) -> Self {
        Self {
            line: Vec::new(),
            // Ten digits and more than one separator each; some room for an index and a line end.
            longest: 14 * numbers + 64,
            overlong: false,
            whole: false,
        }
    }

    /// Hands on every line that the bytes complete; `None` for one that was too long.
    pub fn feed(&mut self, mut bytes: &[u8], take: &mut dyn FnMut(Option<&[u8]>, bool)) {
        while !bytes.is_empty() {
            let end = bytes.iter().position(|&byte| byte == b'\n');
            let part = &bytes[..end.unwrap_or(bytes.len())];
            if self.line.len() + part.len() > self.longest {
                self.overlong = true;
                self.line.clear();
            }
            if !self.overlong {
                self.line.extend_from_slice(part);
            }
            bytes = match end {
                Some(end) => {
                    let line = (!self.overlong).then_some(self.line.as_slice());
                    take(line, self.whole);
                    self.line.clear();
                    self.overlong = false;
                    self.whole = true;
                    &bytes[end + 1..]
                }
                None => &[],
            };
        }
    }

    pub fn forget(&mut self) {
        self.line.clear();
        self.overlong = false;
        self.whole = false;
    }
}

/// The counts of a line; `None` where something is no number. Separators are commas, semicolons, blanks.
pub(super) fn counts(line: &[u8], into: &mut Vec<u64>) -> bool {
    into.clear();
    let separates = |byte: &u8| matches!(byte, b',' | b';' | b' ' | b'\t' | b'\r');
    for field in line.split(separates) {
        if field.is_empty() {
            continue;
        }
        let mut value = 0u64;
        if field.len() > 10 {
            return false;
        }
        for &byte in field {
            if !byte.is_ascii_digit() {
                return false;
            }
            value = 10 * value + u64::from(byte - b'0');
        }
        into.push(value);
    }
    true
}

/// What is common to text that carries a frame row by row.
pub(super) struct Rows {
    pub expected: Expected,
    pub frame: Frame<Counts>,
    pub seen: Vec<bool>,
    pub tally: Tally,
    pub fault: Option<Fault>,
}

impl Rows {
    pub fn new(expected: Expected) -> Self {
        Self {
            frame: expected.frame(),
            seen: vec![false; expected.rows],
            expected,
            tally: Tally::default(),
            fault: None,
        }
    }

    pub fn blame(&mut self, fault: Fault) {
        self.tally.corrupt += 1;
        self.fault = Some(fault);
        self.seen.fill(false);
    }

    /// A frame ended here; if rows of it are missing, it was broken.
    pub fn cut(&mut self) {
        let found = self.seen.iter().filter(|seen| **seen).count();
        if found > 0 {
            let expected = self.expected.rows;
            self.blame(Fault::Rows { found, expected });
        }
    }

    /// Takes a row, or several at once from `row` on, and hands on the frame if that was its last.
    pub fn put(&mut self, row: usize, counts: &[u64], take: &mut dyn FnMut(&Frame<Counts>)) {
        let largest = self.expected.max_count;
        if let Some(&found) = counts.iter().find(|count| **count > largest) {
            return self.blame(Fault::Range { found, largest });
        }
        let from = row * self.expected.columns;
        for (value, &count) in self.frame.values_mut()[from..].iter_mut().zip(counts) {
            *value = count as f64;
        }
        let rows = counts.len() / self.expected.columns;
        self.seen[row..row + rows].fill(true);
        if self.seen.iter().all(|seen| *seen) {
            self.frame.sequence = self.tally.frames;
            self.tally.frames += 1;
            self.seen.fill(false);
            take(&self.frame);
        }
    }
}
