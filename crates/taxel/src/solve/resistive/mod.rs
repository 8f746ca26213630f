//! Lines that resist: Newton's method on apparent conductances, with the derivative among the taxels of each row and each column
//! inverted exactly ([`preconditioner`]), to as far as noise allows.
//!
//! Where a taxel is hardly reached, an answer as exact as elsewhere would be noise: each is believed to be of a usable size
//! beforehand, which counts only where a reading tells less than that (μ, Tikhonov's), and rounds end when every step left is a
//! tenth of what noise makes.

mod another;
mod least_squares;
mod preconditioner;
mod state;

use super::gmres::largest;
use super::{Outcome, Stop};
use crate::circuit::LinearCircuit;
use crate::{Frame, Mark, Siemens, Volts};
use least_squares::{LeastSquares, MOST_TAXELS};
use state::State;

/// Rounds of one attempt, and after how many the prior's part is kept as it is.
const MAX_ROUNDS: u32 = 40;
const FREEZE_AFTER: u32 = 12;
/// A misfit, over the largest conductance, below which the preconditioner of the round before serves.
const NEAR: f64 = 0.05;
/// Steps with a derivative of an earlier frame.
const MAX_FROZEN: u32 = 10;
/// A derivative that needs more steps than this is too old.
const OLD: u32 = 6;
/// Part of a step that is still taken.
const MIN_LENGTH: f64 = 0.03;
const SHORTEN: f64 = 0.3;
/// A step longer than so many times the conductance is cut to between these multiples of it.
const LONG: f64 = 3.0;
const CLIP: (f64, f64) = (-0.75, 3.0);
/// A cut step may make the merit so many times worse.
const MAX_RISE: f64 = 1.1;
/// Where no noise ends the rounds, a misfit of this share of the tolerance does: what each taxel misfits by is less than what all of
/// them make of one another.
const WITHOUT_NOISE: f64 = 0.25;
/// Part of the misfit that a step may leave, at least and at most; where no noise ends the rounds, no more than so many tolerances.
const LEFT: (f64, f64) = (1e-3, 5e-2);
const TOLERANCES: f64 = 1e4;
/// Noise that a hard frame is first solved with, of the largest reading: the first that leads anywhere. From answer to answer it is
/// so many times less, down to a few times what there is, and to that.
const EASED: [f64; 3] = [0.02, 0.2, 2.0];
const EASE: f64 = 10.0;
const FEW: f64 = 3.0;
const LAST: [f64; 2] = [1.7, 1.0];
/// After so many rounds nothing more is tried: those that led somewhere took up to 180.
const MOST_ROUNDS: u32 = 240;
/// Multiples of the apparent conductances that least squares begin from.
const STARTS: [f64; 3] = [1.0, 3.0, 0.3];
/// Readings that such an answer leaves so many times as far off as noise does are not explained.
const EXPLAINED: f64 = 1.5;

/// A standard error that counts, of the largest conductance, and one that leaves nothing to be told; and how much larger than by its own derivative alone a taxel's may be.
const UNRESOLVED: (f64, f64) = (0.01, 0.25);
const CHEAP: f64 = 3.0;
/// A taxel that is read no more than so many times worse than the best is one of a light load, not one behind its lines.
const AS_GOOD: f64 = 4.0;

/// How steps are accepted.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Merit {
    /// The norm of the misfit falls.
    Norm,
    /// Long steps are cut, taxel by taxel, and the sum of logarithms of relative misfits does not rise much.
    Clip,
}

/// What it is solved to.
#[derive(Debug, Clone, Copy)]
pub(super) struct Accuracy {
    /// Of the largest conductance.
    pub(super) tolerance: f64,
    /// Standard deviation of a reading.
    pub(super) sigma_volts: f64,
    /// A frame that is hard to solve may take hundreds of rounds.
    pub(super) is_patient: bool,
}

/// One stream of frames.
pub(super) struct Resistive {
    state: State,
}

impl Resistive {
    /// For a circuit whose lines resist; none for another.
    pub(super) fn new(circuit: &LinearCircuit) -> Option<Self> {
        Some(Self {
            state: State::new(circuit)?,
        })
    }

    pub(super) fn forget(&mut self) {
        self.state.is_warm = false;
    }

