//! Lines of a byte stream through one bounded buffer.

use std::io::{self, ErrorKind, Read};

use crate::plain::{self, Kept};

/// Bytes that are read at once, until a line needs more.
const FIRST_BUFFER: usize = 64 * 1024;
/// Bytes of the buffer before all lines and behind them that are no line's: whoever reads several at a time may look at them.
const BEFORE: usize = plain::BEFORE;
const BEHIND: usize = plain::BEHIND;
/// A line is read to its end to go on behind it, but not for ever: a device may have no line ends at all.
const MAX_GONE: u64 = 64 << 20;

/// What the stream gave.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Line {
    /// A line without its line end: bytes `from..to` of the buffer. `closed` when a line feed followed.
    Text {
        from: usize,
        to: usize,
        closed: bool,
    },
    /// A line above the limit; it is gone.
    TooLong { bytes: u64 },
    /// Nothing more.
    End,
}

/// A stream cut into lines; holds no more than one line and one read.
pub(crate) struct Lines<R> {
    reader: R,
    buffer: Vec<u8>,
    start: usize,
    end: usize,
    limit: usize,
    number: u64,
    bytes: u64,
    ended: bool,
    last: Line,
    again: bool,
}

impl<R: Read> Lines<R> {
    /// Lines of at most `limit` bytes.
    pub(crate) fn new(reader: R, limit: usize) -> Self {
        Self {
            reader,
            buffer: vec![0; FIRST_BUFFER],
            start: BEFORE,
            end: BEFORE,
            limit,
            number: 0,
            bytes: 0,
            ended: false,
            last: Line::End,
            again: false,
        }
    }

    /// Number of the line given last, from 1; 0 before the first.
    pub(crate) fn number(&self) -> u64 {
        self.number
    }

    /// Bytes of the lines given so far.
    pub(crate) fn bytes(&self) -> u64 {
        self.bytes
    }

    /// The longest line allowed, bytes.
    pub(crate) fn limit(&self) -> usize {
        self.limit
    }

    /// The bytes of the line given last.
    pub(crate) fn text(&self, line: Line) -> &[u8] {
        match line {
            Line::Text { from, to, .. } => &self.buffer[from..to],
            Line::TooLong { .. } | Line::End => &[],
        }
    }

    /// The same with all that is held behind them, or was.
    pub(crate) fn text_on(&self, line: Line) -> &[u8] {
        match line {
            Line::Text { from, .. } => &self.buffer[from..],
            Line::TooLong { .. } | Line::End => &[],
        }
    }

    /// Reads a line of plain numbers, see [`plain::read_line`]; false of every other.
    pub(crate) fn read_plain<T: Kept>(&self, line: Line, out: &mut [T], most: T) -> bool {
        let Line::Text { from, to, .. } = line else {
            return false;
        };
        plain::read_line(&self.buffer, from..to, out, most)
    }

    /// Reads a line of plain cells, see [`plain::read_cells`]; false of every other.
    pub(crate) fn read_cells(&self, line: Line, part: u8, out: &mut [f64]) -> bool {
        let Line::Text { from, to, .. } = line else {
            return false;
        };
        plain::read_cells(&self.buffer, from..to, part, out)
    }

    /// The bytes that are held of the lines that come next, and what they were read from. `None` where the line given last is to
    /// come once more.
    pub(crate) fn held(&mut self) -> Option<(&[u8], &mut R)> {
        (!self.again).then_some((&self.buffer[self.start..self.end], &mut self.reader))
    }

