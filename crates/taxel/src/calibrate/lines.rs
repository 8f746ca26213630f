//! Every switch apart, and every line that resists along its length, from uniform loads.

use std::ops::Range;

use super::evaluate::Evaluator;
use super::inverter::{Inverter, Job};
use super::model::{MIN_OHMS, Model};
use crate::Mark;
use crate::parallel::par_map;
use crate::sensor::{PerLine, SheetSpec};

/// How far lines are believed to differ from their mean (a standard deviation, relative to it).
const BELIEVED_MISMATCH: f64 = 0.15;
/// Step of a resistance for the derivative, relative to it (a switch's to no less than 1 ohm).
const STEP: f64 = 0.02;
/// Lines that are looked at in one go.
const BATCH: usize = 16;

/// How far resistances may have moved, relative to their side's mean, for a derivative by them to serve again: it hardly changes, and the
/// steps that it tells end where levels agree, whatever it is off by.
const SERVES: f64 = 0.1;

/// A sheet that conducts less is as good as none, microsiemens.
const LEAST_MICROSIEMENS: f64 = 20.0;

/// The derivative of all levels by every resistance, and where it was found.
pub(super) struct LineSlopes {
    ohms: Vec<f64>,
    sheet: Option<SheetSpec>,
    /// Of ln(G − g_zero) of every taxel of every level, by every resistance, per ohm.
    of: Vec<Vec<Vec<f64>>>,
}

impl LineSlopes {
    fn serves(&self, model: &Model, ohms: &[f64], means: &[f64]) -> bool {
        let near = |((a, b), mean): ((&f64, &f64), &f64)| (a - b).abs() <= SERVES * mean;
        are_alike(self.sheet, model.sheet())
            && self.ohms.len() == ohms.len()
            && self.ohms.iter().zip(ohms).zip(means).all(near)
    }
}

/// Whether uniform loads, under which little flows along a sheet, hardly tell two of them apart.
fn are_alike(one: Option<SheetSpec>, other: Option<SheetSpec>) -> bool {
    // Outside contacts and inside them, microsiemens.
    let numbers = |sheet: Option<SheetSpec>| {
        sheet.map_or((0.0, 0.0), |sheet| {
            let outside = 1e6 / sheet.resistance_ohms;
            (outside, outside * sheet.contact_factor)
        })
    };
    let ((one, in_one), (other, in_other)) = (numbers(one), numbers(other));
    let most = SERVES * one.max(other).max(LEAST_MICROSIEMENS);
    (one - other).abs() <= most && (in_one - in_other).abs() <= 3.0 * most
}

/// Resistances of all switches, columns first, and then of all lines a pitch where that is sought.
fn resistances(model: &Model) -> Vec<f64> {
    let (rows, columns) = (model.sensor.rows(), model.sensor.columns());
    let readout = model.sensor.readout();
    let mut sides = vec![
        (&readout.r_mux_column_ohms, columns),
        (&readout.r_mux_row_ohms, rows),
    ];
    if model.seeks_lines {
        sides.push((&readout.r_line_column_ohms, columns));
        sides.push((&readout.r_line_row_ohms, rows));
    }
    let each = |(values, n): (&Option<PerLine>, usize)| -> Vec<f64> {
        let values = values.as_ref().expect("a start has been found");
        (0..n).map(|i| values.at(i)).collect()
    };
    sides.into_iter().flat_map(each).collect()
}

/// Which of them belong together: one side's switches, or its lines.
fn groups(model: &Model) -> Vec<Range<usize>> {
    let (rows, columns) = (model.sensor.rows(), model.sensor.columns());
    let lines = rows + columns;
    let sides = [0..columns, columns..lines];
    let along = sides
        .clone()
        .map(|side| lines + side.start..lines + side.end);
    let along = along.into_iter().filter(|_| model.seeks_lines);
    sides.into_iter().chain(along).collect()
}

/// Which of them uniform loads tell: not those of a line that is dead in all of them.
fn told(evaluator: &Evaluator, model: &Model) -> Vec<bool> {
    let (rows, columns) = (model.sensor.rows(), model.sensor.columns());
    let levels = &evaluator.evidence.levels;
    let is_read = |taxel: usize| {
        let mut marks = levels.iter().map(|level| level.counts.marks()[taxel]);
        marks.any(|mark| mark == Mark::Good)
    };
    let of_columns = (0..columns).map(|c| (0..rows).any(|r| is_read(r * columns + c)));
    let of_rows = (0..rows).map(|r| (0..columns).any(|c| is_read(r * columns + c)));
    let lines: Vec<bool> = of_columns.chain(of_rows).collect();
    lines.repeat(groups(model).len() / 2)
}

