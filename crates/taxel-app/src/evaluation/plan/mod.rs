//! The file that says what to evaluate.

mod check;

use std::path::{Path, PathBuf};

use serde::Deserialize;
use taxel::Sensor;
use taxel::stats::Bootstrap;
use taxel_plot::report::number;

use crate::error::Error;
use crate::measure::region_specs_of_file;
use crate::methods::MethodName;
use taxel_io::{bounded, sensor_file};

/// The longest plan, bytes.
const MAX: u64 = 1 << 20;

/// A plan as its file has it.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    format: u32,
    title: Option<String>,
    sensor: String,
    #[serde(default = "one")]
    seed: u64,
    resamples: Option<usize>,
    confidence: Option<f64>,
    frames_per_second: Option<f64>,
    live_frames: Option<u64>,
    regions: Option<PathBuf>,
    experiment: Vec<Experiment>,
}

fn one() -> u64 {
    1
}

/// What one experiment asks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Kind {
    /// The same load, again and again.
    Repeatability,
    /// Loads of a staircase.
    Response,
    /// Up and down again.
    Hysteresis,
    /// A load that stays.
    Creep,
    /// One taxel, with more and more others.
    CrossTalk,
    /// Known loads.
    Accuracy,
}

impl Kind {
    /// Its word, as in the plan.
    pub fn word(self) -> &'static str {
        match self {
            Self::Repeatability => "repeatability",
            Self::Response => "response",
            Self::Hysteresis => "hysteresis",
            Self::Creep => "creep",
            Self::CrossTalk => "cross-talk",
            Self::Accuracy => "accuracy",
        }
    }
}

/// What is looked at.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Value {
    /// The converter's.
    Counts,
    /// What the circuit gives.
    Volts,
    /// Conductance, cross-talk removed.
    Siemens,
    /// Load, by the first method.
    Grams,
}

impl Value {
    /// Its unit, as it stands beside an axis.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Counts => "counts",
            Self::Volts => "V",
            Self::Siemens => "S",
            Self::Grams => "g",
        }
    }

    /// What it is, as it stands beside an axis.
    pub fn quantity(self) -> &'static str {
        match self {
            Self::Counts => "reading",
            Self::Volts => "V_out",
            Self::Siemens => "conductance",
            Self::Grams => "load",
        }
    }
}

/// Along which line others are pressed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Along {
    /// Taxels of the same row.
    Row,
    /// Taxels of the same column.
    Column,
}

/// One experiment of a plan.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Experiment {
    /// What is found out.
    pub kind: Kind,
    /// Its name in the report.
    pub name: String,
    /// The table of trials.
    pub trials: Option<PathBuf>,
    /// Instead of trials: a recording with the load of every taxel in every frame.
    pub recording: Option<PathBuf>,
    /// The load of every taxel in every frame, grams: a file of values.
    pub truth_g: Option<PathBuf>,
    /// Frames that belong together where a recording has no trials.
    pub frames_per_experiment: Option<u64>,
    /// What is looked at.
    pub value: Option<Value>,
    /// Where the others are.
    pub along: Option<Along>,
    /// How loads are found, to be compared.
    #[serde(default)]
    pub methods: Vec<String>,
    /// Where ranges of load begin.
    #[serde(default)]
    pub ranges_g: Vec<f64>,
    /// Another sensor file for this experiment: another V_test, another R_k.
    pub sensor: Option<String>,
    /// Words of its setting in the trials, with the sensor file of each.
    #[serde(default)]
    pub settings: std::collections::BTreeMap<String, String>,
    /// Words for the report.
    pub note: Option<String>,
}

impl Experiment {
    /// What is looked at, where the plan does not say.
    pub fn value(&self) -> Value {
        self.value.unwrap_or(match self.kind {
            Kind::Hysteresis | Kind::Creep => Value::Siemens,
            Kind::Accuracy => Value::Grams,
            Kind::CrossTalk => Value::Volts,
            Kind::Repeatability | Kind::Response => Value::Counts,
        })
    }

    /// Along which line others are pressed.
    pub fn along(&self) -> Along {
        self.along.unwrap_or(Along::Row)
    }

