//! Taxels that are no unknowns: absent ones, and those whose reading is only known to be at most the floor.
//!
//! The second are taken to be unloaded: of all conductances that read so little it is the likeliest, and the others come out as
//! right as where each is moved until it reads no more than the floor.
//!
//! Where columns are left open a lost reading (stuck, a spike) is held as well: every other reading has what it conducts in
//! it, and a reading put in its place would have the answer bend to it. First it is taken to be unloaded, then to
//! conduct what those around it do.

use super::SolverState;
use crate::Mark;
use crate::stats::median_high;

impl SolverState {
    /// Reads off a frame's marks what is no unknown, and what that conducts.
    pub(super) fn take_marks(
        &mut self,
        marks: &[Mark],
        columns: usize,
        (unloaded_siemens, holds_lost): (f64, bool),
    ) {
        self.live.gather(marks, columns, &mut self.marks);
        let known = self.held.iter_mut().zip(&mut self.rest);
        for ((held, rest), mark) in known.zip(&self.marks) {
            *held = mark.is_no_unknown() || holds_lost && mark.is_stray();
            *rest = match mark {
                Mark::BelowFloor | Mark::Stuck | Mark::Spike => unloaded_siemens,
                _ => 0.0,
            };
        }
    }

    /// The volts of the unknowns; of the others nothing.
    pub(super) fn take_volts(&mut self, volts: &[f64], columns: usize) {
        self.live.gather(volts, columns, &mut self.measured);
        for (measured, held) in self.measured.iter_mut().zip(&self.held) {
            if *held {
                *measured = 0.0;
            }
        }
    }

    /// Every unknown at nothing.
    pub(super) fn start_at_rest(&mut self) {
        self.g.fill(0.0);
        self.hold_at_rest();
    }

    /// What is held where it is.
    pub(super) fn hold_at_rest(&mut self) {
        for ((g, held), rest) in self.g.iter_mut().zip(&self.held).zip(&self.rest) {
            if *held {
                *g = *rest;
            }
        }
    }

    /// Lets taxels without a reading conduct what those around them do in the answer found; whether there are any.
    pub(super) fn rest_as_around(&mut self) -> bool {
        let columns = self.live.columns.len();
        let mut any = false;
        for at in 0..self.g.len() {
            if !(self.held[at] && self.marks[at].is_stray()) {
                continue;
            }
            let (row, column) = (at / columns, at % columns);
            let (mut around, mut count) = ([0.0; 8], 0);
            for r in row.saturating_sub(1)..(row + 2).min(self.live.rows.len()) {
                for c in column.saturating_sub(1)..(column + 2).min(columns) {
                    if !self.held[r * columns + c] {
                        around[count] = self.g[r * columns + c];
                        count += 1;
                    }
                }
            }
            if let Some(middle) = median_high(&mut around[..count]) {
                self.rest[at] = middle.max(0.0);
                any = true;
            }
        }
        any
    }
}
