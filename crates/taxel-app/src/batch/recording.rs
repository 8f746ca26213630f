//! One recording of an archive, worked through.

use std::path::Path;
use std::time::Instant;

use taxel::uncertainty::Bias;
use taxel::{Frame, Sensor, Siemens};
use taxel_io::AtomicFile;
use taxel_io::exports::file_of;
use taxel_plot::Panel;

use super::entry::{Entry, PROGRAM, Status, Written, about, with_ending, words};
use super::row::Sums;
use super::{Batch, Settings};
use crate::conversion::files::{self, Files, Outputs};
use crate::conversion::tally::Tally;
use crate::conversion::{Conversion, Converted, Request};
use crate::error::Error;
use crate::figures::{FigureRow, Figures};
use crate::fingerprint;
use crate::frames::{DisplayUnit, Input};
use crate::line_survey::Survey;
use crate::methods::MethodName;
use crate::reporter::{Silent, Until};
use crate::sensor_source;
use crate::tare::{self, ToldTare};
use crate::units::{InputUnit, Unit};

/// Endings of what is made of a recording.
pub(super) const ENDINGS: [&str; 4] = [LOADS_PARQUET, LOADS_MCAP, FIGURES, PICTURE];
pub(super) const LOADS_PARQUET: &str = "loads.parquet";
pub(super) const LOADS_MCAP: &str = "loads.mcap";
const FIGURES: &str = "figures.csv";
const PICTURE: &str = "png";

/// Everything that is made of a recording, but for its entry.
///
/// # Errors
/// [`Error::Stopped`]; whatever else is wrong stands in the entry.
pub(super) fn process(
    batch: &Batch,
    recording: &Path,
    place: &Path,
    threads: usize,
    is_stopped: &(dyn Fn() -> bool + Sync),
) -> Result<Entry, Error> {
    let started = Instant::now();
    let (bytes, modified_secs) = about(recording);
    let mut entry = Entry {
        recording: words(recording),
        bytes,
        modified_secs,
        sha256: String::new(),
        program: PROGRAM.to_owned(),
        settings_sha256: batch.fingerprint.clone(),
        status: Status::Broken,
        error: None,
        seconds: 0.0,
        files: Vec::new(),
        row: None,
    };
    match convert(batch, recording, place, threads, is_stopped, &mut entry) {
        Ok(()) => {}
        Err(Error::Stopped) => return Err(Error::Stopped),
        Err(error) => entry.error = Some(error.to_string()),
    }
    entry.seconds = started.elapsed().as_secs_f64();
    Ok(entry)
}

/// Removes what an earlier entry names and this one does not: beside it, it would seem to be its own. And what a full disk
/// has left of what is whole now.
pub(super) fn remove_others(place: &Path, before: Option<&Entry>, now: &Entry) {
    let names = |entry: &Entry, ending: &str| entry.files.iter().any(|file| file.ending == ending);
    for ending in ENDINGS {
        let was = before.is_some_and(|before| names(before, ending));
        // Mostly there is none.
        if was && !names(now, ending) {
            let _ = std::fs::remove_file(with_ending(place, ending));
        }
        if names(now, ending) {
            let _ = std::fs::remove_file(with_ending(place, &format!("{ending}.partial")));
        }
    }
}

