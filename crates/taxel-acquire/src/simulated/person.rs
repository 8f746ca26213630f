//! A simulated person who does what they are told: rests, and grips when a trial begins.

use std::sync::{Arc, Mutex, PoisonError};

use serde::{Deserialize, Serialize};
use taxel::sensor::Array;
use taxel::simulate::{Pattern, PatternKind};
use taxel::{Frame, Grams};

/// Frames a second that patterns are drawn for.
pub const DRAWN_RATE: f64 = 100.0;

/// The frame that is drawn at a time, seconds. A source with as many frames a second sees each once: times are rounded, and 0.29 s
/// is not 28 frames.
pub(super) fn drawn_frame(secs: f64) -> u64 {
    (DRAWN_RATE * secs + 1e-6).max(0.0) as u64
}

/// One grip that a person was told to do. With the seed of the source it says what pressed at any time: the truth.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct ToldGrip {
    /// Which of the person's grips: each has an effort of its own.
    pub trial: u64,
    /// How long they hold, seconds.
    pub hold_secs: f64,
    /// Strength as a share of their usual one, such as that of the other hand.
    pub strength: f64,
    /// When they were told, in the source's time, seconds; `None` before the source has seen it.
    pub begun_secs: Option<f64>,
}

impl ToldGrip {
    /// A grip to come.
    pub fn new(trial: u64, hold_secs: f64, strength: f64) -> Self {
        Self {
            trial,
            hold_secs,
            strength,
            begun_secs: None,
        }
    }

    /// The pattern of it, and its frame at a time of the source.
    fn drawn(&self, array: &Array, secs: f64) -> (Pattern, u64) {
        let pattern = Pattern::new(PatternKind::Grip {
            hold_secs: self.hold_secs,
        });
        let pattern = pattern.with_peak_g(self.strength * pattern.peak_of(array));
        let length = pattern.frames_per_trial().expect("a person who grips");
        let since = self.begun_secs.map_or(0.0, |begun| secs - begun);
        let within = drawn_frame(since);
        (pattern, self.trial * length + within.min(length - 1))
    }

    /// What presses at a time of the source, grams.
    pub fn loads(&self, array: &Array, seed: u64, secs: f64) -> Frame<Grams> {
        let (pattern, frame) = self.drawn(array, secs);
        pattern.loads(array, seed, frame)
    }

    /// All that presses from the word on, grams, [`DRAWN_RATE`] frames a second: the truth, whenever a sensor looks.
    pub fn all_loads(&self, array: &Array, seed: u64) -> impl Iterator<Item = Frame<Grams>> {
        let (pattern, first) = self.drawn(array, self.begun_secs.unwrap_or(0.0));
        let length = pattern.frames_per_trial().unwrap_or(0);
        (first..first + length).map(move |frame| pattern.loads(array, seed, frame))
    }

    /// Which part of the hand presses each taxel then.
    pub fn hand_parts(
        &self,
        array: &Array,
        seed: u64,
        secs: f64,
    ) -> Option<Vec<Option<&'static str>>> {
        let (pattern, frame) = self.drawn(array, secs);
        pattern.hand_parts(array, seed, frame)
    }
}

/// What the person does.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
enum Doing {
    /// Grips now and then, of their own accord.
    #[default]
    AsTheyLike,
    Resting,
    Gripping(ToldGrip),
}

/// The person, to be told from anywhere.
#[derive(Debug, Clone, Default)]
pub struct Person(Arc<Mutex<Doing>>);

impl Person {
    fn with<T>(&self, then: impl FnOnce(&mut Doing) -> T) -> T {
        then(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// From now on they grip when they are told to only.
    pub fn rest(&self) {
        self.with(|doing| *doing = Doing::Resting);
    }

    /// They grip now, once.
    pub fn grip(&self, grip: ToldGrip) {
        self.with(|doing| *doing = Doing::Gripping(grip));
    }

    /// What they were told last, if that was to grip.
    pub fn told(&self) -> Option<ToldGrip> {
        self.with(|doing| match doing {
            Doing::Gripping(grip) => Some(*grip),
            _ => None,
        })
    }

    /// What presses at a time of the source, grams; `None` where they do as they like.
    pub(super) fn loads(&self, array: &Array, seed: u64, secs: f64) -> Option<Frame<Grams>> {
        let doing = self.with(|doing| {
            if let Doing::Gripping(grip) = doing {
                grip.begun_secs.get_or_insert(secs);
            }
            *doing
        });
        match doing {
            Doing::AsTheyLike => None,
            Doing::Resting => Some(Frame::zeros(array.rows, array.columns)),
            Doing::Gripping(grip) => Some(grip.loads(array, seed, secs)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use taxel::sensor::preset;

    fn total(frame: &Frame<Grams>) -> f64 {
        frame.values().iter().sum()
    }

    #[test]
    fn a_person_grips_when_told_and_the_truth_can_be_told_afterwards() {
        let sensor = preset("econe").unwrap();
        let array = sensor.array();
        let person = Person::default();
        assert!(person.loads(array, 4, 1.0).is_none());
        person.rest();
        assert_eq!(total(&person.loads(array, 4, 1.0).unwrap()), 0.0);
        person.grip(ToldGrip::new(2, 3.0, 0.9));
        // The first frame after the word is when it begins; a moment later nothing presses yet, after a second the hand does.
        assert_eq!(total(&person.loads(array, 4, 100.0).unwrap()), 0.0);
        let held = total(&person.loads(array, 4, 102.5).unwrap());
        assert!(held > 5000.0, "{held} g");
        // 3 s after at most 0.7 s of reaction and a quarter of a second to let go, it is over, for good.
        assert_eq!(total(&person.loads(array, 4, 104.0).unwrap()), 0.0);
        assert_eq!(total(&person.loads(array, 4, 900.0).unwrap()), 0.0);
        let told = person.told().unwrap();
        assert_eq!(told.begun_secs, Some(100.0));
        assert_eq!(total(&told.loads(array, 4, 102.5)), held);
        let all: Vec<f64> = told
            .all_loads(array, 4)
            .map(|loads| total(&loads))
            .collect();
        assert!(all.contains(&held) && all[0] == 0.0 && all.last() == Some(&0.0));
        // With the other hand they are as much weaker as was said, taxel by taxel.
        let strong = ToldGrip {
            strength: 1.0,
            ..told
        };
        let ratio = held / total(&strong.loads(array, 4, 102.5));
        assert!((ratio - 0.9).abs() < 1e-9, "{ratio}");
        let parts = told.hand_parts(array, 4, 102.5).unwrap();
        assert!(parts.contains(&Some("thumb")) && parts.contains(&None));
    }
}
