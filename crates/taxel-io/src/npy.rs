//! numpy's `.npy` and `.npz`: one frame (2-D) or frames (3-D: frames, rows, columns), read frame by frame.

mod element;
mod header;
mod npz;
mod write;

use std::io::Read;
use std::marker::PhantomData;
use std::path::{Path, PathBuf};

use taxel::{Counts, Frame, Mark};

use crate::error::{BROKEN_READING, Error, ShapeFault};
use crate::options::{ReadOptions, extension};
use crate::source::{FrameSource, Input, MAX_TAXELS, SkipLog, Skipped, fit_shape, open_input};
pub use element::Element;
use header::{Header, fill};
pub use write::{NpyWriter, NpzWriter};

/// How to read frames from an array.
#[derive(Debug, Clone, Default, PartialEq)]
#[non_exhaustive]
pub struct NpyOptions {
    /// Rows and columns that every frame must have; `None`: whatever the array has.
    pub shape: Option<(usize, usize)>,
    /// The largest count allowed; `None`: any.
    pub max_count: Option<f64>,
    /// The array has rows and columns swapped.
    pub transpose: bool,
    /// Leave out frames with values that are not allowed, instead of stopping at the first.
    pub keep_going: bool,
    /// Which array of a `.npz`; `None`: the first.
    pub array: Option<String>,
}

impl From<ReadOptions> for NpyOptions {
    fn from(options: ReadOptions) -> Self {
        Self {
            shape: Some((options.rows, options.columns)),
            max_count: options.max_count,
            transpose: options.transpose,
            keep_going: options.keep_going,
            array: None,
        }
    }
}

/// Reads frames of quantity `Q` from an array of any number type and byte order.
pub struct NpyReader<Q, R = Input> {
    input: R,
    file: PathBuf,
    header: Header,
    options: NpyOptions,
    layout: Layout,
    least: f64,
    most: f64,
    frame: u64,
    /// Bytes of data read.
    bytes: u64,
    piece: Vec<u8>,
    skips: SkipLog,
    /// The input ends with the array, and verifies it there.
    archived: bool,
    done: bool,
    quantity: PhantomData<Q>,
}

/// How a frame lies in the array.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Layout {
    /// Frames of the array.
    pub(crate) frames: u64,
    /// Rows of the array, before any transposing.
    pub(crate) rows: usize,
    /// Columns of the array, before any transposing.
    pub(crate) columns: usize,
    /// Column by column.
    fortran: bool,
    /// Bytes of all the data.
    data: u64,
}

/// Bytes decoded at a time; a multiple of every number's length.
const PIECE: usize = 64 * 1024;

impl NpyReader<Counts, Input> {
    /// Opens counts in a `.npy` or `.npz` (`-`: a `.npy` on standard input).
    ///
    /// # Errors
    /// [`Error::Open`]; no array, an array of another shape, of no numbers, or not packed as numpy does.
    pub fn open(path: impl AsRef<Path>, options: NpyOptions) -> Result<Self, Error> {
        let most = options.max_count.unwrap_or(f64::MAX);
        Self::open_within(path.as_ref(), options, 0.0, most)
    }
}

impl<Q> NpyReader<Q, Input> {
    /// Opens values of any quantity, in its unit: signs are allowed, `max_count` is not looked at.
    ///
    /// # Errors
    /// As [`NpyReader::open`].
    pub fn open_values(path: impl AsRef<Path>, options: NpyOptions) -> Result<Self, Error> {
        Self::open_within(path.as_ref(), options, -f64::MAX, f64::MAX)
    }

    fn open_within(path: &Path, options: NpyOptions, least: f64, most: f64) -> Result<Self, Error> {
        let (input, file) = open_array(path, options.array.as_deref())?;
        let mut reader = Self::begin(input, file, options, least, most)?;
        reader.archived = extension(path) == "npz";
        Ok(reader)
    }
}

/// The bytes of an array, and its name for messages.
fn open_array(path: &Path, array: Option<&str>) -> Result<(Input, PathBuf), Error> {
    if extension(path) == "npz" {
        return npz::open(path, array);
    }
    Ok((open_input(path)?.0, path.to_owned()))
}

