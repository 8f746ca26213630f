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
/// Fewest pairs of presses in one frame that tell what a frame shares.
const MIN_PAIRS: usize = 20;
/// Fewest unloaded taxels whose mean is one of a frame.
const MIN_UNLOADED: usize = 20;
/// The most of the variance that the error of the scale makes: by itself it may be told badly where others of the fit make up
/// for it.
const MOST_BY_SCALE: f64 = 0.5;
/// Labels are contradicted where they would be off by so many standard errors more than what is read of them.
const CLEAR_CHANCE: f64 = 2.0;
/// Smallest floor, grams.
const MIN_FLOOR_G: f64 = 1e-4;

/// A held-out press: its label, and what was read, grams.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Judged {
    /// Its place among the presses of the evidence, and the frame that it stands in.
    pub(super) press: usize,
    pub(super) frame: usize,
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

/// What is known beside held-out presses.
#[derive(Debug, Clone, Copy)]
pub(super) struct Beside<'a> {
    /// What unloaded taxels read in each frame, grams; none where none are known.
    pub(super) unloaded_g: &'a [Vec<f64>],
    /// What a standard error of the unloaded conductance is worth, grams, where a fit tells it.
    pub(super) zero_g: Option<f64>,
    /// The standard error of the load's scale; of what contacts weigh, where everything was fitted together.
    pub(super) fit_share: f64,
    /// Presses share that error: what they are off by bounds it. Contacts may be off by more than presses alone are, where
    /// spread, saturation and scale make up for each other in these.
    pub(super) presses_share_it: bool,
    /// What labels themselves are off by, taken out.
    pub(super) label_share: f64,
    /// How much farther off presses are that did not choose the effects either.
    pub(super) inflation: f64,
}

/// How wrong loads are: a share of the load and a floor, by held-out presses and by what unloaded taxels read in their
/// frames, and the factor that makes intervals of both hold 95 % of these presses
/// (split conformal prediction: Vovk, Gammerman and Shafer 2005, without a distribution to believe in).
/// What a frame shares of both is told by frames with several presses, and by unloaded taxels.
pub(super) fn uncertainty(judged: &[Judged], beside: Beside) -> Option<UncertaintySpec> {
    if judged.len() < MIN_JUDGED {
        return None;
    }
    let Beside {
        fit_share,
        label_share,
        inflation,
        ..
    } = beside;
    let (share, same) = sizes(judged);
    let (share, same) = (inflation * share, inflation * same);
    let unloaded_g = beside.unloaded_g.iter().flatten();
    let unloaded = quantile(unloaded_g.map(|g| g.abs()), FLOOR_COVERAGE).unwrap_or(0.0);
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
    let own = without_labels(share * share, label_share, chance_of(judged));
    let most = (MOST_BY_SCALE * own).sqrt();
    let shared = fit_share.min(most);
    let fit_share = if beside.presses_share_it {
        shared
    } else {
        fit_share
    };
    let model = (own - shared * shared).max(0.0).sqrt();
    Some(UncertaintySpec {
        model_share: digits(model),
        model_floor_g: digits(floor),
        fit_share: digits(fit_share),
        factor_95: digits(factor),
        presses: judged.len(),
        frame_share: shared_share(judged, inflation).map(|shared| digits(shared.min(model))),
        frame_floor_g: shared_floor_g(beside).map(|shared| digits(shared.min(floor))),
        spread_error: None,
        sheet_share: None,
        material_factor: None,
    })
}

/// A variance without that of labels. What chance may hide is not taken for nothing: `chance` is the standard error of the
/// variance, as a share of it.
pub(super) fn without_labels(variance: f64, label_share: f64, chance: f64) -> f64 {
    let least = if label_share > 0.0 {
        chance.min(1.0)
    } else {
        1.0
    };
    (variance - label_share * label_share).max(least * variance)
}

