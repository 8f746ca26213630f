//! Quantities and units of what is read and written.

use std::fmt;

use taxel::Sensor;
use taxel::frame::grams_from_newtons;
use taxel::metric::kilopascals_from_newtons;

/// Quantity and unit of what is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum InputUnit {
    /// What the converter gave
    Counts,
    /// V_out of the read-out circuit
    Volts,
    /// Conductances, cross-talk already removed
    Siemens,
}

/// Quantity and unit of what is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Unit {
    /// V_out of the read-out circuit
    Volts,
    /// Conductance of a taxel
    Siemens,
    /// Load, grams-force
    Grams,
    /// Load, newtons
    Newtons,
    /// Mean pressure on the taxel's area, kilopascals
    Kilopascals,
    /// Mean pressure on the taxel's area, megapascals
    Megapascals,
}

impl InputUnit {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Counts, Self::Volts, Self::Siemens];

    /// Its word.
    pub fn word(self) -> &'static str {
        match self {
            Self::Counts => "counts",
            Self::Volts => "volts",
            Self::Siemens => "siemens",
        }
    }

    /// What it is, in a few words.
    pub fn description(self) -> &'static str {
        match self {
            Self::Counts => "What the converter gave",
            Self::Volts => "V_out of the read-out circuit",
            Self::Siemens => "Conductances, cross-talk already removed",
        }
    }
}

impl Unit {
    /// All of them.
    pub const ALL: [Self; 6] = [
        Self::Volts,
        Self::Siemens,
        Self::Grams,
        Self::Newtons,
        Self::Kilopascals,
        Self::Megapascals,
    ];

    /// What it is, in a few words.
    pub fn description(self) -> &'static str {
        match self {
            Self::Volts => "V_out of the read-out circuit",
            Self::Siemens => "Conductance of a taxel",
            Self::Grams => "Load, grams-force",
            Self::Newtons => "Load, newtons",
            Self::Kilopascals => "Mean pressure on the taxel's area, kilopascals",
            Self::Megapascals => "Mean pressure on the taxel's area, megapascals",
        }
    }

    /// Its word.
    pub fn word(self) -> &'static str {
        match self {
            Unit::Volts => "volts",
            Unit::Siemens => "siemens",
            Unit::Grams => "g",
            Unit::Newtons => "N",
            Unit::Kilopascals => "kPa",
            Unit::Megapascals => "MPa",
        }
    }

    /// The unit as it stands beside a colour bar.
    pub fn symbol(self) -> &'static str {
        match self {
            Unit::Volts => "V",
            Unit::Siemens => "S",
            Unit::Kilopascals => "kPa",
            Unit::Megapascals => "MPa",
            Unit::Grams | Unit::Newtons => self.word(),
        }
    }

    /// What is measured in it.
    pub fn quantity(self) -> &'static str {
        match self {
            Unit::Volts => "voltage",
            Unit::Siemens => "conductance",
            Unit::Grams | Unit::Newtons => "load",
            Unit::Kilopascals | Unit::Megapascals => "pressure",
        }
    }

    /// Whether the load law is needed to get there.
    pub fn is_load(self) -> bool {
        !matches!(self, Unit::Volts | Unit::Siemens)
    }

    /// Whether a load in it is the number of its newtons; what is no load is shown as it is.
    fn is_newtons(self) -> bool {
        matches!(self, Unit::Newtons | Unit::Volts | Unit::Siemens)
    }

    /// A load in this unit.
    pub fn of_newtons(self, newtons: f64, area_mm2: f64) -> f64 {
        match self {
            Unit::Grams => grams_from_newtons(newtons),
            Unit::Kilopascals => kilopascals_from_newtons(newtons, area_mm2),
            Unit::Megapascals => 1e-3 * kilopascals_from_newtons(newtons, area_mm2),
            Unit::Newtons | Unit::Volts | Unit::Siemens => newtons,
        }
    }
}

