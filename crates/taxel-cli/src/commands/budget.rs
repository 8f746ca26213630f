//! `taxel budget`: which component to change.

mod table;

use std::path::{Path, PathBuf};
use std::str::FromStr;

use serde::Serialize;
use taxel::design::budget::{Budget, BudgetScene, Cause, Change, Errors, Part, changes};
use taxel::design::reach::{LineReach, line_reach};
use taxel::{Frame, Sensor};

use crate::error::Error;
use crate::out::warn_unsolved;
use crate::progress::{Progress, Terminal};
use crate::{Exit, out};
use taxel_app::chain::Chain;
use taxel_app::frames::{DisplayUnit, Input};
use taxel_app::line_survey::Survey;
use taxel_app::methods;
use taxel_app::methods::MethodName;
use taxel_app::units::{InputUnit, Unit};
use taxel_io::sensor_file;

/// Split a sensor's error by cause; what other parts would make of it
///
/// The sensor file is taken for the truth and two frames are read: a gripping hand, and every taxel under full load.
///
/// ALONE: the raw reading's error with this cause and everything else ideal.
///
/// WITHOUT: the error with everything but this cause.
///
/// COMPENSATED: the cross-talk undone by the same circuit; the converter's range, bits and noise are left.
///
/// Mean: mean absolute error of loaded taxels (above 2 % of the largest conductance). Worst: of any taxel. Ghost: the
/// most that an unloaded taxel shows too much. Percents are of the largest conductance; docs/design.md has more.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Sensor file, or the name of a preset
    #[arg(value_name = "FILE|PRESET")]
    sensor: PathBuf,
    /// A frame of a recording in the place of both, solved with this sensor; N from 0, without it the first
    #[arg(long, value_name = "FILE[:N]")]
    frame: Option<FrameOf>,
    /// Frames a second: what an amplifier's gain is at the scan rate follows from it
    #[arg(long, aliases = ["fps", "rate"], value_name = "RATE", default_value_t = 30.0)]
    frames_per_second: f64,
    /// The load of every taxel in the worst frame, grams
    #[arg(long, value_name = "G", default_value_t = 600.0)]
    full_load: f64,
    /// How often the noise is drawn
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=1000))]
    draws: u32,
    /// Seed of the noise
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Print JSON instead of tables
    #[arg(long)]
    json: bool,
}

/// A frame of a recording.
#[derive(Debug, Clone, PartialEq, Eq)]
struct FrameOf {
    file: PathBuf,
    frame: u64,
}

impl FromStr for FrameOf {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        // A colon that no number follows belongs to the name.
        let numbered = text.rsplit_once(':');
        let numbered = numbered.and_then(|(file, n)| Some((file, n.parse().ok()?)));
        let (file, frame) = numbered.unwrap_or((text, 0));
        Ok(Self {
            file: PathBuf::from(file),
            frame,
        })
    }
}

/// Everything about one frame.
#[derive(Debug, Serialize)]
struct SceneReport {
    name: String,
    loaded_taxels: usize,
    largest_siemens: f64,
    /// How far along lines that resist a taxel can be read.
    line_reach: Vec<LineReach>,
    causes: Vec<Part>,
    raw: Errors,
    compensated: Errors,
    /// With one of the converter's causes alone.
    compensated_alone: Vec<(Cause, Errors)>,
    other_parts: Vec<OtherPart>,
}

/// The same frame with another part.
#[derive(Debug, Serialize)]
struct OtherPart {
    name: String,
    #[serde(skip)]
    change: Change,
    raw: Errors,
    compensated: Errors,
}

