//! Lines so long, or so resistive, that readings of the far taxels vanish: what the readings tell and what was believed beforehand,
//! weighed against each other in one sum of squares (Levenberg 1944, Marquardt 1963).
//!
//! Newton's rounds ask each reading for its own taxel, which far ones cannot answer. Here a taxel that no reading tells anything of
//! is left where it was believed to be, and near ones come out with what that makes them uncertain by.

use taxel_linalg::{Spd, View, ViewMut, multiply_lower};

use super::super::gmres::largest;
use super::super::{Outcome, Stop};
use super::state::State;

const MAX_ROUNDS: u32 = 100;
/// The largest conductance that is expected at least, siemens: half of what is believed beforehand.
const EXPECTED_SIEMENS: f64 = 2e-3;
/// Of that, how far below zero one may come out: no conductance is, and what noise makes of an unloaded taxel may.
const BELOW_ZERO: f64 = 0.01;
/// Of that, how near a taxel comes to it.
const NEAREST: f64 = 1e-6;
/// A taxel whose own reading leaves it uncertain by so many times what is believed beforehand is told nothing of.
const UNTOLD: f64 = 10.0;
/// Taxels of an array, at most: of 1024 a round takes tenths of a second, and a frame that no circuit explains takes all rounds.
pub(super) const MOST_TAXELS: usize = 400;
/// Damping: the first, the least that counts, the most; how it falls and rises.
const DAMPING: (f64, f64, f64) = (1e-3, 1e-7, 1e8);
const EASED: f64 = 0.2;
const TIGHTENED: f64 = 6.0;
/// Rounds end when Newton's step is worth so much of one reading's noise, squared: no taxel is off by a tenth of its standard error.
const SETTLED: f64 = 0.01;
/// Or so many rounds, one after the other, have made the sum of squares no smaller than by that.
const SETTLED_ROUNDS: u32 = 3;
/// An error that is small, of what is believed.
const SMALL: f64 = 0.05;
/// Beside taxels of which nothing is told errors are larger than what is linear in them, and marks keep so much farther away.
const BEYOND_LINEAR: f64 = 2.0;

/// Memory for the normal equations, made for the first frame that needs them.
pub(super) struct LeastSquares {
    /// Taxels that readings tell something of.
    told: Vec<usize>,
    /// What each of those moves every reading by, in its noise; one taxel after another.
    moves: Vec<f64>,
    normal: Vec<f64>,
    damped: Vec<f64>,
    factor: Spd,
    right: Vec<f64>,
    step: Vec<f64>,
    /// How far each told taxel is above its least.
    above: Vec<f64>,
    /// What is left of each reading, in its noise.
    left: Vec<f64>,
    unit: Vec<f64>,
    /// Which way readings and beliefs pull each taxel: minus half the slope of the sum of squares.
    pull: Vec<f64>,
    sigma_volts: f64,
    width: f64,
    /// What each conductance is believed to be, siemens.
    centre: f64,
}

impl LeastSquares {
    pub(super) fn new(taxels: usize) -> Self {
        Self {
            told: Vec::with_capacity(taxels),
            moves: vec![0.0; taxels * taxels],
            normal: vec![0.0; taxels * taxels],
            damped: vec![0.0; taxels * taxels],
            factor: Spd::new(taxels),
            right: vec![0.0; taxels],
            step: vec![0.0; taxels],
            above: vec![0.0; taxels],
            left: vec![0.0; taxels],
            unit: vec![0.0; taxels],
            pull: vec![0.0; taxels],
            sigma_volts: 0.0,
            width: EXPECTED_SIEMENS,
            centre: 0.0,
        }
    }

    /// Believes nothing of how much taxels conduct, or as much as those do on average whose errors are small: where all is pressed,
    /// far taxels that were taken for nothing would make those before them seem lighter than they are.
    pub(super) fn believe(&mut self, state: Option<&State>) {
        let known = state.into_iter().flat_map(|state| {
            let taxels = state.g.iter().zip(&state.noise).zip(&state.held);
            taxels.filter(|((_, noise), held)| **held == 0.0 && **noise < SMALL * self.width)
        });
        let mean = crate::stats::mean(known.map(|((g, _), _)| *g));
        self.centre = mean.unwrap_or(0.0).max(0.0);
    }

    /// Solves the frame that `state` has taken, from the conductances in its `g`, which were evaluated. Leaves the standard errors in
    /// its `noise`.
    pub(super) fn solve(&mut self, state: &mut State, sigma_volts: f64) -> Outcome {
        self.sigma_volts = sigma_volts;
        self.width = EXPECTED_SIEMENS.max(largest(&state.measured));
        let (mut damping, mut rounds, mut settled) = (DAMPING.0, 0, 0);
        state.trial.copy_from_slice(&state.g);
        if !state.evaluate() {
            return Outcome::new(Stop::Stalled, 0, f64::INFINITY);
        }
        let mut before = self.weigh(state);
        let stop = loop {
            self.linearise(state);
            if settled == SETTLED_ROUNDS || self.is_settled() {
                break Stop::Converged;
            }
            if rounds == MAX_ROUNDS {
                break Stop::IterationLimit;
            }
            rounds += 1;
            let Some(after) = self.take_step(state, before, &mut damping) else {
                break Stop::Stalled;
            };
            settled = if before - after < SETTLED {
                settled + 1
            } else {
                0
            };
            before = after;
        };
        state.trial.copy_from_slice(&state.g);
        state.evaluate();
        self.find_errors(state);
        Outcome::new(stop, rounds, state.residual())
    }

    /// What is believed of a conductance, as a weight: 1 over its square.
    fn belief(&self) -> f64 {
        self.width.powi(-2)
    }

