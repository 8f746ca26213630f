//! `taxel.Pipeline`: arrays of counts to arrays of loads, on all cores.

mod block;

use std::sync::{Mutex, MutexGuard, TryLockError};
use std::time::Duration;

use numpy::{PyReadonlyArray1, PyReadonlyArray3, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use taxel::pipeline::Repair;
use taxel::screen::{FrameScreen, Level, LineFaults, LineScreen};
use taxel::{Counts, Frame, Mark};
use taxel_app::conversion::block_frames;
use taxel_app::executor::cores;
use taxel_app::in_order::in_order;
use taxel_app::methods::MethodName;

use crate::arrays::{Frames, Numbers, Range, beside_frames, copy_marks, crossings};
use crate::errors;
use crate::interrupt::{Stop, interruptible};
use crate::sensor::Sensor;
use block::{Block, Input, Results, Solving, Wanted, Worker};

/// How often a thread looks whether another has done its work with the same pipeline.
const LOOK: Duration = Duration::from_millis(1);

#[pyclass(frozen, module = "taxel._taxel", subclass)]
pub(crate) struct Pipeline {
    sensor: Sensor,
    method: MethodName,
    repair: Option<bool>,
    /// Whether frames come to loads.
    has_loads: bool,
    state: Mutex<State>,
}

/// What one call leaves to the next.
struct State {
    /// Sees all frames in order.
    screen: FrameScreen,
    workers: Vec<Worker>,
    faults: LineFaults,
    /// Baseline and noise as frames have told them.
    level: Option<Level>,
}

#[pymethods]
impl Pipeline {
    #[new]
    #[pyo3(signature = (sensor, method = "auto", repair = None))]
    fn new(py: Python<'_>, sensor: Sensor, method: &str, repair: Option<bool>) -> PyResult<Self> {
        let method: MethodName = method.parse().map_err(errors::other)?;
        py.detach(|| {
            let mut state = State {
                screen: FrameScreen::from_sensor(&sensor.sensor),
                workers: Vec::new(),
                faults: LineFaults::from_spec(sensor.sensor.screen()),
                level: None,
            };
            state.screen.set_lines(&state.faults);
            state.grow(1, (&sensor, &method, repair))?;
            Ok(Self {
                has_loads: state.workers[0].has_loads(),
                sensor,
                method,
                repair,
                state: Mutex::new(state),
            })
        })
    }

    #[getter]
    fn sensor(&self) -> Sensor {
        self.sensor.clone()
    }

    #[getter]
    fn method(&self) -> String {
        self.method.to_string()
    }

    #[getter]
    fn repair(&self) -> Option<bool> {
        self.repair
    }

    /// Forgets all frames before.
    fn reset(&self, py: Python<'_>) -> PyResult<()> {
        interruptible(py, |stop| {
            self.state(stop).begin_anew(&self.sensor.sensor);
        })
    }

    /// Looks for faulty lines in all frames together; what it finds holds from then on. In words, each.
    fn look_for_faults(&self, py: Python<'_>, frames: &Bound<'_, PyAny>) -> PyResult<Vec<String>> {
        let frames = Frames::take(frames, &self.sensor.sensor)?;
        let numbers = frames.numbers()?;
        let sensor = &self.sensor.sensor;
        let range = Range::Counts(sensor.max_count());
        let found = interruptible(py, |stop| -> Result<Vec<String>, String> {
            let mut screen = LineScreen::from_sensor(sensor);
            let mut frame = Frame::<Counts>::zeros(sensor.rows(), sensor.columns());
            for at in 0..numbers.len() / crossings(sensor) {
                stop.check();
                numbers.copy_frame(at, sensor.columns(), range, frame.values_mut())?;
                let seen = screen.observe(&frame);
                seen.expect("the frame has the sensor's shape");
            }
            let found = screen.finish().with_declared(sensor.screen());
            let words = found.faults.iter().map(ToString::to_string).collect();
            self.state(stop).set_lines(found);
            Ok(words)
        })?;
        found.map_err(errors::array)
    }

    /// Of frames to arrays: see `taxel.Pipeline.process`.
    #[pyo3(signature = (frames, unit, *, single, siemens, standard_errors, figures, marks = None, time = None, tare = None, threads = None))]
    #[allow(clippy::too_many_arguments)]
    fn process<'py>(
        &self,
        py: Python<'py>,
        frames: &Bound<'py, PyAny>,
        unit: &str,
        single: bool,
        siemens: bool,
        standard_errors: bool,
        figures: bool,
        marks: Option<PyReadonlyArray3<'py, u8>>,
        time: Option<PyReadonlyArray1<'py, f64>>,
        tare: Option<PyReadonlyArray3<'py, f64>>,
        threads: Option<usize>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let sensor = &self.sensor.sensor;
        let frames = Frames::take(frames, sensor)?;
        let numbers = frames.numbers()?;
        let count = numbers.len() / crossings(sensor);
        let codes = beside_frames(marks.as_ref(), numbers.len(), "marks")?;
        // One for all frames, or one each.
        let is_one = tare.as_ref().is_some_and(|tare| tare.shape()[0] == 1);
        let zeros = if is_one {
            crossings(sensor)
        } else {
            numbers.len()
        };
        let tare = beside_frames(tare.as_ref(), zeros, "numbers of the tare")?;
        let input = Input::named(unit, sensor)?;
        let wanted = Wanted {
            siemens,
            standard_errors,
            figures,
        };
        let source = Source {
            numbers,
            codes,
            tare,
            time: beside_frames(time.as_ref(), count, "times")?,
            input,
            count,
        };
        let mut results = Results::new(sensor, count, single, wanted, self.has_loads)?;
        let noise_counts = interruptible(py, |stop| {
            if standard_errors {
                self.find_level(&source, stop).map_err(errors::array)?;
            }
            let mut state = self.state(stop);
            let threads = threads.unwrap_or_else(cores);
            let making = (&self.sensor, &self.method, self.repair);
            state.run(making, (&source, wanted, threads), stop, &mut results)?;
            PyResult::Ok(state.noise_counts())
        })??;
        results.into_dict(py, noise_counts)
    }
}

