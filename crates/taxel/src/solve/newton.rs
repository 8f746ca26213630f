//! Every linear topology: Newton's method, matrix-free, on the taxels' apparent conductances.
//!
//! The reading of a taxel is first freed of its own series path, y = I/(V_t − I·(R_c + R_v + R_end)): what
//! the taxel would be if it were alone. Then y ≈ G with a diagonal derivative near one, and what GMRES has
//! left to undo is the cross-talk.

use super::gmres::{Gmres, norm};
use super::lines::LiveLines;
use super::path::OwnPath;
use super::{Method, Outcome, Scratch, Stop};
use crate::circuit::{LineEnds, LinearCircuit, LinearPoint, OperatingPoint};
use crate::sensor::Topology;
use crate::{Frame, Siemens, Volts};

/// Newton's method for any linear circuit.
#[derive(Debug, Clone, PartialEq)]
pub struct Newton {
    circuit: LinearCircuit,
    tolerance: f64,
    rounds: u32,
    restarts: usize,
}

const ROUNDS: u32 = 60;
const DEPTH: usize = 60;
const RESTARTS: usize = 6;
/// Keeps the factor 1, at which an answer explains itself, away from the grid of factors tried.
const GRID_OFFSET: f64 = 0.7;
/// Factors of an answer nearer to 1 than this (in the logarithm) are the answer itself.
const SAME_FACTOR: f64 = 0.02;

/// So many steps in a row shorter than this share of Newton's lead nowhere: the derivative is all but singular there.
const SHORT: f64 = 1e-3;
const SHORT_STEPS: u32 = 3;
/// Other multiples of the measured shape to begin from, where the likely ones lead nowhere.
const OTHER_STARTS: [f64; 6] = [1.0, 0.5, 2.0, 0.2, 5.0, 20.0];

/// A line whose apparent conductances sum to less than this share of their absolute sum is idle.
const IDLE_LINE: f64 = 0.1;

/// What a cold solve starts from a multiple of.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Shape {
    /// The measured apparent conductances.
    Measured,
    /// The first answer, in `kept`.
    Answer,
}

/// Factors at which the sum of the readings is the measured one.
type Crossings = [Option<f64>; 2];

impl Newton {
    /// The method for a circuit.
    pub fn new(circuit: LinearCircuit) -> Self {
        Self {
            circuit,
            tolerance: 1e-9,
            rounds: ROUNDS,
            restarts: RESTARTS,
        }
    }

    /// Stops when no apparent conductance misfits by more than `tolerance` times the largest (1e-9 otherwise).
    pub fn with_tolerance(mut self, tolerance: f64) -> Self {
        self.tolerance = tolerance;
        self
    }

    /// Gives up after so many rounds, or restarts of the linear solver within one: a frame that has no answer takes
    /// all of them, hundreds of times as long as one that has.
    pub(crate) fn with_limits(mut self, rounds: u32, restarts: usize) -> Self {
        (self.rounds, self.restarts) = (rounds, restarts);
        self
    }
}

struct Memory {
    live: LiveLines,
    warm: bool,
    point: Option<LinearPoint>,
    path: Option<OwnPath>,
    measured: Vec<f64>,
    slope: Vec<f64>,
    found: Vec<f64>,
    misfit: Vec<f64>,
    g: Vec<f64>,
    kept: Vec<f64>,
    trial: Vec<f64>,
    step: Vec<f64>,
    gmres: Gmres,
}

impl Memory {
    fn new() -> Self {
        Self {
            live: LiveLines::default(),
            warm: false,
            point: None,
            path: None,
            measured: Vec::new(),
            slope: Vec::new(),
            found: Vec::new(),
            misfit: Vec::new(),
            g: Vec::new(),
            kept: Vec::new(),
            trial: Vec::new(),
            step: Vec::new(),
            gmres: Gmres::new(0, 0),
        }
    }

    fn reshape(&mut self, all: &LineEnds) {
        let ends = self.live.ends(all);
        let taxels = self.live.rows.len() * self.live.columns.len();
        for buffer in [
            &mut self.measured,
            &mut self.slope,
            &mut self.found,
            &mut self.misfit,
            &mut self.g,
            &mut self.kept,
            &mut self.trial,
            &mut self.step,
        ] {
            buffer.clear();
            buffer.resize(taxels, 0.0);
        }
        self.gmres = Gmres::new(taxels, DEPTH.min(taxels));
        self.path = Some(OwnPath::new(&ends));
        self.point = Some(LinearCircuit::new(ends).point());
        self.warm = false;
    }

