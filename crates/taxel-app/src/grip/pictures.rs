//! The pictures of a grip session's page, of a size that two stand side by side on a sheet of A4 with labels of 8 points and more.

use taxel::metric::kilopascals_from_newtons;
use taxel::{Frame, Newtons, Sensor};
use taxel_plot::report::Figure;
use taxel_plot::{Line, LineStyle, Panel, Picture, Series};

use super::protocol::Hand;
use super::trial::MeasuredTrial;
use crate::error::Error;

/// Points of a curve at most: finer than a picture shows.
const POINTS: usize = 600;
/// Curves begin so long before the grip, and end so long after it, seconds.
const AROUND_SECS: f64 = 0.5;
/// What a square map is not made lower than, of the most.
const LEAST_MAP: f64 = 0.7;
/// Sizes of plots, points; heights are the most.
const CURVES: (f64, f64) = (250.0, 85.0);
const PATHS: (f64, f64) = (120.0, 85.0);
const MAP: (f64, f64) = (195.0, 100.0);

/// Forces over time, paths of the centre, and the pressure of each hand's best trial; `height` is that share of the most.
pub(super) fn figures(
    hands: &[(Hand, Vec<MeasuredTrial>)],
    sensor: &Sensor,
    height: f64,
) -> Result<Vec<Figure>, Error> {
    let mut figures = vec![Figure {
        caption: "Every trial. Right hand: blue, solid; left: orange, dashed.".to_owned(),
        picture: curves(hands, height)?,
    }];
    let best: Vec<(Hand, &MeasuredTrial)> = hands
        .iter()
        .filter_map(|(hand, trials)| Some((*hand, best(trials)?)))
        .collect();
    if let Some(picture) = paths(&best, height)? {
        figures.push(Figure {
            caption: "Centre of pressure in the best trials.".to_owned(),
            picture,
        });
    }
    figures.extend(maps(&best, sensor, height)?);
    Ok(figures)
}

/// The trial with the largest force.
pub(super) fn best(trials: &[MeasuredTrial]) -> Option<&MeasuredTrial> {
    let newtons = |trial: &MeasuredTrial| trial.result.max.newtons;
    trials
        .iter()
        .max_by(|a, b| newtons(a).total_cmp(&newtons(b)))
}

/// How a hand's lines look.
fn look(hand: Hand) -> (usize, LineStyle) {
    match hand {
        Hand::Right => (0, LineStyle::Solid),
        Hand::Left => (1, LineStyle::Dashed),
    }
}

fn curves(hands: &[(Hand, Vec<MeasuredTrial>)], height: f64) -> Result<Picture, Error> {
    let mut lines = Vec::new();
    for (hand, trials) in hands {
        let (colour, style) = look(*hand);
        for trial in trials {
            let shown = -AROUND_SECS..=trial.held_secs + AROUND_SECS;
            let points = trial.curve.0.iter().zip(&trial.curve.1);
            let points: Vec<_> = points.filter(|(secs, _)| shown.contains(*secs)).collect();
            let every = points.len().div_ceil(POINTS).max(1);
            let (secs, newtons) = points.into_iter().step_by(every).unzip();
            let line = Line::new("", newtons).over(secs);
            lines.push(line.colour(colour).style(style));
        }
    }
    let series = Series::new("time (s)", Vec::new(), lines)?;
    let series = series.quantity("force").unit("N");
    Ok(series.size(CURVES.0, height * CURVES.1).picture()?)
}

/// Paths of the centre about their means; none where there are none.
fn paths(best: &[(Hand, &MeasuredTrial)], height: f64) -> Result<Option<Picture>, Error> {
    let about_mean = |values: &[f64]| -> Vec<f64> {
        let middle = taxel::stats::mean(values.iter().copied()).unwrap_or(0.0);
        values.iter().map(|value| value - middle).collect()
    };
    let moving = best.iter().filter(|(_, trial)| trial.path.0.len() > 1);
    let line = |(hand, trial): &(Hand, &MeasuredTrial)| {
        let (colour, style) = look(*hand);
        let (x, y) = (about_mean(&trial.path.0), about_mean(&trial.path.1));
        Line::new("", y).over(x).colour(colour).style(style)
    };
    let lines: Vec<Line> = moving.map(line).collect();
    if lines.is_empty() {
        return Ok(None);
    }
    let series = Series::new("columns (mm)", Vec::new(), lines)?;
    let series = series.quantity("rows").unit("mm");
    Ok(Some(series.size(PATHS.0, height * PATHS.1).picture()?))
}

/// A wide map that is lower has its colours beneath it, and takes no less room.
fn map_height(map: &Frame<Newtons>, height: f64) -> f64 {
    if map.columns() > map.rows() {
        MAP.1
    } else {
        height.max(LEAST_MAP) * MAP.1
    }
}

/// Mean pressure over the plateau, both hands in the same colours; what is below 0 is noise, and drawn as nothing.
fn maps(
    best: &[(Hand, &MeasuredTrial)],
    sensor: &Sensor,
    height: f64,
) -> Result<Vec<Figure>, Error> {
    let pressure = |map: &Frame<Newtons>| -> Vec<f64> {
        let newtons = map.values().iter().enumerate();
        newtons
            .map(|(taxel, newtons)| {
                kilopascals_from_newtons(
                    newtons.clamp(0.0, f64::INFINITY),
                    sensor.taxel_area_mm2(taxel),
                )
            })
            .collect()
    };
    let mapped: Vec<_> = best
        .iter()
        .filter_map(|(hand, trial)| Some((*hand, trial.result.number, trial.map.as_ref()?)))
        .map(|(hand, number, map)| (hand, number, map, pressure(map)))
        .collect();
    let all = mapped.iter().flat_map(|(.., values)| values);
    let highest = all.copied().filter(|value| value.is_finite());
    let highest = highest.fold(0.0, f64::max);
    mapped
        .iter()
        .map(|(hand, number, map, values)| {
            let panel = Panel::new(map.rows(), map.columns(), values)?
                .marks(map.marks())?
                .quantity("pressure")
                .unit("kPa")
                .range(0.0, highest)
                .within(MAP.0, map_height(map, height));
            let panel = panel.pitch_mm(sensor.array().pitch_mm);
            let panel = match sensor.positions() {
                Some(positions) => panel.positions_mm(positions)?,
                None => panel,
            };
            Ok(Figure {
                caption: format!(
                    "Mean pressure over the plateau: {} hand, trial {number}.",
                    hand.word()
                ),
                picture: panel.picture()?,
            })
        })
        .collect()
}