    /// Solves a frame, from conductances that it is believed to be near, from the frame before, or from nothing.
    pub(super) fn solve(
        &mut self,
        volts: &Frame<Volts>,
        siemens: &mut Frame<Siemens>,
        (unloaded_siemens, accuracy): (f64, Accuracy),
        near: Option<&[f64]>,
    ) -> Outcome {
        let state = &mut self.state;
        state.take(volts, unloaded_siemens);
        if let Some(near) = near {
            state.g.copy_from_slice(near);
            state.is_warm = true;
        }
        let outcome = solve_taken(state, accuracy);
        state.is_warm = outcome.is_answer();
        siemens.values_mut().copy_from_slice(&state.g);
        mark_unresolved(state, siemens);
        outcome
    }
}

/// Marks what noise alone could make of a taxel that hardly reads: where the standard error by its own derivative is more than the
/// taxel conducts, and counts beside the largest, or is a good part of that. In a frame without loads that is noise itself: what is
/// read as well as anything stays.
fn mark_unresolved(state: &State, siemens: &mut Frame<Siemens>) {
    let resolved = Resolved::of(state);
    let taxels = siemens.marks.iter_mut().zip(&siemens.values);
    for ((mark, g), noise) in taxels.zip(&state.noise) {
        if *mark == Mark::Good && !resolved.is_so(*g, *noise) {
            *mark = Mark::Unresolved;
        }
    }
}

/// What counts beside the largest conductance of a frame, and a noise that leaves nothing to be told, siemens.
struct Resolved {
    counts: f64,
    useless: f64,
}

impl Resolved {
    fn of(state: &State) -> Self {
        // Noise of a taxel that nothing is told of may be larger than any load.
        let told = state
            .g
            .iter()
            .zip(&state.noise)
            .map(|(g, noise)| (g.abs(), noise));
        let told = told.filter(|(g, noise)| CHEAP * *noise <= *g);
        let most = told.fold(0.0, |most: f64, (g, _)| most.max(g));
        let most = most.max(AS_GOOD * CHEAP * state.best_noise() / UNRESOLVED.0);
        Self {
            counts: UNRESOLVED.0 * most,
            useless: UNRESOLVED.1 * most,
        }
    }

    fn is_so(&self, g: f64, noise: f64) -> bool {
        CHEAP * noise <= g.abs().max(self.counts).min(self.useless)
    }
}

fn solve_taken(state: &mut State, accuracy: Accuracy) -> Outcome {
    if let Some(infeasible) = state.infeasible() {
        state.g.fill(0.0);
        state.hold();
        return Outcome::new(Stop::Infeasible(infeasible), 0, f64::INFINITY);
    }
    state.take_apparent();
    state.least_noise.fill(0.0);
    if largest(&state.measured) == 0.0 {
        state.g.fill(0.0);
        state.hold();
        return Outcome::new(Stop::Converged, 0, 0.0);
    }
    let mut rounds = 0;
    if state.is_warm {
        state.hold();
        if state.is_fresh {
            state.kept.copy_from_slice(&state.g);
            if let Some(outcome) = follow(state, accuracy) {
                return outcome;
            }
            state.g.copy_from_slice(&state.kept);
        }
        state.trial.copy_from_slice(&state.g);
        if state.evaluate() {
            let outcome = descend(state, accuracy, Merit::Norm);
            if outcome.stop.is_good() {
                return outcome;
            }
            rounds += outcome.iterations;
        }
    }
    let outcome = cold(state, accuracy);
    Outcome {
        iterations: rounds + outcome.iterations,
        ..outcome
    }
}

/// From nothing: in the ways that were seen to lead somewhere.
fn cold(state: &mut State, mut accuracy: Accuracy) -> Outcome {
    let mut rounds = 0;
    let mut last = Outcome::new(Stop::Stalled, 0, f64::INFINITY);
    let merits = if state.floating {
        [Merit::Norm, Merit::Clip]
    } else {
        [Merit::Clip, Merit::Norm]
    };
    for merit in merits {
        if !start(state) {
            break;
        }
        last = descend(state, accuracy, merit);
        rounds += last.iterations;
        if last.stop.is_good() {
            break;
        }
    }
    let is_patient = accuracy.sigma_volts > 0.0 && accuracy.is_patient;
    let is_good = last.stop.is_good();
    if is_patient && (!is_good || state.beyond_noise(accuracy.sigma_volts) > EXPLAINED) {
        if state.g.len() <= MOST_TAXELS {
            last = weigh(state, accuracy.sigma_volts);
            last.iterations += rounds;
            return last;
        }
        if !is_good {
            (last, accuracy) = ease(state, accuracy);
            rounds += last.iterations;
        }
    }
    let mut last = Outcome {
        iterations: rounds,
        ..last
    };
    if last.stop.is_good() && !state.shares {
        another::look_for(state, accuracy, &mut last);
    }
    last
}