    /// Frames that follow each other and are one experiment, where all loads are known.
    pub fn frames_per_experiment(&self) -> u64 {
        self.frames_per_experiment.unwrap_or(1)
    }

    /// The methods to compare; models are files of the plan's folder.
    pub fn methods(&self, folder: &Path) -> Result<Vec<MethodName>, Error> {
        let usual: &[&str] = match self.kind {
            Kind::Accuracy => &["raw", "auto"],
            Kind::CrossTalk => &["auto"],
            // Where nobody asks for conductances, it does not matter whether the circuit explains the frame.
            _ if matches!(self.value(), Value::Counts | Value::Volts) => &["raw"],
            _ => &["auto"],
        };
        let given = self.methods.iter().map(String::as_str);
        let names: Vec<&str> = if self.methods.is_empty() {
            usual.to_vec()
        } else {
            given.collect()
        };
        let parsed = names.iter().map(|name| match name.parse() {
            Ok(MethodName::Model(file)) => Ok(MethodName::Model(folder.join(file))),
            Ok(method) => Ok(method),
            Err(why) => Err(Error::Request {
                what: format!("experiment '{}': {why}", self.name),
                hint: "methods = [\"raw\", \"auto\"]",
            }),
        });
        parsed.collect()
    }
}

/// A plan, its files found.
pub struct Plan {
    /// The plan itself.
    pub file: PathBuf,
    /// The report's title.
    pub title: String,
    /// The sensor of experiments that name none.
    pub sensor: Sensor,
    /// Where it comes from.
    pub sensor_file: PathBuf,
    /// Named regions in place of those of the sensor files.
    pub regions: Option<PathBuf>,
    /// How intervals are found.
    pub bootstrap: Bootstrap,
    /// Where recordings know no times.
    pub frames_per_second: Option<f64>,
    /// Frames of each recording that is made live.
    pub live_frames: u64,
    /// In the order of the file.
    pub experiments: Vec<Experiment>,
}

impl Plan {
    /// Reads a plan; paths in it are relative to its folder.
    pub fn read(file: &Path) -> Result<Self, Error> {
        let text = text_of(file)?;
        let refused = |reason: String| Error::Plan {
            file: file.to_owned(),
            reason,
        };
        let mut written: Written =
            toml::from_str(&text).map_err(|error| refused(words_of(&error)))?;
        if written.format != 1 {
            return Err(refused(format!(
                "format = {}, but this program knows format 1",
                written.format
            )));
        }
        if written.experiment.is_empty() {
            return Err(refused(
                "no experiment: each begins with [[experiment]]".to_owned(),
            ));
        }
        check::numbers(&written).map_err(refused)?;
        let folder = file.parent().unwrap_or(Path::new(""));
        for experiment in &mut written.experiment {
            check::experiment(experiment)
                .map_err(|why| refused(format!("experiment '{}': {why}", experiment.name)))?;
            for path in [
                &mut experiment.trials,
                &mut experiment.recording,
                &mut experiment.truth_g,
            ] {
                *path = path.take().map(|path| folder.join(path));
            }
        }
        let defaults = Bootstrap::default();
        let sensor_file = next_to(folder, &written.sensor);
        let sensor = sensor_file::load(&sensor_file)?;
        for experiment in &written.experiment {
            check::settings(experiment, &sensor).map_err(refused)?;
        }
        let regions = written.regions.map(|file| folder.join(file));
        Ok(Self {
            sensor: with_regions(sensor, regions.as_deref())?,
            sensor_file,
            regions,
            title: written.title.unwrap_or_else(|| {
                let name = file.file_stem().unwrap_or_default();
                name.to_string_lossy().into_owned()
            }),
            file: file.to_owned(),
            bootstrap: Bootstrap {
                seed: written.seed,
                resamples: written.resamples.unwrap_or(defaults.resamples),
                confidence: written.confidence.unwrap_or(defaults.confidence),
                step: defaults.step,
            },
            frames_per_second: written.frames_per_second,
            live_frames: written.live_frames.unwrap_or(10),
            experiments: written.experiment,
        })
    }

    /// Where its files are.
    pub fn folder(&self) -> &Path {
        self.file.parent().unwrap_or(Path::new(""))
    }

