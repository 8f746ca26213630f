//! What an array would take in memory, judged before any of it is taken.
//!
//! A reader stays below [`MOST_MIB`]. Frames are bounded by their taxels, as recordings are; the exact inverse
//! works with square matrices of the sensed lines, which a long thin array makes large.

use std::path::Path;

use taxel::Sensor;
use taxel::sensor::Topology;
use taxel_io::MAX_TAXELS;

use crate::error::Error;
use crate::unit::MethodName;

/// The most memory that reading and solving may take, MiB.
const MOST_MIB: u64 = 256;

/// What a command holds of each taxel, bytes: frames before and after each step, marks, the inverse's own.
const TAXEL_BYTES: u64 = 640;

/// What the exact inverse holds of each pair of sensed lines, bytes: ten square matrices.
const PAIR_BYTES: u64 = 80;

/// Refuses an array whose frames are larger than is read; `file` is where it is described.
pub(crate) fn check_array(file: &Path, rows: usize, columns: usize) -> Result<(), Error> {
    let taxels = rows.saturating_mul(columns);
    match taxels <= MAX_TAXELS {
        true => Ok(()),
        false => Err(Error::ArrayMemory {
            file: file.to_owned(),
            rows,
            columns,
            needed_mib: mib(taxels as u64, TAXEL_BYTES),
            most_mib: MOST_MIB,
            most_taxels: MAX_TAXELS,
        }),
    }
}

/// Refuses an inverse that would take more memory than there may be; `file` is where the sensor comes from.
pub(crate) fn check_method(sensor: &Sensor, file: &Path, name: &MethodName) -> Result<(), Error> {
    let readout = sensor.readout();
    let is_exact = readout.topology == Topology::TiaGroundedColumns && readout.r_source_ohms == 0.0;
    if !is_exact || !matches!(name, MethodName::Auto | MethodName::Exact) {
        return Ok(());
    }
    let rows = sensor.rows() as u64;
    let needed_mib =
        mib(rows * rows, PAIR_BYTES) + mib((sensor.rows() * sensor.columns()) as u64, TAXEL_BYTES);
    match needed_mib <= MOST_MIB {
        true => Ok(()),
        false => Err(Error::MethodMemory {
            file: file.to_owned(),
            rows: sensor.rows(),
            needed_mib,
            most_mib: MOST_MIB,
        }),
    }
}

fn mib(count: u64, bytes: u64) -> u64 {
    count.saturating_mul(bytes) >> 20
}
