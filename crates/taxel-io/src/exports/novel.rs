//! What pedar and pliance of novel begin with alike: lines of words, the unit, the time of a frame, and a line `time[secs]` with the
//! numbers of the sensors.

use super::cells::number_and_rest;
use super::header::Pairs;
use super::pad::Quantity;
use super::text_file::TextFile;
use super::units::unit_of;
use crate::error::Error;

/// Lines before the numbers at most.
pub(super) const MAX_HEADER: u64 = 100;
/// Behind it stands the unit.
const UNIT: &str = "pressure values in";
/// Behind it stands the time from one frame to the next.
const STEP: &str = "time per frame [secs]:";
/// What the line begins with that names the sensors.
pub(super) const SENSORS: &str = "time[secs]";

/// A header.
pub(super) struct NovelHeader {
    /// Its lines.
    pub(super) lines: String,
    /// The line that names the sensors.
    pub(super) sensors: String,
    /// Of the pressures.
    pub(super) unit: String,
    /// The same, understood.
    pub(super) quantity: Quantity,
    /// From one frame to the next, seconds.
    pub(super) secs_per_frame: Option<f64>,
}

impl NovelHeader {
    /// Reads it, up to the line that names the sensors, which is `expected`; the `hint` says in which order.
    pub(super) fn read(
        text: &mut TextFile,
        format: &'static str,
        expected: &str,
        hint: &'static str,
    ) -> Result<Self, Error> {
        let mut lines = Vec::new();
        let (mut pairs, mut secs_per_frame) = (Pairs::default(), None);
        let sensors = loop {
            if !text.advance()? || text.place(0).line > MAX_HEADER {
                return Err(text.wrong(format, expected, hint));
            }
            let words = text.words();
            let line = words.trim();
            if line.starts_with(SENSORS) {
                break line.to_owned();
            }
            if let Some(said) = line.strip_prefix(UNIT) {
                pairs.add(&format!("{UNIT}:{said}"), &[':'], text.place(0).line);
            }
            if let Some((_, said)) = line.split_once(STEP) {
                secs_per_frame = number_and_rest(said)
                    .map(|(secs, _)| secs)
                    .filter(|secs| *secs > 0.0);
            }
            lines.push(line.to_owned());
        };
        let (unit, quantity) = unit_of(text, format, &pairs, UNIT)?;
        Ok(Self {
            lines: lines.join("\n"),
            sensors,
            unit,
            quantity,
            secs_per_frame,
        })
    }
}