impl Pipeline {
    /// Baseline and noise of these frames, where neither the sensor file nor frames before have told the noise.
    fn find_level(&self, source: &Source, stop: &Stop) -> Result<(), String> {
        let sensor = &self.sensor.sensor;
        let has_noise = sensor.converter().noise_counts.is_some();
        if has_noise
            || !matches!(source.input, Input::Counts(_))
            || self.state(stop).level.is_some()
        {
            return Ok(());
        }
        let mut screen = LineScreen::from_sensor(sensor);
        let mut frame = Frame::<Counts>::zeros(sensor.rows(), sensor.columns());
        for at in 0..source.count {
            stop.check();
            source.copy_frame(at, &mut frame)?;
            let seen = screen.observe(&frame);
            seen.expect("the frame has the sensor's shape");
        }
        self.state(stop).level = screen.level();
        Ok(())
    }

    /// What calls leave to each other, once no other thread works with it. Never waited for with Python held: nothing else of
    /// Python would run meanwhile.
    fn state(&self, stop: &Stop) -> MutexGuard<'_, State> {
        loop {
            match self.state.try_lock() {
                Ok(state) => return state,
                // Of a call that Ctrl-C has ended: how far it came is chance, and nothing is to hang on it.
                Err(TryLockError::Poisoned(state)) => {
                    let mut state = state.into_inner();
                    self.state.clear_poison();
                    state.begin_anew(&self.sensor.sensor);
                    return state;
                }
                Err(TryLockError::WouldBlock) => {
                    stop.check();
                    std::thread::sleep(LOOK);
                }
            }
        }
    }
}

/// Frames as they came.
struct Source<'a> {
    numbers: Numbers<'a>,
    codes: Option<&'a [u8]>,
    /// What is taken off each load, newtons: of every frame the same, or of each frame.
    tare: Option<&'a [f64]>,
    time: Option<&'a [f64]>,
    input: Input,
    count: usize,
}

