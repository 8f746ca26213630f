//! From a recording to forces over time: total, grip and regions, frame by frame, and what each trial amounts to.

mod find_regions;
mod mean;
mod reference;
mod regions_file;
mod series;
mod trials;

use std::path::Path;
use std::str::FromStr;

use taxel::Sensor;
use taxel::metric::CONTACT_NEWTONS;
use taxel::metric::hold::HoldOptions;
use taxel::sensor::Region;
use taxel_io::Event;

use crate::conversion::tally::Tally;
use crate::conversion::{Conversion, Converted, ErrorsWanted, FiguresWanted, Request};
use crate::error::Error;
use crate::exported::{self, exported_words};
use crate::frames::Input;
use crate::line_survey::{FaultyLine, Survey};
use crate::methods::MethodName;
use crate::reporter::Reporter;
use crate::simulated::simulated_source;
use crate::tare::{self, ToldTare};
use crate::units::{InputUnit, Unit};
pub use find_regions::{FoundKind, FoundRegions, finds_regions};
pub use reference::Reference;
pub(crate) use regions_file::region_specs_of_file;
pub use regions_file::{recording_regions_of_file, regions_of_file, regions_to_toml};
pub use series::{ForceSeries, Series};
pub use trials::{ForceOverTime, PlateauFigures, Trial};

/// How a recording is measured.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Settings {
    /// How loads are found.
    pub method: MethodName,
    /// Where trials begin and end.
    pub trials: TrialsBy,
    /// What counts as a trial and its plateau.
    pub hold: HoldOptions,
    /// Load above which a taxel counts as touched, newtons.
    pub touched_newtons: f64,
    /// Whether the 95 % intervals of forces are found, which is most of the work.
    pub intervals: bool,
    /// Seconds since the first frame in which nothing presses: their mean is taken off every taxel.
    pub zero: Option<[f64; 2]>,
    /// Frames a second, in place of the times that the recording tells.
    pub frames_per_second: Option<f64>,
    /// Whether what was not measured is replaced; `None`: as the sensor file says.
    pub repair: Option<bool>,
    /// Whether the recording's tare stays on.
    pub no_tare: bool,
    /// Whether rows and columns are swapped in the recording.
    pub transpose: bool,
    /// Whether frames that cannot be read are left out.
    pub keep_going: bool,
    /// Threads, at most; `None`: one for each core.
    pub threads: Option<usize>,
    /// Whether fingers that are found are cut into their phalanges.
    pub phalanges: bool,
}

/// Where trials begin and end.
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
pub enum TrialsBy {
    /// Where the total force rises and falls.
    #[default]
    Force,
    /// At the marks that were set while it was recorded: each begins a trial, which the next one ends.
    Marks,
    /// The whole recording is one.
    Whole,
    /// From and to, seconds since the first frame.
    Times(Vec<[f64; 2]>),
}

impl Settings {
    /// When a frame was read, seconds, where that is known or told.
    fn secs_of(&self, frame: &Converted) -> Option<f64> {
        let counted = self.frames_per_second;
        let counted = counted.map(|rate| frame.sequence() as f64 / rate);
        counted.or(frame.time_secs())
    }

    /// What seconds count from: the first frame of the recording where frames are counted, even if it could not be read; else the
    /// time of the first one that was.
    fn origin(&self, first: Option<f64>) -> Option<f64> {
        match self.frames_per_second {
            Some(_) => Some(0.0),
            None => first,
        }
    }
}

impl FromStr for TrialsBy {
    type Err = String;

    /// `force`, `marks`, `whole`, or times as `2.5..10.5,20..28`.
    fn from_str(text: &str) -> Result<Self, String> {
        let times = |part: &str| -> Option<[f64; 2]> {
            let (from, to) = part.split_once("..")?;
            let [from, to] = [from, to].map(|secs| secs.trim().parse::<f64>().ok());
            let (from, to) = (from?, to?);
            (from.is_finite() && to.is_finite() && from < to).then_some([from, to])
        };
        match text {
            "force" => Ok(Self::Force),
            "marks" => Ok(Self::Marks),
            "whole" => Ok(Self::Whole),
            text => {
                let all: Option<Vec<[f64; 2]>> = text.split(',').map(times).collect();
                all.map(Self::Times).ok_or_else(|| {
                    "must be force, marks, whole, or seconds as 2.5..10.5, several with commas between, each ending after it begins".to_owned()
                })
            }
        }
    }
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            method: MethodName::Auto,
            trials: TrialsBy::default(),
            hold: HoldOptions::default(),
            touched_newtons: CONTACT_NEWTONS,
            intervals: true,
            zero: None,
            frames_per_second: None,
            repair: None,
            no_tare: false,
            transpose: false,
            keep_going: false,
            threads: None,
            phalanges: false,
        }
    }
}

