//! Which effects are in the data: each is fitted, and kept only where held-out presses are better for it.

use super::evidence::Evidence;
use super::fit::{Fitted, Score, coarse, look_around, refine};
use super::fit_law::LAWS;
use super::lines::separate;
use super::model::{Evaluator, LawModel, Model, Unknown, no_fit};
use super::{Finding, LawChoice, Options};
use crate::sensor::ScanOrder;
use crate::{Error, Sensor};

/// An effect is kept when held-out presses gain this many standard errors by it,
const SIGNIFICANT: f64 = 2.0;
/// and at least this many grams.
const WORTHWHILE_G: f64 = 0.002;
const SPREAD: [Unknown; 3] = [
    Unknown::SpreadRow,
    Unknown::SpreadColumn,
    Unknown::SpreadDiagonal,
];
/// Inner knots of the spline law.
const INNER_KNOTS: usize = 3;

/// The search for the model, and the best so far.
pub(super) struct Search<'a> {
    pub(super) evaluator: Evaluator<'a>,
    pub(super) model: Model,
    pub(super) unknowns: Vec<Unknown>,
    pub(super) best: Option<(Fitted, Score)>,
    pub(super) findings: Vec<Finding>,
    pub(super) laws: Vec<(String, f64)>,
    pub(super) law: String,
    pub(super) separated: bool,
    options: Options,
}

impl<'a> Search<'a> {
    pub(super) fn new(
        sensor: &Sensor,
        evidence: &'a Evidence,
        options: &Options,
    ) -> Result<Self, Error> {
        let mut evaluator = Evaluator::new(evidence);
        let blank = Model {
            sensor: sensor.clone(),
            spread: None,
            law: LawModel {
                ln_factor: 0.0,
                exponent: 1.0,
                saturation: 0.0,
                knots: Vec::new(),
                bends: Vec::new(),
                g_zero: 0.0,
                own_exponents: false,
            },
        };
        let model = coarse(&mut evaluator, &blank).ok_or_else(|| {
            no_fit(
                "every switch resistance from 0.5 to 400 Ohm leaves some frames without a solution",
            )
        })?;
        let mut model = feasible(&mut evaluator, model)
            .ok_or_else(|| no_fit("no switch resistance leaves every frame with a solution"))?;
        let mut unknowns = vec![Unknown::Columns, Unknown::Rows, Unknown::Factor];
        if evidence.levels.is_empty() {
            unknowns.push(Unknown::Exponent);
        }
        if options.open_loop_gain {
            unknowns.push(Unknown::OpenLoopGain);
        }
        if options.r_source {
            unknowns.push(Unknown::Source);
            model.sensor.readout.r_source_ohms = model.sensor.readout.r_source_ohms.max(1.0);
        }
        Ok(Self {
            evaluator,
            model,
            unknowns,
            best: None,
            findings: Vec::new(),
            laws: Vec::new(),
            law: "power".to_owned(),
            separated: false,
            options: options.clone(),
        })
    }

    /// Levels tell lines apart only where at least two differ.
    fn can_separate(&self) -> bool {
        self.evaluator.evidence.levels.len() >= 2
    }

    pub(super) fn run(&mut self, progress: &mut dyn FnMut(&str, f64)) -> Result<(), Error> {
        progress("circuit and load law", 0.0);
        self.fit_base(8)?;
        for _ in 0..2 {
            self.look()?;
            self.fit_base(6)?;
        }
        if self.can_separate() {
            self.separate(progress)?;
            self.look()?;
            self.fit_base(4)?;
        }
        self.judge()?;
        progress("offset", 0.3);
        self.try_offset()?;
        self.try_exponents(progress)?;
        progress("spread", 0.5);
        self.try_spread()?;
        progress("memory of the scan", 0.6);
        self.try_memory()?;
        progress("load law", 0.7);
        self.try_laws()?;
        if self.can_separate() {
            self.separate(progress)?;
            self.look()?;
            self.fit_base(5)?;
            self.judge()?;
        }
        Ok(())
    }

    /// Fits the present unknowns from the present model.
    fn fit_base(&mut self, rounds: usize) -> Result<(), Error> {
        let fitted = refine(&mut self.evaluator, &self.model, &self.unknowns, rounds)
            .ok_or_else(|| no_fit("the fit of circuit and load law did not converge"))?;
        self.model = fitted.answer();
        self.best = Some((fitted, Score::default()));
        Ok(())
    }

