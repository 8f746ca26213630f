//! How much residuals of a fit of everything scatter.

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
pub(super) fn press_scales(loads: &[f64], residuals: &[f64]) -> Vec<f64> {
    let middle = median(loads);
    let part = |heavy: bool| -> Vec<f64> {
        let each = residuals.iter().zip(loads);
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Where what heavy presses tell explains light ones just so, or a hair more, or a hair less, the lightest press counts for as much.
    #[test]
    fn a_hair_changes_no_scale_much() {
        let loads: Vec<f64> = (1..=100).map(f64::from).collect();
        let of_lightest = |light: f64| {
            // Of 1 % of the load, and by light presses as much as at their mean load.
            let off = |load: &f64| {
                if *load > 50.5 {
                    0.01 * load
                } else {
                    0.01 * light
                }
            };
            let residuals: Vec<f64> = loads.iter().map(off).collect();
            press_scales(&loads, &residuals)[0]
        };
        let (less, more) = (of_lightest(25.4), of_lightest(25.6));
        assert!((more / less - 1.0).abs() < 0.02, "{less} {more}");
        // 1.4826 times 0.01 g times 25.5, and half of it.
        assert!(
            (of_lightest(25.5) - 0.189).abs() < 1e-3,
            "{}",
            of_lightest(25.5)
        );
    }
}
