//! Errors of some conductances where others are no unknowns.

use crate::circuit::{NotPassive, OperatingPoint};
use crate::{Frame, Mark};

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

/// What was read of the eight taxels around one.
pub(super) fn read_around<'a, Q>(
    frame: &'a Frame<Q>,
    marks: &'a [Mark],
    taxel: usize,
) -> impl Iterator<Item = f64> + use<'a, Q> {
    let (rows, columns) = (frame.rows(), frame.columns());
    let (row, column) = (taxel / columns, taxel % columns);
    let near = (row.saturating_sub(1)..(row + 2).min(rows)).flat_map(move |r| {
        let line = column.saturating_sub(1)..(column + 2).min(columns);
        line.map(move |c| r * columns + c)
    });
    near.filter(move |&at| at != taxel && marks[at].is_reading())
        .map(|at| frame.values()[at])
}

/// Root mean square of what was read around a taxel less its own value; `None` where nothing was.
pub(super) fn scatter_around<Q>(frame: &Frame<Q>, marks: &[Mark], taxel: usize) -> Option<f64> {
    let own = frame.values()[taxel];
    let each = read_around(frame, marks, taxel).map(|value| (value - own).powi(2));
    let (sum, count) = each.fold((0.0, 0.0f64), |(sum, count), square| {
        (sum + square, count + 1.0)
    });
    (count > 0.0).then(|| (sum / count).sqrt())
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
