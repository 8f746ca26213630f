//! Forward: what a scan of given conductances reads. [theory.md] has the derivation.
//!
//! A reading is `converter(noise(circuit(G)))`; the three are separate parts: [`LinearCircuit`] (every
//! topology whose parts are linear), [`Noise`], [`Converter`].
//!
//! Inside, the sensor is a network of R + C ports, the ends of its lines. Whatever it consists of, the readings need P_rr,
//! Q_cc and K_rc of its inverse port matrix with nothing selected: `network` finds them (lines without resistance, under a
//! sheet, lines that resist), `ends` says what hangs on the ports, `reading` makes voltages of both.
//!
//! [theory.md]: https://github.com/taxel/taxel/blob/main/docs/theory.md

mod converter;
pub(crate) mod diode;
mod ends;
pub mod netlist;
pub(crate) mod network;
mod reading;
pub mod simplified;

pub(crate) use converter::normal;
pub use converter::{Converter, Noise, NoiseDraws, ROUNDING_COUNTS};
pub use diode::DiodeCircuit;
pub use ends::{LineEnds, OfLines};
pub use network::{LineResistance, LinearCircuit, LinearPoint};

use crate::{Error, Frame, Sensor, Siemens, Volts};

/// A circuit that a frame of conductances is scanned by.
///
/// Nothing here assumes a closed form: a circuit with a diode per taxel implements the same three operations at an
/// operating point.
pub trait Circuit: Send + Sync {
    /// Sensed lines.
    fn rows(&self) -> usize;
    /// Driven lines.
    fn columns(&self) -> usize;
    /// Memory for solving this circuit, with no conductances set yet.
    fn operating_point(&self) -> Box<dyn OperatingPoint>;

    /// The scan of one frame: V_out of every taxel, volts. Allocates; streams use an [`OperatingPoint`].
    ///
    /// # Errors
    /// [`NotPassive`] when the conductances are so negative that the network has no solution.
    fn predict(&self, siemens: &Frame<Siemens>) -> Result<Frame<Volts>, NotPassive> {
        let mut point = self.operating_point();
        point.set(siemens.values())?;
        let mut volts = siemens.map(|_, _| 0.0);
        point.predict_into(volts.values_mut());
        Ok(volts)
    }
}

/// A sensor's circuit, whatever it is made of.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum SensorCircuit {
    /// Linear parts alone.
    Linear(LinearCircuit),
    /// Diodes in taxels or in driven lines.
    Diodes(DiodeCircuit),
}

impl SensorCircuit {
    /// The circuit of a sensor.
    ///
    /// # Errors
    /// [`Error::MissingKey`] when a switch resistance is not known yet; as [`LinearCircuit::from_sensor`].
    pub fn from_sensor(sensor: &Sensor) -> Result<Self, Error> {
        Ok(match DiodeCircuit::from_sensor(sensor)? {
            Some(diodes) => Self::Diodes(diodes),
            None => Self::Linear(LinearCircuit::from_sensor(sensor)?),
        })
    }
}

impl Circuit for SensorCircuit {
    fn rows(&self) -> usize {
        match self {
            Self::Linear(circuit) => circuit.rows(),
            Self::Diodes(circuit) => circuit.rows(),
        }
    }

    fn columns(&self) -> usize {
        match self {
            Self::Linear(circuit) => circuit.columns(),
            Self::Diodes(circuit) => circuit.columns(),
        }
    }

    fn operating_point(&self) -> Box<dyn OperatingPoint> {
        match self {
            Self::Linear(circuit) => circuit.operating_point(),
            Self::Diodes(circuit) => circuit.operating_point(),
        }
    }
}

/// The conductances given make an active network: its equations are not positive definite.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error(
    "these conductances make the network active: no scan exists\nhint: conductances must not be negative"
)]
pub struct NotPassive;

/// A circuit solved at one frame of conductances, and its exact derivative there.
/// All slices hold one value per taxel, row by row.
pub trait OperatingPoint: Send {
    /// Solves the network for these conductances, siemens.
    ///
    /// # Errors
    /// [`NotPassive`] when they are so negative that the network has no solution.
    fn set(&mut self, siemens: &[f64]) -> Result<(), NotPassive>;
    /// V_out of every taxel, volts.
    fn predict_into(&self, volts: &mut [f64]);
    /// J·v: change of V_out (volts) along a change of conductances (siemens).
    fn jvp_into(&mut self, direction: &[f64], out: &mut [f64]);
    /// Jᵀ·w: the gradient of Σ w·V_out by the conductances.
    fn vjp_into(&mut self, weights: &[f64], out: &mut [f64]);
}
