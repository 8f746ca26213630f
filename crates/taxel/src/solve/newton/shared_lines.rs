//! What makes GMRES short where lines are left open: the derivative of a frame whose taxels touch each other along their own row and
//! their own column alone.
//!
//! Between the lines of a taxel there is R = 1/y ohms, and dy_e/dG_f = y_e² (b_eᵀ L⁺ b_f)², L⁺ the pseudo-inverse of the network's
//! Laplacian. Taxels of one row share 1/S there, of one column 1/T (S and T what the lines conduct in all), others next to
//! nothing: y² (D + 1/S² ⊗ 11ᵀ + 11ᵀ ⊗ 1/T²) with a diagonal D that leaves a taxel its own R². The inverse is that of a matrix of the
//! rows alone (Woodbury, and Schur for the columns): three passes over the taxels.

use taxel_linalg::{Spd, View, ViewMut, multiply_lower};

/// A taxel's own part is no less than this share of its R².
const LEAST_OWN: f64 = 0.05;
/// A line that conducts less than this share of another is idle.
const IDLE: f64 = 1e-3;

/// The inverse of that derivative, at one frame of conductances.
pub(super) struct SharedLines {
    /// R², and 1/D: nothing of taxels that are no unknowns.
    squares: Vec<f64>,
    own: Vec<f64>,
    /// 1/S² of each row and 1/T² of each column.
    by_row: Vec<f64>,
    by_column: Vec<f64>,
    /// 1/S² ⊗ 1/T² ∘ 1/D, the rows' part against the columns', and the same over the columns' own.
    between: Vec<f64>,
    over_own: Vec<f64>,
    /// One over the columns' own part.
    columns: Vec<f64>,
    rows: Spd,
    schur: Vec<f64>,
    row_sums: Vec<f64>,
    column_sums: Vec<f64>,
    is_set: bool,
}

impl SharedLines {
    pub(super) fn new(rows: usize, columns: usize) -> Self {
        let taxels = || vec![0.0; rows * columns];
        Self {
            squares: taxels(),
            own: taxels(),
            by_row: vec![0.0; rows],
            by_column: vec![0.0; columns],
            between: taxels(),
            over_own: taxels(),
            columns: vec![0.0; columns],
            rows: Spd::new(rows),
            schur: vec![0.0; rows * rows],
            row_sums: vec![0.0; rows],
            column_sums: vec![0.0; columns],
            is_set: false,
        }
    }

    /// Takes the derivative at conductances and the apparent ones that they give.
    pub(super) fn set(&mut self, siemens: &[f64], apparent: &[f64], held: &[bool]) {
        let columns = self.by_column.len();
        self.by_column.fill(0.0);
        for (line, by_row) in siemens.chunks_exact(columns).zip(&mut self.by_row) {
            *by_row = line.iter().sum::<f64>().powi(-2);
            for (sum, g) in self.by_column.iter_mut().zip(line) {
                *sum += g;
            }
        }
        self.by_column
            .iter_mut()
            .for_each(|sum| *sum = sum.powi(-2));
        let taxels = self.squares.iter_mut().zip(&mut self.own);
        let readings = apparent.iter().zip(held);
        for (at, ((square, own), (y, held))) in taxels.zip(readings).enumerate() {
            let shared = self.by_row[at / columns] + self.by_column[at % columns];
            *square = if *held {
                0.0
            } else {
                y.abs().max(1e-30).powi(-2)
            };
            *own = if *held {
                0.0
            } else {
                1.0 / (*square - shared).max(LEAST_OWN * *square)
            };
        }
        self.is_set =
            conduct_alike(&self.by_row) && conduct_alike(&self.by_column) && self.factorise();
    }

    fn factorise(&mut self) -> bool {
        let (m, n) = (self.by_row.len(), self.by_column.len());
        self.columns.copy_from_slice(&self.by_column);
        for (row, p) in self.by_row.iter().enumerate() {
            let line = row * n..(row + 1) * n;
            let mut sum = 0.0;
            for (column, own) in self.own[line.clone()].iter().enumerate() {
                let q = self.by_column[column];
                self.between[row * n + column] = p * own * q;
                self.columns[column] += q * own * q;
                sum += p * own * p;
            }
            self.row_sums[row] = p + sum;
        }
        self.columns.iter_mut().for_each(|own| *own = 1.0 / *own);
        for (over, between) in self
            .over_own
            .chunks_exact_mut(n)
            .zip(self.between.chunks_exact(n))
        {
            for ((over, between), own) in over.iter_mut().zip(between).zip(&self.columns) {
                *over = between * own;
            }
        }
        multiply_lower(
            ViewMut::new(&mut self.schur, m, m),
            View::new(&self.over_own, m, n),
            View::new(&self.between, m, n).transpose(),
        );
        for (at, value) in self.schur.iter_mut().enumerate() {
            *value = -*value;
            if at % (m + 1) == 0 {
                *value += self.row_sums[at / (m + 1)];
            }
        }
        self.rows.factorise(&self.schur)
    }

