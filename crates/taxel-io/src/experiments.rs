//! Labelled presses: `experiments.csv` (one taxel, one load), `equilibration.csv` (one load everywhere) and `totals.csv` (one load
//! on all taxels together).

use std::collections::BTreeSet;
use std::io::Read;
use std::path::{Path, PathBuf};

use crate::error::{Error, TableError};
use crate::source::open_input;
use crate::table::{Row, Table};

/// One labelled taxel in one frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Press {
    /// The recording, its path already relative to the table's folder.
    pub recording: PathBuf,
    /// The frame in it, from 0.
    pub frame: usize,
    /// The taxel's row, from 0.
    pub row: usize,
    /// The taxel's column, from 0.
    pub column: usize,
    /// The load on it, grams-force.
    pub load_g: f64,
    /// Which repetition this is, where the table says.
    pub replicate: Option<String>,
    /// Area under the tip, mm², where the table says.
    pub contact_area_mm2: Option<f64>,
    /// A remark, where the table has one.
    pub note: Option<String>,
    /// The table's line, from 1.
    pub line: u64,
}

/// The same load on every taxel in one frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Uniform {
    /// The recording, its path already relative to the table's folder.
    pub recording: PathBuf,
    /// The frame in it, from 0.
    pub frame: usize,
    /// The load on each taxel, grams-force.
    pub load_g: f64,
    /// The table's line, from 1.
    pub line: u64,
}

/// The load on all taxels together in one frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Total {
    /// The recording, its path already relative to the table's folder.
    pub recording: PathBuf,
    /// The frame in it, from 0.
    pub frame: usize,
    /// The load on the whole array, grams-force; 0 for the empty sensor.
    pub load_g: f64,
    /// What it is held out together with, such as a posture, where the table says.
    pub group: Option<String>,
    /// The table's line, from 1.
    pub line: u64,
}

const PRESS_COLUMNS: [&str; 9] = [
    "recording",
    "frame",
    "row",
    "column",
    "taxel",
    "load_g",
    "replicate",
    "contact_area_mm2",
    "note",
];
const PRESS_NEEDS: &str = "recording, frame, load_g, and row and column (or taxel)";
const UNIFORM_COLUMNS: [&str; 6] = [
    "recording",
    "frame",
    "load_g",
    "replicate",
    "contact_area_mm2",
    "note",
];
const UNIFORM_NEEDS: &str = "recording, frame, load_g";
const TOTAL_COLUMNS: [&str; 6] = ["recording", "frame", "load_g", "group", "replicate", "note"];

/// Reads `experiments.csv` for an array of `rows` × `columns`: columns `recording,frame,row,column,load_g`
/// in any order, or `taxel` (labels, [`taxel_of_label`]) for row and column.
///
/// # Errors
/// A missing or unknown column, a taxel outside the array, a cell that is no number, a negative load, an
/// empty table; each with its place.
pub fn read_presses(
    path: impl AsRef<Path>,
    rows: usize,
    columns: usize,
    labels: Option<&str>,
) -> Result<Vec<Press>, Error> {
    let path = path.as_ref();
    let (input, _) = open_input(path)?;
    read_presses_from(input, path, rows, columns, labels)
}

/// [`read_presses`] from any stream; `path` stands for the file in messages and its folder in paths.
///
/// # Errors
/// As [`read_presses`].
pub fn read_presses_from(
    input: impl Read,
    path: impl AsRef<Path>,
    rows: usize,
    columns: usize,
    labels: Option<&str>,
) -> Result<Vec<Press>, Error> {
    let path = path.as_ref();
    let table = Table::read(input, path, &PRESS_COLUMNS)?;
    let recording = table.need("recording", PRESS_NEEDS)?;
    let frame = table.need("frame", PRESS_NEEDS)?;
    let load = table.need("load_g", PRESS_NEEDS)?;
    let taxel = Taxel {
        label: table.find("taxel"),
        pair: match (table.find("row"), table.find("column"), table.find("taxel")) {
            (Some(row), Some(column), _) => Some((row, column)),
            (None, None, Some(_)) => None,
            (None, ..) => return Err(table.need("row", PRESS_NEEDS).unwrap_err()),
            (_, None, _) => return Err(table.need("column", PRESS_NEEDS).unwrap_err()),
        },
        rows,
        columns,
        labels,
    };
    let (replicate, area, note) = (
        table.find("replicate"),
        table.find("contact_area_mm2"),
        table.find("note"),
    );
    table.rows("press", |line| {
        let (row, column) = taxel.read(line)?;
        let area = line.optional(area)?.and(area);
        Ok(Press {
            recording: next_to(path, line, recording)?,
            frame: line.index(frame, "frame")?,
            row,
            column,
            load_g: line.amount(load, "load_g")?,
            replicate: line.optional(replicate)?.map(str::to_owned),
            contact_area_mm2: area
                .map(|cell| line.amount(cell, "contact_area_mm2"))
                .transpose()?,
            note: line.optional(note)?.map(str::to_owned),
            line: line.line,
        })
    })
}

