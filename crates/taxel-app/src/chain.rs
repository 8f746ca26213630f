//! From a frame that was read to numbers in the unit that was asked for.

use std::path::Path;

use taxel::material::LoadLaw;
use taxel::pipeline::{Pipeline, Repair};
use taxel::screen::LineFaults;
use taxel::solve::{Outcome, Stop};
use taxel::{Counts, Frame, Newtons, Sensor, Siemens, Volts};

use crate::error::{Error, remedy};
use crate::exported::exported_words;
use crate::frames::{DisplayUnit, FrameReader};
use crate::methods::MethodName;
use crate::units::{LoadUnit, Unit};

/// A pipeline, as far as the unit needs it.
pub struct Chain {
    pipeline: Pipeline,
    unit: Unit,
    load_unit: LoadUnit,
}

impl Chain {
    /// For frames of a sensor; `file` is where the sensor comes from.
    ///
    /// # Errors
    /// What the unit needs is not known of the sensor; a method that does not suit it, or does not give the unit.
    pub fn new(sensor: &Sensor, file: &Path, name: &MethodName, unit: Unit) -> Result<Self, Error> {
        if let Some(what) = exported_words(sensor).filter(|_| sensor.material().is_none())
            && unit.is_load()
        {
            return Err(Error::Request {
                what: format!("{}: {what}", file.display()),
                hint: "the numbers as they are can be converted, to .npy or to .csv",
            });
        }
        if unit.is_load() && !name.is_model() {
            LoadLaw::from_sensor(sensor).map_err(|source| Error::InFile {
                file: file.to_owned(),
                source,
            })?;
        }
        if unit == Unit::Siemens && name.is_model() {
            return Err(Error::Request {
                what: format!("{name} estimates loads, not conductances"),
                hint: "ask for loads, or for another method",
            });
        }
        Ok(Self {
            pipeline: if unit == Unit::Volts {
                Pipeline::to_volts(sensor)
            } else {
                name.pipeline(sensor, file)?
            },
            unit,
            load_unit: LoadUnit::of(unit, sensor),
        })
    }

    /// The method's name.
    pub fn method_name(&self) -> &'static str {
        self.pipeline.method_name()
    }

    /// Loads of taxels in its unit.
    pub fn load_unit(&self) -> &LoadUnit {
        &self.load_unit
    }

    /// Tells it which lines are faulty.
    pub fn set_lines(&mut self, faults: &LineFaults) {
        self.pipeline.set_lines(faults);
    }

    /// Replaces what was not measured by the median of its neighbours, or not.
    pub fn set_repair(&mut self, repair: bool) {
        self.pipeline.set_repair(if repair {
            Repair::Everything
        } else {
            Repair::Nothing
        });
    }

    /// Takes in the frame read last. What comes back says how the inverse went, where there was one.
    ///
    /// # Errors
    /// Conductances, where they are not what the chain begins with.
    pub fn take(&mut self, reading: &FrameReader) -> Result<Option<Outcome>, Error> {
        Ok(match reading {
            FrameReader::Counts(_, counts) => {
                let result = self.pipeline.process(counts);
                (self.unit != Unit::Volts).then(|| result.outcome.clone())
            }
            FrameReader::Volts(_, volts) => self.take_volts(volts),
            FrameReader::Siemens(_, siemens) => {
                self.take_siemens(siemens)?;
                None
            }
        })
    }

    /// [`Self::take`] of counts that a screen has marked.
    pub fn take_screened(&mut self, counts: &Frame<Counts>) -> Option<Outcome> {
        let result = self.pipeline.process_screened(counts);
        (self.unit != Unit::Volts).then(|| result.outcome.clone())
    }

    /// [`Self::take`] of volts.
    pub fn take_volts(&mut self, volts: &Frame<Volts>) -> Option<Outcome> {
        let result = self.pipeline.process_volts(volts);
        (self.unit != Unit::Volts).then(|| result.outcome.clone())
    }

    /// [`Self::take`] of conductances.
    ///
    /// # Errors
    /// Where they are not what the chain begins with.
    pub fn take_siemens(&mut self, siemens: &Frame<Siemens>) -> Result<(), Error> {
        let result = self.pipeline.process_siemens(siemens);
        if self.unit == Unit::Volts {
            return Err(Error::Request {
                what: "volts cannot be had from siemens here".to_owned(),
                hint: remedy::SCAN,
            });
        }
        if self.unit.is_load() && result.loads.is_none() {
            return Err(Error::Request {
                what: "a model estimates loads from what was read, not from siemens".to_owned(),
                hint: "without a model, the sensor's load law is used",
            });
        }
        Ok(())
    }

    /// Makes the next frame the first.
    pub fn begin_anew(&mut self) {
        self.pipeline.begin_anew();
    }

    /// Whether loads hang on the frames before.
    pub fn remembers(&self) -> bool {
        self.pipeline.remembers()
    }

    /// The conductances of the frame taken in last, where they were solved for.
    pub fn siemens(&self) -> Option<&Frame<Siemens>> {
        self.pipeline.result().siemens
    }

    /// What was read of the frame taken in last, volts, where it was not taken as conductances.
    pub fn volts(&self) -> &Frame<Volts> {
        self.pipeline.result().volts
    }

    /// The pipeline by itself.
    pub(crate) fn into_pipeline(self) -> Pipeline {
        self.pipeline
    }

    /// The loads of the frame taken in last, newtons, where there are any.
    pub fn loads(&self) -> Option<&Frame<Newtons>> {
        self.pipeline.result().loads
    }

    /// The frame taken in last, in the unit asked for.
    ///
    /// # Errors
    /// No load law where loads are asked for.
    pub fn show_into(&self, shown: &mut Frame<DisplayUnit>) -> Result<(), Error> {
        let (unit, result) = (self.unit, self.pipeline.result());
        match result.siemens.filter(|_| unit == Unit::Siemens) {
            Some(siemens) => copy(siemens, shown),
            None if unit == Unit::Volts => copy(result.volts, shown),
            None => {
                let loads = result.newtons()?;
                shown.copy_meta_from(loads);
                let unit = &self.load_unit;
                unit.all_from_newtons(loads.values(), shown.values_mut());
            }
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
        Stop::IterationLimit => "round-limit",
        Stop::Stalled => "stalled",
        _ => "other",
    };
    let why = format!(
        "{} iterations, residual {:.1e}; its numbers are those of the last one",
        outcome.iterations, outcome.residual
    );
    (word, Some(why))
}

fn copy<Q>(from: &Frame<Q>, to: &mut Frame<DisplayUnit>) {
    to.copy_meta_from(from);
    to.values_mut().copy_from_slice(from.values());
}
