//! Every switch resistance apart, from uniform loads.

use super::evaluate::Evaluator;
use super::inverter::{Inverter, Job};
use super::model::{MIN_OHMS, Model};
use crate::Mark;
use crate::parallel::par_map;
use crate::sensor::PerLine;

/// How far lines are believed to differ from their mean (a standard deviation, relative to it).
const BELIEVED_MISMATCH: f64 = 0.15;
/// Step of a resistance for the derivative, relative to the mean.
const STEP: f64 = 0.02;
/// Lines that are looked at in one go.
const BATCH: usize = 16;

/// Resistances of all lines, columns first.
fn resistances(model: &Model) -> Vec<f64> {
    let (rows, columns) = (model.sensor.rows(), model.sensor.columns());
    let list = |values: &Option<PerLine>, n: usize| -> Vec<f64> {
        let values = values.as_ref().expect("a start has been found");
        (0..n).map(|i| values.at(i)).collect()
    };
    let mut all = list(&model.sensor.readout().r_mux_column_ohms, columns);
    all.extend(list(&model.sensor.readout().r_mux_row_ohms, rows));
    all
}

fn with_resistances(model: &Model, all: &[f64]) -> Model {
    let mut model = model.clone();
    let (column, row) = all.split_at(model.sensor.columns());
    model.sensor.try_out(|spec| {
        spec.readout.r_mux_column_ohms = Some(PerLine::Each(column.to_vec()));
        spec.readout.r_mux_row_ohms = Some(PerLine::Each(row.to_vec()));
    });
    model
}

/// One step towards one resistance per line, such that taxels agree across levels; the mean of columns and the
/// mean of rows stay where the presses put them.
pub(super) fn separate(evaluator: &mut Evaluator, model: &Model) -> Option<Model> {
    // Taxels may differ in exponent here even where the law will have one for all: it costs little, and
    // keeps differences of material from being read as differences of switches.
    let mut model = model.clone();
    let own_exponents = std::mem::replace(&mut model.law.own_exponents, true);
    let columns = model.sensor.columns();
    let mut ohms = resistances(&model);
    let groups = [0..columns, columns..ohms.len()];
    let mean = |ohms: &[f64], i: usize| {
        let group = &groups[usize::from(i >= columns)];
        ohms[group.clone()].iter().sum::<f64>() / group.len() as f64
    };
    let now = with_resistances(&model, &ohms);
    let slopes = slopes(evaluator, &model, &ohms)?;
    let material = evaluator.material(&now)?;
    let data = evaluator.levels(&now)?;
    let prior: Vec<(f64, f64)> = (0..ohms.len())
        .map(|i| {
            let mean = mean(&ohms, i);
            (mean - ohms[i], BELIEVED_MISMATCH * mean)
        })
        .collect();
    let held = groups
        .clone()
        .map(|group| (group.clone(), 1e-4 * mean(&ohms, group.start)));
    let step = data.view().line_step(&slopes, &material, &prior, &held)?;
    let means: Vec<f64> = (0..ohms.len()).map(|i| mean(&ohms, i)).collect();
    for ((ohms, step), mean) in ohms.iter_mut().zip(&step).zip(&means) {
        *ohms = (*ohms + step.clamp(-0.5 * mean, 0.5 * mean)).max(MIN_OHMS);
    }
    let mut answer = with_resistances(&model, &ohms);
    answer.law.own_exponents = own_exponents;
    Some(answer)
}

/// Derivative of ln(G − g_zero) of every taxel at every level by every resistance, per ohm.
fn slopes(evaluator: &mut Evaluator, model: &Model, ohms: &[f64]) -> Option<Vec<Vec<Vec<f64>>>> {
    let evidence = evaluator.evidence;
    let first = evidence.frames.len();
    let which: Vec<usize> = (first..first + evidence.levels.len()).collect();
    let now = with_resistances(model, ohms);
    let g_zero = evaluator.law(&now)?.g_zero;
    let base = evaluator.invert(&now.sensor, &which, |_, siemens| siemens.clone())?;
    // Each batch of lines starts cold, so that the answer cannot depend on who does which.
    let batches: Vec<Vec<usize>> = (0..ohms.len())
        .collect::<Vec<usize>>()
        .chunks(BATCH)
        .map(<[usize]>::to_vec)
        .collect();
    let work = |lines: Vec<usize>| {
        let mut jobs: Vec<Job> = which.iter().map(|&i| (i, None)).collect();
        lines
            .into_iter()
            .map(|line| {
                let step = STEP * ohms[line].max(1.0);
                let mut moved = ohms.to_vec();
                moved[line] += step;
                let there = with_resistances(model, &moved);
                let mut slope = Vec::with_capacity(base.len());
                Inverter::new(evidence, &there.sensor)?.invert(&mut jobs, |at, siemens| {
                    let base = base[at - first].values();
                    let marks = evidence.levels[at - first].counts.marks();
                    // d ln(G − g_zero) = dG/(G − g_zero).
                    let by_ohms = siemens.values().iter().zip(base).zip(marks);
                    slope.push(
                        by_ohms
                            .map(|((there, here), mark)| match mark {
                                Mark::Good => (there - here) / (step * (here - g_zero)),
                                _ => f64::NAN,
                            })
                            .collect(),
                    );
                })?;
                Some(slope)
            })
            .collect::<Option<Vec<Vec<Vec<f64>>>>>()
    };
    let slopes = par_map(evaluator.executor, batches, work)?;
    Some(slopes.into_iter().flatten().collect())
}
