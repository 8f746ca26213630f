//! How the reading follows the load, and where it ends. (The paper's Figs. 24 and 25.)

use super::Power;
use crate::stats::{Bootstrap, Estimate, Line, mean, standard_deviation};

/// A reading under a known load.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoadReading {
    /// In any unit, from 0.
    pub load: f64,
    /// In any unit.
    pub value: f64,
    /// The converter is at its end: the load may be more.
    pub saturated: bool,
}

/// Readings under one load.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoadLevel {
    /// The load.
    pub load: f64,
    /// Mean value, and its interval over experiments.
    pub value: Estimate,
    /// Standard deviation of the readings; `None` of a single one.
    pub standard_deviation: Option<f64>,
    /// Share of the readings at the converter's end, 0 to 1.
    pub saturated_share: f64,
}

/// What readings under several loads say.
#[derive(Debug, Clone, PartialEq)]
pub struct Response {
    /// By load, ascending.
    pub levels: Vec<LoadLevel>,
    /// Straight line through the unsaturated readings.
    pub line: Line,
    /// Its slope, value per load: the sensitivity.
    pub sensitivity: Estimate,
    /// Power law through them; `None` with fewer than three loads.
    pub power: Option<Power>,
    /// Its exponent.
    pub exponent: Option<Estimate>,
    /// Largest distance of a level's mean from the line, in % of the line's rise over the loads: independent
    /// (best straight line) non-linearity.
    pub non_linearity_percent: Estimate,
    /// The least load most of whose readings are at the converter's end.
    pub saturates_at: Option<f64>,
    /// The largest load that is below that.
    pub largest_usable: f64,
    /// The load whose reading stands three standard deviations of the readings without load above their mean, by the
    /// power law (the line where there is none): the limit of detection as IUPAC defines it. `None` where the sensor was not
    /// read without load, or once.
    pub smallest_detectable: Option<f64>,
}

/// Judges readings of one taxel (or of many alike), grouped by experiment. `None` with fewer than two unsaturated loads.
pub fn response(experiments: &[Vec<LoadReading>], bootstrap: &Bootstrap) -> Option<Response> {
    let all = experiments.concat();
    let levels = levels(experiments, bootstrap);
    let saturates_at = levels
        .iter()
        .find(|l| l.saturated_share > 0.5)
        .map(|l| l.load);
    let below = |load: f64| saturates_at.is_none_or(|end| load < end);
    let points = usable(&all, saturates_at);
    let line = Line::fit(&points)?;
    let power = Power::fit(&points);
    let non_linearity = |some: &[LoadReading]| non_linearity_percent(&usable(some, saturates_at));
    let lowest = levels.first().filter(|level| level.load == 0.0);
    let lowest = lowest.and_then(|level| level.standard_deviation);
    let smallest = lowest.and_then(|sigma| match &power {
        // Readings may fall with the load: the rise has the law's sign.
        Some(power) => power.x_of_rise(3.0 * sigma * power.factor.signum()),
        None => Some(3.0 * sigma / line.slope.abs()),
    });
    Some(Response {
        largest_usable: levels.iter().rev().find(|l| below(l.load))?.load,
        sensitivity: bootstrap.estimate(experiments, |some| {
            Some(Line::fit(&usable(some, saturates_at))?.slope)
        })?,
        exponent: bootstrap.estimate(experiments, |some| {
            Some(Power::fit(&usable(some, saturates_at))?.exponent)
        }),
        non_linearity_percent: bootstrap.estimate(experiments, non_linearity)?,
        line,
        power,
        saturates_at,
        smallest_detectable: smallest.filter(|load| load.is_finite()),
        levels,
    })
}

/// Load and value where the converter can still tell.
fn usable(readings: &[LoadReading], saturates_at: Option<f64>) -> Vec<(f64, f64)> {
    readings
        .iter()
        .filter(|r| !r.saturated && saturates_at.is_none_or(|end| r.load < end))
        .map(|r| (r.load, r.value))
        .collect()
}

fn levels(experiments: &[Vec<LoadReading>], bootstrap: &Bootstrap) -> Vec<LoadLevel> {
    let mut loads: Vec<f64> = experiments.iter().flatten().map(|r| r.load).collect();
    loads.sort_by(f64::total_cmp);
    loads.dedup();
    let level = |load: f64| {
        let of_load = |group: &Vec<LoadReading>| -> Vec<LoadReading> {
            group.iter().copied().filter(|r| r.load == load).collect()
        };
        let groups: Vec<Vec<LoadReading>> = experiments.iter().map(of_load).collect();
        let all = groups.concat();
        let values: Vec<f64> = all.iter().map(|r| r.value).collect();
        let value = bootstrap.estimate(&groups, |some| mean(some.iter().map(|r| r.value)))?;
        Some(LoadLevel {
            load,
            value,
            standard_deviation: standard_deviation(&values),
            saturated_share: mean(all.iter().map(|r| f64::from(u8::from(r.saturated))))?,
        })
    };
    loads.into_iter().filter_map(level).collect()
}

/// See [`Response::non_linearity_percent`].
fn non_linearity_percent(points: &[(f64, f64)]) -> Option<f64> {
    let line = Line::fit(points)?;
    let mut loads: Vec<f64> = points.iter().map(|p| p.0).collect();
    loads.sort_by(f64::total_cmp);
    loads.dedup();
    let rise = (line.slope * (loads.last()? - loads.first()?)).abs();
    let off = loads.iter().filter_map(|&load| {
        let of_load = points.iter().filter(|p| p.0 == load).map(|p| p.1);
        Some((mean(of_load)? - line.at(load)).abs())
    });
    let most = off.fold(0.0, f64::max);
    (rise > 0.0).then(|| 100.0 * most / rise)
}
