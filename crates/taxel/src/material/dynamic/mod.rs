//! The dynamic load law: what a taxel's material remembers of earlier loads.
//!
//! The static law turns a conductance into the load x that *would* give it in a fresh material. The material adds to the
//! true load F what it remembers:
//!
//! x = F + Σᵢ wᵢ·sᵢ + Σⱼ hⱼ·qⱼ
//!
//! - F: load on the taxel, grams; x: acting load, grams
//! - sᵢ: creep, F lagging behind with the time constant τᵢ: τᵢ·dsᵢ/dt = F − sᵢ, wᵢ its weight
//! - qⱼ: hysteresis, a play (backlash) of half-width rⱼ grams: qⱼ ← clamp(qⱼ, F − rⱼ, F + rⱼ), hⱼ its weight
//!
//! Prandtl–Ishlinskii plays and exponentials: P. Krejčí and K. Kuhnen, "Inverse control of systems with hysteresis and
//! creep", IEE Proc. Control Theory Appl. 148:185, 2001. Both are driven by F, which makes the inverse of one time step a
//! closed form: given what is remembered, x is a straight line in F with one kink for each play.

mod state;

pub use state::HysteresisState;

use crate::sensor::{DynamicSpec, MAX_DYNAMIC_TERMS};

/// What a material remembers, the same for every taxel.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct DynamicLaw {
    /// Weight (a pure number) and time constant (seconds) of each lag.
    pub lags: Vec<(f64, f64)>,
    /// Weight (a pure number) and half-width (grams) of each play, half-widths ascending.
    pub plays: Vec<(f64, f64)>,
    /// Seconds between frames that tell no time.
    pub period_secs: f64,
}

impl DynamicLaw {
    /// The law that a sensor file gives.
    pub fn from_spec(spec: &DynamicSpec) -> Self {
        let pairs = |a: &[f64], b: &[f64]| a.iter().copied().zip(b.iter().copied()).collect();
        Self {
            lags: pairs(&spec.lag_weight, &spec.lag_secs),
            plays: pairs(&spec.play_weight, &spec.play_g),
            period_secs: spec.period_secs,
        }
    }

    /// As a sensor file has it.
    pub fn to_spec(&self) -> DynamicSpec {
        DynamicSpec {
            lag_weight: self.lags.iter().map(|lag| lag.0).collect(),
            lag_secs: self.lags.iter().map(|lag| lag.1).collect(),
            play_weight: self.plays.iter().map(|play| play.0).collect(),
            play_g: self.plays.iter().map(|play| play.1).collect(),
            period_secs: self.period_secs,
        }
    }

    /// ForwardState step of `secs` seconds.
    pub(crate) fn step(&self, secs: f64) -> Step {
        let mut step = Step {
            lags: self.lags.len(),
            plays: self.plays.len(),
            ..Step::default()
        };
        let mut slope = 1.0;
        for (i, &(weight, tau)) in self.lags.iter().enumerate() {
            let part = secs / tau;
            // 1 − e^(−Δt/τ) and 1 − τ/Δt·(1 − e^(−Δt/τ)), without cancellation.
            let gone = -(-part).exp_m1();
            let new = match part {
                part if part < 1e-4 => part / 2.0,
                part => 1.0 - gone / part,
            };
            step.weight[i] = weight;
            step.keep[i] = 1.0 - gone;
            step.old[i] = gone - new;
            step.new[i] = new;
            slope += weight * new;
        }
        step.slope = slope;
        for (j, &(weight, half_width)) in self.plays.iter().enumerate() {
            slope += weight;
            step.play_weight[j] = weight;
            step.half_width[j] = half_width;
            step.give[j] = weight / slope;
        }
        step
    }

    /// Acting loads of one taxel, grams, from its loads, grams, at these times, seconds: the law forwards, from rest.
    ///
    /// # Panics
    /// When there is not one time for each load.
    pub fn acting(&self, secs: &[f64], loads: &[f64]) -> Vec<f64> {
        assert_eq!(secs.len(), loads.len(), "a time for each load");
        let mut state = ForwardState::default();
        let mut before = secs.first().copied().unwrap_or_default();
        let each = secs.iter().zip(loads).map(|(&now, &load)| {
            let step = self.step(now - before);
            before = now;
            state.advance(&step, load);
            state.acting(&step, load)
        });
        each.collect()
    }
}

/// The numbers of one time step, shared by all taxels: the load runs straight from frame to frame, for which
/// sᵢ ← keep·sᵢ + old·F(before) + new·F is exact.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Step {
    lags: usize,
    plays: usize,
    weight: [f64; MAX_DYNAMIC_TERMS],
    keep: [f64; MAX_DYNAMIC_TERMS],
    old: [f64; MAX_DYNAMIC_TERMS],
    new: [f64; MAX_DYNAMIC_TERMS],
    /// dx/dF while no play moves.
    slope: f64,
    play_weight: [f64; MAX_DYNAMIC_TERMS],
    half_width: [f64; MAX_DYNAMIC_TERMS],
    /// Share of its way that F is held back by once play j moves as well.
    give: [f64; MAX_DYNAMIC_TERMS],
}

/// What one taxel remembers, for the law forwards.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct ForwardState {
    load: f64,
    lags: [f64; MAX_DYNAMIC_TERMS],
    plays: [f64; MAX_DYNAMIC_TERMS],
}

impl ForwardState {
    pub(crate) fn advance(&mut self, step: &Step, load: f64) {
        for i in 0..step.lags {
            self.lags[i] =
                step.keep[i] * self.lags[i] + step.old[i] * self.load + step.new[i] * load;
        }
        for j in 0..step.plays {
            let reach = step.half_width[j];
            self.plays[j] = self.plays[j].clamp(load - reach, load + reach);
        }
        self.load = load;
    }

    pub(crate) fn acting(&self, step: &Step, load: f64) -> f64 {
        let sum = |weights: &[f64], values: &[f64]| -> f64 {
            weights.iter().zip(values).map(|(w, v)| w * v).sum()
        };
        load + sum(&step.weight[..step.lags], &self.lags)
            + sum(&step.play_weight[..step.plays], &self.plays)
    }
}

#[cfg(test)]
mod tests;
