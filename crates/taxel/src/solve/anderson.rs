//! Anderson's mixing of a fixed-point iteration (Anderson 1965; Walker and Ni 2011): the next point is the
//! combination of the last few that leaves the smallest residual.

use taxel_linalg::{Number, dot, wide};

/// The last few points of an iteration, and how to combine them.
pub(super) struct Anderson<T = f64> {
    depth: usize,
    last_image: Vec<T>,
    last_residual: Vec<T>,
    image_steps: Vec<Vec<T>>,
    residual_steps: Vec<Vec<T>>,
    /// Products of the residual's steps with each other.
    products: [[f64; MAX]; MAX],
    /// Steps kept, and the slot that the next one takes.
    kept: usize,
    slot: usize,
    /// Whether the last point belongs to the present iteration.
    following: bool,
    /// Whether the last step was mixed with others.
    is_mixed: bool,
}

impl<T: Kept> Anderson<T> {
    pub(super) fn new(depth: usize, length: usize) -> Self {
        let line = || vec![T::default(); length];
        Self {
            depth,
            last_image: line(),
            last_residual: line(),
            image_steps: (0..depth).map(|_| line()).collect(),
            residual_steps: (0..depth).map(|_| line()).collect(),
            products: [[0.0; MAX]; MAX],
            kept: 0,
            slot: 0,
            following: false,
            is_mixed: false,
        }
    }

    /// Forgets everything and takes another length; allocates nothing when it is no larger than the first.
    pub(super) fn resize(&mut self, length: usize) {
        for vector in self.vectors() {
            vector.resize(length, T::default());
        }
        self.restart();
    }

    fn vectors(&mut self) -> impl Iterator<Item = &mut Vec<T>> {
        let steps = self.image_steps.iter_mut().chain(&mut self.residual_steps);
        steps.chain([&mut self.last_image, &mut self.last_residual])
    }

    /// Forgets the points so far.
    pub(super) fn restart(&mut self) {
        self.kept = 0;
        self.slot = 0;
        self.following = false;
        self.is_mixed = false;
    }

    /// Starts another iteration whose map differs little: the steps seen so far still tell its slope.
    pub(super) fn resume(&mut self) {
        self.following = false;
    }

    /// Goes back to where the last point led by itself, and forgets the points so far. False where it has been mixed with none.
    pub(super) fn retreat(&mut self, point: &mut [T]) -> bool {
        let was_mixed = self.is_mixed;
        if was_mixed {
            point.copy_from_slice(&self.last_image);
            self.restart();
        }
        was_mixed
    }

    /// From a point and its image to the next point, written over `point`.
    pub(super) fn advance(&mut self, point: &mut [T], image: &[T]) {
        let mut right = [0.0; MAX];
        wide(
            #[inline(always)]
            || self.look_at(point, image, &mut right),
        );
        let kept = self.kept;
        let mut system = self.products;
        for (a, line) in system[..kept].iter_mut().enumerate() {
            line[a] *= 1.0 + T::RIDGE;
        }
        self.is_mixed = kept > 0 && solve_small(&mut system, &mut right, kept);
        if !self.is_mixed {
            point.copy_from_slice(image);
            return;
        }
        wide(
            #[inline(always)]
            || {
                let (first, more) = self.image_steps[..kept].split_at(1);
                subtract(point, image, T::of(right[0]), &first[0]);
                for (factor, steps) in right[1..].iter().zip(more) {
                    let factor = T::of(*factor);
                    for (x, step) in point.iter_mut().zip(steps) {
                        *x -= factor * *step;
                    }
                }
            },
        );
    }

    /// The residual of a point and the step to it from the last one; what the residual's steps have to do with it.
    #[inline(always)]
    fn look_at(&mut self, point: &[T], image: &[T], right: &mut [f64; MAX]) {
        if self.following {
            let slot = self.slot;
            self.slot = (slot + 1) % self.depth;
            self.kept = (self.kept + 1).min(self.depth);
            step_from(
                (point, image),
                (&mut self.last_image, &mut self.last_residual),
                (&mut self.image_steps[slot], &mut self.residual_steps[slot]),
            );
            for other in 0..self.kept {
                let product = dot(&self.residual_steps[slot], &self.residual_steps[other]);
                self.products[slot][other] = product.double();
                self.products[other][slot] = product.double();
            }
        } else {
            self.following = true;
            self.last_image.copy_from_slice(image);
            for ((residual, image), point) in self.last_residual.iter_mut().zip(image).zip(point) {
                *residual = *image - *point;
            }
        }
        for (right, step) in right.iter_mut().zip(&self.residual_steps[..self.kept]) {
            *right = dot(step, &self.last_residual).double();
        }
    }
}

/// Numbers that steps are kept in.
pub(super) trait Kept: Number {
    /// Makes steps that are one another's multiples, as far as their digits tell, count once.
    const RIDGE: f64;
}

impl Kept for f32 {
    const RIDGE: f64 = 1e-5;
}

impl Kept for f64 {
    const RIDGE: f64 = 1e-12;
}

const MAX: usize = 5;

/// Residual and image of a point in the place of the last ones, and the steps to them.
#[inline(always)]
fn step_from<T: Number>(
    (point, image): (&[T], &[T]),
    (last_image, last_residual): (&mut [T], &mut [T]),
    (image_step, residual_step): (&mut [T], &mut [T]),
) {
    let n = point.len();
    let (image, image_step, residual_step) =
        (&image[..n], &mut image_step[..n], &mut residual_step[..n]);
    let (last_image, last_residual) = (&mut last_image[..n], &mut last_residual[..n]);
    for i in 0..n {
        let residual = image[i] - point[i];
        image_step[i] = image[i] - last_image[i];
        residual_step[i] = residual - last_residual[i];
        last_image[i] = image[i];
        last_residual[i] = residual;
    }
}

/// out ← a − factor · b.
#[inline(always)]
fn subtract<T: Number>(out: &mut [T], a: &[T], factor: T, b: &[T]) {
    for ((out, a), b) in out.iter_mut().zip(a).zip(b) {
        *out = *a - factor * *b;
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
