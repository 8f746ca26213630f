//! What a simulated material remembers: creep and hysteresis, forwards.

use crate::material::{DynamicLaw, ForwardState};

/// How long a press rises, and how long it has stood when it is read, seconds.
const RISE_SECS: f64 = 0.2;
const HELD_SECS: f64 = 2.0;

/// The state of every taxel of a material that remembers; of one that does not, nothing.
#[derive(Debug, Clone)]
pub struct LoadMemory {
    law: Option<DynamicLaw>,
    taxels: Vec<ForwardState>,
    before_secs: Option<f64>,
}

impl LoadMemory {
    pub(super) fn new(law: Option<&DynamicLaw>, taxels: usize) -> Self {
        Self {
            law: law.cloned(),
            taxels: vec![ForwardState::default(); if law.is_some() { taxels } else { 0 }],
            before_secs: None,
        }
    }

    /// Makes acting loads of loads, grams, at a time in seconds; of frames that tell none, a period of the law after the last.
    pub(super) fn advance(&mut self, secs: Option<f64>, loads: &mut [f64]) {
        let Some(law) = &self.law else { return };
        let step = match (secs, self.before_secs) {
            (Some(now), Some(before)) => now - before,
            _ => law.period_secs,
        };
        self.before_secs = secs;
        let step = law.step(step.max(0.0));
        for (state, load) in self.taxels.iter_mut().zip(loads) {
            state.advance(&step, *load);
            *load = state.acting(&step, *load);
        }
    }
}

/// Makes acting loads of loads, grams, that rise from rest and are held.
pub(super) fn acting_when_held(law: &DynamicLaw, loads: &mut [f64]) {
    let steps = [law.step(RISE_SECS), law.step(HELD_SECS)];
    for load in loads {
        let mut state = ForwardState::default();
        for step in &steps {
            state.advance(step, *load);
        }
        *load = state.acting(&steps[1], *load);
    }
}