    /// How sure intervals are, in words: `95 %`.
    pub fn sure(&self) -> String {
        format!("{} %", number(100.0 * self.bootstrap.confidence))
    }

    /// The sensor that an experiment is of: its own where the plan gives one.
    pub fn sensor_of(&self, word: Option<&String>) -> Result<(Sensor, PathBuf), Error> {
        let Some(word) = word else {
            return Ok((self.sensor.clone(), self.sensor_file.clone()));
        };
        let file = next_to(self.folder(), word);
        let sensor = with_regions(sensor_file::load(&file)?, self.regions.as_deref())?;
        Ok((sensor, file))
    }

    /// With the named regions of this file in place of those that the plan and its sensor files name.
    ///
    /// # Errors
    /// A file of regions that cannot be read, or that do not suit the plan's sensor.
    pub fn with_regions(mut self, file: &Path) -> Result<Self, Error> {
        self.sensor = with_regions(self.sensor, Some(file))?;
        self.regions = Some(file.to_owned());
        Ok(self)
    }
}

/// A sensor with the regions of a file, where there is one.
fn with_regions(sensor: Sensor, file: Option<&Path>) -> Result<Sensor, Error> {
    let Some(file) = file else { return Ok(sensor) };
    let specs = region_specs_of_file(file)?;
    let edited = sensor.edited(|spec| spec.regions = specs);
    edited.map_err(|source| Error::InFile {
        file: file.to_owned(),
        source,
    })
}

/// The text of a plan.
fn text_of(file: &Path) -> Result<String, Error> {
    match bounded::read_text(file, MAX) {
        Ok(Some(text)) => Ok(text),
        Ok(None) => Err(Error::TextLength {
            file: file.to_owned(),
            what: "a plan",
            limit: MAX,
        }),
        Err(source) => Err(Error::OpenPlan {
            file: file.to_owned(),
            source,
        }),
    }
}

/// The files that a plan names.
#[derive(Debug, Default)]
pub struct Names {
    /// Sensor files.
    pub sensors: Vec<PathBuf>,
    /// Tables of trials.
    pub tables: Vec<PathBuf>,
    /// Recordings, loads, models.
    pub others: Vec<PathBuf>,
}

/// The files that a plan names, without a look into them.
pub fn names(file: &Path) -> Result<Names, Error> {
    let written: Written = toml::from_str(&text_of(file)?).map_err(|error| Error::Plan {
        file: file.to_owned(),
        reason: words_of(&error),
    })?;
    let folder = file.parent().unwrap_or(Path::new(""));
    let mut names = Names::default();
    names.sensors.push(next_to(folder, &written.sensor));
    for experiment in &written.experiment {
        let sensors = experiment.sensor.iter().chain(experiment.settings.values());
        names
            .sensors
            .extend(sensors.map(|word| next_to(folder, word)));
        let tables = experiment.trials.iter();
        names.tables.extend(tables.map(|table| folder.join(table)));
        let others = [&experiment.recording, &experiment.truth_g];
        let others = others.into_iter().flatten();
        names.others.extend(others.map(|other| folder.join(other)));
        let methods = experiment.methods(folder)?;
        names
            .others
            .extend(methods.iter().filter_map(MethodName::file));
    }
    let regions = written.regions.iter();
    names.others.extend(regions.map(|file| folder.join(file)));
    Ok(names)
}

/// A file of the plan's folder, or a preset's name.
fn next_to(folder: &Path, word: &str) -> PathBuf {
    let file = folder.join(word);
    if file.exists() || word.contains(['.', '/']) {
        file
    } else {
        PathBuf::from(word)
    }
}

/// What TOML finds wrong, with its place, and with more words where its own are those of its makers.
fn words_of(error: &toml::de::Error) -> String {
    // It quotes the whole line, however long.
    let quoted = error.to_string();
    let lines = quoted.trim_end().lines();
    let short: Vec<String> = lines.map(|line| line.chars().take(200).collect()).collect();
    let text = short.join("\n");
    if text.contains("invalid type: map, expected a sequence") {
        text + "\nwrite [[experiment]], with two brackets: there may be more than one"
    } else {
        text
    }
}
