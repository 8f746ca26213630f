//! `taxel.Pipeline`: arrays of counts to arrays of loads, on all cores.

mod block;

use std::sync::{Mutex, PoisonError};

use numpy::{PyReadonlyArray1, PyReadonlyArray3};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use taxel::pipeline::Repair;
use taxel::screen::{FrameScreen, Level, LineFaults, LineScreen};
use taxel::{Counts, Frame, Mark};
use taxel_app::executor::cores;
use taxel_app::in_order::in_order;
use taxel_app::methods::MethodName;

use crate::arrays::{Frames, Numbers, Range, beside_frames, copy_marks, crossings};
use crate::errors;
use crate::interrupt::{Stop, interruptible};
use crate::sensor::Sensor;
use block::{Block, Input, Results, Solving, Wanted, Worker};

/// Frames of a block, at most: a block begins cold, whatever the number of cores, so that results do not hang on it.
const BLOCK_FRAMES: usize = 64;
/// Numbers of a block, at most.
const BLOCK_NUMBERS: usize = 1 << 19;

#[pyclass(frozen, module = "taxel._taxel", subclass)]
pub(crate) struct Pipeline {
    sensor: Sensor,
    method: MethodName,
    state: Mutex<State>,
}

/// What one call leaves to the next.
struct State {
    /// Sees all frames in order.
    screen: FrameScreen,
    workers: Vec<Worker>,
    repair: Option<bool>,
    faults: LineFaults,
    /// Baseline and noise as frames have told them.
    level: Option<Level>,
}

#[pymethods]
impl Pipeline {
    #[new]
    #[pyo3(signature = (sensor, method = "auto", repair = None))]
    fn new(sensor: Sensor, method: &str, repair: Option<bool>) -> PyResult<Self> {
        let method: MethodName = method.parse().map_err(errors::other)?;
        let mut state = State {
            screen: FrameScreen::from_sensor(&sensor.sensor),
            workers: Vec::new(),
            repair,
            faults: LineFaults::from_spec(sensor.sensor.screen()),
            level: None,
        };
        state.screen.set_lines(&state.faults);
        state.grow(1, &sensor, &method)?;
        Ok(Self {
            sensor,
            method,
            state: Mutex::new(state),
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
        self.lock().repair
    }

    /// Forgets all frames before.
    fn reset(&self) {
        let state = &mut *self.lock();
        state.screen = FrameScreen::from_sensor(&self.sensor.sensor);
        state.screen.set_lines(&state.faults);
        state.level = state.faults.level;
        for worker in &mut state.workers {
            worker.chain.begin_anew();
        }
    }

    /// Looks for faulty lines in all frames together; what it finds holds from then on. In words, each.
    fn look_for_faults(&self, py: Python<'_>, frames: &Bound<'_, PyAny>) -> PyResult<Vec<String>> {
        let frames = Frames::take(frames, &self.sensor.sensor)?;
        let numbers = frames.numbers()?;
        let sensor = &self.sensor.sensor;
        let range = Range::Counts(sensor.max_count());
        let found = interruptible(py, |stop| -> Result<LineFaults, String> {
            let mut screen = LineScreen::from_sensor(sensor);
            let mut frame = Frame::<Counts>::zeros(sensor.rows(), sensor.columns());
            for at in 0..numbers.len() / crossings(sensor) {
                stop.check();
                numbers.copy_frame(at, sensor.columns(), range, frame.values_mut())?;
                let seen = screen.observe(&frame);
                seen.expect("the frame has the sensor's shape");
            }
            Ok(screen.finish().with_declared(sensor.screen()))
        })?;
        let found = found.map_err(errors::array)?;
        let words = found.faults.iter().map(ToString::to_string).collect();
        self.lock().set_lines(found);
        Ok(words)
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
        let tare = beside_frames(tare.as_ref(), numbers.len(), "numbers of the tare")?;
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
        if standard_errors {
            self.find_level(py, &source)?;
        }
        let mut results = Results::new(sensor, count, single, wanted, self.lock().has_loads())?;
        interruptible(py, |stop| {
            let mut state = self.lock();
            let threads = threads.unwrap_or_else(cores);
            state.run(
                (&self.sensor, &self.method),
                (&source, wanted, threads),
                stop,
                &mut results,
            )
        })??;
        results.into_dict(py, self.lock().noise_counts())
    }
}

impl Pipeline {
    /// Baseline and noise of these frames, where neither the sensor file nor frames before have told the noise.
    fn find_level(&self, py: Python<'_>, source: &Source) -> PyResult<()> {
        let sensor = &self.sensor.sensor;
        let is_told = sensor.converter().noise_counts.is_some() || self.lock().level.is_some();
        if is_told || !matches!(source.input, Input::Counts(_)) {
            return Ok(());
        }
        let found = interruptible(py, |stop| -> Result<Option<Level>, String> {
            let mut screen = LineScreen::from_sensor(sensor);
            let mut frame = Frame::<Counts>::zeros(sensor.rows(), sensor.columns());
            for at in 0..source.count {
                stop.check();
                source.copy_frame(at, &mut frame)?;
                let seen = screen.observe(&frame);
                seen.expect("the frame has the sensor's shape");
            }
            Ok(screen.level())
        })?;
        self.lock().level = found.map_err(errors::array)?;
        Ok(())
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Frames as they came.
struct Source<'a> {
    numbers: Numbers<'a>,
    codes: Option<&'a [u8]>,
    /// What is taken off each load, newtons.
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

impl State {
    fn has_loads(&self) -> bool {
        self.workers.first().is_some_and(Worker::has_loads)
    }

    /// Standard deviation of a reading that standard errors were found with.
    fn noise_counts(&self) -> Option<f64> {
        self.workers.first().and_then(Worker::noise_counts)
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
    fn grow(&mut self, workers: usize, sensor: &Sensor, method: &MethodName) -> PyResult<()> {
        while self.workers.len() < workers {
            let mut chain = method
                .pipeline(&sensor.sensor, &sensor.file)
                .map_err(errors::of_app)?;
            chain.set_lines(&self.faults);
            if let Some(repair) = self.repair {
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
        (sensor, method): (&Sensor, &MethodName),
        (source, wanted, threads): (&Source, Wanted, usize),
        stop: &Stop,
        results: &mut Results,
    ) -> PyResult<()> {
        let each = (BLOCK_NUMBERS / crossings(&sensor.sensor)).clamp(1, BLOCK_FRAMES);
        let blocks = source.count.div_ceil(each);
        // What loads remember goes from frame to frame, and so from block to block.
        let is_stream = blocks <= 1 || self.workers[0].chain.remembers();
        let threads = if is_stream {
            1
        } else {
            threads.clamp(1, blocks)
        };
        self.grow(threads, sensor, method)?;
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
