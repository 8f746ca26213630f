//! What a recording brings beside its frames: its sensor, what it lost, what was taken off.

use std::path::{Path, PathBuf};

use taxel::Sensor;
use taxel_io::{Integrity, Tare};

use crate::error::Error;
use crate::hints::SENSOR;
use crate::out;
use taxel_app::frames::carries_sensor;
use taxel_app::sensor_source;
use taxel_app::units::Unit;
use taxel_io::sensor_file;

/// The sensor that is given, else the one that the recording carries; with where it comes from. `None` where neither
/// says one.
pub fn sensor(
    given: Option<&Path>,
    recording: Option<&Path>,
) -> Result<Option<(Sensor, PathBuf)>, Error> {
    if let Some(file) = given {
        return Ok(Some((sensor_file::load(file)?, file.to_owned())));
    }
    let Some(recording) = recording.filter(|file| carries_sensor(file)) else {
        return Ok(None);
    };
    let Some(found) = sensor_source::carried(recording)? else {
        return Ok(None);
    };
    out::note(&format!(
        "sensor `{}` as {} carries it",
        found.name(),
        recording.display()
    ));
    Ok(Some((found, recording.to_owned())))
}

/// As [`sensor`], where there must be one.
pub fn needed_sensor(
    given: Option<&Path>,
    recording: Option<&Path>,
) -> Result<(Sensor, PathBuf), Error> {
    let found = sensor(given, recording)?;
    found.ok_or_else(|| Error::Arguments {
        what: match recording {
            Some(file) => format!("{} names no sensor, and none is given", file.display()),
            None => "no sensor is given".to_owned(),
        },
        hint: SENSOR,
    })
}

/// Says what is missing from a recording; whether anything is.
pub fn tell_missing(file: &Path, integrity: &Integrity) -> bool {
    for words in integrity.words() {
        out::warn(&format!("{}: {words}", file.display()));
    }
    !integrity.is_whole()
}

/// Takes a recording's tare off loads, and says once that it does.
#[derive(Debug, Default)]
pub struct Untared {
    /// It was asked that nothing is taken off.
    off: bool,
    told: bool,
}

impl Untared {
    /// `off`: nothing is to be taken off.
    pub fn new(off: bool) -> Self {
        Self { off, told: false }
    }

    /// Takes off what was taken off while it was recorded. `raw`: the loads are not compensated.
    pub fn apply(
        &mut self,
        tare: Option<&Tare>,
        raw: bool,
        unit: Unit,
        area_mm2: f64,
        loads: &mut [f64],
    ) {
        let Some(tare) = tare.filter(|tare| unit.is_load() && tare.unit == "N") else {
            return;
        };
        let zeros = if raw { &tare.raw } else { &tare.loads };
        if zeros.len() != loads.len() {
            return;
        }
        if !self.told {
            self.told = true;
            let from = tare.from_sequence;
            out::note(&if self.off {
                format!("the tare of the recording, from frame number {from} on, is left out")
            } else {
                format!(
                    "the tare of the recording is taken off, from frame number {from} on (--no-tare leaves it out)"
                )
            });
        }
        if !self.off {
            for (load, zero) in loads.iter_mut().zip(zeros) {
                *load -= unit.of_newtons(*zero, area_mm2);
            }
        }
    }
}
