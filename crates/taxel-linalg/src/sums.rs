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
#[inline]
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
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
#[inline]
pub fn sum(a: &[f64]) -> f64 {
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
