//! From counts to loads in one object: screen, convert, solve, load law, creep and hysteresis, spread.

use crate::calibrate::{DynamicLaw, LoadLaw, Memory, Spread};
use crate::circuit::Converter;
use crate::frame::newtons_from_grams;
use crate::screen::{FrameScreen, LineFaults, ScreenOptions, repair, repair_readings, stand_in};
use crate::solve::{Method, Outcome, Scratch, Stop};
use crate::{Counts, Error, Frame, Mark, Newtons, Sensor, Siemens, Volts};

/// What is replaced by the median of its neighbours, and marked [`Mark::Interpolated`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Repair {
    /// Nothing.
    #[default]
    Nothing,
    /// Single readings: stuck, spikes. What `screen.repair` in the sensor file asks for.
    Readings,
    /// Dead and flickering lines as well.
    Everything,
}

impl Repair {
    fn run<Q>(self, frame: &mut Frame<Q>, scratch: &mut Vec<f64>) {
        match self {
            Repair::Nothing => 0,
            Repair::Readings => repair_readings(frame, scratch),
            Repair::Everything => repair(frame, scratch),
        };
    }
}

/// What one frame comes to: all of it belongs to that frame and was computed once.
#[derive(Debug, Clone, Copy)]
pub struct FrameResult<'a> {
    /// How the inverse went.
    pub outcome: &'a Outcome,
    /// What was read, volts.
    pub volts: &'a Frame<Volts>,
    /// Conductances with the cross-talk removed, siemens; repaired where that was asked for.
    pub siemens: &'a Frame<Siemens>,
    /// Loads with the spread undone, newtons; repaired where that was asked for. Not cut off at zero: noise about
    /// an unloaded taxel adds up to nothing in a sum. `None` where the sensor has no load law.
    pub loads: Option<&'a Frame<Newtons>>,
}

impl<'a> FrameResult<'a> {
    /// The loads, newtons.
    ///
    /// # Errors
    /// [`Error::MissingKey`] when the sensor has no load law.
    pub fn newtons(&self) -> Result<&'a Frame<Newtons>, Error> {
        self.loads.ok_or_else(|| Error::MissingKey {
            key: "material",
            hint: "calibrate the sensor to find its load law, or ask for conductances".to_owned(),
        })
    }
}

/// Everything that a stream of frames of one sensor needs, and its memory; no allocation a frame.
///
/// One call a frame ([`Self::process`]) computes everything; what it found can be looked at as often as needed.
/// The marks say what a number is worth. Where no conductances explain a frame, every number of it is 0; where the
/// inverse came to no answer, or to one of several, the numbers are its last; in all three cases whatever was
/// measured is marked [`Mark::Unresolved`].
///
/// ```
/// use taxel::{Counts, Frame, pipeline::Pipeline, sensor::preset, solve::default_method};
/// let sensor = preset("econe")?;
/// let mut pipeline = Pipeline::new(&sensor, default_method(&sensor)?)?;
/// let frame = Frame::<Counts>::filled(sensor.rows(), sensor.columns(), 24.0);
/// let result = pipeline.process(&frame);
/// assert!(result.outcome.is_answer());
/// assert!(result.newtons()?.values().iter().all(|&load| load.abs() < 0.01));
/// # Ok::<(), taxel::Error>(())
/// ```
pub struct Pipeline {
    converter: Converter,
    screen: FrameScreen,
    method: Box<dyn Method>,
    scratch: Scratch,
    law: Option<LoadLaw>,
    spread: Option<Spread>,
    /// What the material remembers.
    memory: Option<Memory>,
    repair: Repair,
    outcome: Outcome,
    counts: Frame<Counts>,
    volts: Frame<Volts>,
    siemens: Frame<Siemens>,
    grams: Vec<f64>,
    undone: Vec<f64>,
    work: Vec<f64>,
    loads: Frame<Newtons>,
    around: Vec<f64>,
}

impl Pipeline {
    /// For one sensor and a method. Without a material it stops at conductances.
    ///
    /// # Errors
    /// [`Error::MissingKey`] when gain or exponent are still the name of a file.
    pub fn new(sensor: &Sensor, method: Box<dyn Method>) -> Result<Self, Error> {
        let (rows, columns) = (sensor.rows(), sensor.columns());
        let options = ScreenOptions::from_sensor(sensor);
        let mut screen = FrameScreen::new(rows, columns, sensor.max_count(), &options);
        screen.set_lines(&LineFaults::from_spec(&sensor.screen));
        let taxels = rows * columns;
        let gives_loads = method.gives_loads();
        let material = sensor.material.as_ref();
        Ok(Self {
            converter: Converter::from_sensor(sensor),
            screen,
            scratch: method.scratch(),
            method,
            law: material.map(|_| LoadLaw::from_sensor(sensor)).transpose()?,
            spread: material
                .and_then(|material| material.spread)
                .filter(|_| !gives_loads)
                .map(Spread::new),
            memory: material
                .and_then(|material| material.dynamic.as_ref())
                .filter(|_| !gives_loads)
                .map(|spec| Memory::new(&DynamicLaw::from_spec(spec), taxels)),
            repair: match sensor.screen.repair {
                true => Repair::Readings,
                false => Repair::Nothing,
            },
            outcome: Outcome::new(Stop::Direct, 0, 0.0),
            counts: Frame::zeros(rows, columns),
            volts: Frame::zeros(rows, columns),
            siemens: Frame::zeros(rows, columns),
            grams: vec![0.0; taxels],
            undone: vec![0.0; taxels],
            work: vec![0.0; taxels],
            loads: Frame::zeros(rows, columns),
            around: Vec::with_capacity((rows + 1) * (columns + 1) + 2 * (rows + columns)),
        })
    }

