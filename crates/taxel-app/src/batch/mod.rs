//! An archive of recordings: of each the loads, the figures over time, a line of one table; in any order, on any number of
//! machines, and again from where it was cut off.
//!
//! What is made of a recording lies in one folder under the recording's own name, and beside it what it was made of and with
//! ([`Entry`]). The entry is written last and says that the rest is whole; so whoever finds one with the same recording, program
//! and settings need not do it again.

mod entry;
mod recording;
mod row;
mod shard;
mod table;

use std::collections::HashMap;
use std::path::{Component, Path, PathBuf};
use std::sync::Mutex;
use std::sync::mpsc::channel;

use serde::Serialize;
use taxel::Sensor;
use taxel::metric::CONTACT_NEWTONS;

use crate::conversion::{ErrorsWanted, FiguresWanted, Request};
use crate::error::Error;
use crate::executor::cores;
use crate::fingerprint;
use crate::methods::MethodName;
use crate::reporter::Until;
use crate::units::Unit;
pub use entry::{Entry, Status};
use entry::{with_ending, words};
pub use row::Row;
pub use shard::Shard;
pub use table::{manifest, summary};

/// What is made of each recording.
#[derive(Debug, Clone)]
pub struct Settings {
    /// The sensor and where it comes from; without, each recording brings its own.
    pub sensor: Option<(Sensor, PathBuf)>,
    /// How loads are found.
    pub method: MethodName,
    /// What loads and marks are written as.
    pub loads: LoadsFile,
    /// Whether the figures of every frame get their 95 % intervals, and not those of the heaviest frame alone: many times the
    /// work.
    pub intervals: bool,
    /// Whether the frame with the largest force is drawn.
    pub pictures: bool,
    /// Whether what was not measured is replaced; `None`: as the sensor file says.
    pub repair: Option<bool>,
    /// Whether the recordings' tare is left on.
    pub no_tare: bool,
    /// Whether the recordings have rows and columns swapped.
    pub transpose: bool,
    /// Whether the names that a file of another program has in its header are kept in what is written.
    pub with_names: bool,
}

/// What loads and marks are written as, with counts and times.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub enum LoadsFile {
    /// A table of a line a frame.
    #[default]
    Parquet,
    /// A recording.
    Mcap,
    /// Not at all.
    Nothing,
}

impl LoadsFile {
    /// Ending of its files.
    fn ending(self) -> Option<&'static str> {
        match self {
            LoadsFile::Parquet => Some(recording::LOADS_PARQUET),
            LoadsFile::Mcap => Some(recording::LOADS_MCAP),
            LoadsFile::Nothing => None,
        }
    }
}

impl Settings {
    /// With what suits the read-out, and loads as a table.
    pub fn new(sensor: Option<(Sensor, PathBuf)>) -> Self {
        Self {
            sensor,
            method: MethodName::Auto,
            loads: LoadsFile::default(),
            intervals: false,
            pictures: false,
            repair: None,
            no_tare: false,
            transpose: false,
            with_names: false,
        }
    }

    /// What is to be made of the recordings of a sensor.
    fn request<'a>(
        &'a self,
        sensor: &'a Sensor,
        sensor_file: &'a Path,
        threads: usize,
        is_stopped: &'a (dyn Fn() -> bool + Sync),
    ) -> Request<'a> {
        Request {
            sensor,
            sensor_file,
            method: &self.method,
            unit: Unit::Newtons,
            repair: self.repair,
            errors: ErrorsWanted::default(),
            figures: Some(if self.intervals {
                FiguresWanted::WithErrors
            } else {
                FiguresWanted::Values
            }),
            touched_newtons: CONTACT_NEWTONS,
            regions: &[],
            no_tare: self.no_tare,
            zeros: None,
            threads: Some(threads),
            promptly: false,
            is_stopped,
        }
    }

    /// What tells these settings from others: a change of any of them makes another.
    ///
    /// # Errors
    /// A model that cannot be read.
    pub fn fingerprint(&self) -> Result<String, Error> {
        let model = self.method.file();
        let model = model.map(|file| fingerprint::of_file(&file)).transpose()?;
        let mut all = serde_json::json!({
            "sensor": self.sensor.as_ref().map(|(sensor, _)| sensor.to_toml()),
            "method": match &model {
                Some((_, sum)) => sum.clone(),
                None => self.method.to_string(),
            },
            "loads": self.loads,
            "intervals": self.intervals,
            "pictures": self.pictures,
            "repair": self.repair,
            "no_tare": self.no_tare,
            "transpose": self.transpose,
        });
        if self.with_names {
            all["with_names"] = true.into();
        }
        Ok(fingerprint::of_text(&all.to_string()))
    }
}

/// An archive that is worked through.
pub struct Batch {
    settings: Settings,
    fingerprint: String,
    folder: PathBuf,
}

impl Batch {
    /// Into a folder, which is made if it is not there.
    ///
    /// # Errors
    /// A folder that cannot be made; a model that cannot be read; a sensor whose loads cannot be found; intervals without an
    /// inverse.
    pub fn new(settings: Settings, folder: &Path) -> Result<Self, Error> {
        if settings.intervals && !settings.method.inverts() {
            return Err(Error::Request {
                what: format!("there are no intervals with the method {}", settings.method),
                hint: "they need an inverse to carry the converter's noise through: auto, exact or newton",
            });
        }
        if let Some((sensor, file)) = &settings.sensor {
            settings.request(sensor, file, 1, &|| false).check()?;
        }
        std::fs::create_dir_all(folder).map_err(|source| Error::Folder {
            folder: folder.to_owned(),
            source,
        })?;
        Ok(Self {
            fingerprint: settings.fingerprint()?,
            settings,
            folder: folder.to_owned(),
        })
    }

