//! The standard error of every conductance and load of a frame.

use super::beside::{Beside, by_spread};
use super::conductance::{DEPTH, RESTARTS, standard_errors_beside_belief};
use super::known::{Known, is_left_out};
use super::sheet_doubt::SheetDoubt;
use super::standard_errors;
use super::unmeasured::Unmeasured;
use crate::circuit::{
    Circuit, Converter, LineResistance, OperatingPoint, ROUNDING_COUNTS, SensorCircuit,
};
use crate::frame::{grams_from_newtons, newtons_from_grams};
use crate::material::LoadLaw;
use crate::screen::Level;
use crate::sensor::UncertaintySpec;
use crate::solve::gmres::Gmres;
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
    beside: Beside,
    parts: Parts,
    is_known: Vec<bool>,
    moved: Vec<f64>,
    /// Conductances one standard error off, and the loads that they stand for, grams.
    off: Vec<f64>,
    up: Vec<f64>,
    down: Vec<f64>,
    sheet: Option<BySheet>,
    /// Made for the first frame with readings at the ceiling: most streams have none.
    unmeasured: Option<Unmeasured>,
    with_lost: bool,
    /// Whether lines resist: then readings may tell nothing of far taxels.
    has_lines: bool,
}

/// What conductances are off by where the law of the sheet is.
struct BySheet {
    doubt: SheetDoubt,
    gmres: Gmres,
    siemens: Vec<f64>,
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

/// The largest conductance that is expected at least where lines resist, siemens.
const EXPECTED_SIEMENS: f64 = 2e-3;

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
            beside: Beside::new(sensor),
            parts: Parts {
                noise: Frame::zeros(rows, columns),
                fit: Frame::zeros(rows, columns),
                model: Frame::zeros(rows, columns),
            },
            is_known: vec![false; rows * columns],
            moved: vec![0.0; rows * columns],
            off: vec![0.0; rows * columns],
            up: vec![0.0; rows * columns],
            down: vec![0.0; rows * columns],
            sheet: SheetDoubt::new(sensor)?.map(|doubt| BySheet {
                doubt,
                gmres: Gmres::new(rows * columns, DEPTH.min(rows * columns)),
                siemens: vec![0.0; rows * columns],
            }),
            unmeasured: None,
            with_lost: sensor.readout().has_open_columns(),
            has_lines: LineResistance::from_sensor(sensor).is_some_and(|lines| !lines.is_nothing()),
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

