//! The standard error of every conductance and load of a frame.

use super::known::Known;
use super::standard_errors;
use crate::circuit::{Circuit, Converter, LinearCircuit, OperatingPoint, ROUNDING_COUNTS};
use crate::frame::newtons_from_grams;
use crate::material::LoadLaw;
use crate::screen::Level;
use crate::{Error, Frame, Mark, Newtons, Sensor, Siemens};

/// The circuit and the load law, and what one reading is uncertain by.
///
/// Of a frame's numbers it gives the standard errors, infinite where nothing bounds the number: it was not measured, is
/// only a lower or an upper bound, or stands in a frame without an answer; 0 where there is no taxel. A good taxel whose conductance is uncertain by more than
/// itself is marked [`Mark::Unresolved`] in the marks that are handed in.
pub struct StandardErrors {
    point: Box<dyn OperatingPoint>,
    law: Option<LoadLaw>,
    sigma_volts: f64,
    noise_counts: f64,
    siemens: Frame<Siemens>,
    newtons: Frame<Newtons>,
    is_known: Vec<bool>,
    moved: Vec<f64>,
}

impl StandardErrors {
    /// For frames of a sensor; `level`: what a recording says of its noise.
    ///
    /// # Errors
    /// [`Error::MissingKey`] when a switch resistance is not known yet.
    pub fn new(sensor: &Sensor, level: Option<Level>) -> Result<Self, Error> {
        let declared = sensor.converter().noise_counts;
        let noise_counts = match (declared, level) {
            (Some(noise), _) => noise.hypot(ROUNDING_COUNTS),
            (None, Some(level)) => level.noise_counts,
            (None, None) => ROUNDING_COUNTS,
        };
        let (rows, columns) = (sensor.rows(), sensor.columns());
        Ok(Self {
            point: LinearCircuit::from_sensor(sensor)?.operating_point(),
            law: sensor
                .material()
                .map(|_| LoadLaw::from_sensor(sensor))
                .transpose()?,
            sigma_volts: noise_counts * Converter::from_sensor(sensor).lsb_volts(),
            noise_counts,
            siemens: Frame::zeros(rows, columns),
            newtons: Frame::zeros(rows, columns),
            is_known: vec![false; rows * columns],
            moved: vec![0.0; rows * columns],
        })
    }

    /// Standard deviation of a reading, counts: of the sensor file, else of the recording, else of rounding.
    pub fn noise_counts(&self) -> f64 {
        self.noise_counts
    }

    /// Of the conductances of a frame, siemens.
    ///
    /// # Panics
    /// When the frame's shape is not the sensor's, or there is not one mark a taxel.
    pub fn of_siemens(
        &mut self,
        siemens: &Frame<Siemens>,
        is_answer: bool,
        marks: &mut [Mark],
    ) -> &Frame<Siemens> {
        for (known, mark) in self.is_known.iter_mut().zip(marks.iter()) {
            *known = mark.is_no_unknown();
        }
        let mut known = Known {
            point: &mut *self.point,
            is_known: &self.is_known,
            moved: &mut self.moved,
        };
        let found = standard_errors(&mut known, siemens.values(), self.sigma_volts);
        let unbounded = || vec![f64::INFINITY; siemens.values().len()];
        let errors = found.map_or_else(|_| unbounded(), |(errors, _)| errors);
        for (taxel, (error, mark)) in errors.into_iter().zip(marks).enumerate() {
            let is_bounded = is_answer && matches!(*mark, Mark::Good | Mark::Unresolved);
            self.siemens.values_mut()[taxel] = if *mark == Mark::Absent {
                0.0
            } else if is_bounded && error.is_finite() {
                error
            } else {
                f64::INFINITY
            };
            if *mark == Mark::Good && (error.is_nan() || error > siemens.values()[taxel].abs()) {
                *mark = Mark::Unresolved;
            }
        }
        &self.siemens
    }

    /// Of the loads that the load law makes of these conductances, newtons: half of what it makes of one standard error
    /// up and down, since at no load a power law's slope alone would promise too much.
    ///
    /// # Errors
    /// [`Error::MissingKey`] when the sensor has no load law.
    ///
    /// # Panics
    /// As [`Self::of_siemens`].
    pub fn of_loads(
        &mut self,
        siemens: &Frame<Siemens>,
        is_answer: bool,
        marks: &mut [Mark],
    ) -> Result<&Frame<Newtons>, Error> {
        self.of_siemens(siemens, is_answer, marks);
        let law = self.law.as_ref().ok_or_else(LoadLaw::missing)?;
        let errors = self.siemens.values().iter().zip(siemens.values());
        let loads = self.newtons.values_mut().iter_mut().zip(errors);
        for (taxel, (load, (&error, &value))) in loads.enumerate() {
            *load = if marks[taxel] == Mark::Absent {
                0.0
            } else if error.is_finite() {
                let up = law.grams_from_siemens(taxel, value + error);
                let down = law.grams_from_siemens(taxel, value - error);
                newtons_from_grams((up - down) / 2.0)
            } else {
                f64::INFINITY
            };
        }
        Ok(&self.newtons)
    }
}
