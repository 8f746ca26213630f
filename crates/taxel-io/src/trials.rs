//! Trials: what was done to a sensor, one line for each thing that was set up, as `taxel evaluate` reads it.

use std::path::{Path, PathBuf};

use crate::error::Error;
use crate::experiments::{Taxel, next_to};
use crate::table::{Row, Table};

/// One line of a table of trials.
#[derive(Debug, Clone, PartialEq)]
pub struct Trial {
    /// The recording, its path already relative to the table's folder.
    pub recording: PathBuf,
    /// The frame in it, from 0; `None`: every frame is a reading.
    pub frame: Option<usize>,
    /// Row and column of the taxel that is looked at, where its cells are not empty.
    pub taxel: Option<(usize, usize)>,
    /// The named region that is looked at instead.
    pub region: Option<String>,
    /// The load on it, grams-force.
    pub load_g: Option<f64>,
    /// What was set up once: lines with the same word are one experiment. Without it, a line is one.
    pub experiment: Option<String>,
    /// What is compared: before and after, another V_test.
    pub setting: Option<String>,
    /// How many other taxels of the line were pressed.
    pub others: Option<usize>,
    /// The load on the whole array, grams-force.
    pub total_g: Option<f64>,
    /// Where the centre of pressure is known to be, mm from the centre of the first taxel along columns and rows.
    pub place_mm: Option<(f64, f64)>,
    /// The table's line, from 1.
    pub line: u64,
}

const COLUMNS: [&str; 15] = [
    "recording",
    "frame",
    "row",
    "column",
    "taxel",
    "region",
    "load_g",
    "experiment",
    "setting",
    "others",
    "total_g",
    "x_mm",
    "y_mm",
    "contact_area_mm2",
    "note",
];
const NEEDS: &str = "recording, and row and column (or taxel), region or total_g";

/// Reads a table of trials on an array of `rows` × `columns`; columns in any order. Only `recording` must be there; which of
/// the others an evaluation needs, it says.
///
/// # Errors
/// A missing or unknown column, a taxel outside the array or beside a region, a cell that is no number, a negative load, an
/// empty table; each with its place.
pub fn read_trials(
    path: impl AsRef<Path>,
    rows: usize,
    columns: usize,
    labels: Option<&str>,
) -> Result<Vec<Trial>, Error> {
    let path = path.as_ref();
    let table = Table::open(path, &COLUMNS)?;
    let recording = table.need("recording", NEEDS)?;
    for (one, other) in [("row", "column"), ("x_mm", "y_mm")] {
        if table.find(one).is_some() || table.find(other).is_some() {
            table.need(
                one,
                "both or neither of row and column, and of x_mm and y_mm",
            )?;
            table.need(
                other,
                "both or neither of row and column, and of x_mm and y_mm",
            )?;
        }
    }
    let taxel = Taxel {
        label: table.find("taxel"),
        pair: table.find("row").zip(table.find("column")),
        rows,
        columns,
        labels,
    };
    let pair = taxel.pair.map(|(row, column)| [Some(row), Some(column)]);
    let taxel_cells: Vec<Option<usize>> = pair.into_iter().flatten().chain([taxel.label]).collect();
    let find = |name| table.find(name);
    let (frame, load, others) = (find("frame"), find("load_g"), find("others"));
    let (experiment, setting) = (find("experiment"), find("setting"));
    let region = find("region");
    let (total, x, y) = (find("total_g"), find("x_mm"), find("y_mm"));
    table.rows("trial", |line| {
        let text = |cell| Ok::<_, Error>(line.optional(cell)?.map(str::to_owned));
        let mut has_taxel = false;
        for &cell in &taxel_cells {
            has_taxel |= line.optional(cell)?.is_some();
        }
        if let Some(cell) = region.filter(|_| has_taxel)
            && line.optional(region)?.is_some()
        {
            let hint = "a reading is of one taxel or of one region";
            return Err(line.wrong(cell, "region", "nothing beside a taxel", hint));
        }
        Ok(Trial {
            recording: next_to(path, line, recording)?,
            frame: index(line, frame, "frame")?,
            taxel: has_taxel.then(|| taxel.read(line)).transpose()?,
            region: text(region)?,
            load_g: amount(line, load, "load_g")?,
            experiment: text(experiment)?,
            setting: text(setting)?,
            others: index(line, others, "others")?,
            total_g: amount(line, total, "total_g")?,
            place_mm: place(line, x, y)?,
            line: line.line,
        })
    })
}

fn amount(line: &Row<'_>, cell: Option<usize>, name: &'static str) -> Result<Option<f64>, Error> {
    let filled = line.optional(cell)?.and(cell);
    filled.map(|cell| line.amount(cell, name)).transpose()
}

/// Both numbers or neither.
fn place(line: &Row<'_>, x: Option<usize>, y: Option<usize>) -> Result<Option<(f64, f64)>, Error> {
    let number = |cell, name| {
        amount(line, cell, name).map_err(|error| match error {
            Error::Negative {
                at, what, found, ..
            } => Error::Negative {
                at,
                what,
                found,
                hint: "places count from the centre of the taxel at row 0, column 0",
            },
            other => other,
        })
    };
    let both = "x_mm and y_mm go together";
    match (number(x, "x_mm")?, number(y, "y_mm")?) {
        (Some(x), Some(y)) => Ok(Some((x, y))),
        (None, None) => Ok(None),
        (Some(_), None) => Err(line.wrong(y.unwrap_or_default(), "y_mm", "a number", both)),
        (None, Some(_)) => Err(line.wrong(x.unwrap_or_default(), "x_mm", "a number", both)),
    }
}

fn index(line: &Row<'_>, cell: Option<usize>, name: &'static str) -> Result<Option<usize>, Error> {
    let filled = line.optional(cell)?.and(cell);
    filled.map(|cell| line.index(cell, name)).transpose()
}
