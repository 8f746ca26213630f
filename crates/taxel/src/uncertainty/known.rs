//! Errors of some conductances where others are no unknowns.

use crate::Mark;
use crate::circuit::{NotPassive, OperatingPoint};

/// A circuit some of whose conductances are no unknowns, nor their readings used: absent taxels, and those taken to be
/// unloaded because they read less than is recorded. Each moves its own reading alone, which leaves the others' errors to
/// the others.
pub(crate) struct Known<'a> {
    pub(crate) point: &'a mut dyn OperatingPoint,
    pub(crate) is_known: &'a [bool],
    /// Scratch, a number a taxel.
    pub(crate) moved: &'a mut [f64],
}

/// Whether a taxel is no unknown: it is known, or not measured, and left out of the system by those who solve it. A line
/// that hangs on nothing else would make the errors of all others what they are not.
pub(crate) fn is_left_out(mark: Mark) -> bool {
    mark.is_no_unknown() || !mark.is_measured()
}

impl Known<'_> {
    fn moving(&mut self, direction: &[f64], out: &mut [f64], adjoint: bool) {
        for ((moved, value), known) in self.moved.iter_mut().zip(direction).zip(self.is_known) {
            *moved = if *known { 0.0 } else { *value };
        }
        if adjoint {
            self.point.vjp_into(self.moved, out);
        } else {
            self.point.jvp_into(self.moved, out);
        }
        for ((out, value), known) in out.iter_mut().zip(direction).zip(self.is_known) {
            if *known {
                *out = *value;
            }
        }
    }
}

impl OperatingPoint for Known<'_> {
    fn set(&mut self, siemens: &[f64]) -> Result<(), NotPassive> {
        self.point.set(siemens)
    }
    fn predict_into(&self, volts: &mut [f64]) {
        self.point.predict_into(volts);
    }
    fn jvp_into(&mut self, direction: &[f64], out: &mut [f64]) {
        self.moving(direction, out, false);
    }
    fn vjp_into(&mut self, weights: &[f64], out: &mut [f64]) {
        self.moving(weights, out, true);
    }
}
