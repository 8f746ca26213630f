//! One frame under one circuit: conductances of its pressed taxels, what they predict, and what moves with what.

use taxel_linalg::dot;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::readings::Reading;
use crate::circuit::{LinearCircuit, LinearPoint, OperatingPoint};

/// Vectors of random signs that a diagonal is estimated from.
const PROBES: u64 = 6;
/// Rounds of conjugate gradients at most, and the share of the residual that ends them.
const ROUNDS: usize = 25;
const ENOUGH: f64 = 1e-3;
/// Largest conductance, logarithm of siemens: fifty times the resistor's that the line ends in.
const LOG_MOST: f64 = -3.0;
const LOG_LEAST: f64 = -25.0;
/// What is believed of the logarithm of a pressed taxel's conductance: its middle, and its precision (a factor of e⁸ either
/// way).
const LOG_USUAL: f64 = -9.0;
const BELIEF: f64 = 1.0 / 64.0;

/// Which taxels are pressed, and how well they conduct.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Pressed {
    pub(super) taxels: Vec<usize>,
    /// ln of siemens.
    pub(super) logs: Vec<f64>,
}

/// What all frames share at one point of a fit.
#[derive(Clone, Copy)]
pub(super) struct Shared<'a> {
    pub(super) circuit: &'a LinearCircuit,
    pub(super) counts_per_volt: f64,
    /// ln of the siemens of a taxel that is not pressed.
    pub(super) log_unpressed: f64,
}

/// A frame solved at one point.
pub(super) struct FrameFit<'a> {
    readings: &'a [Reading],
    point: LinearPoint,
    siemens: Vec<f64>,
    counts_per_volt: f64,
    pressed: &'a Pressed,
    /// Predicted less read, in standard deviations.
    pub(super) residuals: Vec<f64>,
    /// Taxels that read too much for one that is not pressed, and wait to be named; with what they read more, counts.
    pub(super) dark: Vec<(usize, f64)>,
    /// Of each reading, 1/σ, or 0 where it does not hold the fit.
    weights: Vec<f64>,
    waiting: f64,
    direction: Vec<f64>,
    volts: Vec<f64>,
    diagonal: Vec<f64>,
}

impl<'a> FrameFit<'a> {
    /// A taxel that is not pressed and reads more than is predicted by more than `waiting` standard deviations waits to be
    /// named: its reading does not hold the fit. `None` where these conductances make no network.
    pub(super) fn new(
        readings: &'a [Reading],
        absent: &[bool],
        sigma: f64,
        shared: Shared<'_>,
        pressed: &'a Pressed,
        waiting: f64,
    ) -> Option<Self> {
        let unpressed = shared.log_unpressed.exp();
        let mut siemens: Vec<f64> = absent
            .iter()
            .map(|&absent| if absent { 0.0 } else { unpressed })
            .collect();
        for (&taxel, log) in pressed.taxels.iter().zip(&pressed.logs) {
            siemens[taxel] = log.exp();
        }
        let mut point = shared.circuit.point();
        point.set(&siemens).ok()?;
        let mut volts = vec![0.0; readings.len()];
        point.predict_into(&mut volts);
        let (mut residuals, mut weights) = (Vec::new(), Vec::new());
        let mut dark = Vec::new();
        for (taxel, (reading, volts)) in readings.iter().zip(&volts).enumerate() {
            let residual = reading.residual(volts * shared.counts_per_volt) / sigma;
            let waits = -residual > waiting && pressed.taxels.binary_search(&taxel).is_err();
            let holds = !waits && (residual != 0.0 || matches!(reading, Reading::Is(_)));
            if waits {
                dark.push((taxel, -residual * sigma));
            }
            residuals.push(if waits { 0.0 } else { residual });
            weights.push(if holds { 1.0 / sigma } else { 0.0 });
        }
        if !residuals.iter().all(|residual| residual.is_finite()) {
            return None;
        }
        Some(Self {
            readings,
            point,
            siemens,
            counts_per_volt: shared.counts_per_volt,
            pressed,
            residuals,
            dark,
            weights,
            waiting,
            direction: vec![0.0; readings.len()],
            volts,
            diagonal: Vec::new(),
        })
    }

    /// Half the sum of squares, and what is believed of conductances.
    pub(super) fn misfit(&self) -> f64 {
        let squares: f64 = self.residuals.iter().map(|r| r * r).sum();
        let squares = squares + self.dark.len() as f64 * self.waiting.powi(2).min(1e6);
        let beliefs = self.pressed.logs.iter();
        let beliefs: f64 = beliefs.map(|log| (log - LOG_USUAL).powi(2)).sum();
        0.5 * (squares + BELIEF * beliefs)
    }

    /// What its readings are under another circuit, less those under this one, per step, in standard deviations.
    pub(super) fn change_under(
        &self,
        circuit: &LinearCircuit,
        counts_per_volt: f64,
        step: f64,
    ) -> Vec<f64> {
        let mut point = circuit.point();
        let mut volts = self.volts.clone();
        if point.set(&self.siemens).is_ok() {
            point.predict_into(&mut volts);
        }
        let pairs = volts.iter().zip(&self.volts).zip(&self.weights);
        let change = |((now, before), weight): ((&f64, &f64), &f64)| {
            weight * (now * counts_per_volt - before * self.counts_per_volt) / step
        };
        pairs.map(change).collect()
    }

