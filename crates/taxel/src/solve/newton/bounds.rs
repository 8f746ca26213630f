//! Taxels that are no unknowns: absent ones, and those whose reading is only known to be at most the floor.
//!
//! Such a taxel is taken to be unloaded. Where that alone would read more than the floor, it is taken to read just as
//! much; where that then needs more than an unloaded taxel conducts, it is taken to be unloaded again. Of all
//! conductances that explain the frame these are the nearest to an unloaded one.

use super::{Newton, Outcome, SolverState};
use crate::Mark;

/// Rounds in which bounds may be taken up or given up; after these they are only taken up, so that it ends.
const FREE_ROUNDS: u32 = 6;
const MAX_ROUNDS: u32 = 20;
/// A reading exceeds its bound by more than this share of the bound.
const TOLERANCE: f64 = 1e-6;

impl Newton {
    /// Newton's iteration, again for as long as a reading that has a bound exceeds it.
    pub(super) fn within_bounds(&self, state: &mut SolverState, volts: &[f64]) -> Outcome {
        let columns = self.circuit.ends().column_selected.len();
        let mut iterations = 0;
        for round in 0.. {
            state.take_volts(volts, columns);
            let mut outcome = self.iterate(state);
            iterations += outcome.iterations;
            outcome.iterations = iterations;
            if !outcome.stop.is_good()
                || round == MAX_ROUNDS
                || !state.move_bounds(round < FREE_ROUNDS)
            {
                return outcome;
            }
            state.warm = true;
        }
        unreachable!("the last round returns")
    }
}

impl SolverState {
    /// Reads off a frame's marks what is no unknown, and what that conducts. Bounds that were taken up in the frame before
    /// are taken up again where they still are bounds.
    pub(super) fn take_marks(&mut self, marks: &[Mark], columns: usize, unloaded_siemens: f64) {
        self.live.gather(marks, columns, &mut self.marks);
        for (at, mark) in self.marks.iter().enumerate() {
            self.bounded[at] = *mark == Mark::BelowFloor;
            self.at_bound[at] &= self.bounded[at] && self.warm;
            self.held[at] = *mark == Mark::Absent || self.bounded[at] && !self.at_bound[at];
            self.rest[at] = if self.bounded[at] {
                unloaded_siemens
            } else {
                0.0
            };
        }
    }

    /// The volts of the unknowns, and every bound.
    fn take_volts(&mut self, volts: &[f64], columns: usize) {
        self.live.gather(volts, columns, &mut self.measured);
        if self.bounded.contains(&true)
            && let Some(path) = &self.path
        {
            self.bound.copy_from_slice(&self.measured);
            path.apparent(&mut self.bound, &mut self.slope);
        }
        for (measured, held) in self.measured.iter_mut().zip(&self.held) {
            if *held {
                *measured = 0.0;
            }
        }
    }

    /// Takes up the bounds that the answer exceeds, and gives up those that nothing presses against, if it may. True when
    /// that changes anything.
    fn move_bounds(&mut self, may_give_up: bool) -> bool {
        if !self.bounded.contains(&true) {
            return false;
        }
        self.trial.copy_from_slice(&self.g);
        if self.evaluate().is_none() {
            return false;
        }
        let mut changed = false;
        for at in 0..self.g.len() {
            if !self.bounded[at] {
                continue;
            }
            let exceeds = self.found[at] > self.bound[at] * (1.0 + TOLERANCE);
            let is_slack = self.g[at] > self.rest[at];
            let at_bound = if self.at_bound[at] {
                !(is_slack && may_give_up)
            } else {
                exceeds
            };
            changed |= at_bound != self.at_bound[at];
            self.at_bound[at] = at_bound;
            self.held[at] = !at_bound;
        }
        changed
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
