//! Cholesky factors and inverses.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{
    LltRegularization, cholesky_in_place, cholesky_in_place_scratch,
};
use faer::linalg::cholesky::llt::inverse::{inverse as inverse_of_factor, inverse_scratch};
use faer::linalg::cholesky::llt::solve::{solve_in_place, solve_in_place_scratch};
use faer::linalg::solvers::{DenseSolveCore, Solve};
use faer::{Mat, MatMut, MatRef, Par, Side};

use crate::View;
use crate::simd;
use crate::sweep::Swept;

/// Up to so many rows a matrix is inverted by sweeping: twice as fast at 48, the same at 100.
const SWEPT_ROWS: usize = 64;

/// Factorises symmetric positive definite n×n matrices; owns the scratch for it.
pub struct Spd {
    n: usize,
    factor: Vec<f64>,
    scratch: MemBuffer,
    swept: Swept,
}

impl Spd {
    /// For n × n matrices, and all smaller ones.
    pub fn new(n: usize) -> Self {
        let scratch = MemBuffer::new(
            cholesky_in_place_scratch::<f64>(n, Par::Seq, Default::default())
                .or(inverse_scratch::<f64>(n, Par::Seq))
                .or(solve_in_place_scratch::<f64>(n, 1, Par::Seq)),
        );
        Self {
            n,
            factor: vec![0.0; n * n],
            scratch,
            swept: Swept::new(n.min(SWEPT_ROWS)),
        }
    }

    /// Takes another size; allocates nothing when it is no larger than the first.
    pub fn resize(&mut self, n: usize) {
        if n * n > self.factor.capacity() {
            *self = Self::new(n);
        }
        self.n = n;
        self.factor.resize(n * n, 0.0);
    }

    /// Cholesky of the lower triangle of `matrix` (row-major). False when it is not positive definite.
    pub fn factorise(&mut self, matrix: &[f64]) -> bool {
        let n = self.n;
        // The column-major lower triangle of a symmetric matrix is its row-major upper one, so the
        // lower triangle is copied across while it is read.
        for i in 0..n {
            for j in 0..=i {
                self.factor[j * n + i] = matrix[i * n + j];
            }
        }
        let done = cholesky_in_place(
            MatMut::from_column_major_slice_mut(&mut self.factor, n, n),
            LltRegularization::default(),
            Par::Seq,
            MemStack::new(&mut self.scratch),
            Default::default(),
        )
        .is_ok();
        simd::zero_upper();
        done
    }

    /// x of A x = b in place of b, A what was factorised.
    pub fn solve(&mut self, right: &mut [f64]) {
        let n = self.n;
        solve_in_place(
            MatRef::from_column_major_slice(&self.factor, n, n),
            MatMut::from_column_major_slice_mut(right, n, 1),
            Par::Seq,
            MemStack::new(&mut self.scratch),
        );
        simd::zero_upper();
    }

    /// The whole inverse of `matrix`, both row-major; its lower triangle alone is read. False when it is not positive definite.
    /// What was factorised before is gone.
    pub fn invert(&mut self, matrix: &[f64], out: &mut [f64]) -> bool {
        if self.n <= SWEPT_ROWS {
            return self.swept.invert(self.n, matrix, out);
        }
        let done = self.factorise(matrix);
        if done {
            self.inverse_into(out);
        }
        done
    }

    /// The whole inverse of what was factorised, row-major.
    pub fn inverse_into(&mut self, out: &mut [f64]) {
        let n = self.n;
        inverse_of_factor(
            MatMut::from_column_major_slice_mut(out, n, n),
            MatRef::from_column_major_slice(&self.factor, n, n),
            Par::Seq,
            MemStack::new(&mut self.scratch),
        );
        simd::zero_upper();
        // faer writes the lower triangle of a column-major matrix: the upper of ours.
        for i in 1..n {
            for j in 0..i {
                out[i * n + j] = out[j * n + i];
            }
        }
    }
}

/// x of A x = b, A symmetric and positive definite (row-major, n × n; its lower triangle alone is read), b of n numbers.
/// `None` where A is not positive definite. By Cholesky; allocates.
///
/// # Panics
/// When `matrix` has not n² numbers.
pub fn solve_symmetric(matrix: &[f64], right: &[f64]) -> Option<Vec<f64>> {
    let n = right.len();
    let factor = MatRef::from_row_major_slice(matrix, n, n)
        .llt(Side::Lower)
        .ok()?;
    let solved = factor.solve(Mat::from_fn(n, 1, |i, _| right[i]));
    simd::zero_upper();
    Some((0..n).map(|i| solved[(i, 0)]).collect())
}

/// The inverse of a symmetric positive definite n × n matrix (row-major; its lower triangle alone is read), row-major.
/// `None` where it is not positive definite. By Cholesky; allocates.
///
/// # Panics
/// When `matrix` has not n² numbers.
pub fn inverse_symmetric(matrix: &[f64], n: usize) -> Option<Vec<f64>> {
    let factor = MatRef::from_row_major_slice(matrix, n, n)
        .llt(Side::Lower)
        .ok()?;
    Some(row_major(&factor.inverse()))
}

/// The inverse of any square matrix, row-major; not finite where there is none. By LU with partial pivoting; allocates.
///
/// # Panics
/// When `matrix` is not square.
pub fn inverse(matrix: View<'_>) -> Vec<f64> {
    row_major(&matrix.0.partial_piv_lu().inverse())
}

fn row_major(matrix: &Mat<f64>) -> Vec<f64> {
    simd::zero_upper();
    let (rows, columns) = (matrix.nrows(), matrix.ncols());
    let cells = (0..rows).flat_map(|i| (0..columns).map(move |j| (i, j)));
    cells.map(|cell| matrix[cell]).collect()
}
