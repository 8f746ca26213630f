//! Forces over time as a picture.

use std::path::Path;

use taxel::Sensor;
use taxel_plot::{Line, LineStyle, Picture, Series};

use crate::error::Error;
use taxel_app::exported::exported_caption;
use taxel_app::measure::{ForceSeries, Measurement};
use taxel_app::simulated::simulated_caption;

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
    let total = &series.total;
    lines.push(Line::new("total normal force", thin(&total.newtons)).colour(0));
    lines.extend(band(total).map(|edge| {
        Line::new("", thin(&edge))
            .style(LineStyle::Dashed)
            .colour(0)
    }));
    if let Some(grip) = &series.grip {
        lines.push(Line::new("grip force", thin(&grip.newtons)).colour(1));
    }
    for (at, (region, _)) in series.regions.iter().enumerate() {
        lines.push(Line::new(&region.name, thin(&region.newtons)).colour(2 + at % 8));
    }
    for trial in &measurement.trials {
        for (force, colour) in trial.forces.iter().zip([0, 1]) {
            if let Some(plateau) = &force.plateau {
                let (from, to, mean) = (plateau.from_s, plateau.to_s, plateau.mean_n.value);
                lines.push(
                    Line::new("", vec![mean; 2])
                        .over(vec![from, to])
                        .style(LineStyle::Dashed)
                        .colour(colour),
                );
            }
        }
    }
    lines.extend(saturated(series, &x));
    let label = if has_times { "time (s)" } else { "frame" };
    let name = recording.file_name().unwrap_or_default().to_string_lossy();
    let picture = Series::new(label, thin(&x), lines)?
        .title(name)
        .quantity("force")
        .unit("N")
        .caption(format!(
            "{}{}{}; dashed: plateaus",
            sensor.name(),
            exported_caption(sensor),
            simulated_caption(recording)
        ))
        .picture()?;
    Ok(picture)
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
