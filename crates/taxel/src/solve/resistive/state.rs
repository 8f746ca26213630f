//! What the inverse of lines that resist keeps between rounds and frames.

use super::super::anderson::Anderson;
use super::super::gmres::{Gmres, largest};
use super::super::lines::LiveLines;
use super::super::path::OwnPath;
use super::least_squares::LeastSquares;
use super::preconditioner::Preconditioner;
use crate::circuit::{Circuit, LinearCircuit, LinearPoint, OperatingPoint};
use crate::{Frame, Mark, Volts};

const DEPTH: usize = 30;
const MIXED: usize = 5;
/// No taxel's own derivative is taken for less: readings of corners that hardly anything reaches.
const MIN_OWN: f64 = 1e-7;
/// The largest conductance that is expected, siemens: half of the prior's width.
const EXPECTED_SIEMENS: f64 = 2e-3;
/// Of a reading's noise, the part that a step may still be off by; and of the largest conductance.
const OF_NOISE: f64 = 0.1;

/// One value a taxel, row by row, where nothing else is said.
pub(super) struct State {
    point: LinearPoint,
    path: OwnPath,
    pub(super) live: LiveLines,
    /// The largest reading of an unknown, volts.
    pub(super) largest_volts: f64,
    /// Apparent conductances as measured, and dy/dV there.
    pub(super) measured: Vec<f64>,
    /// Those of the trial.
    pub(super) found: Vec<f64>,
    pub(super) slope: Vec<f64>,
    /// dy/dV at what was measured.
    pub(super) measured_slope: Vec<f64>,
    /// D: dy/dG of the own conductance.
    own: Vec<f64>,
    /// |σ dy/dV / D|: what noise makes of an apparent conductance as one of the taxel, siemens.
    pub(super) noise: Vec<f64>,
    /// What it is of the conductances that are kept.
    pub(super) kept_noise: Vec<f64>,
    /// What it is taken to be at least: where a taxel was left unresolved with more noise than there is.
    pub(super) least_noise: Vec<f64>,
    /// μ.
    shift: Vec<f64>,
    /// dy/dV / D.
    weight: Vec<f64>,
    pub(super) g: Vec<f64>,
    pub(super) kept: Vec<f64>,
    pub(super) trial: Vec<f64>,
    /// (y measured − y)/D − μ G.
    pub(super) misfit: Vec<f64>,
    pub(super) step: Vec<f64>,
    work: Vec<f64>,
    gmres: Gmres,
    pub(super) mixing: Anderson,
    preconditioner: Preconditioner,
    /// Of frames that nothing else leads to; none before the first.
    pub(super) least_squares: Option<Box<LeastSquares>>,
    /// 1 where a taxel is no unknown, else 0; and what it conducts then.
    pub(super) held: Vec<f64>,
    rest: Vec<f64>,
    /// The preconditioner, `own`, `shift` and `noise` are of a frame not long ago.
    pub(super) is_fresh: bool,
    pub(super) is_warm: bool,
    pub(super) floating: bool,
    pub(super) shares: bool,
}

impl State {
    /// For a circuit whose lines resist; none for another.
    pub(super) fn new(circuit: &LinearCircuit) -> Option<Self> {
        let taxels = circuit.rows() * circuit.columns();
        let zeros = || vec![0.0; taxels];
        let mut point = circuit.point();
        let preconditioner = Preconditioner::new(point.lines_mut()?);
        let mut live = LiveLines::default();
        live.take_all(circuit.rows(), circuit.columns());
        Some(Self {
            path: OwnPath::new(circuit.ends()),
            point,
            live,
            largest_volts: 0.0,
            measured: zeros(),
            found: zeros(),
            slope: zeros(),
            measured_slope: zeros(),
            own: vec![1.0; taxels],
            noise: zeros(),
            kept_noise: zeros(),
            least_noise: zeros(),
            shift: zeros(),
            weight: zeros(),
            g: zeros(),
            kept: zeros(),
            trial: zeros(),
            misfit: zeros(),
            step: zeros(),
            work: zeros(),
            gmres: Gmres::new(taxels, DEPTH.min(taxels)),
            mixing: Anderson::new(MIXED, taxels),
            preconditioner,
            least_squares: None,
            held: zeros(),
            rest: zeros(),
            is_fresh: false,
            is_warm: false,
            floating: circuit.ends().is_floating(),
            shares: circuit.ends().are_shares(),
        })
    }

