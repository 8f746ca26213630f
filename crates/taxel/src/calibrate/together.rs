//! Every unknown of a model at once: the most probable values, each told by its own evidence and by what is believed of
//! it beforehand.
//!
//! Either an unknown listens to one kind of evidence alone ([`MisfitTerm`]), so that none is bent to make up for a fault in
//! the model that another kind shows: a posterior with cut feedback (Liu, Bayarri and Berger 2009). Or all listen to all,
//! many residuals of one frame counting as few: one posterior, whose loss falls in every step, and that is found from
//! farther away. The equations of all unknowns, J_kᵀ W r = 0 with the prior's slope, are solved together by Newton's method
//! with the derivative of each kind of evidence by every unknown; their covariance is that of such estimating equations,
//! A⁻¹ B A⁻ᵀ (Huber 1967).

mod held_out;
#[cfg(test)]
mod tests;

use super::equations::{covariance, equations, solve, told_by};
use super::evaluate::{Evaluator, PressEstimate};
use super::least_squares::weights;
use super::model::{Model, Unknown};
use super::scatter::{MIN_SCATTER_G, press_scales, size};
use super::terms::{MisfitTerm, Told};

/// Residuals beyond this many standard deviations count linearly.
const HUBER: f64 = 2.5;
/// A step is too long where a kind of evidence loses so many times what it had lost.
const MAX_RISE: f64 = 1.5;
/// Where there is one loss, what keeps an unknown where it is, as a part of what a step of its whole reach costs.
const STAY: f64 = 0.01;
/// Halvings of a step that leads nowhere.
const MAX_HALVINGS: usize = 6;

/// A fitted model, and the linear map around it that cross-validation and errors use.
pub(super) struct Together {
    pub(super) model: Model,
    pub(super) unknowns: Vec<Unknown>,
    hears: Hears,
    point: Point,
    /// One row for each unknown, of the derivative of all residuals.
    slopes: Vec<Residuals>,
    covariance: Vec<f64>,
}

/// How much of each kind of evidence every unknown hears.
#[derive(Debug, Clone)]
struct Hears {
    of: Vec<[f64; 3]>,
    /// What each kind counts for in one loss, where there is one.
    loss: Option<[f64; 3]>,
}

impl Hears {
    fn new(unknowns: &[Unknown], told: Told, point: &Point) -> Self {
        let each = point.owners.each_ref().map(|owners| {
            let mut presses = owners.clone();
            presses.dedup();
            owners.len() as f64 / presses.len().max(1) as f64
        });
        Self {
            of: unknowns.iter().map(|&u| told.hears(u, each)).collect(),
            loss: told.counts(each),
        }
    }

    /// Whether a step is worth taking by what it makes of the losses: one loss falls; else each kind of evidence is heard by
    /// its own unknowns alone, so that one may lose what others gain.
    fn is_bearable(&self, now: &[f64; 4], before: &[f64; 4]) -> bool {
        if let Some(counts) = self.loss {
            let total = |losses: &[f64; 4]| -> f64 {
                losses[3] + losses.iter().zip(counts).map(|(l, c)| l * c).sum::<f64>()
            };
            return total(now) < total(before);
        }
        let bearable = |(now, before): (&f64, &f64)| *now <= MAX_RISE * before + 10.0;
        now.iter().zip(before).all(bearable)
    }
}

/// Scaled residuals of the three kinds of evidence, and of beliefs.
#[derive(Debug, Clone, Default)]
pub(super) struct Residuals {
    pub(super) of_terms: [Vec<f64>; 3],
    pub(super) beliefs: Vec<f64>,
    /// ln of what stands around each press, so that its derivative tells by how much of it contacts would change.
    contacts: Vec<f64>,
}

/// A model, what it says, and how much of it is believed.
pub(super) struct Point {
    pub(super) residuals: Residuals,
    pub(super) weights: [Vec<f64>; 3],
    scales: [Vec<f64>; 3],
    /// Which press each residual belongs to.
    owners: [Vec<usize>; 3],
}

/// How far to go.
#[derive(Debug, Clone, Copy)]
pub(super) struct Effort {
    /// How often the derivative is computed, at most.
    derivatives: usize,
    /// Steps with each, beyond the first.
    chords: usize,
    /// Ends when no unknown moves by more than so many of its small steps.
    precision: f64,
}

impl Effort {
    /// On the way.
    pub(super) const ROUGH: Self = Self {
        derivatives: 2,
        chords: 1,
        precision: 1.0,
    };
    /// To the end.
    pub(super) const FULL: Self = Self {
        derivatives: 3,
        chords: 2,
        precision: 0.3,
    };

