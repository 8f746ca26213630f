//! The load law: what load a taxel's conductance stands for, and the other way round.

use super::elementary;
use crate::Error;
use crate::sensor::{Bend, Material, MaterialSpec, PerTaxel, Sensor};
use crate::spline::Spline;
use taxel_linalg::{WideWork, wide, wide_fused};

/// G = g_zero + gain · factor · S(load)^exponent · e^bend(ln load), with S(L) = L/(1 + L/saturation).
///
/// `factor` in siemens per gram^exponent, loads in grams, conductances in siemens. Gain and exponent may
/// differ from taxel to taxel. Below g_zero the law is continued by its mirror image, so that noise around
/// an unloaded taxel averages to nothing.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadLaw {
    /// Conductance of an unloaded taxel, siemens.
    pub g_zero: f64,
    /// ln(gain · factor), one for all or one per taxel.
    pub ln_scale: Vec<f64>,
    /// Exponent, one for all or one per taxel.
    pub exponent: Vec<f64>,
    /// Load at which the response is halved, grams.
    pub saturation_load_g: Option<f64>,
    /// Correction of the logarithm over ln load.
    pub bend: Option<Spline>,
}

impl LoadLaw {
    /// A power law, the same for every taxel.
    pub fn power(g_zero: f64, factor: f64, exponent: f64) -> Self {
        Self {
            g_zero,
            ln_scale: vec![factor.ln()],
            exponent: vec![exponent],
            saturation_load_g: None,
            bend: None,
        }
    }

    /// The law of a sensor's material.
    ///
    /// # Errors
    /// [`Error::MissingKey`] without a material.
    pub fn from_sensor(sensor: &Sensor) -> Result<Self, Error> {
        Self::from_material(sensor.material().ok_or_else(Self::missing)?)
    }

    /// Why there are no loads of a sensor without a material.
    pub(crate) fn missing() -> Error {
        Error::MissingKey {
            key: "material",
            hint: "a load law makes loads of conductances".to_owned(),
        }
    }

    /// The law of a material.
    ///
    /// # Errors
    /// [`Error::Knots`] where those of its bend do not ascend.
    fn from_material(material: &Material) -> Result<Self, Error> {
        Ok(Self {
            g_zero: material.g_zero_siemens,
            ln_scale: material
                .gain
                .iter()
                .map(|gain| (gain * material.factor).ln())
                .collect(),
            exponent: material.exponent.clone(),
            saturation_load_g: material.saturation_load_g,
            bend: match &material.bend {
                Some(bend) => Some(Spline::new(&bend.ln_load_g, &bend.ln_siemens).map_err(
                    |source| Error::Knots {
                        key: "material.bend.ln_load_g",
                        source,
                    },
                )?),
                None => None,
            },
        })
    }

    /// The material of a law that is the same for every taxel (the first taxel's, where it is not).
    pub fn to_material(&self) -> MaterialSpec {
        let mut material =
            MaterialSpec::new(self.ln_scale[0].exp(), PerTaxel::One(self.exponent[0]));
        material.g_zero_siemens = self.g_zero;
        material.saturation_load_g = self.saturation_load_g;
        material.bend = self.bend.as_ref().map(|bend| {
            let (ln_load_g, ln_siemens) = bend.knots();
            Bend::new(ln_load_g.to_vec(), ln_siemens.to_vec())
        });
        material
    }

    fn of(values: &[f64], taxel: usize) -> f64 {
        match values {
            [one] => *one,
            each => each[taxel],
        }
    }

    /// Load in grams; negative below g_zero.
    pub fn grams_from_siemens(&self, taxel: usize, siemens: f64) -> f64 {
        let over = siemens - self.g_zero;
        if over == 0.0 {
            return 0.0;
        }
        let (scale, exponent) = (
            Self::of(&self.ln_scale, taxel),
            Self::of(&self.exponent, taxel),
        );
        let acting = if exponent == 1.0 && self.bend.is_none() {
            over.abs() * (-scale).exp()
        } else {
            let response = over.abs().ln() - scale;
            let mut ln_load = [response / exponent];
            if let Some(bend) = &self.bend {
                straighten::<false, _>(bend, &[exponent], &[response], &mut ln_load);
            }
            ln_load[0].exp()
        };
        let load = match self.saturation_load_g {
            Some(half) => acting / (1.0 - acting / half).max(LEAST_LEFT),
            None => acting,
        };
        load.copysign(over)
    }

