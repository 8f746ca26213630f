//! The standard error of every number, in the unit that was asked for.

use std::path::Path;

use taxel::material::LoadLaw;
use taxel::screen::Level;
use taxel::{Frame, Sensor, Siemens, uncertainty};

use crate::error::Error;
use crate::frames::DisplayUnit;
use crate::units::Unit;

/// What numbers of one unit are uncertain by.
pub struct StandardErrors {
    errors: uncertainty::StandardErrors,
    unit: Unit,
    area_mm2: f64,
    /// Standard deviation of a reading, counts: of the sensor file, else of the recording, else of rounding.
    pub noise_counts: f64,
    in_unit: Frame<DisplayUnit>,
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
            area_mm2: sensor.array().taxel_area_mm2,
            in_unit: Frame::zeros(sensor.rows(), sensor.columns()),
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
        let marks = shown.marks_mut();
        let to = self.in_unit.values_mut();
        if self.unit.is_load() {
            let errors = self.errors.of_loads(siemens, is_answer, marks)?;
            for (to, &newtons) in to.iter_mut().zip(errors.values()) {
                *to = self.unit.of_newtons(newtons, self.area_mm2);
            }
        } else {
            let errors = self.errors.of_siemens(siemens, is_answer, marks);
            to.copy_from_slice(errors.values());
        }
        Ok(&self.in_unit)
    }
}
