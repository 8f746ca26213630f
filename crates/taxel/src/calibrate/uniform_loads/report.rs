//! What uniform loads alone told, in words.

use std::fmt;

use serde::Serialize;

use crate::calibrate::{CalibrationReport, Parameter};
use crate::material::LoadLaw;
use crate::stats::median;

/// Loads that are read worse than guessing them by this share tell that little was learnt.
const LITTLE: f64 = 0.5;
/// Switches that differ from the file's by more are none.
const MOST_SWITCHES: f64 = 0.6;
/// A gain below this share of the usual one is none; how many of them are named.
const DEAD: f64 = 0.2;
const MOST_NAMED: usize = 5;
/// A law so many times the one before is of another unit.
const OTHER: f64 = 5.0;
/// What is left of readings is more than noise from here on, times the noise.
const MORE_THAN_NOISE: f64 = 1.5;

/// A law that was tried, judged by loads that it was fitted without.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct UniformLaw {
    /// Its name.
    pub law: String,
    /// Root mean square of held-out readings less predicted ones, counts.
    pub held_out_counts: f64,
    /// Mean absolute error of held-out loads, taxel by taxel, grams.
    pub held_out_mean_absolute_g: Option<f64>,
}

/// How good a calibration by uniform loads alone is.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct UniformReport {
    /// Numbers of the law.
    pub parameters: Vec<Parameter>,
    /// Loads that were fitted, and the least and the largest above nothing, grams a taxel.
    pub levels: usize,
    /// Least load above nothing, grams a taxel.
    pub least_g: f64,
    /// Largest load, grams a taxel.
    pub most_g: f64,
    /// Laws that were tried.
    pub laws: Vec<UniformLaw>,
    /// The law chosen.
    pub law: String,
    /// Root mean square of what the fit leaves of readings, counts.
    pub left_counts: f64,
    /// Standard deviation of a reading by noise and rounding, counts.
    pub noise_counts: f64,
    /// Mean absolute error of held-out loads, taxel by taxel, grams.
    pub held_out_mean_absolute_g: Option<f64>,
    /// Root mean square error of held-out loads' mean over the array, a share of the load.
    pub held_out_array_share: Option<f64>,
    /// Held-out loads whose frame has no answer.
    pub held_out_unsolved: usize,
    /// Readings left out of the fit as faults: too far off to be of the load.
    pub left_out: usize,
    /// Standard deviation of ln gain over the taxels.
    pub gain_deviation: f64,
    /// Standard deviation of ln resistance of the switches from the file's; none where they were held.
    pub switch_deviation: Option<f64>,
    /// Reasons not to use the fit as it is.
    pub doubts: Vec<String>,
    /// What the user should know.
    pub warnings: Vec<String>,
}

impl UniformReport {
    /// How the errors were found.
    pub(super) fn cross_validation(&self) -> String {
        let chosen = if self.laws.len() > 1 {
            "; the law was chosen by the same loads"
        } else {
            ""
        };
        format!(
            "{} uniform loads, some held out in turn{chosen}",
            self.levels
        )
    }

    /// Names taxels that hardly answer to any load.
    pub(super) fn name_dead(&mut self, gains: &[f64], columns: usize) {
        let usual = median(gains.iter().copied()).unwrap_or(1.0);
        let dead = gains
            .iter()
            .enumerate()
            .filter(|(_, gain)| **gain < DEAD * usual);
        let names: Vec<String> = dead
            .map(|(taxel, gain)| {
                let share = 100.0 * gain / usual;
                format!(
                    "row {}, column {} ({share:.0} %)",
                    taxel / columns,
                    taxel % columns
                )
            })
            .collect();
        if !names.is_empty() {
            let more = names.len().saturating_sub(MOST_NAMED);
            let and = if more > 0 {
                format!(" and {more} more")
            } else {
                String::new()
            };
            self.doubts.push(format!(
                "taxels that hardly answer to any load, beside the usual gain: {}{and}; a dead one reads nothing, whatever its gain",
                names[..names.len().min(MOST_NAMED)].join(", ")
            ));
        }
    }

