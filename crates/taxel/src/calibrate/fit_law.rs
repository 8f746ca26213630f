//! A load law from plain pairs of conductance and load.

use super::LawChoice;
use super::least_squares::{Fit, Settings, fit, median, theil_sen};
use super::suspects;
use super::{Parameter, Suspect};
use crate::material::LoadLaw;
use crate::material::Spline;

/// Laws that can be fitted, with their names in reports.
pub(super) const LAWS: [(LawChoice, &str); 3] = [
    (LawChoice::Power, "power"),
    (LawChoice::Saturating, "saturating"),
    (LawChoice::Spline, "spline"),
];

/// Parts that loads are left out in, at most, and pairs that each of their fits takes: thousands of readings would take
/// minutes to say the same.
const MAX_FOLDS: usize = 40;
const MAX_JUDGING: usize = 4000;
/// A saturation is told when it is this many standard errors from none.
const TOLD: f64 = 3.0;
/// Knots of the spline law.
const KNOTS: usize = 5;

/// Parameters of a law: ln factor, exponent, then 1/saturation (per kilogram) or the bends at the inner knots,
/// and last g_zero (in units of `g_unit`) where it is free.
struct Shape {
    choice: LawChoice,
    knots: Vec<f64>,
    g_zero: f64,
    g_unit: Option<f64>,
}

impl Shape {
    fn law(&self, p: &[f64]) -> Option<LoadLaw> {
        let g_zero = match self.g_unit {
            Some(unit) => unit * p[p.len() - 1],
            None => self.g_zero,
        };
        let mut law = LoadLaw::power(g_zero, p[0].exp(), p[1]);
        if !(0.05..20.0).contains(&p[1]) {
            return None;
        }
        match self.choice {
            LawChoice::Saturating => {
                if p[2] < 0.0 {
                    return None;
                }
                law.saturation_load_g = (p[2] > 1e-6).then(|| 1000.0 / p[2]);
            }
            LawChoice::Spline => {
                let mut bends = vec![0.0; self.knots.len()];
                let inner = bends.len() - 1;
                bends[1..inner].copy_from_slice(&p[2..inner + 1]);
                let spline = Spline::new(&self.knots, &bends).ok()?;
                let first = self.knots[0];
                let width = self.knots[inner] - first;
                // More load must mean more conductance, everywhere.
                if (0..=40).any(|i| p[1] + spline.at(first + width * f64::from(i) / 40.0).1 < 0.05)
                {
                    return None;
                }
                law.bend = Some(spline);
            }
            _ => {}
        }
        Some(law)
    }
}

/// Fits a law to pairs (siemens, grams); loads of 0 only serve g_zero. With `g_zero` given it is kept.
/// Residuals are loads in grams.
pub(super) fn fit_law(
    choice: LawChoice,
    pairs: &[(f64, f64)],
    g_zero: Option<f64>,
) -> Option<(LoadLaw, Fit)> {
    let least = pairs.iter().map(|p| p.0).fold(f64::INFINITY, f64::min);
    let shape = Shape {
        choice,
        knots: knots(pairs)?,
        g_zero: g_zero.unwrap_or(0.0),
        g_unit: g_zero.is_none().then_some(least.abs().max(1e-12)),
    };
    let start_zero = g_zero.unwrap_or(0.0);
    let logs: Vec<(f64, f64)> = pairs
        .iter()
        .filter(|p| p.1 > 0.0 && p.0 > start_zero)
        .map(|&(siemens, load)| (load.ln(), (siemens - start_zero).ln()))
        .collect();
    let slope = theil_sen(&logs)?;
    let offsets: Vec<f64> = logs.iter().map(|p| p.1 - slope * p.0).collect();
    let mut start = vec![median(&offsets), slope.clamp(0.1, 10.0)];
    let mut steps = vec![1e-5, 1e-5];
    match choice {
        LawChoice::Saturating => {
            start.push(0.05);
            steps.push(1e-4);
        }
        LawChoice::Spline => {
            start.extend(vec![0.0; shape.knots.len() - 2]);
            steps.extend(vec![1e-5; shape.knots.len() - 2]);
        }
        _ => {}
    }
    if shape.g_unit.is_some() {
        start.push(0.0);
        steps.push(1e-4);
    }
    if pairs.len() <= start.len() {
        return None;
    }
    let fitted = fit(&start, &steps, Settings::default(), |p| {
        let law = shape.law(p)?;
        let residuals: Vec<f64> = pairs
            .iter()
            .map(|&(siemens, load)| law.grams_from_siemens(0, siemens) - load)
            .collect();
        residuals.iter().all(|r| r.is_finite()).then_some(residuals)
    })?;
    Some((shape.law(&fitted.parameters)?, fitted))
}

