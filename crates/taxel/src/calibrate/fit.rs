//! Fits a model's unknowns to the presses, and judges it on presses that it has not seen.

use super::LawChoice;
use super::evaluate::{Evaluator, GHOSTS};
use super::fit_law::fit_law;
use super::least_squares::{Fit, Settings, fit, median, robust_deviation, step};
use super::model::{Model, Unknown, any_moves_frames, with_switches};
use super::readable::LinesAtCeiling;
use super::terms::{MisfitTerm, Told};
use crate::sensor::PerLine;
use crate::stats;

/// Smallest scatter that residuals of a class are scaled by, grams.
const MIN_SCATTER_G: f64 = 1e-3;
/// Loads below this count as none, grams, when unloaded taxels are looked for.
const NEXT_TO_NOTHING_G: f64 = 2.0;
/// Load at which an unloaded taxel's conductance is turned into grams, by the secant.
const GHOST_LOAD_G: f64 = 20.0;

/// A fitted model, and the linear map around it that cross-validation uses.
pub(super) struct Fitted {
    /// The answer.
    pub(super) model: Model,
    pub(super) unknowns: Vec<Unknown>,
    blocks: Vec<Block>,
}

/// Unknowns that one kind of evidence tells.
struct Block {
    term: MisfitTerm,
    unknowns: Vec<Unknown>,
    scatter: f64,
    fit: Fit,
}

/// Errors on presses that the fit had not seen.
#[derive(Debug, Clone, Default)]
pub(super) struct Score {
    /// Of each press: absolute error of its load, grams.
    pub(super) errors_g: Vec<f64>,
    /// Of each press: that, plus the mean size of what is wrongly seen around it and on unloaded taxels.
    pub(super) totals_g: Vec<f64>,
    /// Of each press: what it was read as, grams.
    pub(super) says_g: Vec<f64>,
    /// Presses whose fold had no step of its own: what judges them has seen them.
    pub(super) seen: Vec<usize>,
}

impl Score {
    pub(super) fn mean_error(&self) -> f64 {
        mean(&self.errors_g)
    }

    /// By how much its errors are larger than another score's, on average, and by how many standard errors, press by press.
    pub(super) fn error_above(&self, other: &Score) -> (f64, f64) {
        let pairs = self.errors_g.iter().zip(&other.errors_g);
        let differences: Vec<f64> = pairs.map(|(a, b)| a - b).collect();
        let gain = mean(&differences);
        (gain, gain / standard_error(&differences).max(1e-12))
    }

    /// Mean total, and by how many standard errors another score is better, press by press.
    pub(super) fn worse_than(&self, other: &Score) -> (f64, f64) {
        let differences: Vec<f64> = self
            .totals_g
            .iter()
            .zip(&other.totals_g)
            .map(|(a, b)| a - b)
            .collect();
        let gain = mean(&differences);
        (gain, gain / standard_error(&differences).max(1e-12))
    }
}

pub(super) fn mean(values: &[f64]) -> f64 {
    stats::mean(values.iter().copied()).unwrap_or(0.0)
}

pub(super) fn standard_error(values: &[f64]) -> f64 {
    stats::standard_error(values).unwrap_or(0.0)
}

/// Switch resistances tried as a start, ohms, ascending: too large a one makes frames infeasible.
const STARTS_OHMS: [f64; 12] = [
    0.5, 1.0, 2.0, 4.0, 7.0, 12.0, 20.0, 35.0, 60.0, 110.0, 200.0, 400.0,
];

/// The best start for both switch resistances, by the scatter that a power law leaves;
/// the file's own numbers are a start among others.
pub(super) fn coarse(evaluator: &mut Evaluator, model: &Model) -> Option<Model> {
    let all = evaluator.evidence.presses.len() + evaluator.evidence.levels.len();
    let part: Vec<usize> = (0..all).collect();
    let mut starts: Vec<(PerLine, PerLine)> = STARTS_OHMS
        .iter()
        .map(|&ohms| (PerLine::One(ohms), PerLine::One(ohms)))
        .collect();
    let readout = model.sensor.readout();
    if let (Some(column), Some(row)) = (&readout.r_mux_column_ohms, &readout.r_mux_row_ohms) {
        starts.push((column.clone(), row.clone()));
    }
    let mut best: Option<(f64, Model)> = None;
    for (column, row) in starts {
        let mut model = model.clone();
        model.sensor = with_switches(&model.sensor, column, row);
        let Some((scatter, model)) = with_power_law(evaluator, model, &part) else {
            continue;
        };
        if best.as_ref().is_none_or(|(least, _)| scatter < *least) {
            best = Some((scatter, model));
        }
    }
    best.map(|(_, model)| model)
}