/// By least squares, from one start after another until the readings are explained. On arrays of so long lines nothing may be told of
/// the far taxels, and the near ones are told all the same.
fn weigh(state: &mut State, sigma_volts: f64) -> Outcome {
    let taxels = state.g.len();
    let known = state.least_squares.take();
    let mut equations = known.unwrap_or_else(|| Box::new(LeastSquares::new(taxels)));
    let mut last = Outcome::new(Stop::Stalled, 0, f64::INFINITY);
    let mut rounds = 0;
    for times in STARTS {
        if !start(state) {
            break;
        }
        for g in &mut state.g {
            *g *= times;
        }
        state.hold();
        equations.believe(None);
        rounds += equations.solve(state, sigma_volts).iterations;
        if state.beyond_noise(sigma_volts) <= EXPLAINED {
            equations.believe(Some(state));
            last = equations.solve(state, sigma_volts);
            rounds += last.iterations;
        }
        if state.beyond_noise(sigma_volts) <= EXPLAINED {
            last.stop = Stop::Converged;
            break;
        }
        last.stop = Stop::Stalled;
    }
    state.least_squares = Some(equations);
    state.is_fresh = false;
    last.iterations = rounds;
    last
}

/// On arrays too large for that: as if there were more noise, and from answer to answer less of it. The last one is the answer where it explains the readings: with
/// more noise than there is more taxels are unresolved. On arrays of so long lines what is told of the far ones is next to nothing.
fn ease(state: &mut State, accuracy: Accuracy) -> (Outcome, Accuracy) {
    let mut best = (Outcome::new(Stop::Stalled, 0, f64::INFINITY), accuracy);
    let mut rounds = 0;
    for first in EASED {
        if rounds > MOST_ROUNDS || !start(state) {
            break;
        }
        state.kept.copy_from_slice(&state.g);
        state.kept_noise.fill(0.0);
        let powers = (first * state.largest_volts / (FEW * accuracy.sigma_volts)).log(EASE);
        let powers = powers.round().max(0.0) as i32;
        let eased = (0..=powers).rev().map(|power| FEW * EASE.powi(power));
        for times in eased.chain(LAST) {
            let sigma_volts = times * accuracy.sigma_volts;
            let eased = Accuracy {
                sigma_volts,
                ..accuracy
            };
            let is_answer = best.0.stop.is_good();
            let Some(outcome) = ease_once(state, eased, is_answer, &mut rounds) else {
                break;
            };
            best = (outcome, eased);
        }
        if best.0.stop.is_good() {
            break;
        }
    }
    if state.beyond_noise(accuracy.sigma_volts) > EXPLAINED {
        best.0.stop = Stop::Stalled;
    }
    best.0.iterations = rounds;
    best
}

/// From what is kept, evaluated: as far as the readings tell, or where that leads nowhere and it is an answer, without what was left
/// unresolved there.
fn ease_once(
    state: &mut State,
    eased: Accuracy,
    is_answer: bool,
    rounds: &mut u32,
) -> Option<Outcome> {
    for holds in [false, true] {
        if *rounds > MOST_ROUNDS || holds && !is_answer {
            break;
        }
        if holds {
            hold_unresolved(state);
        }
        let outcome = descend(state, eased, Merit::Norm);
        *rounds += outcome.iterations;
        state.least_noise.fill(0.0);
        if outcome.stop.is_good() {
            state.kept.copy_from_slice(&state.g);
            state.kept_noise.copy_from_slice(&state.noise);
            return Some(outcome);
        }
        state.noise.copy_from_slice(&state.kept_noise);
        state.is_fresh = false;
        if !state.return_to_kept() {
            break;
        }
    }
    None
}

/// Has each taxel that noise leaves unresolved believed beforehand as much as now.
fn hold_unresolved(state: &mut State) {
    let resolved = Resolved::of(state);
    for at in 0..state.g.len() {
        let is_resolved = resolved.is_so(state.g[at], state.noise[at]);
        state.least_noise[at] = if is_resolved { 0.0 } else { state.noise[at] };
    }
}

