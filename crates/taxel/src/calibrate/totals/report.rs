//! What known totals told, in words.

use std::fmt;

use serde::Serialize;

use super::held_out::Judged;
use crate::calibrate::{CalibrationReport, Parameter, Suspect};
use crate::material::LoadLaw;
use crate::stats::{mean, quantile, standard_error};

/// Held-out totals that are off by more than this share of what guessing their mean is off by tell that little was learnt.
const LITTLE: f64 = 0.5;
/// Where there is one load, no guess tells: totals that are off by more than this share of it tell that little was learnt.
const LITTLE_OF_ONE: f64 = 0.25;
/// A law so many times the one before is of another unit.
const OTHER: f64 = 5.0;
/// Fewest parts that tell what new totals are off by.
pub(super) const LEAST_PARTS: usize = 3;

/// A total that took no part.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LeftOut {
    /// Its place among the totals given, from 0.
    pub total: usize,
    /// The load on the whole array, grams.
    pub load_g: f64,
    /// Why.
    pub why: String,
}

impl fmt::Display for LeftOut {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "the frame under {} g is left out: {}",
            self.load_g, self.why
        )
    }
}

/// How good a calibration by known totals is. Errors are of totals that took no part in the fit that reads them.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct TotalsReport {
    /// Numbers of the law.
    pub parameters: Vec<Parameter>,
    /// Loaded frames fitted to.
    pub totals: usize,
    /// Frames of the empty sensor.
    pub empty: usize,
    /// Different loads above nothing.
    pub levels: usize,
    /// Least load above nothing, grams.
    pub least_g: f64,
    /// Largest load, grams.
    pub most_g: f64,
    /// What told what an unloaded taxel conducts.
    pub unloaded_by: String,
    /// Root mean square of what the fit leaves of the totals it was fitted to, a share.
    pub left_share: f64,
    /// The same by noise and rounding alone.
    pub noise_share: f64,
    /// Root mean square of what the empty sensor sums to, grams; none with fewer than two such frames.
    pub empty_g: Option<f64>,
    /// How totals were held out.
    pub held_out: String,
    /// Held-out totals that judged.
    pub held_out_totals: usize,
    /// Held-out totals that could not be judged.
    pub held_out_unjudged: usize,
    /// Mean absolute error of held-out totals, grams.
    pub held_out_mean_absolute_g: Option<f64>,
    /// Standard error of that mean over what was held out together, grams.
    pub held_out_standard_error_g: Option<f64>,
    /// 95th percentile of the absolute error of held-out totals, grams.
    pub held_out_p95_g: Option<f64>,
    /// Mean absolute error of held-out totals, a share of each.
    pub held_out_mean_absolute_share: Option<f64>,
    /// Mean absolute error of guessing the mean of the other totals, grams; none of one load.
    pub guessing_g: Option<f64>,
    /// Totals that the others contradict; [`Suspect::press`] is the place among the totals given.
    pub suspects: Vec<Suspect>,
    /// Totals that took no part for what their frames are.
    pub left_out: Vec<LeftOut>,
    /// Reasons not to use the fit as it is.
    pub doubts: Vec<String>,
    /// What the user should know.
    pub warnings: Vec<String>,
}

impl TotalsReport {
    /// Takes in what held-out totals say.
    pub(super) fn take_judged(&mut self, judged: &[Judged]) {
        let errors = || judged.iter().map(Judged::error_g);
        self.held_out_totals = judged.len();
        self.held_out_mean_absolute_g = mean(errors());
        self.held_out_p95_g = quantile(errors(), 0.95);
        self.held_out_mean_absolute_share = mean(judged.iter().map(|j| j.off().abs()));
        let folds = judged.iter().map(|j| j.fold + 1).max().unwrap_or(0);
        let of_fold = |fold: usize| {
            let own = judged.iter().filter(|j| j.fold == fold);
            mean(own.map(Judged::error_g))
        };
        let means: Vec<f64> = (0..folds).filter_map(of_fold).collect();
        self.held_out_standard_error_g = standard_error(&means);
        let guesses = judged.iter().map(|j| (j.guess_g - j.load_g).abs());
        self.guessing_g = mean(guesses).filter(|_| self.levels > 1);
    }

