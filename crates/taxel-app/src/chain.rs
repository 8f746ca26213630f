//! From a frame that was read to numbers in the unit that was asked for.

use std::path::Path;

use taxel::calibrate::LoadLaw;
use taxel::circuit::Converter;
use taxel::pipeline::Pipeline;
use taxel::pipeline::Repair;
use taxel::screen::{FrameScreen, LineFaults, ScreenOptions, repair};
use taxel::solve::{Outcome, Stop};
use taxel::{Counts, Frame, Sensor, Siemens, Volts};

use crate::error::Error;
use crate::frames::{DisplayUnit, Reading};
use crate::methods::MethodName;
use crate::units::Unit;

/// Screen, converter, inverse, load law, as far as the unit needs them.
pub struct Chain {
    steps: Steps,
    unit: Unit,
    area_mm2: f64,
}

/// How far to go.
enum Steps {
    Convert(Box<Convert>),
    Solve(Box<Pipeline>),
}

/// Counts to volts, nothing solved.
struct Convert {
    screen: FrameScreen,
    converter: Converter,
    counts: Frame<Counts>,
    volts: Frame<Volts>,
    repair: bool,
    around: Vec<f64>,
}

impl Chain {
    /// For frames of a sensor; `file` is where the sensor comes from.
    pub fn new(sensor: &Sensor, file: &Path, name: &MethodName, unit: Unit) -> Result<Self, Error> {
        let in_file = |source| Error::InFile {
            file: file.to_owned(),
            source,
        };
        let steps = if unit == Unit::Volts {
            Steps::Convert(Box::new(Convert::new(sensor)))
        } else {
            let sensor = name.sensor(sensor);
            if unit.is_load() {
                LoadLaw::from_sensor(&sensor).map_err(in_file)?;
            }
            let method = name.open(&sensor, file)?;
            Steps::Solve(Box::new(Pipeline::new(&sensor, method).map_err(in_file)?))
        };
        Ok(Self {
            steps,
            unit,
            area_mm2: sensor.array.taxel_area_mm2,
        })
    }

    /// Tells it which lines are faulty.
    pub fn set_lines(&mut self, faults: &LineFaults) {
        match &mut self.steps {
            Steps::Convert(convert) => convert.screen.set_lines(faults),
            Steps::Solve(pipeline) => pipeline.set_lines(faults),
        }
    }

    /// Replaces what was not measured by the median of its neighbours, or not.
    pub fn set_repair(&mut self, repair: bool) {
        match &mut self.steps {
            Steps::Convert(convert) => convert.repair = repair,
            Steps::Solve(pipeline) => pipeline.set_repair(match repair {
                true => Repair::Everything,
                false => Repair::Nothing,
            }),
        }
    }

    /// Takes in the frame read last. What comes back says how the inverse went, where there was one.
    pub fn take(&mut self, reading: &Reading) -> Result<Option<Outcome>, Error> {
        let outcome = match (&mut self.steps, reading) {
            (Steps::Convert(convert), Reading::Counts(_, counts)) => {
                convert.take(counts)?;
                None
            }
            (Steps::Convert(convert), Reading::Volts(_, volts)) => {
                convert.volts.clone_from(volts);
                None
            }
            (Steps::Solve(pipeline), Reading::Counts(_, counts)) => {
                Some(pipeline.process(counts).outcome.clone())
            }
            (Steps::Solve(pipeline), Reading::Volts(_, volts)) => {
                Some(pipeline.process_volts(volts).outcome.clone())
            }
            (Steps::Solve(pipeline), Reading::Siemens(_, siemens)) => {
                pipeline.process_siemens(siemens);
                None
            }
            (Steps::Convert(_), Reading::Siemens(..)) => {
                return Err(Error::Request {
                    what: "volts cannot be had from siemens here".to_owned(),
                    hint: "simulate a scan of these conductances",
                });
            }
        };
        Ok(outcome)
    }

    /// The conductances of the frame taken in last, where they were solved for.
    pub fn siemens(&self) -> Option<&Frame<Siemens>> {
        match &self.steps {
            Steps::Convert(_) => None,
            Steps::Solve(pipeline) => Some(pipeline.result().siemens),
        }
    }

    /// The frame taken in last, in the unit asked for.
    pub fn show_into(&self, shown: &mut Frame<DisplayUnit>) -> Result<(), Error> {
        let unit = self.unit;
        match &self.steps {
            Steps::Convert(convert) => copy(&convert.volts, shown, |volts| volts),
            Steps::Solve(pipeline) if unit == Unit::Siemens => {
                copy(pipeline.result().siemens, shown, |siemens| siemens);
            }
            Steps::Solve(pipeline) => copy(pipeline.result().newtons()?, shown, |newtons| {
                unit.of_newtons(newtons, self.area_mm2)
            }),
        }
        Ok(())
    }
}

/// Why an inverse stopped, in a word; and in a sentence where it came to no answer.
pub fn stop_words(outcome: &Outcome) -> (&'static str, Option<String>) {
    let word = match &outcome.stop {
        Stop::Direct => return ("direct", None),
        Stop::Converged => return ("converged", None),
        Stop::Infeasible(why) => return ("infeasible", Some(why.to_string())),
        Stop::RoundLimit => "round-limit",
        Stop::Stalled => "stalled",
        _ => "other",
    };
    let why = format!(
        "{} rounds, residual {:.1e}; its numbers are those of the last round",
        outcome.rounds, outcome.residual
    );
    (word, Some(why))
}

fn copy<Q>(from: &Frame<Q>, to: &mut Frame<DisplayUnit>, number: impl Fn(f64) -> f64) {
    to.take_marks(from);
    for (to, from) in to.values_mut().iter_mut().zip(from.values()) {
        *to = number(*from);
    }
}

impl Convert {
    fn new(sensor: &Sensor) -> Self {
        let (rows, columns) = (sensor.rows(), sensor.columns());
        let options = ScreenOptions::from_sensor(sensor);
        let mut screen = FrameScreen::new(rows, columns, sensor.max_count(), &options);
        screen.set_lines(&LineFaults::from_spec(&sensor.screen));
        Self {
            screen,
            converter: Converter::from_sensor(sensor),
            counts: Frame::zeros(rows, columns),
            volts: Frame::zeros(rows, columns),
            repair: sensor.screen.repair,
            around: Vec::new(),
        }
    }

    fn take(&mut self, counts: &Frame<Counts>) -> Result<(), Error> {
        self.counts.clone_from(counts);
        self.screen.mark(&mut self.counts)?;
        self.converter
            .volts_from_counts_into(&self.counts, &mut self.volts);
        if self.repair {
            repair(&mut self.volts, &mut self.around);
        }
        Ok(())
    }
}
