//! A line a trial, for statistics.

use taxel::frame::STANDARD_GRAVITY;

use super::protocol::Hand;
use super::results::{Force, GripResults, TrialResult};
use crate::error::Error;

/// A column: its name, and what it says of a trial.
type Column = (&'static str, fn(&TrialResult) -> String);

/// What is told of every trial, after whose it is, what forces are spoken of, what intervals know, and whether a hand was there. Forces end in `_n`, newtons; their `_error_n` are half of a 95 % interval.
const COLUMNS: [Column; 19] = [
    ("trial", |trial| trial.number.to_string()),
    ("max_n", |trial| trial.max.newtons.to_string()),
    ("max_error_n", |trial| half(Some(trial.max))),
    ("max_kg", |trial| {
        (trial.max.newtons / STANDARD_GRAVITY).to_string()
    }),
    ("total_n", |trial| trial.total.newtons.to_string()),
    ("total_error_n", |trial| half(Some(trial.total))),
    ("plateau_n", |trial| {
        number(trial.plateau.map(|plateau| plateau.newtons))
    }),
    ("plateau_error_n", |trial| half(trial.plateau)),
    ("variation_percent", |trial| number(trial.variation_percent)),
    ("slope_percent_per_s", |trial| {
        number(trial.slope_percent_per_s)
    }),
    ("time_to_peak_s", |trial| trial.time_to_peak_s.to_string()),
    ("rate_n_per_s", |trial| number(trial.rate_n_per_s)),
    ("impulse_n_s", |trial| trial.impulse_n_s.to_string()),
    ("peak_kpa", |trial| trial.peak_kpa.to_string()),
    ("area_mm2", |trial| trial.area_mm2.to_string()),
    ("centre_path_mm", |trial| number(trial.centre_path_mm)),
    ("true_max_n", |trial| number(trial.true_max_newtons)),
    ("recording", |trial| trial.recording.clone()),
    ("doubts", |trial| trial.doubts.join("; ")),
];

fn number(value: Option<f64>) -> String {
    value.map_or_else(String::new, |value| value.to_string())
}

fn half(force: Option<Force>) -> String {
    number(force.and_then(|force| force.half_width_95_newtons))
}

/// All trials as CSV: those of the right hand first.
///
/// # Errors
/// None that data could cause.
pub(super) fn csv_of(results: &GripResults) -> Result<Vec<u8>, Error> {
    let mut parts: Vec<&str> = Vec::new();
    let trials = results.hands.iter().flat_map(|hand| &hand.trials);
    for (name, _) in trials.flat_map(|trial| &trial.shares) {
        if !parts.contains(&name.as_str()) {
            parts.push(name);
        }
    }
    let mut out = csv::Writer::from_writer(Vec::new());
    let first = [
        "person",
        "began_secs",
        "hand",
        "force",
        "intervals",
        "simulated",
    ];
    let head = first.into_iter().chain(COLUMNS.map(|(name, _)| name));
    let shares = parts
        .iter()
        .map(|part| format!("share_{}", part.replace(' ', "_")));
    let head = head.map(str::to_owned).chain(shares);
    out.write_record(head).map_err(unwritten)?;
    for hand in &results.hands {
        for trial in &hand.trials {
            let line = line_of(results, hand.hand, trial, &parts);
            out.write_record(line).map_err(unwritten)?;
        }
    }
    out.into_inner().map_err(unwritten)
}

fn line_of(results: &GripResults, hand: Hand, trial: &TrialResult, parts: &[&str]) -> Vec<String> {
    let mut line = vec![
        results.person.clone(),
        results.began_secs.to_string(),
        hand.word().to_owned(),
        results.force.clone(),
        results.intervals.clone(),
        results.is_simulated.to_string(),
    ];
    line.extend(COLUMNS.map(|(_, of)| of(trial)));
    line.extend(parts.iter().map(|part| {
        let mut shares = trial.shares.iter();
        let share = shares.find(|(name, _)| name == part);
        number(share.map(|(_, share)| *share))
    }));
    line
}

pub(super) fn unwritten(error: impl std::fmt::Display) -> Error {
    Error::Request {
        what: error.to_string(),
        hint: "the table could not be written",
    }
}
