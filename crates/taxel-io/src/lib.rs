//! Recordings of a resistive pressure-sensor matrix: frames to files and back, one file a format.
//!
//! Readers stream: a recording of any length takes the memory of one frame and one buffer. Writers go
//! through [`AtomicFile`]: a file is whole, or its old content is untouched.
//!
//! | module | format |
//! |---|---|
//! | [`text`] | counts as lines of numbers, `.txt` and `.csv` |
//! | [`values`] | loads, volts, siemens as lines of numbers, `.csv` |
//! | [`npy`] | arrays, `.npy` and `.npz` |
//! | [`mcap`] | recordings with times, events and the sensor file, `.mcap` |
//! | [`parquet`] | a table, one row a frame, `.parquet` (feature `parquet`) |
//! | [`columns`] | tables of numbers to look at elsewhere, `.csv`, `.xlsx` (feature `xlsx`), `.parquet` (written only) |
//! | [`experiments`] | labelled presses, `experiments.csv` and `equilibration.csv` |
//! | [`trials`] | what was done to a sensor that is evaluated, `.csv` |
//! | [`pairs`] | conductance against load, `.csv` |
//!
//! [`open_counts`] chooses by the extension.

pub mod atomic;
pub mod bounded;
pub mod columns;
pub mod error;
pub mod experiments;
mod grid;
pub mod integrity;
mod lines;
pub mod mcap;
pub mod npy;
mod number;
pub mod pairs;
pub mod parquet;
pub mod recording;
mod rows;
pub mod sensor_file;
pub mod source;
mod table;
mod temporary;
pub mod text;
pub mod trials;
pub mod values;
mod xlsx;

pub use atomic::AtomicFile;
pub use columns::{Column, write_columns};
pub use error::{Error, ParquetError, Place, TableError};
pub use experiments::{
    Press, Uniform, read_presses, read_uniform_loads, recordings_named_in, recordings_of,
};
pub use integrity::{Damage, Gaps, Integrity};
pub use mcap::{Event, LoadsReader, Losses, McapReader, McapWriter, Tare};
pub use npy::{NpyOptions, NpyReader, NpyWriter, NpzWriter};
pub use pairs::{PairOnLine, read_pairs, read_pairs_by_line};
pub use parquet::{ParquetReader, ParquetWriter};
pub use recording::{ShapeGuess, open_counts, sensor_toml_of, shape_of};
pub use source::{FrameSource, Frames, MAX_TAXELS, Skipped};
pub use text::{TextOptions, TextReader, TextWriter};
pub use trials::{Trial, read_trials};
pub use values::{ValuesReader, ValuesWriter};
