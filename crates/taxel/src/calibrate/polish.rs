//! The end of a calibration: from what the search found, every effect an unknown that is believed to be absent, all of
//! them fitted together. What is then not told from nothing is left out.

use super::choose::{MIN_OFFSET_COUNTS, Search};
use super::effects::{MIN_SHARE, SPREAD, TOLD};
use super::evaluate::{Evaluator, PressEstimate};
use super::fit::{Score, look_again};
use super::model::{Model, Unknown};
use super::terms::{Hearing, MisfitTerm, Told};
use super::together::{Effort, Together, fit_together, loss_of};
use super::{EffectFinding, LawChoice, MAX_SEARCHED_TAXELS};
use crate::Error;
use crate::sensor::{PerLine, ScanOrder};
use crate::stats::{self, robust_deviation};

/// Turns between the unknowns and one resistance a line, at most; they end when no unknown moves by more than this share of
/// its standard error.
const MAX_TURNS: usize = 5;
/// What lines and switches resist is told apart slowly, and at first with all of a side alike: lines told apart make up for a wrong mean.
const ALIKE_TURNS: usize = 3;
const MAX_TURNS_WITH_LINES: usize = 20;
/// Without one that is nearer to the presses, such turns end after so many.
const PATIENCE: usize = 4;
const SETTLED: f64 = 0.3;
/// Unloaded neighbours are added to a press when their noise is below this share of the usual load.
const QUIET: f64 = 0.02;
/// Where a sheet is begun with: 50 kΩ, microsiemens.
const START_SHEET: f64 = 20.0;
/// A sheet that conducts less is none, microsiemens; it is told when −2 ln of the posterior is larger without it by this.
const MIN_SHEET: f64 = 1.0;
const SHEET_TOLD: f64 = 9.0;
/// What is read around presses may not grow by more than this: labels and ghosts can be explained by a spread that leaves
/// loads beside presses where nothing stands.
const MAX_AROUND: f64 = 1.2;
/// A fit of everything that reads held-out presses worse than the search by this share, and so many standard errors, is none: labels
/// that a sheet or a spread bends cost it less.
const WORSE_BY: f64 = 0.5;
const CLEARLY: f64 = 2.0;
/// Fewest presses with nothing near them that tell of what surrounds presses.
pub(super) const MIN_ALONE: usize = 5;

/// On larger arrays, unless labels are explained but for this share of a load, what surrounds presses tells the spread and the
/// carry-over alone: presses off the middle of their taxels bend the rest where that listens to it too. Smaller ones have too few presses alone for that.
const MAX_TAXELS_BY_ALL: usize = 2048;
const EXPLAINED: f64 = 0.02;

/// What a search had found before everything was fitted together.
pub(super) struct Before {
    model: Model,
    unknowns: Vec<Unknown>,
    findings: Vec<EffectFinding>,
    law: String,
    isolated: Vec<bool>,
    unloaded: Vec<Vec<usize>>,
    ghost_grams_per_siemens: f64,
}

