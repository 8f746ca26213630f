//! From counts to loads in one object: screen, convert, solve, load law, creep and hysteresis, spread; or to volts
//! alone, or to loads by an estimator.

mod loads;

use crate::circuit::Converter;
use crate::estimate::LoadEstimator;
use crate::frame::clear_where;
use crate::material::LoadLaw;
use crate::screen::{
    FrameScreen, LineFaults, LowerEnd, Surroundings, repair, repair_readings, stand_in,
};
use crate::sensor::{ScreenSpec, mark_absent};
use crate::solve::{Method, Outcome, Solver, Stop};
use crate::{Counts, Error, Frame, Mark, Newtons, Sensor, Siemens, Volts};
use loads::{FromSiemens, has_no_reading};

/// What is replaced by the median of its neighbours, and marked [`Mark::Interpolated`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
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
    fn run<Q>(self, frame: &mut Frame<Q>, around: &mut Surroundings) {
        match self {
            Repair::Nothing => 0,
            Repair::Readings => repair_readings(frame, around),
            Repair::Everything => repair(frame, around),
        };
    }
}

/// What one frame comes to: all of it belongs to that frame and was computed once.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct FrameResult<'a> {
    /// How the inverse went.
    pub outcome: &'a Outcome,
    /// What was read, volts.
    pub volts: &'a Frame<Volts>,
    /// Conductances with the cross-talk removed, siemens; repaired where that was asked for. `None` where none were
    /// solved for: of an estimator, and of a pipeline that ends at volts.
    pub siemens: Option<&'a Frame<Siemens>>,
    /// Loads with the spread undone, newtons; repaired where that was asked for. Not cut off at zero: noise about
    /// an unloaded taxel adds up to nothing in a sum. `None` where the sensor has no load law, and at volts.
    pub loads: Option<&'a Frame<Newtons>>,
}

impl<'a> FrameResult<'a> {
    /// The loads, newtons.
    ///
    /// # Errors
    /// [`Error::MissingKey`] when the sensor has no load law.
    pub fn newtons(&self) -> Result<&'a Frame<Newtons>, Error> {
        self.loads.ok_or_else(LoadLaw::missing)
    }
}

/// Everything that a stream of frames of one sensor needs, and their state; no allocation a frame.
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
    lower_end: Option<LowerEnd>,
    stage: Stage,
    /// What the sensor file says of its lines, whatever a recording shows.
    declared: ScreenSpec,
    repair: Repair,
    /// Crossings without a taxel; empty where there is one everywhere.
    absent: Vec<bool>,
    outcome: Outcome,
    has_siemens: bool,
    counts: Frame<Counts>,
    volts: Frame<Volts>,
    siemens: Frame<Siemens>,
    loads: Frame<Newtons>,
    around: Surroundings,
}

/// What comes after the volts.
enum Stage {
    Nothing,
    Solve {
        name: &'static str,
        solver: Box<dyn Solver>,
        material: Option<Box<FromSiemens>>,
    },
    Estimate(Box<dyn LoadEstimator>),
}

impl Pipeline {
    /// For one sensor and a method. Without a material it stops at conductances.
    ///
    /// # Errors
    /// [`Error::Knots`] when the bend of the load law has none.
    pub fn new(sensor: &Sensor, method: Box<dyn Method>) -> Result<Self, Error> {
        let material = sensor.material();
        let stage = Stage::Solve {
            name: method.name(),
            solver: method.solver(),
            material: material
                .map(|material| FromSiemens::new(sensor, material).map(Box::new))
                .transpose()?,
        };
        Ok(Self::ending_in(sensor, stage))
    }

    /// For one sensor and an estimator of its loads.
    pub fn with_estimator(sensor: &Sensor, estimator: Box<dyn LoadEstimator>) -> Self {
        Self::ending_in(sensor, Stage::Estimate(estimator))
    }

    /// For one sensor, of which nothing is solved: screened read-out volts.
    pub fn to_volts(sensor: &Sensor) -> Self {
        Self::ending_in(sensor, Stage::Nothing)
    }

