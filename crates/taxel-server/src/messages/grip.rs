//! How a grip session stands, as part of the message `state`.

use serde::{Deserialize, Serialize};

/// A grip session: one person, one operator, trial after trial.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
#[non_exhaustive]
pub struct GripSession {
    /// What happens now.
    pub phase: GripPhase,
    /// Until this phase ends by itself, seconds; `None` where the operator ends it.
    pub remaining_secs: Option<f64>,
    /// How long the phase lasts in all, seconds.
    pub lasts_secs: Option<f64>,
    /// Pseudonymous id of the person; empty before the session begins.
    pub person: String,
    /// Where everything is kept, as the operator would find it.
    pub folder: String,
    /// The trial that is next or going on, by its place in `trials`.
    pub trial: Option<usize>,
    /// All trials of the protocol, in order.
    pub trials: Vec<GripTrial>,
    /// What was measured last, to be accepted or repeated.
    pub measured: Option<GripMeasured>,
    /// What the protocol asks for.
    pub protocol: GripProtocol,
    /// What makes the numbers doubtful, in words; empty where nothing does.
    pub warnings: Vec<String>,
    /// Why something did not work, in words; empty where all did.
    pub trouble: String,
    /// The session was found unfinished, and goes on.
    pub is_resumed: bool,
    /// Frames come from a simulated sensor.
    pub is_simulated: bool,
    /// Names of the files of the results, to be fetched from `/results/`; empty before the session has ended.
    pub files: Vec<String>,
}

/// What happens in a grip session.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum GripPhase {
    /// The person's id is not known yet.
    #[default]
    Setup,
    /// Nothing presses; the operator takes the zero.
    Zero,
    /// The operator starts the next trial.
    Ready,
    /// It begins in a moment.
    Countdown,
    /// The person grips.
    Hold,
    /// The trial is being measured.
    Measuring,
    /// The operator accepts the trial or repeats it.
    Review,
    /// The person rests.
    Rest,
    /// The results are being written.
    Finishing,
    /// The results are there.
    Done,
}

/// Which hand.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
#[allow(clippy::exhaustive_enums, reason = "people have two")]
pub enum GripHand {
    /// The left one.
    Left,
    /// The right one.
    Right,
}

/// One trial of the protocol.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct GripTrial {
    /// The hand that grips.
    pub hand: GripHand,
    /// Which of that hand's trials, from 1.
    pub number: usize,
    /// How often it was repeated.
    pub repeats: usize,
    /// What it came to, once it was accepted.
    pub accepted: Option<GripMeasured>,
}

impl GripTrial {
    /// A trial to come.
    pub fn planned(hand: GripHand, number: usize) -> Self {
        Self {
            hand,
            number,
            repeats: 0,
            accepted: None,
        }
    }
}

/// What a trial came to. Forces are those that the protocol speaks of: grip force on a handle, else the total.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[non_exhaustive]
pub struct GripMeasured {
    /// The largest force, newtons.
    pub max_newtons: f64,
    /// Mean over the plateau, newtons.
    pub plateau_newtons: Option<f64>,
    /// Coefficient of variation over the plateau, %.
    pub variation_percent: Option<f64>,
    /// Seconds from the beginning of the grip to the largest force.
    pub time_to_peak_secs: f64,
    /// The largest total normal force, newtons.
    pub total_newtons: f64,
    /// What makes this trial doubtful, in words.
    pub doubts: Vec<String>,
}

/// What a protocol asks for.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
#[non_exhaustive]
pub struct GripProtocol {
    /// Its name.
    pub name: String,
    /// How the person sits and holds the handle; may be empty.
    pub posture: String,
    /// Length of a hold, seconds.
    pub hold_secs: f64,
    /// Length of a rest, seconds.
    pub rest_secs: f64,
    /// The force to hold, from and to, newtons; `None`: as strongly as possible.
    pub target_newtons: Option<[f64; 2]>,
    /// What the force is: `grip force` or `total normal force`.
    pub force: String,
}
