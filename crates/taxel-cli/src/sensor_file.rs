//! `--sensor`: a file or a preset's name, with the per-taxel files beside it read in.

use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};

use taxel::sensor::{PRESETS, PerTaxel, preset};
use taxel::{Frame, Sensor, Siemens};
use taxel_record::{FrameSource, TextOptions, ValuesReader};

use crate::error::Error;

/// The longest sensor file, bytes: per-taxel numbers of 500 x 500 taxels. What is longer takes fifty times its length to
/// be understood.
const LONGEST: u64 = 4 << 20;

/// Refuses what is too long to be a sensor file.
pub(crate) fn check_length(file: &Path, bytes: u64) -> Result<(), Error> {
    if bytes <= LONGEST {
        return Ok(());
    }
    Err(Error::SensorLength {
        file: file.to_owned(),
        limit: LONGEST,
    })
}

/// Reads the sensor that `--sensor` names. A file goes before a preset of the same name.
pub(crate) fn load(name: &Path) -> Result<Sensor, Error> {
    let in_file = |source| Error::InFile {
        file: name.to_owned(),
        source,
    };
    let word = name.to_str().unwrap_or_default();
    let is_path = word.contains(['/', '\\', '.']) || name.exists();
    if !is_path {
        return Ok(preset(word)?);
    }
    let failed = |source| Error::OpenSensor {
        file: name.to_owned(),
        presets: PRESETS.map(|(name, _)| name).join(", "),
        source,
    };
    let mut text = String::new();
    let file = fs::File::open(name).map_err(failed)?;
    // One byte more than may be, and no more: a device has no end.
    let read = file.take(LONGEST + 1).read_to_string(&mut text);
    check_length(name, text.len() as u64)?;
    read.map_err(failed)?;
    let mut sensor = Sensor::from_toml(&text).map_err(in_file)?;
    let (rows, columns) = (sensor.rows(), sensor.columns());
    if let Some(material) = &mut sensor.material {
        read_in(&mut material.exponent, name, rows, columns)?;
        if let Some(gain) = &mut material.gain {
            read_in(gain, name, rows, columns)?;
        }
    }
    sensor.checked().map_err(in_file)
}

/// Puts the numbers of the file beside the sensor file in the place of its name.
fn read_in(values: &mut PerTaxel, sensor: &Path, rows: usize, columns: usize) -> Result<(), Error> {
    let PerTaxel::File(name) = values else {
        return Ok(());
    };
    let file: PathBuf = sensor.parent().unwrap_or(Path::new("")).join(&*name);
    // The numbers have no unit; the reader does not ask.
    let mut reader = ValuesReader::<Siemens>::open(&file, TextOptions::new(rows, columns))?;
    let mut frame = Frame::zeros(rows, columns);
    if !reader.next_into(&mut frame)? {
        return Ok(());
    }
    let lines = frame.values().chunks_exact(columns);
    *values = PerTaxel::Each(lines.map(<[f64]>::to_vec).collect());
    match reader.next_into(&mut frame) {
        Ok(false) => Ok(()),
        _ => Err(Error::PerTaxelLines {
            file,
            found: rows + 1,
            expected: rows,
        }),
    }
}
