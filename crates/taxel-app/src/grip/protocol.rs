//! What a grip session asks of a person, as a TOML file.

use std::ops::RangeInclusive;
use std::path::Path;

use serde::{Deserialize, Serialize};
use taxel_server::{GripHand, GripProtocol};

use crate::error::Error;
use crate::text_file;

/// The longest protocol, bytes.
const MAX: u64 = 64 << 10;
/// What can be asked of a person and of the disk.
const HOLD_SECS: RangeInclusive<f64> = 1.0..=120.0;
const REST_SECS: RangeInclusive<f64> = 0.0..=3600.0;
const COUNTDOWN_SECS: RangeInclusive<f64> = 1.0..=30.0;
const TRIALS: RangeInclusive<usize> = 1..=20;
const TARGET_NEWTONS: RangeInclusive<f64> = 0.1..=5000.0;
const MAX_TEXT: usize = 300;

/// A protocol. What a file does not say is as [`Protocol::default`] has it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
#[non_exhaustive]
pub struct Protocol {
    /// Its name.
    pub name: String,
    /// How the person sits and holds the handle, in words.
    pub posture: String,
    /// The hands, in the order in which they grip.
    pub hands: Vec<Hand>,
    /// Trials of each hand.
    pub trials: usize,
    /// Whether the hands take turns; else one after the other.
    pub alternating: bool,
    /// Seconds from the operator's start to the grip.
    pub countdown_secs: f64,
    /// How long the person holds, seconds.
    pub hold_secs: f64,
    /// Length of the plateau that means are of, seconds; shorter where a hold is.
    pub plateau_secs: f64,
    /// Rest of a hand from the end of its hold to its next trial, seconds; the other hand may grip meanwhile.
    pub rest_secs: f64,
    /// Whether the zero is taken again by itself before each trial, where nobody holds the handle: it drifts between trials.
    pub zero_before_trials: bool,
    /// The force to hold, from and to, newtons; without it as strongly as possible.
    pub target_newtons: Option<[f64; 2]>,
    /// What counts of a hand's trials.
    pub result: Counts,
}

/// Which hand.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[allow(clippy::exhaustive_enums, reason = "people have two")]
pub enum Hand {
    /// The right one.
    Right,
    /// The left one.
    Left,
}

/// What counts of several trials.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[allow(clippy::exhaustive_enums, reason = "the two that are in use")]
pub enum Counts {
    /// The mean of their largest forces.
    Mean,
    /// The largest of them.
    Best,
}

/// One trial of a protocol.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Planned {
    /// The hand that grips.
    pub hand: Hand,
    /// Which of its trials, from 1.
    pub number: usize,
}

impl Hand {
    /// In one word.
    pub fn word(self) -> &'static str {
        match self {
            Self::Right => "right",
            Self::Left => "left",
        }
    }

    /// The same for viewers.
    pub(super) fn shown(self) -> GripHand {
        match self {
            Self::Right => GripHand::Right,
            Self::Left => GripHand::Left,
        }
    }
}

impl Default for Protocol {
    /// Three trials a hand, right and left in turn, 8 s as strongly as possible with a plateau of 5 s, a minute of rest for each hand. Where each
    /// of these comes from stands in docs/grip.md.
    fn default() -> Self {
        Self {
            name: "maximal grip".to_owned(),
            posture: "Seated, feet on the floor, shoulder at the side, elbow at 90°, forearm and wrist straight".to_owned(),
            hands: vec![Hand::Right, Hand::Left],
            trials: 3,
            alternating: true,
            countdown_secs: 3.0,
            hold_secs: 8.0,
            plateau_secs: 5.0,
            rest_secs: 60.0,
            zero_before_trials: true,
            target_newtons: None,
            result: Counts::Mean,
        }
    }
}

impl Protocol {
    /// Reads and checks a file.
    ///
    /// # Errors
    /// A file that cannot be read, is no TOML, has another key, or asks for what cannot be done.
    pub fn of_file(file: &Path) -> Result<Self, Error> {
        let text = text_file::read(file, "a protocol", MAX)?;
        Self::from_toml(&text).map_err(|what| Error::Request {
            what: format!("{}: {what}", file.display()),
            hint: "docs/grip.md has every key of a protocol; those left out are as usual",
        })
    }

    /// Of a text.
    ///
    /// # Errors
    /// What is wrong with it, in words.
    pub fn from_toml(text: &str) -> Result<Self, String> {
        let protocol: Self = toml::from_str(text).map_err(|error| error.to_string())?;
        protocol.check()?;
        Ok(protocol)
    }