fn knots(pairs: &[(f64, f64)]) -> Option<Vec<f64>> {
    let mut loads: Vec<f64> = pairs
        .iter()
        .map(|p| p.1)
        .filter(|&l| l > 0.0)
        .map(f64::ln)
        .collect();
    loads.sort_by(f64::total_cmp);
    if loads.len() < 3 {
        return None;
    }
    let mut knots: Vec<f64> = (0..KNOTS)
        .map(|i| loads[i * (loads.len() - 1) / (KNOTS - 1)])
        .collect();
    knots.dedup_by(|a, b| (*a - *b).abs() < 0.05);
    (knots.len() >= 2).then_some(knots)
}

/// One law fitted to plain pairs, and its error where it was not fitted.
#[derive(Debug, Clone, PartialEq)]
pub struct LawFit {
    /// `power`, `saturating`, `spline`.
    pub name: &'static str,
    /// The law fitted to all pairs.
    pub law: LoadLaw,
    /// Its numbers with their standard errors; those of a bend are not among them.
    pub parameters: Vec<Parameter>,
    /// Mean absolute error of loads left out of the fit that reads them, grams.
    pub held_out_mean_absolute_g: f64,
    /// Root mean square of the same, grams.
    pub held_out_root_mean_square_g: f64,
}

/// Every law fitted to all pairs (siemens, grams), none judged.
pub(super) fn fit_each(pairs: &[(f64, f64)]) -> Vec<LoadLaw> {
    let fitted = LAWS.iter().map(|&(choice, _)| fit_law(choice, pairs, None));
    fitted.flatten().map(|(law, _)| law).collect()
}

/// Fits every law to pairs (siemens, grams), best first. All pairs of one load are left out together, so
/// that repeated readings of a weight do not vouch for one another: one load at a time up to 40, more in 40 parts, each
/// judged by a fit to at most 4,000 of the others.
///
/// ```
/// use taxel::calibrate::fit_pairs;
/// let pairs: Vec<(f64, f64)> = (1..20)
///     .map(|i| f64::from(i) * 25.0)
///     .map(|load: f64| (1e-6 + 8e-6 * load.powf(0.85), load))
///     .collect();
/// let best = &fit_pairs(&pairs)[0];
/// assert!(best.held_out_mean_absolute_g < 0.01);
/// ```
pub fn fit_pairs(pairs: &[(f64, f64)]) -> Vec<LawFit> {
    let mut loads: Vec<f64> = pairs.iter().map(|p| p.1).collect();
    loads.sort_by(f64::total_cmp);
    loads.dedup();
    let folds = loads.len().min(MAX_FOLDS);
    let mut fits: Vec<LawFit> = LAWS
        .iter()
        .filter_map(|&(choice, name)| {
            let (law, fitted) = fit_law(choice, pairs, None)?;
            let parameters = parameters(&law, &fitted);
            let mut errors = Vec::new();
            for fold in 0..folds {
                let is_out = |load: f64| loads.partition_point(|l| *l < load) % folds == fold;
                let (held, kept): (Vec<_>, Vec<_>) =
                    pairs.iter().copied().partition(|p| is_out(p.1));
                let stride = kept.len().div_ceil(MAX_JUDGING);
                let kept: Vec<_> = kept.into_iter().step_by(stride.max(1)).collect();
                let (law, _) = fit_law(choice, &kept, None)?;
                errors
                    .extend(held.iter().map(|&(siemens, load)| {
                        law.grams_from_siemens(0, siemens).max(0.0) - load
                    }));
            }
            let n = errors.len() as f64;
            Some(LawFit {
                name,
                law,
                parameters,
                held_out_mean_absolute_g: errors.iter().map(|e| e.abs()).sum::<f64>() / n,
                held_out_root_mean_square_g: (errors.iter().map(|e| e * e).sum::<f64>() / n).sqrt(),
            })
        })
        .collect();
    fits.sort_by(|a, b| {
        a.held_out_mean_absolute_g
            .total_cmp(&b.held_out_mean_absolute_g)
    });
    // A saturation that cannot be told from none says no more than the power law.
    let determined = |fit: &LawFit| {
        let half = fit
            .parameters
            .iter()
            .find(|p| p.name == "material.saturation_load_g");
        half.is_some_and(|p| p.standard_error.is_some_and(|e| e < p.value / TOLD))
    };
    if fits
        .first()
        .is_some_and(|fit| fit.name == "saturating" && !determined(fit))
        && let Some(power) = fits.iter().position(|fit| fit.name == "power")
    {
        fits[..=power].rotate_right(1);
    }
    fits
}

