//! What can be wrong with a table of presses, loads, trials or pairs.

use std::path::PathBuf;

use super::Place;

/// Why a table cannot be read, and where.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TableError {
    /// A table that lacks a column.
    #[error("no column `{missing}` at {at}: the header has `{found}`\nhint: {hint}")]
    MissingColumn {
        /// The header.
        at: Place,
        /// The column's name.
        missing: &'static str,
        /// The columns there are.
        found: String,
        /// The nearest name, or the names that are needed.
        hint: String,
    },
    /// A table with a column that nobody reads.
    #[error("unknown column `{found}` at {at}\nhint: {hint}")]
    UnknownColumn {
        /// The header.
        at: Place,
        /// The column's name.
        found: String,
        /// The nearest name, or all known ones.
        hint: String,
    },
    /// A table's cell that is not what its column needs.
    #[error("`{column}` is `{found}` at {at}, but must be {expected}\nhint: {hint}")]
    Cell {
        /// Where its line begins.
        at: Place,
        /// The table's column.
        column: &'static str,
        /// What stands there, shortened.
        found: String,
        /// What it must be.
        expected: &'static str,
        /// What to do.
        hint: &'static str,
    },
    /// A taxel outside the array.
    #[error(
        "taxel outside the array at {at}: `{label}` is row {row}, column {column}, but the array has {rows} rows x {columns} columns, counted from 0\nhint: check the label, `labels` under [array] in the sensor file, and which sensor this is"
    )]
    OutsideArray {
        /// Where its line begins.
        at: Place,
        /// What stands in the table.
        label: String,
        /// The row that means.
        row: usize,
        /// The column that means.
        column: usize,
        /// Rows of the array.
        rows: usize,
        /// Columns of the array.
        columns: usize,
    },
    /// A table that is not CSV: a line with too many cells, a quote that never ends, bytes that are no text.
    #[error(
        "not a table at {at}: {found} cells found, {expected} expected\nhint: one line a press, cells separated by commas; quote a cell that holds a comma"
    )]
    Shape {
        /// The line.
        at: Place,
        /// Its cells.
        found: u64,
        /// The header's cells.
        expected: u64,
    },
    /// A table's line that is not UTF-8.
    #[error("not text at {at}: cell {cell} is not UTF-8\nhint: save the table as CSV UTF-8")]
    NotText {
        /// The line.
        at: Place,
        /// The cell, from 1.
        cell: usize,
    },
    /// A table too large to be one.
    #[error("{} has {found} {what}, at most {limit} expected of a table\nhint: is this a recording? presses go in a table of one line a press; a longer one is read in parts", .file.display())]
    TooLong {
        /// The file.
        file: PathBuf,
        /// How many there are.
        found: u64,
        /// `bytes`, `columns`, …
        what: &'static str,
        /// The most it may have.
        limit: u64,
    },
}
