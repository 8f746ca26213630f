//! What readings at the converter's ceiling leave open about all others.

use super::conductance::{DEPTH, RESTARTS};
use super::known::Known;
use crate::Mark;
use crate::circuit::OperatingPoint;
use crate::solve::gmres::Gmres;

/// What a conductance at the ceiling may be larger by than its bound, as one standard error: a 95 % interval then reaches to
/// about twice the bound.
const SHARE_ABOVE: f64 = 0.5;
/// How exactly, of the norm of what is moved.
const TOLERANCE: f64 = 1e-3;

/// The error of conductances that stand in a frame with readings at the ceiling, of which only a lower bound is known. All
/// may be larger at once, and the others are what explains their own readings beside that: J_oo x = −J_os δ, with o the
/// others, s those at the ceiling and δ what these are larger by.
pub(super) struct AtCeiling {
    gmres: Gmres,
    direction: Vec<f64>,
    moved: Vec<f64>,
    error: Vec<f64>,
}

impl AtCeiling {
    pub(super) fn new(taxels: usize) -> Self {
        Self {
            gmres: Gmres::new(taxels, DEPTH.min(taxels)),
            direction: vec![0.0; taxels],
            moved: vec![0.0; taxels],
            error: vec![0.0; taxels],
        }
    }

    /// One standard error a taxel, siemens, with a sign: what it would be, less what it was found to be. `known` leaves out
    /// the taxels at the ceiling, too, and its point is set to the conductances found.
    pub(super) fn errors(&mut self, known: &mut Known, siemens: &[f64], marks: &[Mark]) -> &[f64] {
        for ((above, mark), value) in self.direction.iter_mut().zip(marks).zip(siemens) {
            *above = match mark {
                Mark::Saturated => SHARE_ABOVE * value.abs(),
                _ => 0.0,
            };
        }
        known.point.jvp_into(&self.direction, &mut self.moved);
        for (moved, known) in self.moved.iter_mut().zip(known.is_known) {
            *moved = if *known { 0.0 } else { -*moved };
        }
        self.gmres.solve(
            |v, out| known.jvp_into(v, out),
            &self.moved,
            &mut self.error,
            TOLERANCE,
            RESTARTS,
        );
        &self.error
    }
}
