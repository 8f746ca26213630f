//! From a plan and its recordings to a report: every figure of a sensor, with its interval.

mod accuracy;
mod at_end;
mod coverage;
mod creep;
mod cross_talk;
mod hysteresis;
pub mod measure;
pub mod plan;
mod provenance;
pub mod readings;
mod reference;
mod regions;
mod repeatability;
mod response;

use std::collections::{BTreeSet, HashMap};
use std::path::PathBuf;

use taxel_io::{Trial, read_trials};
use taxel_plot::report::{Report, Section};

use crate::error::{Error, remedy};
use crate::methods::MethodName;
use crate::reporter::Reporter;
use plan::{Experiment, Kind, Plan, Value};
use readings::{Group, Reader};

/// A plan, carried out.
pub struct Evaluation {
    /// What is to be read.
    pub report: Report,
    /// Frames that could not be read or that no conductances explain.
    pub lost: u64,
}

/// Evaluates everything that a plan names.
pub fn run(plan: &Plan, reporter: &dyn Reporter) -> Result<Evaluation, Error> {
    let mut report = Report {
        title: plan.title.clone(),
        about: provenance::about(plan)?,
        sections: Vec::new(),
    };
    let mut files = BTreeSet::from([plan.file.clone()]);
    files.extend(plan.regions.clone());
    let mut lost = 0;
    for experiment in &plan.experiments {
        let (mut section, left_out) = evaluate(plan, experiment, &mut files, reporter)?;
        section.paragraphs.extend(experiment.note.clone());
        if left_out > 0 {
            section.paragraphs.push(format!(
                "{left_out} frames could not be read, or no conductances explain them; they are left out."
            ));
        }
        lost += left_out;
        report.sections.push(section);
    }
    let (section, left_out) = regions::section(plan, reporter)?;
    lost += left_out;
    report.sections.extend(section);
    report.sections.extend(reference::section(plan, reporter)?);
    report
        .sections
        .push(provenance::data(plan, &files, reporter)?);
    Ok(Evaluation { report, lost })
}

fn evaluate(
    plan: &Plan,
    experiment: &Experiment,
    files: &mut BTreeSet<PathBuf>,
    reporter: &dyn Reporter,
) -> Result<(Section, u64), Error> {
    let Some(table) = &experiment.trials else {
        return accuracy::of_whole_frames(plan, experiment, files, reporter);
    };
    files.insert(table.clone());
    let trials = trials(plan, experiment)?;
    need(experiment, &trials)?;
    no_trial_twice(experiment, &trials)?;
    files.extend(trials.iter().map(|trial| trial.recording.clone()));
    let (groups, lost, faulty) = gather(plan, experiment, trials, files, reporter)?;
    let mut section = match experiment.kind {
        Kind::Repeatability => repeatability::section(plan, experiment, &groups)?,
        Kind::Response => response::section(plan, experiment, &groups)?,
        Kind::Hysteresis => hysteresis::section(plan, experiment, &groups)?,
        Kind::Creep => creep::section(plan, experiment, &groups)?,
        Kind::CrossTalk => cross_talk::section(plan, experiment, &groups)?,
        Kind::Accuracy => accuracy::section(plan, experiment, &groups)?,
    };
    section.paragraphs.extend(faulty_lines(&faulty, reporter));
    Ok((section, lost))
}

/// Lines that are out which are named.
const NAMED: usize = 10;

/// Says which lines are out in recordings; `None` where none is.
fn faulty_lines(faulty: &BTreeSet<String>, reporter: &dyn Reporter) -> Option<String> {
    for line in faulty.iter().take(NAMED) {
        reporter.warn(line);
    }
    let mut named: Vec<&str> = faulty.iter().take(NAMED).map(String::as_str).collect();
    let more = format!("{} more", faulty.len().saturating_sub(NAMED));
    if faulty.len() > NAMED {
        named.push(&more);
    }
    (!named.is_empty()).then(|| {
        format!(
            "Lines that are out, whose readings are no measurement: {}.",
            named.join("; ")
        )
    })
}

/// The trials of an experiment.
pub fn trials(plan: &Plan, experiment: &Experiment) -> Result<Vec<Trial>, Error> {
    let Some(table) = &experiment.trials else {
        return Ok(Vec::new());
    };
    let (sensor, _) = plan.sensor_of(experiment.sensor.as_ref())?;
    let labels = sensor.array().labels.as_deref();
    let trials = read_trials(table, sensor.rows(), sensor.columns(), labels)?;
    for trial in &trials {
        if let Some((row, column)) = trial.taxel
            && sensor.is_absent(row * sensor.columns() + column)
        {
            return Err(Error::AbsentTaxel {
                table: table.clone(),
                line: trial.line,
                row,
                column,
            });
        }
    }
    Ok(trials)
}

