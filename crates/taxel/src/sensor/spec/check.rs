//! What a sensor file says of the last check: how much more or less it reads than when it was calibrated.

use serde::{Deserialize, Serialize};

/// Whether a calibrated sensor still is what it was.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Verdict {
    /// Within the errors that it states.
    Good,
    /// It reads more or less than it did; with the day's scale its intervals hold.
    Rescaled,
    /// No scale makes it what it was.
    Recalibrate,
}

impl Verdict {
    /// Its word, in files and reports.
    pub fn word(self) -> &'static str {
        match self {
            Verdict::Good => "good",
            Verdict::Rescaled => "rescaled",
            Verdict::Recalibrate => "recalibrate",
        }
    }
}

/// The day's scale: `material.factor` counts times `conductance_scale`, and the scale's standard error joins
/// `uncertainty.fit_share` in quadrature. The numbers of the calibration stay as they are.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct CheckSpec {
    /// What loads read by the calibration are divided by, a pure number: of the loads of the check.
    pub scale: f64,
    /// The same of conductances, a pure number: this is what is applied.
    pub conductance_scale: f64,
    /// Standard error of the scale, a pure number.
    pub scale_standard_error: f64,
    /// What unloaded taxels read, grams; told and not applied.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub offset_g: Option<f64>,
    /// Presses and totals that told the scale.
    pub presses: usize,
    /// Date of the check, ISO 8601.
    #[serde(default)]
    pub date: String,
    /// What the check came to.
    pub verdict: Verdict,
    /// Date of the calibration that was checked, ISO 8601.
    #[serde(default)]
    pub calibrated: String,
}
