//! Does the same load read the same?

use taxel::evaluate::repeatability::{OUTLIER_SIGMAS, RepeatedReading, difference, repeatability};
use taxel::stats::Bootstrap;
use taxel_plot::report::{Cell, Figure, Section, Table};
use taxel_plot::{Line, LineStyle, Series, cells};

use super::at_end::{at_end, ceiling, ceiling_line};
use super::plan::{Experiment, Plan, Value};
use super::readings::{Group, TrialReading};
use super::{no_value, too_few};
use crate::error::Error;

const HEAD: [&str; 9] = [
    "setting",
    "readings",
    "marked",
    "far",
    "outliers, %",
    "CV, %",
    "CV without outliers, %",
    "CV between experiments, %",
    "mean",
];

pub(super) fn section(
    plan: &Plan,
    experiment: &Experiment,
    groups: &[Group],
) -> Result<Section, Error> {
    let value = experiment.value();
    let mut table = Table::new(
        format!(
            "Repeated readings, {}; {} intervals over experiments",
            value.unit(),
            plan.sure()
        ),
        &HEAD,
    );
    let mut figures = Vec::new();
    let mut over_readings = false;
    for group in groups {
        let readings = readings(plan, group, value)?;
        let resolution = match value {
            Value::Counts => 1.0,
            _ => 0.0,
        };
        let found = repeatability(&readings, resolution, &plan.bootstrap)
            .ok_or_else(|| too_few(experiment, group, "a reading"))?;
        over_readings |= found.over_readings;
        table.push(cells![
            group.name().to_owned(),
            found.readings,
            found.marked,
            found.far,
            found.outlier_share.times(100.0),
            found.variation.map(|v| v.times(100.0)),
            found.variation_filtered.map(|v| v.times(100.0)),
            found.variation_between.map(|v| 100.0 * v),
            found.mean,
        ]);
        figures.push(figure(group, value)?);
    }
    let mut paragraphs = vec![format!(
        "A reading is an outlier when the screen marks it (stuck, at an end of the converter, outside of the mask) or when it is more than {OUTLIER_SIGMAS} robust standard deviations from the median of its experiment."
    )];
    if over_readings {
        paragraphs.push("Fewer than three experiments: intervals are over single readings and say nothing of setting up anew.".to_owned());
    }
    if let [before, after] = &marked(groups)[..]
        && let Some(change) = difference(before, after, &plan.bootstrap)
    {
        paragraphs.push(format!(
            "Marked readings, {} less {}: {} percentage points.",
            groups[1].name(),
            groups[0].name(),
            Cell::from(change.times(100.0))
        ));
    }
    Ok(Section {
        title: experiment.name.clone(),
        paragraphs,
        tables: vec![table],
        figures,
    })
}

fn readings(plan: &Plan, group: &Group, value: Value) -> Result<Vec<Vec<RepeatedReading>>, Error> {
    group.collect(
        |_| true,
        |_, reading| {
            Ok(RepeatedReading {
                value: reading.value(value).ok_or_else(|| no_value(plan, value))?,
                marked: !reading.is_measured(),
            })
        },
    )
}

/// 1 for a marked reading, 0 for another, of each setting.
fn marked(groups: &[Group]) -> Vec<Vec<Vec<f64>>> {
    let flag = |reading: &&TrialReading| f64::from(u8::from(!reading.is_measured()));
    let of = |group: &Group| {
        let experiments = group.experiments();
        if experiments.len() < Bootstrap::MIN_EXPERIMENTS {
            experiments.concat().iter().map(|r| vec![flag(r)]).collect()
        } else {
            experiments
                .iter()
                .map(|one| one.iter().map(flag).collect())
                .collect()
        }
    };
    groups.iter().map(of).collect()
}

fn figure(group: &Group, value: Value) -> Result<Figure, Error> {
    let values: Vec<f64> = group
        .readings
        .iter()
        .map(|r| r.value(value).unwrap_or(f64::NAN))
        .collect();
    let x: Vec<f64> = (0..values.len()).map(|i| i as f64).collect();
    let ends = vec![0.0, values.len().saturating_sub(1) as f64];
    let mut lines = vec![
        Line::new("", values.clone())
            .style(LineStyle::Points)
            .colour(0),
    ];
    let points = |is_drawn: fn(&TrialReading) -> bool| -> Vec<(f64, f64)> {
        let drawn = group.readings.iter().map(is_drawn);
        let points = drawn
            .zip(&x)
            .zip(&values)
            .filter(|((is_drawn, _), _)| *is_drawn);
        points.map(|((_, x), value)| (*x, *value)).collect()
    };
    let saturated = at_end(points(|reading| reading.saturated));
    if let (Some(saturated), Some(ceiling)) = (&saturated, ceiling(group, value)) {
        lines.push(ceiling_line(ceiling, saturated.values[0], ends));
    }
    lines.extend(saturated);
    let away = points(|reading| reading.marked && !reading.saturated);
    if !away.is_empty() {
        let (at, away): (Vec<f64>, Vec<f64>) = away.into_iter().unzip();
        let line = Line::new("no measurement", away).over(at);
        lines.push(line.style(LineStyle::Points).colour(7));
    }
    let picture = Series::new("reading", x, lines)?
        .title(group.title())
        .quantity(value.quantity())
        .unit(value.unit())
        .picture()?;
    Ok(Figure {
        caption: format!("Repeated readings, {}.", group.title()),
        picture,
    })
}
