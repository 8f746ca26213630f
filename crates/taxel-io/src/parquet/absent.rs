//! What stands here in a build without Parquet.

use std::convert::Infallible;
use std::marker::PhantomData;
use std::path::Path;
use std::time::SystemTime;

use taxel::{Counts, Frame, Newtons, Sensor};

use crate::column::Column;
use crate::error::Error;
use crate::options::ReadOptions;
use crate::source::{FrameSource, Skipped};

fn not_built(file: &Path) -> Error {
    Error::NotBuilt {
        file: file.to_owned(),
        format: "Parquet",
        feature: "parquet",
    }
}

pub(crate) fn write_columns(path: &Path, _columns: &[Column]) -> Result<(), Error> {
    Err(not_built(path))
}

/// Writes a table; not in this build.
pub struct ParquetWriter(Infallible);

impl ParquetWriter {
    /// Begins a table of a sensor's counts.
    ///
    /// # Errors
    /// [`Error::NotBuilt`].
    pub fn create(path: impl AsRef<Path>, _sensor: &Sensor) -> Result<Self, Error> {
        Err(not_built(path.as_ref()))
    }

    /// Begins a table of a sensor's loads.
    ///
    /// # Errors
    /// [`Error::NotBuilt`].
    pub fn create_with_loads(
        path: impl AsRef<Path>,
        _sensor: &Sensor,
        _has_counts: bool,
    ) -> Result<Self, Error> {
        Err(not_built(path.as_ref()))
    }

    /// Appends a frame of counts.
    ///
    /// # Errors
    /// None: there is no such writer.
    pub fn write(&mut self, _frame: &Frame<Counts>, _host: SystemTime) -> Result<(), Error> {
        match self.0 {}
    }

    /// Appends a frame of loads.
    ///
    /// # Errors
    /// None: there is no such writer.
    pub fn write_loads(
        &mut self,
        _counts: Option<&Frame<Counts>>,
        _loads: &Frame<Newtons>,
        _host: SystemTime,
    ) -> Result<(), Error> {
        match self.0 {}
    }

    /// Finishes the file.
    ///
    /// # Errors
    /// None: there is no such writer.
    pub fn commit(self) -> Result<(), Error> {
        match self.0 {}
    }
}

/// Reads a table; not in this build.
pub struct ParquetReader<Q = Counts>(Infallible, PhantomData<Q>);

impl ParquetReader<Counts> {
    /// Opens the counts of a table.
    ///
    /// # Errors
    /// [`Error::NotBuilt`].
    pub fn open_counts(path: impl AsRef<Path>, _options: ReadOptions) -> Result<Self, Error> {
        Err(not_built(path.as_ref()))
    }
}

impl<Q> ParquetReader<Q> {
    /// Opens the loads of a table.
    ///
    /// # Errors
    /// [`Error::NotBuilt`].
    pub fn open_loads(path: impl AsRef<Path>, _options: ReadOptions) -> Result<Self, Error> {
        Err(not_built(path.as_ref()))
    }
}

/// Rows and columns of a table's frames, and how many there are.
pub(crate) fn shape_of(path: &Path) -> Result<(Option<(usize, usize)>, u64), Error> {
    Err(not_built(path))
}

/// The sensor file that a table carries.
pub(crate) fn sensor_toml_of(path: &Path) -> Result<Option<String>, Error> {
    Err(not_built(path))
}

impl<Q> FrameSource<Q> for ParquetReader<Q> {
    fn shape(&self) -> (usize, usize) {
        match self.0 {}
    }
    fn next_into(&mut self, _frame: &mut Frame<Q>) -> Result<bool, Error> {
        match self.0 {}
    }
    fn skipped(&self) -> usize {
        match self.0 {}
    }
    fn skips(&self) -> &[Skipped] {
        match self.0 {}
    }
    fn bytes_read(&self) -> u64 {
        match self.0 {}
    }
    fn bytes_total(&self) -> Option<u64> {
        match self.0 {}
    }
}