/// Pairs (siemens, grams) that the others contradict, by their index: gross slips, such as a load in another unit or
/// swapped cells. More than a fifth of them are none.
///
/// ```
/// use taxel::calibrate::suspect_pairs;
/// let mut pairs: Vec<(f64, f64)> = (1..20)
///     .map(|i| (8e-6 * (25.0 * f64::from(i)).powf(0.85), 25.0 * f64::from(i)))
///     .collect();
/// pairs[4].1 /= 1000.0;
/// let found = suspect_pairs(&pairs);
/// assert_eq!((found.len(), found[0].press, found[0].unit()), (1, 4, Some("kg")));
/// ```
pub fn suspect_pairs(pairs: &[(f64, f64)]) -> Vec<Suspect> {
    let readings: Vec<(usize, f64, f64)> = pairs
        .iter()
        .enumerate()
        .map(|(i, &(siemens, load))| (i, load, siemens))
        .collect();
    let found = suspects::gross(&readings, None);
    if suspects::few(found.len(), pairs.len()) {
        found
    } else {
        Vec::new()
    }
}

/// The numbers of a fitted law.
fn parameters(law: &LoadLaw, fitted: &Fit) -> Vec<Parameter> {
    let error = |i: usize| fitted.covariance[i][i].max(0.0).sqrt();
    let factor = law.ln_scale[0].exp();
    let last = fitted.parameters.len() - 1;
    let unit = if fitted.parameters[last] == 0.0 {
        0.0
    } else {
        law.g_zero / fitted.parameters[last]
    };
    let mut list = vec![
        Parameter::fitted("material.factor", factor, factor * error(0), "S/g^exponent"),
        Parameter::fitted("material.exponent", law.exponent[0], error(1), ""),
        Parameter::fitted(
            "material.g_zero_siemens",
            law.g_zero,
            (unit * error(last)).abs(),
            "S",
        ),
    ];
    if let Some(half) = law.saturation_load_g {
        let relative = error(2) / fitted.parameters[2].max(1e-9);
        list.push(Parameter::fitted(
            "material.saturation_load_g",
            half,
            half * relative,
            "g",
        ));
    }
    list
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_saturating_material_is_told_from_a_power_law() {
        let truth = LoadLaw {
            saturation_load_g: Some(1500.0),
            ..LoadLaw::power(2e-6, 6e-6, 0.9)
        };
        let pairs: Vec<(f64, f64)> = (1..30)
            .map(|i| f64::from(i) * 20.0)
            .map(|load| (truth.siemens_from_grams(0, load), load))
            .collect();
        let (found, _) = fit_law(LawChoice::Saturating, &pairs, Some(2e-6)).unwrap();
        assert!(
            (found.saturation_load_g.unwrap() / 1500.0 - 1.0).abs() < 1e-2,
            "{found:?}"
        );
        let fits = fit_pairs(&pairs);
        assert_ne!(fits[0].name, "power");
        assert!(fits[0].held_out_mean_absolute_g < 0.5);
    }

    #[test]
    fn too_few_pairs_fit_nothing() {
        assert!(fit_law(LawChoice::Power, &[(1e-5, 10.0)], None).is_none());
    }
}
