//! Every linear topology: Newton's method, matrix-free, on the taxels' apparent conductances.
//!
//! The reading of a taxel is first freed of its own series path, y = I/(V_t − I·(R_c + R_v + R_end)): what
//! the taxel would be if it were alone. Then y ≈ G with a diagonal derivative near one, and what GMRES has
//! left to undo is the cross-talk.

mod behind;
mod held;
mod shared_lines;
mod state;

use super::gmres::largest;
use super::resistive::{Accuracy, Resistive};
use super::{Method, Outcome, Solver, Stop};
use crate::circuit::{DiodeCircuit, LinearCircuit, OperatingPoint};
use crate::sensor::Sensor;
use crate::{Frame, Siemens, Volts};
use behind::Behind;
use state::Shape;
pub(crate) use state::SolverState;

/// Newton's method for any linear circuit.
#[derive(Debug, Clone, PartialEq)]
pub struct Newton {
    circuit: LinearCircuit,
    /// What driven lines' diodes drop is taken off first.
    driven: Option<Box<DiodeCircuit>>,
    tolerance: f64,
    iterations: u32,
    restarts: usize,
    unloaded_siemens: f64,
    /// Whether lost readings are no part of the system: columns are left open.
    holds_lost: bool,
    /// Standard deviation of a reading, and of its rounding: lines that resist are solved no further than they tell.
    noise_volts: f64,
    rounding_volts: f64,
}

const MAX_ITERATIONS: u32 = 60;
const RESTARTS: usize = 6;
/// Factors of an answer nearer to 1 than this (in the logarithm) are the answer itself.
const SAME_FACTOR: f64 = 0.02;

/// A misfit of the frame before, as a share of the largest reading, from which its answer is begun with.
const NEAR: f64 = 0.05;

/// So many steps in a row shorter than this share of Newton's lead nowhere: the derivative is all but singular there.
const SHORT: f64 = 1e-3;
const SHORT_STEPS: u32 = 3;
/// Other multiples of the measured shape to begin from, where the likely ones lead nowhere.
const OTHER_STARTS: [f64; 4] = [1.0, 2.0, 0.5, 0.2];
/// Rounds from each of them: where they lead anywhere, 22 were enough.
const MAX_OTHER_ITERATIONS: u32 = 25;

impl Newton {
    /// The method for a circuit.
    pub fn new(circuit: LinearCircuit) -> Self {
        Self {
            circuit,
            driven: None,
            tolerance: 1e-9,
            iterations: MAX_ITERATIONS,
            restarts: RESTARTS,
            unloaded_siemens: 0.0,
            holds_lost: false,
            noise_volts: 0.0,
            rounding_volts: 0.0,
        }
    }

    /// The method for a sensor's circuit: a taxel whose reading is below what is recorded is taken to be unloaded.
    pub(crate) fn from_sensor(sensor: &Sensor, circuit: LinearCircuit) -> Self {
        let (noise_volts, rounding_volts) = super::noise_and_rounding_volts(sensor);
        Self {
            unloaded_siemens: super::unloaded_siemens(sensor),
            holds_lost: sensor.readout().has_open_columns(),
            noise_volts,
            rounding_volts,
            ..Self::new(circuit)
        }
    }

    /// The method for the circuit behind the diodes of driven lines: each column's readings tell what its diode drops, and are those
    /// of the linear circuit at what is left of V_t.
    pub(crate) fn behind_diodes(sensor: &Sensor, circuit: &DiodeCircuit) -> Self {
        Self {
            driven: Some(Box::new(circuit.clone())),
            ..Self::from_sensor(sensor, circuit.linear().clone())
        }
    }

    /// Stops when no apparent conductance misfits by more than `tolerance` times the largest (1e-9 otherwise).
    pub fn with_tolerance(mut self, tolerance: f64) -> Self {
        self.tolerance = tolerance;
        self
    }

    /// Gives up after so many rounds, or restarts of the linear solver within one: a frame that has no answer takes
    /// all of them, hundreds of times as long as one that has.
    pub(crate) fn with_limits(mut self, iterations: u32, restarts: usize) -> Self {
        (self.iterations, self.restarts) = (iterations, restarts);
        self
    }
}

