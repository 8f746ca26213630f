//! What recordings tell of a sensor: its read-out, and how good it is.

use std::path::{Path, PathBuf};

use pyo3::prelude::*;
use taxel_app::evaluation::{self, Evaluation, plan::Plan};
use taxel_app::identify::IdentifyFiles;
use taxel_io::AtomicFile;

use crate::errors;
use crate::interrupt::{Stop, StoppableStages, StoppableThreads, interruptible};
use crate::output::dict_of;
use crate::sensor::Sensor;

/// Which read-out explains recordings of unknown loads: what `taxel identify --json` says. See `taxel.identify`.
#[pyfunction]
pub(crate) fn identify<'py>(
    py: Python<'py>,
    recordings: Vec<PathBuf>,
    sensor: Option<Sensor>,
    rows: Option<usize>,
    equilibration: Option<PathBuf>,
    transpose: bool,
) -> PyResult<Bound<'py, PyAny>> {
    let mut files = IdentifyFiles::default();
    files.recordings = recordings;
    files.sensor = sensor.map(|sensor| sensor.into_parts().0);
    files.rows = rows;
    files.equilibration = equilibration;
    files.transpose = transpose;
    let found = interruptible(py, |stop| {
        files.identify(&StoppableThreads(stop), &StoppableStages(stop))
    })?;
    dict_of(py, &found.map_err(errors::of_app)?)
}

/// A sensor evaluated by a plan: what `taxel evaluate --json` says. See `taxel.evaluate`.
#[pyfunction]
pub(crate) fn evaluate<'py>(py: Python<'py>, plan: PathBuf) -> PyResult<Bound<'py, PyAny>> {
    let found = interruptible(py, |stop| evaluated(&plan, stop))?;
    dict_of(py, &found.map_err(errors::of_app)?.report)
}

/// The same as a page, in a file. See `taxel.report`.
#[pyfunction]
pub(crate) fn report(py: Python<'_>, plan: PathBuf, output: PathBuf) -> PyResult<()> {
    let written = interruptible(py, |stop| -> Result<(), taxel_app::Error> {
        let page = evaluated(&plan, stop)?.report.html();
        stop.check();
        Ok(AtomicFile::write_whole(&output, page.as_bytes())?)
    })?;
    written.map_err(errors::of_app)
}

fn evaluated(plan: &Path, stop: &Stop) -> Result<Evaluation, taxel_app::Error> {
    let mut plan = Plan::read(plan)?;
    plan.bootstrap.step = stop.step();
    evaluation::run(&plan, &StoppableStages(stop))
}
