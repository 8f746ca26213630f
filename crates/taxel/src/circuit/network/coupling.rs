//! What a continuous sheet adds to the network: a chain of conductances between neighbouring lines, on either side.
//!
//! Lines are equipotential, so the couplings of all taxels of two lines add up. Arrays are over the smaller side (m) and
//! the larger (n), row-major, as in `lumped.rs`; the chain of the smaller side joins the taxels (i, j) and (i + 1, j), that of
//! the larger (i, j) and (i, j + 1). Their Laplacians annihilate constants, so that what theory.md builds on row
//! sums stays true.

use crate::material::Sheet;
use taxel_linalg::{Number, wide};

/// Couplings of neighbouring lines, siemens: one value for each line but the last; 0 where two are no neighbours.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Couplings {
    pub(crate) sheet: Sheet,
    pub(crate) small: Vec<f64>,
    pub(crate) large: Vec<f64>,
    small_joined: Vec<bool>,
    large_joined: Vec<bool>,
    line: Vec<f64>,
}

impl Couplings {
    /// For lines at these places along the mat.
    pub(crate) fn new(sheet: Sheet, small: &[usize], large: &[usize]) -> Self {
        let mut couplings = Self {
            sheet,
            small: Vec::with_capacity(small.len()),
            large: Vec::with_capacity(large.len()),
            small_joined: Vec::with_capacity(small.len()),
            large_joined: Vec::with_capacity(large.len()),
            line: Vec::with_capacity(large.len()),
        };
        couplings.reshape(small, large);
        couplings
    }

    /// Takes other lines, with nothing known of their couplings. Allocates nothing for no more lines than at first.
    pub(crate) fn reshape(&mut self, small: &[usize], large: &[usize]) {
        for (joined, places) in [
            (&mut self.small_joined, small),
            (&mut self.large_joined, large),
        ] {
            joined.clear();
            joined.extend(places.windows(2).map(|two| two[1] == two[0] + 1));
        }
        for (couplings, joined) in [
            (&mut self.small, &self.small_joined),
            (&mut self.large, &self.large_joined),
        ] {
            couplings.clear();
            couplings.resize(joined.len(), 0.0);
        }
        self.line.resize(large.len(), 0.0);
    }

    /// Takes the couplings under these conductances, m×n.
    pub(crate) fn update(&mut self, conductance: &[f64]) {
        let (mut small, mut large) = (
            std::mem::take(&mut self.small),
            std::mem::take(&mut self.large),
        );
        self.find(conductance, &mut small, &mut large);
        (self.small, self.large) = (small, large);
    }

    /// The couplings under these conductances.
    pub(crate) fn find(&mut self, conductance: &[f64], small: &mut [f64], large: &mut [f64]) {
        wide(
            #[inline(always)]
            || add_up(self.sheet, conductance, &mut self.line, small, large),
        );
        self.cut_sides(small, large);
    }

    /// Sets couplings of lines that are no neighbours to 0.
    pub(crate) fn cut_sides(&self, small: &mut [f64], large: &mut [f64]) {
        cut(small, &self.small_joined);
        cut(large, &self.large_joined);
    }

    /// Changes of the couplings of the smaller and the larger side along a change of the conductances.
    pub(crate) fn changes(
        &self,
        conductance: &[f64],
        direction: &[f64],
        small: &mut [f64],
        large: &mut [f64],
    ) {
        small.fill(0.0);
        large.fill(0.0);
        self.each_pair(
            conductance,
            |at, other, is_small, line, (by_at, by_other)| {
                let change = by_at * direction[at] + by_other * direction[other];
                if is_small {
                    small[line] += change;
                } else {
                    large[line] += change;
                }
            },
        );
    }

