//! The words of `--unit`, `--input-unit` and `--method`.

use clap::ValueEnum;
use taxel::frame::grams_from_newtons;
use taxel::metric::kilopascals_from_newtons;

/// Quantity and unit of what is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum InputUnit {
    /// What the converter gave
    Counts,
    /// V_out of the read-out circuit
    Volts,
    /// Conductances, cross-talk already removed
    Siemens,
}

/// Quantity and unit of what is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Unit {
    /// V_out of the read-out circuit
    Volts,
    /// Conductance of a taxel
    Siemens,
    /// Load, grams-force
    #[value(name = "g")]
    Grams,
    /// Load, newtons
    #[value(name = "N")]
    Newtons,
    /// Mean pressure on the taxel's area, kilopascals
    #[value(name = "kPa")]
    Kilopascals,
    /// Mean pressure on the taxel's area, megapascals
    #[value(name = "MPa")]
    Megapascals,
}

impl Unit {
    /// Its word on the command line.
    pub(crate) fn word(self) -> &'static str {
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
    pub(crate) fn symbol(self) -> &'static str {
        match self {
            Unit::Volts => "V",
            Unit::Siemens => "S",
            Unit::Kilopascals => "kPa",
            Unit::Megapascals => "MPa",
            Unit::Grams | Unit::Newtons => self.word(),
        }
    }

    /// What is measured in it.
    pub(crate) fn quantity(self) -> &'static str {
        match self {
            Unit::Volts => "voltage",
            Unit::Siemens => "conductance",
            Unit::Grams | Unit::Newtons => "load",
            Unit::Kilopascals | Unit::Megapascals => "pressure",
        }
    }

    /// Whether the load law is needed to get there.
    pub(crate) fn is_load(self) -> bool {
        !matches!(self, Unit::Volts | Unit::Siemens)
    }

    /// A load in this unit.
    pub(crate) fn of_newtons(self, newtons: f64, area_mm2: f64) -> f64 {
        match self {
            Unit::Grams => grams_from_newtons(newtons),
            Unit::Kilopascals => kilopascals_from_newtons(newtons, area_mm2),
            Unit::Megapascals => 1e-3 * kilopascals_from_newtons(newtons, area_mm2),
            Unit::Newtons | Unit::Volts | Unit::Siemens => newtons,
        }
    }
}

/// How conductances are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub(crate) enum MethodName {
    /// What suits the read-out
    #[default]
    Auto,
    /// The e-Cone's closed iteration
    Exact,
    /// Every linear read-out
    Newton,
    /// No compensation
    Raw,
}

impl MethodName {
    /// Its word on the command line.
    pub(crate) fn word(self) -> &'static str {
        match self {
            MethodName::Auto => "auto",
            MethodName::Exact => "exact",
            MethodName::Newton => "newton",
            MethodName::Raw => "raw",
        }
    }
}
