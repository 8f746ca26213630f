//! Plain pairs of conductance and load, from a tester without an array.

use std::path::Path;

use taxel::frame::grams_from_newtons;

use crate::error::Error;
use crate::table::{Row, Table};

const COLUMNS: [&str; 6] = [
    "conductance_siemens",
    "resistance_ohms",
    "load_g",
    "load_n",
    "replicate",
    "note",
];
const NEEDS: &str = "conductance_siemens or resistance_ohms, and load_g or load_n";

/// Reads a table of `conductance_siemens` (or `resistance_ohms`) and `load_g` (or `load_n`), in any order,
/// as pairs of siemens and grams-force.
///
/// # Errors
/// A missing or unknown column, a cell that is no number, a negative load or conductance, a resistance of
/// 0 Ω, an empty table; each with its place.
pub fn read_pairs(path: impl AsRef<Path>) -> Result<Vec<(f64, f64)>, Error> {
    let pairs = read_pairs_by_line(path)?;
    Ok(pairs.into_iter().map(|(_, pair)| pair).collect())
}

/// The line of the file, from 1, and the pair: siemens, grams.
pub type PairOnLine = (u64, (f64, f64));

/// [`read_pairs`] with the line of the file, from 1, that each pair stands on.
///
/// # Errors
/// As [`read_pairs`].
pub fn read_pairs_by_line(path: impl AsRef<Path>) -> Result<Vec<PairOnLine>, Error> {
    let table = Table::open(path.as_ref(), &COLUMNS)?;
    let (siemens, ohms) = either(&table, "conductance_siemens", "resistance_ohms")?;
    let (grams, newtons) = either(&table, "load_g", "load_n")?;
    table.rows("pair", |line| {
        let conductance = match siemens {
            Some(cell) => line.amount(cell, "conductance_siemens")?,
            None => siemens_from_ohms(line, ohms)?,
        };
        let load = match grams {
            Some(cell) => line.amount(cell, "load_g")?,
            None => grams_from_newtons(line.amount(newtons, "load_n")?),
        };
        Ok((line.line, (conductance, load)))
    })
}

/// The cell of column `first`, or else that of `second` (0 where it is not needed).
fn either(
    table: &Table,
    first: &'static str,
    second: &'static str,
) -> Result<(Option<usize>, usize), Error> {
    match (table.find(first), table.find(second)) {
        (Some(cell), _) => Ok((Some(cell), 0)),
        (None, Some(cell)) => Ok((None, cell)),
        (None, None) => Err(table.need(first, NEEDS).unwrap_err()),
    }
}

fn siemens_from_ohms(line: &Row<'_>, cell: usize) -> Result<f64, Error> {
    let ohms = line.amount(cell, "resistance_ohms")?;
    let siemens = ohms.recip();
    if siemens.is_finite() {
        return Ok(siemens);
    }
    let hint = "a short circuit says nothing about the material; leave the line out";
    Err(line.wrong(cell, "resistance_ohms", "above 0", hint))
}
