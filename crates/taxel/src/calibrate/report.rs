//! What a calibration found, with its errors.

use serde::Serialize;
use std::fmt;

/// One fitted number.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Parameter {
    /// Its key in sensor.toml.
    pub name: String,
    /// Its value (the mean, for one per line).
    pub value: f64,
    /// Its standard error, in the same unit.
    pub standard_error: f64,
    /// The unit.
    pub unit: String,
}

/// Something beyond the circuit that was looked for.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Finding {
    /// What was looked for.
    pub name: String,
    /// Whether it is in the fitted sensor.
    pub used: bool,
    /// What was found, with its size and unit.
    pub text: String,
}

/// Quality of a fit. No frame is judged by a fit that saw it: errors are of held-out presses.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Report {
    /// Fitted numbers.
    pub parameters: Vec<Parameter>,
    /// What was looked for beyond the circuit.
    pub findings: Vec<Finding>,
    /// What the user should know before trusting the fit.
    pub warnings: Vec<String>,
    /// Presses used.
    pub presses: usize,
    /// Presses left out (unreadable, on faulty lines), with the reason.
    pub left_out: Vec<String>,
    /// Folds of the cross-validation.
    pub folds: usize,
    /// Mean absolute error of held-out presses, grams.
    pub held_out_mean_absolute_g: f64,
    /// Standard error of that mean over presses, grams.
    pub held_out_standard_error_g: f64,
    /// 95th percentile of the absolute error of held-out presses, grams.
    pub held_out_p95_g: f64,
    /// Law and held-out mean absolute error, grams, of each law tried.
    pub laws: Vec<(String, f64)>,
    /// The law chosen.
    pub law: String,
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{:<34} {:>14}  {:>12}", "fitted", "value", "std. error")?;
        for p in &self.parameters {
            writeln!(
                f,
                "{:<34} {:>14.6e}  {:>12.2e} {}",
                p.name, p.value, p.standard_error, p.unit
            )?;
        }
        writeln!(
            f,
            "\nheld-out presses ({} presses, {} folds, split by press): {:.3} ± {:.3} g mean absolute error, {:.3} g at the 95th percentile",
            self.presses,
            self.folds,
            self.held_out_mean_absolute_g,
            self.held_out_standard_error_g,
            self.held_out_p95_g
        )?;
        for (law, error) in &self.laws {
            let chosen = if *law == self.law { "  <- chosen" } else { "" };
            writeln!(f, "  law {law:<12} {error:>9.3} g held out{chosen}")?;
        }
        for finding in &self.findings {
            let used = if finding.used { "used" } else { "not used" };
            writeln!(f, "{:<22} {used:<9} {}", finding.name, finding.text)?;
        }
        for text in &self.left_out {
            writeln!(f, "left out: {text}")?;
        }
        for warning in &self.warnings {
            writeln!(f, "warning: {warning}")?;
        }
        Ok(())
    }
}