    fn ending_in(sensor: &Sensor, stage: Stage) -> Self {
        let (rows, columns) = (sensor.rows(), sensor.columns());
        let mut screen = FrameScreen::from_sensor(sensor);
        screen.set_lines(&LineFaults::from_spec(sensor.screen()));
        let lower_end = match stage {
            Stage::Solve { .. } => LowerEnd::from_sensor(sensor),
            Stage::Nothing | Stage::Estimate(_) => None,
        };
        Self {
            converter: Converter::from_sensor(sensor),
            screen,
            lower_end,
            declared: sensor.screen().clone(),
            stage,
            repair: if sensor.screen().repair {
                Repair::Readings
            } else {
                Repair::Nothing
            },
            absent: sensor.absent().to_vec(),
            outcome: Outcome::new(Stop::Direct, 0, 0.0),
            has_siemens: false,
            counts: Frame::zeros(rows, columns),
            volts: Frame::zeros(rows, columns),
            siemens: Frame::zeros(rows, columns),
            loads: Frame::zeros(rows, columns),
            around: Surroundings::of_sensor(sensor),
        }
    }

    /// Replaces what was not measured by the median of its neighbours, or not; the sensor file says otherwise.
    pub fn set_repair(&mut self, repair: Repair) {
        self.repair = repair;
    }