impl Source<'_> {
    /// Copies the numbers of frame `at`, and its marks.
    fn copy_frame(&self, at: usize, frame: &mut Frame<Counts>) -> Result<(), String> {
        let (taxels, columns) = (frame.taxels(), frame.columns());
        let range = self.input.range();
        self.numbers
            .copy_frame(at, columns, range, frame.values_mut())?;
        frame.marks_mut().fill(Mark::Good);
        if let Some(codes) = self.codes {
            copy_marks(&codes[at * taxels..(at + 1) * taxels], frame.marks_mut())?;
        }
        Ok(())
    }
}

/// What a worker is made of: sensor, method, whether what was not measured is replaced.
type Making<'a> = (&'a Sensor, &'a MethodName, Option<bool>);

impl State {
    /// Standard deviation of a reading that standard errors were found with.
    fn noise_counts(&self) -> Option<f64> {
        self.workers.first().and_then(Worker::noise_counts)
    }

    /// Forgets all frames before; what was known of lines stays.
    fn begin_anew(&mut self, sensor: &taxel::Sensor) {
        self.screen = FrameScreen::from_sensor(sensor);
        self.screen.set_lines(&self.faults);
        self.level = self.faults.level;
        for worker in &mut self.workers {
            worker.chain.begin_anew();
        }
    }

    fn set_lines(&mut self, faults: LineFaults) {
        self.screen.set_lines(&faults);
        for worker in &mut self.workers {
            worker.chain.set_lines(&faults);
        }
        self.level = faults.level.or(self.level);
        self.faults = faults;
    }

    /// Sees to it that there are so many workers.
    fn grow(&mut self, workers: usize, (sensor, method, repair): Making<'_>) -> PyResult<()> {
        while self.workers.len() < workers {
            let mut chain = method
                .pipeline(&sensor.sensor, &sensor.file)
                .map_err(errors::of_app)?;
            chain.set_lines(&self.faults);
            if let Some(repair) = repair {
                chain.set_repair(if repair {
                    Repair::Everything
                } else {
                    Repair::Nothing
                });
            }
            self.workers.push(Worker::new(chain));
        }
        Ok(())
    }

    fn run(
        &mut self,
        making: Making<'_>,
        (source, wanted, threads): (&Source, Wanted, usize),
        stop: &Stop,
        results: &mut Results,
    ) -> PyResult<()> {
        let (sensor, ..) = making;
        let each = block_frames(crossings(&sensor.sensor));
        let blocks = source.count.div_ceil(each);
        // What loads remember goes from frame to frame, and so from block to block.
        let is_stream = blocks <= 1 || self.workers[0].chain.remembers();
        let threads = if is_stream {
            1
        } else {
            threads.clamp(1, blocks)
        };
        self.grow(threads, making)?;
        for worker in &mut self.workers[..threads] {
            worker.prepare(&sensor.sensor, self.level, wanted)?;
        }
        let held = if threads == 1 { 1 } else { 2 * threads + 1 };
        let memory = (0..held.min(blocks.max(1)))
            .map(|_| Block::new(&sensor.sensor, each))
            .collect();
        let work = Solving {
            wanted,
            input: source.input,
            tare: source.tare,
            begins_anew: !is_stream,
            stop,
            sensor: &sensor.sensor,
        };
        let mut next = 0;
        let screen = &mut self.screen;
        let done = in_order(
            &work,
            &mut self.workers[..threads],
            memory,
            |block| {
                stop.check();
                let frames = next..(next + each).min(source.count);
                next = frames.end;
                block.fill(frames, source, screen)
            },
            |block| {
                results.take(block);
                Ok(())
            },
        );
        if !is_stream {
            // Which worker had the last block is chance; the next call is not to hang on it.
            self.workers.iter_mut().for_each(|w| w.chain.begin_anew());
        }
        done.map_err(errors::array)
    }
}
