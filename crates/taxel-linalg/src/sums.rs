//! Sums over slices.

/// Copies the lower triangle of a row-major n×n matrix to the upper one.
#[inline]
pub fn mirror(values: &mut [f64], n: usize) {
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
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; LANES];
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<LANES>(), b.as_chunks::<LANES>());
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(x, y)| x * y).sum();
    for (x, y) in a.iter().zip(b) {
        for i in 0..LANES {
            sums[i] += x[i] * y[i];
        }
    }
    rest + sums.iter().sum::<f64>()
}

/// Σ a.
#[inline(always)]
pub fn sum(a: &[f64]) -> f64 {
    let mut sums = [0.0; LANES];
    let (a, rest) = a.as_chunks::<LANES>();
    for x in a {
        for i in 0..LANES {
            sums[i] += x[i];
        }
    }
    rest.iter().sum::<f64>() + sums.iter().sum::<f64>()
}
