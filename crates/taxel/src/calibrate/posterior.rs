//! Least squares with priors: the most probable parameters, and their covariance.
//!
//! Levenberg's (1944) and Marquardt's (1963) steps over residuals in standard deviations, Huber's weights (1964) on
//! those of the data; a prior is a residual that has no outliers. Parameters may have a least value.

use super::least_squares::{differences, normal_equations, solve, weights};
use taxel_linalg::inverse_symmetric;

/// A parameter: where to start, its difference step, what is believed of it, its least value, and how far it goes at once.
#[derive(Debug, Clone, Copy)]
pub(super) struct Parameter {
    pub(super) start: f64,
    pub(super) step: f64,
    /// Mean and standard deviation.
    pub(super) prior: Option<(f64, f64)>,
    pub(super) least: f64,
    /// It moves no further in one step.
    pub(super) most_step: f64,
}

/// The most probable parameters.
#[derive(Debug, Clone)]
pub(super) struct Peak {
    pub(super) at: Vec<f64>,
    pub(super) covariance: Vec<Vec<f64>>,
    /// Loss of the data (Huber's) and of the priors.
    pub(super) data_loss: f64,
    pub(super) prior_loss: f64,
}

impl Peak {
    pub(super) fn loss(&self) -> f64 {
        self.data_loss + self.prior_loss
    }

    /// Standard error of a parameter.
    pub(super) fn error(&self, i: usize) -> f64 {
        self.covariance[i][i].max(0.0).sqrt()
    }

    /// Which part of what is known of a parameter was believed before: of 1/C_ii = vᵀ C⁻¹ v, with v = C e/C_ii the way in
    /// which the others follow it, what the priors add.
    pub(super) fn share_of_beliefs(&self, i: usize, parameters: &[Parameter]) -> f64 {
        let own = self.covariance[i][i];
        let follows = self.covariance[i].iter().map(|c| c / own);
        let believed = parameters.iter().zip(follows).map(|(p, v)| {
            let sd = p.prior.map_or(f64::INFINITY, |prior| prior.1);
            (v / sd).powi(2)
        });
        (own * believed.sum::<f64>()).clamp(0.0, 1.0)
    }
}

const MAX_ITERATIONS: usize = 60;
/// Residuals beyond this many standard deviations count linearly.
pub(super) const HUBER: f64 = 3.0;
/// A relative gain of the loss below this ends the search.
const SETTLED: f64 = 1e-8;

/// The parameters that make residuals and priors least, from `start`. The residual function answers nothing where the
/// parameters are impossible; so does this where the start is.
pub(super) fn most_probable(
    parameters: &[Parameter],
    mut residuals: impl FnMut(&[f64]) -> Option<Vec<f64>>,
) -> Option<Peak> {
    let mut at: Vec<f64> = parameters.iter().map(|p| p.start.max(p.least)).collect();
    let mut now = residuals(&at)?;
    let mut damping = 1e-3;
    let steps: Vec<f64> = parameters.iter().map(|p| p.step).collect();
    let mut jacobian = differences(&at, &steps, &now, &mut residuals)?;
    let mut settled = 0;
    for _ in 0..MAX_ITERATIONS {
        let before = total(parameters, &at, &now);
        let Some((there, moved)) = better(
            parameters,
            (&at, &now, before),
            &jacobian,
            &mut damping,
            &mut residuals,
        ) else {
            break;
        };
        let gain = before - total(parameters, &there, &moved);
        (at, now) = (there, moved);
        jacobian = differences(&at, &steps, &now, &mut residuals)?;
        settled = if gain <= SETTLED * (1.0 + before) {
            settled + 1
        } else {
            0
        };
        if settled == 2 {
            break;
        }
    }
    finish(parameters, at, now, &jacobian)
}

/// What the priors add to the loss at a point.
pub(super) fn prior_loss(parameters: &[Parameter], at: &[f64]) -> f64 {
    let one =
        |(p, x): (&Parameter, &f64)| p.prior.map_or(0.0, |(mean, sd)| ((x - mean) / sd).powi(2));
    parameters.iter().zip(at).map(one).sum()
}

fn total(parameters: &[Parameter], at: &[f64], residuals: &[f64]) -> f64 {
    weights(residuals, HUBER).1 + prior_loss(parameters, at)
}

/// Normal equations of data and priors, without the parameters that rest on their least value.
fn equations(
    parameters: &[Parameter],
    at: &[f64],
    now: &[f64],
    jacobian: &[Vec<f64>],
    resting: &[bool],
) -> (Vec<f64>, Vec<f64>) {
    let n = parameters.len();
    let (weight, _) = weights(now, HUBER);
    let rows: Vec<&[f64]> = jacobian.iter().map(Vec::as_slice).collect();
    let (mut normal, mut right) = normal_equations(&rows, now, &weight);
    for (i, p) in parameters.iter().enumerate() {
        if let Some((mean, sd)) = p.prior {
            normal[i * n + i] += 1.0 / (sd * sd);
            right[i] -= (at[i] - mean) / (sd * sd);
        }
    }
    for (i, _) in resting.iter().enumerate().filter(|r| *r.1) {
        for j in 0..n {
            normal[i * n + j] = 0.0;
            normal[j * n + i] = 0.0;
        }
        normal[i * n + i] = 1.0;
        right[i] = 0.0;
    }
    (normal, right)
}

