//! What a calibration found, with its errors.

use super::digits::with_error;
use super::told::Belief;
use serde::Serialize;
use std::fmt;

/// One number of a calibrated sensor: fitted, with its standard error, or held.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Parameter {
    /// Its key in sensor.toml.
    pub name: String,
    /// Its value (the mean, for one per line).
    pub value: f64,
    /// Its standard error, in the same unit; none for a number that was held.
    pub standard_error: Option<f64>,
    /// What held it, for a number that was not fitted.
    pub held: Option<String>,
    /// The unit.
    pub unit: String,
}

impl Parameter {
    /// A fitted number; one without any error was not free to move.
    pub(super) fn fitted(name: &str, value: f64, standard_error: f64, unit: &str) -> Self {
        if standard_error == 0.0 {
            return Self::held(name, value, "an end of its range", unit);
        }
        Self {
            name: name.to_owned(),
            value,
            standard_error: Some(standard_error),
            held: None,
            unit: unit.to_owned(),
        }
    }

    /// A number that was held.
    pub(super) fn held(name: &str, value: f64, by: &str, unit: &str) -> Self {
        Self {
            name: name.to_owned(),
            value,
            standard_error: None,
            held: Some(by.to_owned()),
            unit: unit.to_owned(),
        }
    }
}

impl fmt::Display for Parameter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (value, error) = with_error(self.value, self.standard_error);
        let unit = match self.unit.as_str() {
            "" => String::new(),
            unit => format!(" {unit}"),
        };
        match (&self.held, error) {
            (Some(by), _) => write!(f, "{} = {value}{unit} (held: {by})", self.name),
            (None, Some(error)) => write!(f, "{} = {value} ± {error}{unit}", self.name),
            (None, None) => write!(f, "{} = {value}{unit} (not told)", self.name),
        }
    }
}

/// Below this share of its label a press reads nothing.
const NOTHING: f64 = 0.02;

/// A label that the other presses contradict.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Suspect {
    /// Index into [`super::CalibrationData::presses`].
    pub press: usize,
    /// What its label says, grams.
    pub load_g: f64,
    /// What the others say, grams.
    pub says_g: f64,
    /// Whether the fit was made without it.
    pub left_out: bool,
}

impl Suspect {
    /// The unit that the label may be in, where the ratio is near a thousand.
    pub fn unit(&self) -> Option<&'static str> {
        let ratio = self.says_g / self.load_g;
        match ratio {
            _ if (500.0..2000.0).contains(&ratio) => Some("kg"),
            _ if (0.0005..0.002).contains(&ratio) => Some("mg"),
            _ if (70.0..150.0).contains(&ratio) => Some("N"),
            _ => None,
        }
    }
}

impl fmt::Display for Suspect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let grams = |value: f64| match value {
            _ if value >= 100.0 => format!("{value:.0}"),
            _ if value >= 1.0 => format!("{value:.1}"),
            _ => format!("{value:.3}"),
        };
        let (label, says) = (grams(self.load_g), grams(self.says_g));
        write!(f, "{label} g where the other presses say {says} g")?;
        match self.unit() {
            Some(unit) => write!(f, "; are these {unit}?")?,
            None if self.says_g < NOTHING * self.load_g => {
                write!(f, ": is the taxel dead, or was it missed?")?;
            }
            None => write!(f, " ({:.2} times)", self.says_g / self.load_g)?,
        }
        if self.left_out {
            write!(f, " (left out of the fit)")
        } else {
            Ok(())
        }
    }
}

/// Quality of a fit. Errors are of held-out presses: of presses that neither fitted nor chose what judges them.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct CalibrationReport {
    /// Fitted numbers, and those that were held.
    pub parameters: Vec<Parameter>,
    /// What was looked for beyond the circuit.
    pub findings: Vec<EffectFinding>,
    /// What was believed of each number before, and what told it.
    pub beliefs: Vec<Belief>,
    /// What the user should know before trusting the fit.
    pub warnings: Vec<String>,
    /// Reasons not to use the fit as it is; none for a good one.
    pub doubts: Vec<String>,
    /// Presses used.
    pub presses: usize,
    /// Presses left out (unreadable, on faulty lines), with the reason.
    pub left_out: Vec<String>,
    /// Labels that the other presses contradict.
    pub suspects: Vec<Suspect>,
    /// How presses were held out.
    pub held_out: String,
    /// Held-out presses that judged, and those that could not be.
    pub held_out_presses: usize,
    /// Held-out presses whose fit failed, or whose frame then had no solution.
    pub held_out_unjudged: usize,
    /// Mean absolute error of held-out presses, grams; none where no fit could be made without them.
    pub held_out_mean_absolute_g: Option<f64>,
    /// Standard error of that mean over presses, grams.
    pub held_out_standard_error_g: f64,
    /// 95th percentile of the absolute error of held-out presses, grams.
    pub held_out_p95_g: f64,
    /// Law and held-out mean absolute error, grams, of each law tried.
    pub laws: Vec<(String, f64)>,
    /// The law chosen.
    pub law: String,
}

/// Something beyond the circuit that was looked for.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EffectFinding {
    /// What was looked for.
    pub name: String,
    /// Whether it is in the fitted sensor.
    pub used: bool,
    /// What was found, with its size and unit.
    pub text: String,
}

impl CalibrationReport {
    /// Numbers with their errors, one a line.
    pub fn table(parameters: &[Parameter]) -> String {
        let mut text = format!(
            "{:<28} {:>14}   {:<14} unit\n",
            "fitted", "value", "std. error"
        );
        for p in parameters {
            let (value, error) = with_error(p.value, p.standard_error);
            let error = match (&p.held, error) {
                (Some(by), _) => format!("held: {by}"),
                (None, Some(error)) => format!("± {error}"),
                (None, None) => "not told".to_owned(),
            };
            let line = format!("{:<28} {value:>14}   {error:<14} {}", p.name, p.unit);
            text += line.trim_end();
            text.push('\n');
        }
        text
    }
}

impl fmt::Display for CalibrationReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", Self::table(&self.parameters))?;
        match self.held_out_mean_absolute_g {
            Some(mean) => writeln!(
                f,
                "\nheld-out presses ({} of {} presses; {}): {mean:.3} ± {:.3} g mean absolute error, {:.3} g at the 95th percentile",
                self.held_out_presses,
                self.presses,
                self.held_out,
                self.held_out_standard_error_g,
                self.held_out_p95_g
            )?,
            None => writeln!(f, "\nheld-out presses: no fit could be made without them")?,
        }
        if self.held_out_unjudged > 0 {
            writeln!(
                f,
                "{} held-out presses could not be judged",
                self.held_out_unjudged
            )?;
        }
        for (law, error) in &self.laws {
            let chosen = if *law == self.law { "  <- chosen" } else { "" };
            writeln!(f, "  law {law:<12} {error:>9.3} g held out{chosen}")?;
        }
        for finding in &self.findings {
            let used = if finding.used { "used" } else { "not used" };
            writeln!(f, "{:<22} {used:<9} {}", finding.name, finding.text)?;
        }
        if !self.beliefs.is_empty() {
            writeln!(
                f,
                "\n{:<34} {:<24} {:<18} told by",
                "number", "believed before", "now"
            )?;
            for belief in &self.beliefs {
                writeln!(f, "{belief}")?;
            }
            writeln!(f)?;
        }
        for text in &self.left_out {
            writeln!(f, "left out: {text}")?;
        }
        for warning in self.warnings.iter().chain(&self.doubts) {
            writeln!(f, "warning: {warning}")?;
        }
        Ok(())
    }
}
