//! Which sensor a source is of: `--sensor`, or what the source brings.

use std::path::{Path, PathBuf};

use taxel::Sensor;
use taxel::sensor::SensorSpec;
use taxel_acquire::Address;
use taxel_io::exports::{self, ExportAbout, Survey};
use taxel_io::{SensorFileError, sensor_toml_of};

use crate::error::Error;
use crate::frames::carries_sensor;
use taxel_io::sensor_file;

/// The sensor, and where it comes from.
pub fn of(address: &Address, given: Option<&Path>) -> Result<(Sensor, PathBuf), Error> {
    if let Some(file) = given {
        return Ok((sensor_file::load(file)?, file.to_owned()));
    }
    match address {
        Address::Sim { sensor, .. } => {
            let file = PathBuf::from(sensor);
            Ok((sensor_file::load(&file)?, file))
        }
        Address::File { path, .. } => of_recording(path),
        other => Err(Error::NoSensor {
            source_name: other.to_string(),
        }),
    }
}

/// The virtual sensor that an address names. Its frames may be taken to be of another one, such as what was calibrated of it: of
/// as many lines.
///
/// # Errors
/// A sensor file that cannot be read; another shape than `taken_for` has.
pub fn simulated(named: &str, taken_for: &Sensor) -> Result<Sensor, Error> {
    let sensor = sensor_file::load(Path::new(named))?;
    let shape = |of: &Sensor| [of.rows(), of.columns()];
    let ([rows, columns], [other_rows, other_columns]) = (shape(&sensor), shape(taken_for));
    if [rows, columns] != [other_rows, other_columns] {
        return Err(Error::Request {
            what: format!(
                "sim:{named} is of {rows} × {columns} taxels, and the sensor `{}` that is given for its frames of {other_rows} × {other_columns}",
                taken_for.name()
            ),
            hint: "the address names what is simulated, `sim:FILE?hand`; --sensor, what its readings are taken to be of",
        });
    }
    Ok(sensor)
}

/// The sensor that a recording (.mcap, .parquet) carries, if it carries one.
pub fn carried(path: &Path) -> Result<Option<Sensor>, Error> {
    let text = sensor_toml_of(path)?;
    text.map(|text| checked(path, &text)).transpose()
}

/// What the sensor that a recording carries says otherwise of how it was read than the one that it is taken to be of: with other bits
/// or volts the same counts are other loads. What a calibration fits is no disagreement. Empty where the recording carries none, or
/// cannot be read: that is told by who reads it.
pub fn disagreements(recording: &Path, sensor: &Sensor) -> Vec<String> {
    // What can be read once only is left to who reads it.
    if !(carries_sensor(recording) && recording.is_file()) {
        return Vec::new();
    }
    let Ok(Some(own)) = carried(recording) else {
        return Vec::new();
    };
    let keys = |of: &Sensor| {
        let (converter, readout) = (&of.spec().converter, &of.spec().readout);
        [
            ("converter.bits", converter.bits.to_string()),
            (
                "converter.full_scale_volts",
                converter.full_scale_volts.to_string(),
            ),
            ("converter.inverted", converter.inverted.to_string()),
            ("readout.topology", readout.topology.name().to_owned()),
            ("readout.v_test_volts", readout.v_test_volts.to_string()),
        ]
    };
    let each = keys(&own).into_iter().zip(keys(sensor));
    let differ = each.filter(|((_, own), (_, given))| own != given);
    differ
        .map(|((key, own), (_, given))| format!("{key} is {own} there and {given} here"))
        .collect()
}

/// The sensor of a file of another program, by a reading of it through.
pub fn exported(path: &Path, about: &ExportAbout, survey: &Survey) -> Result<Sensor, Error> {
    checked(path, &exports::sensor_by(path, about, survey).to_toml())
}

/// The same sensor with the whole header of the file that it stands for: with names of persons and of files, which are left out else
/// of all that is written. Of any other recording, and a sensor that was given for it, as it is.
pub fn with_names(sensor: Sensor, recording: &Path) -> Result<Sensor, Error> {
    if sensor.exported().is_none() {
        return Ok(sensor);
    }
    let Some(about) = exports::about(recording)? else {
        return Ok(sensor);
    };
    let mut spec = SensorSpec::from_toml(&sensor.to_toml())?;
    if let Some(exported) = &mut spec.exported {
        exported.header = (!about.header.is_empty()).then_some(about.header);
    }
    checked(recording, &spec.to_toml())
}

fn checked(path: &Path, text: &str) -> Result<Sensor, Error> {
    sensor_file::check_length(path, text.len() as u64)?;
    let sensor = Sensor::from_toml(text).map_err(|source| SensorFileError::Invalid {
        file: path.to_owned(),
        source,
    });
    let sensor = sensor.map_err(taxel_io::Error::from)?;
    sensor_file::check_array(path, sensor.rows(), sensor.columns())?;
    Ok(sensor)
}

/// The sensor that a recording carries.
pub fn of_recording(path: &Path) -> Result<(Sensor, PathBuf), Error> {
    if carries_sensor(path)
        && let Some(sensor) = carried(path)?
    {
        return Ok((sensor, path.to_owned()));
    }
    Err(Error::NoSensor {
        source_name: path.display().to_string(),
    })
}
