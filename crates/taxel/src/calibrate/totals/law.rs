//! The family of laws that totals choose from, and the sum that one of them makes of a frame.

use super::frames::{Solved, counts};
use crate::Sensor;
use crate::material::{LoadLaw, Spread};
use crate::sensor::{MaterialSpec, PerTaxel};
use crate::stats::mean;

/// What is believed of an exponent that no sensor file tells.
pub(super) const EXPONENT: f64 = 0.85;
/// Exponents that a law may have.
pub(super) const EXPONENTS: std::ops::Range<f64> = 0.1..5.0;

/// Laws of two numbers: the load, as a logarithm, of a taxel that conducts `reference` over the unloaded ones, and the exponent
/// over the believed one, as a logarithm. Gains, saturation, bend and spread are those of the sensor file.
pub(super) struct Family {
    base: LoadLaw,
    /// ln gain, one for all or one per taxel.
    ln_gain: Vec<f64>,
    /// The mean of the exponents believed.
    pub(super) exponent: f64,
    /// What a taxel that carries much conducts over the unloaded ones, siemens.
    reference: f64,
    /// What a gram on each taxel adds to the total, more than one where the cover spreads loads beyond the edge; empty: one.
    weights: Vec<f64>,
}

/// A member of a family.
pub(super) struct Member {
    pub(super) law: LoadLaw,
    /// Siemens per gram^exponent, of a taxel of gain 1.
    pub(super) factor: f64,
    /// Mean over the taxels.
    pub(super) exponent: f64,
}

impl Family {
    /// For frames of a sensor whose unloaded taxels conduct `g_zero`. Nothing where no taxel conducts more.
    pub(super) fn new(sensor: &Sensor, frames: &[&Solved], g_zero: f64) -> Option<Self> {
        let mut base = LoadLaw::power(g_zero, 1.0, EXPONENT);
        let mut ln_gain = vec![0.0];
        if let Some(material) = sensor.material() {
            base = LoadLaw::from_sensor(sensor).ok()?;
            base.g_zero = g_zero;
            ln_gain = material.gain.iter().map(|gain| gain.ln()).collect();
        }
        let (mut squares, mut sum) = (0.0, 0.0);
        for frame in frames.iter().filter(|frame| frame.load_g > 0.0) {
            for over in frame.siemens.values().iter().map(|g| (g - g_zero).max(0.0)) {
                squares += over * over;
                sum += over;
            }
        }
        let reference = squares / sum;
        (reference.is_finite() && reference > 0.0).then(|| Self {
            exponent: mean(base.exponent.iter().copied()).unwrap_or(EXPONENT),
            base,
            ln_gain,
            reference,
            weights: weights(sensor),
        })
    }

    /// The law of `[ln grams at the reference, ln exponent over the believed one]`; none outside what exponents may be.
    pub(super) fn member(&self, at: &[f64]) -> Option<Member> {
        let (ln_grams, ratio) = (at[0], at[1].exp());
        let exponent = self.exponent * ratio;
        if !EXPONENTS.contains(&exponent) || !ln_grams.is_finite() {
            return None;
        }
        let ln_factor = self.reference.ln() - exponent * ln_grams;
        let mut law = self.base.clone();
        for own in &mut law.exponent {
            *own *= ratio;
        }
        law.ln_scale = self.ln_gain.iter().map(|gain| gain + ln_factor).collect();
        let factor = ln_factor.exp();
        (factor.is_finite() && factor > 0.0).then_some(Member {
            law,
            factor,
            exponent,
        })
    }

    /// The total that a law makes of a frame, grams. Below the unloaded conductance loads are negative, so that noise about it
    /// adds up to nothing.
    pub(super) fn total_g(&self, law: &LoadLaw, frame: &Solved) -> f64 {
        let each = frame.siemens.values().iter().zip(frame.siemens.marks());
        let counted = each.enumerate().filter(|(_, (_, mark))| counts(**mark));
        let loads = counted.map(|(taxel, (g, _))| {
            let weight = self.weights.get(taxel).copied().unwrap_or(1.0);
            weight * law.grams_from_siemens(taxel, *g)
        });
        loads.sum()
    }
}