    fn is_rough(self) -> bool {
        self.derivatives < Self::FULL.derivatives
    }
}

/// Fits these unknowns of a model, together. Nothing where the model is impossible from the start.
pub(super) fn fit_together(
    evaluator: &mut Evaluator,
    model: &Model,
    unknowns: &[Unknown],
    told: Told,
    effort: Effort,
) -> Option<Together> {
    let mut model = model.clone();
    let mut estimates = evaluator.estimates(&model)?;
    let mut point = Point::new(evaluator, &model, unknowns, &estimates);
    let hears = Hears::new(unknowns, told, &point);
    let may_hold = effort.is_rough();
    let mut slopes = slopes_at(evaluator, (&model, unknowns), &point, may_hold)?;
    'all: for derivative in 0..effort.derivatives {
        if derivative > 0 {
            point = Point::new(evaluator, &model, unknowns, &estimates);
            slopes = slopes_at(evaluator, (&model, unknowns), &point, may_hold)?;
        }
        // So near, the derivative is the same for a few steps.
        for chord in 0..=effort.chords {
            let step = newton_step((&model, unknowns), &hears, &point, &slopes, |_, _| true)?;
            let taken = take_step(evaluator, (&model, unknowns), &hears, &step, &point);
            let Some((moved, there, length)) = taken else {
                if chord == 0 {
                    break 'all;
                }
                break;
            };
            (model, estimates) = (moved, there);
            point = point.at(evaluator, &model, unknowns, &estimates);
            let small =
                |(u, s): (&Unknown, &f64)| (length * s).abs() <= effort.precision * u.step();
            if unknowns.iter().zip(&step).all(small) {
                break 'all;
            }
        }
    }
    point = Point::new(evaluator, &model, unknowns, &estimates);
    let covariance = covariance(&hears.of, &point, &slopes);
    Some(Together {
        unknowns: unknowns.to_vec(),
        model,
        hears,
        point,
        slopes,
        covariance,
    })
}

/// −2 ln of the posterior of what labelled loads say of another model, in the scales of a fit.
pub(super) fn loss_of(
    evaluator: &mut Evaluator,
    model: &Model,
    unknowns: &[Unknown],
    common: &Together,
) -> Option<f64> {
    let estimates = evaluator.estimates(model)?;
    let point = common.point.at(evaluator, model, unknowns, &estimates);
    let residuals = &point.residuals;
    let beliefs: f64 = residuals.beliefs.iter().map(|b| b * b).sum();
    Some(weights(&residuals.of_terms[MisfitTerm::Presses as usize], HUBER).1 + beliefs)
}

impl Point {
    fn new(
        evaluator: &Evaluator,
        model: &Model,
        unknowns: &[Unknown],
        estimates: &[PressEstimate],
    ) -> Self {
        let raw = MisfitTerm::ALL.map(|term| term.residuals(evaluator, estimates));
        let mut scales = [Vec::new(), Vec::new(), Vec::new()];
        for ((term, raw), scales) in MisfitTerm::ALL.iter().zip(&raw).zip(&mut scales) {
            *scales = match term {
                MisfitTerm::Presses => press_scales(&evaluator.evidence.loads_g(), raw),
                _ => vec![size(raw).max(MIN_SCATTER_G); raw.len()],
            };
        }
        let residuals = Residuals::new(evaluator, model, unknowns, estimates, &scales);
        let weights = std::array::from_fn(|i| weights(&residuals.of_terms[i], HUBER).0);
        Self {
            residuals,
            weights,
            scales,
            owners: MisfitTerm::ALL.map(|term| term.owners(estimates)),
        }
    }

    /// Another model in the scales of this point.
    fn at(
        &self,
        evaluator: &Evaluator,
        model: &Model,
        unknowns: &[Unknown],
        estimates: &[PressEstimate],
    ) -> Self {
        let residuals = Residuals::new(evaluator, model, unknowns, estimates, &self.scales);
        Self {
            weights: std::array::from_fn(|i| weights(&residuals.of_terms[i], HUBER).0),
            residuals,
            scales: self.scales.clone(),
            owners: self.owners.clone(),
        }
    }

    /// −2 ln of the likelihood of each kind of evidence and of the beliefs, but for constants.
    fn losses(residuals: &Residuals) -> [f64; 4] {
        let [a, b, c] = &residuals.of_terms;
        let of = |list: &[f64]| weights(list, HUBER).1;
        let beliefs = residuals.beliefs.iter().map(|b| b * b).sum();
        [of(a), of(b), of(c), beliefs]
    }
}

