//! Circuits with diodes: one in every taxel, or one in every driven line.

mod branch;
pub(crate) mod driven;
mod per_column;
pub(crate) mod taxel;

use super::network::LinearCircuit;
use super::{Circuit, LineEnds, OperatingPoint};
use crate::Error;
use crate::sensor::{Diode, DiodePlace, Sensor};
use branch::Junction;
use driven::DrivenDiodes;
pub(crate) use driven::{DrivenPoint, Dropped};
pub(crate) use taxel::Paths;

/// A sensor's circuit with its diodes ([theory.md]).
///
/// Its operating points are exact. Their derivatives leave out how leaks change with a taxel's conductance: at most what
/// leaks is of the signal, 1e-3 with silicon and 0.06 with Schottky diodes.
///
/// [theory.md]: https://github.com/taxel/taxel/blob/main/docs/theory.md
#[derive(Debug, Clone, PartialEq)]
pub struct DiodeCircuit {
    /// The same without diodes; columns behind a diode of their own are cut off by it.
    linear: LinearCircuit,
    diode: Diode,
    /// Between each driver that does not drive and its diode, ohms; empty where diodes stand elsewhere.
    rest_ohms: Vec<f64>,
}

impl DiodeCircuit {
    /// The circuit of a sensor; none where it has no diodes.
    ///
    /// # Errors
    /// As [`LinearCircuit::from_sensor`].
    pub fn from_sensor(sensor: &Sensor) -> Result<Option<Self>, Error> {
        let Some(diode) = sensor.readout().diode else {
            return Ok(None);
        };
        let mut ends = LineEnds::from_sensor(sensor)?;
        let rest_ohms = match diode.place {
            DiodePlace::DrivenLine => ends.cut_off_columns(),
            DiodePlace::Taxel => Vec::new(),
        };
        let linear = LinearCircuit::of_ends(sensor, ends)?;
        Ok(Some(Self {
            linear,
            diode,
            rest_ohms,
        }))
    }

    /// Where its diodes stand, and their numbers.
    pub fn diode(&self) -> Diode {
        self.diode
    }

    /// The same without diodes: what a driven line's diode leaves, seen from behind it.
    pub(crate) fn linear(&self) -> &LinearCircuit {
        &self.linear
    }

    /// What is needed to follow every taxel's own path.
    pub(crate) fn paths(&self) -> Paths {
        let junction = Junction::new(&self.diode);
        Paths::new(self.linear.ends(), junction, self.linear.lines())
    }

    /// What is needed to find what driven lines' diodes drop.
    fn driven(&self) -> DrivenDiodes {
        DrivenDiodes::new(self.linear.ends(), Junction::new(&self.diode))
    }
}

impl Circuit for DiodeCircuit {
    fn rows(&self) -> usize {
        self.linear.rows()
    }

    fn columns(&self) -> usize {
        self.linear.columns()
    }

    fn operating_point(&self) -> Box<dyn OperatingPoint> {
        match self.diode.place {
            DiodePlace::Taxel => Box::new(taxel::TaxelPoint::new(self)),
            DiodePlace::DrivenLine => Box::new(driven::DrivenPoint::new(self)),
        }
    }
}

#[cfg(test)]
mod tests;
