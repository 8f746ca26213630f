//! What the server tells a viewer in words: one type a message. The page has the same types in
//! `web-types/messages.d.ts`; `testdata/messages.js` holds one of each, written from here and checked there.
//!
//! On the wire each is a JSON object whose `kind` says which it is.

mod calibration;
mod grip;
mod hello;
mod state;

pub use calibration::{
    AskedPress, CalibrationPhase, CalibrationSession, HeldOutError, SeenPress, TakenPress,
};
pub use grip::{GripHand, GripMeasured, GripPhase, GripProtocol, GripSession, GripTrial};
pub use hello::{
    ExportedFacts, FileFacts, HandleFacts, Hello, MarkMeaning, RegionFacts, RegionWindow,
    SensorFacts, Severity, Slider, SliderKind, SourceFacts, SourceKind, mark_meanings,
};
pub use state::{
    BadLines, DeviceState, DeviceStatus, Latency, Player, RecordingStatus, State, TareStatus,
};

use serde::Serialize;

/// Version of the messages, in [`Hello`]: a page of another version says that it must be loaded again.
pub const PROTOCOL: u32 = 3;

/// Every message that the server writes as text.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Message {
    /// What a viewer must know first.
    Hello(Box<Hello>),
    /// How things stand.
    State(Box<State>),
    /// Something happened.
    Event(Event),
    /// What a viewer watches.
    Details(Details),
    /// The whole of a recording.
    Curve(Curve),
    /// What became of a request.
    Answer(Answer),
}

impl Message {
    /// The message as it goes over the wire. A number that is not finite is `null` there.
    pub fn to_json(&self) -> String {
        serde_json::to_string(self).expect("plain data is JSON")
    }
}

/// Something that happened, for the time line.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Event {
    /// When, seconds since 1970.
    pub host_secs: f64,
    /// What, in words.
    pub text: String,
}

impl Event {
    /// What happened, and when, in seconds since 1970.
    pub fn new(host_secs: f64, text: impl Into<String>) -> Self {
        let text = text.into();
        Self { host_secs, text }
    }
}

/// What the whole of a recording looks like, before any of it was played. Columns are of one length; a number that is not finite is of a
/// frame without an answer.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
#[non_exhaustive]
pub struct Curve {
    /// How its loads were found.
    pub method: String,
    /// Since its first frame, s.
    pub secs: Vec<f64>,
    /// Sum of all loads that count, newtons.
    pub total_newtons: Vec<f32>,
    /// Highest pressure, kPa.
    pub peak_kilopascals: Vec<f32>,
    /// Contact area, mm².
    pub contact_area_mm2: Vec<f32>,
}

/// What a viewer watches.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
#[non_exhaustive]
pub struct Details {
    /// One each; a taxel of which nothing is known yet is left out.
    pub taxels: Vec<TaxelDetails>,
    /// The frame as a whole; `None` where nobody asked, nothing is known yet, or frames are no loads.
    pub figures: Option<FigureDetails>,
}

impl Details {
    /// Details of these taxels.
    pub fn new(taxels: Vec<TaxelDetails>) -> Self {
        Self {
            taxels,
            figures: None,
        }
    }
}

/// What the figures of one frame are uncertain by. Each figure comes with it: a viewer that shows a frame of another load has
/// no use for this.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
#[non_exhaustive]
pub struct FigureDetails {
    /// The frame's number.
    pub sequence: u64,
    /// Sum of all loads that count, newtons.
    pub total_newtons: f64,
    /// Half the width of its 95 % interval; `None` where nothing bounds it.
    pub total_half_width_95_newtons: Option<f64>,
    /// Contact area, mm².
    pub contact_area_mm2: f64,
    /// Half the width of its 95 % interval; `None` where nothing bounds it.
    pub contact_area_half_width_95_mm2: Option<f64>,
    /// Whether those are of the noise alone: the sensor file has no `[uncertainty]`.
    pub noise_only: bool,
    /// Why nothing bounds them, in words for the viewer; empty where something does.
    pub why_unbounded: String,
}

/// One taxel, all of one frame.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
#[non_exhaustive]
pub struct TaxelDetails {
    /// Sensed line, from 0.
    pub row: usize,
    /// Driven line, from 0.
    pub column: usize,
    /// The frame's number.
    pub sequence: u64,
    /// Load with the cross-talk removed, newtons; siemens without a load law.
    pub load: f32,
    /// Load by the load law on the reading as it is, newtons; siemens without a load law.
    pub raw: f32,
    /// Reading.
    pub counts: u16,
    /// Code of the mark.
    pub mark: u8,
    /// Conductance with the cross-talk removed, siemens; `None` where loads are estimated without one.
    pub siemens: Option<f64>,
    /// Half the width of the 95 % interval of `load`, newtons; `None` where it means nothing.
    pub half_width_95_newtons: Option<f64>,
    /// Whether that is of the noise alone: the sensor file has no `[uncertainty]`.
    pub noise_only: bool,
}

impl TaxelDetails {
    /// A taxel of which nothing but its place is known yet.
    pub fn at(row: usize, column: usize) -> Self {
        Self {
            row,
            column,
            ..Self::default()
        }
    }
}

/// What became of a request.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Answer {
    /// The request's `id`.
    pub to: u64,
    /// Whether it was done.
    pub ok: bool,
    /// What was done, or why not; empty where there is nothing to say.
    pub text: String,
}

impl Answer {
    pub(crate) fn new(to: u64, outcome: Result<Reply, Refused>) -> Self {
        let (ok, text) = match outcome {
            Ok(reply) => (true, reply.text),
            Err(refused) => (false, refused.reason),
        };
        Self { to, ok, text }
    }
}

/// A request was done.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct Reply {
    /// A sentence for the viewer; empty where the page says it all.
    pub text: String,
}

impl Reply {
    /// Done, with nothing to say.
    pub fn done() -> Self {
        Self::default()
    }

    /// Done, and this is to be said.
    pub fn saying(text: impl Into<String>) -> Self {
        Self { text: text.into() }
    }
}

/// A request was not done: why, in words for the viewer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Refused {
    reason: String,
}

impl Refused {
    /// Refused for this reason.
    pub fn because(reason: impl Into<String>) -> Self {
        Self {
            reason: reason.into(),
        }
    }
}

impl std::fmt::Display for Refused {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        out.write_str(&self.reason)
    }
}

impl std::error::Error for Refused {}

impl From<String> for Refused {
    fn from(reason: String) -> Self {
        Self { reason }
    }
}