    /// What a conductance that is off by so much makes a load off by, grams: half of the way from one side to the other. At no load
    /// a power law's slope alone would promise too much.
    pub(crate) fn error_grams(&self, taxel: usize, siemens: f64, error_siemens: f64) -> f64 {
        let up = self.grams_from_siemens(taxel, siemens + error_siemens);
        let down = self.grams_from_siemens(taxel, siemens - error_siemens);
        (up - down) / 2.0
    }

    /// [`Self::grams_from_siemens`] of a whole frame, many taxels at once: the same numbers to some 1e-15.
    ///
    /// # Panics
    /// When there are more loads than conductances, or than taxels that differ.
    pub fn grams_of_frame(&self, siemens: &[f64], grams: &mut [f64]) {
        let n = grams.len();
        let siemens = &siemens[..n];
        if let ([scale], [1.0], None) = (&self.ln_scale[..], &self.exponent[..], &self.bend) {
            self.grams_in_proportion(siemens, grams, (-scale).exp());
            return;
        }
        wide_fused(OfFrame {
            law: self,
            ln_scale: Blocks::new(&self.ln_scale, n),
            exponent: Blocks::new(&self.exponent, n),
            siemens,
            grams,
        });
    }

    /// Of a law whose exponent is 1, as that of numbers that are loads already: no logarithm, and nothing lost to one.
    fn grams_in_proportion(&self, siemens: &[f64], grams: &mut [f64], grams_per_siemens: f64) {
        wide(
            #[inline(always)]
            || {
                for (grams, siemens) in grams.iter_mut().zip(siemens) {
                    *grams = (siemens - self.g_zero) * grams_per_siemens;
                }
                if let Some(half) = self.saturation_load_g {
                    for grams in grams {
                        *grams /= (1.0 - grams.abs() / half).max(LEAST_LEFT);
                    }
                }
            },
        );
    }

    #[inline(always)]
    fn grams_of_block<const FUSED: bool>(
        &self,
        siemens: &[f64; BLOCK],
        ln_scale: &[f64; BLOCK],
        exponent: &[f64; BLOCK],
        grams: &mut [f64; BLOCK],
    ) {
        if siemens.iter().all(|siemens| *siemens == self.g_zero) {
            *grams = [0.0; BLOCK];
            return;
        }
        let mut response = [0.0; BLOCK];
        for lane in 0..BLOCK {
            let over = (siemens[lane] - self.g_zero).abs();
            response[lane] = elementary::ln::<FUSED>(over.max(f64::MIN_POSITIVE)) - ln_scale[lane];
        }
        if let [one] = self.exponent[..] {
            let inverse = 1.0 / one;
            for (grams, response) in grams.iter_mut().zip(&response) {
                *grams = response * inverse;
            }
        } else {
            for lane in 0..BLOCK {
                grams[lane] = response[lane] / exponent[lane];
            }
        }
        if let Some(bend) = &self.bend {
            straighten::<FUSED, _>(bend, exponent, &response, grams);
        }
        for grams in grams.iter_mut() {
            *grams = elementary::exp::<FUSED>(*grams);
        }
        if let Some(half) = self.saturation_load_g {
            for grams in grams.iter_mut() {
                *grams /= (1.0 - *grams / half).max(LEAST_LEFT);
            }
        }
        for (grams, siemens) in grams.iter_mut().zip(siemens) {
            let over = siemens - self.g_zero;
            // No load is none, and what is no number stays none.
            *grams = if over != 0.0 {
                grams.copysign(over) + 0.0 * over
            } else {
                0.0
            };
        }
    }

