//! What a check found, for people and for programs.

use std::fmt;

use serde::Serialize;

use crate::calibrate::with_error;
use crate::sensor::Verdict;

/// The finest error of an offset that is told in words, grams.
const LEAST_OFFSET_G: f64 = 1e-3;

/// How many known loads stated 95 % intervals hold.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Intervals {
    /// Loads inside their interval.
    pub inside: usize,
    /// Loads compared.
    pub presses: usize,
    /// Whether so many outside are no rarer than one time in a hundred.
    pub hold: bool,
}

/// A press that the others contradict.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Contradiction {
    /// Index into [`super::CheckData::presses`].
    pub press: usize,
    /// What its label says, grams.
    pub load_g: f64,
    /// What is read with the day's scale, grams.
    pub reads_g: f64,
}

/// What a few known loads tell of a calibrated sensor.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct CheckReport {
    /// Whether it still is what it was.
    pub verdict: Verdict,
    /// Why the verdict is not better.
    pub reasons: Vec<String>,
    /// What loads are read as over what they are; none where no load tells it.
    pub scale: Option<f64>,
    /// Its standard error, a pure number.
    pub scale_standard_error: Option<f64>,
    /// What the film conducts over what it did at the calibration.
    pub conductance_scale: Option<f64>,
    /// How far the scale of a sensor that has not changed is from 1, 99 times in a hundred.
    pub scale_tolerance: Option<f64>,
    /// What unloaded taxels read, grams.
    pub offset_g: Option<f64>,
    /// Its standard error, grams; none of a single reading.
    pub offset_standard_error_g: Option<f64>,
    /// Presses of a known load that were compared.
    pub presses: usize,
    /// Those of them that stood alone, so that a press is the sum of 3 × 3 taxels.
    pub summed: usize,
    /// Known totals that were compared.
    pub totals: usize,
    /// Intervals of the calibration as it is; none where the sensor file states none.
    pub intervals: Option<Intervals>,
    /// Intervals with the day's scale.
    pub intervals_rescaled: Option<Intervals>,
    /// Presses that the others contradict.
    pub contradictions: Vec<Contradiction>,
    /// What could not be compared, and why.
    pub left_out: Vec<String>,
    /// What limits the check.
    pub notes: Vec<String>,
    /// Date of the calibration that was checked; empty where the sensor file has none.
    pub calibrated: String,
}

impl Intervals {
    fn words(&self) -> String {
        let word = if self.hold { "hold" } else { "do not hold" };
        format!("{} of {} inside: {word}", self.inside, self.presses)
    }
}

impl fmt::Display for CheckReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "verdict      {}", self.verdict.word())?;
        for reason in &self.reasons {
            writeln!(f, "             {reason}")?;
        }
        if let Some(scale) = self.scale {
            let (value, error) = with_error(scale, self.scale_standard_error);
            let error = error.map_or("error not told".to_owned(), |error| format!("± {error}"));
            write!(
                f,
                "scale        {value} {error}: what loads read is divided by"
            )?;
            match self.scale_tolerance {
                Some(within) => {
                    let (_, within) = with_error(1.0, Some(within));
                    writeln!(f, "; unchanged is 1 ± {}", within.unwrap_or_default())?;
                }
                None => writeln!(f)?,
            }
        }
        if let Some(conductance) = self.conductance_scale {
            let (value, _) = with_error(conductance, self.scale_standard_error);
            writeln!(f, "conductance  {value} times that of the calibration")?;
        }
        if let Some(offset) = self.offset_g {
            // Frames that are all alike scatter by nothing; a thousandth of a gram is nobody's business.
            let error = self.offset_standard_error_g.map(|e| e.max(LEAST_OFFSET_G));
            let (value, error) = with_error(offset, error);
            let error = error.map_or(String::new(), |error| format!(" ± {error}"));
            writeln!(f, "offset       {value}{error} g on a taxel without load")?;
        }
        if let Some(intervals) = &self.intervals {
            writeln!(f, "intervals    {}, as calibrated", intervals.words())?;
        }
        if let Some(intervals) = &self.intervals_rescaled {
            writeln!(f, "             {}, rescaled", intervals.words())?;
        }
        writeln!(
            f,
            "compared     {} presses ({} of them as the sum of 3 x 3 taxels), {} totals",
            self.presses, self.summed, self.totals
        )?;
        if !self.calibrated.is_empty() {
            writeln!(f, "calibrated   {}", self.calibrated)?;
        }
        for text in &self.left_out {
            writeln!(f, "left out: {text}")?;
        }
        for note in &self.notes {
            writeln!(f, "note: {note}")?;
        }
        Ok(())
    }
}