    /// The name of the method or estimator; `none` where nothing is solved.
    pub fn method_name(&self) -> &'static str {
        match &self.stage {
            Stage::Nothing => "none",
            Stage::Solve { name, .. } => name,
            Stage::Estimate(estimator) => estimator.name(),
        }
    }

    /// Tells the screen which lines are faulty in this recording, beside those of the sensor file.
    pub fn set_lines(&mut self, faults: &LineFaults) {
        let all = faults.clone().with_declared(&self.declared);
        self.screen.set_lines(&all);
    }

    /// Makes the next frame the first: where a recording jumps, or another begins. What the material remembers is taken to
    /// be nothing.
    pub fn begin_anew(&mut self) {
        match &mut self.stage {
            Stage::Nothing => {}
            Stage::Solve {
                solver, material, ..
            } => {
                solver.forget();
                if let Some(material) = material {
                    material.forget();
                }
            }
            Stage::Estimate(estimator) => estimator.forget(),
        }
    }

    /// Screens, converts and solves one frame of counts, and finds its loads. Marks it brings are kept.
    ///
    /// # Panics
    /// When the frame's shape is not the sensor's.
    pub fn process(&mut self, counts: &Frame<Counts>) -> FrameResult<'_> {
        self.counts.copy_meta_from(counts);
        self.counts.values.copy_from_slice(counts.values());
        self.screen
            .mark(&mut self.counts)
            .expect("the frame has the sensor's shape");
        self.converter
            .volts_from_counts_into(&self.counts, &mut self.volts);
        self.lower_end
            .iter_mut()
            .for_each(|end| end.take(&self.counts));
        self.finish(true)
    }

    /// [`Self::process`] of a frame that a [`FrameScreen`] has marked: converts and solves it, and finds its loads. A screen
    /// remembers frames and sees all of a stream in order; this is most of the work, and may be shared out to several pipelines.
    ///
    /// # Panics
    /// When the frame's shape is not the sensor's.
    pub fn process_screened(&mut self, counts: &Frame<Counts>) -> FrameResult<'_> {
        self.converter
            .volts_from_counts_into(counts, &mut self.volts);
        self.lower_end.iter_mut().for_each(|end| end.take(counts));
        self.finish(true)
    }

    /// Whether loads hang on the frames before: the load law has creep or hysteresis. Such frames are for one pipeline, in
    /// order.
    pub fn remembers(&self) -> bool {
        match &self.stage {
            Stage::Nothing => false,
            Stage::Solve { material, .. } => {
                let material = material.as_ref();
                material.is_some_and(|material| material.remembers())
            }
            Stage::Estimate(_) => true,
        }
    }

    /// The same for one frame of read-out volts: no screen, no converter.
    ///
    /// # Panics
    /// When the frame's shape is not the sensor's.
    pub fn process_volts(&mut self, volts: &Frame<Volts>) -> FrameResult<'_> {
        self.volts.copy_meta_from(volts);
        self.volts.values.copy_from_slice(volts.values());
        mark_absent(&self.absent, &mut self.volts.marks);
        self.finish(false)
    }

    /// Takes a frame of conductances as it is, for the load law alone; an estimator has none.
    ///
    /// # Panics
    /// When the frame's shape is not the sensor's.
    pub fn process_siemens(&mut self, siemens: &Frame<Siemens>) -> FrameResult<'_> {
        self.siemens.copy_meta_from(siemens);
        self.siemens.values.copy_from_slice(siemens.values());
        mark_absent(&self.absent, &mut self.siemens.marks);
        clear_absent(&mut self.siemens);
        self.outcome = Outcome::new(Stop::Direct, 0, 0.0);
        self.has_siemens = true;
        self.find_loads();
        self.result()
    }

    /// The last frame's result again.
    pub fn result(&self) -> FrameResult<'_> {
        let is_estimate = matches!(self.stage, Stage::Estimate(_));
        let has_loads = self.has_loads() && !(is_estimate && self.has_siemens);
        FrameResult {
            outcome: &self.outcome,
            volts: &self.volts,
            siemens: self.has_siemens.then_some(&self.siemens),
            loads: has_loads.then_some(&self.loads),
        }
    }

    /// Whether frames of counts come to loads.
    pub fn has_loads(&self) -> bool {
        match &self.stage {
            Stage::Nothing => false,
            Stage::Solve { material, .. } => material.is_some(),
            Stage::Estimate(_) => true,
        }
    }

    /// Whether they come to conductances.
    pub fn has_siemens(&self) -> bool {
        matches!(self.stage, Stage::Solve { .. })
    }

    /// From the volts on.
    fn finish(&mut self, is_rounded: bool) -> FrameResult<'_> {
        self.has_siemens = matches!(self.stage, Stage::Solve { .. });
        match &self.stage {
            Stage::Nothing => {
                self.outcome = Outcome::new(Stop::Direct, 0, 0.0);
                clear_absent(&mut self.volts);
                self.repair.run(&mut self.volts, &mut self.around);
            }
            Stage::Solve { .. } => {
                self.solve(is_rounded);
                if is_rounded && self.has_stuck_at_lower_end() {
                    self.solve(is_rounded);
                }
                self.find_loads();
            }
            Stage::Estimate(_) => self.estimate(),
        }
        self.result()
    }

    /// Marks readings that the circuit leaves no load for; whether there are any.
    fn has_stuck_at_lower_end(&mut self) -> bool {
        let Some(lower_end) = self.lower_end.as_mut().filter(|_| self.outcome.is_answer()) else {
            return false;
        };
        let stuck = lower_end.unexplained(self.siemens.values(), self.screen.level());
        for &taxel in stuck {
            self.volts.marks[taxel] = Mark::Stuck;
        }
        !stuck.is_empty()
    }

    fn solve(&mut self, is_rounded: bool) {
        let Stage::Solve { solver, .. } = &mut self.stage else {
            return;
        };
        solver.set_rounded(is_rounded);
        stand_in(&mut self.volts, &mut self.around);
        self.outcome = solver.solve_into(&self.volts, &mut self.siemens);
        if !self.outcome.stop.is_good() {
            // An answer that is none is no start for the next frame.
            solver.forget();
            self.siemens.values.fill(0.0);
        }
        mark_unresolved(&self.outcome, &mut self.siemens.marks);
        // The stand-in served the rest of the network; for the taxel itself it is no measurement.
        clear_where(
            &mut self.siemens.values,
            &self.siemens.marks,
            Mark::is_stray,
        );
    }

    fn estimate(&mut self) {
        let Stage::Estimate(estimator) = &mut self.stage else {
            return;
        };
        stand_in(&mut self.volts, &mut self.around);
        self.outcome = estimator.estimate_into(&self.volts, &mut self.loads);
        if !self.outcome.stop.is_good() {
            estimator.forget();
            self.loads.values.fill(0.0);
        }
        mark_unresolved(&self.outcome, &mut self.loads.marks);
        clear_where(&mut self.loads.values, &self.loads.marks, has_no_reading);
        self.repair.run(&mut self.loads, &mut self.around);
    }

    fn find_loads(&mut self) {
        if let Stage::Solve {
            material: Some(material),
            ..
        } = &mut self.stage
        {
            let unexplained = !self.outcome.stop.is_good();
            self.loads.copy_meta_from(&self.siemens);
            material.find_loads(
                &self.siemens,
                unexplained,
                &mut self.loads,
                &mut self.around,
            );
            self.repair.run(&mut self.loads, &mut self.around);
        }
        self.repair.run(&mut self.siemens, &mut self.around);
    }
}

/// Marks what was measured where the frame has no answer.
fn mark_unresolved(outcome: &Outcome, marks: &mut [Mark]) {
    if outcome.is_answer() {
        return;
    }
    for mark in marks {
        if mark.is_measured() || *mark == Mark::Interpolated {
            *mark = Mark::Unresolved;
        }
    }
}

/// What crossings without a taxel read is the cross-talk of others, and a number of nothing.
fn clear_absent<Q>(frame: &mut Frame<Q>) {
    clear_where(&mut frame.values, &frame.marks, |mark| mark == Mark::Absent);
}