    /// Whether the law is far from the one that the sensor file had: another unit, most likely.
    pub(super) fn compare(&mut self, found: &LoadLaw, before: Option<&LoadLaw>) {
        let Some(before) = before else {
            return;
        };
        let load_g = (self.least_g * self.most_g).sqrt();
        let answers = |law: &LoadLaw| law.siemens_from_grams(0, load_g) - law.g_zero;
        let ratio = answers(found) / answers(before);
        if !(1.0 / OTHER..=OTHER).contains(&ratio) {
            self.doubts.push(format!(
                "at {load_g:.3} g taxels conduct {ratio:.3} times what the sensor file's law said: are the loads in grams on each taxel, and not in another unit, or on the whole array?"
            ));
        }
    }

    /// Says what speaks against the fit; `guessing_g`: how far off the median of all loads would be.
    pub(super) fn judge(&mut self, guessing_g: f64) {
        match self.held_out_mean_absolute_g {
            None => self.doubts.push(
                "no held-out load could be read, so that nothing says how good this fit is: check topology, v_test_volts and resistors".to_owned(),
            ),
            Some(error) if error > LITTLE * guessing_g => self.doubts.push(format!(
                "single taxels under held-out loads are {error:.3} g off on average, and guessing the median load would be {guessing_g:.3} g off: little was learnt of them"
            )),
            _ => {}
        }
        if self.left_counts > MORE_THAN_NOISE * self.noise_counts {
            self.warnings.push(format!(
                "readings are {:.1} counts off the fit, noise and rounding are {:.2}: the loads were not uniform, or the circuit is another",
                self.left_counts, self.noise_counts
            ));
        }
        if let Some(share) = self.switch_deviation.filter(|share| *share > MOST_SWITCHES) {
            self.doubts.push(format!(
                "switches come out {:.0} % from the file's, and switches of one kind differ by a few per cent: they stand for something else that is wrong with loads, circuit or file",
                100.0 * share
            ));
        }
        if self.held_out_unsolved > 0 {
            self.warnings.push(format!(
                "{} of {} held-out loads have no answer with this circuit",
                self.held_out_unsolved, self.levels
            ));
        }
        self.warnings.push(
            "uniform loads alone do not tell the circuit: V_t, resistors and diodes are those of the sensor file, switches near them. Single presses of known load would tell".to_owned(),
        );
    }
}

impl fmt::Display for UniformReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", CalibrationReport::table(&self.parameters))?;
        writeln!(
            f,
            "\n{} uniform loads, {:.3} to {:.3} g on each taxel above none; gains differ by {:.0} % (believed: {:.0} %)",
            self.levels,
            self.least_g,
            self.most_g,
            100.0 * self.gain_deviation,
            100.0 * super::fit::GAIN
        )?;
        match self.switch_deviation {
            Some(share) => writeln!(
                f,
                "switches differ from the file's by {:.0} % (believed: {:.0} %)",
                100.0 * share,
                100.0 * super::lines::WITHIN
            )?,
            None => writeln!(f, "switches are those of the sensor file")?,
        }
        for law in &self.laws {
            let chosen = if law.law == self.law {
                "  <- chosen"
            } else {
                ""
            };
            let loads = law.held_out_mean_absolute_g;
            let loads = loads.map_or("no answer".to_owned(), |g| format!("{g:.3} g a taxel"));
            writeln!(
                f,
                "  law {:<12} held-out readings {:.2} counts off (rms), held-out loads {loads}{chosen}",
                law.law, law.held_out_counts
            )?;
        }
        writeln!(
            f,
            "readings fitted to {:.2} counts (rms); noise and rounding {:.2}; {} readings left out as faults",
            self.left_counts, self.noise_counts, self.left_out
        )?;
        if self.laws.len() > 1 {
            writeln!(
                f,
                "the law was chosen by the held-out loads that it is judged by"
            )?;
        }
        if let Some(share) = self.held_out_array_share {
            writeln!(
                f,
                "mean over the array under held-out loads: {:.1} % off (rms)",
                100.0 * share
            )?;
        }
        for warning in self.warnings.iter().chain(&self.doubts) {
            writeln!(f, "warning: {warning}")?;
        }
        Ok(())
    }
}