/// What a recording amounts to.
#[derive(Debug)]
#[non_exhaustive]
pub struct Measurement {
    /// Frame by frame.
    pub series: Series,
    /// Trial by trial; none where the recording tells no times, or nobody pressed.
    pub trials: Vec<Trial>,
    /// What happened to its frames.
    pub tally: Tally,
    /// Lines that cannot be trusted.
    pub faulty_lines: Vec<FaultyLine>,
    /// What happened beside the frames.
    pub events: Vec<Event>,
    /// The recording's tares, which are taken off unless they were asked to stay on.
    pub tares: Vec<ToldTare>,
    /// What was taken off the total as a zero, newtons.
    pub zero_newtons: Option<f64>,
    /// Frames with readings at the end of the converter's range: what is said of them is less than what pressed.
    pub saturated_frames: u64,
    /// What simulated it, as the recording tells; `None` where it does not, as a recording of a real sensor.
    pub simulated: Option<String>,
    /// What intervals tell of: `noise, fit and model`, `noise alone`, or `nothing` where there are none.
    pub intervals_of: &'static str,
    /// What is said of loads that another program has found.
    pub exported: Option<String>,
    /// The force that the recording itself tells, beside the one that is measured.
    pub reference: Option<Reference>,
}

impl Measurement {
    /// Whether no frame was lost, left out, without an answer, or beyond what the converter reads.
    pub fn is_whole(&self) -> bool {
        self.tally.is_whole() && self.saturated_frames == 0
    }
}

/// What is measured.
#[derive(Clone, Copy)]
pub struct Measured<'a> {
    /// A recording of counts.
    pub recording: &'a Path,
    /// Its sensor,
    pub sensor: &'a Sensor,
    /// and where that comes from.
    pub sensor_file: &'a Path,
    /// Parts of it that are measured by themselves.
    pub regions: &'a [Region],
}

