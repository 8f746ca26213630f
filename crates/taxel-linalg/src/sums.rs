//! Sums over slices.

use crate::Number;

/// Copies the lower triangle of a row-major n×n matrix to the upper one.
#[inline]
pub fn mirror<T: Copy>(values: &mut [T], n: usize) {
    for i in 1..n {
        for j in 0..i {
            values[j * n + i] = values[i * n + j];
        }
    }
}

/// Partial sums side by side, so that the compiler may use simd.
const LANES: usize = 8;

/// Σ a b.
#[inline(always)]
pub fn dot<T: Number>(a: &[T], b: &[T]) -> T {
    let mut sums = [T::default(); LANES];
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<LANES>(), b.as_chunks::<LANES>());
    let rest = a_rest.iter().zip(b_rest).map(|(x, y)| *x * *y);
    let rest = rest.fold(T::default(), T::add);
    for (x, y) in a.iter().zip(b) {
        for i in 0..LANES {
            sums[i] += x[i] * y[i];
        }
    }
    rest + sums.into_iter().fold(T::default(), T::add)
}

/// Σ a.
#[inline(always)]
pub fn sum<T: Number>(a: &[T]) -> T {
    let mut sums = [T::default(); LANES];
    let (a, rest) = a.as_chunks::<LANES>();
    for x in a {
        for i in 0..LANES {
            sums[i] += x[i];
        }
    }
    let rest = rest.iter().copied().fold(T::default(), T::add);
    rest + sums.into_iter().fold(T::default(), T::add)
}
