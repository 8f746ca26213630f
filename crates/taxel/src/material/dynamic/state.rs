//! What all taxels of an array remember, and the inverse of the law, frame by frame.

use super::{DynamicLaw, Step};
use crate::sensor::MAX_DYNAMIC_TERMS;

/// Taxels worked on together: all that they remember stays in the first cache.
const BLOCK: usize = 256;

/// What the taxels of an array remember. Before the first frame all loads are 0 and always were: begin without load.
#[derive(Debug, Clone)]
pub struct HysteresisState {
    law: DynamicLaw,
    taxels: usize,
    /// Seconds of the frame before; `None` before the first.
    secs: Option<f64>,
    loads: Vec<f64>,
    /// One list a lag, one list a play.
    lags: Vec<Vec<f64>>,
    plays: Vec<Vec<f64>>,
}

impl HysteresisState {
    /// Nothing remembered.
    pub fn new(law: &DynamicLaw, taxels: usize) -> Self {
        Self {
            law: law.clone(),
            taxels,
            secs: None,
            loads: vec![0.0; taxels],
            lags: vec![vec![0.0; taxels]; law.lags.len()],
            plays: vec![vec![0.0; taxels]; law.plays.len()],
        }
    }

    /// Forgets everything: where a recording jumps.
    pub fn forget(&mut self) {
        self.secs = None;
        let lists = self.lags.iter_mut().chain(&mut self.plays);
        for list in lists.chain([&mut self.loads]) {
            list.fill(0.0);
        }
    }

    /// Replaces the acting load of every taxel by its load, both in grams, and remembers it. `secs` is the frame's time;
    /// without it, the law's period has passed. Time that runs backwards is a jump: everything is forgotten. Where `is_lost`, the
    /// taxel is taken to carry what it carried. No allocation.
    ///
    /// The inverse of one step is exact: plays that are driven by one load from rest move in the order of their half-widths,
    /// so each that moves holds the load back by its share of what is left.
    ///
    /// # Panics
    /// When there is not one number for each taxel.
    pub fn loads_from_acting(
        &mut self,
        secs: Option<f64>,
        grams: &mut [f64],
        is_lost: impl Fn(usize) -> bool,
    ) {
        assert_eq!(grams.len(), self.taxels, "one acting load for each taxel");
        let now = secs.or(self.secs.map(|before| before + self.law.period_secs));
        let now = now.unwrap_or_default();
        if self.secs.is_some_and(|before| now < before) {
            self.forget();
        }
        let step = self.law.step(now - self.secs.unwrap_or(now));
        self.secs = Some(now);
        let arch = pulp::Arch::new();
        for first in (0..self.taxels).step_by(BLOCK) {
            let block = first..(first + BLOCK).min(self.taxels);
            let acting = &mut grams[block.clone()];
            let mut lags: [&mut [f64]; MAX_DYNAMIC_TERMS] = Default::default();
            for (slot, list) in lags.iter_mut().zip(&mut self.lags) {
                *slot = &mut list[block.clone()];
            }
            let mut plays: [&mut [f64]; MAX_DYNAMIC_TERMS] = Default::default();
            for (slot, list) in plays.iter_mut().zip(&mut self.plays) {
                *slot = &mut list[block.clone()];
            }
            let before = &mut self.loads[block.clone()];
            let (mut loads, mut slack) = ([0.0; BLOCK], [0.0; BLOCK]);
            arch.dispatch(
                #[inline(always)]
                || invert(&step, acting, before, &lags, &plays, &mut loads, &mut slack),
            );
            for (i, load) in loads[..block.len()].iter_mut().enumerate() {
                if is_lost(first + i) {
                    *load = before[i];
                }
            }
            arch.dispatch(
                #[inline(always)]
                || remember(&step, &loads, before, &mut lags, &mut plays),
            );
            acting.copy_from_slice(&loads[..block.len()]);
        }
    }
}

/// Loads of a block from acting loads, given what is remembered.
#[inline(always)]
fn invert(
    step: &Step,
    acting: &[f64],
    before: &[f64],
    lags: &[&mut [f64]; MAX_DYNAMIC_TERMS],
    plays: &[&mut [f64]; MAX_DYNAMIC_TERMS],
    loads: &mut [f64; BLOCK],
    slack: &mut [f64; BLOCK],
) {
    let count = acting.len();
    let (loads, slack) = (&mut loads[..count], &mut slack[..count]);
    slack.copy_from_slice(acting);
    for (i, lag) in lags.iter().enumerate().take(step.lags) {
        let (keep, old) = (step.weight[i] * step.keep[i], step.weight[i] * step.old[i]);
        for ((slack, lag), before) in slack.iter_mut().zip(&lag[..count]).zip(&before[..count]) {
            *slack -= keep * lag + old * before;
        }
    }
    for (j, play) in plays.iter().enumerate().take(step.plays) {
        let weight = step.play_weight[j];
        for (slack, play) in slack.iter_mut().zip(&play[..count]) {
            *slack -= weight * play;
        }
    }
    let share = 1.0 / step.slope;
    for (load, slack) in loads.iter_mut().zip(slack.iter()) {
        *load = share * slack;
    }
    for (j, play) in plays.iter().enumerate().take(step.plays) {
        let (give, reach) = (step.give[j], step.half_width[j]);
        for (load, play) in loads.iter_mut().zip(&play[..count]) {
            let over = (*load - (play + reach)).max(0.0);
            let under = ((play - reach) - *load).max(0.0);
            *load += give * (under - over);
        }
    }
    for load in loads {
        *load = load.max(0.0);
    }
}

/// Carries what a block remembers on to these loads.
#[inline(always)]
fn remember(
    step: &Step,
    loads: &[f64; BLOCK],
    before: &mut [f64],
    lags: &mut [&mut [f64]; MAX_DYNAMIC_TERMS],
    plays: &mut [&mut [f64]; MAX_DYNAMIC_TERMS],
) {
    let count = before.len();
    let loads = &loads[..count];
    for (i, lag) in lags.iter_mut().enumerate().take(step.lags) {
        let (keep, old, new) = (step.keep[i], step.old[i], step.new[i]);
        for ((lag, load), before) in lag[..count].iter_mut().zip(loads).zip(&before[..count]) {
            *lag = keep * *lag + old * before + new * load;
        }
    }
    for (j, play) in plays.iter_mut().enumerate().take(step.plays) {
        let reach = step.half_width[j];
        for (play, load) in play[..count].iter_mut().zip(loads) {
            *play = play.max(load - reach).min(load + reach);
        }
    }
    before.copy_from_slice(loads);
}
