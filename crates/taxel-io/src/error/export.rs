//! What is wrong with a file that another program has exported.

use std::path::PathBuf;

use super::Place;

/// What is wrong with a file that another program has exported.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ExportError {
    /// Something that its format does not have there.
    #[error("{format}: {found} at {at}, expected {expected}\nhint: {hint}")]
    Line {
        /// The format.
        format: &'static str,
        /// Where it stands.
        at: Place,
        /// What stands there.
        found: String,
        /// What should.
        expected: String,
        /// What to do.
        hint: &'static str,
    },
    /// A sensor that cannot be, by what the file says of its size.
    #[error(
        "{format}: {rows} rows x {columns} columns at {at}, expected 1 to {limit} sensels in all\nhint: what the file says of its size is broken, or of another"
    )]
    Size {
        /// The format.
        format: &'static str,
        /// Where the file says it.
        at: Place,
        /// Rows that it says.
        rows: usize,
        /// Columns that it says.
        columns: usize,
        /// The most sensels of a sensor.
        limit: usize,
    },
    /// A frame that the file ends in.
    #[error(
        "{format}: the file ends at {at}: {found} of a frame found, expected {expected}\nhint: the export was stopped or the file cut; export it again, or leave the frame out"
    )]
    Cut {
        /// The format.
        format: &'static str,
        /// The last line.
        at: Place,
        /// What there is of the frame.
        found: String,
        /// What a frame has.
        expected: String,
    },
    /// A frame that does not add up to what the file says of it.
    #[error(
        "{format}: the cells of the frame before {at} add up to {found} {unit}, and the file itself says {expected} {unit}\nhint: a number of it was changed or lost"
    )]
    Sum {
        /// The format.
        format: &'static str,
        /// The line behind the frame.
        at: Place,
        /// What they add up to.
        found: f64,
        /// What the file says.
        expected: f64,
        /// Of both.
        unit: &'static str,
    },
    /// A raw count that a converter cannot give.
    #[error(
        "{format}: {value} at {at}, {said}, expected raw counts of 0 to {largest}\nhint: these are values in a unit; a line as `UNITS KPa` in the header tells it"
    )]
    RawRange {
        /// The format.
        format: &'static str,
        /// The line of the value.
        at: Place,
        /// The value.
        value: f64,
        /// The largest that the converter gives.
        largest: f64,
        /// What the header says of the unit.
        said: &'static str,
    },
    /// A unit that nobody here knows.
    #[error(
        "unknown unit `{found}` at {at}, expected one of kPa, MPa, Pa, psi, mmHg, N/cm2, N/mm2, g/cm2, kg/cm2, bar, N, lbf, kg, raw\nhint: nothing is guessed: a wrong unit would be a wrong force"
    )]
    Unit {
        /// Where it stands.
        at: Place,
        /// The unit.
        found: String,
    },
    /// Calibrated values, and a sensor that wants the counts of its converter.
    #[error(
        "{} holds {unit}, calibrated by its program, and not the counts that the sensor file is about\nhint: without that sensor file they are taken as they are", .file.display()
    )]
    NotCounts {
        /// The file.
        file: PathBuf,
        /// Its unit.
        unit: String,
    },
    /// A calibrated value that no raw count stands behind.
    #[error(
        "{value} {unit} at {at} is {counts:.3} raw counts by the file's own calibration, expected a whole number of them\nhint: the calibration lines of the header are not those of these values; without a sensor file of another the values are taken as they are"
    )]
    NotWhole {
        /// Where it stands.
        at: Place,
        /// The value.
        value: f64,
        /// Its unit.
        unit: String,
        /// Raw counts that it would be.
        counts: f64,
    },
    /// Several sensors in one file, and none is named.
    #[error("{} holds {} sensors: {}\nhint: name one behind a #, as in `{}#{}`", .file.display(), .pads.len(), .pads.join(", "), .file.display(), .pads[0])]
    Pads {
        /// The file.
        file: PathBuf,
        /// Their names.
        pads: Vec<String>,
    },
    /// One that is not in the file.
    #[error("no sensor `{missing}` in {}: it has {}", .file.display(), known(.pads))]
    NoPad {
        /// The file.
        file: PathBuf,
        /// The name asked for.
        missing: String,
        /// Those there are.
        pads: Vec<String>,
    },
    /// JSON that is none, or another.
    #[error("{format}: {}: {reason}\nhint: {hint}", .file.display())]
    Json {
        /// The format.
        format: &'static str,
        /// The file.
        file: PathBuf,
        /// Why, with the place.
        reason: String,
        /// What to do.
        hint: &'static str,
    },
}

/// The sensors of a file, and what to do.
fn known(pads: &[String]) -> String {
    match pads {
        [] => "one, which has no name\nhint: leave out the # and what is behind it".to_owned(),
        pads => format!("{}\nhint: name one of them behind the #", pads.join(", ")),
    }
}
