//! Which of the fitted read-outs explain the frames: description lengths, compared as Vuong (1989) does.

use super::advice;
use super::fit::{Fitted, price};
use super::numbers::numbers_of;
use super::readings::{Reading, Readings};
use super::report::{Identification, Standing, UniformFinding, Verdict};
use crate::sensor::Topology;

/// A read-out is out where it takes so many nats more than the best, and so many standard errors of that difference.
const NATS: f64 = 10.0;
const ERRORS: f64 = 3.0;
/// A reading this many standard deviations off is missed; a read-out that misses more than this share explains nothing.
const MISSED: f64 = 3.5;
const MOST_MISSED: f64 = 0.1;
/// Where the best read-out leaves less than this share of the readings to taxels that are not pressed, next to nothing is
/// predicted, and nothing is judged.
const LEAST_TESTED: f64 = 0.1;
/// What one reading may weigh in a comparison, nats: a single one decides nothing.
const HEAVIEST: f64 = 50.0;
/// Two read-outs give the same loads where their conductances, but for a factor, differ by less than this share of all.
const ALIKE: f64 = 0.03;

/// Ranks and judges.
pub(super) fn judge(
    mut fits: Vec<Fitted>,
    mut uniform: Vec<UniformFinding>,
    readings: &Readings,
    named: Option<Topology>,
) -> Identification {
    fits.sort_by(|a, b| a.length(readings).total_cmp(&b.length(readings)));
    let place = |topology| {
        fits.iter()
            .position(|fit| fit.candidate.topology == topology)
    };
    uniform.sort_by_key(|finding| place(finding.topology));
    let contradicts = |topology| {
        let of = |finding: &&UniformFinding| finding.topology == topology;
        uniform.iter().find(of).is_some_and(|finding| finding.out)
    };
    let fair = || {
        fits.iter()
            .filter(|fit| !contradicts(fit.candidate.topology))
    };
    // What is stretched to the end of what it can be puts out none that explains the frames within.
    let best = fair().find(|fit| !fit.is_stretched()).or(fair().next());
    let best = best.unwrap_or(&fits[0]);
    let is_tested = tested(&fits[0], readings) >= LEAST_TESTED;
    let losses = losses(best, readings);
    let standings: Vec<Standing> = fits
        .iter()
        .map(|fit| {
            let (excess, error) = excess(fit, readings, &losses);
            let missed = missed(fit, readings);
            Standing {
                topology: fit.candidate.topology,
                excess_nats: fit.length(readings) - fits[0].length(readings),
                counted_nats: excess,
                standard_error_nats: error,
                missed_share: missed,
                pressed: fit.pressed(),
                is_stretched: fit.is_stretched(),
                out: (is_tested && excess > NATS && excess > ERRORS * error)
                    || (is_tested && missed > MOST_MISSED)
                    || contradicts(fit.candidate.topology),
                numbers: numbers_of(fit),
            }
        })
        .collect();
    let left: Vec<&Fitted> = fits
        .iter()
        .zip(&standings)
        .filter(|(_, standing)| !standing.out)
        .map(|(fit, _)| fit)
        .collect();
    let verdict = verdict(&left, is_tested, readings.absent.len());
    let names: Vec<Topology> = left.iter().map(|fit| fit.candidate.topology).collect();
    Identification {
        verdict,
        measure: advice::measure(&names),
        standings,
        is_tested,
        uniform,
        named,
        frames: readings.frames.len(),
        readings: readings.count(),
        noise_counts: readings.sigma,
    }
}

/// In one word.
fn verdict(left: &[&Fitted], is_tested: bool, taxels: usize) -> Verdict {
    match left {
        [] => Verdict::None,
        _ if !is_tested => Verdict::CannotTell,
        [_] => Verdict::One,
        [first, rest @ ..] if rest.iter().all(|other| are_alike(first, other, taxels)) => {
            Verdict::Alike
        }
        _ => Verdict::CannotTell,
    }
}

/// What each reading costs, nats: its residual, and its taxel where that is named as pressed.
fn losses(fit: &Fitted, readings: &Readings) -> Vec<f64> {
    let mut losses: Vec<f64> = fit
        .residuals
        .iter()
        .map(|r| (0.5 * r * r).min(HEAVIEST))
        .collect();
    let taxels = readings.absent.len();
    let price = price(readings);
    for (frame, pressed) in fit.state.pressed.iter().enumerate() {
        for taxel in &pressed.taxels {
            losses[frame * taxels + taxel] += price;
        }
    }
    losses
}

/// How many nats more than the best it takes, each reading's share bounded, and the standard error of that.
fn excess(fit: &Fitted, readings: &Readings, best: &[f64]) -> (f64, f64) {
    let own = losses(fit, readings);
    let more: Vec<f64> = own.iter().zip(best).map(|(own, best)| own - best).collect();
    let sum: f64 = more.iter().sum();
    let mean = sum / more.len() as f64;
    let squares: f64 = more.iter().map(|x| (x - mean).powi(2)).sum();
    (sum, squares.sqrt())
}

/// The share of the measured readings that belong to taxels that are not pressed.
fn tested(fit: &Fitted, readings: &Readings) -> f64 {
    let pairs = readings.frames.iter().zip(&fit.state.pressed);
    let (mut measured, mut free) = (0usize, 0usize);
    for (frame, pressed) in pairs {
        for (taxel, reading) in frame.iter().enumerate() {
            if matches!(reading, Reading::Is(_)) {
                measured += 1;
                free += usize::from(pressed.taxels.binary_search(&taxel).is_err());
            }
        }
    }
    free as f64 / measured.max(1) as f64
}

/// The share of the readings that are missed.
fn missed(fit: &Fitted, readings: &Readings) -> f64 {
    let missed = fit.residuals.iter().filter(|r| r.abs() > MISSED).count();
    missed as f64 / readings.count().max(1) as f64
}

/// Whether conductances, and with them the loads, are the same under both but for a factor.
fn are_alike(a: &Fitted, b: &Fitted, taxels: usize) -> bool {
    let of = |fit: &Fitted| {
        let mut all = Vec::new();
        for pressed in &fit.state.pressed {
            let mut frame = vec![0.0; taxels];
            for (&taxel, log) in pressed.taxels.iter().zip(&pressed.logs) {
                frame[taxel] = log.exp();
            }
            all.extend(frame);
        }
        all
    };
    let (a, b) = (of(a), of(b));
    let both = || a.iter().zip(&b);
    let factor = both().map(|(a, b)| a * b).sum::<f64>() / a.iter().map(|a| a * a).sum::<f64>();
    let differ: f64 = both().map(|(a, b)| (factor * a - b).abs()).sum();
    differ < ALIKE * b.iter().sum::<f64>()
}