    /// Takes what is left of each reading at the trial, and what is believed; the sum of squares.
    fn weigh(&mut self, state: &State) -> f64 {
        let mut sum = 0.0;
        for at in 0..self.left.len() {
            let is_unknown = state.held[at] == 0.0;
            let per_noise = 1.0 / (self.sigma_volts * state.measured_slope[at]);
            let left = (state.measured[at] - state.found[at]) * per_noise;
            self.left[at] = if is_unknown { left } else { 0.0 };
            let trial = state.trial[at];
            if is_unknown {
                sum += left * left + (trial - self.centre).powi(2) * self.belief();
            }
        }
        if sum.is_finite() { sum } else { f64::INFINITY }
    }

    /// The normal equations at the trial, which is `g`.
    fn linearise(&mut self, state: &mut State) {
        state.linearise(self.sigma_volts, true);
        self.told.clear();
        for at in 0..state.g.len() {
            if state.held[at] == 0.0 && state.noise[at] < UNTOLD * self.width {
                self.told.push(at);
            }
        }
        let (taxels, told, belief) = (state.g.len(), self.told.len(), self.belief());
        for (at, weight) in self.unit.iter_mut().enumerate() {
            let per_noise = state.slope[at] / (self.sigma_volts * state.measured_slope[at]);
            *weight = per_noise * self.left[at];
        }
        state.pulls_into(&self.unit, &mut self.pull);
        for (at, pull) in self.pull.iter_mut().enumerate() {
            *pull -= belief * (state.g[at] - self.centre);
        }
        self.unit.fill(0.0);
        for (at, moves) in self.told.iter().zip(self.moves.chunks_exact_mut(taxels)) {
            self.unit[*at] = 1.0;
            state.moves_into(&self.unit, moves);
            self.unit[*at] = 0.0;
            for (i, moved) in moves.iter_mut().enumerate() {
                let per_noise = state.slope[i] / (self.sigma_volts * state.measured_slope[i]);
                *moved *= per_noise * (1.0 - state.held[i]);
            }
        }
        let moves = &self.moves[..told * taxels];
        let view = || View::new(moves, told, taxels);
        let normal = &mut self.normal[..told * told];
        multiply_lower(ViewMut::new(normal, told, told), view(), view().transpose());
        for (place, at) in self.told.iter().enumerate() {
            normal[place * told + place] += belief;
            let least = BELOW_ZERO * self.width;
            self.above[place] = (state.g[*at] + least).max(NEAREST * least);
            self.right[place] = self.pull[*at];
        }
    }

    /// Factorises the normal equations with so much damping, and with what keeps each taxel above its least; false where that cannot be.
    fn factorise(&mut self, damping: f64, keeps: bool) -> bool {
        let told = self.told.len();
        let damped = &mut self.damped[..told * told];
        damped.copy_from_slice(&self.normal[..told * told]);
        for place in 0..told {
            let own = &mut damped[place * told + place];
            *own *= 1.0 + damping;
            if keeps {
                *own += pressed(self.right[place], self.above[place]);
            }
        }
        self.factor.resize(told);
        self.factor.factorise(damped)
    }

    /// Newton's step by the normal equations with so much damping; false where they have none.
    fn find_step(&mut self, damping: f64) -> bool {
        let told = self.told.len();
        if !self.factorise(damping, true) {
            return false;
        }
        self.step[..told].copy_from_slice(&self.right[..told]);
        self.factor.solve(&mut self.step[..told]);
        true
    }

    fn is_settled(&mut self) -> bool {
        let told = self.told.len();
        self.find_step(0.0) && taxel_linalg::dot(&self.step[..told], &self.right[..told]) <= SETTLED
    }

    /// Takes the first step that makes the sum of squares smaller, with more and more damping; the sum after it.
    fn take_step(&mut self, state: &mut State, before: f64, damping: &mut f64) -> Option<f64> {
        let least = BELOW_ZERO * self.width;
        while *damping <= DAMPING.2 {
            if self.find_step(*damping) {
                // One that nothing is told of is held by what is believed alone.
                for at in 0..state.g.len() {
                    let above = (state.g[at] + least).max(NEAREST * least);
                    let curvature = self.belief() * (1.0 + *damping);
                    let step = self.pull[at] / (curvature + pressed(self.pull[at], above));
                    state.trial[at] = if state.held[at] > 0.0 {
                        state.g[at]
                    } else {
                        moved(above, step) - least
                    };
                }
                let steps = self.step.iter().zip(&self.above);
                for (at, (step, above)) in self.told.iter().zip(steps) {
                    state.trial[*at] = moved(*above, *step) - least;
                }
                if state.evaluate() {
                    let after = self.weigh(state);
                    if after < before {
                        state.g.copy_from_slice(&state.trial);
                        *damping = (EASED * *damping).max(DAMPING.1);
                        return Some(after);
                    }
                }
            }
            *damping *= TIGHTENED;
        }
        None
    }

    /// The standard error of every taxel by the normal equations.
    fn find_errors(&mut self, state: &mut State) {
        let told = self.told.len();
        if !self.factorise(0.0, false) {
            return;
        }
        self.factor.inverse_into(&mut self.damped[..told * told]);
        for noise in &mut state.noise {
            *noise = noise.max(self.width);
        }
        for (place, at) in self.told.iter().enumerate() {
            state.noise[*at] = BEYOND_LINEAR * self.damped[place * told + place].sqrt();
        }
    }
}

/// What holds a taxel that is pulled down this far above its least: it goes no further than that (Coleman and Li 1996).
fn pressed(pull: f64, above: f64) -> f64 {
    (-pull).max(0.0) / above
}

/// A positive number after a step, positive again: down by the step's share of it over and over.
fn moved(number: f64, step: f64) -> f64 {
    if step < 0.0 {
        number * (step / number).exp()
    } else {
        number + step
    }
}
