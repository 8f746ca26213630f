//! `taxel.Sensor`.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use numpy::{IntoPyArray, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};
use taxel::sensor::PRESETS;
use taxel_app::frames::carries_sensor;
use taxel_app::sensor_source;
use taxel_io::sensor_file;

use crate::arrays::crossings;
use crate::errors;
use crate::interrupt::interruptible;
use crate::output::dict_of;

/// What a sensor is: its array, its read-out circuit, its converter, and, once calibrated, its load law.
///
/// Parameters
/// ----------
/// source : str, path or dict
///     A sensor file (``.toml``), the name of a preset (``taxel.presets()``), a recording that carries its sensor (``.mcap``,
///     ``.parquet``), or a dict with the tables of a sensor file.
///
/// Raises
/// ------
/// taxel.FileError
///     No such file or preset.
/// taxel.SensorError
///     What it says cannot be: which key, its value, and what was expected.
#[pyclass(frozen, module = "taxel", from_py_object)]
#[derive(Clone)]
pub(crate) struct Sensor {
    /// Shared: some have a number for every taxel, and every result has its sensor.
    pub(crate) sensor: Arc<taxel::Sensor>,
    pub(crate) file: PathBuf,
}

/// The names of sensors that need no file.
#[pyfunction]
pub(crate) fn presets() -> Vec<&'static str> {
    PRESETS.iter().map(|(name, _)| *name).collect()
}

#[pymethods]
impl Sensor {
    #[new]
    fn new(source: &Bound<'_, PyAny>) -> PyResult<Self> {
        if let Ok(dict) = source.cast::<PyDict>() {
            return Self::from_dict(dict);
        }
        let file: PathBuf = source.extract()?;
        interruptible(source.py(), |_| {
            if carries_sensor(&file) {
                let (sensor, file) = sensor_source::of_recording(&file).map_err(errors::of_app)?;
                return Ok(Self::from_parts(sensor, file));
            }
            let sensor = sensor_file::load(&file).map_err(errors::of_io)?;
            Ok(Self::from_parts(sensor, file))
        })?
    }

    /// A sensor from the text of a sensor file.
    #[staticmethod]
    #[pyo3(signature = (text, file = "sensor.toml".into()))]
    fn from_toml(py: Python<'_>, text: &str, file: PathBuf) -> PyResult<Self> {
        py.detach(|| Self::of_text(text, file))
    }

    /// The sensor that a recording carries; None where it carries none.
    #[staticmethod]
    fn carried_by(py: Python<'_>, path: PathBuf) -> PyResult<Option<Self>> {
        interruptible(py, |_| {
            if !carries_sensor(&path) {
                return Ok(None);
            }
            let sensor = sensor_source::carried(&path).map_err(errors::of_app)?;
            Ok(sensor.map(|sensor| Self::from_parts(sensor, path)))
        })?
    }

    /// A sensor from the tables of a sensor file.
    #[staticmethod]
    fn from_dict(dict: &Bound<'_, PyDict>) -> PyResult<Self> {
        let json = dict.py().import("json")?;
        let text: String = json.call_method1("dumps", (dict,))?.extract()?;
        dict.py().detach(|| {
            let table: toml::Table = serde_json::from_str(&text).map_err(errors::other)?;
            let text = toml::to_string(&table).map_err(errors::other)?;
            Self::of_text(&text, "dict".into())
        })
    }

    /// The text of its sensor file.
    fn to_toml(&self, py: Python<'_>) -> String {
        py.detach(|| self.sensor.to_toml())
    }

