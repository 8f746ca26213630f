//! A law and gains: what every taxel conducts under a load, and how that moves with the unknowns.

use super::levels::Level;
use super::lines::Switches;
use crate::Sensor;
use crate::material::LoadLaw;
use crate::stats;

/// Numbers of the law: ln scale at the reference load, exponent, ln g_zero, 1/saturation per kilogram.
pub(super) const LAW: usize = 4;

/// A fit.
#[derive(Debug, Clone)]
pub(super) struct Fitted {
    /// The law's numbers, then ln gain of every taxel, then ln of each switch over the file's.
    pub(super) at: Vec<f64>,
    /// Standard errors of [`Fitted::reported`], by the curvature of the posterior.
    pub(super) law_errors: [f64; LAW],
    /// Standard deviation of what is left of a reading, volts.
    pub(super) sigma_volts: f64,
    /// Readings that are too far off to be of the load.
    pub(super) left_out: usize,
    pub(super) ln_reference: f64,
    pub(super) saturates: bool,
    pub(super) taxels: usize,
    pub(super) switches: Switches,
}

impl Fitted {
    fn gains(&self) -> &[f64] {
        &self.at[LAW..LAW + self.taxels]
    }

    /// ln of each switch over the file's: columns, then rows.
    pub(super) fn lines(&self) -> &[f64] {
        &self.at[LAW + self.taxels..]
    }

    /// The law as a sensor file has it: ln factor of the mean taxel, exponent, ln g_zero, 1/saturation per kilogram.
    pub(super) fn reported(&self) -> [f64; LAW] {
        let gain = stats::mean(self.gains().iter().copied()).unwrap_or(0.0);
        let ln_factor = self.at[0] - self.at[1] * self.ln_reference + gain;
        [ln_factor, self.at[1], self.at[2], self.at[3]]
    }

    /// The derivative of a number of [`Fitted::reported`] by the unknowns.
    pub(super) fn by_unknowns(&self, number: usize) -> Vec<f64> {
        let mut by = vec![0.0; self.at.len()];
        by[number] = 1.0;
        if number == 0 {
            by[1] = -self.ln_reference;
            by[LAW..LAW + self.taxels].fill(1.0 / self.taxels as f64);
        }
        by
    }

    /// The sensor with its switches as they were found.
    pub(super) fn sensor(&self, known: &Sensor) -> Sensor {
        self.switches.applied(known, self.lines())
    }

    /// f and its derivatives by the law's first two numbers and the saturation at a load, siemens.
    fn response(&self, load_g: f64) -> [f64; 3] {
        let kilograms = load_g / 1000.0;
        let acting = load_g / (1.0 + self.at[3] * kilograms);
        if acting <= 0.0 {
            return [0.0; 3];
        }
        let x = acting.ln() - self.ln_reference;
        let f = (self.at[0] + self.at[1] * x).exp();
        let by_saturation = -f * self.at[1] * kilograms / (1.0 + self.at[3] * kilograms);
        [f, f * x, by_saturation]
    }

    /// The law, with a scale for every taxel.
    pub(super) fn law(&self) -> LoadLaw {
        let ln_factor = self.at[0] - self.at[1] * self.ln_reference;
        LoadLaw {
            g_zero: self.at[2].exp(),
            ln_scale: self.gains().iter().map(|gain| ln_factor + gain).collect(),
            exponent: vec![self.at[1]],
            saturation_load_g: (self.at[3] > 0.0).then(|| 1000.0 / self.at[3]),
            bend: None,
        }
    }

    /// What every taxel conducts under a load, siemens.
    pub(super) fn siemens(&self, level: &Level) -> Vec<f64> {
        let [f, ..] = self.response(level.load_g);
        let g_zero = self.at[2].exp();
        let gains = self.gains().iter().enumerate();
        gains
            .map(|(taxel, gain)| {
                if level.conducts[taxel] {
                    g_zero + f * gain.exp()
                } else {
                    0.0
                }
            })
            .collect()
    }
}

/// From a change of the unknowns to one of the conductances under a load.
pub(super) fn spread(fitted: &Fitted, level: &Level, along: &[f64], siemens: &mut [f64]) {
    let [f, by_exponent, by_saturation] = fitted.response(level.load_g);
    let law = along[0] * f + along[1] * by_exponent + along[3] * by_saturation;
    let zero = along[2] * fitted.at[2].exp();
    let gains = fitted.gains().iter().zip(&along[LAW..]).enumerate();
    for (siemens, (taxel, (gain, moved))) in siemens.iter_mut().zip(gains) {
        *siemens = if level.conducts[taxel] {
            zero + gain.exp() * (law + f * moved)
        } else {
            0.0
        };
    }
}

/// The transpose of [`spread`], added with a weight. What does not conduct has no derivative.
pub(super) fn gather(
    fitted: &Fitted,
    level: &Level,
    by_siemens: &mut [f64],
    weight: f64,
    out: &mut [f64],
) {
    for (by_siemens, conducts) in by_siemens.iter_mut().zip(&level.conducts) {
        *by_siemens = if *conducts { *by_siemens } else { 0.0 };
    }
    let load_g = level.load_g;
    let [f, by_exponent, by_saturation] = fitted.response(load_g);
    let (law, rest) = out.split_at_mut(LAW);
    let (gains, _) = rest.split_at_mut(fitted.taxels);
    let (mut of_law, mut of_zero) = (0.0, 0.0);
    let each = by_siemens.iter().zip(fitted.gains());
    for (out, (by_siemens, gain)) in gains.iter_mut().zip(each) {
        let by_gain = gain.exp() * by_siemens;
        of_law += by_gain;
        of_zero += by_siemens;
        *out += weight * f * by_gain;
    }
    law[0] += weight * f * of_law;
    law[1] += weight * by_exponent * of_law;
    law[2] += weight * fitted.at[2].exp() * of_zero;
    law[3] += weight * by_saturation * of_law;
}