    /// A line whose readings are noise about zero would be a negative conductance to the rest of the network,
    /// which then has no solution: its negative readings count as zero.
    fn clip_idle_lines(&mut self) {
        for line in self.live.lines() {
            let (sum, size) = line.clone().fold((0.0, 0.0), |(sum, size), at| {
                let y = self.measured[at];
                (sum + y, size + y.abs())
            });
            if sum < IDLE_LINE * size {
                for at in line {
                    self.measured[at] = self.measured[at].max(0.0);
                }
            }
        }
    }

    /// Keeps the conductance of every line from g to `trial` above a tenth of what it was. A line that hardly
    /// conducts gets steps which are all rounding beside the other lines' and would make the network active.
    fn hold_lines(&mut self) {
        for line in self.live.lines() {
            let (before, after) = line.clone().fold((0.0, 0.0), |(before, after), at| {
                (before + self.g[at], after + self.trial[at])
            });
            if after < 0.1 * before {
                for at in line {
                    self.trial[at] = 0.1 * self.g[at];
                }
            }
        }
    }

    /// Solves the network at `trial`; the misfit of the apparent conductances is left in `misfit`, their
    /// values in `found`, dy/dV in `slope`. The norm of the misfit, if the network is passive.
    fn evaluate(&mut self) -> Option<f64> {
        let (point, path) = (self.point.as_mut()?, self.path.as_ref()?);
        point.set(&self.trial).ok()?;
        point.predict_into(&mut self.found);
        path.apparent(&mut self.found, &mut self.slope);
        for ((misfit, found), measured) in
            self.misfit.iter_mut().zip(&self.found).zip(&self.measured)
        {
            *misfit = measured - found;
        }
        let size = norm(&self.misfit);
        size.is_finite().then_some(size)
    }

    /// Factors of `shape` whose readings sum to the measured sum, and the one that comes nearest. A source
    /// resistor or a large row resistance makes the sum fall again as conductances grow, so there can be
    /// two such factors, and two answers.
    fn factors(&mut self, shape: Shape) -> (Crossings, f64) {
        let wanted: f64 = self.measured.iter().sum();
        let (mut crossings, mut found) = ([None; 2], 0);
        let mut nearest = (f64::INFINITY, 1.0);
        let mut before: Option<(f64, f64)> = None;
        let (base, powers) = match shape {
            Shape::Measured => (4f64, -2..=6),
            Shape::Answer => (2f64, -5..=9),
        };
        for power in powers {
            let factor = base.powi(power) * GRID_OFFSET;
            self.start_at(shape, factor);
            let Some(excess) = self
                .evaluate()
                .map(|_| (self.found.iter().sum::<f64>() / wanted).ln())
                .filter(|excess| excess.is_finite())
            else {
                continue;
            };
            if excess.abs() < nearest.0 {
                nearest = (excess.abs(), factor);
            }
            if let Some((last, at)) = before
                && last.signum() != excess.signum()
                && found < 2
            {
                let part = last / (last - excess);
                crossings[found] = Some(at * (factor / at).powf(part));
                found += 1;
            }
            before = Some((excess, factor));
        }
        (crossings, nearest.1)
    }

    /// Sets `trial` to a multiple of the measured apparent conductances or of the first answer.
    fn start_at(&mut self, shape: Shape, factor: f64) {
        let from = match shape {
            Shape::Measured => &self.measured,
            Shape::Answer => &self.kept,
        };
        let floor = 1e-9 * largest(from);
        for (trial, value) in self.trial.iter_mut().zip(from) {
            *trial = factor * value.max(floor);
        }
    }

    /// How unlikely the conductances in `g` are: whether some are clearly negative, then the median
    /// distance of ln |G| from its median, which is small when the unpressed taxels look alike.
    fn unlikeliness(&mut self) -> (bool, f64) {
        let least = self.g.iter().fold(0f64, |least, g| least.min(*g));
        let middle = self.g.len() / 2;
        for (out, g) in self.step.iter_mut().zip(&self.g) {
            *out = g.abs().max(1e-15).ln();
        }
        let median = *self.step.select_nth_unstable_by(middle, f64::total_cmp).1;
        for value in &mut self.step {
            *value = (*value - median).abs();
        }
        let scatter = *self.step.select_nth_unstable_by(middle, f64::total_cmp).1;
        (-least > 1e-3 * largest(&self.g), scatter)
    }
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |most, v| most.max(v.abs()))
}

