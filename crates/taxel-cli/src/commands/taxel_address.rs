//! `ROW,COLUMN` on the command line.

use std::str::FromStr;

/// A taxel, both numbers from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct TaxelAddress {
    /// Sensed line.
    pub(crate) row: usize,
    /// Driven line.
    pub(crate) column: usize,
}

/// What stands there is no taxel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("expected ROW,COLUMN, both counted from 0, like 3,17")]
pub(crate) struct NoTaxel;

impl FromStr for TaxelAddress {
    type Err = NoTaxel;

    fn from_str(text: &str) -> Result<Self, NoTaxel> {
        let (row, column) = text.split_once(',').ok_or(NoTaxel)?;
        let number = |text: &str| text.trim().parse().map_err(|_| NoTaxel);
        Ok(Self {
            row: number(row)?,
            column: number(column)?,
        })
    }
}
