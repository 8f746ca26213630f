//! Everything fitted together at once, from circuit and law alone: the short way of a search, taken where uniform loads tell every
//! switch apart. Effects that are tried one after the other take twice the time, and end no nearer.

use super::LawChoice;
use super::choose::Search;
use super::effects::{INNER_KNOTS, SPREAD, is_better};
use super::fit::{Effort, Fitted, Score, refine};
use super::model::{Model, Unknown};
use crate::Error;

/// The law that bends freely, by its name.
const SPLINE: &str = "spline";
/// Exponents that differ by less are alike.
const MIN_DEVIATION: f64 = 1e-3;
/// It is worth another fit of everything where held-out presses are nearer by this share.
const WORTHWHILE: f64 = 0.05;

impl Search<'_> {
    /// Everything together from circuit and law alone, and the law bent where held-out presses gain by that. False, and nothing is
    /// changed, where that says too little.
    pub(super) fn goes_together(
        &mut self,
        progress: &mut dyn FnMut(&str, f64),
    ) -> Result<bool, Error> {
        if self.options.law == LawChoice::Spline {
            return Ok(false);
        }
        let before = self.before();
        self.polish(progress)?;
        if self.together.is_none() {
            return Ok(false);
        }
        if self.explains().is_err() {
            self.go_back_to(&before);
            self.score_held_out()?;
            return Ok(false);
        }
        self.note_exponents();
        if self.options.law == LawChoice::Auto {
            self.try_bend(progress);
        }
        Ok(true)
    }

    /// Says by how much taxels differ in their exponents: it is part of the model, and comes out near nothing where they do not.
    fn note_exponents(&mut self) {
        let material = self.evaluator.material(&self.model);
        let levels = self.evaluator.evidence.levels.len();
        if let Some(material) = material.filter(|_| self.model.law.own_exponents) {
            let deviation = material.exponent_deviation;
            let text = format!("standard deviation {deviation:.4}, by {levels} uniform loads");
            self.note("exponent per taxel", deviation >= MIN_DEVIATION, text);
        }
    }

    /// Whether a law that bends freely reads held-out presses better than the one that everything was fitted with, circuit and
    /// all else as they are; then everything is fitted again with it.
    fn try_bend(&mut self, progress: &mut dyn FnMut(&str, f64)) {
        let is_of_law = |u: &Unknown| !u.moves_frames() && !SPREAD.contains(u);
        let bends = (1..=INNER_KNOTS).map(Unknown::Bend);
        let bent_instead = |unknowns: &[Unknown]| -> Vec<Unknown> {
            let others = unknowns.iter().copied();
            let others = others.filter(|u| *u != Unknown::Saturation);
            others.chain(bends.clone()).collect()
        };
        let of_law: Vec<Unknown> = self.unknowns.iter().copied().filter(is_of_law).collect();
        let mut bent = self.model.clone();
        bent.law.saturation = 0.0;
        self.knots(&mut bent);
        let Some((_, now)) = self.with_law(&self.model.clone(), &of_law) else {
            return;
        };
        let Some((fitted, score)) = self.with_law(&bent, &bent_instead(&of_law)) else {
            return;
        };
        self.laws = vec![
            (self.law.clone(), now.mean_error()),
            (SPLINE.to_owned(), score.mean_error()),
        ];
        let (gain, errors) = now.worse_than(&score);
        if !is_better(gain, errors) || gain < WORTHWHILE * now.mean_error() {
            return;
        }
        let before = self.before();
        let kept = (
            self.together.take(),
            self.best.take(),
            std::mem::take(&mut self.judged),
            std::mem::take(&mut self.beliefs),
        );
        self.model = fitted.model.clone();
        self.unknowns = bent_instead(&self.unknowns);
        SPLINE.clone_into(&mut self.law);
        self.best = Some((fitted, score));
        let gains = |old: &Score, new: &Score| old.worse_than(new).0 > 0.0;
        let is_nearer = self.polish(progress).is_ok()
            && self.together.is_some()
            && matches!((&kept.1, &self.best), (Some((_, old)), Some((_, new))) if gains(old, new));
        if is_nearer {
            self.laws[1].1 = self.error_g();
        } else {
            self.go_back_to(&before);
            (self.together, self.best, self.judged, self.beliefs) = kept;
        }
    }

    /// A fit of the law alone, and its errors on held-out presses.
    fn with_law(&mut self, model: &Model, unknowns: &[Unknown]) -> Option<(Fitted, Score)> {
        let fitted = refine(&mut self.evaluator, model, unknowns, Effort::Rough)?;
        let score = fitted.cross_validate(&mut self.evaluator, self.options.folds)?;
        Some((fitted, score))
    }
}