    /// Of the conductances of a frame, siemens. What readings at the converter's ceiling may be larger by, and
    /// lost ones where lines are left open, is in the errors of the others.
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
        let found = if self.has_lines {
            let good = siemens.values().iter().zip(marks.iter());
            let good = good.filter(|(_, mark)| **mark == Mark::Good);
            let most = good.fold(EXPECTED_SIEMENS, |most: f64, (value, _)| most.max(*value));
            standard_errors_beside_belief(&mut known, siemens.values(), self.sigma_volts, most)
        } else {
            standard_errors(&mut known, siemens.values(), self.sigma_volts).map(|found| found.0)
        };
        let unbounded = || vec![f64::INFINITY; siemens.values().len()];
        let is_found = found.is_ok();
        let mut errors = found.unwrap_or_else(|_| unbounded());
        // Where nothing was found the point stands nowhere.
        let is_bound =
            |mark: &Mark| *mark == Mark::Saturated || self.with_lost && is_left_out(*mark);
        if is_found && marks.iter().any(is_bound) {
            let new = || Unmeasured::new(errors.len(), self.with_lost);
            let unmeasured = self.unmeasured.get_or_insert_with(new);
            let squares = unmeasured.squares(&mut known, siemens, marks);
            for (error, square) in errors.iter_mut().zip(squares) {
                *error = error.hypot(square.sqrt());
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
        self.find_parts(siemens, loads, marks)?;
        if is_answer {
            self.add_sheet(siemens, marks)?;
        }
        let Parts { noise, fit, model } = &self.parts;
        let parts = noise
            .values()
            .iter()
            .zip(fit.values().iter().zip(model.values()));
        for (sigma, (noise, (fit, model))) in self.newtons.values_mut().iter_mut().zip(parts) {
            *sigma = (noise * noise + fit * fit + model * model).sqrt();
        }
        Ok(&self.newtons)
    }

    /// Noise, fit and model, but for what the law of a sheet is off by.
    fn find_parts(
        &mut self,
        siemens: &Frame<Siemens>,
        loads: &[f64],
        marks: &[Mark],
    ) -> Result<(), Error> {
        let law = self.law.as_ref().ok_or_else(LoadLaw::missing)?;
        let errors = self.siemens.values();
        let Parts { noise, fit, model } = &mut self.parts;
        for (one_error, grams) in [(1.0, &mut self.up), (-1.0, &mut self.down)] {
            let both = siemens.values().iter().zip(errors);
            for (off, (value, error)) in self.off.iter_mut().zip(both) {
                *off = value + one_error * error;
            }
            law.grams_of_frame(&self.off, grams);
        }
        let each = noise.values_mut().iter_mut().zip(marks.iter()).zip(errors);
        for (((noise, mark), error), (up, down)) in each.zip(self.up.iter().zip(&self.down)) {
            *noise = match mark {
                Mark::Absent => 0.0,
                _ if error.is_finite() => newtons_from_grams((up - down) / 2.0),
                _ => f64::INFINITY,
            };
        }
        if let Some(beyond) = self.beyond {
            let columns = siemens.columns();
            let near = self.beside.of(loads);
            let parts = fit.values_mut().iter_mut().zip(model.values_mut());
            for (taxel, ((fit, model), mark)) in parts.zip(marks.iter()).enumerate() {
                (*fit, *model) = (0.0, 0.0);
                if *mark != Mark::Absent {
                    let own = loads[taxel].abs();
                    let (own, near) = (grams_from_newtons(own), grams_from_newtons(near[taxel]));
                    let spread = beyond
                        .spread_error
                        .map_or(0.0, |errors| by_spread(errors, loads, columns, taxel));
                    *fit = newtons_from_grams(beyond.fit_g(own)).hypot(spread);
                    *model = newtons_from_grams(beyond.model_beside_g(own, near));
                }
            }
        }
        Ok(())
    }

    /// What loads are off by where the law of the sheet is, beside what the model leaves unexplained.
    fn add_sheet(&mut self, siemens: &Frame<Siemens>, marks: &[Mark]) -> Result<(), Error> {
        let Some(sheet) = &mut self.sheet else {
            return Ok(());
        };
        let law = self.law.as_ref().ok_or_else(LoadLaw::missing)?;
        let values = siemens.values();
        let Ok(changes) = sheet.doubt.look_at(&*self.point, values, &self.is_known) else {
            let each = self.parts.model.values_mut().iter_mut().zip(marks);
            for (model, _) in each.filter(|(_, mark)| **mark != Mark::Absent) {
                *model = f64::INFINITY;
            }
            return Ok(());
        };
        let mut known = Known {
            point: &mut *self.point,
            is_known: &self.is_known,
            moved: &mut self.moved,
        };
        let apply = |v: &[f64], out: &mut [f64]| known.jvp_into(v, out);
        sheet
            .gmres
            .solve(apply, changes, &mut sheet.siemens, 1e-3, RESTARTS);
        for (sign, grams) in [(1.0, &mut self.up), (-1.0, &mut self.down)] {
            let both = values.iter().zip(&sheet.siemens);
            for (off, (value, moved)) in self.off.iter_mut().zip(both) {
                *off = value + sign * moved;
            }
            law.grams_of_frame(&self.off, grams);
        }
        let each = self.parts.model.values_mut().iter_mut().zip(marks);
        for ((model, mark), (up, down)) in each.zip(self.up.iter().zip(&self.down)) {
            if *mark != Mark::Absent {
                *model = model.hypot(newtons_from_grams((up - down) / 2.0));
            }
        }
        Ok(())
    }
}
