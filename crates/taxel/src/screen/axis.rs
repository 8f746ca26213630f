//! The two directions of lines.

use std::fmt;

/// Rows (sensed lines) or columns (driven lines).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Axis {
    /// Sensed lines.
    Row,
    /// Driven lines.
    Column,
}

impl Axis {
    /// Both.
    pub const BOTH: [Axis; 2] = [Axis::Row, Axis::Column];

    /// The lines that cross those of this one.
    pub fn other(self) -> Self {
        match self {
            Axis::Row => Axis::Column,
            Axis::Column => Axis::Row,
        }
    }
}

impl fmt::Display for Axis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Axis::Row => "row",
            Axis::Column => "column",
        })
    }
}
