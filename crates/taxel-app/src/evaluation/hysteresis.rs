//! Does it matter whether the load grew or fell?

use taxel::evaluate::hysteresis::{LoopReading, hysteresis};
use taxel_plot::report::{Figure, Section, Table};
use taxel_plot::{Line, Series, cells};

use super::at_end::readings_at_end;
use super::plan::{Experiment, Plan, Value};
use super::readings::Group;
use super::{no_value, too_few};
use crate::error::Error;

/// Loops that are drawn.
const DRAWN: usize = 8;

pub(super) fn section(
    plan: &Plan,
    experiment: &Experiment,
    groups: &[Group],
) -> Result<Section, Error> {
    let value = experiment.value();
    let mut table = Table::new(
        format!(
            "Hysteresis, % of the range of values; {} intervals over loops",
            plan.sure()
        ),
        &["setting", "loops", "widest", "mean", "zero return"],
    );
    let mut figures = Vec::new();
    for group in groups {
        let loops = loops(plan, group, value)?;
        let found = hysteresis(&loops, &plan.bootstrap).ok_or_else(|| {
            too_few(
                experiment,
                group,
                "a loop (lines with one word under experiment) whose load grows and falls over two loads or more",
            )
        })?;
        table.push(cells![
            group.name().to_owned(),
            found.loops,
            found.widest_percent,
            found.mean_percent,
            found.zero_return_percent,
        ]);
        figures.push(figure(group, value, &loops)?);
    }
    Ok(Section {
        title: experiment.name.clone(),
        paragraphs: vec![
            "Each experiment is a loop: readings in the order of the table, up to the largest load and down again. Hysteresis is the difference between both ways at one load, in % of the loop's range of values; zero return is what stays at the load that the loop began with.".to_owned(),
        ],
        tables: vec![table],
        figures,
    })
}

fn loops(plan: &Plan, group: &Group, value: Value) -> Result<Vec<Vec<LoopReading>>, Error> {
    group.collect(
        super::readings::TrialReading::is_measured,
        |trial, reading| {
            Ok(LoopReading {
                load: trial.load_g.unwrap_or_default(),
                value: reading.value(value).ok_or_else(|| no_value(plan, value))?,
            })
        },
    )
}

fn figure(group: &Group, value: Value, loops: &[Vec<LoopReading>]) -> Result<Figure, Error> {
    let line = |(i, one): (usize, &Vec<LoopReading>)| {
        Line::new(
            format!("loop {}", i + 1),
            one.iter().map(|r| r.value).collect(),
        )
        .over(one.iter().map(|r| r.load).collect())
    };
    let mut lines: Vec<Line> = loops.iter().enumerate().take(DRAWN).map(line).collect();
    lines.extend(readings_at_end(group, |trial, reading, _| {
        trial.load_g.zip(reading.value(value))
    }));
    let picture = Series::new("load (g)", Vec::new(), lines)?
        .title(group.title())
        .quantity(value.quantity())
        .unit(value.unit())
        .order("loop")
        .picture()?;
    Ok(Figure {
        caption: format!(
            "Loops of growing and falling load, {}{}.",
            group.title(),
            if loops.len() > DRAWN {
                format!(": the first {DRAWN} of {}", loops.len())
            } else {
                String::new()
            }
        ),
        picture,
    })
}
