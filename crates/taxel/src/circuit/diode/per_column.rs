//! A derivative that is diagonal but for what the taxels of a column share.

/// J = diag(d) + Σ_c l_c r_cᵀ, l_c and r_c the taxels of column c in `left` and `right`; one value a taxel, row by row.
pub(super) struct PerColumn {
    columns: usize,
    pub(super) diagonal: Vec<f64>,
    pub(super) left: Vec<f64>,
    pub(super) right: Vec<f64>,
    sums: Vec<f64>,
}

impl PerColumn {
    pub(super) fn new(rows: usize, columns: usize) -> Self {
        let none = || vec![0.0; rows * columns];
        Self {
            columns,
            diagonal: none(),
            left: none(),
            right: none(),
            sums: vec![0.0; columns],
        }
    }

    pub(super) fn times(&mut self, direction: &[f64], out: &mut [f64]) {
        apply(
            self.columns,
            &mut self.sums,
            [&self.diagonal, &self.left, &self.right],
            direction,
            out,
        );
    }

    pub(super) fn transposed_times(&mut self, weights: &[f64], out: &mut [f64]) {
        apply(
            self.columns,
            &mut self.sums,
            [&self.diagonal, &self.right, &self.left],
            weights,
            out,
        );
    }
}

fn apply(
    columns: usize,
    sums: &mut [f64],
    [diagonal, left, right]: [&[f64]; 3],
    by: &[f64],
    out: &mut [f64],
) {
    sums.fill(0.0);
    for (by, right) in by.chunks_exact(columns).zip(right.chunks_exact(columns)) {
        for ((sum, by), right) in sums.iter_mut().zip(by).zip(right) {
            *sum += by * right;
        }
    }
    let lines = out.chunks_exact_mut(columns).zip(by.chunks_exact(columns));
    let shares = diagonal
        .chunks_exact(columns)
        .zip(left.chunks_exact(columns));
    for ((out, by), (diagonal, left)) in lines.zip(shares) {
        for (c, out) in out.iter_mut().enumerate() {
            *out = diagonal[c] * by[c] + left[c] * sums[c];
        }
    }
}
