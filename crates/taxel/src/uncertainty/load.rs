//! The standard error of every conductance and load of a frame.

use super::ceiling::AtCeiling;
use super::known::{Known, is_left_out};
use super::standard_errors;
use crate::circuit::{Circuit, Converter, OperatingPoint, ROUNDING_COUNTS, SensorCircuit};
use crate::frame::{grams_from_newtons, newtons_from_grams};
use crate::material::LoadLaw;
use crate::screen::Level;
use crate::sensor::UncertaintySpec;
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
    beyond: Option<UncertaintySpec>,
    parts: Parts,
    is_known: Vec<bool>,
    moved: Vec<f64>,
    /// Made for the first frame with readings at the ceiling: most streams have none.
    at_ceiling: Option<AtCeiling>,
}

/// What the standard errors of loads are made of, newtons; σ² is the sum of their squares.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Parts {
    /// Noise and rounding of the readings, through the inverse and the load law; infinite where nothing bounds the number.
    pub noise: Frame<Newtons>,
    /// The fit: the loads' scale, which all taxels share, and how loads spread to their neighbours.
    pub fit: Frame<Newtons>,
    /// What the model leaves unexplained.
    pub model: Frame<Newtons>,
}

/// Half-width of a 95 % interval in standard errors where noise is all that is known.
const NORMAL_95: f64 = 1.96;

/// Half-width of a 95 % interval in standard errors, by the calibration where it tells.
pub(super) fn factor_95_of(beyond: Option<&UncertaintySpec>) -> f64 {
    beyond.map_or(NORMAL_95, |beyond| beyond.factor_95)
}

/// Standard deviation of a reading, counts: of the sensor file, else of the recording, else of rounding.
pub(crate) fn noise_counts_of(sensor: &Sensor, level: Option<Level>) -> f64 {
    match (sensor.converter().noise_counts, level) {
        (Some(noise), _) => noise.hypot(ROUNDING_COUNTS),
        (None, Some(level)) => level.noise_counts,
        (None, None) => ROUNDING_COUNTS,
    }
}

/// Nobody knows how far to trust what another program has found.
pub(super) fn refuse_exported(sensor: &Sensor) -> Result<(), Error> {
    match sensor.exported() {
        Some(exported) => Err(Error::Exported {
            program: exported.program.clone(),
        }),
        None => Ok(()),
    }
}

/// What of a heavy neighbour's uncertainty a taxel shares: a part of its load that stands elsewhere stands here. Measured on
/// simulated sensors whose loads spread: with nothing of it 2.8 % of unloaded taxels are outside their intervals.
pub(super) const NEAR_SHARE: f64 = 0.06;

/// The heaviest load on the eight neighbours of a taxel.
pub(super) fn heaviest_near(loads: &[f64], columns: usize, taxel: usize) -> f64 {
    let rows = loads.len() / columns;
    let (row, column) = (taxel / columns, taxel % columns);
    let mut most = 0f64;
    for r in row.saturating_sub(1)..(row + 2).min(rows) {
        for c in column.saturating_sub(1)..(column + 2).min(columns) {
            if (r, c) != (row, column) {
                most = most.max(loads[r * columns + c].abs());
            }
        }
    }
    most
}

/// What a load is off by where its spread to the next rows, next columns and across the corners is off by `errors`, in the
/// unit of the loads: to first order a share that is too small leaves here what stands around, less what is taken from here.
pub(super) fn by_spread(errors: [f64; 3], loads: &[f64], columns: usize, taxel: usize) -> f64 {
    let (row, column) = ((taxel / columns) as isize, (taxel % columns) as isize);
    let rows = (loads.len() / columns) as isize;
    let at = |down: isize, right: isize| {
        let (r, c) = (row + down, column + right);
        let is_there = (0..rows).contains(&r) && (0..columns as isize).contains(&c);
        if is_there {
            loads[r as usize * columns + c as usize]
        } else {
            0.0
        }
    };
    let own = loads[taxel];
    let [to_row, to_column, across] = errors;
    let by_row = to_row * (at(-1, 0) + at(1, 0) - 2.0 * own);
    let by_column = to_column * (at(0, -1) + at(0, 1) - 2.0 * own);
    let around = at(-1, -1) + at(-1, 1) + at(1, -1) + at(1, 1);
    by_row.hypot(by_column).hypot(across * (around - 4.0 * own))
}

impl StandardErrors {
    /// For frames of a sensor; `level`: what a recording says of its noise.
    ///
    /// # Errors
    /// [`Error::Exported`] where another program has found the loads; [`Error::MissingKey`] when a switch resistance is not known yet.
    pub fn new(sensor: &Sensor, level: Option<Level>) -> Result<Self, Error> {
        refuse_exported(sensor)?;
        let noise_counts = noise_counts_of(sensor, level);
        let (rows, columns) = (sensor.rows(), sensor.columns());
        Ok(Self {
            point: SensorCircuit::from_sensor(sensor)?.operating_point(),
            law: sensor
                .material()
                .map(|_| LoadLaw::from_sensor(sensor))
                .transpose()?,
            sigma_volts: noise_counts * Converter::from_sensor(sensor).lsb_volts(),
            noise_counts,
            siemens: Frame::zeros(rows, columns),
            newtons: Frame::zeros(rows, columns),
            beyond: sensor.uncertainty().copied(),
            parts: Parts {
                noise: Frame::zeros(rows, columns),
                fit: Frame::zeros(rows, columns),
                model: Frame::zeros(rows, columns),
            },
            is_known: vec![false; rows * columns],
            moved: vec![0.0; rows * columns],
            at_ceiling: None,
        })
    }

    /// Standard deviation of a reading, counts: of the sensor file, else of the recording, else of rounding.
    pub fn noise_counts(&self) -> f64 {
        self.noise_counts
    }