    fn look(&mut self) -> Result<(), Error> {
        look_around(&mut self.evaluator, &self.model)
            .ok_or_else(|| no_fit("a frame has no solution"))
    }

    fn judge(&mut self) -> Result<(), Error> {
        let folds = self.options.folds;
        if let Some((fitted, score)) = &mut self.best {
            *score = fitted
                .cross_validate(&mut self.evaluator, folds)
                .ok_or_else(|| no_fit("cross-validation met a frame without a solution"))?;
        }
        Ok(())
    }

    fn separate(&mut self, progress: &mut dyn FnMut(&str, f64)) -> Result<(), Error> {
        let found = separate(&mut self.evaluator, &self.model, &mut |share| {
            progress("every switch apart", share)
        });
        if let Some(model) = found {
            self.model = model;
            self.separated = true;
        }
        Ok(())
    }

    /// Fits a changed model with more unknowns. The gain on held-out presses (grams, standard errors).
    fn attempt(&mut self, model: &Model, more: &[Unknown]) -> Option<(Fitted, Score, f64, f64)> {
        let mut unknowns = self.unknowns.clone();
        unknowns.extend(more.iter().filter(|u| !self.unknowns.contains(u)));
        let fitted = refine(&mut self.evaluator, model, &unknowns, 6)?;
        let score = fitted.cross_validate(&mut self.evaluator, self.options.folds)?;
        let (gain, errors) = self.best.as_ref()?.1.worse_than(&score);
        Some((fitted, score, gain, errors))
    }

    fn accept(&mut self, fitted: Fitted, score: Score) {
        self.model = fitted.answer();
        self.unknowns = fitted.unknowns.clone();
        self.best = Some((fitted, score));
    }

    fn note(&mut self, name: &str, used: bool, text: String) {
        self.findings.push(Finding {
            name: name.to_owned(),
            used,
            text,
        });
    }

    fn has_ghosts(&self) -> bool {
        self.evaluator.unloaded.iter().any(|u| !u.is_empty())
    }

    fn try_offset(&mut self) -> Result<(), Error> {
        if !self.has_ghosts() {
            self.note(
                "offset",
                false,
                "no unloaded taxels to tell it from".to_owned(),
            );
            return Ok(());
        }
        let model = self.model.clone();
        let Some((fitted, score, gain, errors)) = self.attempt(&model, &[Unknown::Offset]) else {
            self.note("offset", false, "its fit did not converge".to_owned());
            return Ok(());
        };
        let answer = fitted.answer();
        let counts = answer.get(Unknown::Offset);
        let error = fitted.error_of(Unknown::Offset).unwrap_or(0.0);
        let used = is_better(gain, errors) && counts.abs() > 3.0 * error;
        self.note(
            "offset",
            used,
            format!("{counts:.2} ± {error:.2} counts; {}", gained(gain, errors)),
        );
        if used {
            self.accept(fitted, score);
        }
        Ok(())
    }

