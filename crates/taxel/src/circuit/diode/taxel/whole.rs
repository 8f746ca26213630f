//! The currents beside the taxels' own for any ends of lines: all potentials by Newton's method, reading by reading.
//!
//! Without a follower the potentials are the least of a convex function (each branch's current rises with its voltage), so
//! that steps can be shortened until that falls; the follower's potential is found around it.

use taxel_linalg::dot;

use super::Paths;
use crate::circuit::diode::branch::{Branch, Current};

pub(super) struct Whole {
    /// X and D of every taxel.
    pub(super) left: Vec<f64>,
    pub(super) drawn: Vec<f64>,
    branches: Vec<Branch>,
    through: Vec<Current>,
    /// Potentials of rows, then of columns.
    volts: Vec<f64>,
    trial: Vec<f64>,
    residual: Vec<f64>,
    step: Vec<f64>,
    matrix: Vec<f64>,
    totals: Vec<f64>,
    ends: Vec<f64>,
    /// Where a line's end leads, volts, and the part of it that leads to the follower.
    stands: Vec<f64>,
    shares: Vec<f64>,
}

const ROUNDS: usize = 80;
const HALVINGS: usize = 40;
const FOLLOWER_ROUNDS: usize = 50;
/// Accuracy of potentials, of V_t.
const ACCURACY: f64 = 1e-12;

impl Whole {
    pub(super) fn new(paths: &Paths) -> Self {
        let (rows, columns) = (paths.rows, paths.columns);
        let (taxels, lines) = (rows * columns, rows + columns);
        let small = rows.min(columns);
        let none = || vec![0.0; lines];
        Self {
            left: vec![0.0; taxels],
            drawn: vec![0.0; taxels],
            branches: vec![Branch::default(); taxels],
            through: vec![Current::default(); taxels],
            volts: none(),
            trial: none(),
            residual: none(),
            step: none(),
            matrix: vec![0.0; small * small],
            totals: none(),
            ends: none(),
            stands: none(),
            shares: none(),
        }
    }

    pub(super) fn set(&mut self, paths: &Paths, siemens: &[f64]) {
        for (taxel, (branch, g)) in self.branches.iter_mut().zip(siemens).enumerate() {
            *branch = Branch::new(&paths.junction, paths.with_lines(taxel, *g));
        }
        for c in 0..paths.columns {
            self.volts.fill(0.0);
            for r in 0..paths.rows {
                self.select(paths, r, c);
                self.find(paths, r);
                let taxel = r * paths.columns + c;
                let (v_row, v_column) = (self.volts[r], self.volts[paths.rows + c]);
                let own = self.branches[taxel].at(&paths.junction, v_column - v_row);
                let g_cs = paths.ends.column_selected[c];
                self.left[taxel] = own.amperes - paths.ends.row_selected[r] * v_row;
                self.drawn[taxel] = g_cs * (paths.drives[c] - v_column) - own.amperes;
                // The next row takes this one's place.
                if r + 1 < paths.rows {
                    self.volts.swap(r, r + 1);
                }
            }
        }
    }

    /// The ends of all lines with these selected.
    fn select(&mut self, paths: &Paths, r: usize, c: usize) {
        let rows = paths.rows;
        self.ends[..rows].copy_from_slice(&paths.ends.row_unselected);
        self.ends[rows..].copy_from_slice(&paths.ends.column_unselected);
        self.ends[r] = paths.ends.row_selected[r];
        self.ends[rows + c] = paths.ends.column_selected[c];
        self.stands.fill(0.0);
        self.stands[rows + c] = paths.drives[c];
        let follow = &paths.ends.to_follower;
        let parts = follow
            .row_unselected
            .iter()
            .chain(&follow.column_unselected);
        for (share, (part, all)) in self.shares.iter_mut().zip(parts.zip(&self.ends)) {
            *share = part / all;
        }
        (self.shares[r], self.shares[rows + c]) = (0.0, 0.0);
        self.volts[rows + c] = self.volts[rows + c].max(0.5 * paths.drives[c]);
    }

    /// Finds all potentials, with the follower at what is read.
    fn find(&mut self, paths: &Paths, r: usize) {
        if self.shares.iter().all(|share| *share == 0.0) {
            return self.descend(paths);
        }
        let rho = paths.ends.volts_per_volt[r];
        let (mut at, mut before) = (rho * self.volts[r], None::<(f64, f64)>);
        for _ in 0..FOLLOWER_ROUNDS {
            for (stand, share) in self.stands.iter_mut().zip(&self.shares) {
                if *share > 0.0 {
                    *stand = share * at;
                }
            }
            self.descend(paths);
            let off = rho * self.volts[r] - at;
            if off.abs() <= ACCURACY {
                return;
            }
            // The secant of the last two, which nothing keeps from a plain repetition at first.
            let slope = before.map_or(-1.0, |(then, was)| (off - was) / (at - then));
            before = Some((at, off));
            at -= if slope < -1e-3 { off / slope } else { -off };
        }
    }