fn with_resistances(model: &Model, all: &[f64]) -> Model {
    let mut model = model.clone();
    let each = |side: &Range<usize>| Some(PerLine::Each(all[side.clone()].to_vec()));
    let groups = groups(&model);
    model.sensor.try_out(|spec| {
        let readout = &mut spec.readout;
        readout.r_mux_column_ohms = each(&groups[0]);
        readout.r_mux_row_ohms = each(&groups[1]);
        if let [_, _, column_lines, row_lines] = &groups[..] {
            readout.r_line_column_ohms = each(column_lines);
            readout.r_line_row_ohms = each(row_lines);
        }
    });
    model
}

/// One step towards one resistance per switch, and per line where lines resist, such that taxels agree across levels; the mean of each
/// side stays where presses and unloaded taxels put it.
pub(super) fn separate(
    evaluator: &mut Evaluator,
    model: &Model,
    known: &mut Option<LineSlopes>,
) -> Option<Model> {
    // Taxels may differ in exponent here even where the law will have one for all: it costs little, and
    // keeps differences of material from being read as differences of switches.
    let mut model = model.clone();
    let own_exponents = std::mem::replace(&mut model.law.own_exponents, true);
    let mut ohms = resistances(&model);
    let is_told = told(evaluator, &model);
    let members = |group: Range<usize>| group.filter(|&i| is_told[i]).collect();
    let groups: Vec<(Range<usize>, Vec<usize>)> = groups(&model)
        .into_iter()
        .map(|group| (group.clone(), members(group)))
        .collect();
    let means: Vec<f64> = groups
        .iter()
        .flat_map(|(group, members)| {
            let sum: f64 = members.iter().map(|&i| ohms[i]).sum();
            vec![sum / members.len() as f64; group.len()]
        })
        .collect();
    // A line that nothing tells is one as usual: it may not take what the mean of its side is held by.
    for ((ohms, mean), told) in ohms.iter_mut().zip(&means).zip(&is_told) {
        if !told {
            *ohms = *mean;
        }
    }
    let now = with_resistances(&model, &ohms);
    if !known
        .as_ref()
        .is_some_and(|known| known.serves(&model, &ohms, &means))
    {
        *known = Some(LineSlopes {
            of: slopes(evaluator, &model, &ohms, &means)?,
            sheet: model.sheet(),
            ohms: ohms.clone(),
        });
    }
    let slopes = &known.as_ref()?.of;
    let material = evaluator.material(&now)?;
    let data = evaluator.levels(&now)?;
    let of_lines = ohms.iter().zip(&means);
    let prior: Vec<(f64, f64)> = of_lines
        .map(|(ohms, mean)| (mean - ohms, BELIEVED_MISMATCH * mean))
        .collect();
    let held: Vec<(Vec<usize>, f64)> = groups
        .into_iter()
        .map(|(group, members)| (members, 1e-4 * means[group.start]))
        .collect();
    let step = data.view().line_step(slopes, &material, &prior, &held)?;
    let switches = model.sensor.rows() + model.sensor.columns();
    for (line, ((ohms, step), mean)) in ohms.iter_mut().zip(&step).zip(&means).enumerate() {
        if !is_told[line] {
            continue;
        }
        let least = if line < switches {
            MIN_OHMS
        } else {
            0.1 * mean
        };
        *ohms = (*ohms + step.clamp(-0.5 * mean, 0.5 * mean)).max(least);
    }
    let mut answer = with_resistances(&model, &ohms);
    answer.law.own_exponents = own_exponents;
    Some(answer)
}

/// Derivative of ln(G − g_zero) of every taxel at every level by every resistance, per ohm.
fn slopes(
    evaluator: &mut Evaluator,
    model: &Model,
    ohms: &[f64],
    means: &[f64],
) -> Option<Vec<Vec<Vec<f64>>>> {
    let evidence = evaluator.evidence;
    let first = evidence.frames.len();
    let which: Vec<usize> = (first..first + evidence.levels.len()).collect();
    let now = with_resistances(model, ohms);
    let g_zero = evaluator.law(&now)?.g_zero;
    let base = evaluator.invert(&now.sensor, &which, |_, siemens| siemens.clone())?;
    let switches = model.sensor.rows() + model.sensor.columns();
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
                let step = STEP
                    * if line < switches {
                        ohms[line].max(1.0)
                    } else {
                        means[line]
                    };
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
