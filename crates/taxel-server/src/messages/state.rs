//! The message `state`: how things stand.

use std::collections::BTreeMap;

use serde::Serialize;

use super::{CalibrationSession, GripSession};

/// How things stand, twice a second and after every change.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
#[non_exhaustive]
pub struct State {
    /// The source.
    pub device: DeviceStatus,
    /// Frames a second of the source.
    pub frames_per_second: f64,
    /// Frames that have come.
    pub frames: u64,
    /// Frames that the device sent and that did not come.
    pub lost: u64,
    /// Frames that came broken.
    pub corrupt: u64,
    /// Frames that came twice.
    pub repeated: u64,
    /// Frames that came faster than they could be solved.
    pub skipped: u64,
    /// From a whole frame to its loads.
    pub latency_ms: Latency,
    /// Viewers that look.
    pub clients: usize,
    /// What is taken off.
    pub tare: TareStatus,
    /// The recording that goes on, or was ended by an error.
    pub recording: Option<RecordingStatus>,
    /// The method, by name.
    pub method: String,
    /// The file that is played, if it is one.
    pub player: Option<Player>,
    /// Where the sliders stand, by key; of a switch 0 or 1.
    pub sliders: BTreeMap<String, f64>,
    /// Lines that are dead or flicker.
    pub bad_lines: BadLines,
    /// The grip session, where there is one.
    pub grip: Option<Box<GripSession>>,
    /// The guided calibration, where there is one.
    pub calibration: Option<Box<CalibrationSession>>,
}

/// How it stands with the source.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize)]
#[non_exhaustive]
pub struct DeviceStatus {
    /// In one word.
    pub state: DeviceState,
    /// In a sentence.
    pub text: String,
}

impl DeviceStatus {
    /// A state, and a sentence about it.
    pub fn new(state: DeviceState, text: impl Into<String>) -> Self {
        let text = text.into();
        Self { state, text }
    }
}

/// How it stands with a source, in one word.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum DeviceState {
    /// Frames come.
    Live,
    /// It is there, but nothing has come for a while.
    #[default]
    Waiting,
    /// It is away and tried again.
    Lost,
    /// There will be no more.
    Ended,
    /// A file that is held.
    Paused,
}

/// Delays in milliseconds over the last frames.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
#[non_exhaustive]
pub struct Latency {
    /// Half of them are shorter.
    pub median: f64,
    /// 99 of 100 are shorter.
    pub p99: f64,
}

impl Latency {
    /// Both in milliseconds.
    pub fn new(median: f64, p99: f64) -> Self {
        Self { median, p99 }
    }
}

/// What is taken off.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
#[non_exhaustive]
pub struct TareStatus {
    /// Whether anything is.
    pub on: bool,
    /// Since when, seconds since 1970.
    pub host_secs: f64,
}

impl TareStatus {
    /// On or off, and since when, in seconds since 1970.
    pub fn new(on: bool, host_secs: f64) -> Self {
        Self { on, host_secs }
    }
}

/// A recording in progress, or ended by an error.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
#[non_exhaustive]
pub struct RecordingStatus {
    /// Its file.
    pub name: String,
    /// Frames in it.
    pub frames: u64,
    /// Its size.
    pub bytes: u64,
    /// How long it goes on.
    pub secs: f64,
    /// Why it has ended, where nobody ended it.
    pub error: Option<String>,
}

impl RecordingStatus {
    /// A recording of nothing yet, in this file.
    pub fn new(name: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            ..Self::default()
        }
    }
}

/// A file being played.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
#[non_exhaustive]
pub struct Player {
    /// Not held.
    pub playing: bool,
    /// 1: as recorded.
    pub speed: f64,
    /// Where it is, s from its beginning.
    pub position_secs: f64,
    /// How long it is, s.
    pub duration_secs: f64,
    /// The frame at which it is, from 0.
    pub frame: u64,
    /// Frames in it.
    pub frames: u64,
}

impl Player {
    /// A file of so many frames, so long, held at its beginning.
    pub fn new(frames: u64, duration_secs: f64) -> Self {
        Self {
            speed: 1.0,
            frames,
            duration_secs,
            ..Self::default()
        }
    }
}

/// Lines that are dead or flicker, from 0.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize)]
#[non_exhaustive]
pub struct BadLines {
    /// Sensed lines.
    pub rows: Vec<usize>,
    /// Driven lines.
    pub columns: Vec<usize>,
    /// Sensed lines that may be dead: they read nothing beside loads. Nothing is marked for them.
    pub suspect_rows: Vec<usize>,
    /// Driven lines that may be.
    pub suspect_columns: Vec<usize>,
}

impl BadLines {
    /// These rows and columns.
    pub fn new(rows: Vec<usize>, columns: Vec<usize>) -> Self {
        Self {
            rows,
            columns,
            ..Self::default()
        }
    }

    /// The same, with lines that may be dead.
    #[must_use]
    pub fn with_suspects(self, rows: Vec<usize>, columns: Vec<usize>) -> Self {
        Self {
            suspect_rows: rows,
            suspect_columns: columns,
            ..self
        }
    }
}
