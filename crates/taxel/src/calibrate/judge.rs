//! What held-out presses say of a search: how far off they are, and what a load is uncertain by.

use super::choose::Search;
use super::discrepancy::{Beside, Judged, digits, least_noise_g, uncertainty};
use super::effects::SPREAD;
use super::evaluate::Evaluator;
use super::evidence::Evidence;
use super::fit::{Score, mean, standard_error};
use super::least_squares::median;
use super::model::Unknown;
use super::outcome::HeldOut;
use super::polish::judges_forces;
use super::priors::LEVEL_SCALE;
use crate::sensor::UncertaintySpec;

/// Presses are farther off than others when their errors are so by this many standard errors.
const CLEARLY: f64 = 2.0;

impl Search<'_> {
    /// Errors on presses that chose among effects, each by a fit without it: where there are too few to keep some apart,
    /// or a search takes long.
    pub(super) fn judged_by_folds(&self) -> HeldOut {
        let folds = self.options.folds;
        let mut held = HeldOut {
            how: format!(
                "{folds} folds, split by press, each judged by one step from the fit of all to the fit without it; effects and law were chosen by the same presses"
            ),
            ..HeldOut::default()
        };
        if let Some((_, score)) = &self.best {
            held.unjudged = score.seen.len();
            let own = score.errors_g.iter().enumerate();
            held.errors_g = own
                .filter(|(i, _)| !score.seen.contains(i))
                .map(|e| *e.1)
                .collect();
        }
        held
    }

    /// What loads are uncertain by beyond noise: by presses of the folds, as much farther off as those are that did not choose
    /// the effects either, where these are clearly so.
    pub(super) fn uncertainty(&mut self) -> Option<UncertaintySpec> {
        let score = self.best.as_ref().map(|best| best.1.clone())?;
        if self.judged.is_empty() {
            let says: Vec<Option<f64>> = score.says_g.iter().copied().map(Some).collect();
            self.judged = self.readings(&says);
        }
        let inflation = self.inflation(&score);
        let levelled = !self.evaluator.evidence.levels.is_empty();
        let scale = match (&self.together, &self.best) {
            (Some(together), _) => together.error_of_contacts(),
            (None, Some((fitted, _))) => fitted.error_of(Unknown::Factor),
            _ => None,
        };
        let mut fit_share = scale.filter(|_| levelled).unwrap_or(0.0);
        if levelled && self.model.seeks_lines {
            // Scale, spread, lines and switches stand for each other, and turns between them end before they settle: the curvature
            // there says less than is believed beforehand of what loads of contacts are off by.
            fit_share = fit_share.max(LEVEL_SCALE);
        }
        if levelled && self.options.label_share > 0.0 {
            // What labels err by is taken out of what presses are off by, and the common part of it with that.
            let scale = self
                .together
                .as_ref()
                .and_then(|t| t.error_of(Unknown::Factor));
            fit_share = fit_share.max(scale.unwrap_or(0.0).min(LEVEL_SCALE));
        }
        let unloaded = self.evaluator.unloaded_g(&self.model).unwrap_or_default();
        let beside = Beside {
            unloaded_g: &unloaded,
            zero_g: None,
            fit_share,
            presses_share_it: self.together.is_none(),
            label_share: self.options.label_share,
            inflation,
        };
        let found = uncertainty(&self.judged, beside);
        found.map(|found| UncertaintySpec {
            spread_error: self.spread_error(),
            sheet_share: self.sheet_share(),
            ..found
        })
    }

    /// Standard errors of the spread's three shares, where it is there and was fitted with all else.
    fn spread_error(&self) -> Option<[f64; 3]> {
        let together = self.together.as_ref()?;
        let errors = SPREAD.map(|unknown| together.error_of(unknown));
        let [Some(row), Some(column), Some(diagonal)] = errors else {
            return None;
        };
        let is_told = [row, column, diagonal].iter().all(|e| e.is_finite());
        is_told.then(|| [row, column, diagonal].map(digits))
    }

    /// How many times farther off presses are when they did not choose the effects either, where they clearly are: of the
    /// same presses, so that their labels' faults do not count.
    fn inflation(&self, score: &Score) -> f64 {
        let (unseen, own) = (&self.held_out, &self.evaluator.evidence.origin);
        let place = |origin: &usize| own.iter().position(|o| o == origin);
        let chose: Vec<f64> = unseen
            .origin
            .iter()
            .filter_map(place)
            .map(|i| score.errors_g[i])
            .collect();
        if chose.is_empty() || chose.len() != unseen.errors_g.len() {
            return 1.0;
        }
        let farther: Vec<f64> = (unseen.errors_g.iter().zip(&chose))
            .map(|(unseen, chose)| unseen - chose)
            .collect();
        if mean(&farther) < CLEARLY * standard_error(&farther) {
            return 1.0;
        }
        (median(&unseen.errors_g) / median(&chose).max(1e-12)).max(1.0)
    }

    /// Presses with what they were read as, those that were.
    pub(super) fn readings(&mut self, says_g: &[Option<f64>]) -> Vec<Judged> {
        let Some(law) = self.evaluator.law(&self.model) else {
            return Vec::new();
        };
        let (evidence, sensor) = (self.evaluator.evidence, &self.model.sensor);
        let presses = evidence.presses.iter().zip(says_g).enumerate();
        let noise =
            |taxel, load_g| least_noise_g(sensor, &law, evidence.noise_counts, taxel, load_g);
        // A force has the noise of eight unloaded taxels besides.
        let beside = if judges_forces(&self.evaluator) {
            8f64.sqrt()
        } else {
            0.0
        };
        presses
            .filter_map(|(place, (press, says_g))| {
                let taxel = press.row * sensor.columns() + press.column;
                let load_g = press.load_g;
                Some(Judged {
                    press: place,
                    frame: press.frame,
                    load_g,
                    says_g: (*says_g)?,
                    noise_g: noise(taxel, load_g).hypot(beside * noise(taxel, 0.0)),
                })
            })
            .collect()
    }

    /// Errors on presses that took no part.
    pub(super) fn judge_unseen(&mut self, unseen: &Evidence, folds: usize) -> HeldOut {
        let mut held = HeldOut {
            how: format!(
                "every {folds}th frame, split by press; judged by a fit and choices made without them"
            ),
            ..HeldOut::default()
        };
        let mut model = self.model.clone();
        let Some(law) = self.evaluator.law(&model) else {
            held.unjudged = unseen.presses.len();
            return held;
        };
        model.law.g_zero = law.g_zero;
        for (i, press) in unseen.presses.iter().enumerate() {
            let one = unseen.part(&[i]);
            let estimates = Evaluator::new(&one, self.evaluator.executor).estimates(&model);
            match estimates.as_deref() {
                Some([estimate]) => {
                    held.errors_g.push((estimate.load_g - press.load_g).abs());
                    held.origin.push(unseen.origin[i]);
                }
                _ => held.unjudged += 1,
            }
        }
        held
    }
}
