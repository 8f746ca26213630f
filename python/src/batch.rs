//! `taxel.map`: an archive of recordings, as `taxel batch` does it.

use std::path::PathBuf;
use std::sync::Mutex;

use pyo3::prelude::*;
use taxel_app::batch::{self, Done, LoadsFile, Settings};
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
    #[pyo3(signature = (recordings, threads = None))]
    fn run(
        &self,
        py: Python<'_>,
        recordings: Vec<PathBuf>,
        threads: Option<usize>,
    ) -> PyResult<Vec<(String, bool)>> {
        batch::check_names(&recordings).map_err(errors::of_app)?;
        let found = Mutex::new(vec![None; recordings.len()]);
        let done = interruptible(py, |stop| {
            let is_stopped = || stop.is_set();
            let batch = batch::Batch::new(&self.settings, &self.folder)?.until(&is_stopped);
            let mut found = found.lock().expect("nobody else has it");
            batch.run(&recordings, threads, |at, done: &Done| {
                let entry = serde_json::to_string(&done.entry);
                found[at] = Some((entry.expect("numbers and words"), done.again));
            })
        })?;
        done.map_err(errors::of_app)?;
        let found = found.into_inner().expect("the work has ended");
        Ok(found.into_iter().flatten().collect())
    }

    /// Refuses recordings that would be written under one name.
    #[staticmethod]
    fn check_names(recordings: Vec<PathBuf>) -> PyResult<()> {
        batch::check_names(&recordings).map_err(errors::of_app)
    }

    /// Writes `summary.csv` and `manifest.csv` of what is done of these recordings.
    fn write_tables(&self, recordings: Vec<PathBuf>) -> PyResult<()> {
        let batch = batch::Batch::new(&self.settings, &self.folder).map_err(errors::of_app)?;
        let entries = batch.entries(&recordings);
        batch::summary(&self.folder.join("summary.csv"), &entries).map_err(errors::of_app)?;
        batch::manifest(&self.folder.join("manifest.csv"), &entries).map_err(errors::of_app)
    }
}
