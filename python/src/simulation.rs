//! The circuit both ways, and a virtual sensor.

use numpy::{IntoPyArray, PyArray3, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use taxel::circuit::{Circuit, SensorCircuit};
use taxel::simulate::{Imperfections, Pattern, VirtualSensor};
use taxel::{Counts, Frame, Grams, Siemens, Volts};
use taxel_app::methods::MethodName;

use crate::arrays::{Frames, Range};
use crate::errors;
use crate::interrupt::interruptible;
use crate::output::room;
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
    let circuit = SensorCircuit::from_sensor(sensor).map_err(errors::of_taxel)?;
    let taxels = sensor.taxels();
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
) -> PyResult<(Array3<'py>, Vec<bool>)> {
    let named: MethodName = method.parse().map_err(errors::other)?;
    let opened = named
        .open(&sensor.sensor, &sensor.file)
        .map_err(errors::of_app)?;
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
        for at in 0..numbers.len() / sensor.taxels() {
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
    Ok((shaped(py, siemens, sensor)?, answered))
}

/// What a virtual sensor reads of a pattern: a dict of counts and loads_newtons. See `taxel.simulate`.
#[pyfunction]
pub(crate) fn simulate<'py>(
    py: Python<'py>,
    sensor: &Sensor,
    loads: Option<&Bound<'py, PyAny>>,
    pattern: &str,
    frames: usize,
    peak_newtons: Option<f64>,
    seed: u64,
    imperfect: bool,
) -> PyResult<Bound<'py, PyDict>> {
    let nominal = &sensor.sensor;
    let imperfections = if imperfect {
        Imperfections::uneven()
    } else {
        Imperfections::default()
    };
    let drawn =
        VirtualSensor::imperfect(nominal, &imperfections, seed).map_err(errors::of_taxel)?;
    let mut kind = Pattern::named(pattern).ok_or_else(|| {
        errors::other(format!(
            "no pattern {pattern:?}\nhint: hand, grip, fingers, feet, uniform, random, blobs"
        ))
    })?;
    if let Some(peak) = peak_newtons {
        kind = kind.with_peak_g(taxel::frame::grams_from_newtons(peak));
    }
    let given = loads
        .map(|loads| Frames::take(loads, nominal))
        .transpose()?;
    let given = given.as_ref().map(Frames::numbers).transpose()?;
    let count = given.map_or(frames, |given| given.len() / nominal.taxels());
    let mut counts: Vec<f64> = room(count * nominal.taxels())?;
    let mut newtons: Vec<f64> = room(count * nominal.taxels())?;
    interruptible(py, |stop| {
        let mut loads = Frame::<Grams>::zeros(nominal.rows(), nominal.columns());
        for at in 0..count {
            stop.check();
            match given {
                Some(given) => {
                    let values = loads.values_mut();
                    given.copy_frame(at, nominal.columns(), Range::NotNegative, values)?;
                    values
                        .iter_mut()
                        .for_each(|load| *load = taxel::frame::grams_from_newtons(*load));
                }
                None => loads = kind.loads(nominal.array(), seed, at as u64),
            }
            let read: Frame<Counts> = drawn.read(&loads, at as u64).counts;
            counts.extend_from_slice(read.values());
            newtons.extend(
                loads
                    .values()
                    .iter()
                    .map(|g| taxel::frame::newtons_from_grams(*g)),
            );
        }
        Ok::<(), String>(())
    })?
    .map_err(errors::array)?;
    let dict = PyDict::new(py);
    if nominal.max_count() <= f64::from(u16::MAX) {
        let narrow: Vec<u16> = counts.iter().map(|count| *count as u16).collect();
        let shape = (count, nominal.rows(), nominal.columns());
        dict.set_item("counts", narrow.into_pyarray(py).reshape(shape)?)?;
    } else {
        dict.set_item("counts", shaped(py, counts, nominal)?)?;
    }
    dict.set_item("loads_newtons", shaped(py, newtons, nominal)?)?;
    let file = sensor.file.clone();
    let truth = drawn.sensor().clone();
    dict.set_item(
        "truth",
        Sensor {
            sensor: truth,
            file,
        },
    )?;
    Ok(dict)
}

fn shaped<'py>(py: Python<'py>, values: Vec<f64>, sensor: &taxel::Sensor) -> PyResult<Array3<'py>> {
    let frames = values.len() / sensor.taxels();
    values
        .into_pyarray(py)
        .reshape((frames, sensor.rows(), sensor.columns()))
}
