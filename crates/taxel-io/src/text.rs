//! The e-Cone's text recordings: frames of counts as lines of numbers.
//!
//! `.txt`: R lines a frame, C comma-separated counts a line, each closed by a comma, frames one behind the
//! other. `.csv`: the same with one extra line (blank, a header or a time stamp) before each frame.

use std::io::Read;
use std::ops::Range;
use std::path::{Path, PathBuf};

use taxel::{Counts, Executor, Frame};

use crate::error::Error;
use crate::grid::Grid;
use crate::integrity::Integrity;
use crate::number::Rule;
use crate::options::{ReadOptions, extension};
use crate::rows::{ExtraLines, RowWriter};
use crate::source::{FrameSource, Input, Skipped, open_input};

/// Reads frames of counts from text. Fractions are allowed (averaged recordings); signs are not.
///
/// ```
/// use taxel_io::{FrameSource, ReadOptions, TextReader};
/// let text = "1,2,3,\n4,5,6,\n";
/// let reader = TextReader::new(text.as_bytes(), "two lines", ReadOptions::new(2, 3))?;
/// let frame = reader.frames().next().unwrap()?;
/// assert_eq!(frame.at(1, 0), 4.0);
/// # Ok::<(), taxel_io::Error>(())
/// ```
pub struct TextReader<R = Input> {
    grid: Grid<R>,
    shape: (usize, usize),
    total: Option<u64>,
}

impl TextReader<Input> {
    /// Opens a `.txt` or `.csv` recording (`-`: standard input).
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

impl<R: Read> TextReader<R> {
    /// Reads from any stream; `name` stands for the file in messages.
    ///
    /// # Errors
    /// [`Error::Size`] for an array of no or too many taxels.
    pub fn new(reader: R, name: impl Into<PathBuf>, options: ReadOptions) -> Result<Self, Error> {
        let maximum = options.max_count.unwrap_or(f64::MAX);
        Ok(Self {
            grid: Grid::new(reader, &name.into(), options, Rule::Counts { maximum })?,
            shape: (options.rows, options.columns),
            total: None,
        })
    }
}

impl<R: Read + Send> FrameSource<Counts> for TextReader<R> {
    fn shape(&self) -> (usize, usize) {
        self.shape
    }
    fn next_into(&mut self, frame: &mut Frame<Counts>) -> Result<bool, Error> {
        self.grid.next_into(frame)
    }
    fn next_counts(
        &mut self,
        most: usize,
        out: &mut Vec<u16>,
        executor: &dyn Executor,
    ) -> Result<Range<u64>, Error> {
        let total = self.total;
        let left = total.map(|total| total.saturating_sub(self.grid.bytes()));
        // Room for all of them at once, by the bytes of a frame so far: a block that grows is copied, or its pages are new again.
        if let Some((left, each)) = left.zip(self.grid.frame_bytes()) {
            let frames = left / each + 1;
            let frames = usize::try_from(frames).map_or(most, |frames| frames.min(most));
            out.reserve(frames.saturating_mul(self.shape.0 * self.shape.1));
        }
        self.grid.next_counts((most, left), out, executor)
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

/// Writes frames of counts as text: `.csv` with an extra line before each frame (`time_secs=…` or blank),
/// every other name without.
pub struct TextWriter {
    rows: RowWriter,
}

impl TextWriter {
    /// Begins the file, which appears with [`TextWriter::commit`].
    ///
    /// # Errors
    /// [`Error::Create`].
    pub fn create(path: impl AsRef<Path>) -> Result<Self, Error> {
        let extra = match extension(path.as_ref()).as_str() {
            "csv" => ExtraLines::Every,
            _ => ExtraLines::Never,
        };
        let rows = RowWriter::create(path.as_ref(), extra, true, 0.0)?;
        Ok(Self { rows })
    }

    /// Appends a frame.
    ///
    /// # Errors
    /// [`Error::Write`] (disk full), [`Error::FrameShape`] for a frame of another shape than the first,
    /// [`Error::Value`] for a count that is negative or not finite.
    pub fn write(&mut self, frame: &Frame<Counts>) -> Result<(), Error> {
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
