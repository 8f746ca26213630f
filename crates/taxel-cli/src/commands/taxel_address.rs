//! A taxel on the command line: `ROW,COLUMN`, or a label.

use std::str::FromStr;

use taxel_io::experiments::taxel_of_label;

use crate::error::Error;

/// A taxel as it is typed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum TaxelAddress {
    /// Row and column, from 0.
    Numbers(usize, usize),
    /// As on the rig's table.
    Label(String),
}

/// What stands there is no taxel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("expected ROW,COLUMN counted from 0, like 3,17, or a label like C7")]
pub(crate) struct NoTaxel;

impl FromStr for TaxelAddress {
    type Err = NoTaxel;

    fn from_str(text: &str) -> Result<Self, NoTaxel> {
        if let Some((row, column)) = text.split_once(',')
            && let (Ok(row), Ok(column)) = (row.trim().parse(), column.trim().parse())
        {
            return Ok(Self::Numbers(row, column));
        }
        let is_label = taxel_of_label(text, None).is_some();
        is_label
            .then(|| Self::Label(text.to_owned()))
            .ok_or(NoTaxel)
    }
}

impl TaxelAddress {
    /// The label, where one was typed.
    pub(crate) fn label(&self) -> Option<&str> {
        match self {
            Self::Numbers(..) => None,
            Self::Label(label) => Some(label),
        }
    }

    /// Row and column, by the sensor file's `labels` where it has some.
    pub(crate) fn place(&self, labels: Option<&str>) -> Result<(usize, usize), Error> {
        match self {
            Self::Numbers(row, column) => Ok((*row, *column)),
            Self::Label(label) => taxel_of_label(label, labels).ok_or_else(|| Error::Arguments {
                what: format!(
                    "no taxel is called {label}: the sensor file's labels are {}",
                    labels.unwrap_or("A to Z")
                ),
                hint: "letters: the column, in the order of `labels`; number: the row, from 0",
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_taxel_is_two_numbers_or_a_label() {
        assert_eq!("3, 17".parse(), Ok(TaxelAddress::Numbers(3, 17)));
        assert_eq!("C7".parse(), Ok(TaxelAddress::Label("C7".to_owned())));
        assert_eq!("7".parse::<TaxelAddress>(), Err(NoTaxel));
        assert_eq!("a,b".parse::<TaxelAddress>(), Err(NoTaxel));
        let place = |labels| TaxelAddress::Label("C7".to_owned()).place(labels).ok();
        assert_eq!(place(None), Some((7, 2)));
        assert_eq!(place(Some("HGFEDCBA")), Some((7, 5)));
        assert_eq!(place(Some("AB")), None);
    }
}
