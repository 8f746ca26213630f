//! Restarted GMRES (Saad and Schultz 1986) for the matrix-free Newton step.

use taxel_linalg::dot;

/// Memory for systems of one size.
pub(crate) struct Gmres {
    length: usize,
    depth: usize,
    basis: Vec<Vec<f64>>,
    hessenberg: Vec<f64>,
    cosines: Vec<f64>,
    sines: Vec<f64>,
    right: Vec<f64>,
}

impl Gmres {
    pub(crate) fn new(length: usize, depth: usize) -> Self {
        Self {
            length,
            depth,
            basis: vec![vec![0.0; length]; depth + 1],
            hessenberg: vec![0.0; (depth + 1) * depth],
            cosines: vec![0.0; depth],
            sines: vec![0.0; depth],
            right: vec![0.0; depth + 1],
        }
    }

    /// Improves `x` until |b − A x| ≤ `tolerance` · |b| or `restarts` cycles are spent; `apply(v, out)` is A.
    /// Returns the products taken and the relative residual reached.
    pub(crate) fn solve(
        &mut self,
        mut apply: impl FnMut(&[f64], &mut [f64]),
        b: &[f64],
        x: &mut [f64],
        tolerance: f64,
        restarts: usize,
    ) -> (u32, f64) {
        x.fill(0.0);
        let size = norm(b);
        if size == 0.0 {
            return (0, 0.0);
        }
        let (mut products, mut left) = (0, 1.0);
        for cycle in 0..restarts {
            if cycle == 0 {
                self.basis[0].copy_from_slice(b);
            } else {
                let (first, rest) = self.basis.split_at_mut(1);
                apply(x, &mut rest[0]);
                products += 1;
                for i in 0..self.length {
                    first[0][i] = b[i] - rest[0][i];
                }
            }
            let start = norm(&self.basis[0]);
            if start <= tolerance * size {
                return (products, start / size);
            }
            scale(&mut self.basis[0], 1.0 / start);
            self.right.fill(0.0);
            self.right[0] = start;
            let mut used = 0;
            for j in 0..self.depth {
                let (known, new) = self.basis.split_at_mut(j + 1);
                apply(&known[j], &mut new[0]);
                products += 1;
                used = j + 1;
                let exhausted = self.orthogonalise(j);
                left = self.right[j + 1].abs() / size;
                if left <= tolerance || exhausted {
                    break;
                }
            }
            self.update(x, used);
            if left <= tolerance {
                break;
            }
        }
        (products, left)
    }

    /// Gram–Schmidt (modified) of basis vector j+1 and the Givens rotation of its column. True when the
    /// space is exhausted.
    fn orthogonalise(&mut self, j: usize) -> bool {
        let depth = self.depth;
        let (known, new) = self.basis.split_at_mut(j + 1);
        let new = &mut new[0];
        for (i, old) in known.iter().enumerate() {
            let along = dot(new, old);
            self.hessenberg[i * depth + j] = along;
            for (a, b) in new.iter_mut().zip(old) {
                *a -= along * b;
            }
        }
        let height = norm(new);
        if height > 0.0 {
            scale(new, 1.0 / height);
        }
        for i in 0..j {
            let (a, b) = (
                self.hessenberg[i * depth + j],
                self.hessenberg[(i + 1) * depth + j],
            );
            self.hessenberg[i * depth + j] = self.cosines[i] * a + self.sines[i] * b;
            self.hessenberg[(i + 1) * depth + j] = self.cosines[i] * b - self.sines[i] * a;
        }
        let a = self.hessenberg[j * depth + j];
        let length = a.hypot(height);
        (self.cosines[j], self.sines[j]) = if length > 0.0 {
            (a / length, height / length)
        } else {
            (1.0, 0.0)
        };
        self.hessenberg[j * depth + j] = length;
        self.hessenberg[(j + 1) * depth + j] = 0.0;
        self.right[j + 1] = -self.sines[j] * self.right[j];
        self.right[j] *= self.cosines[j];
        if j + 1 < depth {
            self.hessenberg[(j + 1) * depth + j + 1] = 0.0;
        }
        height <= 1e-14 * length
    }

    fn update(&mut self, x: &mut [f64], used: usize) {
        let depth = self.depth;
        for i in (0..used).rev() {
            for k in i + 1..used {
                self.right[i] -= self.hessenberg[i * depth + k] * self.right[k];
            }
            let diagonal = self.hessenberg[i * depth + i];
            self.right[i] = if diagonal == 0.0 {
                0.0
            } else {
                self.right[i] / diagonal
            };
        }
        for (factor, vector) in self.right[..used].iter().zip(&self.basis) {
            for (x, v) in x.iter_mut().zip(vector) {
                *x += factor * v;
            }
        }
    }
}

pub(crate) fn norm(values: &[f64]) -> f64 {
    dot(values, values).sqrt()
}

/// The largest absolute value.
pub(super) fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |most, v| most.max(v.abs()))
}

fn scale(values: &mut [f64], factor: f64) {
    for value in values {
        *value *= factor;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unsymmetric_system_is_solved_across_restarts() {
        let n = 12;
        let apply = |v: &[f64], out: &mut [f64]| {
            for i in 0..n {
                out[i] = (2.0 + i as f64) * v[i] + 0.5 * v[(i + 1) % n] - 0.3 * v[(i + 5) % n];
            }
        };
        let b: Vec<f64> = (0..n).map(|i| (i as f64).sin()).collect();
        let (mut x, mut back) = (vec![0.0; n], vec![0.0; n]);
        let (_, left) = Gmres::new(n, 5).solve(apply, &b, &mut x, 1e-12, 40);
        apply(&x, &mut back);
        assert!(left <= 1e-12);
        for (a, b) in back.iter().zip(&b) {
            assert!((a - b).abs() < 1e-10);
        }
    }
}