/// A model with the power law that suits its conductances, and the scatter left, grams.
fn with_power_law(
    evaluator: &mut Evaluator,
    mut model: Model,
    part: &[usize],
) -> Option<(f64, Model)> {
    let evidence = evaluator.evidence;
    let seen = evaluator.invert(&model.sensor, part, |i, siemens| {
        // Uniform frames are there because they are the first to become infeasible.
        let press = evidence.presses.get(i)?;
        let mut values = siemens.values().to_vec();
        let fifth = values.len() / 5;
        let quiet = *values.select_nth_unstable_by(fifth, f64::total_cmp).1;
        Some(((siemens.at(press.row, press.column), press.load_g), quiet))
    })?;
    let (pairs, quiet): (Vec<(f64, f64)>, Vec<f64>) = seen.into_iter().flatten().unzip();
    let (law, fitted) = fit_law(LawChoice::Power, &pairs, Some(median(&quiet)))?;
    model.law.g_zero = law.g_zero;
    model.law.ln_factor = law.ln_scale[0];
    model.law.exponent = law.exponent[0];
    Some((robust_deviation(&fitted.residuals), model))
}

/// Looks for presses with nothing near them, and for unloaded taxels in every frame: those with the largest
/// raw readings, which are ghosts, and some others.
pub(super) fn look_around(evaluator: &mut Evaluator, model: &Model) -> Option<()> {
    look(evaluator, model, false)
}

/// The same, but a frame's unloaded taxels stay while all of them are still unloaded.
pub(super) fn look_again(evaluator: &mut Evaluator, model: &Model) -> Option<()> {
    look(evaluator, model, true)
}

fn look(evaluator: &mut Evaluator, model: &Model, stays: bool) -> Option<()> {
    let law = evaluator.law(model)?;
    let (rows, columns) = (model.sensor.rows(), model.sensor.columns());
    let presses = evaluator.evidence.presses.len();
    let evidence = evaluator.evidence;
    let all: Vec<usize> = (0..presses).collect();
    let before = evaluator.unloaded.clone();
    let seen = evaluator.invert(&model.sensor, &all, |i, siemens| {
        let press = evidence.presses[i];
        let mut near = vec![0u8; rows * columns];
        let mut alone = press.load_g > 10.0 * NEXT_TO_NOTHING_G;
        for (taxel, &g) in siemens.values().iter().enumerate() {
            if law.grams_from_siemens(taxel, g) < NEXT_TO_NOTHING_G {
                continue;
            }
            let (r, c) = (taxel / columns, taxel % columns);
            let away = r.abs_diff(press.row).max(c.abs_diff(press.column));
            alone &= !(2..=4).contains(&away);
            for r in r.saturating_sub(2)..(r + 3).min(rows) {
                for c in c.saturating_sub(2)..(c + 3).min(columns) {
                    near[r * columns + c] = 1;
                }
            }
        }
        if stays && !before[i].is_empty() && before[i].iter().all(|&t| near[t] == 0) {
            return (alone, before[i].clone());
        }
        let counts = &evidence.frames[i];
        let at_ceiling = LinesAtCeiling::of(counts);
        let mut quiet: Vec<usize> = (0..rows * columns)
            .filter(|&t| near[t] == 0 && counts.marks()[t] == crate::Mark::Good)
            .filter(|&t| !at_ceiling.cross_at(t / columns, t % columns))
            .collect();
        quiet.sort_by(|&a, &b| counts.values()[b].total_cmp(&counts.values()[a]));
        let ghosts = GHOSTS / 2;
        let rest = quiet.len().saturating_sub(ghosts);
        let stride = (rest / ghosts).max(1);
        let others = quiet
            .iter()
            .skip(ghosts)
            .step_by(stride)
            .take(ghosts)
            .copied();
        let quiet: Vec<usize> = quiet.iter().take(ghosts).copied().chain(others).collect();
        (alone, quiet)
    })?;
    let middle = (rows / 2) * columns + columns / 2;
    let siemens = law.siemens_from_grams(middle, GHOST_LOAD_G) - law.g_zero;
    evaluator.ghost_grams_per_siemens = GHOST_LOAD_G / siemens;
    let (isolated, unloaded) = seen.into_iter().unzip();
    if (&isolated, &unloaded) != (&evaluator.isolated, &evaluator.unloaded) {
        (evaluator.isolated, evaluator.unloaded) = (isolated, unloaded);
        evaluator.clear();
    }
    Some(())
}

