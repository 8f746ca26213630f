//! The e-Cone's text: R lines of C counts a frame, each closed by a comma; between frames nothing, or one line that is
//! no row (blank, a header, a time stamp).
//!
//! Rows have no index. A damaged line still counts as the row it was (one that swallowed its line end as several), so
//! that the next frame begins where it should; a blank line, or a pause in the stream, begins one in any case.

use taxel::{Counts, Frame};

use super::fields::{LineBuffer, Rows, counts};
use super::{Decoder, Expected, Fault, Tally};

/// Reads the e-Cone's text.
pub struct EconeText {
    buffer: LineBuffer,
    counts: Vec<u64>,
    rows: Rows,
    next: usize,
    damaged: bool,
}

impl EconeText {
    /// For frames of one sensor.
    pub fn new(expected: Expected) -> Self {
        Self {
            buffer: LineBuffer::new(expected.columns),
            counts: Vec::new(),
            rows: Rows::new(expected),
            next: 0,
            damaged: false,
        }
    }
}

impl Decoder for EconeText {
    fn feed(&mut self, bytes: &[u8], take: &mut dyn FnMut(&Frame<Counts>)) {
        let Self {
            buffer,
            counts: fields,
            rows,
            next,
            damaged,
        } = self;
        buffer.feed(bytes, &mut |line, _| {
            let numbers = line.is_some_and(|line| counts(line, fields));
            let Expected {
                rows: last,
                columns,
                ..
            } = rows.expected;
            if numbers && fields.len() == columns {
                match *damaged {
                    true => *next += 1,
                    false => {
                        rows.put(*next, fields, take);
                        // Whole, or refused for a count out of range.
                        let done = rows.seen.iter().all(|seen| !seen);
                        *damaged = done && *next + 1 < last;
                        *next += 1;
                    }
                }
            } else if line.is_some_and(|line| line.iter().all(u8::is_ascii_whitespace)) {
                rows.cut();
                (*next, *damaged) = (0, false);
            } else if *next > 0 {
                let commas = line.map_or(columns, |l| l.iter().filter(|b| **b == b',').count());
                *next += ((commas + columns / 2) / columns).max(1);
                if !std::mem::replace(damaged, true) {
                    rows.blame(Fault::Fields {
                        found: fields.len(),
                        columns,
                        taxels: rows.expected.taxels(),
                    });
                }
            }
            if *next >= last {
                (*next, *damaged) = (0, false);
            }
        });
    }

    fn forget(&mut self) {
        self.buffer.forget();
        self.rows.cut();
        self.next = 0;
        self.damaged = false;
    }

    fn tally(&self) -> Tally {
        self.rows.tally
    }

    fn last_fault(&self) -> Option<&Fault> {
        self.rows.fault.as_ref()
    }

    fn name(&self) -> &'static str {
        "econe-text"
    }
}