/// The recordings that a table of presses names, each once, in the order of its lines: to ask them for their sensor
/// before the table can be read.
///
/// # Errors
/// As [`read_presses`], of the column `recording`.
pub fn recordings_of(path: impl AsRef<Path>) -> Result<Vec<PathBuf>, Error> {
    let path = path.as_ref();
    let table = Table::open(path, &PRESS_COLUMNS)?;
    let recording = table.need("recording", PRESS_NEEDS)?;
    let mut named = table.rows("press", |line| next_to(path, line, recording))?;
    let mut seen = std::collections::BTreeSet::new();
    named.retain(|recording| seen.insert(recording.clone()));
    Ok(named)
}

/// Reads `equilibration.csv`: columns `recording,frame,load_g` in any order.
///
/// # Errors
/// As [`read_presses`].
pub fn read_uniform_loads(path: impl AsRef<Path>) -> Result<Vec<Uniform>, Error> {
    let path = path.as_ref();
    let table = Table::open(path, &UNIFORM_COLUMNS)?;
    let recording = table.need("recording", UNIFORM_NEEDS)?;
    let frame = table.need("frame", UNIFORM_NEEDS)?;
    let load = table.need("load_g", UNIFORM_NEEDS)?;
    table.rows("load", |line| {
        Ok(Uniform {
            recording: next_to(path, line, recording)?,
            frame: line.index(frame, "frame")?,
            load_g: line.amount(load, "load_g")?,
            line: line.line,
        })
    })
}

/// Reads `totals.csv`: columns `recording,frame,load_g` in any order, and perhaps `group`.
///
/// # Errors
/// As [`read_presses`].
pub fn read_totals(path: impl AsRef<Path>) -> Result<Vec<Total>, Error> {
    let path = path.as_ref();
    let table = Table::open(path, &TOTAL_COLUMNS)?;
    let recording = table.need("recording", UNIFORM_NEEDS)?;
    let frame = table.need("frame", UNIFORM_NEEDS)?;
    let load = table.need("load_g", UNIFORM_NEEDS)?;
    let group = table.find("group");
    table.rows("total", |line| {
        Ok(Total {
            recording: next_to(path, line, recording)?,
            frame: line.index(frame, "frame")?,
            load_g: line.amount(load, "load_g")?,
            group: line.optional(group)?.map(str::to_owned),
            line: line.line,
        })
    })
}

/// The recordings that any table with a column `recording` names, each once, their paths already relative to the table's
/// folder: what must not be written to while the table is used.
///
/// # Errors
/// A file that cannot be read as a table with that column.
pub fn recordings_named_in(path: impl AsRef<Path>) -> Result<Vec<PathBuf>, Error> {
    let path = path.as_ref();
    let table = Table::open_any(path)?;
    let cell = table.need("recording", "recording")?;
    let mut named = BTreeSet::new();
    table.rows("line", |line| {
        named.insert(next_to(path, line, cell)?);
        Ok(())
    })?;
    Ok(named.into_iter().collect())
}

/// A recording's path, relative to the folder of the table.
pub(crate) fn next_to(table: &Path, line: &Row<'_>, cell: usize) -> Result<PathBuf, Error> {
    let name = line.text(cell)?;
    if name.is_empty() {
        let hint = "paths are relative to this table's folder";
        return Err(line.wrong(cell, "recording", "the name of a recording", hint));
    }
    Ok(table.parent().unwrap_or(Path::new("")).join(name))
}

/// Where a table says which taxel was pressed, and what there is to press.
pub(crate) struct Taxel<'a> {
    pub(crate) label: Option<usize>,
    pub(crate) pair: Option<(usize, usize)>,
    pub(crate) rows: usize,
    pub(crate) columns: usize,
    pub(crate) labels: Option<&'a str>,
}