    /// The tables of its sensor file.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let read = || toml::from_str::<toml::Table>(&self.sensor.to_toml());
        let table = py.detach(read).map_err(errors::other)?;
        dict_of(py, &table)
    }

    /// Writes its sensor file; a file of that name is replaced.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let write = || {
            let mut file = taxel_io::AtomicFile::create(&path)?;
            file.put(self.sensor.to_toml().as_bytes())?;
            file.commit()
        };
        py.detach(write).map_err(errors::of_io)
    }

    /// Its name.
    #[getter]
    fn name(&self) -> &str {
        self.sensor.name()
    }

    /// Where it comes from: a file, or a preset's name.
    #[getter]
    fn file(&self) -> &Path {
        &self.file
    }

    /// Sensed lines.
    #[getter]
    fn rows(&self) -> usize {
        self.sensor.rows()
    }

    /// Driven lines.
    #[getter]
    fn columns(&self) -> usize {
        self.sensor.columns()
    }

    /// Rows and columns.
    #[getter]
    fn shape(&self) -> (usize, usize) {
        (self.sensor.rows(), self.sensor.columns())
    }

    /// How the lines that are not selected end, in words.
    #[getter]
    fn readout(&self) -> String {
        self.sensor.readout().words()
    }

    /// From one taxel to the next, mm: down the rows and across the columns.
    #[getter]
    fn pitch_mm(&self) -> (f64, f64) {
        self.sensor.array().pitch_mm.into()
    }

    /// What a taxel's load is divided by for its pressure, mm².
    #[getter]
    fn taxel_area_mm2(&self) -> f64 {
        self.sensor.array().taxel_area_mm2
    }

    /// The same of every taxel, rows × columns: on a cone smaller where it is narrow.
    #[getter]
    fn taxel_areas_mm2<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let taxels = self.sensor.rows() * self.sensor.columns();
        let area = |taxel| self.sensor.taxel_area_mm2(taxel);
        let areas: Vec<f64> = py.detach(|| (0..taxels).map(area).collect());
        areas.into_pyarray(py).reshape(self.shape())
    }

    /// The largest count that the converter gives.
    #[getter]
    fn max_count(&self) -> f64 {
        self.sensor.max_count()
    }

    /// Whether it has a load law, so that frames become newtons.
    #[getter]
    fn has_load_law(&self) -> bool {
        self.sensor.material().is_some()
    }

    /// Whether it says how far its loads can be trusted beyond noise: a calibration has.
    #[getter]
    fn has_uncertainty(&self) -> bool {
        self.sensor.uncertainty().is_some()
    }

    /// Which crossings carry a taxel: bool, rows × columns.
    #[getter]
    fn populated<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<bool>>> {
        let is_there = |taxel| !self.sensor.is_absent(taxel);
        let there: Vec<bool> = py.detach(|| (0..crossings(&self.sensor)).map(is_there).collect());
        there.into_pyarray(py).reshape(self.shape())
    }

    /// Where each taxel lies, mm, x and y: taxels × 2; None where the array is the regular grid of its pitch.
    #[getter]
    fn positions_mm<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray2<f64>>>> {
        let positions = self.sensor.positions();
        let flat = |all: &[[f64; 2]]| all.iter().flatten().copied().collect::<Vec<f64>>();
        let flat = py.detach(|| positions.map(flat));
        flat.map(|flat| {
            let taxels = flat.len() / 2;
            flat.into_pyarray(py).reshape((taxels, 2))
        })
        .transpose()
    }

    fn __repr__(&self) -> String {
        let (sensor, converter) = (&self.sensor, self.sensor.converter());
        let [down, across] = sensor.array().pitch_mm;
        let law = match (sensor.material(), sensor.uncertainty()) {
            (None, _) => "no load law",
            (Some(_), None) => "load law, no calibration's uncertainty",
            (Some(_), Some(_)) => "calibrated",
        };
        format!(
            "<taxel.Sensor {}: {} × {} taxels, {down} × {across} mm apart; {}; {} bits; {law}>",
            PyStringRepr(sensor.name()),
            sensor.rows(),
            sensor.columns(),
            sensor.readout().words(),
            converter.bits,
        )
    }

    /// The same sensor, wherever it comes from.
    fn __eq__(&self, py: Python<'_>, other: &Bound<'_, PyAny>) -> bool {
        let other = other.cast::<Self>().map(Bound::get);
        other.is_ok_and(|other| py.detach(|| self.sensor == other.sensor))
    }

    fn __hash__(&self, py: Python<'_>) -> u64 {
        use std::hash::{DefaultHasher, Hash, Hasher};
        py.detach(|| {
            let mut hasher = DefaultHasher::new();
            self.sensor.to_toml().hash(&mut hasher);
            hasher.finish()
        })
    }

    /// Pickled as the text of its file. Where that came from goes as text: a path of one system is none on another.
    fn __reduce__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<(Bound<'py, PyAny>, (String, OsString))> {
        let make = py.get_type::<Self>().getattr("from_toml")?;
        Ok((make, (self.to_toml(py), self.file.clone().into_os_string())))
    }
}

impl Sensor {
    fn of_text(text: &str, file: PathBuf) -> PyResult<Self> {
        let sensor = taxel::Sensor::from_toml(text).map_err(errors::of_taxel)?;
        sensor_file::check_array(&file, sensor.rows(), sensor.columns()).map_err(errors::of_io)?;
        Ok(Self::from_parts(sensor, file))
    }

    pub(crate) fn from_parts(sensor: taxel::Sensor, file: PathBuf) -> Self {
        let sensor = Arc::new(sensor);
        Self { sensor, file }
    }

    /// The sensor, and where it comes from.
    pub(crate) fn into_parts(self) -> (taxel::Sensor, PathBuf) {
        (Arc::unwrap_or_clone(self.sensor), self.file)
    }
}

/// A name in quotes.
struct PyStringRepr<'a>(&'a str);

impl std::fmt::Display for PyStringRepr<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        Python::attach(|py| match PyString::new(py, self.0).repr() {
            Ok(text) => write!(f, "{text}"),
            Err(_) => write!(f, "{:?}", self.0),
        })
    }
}
