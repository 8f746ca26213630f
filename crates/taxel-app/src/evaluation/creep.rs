//! Does it matter how long the load has been there?

use taxel::evaluate::creep::{Creep, Exponentials, Logarithm, MIN_READINGS, TimedReading, creep};
use taxel_plot::report::{Cell, Figure, Section, Table, number};
use taxel_plot::{Line, LineStyle, Series, cells};

use super::at_end::readings_at_end;
use super::plan::{Experiment, Plan, Value};
use super::readings::Group;
use super::{no_value, too_few};
use crate::error::Error;

/// Holds that are drawn.
const DRAWN: usize = 5;

pub(super) fn section(
    plan: &Plan,
    experiment: &Experiment,
    groups: &[Group],
) -> Result<Section, Error> {
    let value = experiment.value();
    let mut table = Table::new(
        format!(
            "Creep and drift under constant load; {} intervals over holds",
            plan.sure()
        ),
        &[
            "setting",
            "holds",
            "mean length, s",
            "creep, %",
            "drift, %/h",
        ],
    );
    let mut fits = Table::new(
        format!("Curves through each hold, {}", value.unit()),
        &[
            "setting",
            "hold",
            "exponentials: amplitude in % of start (time constant)",
            "left, %",
            "logarithm: % a decade",
            "left, %",
        ],
    );
    let mut figures = Vec::new();
    for group in groups {
        let holds = holds(plan, experiment, group, value)?;
        let found = creep(&holds, &plan.bootstrap).ok_or_else(|| {
            too_few(
                experiment,
                group,
                "a hold (lines with one word under experiment, or one line) of ten readings or more",
            )
        })?;
        table.push(cells![
            group.name().to_owned(),
            found.holds,
            found.secs,
            found.percent,
            found.drift_percent_per_hour,
        ]);
        for (i, (some, log)) in found.exponentials.iter().zip(&found.logarithms).enumerate() {
            fits.push(fit_row(group.name(), i + 1, some, log));
        }
        figures.push(figure(group, value, &holds, &found)?);
    }
    Ok(Section {
        title: experiment.name.clone(),
        paragraphs: vec![
            "Each experiment is a hold of one load. Creep is the change from the hold's first tenth to its last; drift the slope of its last half. Two exponentials are given where they leave less than nine tenths of what one leaves.".to_owned(),
        ],
        tables: vec![table, fits],
        figures,
    })
}

fn fit_row(name: &str, hold: usize, some: &Exponentials, log: &Logarithm) -> Vec<Cell> {
    let of_start = |amount: f64| 100.0 * amount / some.start.abs();
    let terms = some
        .terms
        .iter()
        .map(|(a, tau)| format!("{} ({} s)", number(of_start(*a)), number(*tau)));
    cells![
        name,
        hold,
        terms.collect::<Vec<_>>().join(", "),
        of_start(some.residual),
        100.0 * log.rise * std::f64::consts::LN_10 / log.start.abs(),
        100.0 * log.residual / log.start.abs(),
    ]
}

fn holds(
    plan: &Plan,
    experiment: &Experiment,
    group: &Group,
    value: Value,
) -> Result<Vec<Vec<TimedReading>>, Error> {
    group.collect(
        super::readings::TrialReading::is_measured,
        |trial, reading| {
            Ok(TimedReading {
                secs: reading.secs.ok_or_else(|| Error::NoTimes {
                    file: trial.recording.clone(),
                    experiment: experiment.name.clone(),
                })?,
                value: reading.value(value).ok_or_else(|| no_value(plan, value))?,
            })
        },
    )
}

fn figure(
    group: &Group,
    value: Value,
    holds: &[Vec<TimedReading>],
    found: &Creep,
) -> Result<Figure, Error> {
    let mut lines = Vec::new();
    let whole = holds.iter().filter(|hold| hold.len() >= MIN_READINGS);
    for (i, (hold, fit)) in whole.zip(&found.exponentials).take(DRAWN).enumerate() {
        let since: Vec<f64> = hold.iter().map(|r| r.secs - hold[0].secs).collect();
        let measured = hold.iter().map(|r| r.value).collect();
        let fitted = since.iter().map(|&secs| fit.at(secs)).collect();
        lines.push(
            Line::new(format!("hold {}", i + 1), measured)
                .over(since.clone())
                .colour(i),
        );
        lines.push(
            Line::new("", fitted)
                .over(since)
                .style(LineStyle::Dashed)
                .colour(i),
        );
    }
    lines.extend(readings_at_end(group, |_, reading, first| {
        let since = reading.secs? - first.secs?;
        Some((since, reading.value(value)?))
    }));
    let picture = Series::new("time (s)", Vec::new(), lines)?
        .title(group.title())
        .quantity(value.quantity())
        .unit(value.unit())
        .picture()?;
    Ok(Figure {
        caption: format!(
            "Holds of constant load, {}; dashed: exponentials.",
            group.title()
        ),
        picture,
    })
}