fn with_values(model: &Model, unknowns: &[Unknown], values: &[f64]) -> Option<Model> {
    let mut moved = model.clone();
    for (&unknown, &value) in unknowns.iter().zip(values) {
        moved.set(unknown, value)?;
    }
    Some(moved)
}

/// How thoroughly to fit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Effort {
    /// On the way.
    Rough,
    /// To the end.
    Full,
}

/// Fits some unknowns of a model, those of each witness in turn.
pub(super) fn refine(
    evaluator: &mut Evaluator,
    model: &Model,
    unknowns: &[Unknown],
    effort: Effort,
) -> Option<Fitted> {
    let groups: Vec<(MisfitTerm, Vec<Unknown>)> = MisfitTerm::ALL
        .into_iter()
        .map(|w| {
            (
                w,
                unknowns
                    .iter()
                    .copied()
                    .filter(|&u| MisfitTerm::of(u, Told::default()) == w)
                    .collect(),
            )
        })
        .filter(|(_, group): &(_, Vec<Unknown>)| !group.is_empty())
        .collect();
    let (iterations, precision) = match effort {
        Effort::Rough => (2, 1.0),
        Effort::Full => (4, 0.1),
    };
    // Witnesses disagree a little until the others are heard: twice when there are several.
    let passes = if effort == Effort::Full && groups.len() > 1 {
        2
    } else {
        1
    };
    let mut model = model.clone();
    let mut blocks = Vec::new();
    for _ in 0..passes {
        blocks.clear();
        for (term, group) in &groups {
            let block = fit_block(evaluator, &model, *term, group, (iterations, precision))?;
            model = with_values(&model, group, &block.fit.parameters)?;
            blocks.push(block);
        }
    }
    Some(Fitted {
        model,
        unknowns: unknowns.to_vec(),
        blocks,
    })
}

/// Fits the unknowns of one witness alone: the model, the loss per residual, and whether any value is beyond
/// three standard errors from nothing.
pub(super) fn refine_alone(
    evaluator: &mut Evaluator,
    model: &Model,
    unknowns: &[Unknown],
) -> Option<(Model, f64, bool)> {
    let term = MisfitTerm::of(unknowns[0], Told::default());
    let block = fit_block(evaluator, model, term, unknowns, (3, 0.1))?;
    let found = &block.fit;
    let clear = (0..unknowns.len())
        .any(|i| found.parameters[i].abs() > 3.0 * found.covariance[i][i].max(0.0).sqrt());
    let loss =
        block.scatter.powi(2) * mean(&found.residuals.iter().map(|r| r * r).collect::<Vec<_>>());
    Some((
        with_values(model, unknowns, &found.parameters)?,
        loss,
        clear,
    ))
}

/// Fits both mean switch resistances (and what lines resist, where that is sought), and the offset where that is asked for, by unloaded taxels alone: what they
/// read are ghosts, and ghosts are the switches'. Neither loads nor the material matter. The second answer is the
/// offset's standard error in counts.
pub(super) fn switches_by_ghosts(
    evaluator: &mut Evaluator,
    model: &Model,
    with_offset: bool,
) -> Option<(Model, f64)> {
    let mut unknowns = model.switches().to_vec();
    if with_offset {
        unknowns.push(Unknown::Offset);
    }
    let effort = if model.seeks_lines {
        (10, 0.1)
    } else {
        (3, 0.3)
    };
    let block = fit_block(evaluator, model, MisfitTerm::Unloaded, &unknowns, effort)?;
    let error = if with_offset {
        let at = unknowns.len() - 1;
        block.fit.covariance[at][at].max(0.0).sqrt()
    } else {
        f64::INFINITY
    };
    Some((with_values(model, &unknowns, &block.fit.parameters)?, error))
}

fn fit_block(
    evaluator: &mut Evaluator,
    model: &Model,
    term: MisfitTerm,
    unknowns: &[Unknown],
    (iterations, precision): (usize, f64),
) -> Option<Block> {
    let before = evaluator.estimates(model)?;
    let scatter = robust_deviation(&term.residuals(evaluator, &before)).max(MIN_SCATTER_G);
    let start: Vec<f64> = unknowns.iter().map(|&u| model.get(u)).collect();
    let steps: Vec<f64> = unknowns.iter().map(|u| u.difference()).collect();
    // It ends by small steps, whatever those for derivatives are.
    let small = unknowns.iter().map(|u| u.step() / u.difference());
    let precision = precision * small.fold(1.0, f64::min);
    let settings = Settings {
        iterations: if any_moves_frames(unknowns) {
            iterations
        } else {
            20
        },
        precision,
        ..scaled()
    };
    let fit = fit(&start, &steps, settings, |values| {
        let moved = with_values(model, unknowns, values)?;
        let estimates = evaluator.estimates(&moved)?;
        let mut residuals = term.residuals(evaluator, &estimates);
        residuals.iter_mut().for_each(|r| *r /= scatter);
        residuals.extend(moved.surprises(unknowns));
        Some(residuals)
    })?;
    Some(Block {
        term,
        unknowns: unknowns.to_vec(),
        scatter,
        fit,
    })
}