/// Loads of taxels in a unit: a pressure by the taxel's own area, which a cone narrows.
#[derive(Debug, Clone)]
pub struct LoadUnit {
    unit: Unit,
    /// One for all, or one of each, mm².
    areas: Vec<f64>,
}

impl LoadUnit {
    /// Of a sensor's taxels.
    pub fn of(unit: Unit, sensor: &Sensor) -> Self {
        let taxels = if sensor.has_one_area() {
            1
        } else {
            sensor.rows() * sensor.columns()
        };
        let areas = (0..taxels).map(|taxel| sensor.taxel_area_mm2(taxel));
        Self {
            unit,
            areas: areas.collect(),
        }
    }

    /// The unit.
    pub fn unit(&self) -> Unit {
        self.unit
    }

    /// A taxel's load in the unit.
    pub fn from_newtons(&self, taxel: usize, newtons: f64) -> f64 {
        let area_mm2 = match self.areas[..] {
            [one] => one,
            ref each => each[taxel],
        };
        self.unit.of_newtons(newtons, area_mm2)
    }

    /// Loads of all taxels in the unit.
    pub(crate) fn all_from_newtons(&self, newtons: &[f64], out: &mut [f64]) {
        let pairs = out.iter_mut().zip(newtons);
        match self.areas[..] {
            _ if self.unit.is_newtons() => out.copy_from_slice(newtons),
            [one] => pairs.for_each(|(out, &newtons)| *out = self.unit.of_newtons(newtons, one)),
            ref each => pairs.zip(each).for_each(|((out, &newtons), &area_mm2)| {
                *out = self.unit.of_newtons(newtons, area_mm2);
            }),
        }
    }

    /// The newtons of all taxels' loads in the unit.
    pub(crate) fn all_newtons(&self, loads: &[f64], out: &mut [f64]) {
        if self.unit.is_newtons() {
            return out.copy_from_slice(loads);
        }
        let is_even = self.areas.len() == 1;
        let one = self.from_newtons(0, 1.0);
        for (taxel, (out, load)) in out.iter_mut().zip(loads).enumerate() {
            *out = load
                / if is_even {
                    one
                } else {
                    self.from_newtons(taxel, 1.0)
                };
        }
    }

    /// The newtons of a taxel's load in the unit.
    pub fn newtons(&self, taxel: usize, load: f64) -> f64 {
        load / self.from_newtons(taxel, 1.0)
    }
}

impl fmt::Display for Unit {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(self.word())
    }
}

impl fmt::Display for InputUnit {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(self.word())
    }
}

/// Three digits of a number, as print has it: of most measurements more are not known.
pub(crate) fn three_digits(value: f64) -> String {
    let decimals = if value == 0.0 {
        0.0
    } else {
        (2.0 - value.abs().log10().floor()).clamp(0.0, 3.0)
    };
    format!("{value:.0$}", decimals as usize).replace('-', "\u{2212}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn loads_of_all_taxels_are_those_of_each() {
        let newtons: Vec<f64> = (0..37).map(|n| f64::from(n * n) / 7.0 - 3.0).collect();
        let bits = |numbers: &[f64]| -> Vec<u64> { numbers.iter().map(|n| n.to_bits()).collect() };
        for unit in Unit::ALL {
            for areas in [vec![3.7], (1..38).map(f64::from).collect()] {
                let unit = LoadUnit { unit, areas };
                let (mut shown, mut back) = (vec![0.0; 37], vec![0.0; 37]);
                unit.all_from_newtons(&newtons, &mut shown);
                unit.all_newtons(&shown, &mut back);
                let pairs = newtons.iter().enumerate();
                let each: Vec<f64> = pairs.map(|(at, n)| unit.from_newtons(at, *n)).collect();
                assert_eq!(bits(&shown), bits(&each));
                let pairs = shown.iter().enumerate();
                let each: Vec<f64> = pairs.map(|(at, n)| unit.newtons(at, *n)).collect();
                assert_eq!(bits(&back), bits(&each));
            }
        }
    }
}
