//! An open recording: blocks of frames, one after the other. `taxel.Recording` stands on it.

use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::UNIX_EPOCH;

use numpy::{IntoPyArray, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use taxel::{Frame, Mark};
use taxel_app::frames::{FrameReader, Input};
use taxel_app::units::InputUnit;
use taxel_io::{ReadOptions, shape_of};

use crate::errors;
use crate::interrupt::{Stop, StoppableThreads, interruptible};
use crate::output::bytes;
use crate::sensor::Sensor;

#[pyclass(frozen, module = "taxel._taxel")]
pub(crate) struct Reader {
    state: Mutex<FrameReader>,
    shape: (usize, usize),
    unit: InputUnit,
}

/// Numbers of frames, in the narrower type as long as they fit: counts may be means of several readings.
enum Values {
    U16(Vec<u16>),
    F64(Vec<f64>),
}

impl Values {
    fn extend(&mut self, values: &[f64]) {
        if let Self::U16(narrow) = self {
            let before = narrow.len();
            narrow.extend(values.iter().map(|&x| x as i32 as u16));
            let both = narrow[before..].iter().zip(values);
            // Without branches, so that several are looked at at once.
            let fits = both.fold(true, |all, (&n, &x)| all & (f64::from(n) == x));
            if fits {
                return;
            }
            *self = Self::F64(narrow[..before].iter().map(|&n| f64::from(n)).collect());
        }
        if let Self::F64(wide) = self {
            wide.extend_from_slice(values);
        }
    }
}

/// What is taken off the loads of frames, newtons. Mostly it is the same for all of them, and then kept once.
enum Tares {
    None,
    Same(Vec<f64>),
    Each(Vec<f64>),
}

impl Tares {
    /// Adds that of frame `at`.
    fn add(&mut self, tare: Option<&[f64]>, at: usize, taxels: usize) {
        match (&*self, tare) {
            (Self::None, None) => return,
            (Self::None, Some(tare)) if at == 0 => return *self = Self::Same(tare.to_vec()),
            (Self::Same(same), Some(tare)) if same == tare => return,
            _ => {}
        }
        let mut tares = match std::mem::replace(self, Self::None) {
            Self::None => vec![0.0; at * taxels],
            Self::Same(same) => same.repeat(at),
            Self::Each(tares) => tares,
        };
        tares.extend_from_slice(tare.unwrap_or_default());
        tares.resize((at + 1) * taxels, 0.0);
        *self = Self::Each(tares);
    }
}

/// Frames read: numbers, and what stands beside them.
struct Chunk {
    values: Values,
    /// Codes; none as long as all readings are good.
    marks: Option<Vec<u8>>,
    taxels: usize,
    time: Vec<f64>,
    tare: Tares,
    sequence: Vec<u64>,
}

#[pymethods]
impl Reader {
    /// Opens a file of frames of the sensor, or without one of the shape that the file tells.
    #[new]
    #[pyo3(signature = (path, sensor, unit, transpose, keep_going))]
    fn new(
        py: Python<'_>,
        path: PathBuf,
        sensor: Option<Sensor>,
        unit: &str,
        transpose: bool,
        keep_going: bool,
    ) -> PyResult<Self> {
        let unit = InputUnit::ALL
            .into_iter()
            .find(|known| known.word() == unit)
            .ok_or_else(|| {
                errors::other(format!("unit {unit:?}\nhint: counts, volts or siemens"))
            })?;
        let mut options = match &sensor {
            Some(sensor) => ReadOptions::of(&sensor.sensor),
            None => {
                let guess = interruptible(py, |_| shape_of(&path))?.map_err(errors::of_io)?;
                let (Some(rows), Some(columns)) = (guess.rows, guess.columns) else {
                    return Err(errors::other(format!(
                        "{}: nothing in the file says how many rows a frame has\nhint: sensor=, a sensor file or a preset's name",
                        path.display()
                    )));
                };
                ReadOptions::new(rows, columns)
            }
        };
        (options.transpose, options.keep_going) = (transpose, keep_going);
        options.accept_damage = keep_going;
        let input = Input {
            file: path,
            unit,
            options,
        };
        let reader = interruptible(py, |_| input.open())?.map_err(errors::of_app)?;
        Ok(Self {
            state: Mutex::new(reader),
            shape: (options.rows, options.columns),
            unit,
        })
    }

    #[getter]
    fn shape(&self) -> (usize, usize) {
        self.shape
    }

    /// The next frames, at most so many; None at the end.
    fn read<'py>(&self, py: Python<'py>, most: usize) -> PyResult<Option<Bound<'py, PyDict>>> {
        let chunk = interruptible(py, |stop| {
            let mut reader = self.lock();
            let mut chunk = Chunk::new(self.unit == InputUnit::Counts);
            loop {
                chunk.add_plain(&mut reader, most, stop)?;
                if chunk.sequence.len() >= most || !reader.advance().map_err(errors::of_frames)? {
                    return PyResult::Ok(chunk);
                }
                stop.check();
                chunk.add(&reader);
            }
        })??;
        if chunk.sequence.is_empty() {
            return Ok(None);
        }
        chunk.into_dict(py, self.shape).map(Some)
    }

    /// Goes past frames without keeping them; how many there were.
    fn skip(&self, py: Python<'_>, most: usize) -> PyResult<usize> {
        interruptible(py, |stop| {
            let mut reader = self.lock();
            let mut skipped = 0;
            while skipped < most && reader.advance().map_err(errors::of_frames)? {
                stop.check();
                skipped += 1;
            }
            Ok(skipped)
        })?
    }

    /// What happened up to the frame read last: dicts of secs, kind, text, unix_secs.
    fn events<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        let events = py.detach(|| match &mut *self.lock() {
            FrameReader::Counts(source, _) => source.take_events(),
            FrameReader::Volts(source, _) => source.take_events(),
            FrameReader::Siemens(source, _) => source.take_events(),
        });
        let list = PyList::empty(py);
        for event in events {
            let dict = PyDict::new(py);
            dict.set_item("secs", event.secs)?;
            dict.set_item("kind", event.kind)?;
            dict.set_item("text", event.text)?;
            let unix = event.at.duration_since(UNIX_EPOCH);
            dict.set_item("unix_secs", unix.map_or(0.0, |since| since.as_secs_f64()))?;
            list.append(dict)?;
        }
        Ok(list)
    }

    /// What is missing from what was read so far, in words.
    fn missing(&self, py: Python<'_>) -> Vec<String> {
        py.detach(|| words_of_missing(&self.lock()))
    }
}

