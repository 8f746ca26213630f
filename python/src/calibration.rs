//! `taxel.calibrate`.

use std::path::PathBuf;

use numpy::PyReadonlyArray1;
use numpy::ndarray::ArrayView1;
use pyo3::prelude::*;
use taxel::calibrate::{
    Calibration as Found, CalibrationData, CalibrationOptions, LawChoice, PressLabel,
    calibrate_with,
};
use taxel::frame::grams_from_newtons;
use taxel::{Counts, Frame};
use taxel_app::{calibration_picture, presses};
use taxel_plot::Format;

use crate::arrays::{Frames, Numbers, Range, crossings};
use crate::errors;
use crate::interrupt::{Stop, StoppableStages, StoppableThreads, interruptible};
use crate::output::dict_of;
use crate::sensor::Sensor;

#[pyclass(frozen, module = "taxel._taxel", subclass)]
pub(crate) struct Calibration {
    found: Found,
    file: PathBuf,
}

/// Labelled presses in arrays.
#[derive(FromPyObject)]
pub(crate) struct Labelled<'py> {
    frames: Bound<'py, PyAny>,
    frame: PyReadonlyArray1<'py, i64>,
    row: PyReadonlyArray1<'py, i64>,
    column: PyReadonlyArray1<'py, i64>,
    load_newtons: PyReadonlyArray1<'py, f64>,
    uniform_frames: Option<Bound<'py, PyAny>>,
    uniform_newtons: PyReadonlyArray1<'py, f64>,
}

impl Labelled<'_> {
    fn data(&self, sensor: &taxel::Sensor) -> PyResult<CalibrationData> {
        let frames = Frames::take(&self.frames, sensor)?;
        let numbers = frames.numbers()?;
        let labels = Labels {
            frame: self.frame.as_array(),
            row: self.row.as_array(),
            column: self.column.as_array(),
            load_newtons: self.load_newtons.as_array(),
        };
        let take = |frames| Frames::take(frames, sensor);
        let uniform = self.uniform_frames.as_ref().map(take).transpose()?;
        let uniform = uniform.as_ref().map(Frames::numbers).transpose()?;
        let newtons = self.uniform_newtons.as_array();
        interruptible(self.frames.py(), |stop| -> Result<_, String> {
            let mut data = labels.data(numbers, sensor, stop)?;
            if let Some(uniform) = uniform {
                let frames = frames_of(uniform, sensor, stop);
                data.uniform = with_loads(
                    frames.map_err(|why| format!("uniform_frames: {why}"))?,
                    newtons,
                )?;
            }
            Ok(data)
        })?
        .map_err(errors::array)
    }
}

/// All frames of counts.
fn frames_of(
    numbers: Numbers<'_>,
    sensor: &taxel::Sensor,
    stop: &Stop,
) -> Result<Vec<Frame<Counts>>, String> {
    let range = Range::Counts(sensor.max_count());
    let one = |at: usize| {
        stop.check();
        let mut frame = Frame::<Counts>::zeros(sensor.rows(), sensor.columns());
        numbers.copy_frame(at, sensor.columns(), range, frame.values_mut())?;
        sensor.mark_absent(frame.marks_mut());
        frame.sequence = at as u64;
        Ok(frame)
    };
    (0..numbers.len() / crossings(sensor)).map(one).collect()
}

/// Frames under uniform loads with the load on every taxel, grams.
fn with_loads(
    frames: Vec<Frame<Counts>>,
    newtons: ArrayView1<'_, f64>,
) -> Result<Vec<(Frame<Counts>, f64)>, String> {
    if frames.len() != newtons.len() {
        return Err(format!(
            "{} uniform frames and {} loads: one of each belongs together",
            frames.len(),
            newtons.len()
        ));
    }
    let grams = |(at, newtons): (usize, &f64)| {
        let grams = grams_from_newtons(*newtons);
        let is_load = grams.is_finite() && grams >= 0.0;
        is_load
            .then_some(grams)
            .ok_or_else(|| format!("uniform frame {at}: {newtons} N on every taxel is none"))
    };
    let loads: Result<Vec<f64>, String> = newtons.iter().enumerate().map(grams).collect();
    Ok(frames.into_iter().zip(loads?).collect())
}

