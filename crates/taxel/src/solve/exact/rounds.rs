//! The rounds of the fixed point: which of them are in single precision, and where they stop.

use super::super::{Outcome, Stop};
use super::Accuracy;
use super::state::SolverState;

const MAX_ROUNDS: u32 = 60;
/// How far a round goes of where it leads: all the way, or with care, where that leads nowhere (columns' resistances that are many times too
/// large, whose frames still have an answer).
pub(super) const ALL_THE_WAY: f64 = 1.0;
pub(super) const WITH_CARE: f64 = 0.5;
/// The rounds left change a conductance by about change × ratio/(1 − ratio) in all; how much more is allowed
/// for, since mixed steps are irregular.
pub(super) const SAFETY: f64 = 4.0;
const SLOWEST: f64 = 0.9;
/// What a change is expected to be of the one before, where that is not known yet.
const USUAL_RATIO: f64 = 0.1;
/// Rounds are in single precision while changes of more than this share of the largest conductance are expected, and to the end where no
/// more accuracy is asked for: what they move, a part of each share, errs by some 1e-7 of itself.
const SINGLE: f64 = 2e-6;
const SINGLE_TO_THE_END: f64 = 5e-7;
/// Where columns conduct much more to taxels than to their ends, more of the digits are lost: changes below this share that shrink by less than
/// this factor are left to double precision.
const SMALL: f64 = 1e-4;
const STANDS_STILL: f64 = 0.4;
/// A mixed step whose change is so many times the one before is taken back, unless that is next to nothing.
const GROWN: f64 = 1.5;
const NOTHING: f64 = 10.0;
/// From this round on, changes as large as this are those of an iteration that leads nowhere.
const LATE: u32 = 12;
const STALLED: f64 = 0.3;

/// In so many rounds a sheet's couplings have come near to where they lead, from nothing and from those of the frame before: near enough for
/// single precision.
const EARLY_COLD: u32 = 3;
const EARLY_WARM: u32 = 2;

/// Where a frame differs from the one before by more than this share of its largest conductance, that one is no start: what the mixing has learnt
/// there misleads, and changes tell nothing of what is left (up to 21 standard errors of rounding at 50 Ω, where every frame is another).
const JUMP: f64 = 0.2;

/// Goes to the accuracy, each round `part` of the way; gives up (`Stalled`) where it does not contract.
pub(super) fn run(state: &mut SolverState, accuracy: Accuracy, part: f64) -> Outcome {
    let is_cold = !state.warm;
    state.begin(is_cold);
    let mut course = Course::new(accuracy.share);
    let mut is_single = true;
    for round in 1..=MAX_ROUNDS {
        let stalled = Outcome::new(Stop::Stalled, round, course.last_change);
        if is_single && !course.may_be_single(round) {
            state.full.take(&state.half);
            is_single = false;
        }
        let is_first = is_cold && round == 1;
        if let Some(sideways) = &mut state.sideways {
            let early = if is_cold { EARLY_COLD } else { EARLY_WARM };
            sideways.is_late = is_single && round > early;
        }
        let seen = state.conductances(is_single, is_first);
        let Some((largest, change)) = seen else {
            return stalled;
        };
        let change = change / largest;
        course.tolerance = accuracy.at(largest);
        if !change.is_finite() || (round > LATE && change > STALLED) {
            return stalled;
        }
        if round == 1 && state.warm && state.follows && change > JUMP {
            state.warm = false;
            return run(state, accuracy, part);
        }
        if course.has_grown(change) && state.retreat(is_single) {
            continue;
        }
        if course.ends(round, change, is_single) {
            state.finish(is_single);
            return Outcome::new(Stop::Converged, round, change);
        }
        state.advance(is_single, part);
    }
    state.finish(is_single);
    Outcome::new(Stop::IterationLimit, MAX_ROUNDS, course.last_change)
}

/// How the changes of the largest conductance have gone.
struct Course {
    tolerance: f64,
    /// Of the last change to the one before, from the third round on.
    ratio: Option<f64>,
    last_change: f64,
}

impl Course {
    fn new(tolerance: f64) -> Self {
        Self {
            tolerance,
            ratio: None,
            last_change: f64::INFINITY,
        }
    }

    fn left(change: f64, ratio: f64) -> f64 {
        let ratio = ratio.min(SLOWEST);
        SAFETY * change * ratio / (1.0 - ratio)
    }

    /// Whether small changes hardly shrink any more: they may be those of the digits.
    fn has_stood_still(&self) -> bool {
        self.last_change < SMALL && self.ratio.is_some_and(|ratio| ratio > STANDS_STILL)
    }

    /// Whether half of the digits are enough for the next round.
    fn may_be_single(&self, round: u32) -> bool {
        // The first change is none of the iteration's.
        if round <= 2 {
            return true;
        }
        let ratio = self.ratio.unwrap_or(USUAL_RATIO);
        if self.has_stood_still() {
            return false;
        }
        self.tolerance >= SINGLE_TO_THE_END || self.last_change * ratio > SINGLE
    }

    /// Whether the last step has led away: mixed with others that were nearly one another's multiples, it may lead to an answer that
    /// belongs to no network.
    fn has_grown(&self, change: f64) -> bool {
        change > GROWN * self.last_change && change > NOTHING * self.tolerance
    }

    /// Whether no conductance is estimated to change by more than the tolerance any more.
    fn ends(&mut self, round: u32, change: f64, is_single: bool) -> bool {
        // From the second change on, their ratio says what is left.
        let ratio = match round {
            1 | 2 => 1.0,
            _ => change / self.last_change,
        };
        let left = Self::left(change, ratio.max(self.ratio.unwrap_or(0.0)));
        if round >= 3 {
            self.ratio = Some(ratio);
        }
        self.last_change = change;
        let is_told = !is_single || self.tolerance >= SINGLE_TO_THE_END;
        round > 1 && left <= self.tolerance && is_told
    }
}