impl Method for Newton {
    fn name(&self) -> &'static str {
        "newton"
    }

    fn solver(&self) -> Box<dyn Solver> {
        Box::new(NewtonSolver {
            method: self.clone(),
            state: SolverState::new(),
        })
    }
}

struct NewtonSolver {
    method: Newton,
    state: SolverState,
}

impl Solver for NewtonSolver {
    fn solve_into(&mut self, volts: &Frame<Volts>, siemens: &mut Frame<Siemens>) -> Outcome {
        self.method
            .solve_from(volts, siemens, &mut self.state, None)
    }

    fn forget(&mut self) {
        self.state.forget();
    }

    fn set_rounded(&mut self, is_rounded: bool) {
        self.state.is_rounded = is_rounded;
    }
}

impl Newton {
    /// [`Solver::solve_into`] from conductances that the answer is believed to be near, one a taxel, in place of the
    /// frame before. Only where they lead nowhere is it solved as if nothing were known.
    ///
    /// # Panics
    /// As [`Solver::solve_into`], and when there is not one conductance a taxel.
    pub(crate) fn solve_from(
        &self,
        volts: &Frame<Volts>,
        siemens: &mut Frame<Siemens>,
        state: &mut SolverState,
        near: Option<&[f64]>,
    ) -> Outcome {
        let ends = self.circuit.ends();
        let columns = ends.column_selected.len();
        assert_eq!(
            (volts.rows(), volts.columns()),
            (ends.row_selected.len(), columns),
            "the frame has the sensor's shape"
        );
        siemens.copy_meta_from(volts);
        if let Some(circuit) = &self.driven {
            let behind = state.behind.take();
            let mut behind = behind.unwrap_or_else(|| Box::new(Behind::new(circuit, volts)));
            let outcome = self.solve_behind(&mut behind, volts, siemens, (state, near));
            state.behind = Some(behind);
            return outcome;
        }
        self.solve_linear(volts, siemens, state, near)
    }

    /// The same of readings without diodes.
    fn solve_linear(
        &self,
        volts: &Frame<Volts>,
        siemens: &mut Frame<Siemens>,
        state: &mut SolverState,
        near: Option<&[f64]>,
    ) -> Outcome {
        let columns = volts.columns();
        if self.circuit.lines().is_some() {
            return self.solve_resistive(volts, siemens, state, near);
        }
        if state.live.update(volts) {
            state.reshape(&self.circuit);
        }
        if state.g.is_empty() {
            siemens.values_mut().fill(0.0);
            return Outcome::new(Stop::Direct, 0, 0.0);
        }
        state.take_marks(
            volts.marks(),
            columns,
            (self.unloaded_siemens, self.holds_lost),
        );
        if let Some(near) = near {
            state.live.gather(near, columns, &mut state.g);
            state.warm = true;
        }
        state.take_volts(volts.values(), columns);
        let mut outcome = self.iterate(state);
        // From one of several answers the next frame would converge to the same, and nobody would look for another.
        state.warm = outcome.is_answer();
        state.live.scatter(&state.g, columns, siemens.values_mut());
        if self.holds_lost && outcome.is_answer() && state.rest_as_around() {
            state.take_volts(volts.values(), columns);
            let again = self.iterate(state);
            state.warm = again.is_answer();
            if again.is_answer() {
                state.live.scatter(&state.g, columns, siemens.values_mut());
                outcome = again;
            }
        }
        outcome
    }

    fn solve_resistive(
        &self,
        volts: &Frame<Volts>,
        siemens: &mut Frame<Siemens>,
        state: &mut SolverState,
        near: Option<&[f64]>,
    ) -> Outcome {
        if state.resistive.is_none() {
            state.resistive = Resistive::new(&self.circuit).map(Box::new);
        }
        let rounding_volts = if state.is_rounded {
            self.rounding_volts
        } else {
            0.0
        };
        let accuracy = Accuracy {
            tolerance: self.tolerance,
            sigma_volts: self.noise_volts.hypot(rounding_volts),
            // A fit tries many circuits that explain nothing.
            is_patient: self.restarts >= RESTARTS,
        };
        match &mut state.resistive {
            Some(resistive) => {
                resistive.solve(volts, siemens, (self.unloaded_siemens, accuracy), near)
            }
            None => Outcome::new(Stop::Stalled, 0, f64::INFINITY),
        }
    }