    /// Whether more than noise is known: a calibration has told what fit and model leave.
    pub fn knows_more_than_noise(&self) -> bool {
        self.beyond.is_some()
    }

    /// Half-width of an interval that holds 95 % of loads, in their standard errors.
    pub fn factor_95(&self) -> f64 {
        factor_95_of(self.beyond.as_ref())
    }

    /// What the last frame's standard errors of loads are made of.
    pub fn parts(&self) -> &Parts {
        &self.parts
    }

    /// Of the conductances of a frame, siemens. What readings at the converter's ceiling may be larger by is in the errors of
    /// the others.
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
            *known = is_left_out(*mark) || *mark == Mark::Saturated;
        }
        let mut known = Known {
            point: &mut *self.point,
            is_known: &self.is_known,
            moved: &mut self.moved,
        };
        let found = standard_errors(&mut known, siemens.values(), self.sigma_volts);
        let unbounded = || vec![f64::INFINITY; siemens.values().len()];
        let is_found = found.is_ok();
        let mut errors = found.map_or_else(|_| unbounded(), |(errors, _)| errors);
        // Where nothing was found the point stands nowhere.
        if is_found && marks.contains(&Mark::Saturated) {
            let at_ceiling = self
                .at_ceiling
                .get_or_insert_with(|| AtCeiling::new(errors.len()));
            let above = at_ceiling.errors(&mut known, siemens.values(), marks);
            for (error, above) in errors.iter_mut().zip(above) {
                *error = error.hypot(*above);
            }
        }
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

    /// Of loads found from these conductances, newtons. The part of noise is half of what the load law makes of one standard
    /// error up and down, since at no load a power law's slope alone would promise too much. Where the sensor file says
    /// it, fit and model have a part as well.
    ///
    /// # Errors
    /// [`Error::MissingKey`] when the sensor has no load law.
    ///
    /// # Panics
    /// As [`Self::of_siemens`], and when there is not one load a taxel.
    pub fn of_loads(
        &mut self,
        siemens: &Frame<Siemens>,
        loads: &[f64],
        is_answer: bool,
        marks: &mut [Mark],
    ) -> Result<&Frame<Newtons>, Error> {
        self.of_siemens(siemens, is_answer, marks);
        let law = self.law.as_ref().ok_or_else(LoadLaw::missing)?;
        let errors = self.siemens.values().iter().zip(siemens.values());
        let Parts { noise, fit, model } = &mut self.parts;
        for (taxel, (noise, (&error, &value))) in
            noise.values_mut().iter_mut().zip(errors).enumerate()
        {
            *noise = if marks[taxel] == Mark::Absent {
                0.0
            } else if error.is_finite() {
                let up = law.grams_from_siemens(taxel, value + error);
                let down = law.grams_from_siemens(taxel, value - error);
                newtons_from_grams((up - down) / 2.0)
            } else {
                f64::INFINITY
            };
        }
        if let Some(beyond) = self.beyond {
            let columns = siemens.columns();
            let parts = fit.values_mut().iter_mut().zip(model.values_mut());
            for (taxel, ((fit, model), mark)) in parts.zip(marks.iter()).enumerate() {
                (*fit, *model) = (0.0, 0.0);
                if *mark != Mark::Absent {
                    let own = loads[taxel].abs();
                    let near = NEAR_SHARE * heaviest_near(loads, columns, taxel);
                    let (own, near) = (grams_from_newtons(own), grams_from_newtons(near));
                    let spread = beyond
                        .spread_error
                        .map_or(0.0, |errors| by_spread(errors, loads, columns, taxel));
                    *fit = newtons_from_grams(beyond.fit_g(own)).hypot(spread);
                    *model = newtons_from_grams(beyond.model_beside_g(own, near));
                }
            }
        }
        let parts = noise
            .values()
            .iter()
            .zip(fit.values().iter().zip(model.values()));
        for (sigma, (noise, (fit, model))) in self.newtons.values_mut().iter_mut().zip(parts) {
            *sigma = noise.hypot(fit.hypot(*model));
        }
        Ok(&self.newtons)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::Spread;

    /// Against a spread that is undone with a share that is a little off: a lone load, an even contact, the edge.
    #[test]
    fn a_wrong_spread_leaves_what_it_says() {
        let (rows, columns) = (7, 8);
        let mut loads = vec![0.0; rows * columns];
        loads[2 * columns + 2] = 600.0;
        for row in 4..7 {
            for column in 4..8 {
                loads[row * columns + column] = 100.0;
            }
        }
        let truth = [0.004, 0.003, 0.001];
        let off = 5e-4;
        for which in 0..3 {
            let mut errors = [0.0; 3];
            errors[which] = off;
            let mut wrong = truth;
            wrong[which] += off;
            let (mut acting, mut found) = (loads.clone(), loads.clone());
            Spread::new(truth).apply(columns, &loads, &mut acting);
            let mut work = vec![0.0; loads.len()];
            Spread::new(wrong).undo(columns, &[], &acting, &mut found, &mut work);
            for taxel in 0..loads.len() {
                let says = by_spread(errors, &loads, columns, taxel);
                let is = (found[taxel] - loads[taxel]).abs();
                assert!(
                    (says - is).abs() < 0.03 * says.max(600.0 * off),
                    "{which} {taxel}: {says} {is}"
                );
            }
        }
        // A press that stands alone: 600 g · 0.0005 beside it, twice that on it.
        let says = |taxel| by_spread([off, 0.0, 0.0], &loads, columns, taxel);
        assert!(
            (says(columns + 2) - 0.3).abs() < 1e-12 && (says(2 * columns + 2) - 0.6).abs() < 1e-12
        );
    }
}