impl Reader {
    /// Never waited for with Python held: nothing else of Python would run meanwhile.
    fn lock(&self) -> MutexGuard<'_, FrameReader> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn words_of_missing(reader: &FrameReader) -> Vec<String> {
    let (count, first) = reader.skips();
    let mut words = reader.integrity().words();
    if count > 0 {
        words.push(match first.first() {
            Some(skip) => format!(
                "{count} frames left out; frame {}: {}",
                skip.frame, skip.error
            ),
            None => format!("{count} frames left out"),
        });
    }
    words
}

impl Chunk {
    fn new(is_narrow: bool) -> Self {
        Self {
            values: if is_narrow {
                Values::U16(Vec::new())
            } else {
                Values::F64(Vec::new())
            },
            marks: None,
            taxels: 0,
            time: Vec::new(),
            tare: Tares::None,
            sequence: Vec::new(),
        }
    }

    /// Adds frames that need no look at each.
    fn add_plain(&mut self, reader: &mut FrameReader, most: usize, stop: &Stop) -> PyResult<()> {
        let wanted = most - self.sequence.len();
        let (FrameReader::Counts(source, frame), Values::U16(values)) = (reader, &mut self.values)
        else {
            return Ok(());
        };
        let read = source.next_counts(wanted, values, &StoppableThreads(stop));
        let read = read.map_err(|error| errors::of_frames(error.into()))?;
        if read.is_empty() {
            return Ok(());
        }
        self.taxels = frame.values().len();
        let count = (read.end - read.start) as usize;
        self.sequence.extend(read);
        let frames = self.sequence.len();
        self.time.resize(frames, f64::NAN);
        if let Some(marks) = &mut self.marks {
            marks.resize(frames * self.taxels, Mark::Good.code());
        }
        let before = frames - count;
        (before..frames).for_each(|at| self.tare.add(None, at, self.taxels));
        Ok(())
    }

    fn add(&mut self, reader: &FrameReader) {
        match reader {
            FrameReader::Counts(_, frame) => self.add_frame(frame),
            FrameReader::Volts(_, frame) => self.add_frame(frame),
            FrameReader::Siemens(_, frame) => self.add_frame(frame),
        }
        let taxels = self.taxels;
        let tare = reader
            .tare()
            .filter(|tare| tare.unit == "N" && tare.loads.len() == taxels);
        let loads = tare.map(|tare| &tare.loads[..]);
        self.tare.add(loads, self.sequence.len() - 1, taxels);
    }

    fn add_frame<Q>(&mut self, frame: &Frame<Q>) {
        self.values.extend(frame.values());
        self.taxels = frame.values().len();
        let before = self.sequence.len() * self.taxels;
        let good = Mark::Good.code();
        if self.marks.is_none() && frame.marks().iter().any(|mark| *mark != Mark::Good) {
            self.marks = Some(vec![good; before]);
        }
        if let Some(marks) = &mut self.marks {
            marks.extend(frame.marks().iter().map(|mark| mark.code()));
        }
        self.time.push(frame.time_secs.unwrap_or(f64::NAN));
        self.sequence.push(frame.sequence);
    }

    fn into_dict(
        self,
        py: Python<'_>,
        (rows, columns): (usize, usize),
    ) -> PyResult<Bound<'_, PyDict>> {
        let shape = (self.sequence.len(), rows, columns);
        let dict = PyDict::new(py);
        match self.values {
            Values::U16(values) => dict.set_item("values", values.into_pyarray(py).reshape(shape)?),
            Values::F64(values) => dict.set_item("values", values.into_pyarray(py).reshape(shape)?),
        }?;
        if let Some(marks) = self.marks {
            dict.set_item("marks", bytes(py, marks).reshape(shape)?)?;
        }
        dict.set_item("time", self.time.into_pyarray(py))?;
        dict.set_item("sequence", self.sequence.into_pyarray(py))?;
        match self.tare {
            Tares::None => {}
            Tares::Same(tare) => {
                dict.set_item("tare", tare.into_pyarray(py).reshape((1, rows, columns))?)?;
            }
            Tares::Each(tares) => {
                dict.set_item("tare", tares.into_pyarray(py).reshape(shape)?)?;
            }
        }
        Ok(dict)
    }
}