/// The same without Python.
struct Labels<'a> {
    frame: ArrayView1<'a, i64>,
    row: ArrayView1<'a, i64>,
    column: ArrayView1<'a, i64>,
    load_newtons: ArrayView1<'a, f64>,
}

impl Labels<'_> {
    fn data(
        &self,
        numbers: Numbers<'_>,
        sensor: &taxel::Sensor,
        stop: &Stop,
    ) -> Result<CalibrationData, String> {
        let mut data = CalibrationData {
            frames: frames_of(numbers, sensor, stop)?,
            ..CalibrationData::default()
        };
        let (frame, row) = (&self.frame, &self.row);
        let (column, load) = (&self.column, &self.load_newtons);
        let counts = [frame.len(), row.len(), column.len(), load.len()];
        if counts.iter().any(|count| *count != counts[0]) {
            return Err(format!(
                "{} frames, {} rows, {} columns and {} loads: one of each is a press",
                counts[0], counts[1], counts[2], counts[3]
            ));
        }
        let place = |what: &str, press: usize, value: i64, most: usize| {
            usize::try_from(value)
                .ok()
                .filter(|value| *value < most)
                .ok_or_else(|| {
                    format!(
                        "press {press}: {what} {value}, but there are {most}\nhint: counted from 0"
                    )
                })
        };
        for press in 0..counts[0] {
            let load_g = grams_from_newtons(load[press]);
            if !(load_g.is_finite() && load_g >= 0.0) {
                return Err(format!(
                    "press {press}: a load of {} N is none",
                    load[press]
                ));
            }
            data.presses.push(PressLabel {
                frame: place("frame", press, frame[press], data.frames.len())?,
                row: place("row", press, row[press], sensor.rows())?,
                column: place("column", press, column[press], sensor.columns())?,
                load_g,
            });
        }
        Ok(data)
    }
}

/// What to fit, and how.
#[derive(FromPyObject)]
pub(crate) struct Options {
    law: String,
    per_line: bool,
    fit_gain: bool,
    fit_source: bool,
    line_resistance: bool,
    label_error: f64,
    folds: usize,
    date: String,
    transpose: bool,
}

impl Options {
    fn of(&self, files: Vec<String>) -> PyResult<CalibrationOptions> {
        if !(0.0..0.5).contains(&self.label_error) {
            return Err(errors::other(format!(
                "label_error {}: a share from 0 to below a half",
                self.label_error
            )));
        }
        if self.folds < 2 {
            return Err(errors::other(format!(
                "{} folds, but 2 or more are needed",
                self.folds
            )));
        }
        let mut options = CalibrationOptions::default();
        options.law = match self.law.as_str() {
            "auto" => LawChoice::Auto,
            "power" => LawChoice::Power,
            "saturating" => LawChoice::Saturating,
            "spline" => LawChoice::Spline,
            other => {
                return Err(errors::other(format!(
                    "no law {other:?}\nhint: auto, power, saturating, spline"
                )));
            }
        };
        options.per_line = self.per_line;
        options.open_loop_gain = self.fit_gain;
        options.r_source = self.fit_source;
        options.line_resistance = self.line_resistance;
        options.label_share = self.label_error;
        options.folds = self.folds;
        options.date = self.date.clone();
        options.files = files;
        Ok(options)
    }
}

