//! The standard error of every number: the converter's noise carried through the inverse.

use std::path::Path;

use taxel::circuit::{Circuit, Converter, LinearCircuit, OperatingPoint, ROUNDING_COUNTS};
use taxel::frame::newtons_from_grams;
use taxel::material::LoadLaw;
use taxel::screen::Level;
use taxel::solve::standard_errors;
use taxel::{Frame, Mark, Sensor, Siemens};

use crate::error::Error;
use crate::frames::DisplayUnit;
use crate::units::Unit;

/// The circuit, and what one reading is uncertain by.
pub struct StandardErrors {
    point: Box<dyn OperatingPoint>,
    law: Option<LoadLaw>,
    unit: Unit,
    area_mm2: f64,
    sigma_volts: f64,
    /// Standard deviation of a reading, counts: of the sensor file, else of the recording, else of rounding.
    pub noise_counts: f64,
    errors: Frame<DisplayUnit>,
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
        let declared = sensor.converter().noise_counts;
        let noise_counts = match (declared, level) {
            (Some(noise), _) => noise.hypot(ROUNDING_COUNTS),
            (None, Some(level)) => level.noise_counts,
            (None, None) => ROUNDING_COUNTS,
        };
        let circuit = LinearCircuit::from_sensor(sensor).map_err(in_file)?;
        Ok(Self {
            point: circuit.operating_point(),
            law: if unit.is_load() {
                Some(LoadLaw::from_sensor(sensor).map_err(in_file)?)
            } else {
                None
            },
            unit,
            area_mm2: sensor.array().taxel_area_mm2,
            sigma_volts: noise_counts * Converter::from_sensor(sensor).lsb_volts(),
            noise_counts,
            errors: Frame::zeros(sensor.rows(), sensor.columns()),
        })
    }

    /// The standard errors of a frame's numbers, in their unit; a good taxel whose conductance is uncertain by
    /// more than itself is marked unresolved in `shown`. Infinite where nothing bounds the number: it was not measured,
    /// is only a lower bound, or stands in a frame without an answer.
    pub fn of(
        &mut self,
        siemens: &Frame<Siemens>,
        is_answer: bool,
        shown: &mut Frame<DisplayUnit>,
    ) -> &Frame<DisplayUnit> {
        let found = standard_errors(&mut *self.point, siemens.values(), self.sigma_volts);
        let unbounded = || vec![f64::INFINITY; siemens.values().len()];
        let errors = found.map_or_else(|_| unbounded(), |(errors, _)| errors);
        for (i, error) in errors.into_iter().enumerate() {
            let value = siemens.values()[i];
            let mark = &mut shown.marks_mut()[i];
            let is_bounded = is_answer && matches!(*mark, Mark::Good | Mark::Unresolved);
            self.errors.values_mut()[i] = if is_bounded && error.is_finite() {
                self.in_unit(i, value, error)
            } else {
                f64::INFINITY
            };
            if *mark == Mark::Good && (error.is_nan() || error > value.abs()) {
                *mark = Mark::Unresolved;
            }
        }
        &self.errors
    }

    /// Half of what the load law makes of one standard error up and down: at no load a power law's slope
    /// alone would promise too much.
    fn in_unit(&self, taxel: usize, siemens: f64, error: f64) -> f64 {
        let Some(law) = &self.law else {
            return error;
        };
        let up = law.grams_from_siemens(taxel, siemens + error);
        let down = law.grams_from_siemens(taxel, siemens - error);
        let newtons = newtons_from_grams((up - down) / 2.0);
        self.unit.of_newtons(newtons, self.area_mm2)
    }
}