#[derive(Debug, Serialize)]
struct Report {
    sensor: String,
    rows: usize,
    columns: usize,
    /// The read-out and its parts in a line.
    parts: String,
    frames_per_second: f64,
    draws: u32,
    seed: u64,
    #[serde(skip)]
    grams: bool,
    scenes: Vec<SceneReport>,
}

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<Exit, Error> {
    for (option, value) in [
        ("--frames-per-second", args.frames_per_second),
        ("--full-load", args.full_load),
    ] {
        if !value.is_finite() || value <= 0.0 {
            return Err(Error::Arguments {
                what: format!("{option} is {value}, but must be a finite number above 0"),
                hint: "30 frames a second and 600 grams are the defaults",
            });
        }
    }
    let sensor = sensor_file::load(&args.sensor)?;
    methods::check_memory(&sensor, &args.sensor, &MethodName::Auto)?;
    let in_file = |source| taxel_app::Error::InFile {
        file: args.sensor.clone(),
        source,
    };
    let budget = Budget::new(&sensor, args.draws, args.seed).map_err(in_file)?;
    let scenes = match &args.frame {
        Some(frame) => vec![scene_of(frame, &sensor, &args.sensor)?],
        None => vec![budget.typical(), budget.worst(Some(args.full_load))],
    };
    let progress = Progress::new("taking the sensor apart");
    let shares = scenes.len() as f64;
    let reports = scenes.iter().enumerate().map(|(i, scene)| {
        let done = |share: f64| progress.set((i as f64 + share) / shares);
        report_of(&budget, scene, args.frames_per_second, done).map_err(in_file)
    });
    let report = Report {
        sensor: match sensor.name() {
            "" => args.sensor.display().to_string(),
            name => name.to_owned(),
        },
        rows: sensor.rows(),
        columns: sensor.columns(),
        parts: table::parts_of(&sensor),
        frames_per_second: args.frames_per_second,
        draws: args.draws,
        seed: args.seed,
        grams: budget.has_law(),
        scenes: reports.collect::<Result<_, _>>()?,
    };
    drop(progress);
    if args.json {
        out::json(&report)?
    } else {
        out::result(&report.to_string())?
    }
    for scene in &report.scenes {
        for reach in scene.line_reach.iter().filter(|reach| !reach.is_enough()) {
            out::warn(&format!("{}: {}", scene.name, table::too_far(reach)));
        }
        if scene.compensated.unsolved > 0 {
            out::warn(&format!(
                "{}: {} of {} draws have no answer: the inverse did not converge",
                scene.name, scene.compensated.unsolved, scene.compensated.draws
            ));
        }
    }
    Ok(Exit::Good)
}

fn report_of(
    budget: &Budget,
    scene: &BudgetScene,
    rate: f64,
    done: impl Fn(f64),
) -> Result<SceneReport, taxel::Error> {
    let sensor = budget.sensor();
    let all = Cause::of(sensor);
    let (loaded_taxels, largest_siemens) = scene.loaded();
    let taxels_per_second = rate * (sensor.rows() * sensor.columns()) as f64;
    let converters = all.iter().filter(|cause| cause.is_converters());
    let mut report = SceneReport {
        name: scene.name.clone(),
        loaded_taxels,
        largest_siemens,
        line_reach: line_reach(sensor, &scene.siemens),
        causes: budget.split(scene)?,
        raw: budget.raw(scene, &all)?,
        compensated: budget.compensated(scene, &all)?,
        compensated_alone: converters
            .map(|&cause| Ok((cause, budget.compensated(scene, &[cause])?)))
            .collect::<Result<_, taxel::Error>>()?,
        other_parts: Vec::new(),
    };
    let changes = changes(sensor, taxels_per_second);
    let count = changes.len() as f64;
    for (i, change) in changes.into_iter().enumerate() {
        done(i as f64 / count);
        let changed = budget.with(|sensor| change.apply(sensor))?;
        report.other_parts.push(OtherPart {
            name: change.name(),
            raw: changed.raw(scene, &all)?,
            compensated: changed.compensated(scene, &all)?,
            change,
        });
    }
    Ok(report)
}

/// The conductances behind a frame of a recording; what noise makes negative is 0.
fn scene_of(of: &FrameOf, sensor: &Sensor, file: &Path) -> Result<BudgetScene, Error> {
    let input = Input::new(&of.file, InputUnit::Counts, sensor);
    let mut chain = Chain::new(sensor, file, &MethodName::Auto, Unit::Siemens)?;
    chain.set_lines(&Survey::of(&input, sensor, &Terminal, None)?.faults);
    let mut reading = input.open()?;
    let mut read = 0;
    while reading.advance()? {
        if read == of.frame {
            if let Some(outcome) = chain.take(&reading)? {
                warn_unsolved(read, &outcome);
            }
            let mut shown = Frame::<DisplayUnit>::zeros(sensor.rows(), sensor.columns());
            chain.show_into(&mut shown)?;
            return Ok(BudgetScene {
                name: format!("frame {} of {}", of.frame, of.file.display()),
                siemens: shown.map(|_, siemens| siemens.max(0.0)),
            });
        }
        read += 1;
    }
    Err(taxel_app::Error::NoFrame {
        asked_by: "--frame".to_owned(),
        file: of.file.clone(),
        wanted: of.frame,
        found: read,
    }
    .into())
}
