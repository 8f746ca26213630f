//! LU factors of many square matrices of one size, kept side by side.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::lu::partial_pivoting::factor::{lu_in_place, lu_in_place_scratch};
use faer::{MatMut, Par};

use crate::simd;

/// Factors of `count` matrices of n × n, with partial pivoting; owns its memory.
pub struct LuBlocks {
    n: usize,
    /// Column by column, one matrix after the other: first the matrix, then its factors with the reciprocals of U's diagonal.
    values: Vec<f64>,
    /// Row of the matrix that each row of the factors is.
    rows: Vec<usize>,
    back: Vec<usize>,
    moved: Vec<f64>,
    scratch: MemBuffer,
}

impl LuBlocks {
    /// For so many matrices of n × n.
    pub fn new(n: usize, count: usize) -> Self {
        let scratch = lu_in_place_scratch::<usize, f64>(n, n, Par::Seq, Default::default());
        Self {
            n,
            values: vec![0.0; n * n * count],
            rows: vec![0; n * count],
            back: vec![0; n],
            moved: vec![0.0; n],
            scratch: MemBuffer::new(scratch),
        }
    }

    /// A matrix to be written, **column by column**: the value of row i and column j stands at j n + i.
    pub fn matrix_mut(&mut self, which: usize) -> &mut [f64] {
        let size = self.n * self.n;
        &mut self.values[which * size..(which + 1) * size]
    }

    /// All matrices, one after the other, each column by column.
    pub fn matrices_mut(&mut self) -> &mut [f64] {
        &mut self.values
    }

    /// Factorises a matrix in its place. False where it is singular.
    pub fn factorise(&mut self, which: usize) -> bool {
        let n = self.n;
        let values = &mut self.values[which * n * n..(which + 1) * n * n];
        let rows = &mut self.rows[which * n..(which + 1) * n];
        lu_in_place(
            MatMut::from_column_major_slice_mut(values, n, n),
            rows,
            &mut self.back,
            Par::Seq,
            MemStack::new(&mut self.scratch),
            Default::default(),
        );
        simd::zero_upper();
        let mut is_regular = true;
        for pivot in values.iter_mut().step_by(n + 1) {
            *pivot = 1.0 / *pivot;
            is_regular &= pivot.is_finite();
        }
        is_regular
    }

    /// x ← A⁻¹ x by the factors of a matrix.
    pub fn solve(&mut self, which: usize, x: &mut [f64]) {
        let n = self.n;
        let values = &self.values[which * n * n..(which + 1) * n * n];
        for (moved, &row) in self.moved.iter_mut().zip(&self.rows[which * n..]) {
            *moved = x[row];
        }
        x.copy_from_slice(&self.moved);
        for (j, column) in values.chunks_exact(n).enumerate() {
            let value = x[j];
            for (x, below) in x[j + 1..].iter_mut().zip(&column[j + 1..]) {
                *x -= value * below;
            }
        }
        for (j, column) in values.chunks_exact(n).enumerate().rev() {
            x[j] *= column[j];
            let value = x[j];
            for (x, above) in x[..j].iter_mut().zip(column) {
                *x -= value * above;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_solved_for_gives_the_right_side() {
        let (n, count) = (9, 3);
        let value = |k: usize, i: usize, j: usize| (((k + 3) * (i + 2) * (j + 5)) as f64).sin();
        let mut lu = LuBlocks::new(n, count);
        for k in 0..count {
            let matrix = lu.matrix_mut(k);
            for (at, cell) in matrix.iter_mut().enumerate() {
                *cell = value(k, at % n, at / n);
            }
            assert!(lu.factorise(k));
        }
        for k in 0..count {
            let right: Vec<f64> = (0..n).map(|i| (i as f64).cos()).collect();
            let mut x = right.clone();
            lu.solve(k, &mut x);
            for (i, right) in right.iter().enumerate() {
                let back: f64 = x.iter().enumerate().map(|(j, x)| value(k, i, j) * x).sum();
                assert!((back - right).abs() < 1e-10, "{back} {right}");
            }
        }
        lu.matrix_mut(0).fill(0.0);
        assert!(!lu.factorise(0));
    }
}
