//! `A..B` on the command line.

use std::str::FromStr;

/// Frames from `first` up to and without `end`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct FrameRange {
    pub(super) first: u64,
    pub(super) end: Option<u64>,
}

/// What stands there is no range.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("expected A..B, frames counted from 0, like 10..20, 10..=19 or 10..")]
pub(super) struct NoRange;

impl FrameRange {
    pub(super) fn one(frame: u64) -> Self {
        Self {
            first: frame,
            end: Some(frame.saturating_add(1)),
        }
    }

    pub(super) fn all() -> Self {
        Self {
            first: 0,
            end: None,
        }
    }

    pub(super) fn is_one(self) -> bool {
        self.end == self.first.checked_add(1)
    }
}

impl FromStr for FrameRange {
    type Err = NoRange;

    fn from_str(text: &str) -> Result<Self, NoRange> {
        let (first, end) = text.split_once("..").ok_or(NoRange)?;
        let number = |text: &str| text.trim().parse::<u64>().map_err(|_| NoRange);
        let first = match first.trim() {
            "" => 0,
            first => number(first)?,
        };
        let end = match end.trim().strip_prefix('=') {
            Some(last) => Some(number(last)?.checked_add(1).ok_or(NoRange)?),
            None if end.trim().is_empty() => None,
            None => Some(number(end)?),
        };
        match end {
            Some(end) if end <= first => Err(NoRange),
            _ => Ok(Self { first, end }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_are_read_as_in_rust() {
        let range = |first, end| Ok(FrameRange { first, end });
        assert_eq!("3..7".parse(), range(3, Some(7)));
        assert_eq!("3..=7".parse(), range(3, Some(8)));
        assert_eq!("3..".parse(), range(3, None));
        assert_eq!("..4".parse(), range(0, Some(4)));
        for wrong in ["", "3", "7..3", "3..3", "a..b", "-1..3"] {
            assert_eq!(wrong.parse::<FrameRange>(), Err(NoRange), "{wrong}");
        }
    }
}
