//! What happened beside the frames.

use std::time::SystemTime;

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

/// Nanoseconds since 1970.
pub(crate) fn nanos(at: std::time::SystemTime) -> u64 {
    at.duration_since(std::time::SystemTime::UNIX_EPOCH)
        .map_or(0, |since| {
            u64::try_from(since.as_nanos()).unwrap_or(u64::MAX)
        })
}