/// The layout of the frames in a file, exactly.
pub(crate) fn layout_of(path: &Path) -> Result<Layout, Error> {
    let (mut input, file) = open_array(path, None)?;
    let header = Header::read(&mut input, &file)?;
    layout(&header, &file, &NpyOptions::default())
}

impl<Q, R: Read> NpyReader<Q, R> {
    /// Reads values of any quantity from any stream; `name` stands for the file in messages.
    ///
    /// # Errors
    /// No array, an array of another shape, or of no numbers.
    pub fn new(reader: R, name: impl Into<PathBuf>, options: NpyOptions) -> Result<Self, Error> {
        Self::begin(reader, name.into(), options, -f64::MAX, f64::MAX)
    }

    fn begin(
        mut input: R,
        file: PathBuf,
        options: NpyOptions,
        least: f64,
        most: f64,
    ) -> Result<Self, Error> {
        let header = Header::read(&mut input, &file)?;
        let layout = layout(&header, &file, &options)?;
        Ok(Self {
            input,
            file,
            header,
            options,
            layout,
            least,
            most,
            frame: 0,
            bytes: 0,
            piece: vec![0; PIECE],
            skips: SkipLog::default(),
            archived: false,
            done: false,
            quantity: PhantomData,
        })
    }

    /// Reads one frame, good or bad, whole.
    fn one_frame(&mut self, values: &mut [f64]) -> Result<(), Error> {
        let Layout {
            rows,
            columns,
            fortran,
            ..
        } = self.layout;
        let element = self.header.element;
        // Position in the array, and how far the next value is in the frame.
        let across = fortran != self.options.transpose;
        let (inner, outer) = match (across, fortran) {
            (false, _) => (1, 1),
            (true, true) => (rows, columns),
            (true, false) => (columns, rows),
        };
        let mut left = rows * columns * element.bytes();
        let mut i = 0;
        while left > 0 {
            let piece = &mut self.piece[..left.min(PIECE)];
            let before = self.header.bytes + self.bytes;
            let held = fill(&mut self.input, piece, &self.file, before)?;
            self.bytes += held as u64;
            if held < piece.len() {
                return Err(self.cut_short());
            }
            left -= held;
            element.decode(piece, self.header.big_endian, |value| {
                let place = if across {
                    i % inner * outer + i / inner
                } else {
                    i
                };
                values[place] = value;
                i += 1;
            });
        }
        self.check(values)
    }

    fn check(&self, values: &[f64]) -> Result<(), Error> {
        let allowed = self.least..=self.most;
        let Some(i) = values.iter().position(|v| !allowed.contains(v)) else {
            return Ok(());
        };
        let columns = self.shape().1;
        let (row, column) = if self.options.transpose {
            (i % columns, i / columns)
        } else {
            (i / columns, i % columns)
        };
        Err(Error::Value {
            file: self.file.clone(),
            frame: self.frame,
            row,
            column,
            found: values[i],
            minimum: self.least,
            maximum: self.most,
            hint: BROKEN_READING,
        })
    }

    /// Behind the last frame: reads an archive's array to its end, where its checksum is verified.
    fn finish(&mut self) -> Result<(), Error> {
        if std::mem::replace(&mut self.done, true) || !self.archived {
            return Ok(());
        }
        loop {
            let before = self.header.bytes + self.bytes;
            if fill(&mut self.input, &mut self.piece, &self.file, before)? == 0 {
                return Ok(());
            }
        }
    }

    fn cut_short(&mut self) -> Error {
        self.done = true;
        Error::NpyCutShort {
            file: self.file.clone(),
            frame: self.frame,
            found: self.bytes,
            expected: self.layout.data,
            hint: "the file was copied or written in part",
        }
    }
}

impl<Q, R: Read> FrameSource<Q> for NpyReader<Q, R> {
    fn shape(&self) -> (usize, usize) {
        if self.options.transpose {
            (self.layout.columns, self.layout.rows)
        } else {
            (self.layout.rows, self.layout.columns)
        }
    }