impl Taxel<'_> {
    pub(crate) fn read(&self, line: &Row<'_>) -> Result<(usize, usize), Error> {
        let labelled = match self.label {
            Some(cell) => self.by_label(line, cell)?,
            None => None,
        };
        let numbered = match (self.pair, labelled) {
            (None, _) => None,
            (Some(pair), Some(_)) if self.is_empty(line, pair)? => None,
            (Some((row, column)), _) => {
                let taxel = (line.index(row, "row")?, line.index(column, "column")?);
                let label = format!("{},{}", taxel.0, taxel.1);
                Some(self.inside(line, row, taxel, label)?)
            }
        };
        match (labelled, numbered, self.label) {
            (Some(a), Some(b), Some(cell)) if a != b => {
                let hint =
                    "leave out one of taxel and row, column, or the table contradicts itself";
                Err(line.wrong(cell, "taxel", "the same taxel as its row and column", hint))
            }
            (Some(taxel), ..) | (None, Some(taxel), _) => Ok(taxel),
            (None, None, cell) => Err(label_words(line, cell.unwrap_or_default())),
        }
    }

    fn is_empty(&self, line: &Row<'_>, pair: (usize, usize)) -> Result<bool, Error> {
        Ok(line.text(pair.0)?.is_empty() && line.text(pair.1)?.is_empty())
    }

    fn by_label(&self, line: &Row<'_>, cell: usize) -> Result<Option<(usize, usize)>, Error> {
        let Some(label) = line.optional(Some(cell))? else {
            return Ok(None);
        };
        let Some(taxel) = taxel_of_label(label, self.labels) else {
            return Err(label_words(line, cell));
        };
        self.inside(line, cell, taxel, label.to_owned()).map(Some)
    }

    fn inside(
        &self,
        line: &Row<'_>,
        cell: usize,
        (row, column): (usize, usize),
        label: String,
    ) -> Result<(usize, usize), Error> {
        if row < self.rows && column < self.columns {
            return Ok((row, column));
        }
        let (rows, columns) = (self.rows, self.columns);
        let at = line.place(cell);
        Err(TableError::OutsideArray {
            at,
            label,
            row,
            column,
            rows,
            columns,
        }
        .into())
    }
}

fn label_words(line: &Row<'_>, cell: usize) -> Error {
    let expected = "letters and a number, like `C7`";
    let hint = "letters: the column, in the order of `labels` under [array] in the sensor file; number: the row, from 0";
    line.wrong(cell, "taxel", expected, hint)
}

/// Row and column of a label like `C7`: letters are the column, the number is the row, from 0.
///
/// `labels` are the columns' letters in order (`"ABCDEFGH"`); without it A is 0, Z is 25, AA is 26.
/// Small letters are taken for capitals where `labels` has no small ones.
///
/// ```
/// use taxel_io::experiments::taxel_of_label;
/// assert_eq!(taxel_of_label("C7", None), Some((7, 2)));
/// assert_eq!(taxel_of_label("AA0", None), Some((0, 26)));
/// assert_eq!(taxel_of_label("C7", Some("HGFEDCBA")), Some((7, 5)));
/// ```
pub fn taxel_of_label(label: &str, labels: Option<&str>) -> Option<(usize, usize)> {
    let digits = label.find(|c: char| c.is_ascii_digit())?;
    let (letters, number) = label.split_at(digits);
    let letters = letters.trim_end();
    if letters.is_empty() || !number.bytes().all(|b| b.is_ascii_digit()) {
        return None;
    }
    let row = number.parse().ok()?;
    let column = match labels {
        Some(map) => {
            let mut given = letters.chars();
            let letter = given.next().filter(|_| given.as_str().is_empty())?;
            map.chars()
                .position(|c| c == letter)
                .or_else(|| map.chars().position(|c| c.eq_ignore_ascii_case(&letter)))?
        }
        None => column_of_letters(letters)?,
    };
    Some((row, column))
}

fn column_of_letters(letters: &str) -> Option<usize> {
    let mut column = 0usize;
    for letter in letters.bytes() {
        if !letter.is_ascii_alphabetic() {
            return None;
        }
        let place = usize::from(letter.to_ascii_uppercase() - b'A') + 1;
        column = column.checked_mul(26)?.checked_add(place)?;
    }
    column.checked_sub(1)
}