    /// Goes past lines of all in all so many bytes that were read elsewhere; what was held and read behind them, piece by
    /// piece, comes next.
    pub(crate) fn put_back<'a>(
        &mut self,
        bytes: usize,
        lines: usize,
        rest: impl Iterator<Item = &'a [u8]>,
    ) {
        (self.start, self.end) = (BEFORE, BEFORE);
        for piece in rest {
            let begin = self.end;
            self.end += piece.len();
            // What is there is written over, not cleared first.
            if self.buffer.len() < self.end + BEHIND {
                self.buffer.resize(self.end + BEHIND, 0);
            }
            self.buffer[begin..self.end].copy_from_slice(piece);
        }
        self.bytes += bytes as u64;
        self.number += lines as u64;
        self.last = Line::End;
    }

    /// Has the next call give the line given last once more.
    pub(crate) fn unread(&mut self) {
        if self.last != Line::End && !self.again {
            self.again = true;
            self.number -= 1;
        }
    }

    /// The next line.
    pub(crate) fn next(&mut self) -> io::Result<Line> {
        if self.again {
            self.again = false;
            self.number += 1;
            return Ok(self.last);
        }
        self.last = self.find()?;
        if self.last != Line::End {
            self.number += 1;
        }
        Ok(self.last)
    }

    fn find(&mut self) -> io::Result<Line> {
        let mut searched = self.start;
        loop {
            if let Some(offset) = memchr::memchr(b'\n', &self.buffer[searched..self.end]) {
                return Ok(self.take(searched + offset, true));
            }
            if self.end - self.start > self.limit {
                return self.discard();
            }
            let held = self.end - self.start;
            if self.ended {
                return Ok(match held {
                    0 => Line::End,
                    _ => self.take(self.end, false),
                });
            }
            self.fill()?;
            searched = self.start + held;
        }
    }

    /// The line from `start` to `to`, where its line feed is, or the end.
    fn take(&mut self, to: usize, closed: bool) -> Line {
        let mut from = self.start;
        self.start = to + usize::from(closed);
        self.bytes += (self.start - from) as u64;
        let text = &self.buffer[from..to];
        if text.len() > self.limit {
            return Line::TooLong {
                bytes: text.len() as u64,
            };
        }
        // Programs that put a carriage return before each line feed do so twice where one was there.
        let returns = text.iter().rev().take_while(|byte| **byte == b'\r');
        let to = to - returns.count();
        if self.number == 0 && text.starts_with(b"\xEF\xBB\xBF") {
            from += 3;
        }
        Line::Text { from, to, closed }
    }

    /// Drops the rest of a line that is too long; one that does not end is no text.
    fn discard(&mut self) -> io::Result<Line> {
        let mut bytes = 0u64;
        loop {
            if bytes > MAX_GONE {
                let why = format!("a line that does not end in {bytes} bytes: this is no text");
                return Err(io::Error::new(ErrorKind::InvalidData, why));
            }
            let held = &self.buffer[self.start..self.end];
            let stop = memchr::memchr(b'\n', held);
            let gone = &held[..stop.unwrap_or(held.len())];
            bytes += gone.len() as u64;
            let used = gone.len() + usize::from(stop.is_some());
            self.bytes += used as u64;
            self.start += used;
            if stop.is_some() || (self.ended && self.start == self.end) {
                return Ok(Line::TooLong { bytes });
            }
            self.fill()?;
        }
    }

    /// Reads once more behind what is held.
    fn fill(&mut self) -> io::Result<()> {
        if self.start > BEFORE {
            self.buffer.copy_within(self.start..self.end, BEFORE);
            self.end -= self.start - BEFORE;
            self.start = BEFORE;
        }
        if self.end == self.buffer.len() - BEHIND {
            // Only reached with at most `limit` bytes held, so this is bounded.
            let length = self.buffer.len() * 2;
            self.buffer.resize(length, 0);
        }
        let room = self.buffer.len() - BEHIND;
        let read = read_some(&mut self.reader, &mut self.buffer[self.end..room])?;
        self.ended = read == 0;
        self.end += read;
        Ok(())
    }
}

/// Reads once; 0 at the end.
pub(crate) fn read_some(reader: &mut impl Read, out: &mut [u8]) -> io::Result<usize> {
    loop {
        match reader.read(out) {
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            read => return read,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Gives one byte a read, the worst case of a slow pipe.
    struct Trickle<'a>(&'a [u8]);

    impl Read for Trickle<'_> {
        fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
            let n = self.0.len().min(1).min(out.len());
            out[..n].copy_from_slice(&self.0[..n]);
            self.0 = &self.0[n..];
            Ok(n)
        }
    }

    fn all(bytes: &[u8], limit: usize) -> Vec<String> {
        let mut lines = Lines::new(Trickle(bytes), limit);
        let mut out = Vec::new();
        loop {
            let line = lines.next().unwrap();
            match line {
                Line::End => return out,
                Line::TooLong { bytes } => out.push(format!("<{bytes}>")),
                Line::Text { .. } => out.push(String::from_utf8_lossy(lines.text(line)).into()),
            }
        }
    }

    #[test]
    fn every_kind_of_line_end_and_a_byte_order_mark() {
        assert_eq!(all(b"\xEF\xBB\xBF1,2\r\n\n3", 10), ["1,2", "", "3"]);
        assert_eq!(all(b"1\r\r\n\r\r\n2\r\r", 10), ["1", "", "2"]);
        assert_eq!(all(b"", 10), [] as [&str; 0]);
        assert_eq!(all(b"\n", 10), [""]);
    }

    #[test]
    fn a_line_above_the_limit_is_dropped_whole() {
        assert_eq!(all(b"1,2,3,4,5\n6\n", 4), ["<9>", "6"]);
        assert_eq!(all(b"1,2,3,4,5", 4), ["<9>"]);
    }

    #[test]
    fn a_line_without_end_is_given_up() {
        let mut lines = Lines::new(io::repeat(b'0'), 1000);
        let error = lines.next().unwrap_err();
        assert!(error.to_string().contains("does not end"), "{error}");
        assert!(lines.buffer.len() <= FIRST_BUFFER);
    }

    #[test]
    fn an_unread_line_comes_again_with_its_number() {
        let mut lines = Lines::new(&b"a\nb\n"[..], 10);
        lines.next().unwrap();
        lines.unread();
        assert_eq!(lines.number(), 0);
        let line = lines.next().unwrap();
        assert_eq!((lines.text(line), lines.number()), (&b"a"[..], 1));
        assert_eq!(lines.bytes(), 2);
    }
}
