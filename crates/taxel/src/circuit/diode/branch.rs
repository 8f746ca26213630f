//! A taxel with its diode: the current through both at a voltage across both.
//!
//! v = i/g + n V_T ln(1 + i/I_s), solved for i by Wright's ω: i = α ω(z) − I_s with α = n V_T g, z = ln(I_s/α) + (v + I_s/g)/(n V_T),
//! where ω + ln ω = z, and di/dv = g ω/(1 + ω).

use crate::sensor::Diode;

/// The numbers of a diode as currents need them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Junction {
    /// I_s, amperes.
    pub(crate) saturation: f64,
    /// n V_T, volts.
    pub(crate) scale: f64,
    ln_saturation: f64,
}

impl Junction {
    pub(crate) fn new(diode: &Diode) -> Self {
        Self {
            saturation: diode.saturation_amperes,
            scale: diode.scale_volts(),
            ln_saturation: diode.saturation_amperes.ln(),
        }
    }

    /// What a current drops, volts; of a current that only noise turns round as much the other way.
    #[inline]
    pub(crate) fn drop(&self, amperes: f64) -> f64 {
        (self.scale * (amperes.abs() / self.saturation).ln_1p()).copysign(amperes)
    }

    /// d drop/d i, ohms.
    #[inline]
    pub(crate) fn drop_slope(&self, amperes: f64) -> f64 {
        self.scale / (amperes.abs() + self.saturation)
    }
}

/// A conductance with a diode in series.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Branch {
    /// g, siemens; nothing below 0.
    siemens: f64,
    /// n V_T g.
    alpha: f64,
    /// What z is at no voltage.
    z_zero: f64,
}

/// A current and its derivative by the voltage.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Current {
    pub(super) amperes: f64,
    pub(super) siemens: f64,
}

impl Branch {
    #[inline]
    pub(super) fn new(junction: &Junction, siemens: f64) -> Self {
        if siemens <= 0.0 {
            return Self::default();
        }
        let alpha = junction.scale * siemens;
        Self {
            siemens,
            alpha,
            z_zero: junction.ln_saturation - alpha.ln() + junction.saturation / alpha,
        }
    }

    /// The current from the diode's anode on, at a voltage across both.
    #[inline]
    pub(super) fn at(&self, junction: &Junction, volts: f64) -> Current {
        if self.siemens == 0.0 {
            return Current::default();
        }
        let w = wright_omega(self.z_zero + volts / junction.scale);
        Current {
            amperes: self.alpha * w - junction.saturation,
            siemens: self.siemens * w / (1.0 + w),
        }
    }

    /// g, siemens.
    #[inline]
    pub(super) fn conductance(&self) -> f64 {
        self.siemens
    }
}

/// ω with ω + ln ω = z, by the iteration of Fritsch, Shafer and Crowley (1973), to the last digits.
#[inline]
fn wright_omega(z: f64) -> f64 {
    let mut w = if z < -1.5 {
        let e = z.exp();
        if z < -18.0 {
            return e * (1.0 - e);
        }
        e * (1.0 - e * (1.0 - 1.5 * e))
    } else if z < 3.0 {
        let x = z - 1.0;
        // The first terms about z = 1, where ω = 1.
        1.0 + x * (0.5 + x * (0.0625 - x / 192.0))
    } else {
        let ln = z.ln();
        z - ln + ln / z
    };
    for _ in 0..2 {
        let residual = z - w - w.ln();
        let next = (1.0 + w) * (1.0 + w + 2.0 / 3.0 * residual);
        w *= 1.0 + residual / (1.0 + w) * (next - 0.5 * residual) / (next - residual);
    }
    w
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensor::{DiodePlace, DiodeSpec, preset};

    #[test]
    fn omega_solves_its_equation_everywhere() {
        let mut worst = 0f64;
        for i in -6000..40_000 {
            let z = f64::from(i) * 0.01;
            let w = wright_omega(z);
            let scale = z.abs().max(1.0);
            worst = worst.max((w + w.ln() - z).abs() / scale);
        }
        assert!(worst < 6e-16, "{worst:e}");
    }

    #[test]
    fn the_current_drops_the_voltage_over_both_and_its_slope_is_a_derivative() {
        let spec = DiodeSpec::new(DiodePlace::Taxel, 2e-7, 1.05);
        let sensor = preset("econe")
            .unwrap()
            .edited(|s| s.readout.diode = Some(spec));
        let junction = Junction::new(&sensor.unwrap().readout().diode.unwrap());
        for g in [1e-9, 1e-6, 1e-4, 1e-2] {
            let branch = Branch::new(&junction, g);
            for volts in [-3.0, -0.1, -1e-3, 0.0, 1e-3, 0.05, 0.4, 3.3] {
                let now = branch.at(&junction, volts);
                let ratio = now.amperes / junction.saturation;
                // Far below nothing, the current is −I_s to its last digit, which says no voltage.
                if ratio > -1.0 + 1e-9 {
                    let over = now.amperes / g + junction.scale * ratio.ln_1p();
                    assert!(
                        (over - volts).abs() < 1e-6 * volts.abs() + 1e-12,
                        "{g} {volts} {over}"
                    );
                }
                let step = 1e-5;
                let up = branch.at(&junction, volts + step).amperes;
                let down = branch.at(&junction, volts - step).amperes;
                let slope = (up - down) / (2.0 * step);
                assert!(
                    (slope - now.siemens).abs() < 1e-5 * g + 1e-13,
                    "{g} {volts}"
                );
            }
        }
    }
}
