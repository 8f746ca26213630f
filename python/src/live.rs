//! A sensor while it reads.

use std::collections::VecDeque;
use std::path::PathBuf;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant, UNIX_EPOCH};

use numpy::{IntoPyArray, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use taxel_acquire::Address;
use taxel_acquire::protocol::LinkStats;
use taxel_app::methods::MethodName;
use taxel_app::sensor_source;
use taxel_app::session::{LiveFrame, Session, SessionOptions};

use crate::errors;
use crate::sensor::Sensor;

/// How often a waiting call asks whether Ctrl-C was pressed, and whether the source has ended.
const LOOK: Duration = Duration::from_millis(20);

/// Frames of a source, newest kept where Python is slower.
#[pyclass(frozen, module = "taxel._taxel", subclass)]
pub(crate) struct Stream {
    session: Mutex<Option<Session>>,
    /// What was counted when it was closed.
    counted: Mutex<Counted>,
    waiting: Arc<Waiting>,
    sensor: Sensor,
}

/// What happened to frames before they were solved.
#[derive(Clone, Copy, Default)]
struct Counted {
    link: LinkStats,
    /// The inverse was slower.
    left_out: u64,
}

impl Counted {
    fn of(session: &Session) -> Self {
        Self {
            link: session.link_stats(),
            left_out: session.left_out(),
        }
    }
}

/// What came and was not taken yet.
struct Waiting {
    frames: Mutex<Queue>,
    came: Condvar,
    most: usize,
}

#[derive(Default)]
struct Queue {
    frames: VecDeque<Taken>,
    /// Frames that came, and those that nobody took in time.
    came: u64,
    dropped: u64,
}

/// A frame, owned.
struct Taken {
    number: u64,
    unix_secs: f64,
    device_secs: Option<f64>,
    loads: Option<Vec<f64>>,
    siemens: Option<Vec<f64>>,
    marks: Vec<u8>,
    is_answer: bool,
    total_newtons: f64,
}

impl Waiting {
    fn lock(&self) -> MutexGuard<'_, Queue> {
        lock(&self.frames)
    }

    fn push(&self, frame: &LiveFrame) {
        let mut queue = self.lock();
        let number = queue.came;
        queue.came += 1;
        if queue.frames.len() == self.most {
            queue.frames.pop_front();
            queue.dropped += 1;
        }
        queue.frames.push_back(Taken::of(frame, number));
        self.came.notify_one();
    }
}

impl Taken {
    fn of(frame: &LiveFrame, number: u64) -> Self {
        let codes = |marks: &[taxel::Mark]| marks.iter().map(|mark| mark.code()).collect();
        let marks = frame.loads.map(|loads| codes(loads.marks()));
        let marks = marks.or_else(|| frame.siemens.map(|siemens| codes(siemens.marks())));
        let time = frame.loads.map(|loads| loads.time_secs);
        let time = time.or_else(|| frame.siemens.map(|siemens| siemens.time_secs));
        Self {
            number,
            unix_secs: frame
                .at
                .duration_since(UNIX_EPOCH)
                .map_or(0.0, |since| since.as_secs_f64()),
            device_secs: time.flatten(),
            loads: frame.loads.map(|loads| loads.values().to_vec()),
            siemens: frame.siemens.map(|siemens| siemens.values().to_vec()),
            marks: marks.unwrap_or_default(),
            is_answer: frame.is_answer,
            total_newtons: frame.figures.total_force_newtons,
        }
    }

    fn into_dict(self, py: Python<'_>, shape: (usize, usize)) -> PyResult<Bound<'_, PyDict>> {
        let dict = PyDict::new(py);
        dict.set_item("number", self.number)?;
        dict.set_item("unix_secs", self.unix_secs)?;
        dict.set_item("device_secs", self.device_secs)?;
        for (name, values) in [("loads", self.loads), ("siemens", self.siemens)] {
            let values = values.map(|values| values.into_pyarray(py).reshape(shape));
            dict.set_item(name, values.transpose()?)?;
        }
        dict.set_item("marks", self.marks.into_pyarray(py).reshape(shape)?)?;
        dict.set_item("answered", self.is_answer)?;
        dict.set_item("force_newtons", self.total_newtons)?;
        Ok(dict)
    }
}

fn lock<T>(held: &Mutex<T>) -> MutexGuard<'_, T> {
    held.lock().unwrap_or_else(PoisonError::into_inner)
}

