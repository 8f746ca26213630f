//! What is believed of a sensor before it is calibrated: stated, and overridden by the sensor file.

use super::CalibrationOptions;
use crate::Sensor;
use crate::parts::SWITCHES;
use crate::sensor::{PerLine, USUAL_OPEN_LOOP_GAIN};

/// A switch of which nothing is known, ohms, and the factor within which that is believed (one standard deviation).
pub(super) const USUAL_OHMS: f64 = 10.0;
pub(super) const WITHIN: f64 = 3.0;
/// The factor within which column and row switches are believed to be alike, or to differ as the file says.
pub(super) const ALIKE_WITHIN: f64 = 1.4;
/// Standard deviations of a bend of the law, and of 1/saturation, per kilogram: both are believed to be none.
pub(super) const BEND: f64 = 0.3;
pub(super) const SATURATION: f64 = 2.0;
/// Standard deviation of the share of a load that stands on one neighbour (a row or a column away: it is believed to be
/// none), and of the difference between the two.
pub(super) const SPREAD_SHARE: f64 = 0.05;
pub(super) const SPREAD_DIFFERENCE: f64 = 0.01;
/// What stands on a neighbour across the corner, as a part of that, and the standard deviation of this share of a load.
pub(super) const SPREAD_DIAGONAL: (f64, f64) = (0.2, 0.005);
/// Standard deviation of a sheet's 1/R_s, microsiemens: it is believed to be cut, and 10 kΩ is no surprise.
pub(super) const SHEET_MICROSIEMENS: f64 = 100.0;
/// Its contact factor, and what is believed of its logarithm.
pub(super) const USUAL_CONTACT_FACTOR: f64 = 3.0;
pub(super) const CONTACT_FACTOR: (f64, f64) = (1.098_612_288_668_109_8, std::f64::consts::LN_2);
/// Standard deviation of the ratio between uniform loads and labels of presses, as a logarithm: both are grams.
pub(super) const LEVEL_SCALE: f64 = 0.02;
/// What is believed of the logarithm of what a line resists from one taxel to the next, ohms: 1, within a factor of 10.
pub(super) const LINE_OHMS: (f64, f64) = (0.0, std::f64::consts::LN_10);
/// The factor within which a diode's I_s is believed: makers differ by two, and so do 10 °C.
const DIODE_WITHIN: f64 = 2.0;
/// No switch has less: a smaller number in the file stands for one that is not known.
const MIN_SWITCH_OHMS: f64 = 0.1;
/// A source resistor of which nothing is known, ohms.
const USUAL_SOURCE_OHMS: f64 = 10.0;

/// Means and standard deviations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Beliefs {
    /// Mean resistances of columns and rows, ohms.
    pub(super) column_ohms: f64,
    pub(super) row_ohms: f64,
    pub(super) exponent: (f64, f64),
    /// ln of the open-loop gain and of the source resistor, where they are to be found.
    pub(super) gain: Option<(f64, f64)>,
    pub(super) source: Option<(f64, f64)>,
    /// ln of the diodes' I_s, amperes, where there are any.
    pub(super) diode: Option<(f64, f64)>,
}

impl Beliefs {
    /// What a parts list and the options say.
    pub(super) fn of(sensor: &Sensor, options: &CalibrationOptions) -> Self {
        let readout = sensor.readout();
        let usual = named_switch(sensor.name()).unwrap_or(USUAL_OHMS);
        let mean = |list: &Option<PerLine>, lines| {
            let mean = list.as_ref().map(|l| l.mean(lines));
            mean.filter(|ohms| *ohms >= MIN_SWITCH_OHMS)
        };
        let column = mean(&readout.r_mux_column_ohms, sensor.columns());
        let row = mean(&readout.r_mux_row_ohms, sensor.rows());
        let factor = WITHIN.ln();
        let gain = readout.open_loop_gain().unwrap_or(USUAL_OPEN_LOOP_GAIN);
        let source = if readout.r_source_ohms > 0.0 {
            readout.r_source_ohms
        } else {
            USUAL_SOURCE_OHMS
        };
        Self {
            column_ohms: column.or(row).unwrap_or(usual),
            row_ohms: row.or(column).unwrap_or(usual),
            exponent: (0.85, 0.2),
            gain: (options.open_loop_gain && readout.has_amplifier())
                .then_some((gain.ln(), factor)),
            source: options.r_source.then_some((source.ln(), factor)),
            diode: (readout.diode).map(|diode| (diode.saturation_amperes.ln(), DIODE_WITHIN.ln())),
        }
    }

    /// ln of the sum of both resistances.
    pub(super) fn ln_sum(&self) -> (f64, f64) {
        ((self.column_ohms + self.row_ohms).ln(), WITHIN.ln())
    }

    /// ln of their ratio.
    pub(super) fn ln_ratio(&self) -> (f64, f64) {
        ((self.column_ohms / self.row_ohms).ln(), ALIKE_WITHIN.ln())
    }
}

/// The typical on-resistance of a switch that the sensor's name tells, ohms.
fn named_switch(name: &str) -> Option<f64> {
    let plain = |text: &str| -> String {
        let letters = text.chars().filter(char::is_ascii_alphanumeric);
        letters.map(|c| c.to_ascii_uppercase()).collect()
    };
    let name = plain(name);
    let part = SWITCHES.iter().find(|s| name.contains(&plain(s.name)));
    part.map(|part| part.typical_ohms)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensor::preset;

    #[test]
    fn a_part_in_the_name_is_believed_and_numbers_in_the_file_more() {
        let of = |name: Option<&str>, row: Option<f64>| {
            let sensor = preset("mat-16x16-cd4067").unwrap().edited(|spec| {
                spec.readout.r_mux_column_ohms = None;
                spec.readout.r_mux_row_ohms = row.map(PerLine::One);
                spec.name = name.unwrap_or(&spec.name).to_owned();
            });
            let beliefs = Beliefs::of(&sensor.unwrap(), &CalibrationOptions::default());
            (beliefs.column_ohms, beliefs.row_ohms)
        };
        assert_eq!(of(None, None).0, 70.0);
        assert_eq!(of(None, Some(3.0)), (3.0, 3.0));
        assert_eq!(of(Some("mine"), None).1, USUAL_OHMS);
    }
}
