//! The square root of a symmetric matrix whose eigenvalues are one or more.
//!
//! The scaled product form of Denman and Beavers' iteration (Cheng, Higham, Kenney and Laub 2001):
//! M ← ½I + ¼(γ²M + M⁻¹/γ²), Y ← ½γ(Y + Y M⁻¹/γ²), from M = Y = A to M = I, Y = A^½. With the eigenvalues of M
//! in [1, b], γ² = 1/√b is best and leaves them in [1, ½ + ¼(√b + 1/√b)], so that the number of rounds is known
//! beforehand: three for b = 100. What is then left, Y (I + E)^−½, is a short series.

use taxel_linalg::{Spd, View, ViewMut, mirror, multiply_lower};

/// Eigenvalues of M within this of 1 leave 3e-13 to the series' next term.
const SERIES: f64 = 1e-3;
/// More than any b that a double can hold needs.
const MAX_ITERATIONS: usize = 24;

/// Memory for matrices of one size.
pub(super) struct SquareRoot {
    n: usize,
    m: Vec<f64>,
    inverse: Vec<f64>,
    product: Vec<f64>,
    spd: Spd,
}

impl SquareRoot {
    pub(super) fn new(n: usize) -> Self {
        Self {
            n,
            m: vec![0.0; n * n],
            inverse: vec![0.0; n * n],
            product: vec![0.0; n * n],
            spd: Spd::new(n),
        }
    }

    /// Takes another size; allocates nothing when it is no larger than the first.
    pub(super) fn resize(&mut self, n: usize) {
        self.n = n;
        for square in [&mut self.m, &mut self.inverse, &mut self.product] {
            square.resize(n * n, 0.0);
        }
        self.spd.resize(n);
    }

    /// y ← y^½, for y − I positive semi-definite. False when it is not, or not finite.
    pub(super) fn in_place(&mut self, y: &mut [f64]) -> bool {
        let n = self.n;
        let mut bound = 1f64;
        for line in y.chunks_exact(n) {
            let sum = line.iter().map(|x| x.abs()).sum::<f64>();
            if !sum.is_finite() {
                return false;
            }
            bound = bound.max(sum);
        }
        self.m.copy_from_slice(y);
        for round in 0..MAX_ITERATIONS {
            if bound - 1.0 <= SERIES {
                break;
            }
            if !self.spd.factorise(&self.m) {
                return false;
            }
            self.spd.inverse_into(&mut self.inverse);
            let root = bound.sqrt();
            if round == 0 {
                // Y M⁻¹ = I.
                self.product.fill(0.0);
                self.product
                    .iter_mut()
                    .step_by(n + 1)
                    .for_each(|x| *x = 1.0);
            } else {
                times(&mut self.product, y, &self.inverse, n);
            }
            let half = 0.5 / root.sqrt();
            for (y, product) in y.iter_mut().zip(&self.product) {
                *y = half * (*y + root * product);
            }
            mirror(y, n);
            for (m, inverse) in self.m.iter_mut().zip(&self.inverse) {
                *m = 0.25 * (*m / root + root * inverse);
            }
            self.m.iter_mut().step_by(n + 1).for_each(|x| *x += 0.5);
            bound = 0.5 + 0.25 * (root + 1.0 / root);
        }
        self.finish(y);
        true
    }

    /// y ← y (I + E)^−½ with E = M − I: 1 − E/2 + 3E²/8 − 5E³/16.
    fn finish(&mut self, y: &mut [f64]) {
        let n = self.n;
        let e = &mut self.m;
        e.iter_mut().step_by(n + 1).for_each(|x| *x -= 1.0);
        times(&mut self.product, e, e, n);
        mirror(&mut self.product, n);
        for (square, e) in self.product.iter_mut().zip(e.iter()) {
            *square = 0.375 * e - 0.3125 * *square;
        }
        times(&mut self.inverse, e, &self.product, n);
        for (series, e) in self.inverse.iter_mut().zip(e.iter()) {
            *series -= 0.5 * e;
        }
        mirror(&mut self.inverse, n);
        times(&mut self.product, y, &self.inverse, n);
        for (y, product) in y.iter_mut().zip(&self.product) {
            *y += product;
        }
        mirror(y, n);
    }
}

/// The lower triangle of a product of two symmetric matrices that commute.
fn times(out: &mut [f64], a: &[f64], b: &[f64], n: usize) {
    multiply_lower(
        ViewMut::new(out, n, n),
        View::new(a, n, n),
        View::new(b, n, n),
    );
}

#[cfg(test)]
mod tests {
    use super::*;
    use taxel_linalg::multiply;

    #[test]
    fn the_root_times_itself_is_the_matrix() {
        for (n, size) in [(1, 3.0), (5, 1e-9), (40, 0.1), (40, 30.0), (64, 1e5)] {
            let factor: Vec<f64> = (0..n * n).map(|i| (i as f64 * 0.7).sin()).collect();
            let (mut matrix, mut back) = (vec![0.0; n * n], vec![0.0; n * n]);
            let a = View::new(&factor, n, n);
            multiply(ViewMut::new(&mut matrix, n, n), a, a.transpose());
            for (i, x) in matrix.iter_mut().enumerate() {
                *x = *x * size / n as f64 + f64::from(u8::from(i % (n + 1) == 0));
            }
            let mut root = matrix.clone();
            assert!(SquareRoot::new(n).in_place(&mut root));
            let a = View::new(&root, n, n);
            multiply(ViewMut::new(&mut back, n, n), a, a);
            let most = matrix.iter().fold(0f64, |most, x| most.max(x.abs()));
            for (found, expected) in back.iter().zip(&matrix) {
                assert!((found - expected).abs() < 1e-11 * most, "{n} {size}");
            }
        }
    }

    #[test]
    fn what_is_not_finite_is_refused() {
        assert!(!SquareRoot::new(2).in_place(&mut [f64::NAN, 0.0, 0.0, 1.0]));
        assert!(!SquareRoot::new(2).in_place(&mut [f64::INFINITY, 0.0, 0.0, 1.0]));
    }
}
