//! Sensors that are found by name.

use super::{Sensor, keys::nearest};
use crate::Error;

/// Name and sensor.toml of every shipped preset.
pub const PRESETS: [(&str, &str); 3] = [
    ("econe", include_str!("presets/econe.toml")),
    (
        "mat-16x16-cd4067",
        include_str!("presets/mat-16x16-cd4067.toml"),
    ),
    (
        "mat-32x32-adg732",
        include_str!("presets/mat-32x32-adg732.toml"),
    ),
];

/// The shipped sensor called `name`.
///
/// # Errors
/// [`Error::UnknownPreset`], naming the nearest and all others.
pub fn preset(name: &str) -> Result<Sensor, Error> {
    match PRESETS.iter().find(|(known, _)| *known == name) {
        Some((_, text)) => Sensor::from_toml(text),
        None => Err(Error::UnknownPreset {
            name: name.to_owned(),
            hint: nearest(name, PRESETS.iter().map(|(known, _)| *known)),
        }),
    }
}
