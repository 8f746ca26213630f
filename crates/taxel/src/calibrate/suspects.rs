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
/// siemens) to what the others say. Of a taxel that says nothing there is no logarithm: it is named where by the others its
/// load conducts several times `clear`, siemens, what noise does not make of an unloaded one.
pub(super) fn gross(readings: &[(usize, f64, f64)], clear: Option<f64>) -> Vec<Suspect> {
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
    let silent = readings.iter().filter(|&&(_, load, g)| {
        let wanted = (offset + slope * load.ln()).exp();
        load > 0.0 && clear.is_some_and(|clear| g <= clear && wanted > GROSS_FACTOR * clear)
    });
    let silent: Vec<Suspect> = silent
        .map(|&(press, load_g, _)| Suspect {
            press,
            load_g,
            says_g: 0.0,
            left_out: true,
        })
        .collect();
    let is_named = |press: usize| silent.iter().any(|s| s.press == press);
    let far: Vec<Suspect> = logs
        .iter()
        .zip(&off)
        .filter(|((press, ..), off)| off.abs() > limit && !is_named(*press))
        .map(|(&(press, ln_load, _), off)| Suspect {
            press,
            load_g: ln_load.exp(),
            says_g: (ln_load + off).exp(),
            left_out: true,
        })
        .collect();
    silent.into_iter().chain(far).collect()
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
        assert_eq!(gross(&readings, Some(1e-6)), []);
        readings[11].1 /= 1000.0;
        let found = gross(&readings, None);
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].press, 11);
        assert!((found[0].says_g / 166.0 - 1.0).abs() < 0.1, "{found:?}");
    }
    #[test]
    fn a_taxel_that_says_nothing_under_a_load_is_named_and_a_light_touch_is_not() {
        let mut readings: Vec<(usize, f64, f64)> = (0..40)
            .map(|i| {
                let load = 1.0 + 10.0 * f64::from(i);
                (i as usize, load, 8e-6 * load.powf(0.86))
            })
            .collect();
        // Noise makes up to 1e-5 S, as of a load of 1 g: a silent one is no wonder.
        readings[0].2 = -1e-6;
        assert_eq!(gross(&readings, Some(1e-5)), []);
        for silent in [-1e-6, 0.0, 3e-6] {
            readings[20].2 = silent;
            let found = gross(&readings, Some(1e-5));
            assert_eq!(found.len(), 1, "{found:?}");
            assert_eq!((found[0].press, found[0].says_g), (20, 0.0));
        }
    }
}
