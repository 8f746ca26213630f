//! What a recording brings beside its frames: its sensor, what it lost, what was taken off.

use std::path::{Path, PathBuf};

use taxel::Sensor;
use taxel_acquire::Address;
use taxel_io::{Integrity, Tare};

use crate::error::Error;
use crate::hints::SENSOR;
use crate::out;
use taxel_app::exported::exported_words;
use taxel_app::frames::carries_sensor;
use taxel_app::sensor_source;
use taxel_app::tare;
use taxel_app::units::{LoadUnit, Unit};
use taxel_io::exports::{ExportAbout, Survey};
use taxel_io::sensor_file;

/// The sensor that is given, else the one that the recording carries; with where it comes from. `None` where neither
/// says one.
pub fn sensor(
    given: Option<&Path>,
    recording: Option<&Path>,
) -> Result<Option<(Sensor, PathBuf)>, Error> {
    if let Some(file) = given {
        let sensor = sensor_file::load(file)?;
        if let Some(recording) = recording {
            doubt_other_sensor(recording, &sensor, file);
        }
        return Ok(Some((sensor, file.to_owned())));
    }
    let Some(recording) = recording.filter(|file| carries_sensor(file)) else {
        return Ok(None);
    };
    let found = sensor_source::carried(recording)?;
    Ok(found.map(|found| told(found, recording)))
}

/// The sensor of a file of another program, by a reading of it through.
pub fn exported_sensor(
    file: &Path,
    about: &ExportAbout,
    survey: &Survey,
) -> Result<(Sensor, PathBuf), Error> {
    Ok(told(sensor_source::exported(file, about, survey)?, file))
}

/// Warns of a recording that says itself that it was read otherwise than a sensor file has it.
pub fn doubt_other_sensor(recording: &Path, sensor: &Sensor, file: &Path) {
    let differ = sensor_source::disagreements(recording, sensor);
    if !differ.is_empty() {
        out::warn(&format!(
            "{} carries another sensor than {}: {}; loads are wrong if it is right",
            recording.display(),
            file.display(),
            differ.join(", ")
        ));
    }
}

/// Says that a recording's own sensor is taken.
fn told(found: Sensor, recording: &Path) -> (Sensor, PathBuf) {
    out::note(&format!(
        "sensor `{}` as {} carries it",
        found.name(),
        recording.display()
    ));
    if let Some(words) = exported_words(&found) {
        out::note(&words);
    }
    (found, recording.to_owned())
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

/// The sensor as it is written: with the names that its header has, where they are `wanted`.
pub fn named(sensor: Sensor, recording: &Path, wanted: bool) -> Result<Sensor, Error> {
    if wanted {
        Ok(sensor_source::with_names(sensor, recording)?)
    } else {
        Ok(sensor)
    }
}

/// The same of an address: a file's names; other sources have none.
pub fn named_of(address: &Address, sensor: Sensor, wanted: bool) -> Result<Sensor, Error> {
    match address {
        Address::File { path, .. } => named(sensor, path, wanted),
        _ => Ok(sensor),
    }
}

/// Refuses loads that another program has found where the readings of a circuit are asked for.
pub fn needs_readings(sensor: &Sensor) -> Result<(), Error> {
    match sensor.exported() {
        Some(exported) => Err(Error::Arguments {
            what: format!(
                "these are loads as {} has exported them, and no readings of a circuit",
                exported.program
            ),
            hint: "a sensor file of your own (--sensor) tells circuit and converter; Tekscan's calibrated exports give raw counts by it",
        }),
        None => Ok(()),
    }
}

/// Says what is missing from a recording; whether anything is.
pub fn tell_missing(file: &Path, integrity: &Integrity) -> bool {
    for words in integrity.words() {
        out::warn(&format!("{}: {words}", file.display()));
    }
    !integrity.is_whole()
}

/// Says once that a recording's tare is taken off, or is not.
#[derive(Debug, Default)]
pub struct TareNote {
    /// It was asked that nothing is taken off.
    off: bool,
    told: bool,
}

impl TareNote {
    /// `off`: nothing is to be taken off.
    pub fn new(off: bool) -> Self {
        Self { off, told: false }
    }

    /// Says so of the first frame that has one for so many loads. `raw`: they are not compensated.
    pub fn tell(&mut self, tare: Option<&Tare>, raw: bool, unit: Unit, loads: usize) {
        let Some(tare) = tare.filter(|_| !self.told) else {
            return;
        };
        if tare::zeros(tare, raw, unit, loads).is_none() {
            return;
        }
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
}

/// Takes a recording's tare off loads, and says once that it does.
#[derive(Debug, Default)]
pub struct Untared {
    note: TareNote,
}

impl Untared {
    /// `off`: nothing is to be taken off.
    pub fn new(off: bool) -> Self {
        Self {
            note: TareNote::new(off),
        }
    }

    /// Takes off what was taken off while it was recorded. `raw`: the loads are not compensated.
    pub fn apply(
        &mut self,
        tare: Option<&Tare>,
        raw: bool,
        load_unit: &LoadUnit,
        loads: &mut [f64],
    ) {
        let unit = load_unit.unit();
        self.note.tell(tare, raw, unit, loads.len());
        let zeros = tare.filter(|_| !self.note.off);
        let zeros = zeros.and_then(|tare| tare::zeros(tare, raw, unit, loads.len()));
        if let Some(zeros) = zeros {
            tare::take_off(zeros, load_unit, loads);
        }
    }
}
