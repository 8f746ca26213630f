//! How far to trust what a frame amounts to: total force, contact area, centre of pressure.
//!
//! Errors of taxels hang together: noise through the lines, the fit through the scale, the model through what a frame shares.
//! So each figure is taken for what it is, a sum of loads with weights, and its errors are found for the whole of it.

mod area;
mod grip;

use super::beside::Beside;
use super::detached::Detached;
use super::known::{Known, is_left_out, scatter_around};
use super::load::{factor_95_of, noise_counts_of, refuse_exported};
use super::sheet_doubt::SheetDoubt;
use super::{Adjoint, Bias, least_error_siemens, set_passive};
use crate::circuit::{Circuit, Converter, OperatingPoint, SensorCircuit};
use crate::frame::{grams_from_newtons, newtons_from_grams};
use crate::material::{LoadLaw, Spread};
use crate::metric::{CONTACT_NEWTONS, GripForce, is_usable, mean_direction};
use crate::screen::Level;
use crate::sensor::{Region, Rings, UncertaintySpec};
use crate::{Error, Frame, Mark, Newtons, Sensor, Siemens};

/// What one figure is uncertain by, in its unit; σ² is the sum of the squares of the parts.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub struct FigureError {
    /// Noise and rounding of the readings.
    pub noise: f64,
    /// The fit: the loads' scale, which all taxels share.
    pub fit: f64,
    /// What the model leaves unexplained: what all taxels of a frame share, and what each is off by itself.
    pub model: f64,
    /// Half the width of its 95 % interval; infinite where nothing bounds it.
    pub half_width_95: f64,
}

impl FigureError {
    /// One standard error.
    pub fn standard_error(&self) -> f64 {
        self.noise.hypot(self.fit.hypot(self.model))
    }

    fn unbounded() -> Self {
        Self {
            noise: f64::INFINITY,
            half_width_95: f64::INFINITY,
            ..Self::default()
        }
    }
}

/// What the figures of a frame are uncertain by; the figures are those of [`crate::metric::FrameFigures`].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub struct FrameFigureErrors {
    /// Of the sum of all loads that count, newtons.
    pub total_force_newtons: FigureError,
    /// Of the grip force of a handle, newtons,
    pub grip_newtons: Option<FigureError>,
    /// and of its direction, radians; a quarter of a turn where nothing is known of it.
    pub grip_direction: Option<FigureError>,
    /// Of the contact area, mm².
    pub contact_area_mm2: FigureError,
    /// Of the centre of pressure, mm, in the order of `centre_mm`. `None` when nothing touches.
    pub centre_mm: Option<[FigureError; 2]>,
}

/// The errors of figures, frame by frame; of the frame looked at, whatever its taxels share.
///
/// What stands on taxels that were not measured is in neither a figure nor its error; a load below what a recorder keeps
/// counts as none.
pub struct FigureErrors {
    point: Box<dyn OperatingPoint>,
    adjoint: Adjoint,
    law: LoadLaw,
    spread: Option<Spread>,
    beside: Beside,
    beyond: Option<UncertaintySpec>,
    sheet: Option<SheetDoubt>,
    /// Where lines are left open, what taxels of those that are out may add to readings.
    detached: Option<Detached>,
    sigma_volts: f64,
    sensor: Sensor,
    is_looked_at: bool,
    /// What noise has added to each load, where that is known.
    bias: Option<Bias>,
    /// Load above which a taxel counts as touched, newtons.
    threshold_newtons: f64,
    /// Where each taxel lies: across the rows and across the columns, mm.
    places_mm: Vec<[f64; 2]>,
    is_known: Vec<bool>,
    moved: Vec<f64>,
    /// Newtons that one siemens makes, per taxel; 0 where no reading stands behind the load.
    slope: Vec<f64>,
    /// Noise of each load at least, newtons.
    noise: Vec<f64>,
    /// What each load is off by itself, newtons.
    own: Vec<f64>,
    weights: Vec<f64>,
    /// Directions that may be that of the grip force as well.
    rivals: Vec<GripForce>,
    right: Vec<f64>,
    work: Vec<f64>,
}

