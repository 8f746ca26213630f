//! Taxels that are no unknowns: absent ones, and those whose reading is only known to be at most the floor.
//!
//! The second are taken to be unloaded: of all conductances that read so little it is the likeliest, and the others come out as
//! right as where each is moved until it reads no more than the floor.

use super::SolverState;
use crate::Mark;

impl SolverState {
    /// Reads off a frame's marks what is no unknown, and what that conducts.
    pub(super) fn take_marks(&mut self, marks: &[Mark], columns: usize, unloaded_siemens: f64) {
        self.live.gather(marks, columns, &mut self.marks);
        let known = self.held.iter_mut().zip(&mut self.rest);
        for ((held, rest), mark) in known.zip(&self.marks) {
            *held = mark.is_no_unknown();
            *rest = match mark {
                Mark::BelowFloor => unloaded_siemens,
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
}