    fn iterate(&self, state: &mut SolverState) -> Outcome {
        if let Some(path) = &state.path
            && let Some(infeasible) = path.infeasible(
                &state.measured,
                &state.live,
                self.circuit.ends().are_shares(),
            )
        {
            state.start_at_rest();
            return Outcome::new(Stop::Infeasible(infeasible), 0, f64::INFINITY);
        }
        if let Some(path) = &state.path {
            path.apparent(&mut state.measured, &mut state.slope);
        }
        state.clip_idle_lines();
        let scale = largest(&state.measured);
        if scale == 0.0 {
            state.start_at_rest();
            return Outcome::new(Stop::Converged, 0, 0.0);
        }
        if state.warm {
            state.hold_at_rest();
            state.trial.copy_from_slice(&state.g);
            let size = state.evaluate();
            // Where there is one answer, the frame before may be farther from it than the readings are.
            let is_near = |size: &f64| !self.unique() || state.relative(*size, scale) < NEAR;
            if let Some(size) = size.filter(is_near) {
                let outcome = self.descend(state, size, scale, self.iterations);
                if outcome.stop.is_good() {
                    return outcome;
                }
            }
        }
        self.cold(state, scale)
    }

    /// Solves without a previous frame, and looks for a second answer.
    fn cold(&self, state: &mut SolverState, scale: f64) -> Outcome {
        let (crossings, nearest) = state.factors(Shape::Measured);
        let first = crossings[0].unwrap_or(nearest);
        let Some(mut best) =
            self.descend_from(state, Shape::Measured, first, scale, self.iterations)
        else {
            return Outcome::new(Stop::Stalled, 0, f64::INFINITY);
        };
        state.kept.copy_from_slice(&state.g);
        if best.stop.is_good() {
            if !self.unique() {
                self.look_for_another(state, &mut best, scale);
            }
        } else if let Some(second) = crossings[1]
            && let Some(outcome) =
                self.descend_from(state, Shape::Measured, second, scale, self.iterations)
            && outcome.stop.is_good()
        {
            state.kept.copy_from_slice(&state.g);
            best = outcome;
        }
        if !best.stop.is_good() {
            best = self.begin_elsewhere(state, best, scale);
            if best.stop.is_good() && !self.unique() {
                self.look_for_another(state, &mut best, scale);
            }
        }
        state.g.copy_from_slice(&state.kept);
        best
    }

    /// Newton's iteration from other starts, when the likely ones led nowhere; what is best is in `kept`.
    fn begin_elsewhere(&self, state: &mut SolverState, failed: Outcome, scale: f64) -> Outcome {
        let iterations = self.iterations.min(MAX_OTHER_ITERATIONS);
        for factor in OTHER_STARTS {
            let found = self.descend_from(state, Shape::Measured, factor, scale, iterations);
            if let Some(outcome) = found.filter(|outcome| outcome.stop.is_good()) {
                state.kept.copy_from_slice(&state.g);
                return outcome;
            }
        }
        failed
    }

    /// Whether a frame has one answer at most ([theory.md]): unselected rows open, and no source resistor between the
    /// driven column and what the unselected ones hang on; or all unselected lines open, where no sheet ties neighbours
    /// together.
    ///
    /// [theory.md]: https://github.com/taxel/taxel/blob/main/docs/theory.md
    fn unique(&self) -> bool {
        let ends = self.circuit.ends();
        ends.are_shares() || (ends.is_floating() && self.circuit.sheet().is_none())
    }