impl FigureErrors {
    /// For frames of a sensor; `level`: what a recording says of its noise.
    ///
    /// # Errors
    /// [`Error::Exported`] where another program has found the loads; [`Error::MissingKey`] when a switch resistance or the load law is not known yet.
    pub fn new(sensor: &Sensor, level: Option<Level>) -> Result<Self, Error> {
        refuse_exported(sensor)?;
        let material = sensor.material().ok_or_else(LoadLaw::missing)?;
        let taxels = sensor.rows() * sensor.columns();
        // Round a handle it is the circular mean, which asks for angles.
        let place = |taxel: usize| match sensor.handle() {
            Some(handle) => [handle.step_mm * handle.ring_and_line(taxel).0 as f64; 2],
            None => sensor.place_mm(taxel),
        };
        let none = || vec![0.0; taxels];
        Ok(Self {
            point: SensorCircuit::from_sensor(sensor)?.operating_point(),
            adjoint: Adjoint::new(taxels),
            law: LoadLaw::from_sensor(sensor)?,
            spread: material.spread.map(Spread::new),
            beside: Beside::new(sensor),
            beyond: sensor.uncertainty().copied(),
            sheet: SheetDoubt::new(sensor)?,
            detached: sensor
                .readout()
                .has_open_columns()
                .then(|| Detached::new(taxels)),
            sigma_volts: noise_counts_of(sensor, level)
                * Converter::from_sensor(sensor).lsb_volts(),
            sensor: sensor.clone(),
            is_looked_at: false,
            bias: None,
            threshold_newtons: CONTACT_NEWTONS,
            places_mm: (0..taxels).map(place).collect(),
            is_known: vec![false; taxels],
            moved: none(),
            slope: none(),
            noise: none(),
            own: none(),
            weights: none(),
            rivals: Vec::new(),
            right: none(),
            work: vec![0.0; Spread::room(taxels, sensor.columns())],
        })
    }

    /// With another load above which a taxel counts as touched, newtons; 0.05 otherwise.
    pub fn with_threshold(mut self, newtons: f64) -> Self {
        self.threshold_newtons = newtons;
        self
    }

    /// Whether more than noise is known: a calibration has told what fit and model leave.
    pub fn knows_more_than_noise(&self) -> bool {
        self.beyond.is_some()
    }

    /// What noise has added to the loads of the frame that is looked at next ([`super::NoiseBias`]), taken off them before they
    /// are summed: then the sums are uncertain by how far its draws are apart, and by what it cannot tell.
    pub fn set_bias(&mut self, bias: Option<&Bias>) {
        match (&mut self.bias, bias) {
            (Some(own), Some(bias)) => own.clone_from(bias),
            (own, bias) => *own = bias.cloned(),
        }
    }

    /// Of one frame: its conductances, and the loads found from them.
    ///
    /// # Panics
    /// When a frame's shape is not the sensor's.
    pub fn of(
        &mut self,
        siemens: &Frame<Siemens>,
        loads: &Frame<Newtons>,
        is_answer: bool,
    ) -> FrameFigureErrors {
        let threshold = self.threshold_newtons;
        let touches = |(load, mark): (&f64, &Mark)| is_usable(*mark) && *load > threshold;
        let is_touched = loads.values().iter().zip(loads.marks()).any(touches);
        let is_bounded = !loads.marks().contains(&Mark::Saturated);
        // A reading at the ceiling bounds no sum that it is in, and tells of the others what it tells.
        self.is_looked_at = is_answer && set_passive(&mut *self.point, siemens.values()).is_ok();
        if self.is_looked_at {
            self.look_at(siemens, loads);
        }
        if !self.is_looked_at || !is_bounded {
            let of_handle = self.sensor.handle().map(|_| FigureError::unbounded());
            return FrameFigureErrors {
                total_force_newtons: FigureError::unbounded(),
                grip_newtons: of_handle,
                grip_direction: of_handle,
                contact_area_mm2: FigureError::unbounded(),
                centre_mm: is_touched.then(|| [FigureError::unbounded(); 2]),
            };
        }
        let [grip_newtons, grip_direction] = self.grip(loads);
        FrameFigureErrors {
            total_force_newtons: self.total(loads),
            grip_newtons,
            grip_direction,
            contact_area_mm2: self.area(siemens, loads),
            centre_mm: self.centre(loads),
        }
    }

    /// Standard error by noise of the sum of all loads of one frame with an answer, newtons, and what it is uncertain by in
    /// every such frame alike since noise has added to it ([`Self::set_bias`]); none of what no circuit has.
    pub(crate) fn noise_of_total(
        &mut self,
        siemens: &Frame<Siemens>,
        loads: &Frame<Newtons>,
    ) -> Option<[f64; 2]> {
        set_passive(&mut *self.point, siemens.values()).ok()?;
        self.look_at(siemens, loads);
        let noise = self.total(loads).noise;
        let sum = self.weights.iter().zip(loads.values());
        let [_, common] = self.doubts_of_bias(sum.map(|(weight, load)| weight * load).sum());
        Some([noise, common])
    }