fn convert(
    batch: &Batch,
    recording: &Path,
    place: &Path,
    threads: usize,
    is_stopped: &(dyn Fn() -> bool + Sync),
    entry: &mut Entry,
) -> Result<(), Error> {
    if recording.is_dir() {
        return Err(Error::Request {
            what: format!("{} is a directory", recording.display()),
            hint: "`find DIRECTORY -name '*.mcap'` names what is in it, for --list",
        });
    }
    let about = std::fs::metadata(file_of(recording)).map_err(|source| taxel_io::Error::Open {
        file: recording.to_owned(),
        source,
    })?;
    if !about.is_file() {
        return Err(Error::Request {
            what: format!("{} is no file", recording.display()),
            hint: "a recording of an archive is read more than once, which a pipe or a device does not bear",
        });
    }
    (_, entry.sha256) = fingerprint::of_file_shown(recording, &Until(is_stopped))?;
    let (sensor, sensor_file) = match &batch.settings.sensor {
        Some((sensor, file)) => (sensor.clone(), file.clone()),
        None => sensor_source::of_recording(recording)?,
    };
    let sensor = if batch.settings.with_names {
        sensor_source::with_names(sensor, recording)?
    } else {
        sensor
    };
    let folder = place.parent().expect("a file lies in a folder");
    std::fs::create_dir_all(folder).map_err(|source| Error::Folder {
        folder: folder.to_owned(),
        source,
    })?;
    let job = Job {
        settings: &batch.settings,
        is_stopped,
        recording,
        place,
        threads,
        sensor: &sensor,
        sensor_file: &sensor_file,
    };
    job.run(entry)
}

/// What is to be done with one recording.
struct Job<'a> {
    settings: &'a Settings,
    is_stopped: &'a (dyn Fn() -> bool + Sync),
    recording: &'a Path,
    place: &'a Path,
    threads: usize,
    sensor: &'a Sensor,
    sensor_file: &'a Path,
}

