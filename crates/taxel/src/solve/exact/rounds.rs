//! The rounds of the fixed point in S: which of them are in single precision, and where they stop.

use super::super::network::Network;
use super::super::{Outcome, Stop};
use super::Accuracy;
use super::state::{SolverState, unpack};
use taxel_linalg::{View, ViewMut, multiply_lower};

const MAX_ROUNDS: u32 = 25;
/// The rounds left change a conductance by about change × ratio/(1 − ratio) in all; how much more is allowed
/// for, since mixed steps are irregular.
pub(super) const SAFETY: f64 = 4.0;
const SLOWEST: f64 = 0.9;
/// Under a sheet no ratio counts for less: in a steady stream mixing foresees most of a change at once, and what it has not
/// foreseen shrinks as slowly as ever (frames that stopped in the third round were off by 2e-8).
const LEAST_RATIO: f64 = 0.08;
/// What a change is expected to be of the one before, where that is not known yet.
const USUAL_RATIO: f64 = 0.1;
/// A round is in double precision where no more than so many times the tolerance is expected to be left after it: it may be the last one.
const NEARLY: f64 = 10.0;
/// A round is in single precision where the change expected of it, a share of the largest conductance, times the tolerance is above this: its
/// products err by some 1e-7 of their terms, which bends the mixing of the rounds after it.
const SINGLE: f64 = 1e-11;

/// Where a frame differs from the one before by more than this share of its largest conductance, that one is no start: what the mixing has learnt
/// there misleads, and changes tell nothing of what is left (up to 21 standard errors of rounding at 50 Ω, where every frame is another).
const JUMP: f64 = 0.2;

/// The fixed point in S; gives up (`Stalled`) as soon as it does not contract.
pub(super) fn run(state: &mut SolverState, accuracy: Accuracy) -> Outcome {
    for (root, p) in state.diagonal.iter_mut().zip(&state.network.p) {
        *root = p.sqrt();
    }
    let is_cold = !state.warm;
    start(state);
    if let Some(sideways) = &mut state.network.sideways {
        sideways.begin();
    }
    let mut course = Course::new(accuracy.share, state.network.sideways.is_some());
    let mut was_single = false;
    for round in 1..=MAX_ROUNDS {
        let stalled = Outcome::new(Stop::Stalled, round, course.last_change);
        let is_single = course.may_be_single(round);
        if was_single && !is_single {
            state.single.conductances_into(&mut state.network.g);
        }
        was_single = is_single;
        let network = &mut state.network;
        let seen = if is_single {
            let is_diagonal = is_cold && round == 1;
            (state.single).conductances(&state.packed, is_diagonal, network)
        } else {
            conductances(network, &state.packed)
        };
        let Some((largest, change)) = seen else {
            return stalled;
        };
        let change = change / largest;
        course.tolerance = accuracy.at(largest);
        if !change.is_finite() || (round > 4 && change > 0.3) {
            return stalled;
        }
        if round == 1 && state.warm && state.follows && change > JUMP {
            state.warm = false;
            return run(state, accuracy);
        }
        if course.ends(round, change) && !is_single {
            return Outcome::new(Stop::Converged, round, change);
        }
        if !image_of(state, is_single) {
            return stalled;
        }
        state.mixing.advance(&mut state.packed, &state.image);
    }
    Outcome::new(Stop::IterationLimit, MAX_ROUNDS, course.last_change)
}

/// How the changes of the largest conductance have gone.
struct Course {
    tolerance: f64,
    has_sheet: bool,
    /// Of the last change to the one before, from the third round on.
    ratio: Option<f64>,
    last_change: f64,
}

impl Course {
    fn new(tolerance: f64, has_sheet: bool) -> Self {
        Self {
            tolerance,
            has_sheet,
            ratio: None,
            last_change: f64::INFINITY,
        }
    }

    fn left(change: f64, ratio: f64) -> f64 {
        let ratio = ratio.min(SLOWEST);
        SAFETY * change * ratio / (1.0 - ratio)
    }

    /// Whether the next round leaves so much that half of the digits are enough for it.
    fn may_be_single(&self, round: u32) -> bool {
        // The first change is none of the iteration's.
        if round <= 2 {
            return true;
        }
        let ratio = self.ratio.unwrap_or(USUAL_RATIO);
        let change = self.last_change * ratio;
        let left = Self::left(change, ratio);
        change * self.tolerance > SINGLE && left > NEARLY * self.tolerance
    }