    /// Conductance in siemens under a load in grams.
    pub fn siemens_from_grams(&self, taxel: usize, load_g: f64) -> f64 {
        if load_g == 0.0 {
            return self.g_zero;
        }
        let (scale, exponent) = (
            Self::of(&self.ln_scale, taxel),
            Self::of(&self.exponent, taxel),
        );
        let load = load_g.abs();
        let acting = match self.saturation_load_g {
            Some(half) => load / (1.0 + load / half),
            None => load,
        };
        let bend = self
            .bend
            .as_ref()
            .map_or(0.0, |bend| bend.at(acting.ln()).0);
        let over = (scale + exponent * acting.ln() + bend).exp();
        self.g_zero + over.copysign(load_g)
    }

    /// How many grams a siemens is worth at this conductance: the slope of [`Self::grams_from_siemens`],
    /// by a central difference of a thousandth.
    pub fn grams_per_siemens(&self, taxel: usize, siemens: f64) -> f64 {
        let step = 1e-3
            * (siemens - self.g_zero)
                .abs()
                .max(1e-3 * self.g_zero.abs())
                .max(1e-9);
        let up = self.grams_from_siemens(taxel, siemens + step);
        let down = self.grams_from_siemens(taxel, siemens - step);
        (up - down) / (2.0 * step)
    }
}

/// What is left of the response at least: beyond the asymptote no load explains the conductance; a hundredfold stands for that.
const LEAST_LEFT: f64 = 0.01;
/// Taxels whose loads are found one step after the other, all at hand.
const BLOCK: usize = 64;
const MAX_STEPS: usize = 20;
/// The last step, of a logarithm.
const LAST_STEP: f64 = 1e-12;
/// A bend that turns the law's slope around is none that can be undone; no less than this is believed of it.
const LEAST_SLOPE: f64 = 0.05;

/// The loads of a whole frame.
struct OfFrame<'a> {
    law: &'a LoadLaw,
    ln_scale: Blocks<'a>,
    exponent: Blocks<'a>,
    siemens: &'a [f64],
    grams: &'a mut [f64],
}

impl WideWork for OfFrame<'_> {
    type Output = ();

    #[inline(always)]
    fn run<const FUSED: bool>(self) {
        let (law, ln_scale, exponent) = (self.law, self.ln_scale, self.exponent);
        let (blocks, rest) = self.grams.as_chunks_mut::<BLOCK>();
        let (of_blocks, of_rest) = self.siemens.as_chunks::<BLOCK>();
        for (k, (grams, siemens)) in blocks.iter_mut().zip(of_blocks).enumerate() {
            law.grams_of_block::<FUSED>(siemens, ln_scale.at(k), exponent.at(k), grams);
        }
        if !rest.is_empty() {
            let mut siemens = [law.g_zero; BLOCK];
            let mut grams = [0.0; BLOCK];
            siemens[..rest.len()].copy_from_slice(of_rest);
            law.grams_of_block::<FUSED>(&siemens, &ln_scale.last, &exponent.last, &mut grams);
            rest.copy_from_slice(&grams[..rest.len()]);
        }
    }
}

/// One number for all taxels or one each, block by block.
struct Blocks<'a> {
    each: &'a [[f64; BLOCK]],
    /// Of all taxels, or those after the last whole block.
    last: [f64; BLOCK],
}

impl<'a> Blocks<'a> {
    fn new(values: &'a [f64], taxels: usize) -> Self {
        if let [one] = values {
            return Self {
                each: &[],
                last: [*one; BLOCK],
            };
        }
        let (each, rest) = values[..taxels].as_chunks();
        let mut last = [1.0; BLOCK];
        last[..rest.len()].copy_from_slice(rest);
        Self { each, last }
    }

    #[inline(always)]
    fn at(&self, block: usize) -> &[f64; BLOCK] {
        self.each.get(block).unwrap_or(&self.last)
    }
}

