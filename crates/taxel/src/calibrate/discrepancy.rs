//! What a calibrated sensor's loads are uncertain by beyond noise: from presses that did not fit what reads them.

use super::least_squares::median;
use crate::Sensor;
use crate::circuit::{Converter, ROUNDING_COUNTS};
use crate::material::LoadLaw;
use crate::sensor::UncertaintySpec;
use crate::stats::quantile;
use crate::uncertainty::least_error_siemens;

/// The share of new presses that an interval is to hold.
const COVERAGE: f64 = 0.95;
/// The factor of a normal distribution for it.
const NORMAL: f64 = 1.96;
/// The share of unloaded taxels that the floor alone holds: more than [`COVERAGE`], since there are so many of them.
const FLOOR_COVERAGE: f64 = 0.985;
/// Fewest presses that tell a share, a floor and a factor.
const MIN_JUDGED: usize = 8;
/// Smallest floor, grams.
const MIN_FLOOR_G: f64 = 1e-4;

/// A held-out press: its label, and what was read, grams.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Judged {
    pub(super) load_g: f64,
    pub(super) says_g: f64,
    /// What noise its reading has at least, grams.
    pub(super) noise_g: f64,
}

impl Judged {
    fn error_g(&self) -> f64 {
        (self.says_g - self.load_g).abs()
    }
}

/// How wrong loads are: a share of the load and a floor, by held-out presses and by what unloaded taxels read in their
/// frames (grams; none where none are known), and the factor that makes intervals of both hold 95 % of these presses
/// (split conformal prediction: Vovk, Gammerman and Shafer 2005, without a distribution to believe in).
/// `fit_share`: the standard error of the load's scale; `label_share`: what labels themselves are off by, taken out;
/// `inflation`: how much farther off presses are that did not choose the effects either.
pub(super) fn uncertainty(
    judged: &[Judged],
    unloaded_g: &[f64],
    fit_share: f64,
    label_share: f64,
    inflation: f64,
) -> Option<UncertaintySpec> {
    if judged.len() < MIN_JUDGED {
        return None;
    }
    let (share, same) = sizes(judged);
    let (share, same) = (inflation * share, inflation * same);
    let unloaded = quantile(unloaded_g.iter().map(|g| g.abs()), FLOOR_COVERAGE).unwrap_or(0.0);
    // Noise has a part of its own; beside nothing it is as large as the rest, and counted twice.
    let beyond = |size: f64, noise: f64| (size * size - noise * noise).max(0.0).sqrt();
    let usual = median(&judged.iter().map(|j| j.noise_g).collect::<Vec<_>>());
    let mut factor = NORMAL;
    let mut floor = MIN_FLOOR_G;
    for _ in 0..3 {
        floor = (unloaded / factor)
            .max(beyond(same, usual))
            .max(MIN_FLOOR_G);
        factor = conformal(judged, share, floor, inflation).max(NORMAL);
    }
    let own = (share * share - label_share * label_share).max(0.0);
    let model = (own - fit_share * fit_share).max(0.0).sqrt();
    Some(UncertaintySpec {
        model_share: digits(model),
        model_floor_g: digits(floor),
        fit_share: digits(fit_share.min(own.sqrt())),
        factor_95: digits(factor),
        presses: judged.len(),
        frame_share: None,
        frame_floor_g: None,
    })
}

/// The error of heavy presses as a share of the load, and what light ones are off by besides.
fn sizes(judged: &[Judged]) -> (f64, f64) {
    let loads: Vec<f64> = judged.iter().map(|j| j.load_g).collect();
    let middle = median(&loads);
    let size = |values: Vec<f64>| 1.4826 * median(&values);
    let heavy = judged.iter().filter(|j| j.load_g > middle);
    let share = size(heavy.map(|j| j.error_g() / j.load_g).collect());
    let light: Vec<&Judged> = judged.iter().filter(|j| j.load_g <= middle).collect();
    let mean = light.iter().map(|j| j.load_g).sum::<f64>() / light.len().max(1) as f64;
    let same = size(light.iter().map(|j| j.error_g()).collect()).powi(2) - (share * mean).powi(2);
    (share, same.max(0.0).sqrt())
}

/// The ⌈(n + 1) · 95 %⌉th smallest error in units of what it is believed to be: the next press is within so many of them
/// with that probability. With too few presses for it, the largest.
fn conformal(judged: &[Judged], share: f64, floor: f64, inflation: f64) -> f64 {
    let mut scores: Vec<f64> = judged
        .iter()
        .map(|j| inflation * j.error_g() / floor.hypot(share * j.load_g).hypot(j.noise_g))
        .collect();
    scores.sort_by(f64::total_cmp);
    let rank = ((scores.len() + 1) as f64 * COVERAGE).ceil() as usize;
    scores[rank.min(scores.len()) - 1]
}

/// Three digits: no more are told.
fn digits(value: f64) -> f64 {
    format!("{value:.2e}").parse().unwrap_or(value)
}

/// What noise the reading of a load has at least, grams: as if the taxel were alone and the switches ideal.
pub(super) fn least_noise_g(
    sensor: &Sensor,
    law: &LoadLaw,
    noise_counts: f64,
    taxel: usize,
    load_g: f64,
) -> f64 {
    let sigma_volts =
        noise_counts.hypot(ROUNDING_COUNTS) * Converter::from_sensor(sensor).lsb_volts();
    let siemens = law.siemens_from_grams(taxel, load_g);
    let sigma = least_error_siemens(sensor, sigma_volts, siemens);
    let (up, down) = (siemens + sigma, siemens - sigma);
    (law.grams_from_siemens(taxel, up) - law.grams_from_siemens(taxel, down)) / 2.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::circuit::normal;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    fn drawn(seed: u64, count: usize) -> Vec<Judged> {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        (0..count)
            .map(|i| {
                let load_g = 10.0 + 590.0 * i as f64 / count as f64;
                let sigma = 0.5f64.hypot(0.03 * load_g);
                // Heavier tails than a normal distribution: one in ten is three times as far off.
                let tail = if i % 10 == 3 { 3.0 } else { 1.0 };
                Judged {
                    load_g,
                    says_g: load_g + tail * sigma * normal(&mut random),
                    noise_g: 0.0,
                }
            })
            .collect()
    }

    #[test]
    fn intervals_hold_as_many_new_presses_as_they_say_whatever_the_distribution() {
        let (mut held, mut all) = (0, 0);
        for seed in 0..40 {
            let found = uncertainty(&drawn(seed, 120), &[], 0.0, 0.0, 1.0).unwrap();
            for new in drawn(1000 + seed, 100) {
                let sigma = found.model_floor_g.hypot(found.model_share * new.load_g);
                held += usize::from(new.error_g() <= found.factor_95 * sigma);
                all += 1;
            }
        }
        let share = held as f64 / all as f64;
        assert!((0.94..0.97).contains(&share), "{share}");
    }

    #[test]
    fn the_error_of_labels_is_taken_out_and_few_presses_tell_nothing() {
        let judged = drawn(3, 150);
        let all = uncertainty(&judged, &[], 0.01, 0.0, 1.0).unwrap();
        let without = uncertainty(&judged, &[], 0.01, 0.02, 1.0).unwrap();
        assert!(without.model_share < all.model_share);
        assert_eq!(without.factor_95, all.factor_95);
        assert_eq!(uncertainty(&judged[..7], &[], 0.0, 0.0, 1.0), None);
    }
}