    /// Takes a frame: the readings of the unknowns, and what the other taxels conduct.
    pub(super) fn take(&mut self, volts: &Frame<Volts>, unloaded_siemens: f64) {
        let marks = volts.marks().iter();
        let known = self.held.iter_mut().zip(&mut self.rest);
        let mut changed = false;
        for ((held, rest), mark) in known.zip(marks) {
            let is_held = mark.is_no_unknown() || mark.is_out();
            let now = f64::from(u8::from(is_held));
            changed |= *held != now;
            *held = now;
            *rest = if *mark == Mark::BelowFloor {
                unloaded_siemens
            } else {
                0.0
            };
        }
        self.is_fresh &= !changed;
        self.measured.copy_from_slice(volts.values());
        for (measured, held) in self.measured.iter_mut().zip(&self.held) {
            if *held > 0.0 {
                *measured = 0.0;
            }
        }
    }

    /// Why no conductances read this, if that is known.
    pub(super) fn infeasible(&self) -> Option<super::super::Infeasible> {
        self.path
            .infeasible(&self.measured, &self.live, self.shares)
    }

    /// From volts to apparent conductances.
    pub(super) fn take_apparent(&mut self) {
        self.largest_volts = largest(&self.measured);
        self.path
            .apparent(&mut self.measured, &mut self.measured_slope);
    }

    /// A trial: a multiple of the apparent conductances, nothing below a millionth of the largest.
    pub(super) fn start_at(&mut self, factor: f64) {
        let floor = 1e-6 * largest(&self.measured);
        let known = self.held.iter().zip(&self.rest);
        for ((trial, measured), (held, rest)) in
            self.trial.iter_mut().zip(&self.measured).zip(known)
        {
            *trial = if *held > 0.0 {
                *rest
            } else {
                factor * measured.max(floor)
            };
        }
    }

    /// What is held where it is.
    pub(super) fn hold(&mut self) {
        for ((g, held), rest) in self.g.iter_mut().zip(&self.held).zip(&self.rest) {
            if *held > 0.0 {
                *g = *rest;
            }
        }
    }

    /// Solves the network at the trial and leaves the misfit by the D and μ that there are. False where it is not passive.
    pub(super) fn evaluate(&mut self) -> bool {
        if self.point.set(&self.trial).is_err() {
            return false;
        }
        self.point.predict_into(&mut self.found);
        self.path.apparent(&mut self.found, &mut self.slope);
        self.find_misfit();
        self.found.iter().all(|y| y.is_finite())
    }

    /// Back to the conductances that are kept, with their misfit. False where they are not passive.
    pub(super) fn return_to_kept(&mut self) -> bool {
        self.g.copy_from_slice(&self.kept);
        self.trial.copy_from_slice(&self.kept);
        self.evaluate()
    }

    fn find_misfit(&mut self) {
        let taxels = self.misfit.iter_mut().zip(&self.measured).zip(&self.found);
        let by = self.own.iter().zip(&self.shift).zip(&self.trial);
        for (((misfit, measured), found), ((own, shift), trial)) in taxels.zip(by) {
            *misfit = (measured - found) / own - shift * trial;
        }
        for (misfit, held) in self.misfit.iter_mut().zip(&self.held) {
            if *held > 0.0 {
                *misfit = 0.0;
            }
        }
    }

    /// The sum of what the unknowns read, over what they are measured to.
    pub(super) fn excess(&self) -> f64 {
        let found = self.found.iter().zip(&self.held);
        let found: f64 = found.map(|(y, held)| y * (1.0 - held)).sum();
        found / self.measured.iter().sum::<f64>()
    }

    /// D, and unless it is `frozen` μ, at the point evaluated last; `sigma_volts`: noise of a reading.
    pub(super) fn linearise(&mut self, sigma_volts: f64, frozen: bool) {
        if let Some(lines) = self.point.lines_mut() {
            lines.own_slopes_into(&mut self.own);
        }
        for at in 0..self.own.len() {
            let slope = self.slope[at];
            self.own[at] = (self.own[at] * slope).max(MIN_OWN);
            self.weight[at] = slope / self.own[at];
            let noise = (sigma_volts * self.weight[at]).abs();
            self.noise[at] = noise.max(self.least_noise[at]);
            if !frozen {
                self.shift[at] = (self.noise[at] / EXPECTED_SIEMENS).powi(2);
            }
        }
        self.find_misfit();
    }

