//! Text lines, as most sketches print them: `v,v,…` a frame a line, or `row,v,v,…` a row a line.
//!
//! Commas, semicolons and blanks separate. Lines that begin with anything but a digit (`# ready`) are passed over, unless
//! most of them is numbers: those are damaged. A frame is complete when every row of it has come; a row that comes again,
//! or falls back, begins the next.

use std::time::Duration;

use taxel::{Counts, Frame};

use super::fields::{LineBuffer, Pace, Rows, counts, was_numbers};
use super::{Decoder, Expected, FrameFault, LinkStats};

/// Reads text lines.
pub struct Lines {
    buffer: LineBuffer,
    counts: Vec<u64>,
    rows: Rows,
    last_row: usize,
    /// A row of this frame was damaged: the rest of it is of no use.
    damaged: bool,
    pace: Pace,
}

impl Lines {
    /// For frames of one sensor.
    pub fn new(expected: Expected) -> Self {
        Self {
            buffer: LineBuffer::new(expected.taxels()),
            counts: Vec::new(),
            rows: Rows::new(expected),
            last_row: 0,
            damaged: false,
            pace: Pace::default(),
        }
    }

    /// What has begun will not be completed.
    fn give_up(&mut self) {
        let begun = self.buffer.forget();
        if !self.rows.cut() && begun {
            self.rows.blame(FrameFault::Broken {
                what: "a line that ended before its end",
            });
        }
        self.last_row = 0;
        self.damaged = false;
    }
}

/// Whether a line begins as numbers do.
fn is_meant(line: &[u8]) -> bool {
    line.first().is_some_and(u8::is_ascii_digit) || line.starts_with(b" ")
}

impl Decoder for Lines {
    fn feed(&mut self, bytes: &[u8], take: &mut dyn FnMut(&Frame<Counts>)) {
        let Self {
            buffer,
            counts: fields,
            rows,
            last_row,
            damaged,
            pace,
        } = self;
        buffer.feed(bytes, &mut |line, whole| {
            let Some(line) = line else {
                return rows.blame(FrameFault::Broken {
                    what: "a line longer than a frame of this sensor",
                });
            };
            let was_meant = whole && was_numbers(line, rows.expected.columns);
            if !is_meant(line) && !was_meant {
                rows.link_stats.passed_over += u64::from(!line.trim_ascii().is_empty());
                return;
            }
            let numbers = counts(line, fields);
            let Expected { columns, .. } = rows.expected;
            let taxels = rows.expected.taxels();
            if numbers && fields.len() == taxels {
                rows.cut();
                *damaged = false;
                rows.put(0, fields, take);
            } else if numbers
                && fields.len() == columns + 1
                && fields[0] < rows.expected.rows as u64
            {
                let row = fields[0] as usize;
                if rows.seen[row] || row < *last_row {
                    rows.cut();
                    *damaged = false;
                }
                if *damaged && row > *last_row {
                    return;
                }
                (*last_row, *damaged) = (row, false);
                rows.put(row, &fields[1..], take);
                if rows.seen.iter().all(|seen| !seen) {
                    *last_row = 0;
                }
            } else if whole {
                // Before the first line end it may have been the rest of a line.
                rows.blame(if numbers {
                    FrameFault::Fields {
                        found: fields.len(),
                        columns,
                        taxels,
                    }
                } else {
                    FrameFault::Broken {
                        what: "a line with something that is no count",
                    }
                });
                *damaged = true;
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
        "lines"
    }
}