    /// Of the sum of some taxels' loads of the frame that [`Self::of`] looked at last, newtons.
    ///
    /// # Panics
    /// When a frame's shape is not the sensor's.
    pub fn of_region(&mut self, loads: &Frame<Newtons>, region: &Region) -> FigureError {
        let is_bounded = |&taxel: &usize| loads.marks()[taxel] != Mark::Saturated;
        let here = region.taxels_at(loads.sequence);
        if !self.is_looked_at || !here.iter().all(is_bounded) {
            return FigureError::unbounded();
        }
        self.weights.fill(0.0);
        for &taxel in here {
            self.weights[taxel] = f64::from(u8::from(is_usable(loads.marks()[taxel])));
        }
        self.of_sum(loads)
    }

    /// Slopes and errors of every taxel.
    fn look_at(&mut self, siemens: &Frame<Siemens>, loads: &Frame<Newtons>) {
        for (taxel, &mark) in loads.marks().iter().enumerate() {
            self.is_known[taxel] = is_left_out(siemens.marks()[taxel]);
            let load_g = grams_from_newtons(loads.values()[taxel]);
            let own_g = self.beyond.map_or(0.0, |beyond| beyond.own_g(load_g));
            let has_reading = is_usable(mark) && mark != Mark::Interpolated;
            (self.slope[taxel], self.noise[taxel], self.own[taxel]) = if has_reading {
                let value = siemens.values()[taxel];
                let error = least_error_siemens(&self.sensor, self.sigma_volts, value);
                let noise = newtons_from_grams(self.law.error_grams(taxel, value, error));
                (noise / error, noise, newtons_from_grams(own_g))
            } else if mark == Mark::Interpolated {
                // As wrong may be what it was given.
                let off = scatter_around(loads, loads.marks(), taxel);
                (0.0, 0.0, off.unwrap_or(0.0))
            } else {
                (0.0, 0.0, 0.0)
            };
            if self.is_known[taxel] {
                (self.slope[taxel], self.noise[taxel]) = (0.0, 0.0);
            }
        }
        if let Some(detached) = &mut self.detached {
            detached.look_at(&mut *self.point, siemens);
        }
        if let Some(sheet) = &mut self.sheet {
            let found = sheet.look_at(&*self.point, siemens.values(), &self.is_known);
            self.is_looked_at &= found.is_ok();
        }
    }

    fn total(&mut self, loads: &Frame<Newtons>) -> FigureError {
        for (weight, mark) in self.weights.iter_mut().zip(loads.marks()) {
            *weight = f64::from(u8::from(is_usable(*mark)));
        }
        self.of_sum(loads)
    }

    /// Of the sum of loads with the weights as they stand: a scale that all share moves it as a whole.
    fn of_sum(&mut self, loads: &Frame<Newtons>) -> FigureError {
        let (mut sum, mut count) = (0.0, 0.0);
        for (weight, load) in self.weights.iter().zip(loads.values()) {
            sum += weight * load;
            count += weight;
        }
        let (share, floor) = self.shared();
        let model = (share * sum).hypot(floor * count).hypot(self.own_of_sum());
        let fit = self.beyond.map_or(0.0, |beyond| beyond.fit_share) * sum.abs();
        let [apart, common] = self.doubts_of_bias(sum);
        let [noise, by_sheet] = self.errors_of_sum();
        let model = model.hypot(common).hypot(by_sheet);
        self.figure(noise.hypot(apart), fit, model)
    }

    /// What the weighted sum of loads is uncertain by since noise has added to them: by its draws, and by what is wrong in
    /// every frame alike.
    fn doubts_of_bias(&self, sum: f64) -> [f64; 2] {
        let Some(bias) = &self.bias else {
            return [0.0; 2];
        };
        let of = |draw: &[f64]| -> f64 { self.weights.iter().zip(draw).map(|(w, b)| w * b).sum() };
        let [one, other] = [of(&bias.draws[0]), of(&bias.draws[1])];
        let added = (one + other) / 2.0;
        // Bends of higher order are to this one as this one is to the sum.
        let higher = if sum == 0.0 {
            1.0
        } else {
            (added / sum).abs().min(1.0)
        };
        let common = added.abs() * bias.share.hypot(higher);
        [(one - other).abs() / 2.0, common.hypot(of(&bias.resting))]
    }

    /// Of a place that the loads tell by the weights as they stand: no common scale moves it, one that leans over the
    /// contact by what a frame shares does, and so do errors of single taxels.
    fn of_place(&mut self, loads: &Frame<Newtons>) -> FigureError {
        let (mut sum, mut spread, mut lever) = (0.0, 0.0, 0.0);
        for (weight, load) in self.weights.iter().zip(loads.values()) {
            if *weight != 0.0 {
                sum += load.max(0.0);
                spread += load.max(0.0) * weight.powi(2);
                lever += weight;
            }
        }
        let (share, floor) = self.shared();
        let shared = (share * (sum * spread).sqrt()).hypot(floor * lever);
        let [noise, by_sheet] = self.errors_of_sum();
        let model = shared.hypot(self.own_of_sum()).hypot(by_sheet);
        self.figure(noise, 0.0, model)
    }

