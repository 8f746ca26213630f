//! What all taxels of an array remember, and the inverse of the law, frame by frame.

use taxel_linalg::wide;

use super::{DynamicLaw, Step};

/// Taxels worked on together: each step goes through all of them, which stay in the first cache.
const LANES: usize = 64;
/// One number each.
type Lanes = [f64; LANES];

/// What the taxels of an array remember. Before the first frame all loads are 0 and always were: begin without load.
#[derive(Debug, Clone)]
pub struct HysteresisState {
    law: DynamicLaw,
    taxels: usize,
    /// Seconds of the frame before; `None` before the first.
    secs: Option<f64>,
    loads: Vec<Lanes>,
    /// One list a lag, one list a play.
    lags: Vec<Vec<Lanes>>,
    plays: Vec<Vec<Lanes>>,
}

impl HysteresisState {
    /// Nothing remembered.
    pub fn new(law: &DynamicLaw, taxels: usize) -> Self {
        let nothing = vec![[0.0; LANES]; taxels.div_ceil(LANES)];
        Self {
            law: law.clone(),
            taxels,
            secs: None,
            lags: vec![nothing.clone(); law.lags.len()],
            plays: vec![nothing.clone(); law.plays.len()],
            loads: nothing,
        }
    }

    /// Forgets everything: where a recording jumps.
    pub fn forget(&mut self) {
        self.secs = None;
        let lists = self.lags.iter_mut().chain(&mut self.plays);
        for list in lists.chain([&mut self.loads]) {
            list.fill([0.0; LANES]);
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
        wide(
            #[inline(always)]
            || self.take(&step, grams, is_lost),
        );
    }

    #[inline(always)]
    fn take(&mut self, step: &Step, grams: &mut [f64], is_lost: impl Fn(usize) -> bool) {
        let (whole, rest) = grams.as_chunks_mut::<LANES>();
        for (at, acting) in whole.iter_mut().enumerate() {
            let lost = |lane| is_lost(at * LANES + lane);
            self.take_lanes(step, at, acting, lost);
        }
        if !rest.is_empty() {
            let (at, mut acting) = (whole.len(), [0.0; LANES]);
            acting[..rest.len()].copy_from_slice(rest);
            let lost = |lane| at * LANES + lane < self.taxels && is_lost(at * LANES + lane);
            let lost: [bool; LANES] = std::array::from_fn(lost);
            self.take_lanes(step, at, &mut acting, |lane| lost[lane]);
            rest.copy_from_slice(&acting[..rest.len()]);
        }
    }

    /// Loads from acting loads, given what is remembered, which goes on.
    #[inline(always)]
    fn take_lanes(
        &mut self,
        step: &Step,
        at: usize,
        acting: &mut Lanes,
        is_lost: impl Fn(usize) -> bool,
    ) {
        let before = self.loads[at];
        let mut load = *acting;
        for (i, lag) in self.lags.iter().enumerate() {
            let (keep, old) = (step.weight[i] * step.keep[i], step.weight[i] * step.old[i]);
            let lag = &lag[at];
            for lane in 0..LANES {
                load[lane] -= keep * lag[lane] + old * before[lane];
            }
        }
        for (weight, play) in step.play_weight.iter().zip(&self.plays) {
            for (load, play) in load.iter_mut().zip(&play[at]) {
                *load -= weight * play;
            }
        }
        let share = 1.0 / step.slope;
        for load in &mut load {
            *load *= share;
        }
        for (j, play) in self.plays.iter().enumerate() {
            let (give, reach) = (step.give[j], step.half_width[j]);
            for (load, play) in load.iter_mut().zip(&play[at]) {
                let over = greater(*load - (play + reach), 0.0);
                let under = greater((play - reach) - *load, 0.0);
                *load += give * (under - over);
            }
        }
        for load in &mut load {
            *load = greater(*load, 0.0);
        }
        // Nearly always none is.
        if (0..LANES).fold(false, |any, lane| any | is_lost(lane)) {
            for lane in (0..LANES).filter(|&lane| is_lost(lane)) {
                load[lane] = before[lane];
            }
        }
        self.remember(step, at, &load);
        *acting = load;
    }

    /// Carries what some taxels remember on to these loads.
    #[inline(always)]
    fn remember(&mut self, step: &Step, at: usize, loads: &Lanes) {
        let before = self.loads[at];
        for (i, lag) in self.lags.iter_mut().enumerate() {
            let (keep, old, new) = (step.keep[i], step.old[i], step.new[i]);
            let lag = &mut lag[at];
            for lane in 0..LANES {
                lag[lane] = keep * lag[lane] + old * before[lane] + new * loads[lane];
            }
        }
        for (reach, play) in step.half_width.iter().zip(&mut self.plays) {
            for (play, load) in play[at].iter_mut().zip(loads) {
                *play = less(greater(*play, load - reach), load + reach);
            }
        }
        self.loads[at] = *loads;
    }
}

/// The greater of two, as one instruction; the second where the first is no number.
#[inline(always)]
fn greater(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// The less of two, likewise.
#[inline(always)]
fn less(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}
