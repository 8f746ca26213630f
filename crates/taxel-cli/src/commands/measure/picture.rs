//! Forces over time as a picture.

use std::path::Path;

use taxel::Sensor;
use taxel_plot::{Line, LineStyle, Picture, Series};

use crate::error::Error;
use taxel_app::exported::exported_caption;
use taxel_app::measure::{ForceSeries, Measurement, PlateauFigures};
use taxel_app::simulated::simulated_caption;

/// Regions have the colours from the third on, one each: those beyond the last are left to the table.
const REGIONS_FROM: usize = 2;
const MOST_REGIONS: usize = 8;
/// Points that a line has at most: finer than a picture shows.
const POINTS: usize = 1500;

/// Total force with its interval, grip force, regions; plateaus as what they are, a mean over a time.
pub(super) fn forces(
    recording: &Path,
    sensor: &Sensor,
    measurement: &Measurement,
) -> Result<Picture, Error> {
    let series = &measurement.series;
    let has_times = series.has_times();
    let frames = series.frame.iter().map(|&frame| frame as f64);
    let x: Vec<f64> = if has_times {
        series.secs.clone()
    } else {
        frames.collect()
    };
    let every = x.len().div_ceil(POINTS).max(1);
    let thin = |values: &[f64]| -> Vec<f64> { values.iter().copied().step_by(every).collect() };
    let mut lines = Vec::new();
    let mut dashed = Vec::new();
    let total = &series.total;
    lines.push(Line::new("total normal force", thin(&total.newtons)).colour(0));
    lines.extend(band(total).map(|edge| {
        Line::new("", thin(&edge))
            .style(LineStyle::Dashed)
            .colour(0)
    }));
    if lines.len() > 1 {
        dashed.push("the total's 95 % interval");
    }
    if let Some(grip) = &series.grip {
        lines.push(Line::new("grip force", thin(&grip.newtons)).colour(1));
    }
    for (at, (region, _)) in series.regions.iter().take(MOST_REGIONS).enumerate() {
        lines.push(Line::new(&region.name, thin(&region.newtons)).colour(REGIONS_FROM + at));
    }
    let plateaus = plateaus(measurement);
    if !plateaus.is_empty() {
        dashed.push("plateaus");
    }
    lines.extend(plateaus);
    lines.extend(saturated(series, &x));
    let label = if has_times { "time (s)" } else { "frame" };
    let name = recording.file_name().unwrap_or_default().to_string_lossy();
    let picture = Series::new(label, thin(&x), lines)?
        .title(name)
        .quantity("force")
        .unit("N")
        .caption(format!(
            "{}{}{}{}{}",
            sensor.name(),
            exported_caption(sensor),
            simulated_caption(recording),
            if dashed.is_empty() {
                String::new()
            } else {
                format!("; dashed: {}", dashed.join(", "))
            },
            match series.regions.len().saturating_sub(MOST_REGIONS) {
                0 => String::new(),
                more => format!("; {more} more in the table alone"),
            }
        ))
        .picture()?;
    Ok(picture)
}

/// The mean of every plateau over its time, in the colour of its force's line.
fn plateaus(measurement: &Measurement) -> Vec<Line> {
    let grip = measurement.series.grip.as_ref().map(|_| 1);
    let regions = REGIONS_FROM..REGIONS_FROM + MOST_REGIONS;
    // As forces of a trial are in order.
    let colours: Vec<usize> = [0].into_iter().chain(grip).chain(regions).collect();
    let forces = measurement.trials.iter().flat_map(|trial| {
        let forces = trial.forces.iter().zip(&colours);
        forces.filter_map(|(force, colour)| Some((force.plateau.as_ref()?, *colour)))
    });
    let line = |(plateau, colour): (&PlateauFigures, usize)| {
        Line::new("", vec![plateau.mean_n.value; 2])
            .over(vec![plateau.from_s, plateau.to_s])
            .style(LineStyle::Dashed)
            .colour(colour)
    };
    forces.map(line).collect()
}

/// The total in frames with readings at the end of the converter's range, a dot each: more pressed than they show.
fn saturated(series: &taxel_app::measure::Series, x: &[f64]) -> Option<Line> {
    let frames = series.is_saturated.iter().zip(x).zip(&series.total.newtons);
    let beyond: Vec<(f64, f64)> = frames
        .filter(|((is_saturated, _), _)| **is_saturated)
        .map(|((_, x), newtons)| (*x, *newtons))
        .collect();
    let every = beyond.len().div_ceil(POINTS).max(1);
    let (x, newtons) = beyond.into_iter().step_by(every).unzip();
    let line = Line::new("at the converter's end: more pressed", newtons);
    let line = line.over(x).style(LineStyle::Points).colour(3);
    (!line.values.is_empty()).then_some(line)
}

/// The edges of a force's interval, where it would be seen: a hundredth of the largest force, or more.
fn band(force: &ForceSeries) -> impl Iterator<Item = Vec<f64>> + '_ {
    let largest = |values: &[f64]| {
        values
            .iter()
            .copied()
            .filter(|v| v.is_finite())
            .fold(0.0, f64::max)
    };
    let is_seen = largest(&force.half_width_95) >= 0.01 * largest(&force.newtons);
    let edge = |sign: f64| {
        let pairs = force.newtons.iter().zip(&force.half_width_95);
        pairs.map(|(value, half)| value + sign * half).collect()
    };
    [-1.0, 1.0].into_iter().filter(move |_| is_seen).map(edge)
}
