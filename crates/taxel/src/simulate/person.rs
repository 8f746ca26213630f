//! A simulated person who grips: trial after trial with effort, tremor, fatigue, and fingers that share the work in their own way.
//!
//! The numbers are our choice, near what is told of maximal grips of healthy people: a rise of 0.3 to 0.7 s, 8 s held, a few
//! per cent of variation, some of it a tremor of 8 to 12 Hz, a force that falls by ½ to 4 % a second, trials that differ by 4 %.

use std::f64::consts::TAU;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::drawing::HAND_GROUPS;
use super::{Purpose, generator};

/// Frames a second that patterns are drawn for.
const RATE: f64 = 100.0;
/// From one trial to the next at least, seconds, and between two grips.
const TRIAL_SECS: f64 = 20.0;
const PAUSE_SECS: f64 = 12.0;
/// Before each trial, seconds.
const REST_SECS: f64 = 0.5;
/// Letting go takes so long, seconds.
const RELEASE_SECS: f64 = 0.25;

/// Frames from the beginning of one trial to that of the next; the first and the last of them are without load.
pub(super) fn frames_per_trial(hold_secs: f64) -> u64 {
    (RATE * TRIAL_SECS.max(hold_secs + PAUSE_SECS)).round() as u64
}

/// How one person grips.
#[derive(Debug, Clone)]
pub(super) struct Person {
    /// Strength as a share of the drawing's highest.
    strength: f64,
    rise_secs: f64,
    /// Share of the force lost a second.
    fatigue: f64,
    /// Share of the force that trembles, and how often a second.
    tremor: f64,
    tremor_hertz: f64,
    /// What each part adds, about 1.
    shares: [f64; HAND_GROUPS],
    /// Where each part's own slow wave begins, in turns.
    phases: [f64; HAND_GROUPS],
}

impl Person {
    /// Drawn from the shape of a seed.
    pub(super) fn draw(shape: &mut ChaCha8Rng) -> Self {
        Self {
            strength: shape.random_range(0.35..0.8),
            rise_secs: shape.random_range(0.3..0.7),
            fatigue: shape.random_range(0.005..0.04),
            tremor: shape.random_range(0.002..0.012),
            tremor_hertz: shape.random_range(8.0..12.0),
            shares: std::array::from_fn(|_| shape.random_range(0.8..1.2)),
            phases: std::array::from_fn(|_| shape.random()),
        }
    }

    /// How hard each part presses in a frame of grips of `hold_secs`, 0 to 1.
    pub(super) fn levels(&self, seed: u64, frame: u64, hold_secs: f64) -> Vec<f64> {
        let secs = frame as f64 / RATE;
        let trial_secs = frames_per_trial(hold_secs) as f64 / RATE;
        let trial = (secs / trial_secs).floor();
        let drawn = &mut generator(seed, Purpose::Contacts, trial as u64);
        let (effort, late) = (drawn.random_range(0.96..1.04), drawn.random_range(0.0..0.2));
        let within = secs - trial * trial_secs - REST_SECS - late;
        let held = self.held(within, hold_secs) * effort * self.strength;
        let tremor = 1.0 + self.tremor * (TAU * self.tremor_hertz * secs).sin();
        let part = |group: usize| {
            // Fingers hand the work to each other, slowly.
            let wave = 1.0 + 0.02 * (TAU * (self.phases[group] + secs / 3.7)).sin();
            (held * tremor * wave * self.shares[group]).clamp(0.0, 1.0)
        };
        (0..HAND_GROUPS).map(part).collect()
    }

    /// From the beginning of a grip: up, tiring, gone.
    fn held(&self, secs: f64, hold_secs: f64) -> f64 {
        let smooth = |x: f64| {
            let x = x.clamp(0.0, 1.0);
            x * x * (3.0 - 2.0 * x)
        };
        let up = smooth(secs / self.rise_secs);
        let gone = 1.0 - smooth((secs - hold_secs) / RELEASE_SECS);
        let tired = 1.0 - self.fatigue * (secs - self.rise_secs).max(0.0);
        up * gone * tired.max(0.0)
    }
}
