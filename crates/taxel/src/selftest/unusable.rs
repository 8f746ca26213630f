//! Recordings that cannot be tested.

use crate::Error;

const FEW: &str = "record for a few seconds; a hand needs longer to reach every taxel";
const LOADED: &str =
    "are the two recordings swapped? take everything off the array while the empty one is made";
const IDLE: &str = "rub a hand over the whole array while it is recorded, and check that counts grow with the load";
const SHAPE: &str = "both recordings must be of the sensor whose file is given";

/// Recordings that cannot be tested.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Unusable {
    /// Too few frames to tell a fault from chance.
    #[error(
        "the {recording} recording has {found} frames, but the self-test takes {needed}\nhint: {FEW}"
    )]
    TooFewFrames {
        /// `empty` or `rubbed`.
        recording: &'static str,
        /// Frames there are.
        found: u64,
        /// Fewest that will do.
        needed: u64,
    },
    /// Something lay on the array in the recording that should be empty.
    #[error(
        "the empty recording has a load: {empty_percent:.1} % of its readings move as under a load, {rubbed_percent:.1} % of those of the rubbed one, and {below_percent:.1} % of the rubbed one lie far below it\nhint: {LOADED}"
    )]
    LoadInEmpty {
        /// Share of the empty recording's readings that are far from their taxel's median, percent.
        empty_percent: f64,
        /// The same of the rubbed recording, from the empty one's medians, percent.
        rubbed_percent: f64,
        /// Share of the rubbed recording's readings far below the empty one's medians, percent.
        below_percent: f64,
    },
    /// Nothing pressed on the array in the recording that should be rubbed.
    #[error(
        "the rubbed recording has no load: none of its {readings} readings rises {counts:.0} counts above the empty one\nhint: {IDLE}"
    )]
    NoLoadInRubbed {
        /// Readings of the recording.
        readings: u64,
        /// The rise that would be a load (median over the taxels), counts.
        counts: f64,
    },
    /// A frame of another shape.
    #[error(transparent)]
    Frame(#[from] Error),
}

impl Unusable {
    /// What to do, as it stands behind `hint:`.
    pub fn hint(&self) -> &'static str {
        match self {
            Unusable::TooFewFrames { .. } => FEW,
            Unusable::LoadInEmpty { .. } => LOADED,
            Unusable::NoLoadInRubbed { .. } => IDLE,
            Unusable::Frame(_) => SHAPE,
        }
    }
}
