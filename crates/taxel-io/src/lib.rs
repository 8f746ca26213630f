#![doc = include_str!("../README.md")]
//!
//! # Modules, in reading order
//!
//! | module | format |
//! |---|---|
//! | [`text`] | counts as lines of numbers, `.txt` and `.csv` |
//! | [`values`] | loads, volts, siemens as lines of numbers, `.csv` |
//! | [`npy`] | arrays, `.npy` and `.npz` |
//! | [`mcap`] | recordings with times, events and the sensor file, `.mcap` |
//! | [`parquet`] | a table, one row a frame, `.parquet` (feature `parquet`) |
//! | [`exports`] | what other programs export: Tekscan, RSscan, zebris, XSENSOR, novel and others (read only) |
//! | [`columns`] | tables of numbers to look at elsewhere, `.csv`, `.xlsx` (feature `xlsx`), `.parquet` (written only) |
//! | [`experiments`] | labelled presses, `experiments.csv`, `equilibration.csv` and `totals.csv` |
//! | [`trials`] | what was done to a sensor that is evaluated, `.csv` |
//! | [`pairs`] | conductance against load, `.csv` |
//!
//! [`open_counts`] chooses by the extension.

pub mod atomic;
pub mod bounded;
mod column;
pub mod columns;
pub mod error;
mod event;
pub mod experiments;
pub mod exports;
mod grid;
pub mod integrity;
mod lines;
mod losses;
pub mod mcap;
pub mod npy;
mod number;
mod options;
pub mod pairs;
pub mod parquet;
mod plain;
mod positions;
pub mod recording;
mod rows;
pub mod sensor_file;
pub mod source;
mod table;
mod tare;
mod temporary;
pub mod text;
pub mod trials;
pub mod values;
mod words;
mod xlsx;

pub use atomic::AtomicFile;
pub use column::Column;
pub use columns::write_columns;
pub use error::{
    BROKEN_READING, Error, ExportError, ParquetError, Place, SensorFileError, ShapeFault,
    TableError,
};
pub use experiments::{
    Press, Total, Uniform, read_presses, read_totals, read_uniform_loads, recordings_named_in,
    recordings_of,
};
pub use integrity::{Damage, Gaps, Integrity, TimeGaps};
pub use mcap::{Event, LoadsReader, Losses, McapReader, McapWriter, Tare};
pub use npy::{NpyOptions, NpyReader, NpyWriter, NpzWriter};
pub use options::{ReadOptions, extension};
pub use pairs::{PairOnLine, read_pairs, read_pairs_by_line};
pub use parquet::{ParquetReader, ParquetWriter};
pub use recording::{ShapeGuess, open_counts, sensor_toml_of, shape_of};
pub use source::{FrameSource, Frames, MAX_TAXELS, Skipped};
pub use text::{TextReader, TextWriter};
pub use trials::{Trial, read_trials};
pub use values::{ValuesReader, ValuesWriter};