    /// The same for the logarithm of the conductance of all taxels that are not pressed.
    pub(super) fn change_unpressed(&mut self) -> Vec<f64> {
        self.direction.copy_from_slice(&self.siemens);
        for &taxel in &self.pressed.taxels {
            self.direction[taxel] = 0.0;
        }
        let mut out = vec![0.0; self.direction.len()];
        self.point.jvp_into(&self.direction, &mut out);
        self.weigh(&mut out);
        out
    }

    fn weigh(&self, volts: &mut [f64]) {
        for (value, weight) in volts.iter_mut().zip(&self.weights) {
            *value *= weight * self.counts_per_volt;
        }
    }

    /// J v: change of the weighted readings along a change of the logarithms.
    fn forward(&mut self, along: &[f64], out: &mut [f64]) {
        self.direction.fill(0.0);
        for (&taxel, along) in self.pressed.taxels.iter().zip(along) {
            self.direction[taxel] = along * self.siemens[taxel];
        }
        self.point.jvp_into(&self.direction, out);
        self.weigh(out);
    }

    /// Jᵀ w.
    pub(super) fn backward(&mut self, of: &[f64]) -> Vec<f64> {
        for ((to, from), weight) in self.direction.iter_mut().zip(of).zip(&self.weights) {
            *to = from * weight * self.counts_per_volt;
        }
        let mut out = vec![0.0; of.len()];
        self.point.vjp_into(&self.direction, &mut out);
        let taxels = self.pressed.taxels.iter();
        taxels
            .map(|&taxel| out[taxel] * self.siemens[taxel])
            .collect()
    }

    /// Estimates the diagonal of JᵀJ from random signs: a preconditioner needs no more.
    pub(super) fn probe(&mut self) {
        let mut sums = vec![BELIEF; self.pressed.taxels.len()];
        let mut random = ChaCha8Rng::seed_from_u64(1);
        for _ in 0..PROBES {
            let signs: Vec<f64> = (0..self.readings.len())
                .map(|_| if random.random::<bool>() { 1.0 } else { -1.0 })
                .collect();
            for (sum, value) in sums.iter_mut().zip(self.backward(&signs)) {
                *sum += value * value / PROBES as f64;
            }
        }
        self.diagonal = sums;
    }

    /// x of (JᵀJ + prior + damping · diagonal) x = right, by preconditioned conjugate gradients.
    pub(super) fn solve(&mut self, right: &[f64], damping: f64) -> Vec<f64> {
        let n = right.len();
        let mut x = vec![0.0; n];
        let mut r = right.to_vec();
        let scale: Vec<f64> = self
            .diagonal
            .iter()
            .map(|d| 1.0 / (d * (1.0 + damping)))
            .collect();
        let mut z: Vec<f64> = r.iter().zip(&scale).map(|(r, s)| r * s).collect();
        let mut p = z.clone();
        let mut rz = dot(&r, &z);
        let first = rz;
        let mut image = vec![0.0; self.readings.len()];
        for _ in 0..ROUNDS.min(2 * n) {
            if rz <= ENOUGH * ENOUGH * first || rz <= 0.0 {
                break;
            }
            self.forward(&p, &mut image);
            let mut ap = self.backward(&image);
            for ((ap, p), d) in ap.iter_mut().zip(&p).zip(&self.diagonal) {
                *ap += (BELIEF + damping * d) * p;
            }
            let curvature = dot(&p, &ap);
            if curvature <= 0.0 || !curvature.is_finite() {
                break;
            }
            let step = rz / curvature;
            for i in 0..n {
                x[i] += step * p[i];
                r[i] -= step * ap[i];
                z[i] = r[i] * scale[i];
            }
            let next = dot(&r, &z);
            for (p, z) in p.iter_mut().zip(&z) {
                *p = z + next / rz * *p;
            }
            rz = next;
        }
        x
    }

    /// −(gradient of [`Self::misfit`]) by the logarithms.
    pub(super) fn descent(&mut self) -> Vec<f64> {
        let residuals = std::mem::take(&mut self.residuals);
        let mut down = self.backward(&residuals);
        self.residuals = residuals;
        for (down, log) in down.iter_mut().zip(&self.pressed.logs) {
            *down = -*down - BELIEF * (log - LOG_USUAL);
        }
        down
    }

    /// The residuals once the logarithms have moved by `x`, to first order.
    pub(super) fn residuals_after(&mut self, x: &[f64]) -> Vec<f64> {
        let mut image = vec![0.0; self.residuals.len()];
        self.forward(x, &mut image);
        self.residuals
            .iter()
            .zip(&image)
            .map(|(r, i)| r + i)
            .collect()
    }

    /// What is left of `column` once the logarithms have followed: column − J x.
    pub(super) fn less(&mut self, column: &[f64], x: &[f64]) -> Vec<f64> {
        let mut image = vec![0.0; column.len()];
        self.forward(x, &mut image);
        column.iter().zip(&image).map(|(c, i)| c - i).collect()
    }
}

/// Within what a pressed taxel can conduct.
pub(super) fn bounded(log: f64) -> f64 {
    log.clamp(LOG_LEAST, LOG_MOST)
}
