//! What readings that are no more than a bound, or none, leave open about all others.

use super::conductance::{DEPTH, RESTARTS};
use super::detached::Detached;
use super::known::{Known, scatter_around};
use crate::circuit::OperatingPoint;
use crate::solve::gmres::Gmres;
use crate::{Frame, Mark, Siemens};

/// What a conductance at the ceiling may be larger by than its bound, as one standard error: a 95 % interval then reaches to
/// about twice the bound.
const SHARE_ABOVE: f64 = 0.5;
/// How exactly, of the norm of what is moved.
const TOLERANCE: f64 = 1e-3;

/// The error of conductances that stand in a frame with readings at the ceiling, of which only a lower bound is known, or, where
/// lines are left open, with lost ones. The others are what explains their own readings beside that: J_oo x = −J_os δ, with o
/// the others, s those without a reading and δ what these are off by. All at the ceiling may be larger at once; lost ones
/// are off each by itself, by as much as those around differ from what stands for them.
pub(super) struct Unmeasured {
    /// Where lost readings and lines that are out count: where lines are not left open they tell little of others.
    detached: Option<Detached>,
    gmres: Gmres,
    direction: Vec<f64>,
    moved: Vec<f64>,
    error: Vec<f64>,
    squares: Vec<f64>,
}

impl Unmeasured {
    pub(super) fn new(taxels: usize, with_lost: bool) -> Self {
        Self {
            detached: with_lost.then(|| Detached::new(taxels)),
            gmres: Gmres::new(taxels, DEPTH.min(taxels)),
            direction: vec![0.0; taxels],
            moved: vec![0.0; taxels],
            error: vec![0.0; taxels],
            squares: vec![0.0; taxels],
        }
    }

    /// The square of one standard error a taxel, siemens². `known` leaves out the taxels without a reading, and its point is
    /// set to the conductances found.
    pub(super) fn squares(
        &mut self,
        known: &mut Known,
        siemens: &Frame<Siemens>,
        marks: &[Mark],
    ) -> &[f64] {
        self.squares.fill(0.0);
        if marks.contains(&Mark::Saturated) {
            let each = self.direction.iter_mut().zip(marks).zip(siemens.values());
            for ((above, mark), value) in each {
                *above = match mark {
                    Mark::Saturated => SHARE_ABOVE * value.abs(),
                    _ => 0.0,
                };
            }
            self.add(known);
        }
        if self.detached.is_some() {
            for taxel in (0..marks.len()).filter(|&taxel| is_lost(marks[taxel])) {
                self.direction.fill(0.0);
                self.direction[taxel] = off(siemens, marks, taxel);
                self.add(known);
            }
        }
        if let Some(detached) = &mut self.detached {
            detached.look_at(known.point, siemens);
            for volts in detached.moves() {
                self.moved.copy_from_slice(volts);
                undo(known, &mut self.gmres, &mut self.moved, &mut self.error);
                add_squares(&mut self.squares, &self.error);
            }
        }
        &self.squares
    }

    /// What the others are off by where those without a reading are off by `direction`.
    fn add(&mut self, known: &mut Known) {
        known.point.jvp_into(&self.direction, &mut self.moved);
        undo(known, &mut self.gmres, &mut self.moved, &mut self.error);
        add_squares(&mut self.squares, &self.error);
    }
}

/// What the others are off by where readings are by what moved.
fn undo(known: &mut Known, gmres: &mut Gmres, moved: &mut [f64], error: &mut [f64]) {
    for (moved, known) in moved.iter_mut().zip(known.is_known) {
        *moved = if *known { 0.0 } else { -*moved };
    }
    gmres.solve(
        |v, out| known.jvp_into(v, out),
        moved,
        error,
        TOLERANCE,
        RESTARTS,
    );
}

fn add_squares(squares: &mut [f64], errors: &[f64]) {
    for (square, error) in squares.iter_mut().zip(errors) {
        *square += error * error;
    }
}

/// Whether a single reading is none, repaired or not.
fn is_lost(mark: Mark) -> bool {
    mark.is_stray() || mark == Mark::Interpolated
}

/// What the conductances around a taxel differ from its own by; its own where none was read.
fn off(siemens: &Frame<Siemens>, marks: &[Mark], taxel: usize) -> f64 {
    scatter_around(siemens, marks, taxel).unwrap_or(siemens.values()[taxel].abs())
}
