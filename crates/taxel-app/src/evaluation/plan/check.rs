//! Whether a plan makes sense.

use std::collections::BTreeSet;

use taxel::Sensor;
use taxel_io::read_trials;
use taxel_plot::report::number;

use super::{Experiment, Kind, Written};

/// Numbers that are in no experiment.
pub(super) fn numbers(written: &Written) -> Result<(), String> {
    let outside =
        |key, found: String, expected| Err(format!("{key} = {found}, expected {expected}"));
    match written {
        Written {
            confidence: Some(share),
            ..
        } if !(0.5..1.0).contains(share) => outside(
            "confidence",
            number(*share),
            "0.5 to below 1: 0.95 for 95 %",
        ),
        Written {
            resamples: Some(count),
            ..
        } if !(100..=1_000_000).contains(count) => {
            outside("resamples", count.to_string(), "100 to 1000000")
        }
        Written {
            frames_per_second: Some(rate),
            ..
        } if !(*rate > 0.0 && rate.is_finite()) => {
            outside("frames_per_second", rate.to_string(), "a number above 0")
        }
        Written {
            live_frames: Some(0),
            ..
        } => outside("live_frames", "0".to_owned(), "1 or more"),
        _ => Ok(()),
    }
}

/// Keys that another kind of experiment has: nothing is left unread in silence.
fn keys(experiment: &Experiment) -> Result<(), String> {
    let kind = experiment.kind;
    let whole = experiment.recording.is_some();
    let keys = [
        (
            "value",
            experiment.value.is_some(),
            !matches!(kind, Kind::Accuracy | Kind::CrossTalk),
        ),
        ("along", experiment.along.is_some(), kind == Kind::CrossTalk),
        (
            "ranges_g",
            !experiment.ranges_g.is_empty(),
            kind == Kind::Accuracy,
        ),
        (
            "frames_per_experiment",
            experiment.frames_per_experiment.is_some(),
            whole,
        ),
        ("settings", !experiment.settings.is_empty(), !whole),
    ];
    match keys.iter().find(|(_, given, read)| *given && !read) {
        Some((key, ..)) => Err(format!(
            "{key} applies to {}, and this experiment is {}{}",
            applies_to(key),
            kind.word(),
            if whole {
                " of a recording with all loads"
            } else {
                " by a table of trials"
            }
        )),
        None => Ok(()),
    }
}

/// The experiments that read a key.
fn applies_to(key: &str) -> &'static str {
    match key {
        "value" => "all kinds but accuracy and cross-talk",
        "along" => "cross-talk only",
        "ranges_g" => "accuracy only",
        "frames_per_experiment" => "accuracy of a recording with truth_g only",
        _ => "tables of trials only",
    }
}

/// Every setting with a sensor file of its own is one of the trials': a word that is spelt otherwise there would be
/// evaluated with the wrong sensor. What is wrong with the table itself is said where it is read.
pub(super) fn settings(experiment: &Experiment, sensor: &Sensor) -> Result<(), String> {
    let (Some(table), false) = (&experiment.trials, experiment.settings.is_empty()) else {
        return Ok(());
    };
    let labels = sensor.array().labels.as_deref();
    let Ok(trials) = read_trials(table, sensor.rows(), sensor.columns(), labels) else {
        return Ok(());
    };
    let known: BTreeSet<&str> = trials.iter().filter_map(|t| t.setting.as_deref()).collect();
    match experiment
        .settings
        .keys()
        .find(|word| !known.contains(word.as_str()))
    {
        Some(word) => Err(format!(
            "experiment '{}': [experiment.settings] names '{word}'; {} has {}",
            experiment.name,
            table.display(),
            match known.len() {
                0 => "no column `setting`".to_owned(),
                _ => listed(known),
            }
        )),
        None => Ok(()),
    }
}

/// `'0.4 V', '1 V' and '9 V'`.
fn listed(words: BTreeSet<&str>) -> String {
    let quoted: Vec<String> = words.iter().map(|word| format!("'{word}'")).collect();
    match quoted.split_last() {
        Some((last, [])) => last.clone(),
        Some((last, rest)) => format!("{} and {last}", rest.join(", ")),
        None => String::new(),
    }
}

/// What must go together.
pub(super) fn experiment(experiment: &Experiment) -> Result<(), String> {
    let whole = experiment.recording.is_some() || experiment.truth_g.is_some();
    match (&experiment.trials, whole) {
        (Some(_), true) => return Err("both trials and recording; one of them".to_owned()),
        (None, false) => {
            return Err("no trials: the table of what was pressed when".to_owned());
        }
        (None, true) if experiment.kind != Kind::Accuracy => {
            return Err(format!("{} needs trials", experiment.kind.word()));
        }
        (None, true) if experiment.recording.is_none() || experiment.truth_g.is_none() => {
            return Err("recording and truth_g go together".to_owned());
        }
        _ => {}
    }
    keys(experiment)?;
    if experiment.name.trim().is_empty() {
        return Err("no name: it is the title in the report".to_owned());
    }
    if experiment.frames_per_experiment == Some(0) {
        return Err("frames_per_experiment = 0, expected 1 or more".to_owned());
    }
    if !experiment.ranges_g.is_sorted() {
        return Err(format!("ranges_g = {:?} must ascend", experiment.ranges_g));
    }
    Ok(())
}
