//! What can be wrong with a Parquet table.

use std::path::PathBuf;

use taxel::Mark;

use super::words::names_words;

/// Why a table cannot be read as frames, and where. Frames are counted from 0.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ParquetError {
    /// A file that is no Parquet, or whose end is damaged.
    #[error("cannot read {} as Parquet: {reason}\nhint: it is cut short, damaged, or of another kind", .file.display())]
    NotParquet {
        /// The file.
        file: PathBuf,
        /// Why.
        reason: String,
    },
    /// A Parquet table of something else.
    #[error("no column `{missing}` in {}: it has {}\nhint: {}", .file.display(), names_words(.found), column_hint(*.is_counts, .found))]
    NoColumn {
        /// The file.
        file: PathBuf,
        /// The column asked for.
        missing: &'static str,
        /// The columns there are.
        found: Vec<String>,
        /// Counts were asked for, not loads.
        is_counts: bool,
    },
    /// A column of a Parquet table that is no list of numbers.
    #[error("column `{column}` of {} has {found}, expected a list of numbers: one a taxel, row by row\nhint: a table of this program has such columns", .file.display())]
    ColumnType {
        /// The file.
        file: PathBuf,
        /// The column.
        column: &'static str,
        /// What it holds.
        found: String,
    },
    /// A row of a Parquet table that is no frame of the sensor.
    #[error("`{column}` has {found} numbers in {}, frame {frame}, expected {rows} rows x {columns} columns = {}\nhint: the recording is of another sensor, or a number is missing; check rows and columns in the sensor file", .file.display(), .rows * .columns)]
    RowLength {
        /// The file.
        file: PathBuf,
        /// The frame.
        frame: u64,
        /// The column.
        column: &'static str,
        /// Its numbers in that row.
        found: usize,
        /// Rows of the sensor.
        rows: usize,
        /// Columns of the sensor.
        columns: usize,
    },
    /// A mark that this program does not know.
    #[error("mark {found} in {}, frame {frame}, row {row}, column {column}, expected a whole number of 0 to {}\nhint: a later version wrote the table, or another program changed it", .file.display(), Mark::ALL.len() - 1)]
    MarkCode {
        /// The file.
        file: PathBuf,
        /// The frame.
        frame: u64,
        /// Row of the taxel, as the file has it.
        row: usize,
        /// Its column.
        column: usize,
        /// The mark's code.
        found: f64,
    },
    /// A row of a Parquet table that cannot be read.
    #[error("cannot read frame {frame} of {}: {reason}\nhint: the file is damaged, or another program packed it in a way that is not read; what is before that frame is whole", .file.display())]
    Row {
        /// The file.
        file: PathBuf,
        /// The frame.
        frame: u64,
        /// Why.
        reason: String,
    },
    /// A Parquet table that says one half of how its frames are shaped, and not the other.
    #[error("{} does not say how many rows and columns a frame has: no number `{missing}` in its metadata\nhint: give the sensor file", .file.display())]
    NoShape {
        /// The file.
        file: PathBuf,
        /// What its metadata lacks.
        missing: &'static str,
    },
}

/// What to do about a table without the column asked for.
fn column_hint(is_counts: bool, found: &[String]) -> &'static str {
    let has = |name: &str| found.iter().any(|column| column == name);
    match (is_counts, has("counts"), has("newtons")) {
        (true, _, true) => "it is a table of loads, which are read as values",
        (false, true, _) => "it is a table of counts; compensated, it has loads as well",
        _ => {
            "a table of this program has a list of numbers in each row: counts in `counts`, loads in `newtons`"
        }
    }
}
