//! What Newton's method keeps between rounds and frames, and the misfit of its trial.

use super::super::gmres::{Gmres, largest, norm};
use super::super::lines::LiveLines;
use super::super::path::OwnPath;
use super::super::resistive::Resistive;
use super::shared_lines::SharedLines;
use crate::Mark;
use crate::circuit::{LinearCircuit, LinearPoint, OperatingPoint};

const DEPTH: usize = 60;
/// Keeps the factor 1, at which an answer explains itself, away from the grid of factors tried.
const GRID_OFFSET: f64 = 0.7;
/// A line whose apparent conductances sum to less than this share of their absolute sum is idle.
const IDLE_LINE: f64 = 0.1;

/// What a cold solve starts from a multiple of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Shape {
    /// The measured apparent conductances.
    Measured,
    /// The first answer, in `kept`.
    Answer,
}

/// Factors at which the sum of the readings is the measured one.
pub(super) type Crossings = [Option<f64>; 2];

pub(crate) struct SolverState {
    pub(super) live: LiveLines,
    pub(super) warm: bool,
    pub(super) point: Option<LinearPoint>,
    pub(super) path: Option<OwnPath>,
    pub(super) measured: Vec<f64>,
    pub(super) slope: Vec<f64>,
    pub(super) found: Vec<f64>,
    pub(super) misfit: Vec<f64>,
    pub(super) g: Vec<f64>,
    pub(super) kept: Vec<f64>,
    pub(super) trial: Vec<f64>,
    pub(super) step: Vec<f64>,
    pub(super) gmres: Gmres,
    /// What makes it short, where lines are left open, and what that undoes of a direction.
    pub(super) shared_lines: Option<SharedLines>,
    pub(super) undone: Vec<f64>,
    /// Taxels that are no unknowns: absent, or taken to be unloaded.
    pub(super) held: Vec<bool>,
    /// What those conduct, siemens.
    pub(super) rest: Vec<f64>,
    pub(super) marks: Vec<Mark>,
    /// Whether a converter has rounded the readings.
    pub(super) is_rounded: bool,
    /// In place of all else, where lines resist.
    pub(super) resistive: Option<Box<Resistive>>,
    /// Readings behind driven lines' diodes.
    pub(super) behind: Option<Box<super::behind::Behind>>,
}

impl SolverState {
    pub(crate) fn new() -> Self {
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
            shared_lines: None,
            undone: Vec::new(),
            held: Vec::new(),
            rest: Vec::new(),
            marks: Vec::new(),
            is_rounded: true,
            resistive: None,
            behind: None,
        }
    }

    /// Makes the next solve start cold.
    pub(crate) fn forget(&mut self) {
        self.warm = false;
        if let Some(behind) = &mut self.behind {
            behind.forget();
        }
        if let Some(resistive) = &mut self.resistive {
            resistive.forget();
        }
    }

    pub(super) fn reshape(&mut self, all: &LinearCircuit) {
        let circuit = self.live.circuit(all);
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
            &mut self.rest,
            &mut self.undone,
        ] {
            buffer.clear();
            buffer.resize(taxels, 0.0);
        }
        self.held.clear();
        self.held.resize(taxels, false);
        self.marks.clear();
        self.marks.resize(taxels, Mark::Good);
        self.gmres = Gmres::new(taxels, DEPTH.min(taxels));
        let (rows, columns) = (self.live.rows.len(), self.live.columns.len());
        let is_open = circuit.ends().is_floating();
        self.shared_lines = is_open.then(|| SharedLines::new(rows, columns));
        self.path = Some(OwnPath::new(circuit.ends()));
        self.point = Some(circuit.point());
        self.warm = false;
    }

    /// A line whose readings are noise about zero would be a negative conductance to the rest of the network,
    /// which then has no solution: its negative readings count as zero.
    pub(super) fn clip_idle_lines(&mut self) {
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
    pub(super) fn hold_lines(&mut self) {
        for line in self.live.lines() {
            let (before, after) = line.clone().fold((0.0, 0.0), |(before, after), at| {
                (before + self.g[at], after + self.trial[at])
            });
            if after < 0.1 * before {
                for at in line.filter(|&at| !self.held[at]) {
                    self.trial[at] = 0.1 * self.g[at];
                }
            }
        }
    }

    /// Solves the network at `trial`; the misfit of the apparent conductances is left in `misfit`, their
    /// values in `found`, dy/dV in `slope`. The norm of the misfit, if the network is passive.
    pub(super) fn evaluate(&mut self) -> Option<f64> {
        let (point, path) = (self.point.as_mut()?, self.path.as_ref()?);
        point.set(&self.trial).ok()?;
        point.predict_into(&mut self.found);
        path.apparent(&mut self.found, &mut self.slope);
        let readings = self.found.iter().zip(&self.measured).zip(&self.held);
        for (misfit, ((found, measured), held)) in self.misfit.iter_mut().zip(readings) {
            *misfit = if *held { 0.0 } else { measured - found };
        }
        let size = norm(&self.misfit);
        size.is_finite().then_some(size)
    }

    /// Factors of `shape` whose readings sum to the measured sum, and the one that comes nearest. A source
    /// resistor or a large row resistance makes the sum fall again as conductances grow, so there can be
    /// two such factors, and two answers.
    pub(super) fn factors(&mut self, shape: Shape) -> (Crossings, f64) {
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
                .map(|_| (self.sum_of_found() / wanted).ln())
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

    /// A norm as a share of so much on every taxel.
    pub(super) fn relative(&self, size: f64, scale: f64) -> f64 {
        size / (scale * (self.g.len() as f64).sqrt())
    }

    /// Of the taxels that are unknown.
    fn sum_of_found(&self) -> f64 {
        let found = self.found.iter().zip(&self.held);
        found
            .map(|(found, held)| if *held { 0.0 } else { *found })
            .sum()
    }

    /// Sets `trial` to a multiple of the measured apparent conductances or of the first answer.
    pub(super) fn start_at(&mut self, shape: Shape, factor: f64) {
        let from = match shape {
            Shape::Measured => &self.measured,
            Shape::Answer => &self.kept,
        };
        let floor = 1e-9 * largest(from);
        let known = self.held.iter().zip(&self.rest);
        for ((trial, value), (held, rest)) in self.trial.iter_mut().zip(from).zip(known) {
            *trial = if *held {
                *rest
            } else {
                factor * value.max(floor)
            };
        }
    }

    /// How unlikely the conductances in `g` are.
    pub(super) fn unlikeliness(&mut self) -> (bool, f64) {
        let unknown = self.g.iter().zip(&self.held).filter(|(_, held)| !**held);
        super::super::unlikeliness(unknown.map(|(g, _)| *g), &mut self.step)
    }
}