/// ln of the acting loads where exponent · ln load + bend(ln load) is the response; where the law's slope turns around, by Newton's
/// steps from what it would be without a bend.
#[inline(always)]
fn straighten<const FUSED: bool, const LANES: usize>(
    bend: &Spline,
    exponent: &[f64; LANES],
    response: &[f64; LANES],
    ln_load: &mut [f64; LANES],
) {
    let start = *ln_load;
    if bend.cross::<FUSED, _>(response, exponent, LEAST_SLOPE, ln_load) {
        return;
    }
    *ln_load = start;
    for _ in 0..MAX_STEPS {
        let (value, slope) = bend.at_each(ln_load);
        let mut longest = 0f64;
        for lane in 0..LANES {
            let left = exponent[lane] * ln_load[lane] + value[lane] - response[lane];
            let step = left / (exponent[lane] + slope[lane]).max(LEAST_SLOPE);
            ln_load[lane] -= step;
            longest = if step.abs() > longest {
                step.abs()
            } else {
                longest
            };
        }
        if longest < LAST_STEP {
            break;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn laws() -> Vec<LoadLaw> {
        let power = LoadLaw::power(1e-6, 8.29e-6, 0.857);
        let saturating = LoadLaw {
            saturation_load_g: Some(2500.0),
            ..power.clone()
        };
        let bent = LoadLaw {
            bend: Spline::new(&[3.0, 4.5, 6.0], &[0.0, 0.05, -0.08]).ok(),
            ..power.clone()
        };
        vec![power, saturating, bent]
    }

    #[test]
    fn every_law_round_trips_and_is_odd_about_g_zero() {
        for law in laws() {
            for load in [-30.0, 0.0, 0.3, 12.0, 150.0, 600.0] {
                let siemens = law.siemens_from_grams(0, load);
                assert!(
                    (law.grams_from_siemens(0, siemens) - load).abs()
                        < 1e-9 * (1.0 + f64::abs(load))
                );
            }
        }
    }

    #[test]
    fn a_frame_at_once_is_every_taxel_by_itself() {
        // More than a block, and no whole number of them.
        let taxels = 101;
        let siemens: Vec<f64> = (0..taxels)
            .map(|t| 1e-6 + 1e-7 * (t as f64 - 5.0).powi(3))
            .chain([f64::NAN, 1e-6])
            .collect();
        let n = siemens.len();
        for law in laws() {
            for (gains, exponents) in [(1, 1), (n, 1), (1, n), (n, n)] {
                let law = LoadLaw {
                    ln_scale: (0..gains).map(|t| -11.7 + 0.01 * t as f64).collect(),
                    exponent: (0..exponents).map(|t| 0.85 + 0.003 * t as f64).collect(),
                    ..law.clone()
                };
                let mut grams = vec![0.0; n];
                law.grams_of_frame(&siemens, &mut grams);
                for (taxel, (grams, siemens)) in grams.iter().zip(&siemens).enumerate() {
                    let alone = law.grams_from_siemens(taxel, *siemens);
                    let same = (grams - alone).abs() <= 1e-14 * alone.abs();
                    assert!(same || grams.is_nan() && alone.is_nan(), "{grams} {alone}");
                }
            }
        }
    }

    #[test]
    fn numbers_that_are_loads_already_pass_as_they_are() {
        let law = LoadLaw::power(0.0, 1.0, 1.0);
        let siemens: Vec<f64> = (0..70).map(|t| 0.1 * f64::from(t) - 0.7).collect();
        let mut grams = vec![0.0; siemens.len()];
        law.grams_of_frame(&siemens, &mut grams);
        assert_eq!(grams, siemens);
        assert_eq!(law.grams_from_siemens(0, 0.3), 0.3);
    }

    #[test]
    fn the_power_law_is_the_formula() {
        let g = LoadLaw::power(1e-6, 8.29e-6, 0.857).siemens_from_grams(0, 100.0);
        assert!((g - (1e-6 + 8.29e-6 * 100f64.powf(0.857))).abs() < 1e-18);
    }

    #[test]
    fn a_saturating_taxel_at_its_half_load_acts_as_under_half_of_it() {
        let law = LoadLaw {
            saturation_load_g: Some(400.0),
            ..LoadLaw::power(0.0, 1e-6, 1.0)
        };
        assert!((law.siemens_from_grams(0, 400.0) - 200e-6).abs() < 1e-15);
    }
}
