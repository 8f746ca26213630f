//! The circuit both ways, and a virtual sensor.

use numpy::{IntoPyArray, PyArray1, PyArray3, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use taxel::circuit::{Circuit, SensorCircuit};
use taxel::frame::{grams_from_newtons, newtons_from_grams};
use taxel::simulate::{Imperfections, Pattern, VirtualSensor};
use taxel::{Counts, Frame, Grams, Siemens, Volts};
use taxel_app::methods::MethodName;

use crate::arrays::{Frames, Range, crossings};
use crate::errors;
use crate::interrupt::interruptible;
use crate::output::{Output, room};
use crate::sensor::Sensor;

type Array3<'py> = Bound<'py, PyArray3<f64>>;

/// What the read-out gives of conductances: volts. See `taxel.scan`.
#[pyfunction]
pub(crate) fn scan<'py>(
    py: Python<'py>,
    sensor: &Sensor,
    siemens: &Bound<'py, PyAny>,
) -> PyResult<Array3<'py>> {
    let sensor = &sensor.sensor;
    let frames = Frames::take(siemens, sensor)?;
    let numbers = frames.numbers()?;
    let circuit = py.detach(|| SensorCircuit::from_sensor(sensor));
    let circuit = circuit.map_err(errors::of_taxel)?;
    let taxels = crossings(sensor);
    let mut volts = room(numbers.len())?;
    volts.resize(numbers.len(), 0.0);
    interruptible(py, |stop| {
        let mut point = circuit.operating_point();
        let mut g = vec![0.0; taxels];
        for (at, volts) in volts.chunks_exact_mut(taxels).enumerate() {
            stop.check();
            numbers.copy_frame(at, sensor.columns(), Range::NotNegative, &mut g)?;
            point
                .set(&g)
                .map_err(|_| format!("frame {at}: conductances that no network has"))?;
            point.predict_into(volts);
        }
        Ok::<(), String>(())
    })?
    .map_err(errors::array)?;
    shaped(py, volts, sensor)
}

/// Conductances behind volts, and whether each frame has an answer. See `taxel.solve`.
#[pyfunction]
pub(crate) fn solve<'py>(
    py: Python<'py>,
    sensor: &Sensor,
    volts: &Bound<'py, PyAny>,
    method: &str,
) -> PyResult<(Array3<'py>, Bound<'py, PyArray1<bool>>)> {
    let named: MethodName = method.parse().map_err(errors::other)?;
    let opened = interruptible(py, |_| named.open(&sensor.sensor, &sensor.file))?;
    let opened = opened.map_err(errors::of_app)?;
    let taxel_app::methods::Opened::Method(method) = opened else {
        return Err(errors::other(
            "a model estimates loads, not conductances\nhint: Pipeline(sensor, method)",
        ));
    };
    let sensor = &sensor.sensor;
    let frames = Frames::take(volts, sensor)?;
    let numbers = frames.numbers()?;
    let mut siemens: Vec<f64> = room(numbers.len())?;
    let answered = interruptible(py, |stop| {
        let mut solver = method.solver();
        let (rows, columns) = (sensor.rows(), sensor.columns());
        let mut read = Frame::<Volts>::zeros(rows, columns);
        let mut found = Frame::<Siemens>::zeros(rows, columns);
        let mut answered = Vec::new();
        for at in 0..numbers.len() / crossings(sensor) {
            stop.check();
            numbers.copy_frame(at, columns, Range::Finite, read.values_mut())?;
            sensor.mark_absent(read.marks_mut());
            let outcome = solver.solve_into(&read, &mut found);
            if !outcome.stop.is_good() {
                solver.forget();
            }
            answered.push(outcome.is_answer());
            siemens.extend_from_slice(found.values());
        }
        Ok::<_, String>(answered)
    })?
    .map_err(errors::array)?;
    Ok((shaped(py, siemens, sensor)?, answered.into_pyarray(py)))
}

/// What presses on a virtual sensor, and how it differs from the file.
#[derive(FromPyObject)]
pub(crate) struct Drawing {
    pattern: String,
    frames: usize,
    peak_newtons: Option<f64>,
    seed: u64,
    imperfect: bool,
}

impl Drawing {
    fn sensor(&self, nominal: &taxel::Sensor) -> PyResult<VirtualSensor> {
        let imperfections = if self.imperfect {
            Imperfections::uneven()
        } else {
            Imperfections::default()
        };
        VirtualSensor::imperfect(nominal, &imperfections, self.seed).map_err(errors::of_taxel)
    }

    fn pattern(&self) -> PyResult<Pattern> {
        let found = Pattern::named(&self.pattern).ok_or_else(|| {
            errors::other(format!(
                "no pattern `{}`\nhint: hand, grip, regrip, fingers, feet, uniform, random, blobs, press",
                self.pattern
            ))
        })?;
        match self.peak_newtons {
            None => Ok(found),
            Some(peak) if peak.is_finite() && peak > 0.0 => {
                Ok(found.with_peak_g(grams_from_newtons(peak)))
            }
            Some(peak) => Err(errors::other(format!(
                "peak_newtons {peak}: a load above 0"
            ))),
        }
    }
}

/// What a virtual sensor reads: a dict of counts, loads_newtons and truth. See `taxel.simulate`.
#[pyfunction]
pub(crate) fn simulate<'py>(
    py: Python<'py>,
    sensor: &Sensor,
    loads: Option<&Bound<'py, PyAny>>,
    drawing: Drawing,
) -> PyResult<Bound<'py, PyDict>> {
    let nominal = &sensor.sensor;
    let pattern = drawing.pattern()?;
    let drawn = interruptible(py, |_| drawing.sensor(nominal))??;
    let given = loads
        .map(|loads| Frames::take(loads, nominal))
        .transpose()?;
    let given = given.as_ref().map(Frames::numbers).transpose()?;
    let count = given.map_or(drawing.frames, |given| given.len() / crossings(nominal));
    let mut counts = Output::new(false, count.saturating_mul(crossings(nominal)))?;
    let mut newtons = Output::new(false, count.saturating_mul(crossings(nominal)))?;
    interruptible(py, |stop| {
        let mut loads = Frame::<Grams>::zeros(nominal.rows(), nominal.columns());
        let mut memory = drawn.memory();
        for at in 0..count {
            stop.check();
            match given {
                Some(given) => {
                    let (values, range) = (loads.values_mut(), Range::NotNegative);
                    given.copy_frame(at, nominal.columns(), range, values)?;
                    let each = values.iter_mut();
                    each.for_each(|load| *load = grams_from_newtons(*load));
                }
                None => loads = pattern.loads(nominal.array(), drawing.seed, at as u64),
            }
            let read: Frame<Counts> = drawn.read_next(&mut memory, &loads, at as u64).counts;
            counts.extend(read.values().iter().copied());
            newtons.extend(loads.values().iter().map(|g| newtons_from_grams(*g)));
        }
        Ok::<(), String>(())
    })?
    .map_err(errors::array)?;
    let dict = PyDict::new(py);
    dict.set_item("counts", counts.into_array(py))?;
    dict.set_item("loads_newtons", newtons.into_array(py))?;
    let truth = Sensor::from_parts(drawn.sensor().clone(), sensor.file.clone());
    dict.set_item("truth", truth)?;
    Ok(dict)
}

fn shaped<'py>(py: Python<'py>, values: Vec<f64>, sensor: &taxel::Sensor) -> PyResult<Array3<'py>> {
    let frames = values.len() / crossings(sensor);
    values
        .into_pyarray(py)
        .reshape((frames, sensor.rows(), sensor.columns()))
}