/// Residuals come in units of their witness's scatter.
fn scaled() -> Settings {
    Settings {
        huber: 2.5,
        scale: Some(1.0),
        ..Settings::default()
    }
}

impl Fitted {
    fn block_of(&self, unknown: Unknown) -> Option<(&Block, usize)> {
        self.blocks.iter().find_map(|block| {
            let at = block.unknowns.iter().position(|&u| u == unknown)?;
            Some((block, at))
        })
    }

    /// Standard error of a fitted unknown.
    pub(super) fn error_of(&self, unknown: Unknown) -> Option<f64> {
        let (block, at) = self.block_of(unknown)?;
        Some(block.fit.covariance[at][at].max(0.0).sqrt())
    }

    /// Correlation of two fitted unknowns of one witness.
    pub(super) fn correlation(&self, a: Unknown, b: Unknown) -> Option<f64> {
        let (block, i) = self.block_of(a)?;
        let j = block.unknowns.iter().position(|&u| u == b)?;
        let c = &block.fit.covariance;
        Some(c[i][j] / (c[i][i] * c[j][j]).sqrt())
    }

    /// Errors on held-out presses: the unknowns are fitted anew without each fold (a Gauss–Newton step from the
    /// common answer, where the problem is all but linear) and judged on it. Presses of one frame stay together. Effects
    /// are chosen by them, so that they are no measure of what was chosen.
    pub(super) fn cross_validate(&self, evaluator: &mut Evaluator, folds: usize) -> Option<Score> {
        let presses = evaluator.evidence.presses.clone();
        let folds = folds.clamp(2, presses.len());
        let base = evaluator.estimates(&self.model)?;
        let mut score = Score {
            errors_g: vec![0.0; presses.len()],
            totals_g: vec![0.0; presses.len()],
            says_g: vec![0.0; presses.len()],
            seen: Vec::new(),
        };
        for fold in 0..folds {
            let held = |i: usize| presses[i].frame % folds == fold;
            let mut model = self.model.clone();
            let mut failed = false;
            for block in &self.blocks {
                let owner = block.term.owners(&base);
                let mut residuals = block.term.residuals(evaluator, &base);
                residuals.iter_mut().for_each(|r| *r /= block.scatter);
                residuals.extend(self.model.surprises(&block.unknowns));
                // What is believed beforehand belongs to no press.
                let kept = |k: usize| owner.get(k).is_none_or(|&press| !held(press));
                let Some(change) = step(&block.fit.jacobian, &residuals, scaled(), kept) else {
                    failed = true;
                    continue;
                };
                let values: Vec<f64> = block
                    .unknowns
                    .iter()
                    .zip(&change)
                    .map(|(&u, step)| self.model.get(u) + step)
                    .collect();
                match with_values(&model, &block.unknowns, &values) {
                    Some(moved) => model = moved,
                    None => failed = true,
                }
            }
            // Only the held-out frames need another inversion.
            let which: Vec<usize> = (0..presses.len()).filter(|&i| held(i)).collect();
            if failed {
                score.seen.extend(&which);
            }
            let part = evaluator.evidence.part(&which);
            let mut tester = evaluator.part(&part, &which, &self.model)?;
            let mut estimates = tester.estimates(&model);
            if estimates.is_none() && !failed {
                // The step leaves one of its frames without a solution.
                score.seen.extend(&which);
                estimates = tester.estimates(&self.model);
            }
            evaluator.take_back(&which, tester);
            for (&i, estimate) in which.iter().zip(estimates?) {
                let error = (estimate.load_g - presses[i].load_g).abs();
                let size = |x: &[f64]| mean(&x.iter().map(|x| x.abs()).collect::<Vec<_>>());
                score.errors_g[i] = error;
                score.says_g[i] = estimate.load_g;
                score.totals_g[i] = error + size(&estimate.neighbours_g) + size(&estimate.ghosts_g);
            }
        }
        Some(score)
    }
}