/// The equations of a spread are symmetric: what undoes one of loads undoes one of weights.
fn weights(sensor: &Sensor) -> Vec<f64> {
    let Some(spread) = sensor.material().and_then(|material| material.spread) else {
        return Vec::new();
    };
    let ones = vec![1.0; sensor.rows() * sensor.columns()];
    let mut weights = ones.clone();
    let mut work = vec![0.0; Spread::room(ones.len(), sensor.columns())];
    Spread::new(spread).undo(
        sensor.columns(),
        sensor.absent(),
        &ones,
        &mut weights,
        &mut work,
    );
    weights
}

impl Member {
    /// The material of a sensor file with this law: gains, saturation, bend, spread and sheet stay, what the material remembers
    /// goes.
    pub(super) fn material(&self, sensor: &Sensor) -> MaterialSpec {
        let digits = |value: f64| format!("{value:.6e}").parse().unwrap_or(value);
        let all = |law: &LoadLaw| match law.exponent.as_slice() {
            [one] => PerTaxel::One(digits(*one)),
            each => PerTaxel::Each(
                each.chunks_exact(sensor.columns())
                    .map(|row| row.iter().map(|own| digits(*own)).collect())
                    .collect(),
            ),
        };
        let fresh = || MaterialSpec::new(1.0, PerTaxel::One(EXPONENT));
        let mut material = sensor.spec().material.clone().unwrap_or_else(fresh);
        material.factor = digits(self.factor);
        material.exponent = all(&self.law);
        material.g_zero_siemens = digits(self.law.g_zero);
        material.dynamic = None;
        material
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Frame;
    use crate::sensor::preset;

    fn solved(sensor: &Sensor, loads: &[f64]) -> Solved {
        let law = LoadLaw::from_sensor(sensor).unwrap();
        let each = loads.iter().enumerate();
        let siemens = each.map(|(t, g)| law.siemens_from_grams(t, *g)).collect();
        Solved {
            total: 0,
            load_g: loads.iter().sum(),
            siemens: Frame::new(sensor.rows(), sensor.columns(), siemens).unwrap(),
            noise_siemens: 0.0,
            lost: 0,
        }
    }

    #[test]
    fn the_true_law_is_a_member_and_says_the_total() {
        let sensor = preset("mat-16x16-cd4067").unwrap();
        let loads: Vec<f64> = (0..256).map(|t| f64::from(t % 17) * 9.0).collect();
        let frame = solved(&sensor, &loads);
        let family = Family::new(&sensor, &[&frame], 1e-6).unwrap();
        let ln_grams = (family.reference / 2e-6).ln() / 0.85;
        let member = family.member(&[ln_grams, 0.0]).unwrap();
        assert!((member.factor / 2e-6 - 1.0).abs() < 1e-12);
        let total = family.total_g(&member.law, &frame);
        assert!((total / frame.load_g - 1.0).abs() < 1e-12);
        assert!(family.member(&[ln_grams, 3.0]).is_none());
    }

    #[test]
    fn a_cover_that_spreads_loads_beyond_the_edge_is_counted_back() {
        let spread = [0.08, 0.06, 0.01];
        let plain = preset("mat-16x16-cd4067").unwrap();
        let spreads = |spec: &mut crate::sensor::SensorSpec| {
            spec.material.as_mut().unwrap().spread = Some(spread);
        };
        let sensor = plain.edited(spreads).unwrap();
        let mut loads = vec![0.0; 256];
        // In a corner, where most goes beyond the edge.
        loads[0] = 100.0;
        let mut felt = loads.clone();
        Spread::new(spread).apply(16, &loads, &mut felt);
        assert!(felt.iter().sum::<f64>() < 90.0);
        let frame = solved(&sensor, &felt);
        let family = Family::new(&sensor, &[&frame], 1e-6).unwrap();
        let total = family.total_g(&LoadLaw::from_sensor(&sensor).unwrap(), &frame);
        assert!((total - 100.0).abs() < 1e-6, "{total}");
    }
}
