//! How conductances and loads are found: methods by name, learned models by file.

use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use taxel::Sensor;
use taxel::estimate::LoadEstimator;
use taxel::pipeline::Pipeline;
use taxel::solve::{Method, method};
use taxel_io::sensor_file::{MAX_MEMORY_MIB, TAXEL_BYTES};
use taxel_learn::{Learned, Model};

use crate::error::Error;

/// How loads are found.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum MethodName {
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

/// What a name of a method stands for.
pub enum Opened {
    /// Volts to conductances.
    Method(Box<dyn Method>),
    /// Volts to loads.
    Estimator(Box<dyn LoadEstimator>),
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
                    "no method `{other}`; known: auto, exact, newton, raw, or the file of a trained model"
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
    pub fn file(&self) -> Option<PathBuf> {
        match self {
            MethodName::Model(file) => Some(file.clone()),
            _ => None,
        }
    }

    /// Whether it undoes the circuit, so that the noise of readings can be carried through to loads.
    pub fn inverts(&self) -> bool {
        !matches!(self, MethodName::Raw | MethodName::Model(_))
    }

    /// Whether it estimates loads, and no conductances.
    pub fn is_model(&self) -> bool {
        matches!(self, MethodName::Model(_))
    }

    /// Counts to loads by it, for a sensor that comes from `file`; to conductances where the sensor has no load law.
    ///
    /// # Errors
    /// A model that cannot be read or does not suit the sensor; a circuit that is not known.
    pub fn pipeline(&self, sensor: &Sensor, file: &Path) -> Result<Pipeline, Error> {
        match self.open(sensor, file)? {
            Opened::Method(method) => {
                Pipeline::new(sensor, method).map_err(|source| Error::InFile {
                    file: file.to_owned(),
                    source,
                })
            }
            Opened::Estimator(estimator) => Ok(Pipeline::with_estimator(sensor, estimator)),
        }
    }

    /// What stands behind the name, for a sensor that comes from `file`.
    ///
    /// # Errors
    /// As [`Self::pipeline`].
    pub fn open(&self, sensor: &Sensor, file: &Path) -> Result<Opened, Error> {
        check_memory(sensor, file, self)?;
        if let MethodName::Model(model) = self {
            let learned = Learned::new(Model::read(model)?, sensor)?;
            return Ok(Opened::Estimator(Box::new(learned)));
        }
        let method = method(&self.to_string(), sensor).map_err(|source| Error::InFile {
            file: file.to_owned(),
            source,
        })?;
        Ok(Opened::Method(method))
    }
}

/// What the exact inverse holds of each pair of sensed lines, bytes: ten square matrices.
const PAIR_BYTES: u64 = 80;

/// Refuses an inverse that would take more memory than there may be; `file` is where the sensor comes from.
pub fn check_memory(sensor: &Sensor, file: &Path, name: &MethodName) -> Result<(), Error> {
    let readout = sensor.readout();
    let is_exact =
        readout.has_amplifier() && readout.table.sensed.is_open() && readout.r_source_ohms == 0.0;
    if !is_exact || !matches!(name, MethodName::Auto | MethodName::Exact) {
        return Ok(());
    }
    let rows = sensor.rows() as u64;
    let needed_mib =
        mib(rows * rows, PAIR_BYTES) + mib((sensor.rows() * sensor.columns()) as u64, TAXEL_BYTES);
    if needed_mib <= MAX_MEMORY_MIB {
        Ok(())
    } else {
        Err(Error::MethodMemory {
            file: file.to_owned(),
            rows: sensor.rows(),
            needed_mib,
            most_mib: MAX_MEMORY_MIB,
        })
    }
}

fn mib(count: u64, bytes: u64) -> u64 {
    count.saturating_mul(bytes) >> 20
}
