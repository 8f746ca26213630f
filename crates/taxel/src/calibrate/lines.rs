//! Every switch resistance apart, from uniform loads.

use super::model::{Evaluator, Model, level_data};
use crate::sensor::PerLine;
use crate::{Frame, Siemens};

/// How far lines are believed to differ from their mean (a standard deviation, relative).
const BELIEVED_MISMATCH: f64 = 0.15;
/// Step of ln R for the derivative.
const STEP: f64 = 0.02;
const ROUNDS: usize = 4;

/// Resistances of all lines, columns first.
fn resistances(model: &Model) -> Vec<f64> {
    let (rows, columns) = (model.sensor.rows(), model.sensor.columns());
    let list = |values: &Option<PerLine>, n: usize| -> Vec<f64> {
        let values = values.as_ref().expect("a start has been found");
        (0..n).map(|i| values.at(i)).collect()
    };
    let mut all = list(&model.sensor.readout.r_mux_column_ohms, columns);
    all.extend(list(&model.sensor.readout.r_mux_row_ohms, rows));
    all
}

fn with_resistances(model: &Model, all: &[f64]) -> Model {
    let mut model = model.clone();
    let (column, row) = all.split_at(model.sensor.columns());
    model.sensor.readout.r_mux_column_ohms = Some(PerLine::Each(column.to_vec()));
    model.sensor.readout.r_mux_row_ohms = Some(PerLine::Each(row.to_vec()));
    model
}

/// The model with one resistance per line, such that taxels agree across levels; the mean of ln R of columns
/// and of rows stays where the presses put it.
pub(super) fn separate(
    evaluator: &mut Evaluator,
    model: &Model,
    progress: &mut dyn FnMut(f64),
) -> Option<Model> {
    let (rows, columns) = (model.sensor.rows(), model.sensor.columns());
    let evidence = evaluator.evidence;
    let first = evidence.frames.len();
    let which: Vec<usize> = (first..first + evidence.levels.len()).collect();
    let start: Vec<f64> = resistances(model).iter().map(|r| r.ln()).collect();
    let centre = |range: std::ops::Range<usize>| {
        let n = range.len() as f64;
        start[range].iter().sum::<f64>() / n
    };
    let (column_mean, row_mean) = (centre(0..columns), centre(columns..columns + rows));
    let mut ln_r = start.clone();
    for round in 0..ROUNDS {
        let now = with_resistances(model, &exp(&ln_r));
        let material = evaluator.material(&now)?;
        let data = evaluator.levels(&now)?;
        let g_zero = evaluator.law(&now)?.g_zero;
        let mut slopes = Vec::with_capacity(ln_r.len());
        for i in 0..ln_r.len() {
            progress((round as f64 + i as f64 / ln_r.len() as f64) / ROUNDS as f64);
            let mut moved = ln_r.clone();
            moved[i] += STEP;
            let mut frames: Vec<Frame<Siemens>> = Vec::new();
            let there = with_resistances(model, &exp(&moved));
            evaluator.invert(&there.sensor, &which, |_, siemens| {
                frames.push(siemens.clone())
            })?;
            let moved = level_data(evidence, &frames, g_zero, &there).ln_siemens;
            slopes.push(
                moved
                    .iter()
                    .zip(&data.ln_siemens)
                    .map(|(a, b)| a.iter().zip(b).map(|(a, b)| (a - b) / STEP).collect())
                    .collect(),
            );
        }
        let prior: Vec<(f64, f64)> = ln_r
            .iter()
            .enumerate()
            .map(|(i, x)| {
                let mean = if i < columns { column_mean } else { row_mean };
                (mean - x, BELIEVED_MISMATCH)
            })
            .collect();
        let groups = [(0..columns, 1e-3), (columns..columns + rows, 1e-3)];
        let step = data.view().line_step(&slopes, &material, &prior, &groups)?;
        let mut largest = 0f64;
        for (x, step) in ln_r.iter_mut().zip(&step) {
            let step = step.clamp(-0.5, 0.5);
            largest = largest.max(step.abs());
            *x += step;
        }
        if largest < 1e-3 {
            break;
        }
    }
    Some(with_resistances(model, &exp(&ln_r)))
}

fn exp(values: &[f64]) -> Vec<f64> {
    values.iter().map(|x| x.exp()).collect()
}