    fn try_exponents(&mut self, progress: &mut dyn FnMut(&str, f64)) -> Result<(), Error> {
        if self.evaluator.evidence.levels.len() < 3 {
            return Ok(());
        }
        let mut model = self.model.clone();
        model.law.own_exponents = true;
        // The switches were told apart under one exponent for all; they must be again under many.
        let separated = separate(&mut self.evaluator, &model, &mut |share| {
            progress("an exponent per taxel", share)
        });
        if let Some(separated) = separated {
            model = separated;
        }
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

    fn try_spread(&mut self) -> Result<(), Error> {
        let isolated = self.evaluator.isolated.iter().filter(|&&i| i).count();
        if isolated < 5 {
            self.note(
                "spread",
                false,
                format!("only {isolated} presses with nothing near them"),
            );
            return Ok(());
        }
        let model = self.model.clone();
        let Some((fitted, score, gain, errors)) = self.attempt(&model, &SPREAD) else {
            self.note("spread", false, "its fit did not converge".to_owned());
            return Ok(());
        };
        let spread = fitted
            .answer()
            .spread
            .unwrap_or(super::Spread::new([0.0; 3]));
        let away = 1.0 - spread.kept();
        let used = is_better(gain, errors) && away > 0.0;
        self.note(
            "spread",
            used,
            format!(
                "neighbours take {:.1} % of a load (one row away {:.2} %, one column {:.2} %, diagonal {:.2} %), from {isolated} presses; {}",
                100.0 * away,
                100.0 * spread.row,
                100.0 * spread.column,
                100.0 * spread.diagonal,
                gained(gain, errors)
            ),
        );
        if used {
            self.accept(fitted, score);
        }
        Ok(())
    }

    fn try_memory(&mut self) -> Result<(), Error> {
        let mut best: Option<(Fitted, Score, f64, f64, ScanOrder)> = None;
        for order in [ScanOrder::RowByRow, ScanOrder::ColumnByColumn] {
            let mut model = self.model.clone();
            model.sensor.converter.scan_order = order;
            let Some((fitted, score, gain, errors)) = self.attempt(&model, &[Unknown::Memory])
            else {
                continue;
            };
            if best.as_ref().is_none_or(|b| gain > b.2) {
                best = Some((fitted, score, gain, errors, order));
            }
        }
        let Some((fitted, score, gain, errors, order)) = best else {
            return Ok(());
        };
        let memory = fitted.answer().get(Unknown::Memory);
        let error = fitted.error_of(Unknown::Memory).unwrap_or(0.0);
        let used = is_better(gain, errors) && memory > 3.0 * error;
        let along = match order {
            ScanOrder::RowByRow => "row by row",
            ScanOrder::ColumnByColumn => "column by column",
        };
        self.note(
            "memory of the scan",
            used,
            format!(
                "a reading keeps {:.2} ± {:.2} % of the one before, scanned {along}; {}",
                100.0 * memory,
                100.0 * error,
                gained(gain, errors)
            ),
        );
        if used {
            self.accept(fitted, score);
        }
        Ok(())
    }

    fn try_laws(&mut self) -> Result<(), Error> {
        let power = self.best.as_ref().map_or(0.0, |b| b.1.mean_error());
        self.laws.push(("power".to_owned(), power));
        for (choice, name) in LAWS {
            let wanted = self.options.law == choice;
            if choice == LawChoice::Power || !(wanted || self.options.law == LawChoice::Auto) {
                continue;
            }
            let mut model = self.model.clone();
            let more = match choice {
                LawChoice::Saturating => {
                    model.law.saturation = 0.1;
                    vec![Unknown::Saturation]
                }
                _ => {
                    model.law.saturation = 0.0;
                    self.knots(&mut model);
                    (1..=INNER_KNOTS).map(Unknown::Bend).collect()
                }
            };
            let kept: Vec<Unknown> = self.unknowns.clone();
            self.unknowns.retain(|u| *u != Unknown::Saturation);
            let attempt = self.attempt(&model, &more);
            self.unknowns = kept;
            let Some((fitted, score, gain, errors)) = attempt else {
                continue;
            };
            self.laws.push((name.to_owned(), score.mean_error()));
            if wanted || is_better(gain, errors) {
                self.law = name.to_owned();
                self.accept(fitted, score);
            }
        }
        Ok(())
    }

    /// Knots of the spline law over the loads that were labelled.
    fn knots(&self, model: &mut Model) {
        let loads: Vec<f64> = self
            .evaluator
            .evidence
            .presses
            .iter()
            .map(|p| p.load_g)
            .filter(|&l| l > 1.0)
            .collect();
        let least = loads
            .iter()
            .fold(f64::INFINITY, |a, &b| a.min(b))
            .max(5.0)
            .ln();
        let most = loads.iter().fold(0f64, |a, &b| a.max(b)).max(10.0).ln();
        let parts = INNER_KNOTS + 1;
        model.law.knots = (0..=parts)
            .map(|i| least + (most - least) * i as f64 / parts as f64)
            .collect();
        model.law.bends = vec![0.0; parts + 1];
    }
}

/// A model under which every frame has a solution: the start was chosen on a part of them, and too large a
/// resistance is what makes frames infeasible.
fn feasible(evaluator: &mut Evaluator, mut model: Model) -> Option<Model> {
    if !evaluator.evidence.levels.is_empty() {
        // From here on the levels give the law; the factor is that of their loads.
        model.law.ln_factor = 0.0;
    }
    for _ in 0..40 {
        if evaluator.estimates(&model).is_some() {
            return Some(model);
        }
        model.set(Unknown::Columns, -0.15)?;
        model.set(Unknown::Rows, -0.15)?;
    }
    None
}

fn is_better(gain: f64, errors: f64) -> bool {
    gain > WORTHWHILE_G && errors > SIGNIFICANT
}

fn gained(gain: f64, errors: f64) -> String {
    match gain > 0.0 {
        true => format!("held-out presses gain {gain:.3} g by it ({errors:.1} standard errors)"),
        false => format!("held-out presses lose {:.3} g by it", -gain),
    }
}