    /// Whether every step left is small beside the noise, or beside the largest conductance.
    pub(super) fn is_settled(&self, tolerance: f64) -> bool {
        let least = tolerance * largest(&self.trial);
        let taxels = self.misfit.iter().zip(&self.shift).zip(&self.noise);
        let mut taxels = taxels.map(|((r, shift), noise)| (r.abs(), 1.0 + shift, noise));
        taxels.all(|(r, with, noise)| r / with <= least + OF_NOISE * noise / with.sqrt())
    }

    /// What conductances that move so move readings by, volts, at the point evaluated last.
    pub(super) fn moves_into(&mut self, direction: &[f64], out: &mut [f64]) {
        if let Some(lines) = self.point.lines_mut() {
            lines.jvp_into(direction, out);
        }
    }

    /// What readings that count so much move each conductance's count by: the adjoint of [`Self::moves_into`].
    pub(super) fn pulls_into(&mut self, weights: &[f64], out: &mut [f64]) {
        if let Some(lines) = self.point.lines_mut() {
            lines.vjp_into(weights, out);
        }
    }

    /// The preconditioner of the point evaluated last.
    pub(super) fn precondition(&mut self) -> bool {
        let Some(lines) = self.point.lines_mut() else {
            return false;
        };
        let by = (&self.weight[..], &self.shift[..]);
        self.is_fresh = self.preconditioner.set(lines, by, &self.held);
        self.is_fresh
    }

    /// `step` ← Newton's step, to a part of the misfit.
    pub(super) fn find_step(&mut self, tolerance: f64) {
        let Some(lines) = self.point.lines_mut() else {
            return;
        };
        let (preconditioner, work) = (&mut self.preconditioner, &mut self.work);
        let (weight, shift, held) = (&self.weight, &self.shift, &self.held);
        let apply = |v: &[f64], out: &mut [f64]| {
            preconditioner.apply(lines, v, work);
            lines.jvp_into(work, out);
            for at in 0..out.len() {
                out[at] = if held[at] > 0.0 {
                    v[at]
                } else {
                    out[at] * weight[at] + shift[at] * work[at]
                };
            }
        };
        self.gmres
            .solve(apply, &self.misfit, &mut self.step, tolerance, 1);
        work.copy_from_slice(&self.step);
        preconditioner.apply(lines, work, &mut self.step);
    }

    /// `step` ← M⁻¹ of the misfit.
    pub(super) fn find_frozen_step(&mut self) {
        if let Some(lines) = self.point.lines_mut() {
            self.preconditioner
                .apply(lines, &self.misfit, &mut self.step);
        }
    }

    /// A trial: a multiple of the conductances that are kept.
    pub(super) fn start_at_multiple(&mut self, factor: f64) {
        let known = self.held.iter().zip(&self.rest);
        for ((trial, g), (held, rest)) in self.trial.iter_mut().zip(&self.kept).zip(known) {
            *trial = if *held > 0.0 { *rest } else { factor * g };
        }
    }

    /// How unlikely the conductances in `g` are, by those of the unknowns that are told.
    pub(super) fn unlikeliness(&mut self) -> (bool, f64) {
        let most = largest(&self.g);
        let taxels = self.g.iter().zip(&self.held).zip(&self.noise);
        let told = taxels.filter(|((_, held), noise)| **held == 0.0 && **noise <= 1e-3 * most);
        super::super::unlikeliness(told.map(|((g, _), _)| *g), &mut self.work)
    }

    /// What noise makes of the taxel that reads best, siemens.
    pub(super) fn best_noise(&self) -> f64 {
        let noise = self.noise.iter().zip(&self.held);
        let unknown = noise
            .filter(|(_, held)| **held == 0.0)
            .map(|(noise, _)| *noise);
        let least = unknown.fold(f64::INFINITY, f64::min);
        if least.is_finite() { least } else { 0.0 }
    }

    /// How many times as far off as noise the trial leaves the readings, root mean square.
    pub(super) fn beyond_noise(&self, sigma_volts: f64) -> f64 {
        let readings = self.measured.iter().zip(&self.found).zip(&self.slope);
        let off = readings
            .zip(&self.held)
            .filter(|(_, held)| **held == 0.0)
            .map(|(((measured, found), slope), _)| (measured - found) / (slope * sigma_volts));
        crate::stats::mean(off.map(|off| off * off)).map_or(0.0, f64::sqrt)
    }

    /// The largest misfit of an apparent conductance, over the largest measured.
    pub(super) fn residual(&self) -> f64 {
        let off = self.measured.iter().zip(&self.found).zip(&self.held);
        let off = off.map(|((measured, found), held)| (measured - found).abs() * (1.0 - held));
        off.fold(0.0, f64::max) / largest(&self.measured)
    }
}
