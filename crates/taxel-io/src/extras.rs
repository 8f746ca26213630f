//! What a recording holds beside its frames: what happened, what was tared, what was lost.

use std::time::SystemTime;

use serde::Serialize;

/// Something that happened during a recording.
#[derive(Debug, Clone, PartialEq)]
pub struct Event {
    /// When, by the host's clock.
    pub at: SystemTime,
    /// Seconds since the recording's first frame, by the same clock; negative before it.
    pub secs: f64,
    /// `tare`, `mark`, `device`.
    pub kind: String,
    /// What, in words.
    pub text: String,
}

/// What each taxel shows without load, taken off from a frame on; or that nothing is taken off any more.
#[derive(Debug, Clone, PartialEq)]
pub struct Tare {
    /// The device's number of the first frame that it applies to.
    pub from_sequence: u64,
    /// When it was taken, by the host's clock.
    pub at: SystemTime,
    /// Unit of the numbers: `N`, or `S` where the sensor has no load law.
    pub unit: String,
    /// What is taken off the compensated numbers, a taxel each, row by row; empty: nothing any more.
    pub loads: Vec<f64>,
    /// What is taken off the numbers that are not compensated; empty where that is unknown.
    pub raw: Vec<f64>,
}

impl Tare {
    /// That nothing is taken off from that frame on.
    pub fn undone(from_sequence: u64, at: SystemTime) -> Self {
        Self {
            from_sequence,
            at,
            unit: "N".to_owned(),
            loads: Vec::new(),
            raw: Vec::new(),
        }
    }

    /// Whether it takes nothing off.
    pub fn is_undone(&self) -> bool {
        self.loads.is_empty()
    }
}

/// What was lost between the sensor and the file, counted while it was recorded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[non_exhaustive]
pub struct Losses {
    /// Frames that the device numbered and that never came.
    pub lost: u64,
    /// Packets or lines that came broken.
    pub corrupt: u64,
    /// Times that the device began to number its frames anew.
    pub restarts: u64,
    /// Times that the link was lost and found again.
    pub outages: u64,
    /// Lines or packets that were passed over, for they belonged to no frame.
    pub skipped: u64,
    /// Frames whose counts are in the file, but not the loads or figures that were asked for.
    pub left_out: u64,
    /// Packets of other senders than the one that is recorded.
    pub other_senders: u64,
}

impl Losses {
    /// Every count with its key in the file.
    pub fn counts(&self) -> [(&'static str, u64); 7] {
        [
            ("lost", self.lost),
            ("corrupt", self.corrupt),
            ("restarts", self.restarts),
            ("outages", self.outages),
            ("skipped", self.skipped),
            ("left_out", self.left_out),
            ("other_senders", self.other_senders),
        ]
    }

    /// Whether nothing was lost.
    pub fn is_none(&self) -> bool {
        self.counts().iter().all(|(_, count)| *count == 0)
    }

    /// What was lost, in words, one sentence a cause; empty where nothing was.
    pub fn words(&self) -> Vec<String> {
        let told = [
            (self.lost, "frame", "never came"),
            (self.corrupt, "packet or line", "came broken"),
            (self.restarts, "time", "the device began anew"),
            (self.outages, "time", "the link was lost"),
            (self.skipped, "line or packet", "belonged to no frame"),
            (self.left_out, "frame", "had no loads or figures in time"),
            (
                self.other_senders,
                "packet",
                "of other senders were left out",
            ),
        ];
        told.into_iter()
            .filter(|(count, _, _)| *count > 0)
            .map(|(count, what, how)| match count {
                1 => format!("1 {what} {}", how.replace(" were ", " was ")),
                _ => format!("{count} {} {how}", plural(what)),
            })
            .collect()
    }
}

fn plural(what: &str) -> String {
    let words: Vec<String> = what.split(" or ").map(|word| format!("{word}s")).collect();
    words.join(" or ")
}
