//! CSV of real numbers (loads, volts, siemens): R lines of C comma-separated numbers a frame.

use std::io::Read;
use std::marker::PhantomData;
use std::path::{Path, PathBuf};

use taxel::Frame;

use crate::error::Error;
use crate::grid::Grid;
use crate::integrity::Integrity;
use crate::number::Rule;
use crate::options::ReadOptions;
use crate::rows::{ExtraLines, RowWriter};
use crate::source::{FrameSource, Input, Skipped, open_input};

/// Reads frames of quantity `Q`, in its unit; signs and fractions are allowed, NaN and infinities are not.
/// `max_count` of the options is not looked at.
pub struct ValuesReader<Q, R = Input> {
    grid: Grid<R>,
    shape: (usize, usize),
    total: Option<u64>,
    quantity: PhantomData<Q>,
}

impl<Q> ValuesReader<Q, Input> {
    /// Opens a CSV of values (`-`: standard input).
    ///
    /// # Errors
    /// [`Error::Open`]; [`Error::Size`] for an array of no or too many taxels.
    pub fn open(path: impl AsRef<Path>, options: ReadOptions) -> Result<Self, Error> {
        let path = path.as_ref();
        let (input, total) = open_input(path)?;
        let mut reader = Self::new(input, path, options.for_file(path))?;
        reader.total = total;
        Ok(reader)
    }
}

impl<Q, R: Read> ValuesReader<Q, R> {
    /// Reads from any stream; `name` stands for the file in messages.
    ///
    /// # Errors
    /// [`Error::Size`] for an array of no or too many taxels.
    pub fn new(reader: R, name: impl Into<PathBuf>, options: ReadOptions) -> Result<Self, Error> {
        Ok(Self {
            grid: Grid::new(reader, &name.into(), options, Rule::Finite)?,
            shape: (options.rows, options.columns),
            total: None,
            quantity: PhantomData,
        })
    }
}

impl<Q, R: Read> FrameSource<Q> for ValuesReader<Q, R> {
    fn shape(&self) -> (usize, usize) {
        self.shape
    }
    fn next_into(&mut self, frame: &mut Frame<Q>) -> Result<bool, Error> {
        self.grid.next_into(frame)
    }
    fn skipped(&self) -> usize {
        self.grid.skips().count
    }
    fn skips(&self) -> &[Skipped] {
        &self.grid.skips().first
    }
    fn integrity(&self) -> Integrity {
        self.grid.integrity()
    }
    fn bytes_read(&self) -> u64 {
        self.grid.bytes()
    }
    fn bytes_total(&self) -> Option<u64> {
        self.total
    }
}

/// Writes frames of any quantity, each number as the shortest text that reads back as the same number.
pub struct ValuesWriter<Q> {
    rows: RowWriter,
    quantity: PhantomData<Q>,
}

impl<Q> ValuesWriter<Q> {
    /// Begins a file of frames one behind the other; it appears with [`ValuesWriter::commit`].
    ///
    /// # Errors
    /// [`Error::Create`].
    pub fn create(path: impl AsRef<Path>) -> Result<Self, Error> {
        Ok(Self {
            rows: RowWriter::create(path.as_ref(), ExtraLines::Never, false, -f64::MAX)?,
            quantity: PhantomData,
        })
    }

    /// The same, but infinite numbers are written too, as `inf`: standard errors of what nothing bounds. Such a file is
    /// not read back by this library.
    pub fn allow_infinity(mut self) -> Self {
        self.rows.allow_infinity();
        self
    }

    /// Appends a frame.
    ///
    /// # Errors
    /// [`Error::Write`] (disk full), [`Error::FrameShape`] for a frame of another shape than the first,
    /// [`Error::Value`] for a value that is not finite.
    pub fn write(&mut self, frame: &Frame<Q>) -> Result<(), Error> {
        self.rows.write(frame)
    }

    /// Frames written so far.
    pub fn frames(&self) -> u64 {
        self.rows.frames()
    }

    /// Finishes the file and gives it its name.
    ///
    /// # Errors
    /// [`Error::Write`].
    pub fn commit(self) -> Result<(), Error> {
        self.rows.commit()
    }
}
