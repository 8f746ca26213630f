//! A sensor file or a preset's name, with the per-taxel files beside it read in.

use std::path::{Path, PathBuf};

use crate::{
    Error, FrameSource, MAX_TAXELS, ReadOptions, SensorFileError, ValuesReader, bounded, positions,
};
use taxel::sensor::{PRESETS, SensorSpec, preset};
use taxel::{Frame, Sensor, Siemens};

/// The most memory that reading and solving may take, MiB.
pub const MAX_MEMORY_MIB: u64 = 256;

/// What is held of each taxel, bytes: frames before and after each step, marks, the inverse's own.
pub const TAXEL_BYTES: u64 = 640;

/// The longest sensor file, bytes: per-taxel numbers of 300 x 300 taxels. What is longer takes eighty times its length to
/// be understood, and memory stays below 256 MiB.
const MAX: u64 = 2 << 20;

/// Refuses what is too long to be a sensor file.
pub fn check_length(file: &Path, bytes: u64) -> Result<(), Error> {
    if bytes <= MAX {
        return Ok(());
    }
    Err(too_long(file))
}

fn too_long(file: &Path) -> Error {
    let file = file.to_owned();
    SensorFileError::Length { file, limit: MAX }.into()
}

/// Reads the sensor of a file or a preset. A file goes before a preset of the same name.
pub fn load(name: &Path) -> Result<Sensor, Error> {
    let in_file = |source| SensorFileError::Invalid {
        file: name.to_owned(),
        source,
    };
    let word = name.to_str().unwrap_or_default();
    let is_path = word.contains(['/', '\\', '.']) || name.exists();
    if !is_path {
        return Ok(preset(word).map_err(SensorFileError::Preset)?);
    }
    let mut spec = SensorSpec::from_toml(&text_of(name)?).map_err(in_file)?;
    let (rows, columns) = (spec.array.rows, spec.array.columns);
    check_array(name, rows, columns)?;
    let pitch_mm = spec.array.pitch_mm;
    spec.resolve(
        |file| per_taxel(&next_to(name, file), rows, columns),
        |file| positions::read(&next_to(name, file), pitch_mm),
    )?;
    Ok(Sensor::try_from(spec).map_err(in_file)?)
}

/// The text of a sensor file.
pub fn text_of(name: &Path) -> Result<String, Error> {
    match bounded::read_text(name, MAX) {
        Ok(Some(text)) => Ok(text),
        Ok(None) => Err(too_long(name)),
        Err(source) => Err(SensorFileError::Open {
            file: name.to_owned(),
            presets: PRESETS.map(|(name, _)| name).join(", "),
            source,
        }
        .into()),
    }
}

/// A file that a sensor file names: it is in the same folder.
pub fn next_to(sensor: &Path, name: &str) -> PathBuf {
    sensor.parent().unwrap_or(Path::new("")).join(name)
}

/// The numbers of a file beside the sensor file, one for each taxel.
fn per_taxel(file: &Path, rows: usize, columns: usize) -> Result<Vec<f64>, Error> {
    // The numbers have no unit; the reader does not ask.
    let mut reader = ValuesReader::<Siemens>::open(file, ReadOptions::new(rows, columns))?;
    let mut frame = Frame::zeros(rows, columns);
    let lines = |found| SensorFileError::PerTaxelLines {
        file: file.to_owned(),
        found,
        expected: rows,
    };
    if !reader.next_into(&mut frame)? {
        return Err(lines(0).into());
    }
    let numbers = frame.values().to_vec();
    match reader.next_into(&mut frame) {
        Ok(false) => Ok(numbers),
        _ => Err(lines(rows + 1).into()),
    }
}

/// Refuses an array whose frames are larger than is read; `file` is where it is described.
pub fn check_array(file: &Path, rows: usize, columns: usize) -> Result<(), Error> {
    let taxels = rows.saturating_mul(columns);
    if taxels <= MAX_TAXELS {
        Ok(())
    } else {
        Err(SensorFileError::ArrayMemory {
            file: file.to_owned(),
            rows,
            columns,
            needed_mib: (taxels as u64).saturating_mul(TAXEL_BYTES) >> 20,
            most_mib: MAX_MEMORY_MIB,
            most_taxels: MAX_TAXELS,
        }
        .into())
    }
}
