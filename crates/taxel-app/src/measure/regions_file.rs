//! Named regions in a file of their own.

use std::path::Path;

use serde::{Deserialize, Serialize};
use taxel::Sensor;
use taxel::sensor::{Region, RegionSpec};

use crate::error::Error;
use crate::text_file;

/// The longest file of regions, bytes: as long as a sensor file.
const MAX: u64 = 2 << 20;

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct RegionsFile {
    #[serde(default, rename = "region")]
    regions: Vec<RegionSpec>,
}

/// The text of such a file.
pub fn regions_to_toml(regions: &[RegionSpec]) -> String {
    let file = RegionsFile {
        regions: regions.to_vec(),
    };
    toml::to_string(&file).expect("regions are plain data")
}

/// The regions of a sensor that a TOML file names, a `[[region]]` each.
///
/// # Errors
/// A file that cannot be read, is no TOML, has another key, names no region, or one that the sensor cannot have.
pub fn regions_of_file(file: &Path, sensor: &Sensor) -> Result<Vec<Region>, Error> {
    let specs = region_specs_of_file(file)?;
    Region::all(&specs, sensor).map_err(|source| Error::InFile {
        file: file.to_owned(),
        source,
    })
}

/// The same of a recording: regions that move in it are there once for each window of time, with `frames`.
///
/// # Errors
/// As [`regions_of_file`]; two windows of one region that overlap.
pub fn recording_regions_of_file(file: &Path, sensor: &Sensor) -> Result<Vec<Region>, Error> {
    let specs = region_specs_of_file(file)?;
    Region::of_recording(&specs, sensor).map_err(|source| Error::InFile {
        file: file.to_owned(),
        source,
    })
}

/// The same as the file says them, whatever the sensor.
pub(crate) fn region_specs_of_file(file: &Path) -> Result<Vec<RegionSpec>, Error> {
    let text = text_file::read(file, "a file of regions", MAX)?;
    let read: RegionsFile = toml::from_str(&text).map_err(|source| Error::Request {
        what: format!("{}: {}", file.display(), source.to_string().trim_end()),
        hint: "a [[region]] each, with `name`, and `boxes` or `outline`",
    })?;
    if read.regions.is_empty() {
        return Err(Error::Request {
            what: format!("{}: there is no region in it", file.display()),
            hint: "a [[region]] each, with `name`, and `boxes` or `outline`",
        });
    }
    Ok(read.regions)
}
