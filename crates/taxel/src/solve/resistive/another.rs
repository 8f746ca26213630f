//! A second answer: where a source resistor or a large resistance of rows makes readings fall again as everything is pressed harder,
//! two sets of conductances can explain a frame.

use super::super::gmres::largest;
use super::super::{Outcome, Stop};
use super::state::State;
use super::{Accuracy, CHEAP, Merit, descend};

/// Multiples of the first answer: 0.7 · 2^power, so that the answer itself is none of them.
const FACTORS: std::ops::RangeInclusive<i32> = -5..=9;
const OFFSET: f64 = 0.7;
/// Multiples nearer to 1 than this (in the logarithm) are the answer itself.
const SAME_FACTOR: f64 = 0.02;
/// Answers that differ by less, of the largest conductance, and by less than noise may make, are one.
const SAME: f64 = 1e-3;

/// Tries other multiples of the answer in `g` that explain the sum of the readings. The likelier answer ends up there; with a second
/// one, or a start that leads nowhere, the first is ambiguous.
pub(super) fn look_for(state: &mut State, accuracy: Accuracy, best: &mut Outcome) {
    state.kept.copy_from_slice(&state.g);
    let starts = multiples(state);
    let mut likelihood = None;
    for factor in starts.into_iter().flatten() {
        let likelihood = likelihood.get_or_insert_with(|| {
            state.g.copy_from_slice(&state.kept);
            state.unlikeliness()
        });
        state.start_at_multiple(factor);
        if !state.evaluate() {
            continue;
        }
        state.g.copy_from_slice(&state.trial);
        let outcome = descend(state, accuracy, Merit::Norm);
        if outcome.stop.is_good() && is_same(state) {
            continue;
        }
        best.ambiguous = true;
        let unlikely = state.unlikeliness();
        if outcome.stop.is_good() && unlikely < *likelihood {
            *likelihood = unlikely;
            state.kept.copy_from_slice(&state.g);
            *best = Outcome {
                ambiguous: true,
                ..outcome
            };
        }
    }
    // Back to the answer, with its misfit and its noise.
    if !state.return_to_kept() {
        *best = Outcome::new(Stop::Stalled, best.iterations, f64::INFINITY);
    } else if likelihood.is_some() {
        state.linearise(accuracy.sigma_volts, false);
        state.is_fresh = false;
    }
}

/// Up to two multiples of the answer, other than itself, whose readings sum to what is measured.
fn multiples(state: &mut State) -> [Option<f64>; 2] {
    let (mut found, mut count) = ([None; 2], 0);
    let mut before: Option<(f64, f64)> = None;
    for power in FACTORS {
        let factor = OFFSET * 2f64.powi(power);
        state.start_at_multiple(factor);
        if !state.evaluate() {
            continue;
        }
        let excess = state.excess().ln();
        if !excess.is_finite() {
            continue;
        }
        if let Some((last, at)) = before
            && last.signum() != excess.signum()
            && count < 2
        {
            let crossing = at * (factor / at).powf(last / (last - excess));
            if crossing.ln().abs() >= SAME_FACTOR {
                found[count] = Some(crossing);
                count += 1;
            }
        }
        before = Some((excess, factor));
    }
    found
}

/// Whether what was found is the answer that is kept.
fn is_same(state: &State) -> bool {
    let least = SAME * largest(&state.g);
    let taxels = state.g.iter().zip(&state.kept).zip(&state.noise);
    let mut apart = taxels.map(|((a, b), noise)| ((a - b).abs(), noise));
    apart.all(|(apart, noise)| apart <= least + 2.0 * CHEAP * noise)
}
