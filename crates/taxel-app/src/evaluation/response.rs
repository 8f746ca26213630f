//! How the reading follows the load, and where it ends.

use taxel::evaluate::response::{LoadReading, Response, response};
use taxel_plot::report::{Cell, Figure, Section, Table, number};
use taxel_plot::{Line, LineStyle, Series, cells};

use super::at_end::{at_end, ceiling, ceiling_line};
use super::plan::{Experiment, Plan, Value};
use super::readings::Group;
use super::{no_value, too_few};
use crate::error::Error;

/// Loads that are listed one by one at most: more are those of a gauge that was read all the time, one reading each.
const LISTED: usize = 100;
/// Positions at which a fitted curve is drawn.
const DRAWN: usize = 60;

const HEAD: [&str; 9] = [
    "setting",
    "sensitivity",
    "offset",
    "R²",
    "non-linearity, %",
    "exponent",
    "saturates at, g",
    "usable, g",
    "smallest, g",
];
const LEVEL_HEAD: [&str; 5] = [
    "setting",
    "load, g",
    "mean",
    "standard deviation",
    "saturated, %",
];

fn row(group: &Group, found: &Response) -> Vec<Cell> {
    cells![
        group.name().to_owned(),
        found.sensitivity,
        found.line.offset,
        found.line.r_squared,
        found.non_linearity_percent,
        found.exponent,
        found.saturates_at,
        usable(found),
        found.smallest_detectable,
    ]
}

pub(super) fn section(
    plan: &Plan,
    experiment: &Experiment,
    groups: &[Group],
) -> Result<Section, Error> {
    let value = experiment.value();
    let unit = value.unit();
    let mut table = Table::new(
        format!(
            "Response to load; sensitivity in {unit} per g; {} intervals over experiments",
            plan.sure()
        ),
        &HEAD,
    );
    let mut levels = Table::new(
        format!("Mean {} under each load, {unit}", value.quantity()),
        &LEVEL_HEAD,
    );
    let (mut figures, mut left_out) = (Vec::new(), Vec::new());
    for group in groups {
        let found = response(&readings(plan, group, value)?, &plan.bootstrap).ok_or_else(|| {
            too_few(
                experiment,
                group,
                "readings under two loads or more that do not saturate",
            )
        })?;
        table.push(row(group, &found));
        if found.levels.len() > LISTED {
            left_out.push(format!("{} ({})", group.name(), found.levels.len()));
        }
        for level in found.levels.iter().filter(|_| found.levels.len() <= LISTED) {
            levels.push(cells![
                group.name().to_owned(),
                level.load,
                level.value,
                level.standard_deviation,
                100.0 * level.saturated_share,
            ]);
        }
        figures.push(figure(plan, group, value, &found)?);
    }
    let mut paragraphs = vec!["Line and power law (offset + factor · load^exponent) are least squares over the readings below saturation. Non-linearity is the largest distance of a load's mean from the best straight line, in % of the line's rise. The smallest load that can be told from none lifts the reading by three standard deviations of the readings without load. A load saturates when more than half of its readings are at the converter's end.".to_owned()];
    if !left_out.is_empty() {
        paragraphs.push(format!(
            "Too many different loads to list: {}. Round the loads in the table where several readings should count as one load.",
            left_out.join(", ")
        ));
    }
    Ok(Section {
        title: experiment.name.clone(),
        paragraphs,
        tables: [table, levels]
            .into_iter()
            .filter(|table| !table.rows.is_empty())
            .collect(),
        figures,
    })
}

fn usable(found: &Response) -> String {
    let from = found.smallest_detectable.unwrap_or(found.levels[0].load);
    format!("{} to {}", number(from), number(found.largest_usable))
}

fn readings(plan: &Plan, group: &Group, value: Value) -> Result<Vec<Vec<LoadReading>>, Error> {
    // What is no measurement says nothing of the response; what is saturated says where it ends.
    let keep = |reading: &super::readings::TrialReading| !reading.marked || reading.saturated;
    group.collect(keep, |trial, reading| {
        Ok(LoadReading {
            load: trial.load_g.unwrap_or_default(),
            value: reading.value(value).ok_or_else(|| no_value(plan, value))?,
            saturated: reading.saturated,
        })
    })
}

fn figure(plan: &Plan, group: &Group, value: Value, found: &Response) -> Result<Figure, Error> {
    let loads: Vec<f64> = found.levels.iter().map(|level| level.load).collect();
    let (first, last) = (loads[0], loads[loads.len() - 1]);
    let x: Vec<f64> = (0..=DRAWN)
        .map(|i| first + (last - first) * i as f64 / DRAWN as f64)
        .collect();
    let ceiling = ceiling(group, value);
    // Nothing reads more than the converter can.
    let below = |x: f64, y: f64| match (found.saturates_at, ceiling) {
        (Some(end), _) if x > end => f64::NAN,
        (_, Some(ceiling)) if y.abs() > ceiling => f64::NAN,
        _ => y,
    };
    let line = |x: &f64| below(*x, found.line.at(*x));
    let mut lines = vec![
        Line::new(
            format!("readings, {}", plan.sure()),
            found.levels.iter().map(|l| l.value.value).collect(),
        )
        .over(loads)
        .style(LineStyle::Points)
        .errors(found.levels.iter().map(|l| half(&l.value)).collect())
        .colour(0),
        Line::new("straight line", x.iter().map(line).collect())
            .style(LineStyle::Dashed)
            .colour(1),
    ];
    if let Some(power) = &found.power {
        let curve = |x: &f64| below(*x, power.at(*x));
        lines.push(Line::new("power law", x.iter().map(curve).collect()).colour(2));
    }
    if let (Some(_), Some(ceiling)) = (found.saturates_at, ceiling) {
        let like = found.levels.last().map_or(1.0, |l| l.value.value);
        lines.push(ceiling_line(ceiling, like, x.clone()));
    }
    let saturated = found.levels.iter().filter(|l| l.saturated_share > 0.0);
    lines.extend(at_end(saturated.map(|l| (l.load, l.value.value)).collect()));
    let picture = Series::new("load (g)", x, lines)?
        .title(group.title())
        .quantity(value.quantity())
        .unit(value.unit())
        .picture()?;
    let end = match found.saturates_at {
        Some(load) => format!("Saturated from {} g.", number(load)),
        None => "Nothing saturated.".to_owned(),
    };
    Ok(Figure {
        caption: format!("Response to load, {}. {end}", group.title()),
        picture,
    })
}

/// Half the length of an interval, for an error bar.
pub(super) fn half(estimate: &taxel::stats::Estimate) -> f64 {
    estimate
        .interval
        .map_or(0.0, |(low, high)| (high - low) / 2.0)
}