/// The standard error of the variance that heavy presses tell by a median deviation, as a share of it: that has 37 % of a standard
/// deviation's efficiency.
fn chance_of(judged: &[Judged]) -> f64 {
    let heavy = (judged.len() / 2).max(1) as f64;
    (2.0 / (0.37 * heavy)).sqrt()
}

/// Words on labels that are said to be farther off than presses are from them.
pub(super) fn doubt_label_share(judged: &[Judged], label_share: f64) -> Option<String> {
    if judged.len() < MIN_JUDGED || label_share == 0.0 {
        return None;
    }
    let (share, _) = sizes(judged);
    doubted_share(share * share, label_share, chance_of(judged))
}

/// The same of any variance and what chance it has.
pub(super) fn doubted_share(variance: f64, label_share: f64, chance: f64) -> Option<String> {
    let most = variance * CLEAR_CHANCE.mul_add(chance, 1.0);
    (label_share * label_share > most).then(|| {
        format!(
            "labels are said to be {:.1} % off, and what is read of them is {:.1} % off: say a smaller --label-error, or errors are told too small",
            100.0 * label_share,
            100.0 * variance.sqrt()
        )
    })
}

/// What all presses of a frame are off by together, a share of the load: by the products of two heavy ones of a frame. Nothing
/// with too few of them.
fn shared_share(judged: &[Judged], inflation: f64) -> Option<f64> {
    let (share, _) = sizes(judged);
    let middle = median(&judged.iter().map(|j| j.load_g).collect::<Vec<_>>());
    let heavy: Vec<(usize, f64)> = judged
        .iter()
        .filter(|j| j.load_g > middle)
        // A wrong label is no more than a large error.
        .map(|j| {
            let off = (j.says_g - j.load_g) / j.load_g;
            (j.frame, off.clamp(-3.0 * share, 3.0 * share))
        })
        .collect();
    let mut products = Vec::new();
    for (i, (frame, off)) in heavy.iter().enumerate() {
        let others = heavy[..i].iter().filter(|other| other.0 == *frame);
        products.extend(others.map(|other| other.1 * off));
    }
    (products.len() >= MIN_PAIRS).then(|| {
        let count = products.len() as f64;
        let mean = products.iter().sum::<f64>() / count;
        // What chance may hide is not taken for nothing.
        let chance = share * share / count.sqrt();
        inflation * (mean.max(0.0) + chance).sqrt()
    })
}

