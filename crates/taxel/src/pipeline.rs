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

/// Everything that a stream of frames of one sensor needs, and its memory; no allocation a frame.
///
/// ```
/// use taxel::{Counts, Frame, pipeline::Pipeline, sensor::preset, solve::default_method};
/// let sensor = preset("econe")?;
/// let mut pipeline = Pipeline::new(&sensor, default_method(&sensor)?)?;
/// let frame = Frame::<Counts>::filled(sensor.rows(), sensor.columns(), 24.0);
/// let outcome = pipeline.siemens_from_counts(&frame);
/// assert!(outcome.stop.is_good());
/// let loads = pipeline.newtons()?;
/// assert!(loads.values().iter().all(|&load| load < 0.01));
/// # Ok::<(), taxel::Error>(())
/// ```
pub struct Pipeline {
    converter: Converter,
    screen: FrameScreen,
    method: Box<dyn Method>,
    scratch: Scratch,
    law: Option<LoadLaw>,
    spread: Option<Spread>,
    /// What the material remembers, and whether it has seen the last frame.
    memory: Option<Memory>,
    remembered: bool,
    /// Some conductances explain the last frame.
    explained: bool,
    repair: Repair,
    counts: Frame<Counts>,
    volts: Frame<Volts>,
    siemens: Frame<Siemens>,
    grams: Vec<f64>,
    /// Loads once what is remembered is taken off.
    felt: Vec<f64>,
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
        let options = ScreenOptions::from_spec(&sensor.screen);
        let mut screen = FrameScreen::new(rows, columns, sensor.max_count(), &options);
        screen.set_lines(&LineFaults::from_spec(&sensor.screen));
        let taxels = rows * columns;
        let gives_loads = method.gives_loads();
        Ok(Self {
            converter: Converter::from_sensor(sensor),
            screen,
            scratch: method.scratch(),
            method,
            law: match sensor.material {
                Some(_) => Some(LoadLaw::from_sensor(sensor)?),
                None => None,
            },
            spread: sensor
                .material
                .as_ref()
                .and_then(|material| material.spread)
                .filter(|_| !gives_loads)
                .map(Spread::new),
            memory: sensor
                .material
                .as_ref()
                .and_then(|material| material.dynamic.as_ref())
                .filter(|_| !gives_loads)
                .map(|spec| Memory::new(&DynamicLaw::from_spec(spec), taxels)),
            remembered: false,
            explained: true,
            repair: match sensor.screen.repair {
                true => Repair::Readings,
                false => Repair::Nothing,
            },
            counts: Frame::zeros(rows, columns),
            volts: Frame::zeros(rows, columns),
            siemens: Frame::zeros(rows, columns),
            grams: vec![0.0; taxels],
            felt: vec![0.0; taxels],
            undone: vec![0.0; taxels],
            work: vec![0.0; taxels],
            loads: Frame::zeros(rows, columns),
            around: Vec::with_capacity(taxels),
        })
    }

    /// Replaces what was not measured by the median of its neighbours, or not; the sensor file says otherwise.
    pub fn set_repair(&mut self, repair: Repair) {
        self.repair = repair;
    }

    /// Undoes the mechanical spread, or not; the sensor file says otherwise.
    pub fn set_spread(&mut self, spread: Option<Spread>) {
        self.spread = spread;
    }

    /// The name of the method.
    pub fn method_name(&self) -> &'static str {
        self.method.name()
    }

    /// Tells the screen which lines are faulty in this recording, beside those of the sensor file.
    pub fn set_lines(&mut self, faults: &LineFaults) {
        self.screen.set_lines(faults);
    }

    /// Makes the next frame start cold: where an inverse failed.
    pub fn forget(&mut self) {
        self.scratch.forget();
    }

    /// Makes the next frame the first: where a recording jumps, or another begins. What the material remembers is taken to
    /// be nothing.
    pub fn begin_anew(&mut self) {
        self.scratch.forget();
        if let Some(memory) = &mut self.memory {
            memory.forget();
        }
    }

    /// Screens, converts and solves one frame of counts. Marks it brings are kept.
    ///
    /// # Panics
    /// When the frame's shape is not the sensor's.
    pub fn siemens_from_counts(&mut self, counts: &Frame<Counts>) -> Outcome {
        self.counts.take_marks(counts);
        self.counts.values.copy_from_slice(counts.values());
        self.screen
            .mark(&mut self.counts)
            .expect("the frame has the sensor's shape");
        self.converter
            .volts_from_counts_into(&self.counts, &mut self.volts);
        self.solve()
    }

    /// Solves one frame of read-out volts: no screen, no converter.
    ///
    /// # Panics
    /// When the frame's shape is not the sensor's.
    pub fn siemens_from_volts(&mut self, volts: &Frame<Volts>) -> Outcome {
        self.volts.take_marks(volts);
        self.volts.values.copy_from_slice(volts.values());
        self.solve()
    }

    /// Takes a frame of conductances as it is, for the load law alone.
    ///
    /// # Panics
    /// When the frame's shape is not the sensor's.
    pub fn take_siemens(&mut self, siemens: &Frame<Siemens>) {
        self.siemens.take_marks(siemens);
        self.siemens.values.copy_from_slice(siemens.values());
        (self.remembered, self.explained) = (false, true);
    }

    fn solve(&mut self) -> Outcome {
        self.remembered = false;
        stand_in(&mut self.volts, &mut self.around);
        let outcome = self
            .method
            .solve_into(&self.volts, &mut self.siemens, &mut self.scratch);
        self.explained = !matches!(outcome.stop, Stop::Infeasible(_));
        // The stand-in served the rest of the network; for the taxel itself it is no measurement.
        for (value, mark) in self.siemens.values.iter_mut().zip(&self.siemens.marks) {
            if matches!(mark, Mark::Stuck | Mark::Spike) && self.repair == Repair::Nothing {
                *value = 0.0;
            }
        }
        outcome
    }

    /// The volts of the last frame.
    pub fn volts(&self) -> &Frame<Volts> {
        &self.volts
    }

    /// The conductances of the last frame, with the cross-talk removed; repaired where that was asked for.
    pub fn siemens(&mut self) -> &Frame<Siemens> {
        self.repair.run(&mut self.siemens, &mut self.around);
        &self.siemens
    }

    /// The loads of the last frame: spread undone, nothing below zero, repaired where that was asked for.
    ///
    /// # Errors
    /// [`Error::MissingKey`] when the sensor has no load law.
    pub fn newtons(&mut self) -> Result<&Frame<Newtons>, Error> {
        let Some(law) = &self.law else {
            return Err(Error::MissingKey {
                key: "material",
                hint: "run `taxel calibrate` to find the load law, or ask for --unit siemens"
                    .to_owned(),
            });
        };
        let columns = self.siemens.columns();
        self.loads.take_marks(&self.siemens);
        let lost = |mark: Mark| {
            matches!(
                mark,
                Mark::Open | Mark::Flickering | Mark::Stuck | Mark::Spike
            )
        };
        for (taxel, (grams, &siemens)) in
            self.grams.iter_mut().zip(self.siemens.values()).enumerate()
        {
            *grams = law.grams_from_siemens(taxel, siemens);
        }
        if let Some(memory) = &mut self.memory {
            if !self.remembered {
                let (marks, secs) = (&self.loads.marks, self.siemens.time_secs);
                // Numbers of a frame that nothing explains are none to remember.
                let explained = self.explained;
                let is_lost = |taxel: usize| !explained || lost(marks[taxel]);
                memory.loads_from_acting(secs, &mut self.grams, is_lost);
                self.felt.copy_from_slice(&self.grams);
                self.remembered = true;
            }
            self.grams.copy_from_slice(&self.felt);
        }
        if let Some(spread) = self.spread {
            // A lost taxel in the middle of a load would look like a hole that its neighbours fill.
            fill_lost(&mut self.loads, &mut self.grams, &mut self.around, lost);
            spread.undo(columns, &self.grams, &mut self.undone, &mut self.work);
            self.grams.copy_from_slice(&self.undone);
        }
        for ((load, grams), mark) in self
            .loads
            .values
            .iter_mut()
            .zip(&self.grams)
            .zip(&self.loads.marks)
        {
            *load = match lost(*mark) {
                true => 0.0,
                false => newtons_from_grams(grams.max(0.0)),
            };
        }
        self.repair.run(&mut self.loads, &mut self.around);
        Ok(&self.loads)
    }
}

/// Gives lost taxels the median load around them, for what is computed from neighbourhoods.
fn fill_lost(
    frame: &mut Frame<Newtons>,
    grams: &mut [f64],
    around: &mut Vec<f64>,
    lost: impl Fn(Mark) -> bool,
) {
    if !frame.marks.iter().any(|&mark| lost(mark)) {
        return;
    }
    frame.values.copy_from_slice(grams);
    crate::screen::fill(frame, around, lost);
    grams.copy_from_slice(&frame.values);
}