    /// Works one recording through with so many threads, unless that was done before. What is wrong with it stands in the
    /// entry. Ended once nobody wants it any more, which is asked before every frame, and every 64 kB of the file's fingerprint.
    ///
    /// What was made of it before stays until there is something else of it: a recording out of reach, or a full disk, destroys
    /// nothing.
    ///
    /// # Errors
    /// [`Error::Stopped`].
    pub fn process(
        &self,
        recording: &Path,
        threads: usize,
        is_stopped: &(dyn Fn() -> bool + Sync),
    ) -> Result<Done, Error> {
        let place = self.folder.join(name_of(recording));
        if let Some(entry) = entry::found(&place, recording, &self.fingerprint, Until(is_stopped)) {
            return Ok(Done {
                entry,
                again: false,
            });
        }
        let before = entry::read(&place).filter(|entry| entry.row.is_some());
        let mut entry = recording::process(self, recording, &place, threads, is_stopped)?;
        if entry.row.is_some() || before.is_none() {
            match entry.write(&place) {
                Ok(()) => recording::remove_others(&place, before.as_ref(), &entry),
                Err(error) => entry.break_off(&error),
            }
        }
        Ok(Done { entry, again: true })
    }

    /// Works recordings through, several at once; `each` hears of every one when it is done, in the order in which they are.
    ///
    /// # Errors
    /// [`Error::Stopped`].
    pub fn run(
        &self,
        recordings: &[PathBuf],
        threads: Option<usize>,
        is_stopped: &(dyn Fn() -> bool + Sync),
        mut each: impl FnMut(usize, &Done),
    ) -> Result<(), Error> {
        let threads = threads.unwrap_or_else(cores).max(1);
        let workers = threads.min(recordings.len());
        let queue = Mutex::new(recordings.iter().enumerate());
        let (done, results) = channel();
        std::thread::scope(|scope| {
            for _ in 0..workers {
                let (queue, done) = (&queue, done.clone());
                scope.spawn(move || {
                    while let Some((at, recording)) = next(queue) {
                        // Fewer recordings than threads: each gets several.
                        let result = self.process(recording, threads / workers, is_stopped);
                        if done.send((at, result)).is_err() {
                            break;
                        }
                    }
                });
            }
            drop(done);
            // Ended early, it is dropped, and nobody takes a recording any more.
            for (at, result) in results {
                each(at, &result?);
            }
            Ok(())
        })
    }

    /// Refuses recordings that would be written under one name, or replaced: by what is made of another, or by `tables`.
    ///
    /// # Errors
    /// [`Error::Request`] with both.
    pub fn check_names(&self, recordings: &[PathBuf], tables: &[PathBuf]) -> Result<(), Error> {
        let mut names = HashMap::new();
        let mut written: HashMap<PathBuf, &Path> = HashMap::new();
        for recording in recordings {
            if let Some(other) = names.insert(name_of(recording), recording) {
                return Err(Error::Request {
                    what: format!(
                        "{} and {} would be written under one name",
                        words(other),
                        words(recording)
                    ),
                    hint: "give each recording once, or give them to two folders",
                });
            }
            let place = self.folder.join(name_of(recording));
            for ending in recording::ENDINGS.into_iter().chain([entry::ENDING]) {
                written.extend(
                    there(&with_ending(&place, ending)).map(|file| (file, recording.as_path())),
                );
            }
        }
        for table in tables {
            written.extend(there(table).map(|file| (file, table.as_path())));
        }
        for recording in recordings {
            let file = there(recording);
            if let Some(by) = file.and_then(|file| written.get(&file)) {
                return Err(Error::Request {
                    what: format!(
                        "the recording {} would be replaced: {} is written there",
                        words(recording),
                        if tables.iter().any(|table| table == by) {
                            "a table".to_owned()
                        } else {
                            format!("what is made of {}", words(by))
                        }
                    ),
                    hint: "write to another folder, or leave the results of a former run out",
                });
            }
        }
        Ok(())
    }
}

/// The one name of a file, where there is such a file.
fn there(file: &Path) -> Option<PathBuf> {
    std::fs::canonicalize(file).ok()
}

fn next<T>(queue: &Mutex<impl Iterator<Item = T>>) -> Option<T> {
    let mut queue = queue
        .lock()
        .unwrap_or_else(std::sync::PoisonError::into_inner);
    queue.next()
}

/// A recording that is done.
pub struct Done {
    /// What was made of it.
    pub entry: Entry,
    /// Whether it was done now, and not found done.
    pub again: bool,
}

/// Where in the folder things of a recording lie: under its own name as it was given, so that it does not hang on what other
/// recordings there are.
pub fn name_of(recording: &Path) -> PathBuf {
    let parts = recording.components().filter_map(|part| match part {
        Component::Normal(name) => Some(name.to_owned()),
        Component::ParentDir => Some("up".into()),
        Component::Prefix(_) | Component::RootDir | Component::CurDir => None,
    });
    parts.collect()
}
