//! What recordings tell of a sensor: its read-out, and how good it is.

use std::path::PathBuf;

use pyo3::prelude::*;
use taxel_app::Silent;
use taxel_app::evaluation::{self, Evaluation, plan::Plan};
use taxel_app::identify::IdentifyFiles;
use taxel_io::AtomicFile;

use crate::errors;
use crate::interrupt::interruptible;
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
    files.sensor = sensor.map(|sensor| sensor.sensor);
    files.rows = rows;
    files.equilibration = equilibration;
    files.transpose = transpose;
    let found = interruptible(py, |_| files.identify(&Silent))?.map_err(errors::of_app)?;
    dict_of(py, &found.identification)
}

/// A sensor evaluated by a plan: what `taxel evaluate --json` says. See `taxel.evaluate`.
#[pyfunction]
pub(crate) fn evaluate<'py>(py: Python<'py>, plan: PathBuf) -> PyResult<Bound<'py, PyAny>> {
    let found = evaluated(py, plan)?;
    dict_of(py, &found.report)
}

/// The same as a page, in a file. See `taxel.report`.
#[pyfunction]
pub(crate) fn report(py: Python<'_>, plan: PathBuf, output: PathBuf) -> PyResult<()> {
    let found = evaluated(py, plan)?;
    let page = found.report.html();
    AtomicFile::write_whole(&output, page.as_bytes()).map_err(errors::of_io)
}

fn evaluated(py: Python<'_>, plan: PathBuf) -> PyResult<Evaluation> {
    let work = || Plan::read(&plan).and_then(|plan| evaluation::run(&plan, &Silent));
    interruptible(py, |_| work())?.map_err(errors::of_app)
}