    /// Whether no conductance is estimated to change by more than the tolerance any more.
    fn ends(&mut self, round: u32, change: f64) -> bool {
        // From the second change on, their ratio says what is left.
        let ratio = match round {
            1 | 2 => 1.0,
            _ if self.has_sheet => (change / self.last_change).max(LEAST_RATIO),
            _ => change / self.last_change,
        };
        let left = Self::left(change, ratio.max(self.ratio.unwrap_or(0.0)));
        if round >= 3 {
            self.ratio = Some(ratio);
        }
        self.last_change = change;
        round > 1 && left <= self.tolerance
    }
}

/// Below this no denominator is held: where one is not positive there is no answer.
pub(super) const FLOOR: f64 = f64::MIN_POSITIVE;

/// G of the network from S. The largest conductance and the largest change of one; nothing where a column's denominator is
/// not positive.
fn conductances(network: &mut Network, packed: &[f64]) -> Option<(f64, f64)> {
    let m = network.m;
    unpack(packed, &mut network.s, m, |s| s);
    network.take_couplings(&packed[m * (m + 1) / 2..]);
    if network.columns_from_s(FLOOR).0 <= 0.0 || network.settle(FLOOR) <= 0.0 {
        return None;
    }
    Some(network.conductances())
}

/// The first S: the previous frame's, scaled to this one's P_rr, or diag(1/P_rr); and the weights that make its entries comparable.
fn start(state: &mut SolverState) {
    let SolverState {
        network,
        packed,
        mixing,
        stretch,
        diagonal: root_p,
        ..
    } = state;
    let m = network.m;
    if state.warm {
        mixing.resume();
    } else {
        mixing.restart();
    }
    let weights = mixing.weights_mut();
    let mut at = 0;
    for i in 0..m {
        for j in 0..=i {
            weights[at] = root_p[i] * root_p[j];
            let kept = if state.warm {
                packed[at] * stretch[i] * stretch[j]
            } else {
                0.0
            };
            packed[at] = if i == j && kept == 0.0 {
                1.0 / network.p[i]
            } else {
                kept
            };
            at += 1;
        }
    }
    // Couplings are small beside what columns and rows conduct: as much as resistances of one size make comparable.
    let ohms = root_p.iter().map(|root| root * root).sum::<f64>() / m as f64;
    weights[at..].fill(ohms);
    if !state.warm {
        network.g.fill(0.0);
        packed[at..].fill(0.0);
    }
}

/// The next S, packed, from the conductances of the present one. False when it is not positive definite.
fn image_of(state: &mut SolverState, is_single: bool) -> bool {
    let SolverState {
        network,
        packed,
        image,
        diagonal,
        triangle,
        single,
        ..
    } = state;
    let m = network.m;
    if is_single {
        single.product_into(&mut network.product);
    } else {
        let (g, h) = (
            View::new(&network.g, m, network.n),
            View::new(&network.h, m, network.n),
        );
        multiply_lower(ViewMut::new(&mut network.product, m, m), g, h.transpose());
    }
    let now = network.sideways.as_ref().map(|s| &s.now);
    if let Some(now) = now {
        let (rows, columns) = image[m * (m + 1) / 2..].split_at_mut(now.small.len());
        rows.copy_from_slice(&now.small);
        columns.copy_from_slice(&now.large);
    }
    for i in 0..m {
        let (low, at) = (i * m, i * (i + 1) / 2);
        let lines = image[at..at + i].iter_mut();
        for (image, product) in lines.zip(&mut network.product[low..low + i]) {
            *product = -*product;
            *image = *product;
        }
        if let (Some(now), Some(before)) = (now, i.checked_sub(1)) {
            network.product[low + before] -= now.small[before];
        }
        image[at + i] = packed[at + i];
        network.product[low + i] = packed[at + i];
    }
    if !network.spd.factorise(&network.product) {
        return false;
    }
    network.spd.inverse_diagonal_into(diagonal, triangle);
    for i in 0..m {
        let found = diagonal[i];
        // 1/found is the Schur complement of S_ii, so this makes it 1/P_rr if no other entry moves.
        image[i * (i + 1) / 2 + i] += 1.0 / network.p[i] - 1.0 / found;
    }
    true
}