    /// Adds to `out` the gradient by the conductances, from those by the couplings of the smaller and the larger side.
    pub(crate) fn add_gradient(
        &self,
        conductance: &[f64],
        small: &[f64],
        large: &[f64],
        out: &mut [f64],
    ) {
        self.each_pair(
            conductance,
            |at, other, is_small, line, (by_at, by_other)| {
                let by_coupling = if is_small { small[line] } else { large[line] };
                out[at] += by_coupling * by_at;
                out[other] += by_coupling * by_other;
            },
        );
    }

    /// Every pair of neighbouring taxels that are joined: their places, the side and line, and the slopes of ℓ.
    #[inline(always)]
    fn each_pair(
        &self,
        conductance: &[f64],
        mut visit: impl FnMut(usize, usize, bool, usize, (f64, f64)),
    ) {
        let n = self.large_joined.len() + 1;
        for i in 0..conductance.len() / n {
            for j in 0..n {
                let at = i * n + j;
                let mut pair = |other: usize, is_small, line| {
                    let slopes = self.sheet.slopes(conductance[at], conductance[other]);
                    visit(at, other, is_small, line, slopes);
                };
                if self.large_joined.get(j) == Some(&true) {
                    pair(at + 1, false, j);
                }
                if self.small_joined.get(i) == Some(&true) {
                    pair(at + n, true, i);
                }
            }
        }
    }
}

/// The couplings under these conductances as if all lines were joined; `line` is room for one of the smaller side's.
#[inline(always)]
pub(crate) fn add_up<T: Number>(
    sheet: Sheet,
    conductance: &[T],
    line: &mut [T],
    small: &mut [T],
    large: &mut [T],
) {
    let n = line.len();
    large.fill(T::default());
    for line in conductance.chunks_exact(n) {
        let (left, right) = (&line[..n - 1], &line[1..]);
        for ((sum, a), b) in large.iter_mut().zip(left).zip(right) {
            *sum += sheet.between(*a, *b);
        }
    }
    let pairs = conductance[..conductance.len() - n].chunks_exact(n);
    let pairs = pairs.zip(conductance[n..].chunks_exact(n));
    for (sum, (above, below)) in small.iter_mut().zip(pairs) {
        for ((out, a), b) in line.iter_mut().zip(above).zip(below) {
            *out = sheet.between(*a, *b);
        }
        *sum = taxel_linalg::sum(line);
    }
}

fn cut(couplings: &mut [f64], joined: &[bool]) {
    for (coupling, joined) in couplings.iter_mut().zip(joined) {
        if !joined {
            *coupling = 0.0;
        }
    }
}

/// What line i's own diagonal gains by the couplings of its chain.
#[inline(always)]
pub(crate) fn diagonal(couplings: &[f64], i: usize) -> f64 {
    let before = i.checked_sub(1).map_or(0.0, |before| couplings[before]);
    before + couplings.get(i).copied().unwrap_or(0.0)
}

/// out ← out + L x for the Laplacian L of a chain.
pub(crate) fn add_laplacian(couplings: &[f64], x: &[f64], out: &mut [f64]) {
    for (j, coupling) in couplings.iter().enumerate() {
        let flow = coupling * (x[j] - x[j + 1]);
        out[j] += flow;
        out[j + 1] -= flow;
    }
}

/// The Cholesky factor of a diagonal with the Laplacian of a chain added: tridiagonal, positive definite.
/// T = E Eᵀ with E lower bidiagonal.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Chain {
    /// 1/E_jj.
    inverse: Vec<f64>,
    /// E_j+1,j.
    below: Vec<f64>,
}

impl Chain {
    pub(crate) fn new(lines: usize) -> Self {
        Self {
            inverse: vec![0.0; lines],
            below: vec![0.0; lines],
        }
    }

