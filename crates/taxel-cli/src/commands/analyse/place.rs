//! Which taxels are looked at.

use std::str::FromStr;

use taxel::sensor::Region;

use crate::commands::taxel_address::TaxelAddress;
use crate::error::Error;
use crate::out;

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

/// A region of the array, as it is asked for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum RegionWanted {
    Block(Range),
    /// A named one of the sensor file, or of a file of regions.
    Named(String),
}

impl FromStr for RegionWanted {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        // Whoever writes two dots means lines.
        if text.contains("..") {
            return text.parse().map(Self::Block);
        }
        Ok(Self::Named(text.to_owned()))
    }
}

/// The region of this name.
fn named<'a>(name: &str, regions: &'a [Region]) -> Result<&'a Region, Error> {
    let found = regions.iter().find(|region| region.name() == name);
    found.ok_or_else(|| {
        let known: Vec<&str> = regions.iter().map(Region::name).collect();
        Error::Arguments {
            what: match known.len() {
                0 => format!("--region {name}: the sensor file names no regions"),
                _ => format!("--region {name}: there are {}", known.join(", ")),
            },
            hint: "--regions names a file of them; without a name a region is R..R,C..C, rows and columns from 0, ends included",
        }
    })
}

/// Everything that was asked for.
pub(super) struct Wanted<'a> {
    pub(super) taxels: &'a [TaxelAddress],
    pub(super) row: Option<usize>,
    pub(super) column: Option<usize>,
    pub(super) region: Option<&'a RegionWanted>,
    /// Those that have names.
    pub(super) regions: &'a [Region],
}

impl Wanted<'_> {
    /// Says which taxels are looked at of a region that lies elsewhere in other frames.
    pub(super) fn tell_if_it_moves(&self) -> Result<(), Error> {
        let Some(RegionWanted::Named(name)) = self.region else {
            return Ok(());
        };
        let region = named(name, self.regions)?;
        if region.moves() {
            out::note(&format!(
                "{name} moves: these are all the taxels of its {} windows of time, {}",
                region.windows().count(),
                region.taxels().len()
            ));
        }
        Ok(())
    }

    /// Names and places, all of them on the array.
    pub(super) fn places(
        &self,
        rows: usize,
        columns: usize,
        labels: Option<&str>,
    ) -> Result<Vec<(String, usize, usize)>, Error> {
        let mut places = Vec::new();
        for taxel in self.taxels {
            let (row, column) = taxel.place(labels)?;
            check("--taxel", row, column, rows, columns)?;
            let numbers = name_of(row, column);
            places.push((
                taxel
                    .label()
                    .map_or(numbers.clone(), |name| format!("{name} ({numbers})")),
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
        match self.region {
            Some(RegionWanted::Block(region)) => block("--region", region.rows, region.columns)?,
            Some(RegionWanted::Named(name)) => {
                let taxels = named(name, self.regions)?.taxels().iter();
                places.extend(taxels.map(|taxel| {
                    let (row, column) = (taxel / columns, taxel % columns);
                    (name_of(row, column), row, column)
                }));
            }
            None => {}
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
    fn ranges_have_two_ends() {
        let range = Range {
            rows: (1, 2),
            columns: (3, 5),
        };
        assert_eq!("1..2,3..5".parse(), Ok(range));
        assert_eq!("1..=2, 3..=5".parse(), Ok(range));
        assert!("2..1,3..5".parse::<Range>().is_err());
    }
}
