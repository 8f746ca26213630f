//! Effects beyond the circuit: offset, exponents, spread, carry-over, the law's shape. Each is fitted, and kept only
//! where held-out presses are better for it (the offset: unless they are better without).

use super::LawChoice;
use super::choose::{MIN_OFFSET_COUNTS, Search};
use super::digits::fixed;
use super::fit::{Effort, Fitted, refine_alone, switches_by_ghosts};
use super::fit_law::LAWS;
use super::model::{Model, Unknown};
use crate::Error;
use crate::sensor::ScanOrder;

/// An effect is kept when held-out presses gain this many standard errors by it,
const SIGNIFICANT: f64 = 2.0;
/// and at least this many grams.
const WORTHWHILE_G: f64 = 0.002;
pub(super) const SPREAD: [Unknown; 3] = [
    Unknown::SpreadRow,
    Unknown::SpreadColumn,
    Unknown::SpreadDiagonal,
];
/// Shares (of a load, of the previous reading) below this are taken for none.
pub(super) const MIN_SHARE: f64 = 1e-3;
/// A saturation is told when it is this many standard errors from none.
pub(super) const TOLD: f64 = 3.0;
/// Inner knots of the spline law.
pub(super) const INNER_KNOTS: usize = 3;

impl Search<'_> {
    pub(super) fn try_offset(&mut self) -> Result<(), Error> {
        if self.uses("offset") {
            return Ok(());
        }
        if !self.evaluator.has_unloaded() {
            self.note(
                "offset",
                false,
                "no unloaded taxels to tell it from".to_owned(),
            );
            return Ok(());
        }
        // The switches that ghosts tell go with the offset assumed: without and with one, each with its own.
        let by_ghosts = self.can_separate();
        let mut without = self.model.clone();
        without.set(Unknown::Offset, 0.0);
        if by_ghosts
            && let Some((model, _)) = switches_by_ghosts(&mut self.evaluator, &without, false)
        {
            without = model;
        }
        let with = if by_ghosts {
            switches_by_ghosts(&mut self.evaluator, &without, true).map(|(model, error)| {
                let clear = model.get(Unknown::Offset).abs() > 3.0 * error;
                (model, clear)
            })
        } else {
            refine_alone(&mut self.evaluator, &without, &[Unknown::Offset])
                .map(|(model, _, clear)| (model, clear))
        };
        let Some((with, clear)) = with else {
            self.note("offset", false, "its fit did not converge".to_owned());
            return Ok(());
        };
        let counts = with.get(Unknown::Offset);
        if self.model.get(Unknown::Offset) != 0.0 {
            self.model = without;
            self.fit_base(Effort::Rough)?;
            self.score_held_out()?;
        }
        if !clear || counts.abs() < MIN_OFFSET_COUNTS {
            self.note("offset", false, format!("{counts:.2} counts"));
            return Ok(());
        }
        let Some((fitted, score, ..)) = self.attempt(&with, &[Unknown::Offset]) else {
            self.note("offset", false, "its fit did not converge".to_owned());
            return Ok(());
        };
        // The ghosts' word is enough to begin with: an offset and a law that bends can hide each other, so that
        // presses gain by neither alone. They judge once both are there.
        self.note("offset", true, reported(&fitted));
        self.accept(fitted, score);
        Ok(())
    }

    /// Whether held-out presses are better without the offset that ghosts told, now that all else is known.
    pub(super) fn doubt_offset(&mut self) -> Result<(), Error> {
        let Some(text) = self
            .best
            .as_ref()
            .filter(|_| self.uses("offset"))
            .map(|(fitted, _)| reported(fitted))
        else {
            return Ok(());
        };
        let mut without = self.model.clone();
        without.set(Unknown::Offset, 0.0);
        if self.can_separate()
            && let Some((model, _)) = switches_by_ghosts(&mut self.evaluator, &without, false)
        {
            without = model;
        }
        let all = self.unknowns.clone();
        self.unknowns.retain(|&u| u != Unknown::Offset);
        let Some((fitted, score, gain, errors)) = self.attempt(&without, &[]) else {
            self.unknowns = all;
            return Ok(());
        };
        let doubtful = gain >= 0.0;
        self.note(
            "offset",
            !doubtful,
            format!("{text}; {}", gained(-gain, -errors)),
        );
        if doubtful {
            self.accept(fitted, score)
        } else {
            self.unknowns = all
        }
        Ok(())
    }

    pub(super) fn try_exponents(&mut self) -> Result<(), Error> {
        if self.evaluator.evidence.levels.len() < 3 || self.uses("exponent per taxel") {
            return Ok(());
        }
        let mut model = self.model.clone();
        model.law.own_exponents = true;
        let deviation = self
            .evaluator
            .material(&model)
            .map_or(0.0, |m| m.exponent_deviation);
        let Some((fitted, score, gain, errors)) = self.attempt(&model, &[]) else {
            self.note(
                "exponent per taxel",
                false,
                "its fit did not converge".to_owned(),
            );
            return Ok(());
        };
        let used = is_better(gain, errors);
        self.note(
            "exponent per taxel",
            used,
            format!(
                "standard deviation {deviation:.4}; {}",
                gained(gain, errors)
            ),
        );
        if used {
            self.accept(fitted, score);
        }
        Ok(())
    }

    pub(super) fn try_spread(&mut self) -> Result<(), Error> {
        if self.uses("spread") {
            return Ok(());
        }
        let isolated = self.evaluator.isolated.iter().filter(|&&i| i).count();
        if isolated < 5 {
            self.note(
                "spread",
                false,
                format!("only {isolated} presses with nothing near them"),
            );
            return Ok(());
        }
        let Some((model, _, clear)) = refine_alone(&mut self.evaluator, &self.model, &SPREAD)
        else {
            self.note("spread", false, "its fit did not converge".to_owned());
            return Ok(());
        };
        let kept = model.spread.map_or(1.0, |s| s.kept());
        if !clear || kept > 1.0 - MIN_SHARE {
            self.note(
                "spread",
                false,
                format!(
                    "neighbours take {} % of a load, from {isolated} presses",
                    fixed(100.0 * (1.0 - kept), 2)
                ),
            );
            return Ok(());
        }
        let Some((fitted, score, gain, errors)) = self.attempt(&model, &SPREAD) else {
            self.note("spread", false, "its fit did not converge".to_owned());
            return Ok(());
        };
        let spread = fitted
            .model
            .spread
            .unwrap_or(crate::material::Spread::new([0.0; 3]));
        let away = 1.0 - spread.kept();
        let used = is_better(gain, errors) && away > 0.0;
        self.note(
            "spread",
            used,
            format!(
                "neighbours take {} % of a load (one row away {} %, one column {} %, diagonal {} %), from {isolated} presses; {}",
                fixed(100.0 * away, 1),
                fixed(100.0 * spread.row, 2),
                fixed(100.0 * spread.column, 2),
                fixed(100.0 * spread.diagonal, 2),
                gained(gain, errors)
            ),
        );
        if used {
            self.accept(fitted, score);
        }
        Ok(())
    }

    pub(super) fn try_carry_over(&mut self) -> Result<(), Error> {
        if !self.evaluator.isolated.contains(&true) || self.uses("memory of the scan") {
            return Ok(());
        }
        let mut best: Option<(Model, f64, bool)> = None;
        for order in [ScanOrder::RowByRow, ScanOrder::ColumnByColumn] {
            let mut model = self.model.clone();
            model
                .sensor
                .try_out(|spec| spec.converter.scan_order = order);
            let Some(found) = refine_alone(&mut self.evaluator, &model, &[Unknown::CarryOver])
            else {
                continue;
            };
            if best.as_ref().is_none_or(|b| found.1 < b.1) {
                best = Some(found);
            }
        }
        let Some((model, _, clear)) = best else {
            return Ok(());
        };
        let order = model.sensor.converter().scan_order;
        let carry_over = model.get(Unknown::CarryOver);
        if !clear || carry_over < MIN_SHARE {
            self.note(
                "memory of the scan",
                false,
                format!(
                    "a reading keeps {:.2} % of the one before",
                    100.0 * carry_over
                ),
            );
            return Ok(());
        }
        let Some((fitted, score, gain, errors)) = self.attempt(&model, &[Unknown::CarryOver])
        else {
            return Ok(());
        };
        let carry_over = fitted.model.get(Unknown::CarryOver);
        let error = fitted.error_of(Unknown::CarryOver).unwrap_or(0.0);
        let used = is_better(gain, errors) && carry_over > 3.0 * error;
        let along = match order {
            ScanOrder::RowByRow => "row by row",
            ScanOrder::ColumnByColumn => "column by column",
        };
        self.note(
            "memory of the scan",
            used,
            format!(
                "a reading keeps {:.2} ± {:.2} % of the one before, scanned {along}; {}",
                100.0 * carry_over,
                100.0 * error,
                gained(gain, errors)
            ),
        );
        if used {
            self.accept(fitted, score);
        }
        Ok(())
    }

    /// Tries other shapes of the law. The spline waits for the others (`with_spline`): before every effect is in,
    /// its freedom makes up for those that are missing.
    pub(super) fn try_laws(&mut self, with_spline: bool) -> Result<(), Error> {
        let now = self.best.as_ref().map_or(0.0, |b| b.1.mean_error());
        self.laws.retain(|(name, _)| *name != self.law);
        self.laws.push((self.law.clone(), now));
        for (choice, name) in LAWS {
            let wanted = self.options.law == choice;
            let asked = wanted || self.options.law == LawChoice::Auto;
            // A law that another effect asked for may no longer be needed: the plainest is tried again.
            let back = choice == LawChoice::Power && asked && self.law != name;
            if (choice == LawChoice::Power && !back)
                || !asked
                || self.law == name
                || (choice == LawChoice::Spline && !with_spline)
            {
                continue;
            }
            let mut model = self.model.clone();
            (model.law.saturation, model.law.knots, model.law.bends) =
                (0.0, Vec::new(), Vec::new());
            let more = match choice {
                LawChoice::Power => Vec::new(),
                LawChoice::Saturating => {
                    model.law.saturation = 0.1;
                    vec![Unknown::Saturation]
                }
                _ => {
                    self.knots(&mut model);
                    (1..=INNER_KNOTS).map(Unknown::Bend).collect()
                }
            };
            let kept: Vec<Unknown> = self.unknowns.clone();
            self.unknowns
                .retain(|u| !matches!(u, Unknown::Saturation | Unknown::Bend(_)));
            let attempt = self.attempt(&model, &more);
            self.unknowns = kept;
            let Some((fitted, score, gain, errors)) = attempt else {
                continue;
            };
            self.laws.retain(|(known, _)| known != name);
            self.laws.push((name.to_owned(), score.mean_error()));
            let saturation = fitted.model.law.saturation;
            let determined = fitted
                .error_of(Unknown::Saturation)
                .is_none_or(|error| saturation > TOLD * error);
            if wanted || (back && gain >= 0.0) || (!back && is_better(gain, errors) && determined) {
                self.law = name.to_owned();
                self.accept(fitted, score);
            }
        }
        Ok(())
    }

    /// Knots of the spline law over the loads that were labelled.
    pub(super) fn knots(&self, model: &mut Model) {
        let loads: Vec<f64> = self
            .evaluator
            .evidence
            .presses
            .iter()
            .map(|p| p.load_g)
            .filter(|&l| l > 0.0)
            .collect();
        let most = loads.iter().fold(0f64, |a, &b| a.max(b));
        let least = loads.iter().fold(most, |a, &b| a.min(b)).max(most / 100.0);
        let (least, most) = (least.ln(), most.ln());
        let parts = INNER_KNOTS + 1;
        model.law.knots = (0..=parts)
            .map(|i| least + (most - least) * i as f64 / parts as f64)
            .collect();
        model.law.bends = vec![0.0; parts + 1];
    }
}

/// What ghosts say of the offset.
fn reported(fitted: &Fitted) -> String {
    format!(
        "{:.2} ± {:.2} counts",
        fitted.model.get(Unknown::Offset),
        fitted.error_of(Unknown::Offset).unwrap_or(0.0)
    )
}

pub(super) fn is_better(gain: f64, errors: f64) -> bool {
    gain > WORTHWHILE_G && errors > SIGNIFICANT
}

pub(super) fn gained(gain: f64, errors: f64) -> String {
    if gain > 0.0 {
        format!("held-out presses gain {gain:.3} g by it ({errors:.1} standard errors)")
    } else {
        format!("held-out presses lose {:.3} g by it", -gain)
    }
}