/// What all unloaded taxels of a frame read together, grams: by the means of frames, and by what is known of no load at all.
fn shared_floor_g(beside: Beside) -> Option<f64> {
    let means: Vec<f64> = beside
        .unloaded_g
        .iter()
        .filter(|frame| frame.len() >= MIN_UNLOADED)
        .map(|frame| frame.iter().sum::<f64>() / frame.len() as f64)
        .collect();
    let told = (means.len() >= MIN_JUDGED).then(|| {
        let squares = means.iter().map(|mean| mean * mean).sum::<f64>();
        beside.inflation * (squares / means.len() as f64).sqrt()
    });
    match (told, beside.zero_g) {
        (Some(told), zero) => Some(told.hypot(zero.unwrap_or(0.0))),
        (None, zero) => zero,
    }
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
pub(super) fn digits(value: f64) -> f64 {
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
    law.error_grams(taxel, siemens, sigma)
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
                    press: i,
                    frame: i,
                    load_g,
                    says_g: load_g + tail * sigma * normal(&mut random),
                    noise_g: 0.0,
                }
            })
            .collect()
    }

    fn beside<'a>(fit_share: f64, label_share: f64) -> Beside<'a> {
        Beside {
            unloaded_g: &[],
            zero_g: None,
            fit_share,
            presses_share_it: true,
            label_share,
            inflation: 1.0,
        }
    }

    #[test]
    fn presses_of_one_frame_tell_what_it_shares() {
        for (shared, own) in [(0.03, 0.01), (0.01, 0.03), (0.0, 0.03)] {
            let mut random = ChaCha8Rng::seed_from_u64(11);
            let mut judged = Vec::new();
            for frame in 0..100 {
                let together = shared * normal(&mut random);
                for press in 0..3 {
                    let load_g = 200.0 + 5.0 * frame as f64;
                    let off = together + own * normal(&mut random);
                    judged.push(Judged {
                        press: 3 * frame + press,
                        frame,
                        load_g,
                        says_g: load_g * (1.0 + off),
                        noise_g: 0.0,
                    });
                }
            }
            let found = uncertainty(&judged, beside(0.0, 0.0)).unwrap();
            let found = found.frame_share.unwrap();
            // Half of the presses are heavy, in 50 frames: a standard error of 14 % and what chance may hide.
            let most = f64::hypot(1.25 * shared, 0.35 * own);
            assert!((0.8 * shared..most).contains(&found), "{shared} {found}");
        }
        // One press a frame tells nothing.
        let found = uncertainty(&drawn(3, 150), beside(0.0, 0.0)).unwrap();
        assert_eq!(found.frame_share, None);
        assert!((found.shared_share() / found.model_share - 0.5f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn unloaded_taxels_tell_what_they_share() {
        let mut random = ChaCha8Rng::seed_from_u64(5);
        let frames: Vec<Vec<f64>> = (0..60)
            .map(|_| {
                let mean = 0.02 * normal(&mut random);
                (0..120).map(|_| mean + 0.1 * normal(&mut random)).collect()
            })
            .collect();
        let known = Beside {
            unloaded_g: &frames,
            ..beside(0.0, 0.0)
        };
        let found = uncertainty(&drawn(3, 150), known).unwrap().frame_floor_g;
        assert!((0.018..0.028).contains(&found.unwrap()), "{found:?}");
    }

    #[test]
    fn intervals_hold_as_many_new_presses_as_they_say_whatever_the_distribution() {
        let (mut held, mut all) = (0, 0);
        for seed in 0..40 {
            let found = uncertainty(&drawn(seed, 120), beside(0.0, 0.0)).unwrap();
            for new in drawn(1000 + seed, 100) {
                let sigma = found.model_floor_g.hypot(found.model_share * new.load_g);
                held += usize::from(new.error_g() <= found.factor_95 * sigma);
                all += 1;
            }
        }
        let share = held as f64 / all as f64;
        assert!((0.94..0.97).contains(&share), "{share}");
    }

    /// Labels that are as far off as they are said to be leave what chance may hide; farther off than presses are, they are doubted.
    #[test]
    fn labels_explain_no_more_than_chance_lets_them() {
        let mut random = ChaCha8Rng::seed_from_u64(4);
        let mut judged = drawn(4, 200);
        for press in &mut judged {
            press.load_g += 300.0;
            press.says_g = press.load_g * (1.0 + 0.02 * normal(&mut random));
        }
        let found = uncertainty(&judged, beside(0.0, 0.02)).unwrap();
        assert!((0.007..0.012).contains(&found.model_share), "{found:?}");
        assert_eq!(doubt_label_share(&judged, 0.0), None);
        assert_eq!(doubt_label_share(&judged, 0.02), None);
        let words = doubt_label_share(&judged, 0.04).unwrap();
        assert!(words.contains("4.0 %") && words.contains("2."), "{words}");
    }

    #[test]
    fn the_error_of_labels_is_taken_out_and_few_presses_tell_nothing() {
        let judged = drawn(3, 150);
        let all = uncertainty(&judged, beside(0.01, 0.0)).unwrap();
        let without = uncertainty(&judged, beside(0.01, 0.02)).unwrap();
        assert!(without.model_share < all.model_share);
        assert_eq!(without.factor_95, all.factor_95);
        assert_eq!(uncertainty(&judged[..7], beside(0.0, 0.0)), None);
    }
}