impl Measured<'_> {
    /// Every frame of it, and every trial.
    ///
    /// # Errors
    /// A recording that cannot be read, a sensor without a load law, times that run backwards, trials outside the recording;
    /// [`Error::Stopped`] when `is_stopped` says so.
    pub fn measure(
        &self,
        settings: &Settings,
        reporter: &dyn Reporter,
        is_stopped: &(dyn Fn() -> bool + Sync),
    ) -> Result<Measurement, Error> {
        let survey = self.survey(settings, reporter)?;
        let zeros = self.zeros(settings, &survey, reporter, is_stopped)?;
        let input = self.input(settings);
        let mut request = self.request(settings, is_stopped, !input.can_be_read_twice());
        request.zeros = zeros.as_deref();
        let conversion = Conversion::new(request, &survey)?;
        let series = Series::new(self.sensor, self.regions, self.has_intervals(settings));
        series.check_names()?;
        let mut seen = Seen {
            series,
            tally: Tally::new(Unit::Newtons, self.sensor.array().taxel_area_mm2),
            events: Vec::new(),
            tares: Vec::new(),
        };
        let is_raw = settings.method == MethodName::Raw;
        let mut reading = input.open()?;
        let stage = reporter.stage("measuring");
        conversion.run(&mut reading, &*stage, |frame| {
            seen.add(frame, settings.secs_of(frame), is_raw);
            Ok(())
        })?;
        drop(stage);
        seen.tally.finish(&reading);
        let Seen {
            mut series,
            tally,
            events,
            tares,
        } = seen;
        let first = series.secs.first().copied();
        let origin = settings.origin(first).unwrap_or(0.0);
        series.begin_at(origin, self.recording)?;
        self.check_frames_of_regions(&series)?;
        Ok(Measurement {
            zero_newtons: zeros.map(|zeros| zeros.iter().sum()),
            trials: trials::trials(&series, &events, settings)?,
            tally,
            faulty_lines: survey.lines(),
            events,
            tares,
            saturated_frames: series.is_saturated.iter().filter(|is| **is).count() as u64,
            simulated: simulated_source(self.recording),
            intervals_of: self.intervals_of(settings),
            exported: exported_words(self.sensor),
            reference: Reference::of(&series),
            series,
        })
    }

    /// Regions that move belong to one recording; of another they would read nothing where there is no such frame.
    fn check_frames_of_regions(&self, series: &Series) -> Result<(), Error> {
        let end = series.frame.last().map_or(0, |last| last + 1);
        let beyond = self.regions.iter().find_map(|region| {
            let [from, to] = region.last_frames()?;
            (from >= end).then(|| (region.name(), from, to))
        });
        let Some((name, from, to)) = beyond else {
            return Ok(());
        };
        Err(taxel::Error::Region {
            name: format!("`{name}`"),
            problem: format!(
                "is said of frames {from} to {to}, and {} has {end}, counted from 0",
                self.recording.display()
            ),
            hint: "regions with `frames` belong to the recording that they were found in",
        }
        .into())
    }

    /// Mean loads of the seconds in which nothing presses, newtons.
    fn zeros(
        &self,
        settings: &Settings,
        survey: &Survey,
        reporter: &dyn Reporter,
        is_stopped: &(dyn Fn() -> bool + Sync),
    ) -> Result<Option<Vec<f64>>, Error> {
        let Some([from, to]) = settings.zero else {
            return Ok(None);
        };
        let window = Some([from, to]);
        let (mean, frames) = self.mean_loads(settings, window, survey, reporter, is_stopped)?;
        if frames == 0 {
            return Err(Error::Request {
                what: format!(
                    "no frame with an answer from {from} s to {to} s to take the zero from"
                ),
                hint: "seconds since the first frame; a recording without times needs to be told how many frames a second there were",
            });
        }
        Ok(Some(mean.values().to_vec()))
    }

    /// What a first pass finds, if what is asked for can be done at all.
    fn survey(&self, settings: &Settings, reporter: &dyn Reporter) -> Result<Survey, Error> {
        self.request(settings, &|| false, false).check()?;
        if self.sensor.exported().is_some() {
            // Another program has looked after its lines, and nobody asks how many frames there are.
            return Ok(Survey::declared(self.sensor));
        }
        Survey::of(
            &self.input(settings),
            self.sensor,
            reporter,
            settings.threads,
        )
    }

    /// Whether there is an inverse, so that noise can be carried through to forces.
    fn has_intervals(&self, settings: &Settings) -> bool {
        settings.intervals && settings.method.inverts() && self.sensor.exported().is_none()
    }

    fn intervals_of(&self, settings: &Settings) -> &'static str {
        if self.has_intervals(settings) {
            exported::intervals_of(self.sensor)
        } else {
            exported::NOTHING
        }
    }

    fn input(&self, settings: &Settings) -> Input {
        let mut input = Input::new(self.recording, InputUnit::Counts, self.sensor);
        input.options.transpose = settings.transpose;
        input.options.keep_going = settings.keep_going;
        input.options.accept_damage = true;
        input
    }

    fn request<'a>(
        &'a self,
        settings: &'a Settings,
        is_stopped: &'a (dyn Fn() -> bool + Sync),
        promptly: bool,
    ) -> Request<'a> {
        Request {
            sensor: self.sensor,
            sensor_file: self.sensor_file,
            method: &settings.method,
            unit: Unit::Newtons,
            repair: settings.repair,
            errors: ErrorsWanted::default(),
            figures: Some(if self.has_intervals(settings) {
                FiguresWanted::WithErrors
            } else {
                FiguresWanted::Values
            }),
            touched_newtons: settings.touched_newtons,
            regions: self.regions,
            no_tare: settings.no_tare,
            zeros: None,
            threads: settings.threads,
            promptly,
            is_stopped,
        }
    }
}

/// What was seen of a recording so far.
struct Seen {
    series: Series,
    tally: Tally,
    events: Vec<Event>,
    tares: Vec<ToldTare>,
}

impl Seen {
    fn add(&mut self, frame: &Converted, secs: Option<f64>, is_raw: bool) {
        self.tally.add(frame);
        let taxels = frame.shown.values().len();
        tare::note(&mut self.tares, frame.tare.as_deref(), is_raw, taxels);
        self.events.extend(frame.events.iter().cloned());
        self.series.add(frame, secs);
    }
}
