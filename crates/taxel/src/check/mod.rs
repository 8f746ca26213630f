//! Has it changed? A few known loads on the day of use against a calibrated sensor: its scale and offset since, whether
//! its stated intervals still hold, and a verdict.
//!
//! The scale is of conductances: temperature, humidity and wear change what the film conducts. Under a power law that is
//! a scale of loads as well, the two can't be told apart, and none needs to be chosen; with saturation or a bend the
//! conductance is what changes.

mod frames;
mod report;
mod scale;
mod verdict;

pub use report::{CheckReport, Contradiction, Intervals};

use crate::calibrate::PressLabel;
use crate::sensor::CheckSpec;
use crate::{Counts, Error, Frame, Sensor};
use frames::Measurement;

/// What there is to check with.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CheckData {
    /// The frames that presses point into.
    pub frames: Vec<Frame<Counts>>,
    /// Presses of known load; 0 for taxels that are known to carry nothing.
    pub presses: Vec<PressLabel>,
    /// Frames under one known load on the whole array, grams: a person, a plate.
    pub totals: Vec<(Vec<Frame<Counts>>, f64)>,
    /// What of it was left out before, in words.
    pub left_out: Vec<String>,
    /// Frames of the array with nothing on it.
    pub empty: Vec<Frame<Counts>>,
}

/// Compares what a sensor reads under known loads with them. A scale of an earlier check is left out first: the check is
/// always of the calibration. Every frame is read as the first after rest.
///
/// # Errors
/// No load law, or a switch resistance that is not known; presses outside the array; frames of another shape; nothing
/// to compare.
pub fn check(sensor: &Sensor, data: &CheckData) -> Result<CheckReport, Error> {
    let sensor = sensor.edited(|spec| spec.check = None)?;
    if data.presses.is_empty() && data.totals.is_empty() && data.empty.is_empty() {
        return Err(Error::NothingToCheck);
    }
    for press in &data.presses {
        let inside = press.row < sensor.rows() && press.column < sensor.columns();
        if !inside || press.frame >= data.frames.len() {
            return Err(Error::PressOutside {
                row: press.row,
                column: press.column,
                frame: press.frame,
                rows: sensor.rows(),
                columns: sensor.columns(),
                frames: data.frames.len(),
            });
        }
    }
    verdict::judge(&sensor, Measurement::new(&sensor, data)?)
}

/// The sensor with the day's scale in its file; `date` of the check, ISO 8601.
///
/// # Errors
/// A scale that no sensor file takes: 0.1 to 10; no scale at all.
pub fn checked(sensor: &Sensor, report: &CheckReport, date: &str) -> Result<Sensor, Error> {
    let (Some(scale), Some(conductance)) = (report.scale, report.conductance_scale) else {
        return Err(Error::NoScale);
    };
    sensor.edited(|spec| {
        spec.check = Some(CheckSpec {
            scale: digits(scale),
            conductance_scale: digits(conductance),
            scale_standard_error: digits(report.scale_standard_error.unwrap_or(0.0)),
            offset_g: report.offset_g.map(digits),
            presses: report.presses + report.totals,
            date: date.to_owned(),
            verdict: report.verdict,
            calibrated: report.calibrated.clone(),
        });
    })
}

/// Five digits: no check tells more.
fn digits(value: f64) -> f64 {
    format!("{value:.4e}").parse().unwrap_or(value)
}

#[cfg(test)]
mod tests;