impl Method for Newton {
    fn name(&self) -> &'static str {
        "newton"
    }

    fn scratch(&self) -> Scratch {
        Scratch::new(Memory::new())
    }

    fn solve_into(
        &self,
        volts: &Frame<Volts>,
        siemens: &mut Frame<Siemens>,
        scratch: &mut Scratch,
    ) -> Outcome {
        self.solve_from(volts, siemens, scratch, None)
    }
}

impl Newton {
    /// [`Method::solve_into`] from conductances that the answer is believed to be near, one a taxel, in place of the
    /// frame before. Only where they lead nowhere is it solved as if nothing were known.
    ///
    /// # Panics
    /// As [`Method::solve_into`], and when there is not one conductance a taxel.
    pub(crate) fn solve_near(
        &self,
        volts: &Frame<Volts>,
        near: &[f64],
        siemens: &mut Frame<Siemens>,
        scratch: &mut Scratch,
    ) -> Outcome {
        self.solve_from(volts, siemens, scratch, Some(near))
    }

    fn solve_from(
        &self,
        volts: &Frame<Volts>,
        siemens: &mut Frame<Siemens>,
        scratch: &mut Scratch,
        near: Option<&[f64]>,
    ) -> Outcome {
        let ends = self.circuit.ends();
        let columns = ends.column_selected.len();
        assert_eq!(
            (volts.rows(), volts.columns()),
            (ends.row_selected.len(), columns),
            "the frame has the sensor's shape"
        );
        let cold = scratch.take_cold();
        let memory: &mut Memory = scratch.get();
        memory.warm &= !cold;
        siemens.take_marks(volts);
        if memory.live.update(volts) {
            memory.reshape(ends);
        }
        if memory.g.is_empty() {
            siemens.values_mut().fill(0.0);
            return Outcome::new(Stop::Direct, 0, 0.0);
        }
        memory
            .live
            .gather(volts.values(), columns, &mut memory.measured);
        if let Some(near) = near {
            memory.live.gather(near, columns, &mut memory.g);
            memory.warm = true;
        }
        let outcome = self.iterate(memory);
        memory.warm = outcome.stop.is_good();
        memory
            .live
            .scatter(&memory.g, columns, siemens.values_mut());
        outcome
    }

    fn iterate(&self, memory: &mut Memory) -> Outcome {
        if let Some(path) = &memory.path
            && let Some(infeasible) = path.infeasible(&memory.measured, &memory.live, self.unique())
        {
            memory.g.fill(0.0);
            return Outcome::new(Stop::Infeasible(infeasible), 0, f64::INFINITY);
        }
        if let Some(path) = &memory.path {
            path.apparent(&mut memory.measured, &mut memory.slope);
        }
        memory.clip_idle_lines();
        let scale = largest(&memory.measured);
        if scale == 0.0 {
            memory.g.fill(0.0);
            return Outcome::new(Stop::Converged, 0, 0.0);
        }
        if memory.warm {
            memory.trial.copy_from_slice(&memory.g);
            if let Some(size) = memory.evaluate() {
                let outcome = self.descend(memory, size, scale);
                if outcome.stop.is_good() {
                    return outcome;
                }
            }
        }
        self.cold(memory, scale)
    }

    /// Solves without a previous frame, and looks for a second answer.
    fn cold(&self, memory: &mut Memory, scale: f64) -> Outcome {
        let (crossings, nearest) = memory.factors(Shape::Measured);
        let first = crossings[0].unwrap_or(nearest);
        let Some(mut best) = self.descend_from(memory, Shape::Measured, first, scale) else {
            return Outcome::new(Stop::Stalled, 0, f64::INFINITY);
        };
        memory.kept.copy_from_slice(&memory.g);
        if best.stop.is_good() {
            if !self.unique() {
                self.look_for_another(memory, &mut best, scale);
            }
        } else if let Some(second) = crossings[1]
            && let Some(outcome) = self.descend_from(memory, Shape::Measured, second, scale)
            && outcome.stop.is_good()
        {
            memory.kept.copy_from_slice(&memory.g);
            best = outcome;
        }
        if !best.stop.is_good() {
            best = self.begin_elsewhere(memory, best, scale);
            if best.stop.is_good() && !self.unique() {
                self.look_for_another(memory, &mut best, scale);
            }
        }
        memory.g.copy_from_slice(&memory.kept);
        best
    }

