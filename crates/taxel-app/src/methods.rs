//! How conductances and loads are found: methods by name, learned models by file.

use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use taxel::Sensor;
use taxel::sensor::Topology;
use taxel::solve::{Method, method};
use taxel_io::sensor_file::{MAX_MEMORY_MIB, TAXEL_BYTES};
use taxel_learn::{Learned, Model, with_law};

use crate::error::Error;

/// How loads are found.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
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

    /// The method for a sensor that comes from `file`.
    pub fn open(&self, sensor: &Sensor, file: &Path) -> Result<Box<dyn Method>, Error> {
        check_memory(sensor, file, self)?;
        match self {
            MethodName::Model(model) => Ok(Box::new(Learned::new(Model::read(model)?, sensor)?)),
            name => method(&name.to_string(), sensor).map_err(|source| Error::InFile {
                file: file.to_owned(),
                source,
            }),
        }
    }

    /// The sensor as the method needs it: a network's loads need a law, any law, to be carried.
    pub fn sensor(&self, sensor: &Sensor) -> Sensor {
        match self {
            MethodName::Model(_) => with_law(sensor.clone()),
            _ => sensor.clone(),
        }
    }
}

/// What the exact inverse holds of each pair of sensed lines, bytes: ten square matrices.
const PAIR_BYTES: u64 = 80;

/// Refuses an inverse that would take more memory than there may be; `file` is where the sensor comes from.
pub fn check_memory(sensor: &Sensor, file: &Path, name: &MethodName) -> Result<(), Error> {
    let readout = &sensor.readout;
    let is_exact = readout.topology == Topology::TiaGroundedColumns && readout.r_source_ohms == 0.0;
    if !is_exact || !matches!(name, MethodName::Auto | MethodName::Exact) {
        return Ok(());
    }
    let rows = sensor.rows() as u64;
    let needed_mib =
        mib(rows * rows, PAIR_BYTES) + mib((sensor.rows() * sensor.columns()) as u64, TAXEL_BYTES);
    match needed_mib <= MAX_MEMORY_MIB {
        true => Ok(()),
        false => Err(Error::MethodMemory {
            file: file.to_owned(),
            rows: sensor.rows(),
            needed_mib,
            most_mib: MAX_MEMORY_MIB,
        }),
    }
}

fn mib(count: u64, bytes: u64) -> u64 {
    count.saturating_mul(bytes) >> 20
}