    /// What of it cannot be done, in words.
    fn check(&self) -> Result<(), String> {
        for (key, value, range) in [
            ("hold_secs", self.hold_secs, HOLD_SECS),
            ("rest_secs", self.rest_secs, REST_SECS),
            ("countdown_secs", self.countdown_secs, COUNTDOWN_SECS),
            ("plateau_secs", self.plateau_secs, 0.2..=self.hold_secs),
        ] {
            if !range.contains(&value) {
                let (low, high) = (range.start(), range.end());
                return Err(format!("{key} is {value}, expected {low} to {high}"));
            }
        }
        if !TRIALS.contains(&self.trials) {
            let (found, low, high) = (self.trials, TRIALS.start(), TRIALS.end());
            return Err(format!("trials is {found}, expected {low} to {high}"));
        }
        let twice = self.hands.len() == 2 && self.hands[0] == self.hands[1];
        if self.hands.is_empty() || self.hands.len() > 2 || twice {
            return Err(
                "hands names each hand once: [\"right\", \"left\"], or one of them".to_owned(),
            );
        }
        if let Some([low, high]) = self.target_newtons
            && !(TARGET_NEWTONS.contains(&low) && TARGET_NEWTONS.contains(&high) && low < high)
        {
            return Err(format!(
                "target_newtons is [{low}, {high}], expected from and to, {} to {} N",
                TARGET_NEWTONS.start(),
                TARGET_NEWTONS.end()
            ));
        }
        for (key, text) in [("name", &self.name), ("posture", &self.posture)] {
            let length = text.chars().count();
            if length > MAX_TEXT {
                return Err(format!("{key} has {length} characters, at most {MAX_TEXT}"));
            }
        }
        Ok(())
    }

    /// Its trials in order.
    pub fn plan(&self) -> Vec<Planned> {
        let numbers = 1..=self.trials;
        if self.alternating {
            let of_number = |number| self.hands.iter().map(move |&hand| Planned { hand, number });
            numbers.flat_map(of_number).collect()
        } else {
            let of_hand =
                |&hand: &Hand| numbers.clone().map(move |number| Planned { hand, number });
            self.hands.iter().flat_map(of_hand).collect()
        }
    }

    /// For viewers; `force`: what is measured, in words.
    pub(super) fn shown(&self, force: &str) -> GripProtocol {
        let mut shown = GripProtocol::default();
        shown.name.clone_from(&self.name);
        shown.posture.clone_from(&self.posture);
        shown.hold_secs = self.hold_secs;
        shown.rest_secs = self.rest_secs;
        shown.target_newtons = self.target_newtons;
        shown.force = force.to_owned();
        shown
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hands_take_turns_or_follow_each_other() {
        let words = |protocol: &Protocol| -> Vec<String> {
            let plan = protocol.plan();
            plan.iter()
                .map(|p| format!("{}{}", p.hand.word(), p.number))
                .collect()
        };
        let usual = Protocol::default();
        assert_eq!(
            words(&usual),
            ["right1", "left1", "right2", "left2", "right3", "left3"]
        );
        let text = "hands = [\"left\", \"right\"]\ntrials = 2\nalternating = false";
        let other = Protocol::from_toml(text).unwrap();
        assert_eq!(words(&other), ["left1", "left2", "right1", "right2"]);
        assert_eq!(other.hold_secs, usual.hold_secs);
        assert_eq!(Protocol::from_toml("").unwrap(), usual);
    }

    #[test]
    fn what_cannot_be_asked_is_said_with_both_numbers() {
        for (text, says) in [
            ("hold_secs = 0.5", "hold_secs is 0.5, expected 1 to 120"),
            ("plateau_secs = 9", "plateau_secs is 9, expected 0.2 to 8"),
            ("trials = 0", "trials is 0, expected 1 to 20"),
            ("hands = []", "each hand once"),
            ("hands = [\"left\", \"left\"]", "each hand once"),
            ("hands = [\"foot\"]", "unknown variant"),
            ("target_newtons = [200, 100]", "[200, 100]"),
            ("rest_secs = nan", "rest_secs is NaN"),
            ("hold = 8", "unknown field `hold`"),
        ] {
            let why = Protocol::from_toml(text).unwrap_err();
            assert!(why.contains(says), "{text}: {why}");
        }
    }
}
