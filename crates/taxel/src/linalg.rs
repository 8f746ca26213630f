//! Dense kernels over row-major slices, with all scratch owned by the caller: thin names over faer.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{
    LltRegularization, cholesky_in_place, cholesky_in_place_scratch,
};
use faer::linalg::cholesky::llt::inverse::{inverse, inverse_scratch};
use faer::linalg::matmul::matmul;
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::linalg::triangular_inverse::invert_lower_triangular;
use faer::{Accum, MatMut, MatRef, Par};

use crate::simd;

/// A row-major slice seen as a matrix.
pub(crate) fn view(values: &[f64], rows: usize, columns: usize) -> MatRef<'_, f64> {
    MatRef::from_row_major_slice(values, rows, columns)
}

/// A row-major slice seen as a matrix that can be written.
pub(crate) fn view_mut(values: &mut [f64], rows: usize, columns: usize) -> MatMut<'_, f64> {
    MatMut::from_row_major_slice_mut(values, rows, columns)
}

/// out ← a b.
pub(crate) fn multiply(out: MatMut<'_, f64>, a: MatRef<'_, f64>, b: MatRef<'_, f64>) {
    matmul(out, Accum::Replace, a, b, 1.0, Par::Seq);
    simd::zero_upper();
}

/// out ← out + factor · a b.
pub(crate) fn multiply_add(
    out: MatMut<'_, f64>,
    a: MatRef<'_, f64>,
    b: MatRef<'_, f64>,
    factor: f64,
) {
    matmul(out, Accum::Add, a, b, factor, Par::Seq);
    simd::zero_upper();
}

/// Lower triangle of out ← a b, for a product known to be symmetric. The upper triangle is untouched.
pub(crate) fn multiply_lower(out: MatMut<'_, f64>, a: MatRef<'_, f64>, b: MatRef<'_, f64>) {
    triangular::matmul(
        out,
        BlockStructure::TriangularLower,
        Accum::Replace,
        a,
        BlockStructure::Rectangular,
        b,
        BlockStructure::Rectangular,
        1.0,
        Par::Seq,
    );
    simd::zero_upper();
}

/// Copies the lower triangle of a row-major n×n matrix to the upper one.
pub(crate) fn mirror(values: &mut [f64], n: usize) {
    for i in 1..n {
        for j in 0..i {
            values[j * n + i] = values[i * n + j];
        }
    }
}

/// Partial sums side by side, so that the compiler may use simd.
const LANES: usize = 8;

/// Σ a b.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; LANES];
    let (a, b) = (a.chunks_exact(LANES), b.chunks_exact(LANES));
    let rest = a.remainder().iter().zip(b.remainder());
    let rest: f64 = rest.map(|(x, y)| x * y).sum();
    for (x, y) in a.zip(b) {
        for ((sum, x), y) in sums.iter_mut().zip(x).zip(y) {
            *sum += x * y;
        }
    }
    rest + sums.iter().sum::<f64>()
}

/// Σ a.
pub(crate) fn sum(a: &[f64]) -> f64 {
    let mut sums = [0.0; LANES];
    let a = a.chunks_exact(LANES);
    let rest: f64 = a.remainder().iter().sum();
    for x in a {
        for (sum, x) in sums.iter_mut().zip(x) {
            *sum += x;
        }
    }
    rest + sums.iter().sum::<f64>()
}

/// Factorises symmetric positive definite n×n matrices; owns the memory for it.
pub(crate) struct Spd {
    n: usize,
    factor: Vec<f64>,
    memory: MemBuffer,
}

impl Spd {
    pub(crate) fn new(n: usize) -> Self {
        let memory = MemBuffer::new(
            cholesky_in_place_scratch::<f64>(n, Par::Seq, Default::default())
                .or(inverse_scratch::<f64>(n, Par::Seq)),
        );
        Self {
            n,
            factor: vec![0.0; n * n],
            memory,
        }
    }

    /// Takes another size; allocates nothing when it is no larger than the first.
    pub(crate) fn resize(&mut self, n: usize) {
        if n * n > self.factor.capacity() {
            *self = Self::new(n);
        }
        self.n = n;
        self.factor.resize(n * n, 0.0);
    }

    /// Cholesky of the lower triangle of `matrix` (row-major). False when it is not positive definite.
    pub(crate) fn factorise(&mut self, matrix: &[f64]) -> bool {
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
            MemStack::new(&mut self.memory),
            Default::default(),
        )
        .is_ok();
        simd::zero_upper();
        done
    }

    /// The whole inverse of what was factorised, row-major.
    pub(crate) fn inverse_into(&mut self, out: &mut [f64]) {
        let n = self.n;
        inverse(
            MatMut::from_column_major_slice_mut(out, n, n),
            MatRef::from_column_major_slice(&self.factor, n, n),
            Par::Seq,
            MemStack::new(&mut self.memory),
        );
        simd::zero_upper();
        // faer writes the lower triangle of a column-major matrix: the upper of ours.
        for i in 1..n {
            for j in 0..i {
                out[i * n + j] = out[j * n + i];
            }
        }
    }

    /// The diagonal of the inverse alone; `triangle` is n×n scratch.
    pub(crate) fn inverse_diagonal_into(&mut self, out: &mut [f64], triangle: &mut [f64]) {
        let n = self.n;
        triangle.fill(0.0);
        invert_lower_triangular(
            MatMut::from_column_major_slice_mut(triangle, n, n),
            MatRef::from_column_major_slice(&self.factor, n, n),
            Par::Seq,
        );
        simd::zero_upper();
        for (j, value) in out.iter_mut().enumerate() {
            let line = &triangle[j * n + j..(j + 1) * n];
            *value = dot(line, line);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn example(n: usize) -> Vec<f64> {
        let mut matrix = vec![0.0; n * n];
        for i in 0..n {
            for j in 0..n {
                matrix[i * n + j] = 1.0 / (1.0 + i.abs_diff(j) as f64);
            }
            matrix[i * n + i] += n as f64;
        }
        matrix
    }

    #[test]
    fn inverse_times_matrix_is_identity_and_its_diagonal_agrees() {
        for n in [1, 2, 7, 33, 64] {
            let matrix = example(n);
            let mut spd = Spd::new(n);
            assert!(spd.factorise(&matrix));
            let (mut inv, mut product) = (vec![0.0; n * n], vec![0.0; n * n]);
            spd.inverse_into(&mut inv);
            multiply(
                view_mut(&mut product, n, n),
                view(&matrix, n, n),
                view(&inv, n, n),
            );
            let (mut diagonal, mut triangle) = (vec![0.0; n], vec![0.0; n * n]);
            spd.inverse_diagonal_into(&mut diagonal, &mut triangle);
            for i in 0..n {
                assert!((diagonal[i] - inv[i * n + i]).abs() < 1e-13);
                for j in 0..n {
                    let expected = f64::from(u8::from(i == j));
                    assert!((product[i * n + j] - expected).abs() < 1e-12);
                }
            }
        }
    }

    #[test]
    fn an_indefinite_matrix_is_refused() {
        assert!(!Spd::new(2).factorise(&[1.0, 2.0, 2.0, 1.0]));
    }
}