impl Job<'_> {
    fn run(&self, entry: &mut Entry) -> Result<(), Error> {
        let mut input = Input::new(self.recording, InputUnit::Counts, self.sensor);
        input.options.transpose = self.settings.transpose;
        input.options.keep_going = true;
        input.options.accept_damage = true;
        let request =
            self.settings
                .request(self.sensor, self.sensor_file, self.threads, self.is_stopped);
        let wanted = Until(self.is_stopped);
        let survey = Survey::of(&input, self.sensor, &wanted, Some(self.threads))?;
        let files = self.files();
        let seen = self.convert(request, &input, &survey, &files)?;
        let heaviest = seen.heaviest.as_ref();
        let peak = heaviest.map(|heaviest| self.figures(heaviest, &survey));
        let row = seen.sums.row(
            self.sensor,
            &survey,
            &seen.tally,
            seen.tares.first(),
            peak.transpose()?,
        );
        let drawn = seen.heaviest.filter(|_| self.settings.pictures);
        if let Some(heaviest) = &drawn {
            self.picture(&heaviest.shown)?;
        }
        let loads = self.settings.loads.ending();
        let picture = drawn.map(|_| PICTURE);
        let written = [loads, Some(FIGURES), picture].into_iter().flatten();
        entry.files = written.map(|ending| self.written(ending)).collect();
        entry.row = Some(row);
        entry.status = if seen.tally.is_whole() {
            Status::Done
        } else {
            Status::Incomplete
        };
        Ok(())
    }

    /// Writes loads and figures, frame by frame.
    fn convert(
        &self,
        request: Request,
        input: &Input,
        survey: &Survey,
        files: &Files,
    ) -> Result<Seen, Error> {
        let written = files::Written {
            input,
            sensor: self.sensor,
            unit: Unit::Newtons,
            no_tare: self.settings.no_tare,
            frames: survey.frames,
            replaces: true,
        };
        let conversion = Conversion::new(request, survey)?;
        let mut outputs = Outputs::create(files, written)?;
        let mut seen = Seen {
            tally: Tally::new(Unit::Newtons, self.sensor.array().taxel_area_mm2),
            sums: Sums::default(),
            tares: Vec::new(),
            heaviest: None,
        };
        let is_raw = self.settings.method == MethodName::Raw;
        let taxels = self.sensor.taxels();
        let mut reading = input.open()?;
        conversion.run(&mut reading, &Silent, |frame| {
            seen.add(frame);
            let tare = frame.tare.as_deref().filter(|_| !self.settings.no_tare);
            tare::note(&mut seen.tares, tare, is_raw, taxels);
            outputs.write(frame)
        })?;
        seen.tally.finish(&reading);
        self.check(&seen.tally)?;
        outputs.commit(&mut reading)?;
        Ok(seen)
    }

    /// Refuses a recording of nothing: then nothing is written.
    fn check(&self, tally: &Tally) -> Result<(), Error> {
        if tally.frames > 0 {
            return Ok(());
        }
        let file = self.recording.display();
        Err(match tally.skipped.first() {
            Some(skipped) => Error::Request {
                what: format!("{file}: no frame can be read; the first: {}", skipped.why),
                hint: "is it a recording of counts, and of this sensor?",
            },
            None => Error::Request {
                what: format!("{file}: there is no frame in it"),
                hint: "was anything recorded?",
            },
        })
    }

    /// Those of the frame with the largest force, with what they are uncertain by.
    fn figures(&self, heaviest: &Heaviest, survey: &Survey) -> Result<FigureRow, Error> {
        let siemens = heaviest.siemens.as_ref().filter(|_| self.is_ours());
        let Some(siemens) = siemens else {
            return Ok(heaviest.figures);
        };
        let level = survey.faults.level;
        let mut figures = Figures::new(self.sensor, self.sensor_file, Unit::Newtons, level)?;
        // Marks are all that is taken of the loads before a tare.
        let mut loads = Frame::zeros(self.sensor.rows(), self.sensor.columns());
        loads.copy_meta_from(&heaviest.shown);
        figures.set_bias(heaviest.bias.as_ref());
        let mut row = figures.of(Some(siemens), &loads, &heaviest.shown, true);
        row.frame = heaviest.figures.frame;
        Ok(row)
    }

    /// Whether no other program has found the loads, so that something tells how far to trust them.
    fn is_ours(&self) -> bool {
        self.sensor.exported().is_none()
    }

    fn written(&self, ending: &str) -> Written {
        let about = std::fs::metadata(with_ending(self.place, ending));
        Written {
            ending: ending.to_owned(),
            bytes: about.map_or(0, |about| about.len()),
        }
    }

    fn files(&self) -> Files {
        let ending = self.settings.loads.ending();
        Files {
            numbers: ending.map(|ending| with_ending(self.place, ending)),
            figures: Some(with_ending(self.place, FIGURES)),
            figure_errors: self.settings.intervals && self.is_ours(),
            ..Files::default()
        }
    }

    /// Draws the frame with the largest force.
    fn picture(&self, frame: &Frame<DisplayUnit>) -> Result<(), Error> {
        let array = self.sensor.array();
        let name = self.place.file_name().unwrap_or_default().to_string_lossy();
        let panel = Panel::new(frame.rows(), frame.columns(), frame.values())?
            .title(format!("{name}, frame {}", frame.sequence))
            .quantity("load")
            .unit("N")
            .pitch_mm(array.pitch_mm)
            .marks(frame.marks())?;
        let panel = match self.sensor.positions() {
            Some(positions_mm) => panel.positions_mm(positions_mm)?,
            None => panel,
        };
        let picture = with_ending(self.place, PICTURE);
        Ok(AtomicFile::write_whole(&picture, &panel.picture()?.png()?)?)
    }
}

/// What was seen of a recording.
struct Seen {
    tally: Tally,
    sums: Sums,
    /// Those that were taken off.
    tares: Vec<ToldTare>,
    heaviest: Option<Heaviest>,
}

/// The frame with the largest force, of those with an answer: the others' numbers are the last that an inverse tried.
struct Heaviest {
    shown: Frame<DisplayUnit>,
    siemens: Option<Frame<Siemens>>,
    bias: Option<Bias>,
    figures: FigureRow,
}

impl Seen {
    fn add(&mut self, frame: &Converted) {
        self.sums.add(frame);
        self.tally.add(frame);
        let Some(figures) = frame.figures.filter(|_| frame.is_answer()) else {
            return;
        };
        let force = |figures: &FigureRow| figures.total_force.value;
        let before = self
            .heaviest
            .as_ref()
            .map(|heaviest| force(&heaviest.figures));
        if before.is_none_or(|before| force(&figures) > before) {
            self.heaviest = Some(Heaviest {
                shown: frame.shown.clone(),
                siemens: frame.siemens.clone(),
                bias: frame.bias.clone(),
                figures,
            });
        }
    }
}