impl Residuals {
    fn new(
        evaluator: &Evaluator,
        model: &Model,
        unknowns: &[Unknown],
        estimates: &[PressEstimate],
        scales: &[Vec<f64>; 3],
    ) -> Self {
        let of_terms = std::array::from_fn(|i| {
            let mut residuals = MisfitTerm::ALL[i].residuals(evaluator, estimates);
            for (residual, scale) in residuals.iter_mut().zip(&scales[i]) {
                *residual /= scale;
            }
            residuals
        });
        Self {
            of_terms,
            beliefs: model.surprises(unknowns),
            contacts: estimates
                .iter()
                .map(|estimate| estimate.together_g.max(1.0).ln())
                .collect(),
        }
    }
}

impl Residuals {
    /// As many, of what depends on nothing.
    fn nothing(&self) -> Self {
        let zeros = |list: &Vec<f64>| vec![0.0; list.len()];
        Self {
            of_terms: self.of_terms.each_ref().map(zeros),
            beliefs: zeros(&self.beliefs),
            contacts: zeros(&self.contacts),
        }
    }
}

/// The derivative of every residual by every unknown, one-sided differences. One that can move nowhere is held where it is, on the way
/// (`may_hold`); at the end there is no answer then.
fn slopes_at(
    evaluator: &mut Evaluator,
    (model, unknowns): (&Model, &[Unknown]),
    point: &Point,
    may_hold: bool,
) -> Option<Vec<Residuals>> {
    let mut slopes = Vec::with_capacity(unknowns.len());
    for &unknown in unknowns {
        let value = model.get(unknown);
        // Beside its range and beside frames without a solution there may be little room.
        let found = [1.0, -1.0, 0.1, -0.1, 0.01, -0.01]
            .into_iter()
            .find_map(|part| {
                let step = part * unknown.difference();
                let mut moved = model.clone();
                moved.set(unknown, value + step)?;
                let estimates = evaluator.estimates(&moved)?;
                Some((moved, estimates, step))
            });
        let Some((moved, estimates, step)) = found else {
            if !may_hold {
                return None;
            }
            slopes.push(point.residuals.nothing());
            continue;
        };
        let mut there = Residuals::new(evaluator, &moved, unknowns, &estimates, &point.scales);
        let here = &point.residuals;
        let lists = there.of_terms.iter_mut().zip(&here.of_terms);
        for (there, here) in lists.chain([
            (&mut there.beliefs, &here.beliefs),
            (&mut there.contacts, &here.contacts),
        ]) {
            for (there, here) in there.iter_mut().zip(here) {
                *there = (*there - here) / step;
            }
        }
        slopes.push(there);
    }
    Some(slopes)
}

/// Newton's step of all equations, over the residuals for which `keep` (kind, residual) holds; an unknown that would leave
/// its range stops at its end.
fn newton_step(
    (model, unknowns): (&Model, &[Unknown]),
    hears: &Hears,
    point: &Point,
    slopes: &[Residuals],
    keep: impl Fn(usize, usize) -> bool,
) -> Option<Vec<f64>> {
    let n = unknowns.len();
    let (mut matrix, right) = equations(&hears.of, point, slopes, &keep);
    if hears.loss.is_some() {
        for (k, unknown) in unknowns.iter().enumerate() {
            matrix[k * (n + 1)] += STAY / unknown.reach().powi(2);
        }
    }
    let mut fixed: Vec<Option<f64>> = vec![None; n];
    loop {
        let (mut reduced, mut wanted) = (matrix.clone(), right.clone());
        for (k, fixed) in fixed.iter().enumerate() {
            if let Some(step) = fixed {
                reduced[k * n..(k + 1) * n].fill(0.0);
                reduced[k * n + k] = 1.0;
                wanted[k] = *step;
            }
        }
        let step = solve(&reduced, &wanted)?;
        let mut stopped = false;
        for (k, &unknown) in unknowns.iter().enumerate() {
            let value = model.get(unknown);
            let [least, most] = model.range(unknown);
            if fixed[k].is_none() && !(least..=most).contains(&(value + step[k])) {
                // One that ends at its bound would else make the whole step impossible.
                fixed[k] = Some((value + step[k]).clamp(least, most) - value);
                stopped = true;
            }
        }
        if !stopped {
            return Some(step);
        }
        hold_what_means_nothing(unknowns, &mut fixed);
    }
}