    /// Says what speaks against the fit.
    pub(super) fn judge(&mut self) {
        let off = self.held_out_mean_absolute_g;
        let share = self.held_out_mean_absolute_share;
        match (off, self.guessing_g) {
            (None, _) => self.doubts.push(
                "no total could be held out, so that nothing says how good this fit is: give more frames, under other loads".to_owned(),
            ),
            (Some(off), Some(guess)) if off > LITTLE * guess => self.doubts.push(format!(
                "held-out totals are {off:.1} g off on average, and guessing the mean of the others would be {guess:.1} g off: little was learnt of what makes them differ. Are totals and frames in the same order, and topology, v_test_volts, resistors and `converter.inverted` right?"
            )),
            (Some(off), None) if share > Some(LITTLE_OF_ONE) => self.doubts.push(format!(
                "held-out totals are {off:.1} g off on average, of {} g: the same load reads otherwise from frame to frame",
                self.most_g
            )),
            _ => {}
        }
        if self.levels == 1 {
            self.warnings.push(format!(
                "all totals are {} g: what reads any load as that one would pass as well. A second load would tell",
                self.most_g
            ));
        }
        if self.held_out_unjudged > 0 && off.is_some() {
            self.warnings.push(format!(
                "{} held-out totals could not be read by a fit without them",
                self.held_out_unjudged
            ));
        }
        self.warnings.push(
            "totals do not tell the circuit, nor single taxels: V_t, resistors, switches and gains are those of the sensor file".to_owned(),
        );
    }

    /// Whether the law is far from the one that the sensor file had: another unit, most likely. `load_g`: what a taxel carries.
    pub(super) fn compare(&mut self, found: &LoadLaw, before: Option<&LoadLaw>, load_g: f64) {
        let Some(before) = before else {
            return;
        };
        let answers = |law: &LoadLaw| law.siemens_from_grams(0, load_g) - law.g_zero;
        let ratio = answers(found) / answers(before);
        if !(1.0 / OTHER..=OTHER).contains(&ratio) {
            self.doubts.push(format!(
                "under {load_g:.3} g taxels conduct {ratio:.3} times what the sensor file's law said: are the totals in grams on the whole array, and not in another unit, or on each taxel?"
            ));
        }
    }
}

impl fmt::Display for TotalsReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", CalibrationReport::table(&self.parameters))?;
        let range = if self.levels == 1 {
            format!("all of {} g", self.most_g)
        } else {
            format!(
                "{} loads, {} to {} g",
                self.levels, self.least_g, self.most_g
            )
        };
        writeln!(
            f,
            "\n{} totals ({range}), {} frames of the empty sensor",
            self.totals, self.empty
        )?;
        match (
            self.held_out_mean_absolute_g,
            self.held_out_mean_absolute_share,
        ) {
            (Some(off), Some(share)) => {
                let error = self.held_out_standard_error_g;
                let error = error.map_or(String::new(), |error| format!(" ± {error:.1}"));
                writeln!(
                    f,
                    "held-out totals ({} of {}; {}): {off:.1}{error} g mean absolute error ({:.2} %), {:.1} g at the 95th percentile",
                    self.held_out_totals,
                    self.totals,
                    self.held_out,
                    100.0 * share,
                    self.held_out_p95_g.unwrap_or(off)
                )?;
            }
            _ => writeln!(f, "held-out totals: no fit could be made without any")?,
        }
        if let Some(guess) = self.guessing_g {
            writeln!(f, "guessing the mean of the others: {guess:.1} g off")?;
        }
        writeln!(
            f,
            "totals fitted to {:.2} % (rms); by noise and rounding {:.2} %",
            100.0 * self.left_share,
            100.0 * self.noise_share
        )?;
        writeln!(f, "unloaded taxels: {}", self.unloaded_by)?;
        if let Some(empty) = self.empty_g {
            writeln!(f, "the empty sensor sums to {empty:.1} g (rms)")?;
        }
        for out in &self.left_out {
            writeln!(f, "warning: {out}")?;
        }
        for suspect in &self.suspects {
            writeln!(f, "warning: a total of {}", suspect_words(suspect))?;
        }
        for warning in self.warnings.iter().chain(&self.doubts) {
            writeln!(f, "warning: {warning}")?;
        }
        Ok(())
    }
}

/// A total that the others contradict.
fn suspect_words(suspect: &Suspect) -> String {
    let unit = suspect
        .unit()
        .map_or(String::new(), |unit| format!("; are these {unit}?"));
    format!(
        "{} g where the other totals say {:.4} g{unit} (left out of the fit)",
        suspect.load_g, suspect.says_g
    )
}