    /// out ← M⁻¹ v, one number a taxel; v itself where nothing was taken.
    pub(super) fn apply(&mut self, v: &[f64], out: &mut [f64]) {
        out.copy_from_slice(v);
        self.apply_in_place(out);
    }

    /// The same in place.
    pub(super) fn apply_in_place(&mut self, values: &mut [f64]) {
        if !self.is_set {
            return;
        }
        let n = self.by_column.len();
        let taxels = values.iter_mut().zip(&self.squares).zip(&self.own);
        taxels.for_each(|((value, square), own)| *value *= square * own);
        self.column_sums.fill(0.0);
        for (line, sum) in values.chunks_exact(n).zip(&mut self.row_sums) {
            *sum = line.iter().sum();
            for (sum, value) in self.column_sums.iter_mut().zip(line) {
                *sum += value;
            }
        }
        // The sums over rows and columns of the answer, each times its own 1/S² or 1/T².
        let (p, q) = (&self.by_row, &self.by_column);
        self.column_sums
            .iter_mut()
            .zip(q)
            .for_each(|(sum, q)| *sum *= q);
        for ((sum, p), over) in self
            .row_sums
            .iter_mut()
            .zip(p)
            .zip(self.over_own.chunks_exact(n))
        {
            *sum = *sum * p - taxel_linalg::dot(over, &self.column_sums);
        }
        self.rows.solve(&mut self.row_sums);
        for (sum, between) in self.row_sums.iter().zip(self.between.chunks_exact(n)) {
            for (column, between) in self.column_sums.iter_mut().zip(between) {
                *column -= between * sum;
            }
        }
        let solved = self.column_sums.iter_mut().zip(&self.columns);
        solved.for_each(|(sum, own)| *sum *= own);
        for ((row, (line, own)), sum) in (values.chunks_exact_mut(n).zip(self.own.chunks_exact(n)))
            .enumerate()
            .zip(&self.row_sums)
        {
            let of_row = self.by_row[row] * sum;
            for ((value, own), (column, q)) in
                line.iter_mut().zip(own).zip(self.column_sums.iter().zip(q))
            {
                *value -= own * (of_row + q * column);
            }
        }
    }
}

/// Whether no line is idle beside the others. What such a line reads hardly tells its taxels apart, and noise there is not to be
/// made a step of.
fn conduct_alike(squares: &[f64]) -> bool {
    let most = squares.iter().copied().fold(0.0, f64::max);
    let least = squares.iter().copied().fold(f64::INFINITY, f64::min);
    most * IDLE * IDLE < least
}

#[cfg(test)]
mod tests {
    use super::*;

    /// M M⁻¹ v is v, M written out.
    #[test]
    fn it_inverts_what_it_says() {
        let (m, n) = (3, 5);
        let siemens: Vec<f64> = (0..m * n)
            .map(|at| 1e-6 * (1.0 + (at * at % 7) as f64))
            .collect();
        let apparent: Vec<f64> = siemens.iter().map(|g| 1.4 * g).collect();
        let held: Vec<bool> = (0..m * n).map(|at| at == 8).collect();
        let mut lines = SharedLines::new(m, n);
        lines.set(&siemens, &apparent, &held);
        let v: Vec<f64> = (0..m * n)
            .map(|at| if held[at] { 0.0 } else { (at as f64).sin() })
            .collect();
        let mut x = vec![0.0; m * n];
        lines.apply(&v, &mut x);
        for (at, y) in apparent.iter().enumerate().filter(|(at, _)| !held[*at]) {
            let (row, column) = (at / n, at % n);
            let sum = |is_in: &dyn Fn(usize) -> bool| -> f64 {
                (0..m * n).filter(|&at| is_in(at)).map(|at| x[at]).sum()
            };
            let of_row = lines.by_row[row] * sum(&|at| at / n == row);
            let of_column = lines.by_column[column] * sum(&|at| at % n == column);
            let back = y * y * (x[at] / lines.own[at] + of_row + of_column);
            assert!((back - v[at]).abs() < 1e-12, "{at}: {back} {}", v[at]);
        }
        assert_eq!(x[8], 0.0);
    }
}