    /// Replaces what was not measured by the median of its neighbours, or not; the sensor file says otherwise.
    pub fn set_repair(&mut self, repair: Repair) {
        self.repair = repair;
    }

    /// The name of the method.
    pub fn method_name(&self) -> &'static str {
        self.method.name()
    }

    /// Tells the screen which lines are faulty in this recording, beside those of the sensor file.
    pub fn set_lines(&mut self, faults: &LineFaults) {
        self.screen.set_lines(faults);
    }

    /// Makes the next frame the first: where a recording jumps, or another begins. What the material remembers is taken to
    /// be nothing.
    pub fn begin_anew(&mut self) {
        self.scratch.forget();
        if let Some(memory) = &mut self.memory {
            memory.forget();
        }
    }

    /// Screens, converts and solves one frame of counts, and finds its loads. Marks it brings are kept.
    ///
    /// # Panics
    /// When the frame's shape is not the sensor's.
    pub fn process(&mut self, counts: &Frame<Counts>) -> FrameResult<'_> {
        self.counts.take_marks(counts);
        self.counts.values.copy_from_slice(counts.values());
        self.screen
            .mark(&mut self.counts)
            .expect("the frame has the sensor's shape");
        self.converter
            .volts_from_counts_into(&self.counts, &mut self.volts);
        self.solve();
        self.find_loads()
    }

    /// The same for one frame of read-out volts: no screen, no converter.
    ///
    /// # Panics
    /// When the frame's shape is not the sensor's.
    pub fn process_volts(&mut self, volts: &Frame<Volts>) -> FrameResult<'_> {
        self.volts.take_marks(volts);
        self.volts.values.copy_from_slice(volts.values());
        self.solve();
        self.find_loads()
    }

    /// Takes a frame of conductances as it is, for the load law alone.
    ///
    /// # Panics
    /// When the frame's shape is not the sensor's.
    pub fn process_siemens(&mut self, siemens: &Frame<Siemens>) -> FrameResult<'_> {
        self.siemens.take_marks(siemens);
        self.siemens.values.copy_from_slice(siemens.values());
        self.outcome = Outcome::new(Stop::Direct, 0, 0.0);
        self.find_loads()
    }

    /// The last frame's result again.
    pub fn result(&self) -> FrameResult<'_> {
        FrameResult {
            outcome: &self.outcome,
            volts: &self.volts,
            siemens: &self.siemens,
            loads: self.law.is_some().then_some(&self.loads),
        }
    }

    fn solve(&mut self) {
        stand_in(&mut self.volts, &mut self.around);
        self.outcome = self
            .method
            .solve_into(&self.volts, &mut self.siemens, &mut self.scratch);
        if !self.outcome.stop.is_good() {
            // An answer that is none is no start for the next frame.
            self.scratch.forget();
        }
        if matches!(self.outcome.stop, Stop::Infeasible(_)) {
            self.siemens.values.fill(0.0);
        }
        if !self.outcome.is_answer() {
            for mark in &mut self.siemens.marks {
                if mark.is_measured() || *mark == Mark::Interpolated {
                    *mark = Mark::Unresolved;
                }
            }
        }
        // The stand-in served the rest of the network; for the taxel itself it is no measurement.
        for (value, mark) in self.siemens.values.iter_mut().zip(&self.siemens.marks) {
            if matches!(mark, Mark::Stuck | Mark::Spike) {
                *value = 0.0;
            }
        }
    }

    fn find_loads(&mut self) -> FrameResult<'_> {
        if let Some(law) = &self.law {
            self.loads.take_marks(&self.siemens);
            let siemens = self.siemens.values.iter().enumerate();
            for (grams, (taxel, &siemens)) in self.grams.iter_mut().zip(siemens) {
                *grams = law.grams_from_siemens(taxel, siemens);
            }
            let unexplained = matches!(self.outcome.stop, Stop::Infeasible(_));
            let marks = &self.loads.marks;
            if let Some(memory) = &mut self.memory {
                // Numbers of a frame that nothing explains are none to remember.
                let is_lost = |taxel: usize| unexplained || is_lost(marks[taxel]);
                memory.loads_from_acting(self.siemens.time_secs, &mut self.grams, is_lost);
            }
            if let Some(spread) = self.spread.filter(|_| !unexplained) {
                // A lost taxel in the middle of a load would look like a hole that its neighbours fill.
                fill_lost(&mut self.loads, &mut self.grams, &mut self.around);
                spread.undo(
                    self.loads.columns(),
                    &self.grams,
                    &mut self.undone,
                    &mut self.work,
                );
                self.grams.copy_from_slice(&self.undone);
            }
            let loads = self.loads.values.iter_mut().zip(&self.loads.marks);
            for ((load, mark), &grams) in loads.zip(&self.grams) {
                *load = match unexplained || is_lost(*mark) {
                    true => 0.0,
                    false => newtons_from_grams(grams),
                };
            }
            self.repair.run(&mut self.loads, &mut self.around);
        }
        self.repair.run(&mut self.siemens, &mut self.around);
        self.result()
    }
}

/// Whether a taxel has no reading of its own.
fn is_lost(mark: Mark) -> bool {
    matches!(
        mark,
        Mark::Open | Mark::Flickering | Mark::Stuck | Mark::Spike
    )
}

/// Gives lost taxels the median load around them, for what is computed from neighbourhoods.
fn fill_lost(frame: &mut Frame<Newtons>, grams: &mut [f64], around: &mut Vec<f64>) {
    if !frame.marks.iter().any(|&mark| is_lost(mark)) {
        return;
    }
    frame.values.copy_from_slice(grams);
    crate::screen::fill(frame, around, is_lost);
    grams.copy_from_slice(&frame.values);
}