    /// Newton's iteration from other starts, when the likely ones led nowhere; what is best is in `kept`.
    fn begin_elsewhere(&self, memory: &mut Memory, failed: Outcome, scale: f64) -> Outcome {
        for factor in OTHER_STARTS {
            let found = self.descend_from(memory, Shape::Measured, factor, scale);
            if let Some(outcome) = found.filter(|outcome| outcome.stop.is_good()) {
                memory.kept.copy_from_slice(&memory.g);
                return outcome;
            }
        }
        failed
    }

    /// Whether a frame has one answer at most: unselected rows open, and no source resistor between the
    /// driven column and what the unselected ones hang on (docs/theory.md).
    fn unique(&self) -> bool {
        let ends = self.circuit.ends();
        matches!(
            ends.topology,
            Topology::TiaGroundedColumns | Topology::DividerGroundedColumns
        ) && ends.column_selected == ends.column_unselected
    }

    /// Tries other multiples of the answer in `kept` that explain the sum of the readings. The likelier
    /// answer ends up in `kept`; with a second one, or a start that leads nowhere, the first is ambiguous.
    fn look_for_another(&self, memory: &mut Memory, best: &mut Outcome, scale: f64) {
        let mut likelihood = memory.unlikeliness();
        for factor in memory.factors(Shape::Answer).0.into_iter().flatten() {
            if factor.ln().abs() < SAME_FACTOR {
                continue;
            }
            let Some(outcome) = self.descend_from(memory, Shape::Answer, factor, scale) else {
                continue;
            };
            let apart = memory.g.iter().zip(&memory.kept);
            let apart = apart.fold(0f64, |most, (a, b)| most.max((a - b).abs()));
            if outcome.stop.is_good() && apart <= 1e-3 * largest(&memory.g) {
                continue;
            }
            best.ambiguous = true;
            let unlikely = memory.unlikeliness();
            if outcome.stop.is_good() && unlikely < likelihood {
                likelihood = unlikely;
                memory.kept.copy_from_slice(&memory.g);
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
        memory: &mut Memory,
        shape: Shape,
        factor: f64,
        scale: f64,
    ) -> Option<Outcome> {
        memory.start_at(shape, factor);
        let size = memory.evaluate()?;
        memory.g.copy_from_slice(&memory.trial);
        Some(self.descend(memory, size, scale))
    }

    /// Newton's iteration from `memory.g`, whose misfit is known.
    fn descend(&self, memory: &mut Memory, mut size: f64, scale: f64) -> Outcome {
        let mut short = 0;
        for round in 1..=self.rounds {
            let residual = largest(&memory.misfit) / scale;
            if residual <= self.tolerance {
                return Outcome::new(Stop::Converged, round - 1, residual);
            }
            let stepped = self.step(memory, size, scale).filter(|(_, length)| {
                short = if *length < SHORT { short + 1 } else { 0 };
                short < SHORT_STEPS
            });
            let Some((smaller, _)) = stepped else {
                // Put the network back to the best point, so that the misfit is that of the answer.
                memory.trial.copy_from_slice(&memory.g);
                memory.evaluate();
                return Outcome::new(Stop::Stalled, round, largest(&memory.misfit) / scale);
            };
            size = smaller;
        }
        Outcome::new(
            Stop::RoundLimit,
            self.rounds,
            largest(&memory.misfit) / scale,
        )
    }

    /// One damped step; the norm of the misfit after it, if it fell, and the share of Newton's step taken.
    fn step(&self, memory: &mut Memory, size: f64, scale: f64) -> Option<(f64, f64)> {
        let relative = size / (scale * (memory.g.len() as f64).sqrt());
        let tolerance = (0.1 * relative).clamp(1e-10, 1e-2);
        {
            let (point, slope) = (memory.point.as_mut()?, &memory.slope);
            let apply = |v: &[f64], out: &mut [f64]| {
                point.derivative_into(v, out);
                for (out, slope) in out.iter_mut().zip(slope) {
                    *out *= slope;
                }
            };
            let (misfit, step) = (&memory.misfit, &mut memory.step);
            memory
                .gmres
                .solve(apply, misfit, step, tolerance, self.restarts);
        }
        let mut length = 1.0;
        for _ in 0..30 {
            for ((trial, g), step) in memory.trial.iter_mut().zip(&memory.g).zip(&memory.step) {
                *trial = g + length * step;
            }
            memory.hold_lines();
            if let Some(now) = memory.evaluate()
                && now < size * (1.0 - 1e-4 * length)
            {
                memory.g.copy_from_slice(&memory.trial);
                return Some((now, length));
            }
            length *= 0.5;
        }
        None
    }
}
