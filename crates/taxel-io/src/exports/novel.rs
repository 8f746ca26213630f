//! What pedar and pliance of novel begin with alike: lines of words, the unit, the time of a frame, and a line `time[secs]` with the
//! numbers of the sensors.

use super::cells::number_and_rest;
use super::header::Pairs;
use super::pad::Quantity;
use super::text_file::{TextFile, text_of};
use super::units::unit_of;
use crate::error::Error;

/// Lines before the numbers at most.
pub(super) const MAX_HEADER: u64 = 100;
/// Behind it stands the unit.
const UNIT: &str = "pressure values in";
/// Behind it stands the time from one frame to the next.
const STEP: &str = "time per frame[secs]:";
/// Behind it stands how long all frames took, and how many there were in a second.
const TOTAL: [&str; 2] = ["total time[secs]:", "total times[secs]:"];
const RATE: &str = "scanning rate[Hz]:";
/// Rate and time per frame are of one recording where their product is as near to 1: both are rounded.
const SAME_RATE: f64 = 0.01;
/// How far from a whole number the frames of a recording may come out by its length: times are rounded to milliseconds.
const NEAR_WHOLE: f64 = 0.1;
/// What the line begins with that names the sensors, as [`as_usual`] spells it.
pub(super) const SENSORS: &str = "time[secs]";

/// A line of a header, its units spelled as most versions do: `Time [s]` is `time[secs]`.
pub(super) fn as_usual(line: &str) -> String {
    let mut line = line.trim().replace(" [", "[");
    for unit in ["[s]", "[sec]", "[seconds]"] {
        line = line.replace(unit, "[secs]");
    }
    // The line that names the sensors: in small letters.
    match line.get(..SENSORS.len()) {
        Some(first) if first.eq_ignore_ascii_case(SENSORS) => {
            format!("{SENSORS}{}", &line[SENSORS.len()..])
        }
        _ => line,
    }
}

/// Whether a line names the sensors.
pub(super) fn names_sensors(line: &[u8]) -> bool {
    // Every other line of a file begins with a number.
    let is_word = line
        .trim_ascii_start()
        .first()
        .is_some_and(u8::is_ascii_alphabetic);
    is_word && as_usual(&text_of(line)).starts_with(SENSORS)
}

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
    /// Of all frames, seconds.
    total_secs: Option<f64>,
    /// Frames in a second.
    rate: Option<f64>,
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
        let (mut total_secs, mut rate) = (None, None);
        let sensors = loop {
            if !text.advance()? || text.number() > MAX_HEADER {
                return Err(text.wrong(format, expected, hint));
            }
            let words = text.words();
            let (line, usual) = (words.trim(), as_usual(&words));
            if usual.starts_with(SENSORS) {
                break usual;
            }
            if let Some(said) = line.strip_prefix(UNIT) {
                pairs.add(&format!("{UNIT}:{said}"), &[':'], text.number());
            }
            let behind = |key: &str| {
                let (_, said) = usual.split_once(key)?;
                let (number, _) = number_and_rest(said)?;
                Some(number).filter(|number| *number > 0.0)
            };
            secs_per_frame = secs_per_frame.or(behind(STEP));
            total_secs = total_secs.or(TOTAL.into_iter().find_map(behind));
            rate = rate.or(behind(RATE));
            lines.push(line.to_owned());
        };
        let (unit, quantity) = unit_of(text, format, &pairs, UNIT)?;
        Ok(Self {
            lines: lines.join("\n"),
            sensors,
            unit,
            quantity,
            secs_per_frame,
            total_secs,
            rate,
        })
    }

    /// How many frames it says there are, where they are numbered from its first step in time on; `None` where that is not sure.
    pub(super) fn frames(&self, first_secs: f64) -> Option<u64> {
        let step = self.secs_per_frame?;
        let rate = self
            .rate
            .filter(|rate| (rate * step - 1.0).abs() < SAME_RATE);
        let rate = rate.unwrap_or(1.0 / step);
        let frames = self.total_secs? * rate;
        let is_whole = (frames - frames.round()).abs() < NEAR_WHOLE;
        let begins = (first_secs * rate - 1.0).abs() < NEAR_WHOLE;
        (is_whole && begins).then(|| frames.round() as u64)
    }
}
