//! A frame that was solved a moment ago as a line of JSON, for programs that know nothing of this one.

use serde::Serialize;
use taxel::metric::is_usable;
use taxel::{Frame, Mark, Newtons};

use crate::session::LiveFrame;

/// Loads are told to a tenth of a millinewton.
const PARTS: f64 = 1e4;

/// What stands in a line; units are in the names.
#[derive(Serialize)]
struct Line {
    frame: u64,
    /// Of the device's clock, seconds.
    #[serde(skip_serializing_if = "Option::is_none")]
    time_s: Option<f64>,
    /// When it arrived, seconds since 1970.
    unix_s: f64,
    /// Whether the inverse came to an answer.
    is_answer: bool,
    /// Null, as those that follow, without an answer and where the sensor has no load law.
    total_n: Option<f64>,
    peak_kpa: Option<f64>,
    area_mm2: Option<f64>,
    /// Centre of pressure across the columns and across the rows; null where nothing presses as well.
    centre_mm: Option<[f64; 2]>,
    measured_share: f64,
    /// Rows of loads; null where nothing was measured, or there is no taxel.
    #[serde(skip_serializing_if = "Option::is_none")]
    loads_n: Option<Vec<Vec<Option<f64>>>>,
    /// What is not good: row, column, word.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    marks: Vec<(usize, usize, &'static str)>,
}

/// The frame as a line, its line end included; with the loads of all taxels, or their sums alone.
pub fn json_line(frame: &LiveFrame, with_loads: bool) -> String {
    let figures = frame.figures;
    let since = frame.at.duration_since(std::time::UNIX_EPOCH);
    let has_loads = frame.loads.is_some() && frame.is_answer;
    let line = Line {
        frame: frame.counts.sequence,
        time_s: frame.counts.time_secs,
        unix_s: since.unwrap_or_default().as_secs_f64(),
        is_answer: frame.is_answer,
        total_n: has_loads.then(|| rounded(figures.total_force_newtons)),
        peak_kpa: has_loads.then(|| rounded(figures.peak_kilopascals)),
        area_mm2: has_loads.then(|| rounded(figures.contact_area_mm2)),
        centre_mm: figures
            .centre_mm
            .filter(|_| has_loads)
            .map(|[row, column]| [rounded(column), rounded(row)]),
        measured_share: rounded(figures.measured_share),
        loads_n: frame.loads.filter(|_| with_loads).map(rows_of),
        marks: frame
            .loads
            .filter(|_| with_loads)
            .map(marks_of)
            .unwrap_or_default(),
    };
    let mut text = serde_json::to_string(&line).expect("plain data is JSON");
    text.push('\n');
    text
}

fn rounded(value: f64) -> f64 {
    (value * PARTS).round() / PARTS
}

fn rows_of(loads: &Frame<Newtons>) -> Vec<Vec<Option<f64>>> {
    let told = loads
        .values()
        .iter()
        .zip(loads.marks())
        .map(|(&load, mark)| is_usable(*mark).then(|| rounded(load)));
    let told: Vec<Option<f64>> = told.collect();
    told.chunks(loads.columns()).map(<[_]>::to_vec).collect()
}

fn marks_of(loads: &Frame<Newtons>) -> Vec<(usize, usize, &'static str)> {
    let marks = loads.marks().iter().enumerate();
    let told = marks.filter(|(_, mark)| !matches!(mark, Mark::Good | Mark::Absent));
    let columns = loads.columns();
    told.map(|(at, mark)| (at / columns, at % columns, mark.word()))
        .collect()
}