    /// Tries other multiples of the answer in `kept` that explain the sum of the readings. The likelier
    /// answer ends up in `kept`; with a second one, or a start that leads nowhere, the first is ambiguous.
    fn look_for_another(&self, state: &mut SolverState, best: &mut Outcome, scale: f64) {
        let mut likelihood = state.unlikeliness();
        for factor in state.factors(Shape::Answer).0.into_iter().flatten() {
            if factor.ln().abs() < SAME_FACTOR {
                continue;
            }
            let Some(outcome) =
                self.descend_from(state, Shape::Answer, factor, scale, self.iterations)
            else {
                continue;
            };
            let apart = state.g.iter().zip(&state.kept);
            let apart = apart.fold(0f64, |most, (a, b)| most.max((a - b).abs()));
            if outcome.stop.is_good() && apart <= 1e-3 * largest(&state.g) {
                continue;
            }
            best.ambiguous = true;
            let unlikely = state.unlikeliness();
            if outcome.stop.is_good() && unlikely < likelihood {
                likelihood = unlikely;
                state.kept.copy_from_slice(&state.g);
                *best = Outcome {
                    ambiguous: true,
                    ..outcome
                };
            }
        }
    }

    /// Newton's iteration from a multiple of a shape; none when the network is not passive there.
    fn descend_from(
        &self,
        state: &mut SolverState,
        shape: Shape,
        factor: f64,
        scale: f64,
        iterations: u32,
    ) -> Option<Outcome> {
        state.start_at(shape, factor);
        let size = state.evaluate()?;
        state.g.copy_from_slice(&state.trial);
        Some(self.descend(state, size, scale, iterations))
    }

    /// So many rounds of Newton's iteration, at most, from `state.g`, whose misfit is known.
    fn descend(
        &self,
        state: &mut SolverState,
        mut size: f64,
        scale: f64,
        iterations: u32,
    ) -> Outcome {
        let mut short = 0;
        for round in 1..=iterations {
            let residual = largest(&state.misfit) / scale;
            if residual <= self.tolerance {
                return Outcome::new(Stop::Converged, round - 1, residual);
            }
            let stepped = self.step(state, size, scale).filter(|(_, length)| {
                short = if *length < SHORT { short + 1 } else { 0 };
                short < SHORT_STEPS
            });
            let Some((smaller, _)) = stepped else {
                // Put the network back to the best point, so that the misfit is that of the answer.
                state.trial.copy_from_slice(&state.g);
                state.evaluate();
                return Outcome::new(Stop::Stalled, round, largest(&state.misfit) / scale);
            };
            size = smaller;
        }
        Outcome::new(
            Stop::IterationLimit,
            self.iterations,
            largest(&state.misfit) / scale,
        )
    }

    /// One damped step; the norm of the misfit after it, if it fell, and the share of Newton's step taken.
    fn step(&self, state: &mut SolverState, size: f64, scale: f64) -> Option<(f64, f64)> {
        let relative = state.relative(size, scale);
        // The step itself is no better than this share of the misfit; and more than the answer is to have is not asked of it.
        let enough = 0.01 * self.tolerance * scale / largest(&state.misfit);
        let tolerance = (0.1 * relative).max(enough).clamp(1e-10, 1e-2);
        {
            let (point, slope) = (state.point.as_mut()?, &state.slope);
            // What is held moves nothing and asks for nothing, so that the step leaves it where it is.
            let held = &state.held;
            let (shared, undone) = (&mut state.shared_lines, &mut state.undone);
            if let Some(shared) = shared {
                shared.set(&state.g, &state.found, held);
            }
            let apply = |v: &[f64], out: &mut [f64]| {
                match shared {
                    Some(shared) => {
                        shared.apply(v, undone);
                        point.jvp_into(undone, out);
                    }
                    None => point.jvp_into(v, out),
                }
                for ((out, slope), held) in out.iter_mut().zip(slope).zip(held) {
                    *out = if *held { 0.0 } else { *out * slope };
                }
            };
            let (misfit, step) = (&state.misfit, &mut state.step);
            state
                .gmres
                .solve(apply, misfit, step, tolerance, self.restarts);
        }
        if let Some(shared) = &mut state.shared_lines {
            shared.apply_in_place(&mut state.step);
        }
        let mut length = 1.0;
        for _ in 0..30 {
            for ((trial, g), step) in state.trial.iter_mut().zip(&state.g).zip(&state.step) {
                *trial = g + length * step;
            }
            state.hold_lines();
            if let Some(now) = state.evaluate()
                && now < size * (1.0 - 1e-4 * length)
            {
                state.g.copy_from_slice(&state.trial);
                return Some((now, length));
            }
            length *= 0.5;
        }
        None
    }
}