    /// Factors diag(`diagonal`) + L(`couplings`). False when that is not positive definite.
    pub(crate) fn factorise(&mut self, diagonal_of: &[f64], couplings: &[f64]) -> bool {
        let mut from_before = 0.0;
        for (j, own) in diagonal_of.iter().enumerate() {
            let pivot = own + diagonal(couplings, j) - from_before;
            if pivot.is_nan() || pivot <= 0.0 {
                return false;
            }
            self.inverse[j] = 1.0 / pivot.sqrt();
            self.below[j] = -couplings.get(j).copied().unwrap_or(0.0) * self.inverse[j];
            from_before = self.below[j] * self.below[j];
        }
        true
    }

    /// rows ← rows T⁻¹, each of as many values as there are lines.
    pub(crate) fn solve_rows(&self, rows: &mut [f64]) {
        let n = self.inverse.len();
        // Four at a time: within one row each value waits for the one before it.
        let mut blocks = rows.chunks_exact_mut(4 * n);
        for block in &mut blocks {
            self.solve_block::<4>(block);
        }
        for row in blocks.into_remainder().chunks_exact_mut(n) {
            self.solve_block::<1>(row);
        }
    }

    fn solve_block<const ROWS: usize>(&self, rows: &mut [f64]) {
        let n = self.inverse.len();
        let mut x = [0.0; ROWS];
        let mut below = 0.0;
        for j in 0..n {
            for (r, x) in x.iter_mut().enumerate() {
                *x = (rows[r * n + j] - below * *x) * self.inverse[j];
                rows[r * n + j] = *x;
            }
            below = self.below[j];
        }
        x = [0.0; ROWS];
        for j in (0..n).rev() {
            for (r, x) in x.iter_mut().enumerate() {
                *x = (rows[r * n + j] - self.below[j] * *x) * self.inverse[j];
                rows[r * n + j] = *x;
            }
        }
    }

    /// The diagonal of T⁻¹.
    pub(crate) fn inverse_diagonal_into(&self, out: &mut [f64]) {
        // T⁻¹ = E⁻ᵀ E⁻¹: from the last line back, each needs only the one after it.
        let mut after = 0.0;
        for j in (0..self.inverse.len()).rev() {
            let step = self.below[j] * self.inverse[j];
            after = self.inverse[j] * self.inverse[j] + step * step * after;
            out[j] = after;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chain_is_solved_and_its_inverse_known() {
        let own = [2.0, 0.5, 1.0, 3.0, 0.1];
        let couplings = [0.3, 0.0, 2.0, 1.5];
        let mut chain = Chain::new(5);
        assert!(chain.factorise(&own, &couplings));
        let x: Vec<f64> = (0..35).map(|i| f64::from(i * i % 11) - 4.0).collect();
        let mut right = Vec::new();
        for row in x.chunks_exact(5) {
            let mut line: Vec<f64> = row.iter().zip(&own).map(|(x, d)| x * d).collect();
            add_laplacian(&couplings, row, &mut line);
            right.extend(line);
        }
        chain.solve_rows(&mut right);
        for (found, x) in right.iter().zip(&x) {
            assert!((found - x).abs() < 1e-12, "{found} {x}");
        }
        let mut identity = vec![0.0; 25];
        identity.iter_mut().step_by(6).for_each(|x| *x = 1.0);
        chain.solve_rows(&mut identity);
        let mut found = vec![0.0; 5];
        chain.inverse_diagonal_into(&mut found);
        for (j, found) in found.iter().enumerate() {
            assert!((found / identity[6 * j] - 1.0).abs() < 1e-13);
        }
        assert!(!chain.factorise(&[0.0, 1.0, 1.0, 1.0, 1.0], &[0.0; 4]));
    }

    #[test]
    fn lines_that_are_no_neighbours_are_not_coupled() {
        let mut couplings = Couplings::new(Sheet::new(1e3, 1.0), &[0, 2, 3], &[4, 5]);
        couplings.update(&[1e-3; 6]);
        assert_eq!(couplings.small[0], 0.0);
        assert!(couplings.small[1] > 0.0 && couplings.large[0] > 0.0);
    }
}