/// A step that lowers the loss, longer or shorter as it has to be.
fn better(
    parameters: &[Parameter],
    (at, now, before): (&[f64], &[f64], f64),
    jacobian: &[Vec<f64>],
    damping: &mut f64,
    residuals: &mut impl FnMut(&[f64]) -> Option<Vec<f64>>,
) -> Option<(Vec<f64>, Vec<f64>)> {
    let free = vec![false; at.len()];
    let (_, right) = equations(parameters, at, now, jacobian, &free);
    let pressed = |i: usize| at[i] <= parameters[i].least && right[i] < 0.0;
    let resting: Vec<bool> = (0..at.len()).map(pressed).collect();
    let (normal, right) = equations(parameters, at, now, jacobian, &resting);
    for _ in 0..16 {
        if let Some(step) = solve(&normal, &right, *damping) {
            // Shorter as a whole, so that it leads where it led.
            let each = step.iter().zip(parameters);
            let length = each.fold(1.0, |length: f64, (step, parameter)| {
                length.min(parameter.most_step / step.abs())
            });
            let there: Vec<f64> = (0..at.len())
                .map(|i| (at[i] + length * step[i]).max(parameters[i].least))
                .collect();
            if let Some(moved) = residuals(&there)
                && total(parameters, &there, &moved) <= before
            {
                *damping *= 0.1;
                return Some((there, moved));
            }
        }
        *damping = damping.max(1e-9) * 8.0;
    }
    None
}

fn finish(
    parameters: &[Parameter],
    at: Vec<f64>,
    now: Vec<f64>,
    jacobian: &[Vec<f64>],
) -> Option<Peak> {
    let free = vec![false; at.len()];
    let (normal, _) = equations(parameters, &at, &now, jacobian, &free);
    let inverse = inverse_symmetric(&normal, at.len())?;
    let rows = inverse.chunks_exact(at.len().max(1));
    let covariance: Vec<Vec<f64>> = rows.map(<[f64]>::to_vec).collect();
    covariance
        .iter()
        .flatten()
        .all(|c| c.is_finite())
        .then(|| Peak {
            data_loss: weights(&now, HUBER).1,
            prior_loss: prior_loss(parameters, &at),
            covariance,
            at,
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parameter(start: f64, prior: Option<(f64, f64)>, least: f64) -> Parameter {
        Parameter {
            start,
            step: 1e-6,
            prior,
            least,
            most_step: f64::INFINITY,
        }
    }

    /// From far off, where a full step would leave the region in which anything is told.
    #[test]
    fn no_step_is_longer_than_its_parameter_allows() {
        let ln_2 = f64::ln(2.0);
        let parameters = [
            Parameter {
                most_step: ln_2,
                ..parameter(0.0, None, f64::NEG_INFINITY)
            },
            parameter(1.0, None, f64::NEG_INFINITY),
        ];
        let mut tried = vec![0.0];
        let peak = most_probable(&parameters, |x| {
            if !tried.contains(&x[0]) {
                tried.push(x[0]);
            }
            Some(vec![x[0] - 5.0, x[0] + x[1]])
        })
        .unwrap();
        assert!((peak.at[0] - 5.0).abs() < 1e-4 && (peak.at[1] + 5.0).abs() < 1e-4);
        let longest = tried.windows(2).map(|pair| (pair[1] - pair[0]).abs());
        let longest = longest.fold(0.0, f64::max);
        assert!(longest < ln_2 + 1e-5, "{longest}");
        assert!(tried.len() > 8, "{}", tried.len());
    }

    #[test]
    fn what_data_do_not_tell_the_prior_does() {
        let parameters = [
            parameter(5.0, Some((1.0, 0.5)), f64::NEG_INFINITY),
            parameter(-3.0, Some((1.0, 0.5)), f64::NEG_INFINITY),
        ];
        // Only the sum is told.
        let peak = most_probable(&parameters, |x| Some(vec![(x[0] + x[1] - 4.0) / 1e-3])).unwrap();
        for i in 0..2 {
            assert!((peak.at[i] - 2.0).abs() < 1e-4, "{:?}", peak.at);
            assert!((peak.error(i) - 0.5 / f64::sqrt(2.0)).abs() < 1e-3);
            // Their difference is all belief.
            assert!((peak.share_of_beliefs(i, &parameters) - 1.0).abs() < 1e-4);
        }
        let told = most_probable(&parameters, |x| Some(vec![x[0] - 4.0, x[1] / 0.1])).unwrap();
        let shares = [0, 1].map(|i| told.share_of_beliefs(i, &parameters));
        assert!((shares[0] - 0.8).abs() < 1e-4 && (shares[1] - 1.0 / 26.0).abs() < 1e-4);
    }

    #[test]
    fn a_least_value_holds_and_the_rest_goes_on() {
        let parameters = [parameter(1.0, None, 0.0), parameter(0.0, None, -9.0)];
        let peak =
            most_probable(&parameters, |x| Some(vec![x[0] + 1.0, x[0] + x[1] - 2.0])).unwrap();
        assert_eq!(peak.at[0], 0.0);
        assert!((peak.at[1] - 2.0).abs() < 1e-6, "{:?}", peak.at);
    }
}
