//! Frames of counts, of loads, or of both as a Parquet table: one row a frame.
//!
//! | column | type |
//! |---|---|
//! | `sequence` | int64: the device's own number, else the position |
//! | `time_secs` | double: device time, NaN where unknown |
//! | `host_time` | timestamp, µs, UTC |
//! | `counts` | fixed-size list of rows · columns uint16, row by row |
//! | `newtons` | fixed-size list of rows · columns double |
//! | `marks` | fixed-size list of rows · columns uint8: how far each load can be trusted |
//!
//! Rows, columns and the sensor file are in the table's metadata (`taxel.rows`, `taxel.columns`, `taxel.sensor_toml`).
//!
//! [`ParquetReader`] reads these, and tables that other programs made of them: any number type, other columns beside them,
//! lists of any kind, as long as every row has one number a taxel. Needs the feature `parquet`; without it everything here
//! is [`Error::NotBuilt`](crate::Error::NotBuilt).

#[cfg(feature = "parquet")]
mod columns;
#[cfg(feature = "parquet")]
mod numbers;
#[cfg(feature = "parquet")]
mod pages;
#[cfg(feature = "parquet")]
mod read;
#[cfg(feature = "parquet")]
mod table;
#[cfg(feature = "parquet")]
mod write;

#[cfg(not(feature = "parquet"))]
mod absent;

#[cfg(not(feature = "parquet"))]
pub use absent::{ParquetReader, ParquetWriter};
#[cfg(not(feature = "parquet"))]
pub(crate) use absent::{sensor_toml_of, shape_of, write_columns};
#[cfg(feature = "parquet")]
pub(crate) use columns::write as write_columns;
#[cfg(feature = "parquet")]
pub use read::ParquetReader;
#[cfg(feature = "parquet")]
pub(crate) use table::{sensor_toml_of, shape_of};
#[cfg(feature = "parquet")]
pub use write::ParquetWriter;

/// Names of the columns.
#[cfg(feature = "parquet")]
const SEQUENCE: &str = "sequence";
#[cfg(feature = "parquet")]
const TIME_SECS: &str = "time_secs";
#[cfg(feature = "parquet")]
const HOST_TIME: &str = "host_time";
#[cfg(feature = "parquet")]
const COUNTS: &str = "counts";
#[cfg(feature = "parquet")]
const NEWTONS: &str = "newtons";
#[cfg(feature = "parquet")]
const MARKS: &str = "marks";
/// Names of what stands in the table's metadata.
#[cfg(feature = "parquet")]
const META_ROWS: &str = "taxel.rows";
#[cfg(feature = "parquet")]
const META_COLUMNS: &str = "taxel.columns";
#[cfg(feature = "parquet")]
const META_SENSOR: &str = "taxel.sensor_toml";
