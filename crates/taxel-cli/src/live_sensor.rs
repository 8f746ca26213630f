//! Which sensor a source is of: `--sensor`, or what the source brings.

use std::path::{Path, PathBuf};

use taxel::Sensor;
use taxel_acquire::Address;
use taxel_record::McapReader;

use crate::error::Error;
use crate::frames::is_mcap;
use crate::sensor_file;

/// The sensor, and where it comes from.
pub(crate) fn of(address: &Address, given: Option<&Path>) -> Result<(Sensor, PathBuf), Error> {
    if let Some(file) = given {
        return Ok((sensor_file::load(file)?, file.to_owned()));
    }
    match address {
        Address::Sim { sensor, .. } => {
            let file = PathBuf::from(sensor);
            Ok((sensor_file::load(&file)?, file))
        }
        Address::File { path, .. } => of_recording(path),
        other => Err(Error::Arguments {
            what: format!("{other} names no sensor"),
            hint: "pass --sensor with a sensor file or the name of a preset (econe, mat-16x16-cd4067, mat-32x32-adg732)",
        }),
    }
}

/// The sensor that a recording carries.
pub(crate) fn of_recording(path: &Path) -> Result<(Sensor, PathBuf), Error> {
    let carries = is_mcap(path);
    if carries {
        let reader = McapReader::open_any(path)?;
        if let Some(text) = reader.sensor_toml() {
            let in_file = |source| Error::InFile {
                file: path.to_owned(),
                source,
            };
            let sensor = Sensor::from_toml(text).and_then(Sensor::checked);
            return Ok((sensor.map_err(in_file)?, path.to_owned()));
        }
    }
    Err(Error::Arguments {
        what: format!("{} names no sensor", path.display()),
        hint: "pass --sensor with a sensor file or the name of a preset (econe, mat-16x16-cd4067, mat-32x32-adg732)",
    })
}