/// Fits a sensor to labelled presses: a table with its recordings, or arrays. `taxel.calibrate` is the face of it.
#[pyfunction]
pub(crate) fn calibrate(
    py: Python<'_>,
    sensor: &Sensor,
    table: Option<PathBuf>,
    labelled: Option<Labelled<'_>>,
    equilibration: Option<PathBuf>,
    options: Options,
    progress: Option<Py<PyAny>>,
) -> PyResult<Calibration> {
    let known = &sensor.sensor;
    let data = match (&table, labelled) {
        (Some(table), _) => {
            let (uniform, transpose) = (equilibration.as_deref(), options.transpose);
            interruptible(py, |stop| {
                presses::read(table, uniform, transpose, known, &StoppableStages(stop))
            })?
            .map_err(errors::of_app)?
        }
        (None, Some(labelled)) => labelled.data(known)?,
        (None, None) => return Err(errors::other("no presses are given")),
    };
    let files = [&table, &equilibration].into_iter().flatten();
    let options = options.of(files.map(|file| file.display().to_string()).collect())?;
    let found = interruptible(py, |stop| {
        let mut tell = |stage: &str, share: f64| {
            stop.check();
            if let Some(progress) = &progress {
                // What a bar cannot show is no reason to lose a fit, but is told.
                Python::attach(|py| {
                    if let Err(error) = progress.call1(py, (stage, share)) {
                        error.write_unraisable(py, Some(progress.bind(py)));
                    }
                });
            }
        };
        calibrate_with(known, &data, &options, &StoppableThreads(stop), &mut tell)
    })?
    .map_err(errors::of_taxel)?;
    Ok(Calibration {
        found,
        file: sensor.file.clone(),
    })
}

#[pymethods]
impl Calibration {
    /// The sensor with what was found.
    #[getter]
    fn sensor(&self) -> Sensor {
        Sensor::from_parts(self.found.sensor.clone(), self.file.clone())
    }

    /// All that the command reports, as a dict.
    #[getter]
    fn report<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        dict_of(py, &self.found.report)
    }

    /// What is read of each press beside its label, newtons: columns of a table.
    #[getter]
    fn residuals<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, pyo3::types::PyDict>> {
        use numpy::IntoPyArray;
        let newtons = taxel::frame::newtons_from_grams;
        let all = &self.found.residuals;
        let column = |value: fn(&taxel::calibrate::PressResidual) -> f64| {
            let values = || -> Vec<f64> { all.iter().map(|found| newtons(value(found))).collect() };
            py.detach(values).into_pyarray(py)
        };
        let dict = pyo3::types::PyDict::new(py);
        let press = || -> Vec<u64> { all.iter().map(|found| found.press as u64).collect() };
        let held_out = || -> Vec<bool> { all.iter().map(|found| found.held_out).collect() };
        let (press, held_out) = py.detach(|| (press(), held_out()));
        dict.set_item("press", press.into_pyarray(py))?;
        dict.set_item("held_out", held_out.into_pyarray(py))?;
        dict.set_item("load_newtons", column(|found| found.load_g))?;
        dict.set_item("estimate_newtons", column(|found| found.estimate_g))?;
        dict.set_item(
            "standard_error_newtons",
            column(|found| found.standard_error_g),
        )?;
        dict.set_item(
            "half_width_95_newtons",
            column(|found| found.half_width_95_g),
        )?;
        Ok(dict)
    }

    /// The picture of `taxel calibrate --picture`: the bytes of a `png` or the text of an `svg`.
    fn picture(&self, py: Python<'_>, format: &str) -> PyResult<Vec<u8>> {
        let format = Format::from_extension(std::path::Path::new(&format!("picture.{format}")));
        let format = format.map_err(errors::other)?;
        interruptible(py, |stop| -> Result<Vec<u8>, String> {
            let picture = calibration_picture::of(&self.found).map_err(|e| e.to_string())?;
            stop.check();
            picture.render(format).map_err(|e| e.to_string())
        })?
        .map_err(errors::other)
    }

    fn __str__(&self) -> String {
        self.found.report.to_string()
    }
}
