//! Where taxels lie, as a table beside the sensor file.

use std::path::Path;

use crate::error::Error;
use crate::table::{Row, Table};

const COLUMNS: [&str; 6] = [
    "row",
    "column",
    "x_mm",
    "y_mm",
    "picture_row",
    "picture_column",
];
const NEEDS: &str = "row, column, x_mm, y_mm; or row, column, picture_row, picture_column";

/// Reads a table of `row`, `column` and either `x_mm`, `y_mm` or the cell of a picture, `picture_row`, `picture_column`,
/// whose cells are `pitch_mm` (between rows, between columns) apart: of each line row, column, x and y in mm.
///
/// # Errors
/// A missing or unknown column, a cell that is no number, an empty table; each with its place.
pub(crate) fn read(path: &Path, pitch_mm: [f64; 2]) -> Result<Vec<[f64; 4]>, Error> {
    let table = Table::open(path, &COLUMNS)?;
    let row = table.need("row", NEEDS)?;
    let column = table.need("column", NEEDS)?;
    let in_cells = table.find("picture_row").is_some();
    let (x, y, scale) = if in_cells {
        (
            ("picture_column", table.need("picture_column", NEEDS)?),
            ("picture_row", table.need("picture_row", NEEDS)?),
            [pitch_mm[1], pitch_mm[0]],
        )
    } else {
        (
            ("x_mm", table.need("x_mm", NEEDS)?),
            ("y_mm", table.need("y_mm", NEEDS)?),
            [1.0, 1.0],
        )
    };
    table.rows("place", |line: &Row<'_>| {
        Ok([
            line.index(row, "row")? as f64,
            line.index(column, "column")? as f64,
            scale[0] * line.number(x.1, x.0)?,
            scale[1] * line.number(y.1, y.0)?,
        ])
    })
}
