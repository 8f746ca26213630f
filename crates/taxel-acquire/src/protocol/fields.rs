//! Lines of numbers: what the text protocols share.

use std::time::Duration;

use taxel::{Counts, Frame};

use super::{Expected, FrameFault, LinkStats};

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

    /// Hands on every line that the bytes complete; `None` for one that is too long, as soon as it is. Zero bytes before a
    /// line belong to none: a line that is powered up reads as such.
    pub fn feed(&mut self, mut bytes: &[u8], take: &mut dyn FnMut(Option<&[u8]>, bool)) {
        while !bytes.is_empty() {
            let end = bytes.iter().position(|&byte| byte == b'\n');
            let mut part = &bytes[..end.unwrap_or(bytes.len())];
            if self.line.is_empty() {
                let zeros = part.iter().take_while(|byte| **byte == 0).count();
                part = &part[zeros..];
            }
            if !self.overlong && self.line.len() + part.len() > self.longest {
                self.overlong = true;
                self.line.clear();
                take(None, self.whole);
            }
            if !self.overlong {
                self.line.extend_from_slice(part);
            }
            bytes = match end {
                Some(end) => {
                    if !self.overlong {
                        take(Some(&self.line), self.whole);
                    }
                    self.line.clear();
                    self.overlong = false;
                    self.whole = true;
                    &bytes[end + 1..]
                }
                None => &[],
            };
        }
    }

    /// The line that has begun, where its beginning is known.
    pub fn pending(&self) -> Option<&[u8]> {
        (self.whole && !self.line.is_empty()).then_some(&self.line)
    }

    /// Lets go of a line that has begun; whether it was the beginning of numbers.
    pub fn forget(&mut self) -> bool {
        let begun = self.whole && self.line.first().is_some_and(u8::is_ascii_digit);
        self.line.clear();
        self.overlong = false;
        self.whole = false;
        begun
    }
}

/// Whether a line that is no row was to be one: most of it is numbers, and they are not few.
pub(super) fn was_numbers(line: &[u8], columns: usize) -> bool {
    let separates = |byte: &u8| matches!(byte, b',' | b';' | b' ' | b'\t' | b'\r');
    let (mut fields, mut numbers) = (0, 0);
    for field in line.split(separates).filter(|field| !field.is_empty()) {
        fields += 1;
        numbers += usize::from(field.iter().all(u8::is_ascii_digit));
    }
    !line.starts_with(b"#") && numbers >= (columns / 2).max(2) && 2 * numbers >= fields
}

/// How often frames come, where they come as datagrams.
#[derive(Debug, Default)]
pub(super) struct Pace {
    since: Duration,
    periods: Vec<Duration>,
    frames: u64,
}

impl Pace {
    /// The periods that the usual one is the median of, and how many it takes to know it.
    const MAX_PERIODS: usize = 9;
    const MIN: usize = 3;

    /// A datagram has come; whether it is too late to belong to the same frame as the one before.
    pub fn datagram(&mut self, after: Duration) -> bool {
        self.since += after;
        if self.periods.len() < Self::MIN {
            return false;
        }
        let mut sorted = self.periods.clone();
        sorted.sort_unstable();
        after > sorted[sorted.len() / 2].mul_f64(0.75)
    }

    /// So many frames have come by now.
    pub fn frames(&mut self, frames: u64) {
        let new = u32::try_from(frames - self.frames).unwrap_or(u32::MAX);
        if new == 0 {
            return;
        }
        if self.periods.len() == Self::MAX_PERIODS {
            self.periods.remove(0);
        }
        self.periods.push(self.since / new);
        (self.since, self.frames) = (Duration::ZERO, frames);
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
    pub link_stats: LinkStats,
    pub fault: Option<FrameFault>,
}

impl Rows {
    pub fn new(expected: Expected) -> Self {
        Self {
            frame: expected.frame(),
            seen: vec![false; expected.rows],
            expected,
            link_stats: LinkStats::default(),
            fault: None,
        }
    }

    pub fn blame(&mut self, fault: FrameFault) {
        self.link_stats.corrupt += 1;
        self.fault = Some(fault);
        self.seen.fill(false);
    }

    /// A frame ended here; if rows of it are missing, it was broken: whether it was.
    pub fn cut(&mut self) -> bool {
        let found = self.seen.iter().filter(|seen| **seen).count();
        if found > 0 {
            let expected = self.expected.rows;
            self.blame(FrameFault::Rows { found, expected });
        }
        found > 0
    }

    /// Takes a row, or several at once from `row` on, and hands on the frame if that was its last.
    pub fn put(&mut self, row: usize, counts: &[u64], take: &mut dyn FnMut(&Frame<Counts>)) {
        let largest = self.expected.max_count;
        if let Some(&found) = counts.iter().find(|count| **count > largest) {
            return self.blame(FrameFault::Range { found, largest });
        }
        let from = row * self.expected.columns;
        for (value, &count) in self.frame.values_mut()[from..].iter_mut().zip(counts) {
            *value = count as f64;
        }
        let rows = counts.len() / self.expected.columns;
        self.seen[row..row + rows].fill(true);
        if self.seen.iter().all(|seen| *seen) {
            // A broken frame leaves a gap.
            self.frame.sequence = self.link_stats.frames + self.link_stats.corrupt;
            self.link_stats.frames += 1;
            self.seen.fill(false);
            take(&self.frame);
        }
    }
}
