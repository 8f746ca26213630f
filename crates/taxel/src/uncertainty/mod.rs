//! How far to trust a number: the converter's noise and rounding carried through the inverse and the load law.

mod beside;
mod conductance;
mod detached;
mod figures;
mod known;
mod load;
mod noise_bias;
mod sheet_doubt;
mod unmeasured;

pub(crate) use conductance::{Adjoint, influence_of, set_passive};
pub use conductance::{Uncertainty, standard_errors, standard_errors_by};
pub use figures::{FigureError, FigureErrors, FrameFigureErrors};
pub(crate) use known::{Known, is_left_out};
pub(crate) use load::noise_counts_of;
pub use load::{Parts, StandardErrors};
pub(crate) use noise_bias::take_off_siemens;
pub use noise_bias::{Bias, NoiseBias};

use crate::Sensor;
use crate::sensor::Sense;

/// Standard error that a taxel's conductance has at least, siemens: as if it were alone and the switches ideal.
pub(crate) fn least_error_siemens(sensor: &Sensor, sigma_volts: f64, siemens: f64) -> f64 {
    let readout = sensor.readout();
    let ohms = readout.sense.ohms();
    let slope = match readout.sense {
        Sense::Amplifier { .. } => 1.0,
        Sense::PullDown { .. } => (1.0 + ohms * siemens).powi(2),
    };
    slope * sigma_volts / (readout.v_test_volts * ohms)
}