/// Every line must have what its kind of experiment is about.
fn need(experiment: &Experiment, trials: &[Trial]) -> Result<(), Error> {
    for trial in trials {
        let missing = match experiment.kind {
            Kind::Accuracy if trial.total_g.is_some() || trial.place_mm.is_some() => None,
            Kind::Accuracy if !has_place(trial) || trial.load_g.is_none() => {
                Some("taxel or region and load_g, or total_g, or x_mm and y_mm")
            }
            Kind::CrossTalk if trial.taxel.is_none() => Some("row and column, or taxel"),
            _ if !has_place(trial) => Some("row and column, or taxel, or region"),
            // A region has no counts, volts or siemens.
            _ if trial.region.is_some() && experiment.value() != Value::Grams => {
                Some("`value = \"grams\"` in the plan where a region is named")
            }
            Kind::Response | Kind::Hysteresis if trial.load_g.is_none() => Some("load_g"),
            Kind::CrossTalk if trial.others.is_none() => Some("others"),
            _ => None,
        };
        if let Some(needs) = missing {
            return Err(Error::Trial {
                table: experiment.trials.clone().unwrap_or_default(),
                line: trial.line,
                kind: experiment.kind.word(),
                needs,
            });
        }
    }
    Ok(())
}

/// Whether a trial says what is looked at.
fn has_place(trial: &Trial) -> bool {
    trial.taxel.is_some() || trial.region.is_some()
}

/// A line without the name of an experiment is an experiment of its own: the same frames of the same taxel a second time
/// would be taken for something new, and make every interval too narrow.
fn no_trial_twice(experiment: &Experiment, trials: &[Trial]) -> Result<(), Error> {
    let mut seen: HashMap<_, Vec<&Trial>> = HashMap::new();
    for trial in trials.iter().filter(|trial| trial.experiment.is_none()) {
        let place = (&trial.recording, trial.taxel, &trial.region, &trial.setting);
        let others = seen.entry(place).or_default();
        // All frames of a recording have every one of them among them.
        let same = |other: &&&Trial| match (other.frame, trial.frame) {
            (Some(a), Some(b)) => a == b,
            _ => true,
        };
        if let Some(first) = others.iter().find(same) {
            return Err(Error::TrialTwice {
                table: experiment.trials.clone().unwrap_or_default(),
                lines: (first.line, trial.line),
                recording: trial.recording.clone(),
                frames: match trial.frame.or(first.frame) {
                    Some(frame) => format!("frame {frame}"),
                    None => "all frames".to_owned(),
                },
            });
        }
        others.push(trial);
    }
    Ok(())
}

/// Reads what the trials point to, setting by setting.
fn gather(
    plan: &Plan,
    experiment: &Experiment,
    trials: Vec<Trial>,
    files: &mut BTreeSet<PathBuf>,
    reporter: &dyn Reporter,
) -> Result<(Vec<Group>, u64, BTreeSet<String>), Error> {
    let table = experiment.trials.clone().unwrap_or_default();
    let mut by_setting: Vec<(String, Vec<Trial>)> = Vec::new();
    for trial in trials {
        let setting = trial.setting.clone().unwrap_or_default();
        match by_setting.iter_mut().find(|(name, _)| *name == setting) {
            Some((_, group)) => group.push(trial),
            None => by_setting.push((setting, vec![trial])),
        }
    }
    let methods = experiment.methods(plan.folder())?;
    files.extend(methods.iter().filter_map(MethodName::file));
    let (mut groups, mut lost, mut faulty) = (Vec::new(), 0, BTreeSet::new());
    for (setting, trials) in by_setting {
        let own = experiment.settings.get(&setting);
        let (sensor, file) = plan.sensor_of(own.or(experiment.sensor.as_ref()))?;
        files.insert(file.clone());
        regions::check(&table, &trials, &sensor)?;
        let mut reader = Reader::new(&sensor, &file, &methods, plan.frames_per_second, reporter)?;
        if experiment.kind == Kind::Accuracy {
            reader.find_intervals(&methods);
        }
        let readings = reader.read(&table, &trials)?;
        let left_out = reader.skipped + reader.unsolved;
        lost += left_out;
        faulty.append(&mut reader.faulty);
        groups.push(Group {
            experiment: experiment.name.clone(),
            lost: left_out,
            setting,
            sensor,
            trials,
            readings,
        });
    }
    Ok((groups, lost, faulty))
}

/// An evaluation that its readings do not allow.
fn too_few(experiment: &Experiment, group: &Group, needs: &'static str) -> Error {
    Error::TooFew {
        table: experiment.trials.clone().unwrap_or_default(),
        setting: group.name().to_owned(),
        kind: experiment.kind.word(),
        readings: group.readings.len(),
        lost: group.lost,
        needs,
    }
}

/// A reading has no such value by the first method.
fn no_value(plan: &Plan, value: Value) -> Error {
    match value {
        Value::Siemens => Error::Request {
            what: format!(
                "{}: siemens are asked for, but the first method is a model, which estimates loads alone",
                plan.file.display()
            ),
            hint: "let `raw`, `auto`, `exact` or `newton` be the first of the methods, or look at another value: counts, volts, grams",
        },
        _ => no_law(plan),
    }
}

/// A reading has no load because the sensor file has no load law.
fn no_law(plan: &Plan) -> Error {
    Error::Request {
        what: format!(
            "{}: loads are asked for, but the sensor file has no [material]",
            plan.file.display()
        ),
        hint: remedy::CALIBRATE,
    }
}
