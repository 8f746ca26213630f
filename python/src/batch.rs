//! `taxel.map`: an archive of recordings, as `taxel batch` does it.

use std::path::PathBuf;

use pyo3::prelude::*;
use taxel_app::Error;
use taxel_app::batch::{self, Done, Entry, LoadsFile, Settings};
use taxel_app::methods::MethodName;

use crate::errors;
use crate::interrupt::interruptible;
use crate::sensor::Sensor;

/// A folder that an archive is worked into, and what is made of each recording: checked once, however often it is called.
#[pyclass(frozen, module = "taxel._taxel")]
pub(crate) struct Batch {
    batch: batch::Batch,
    folder: PathBuf,
}

#[pymethods]
impl Batch {
    #[new]
    #[pyo3(signature = (folder, sensor, *, method, loads, intervals, pictures, repair, no_tare, transpose, with_names))]
    #[allow(clippy::too_many_arguments)]
    fn new(
        py: Python<'_>,
        folder: PathBuf,
        sensor: Option<Sensor>,
        method: &str,
        loads: &str,
        intervals: bool,
        pictures: bool,
        repair: Option<bool>,
        no_tare: bool,
        transpose: bool,
        with_names: bool,
    ) -> PyResult<Self> {
        let mut settings = Settings::new(sensor.map(Sensor::into_parts));
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
        settings.with_names = with_names;
        let batch = interruptible(py, |_| batch::Batch::new(settings, &folder))?;
        Ok(Self {
            batch: batch.map_err(errors::of_app)?,
            folder,
        })
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
        let done = interruptible(py, |stop| -> Result<_, Error> {
            self.batch.check_names(&recordings, &files)?;
            let mut found = vec![None; recordings.len()];
            let is_stopped = || stop.is_set();
            self.batch
                .run(&recordings, threads, &is_stopped, |at, done: &Done| {
                    found[at] = Some((done.entry.clone(), done.again));
                })?;
            let (entries, again): (Vec<Entry>, Vec<bool>) = found.into_iter().flatten().unzip();
            write_tables(&files, &entries)?;
            let json = |entry: &Entry| serde_json::to_string(entry).expect("numbers and words");
            Ok(entries.iter().map(json).zip(again).collect())
        })?;
        done.map_err(errors::of_app)
    }

    /// Refuses recordings that would be written under one name, or replaced.
    fn check_names(&self, py: Python<'_>, recordings: Vec<PathBuf>) -> PyResult<()> {
        let checked = interruptible(py, |_| self.batch.check_names(&recordings, &self.tables()));
        checked?.map_err(errors::of_app)
    }

    /// Writes `summary.csv` and `manifest.csv` of recordings, from their entries as `run` has given them.
    fn write_tables(&self, py: Python<'_>, entries: Vec<String>) -> PyResult<()> {
        interruptible(py, |_| {
            let read = |entry: &String| serde_json::from_str(entry);
            let entries: Result<Vec<Entry>, _> = entries.iter().map(read).collect();
            let entries = entries.map_err(|error| errors::other(format!("an entry: {error}")))?;
            write_tables(&self.tables(), &entries).map_err(errors::of_app)
        })?
    }
}

/// `summary.csv` and `manifest.csv`, where they are wanted.
fn write_tables(files: &[PathBuf], entries: &[Entry]) -> Result<(), Error> {
    if let [summary, manifest] = files {
        batch::summary(summary, entries)?;
        batch::manifest(manifest, entries)?;
    }
    Ok(())
}

impl Batch {
    fn tables(&self) -> Vec<PathBuf> {
        let names = ["summary.csv", "manifest.csv"];
        names.map(|name| self.folder.join(name)).into()
    }
}
