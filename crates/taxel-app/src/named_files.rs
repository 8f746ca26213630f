//! Files that are read because another file names them, found before any work, so that no output replaces one.
//!
//! What cannot be read names nothing here: why, is said where it is read in earnest. Standard input and pipes are not
//! looked at, since they can be read once only.

use std::path::{Path, PathBuf};

use taxel::sensor::{PerTaxel, SensorSpec};

use crate::evaluation::plan;
use taxel_io::sensor_file;

/// The files of per-taxel numbers that a sensor file names.
pub fn of_sensor(file: &Path) -> Vec<PathBuf> {
    if !file.is_file() {
        return Vec::new();
    }
    let text = sensor_file::text_of(file);
    let Some(sensor) = text.ok().and_then(|text| SensorSpec::from_toml(&text).ok()) else {
        return Vec::new();
    };
    let Some(material) = sensor.material else {
        return Vec::new();
    };
    let values = [Some(material.exponent), material.gain];
    let named = values
        .into_iter()
        .flatten()
        .filter_map(|value| match value {
            PerTaxel::File(name) => Some(sensor_file::next_to(file, &name)),
            _ => None,
        });
    named.collect()
}

/// The recordings that a table of presses, of uniform loads or of trials names.
pub fn of_table(file: &Path) -> Vec<PathBuf> {
    if file.is_file() {
        taxel_io::recordings_named_in(file).unwrap_or_default()
    } else {
        Vec::new()
    }
}

/// Everything that the plan of an evaluation names, and what that names in turn.
pub fn of_plan(file: &Path) -> Vec<PathBuf> {
    if !file.is_file() {
        return Vec::new();
    }
    let Ok(named) = plan::names(file) else {
        return Vec::new();
    };
    let mut all = Vec::new();
    for sensor in named.sensors {
        all.extend(of_sensor(&sensor));
        all.push(sensor);
    }
    for table in named.tables {
        all.extend(of_table(&table));
        all.push(table);
    }
    all.extend(named.others);
    all
}
