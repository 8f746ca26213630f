//! One column of a table of numbers.

/// A column; a number that is not finite is an empty cell (in Parquet it stays what it is).
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// Its name.
    pub name: String,
    /// Its numbers, as many as every other column has.
    pub values: Vec<f64>,
}
