//! `taxel.map`: an archive of recordings, as `taxel batch` does it.

use std::path::PathBuf;
use std::sync::Mutex;

use pyo3::prelude::*;
use taxel_app::batch::{self, Done, Entry, LoadsFile, Settings};
use taxel_app::methods::MethodName;

use crate::errors;
use crate::interrupt::interruptible;
use crate::sensor::Sensor;

/// A folder that an archive is worked into, and what is made of each recording.
#[pyclass(frozen, module = "taxel._taxel")]
pub(crate) struct Batch {
    settings: Settings,
    folder: PathBuf,
}

#[pymethods]
impl Batch {
    #[new]
    #[pyo3(signature = (folder, sensor, *, method, loads, intervals, pictures, repair, no_tare, transpose))]
    #[allow(clippy::too_many_arguments)]
    fn new(
        folder: PathBuf,
        sensor: Option<Sensor>,
        method: &str,
        loads: &str,
        intervals: bool,
        pictures: bool,
        repair: Option<bool>,
        no_tare: bool,
        transpose: bool,
    ) -> PyResult<Self> {
        let mut settings = Settings::new(sensor.map(|sensor| (sensor.sensor, sensor.file)));
        settings.method = method.parse::<MethodName>().map_err(errors::other)?;
        settings.loads = match loads {
            "parquet" => LoadsFile::Parquet,
            "mcap" => LoadsFile::Mcap,
            "none" => LoadsFile::Nothing,
            other => {
                return Err(errors::other(format!(
                    "loads {other:?}\nhint: loads are written as \"parquet\" or \"mcap\", or \"none\" are"
                )));
            }
        };
        settings.intervals = intervals;
        settings.pictures = pictures;
        settings.repair = repair;
        settings.no_tare = no_tare;
        settings.transpose = transpose;
        Ok(Self { settings, folder })
    }

    /// Works recordings through, several at once; their entries in their order, as JSON, each with whether it was done now.
    /// `tables`: `summary.csv` and `manifest.csv` are written.
    #[pyo3(signature = (recordings, threads = None, tables = false))]
    fn run(
        &self,
        py: Python<'_>,
        recordings: Vec<PathBuf>,
        threads: Option<usize>,
        tables: bool,
    ) -> PyResult<Vec<(String, bool)>> {
        let files = if tables { self.tables() } else { Vec::new() };
        let found = Mutex::new(vec![None; recordings.len()]);
        let done = interruptible(py, |stop| {
            let is_stopped = || stop.is_set();
            let batch = batch::Batch::new(&self.settings, &self.folder)?.until(&is_stopped);
            batch.check_names(&recordings, &files)?;
            let mut found = found.lock().expect("nobody else has it");
            batch.run(&recordings, threads, |at, done: &Done| {
                found[at] = Some((done.entry.clone(), done.again));
            })
        })?;
        done.map_err(errors::of_app)?;
        let found = found.into_inner().expect("the work has ended");
        let (entries, again): (Vec<Entry>, Vec<bool>) = found.into_iter().flatten().unzip();
        if let [summary, manifest] = &files[..] {
            batch::summary(summary, &entries).map_err(errors::of_app)?;
            batch::manifest(manifest, &entries).map_err(errors::of_app)?;
        }
        let json = |entry: &Entry| serde_json::to_string(entry).expect("numbers and words");
        Ok(entries.iter().map(json).zip(again).collect())
    }

    /// Refuses recordings that would be written under one name, or replaced.
    fn check_names(&self, recordings: Vec<PathBuf>) -> PyResult<()> {
        let batch = batch::Batch::new(&self.settings, &self.folder).map_err(errors::of_app)?;
        let checked = batch.check_names(&recordings, &self.tables());
        checked.map_err(errors::of_app)
    }

    /// Writes `summary.csv` and `manifest.csv` of recordings, from their entries as `run` has given them.
    fn write_tables(&self, entries: Vec<String>) -> PyResult<()> {
        let read = |entry: &String| serde_json::from_str(entry);
        let entries: Result<Vec<Entry>, _> = entries.iter().map(read).collect();
        let entries = entries.map_err(|error| errors::other(format!("an entry: {error}")))?;
        let [summary, manifest] = &self.tables()[..] else {
            unreachable!("there are two");
        };
        batch::summary(summary, &entries).map_err(errors::of_app)?;
        batch::manifest(manifest, &entries).map_err(errors::of_app)
    }
}

impl Batch {
    fn tables(&self) -> Vec<PathBuf> {
        let names = ["summary.csv", "manifest.csv"];
        names.map(|name| self.folder.join(name)).into()
    }
}
