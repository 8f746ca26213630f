//! The e-Cone's text: R lines of C counts a frame, each closed by a comma; between frames nothing, or one line that is
//! no row (blank, a header, a time stamp).
//!
//! Rows have no index. A damaged line still counts as the row it was (one that swallowed its line end as several), so
//! that the next frame begins where it should; a blank line, a pause in the stream, or a header where frames had one
//! before, begins one in any case. Of datagrams, of which some may be lost, one that comes late begins one too: a frame
//! in several needs a pause, a blank line or a header behind it, or a lost one shifts its rows.

use std::time::Duration;

use taxel::{Counts, Frame};

use super::fields::{LineBuffer, Pace, Rows, counts, was_numbers};
use super::{Decoder, Expected, FrameFault, LinkStats};

/// Reads the e-Cone's text.
pub struct EconeText {
    buffer: LineBuffer,
    counts: Vec<u64>,
    rows: Rows,
    next: usize,
    damaged: bool,
    /// A header stands before the frame that comes; one stood before the frame that came last.
    header: bool,
    headed: bool,
    pace: Pace,
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
            header: false,
            headed: false,
            pace: Pace::default(),
        }
    }

    /// What has begun will not be completed.
    fn give_up(&mut self) {
        let begun = self.buffer.forget();
        if !self.rows.cut() && begun && !self.damaged {
            self.rows.blame(FrameFault::Broken {
                what: "a line that ended before its end",
            });
        }
        self.next = 0;
        self.damaged = false;
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
            header,
            headed,
            pace,
        } = self;
        buffer.feed(bytes, &mut |line, whole| {
            let numbers = line.is_some_and(|line| counts(line, fields));
            let Expected {
                rows: last,
                columns,
                ..
            } = rows.expected;
            if numbers && fields.len() == columns {
                if *damaged {
                    *next += 1
                } else {
                    rows.put(*next, fields, take);
                    // Whole, or refused for a count out of range.
                    let done = rows.seen.iter().all(|seen| !seen);
                    *damaged = done && *next + 1 < last;
                    *next += 1;
                }
            } else if line.is_some_and(|line| line.iter().all(u8::is_ascii_whitespace)) {
                rows.cut();
                (*next, *damaged) = (0, false);
            } else if line.is_some_and(|line| !was_numbers(line, columns))
                && (*next == 0 || *headed)
            {
                // A header: rows that are missing before it do not come any more.
                *header = true;
                rows.link_stats.passed_over += 1;
                rows.cut();
                (*next, *damaged) = (0, false);
            } else if *next > 0 || whole {
                let commas = line.map_or(columns, |l| l.iter().filter(|b| **b == b',').count());
                *next += ((commas + columns / 2) / columns).max(1);
                if !std::mem::replace(damaged, true) {
                    rows.blame(FrameFault::Fields {
                        found: fields.len(),
                        columns,
                        taxels: rows.expected.taxels(),
                    });
                }
            }
            if *next >= last {
                (*next, *damaged) = (0, false);
                *headed = std::mem::take(header);
            }
        });
        pace.frames(rows.link_stats.frames);
    }

    fn forget(&mut self) {
        self.give_up();
    }

    fn datagram(&mut self, after: Duration) {
        if self.pace.datagram(after) {
            self.give_up();
        }
    }

    fn link_stats(&self) -> LinkStats {
        self.rows.link_stats
    }

    fn last_fault(&self) -> Option<&FrameFault> {
        self.rows.fault.as_ref()
    }

    fn name(&self) -> &'static str {
        "econe-text"
    }
}
