//! Which taxels are looked at.

use std::str::FromStr;

use taxel_io::experiments::taxel_of_label;

use crate::error::Error;

/// A taxel as it is typed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Place {
    /// Row and column, from 0.
    Numbers(usize, usize),
    /// As on the rig's table.
    Label(String),
}

impl FromStr for Place {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if let Some((row, column)) = text.split_once(',')
            && let (Ok(row), Ok(column)) = (row.trim().parse(), column.trim().parse())
        {
            return Ok(Self::Numbers(row, column));
        }
        match taxel_of_label(text, None) {
            Some(_) => Ok(Self::Label(text.to_owned())),
            None => {
                Err("expected ROW,COLUMN counted from 0, like 3,17, or a label like C7".to_owned())
            }
        }
    }
}

/// Rows and columns, ends included.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Range {
    rows: (usize, usize),
    columns: (usize, usize),
}

impl FromStr for Range {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let ends = |text: &str| {
            let (from, to) = text.trim().split_once("..")?;
            let (from, to) = (from.parse().ok()?, to.trim_start_matches('=').parse().ok()?);
            (from <= to).then_some((from, to))
        };
        let both = text
            .split_once(',')
            .and_then(|(r, c)| Some((ends(r)?, ends(c)?)));
        match both {
            Some((rows, columns)) => Ok(Self { rows, columns }),
            None => Err(
                "expected R..R,C..C counted from 0, ends included, like 10..13,20..25".to_owned(),
            ),
        }
    }
}

/// Everything that was asked for.
pub(super) struct Wanted<'a> {
    pub(super) taxels: &'a [Place],
    pub(super) row: Option<usize>,
    pub(super) column: Option<usize>,
    pub(super) region: Option<Range>,
}

impl Wanted<'_> {
    /// Names and places, all of them on the array.
    pub(super) fn places(
        &self,
        rows: usize,
        columns: usize,
        labels: Option<&str>,
    ) -> Result<Vec<(String, usize, usize)>, Error> {
        let mut places = Vec::new();
        for taxel in self.taxels {
            let (name, row, column) = match taxel {
                Place::Numbers(row, column) => (None, *row, *column),
                Place::Label(label) => {
                    let found = taxel_of_label(label, labels).ok_or_else(|| Error::Arguments {
                        what: format!("no taxel is called {label}: the sensor file's labels are {}", labels.unwrap_or("A to Z")),
                        hint: "letters: the column, in the order of `labels`; number: the row, from 0",
                    })?;
                    (Some(label), found.0, found.1)
                }
            };
            check("--taxel", row, column, rows, columns)?;
            let numbers = name_of(row, column);
            places.push((
                name.map_or(numbers.clone(), |name| format!("{name} ({numbers})")),
                row,
                column,
            ));
        }
        let mut block = |option, rows_of: (usize, usize), columns_of: (usize, usize)| {
            check(option, rows_of.1, columns_of.1, rows, columns)?;
            for row in rows_of.0..=rows_of.1 {
                places.extend((columns_of.0..=columns_of.1).map(|c| (name_of(row, c), row, c)));
            }
            Ok::<_, Error>(())
        };
        if let Some(row) = self.row {
            block("--row", (row, row), (0, columns - 1))?;
        }
        if let Some(column) = self.column {
            block("--column", (0, rows - 1), (column, column))?;
        }
        if let Some(region) = self.region {
            block("--region", region.rows, region.columns)?;
        }
        Ok(places)
    }
}

fn name_of(row: usize, column: usize) -> String {
    format!("row {row}, column {column}")
}

fn check(
    option: &'static str,
    row: usize,
    column: usize,
    rows: usize,
    columns: usize,
) -> Result<(), Error> {
    if row < rows && column < columns {
        Ok(())
    } else {
        Err(Error::TaxelOutside {
            option,
            row,
            column,
            rows,
            columns,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_numbers_or_labels() {
        assert_eq!("3, 17".parse(), Ok(Place::Numbers(3, 17)));
        assert_eq!("C7".parse(), Ok(Place::Label("C7".to_owned())));
        assert!("7".parse::<Place>().is_err() && "a,b".parse::<Place>().is_err());
        let range = Range {
            rows: (1, 2),
            columns: (3, 5),
        };
        assert_eq!("1..2,3..5".parse(), Ok(range));
        assert_eq!("1..=2, 3..=5".parse(), Ok(range));
        assert!("2..1,3..5".parse::<Range>().is_err());
    }
}
