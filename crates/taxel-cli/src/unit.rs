//! The words of `--unit`, `--input-unit` and `--method`.

use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use clap::ValueEnum;
use taxel::Sensor;
use taxel::frame::grams_from_newtons;
use taxel::metric::kilopascals_from_newtons;
use taxel::solve::{Method, method};
use taxel_learn::{Learned, Model, with_law};

use crate::error::Error;
use crate::memory;

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

/// How loads are found.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
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
    /// A model that `taxel train` wrote
    Model(PathBuf),
}

impl FromStr for MethodName {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Ok(match text {
            "auto" => Self::Auto,
            "exact" => Self::Exact,
            "newton" => Self::Newton,
            "raw" => Self::Raw,
            file if Path::new(file).extension().is_some() || file.contains('/') => {
                Self::Model(PathBuf::from(file))
            }
            other => {
                return Err(format!(
                    "no method `{other}`; known: auto, exact, newton, raw, or the file of a model that `taxel train` wrote"
                ));
            }
        })
    }
}

impl fmt::Display for MethodName {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            MethodName::Auto => f.write_str("auto"),
            MethodName::Exact => f.write_str("exact"),
            MethodName::Newton => f.write_str("newton"),
            MethodName::Raw => f.write_str("raw"),
            MethodName::Model(file) => write!(f, "{}", file.display()),
        }
    }
}

impl MethodName {
    /// The file of a model.
    pub(crate) fn file(&self) -> Option<PathBuf> {
        match self {
            MethodName::Model(file) => Some(file.clone()),
            _ => None,
        }
    }

    /// The method for a sensor that comes from `file`.
    pub(crate) fn open(&self, sensor: &Sensor, file: &Path) -> Result<Box<dyn Method>, Error> {
        memory::check_method(sensor, file, self)?;
        match self {
            MethodName::Model(model) => Ok(Box::new(Learned::new(Model::read(model)?, sensor)?)),
            name => method(&name.to_string(), sensor).map_err(|source| Error::InFile {
                file: file.to_owned(),
                source,
            }),
        }
    }

    /// The sensor as the method needs it: a network's loads need a law, any law, to be carried.
    pub(crate) fn sensor(&self, sensor: &Sensor) -> Sensor {
        match self {
            MethodName::Model(_) => with_law(sensor.clone()),
            _ => sensor.clone(),
        }
    }
}
