//! Labels that the other presses contradict.

use super::Suspect;
use super::least_squares::{median, robust_deviation, theil_sen};

/// A label is named where it is off by this many of the others' deviations and by this factor,
const DEVIATIONS: f64 = 8.0;
const FACTOR: f64 = 1.15;
/// and, before there is a fit, by this factor from the straight line through the logarithms of the others.
const GROSS_FACTOR: f64 = 4.0;
/// More than this share of wrong labels is no small number of slips: the model is wrong, or two units are mixed.
const MAX_SHARE: f64 = 0.2;

/// Labels far off a power law between load and apparent conductance over an unloaded taxel's: (press, load,
/// siemens) to what the others say.
pub(super) fn gross(readings: &[(usize, f64, f64)]) -> Vec<Suspect> {
    let usable = |r: &&(usize, f64, f64)| r.1 > 0.0 && r.2 > 0.0;
    let logs: Vec<(usize, f64, f64)> = readings
        .iter()
        .filter(usable)
        .map(|&(p, load, g)| (p, load.ln(), g.ln()))
        .collect();
    let points: Vec<(f64, f64)> = logs.iter().map(|l| (l.1, l.2)).collect();
    let Some(slope) = theil_sen(&points).filter(|s| *s > 0.05) else {
        return Vec::new();
    };
    let offset = median(&points.iter().map(|p| p.1 - slope * p.0).collect::<Vec<_>>());
    let off: Vec<f64> = points
        .iter()
        .map(|p| (p.1 - offset) / slope - p.0)
        .collect();
    let limit = (DEVIATIONS * robust_deviation(&off)).max(GROSS_FACTOR.ln());
    logs.iter()
        .zip(&off)
        .filter(|(_, off)| off.abs() > limit)
        .map(|(&(press, ln_load, _), off)| Suspect {
            press,
            load_g: ln_load.exp(),
            says_g: (ln_load + off).exp(),
            left_out: true,
        })
        .collect()
}

/// Labels that a fit reads otherwise: (press, label, what the fit says), all grams.
pub(super) fn after(estimates: &[(usize, f64, f64)]) -> Vec<Suspect> {
    // A light press is as far off in grams as the lightest that can be told.
    let off: Vec<f64> = estimates.iter().map(|e| e.2 - e.1).collect();
    let shares: Vec<f64> = estimates
        .iter()
        .map(|e| (e.2 - e.1) / e.1.max(1.0))
        .collect();
    let (grams, share) = (robust_deviation(&off), robust_deviation(&shares));
    estimates
        .iter()
        .filter(|e| {
            let away = (e.2 - e.1).abs();
            let ratio = (e.2.max(1e-3) / e.1.max(1e-3)).ln().abs();
            away > DEVIATIONS * grams && away > DEVIATIONS * share * e.1 && ratio > FACTOR.ln()
        })
        .map(|&(press, load_g, says_g)| Suspect {
            press,
            load_g,
            says_g,
            left_out: false,
        })
        .collect()
}

/// Fewer than can be slips.
pub(super) fn few(suspects: usize, presses: usize) -> bool {
    suspects as f64 <= MAX_SHARE * presses as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_load_in_kilograms_is_named_and_nothing_else() {
        let mut readings: Vec<(usize, f64, f64)> = (0..40)
            .map(|i| {
                let load = 12.0 + 14.0 * f64::from(i);
                let g = 8e-6 * load.powf(0.86);
                (i as usize, load, g / (1.0 + 20.0 * g))
            })
            .collect();
        assert_eq!(gross(&readings), []);
        readings[11].1 /= 1000.0;
        let found = gross(&readings);
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].press, 11);
        assert!((found[0].says_g / 166.0 - 1.0).abs() < 0.1, "{found:?}");
    }
}
