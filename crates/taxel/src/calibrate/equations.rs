//! The equations of unknowns that each listen to some of the evidence: Newton's matrix, and the covariance of their
//! answer.

use super::together::{Point, Residuals};
use taxel_linalg::{View, dot, inverse};

/// Rows of equations, row-major, one for each unknown, and their right sides; `hears`: how much of each kind of evidence an
/// unknown hears.
pub(super) fn equations(
    hears: &[[f64; 3]],
    point: &Point,
    slopes: &[Residuals],
    keep: &impl Fn(usize, usize) -> bool,
) -> (Vec<f64>, Vec<f64>) {
    let n = hears.len();
    let (mut matrix, mut right) = (vec![0.0; n * n], vec![0.0; n]);
    for (k, hears) in hears.iter().enumerate() {
        let believed = |other: &[f64]| dot(&slopes[k].beliefs, other);
        right[k] = -believed(&point.residuals.beliefs);
        for (l, other) in slopes.iter().enumerate() {
            matrix[k * n + l] = believed(&other.beliefs);
        }
        for (kind, share) in hears.iter().enumerate().filter(|(_, share)| **share > 0.0) {
            let weighted: Vec<f64> = (slopes[k].of_terms[kind].iter().zip(&point.weights[kind]))
                .enumerate()
                .map(|(i, (slope, w))| {
                    if keep(kind, i) {
                        share * slope * w
                    } else {
                        0.0
                    }
                })
                .collect();
            right[k] -= dot(&weighted, &point.residuals.of_terms[kind]);
            for (l, other) in slopes.iter().enumerate() {
                matrix[k * n + l] += dot(&weighted, &other.of_terms[kind]);
            }
        }
    }
    (matrix, right)
}

/// A few equations, scaled so that units do not matter.
pub(super) fn solve(matrix: &[f64], right: &[f64]) -> Option<Vec<f64>> {
    let n = right.len();
    let size = |k: usize| matrix[k * n + k].abs().sqrt().max(1e-150);
    let mut scaled = matrix.to_vec();
    for k in 0..n {
        for l in 0..n {
            scaled[k * n + l] /= size(k) * size(l);
        }
        scaled[k * n + k] += 1e-9;
    }
    let inverse = inverse(View::new(&scaled, n, n));
    let step: Vec<f64> = (0..n)
        .map(|k| {
            (0..n)
                .map(|l| inverse[k * n + l] * right[l] / (size(k) * size(l)))
                .sum()
        })
        .collect();
    step.iter().all(|x: &f64| x.is_finite()).then_some(step)
}

/// A⁻¹ B A⁻ᵀ, row-major.
pub(super) fn covariance(hears: &[[f64; 3]], point: &Point, slopes: &[Residuals]) -> Vec<f64> {
    let n = hears.len();
    let (matrix, _) = equations(hears, point, slopes, &|_, _| true);
    let size: Vec<f64> = (0..n)
        .map(|k| matrix[k * n + k].abs().sqrt().max(1e-150))
        .collect();
    let mut scaled = matrix.clone();
    for k in 0..n {
        for l in 0..n {
            scaled[k * n + l] /= size[k] * size[l];
        }
        if matrix[k * n + k] == 0.0 {
            // Nothing depends on it.
            scaled[k * n + k] = 1.0;
        }
    }
    let inverse = inverse(View::new(&scaled, n, n));
    let between = information(hears, point, slopes);
    let between: Vec<f64> = (0..n * n)
        .map(|i| between.iter().map(|kind| kind[i]).sum())
        .collect();
    let mut out = vec![0.0; n * n];
    for i in 0..n {
        for j in 0..n {
            let mut sum = 0.0;
            for k in 0..n {
                for l in 0..n {
                    sum += inverse[i * n + k] * between[k * n + l] * inverse[j * n + l]
                        / (size[k] * size[l]);
                }
            }
            out[i * n + j] = sum / (size[i] * size[j]);
        }
    }
    out
}

/// What the three kinds of evidence, and beliefs, say of the unknowns: n × n each, row-major. Evidence of different kinds is
/// independent, and beliefs are shared. What counts for less than it says is many that err together.
fn information(hears: &[[f64; 3]], point: &Point, slopes: &[Residuals]) -> [Vec<f64>; 4] {
    let n = hears.len();
    let mut kinds = [(); 4].map(|()| vec![0.0; n * n]);
    for (k, slope) in slopes.iter().enumerate() {
        for (kind, of_term) in slope.of_terms.iter().enumerate() {
            let weighted = of_term.iter().zip(&point.weights[kind]);
            let weighted: Vec<f64> = weighted.map(|(slope, w)| slope * w).collect();
            for (l, other) in slopes.iter().enumerate() {
                let share = (hears[k][kind] * hears[l][kind]).sqrt();
                if share > 0.0 {
                    kinds[kind][k * n + l] = share * dot(&weighted, &other.of_terms[kind]);
                }
            }
        }
        for (l, other) in slopes.iter().enumerate() {
            kinds[3][k * n + l] = dot(&slope.beliefs, &other.beliefs);
        }
    }
    kinds
}

/// For each unknown, the parts of what is known of it that come from the three kinds of evidence and from beliefs; they sum to 1.
/// With I the information of all and v = I⁻¹e/(I⁻¹)ₖₖ, the way in which the others follow this one, what is known of it is
/// 1/(I⁻¹)ₖₖ = vᵀ I v, a sum over the kinds.
pub(super) fn told_by(hears: &[[f64; 3]], point: &Point, slopes: &[Residuals]) -> Vec<[f64; 4]> {
    let n = hears.len();
    let kinds = information(hears, point, slopes);
    let all: Vec<f64> = (0..n * n)
        .map(|i| kinds.iter().map(|kind| kind[i]).sum())
        .collect();
    let quadratic = |matrix: &[f64], v: &[f64]| -> f64 {
        let rows = matrix.chunks_exact(n).zip(v);
        rows.map(|(row, v_k)| v_k * dot(row, v)).sum()
    };
    (0..n)
        .map(|k| {
            let mut unit = vec![0.0; n];
            unit[k] = 1.0;
            let follows = solve(&all, &unit).filter(|v| v[k] > 0.0);
            let Some(follows) = follows else {
                return [f64::NAN; 4];
            };
            let parts = kinds.each_ref().map(|kind| quadratic(kind, &follows));
            let sum: f64 = parts.iter().sum();
            parts.map(|part| part / sum)
        })
        .collect()
}
