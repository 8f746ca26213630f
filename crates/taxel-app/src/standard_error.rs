//! The standard error of every number, in the unit that was asked for.

use std::path::Path;

use taxel::material::LoadLaw;
use taxel::screen::Level;
use taxel::{Frame, Sensor, Siemens, uncertainty};

use crate::error::Error;
use crate::frames::DisplayUnit;
use crate::units::{LoadUnit, Unit};

/// What numbers of one unit are uncertain by.
pub struct StandardErrors {
    errors: uncertainty::StandardErrors,
    unit: Unit,
    load_unit: LoadUnit,
    /// Standard deviation of a reading, counts: of the sensor file, else of the recording, else of rounding.
    pub noise_counts: f64,
    in_unit: Frame<DisplayUnit>,
    /// The frame's loads, newtons.
    loads: Vec<f64>,
}

/// One part of the standard errors of loads.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Part {
    /// Noise and rounding of the readings.
    Noise,
    /// The fit: the loads' scale.
    Fit,
    /// What the model leaves unexplained.
    Model,
}

impl Part {
    /// All three.
    pub const ALL: [Part; 3] = [Part::Noise, Part::Fit, Part::Model];

    /// Its word in file names.
    pub fn word(self) -> &'static str {
        match self {
            Part::Noise => "noise",
            Part::Fit => "fit",
            Part::Model => "model",
        }
    }
}

impl StandardErrors {
    /// For frames of a sensor that comes from `file`; `level`: what a recording says of its noise.
    ///
    /// # Errors
    /// A sensor without a circuit, or without a load law where loads are asked for.
    pub fn new(
        sensor: &Sensor,
        file: &Path,
        unit: Unit,
        level: Option<Level>,
    ) -> Result<Self, Error> {
        let in_file = |source| Error::InFile {
            file: file.to_owned(),
            source,
        };
        let errors = uncertainty::StandardErrors::new(sensor, level).map_err(in_file)?;
        if unit.is_load() {
            LoadLaw::from_sensor(sensor).map_err(in_file)?;
        }
        Ok(Self {
            noise_counts: errors.noise_counts(),
            errors,
            unit,
            load_unit: LoadUnit::of(unit, sensor),
            in_unit: Frame::zeros(sensor.rows(), sensor.columns()),
            loads: vec![0.0; sensor.rows() * sensor.columns()],
        })
    }

    /// The standard errors of a frame's numbers, in their unit; a good taxel whose conductance is uncertain by
    /// more than itself is marked unresolved in `shown`. Infinite where nothing bounds the number: it was not measured,
    /// is only a lower bound, or stands in a frame without an answer.
    ///
    /// # Errors
    /// No load law where loads are asked for, which [`Self::new`] has refused.
    pub fn of(
        &mut self,
        siemens: &Frame<Siemens>,
        is_answer: bool,
        shown: &mut Frame<DisplayUnit>,
    ) -> Result<&Frame<DisplayUnit>, Error> {
        let to = self.in_unit.values_mut();
        if self.unit.is_load() {
            let loads = self.loads.iter_mut().zip(shown.values()).enumerate();
            loads.for_each(|(taxel, (load, shown))| *load = self.load_unit.newtons(taxel, *shown));
            let marks = shown.marks_mut();
            let errors = self
                .errors
                .of_loads(siemens, &self.loads, is_answer, marks)?;
            for (taxel, (to, newtons)) in to.iter_mut().zip(errors.values()).enumerate() {
                *to = self.load_unit.from_newtons(taxel, *newtons);
            }
        } else {
            let errors = self
                .errors
                .of_siemens(siemens, is_answer, shown.marks_mut());
            to.copy_from_slice(errors.values());
        }
        Ok(&self.in_unit)
    }

    /// The last frame's standard errors, in their unit.
    pub fn last(&self) -> &Frame<DisplayUnit> {
        &self.in_unit
    }

    /// Whether fit and model have a part in the errors of loads: whether the sensor file says so.
    pub fn knows_more_than_noise(&self) -> bool {
        self.unit.is_load() && self.errors.knows_more_than_noise()
    }

    /// Half-widths of 95 % intervals of the last frame's numbers, in their unit.
    pub fn half_widths_into(&self, half: &mut Frame<DisplayUnit>) {
        let factor = if self.unit.is_load() {
            self.errors.factor_95()
        } else {
            1.96
        };
        half.copy_meta_from(&self.in_unit);
        let all = half.values_mut().iter_mut().zip(self.in_unit.values());
        all.for_each(|(half, sigma)| *half = factor * sigma);
    }

    /// One part of the last frame's standard errors of loads, in their unit.
    pub fn part_into(&self, part: Part, out: &mut Frame<DisplayUnit>) {
        let parts = self.errors.parts();
        let newtons = match part {
            Part::Noise => &parts.noise,
            Part::Fit => &parts.fit,
            Part::Model => &parts.model,
        };
        out.copy_meta_from(&self.in_unit);
        let each = out.values_mut().iter_mut().zip(newtons.values());
        for (taxel, (out, newtons)) in each.enumerate() {
            *out = self.load_unit.from_newtons(taxel, *newtons);
        }
    }
}
