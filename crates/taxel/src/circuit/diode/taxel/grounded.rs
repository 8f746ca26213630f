//! The currents beside the taxels' own where unselected columns are held at ground.
//!
//! Every row that is not read is one equation of its own potential: what comes in through the driven column's taxel leaves
//! through reverse diodes to ground, and by the row's end.

use super::Paths;
use super::currents::Beside;
use super::leaks::Leaks;
use crate::circuit::diode::branch::{Branch, Current};

pub(super) struct Grounded {
    branches: Vec<Branch>,
    leaks: Leaks,
    /// Potential of each row while each column is driven and the row is not read, volts.
    floats: Vec<f64>,
    /// What each column feeds into each row then, and its derivative by the column's potential.
    feeds: Vec<Current>,
    /// The driven column's potential at which that holds, and the sum of its feeds.
    columns: Vec<(f64, Current)>,
    /// What all feeds of a column but a row's drop along the line on the way to that row, volts; nothing where lines do not resist.
    drops: Vec<f64>,
}

/// Rounds of a row's equation, and of a column's.
const ROUNDS: usize = 60;
const COLUMN_ROUNDS: usize = 12;
/// Accuracy of what a row draws: where rows are held alike it is all of the current, else a leak.
const ACCURACY: f64 = 1e-14;
const LEAK_ACCURACY: f64 = 1e-8;

impl Grounded {
    pub(super) fn new(paths: &Paths) -> Self {
        let taxels = paths.rows * paths.columns;
        Self {
            branches: vec![Branch::default(); taxels],
            leaks: Leaks::new(paths),
            floats: vec![f64::NAN; taxels],
            feeds: vec![Current::default(); taxels],
            columns: vec![(0.0, Current::default()); paths.columns],
            drops: vec![0.0; taxels],
        }
    }

    /// Finds what flows beside the taxels' own currents. Where rows are held alike and `is_read`, readings tell what a column feeds.
    pub(super) fn set(&mut self, paths: &Paths, siemens: &[f64], is_read: bool) {
        for (taxel, (branch, g)) in self.branches.iter_mut().zip(siemens).enumerate() {
            *branch = Branch::new(&paths.junction, paths.with_lines(taxel, *g));
        }
        self.leaks.set(paths, siemens);
        if is_read && paths.rows_alike {
            return;
        }
        for c in 0..paths.columns {
            self.drive(paths, c);
            self.find_drops(paths, c);
        }
    }

    /// Finds the potential of a driven column whose rows are all held as those that are not read.
    fn drive(&mut self, paths: &Paths, c: usize) {
        let (u, g_cs) = (paths.drives[c], paths.ends.column_selected[c]);
        let mut v = u;
        let mut sum = Current::default();
        for _ in 0..COLUMN_ROUNDS {
            sum = Current::default();
            for r in 0..paths.rows {
                let one = self.feed(paths, r, c, v);
                sum.amperes += one.amperes;
                sum.siemens += one.siemens;
            }
            let step = (g_cs * (u - v) - sum.amperes) / (g_cs + sum.siemens);
            v = (v + step).clamp(0.0, u);
            sum.amperes += sum.siemens * step;
            if step.abs() <= 1e-13 * u {
                break;
            }
        }
        self.columns[c] = (v, sum);
    }

