//! How much of an unloaded taxel's current reaches the read-out.

use crate::circuit::LineEnds;
use crate::{Frame, Siemens};

/// The share of an unloaded taxel's current that reaches the read-out, in its frame: what its lines' other
/// taxels leave of the drive and of the current. Noise in grams grows by its inverse, so ghosts are weighed
/// with it; otherwise the fit would prefer the circuit that amplifies noise least.
pub(super) fn transfers(ends: &LineEnds, siemens: &Frame<Siemens>) -> impl Fn(usize) -> f64 {
    let (rows, columns) = (siemens.rows(), siemens.columns());
    let (mut row, mut column) = (vec![0.0; rows], vec![0.0; columns]);
    for (sum, line) in row.iter_mut().zip(siemens.values().chunks_exact(columns)) {
        *sum = taxel_linalg::sum(line);
        column.iter_mut().zip(line).for_each(|(sum, g)| *sum += g);
    }
    for (sum, end) in row.iter_mut().zip(&ends.row_selected) {
        *sum = 1.0 / (1.0 + sum.max(0.0) / end);
    }
    for (sum, end) in column.iter_mut().zip(&ends.column_selected) {
        *sum = 1.0 / (1.0 + sum.max(0.0) / end);
    }
    move |t| row[t / columns] * column[t % columns]
}