impl Search<'_> {
    pub(super) fn before(&self) -> Before {
        Before {
            model: self.model.clone(),
            unknowns: self.unknowns.clone(),
            findings: self.findings.clone(),
            law: self.law.clone(),
            isolated: self.evaluator.isolated.clone(),
            unloaded: self.evaluator.unloaded.clone(),
            ghost_grams_per_siemens: self.evaluator.ghost_grams_per_siemens,
        }
    }

    pub(super) fn go_back_to(&mut self, before: &Before) {
        self.model = before.model.clone();
        self.unknowns.clone_from(&before.unknowns);
        self.findings.clone_from(&before.findings);
        self.beliefs.clear();
        self.together = None;
        self.judged.clear();
        self.law.clone_from(&before.law);
        // Its fit has a derivative of what it looked at, not of what was looked at since.
        let evaluator = &mut self.evaluator;
        evaluator.isolated.clone_from(&before.isolated);
        evaluator.unloaded.clone_from(&before.unloaded);
        evaluator.ghost_grams_per_siemens = before.ghost_grams_per_siemens;
        evaluator.forces = false;
        evaluator.clear();
    }

    /// Fits everything together, and keeps it where it is more probable than what the search found; in the first of the
    /// ways that suit its size for which that is so.
    pub(super) fn polish(&mut self, progress: &mut dyn FnMut(&str, f64)) -> Result<(), Error> {
        let before = self.before();
        let taxels = self.model.sensor.rows() * self.model.sensor.columns();
        let is_slow = self.model.seeks_lines && taxels > MAX_SEARCHED_TAXELS;
        let ways: &[Hearing] = if is_slow {
            &[Hearing::All]
        } else if taxels <= MAX_TAXELS_BY_ALL {
            &[Hearing::All, Hearing::AllOfPresses]
        } else if self.explains_labels() {
            &[Hearing::All]
        } else {
            &[Hearing::AllOfPresses]
        };
        for &hearing in ways {
            self.hearing = hearing;
            let together = self.everything(progress);
            let better = together.filter(|together| self.is_more_probable(together, &before));
            if let Some(together) = better
                && self.take(together)
            {
                return Ok(());
            }
            self.go_back_to(&before);
        }
        self.score_held_out()
    }

    /// Whether the search alone reads held-out presses well: what is left are small effects, and no faults of labels.
    fn explains_labels(&self) -> bool {
        let presses = self.evaluator.evidence.presses.iter();
        let score = self.best.as_ref().map(|best| &best.1);
        let errors = score.map_or(&[][..], |score| &score.errors_g);
        let shares = errors.iter().zip(presses);
        let shares = shares.filter(|(_, press)| press.load_g > 0.0);
        stats::median(shares.map(|(error, press)| error / press.load_g))
            .is_some_and(|share| share < EXPLAINED)
    }

    /// Each effect of before that was not told from nothing here would have to be worth as much as one that is told.
    fn is_more_probable(&mut self, together: &Together, than: &Before) -> bool {
        let mut old = than.model.clone();
        old.levelled = self.can_separate();
        let effects = [&SPREAD[..], &[Unknown::Offset, Unknown::CarryOver]].concat();
        let only_before = effects
            .iter()
            .filter(|u| than.unknowns.contains(u) && !together.unknowns.contains(u))
            .count();
        loss_of(&mut self.evaluator, &old, &together.unknowns, together).is_none_or(|old| {
            together.loss(MisfitTerm::Presses) < old + only_before as f64 * TOLD * TOLD
        })
    }

    /// Takes a fit of everything, judged by presses that it is fitted without; not one that reads them clearly worse than the
    /// search does.
    fn take(&mut self, together: Together) -> bool {
        let folds = self.options.folds;
        let mut says = Vec::new();
        if let (Some((_, score)), Some(estimates)) = (
            &mut self.best,
            together.held_out(&mut self.evaluator, folds),
        ) {
            let presses = self.evaluator.evidence.presses.iter();
            let errors_g: Vec<f64> = presses
                .zip(&estimates)
                .map(|(press, says)| (says.load_g - press.load_g).abs())
                .collect();
            let found = Score {
                totals_g: errors_g.clone(),
                errors_g,
                says_g: estimates.iter().map(|says| says.load_g).collect(),
                seen: Vec::new(),
            };
            let (worse_g, standard_errors) = found.worse_than(score);
            let mean_g = stats::mean(score.errors_g.iter().copied()).unwrap_or(0.0);
            if standard_errors > CLEARLY && worse_g > WORSE_BY * mean_g {
                return false;
            }
            says = judged(&self.evaluator, &estimates);
            *score = found;
        }
        self.judged = self.readings(&says);
        self.together = Some(together);
        true
    }

    /// Nothing where a step has no solution.
    fn everything(&mut self, progress: &mut dyn FnMut(&str, f64)) -> Option<Together> {
        self.add_effects();
        self.look_closely(false)?;
        self.choose_scan_order()?;
        self.model.spread_is_believed = true;
        let around = self.around_g()?;
        let mut found = self.turns(progress)?;
        let carry = found.model.get(Unknown::CarryOver);
        let error = found.error_of(Unknown::CarryOver);
        if error.is_some_and(|error| carry <= TOLD * error) {
            // With all else known, the order may be told better.
            let order = self.model.sensor.converter().scan_order;
            self.choose_scan_order()?;
            if self.model.sensor.converter().scan_order != order {
                found = self.turns(progress)?;
            }
        }
        let found = self.leave_out_what_is_not_there(&found, progress)?;
        (self.around_g()? <= MAX_AROUND * around).then_some(found)
    }

    /// Fits the unknowns and the lines in turns, until neither moves.
    fn turns(&mut self, progress: &mut dyn FnMut(&str, f64)) -> Option<Together> {
        let readout = self.model.sensor.readout();
        let are_alike = matches!(readout.r_line_row_ohms, Some(PerLine::One(_)));
        let mut last = None;
        // With lines that resist: the turn by which presses are nearest, how near, and its model.
        let mut best: Option<(usize, f64, Model)> = None;
        let most = if self.model.seeks_lines {
            MAX_TURNS_WITH_LINES
        } else {
            MAX_TURNS
        };
        for turn in 0..most {
            progress("everything together", 0.6 + 0.05 * turn as f64);
            let value = |model: &Model, unknown| match unknown {
                // Shifts, of what was there before.
                Unknown::Columns => model.mean_ohms().0,
                Unknown::Rows => model.mean_ohms().1,
                _ => model.get(unknown),
            };
            let now = |model| self.unknowns.iter().map(|&u| value(model, u)).collect();
            let before: Vec<f64> = now(&self.model);
            let found = self.fit_all(Effort::ROUGH)?;
            if self.can_separate() && (turn >= ALIKE_TURNS || !are_alike) {
                self.separate_all(progress);
            }
            self.look_closely(turn > 0)?;
            let settled = self.unknowns.iter().zip(&before).all(|(&u, before)| {
                let error = found.error_of(u).unwrap_or(0.0);
                (value(&self.model, u) - before).abs() <= SETTLED * error.max(u.step())
            });
            if self.model.seeks_lines {
                let error_g = self.error_on_presses_g()?;
                if best.as_ref().is_none_or(|(_, least, _)| error_g < *least) {
                    best = Some((turn, error_g, self.model.clone()));
                }
            }
            last = Some(found);
            let since = best.as_ref().map_or(0, |(at, _, _)| turn - at);
            if settled && (turn > ALIKE_TURNS || !self.model.seeks_lines) || since > PATIENCE {
                break;
            }
        }
        if let Some((_, _, model)) = best {
            // Lines and switches, rows and columns, turn about each other: the last is not the nearest.
            self.model = model;
            last = Some(self.fit_all(Effort::ROUGH)?);
            self.look_closely(true)?;
        }
        last
    }

    /// The usual size of what is read around presses with nothing near them, grams; 0 where there are too few.
    fn around_g(&mut self) -> Option<f64> {
        if self.alone() < MIN_ALONE {
            return Some(0.0);
        }
        let estimates = self.evaluator.estimates(&self.model)?;
        let sizes = estimates.iter().flat_map(|e| &e.neighbours_g);
        stats::median(sizes.map(|g| g.abs()))
    }

    /// What tells which unknown.
    fn told(&self) -> Told {
        Told {
            switches_by_unloaded: self.can_separate() && !self.by_presses,
            spread_by_presses: self.alone() < MIN_ALONE,
            hearing: self.hearing,
        }
    }

    /// Presses with nothing near them.
    pub(super) fn alone(&self) -> usize {
        self.evaluator.isolated.iter().filter(|&&i| i).count()
    }

    fn fit_all(&mut self, effort: Effort) -> Option<Together> {
        let told = self.told();
        let evaluator = &mut self.evaluator;
        let found = fit_together(evaluator, &self.model, &self.unknowns, told, effort)?;
        self.model = found.model.clone();
        Some(found)
    }

    /// Looks for what is unloaded and alone anew (`again`: where it has changed), and whether the neighbours of a press are quiet enough to be added to it.
    fn look_closely(&mut self, again: bool) -> Option<()> {
        self.evaluator.forces = false;
        if again {
            look_again(&mut self.evaluator, &self.model)?;
        } else {
            self.look().ok()?;
        }
        let estimates = self.evaluator.estimates(&self.model)?;
        let ghosts = estimates.iter().flat_map(|e| &e.ghosts_g).copied();
        let noise = 8f64.sqrt() * robust_deviation(ghosts);
        let loads = self.evaluator.evidence.loads_g();
        self.evaluator.forces = noise < QUIET * stats::median(loads).unwrap_or(0.0);
        Some(())
    }

    /// Makes every effect an unknown that there is evidence of.
    fn add_effects(&mut self) {
        let levels = self.evaluator.evidence.levels.len();
        self.model.law.own_exponents = levels >= 3;
        self.model.levelled = self.can_separate();
        let mut more = Vec::new();
        let asked = matches!(self.options.law, LawChoice::Auto | LawChoice::Saturating);
        if asked && self.model.law.bends.is_empty() {
            more.push(Unknown::Saturation);
        }
        if self.can_separate() && !self.by_presses {
            more.extend(self.model.switches());
        }
        more.extend(SPREAD);
        if self.alone() >= MIN_ALONE {
            more.push(Unknown::CarryOver);
        }
        if self.evaluator.has_unloaded() {
            more.push(Unknown::Offset);
        }
        if levels > 0 {
            // Beside lines that resist too: both pass current between taxels under a uniform load, but lines do so more the
            // farther from their ends, and a film alike everywhere.
            more.extend([Unknown::Sheet, Unknown::SheetContact]);
            self.model.set(Unknown::Sheet, START_SHEET);
        } else {
            let why = "not told by these presses: a uniform load would tell, or labelled presses inside a contact";
            self.note("sheet", false, why.to_owned());
        }
        more.retain(|u| !self.unknowns.contains(u));
        self.unknowns.extend(more);
    }

    /// Fits again without the effects that were not told from nothing, and says what was found.
    fn leave_out_what_is_not_there(
        &mut self,
        found: &Together,
        progress: &mut dyn FnMut(&str, f64),
    ) -> Option<Together> {
        let value = |unknown: Unknown| found.model.get(unknown);
        let told = |unknown: Unknown| {
            found
                .error_of(unknown)
                .is_some_and(|error| value(unknown).abs() > TOLD * error)
        };
        let kept = self.model.spread.map_or(1.0, |spread| spread.kept());
        let spread = SPREAD.into_iter().any(told) && kept < 1.0 - MIN_SHARE;
        let carry = told(Unknown::CarryOver) && value(Unknown::CarryOver) > MIN_SHARE;
        let offset = told(Unknown::Offset) && value(Unknown::Offset).abs() > MIN_OFFSET_COUNTS;
        let saturates = told(Unknown::Saturation) || self.options.law == LawChoice::Saturating;
        let sheet = value(Unknown::Sheet) > MIN_SHEET
            && (told(Unknown::Sheet) || self.is_sheet_told(found));
        let gone = |unknown: &Unknown| match unknown {
            Unknown::SpreadRow | Unknown::SpreadColumn | Unknown::SpreadDiagonal => !spread,
            Unknown::CarryOver => !carry,
            Unknown::Offset => !offset,
            Unknown::Saturation => !saturates,
            Unknown::Sheet | Unknown::SheetContact => !sheet,
            _ => false,
        };
        let stays = [spread, carry, offset, sheet];
        let looked_for = self.unknowns.clone();
        let first = self.words(found, &looked_for, stays);
        if self.unknowns.contains(&Unknown::Saturation) {
            let law = if saturates { "saturating" } else { "power" };
            law.clone_into(&mut self.law);
        }
        let left: Vec<Unknown> = self.unknowns.iter().copied().filter(gone).collect();
        self.unknowns.retain(|u| !left.contains(u));
        for unknown in left {
            match unknown {
                Unknown::SpreadRow => self.model.spread = None,
                Unknown::SpreadColumn | Unknown::SpreadDiagonal | Unknown::SheetContact => {}
                _ => {
                    self.model.set(unknown, 0.0);
                }
            }
        }
        if looked_for.contains(&Unknown::Sheet) && !sheet && found.model.sheet().is_some() {
            // The lines were told apart under a sheet.
            self.turns(progress)?;
        }
        let last = self.fit_all(Effort::FULL)?;
        self.tell_beliefs(found, &last);
        // Of what stays what the last fit found, of what does not what was there before it went.
        let now = self.words(&last, &looked_for, stays);
        for (first, now) in first.into_iter().zip(now) {
            let finding = if now.used { now } else { first };
            self.note(&finding.name, finding.used, finding.text);
        }
        Some(last)
    }

    /// Whether all that is known is clearly less probable without a sheet. Its two numbers stand for each other in a wide
    /// valley, so that neither is told well where both together are.
    fn is_sheet_told(&mut self, found: &Together) -> bool {
        let mut model = found.model.clone();
        if model.set(Unknown::Sheet, 0.0).is_none() {
            return false;
        }
        let is_sheet = |u: &Unknown| matches!(u, Unknown::Sheet | Unknown::SheetContact);
        let unknowns: Vec<Unknown> = self
            .unknowns
            .iter()
            .copied()
            .filter(|u| !is_sheet(u))
            .collect();
        let told = self.told();
        let evaluator = &mut self.evaluator;
        let Some(without) = fit_together(evaluator, &model, &unknowns, told, Effort::ROUGH) else {
            return true;
        };
        let loss = loss_of(evaluator, &without.model, &self.unknowns, found);
        loss.is_none_or(|loss| loss > found.loss(MisfitTerm::Presses) + SHEET_TOLD)
    }

    /// Takes the order of the scan that explains what surrounds presses best.
    fn choose_scan_order(&mut self) -> Option<()> {
        if !self.unknowns.contains(&Unknown::CarryOver) {
            return Some(());
        }
        let unknowns = [SPREAD.as_slice(), &[Unknown::CarryOver]].concat();
        let mut fits: Vec<Together> = Vec::new();
        for order in [ScanOrder::RowByRow, ScanOrder::ColumnByColumn] {
            let mut model = self.model.clone();
            model
                .sensor
                .try_out(|spec| spec.converter.scan_order = order);
            // A model without a sheet says too little of presses for them to be asked.
            let told = Told {
                hearing: Hearing::Own,
                ..self.told()
            };
            let evaluator = &mut self.evaluator;
            fits.push(fit_together(
                evaluator,
                &model,
                &unknowns,
                told,
                Effort::ROUGH,
            )?);
        }
        let loss = |fit: &Together| fit.loss_in_scales_of(MisfitTerm::Surroundings, &fits[0]);
        // No reading keeps less than nothing of the one before.
        let kept = [&fits[0], &fits[1]].map(|fit| fit.model.get(Unknown::CarryOver) > 0.0);
        let best = match kept {
            [true, false] => 0,
            [false, true] => 1,
            _ => usize::from(loss(&fits[1]) < loss(&fits[0])),
        };
        self.model = fits[best].model.clone();
        Some(())
    }
}

/// Fewest presses with nothing near them that stand for all in what a load is uncertain by.
const MIN_FORCES: usize = 40;

/// Whether what loads are uncertain by is judged by presses with nothing near them alone, as forces: there are enough of them,
/// and a press beside its taxel is no fault of the sensor.
pub(super) fn judges_forces(evaluator: &Evaluator) -> bool {
    let alone = evaluator.isolated.iter().filter(|&&i| i).count();
    evaluator.forces && alone >= MIN_FORCES
}

/// What presses are read as, of those that are judged by.
pub(super) fn judged(evaluator: &Evaluator, estimates: &[PressEstimate]) -> Vec<Option<f64>> {
    let forces = judges_forces(evaluator);
    let presses = estimates.iter().zip(&evaluator.isolated);
    presses
        .map(|(says, isolated)| match (forces, *isolated) {
            (false, _) => Some(says.load_g),
            (true, isolated) => isolated.then_some(says.force_g),
        })
        .collect()
}