    /// What column c at a potential feeds into a row that is not read.
    fn feed(&mut self, paths: &Paths, r: usize, c: usize, column_volts: f64) -> Current {
        let taxel = r * paths.columns + c;
        let (junction, branch) = (&paths.junction, &self.branches[taxel]);
        let g_end = paths.ends.row_unselected[r];
        let out = |v: f64| {
            let (all, own) = (self.leaks.at(r, v), self.leaks.of_one(junction, taxel, v));
            Current {
                amperes: all.amperes - own.amperes + g_end * v,
                siemens: (all.siemens - own.siemens).max(0.0) + g_end,
            }
        };
        let mut v = self.floats[taxel];
        if !(v > 0.0 && v < column_volts) {
            // What would leave at the column's potential, had it come in.
            let i = out(column_volts).amperes;
            let over = i / branch.conductance() + junction.drop(i);
            v = if over < column_volts {
                column_volts - over
            } else {
                0.5 * column_volts
            };
        }
        let accuracy = if paths.rows_alike {
            ACCURACY
        } else {
            LEAK_ACCURACY
        };
        let (mut least, mut most) = (0.0, column_volts);
        let mut now = (Current::default(), Current::default());
        for _ in 0..ROUNDS {
            now = (branch.at(junction, column_volts - v), out(v));
            let left = now.0.amperes - now.1.amperes;
            *(if left > 0.0 { &mut least } else { &mut most }) = v;
            let step = left / (now.0.siemens + now.1.siemens);
            if left.abs() <= accuracy * now.0.amperes {
                break;
            }
            let next = v + step;
            let next = if next > least && next < most {
                next
            } else {
                0.5 * (least + most)
            };
            let moved = (next - v).abs();
            v = next;
            if moved.is_nan() || moved <= 1e-15 * column_volts {
                break;
            }
        }
        self.floats[taxel] = v;
        let (inward, outward) = now;
        let both = inward.siemens + outward.siemens;
        let feed = Current {
            amperes: inward.amperes,
            siemens: if both > 0.0 {
                inward.siemens * outward.siemens / both
            } else {
                0.0
            },
        };
        self.feeds[taxel] = feed;
        feed
    }

    /// The potential of a driven column whose rows are held alike, volts, and that of a row then.
    pub(super) fn alike(&self, taxel: usize, column: usize) -> (f64, f64) {
        (self.columns[column].0, self.floats[taxel])
    }

    /// D: what the driven column feeds into the rows that are not read, at a potential of it.
    #[inline]
    pub(super) fn drawn(&self, taxel: usize, column: usize, column_volts: f64) -> Current {
        let (at, sum) = self.columns[column];
        let feed = self.feeds[taxel];
        let siemens = (sum.siemens - feed.siemens).max(0.0);
        Current {
            amperes: sum.amperes - feed.amperes + siemens * (column_volts - at),
            siemens,
        }
    }

    /// Feeds leave a column that resists on its way.
    fn find_drops(&mut self, paths: &Paths, c: usize) {
        let (Some(along), n) = (&paths.along, paths.columns) else {
            return;
        };
        for r in 0..paths.rows {
            let to_here = along.column_ohms[r * n + c];
            let others = (0..paths.rows).filter(|&other| other != r);
            let drop = others.map(|other| {
                let taxel = other * n + c;
                self.feeds[taxel].amperes * to_here.min(along.column_ohms[taxel])
            });
            self.drops[r * n + c] = drop.sum();
        }
    }

    /// X: what leaves the row that is read for other columns, at a potential of its end and with a current along it.
    #[inline]
    pub(super) fn left(&self, paths: &Paths, taxel: usize, row_volts: f64, amperes: f64) -> Beside {
        let n = paths.columns;
        let (row, junction) = (taxel / n, &paths.junction);
        let Some(along) = &paths.along else {
            let all = self.leaks.at(row, row_volts);
            let own = self.leaks.of_one(junction, taxel, row_volts.max(0.0));
            return Beside {
                amperes: all.amperes - own.amperes,
                siemens: (all.siemens - own.siemens).max(0.0),
                volts: 0.0,
            };
        };
        // The row rises towards the taxel that its current comes from, and what leaks on the way is missing from there on.
        let line = row * n..(row + 1) * n;
        let own_ohms = along.row_ohms[taxel];
        let mut sum = Beside {
            volts: -self.drops[taxel],
            ..Beside::default()
        };
        for other in line.filter(|&other| other != taxel) {
            let shared = own_ohms.min(along.row_ohms[other]);
            let one = self
                .leaks
                .of_one(junction, other, row_volts + amperes * shared);
            sum.amperes += one.amperes;
            sum.siemens += one.siemens;
            sum.volts += one.amperes * shared;
        }
        sum
    }
}
