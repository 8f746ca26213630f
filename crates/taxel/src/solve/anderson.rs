//! Anderson's mixing of a fixed-point iteration (Anderson 1965; Walker and Ni 2011): the next point is the
//! combination of the last few that leaves the smallest residual.

use taxel_linalg::{dot, wide};

/// The last few points of an iteration, and how to combine them.
pub(super) struct Anderson {
    depth: usize,
    length: usize,
    /// Weights of the residual's entries.
    weight: Vec<f64>,
    last_image: Vec<f64>,
    last_residual: Vec<f64>,
    residual: Vec<f64>,
    image_steps: Vec<Vec<f64>>,
    residual_steps: Vec<Vec<f64>>,
    /// Products of the residual's steps with each other.
    products: [[f64; MAX]; MAX],
    /// Steps kept, and the slot that the next one takes.
    kept: usize,
    slot: usize,
    /// Whether the last point belongs to the present iteration.
    following: bool,
}

impl Anderson {
    pub(super) fn new(depth: usize, length: usize) -> Self {
        Self {
            depth,
            length,
            weight: vec![1.0; length],
            last_image: vec![0.0; length],
            last_residual: vec![0.0; length],
            residual: vec![0.0; length],
            image_steps: vec![vec![0.0; length]; depth],
            residual_steps: vec![vec![0.0; length]; depth],
            products: [[0.0; MAX]; MAX],
            kept: 0,
            slot: 0,
            following: false,
        }
    }

    /// Forgets everything and takes another length; allocates nothing when it is no larger than the first.
    pub(super) fn resize(&mut self, length: usize) {
        self.length = length;
        let vectors = self.image_steps.iter_mut().chain(&mut self.residual_steps);
        for vector in vectors.chain([
            &mut self.weight,
            &mut self.last_image,
            &mut self.last_residual,
            &mut self.residual,
        ]) {
            vector.resize(length, 1.0);
        }
        self.restart();
    }

    /// Forgets the points so far.
    pub(super) fn restart(&mut self) {
        self.kept = 0;
        self.slot = 0;
        self.following = false;
    }

    /// Starts another iteration whose map differs little: the steps seen so far still tell its slope.
    pub(super) fn resume(&mut self) {
        self.following = false;
    }

    /// The weights of the residual's entries, to be set before a run.
    pub(super) fn weights_mut(&mut self) -> &mut [f64] {
        &mut self.weight
    }

    /// From a point and its image to the next point, written over `point`.
    pub(super) fn advance(&mut self, point: &mut [f64], image: &[f64]) {
        wide(
            #[inline(always)]
            || self.look_at(point, image),
        );
        point.copy_from_slice(image);
        self.following = true;
        let kept = self.kept;
        if kept == 0 {
            return;
        }
        let mut system = self.products;
        let mut right = [0.0; MAX];
        wide(
            #[inline(always)]
            || {
                for (right, step) in right.iter_mut().zip(&self.residual_steps[..kept]) {
                    *right = dot(step, &self.last_residual);
                }
            },
        );
        for (a, line) in system[..kept].iter_mut().enumerate() {
            line[a] *= 1.0 + 1e-12;
        }
        if !solve_small(&mut system, &mut right, kept) {
            return;
        }
        wide(
            #[inline(always)]
            || {
                for (factor, steps) in right.iter().zip(&self.image_steps[..kept]) {
                    for (x, step) in point.iter_mut().zip(steps) {
                        *x -= factor * step;
                    }
                }
            },
        );
    }

    /// The residual of a point, and the step to it from the last one.
    #[inline(always)]
    fn look_at(&mut self, point: &[f64], image: &[f64]) {
        for (((residual, image), point), weight) in self
            .residual
            .iter_mut()
            .zip(image)
            .zip(point)
            .zip(&self.weight)
        {
            *residual = (image - point) * weight;
        }
        if self.following {
            let slot = self.slot;
            self.slot = (slot + 1) % self.depth;
            self.kept = (self.kept + 1).min(self.depth);
            difference(&mut self.image_steps[slot], image, &self.last_image);
            let steps = &mut self.residual_steps[slot];
            difference(steps, &self.residual, &self.last_residual);
            for other in 0..self.kept {
                let product = dot(&self.residual_steps[slot], &self.residual_steps[other]);
                self.products[slot][other] = product;
                self.products[other][slot] = product;
            }
        }
        self.last_image.copy_from_slice(image);
        std::mem::swap(&mut self.last_residual, &mut self.residual);
    }
}

const MAX: usize = 5;

#[inline(always)]
fn difference(out: &mut [f64], a: &[f64], b: &[f64]) {
    for ((out, a), b) in out.iter_mut().zip(a).zip(b) {
        *out = a - b;
    }
}

/// Gaussian elimination without pivoting (the system is positive definite). False when it is singular.
fn solve_small(system: &mut [[f64; MAX]; MAX], right: &mut [f64; MAX], n: usize) -> bool {
    for i in 0..n {
        if system[i][i] <= 0.0 || !system[i][i].is_finite() {
            return false;
        }
        for j in i + 1..n {
            let factor = system[j][i] / system[i][i];
            let (above, below) = system.split_at_mut(j);
            for (value, pivot) in below[0][i..n].iter_mut().zip(&above[i][i..n]) {
                *value -= factor * pivot;
            }
            right[j] -= factor * right[i];
        }
    }
    for i in (0..n).rev() {
        for k in i + 1..n {
            right[i] -= system[i][k] * right[k];
        }
        right[i] /= system[i][i];
    }
    right[..n].iter().all(|x| x.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_linear_iteration_in_three_dimensions_ends_after_a_few_steps() {
        let image = |x: &[f64]| {
            vec![
                0.9 * x[0] + 0.2 * x[1] + 1.0,
                0.8 * x[1] - 0.3 * x[2],
                0.1 * x[0] + 0.7 * x[2] + 2.0,
            ]
        };
        let mut mixing = Anderson::new(3, 3);
        let mut x = vec![0.0; 3];
        for _ in 0..8 {
            let y = image(&x);
            mixing.advance(&mut x, &y);
        }
        for (x, y) in x.iter().zip(image(&x)) {
            assert!((x - y).abs() < 1e-9, "{x} {y}");
        }
    }
}