    fn next_into(&mut self, frame: &mut Frame<Q>) -> Result<bool, Error> {
        let (rows, columns) = self.shape();
        fit_shape(frame, rows, columns);
        while !self.done && self.frame < self.layout.frames {
            let result = self.one_frame(frame.values_mut());
            let number = self.frame;
            self.frame += 1;
            match result {
                Ok(()) => {
                    frame.marks_mut().fill(Mark::Good);
                    frame.sequence = number;
                    frame.time_secs = None;
                    return Ok(true);
                }
                Err(error) if self.options.keep_going && error.is_one_frame() => {
                    self.skips.add(Skipped {
                        frame: number,
                        first_line: None,
                        error,
                    });
                }
                Err(error) => {
                    self.done = true;
                    return Err(error);
                }
            }
        }
        self.finish()?;
        Ok(false)
    }

    fn skipped(&self) -> usize {
        self.skips.count
    }
    fn skips(&self) -> &[Skipped] {
        &self.skips.first
    }
    fn bytes_read(&self) -> u64 {
        self.header.bytes + self.bytes
    }
    fn bytes_total(&self) -> Option<u64> {
        Some(self.header.bytes + self.layout.data)
    }
}

/// Checks the header's shape against what is asked for, and against sense.
fn layout(header: &Header, file: &Path, options: &NpyOptions) -> Result<Layout, Error> {
    let wrong = |expected: String, hint| Error::FileShape {
        file: file.to_owned(),
        found: shape_words(&header.shape),
        expected,
        hint,
    };
    let (frames, rows, columns) = match header.shape[..] {
        [rows, columns] => (1, rows, columns),
        [frames, rows, columns] => (frames, rows, columns),
        _ => {
            let expected = "(rows, columns) or (frames, rows, columns)".to_owned();
            return Err(wrong(expected, ShapeFault::Dimensions));
        }
    };
    // With one line of one frame both orders are the same.
    let fortran = header.fortran_order && (frames > 1 || (rows > 1 && columns > 1));
    if fortran && header.shape.len() == 3 {
        let expected = "3-D in C order".to_owned();
        return Err(wrong(expected, ShapeFault::FortranOrder));
    }
    if let Some(expected) = options.shape {
        check_shape((rows, columns), expected, options.transpose).map_err(|hint| {
            let (rows, columns) = if options.transpose {
                (expected.1, expected.0)
            } else {
                expected
            };
            wrong(format!("frames of {rows} rows x {columns} columns"), hint)
        })?;
    }
    let Some(data) = data_bytes(header.element, frames, rows, columns) else {
        return Err(Error::Size {
            file: file.to_owned(),
            rows: usize::try_from(rows).unwrap_or(usize::MAX),
            columns: usize::try_from(columns).unwrap_or(usize::MAX),
            limit: MAX_TAXELS,
        });
    };
    if frames == 0 {
        return Err(Error::Empty {
            file: file.to_owned(),
            what: "frame",
            found: 0,
        });
    }
    let (rows, columns) = (rows as usize, columns as usize);
    Ok(Layout {
        frames,
        rows,
        columns,
        fortran,
        data,
    })
}

/// Bytes of all the data, where a frame is neither empty nor too large.
fn data_bytes(element: Element, frames: u64, rows: u64, columns: u64) -> Option<u64> {
    let taxels = rows.checked_mul(columns)?;
    let bytes = taxels.checked_mul(element.bytes() as u64)?;
    let sensible = (1..=MAX_TAXELS as u64).contains(&taxels);
    bytes.checked_mul(frames).filter(|_| sensible)
}

/// What is the matter, where the shape is not the expected one.
fn check_shape(
    found: (u64, u64),
    expected: (usize, usize),
    transpose: bool,
) -> Result<(), ShapeFault> {
    let expected = (expected.0 as u64, expected.1 as u64);
    let swapped = (expected.1, expected.0);
    let (wanted, other) = if transpose {
        (swapped, expected)
    } else {
        (expected, swapped)
    };
    if found == wanted {
        return Ok(());
    }
    Err(match (found == other, transpose) {
        (true, false) => ShapeFault::Swapped,
        (true, true) => ShapeFault::NotSwapped,
        _ => ShapeFault::OtherSensor,
    })
}

fn shape_words(shape: &[u64]) -> String {
    let numbers: Vec<String> = shape.iter().map(u64::to_string).collect();
    format!("({})", numbers.join(", "))
}
