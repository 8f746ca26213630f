//! Robust non-linear least squares for a handful of parameters: Levenberg (1944) and Marquardt (1963) with
//! Huber's weights (1964) and differences for the derivative.

use taxel_linalg::{inverse_symmetric, solve_symmetric};

/// The answer of [`fit`].
#[derive(Debug, Clone)]
pub(super) struct Fit {
    pub(super) parameters: Vec<f64>,
    /// Covariance of the parameters, from the residuals' own scatter.
    pub(super) covariance: Vec<Vec<f64>>,
    /// Residuals at the answer.
    pub(super) residuals: Vec<f64>,
    /// Derivative of each residual by each parameter at the answer.
    pub(super) jacobian: Vec<Vec<f64>>,
}

/// How to fit.
#[derive(Debug, Clone, Copy)]
pub(super) struct Settings {
    /// Residuals beyond this many standard deviations count linearly.
    pub(super) huber: f64,
    /// The standard deviation, where residuals come scaled; else a robust one of theirs.
    pub(super) scale: Option<f64>,
    pub(super) iterations: usize,
    /// Stops when no parameter moves by more than this many of its difference steps.
    pub(super) precision: f64,
}

impl Settings {
    fn limit(&self, residuals: &[f64]) -> f64 {
        self.huber * self.scale.unwrap_or_else(|| robust_deviation(residuals))
    }
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            huber: 2.0,
            scale: None,
            iterations: 40,
            precision: 1e-4,
        }
    }
}

/// [`crate::stats::robust_deviation`] of a list.
pub(super) fn robust_deviation(values: &[f64]) -> f64 {
    crate::stats::robust_deviation(values.iter().copied())
}

/// Median; 0 for nothing.
pub(super) fn median(values: &[f64]) -> f64 {
    crate::stats::median(values.iter().copied()).unwrap_or(0.0)
}

/// Median slope between all pairs of points (Theil 1950, Sen 1968); nothing for points above one another.
pub(super) fn theil_sen(points: &[(f64, f64)]) -> Option<f64> {
    let stride = points.len().div_ceil(300).max(1);
    let points: Vec<(f64, f64)> = points.iter().step_by(stride).copied().collect();
    let mut slopes = Vec::new();
    for (i, a) in points.iter().enumerate() {
        for b in &points[..i] {
            if (a.0 - b.0).abs() > 0.02 {
                slopes.push((a.1 - b.1) / (a.0 - b.0));
            }
        }
    }
    (!slopes.is_empty()).then(|| median(&slopes))
}

/// Huber's weights of residuals at a scale, and the loss.
pub(super) fn weights(residuals: &[f64], limit: f64) -> (Vec<f64>, f64) {
    let mut loss = 0.0;
    let weights = residuals
        .iter()
        .map(|r| {
            let size = r.abs();
            if size <= limit || limit == 0.0 {
                loss += r * r;
                1.0
            } else {
                loss += limit * (2.0 * size - limit);
                limit / size
            }
        })
        .collect();
    (weights, loss)
}

/// One Gauss–Newton step over the residuals for which `keep` holds: −(JᵀWJ)⁻¹JᵀWr.
pub(super) fn step(
    jacobian: &[Vec<f64>],
    residuals: &[f64],
    settings: Settings,
    keep: impl Fn(usize) -> bool,
) -> Option<Vec<f64>> {
    let kept: Vec<usize> = (0..residuals.len()).filter(|&i| keep(i)).collect();
    let chosen: Vec<f64> = kept.iter().map(|&i| residuals[i]).collect();
    let (weight, _) = weights(&chosen, settings.limit(&chosen));
    let rows: Vec<&[f64]> = kept.iter().map(|&i| jacobian[i].as_slice()).collect();
    let (normal, right) = normal_equations(&rows, &chosen, &weight);
    solve(&normal, &right, 0.0)
}

/// JᵀWJ of rows of J, row-major and only its lower triangle, and −JᵀWr.
pub(super) fn normal_equations(
    rows: &[&[f64]],
    residuals: &[f64],
    weight: &[f64],
) -> (Vec<f64>, Vec<f64>) {
    let n = rows.first().map_or(0, |row| row.len());
    let (mut products, mut sums) = (vec![0.0; n * n], vec![0.0; n]);
    for ((row, r), w) in rows.iter().zip(residuals).zip(weight) {
        for (i, (a, sum)) in row.iter().zip(&mut sums).enumerate() {
            let weighted = w * a;
            *sum -= weighted * r;
            for (product, b) in products[i * n..][..=i].iter_mut().zip(*row) {
                *product += weighted * b;
            }
        }
    }
    (products, sums)
}

