//! How far to trust a contact area.

use super::super::known::Known;
use super::super::load::factor_95_of;
use super::super::{Uncertainty, standard_errors_by};
use super::{FigureError, FigureErrors};
use crate::frame::newtons_from_grams;
use crate::metric::is_usable;
use crate::{Frame, Newtons, Siemens};

/// Each error is itself uncertain by a quarter: what is counted needs no more.
const PROBES: Uncertainty = Uncertainty::Probes(8);

impl FigureErrors {
    /// A taxel is touched or not with the probability that its error leaves; what the frame shares moves all of them over
    /// the threshold together, those beside a heavy one by a little of its load. Those that count as touched though their
    /// intervals reach down to no load may all carry none: unloaded taxels are many, lightly loaded ones are few.
    pub(super) fn area(&mut self, siemens: &Frame<Siemens>, loads: &Frame<Newtons>) -> FigureError {
        let fit_share = self.beyond.map_or(0.0, |beyond| beyond.fit_share);
        let factor = factor_95_of(self.beyond.as_ref());
        let (share, floor) = self.shared();
        let (mut noise, mut all) = (0.0, 0.0);
        let (mut by_fit, mut by_model, mut undecided) = (0.0, 0.0, 0.0);
        let through_lines = self.noise_through_open_lines(siemens);
        let near = self.beside.of(loads.values());
        for (taxel, (&load, mark)) in loads.values().iter().zip(loads.marks()).enumerate() {
            if !is_usable(*mark) {
                continue;
            }
            let cell = self.sensor.cell_mm2(taxel);
            let above = load - self.threshold_newtons;
            let own_noise = through_lines
                .as_ref()
                .map_or(self.noise[taxel], |n| n[taxel]);
            let shared = (share * load.abs().max(near[taxel])).hypot(floor);
            noise += cell.powi(2) * doubt(above, own_noise);
            let alone = own_noise.hypot(self.own[taxel]);
            all += cell.powi(2) * doubt(above, alone);
            let moves = |by: f64| cell * f64::from(u8::from(above.abs() <= by)) / 2.0;
            by_fit += moves(fit_share * load.abs());
            by_model += moves(shared);
            let error = alone.hypot(shared).hypot(fit_share * load);
            if above > 0.0 && load <= factor * error {
                undecided += cell;
            }
        }
        let noise = noise.sqrt();
        let model = (all - noise * noise).max(0.0).sqrt().hypot(by_model);
        let mut figure = self.figure(noise, by_fit, model);
        // Not a draw of many that make up for each other: beside what chance leaves, and all of one sign.
        figure.noise += undecided / factor;
        figure.half_width_95 += undecided;
        figure
    }

    /// Standard errors of loads by the noise of all readings, newtons, where lines are left open: there it goes from taxel to taxel, and is
    /// many times that of a taxel alone.
    fn noise_through_open_lines(&mut self, siemens: &Frame<Siemens>) -> Option<Vec<f64>> {
        if !self.sensor.readout().has_open_columns() {
            return None;
        }
        let mut known = Known {
            point: &mut *self.point,
            is_known: &self.is_known,
            moved: &mut self.moved,
        };
        let errors =
            standard_errors_by(PROBES, &mut known, siemens.values(), self.sigma_volts).ok()?;
        let each = errors.iter().zip(siemens.values()).enumerate();
        let newtons = |(taxel, (error, value)): (usize, (&f64, &f64))| {
            newtons_from_grams(self.law.error_grams(taxel, *value, *error))
        };
        Some(each.map(newtons).collect())
    }
}

/// Variance of whether a taxel is over a threshold that it is `above` with a standard error.
fn doubt(above: f64, error: f64) -> f64 {
    // Beyond five standard errors there is none.
    if above.abs() >= 5.0 * error {
        return 0.0;
    }
    // The normal distribution to 1.4e-4 (Page 1977).
    let z = above / error;
    let p = 1.0 / (1.0 + (-z * (1.5976 + 0.070_565 * z * z)).exp());
    p * (1.0 - p)
}