#[pymethods]
impl Stream {
    #[new]
    fn new(
        py: Python<'_>,
        address: &str,
        sensor: Option<Sensor>,
        method: &str,
        queue: usize,
        record: Option<PathBuf>,
    ) -> PyResult<Self> {
        let address: Address = address.parse().map_err(errors::other)?;
        if queue == 0 {
            return Err(errors::other(
                "queue 0\nhint: room for one frame or more is needed",
            ));
        }
        let sensor = match sensor {
            Some(sensor) => sensor,
            None => {
                let found = py.detach(|| sensor_source::of(&address, None));
                let (sensor, file) = found.map_err(errors::of_app)?;
                Sensor::from_parts(sensor, file)
            }
        };
        let waiting = Arc::new(Waiting {
            frames: Mutex::default(),
            came: Condvar::new(),
            most: queue,
        });
        let mut options =
            SessionOptions::new(address, taxel::Sensor::clone(&sensor.sensor), &sensor.file);
        let named: Result<MethodName, String> = method.parse();
        options.method = named.map_err(errors::other)?;
        options.record = record;
        let to = waiting.clone();
        options.observer = Some(Box::new(move |frame| to.push(frame)));
        let session = py
            .detach(|| Session::start(options))
            .map_err(errors::of_app)?;
        Ok(Self {
            session: Mutex::new(Some(session)),
            counted: Mutex::default(),
            waiting,
            sensor,
        })
    }

    #[getter]
    fn sensor(&self) -> Sensor {
        self.sensor.clone()
    }

    /// The next frame as a dict; None once the source has ended, or where none came in time.
    #[pyo3(signature = (timeout = None))]
    fn next<'py>(
        &self,
        py: Python<'py>,
        timeout: Option<f64>,
    ) -> PyResult<Option<Bound<'py, PyDict>>> {
        let wait = |secs: f64| {
            Duration::try_from_secs_f64(secs).map_err(|_| {
                errors::other(format!(
                    "a timeout of {secs} s\nhint: 0 or more; without one it waits for as long as it takes"
                ))
            })
        };
        let wait = timeout.map(wait).transpose()?;
        let until = wait.map(|wait| Instant::now() + wait);
        let shape = (self.sensor.sensor.rows(), self.sensor.sensor.columns());
        loop {
            // Asked before the queue is looked at: what came before the end is there by then.
            let has_ended = self.has_ended();
            let taken = py.detach(|| {
                let queue = self.waiting.lock();
                let waits = |queue: &mut Queue| queue.frames.is_empty();
                let waited = self.waiting.came.wait_timeout_while(queue, LOOK, waits);
                waited
                    .unwrap_or_else(PoisonError::into_inner)
                    .0
                    .frames
                    .pop_front()
            });
            if let Some(taken) = taken {
                return taken.into_dict(py, shape).map(Some);
            }
            py.check_signals()?;
            if has_ended || until.is_some_and(|until| Instant::now() >= until) {
                return Ok(None);
            }
        }
    }

    /// Whether the source has no more frames to give; some may still wait to be taken.
    fn has_ended(&self) -> bool {
        let session = lock(&self.session);
        session.as_ref().is_none_or(Session::has_ended)
    }

    /// How the source stands, in words.
    fn state(&self) -> String {
        let state = lock(&self.session).as_ref().map(Session::state);
        state.map_or("closed".to_owned(), |(link, text)| {
            if text.is_empty() {
                link.word().to_owned()
            } else {
                text
            }
        })
    }

    /// Frames received, lost, corrupt and repeated on the way; those left out because the inverse was slower, or Python.
    fn statistics<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        let now = lock(&self.session).as_ref().map(Counted::of);
        let counted = now.unwrap_or_else(|| *lock(&self.counted));
        dict.set_item("received", counted.link.frames)?;
        dict.set_item("lost", counted.link.lost)?;
        dict.set_item("corrupt", counted.link.corrupt)?;
        dict.set_item("repeated", counted.link.repeated)?;
        dict.set_item("left_out", counted.left_out)?;
        dict.set_item("troubles", counted.link.troubles())?;
        let queue = self.waiting.lock();
        dict.set_item("solved", queue.came)?;
        dict.set_item("dropped", queue.dropped)?;
        dict.set_item("waiting", queue.frames.len())?;
        Ok(dict)
    }

    /// Ends the source; a recording is whole when this returns.
    fn close(&self, py: Python<'_>) {
        py.detach(|| {
            let session = lock(&self.session).take();
            if let Some(mut session) = session {
                session.end();
                *lock(&self.counted) = Counted::of(&session);
            }
            self.waiting.lock().frames.clear();
        });
    }
}
