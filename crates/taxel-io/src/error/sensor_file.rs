//! What can go wrong between a sensor file and a sensor.

use std::io;
use std::path::PathBuf;

/// Why there is no sensor.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SensorFileError {
    /// The sensor file cannot be read.
    #[error("cannot open {}: {source}\nhint: a sensor is a file, or one of the presets {presets}", .file.display())]
    Open {
        /// The file.
        file: PathBuf,
        /// The names of the presets.
        presets: String,
        /// The system's reason.
        source: io::Error,
    },
    /// A file that is too long to be a sensor's.
    #[error("{}: more than {limit} bytes, no sensor file has so many\nhint: is this a recording? per-taxel numbers of large arrays go in a .csv beside it", .file.display())]
    Length {
        /// The file, or the recording that carries it.
        file: PathBuf,
        /// The most it may have.
        limit: u64,
    },
    /// An array whose frames are larger than is read.
    #[error("{}: {rows} rows x {columns} columns need about {needed_mib} MiB of memory, at most {most_mib} are taken: an array has at most {most_taxels} taxels\nhint: check rows and columns; a larger sensor is read in parts, each with a sensor file of its own", .file.display())]
    ArrayMemory {
        /// The sensor file, or the recording that carries it.
        file: PathBuf,
        /// Rows of the array.
        rows: usize,
        /// Its columns.
        columns: usize,
        /// What it would take, MiB.
        needed_mib: u64,
        /// The most that is taken, MiB.
        most_mib: u64,
        /// The most taxels.
        most_taxels: usize,
    },
    /// A file of per-taxel numbers holds more than one number per taxel.
    #[error(
        "{}: {found} lines or more, but the array has {expected} rows\nhint: a file of per-taxel numbers has one line per row", .file.display()
    )]
    PerTaxelLines {
        /// The file.
        file: PathBuf,
        /// Lines found, at least.
        found: usize,
        /// Rows of the array.
        expected: usize,
    },
    /// A preset of a name that there is not.
    #[error(transparent)]
    Preset(taxel::Error),
    /// The sensor file, or the one that a recording carries, makes no sense.
    #[error("{}: {source}", .file.display())]
    Invalid {
        /// The file, or the preset's name.
        file: PathBuf,
        /// Why.
        source: taxel::Error,
    },
}
