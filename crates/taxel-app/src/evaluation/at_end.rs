//! Readings at the end of the converter's range, as pictures show them.

use taxel::circuit::Converter;
use taxel::{Counts, Frame};
use taxel_io::Trial;
use taxel_plot::{Line, LineStyle};

use super::plan::Value;
use super::readings::{Group, TrialReading};

/// What the legend calls them: what pressed may be more.
pub(super) const AT_END: &str = "at the converter's end";
/// Of them a picture shows this many at most.
const DRAWN: usize = 2000;

/// Such points, drawn over the others in a colour of their own; `None` where there are none.
pub(super) fn at_end(points: Vec<(f64, f64)>) -> Option<Line> {
    let step = points.len().div_ceil(DRAWN).max(1);
    let (x, values): (Vec<f64>, Vec<f64>) = points.into_iter().step_by(step).unzip();
    let line = Line::new(AT_END, values).over(x);
    let line = line.style(LineStyle::Points).colour(3);
    (!line.values.is_empty()).then_some(line)
}

/// The readings of a group there, at the places that `place` gives a reading of a trial; its third is the first reading of
/// the same experiment.
pub(super) fn readings_at_end(
    group: &Group,
    place: impl Fn(&Trial, &TrialReading, &TrialReading) -> Option<(f64, f64)>,
) -> Option<Line> {
    let mut points = Vec::new();
    for experiment in group.experiments() {
        let there = experiment.iter().filter(|reading| reading.saturated);
        points.extend(there.filter_map(|reading| {
            let trial = &group.trials[reading.trial];
            place(trial, reading, experiment[0])
        }));
    }
    at_end(points)
}

/// The largest reading that the converter has, where the value is one: its size.
pub(super) fn ceiling(group: &Group, value: Value) -> Option<f64> {
    let sensor = &group.sensor;
    match value {
        Value::Counts => Some(sensor.max_count()),
        Value::Volts => {
            let end = Frame::<Counts>::filled(1, 1, sensor.max_count());
            let volts = Converter::from_sensor(sensor).volts_from_counts(&end);
            Some(volts.values()[0].abs())
        }
        Value::Siemens | Value::Grams => None,
    }
}

/// That reading, drawn from end to end; `like` is a reading of its sign.
pub(super) fn ceiling_line(ceiling: f64, like: f64, x: Vec<f64>) -> Line {
    // Some read-outs give negative volts.
    Line::new("converter's end", vec![like.signum() * ceiling; x.len()])
        .over(x)
        .style(LineStyle::Dashed)
        .colour(7)
}
