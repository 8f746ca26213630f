//! What leaks out of a row through its reverse diodes into grounded columns, against the row's potential.
//!
//! The columns are lifted by what all other rows, which float high, leak into them at the same time, times their ends.

use super::Paths;
use crate::circuit::diode::branch::{Branch, Current, Junction};

/// Points of a table, and from which I_s on more: a leak bends where its taxel's drop, I_s/g, reaches the row's potential, which is
/// nowhere with silicon, and anywhere with Schottky diodes; then points stand half of n V_T apart.
const POINTS: usize = 32;
const STRONG_AMPERES: f64 = 1e-8;
const MOST_POINTS: usize = 1024;

/// Of every row, the current into all columns, were they at ground: tabulated where n V_T is the scale near nothing, and ever wider
/// apart above.
pub(super) struct Leaks {
    /// Current and its derivative by the place in the table, row by row.
    values: Vec<[f64; 2]>,
    points: usize,
    scale: f64,
    /// Whether points are as far apart everywhere, and their distance: volts, or the logarithm of volts over the scale and one.
    is_even: bool,
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
        let is_even = paths.junction.saturation > STRONG_AMPERES;
        let points = if is_even {
            ((2.0 * most / scale) as usize).clamp(POINTS, MOST_POINTS)
        } else {
            POINTS
        };
        let range = if is_even {
            most
        } else {
            (most / scale).ln_1p()
        };
        Self {
            values: vec![[0.0; 2]; paths.rows * points],
            points,
            scale,
            is_even,
            per_point: range / (points - 1) as f64,
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
            let table = &mut self.values[row * self.points..(row + 1) * self.points];
            for (k, value) in table.iter_mut().enumerate() {
                let at = k as f64 * self.per_point;
                let (volts, stretch) = if self.is_even {
                    (at, 1.0)
                } else {
                    (self.scale * at.exp_m1(), self.scale * at.exp())
                };
                let leak = into_columns(junction, line, volts);
                *value = [leak.amperes, leak.siemens * stretch * self.per_point];
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
        let table = &self.values[row * self.points..(row + 1) * self.points];
        let (place, stretch) = if self.is_even {
            (volts / self.per_point, 1.0)
        } else {
            let place = (volts.max(0.0) / self.scale).ln_1p() / self.per_point;
            (place, volts.max(0.0) + self.scale)
        };
        if volts <= 0.0 {
            let [amperes, slope] = table[0];
            let siemens = slope / (stretch * self.per_point);
            return Current {
                amperes: amperes + siemens * volts,
                siemens,
            };
        }
        let k = (place as usize).min(self.points - 2);
        let x = place - k as f64;
        let [from, from_slope] = table[k];
        let [to, to_slope] = table[k + 1];
        // Hermite's cubic.
        let (rise, a) = (to - from, from_slope);
        let b = 3.0 * rise - 2.0 * from_slope - to_slope;
        let c = from_slope + to_slope - 2.0 * rise;
        Current {
            amperes: from + x * (a + x * (b + x * c)),
            siemens: (a + x * (2.0 * b + 3.0 * x * c)) / (self.per_point * stretch),
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