    /// Shares of the load and newtons that all taxels of a frame are off by together.
    fn shared(&self) -> (f64, f64) {
        self.beyond.map_or((0.0, 0.0), |beyond| {
            (
                beyond.shared_share(),
                newtons_from_grams(beyond.shared_floor_g()),
            )
        })
    }

    /// Standard error of the weighted sum of loads by what each is off by itself.
    fn own_of_sum(&self) -> f64 {
        let each = self.weights.iter().zip(&self.own);
        each.map(|(w, own)| (w * own).powi(2)).sum::<f64>().sqrt()
    }

    /// The same by the noise of the readings, and by the law of the sheet: one solve with the adjoint of the circuit's derivative
    /// tells what each reading adds to the sum.
    fn errors_of_sum(&mut self) -> [f64; 2] {
        let (columns, absent) = (self.sensor.columns(), self.sensor.absent());
        let weights = match &self.spread {
            Some(spread) => {
                // The equations are symmetric: what undoes a spread of loads undoes one of weights.
                spread.undo(
                    columns,
                    absent,
                    &self.weights,
                    &mut self.right,
                    &mut self.work,
                );
                &self.right
            }
            None => &self.weights,
        };
        let right = &mut self.work[..weights.len()];
        for (right, (weight, slope)) in right.iter_mut().zip(weights.iter().zip(&self.slope)) {
            *right = weight * slope;
        }
        let mut known = Known {
            point: &mut *self.point,
            is_known: &self.is_known,
            moved: &mut self.moved,
        };
        let influence =
            self.adjoint
                .influence_of(&mut known, &self.work[..self.weights.len()], TOLERANCE);
        let sheet = self.sheet.as_ref();
        let noise = self.sigma_volts * influence.iter().map(|x| x * x).sum::<f64>().sqrt();
        let of = |volts: &Vec<f64>| influence.iter().zip(volts).map(|(x, v)| x * v).sum::<f64>();
        let moves = self.detached.as_ref().map_or(&[][..], Detached::moves);
        let by_detached = moves.iter().map(|volts| of(volts).powi(2));
        [
            noise.hypot(by_detached.sum::<f64>().sqrt()),
            sheet.map_or(0.0, |sheet| sheet.of_sum(influence)),
        ]
    }

    fn figure(&self, noise: f64, fit: f64, model: f64) -> FigureError {
        let mut figure = FigureError {
            noise,
            fit,
            model,
            half_width_95: 0.0,
        };
        let factor = factor_95_of(self.beyond.as_ref());
        figure.half_width_95 = factor * figure.standard_error();
        figure
    }

    fn touched(&self, loads: &Frame<Newtons>, taxel: usize) -> Option<f64> {
        let load = loads.values()[taxel];
        let is_touched = is_usable(loads.marks()[taxel]) && load > self.threshold_newtons;
        is_touched.then_some(load)
    }

    fn centre(&mut self, loads: &Frame<Newtons>) -> Option<[FigureError; 2]> {
        let taxels = 0..loads.values().len();
        let sum: f64 = taxels.clone().filter_map(|t| self.touched(loads, t)).sum();
        if sum <= 0.0 {
            return None;
        }
        let round = match self.sensor.handle() {
            Some(handle) => {
                let each = taxels
                    .clone()
                    .filter_map(|t| Some((t, self.touched(loads, t)?)));
                let mean = mean_direction(each, handle)?;
                Some((usize::from(handle.rings == Rings::Rows), mean))
            }
            None => None,
        };
        Some([0, 1].map(|axis| {
            if let Some((_, mean)) = round.as_ref().filter(|(round, _)| *round == axis) {
                return self.centre_round(loads, mean);
            }
            let at = |own: &Self, taxel: usize| own.places_mm[taxel][axis];
            let moment = |taxel| {
                self.touched(loads, taxel)
                    .map(|load| load * at(self, taxel))
            };
            let middle = taxels.clone().filter_map(moment).sum::<f64>() / sum;
            for taxel in taxels.clone() {
                let touched = self.touched(loads, taxel);
                self.weights[taxel] = touched.map_or(0.0, |_| (at(self, taxel) - middle) / sum);
            }
            self.of_place(loads)
        }))
    }
}

/// Relative residual at which a solve with the adjoint ends: errors need two digits.
const TOLERANCE: f64 = 1e-3;
