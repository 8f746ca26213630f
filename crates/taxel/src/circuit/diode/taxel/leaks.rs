//! What leaks out of a row through its reverse diodes into grounded columns, against the row's potential.
//!
//! The columns are lifted by what all other rows, which float high, leak into them at the same time, times their ends.

use super::Paths;
use crate::circuit::diode::branch::{Branch, Current, Junction};

/// Points of a table: between them a cubic is off by 5e-7 of the leak, which is 0.06 of the signal at most.
const POINTS: usize = 32;

/// Of every row, the current into all columns, were they at ground: tabulated where n V_T is the scale near nothing, and ever wider
/// apart above.
pub(super) struct Leaks {
    /// Current and its derivative by the place in the table, row by row.
    values: Vec<[f64; 2]>,
    scale: f64,
    per_point: f64,
    /// Every taxel with its column's end in series, and what its column stands at for the other rows' leaks, volts.
    ways: Vec<(Branch, f64)>,
    floating_volts: f64,
    /// Of each column, from all rows, amperes.
    into_columns: Vec<f64>,
}

impl Leaks {
    pub(super) fn new(paths: &Paths) -> Self {
        let most = paths.drives.iter().copied().fold(0.0, f64::max);
        let scale = paths.junction.scale;
        Self {
            values: vec![[0.0; 2]; paths.rows * POINTS],
            scale,
            per_point: (most / scale).ln_1p() / (POINTS - 1) as f64,
            ways: vec![(Branch::default(), 0.0); paths.rows * paths.columns],
            // Rows that hang on nothing else float a few n V_T below the driven column; rows held at an end do not.
            floating_volts: if paths.ends.rows_open {
                0.9 * most
            } else {
                0.0
            },
            into_columns: vec![0.0; paths.columns],
        }
    }

    pub(super) fn set(&mut self, paths: &Paths, siemens: &[f64]) {
        let (junction, n) = (&paths.junction, paths.columns);
        let ends = &paths.ends.column_unselected;
        self.into_columns.fill(0.0);
        for (taxel, (way, &g)) in self.ways.iter_mut().zip(siemens).enumerate() {
            let g = paths.with_lines(taxel, g);
            let end = ends[taxel % n];
            *way = (Branch::new(junction, g * end / (g.max(0.0) + end)), 0.0);
            let leak = backwards(junction, &way.0, self.floating_volts).amperes;
            way.1 = -leak / end;
            self.into_columns[taxel % n] += leak;
        }
        for (taxel, way) in self.ways.iter_mut().enumerate() {
            way.1 += self.into_columns[taxel % n] / ends[taxel % n];
        }
        for (row, line) in self.ways.chunks_exact(n).enumerate() {
            let table = &mut self.values[row * POINTS..(row + 1) * POINTS];
            for (k, value) in table.iter_mut().enumerate() {
                let volts = self.scale * (k as f64 * self.per_point).exp_m1();
                let leak = into_columns(junction, line, volts);
                *value = [
                    leak.amperes,
                    leak.siemens * (volts + self.scale) * self.per_point,
                ];
            }
        }
    }

    /// Through one taxel alone, its row at a potential.
    #[inline]
    pub(super) fn of_one(&self, junction: &Junction, taxel: usize, volts: f64) -> Current {
        let (branch, lift) = &self.ways[taxel];
        backwards(junction, branch, volts - lift)
    }

    /// Of a row at a potential; below ground on a straight line.
    #[inline]
    pub(super) fn at(&self, row: usize, volts: f64) -> Current {
        if volts <= 0.0 {
            let [amperes, slope] = self.values[row * POINTS];
            let siemens = slope / (self.scale * self.per_point);
            return Current {
                amperes: amperes + siemens * volts,
                siemens,
            };
        }
        let place = (volts / self.scale).ln_1p() / self.per_point;
        let k = (place as usize).min(POINTS - 2);
        let x = place - k as f64;
        let [from, from_slope] = self.values[row * POINTS + k];
        let [to, to_slope] = self.values[row * POINTS + k + 1];
        // Hermite's cubic.
        let (rise, a) = (to - from, from_slope);
        let b = 3.0 * rise - 2.0 * from_slope - to_slope;
        let c = from_slope + to_slope - 2.0 * rise;
        Current {
            amperes: from + x * (a + x * (b + x * c)),
            siemens: (a + x * (2.0 * b + 3.0 * x * c)) / (self.per_point * (volts + self.scale)),
        }
    }
}

/// Through these taxels, backwards, into columns that are lifted.
fn into_columns(junction: &Junction, line: &[(Branch, f64)], volts: f64) -> Current {
    let mut sum = Current::default();
    for (branch, lift) in line {
        let one = backwards(junction, branch, volts - lift);
        sum.amperes += one.amperes;
        sum.siemens += one.siemens;
    }
    sum
}

/// Through one taxel, from its row at a potential above its column.
#[inline]
fn backwards(junction: &Junction, branch: &Branch, volts: f64) -> Current {
    let through = branch.at(junction, -volts);
    Current {
        amperes: -through.amperes,
        siemens: through.siemens,
    }
}
