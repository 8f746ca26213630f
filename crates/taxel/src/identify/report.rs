//! What was found out, for people and for programs.

use std::fmt;

use serde::Serialize;

use crate::calibrate::with_error;
use crate::sensor::Topology;

/// How far the frames tell the read-out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Verdict {
    /// One read-out explains the frames, the others do not.
    One,
    /// Several explain them, and give the same loads: whichever is taken.
    Alike,
    /// Several explain them, and give different loads.
    CannotTell,
    /// None explains them.
    None,
}

/// A number of a read-out that was fitted.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct NumberFound {
    /// What it is; symbols as in docs/theory.md.
    pub name: &'static str,
    /// Its value; none where the frames do not tell it.
    pub value: Option<f64>,
    /// Its standard error from noise alone.
    pub standard_error: Option<f64>,
    /// Its unit: ohms where the sensor file has the resistor, else the resistor itself; empty for a pure number.
    pub unit: String,
}

/// How one read-out fares.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Standing {
    /// The read-out.
    pub topology: Topology,
    /// Nats that telling the readings takes more than by the best.
    pub excess_nats: f64,
    /// The same with no reading counted for more than 50: a few that are far off decide nothing.
    pub counted_nats: f64,
    /// Standard error of the latter over readings.
    pub standard_error_nats: f64,
    /// Share of the readings that are more than 3.5 standard deviations off.
    pub missed_share: f64,
    /// Taxels that it takes for pressed, in all frames.
    pub pressed: usize,
    /// One of its numbers stands at the end of what it can be, as a switch of half the resistor that its line ends in.
    pub is_stretched: bool,
    /// It does not explain the frames.
    pub out: bool,
    /// Its likely numbers.
    pub numbers: Vec<NumberFound>,
}

/// How a read-out fares with uniform loads.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct UniformFinding {
    /// The read-out.
    pub topology: Topology,
    /// Whether any conductance gives such a mean reading.
    pub reaches: bool,
    /// How unlikely it is that lines scatter so little, nats; none where the mean reading cannot be.
    pub too_little_nats: Option<f64>,
    /// Scatter of the rows' means over the least that single taxels make it, of the typical frame.
    pub rows: Option<f64>,
    /// The same of the columns.
    pub columns: Option<f64>,
    /// It does not explain the frames.
    pub out: bool,
}

/// A measurement that decides between read-outs.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Measurement {
    /// What to measure.
    pub measure: &'static str,
    /// What each outcome says.
    pub means: Vec<&'static str>,
}

/// Which read-outs explain the frames.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Identification {
    /// In one word.
    pub verdict: Verdict,
    /// All read-outs, the likeliest first.
    pub standings: Vec<Standing>,
    /// Whether enough readings of taxels that are not pressed are left to contradict a read-out.
    pub is_tested: bool,
    /// How they fare with uniform loads; empty without any, in the order of `standings`.
    pub uniform: Vec<UniformFinding>,
    /// What decides between those that are left.
    pub measure: Vec<Measurement>,
    /// What the sensor file names.
    pub named: Option<Topology>,
    /// Frames looked at.
    pub frames: usize,
    /// Readings in them that say something.
    pub readings: usize,
    /// Standard deviation of a reading that was taken, rounding included, counts.
    pub noise_counts: f64,
}

impl Identification {
    /// The read-outs that explain the frames, the likeliest first.
    pub fn left(&self) -> impl Iterator<Item = &Standing> {
        self.standings.iter().filter(|standing| !standing.out)
    }

    fn headline(&self) -> String {
        let names: Vec<&str> = self.left().map(|s| s.topology.name()).collect();
        let names = names.join(", ");
        match self.verdict {
            Verdict::One => names,
            Verdict::Alike => format!("{names}: alike in these frames, with the same loads"),
            Verdict::CannotTell => format!("cannot tell: {names}"),
            Verdict::None => "none of the six read-outs".to_owned(),
        }
    }
}

impl fmt::Display for NumberFound {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(value) = self.value else {
            return write!(f, "{}: these frames do not tell it", self.name);
        };
        let (value, error) = with_error(value, self.standard_error);
        let error = error.map_or(String::new(), |error| format!(" ± {error}"));
        write!(f, "{}: {value}{error}", self.name)?;
        match self.unit.as_str() {
            "" => Ok(()),
            unit => write!(f, " {unit}"),
        }
    }
}

impl fmt::Display for Identification {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "read-out     {}", self.headline())?;
        if let Some(named) = self.named
            && !self.left().any(|standing| standing.topology == named)
        {
            writeln!(f, "             the sensor file says {}", named.name())?;
        }
        if !self.is_tested {
            writeln!(
                f,
                "             nearly every reading is of a pressed taxel: nothing is left that could contradict a read-out"
            )?;
        }
        writeln!(
            f,
            "looked at    {} frames, {} readings, noise {:.2} counts\n",
            self.frames, self.readings, self.noise_counts
        )?;
        writeln!(
            f,
            "{:<26}{:>12}{:>9}{:>9}",
            "", "nats more", "missed", "pressed"
        )?;
        for standing in &self.standings {
            let word = match standing {
                Standing { out: true, .. } => "  out",
                Standing {
                    is_stretched: true, ..
                } => "  by a number at the end of what it can be",
                _ => "",
            };
            writeln!(
                f,
                "{:<26}{:>12}{:>9}{:>9}{word}",
                standing.topology.name(),
                nats(standing.excess_nats),
                percent(standing.missed_share),
                standing.pressed
            )?;
        }
        self.write_uniform(f)?;
        for standing in self.left() {
            writeln!(f, "\nwith {}:", standing.topology.name())?;
            for number in &standing.numbers {
                writeln!(f, "  {number}")?;
            }
        }
        if !self.measure.is_empty() {
            writeln!(f, "\nto decide, measure:")?;
        }
        for measurement in &self.measure {
            writeln!(f, "  {}", measurement.measure)?;
            for means in &measurement.means {
                writeln!(f, "    {means}")?;
            }
        }
        Ok(())
    }
}

impl Identification {
    fn write_uniform(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.uniform.is_empty() {
            return Ok(());
        }
        writeln!(
            f,
            "\nuniform loads: scatter of lines, over the least that single taxels make it"
        )?;
        writeln!(f, "{:<26}{:>12}{:>9}", "", "rows", "columns")?;
        for finding in &self.uniform {
            let word = if finding.out { "  out" } else { "" };
            let name = finding.topology.name();
            let ratio =
                |ratio: Option<f64>| ratio.map_or("-".to_owned(), |ratio| format!("{ratio:.2}"));
            if finding.reaches {
                writeln!(
                    f,
                    "{name:<26}{:>12}{:>9}{word}",
                    ratio(finding.rows),
                    ratio(finding.columns)
                )?;
            } else {
                writeln!(f, "{name:<26}  no conductance reads so much{word}")?;
            }
        }
        Ok(())
    }
}

/// Differences beyond any doubt need no digits.
fn nats(value: f64) -> String {
    if value < 10_000.0 {
        format!("{value:.0}")
    } else {
        "> 10000".to_owned()
    }
}

fn percent(share: f64) -> String {
    match 100.0 * share {
        0.0 => "0 %".to_owned(),
        percent if percent < 0.1 => "< 0.1 %".to_owned(),
        percent if percent < 10.0 => format!("{percent:.1} %"),
        percent => format!("{percent:.0} %"),
    }
}
