//! Presses with what is read of them, and how far that may be off.

use super::discrepancy::Judged;
use super::evidence::Evidence;
use super::outcome::Outcome;

/// A labelled press and what is read of it.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct PressResidual {
    /// Index into [`super::CalibrationData::presses`].
    pub press: usize,
    /// Its label, grams.
    pub load_g: f64,
    /// What is read: the load on its taxel, or with that on the neighbours where the press stands alone and a sheet or spread is
    /// looked for; grams.
    pub estimate_g: f64,
    /// One standard error of that, grams, as the calibrated sensor states it; of noise the least that a reading has.
    pub standard_error_g: f64,
    /// Half the width of its 95 % interval, grams.
    pub half_width_95_g: f64,
    /// Whether it was read by a fit without it.
    pub held_out: bool,
}

/// Held-out presses first, then all by the fit of all.
pub(super) fn residuals(outcome: &Outcome, evidence: &Evidence) -> Vec<PressResidual> {
    let factor = outcome.uncertainty.map_or(1.96, |found| found.factor_95);
    let of = |held_out: bool| {
        move |judged: &Judged| {
            let beyond = outcome.uncertainty.as_ref();
            let beyond = beyond.map_or(0.0, |found| found.beyond_noise_g(judged.says_g));
            let standard_error_g = beyond.hypot(judged.noise_g);
            PressResidual {
                press: evidence.origin[judged.press],
                load_g: judged.load_g,
                estimate_g: judged.says_g,
                standard_error_g,
                half_width_95_g: factor * standard_error_g,
                held_out,
            }
        }
    };
    let held_out = outcome.held_out.judged.iter().map(of(true));
    held_out
        .chain(outcome.fitted.iter().map(of(false)))
        .collect()
}