pub(super) fn solve(normal: &[f64], right: &[f64], damping: f64) -> Option<Vec<f64>> {
    let mut damped = normal.to_vec();
    for of_itself in damped.iter_mut().step_by(right.len() + 1) {
        *of_itself += damping * *of_itself + 1e-300;
    }
    let step = solve_symmetric(&damped, right)?;
    step.iter().all(|x| x.is_finite()).then_some(step)
}

/// Fits from `start`; `steps` are the differences for the derivative, in each parameter's unit. The residual
/// function answers nothing where the parameters are impossible.
pub(super) fn fit(
    start: &[f64],
    steps: &[f64],
    settings: Settings,
    mut residuals: impl FnMut(&[f64]) -> Option<Vec<f64>>,
) -> Option<Fit> {
    let n = start.len();
    let mut at = start.to_vec();
    let mut now = residuals(&at)?;
    let mut damping = 1e-4;
    let mut jacobian = Vec::new();
    for round in 0..=settings.iterations {
        jacobian = differences(&at, steps, &now, &mut residuals)?;
        if round == settings.iterations {
            break;
        }
        let limit = settings.limit(&now);
        let (weight, loss) = weights(&now, limit);
        let rows: Vec<&[f64]> = jacobian.iter().map(Vec::as_slice).collect();
        let (normal, right) = normal_equations(&rows, &now, &weight);
        let mut moved = None;
        for _ in 0..12 {
            let Some(step) = solve(&normal, &right, damping) else {
                damping = damping.max(1e-8) * 10.0;
                continue;
            };
            let trial: Vec<f64> = at.iter().zip(&step).map(|(x, s)| x + s).collect();
            if let Some(there) = residuals(&trial)
                && weights(&there, limit).1 <= loss
            {
                moved = Some((trial, there, step));
                damping *= 0.1;
                break;
            }
            damping = damping.max(1e-8) * 10.0;
        }
        let Some((trial, there, step)) = moved else {
            break;
        };
        at = trial;
        now = there;
        // So near, the derivative is the same.
        if (0..n).all(|i| step[i].abs() <= settings.precision * steps[i]) {
            break;
        }
    }
    Some(finish(at, now, jacobian, settings))
}

/// The derivative of residuals by parameters, one-sided differences by these steps.
pub(super) fn differences(
    at: &[f64],
    steps: &[f64],
    now: &[f64],
    residuals: &mut impl FnMut(&[f64]) -> Option<Vec<f64>>,
) -> Option<Vec<Vec<f64>>> {
    let mut jacobian = vec![vec![0.0; at.len()]; now.len()];
    for i in 0..at.len() {
        // The other side of the point, where this one is impossible.
        let (moved, step) = [steps[i], -steps[i]].into_iter().find_map(|step| {
            let mut there = at.to_vec();
            there[i] += step;
            residuals(&there).map(|moved| (moved, step))
        })?;
        for (row, (moved, now)) in jacobian.iter_mut().zip(moved.iter().zip(now)) {
            row[i] = (moved - now) / step;
        }
    }
    Some(jacobian)
}

fn finish(at: Vec<f64>, residuals: Vec<f64>, jacobian: Vec<Vec<f64>>, settings: Settings) -> Fit {
    let n = at.len();
    let (weight, loss) = weights(&residuals, settings.limit(&residuals));
    let rows: Vec<&[f64]> = jacobian.iter().map(Vec::as_slice).collect();
    let (normal, _) = normal_equations(&rows, &residuals, &weight);
    let freedom = residuals.len().saturating_sub(n).max(1) as f64;
    let scatter = loss / freedom;
    let covariance = match inverse_symmetric(&normal, n) {
        Some(inverse) => inverse
            .chunks_exact(n.max(1))
            .map(|row| row.iter().map(|x| scatter * x).collect())
            .collect(),
        None => vec![vec![f64::INFINITY; n]; n],
    };
    Fit {
        parameters: at,
        covariance,
        residuals,
        jacobian,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curve_with_an_outlier_is_found_with_its_errors() {
        let x: Vec<f64> = (0..40).map(|i| f64::from(i) / 10.0).collect();
        let mut y: Vec<f64> = x
            .iter()
            .map(|x| 2.0 * (-0.7 * x).exp() + 1e-3 * (37.0 * x).sin())
            .collect();
        y[7] += 5.0;
        let fit = fit(&[1.0, -0.1], &[1e-5, 1e-5], Settings::default(), |p| {
            Some(
                x.iter()
                    .zip(&y)
                    .map(|(x, y)| p[0] * (p[1] * x).exp() - y)
                    .collect(),
            )
        })
        .unwrap();
        for (found, truth) in fit.parameters.iter().zip([2.0, -0.7]) {
            assert!((found - truth).abs() < 3e-3, "{found} against {truth}");
        }
        assert!(fit.covariance[0][0].sqrt() < 0.1);
    }
}