/// The contact factor of a sheet that is about to go is told by nothing: its step would only shorten that of all others.
fn hold_what_means_nothing(unknowns: &[Unknown], fixed: &mut [Option<f64>]) {
    let place = |unknown: Unknown| unknowns.iter().position(|&u| u == unknown);
    if let (Some(sheet), Some(contact)) = (place(Unknown::Sheet), place(Unknown::SheetContact))
        && fixed[sheet].is_some()
    {
        fixed[contact] = Some(0.0);
    }
}

/// The model after a step, or after a part of it that is possible and does not lead clearly away.
fn take_step(
    evaluator: &mut Evaluator,
    (model, unknowns): (&Model, &[Unknown]),
    hears: &Hears,
    step: &[f64],
    point: &Point,
) -> Option<(Model, Vec<PressEstimate>, f64)> {
    let before = Point::losses(&point.residuals);
    let mut length = longest(unknowns, step);
    for _ in 0..MAX_HALVINGS {
        let moved = unknowns
            .iter()
            .zip(step)
            .try_fold(model.clone(), |mut moved, (&u, step)| {
                // Rounding may lead a hair beyond its range.
                let [least, most] = model.range(u);
                moved.set(u, (model.get(u) + length * step).clamp(least, most))?;
                Some(moved)
            });
        if let Some(moved) = moved
            && let Some(estimates) = evaluator.estimates(&moved)
        {
            let there = Residuals::new(evaluator, &moved, unknowns, &estimates, &point.scales);
            if hears.is_bearable(&Point::losses(&there), &before) {
                return Some((moved, estimates, length));
            }
        }
        length *= 0.5;
    }
    None
}

/// The share of a step that moves no unknown farther than the model is trusted to be linear.
fn longest(unknowns: &[Unknown], step: &[f64]) -> f64 {
    let share = |(u, s): (&Unknown, &f64)| u.reach() / s.abs().max(1e-300);
    unknowns.iter().zip(step).map(share).fold(1.0, f64::min)
}

impl Together {
    fn place(&self, unknown: Unknown) -> Option<usize> {
        self.unknowns.iter().position(|&u| u == unknown)
    }

    /// Standard error of a fitted unknown.
    pub(super) fn error_of(&self, unknown: Unknown) -> Option<f64> {
        let at = self.place(unknown)?;
        Some(
            self.covariance[at * (self.unknowns.len() + 1)]
                .max(0.0)
                .sqrt(),
        )
    }

    /// Standard error of a contact's load by all that is fitted together, a share of it: the usual one of the contacts that
    /// were pressed. Nothing where there was none.
    pub(super) fn error_of_contacts(&self) -> Option<f64> {
        let n = self.unknowns.len();
        let variance = |i: usize| -> f64 {
            let slope = |k: usize| self.slopes[k].contacts[i];
            let row = |k: usize| {
                (0..n)
                    .map(|l| self.covariance[k * n + l] * slope(l))
                    .sum::<f64>()
            };
            (0..n).map(|k| slope(k) * row(k)).sum()
        };
        let contacts = &self.point.residuals.contacts;
        let pressed = (0..contacts.len()).filter(|&i| contacts[i] > 0.0);
        crate::stats::median(pressed.map(variance)).map(|variance| variance.max(0.0).sqrt())
    }

    /// For each unknown, the parts of what is known of it from what surrounds lone presses, unloaded taxels, labels, beliefs.
    pub(super) fn told_by(&self) -> Vec<[f64; 4]> {
        told_by(&self.hears.of, &self.point, &self.slopes)
    }

    /// Correlation of two fitted unknowns.
    pub(super) fn correlation(&self, a: Unknown, b: Unknown) -> Option<f64> {
        let (i, j, n) = (self.place(a)?, self.place(b)?, self.unknowns.len());
        let c = &self.covariance;
        Some(c[i * n + j] / (c[i * n + i] * c[j * n + j]).sqrt())
    }

    /// −2 ln of the posterior of one kind of evidence, but for a constant.
    pub(super) fn loss(&self, term: MisfitTerm) -> f64 {
        let beliefs = &self.point.residuals.beliefs;
        weights(&self.point.residuals.of_terms[term as usize], HUBER).1
            + beliefs.iter().map(|b| b * b).sum::<f64>()
    }

    /// The same of what surrounds presses or is unloaded, in the scales of another fit.
    pub(super) fn loss_in_scales_of(&self, term: MisfitTerm, common: &Self) -> f64 {
        let kind = term as usize;
        let own = self.point.residuals.of_terms[kind].iter();
        let scales = self.point.scales[kind]
            .iter()
            .zip(&common.point.scales[kind]);
        let scaled: Vec<f64> = own
            .zip(scales)
            .map(|(r, (own, common))| r * own / common)
            .collect();
        weights(&scaled, HUBER).1
    }
}
