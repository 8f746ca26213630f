//! Recordings that a plan names and nobody has made yet: made live, with a word for each of what to press.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use taxel_acquire::Address;
use taxel_acquire::transport::State;
use taxel_io::Trial;
use taxel_plot::report::number;

use super::plan::{Experiment, Plan};
use crate::error::Error;
use crate::frames::is_mcap;
use crate::reporter::Reporter;
use crate::session::{Session, SessionOptions};

/// How long a source may be silent.
const PATIENCE: Duration = Duration::from_secs(20);

/// The person who presses what a plan asks for.
pub trait Operator: Reporter {
    /// Says what the next recording is of, and waits until the person is ready for it. Who ends it there is heard from the first word on.
    ///
    /// # Errors
    /// Why the person never will be.
    fn wait(&self, what: &str) -> Result<(), Error>;

    /// Whether the person wants to end.
    fn has_ended(&self) -> bool;
}

/// A recording to make.
struct Missing {
    file: PathBuf,
    experiment: String,
    /// What to do for each of its trials.
    words: Vec<String>,
    frames: u64,
}

/// Makes every recording that the plan's trials name and that does not exist, in the order of the tables; those that
/// exist are kept. Gives how many were made.
pub fn measure(plan: &Plan, address: &Address, operator: &dyn Operator) -> Result<usize, Error> {
    let wanted = missing(plan)?;
    if wanted.is_empty() {
        return Ok(0);
    }
    operator.note(&format!(
        "{} recordings to make; Enter begins one, Ctrl-C ends: what was recorded is kept",
        wanted.len(),
    ));
    let mut session = Session::start(SessionOptions::new(
        address.clone(),
        plan.sensor.clone(),
        &plan.sensor_file,
    ))?;
    for (number, one) in wanted.iter().enumerate() {
        operator.wait(&format!(
            "[{}/{}] {}: {}, then Enter",
            number + 1,
            wanted.len(),
            one.experiment,
            one.words.join("; "),
        ))?;
        let frames = record(&mut session, &one.file, one.frames, operator)?;
        operator.note(&format!("{frames} frames in {}", one.file.display()));
    }
    session.end();
    Ok(wanted.len())
}

/// Recordings to make, each with its experiment and what to press, in the order of the tables.
fn missing(plan: &Plan) -> Result<Vec<Missing>, Error> {
    let mut wanted: Vec<Missing> = Vec::new();
    for experiment in &plan.experiments {
        for trial in super::trials(plan, experiment)? {
            if trial.recording.exists() {
                continue;
            }
            if !is_mcap(&trial.recording) {
                return Err(Error::Request {
                    what: format!(
                        "{} does not exist, and what is measured is recorded as .mcap",
                        trial.recording.display()
                    ),
                    hint: "name it .mcap in the table of trials",
                });
            }
            let known = wanted.iter().position(|one| one.file == trial.recording);
            let place = known.unwrap_or_else(|| {
                wanted.push(Missing {
                    file: trial.recording.clone(),
                    experiment: experiment.name.clone(),
                    words: Vec::new(),
                    frames: plan.live_frames,
                });
                wanted.len() - 1
            });
            let one = &mut wanted[place];
            let words = words_of(experiment, &trial);
            if !one.words.contains(&words) {
                one.words.push(words);
            }
            // A trial that asks for a frame gets it.
            let asked = trial.frame.map_or(0, |frame| frame as u64 + 1);
            one.frames = one.frames.max(asked);
        }
    }
    Ok(wanted)
}

/// What to do for a trial.
fn words_of(experiment: &Experiment, trial: &Trial) -> String {
    let mut words = match (trial.taxel, trial.load_g) {
        (Some((row, column)), Some(load)) if load > 0.0 => {
            format!("press row {row}, column {column} with {} g", number(load))
        }
        (Some(_), Some(_)) => "take everything off".to_owned(),
        (Some((row, column)), None) => format!("press row {row}, column {column}"),
        (None, load) => match (&trial.region, load) {
            (Some(_), Some(0.0)) => "take everything off".to_owned(),
            (Some(region), Some(load)) => format!("press {region} with {} g", number(load)),
            (Some(region), None) => format!("press {region}"),
            (None, _) => "press".to_owned(),
        },
    };
    if let Some((x, y)) = trial.place_mm {
        words += &format!(" at x {} mm, y {} mm", number(x), number(y));
    }
    if let Some(total) = trial.total_g {
        words += &format!(", {} g in all", number(total));
    }
    if let Some(others) = trial.others {
        let line = match experiment.along() {
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

/// Records so many frames and gives how many; the file is whole when this returns. It has its name only
/// then: one that is too short would pass for one that was made.
fn record(
    session: &mut Session,
    file: &Path,
    frames: u64,
    operator: &dyn Operator,
) -> Result<u64, Error> {
    let partial = file.with_extension("partial.mcap");
    // Of a run that was killed.
    let _ = fs::remove_file(&partial);
    if let Some(folder) = file.parent() {
        // Where this fails, the recording says why.
        let _ = fs::create_dir_all(folder);
    }
    session.record(&partial, Some(frames))?;
    let ended = |frames, why| Error::RecordingEnded {
        name: file.display().to_string(),
        frames,
        why,
    };
    let begun = Instant::now();
    loop {
        let recording = session.recording().unwrap_or_default();
        let (state, text) = session.state();
        let silent = begun.elapsed() > PATIENCE && recording.frames == 0;
        let why = match (recording.error, state) {
            (Some(error), _) => Some(error),
            (None, State::Ended) => Some(text),
            _ if silent => Some(format!("no frame in {} s: {text}", PATIENCE.as_secs())),
            _ if operator.has_ended() => Some("ended by Ctrl-C".to_owned()),
            _ => None,
        };
        if recording.frames >= frames || why.is_some() {
            let saved = session.stop_recording().unwrap_or_default();
            let why = saved.error.or(why.filter(|_| saved.frames < frames));
            if let Some(why) = why {
                let _ = fs::remove_file(&partial);
                return Err(ended(saved.frames, why));
            }
            return match fs::rename(&partial, file) {
                Ok(()) => Ok(saved.frames),
                Err(error) => Err(ended(saved.frames, error.to_string())),
            };
        }
        std::thread::sleep(Duration::from_millis(5));
    }
}
