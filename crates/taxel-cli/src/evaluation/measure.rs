//! Recordings that a plan names and nobody has made yet: made live, with a word for each of what to press.

use std::collections::BTreeMap;
use std::io::{self, BufRead};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use taxel_acquire::Address;
use taxel_acquire::transport::State;
use taxel_record::Trial;
use taxel_view::report::number;

use super::plan::{Experiment, Plan};
use crate::error::Error;
use crate::frames::is_mcap;
use crate::live::{Options, Session, Wanted};
use crate::unit::MethodName;
use crate::{interrupt, out};

/// How long a source may be silent.
const PATIENCE: Duration = Duration::from_secs(20);

/// Makes every recording that the plan's trials name and that does not exist; those that exist are kept. Gives how many
/// were made.
pub(crate) fn measure(plan: &Plan, address: &Address) -> Result<usize, Error> {
    let wanted = missing(plan)?;
    if wanted.is_empty() {
        return Ok(0);
    }
    out::note(&format!(
        "{} recordings to make, {} frames each; Enter begins one, Ctrl-C ends and keeps what there is",
        wanted.len(),
        plan.live_frames
    ));
    interrupt::listen();
    let mut session = Session::start(Options {
        address: address.clone(),
        sensor: plan.sensor.clone(),
        sensor_file: plan.sensor_file.clone(),
        method: MethodName::Auto,
        folder: PathBuf::new(),
        wanted: Wanted {
            loads: false,
            figures: false,
        },
        server: None,
        record: None,
    })?;
    let mut made = 0;
    for (file, (name, words)) in &wanted {
        out::note(&format!(
            "[{}/{}] {name}: {words}, then Enter",
            made + 1,
            wanted.len()
        ));
        wait_for_enter()?;
        record(&mut session, file, plan.live_frames)?;
        made += 1;
    }
    session.end();
    Ok(made)
}

/// Recordings to make, each with its experiment and what to press.
fn missing(plan: &Plan) -> Result<BTreeMap<PathBuf, (String, String)>, Error> {
    let mut wanted: BTreeMap<PathBuf, (String, Vec<String>)> = BTreeMap::new();
    for experiment in &plan.experiments {
        for trial in super::trials(plan, experiment)? {
            if trial.recording.exists() {
                continue;
            }
            if !is_mcap(&trial.recording) {
                return Err(Error::Arguments {
                    what: format!(
                        "{} does not exist, and what is measured is recorded as .mcap",
                        trial.recording.display()
                    ),
                    hint: "name it .mcap in the table of trials",
                });
            }
            let entry = wanted.entry(trial.recording.clone());
            let (_, words) = entry.or_insert_with(|| (experiment.name.clone(), Vec::new()));
            words.push(words_of(experiment, &trial));
        }
    }
    let joined = |(name, words): (String, Vec<String>)| (name, words.join("; "));
    Ok(wanted
        .into_iter()
        .map(|(file, entry)| (file, joined(entry)))
        .collect())
}

/// What to do for a trial.
fn words_of(experiment: &Experiment, trial: &Trial) -> String {
    let mut words = match (trial.taxel, trial.load_g) {
        (Some((row, column)), Some(load)) if load > 0.0 => {
            format!("press row {row}, column {column} with {} g", number(load))
        }
        (Some(_), Some(_)) => "take everything off".to_owned(),
        (Some((row, column)), None) => format!("press row {row}, column {column}"),
        (None, _) => "press".to_owned(),
    };
    if let Some(total) = trial.total_g {
        words += &format!(", {} g in all", number(total));
    }
    if let Some(others) = trial.others {
        let line = match experiment.along {
            super::plan::Along::Row => "row",
            super::plan::Along::Column => "column",
        };
        words += &format!(" and {others} others of its {line} alike");
    }
    if let Some(setting) = &trial.setting {
        words += &format!(" ({setting})");
    }
    words
}

fn wait_for_enter() -> Result<(), Error> {
    let mut line = String::new();
    match io::stdin().lock().read_line(&mut line) {
        Ok(0) | Err(_) => Err(Error::Arguments {
            what: "nobody can press Enter: standard input has ended".to_owned(),
            hint: "run it in a terminal; what was recorded is kept, and a next run goes on from there",
        }),
        Ok(_) => Ok(()),
    }
}

/// Records so many frames; the file is whole when this returns.
fn record(session: &mut Session, file: &Path, frames: u64) -> Result<(), Error> {
    session.record(file)?;
    let begun = Instant::now();
    loop {
        let recording = session.recording().unwrap_or_default();
        let (state, text) = session.state();
        let silent = begun.elapsed() > PATIENCE && recording.frames == 0;
        let why = match (recording.error, state) {
            (Some(error), _) => Some(error),
            (None, State::Ended) => Some(text),
            _ if silent => Some(format!("no frame in {} s: {text}", PATIENCE.as_secs())),
            _ if interrupt::asked() => Some("ended by Ctrl-C".to_owned()),
            _ => None,
        };
        if recording.frames >= frames {
            session.stop_recording();
            return Ok(());
        }
        if let Some(why) = why {
            session.stop_recording();
            // A recording that is too short would pass for one that was made.
            let _ = std::fs::remove_file(file);
            return Err(Error::RecordingEnded {
                name: file.display().to_string(),
                frames: recording.frames,
                why,
            });
        }
        std::thread::sleep(Duration::from_millis(5));
    }
}