/// The apparent conductances; of lines that float the multiple of them that reads the measured sum.
fn start(state: &mut State) -> bool {
    let mut factor = 1.0;
    if state.floating {
        let (mut low, mut high) = ((1e-3f64).ln(), (1e3f64).ln());
        for _ in 0..12 {
            let middle = 0.5 * (low + high);
            state.start_at(middle.exp());
            if state.evaluate() && state.excess() < 1.0 {
                low = middle;
            } else {
                high = middle;
            }
        }
        factor = (0.5 * (low + high)).exp();
    }
    state.start_at(factor);
    state.g.copy_from_slice(&state.trial);
    state.evaluate()
}

/// The frame after one whose derivative is known: steps with that alone. Nothing where they do not lead there.
fn follow(state: &mut State, accuracy: Accuracy) -> Option<Outcome> {
    state.mixing.restart();
    for round in 0..MAX_FROZEN {
        state.trial.copy_from_slice(&state.g);
        if !state.evaluate() {
            return None;
        }
        if state.is_settled(accuracy.tolerance) {
            state.is_fresh = round <= OLD;
            return Some(Outcome::new(Stop::Converged, round, state.residual()));
        }
        state.find_frozen_step();
        for (step, g) in state.step.iter_mut().zip(&state.g) {
            *step += g;
        }
        state.mixing.advance(&mut state.g, &state.step);
        state.hold();
    }
    None
}

/// Newton's rounds from `g`, which was evaluated.
fn descend(state: &mut State, accuracy: Accuracy, merit: Merit) -> Outcome {
    let (tolerance, least) = if accuracy.sigma_volts > 0.0 {
        (accuracy.tolerance, LEFT.0)
    } else {
        let tolerance = accuracy.tolerance;
        (
            WITHOUT_NOISE * tolerance,
            LEFT.0.min(TOLERANCES * tolerance),
        )
    };
    for round in 0..MAX_ROUNDS {
        state.linearise(accuracy.sigma_volts, round > FREEZE_AFTER);
        let residual = state.residual();
        if state.is_settled(tolerance) {
            // What is new since the last preconditioner is less than a step.
            return Outcome::new(Stop::Converged, round, residual);
        }
        let size = largest(&state.misfit) / largest(&state.g);
        // Near the answer the derivative of the round before leads there as well.
        let is_known = round > 0 && size < NEAR;
        if !is_known && !state.precondition() {
            return Outcome::new(Stop::Stalled, round, residual);
        }
        state.find_step((0.3 * size).clamp(least, LEFT.1));
        if !take_step(state, merit) {
            // Back to the best point, so that the misfit is that of the answer.
            state.trial.copy_from_slice(&state.g);
            state.evaluate();
            return Outcome::new(Stop::Stalled, round, state.residual());
        }
    }
    Outcome::new(Stop::IterationLimit, MAX_ROUNDS, state.residual())
}

/// Takes a step, or the part of it that is acceptable.
fn take_step(state: &mut State, merit: Merit) -> bool {
    let before = measure(state, merit);
    let least = 1e-3 * largest(&state.g);
    let is_long = merit == Merit::Clip
        && state
            .step
            .iter()
            .zip(&state.g)
            .any(|(step, g)| step.abs() > LONG * (g.abs() + least));
    if is_long {
        let taxels = state.step.iter_mut().zip(&state.g).zip(&state.noise);
        for ((step, g), noise) in taxels {
            let size = g.abs() + least + noise;
            *step = step.clamp(CLIP.0 * size, CLIP.1 * size);
        }
    }
    let allowed = if is_long { MAX_RISE } else { 1.0 };
    let mut length = 1.0;
    while length >= MIN_LENGTH {
        for ((trial, g), step) in state.trial.iter_mut().zip(&state.g).zip(&state.step) {
            *trial = g + length * step;
        }
        if state.evaluate() && measure(state, merit) < allowed * before {
            state.g.copy_from_slice(&state.trial);
            return true;
        }
        length *= SHORTEN;
    }
    false
}

fn measure(state: &State, merit: Merit) -> f64 {
    match merit {
        Merit::Norm => state.misfit.iter().map(|r| r * r).sum(),
        Merit::Clip => {
            let least = 1e-3 * largest(&state.g);
            let taxels = state.misfit.iter().zip(&state.g);
            taxels
                .map(|(r, g)| (r.abs() / (g.abs() + least)).ln_1p())
                .sum()
        }
    }
}
