//! How much residuals of a fit of everything scatter.

use super::evaluate::Evaluator;
use super::least_squares::median;

/// Smallest scatter that residuals of a kind are scaled by, grams.
pub(super) const MIN_SCATTER_G: f64 = 1e-3;

/// What is the same for all presses is at least this share of what light ones are off by: taken for nothing, it would leave the lightest
/// of them to tell everything, and then not, by turns.
const LEAST_SAME: f64 = 0.5;

/// The usual size of residuals: their deviation from nothing, that of a normal distribution with the same median size.
pub(super) fn size(residuals: &[f64]) -> f64 {
    let sizes: Vec<f64> = residuals.iter().map(|r| r.abs()).collect();
    1.4826 * median(&sizes)
}

/// What a labelled load is uncertain by: a part that is the same for all, which light ones tell, and one that goes with
/// the load (labels, creep while it is held), which heavy ones tell.
pub(super) fn press_scales(evaluator: &Evaluator, residuals: &[f64]) -> Vec<f64> {
    let loads = evaluator.evidence.loads_g();
    let middle = median(&loads);
    let part = |heavy: bool| -> Vec<f64> {
        let each = residuals.iter().zip(&loads);
        each.filter(|(_, load)| (**load > middle) == heavy)
            .map(|(r, load)| if heavy { r / load } else { *r })
            .collect()
    };
    let share = size(&part(true));
    let of_light = loads.iter().filter(|load| **load <= middle).sum::<f64>()
        / loads.iter().filter(|load| **load <= middle).count().max(1) as f64;
    let light = size(&part(false));
    let same = light.powi(2) - (share * of_light).powi(2);
    let same = same.max((LEAST_SAME * light).powi(2)).sqrt();
    let same = same.max(MIN_SCATTER_G);
    loads.iter().map(|load| same.hypot(share * load)).collect()
}