    fn descend(&mut self, paths: &Paths) {
        let most = self.stands.iter().copied().fold(0.0, f64::max);
        self.trial.copy_from_slice(&self.volts);
        self.evaluate(paths);
        for _ in 0..ROUNDS {
            if !self.newton(paths) {
                return;
            }
            let falls: f64 = dot(&self.residual, &self.step);
            let longest = self.step.iter().fold(0f64, |most, s| most.max(s.abs()));
            let mut length = 1.0;
            for _ in 0..HALVINGS {
                for (trial, (volts, step)) in
                    self.trial.iter_mut().zip(self.volts.iter().zip(&self.step))
                {
                    *trial = volts + length * step;
                }
                self.evaluate(paths);
                // Short of the least along the step, or not far behind it.
                let still = dot(&self.residual, &self.step);
                if still >= -0.5 * falls || longest <= ACCURACY * most {
                    break;
                }
                length *= 0.5;
            }
            self.volts.copy_from_slice(&self.trial);
            if longest <= ACCURACY * most {
                return;
            }
        }
    }

    /// What is left of Kirchhoff's law at every line, with the branches' slopes, at `trial`.
    fn evaluate(&mut self, paths: &Paths) {
        let (rows, n) = (paths.rows, paths.columns);
        for line in 0..rows + n {
            self.residual[line] = self.ends[line] * (self.stands[line] - self.trial[line]);
        }
        for r in 0..rows {
            for c in 0..n {
                let taxel = r * n + c;
                let over = self.trial[rows + c] - self.trial[r];
                let now = self.branches[taxel].at(&paths.junction, over);
                self.through[taxel] = now;
                self.residual[r] += now.amperes;
                self.residual[rows + c] -= now.amperes;
            }
        }
    }

    /// Newton's step from `trial`, by eliminating the larger side. False where the matrix is singular.
    fn newton(&mut self, paths: &Paths) -> bool {
        let (rows, n) = (paths.rows, paths.columns);
        self.totals.copy_from_slice(&self.ends);
        for (taxel, now) in self.through.iter().enumerate() {
            self.totals[taxel / n] += now.siemens;
            self.totals[rows + taxel % n] += now.siemens;
        }
        let by_rows = rows <= n;
        let (m, large) = if by_rows { (rows, n) } else { (n, rows) };
        let (small_at, large_at) = if by_rows { (0, rows) } else { (rows, 0) };
        let through = &self.through;
        let between = |small: usize, large: usize| {
            let taxel = if by_rows {
                small * n + large
            } else {
                large * n + small
            };
            through[taxel].siemens
        };
        for i in 0..m {
            for j in 0..=i {
                let shared: f64 = (0..large)
                    .map(|l| between(i, l) * between(j, l) / self.totals[large_at + l])
                    .sum();
                let own = if i == j {
                    self.totals[small_at + i]
                } else {
                    0.0
                };
                self.matrix[i * m + j] = own - shared;
            }
            let pushed: f64 = (0..large)
                .map(|l| between(i, l) * self.residual[large_at + l] / self.totals[large_at + l])
                .sum();
            self.step[small_at + i] = self.residual[small_at + i] + pushed;
        }
        if !solve_in_place(&mut self.matrix, &mut self.step[small_at..small_at + m]) {
            return false;
        }
        for l in 0..large {
            let pulled: f64 = (0..m)
                .map(|i| between(i, l) * self.step[small_at + i])
                .sum();
            self.step[large_at + l] =
                (self.residual[large_at + l] + pulled) / self.totals[large_at + l];
        }
        self.step.iter().all(|step| step.is_finite())
    }
}

/// Solves a symmetric positive system of which the lower triangle is given, in the place of both. False where it is singular.
fn solve_in_place(matrix: &mut [f64], right: &mut [f64]) -> bool {
    let m = right.len();
    for j in 0..m {
        let (above, below) = matrix.split_at_mut((j + 1) * m);
        let pivot_row = &mut above[j * m..];
        let pivot = pivot_row[j] - dot(&pivot_row[..j], &pivot_row[..j]);
        if pivot.is_nan() || pivot <= 0.0 {
            return false;
        }
        let pivot = pivot.sqrt();
        pivot_row[j] = pivot;
        for row in below.chunks_exact_mut(m) {
            row[j] = (row[j] - dot(&row[..j], &pivot_row[..j])) / pivot;
        }
    }
    for i in 0..m {
        let done = dot(&matrix[i * m..i * m + i], &right[..i]);
        right[i] = (right[i] - done) / matrix[i * m + i];
    }
    for i in (0..m).rev() {
        let done: f64 = (i + 1..m).map(|k| matrix[k * m + i] * right[k]).sum();
        right[i] = (right[i] - done) / matrix[i * m + i];
    }
    true
}
