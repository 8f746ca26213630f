//! How good a fit is, by presses that neither fitted nor chose it.

use super::super::discrepancy::{Judged, least_noise_g};
use super::super::evidence::Evidence;
use super::super::outcome::HeldOut;
use super::fit::plain_law;
use super::known::KnownFrames;
use super::{Chosen, PressFit};
use crate::Sensor;
use crate::material::LoadLaw;
use crate::parallel::par_map;

impl PressFit<'_> {
    /// Errors on presses that no fit has seen, and those of each law.
    pub(super) fn judged_by_spare(
        &self,
        spare: Vec<usize>,
        chosen: &Chosen,
    ) -> (HeldOut, Vec<(String, f64)>) {
        let fold = self.scores(chosen, chosen, &spare);
        let laws = fold.laws.into_iter();
        let held = HeldOut {
            how: format!(
                "{} presses that neither fitted nor chose; a fit of this array takes no more than it did",
                spare.len()
            ),
            errors_g: fold.errors_g,
            judged: fold.judged,
            origin: Vec::new(),
            unjudged: fold.unjudged,
        };
        (
            held,
            laws.map(|(name, e)| (name.to_owned(), super::super::fit::mean(&e)))
                .collect(),
        )
    }

    /// Errors on presses that neither fitted nor chose: each fold is read by a fit and a choice made without it. With
    /// them, those of each law.
    pub(super) fn held_out(
        &self,
        known: &KnownFrames,
        chosen: &Chosen,
        progress: &mut dyn FnMut(&str, f64),
    ) -> (HeldOut, Vec<(String, f64)>) {
        let presses = &self.evidence.presses;
        let mut used: Vec<usize> = known
            .frames
            .iter()
            .flat_map(|f| f.presses.clone())
            .collect();
        used.extend(&known.crowded);
        let mut frames: Vec<usize> = used.iter().map(|&p| presses[p].frame).collect();
        frames.sort_unstable();
        frames.dedup();
        let folds = self.options.folds.clamp(2, frames.len().max(2));
        let fold_of = |p: usize| frames.partition_point(|&f| f < presses[p].frame) % folds;
        progress("held-out presses", 0.5);
        let scores = par_map(self.executor, (0..folds).collect(), |fold| {
            let held = used.iter().copied().filter(|&p| fold_of(p) == fold);
            Some(self.score_fold(&known.with(|p| fold_of(p) != fold), held.collect(), chosen))
        });
        let mut held = HeldOut {
            how: format!(
                "{folds} folds, split by press; each judged by a fit and a choice of law made without it{}",
                if self.with_lines {
                    "; that lines resist was told by all of them"
                } else {
                    ""
                }
            ),
            ..HeldOut::default()
        };
        let mut laws: Vec<(String, Vec<f64>)> = Vec::new();
        for fold in scores.unwrap_or_default() {
            held.unjudged += fold.unjudged;
            held.errors_g.extend(&fold.errors_g);
            held.judged.extend(&fold.judged);
            for (name, errors) in fold.laws {
                match laws.iter_mut().find(|(known, _)| known == name) {
                    Some((_, all)) => all.extend(errors),
                    None => laws.push((name.to_owned(), errors)),
                }
            }
        }
        let means = laws
            .into_iter()
            .map(|(name, e)| (name, super::super::fit::mean(&e)));
        (held, means.collect())
    }

    /// Errors on the presses of one fold, by a fit and a choice made from the others.
    fn score_fold(&self, others: &KnownFrames, held: Vec<usize>, near: &Chosen) -> Fold {
        match self.choose(others, Some(near)) {
            Ok(chosen) => self.scores(&chosen, near, &held),
            Err(_) => Fold {
                unjudged: held.len(),
                ..Fold::default()
            },
        }
    }

    /// Errors of every law's fit on presses that it has not seen.
    fn scores(&self, chosen: &Chosen, near: &Chosen, held: &[usize]) -> Fold {
        let mut fold = Fold::default();
        for (at, (name, fitted)) in chosen.fits.iter().enumerate() {
            let read = self.read(held, fitted, near);
            let law = plain_law(&fitted.model);
            let read: Vec<Judged> = held
                .iter()
                .zip(&read)
                .filter_map(|(&p, &says_g)| {
                    Some(judged(
                        self.evidence,
                        &fitted.model.sensor,
                        &law,
                        p,
                        says_g?,
                    ))
                })
                .collect();
            let errors: Vec<f64> = read.iter().map(|j| (j.says_g - j.load_g).abs()).collect();
            if at == chosen.at {
                fold.unjudged = held.len() - errors.len();
                fold.errors_g.clone_from(&errors);
                fold.judged = read;
            }
            fold.laws.push((name, errors));
        }
        fold
    }
}

/// A press and what is read of it, grams.
pub(super) fn judged(
    evidence: &Evidence,
    sensor: &Sensor,
    law: &LoadLaw,
    place: usize,
    says_g: f64,
) -> Judged {
    let press = evidence.presses[place];
    Judged {
        press: place,
        frame: press.frame,
        load_g: press.load_g,
        says_g,
        noise_g: least_noise_g(sensor, law, evidence.noise_counts, 0, press.load_g),
    }
}

/// Errors on one fold, grams: of the law chosen, and of each.
#[derive(Default)]
struct Fold {
    errors_g: Vec<f64>,
    judged: Vec<Judged>,
    unjudged: usize,
    laws: Vec<(&'static str, Vec<f64>)>,
}
