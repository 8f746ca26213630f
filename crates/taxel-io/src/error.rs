//! What can go wrong between a frame and its file: what, where, both numbers, and what to do.

mod export;
mod kinds;
mod parquet;
mod sensor_file;
mod shape;
mod table;
mod words;

use std::fmt;
use std::io;
use std::path::PathBuf;

pub use export::ExportError;
pub use parquet::ParquetError;
pub use sensor_file::SensorFileError;
pub use shape::ShapeFault;
pub(crate) use shape::other_shape;
pub use table::TableError;
use words::{kept_words, names_words, value_words};

/// A place in a text file, for messages and editors.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Place {
    /// The file, as it was named by the caller.
    pub file: PathBuf,
    /// Its line, from 1; 0 of what is of no line.
    pub line: u64,
    /// The byte in that line, from 1.
    pub column: u64,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { file, line, column } = self;
        // What a whole file lacks stands on no line of it.
        if *line == 0 {
            return write!(f, "{}", file.display());
        }
        write!(f, "{}, line {line}, column {column}", file.display())
    }
}

/// The hint of an [`Error::Value`] that a reader met in one frame: the others can be read without it.
pub const BROKEN_READING: &str = "a reading that is missing or broken";

/// Everything that reading and writing recordings can refuse to do, and why. Frames are counted from 0.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A sensor file that cannot be read, or makes no sense.
    #[error(transparent)]
    SensorFile(#[from] SensorFileError),
    /// What is wrong with a file that another program has exported.
    #[error(transparent)]
    Export(Box<ExportError>),
    /// A table that a spreadsheet does not hold.
    #[error(
        "{}: {rows} rows x {columns} columns, but a sheet holds {most_rows} x {most_columns}\nhint: write .csv or .parquet", .file.display()
    )]
    SheetSize {
        /// The file.
        file: PathBuf,
        /// Rows of the table, its names included.
        rows: usize,
        /// Its columns.
        columns: usize,
        /// Rows that a sheet holds.
        most_rows: usize,
        /// Columns that a sheet holds.
        most_columns: usize,
    },
    /// The file cannot be opened.
    #[error("cannot open {}: {source}\nhint: check the name, and that you may read it", .file.display())]
    Open {
        /// The file.
        file: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// Reading stopped in the middle.
    #[error("cannot read on in {} after {bytes} bytes: {source}\nhint: the disk, the device or the archive is at fault; copy the file and compare", .file.display())]
    Read {
        /// The file.
        file: PathBuf,
        /// Bytes read until then.
        bytes: u64,
        /// The system's reason.
        source: io::Error,
    },
    /// The output cannot be begun; nothing was changed.
    #[error("cannot write {}: {source}\nhint: check that its folder exists and that you may write there", .file.display())]
    Create {
        /// The file.
        file: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// A recording of that name is there already.
    #[error("{} already exists\nhint: recordings are never overwritten; choose another name", .file.display())]
    Exists {
        /// The file.
        file: PathBuf,
    },
    /// Writing stopped in the middle (disk full): an older file of that name is untouched.
    #[error("cannot finish {} after {bytes} bytes: {source}; {}", .file.display(), kept_words(.kept))]
    Write {
        /// The file that was to be written.
        file: PathBuf,
        /// Bytes handed over until then.
        bytes: u64,
        /// Where the part that was written is kept, if anywhere.
        kept: Option<PathBuf>,
        /// The system's reason.
        source: io::Error,
    },
    /// A file whose first bytes must be written last, into something that cannot go back (a pipe).
    #[error("cannot write the number of frames at the start of {} after its {frames} frames\nhint: a pipe cannot go back; write .npy to a file, or text to the pipe", .file.display())]
    CannotGoBack {
        /// The output.
        file: PathBuf,
        /// Frames written.
        frames: u64,
    },
    /// A name that says nothing about the format.
    #[error("cannot tell the format of {} from `{extension}`\nhint: recordings end in .txt, .csv, .npy, .npz, .mcap or .parquet", .file.display())]
    UnknownFormat {
        /// The file.
        file: PathBuf,
        /// What follows the last dot.
        extension: String,
    },
    /// Nothing in it.
    #[error("no {what} in {}: {found} found, at least 1 expected\nhint: the file is empty or holds blank lines only; was the recording ever started?", .file.display())]
    Empty {
        /// The file.
        file: PathBuf,
        /// What should have been there.
        what: &'static str,
        /// How many of them there are, 0.
        found: u64,
    },
    /// Lines, but none of numbers.
    #[error(
        "no line of numbers: {at} has {characters} characters, and they are words\nhint: {hint}"
    )]
    NoNumbers {
        /// The first line that is not blank.
        at: Place,
        /// How many characters it has: it may tell of a person, and is not shown.
        characters: usize,
        /// What to do.
        hint: &'static str,
    },
    /// An array that no sensor has.
    #[error("cannot read {} as frames of {rows} rows x {columns} columns: a frame has 1 to {limit} taxels, so that memory stays below 256 MiB\nhint: check rows and columns in the sensor file", .file.display())]
    Size {
        /// The file.
        file: PathBuf,
        /// Rows asked for or found.
        rows: usize,
        /// Columns asked for or found.
        columns: usize,
        /// The most taxels a frame may have.
        limit: usize,
    },
    /// A frame, mostly the last, that has too few lines.
    #[error(
        "frame {frame} is cut short at {at}: {found} whole lines found, {expected} expected\nhint: {hint}"
    )]
    CutShort {
        /// Where the next line should be, or the line that is cut.
        at: Place,
        /// The frame.
        frame: u64,
        /// Whole lines of it.
        found: usize,
        /// Lines of a frame.
        expected: usize,
        /// What to do.
        hint: &'static str,
    },
    /// A frame that goes on where its extra line should be.
    #[error(
        "frame {frame} has no extra line before it at {at}: line {found} of {expected} of the frame before it?\nhint: every frame so far began with an extra line; one is missing, or a line is doubled"
    )]
    NoExtraLine {
        /// The line that should be the extra one.
        at: Place,
        /// The frame.
        frame: u64,
        /// Which line of the frame before it this would be.
        found: usize,
        /// Lines of a frame.
        expected: usize,
    },
    /// A line with too few or too many numbers.
    #[error("wrong number of values at {at}: {found} found, {expected} expected\nhint: {hint}")]
    LineShape {
        /// The line.
        at: Place,
        /// Numbers on it.
        found: usize,
        /// Numbers it should have.
        expected: usize,
        /// What is the matter with its shape.
        hint: ShapeFault,
    },
    /// A line that no frame could have.
    #[error(
        "line too long at {at}: {found} bytes, at most {limit} expected\nhint: this is not a text recording of that many columns; check the file and the sensor"
    )]
    LineLength {
        /// The line.
        at: Place,
        /// Its bytes.
        found: u64,
        /// The most it may have.
        limit: usize,
    },
    /// A word, or nothing, where a number should be.
    #[error("not a number at {at}: value {number} of {expected} is `{found}`\nhint: {hint}")]
    Word {
        /// Where it begins.
        at: Place,
        /// Which value of its line, from 1.
        number: usize,
        /// Values on the line.
        expected: usize,
        /// What stands there, shortened.
        found: String,
        /// What to do.
        hint: &'static str,
    },
    /// NaN, an infinity, or a number beyond ±1.8e308.
    #[error(
        "not a finite number at {at}: value {number} of {expected} is `{found}`\nhint: a reading that is missing or broken"
    )]
    NotFinite {
        /// Where it begins.
        at: Place,
        /// Which value of its line, from 1.
        number: usize,
        /// Values on the line.
        expected: usize,
        /// What stands there, shortened.
        found: String,
    },
    /// A time that is none.
    #[error(
        "not a time at {at}: `time_secs` is `{found}`, expected seconds as -1e10 to 1e10\nhint: a decimal point, no comma; where the time is unknown, leave the line blank"
    )]
    Time {
        /// Where it begins.
        at: Place,
        /// What stands there, shortened.
        found: String,
    },
    /// A count or load below zero.
    #[error("negative {what} at {at}: {found}, at least 0 expected\nhint: {hint}")]
    Negative {
        /// Where it begins.
        at: Place,
        /// `count`, `load_g`, …
        what: &'static str,
        /// The number.
        found: f64,
        /// What to do.
        hint: &'static str,
    },
    /// A count that the converter cannot give.
    #[error(
        "count above the converter's range at {at}: {found}, at most {maximum} expected\nhint: check `bits` under [converter] in the sensor file, or the recording is broken there"
    )]
    TooLarge {
        /// Where it begins.
        at: Place,
        /// The number.
        found: f64,
        /// The largest count.
        maximum: f64,
    },
    /// What is wrong with a table.
    #[error(transparent)]
    Table(#[from] TableError),
    /// A .npy array that does not begin as one.
    #[error("not a .npy array: {}, byte {byte}: found `{found}`, expected {expected}\nhint: write it with numpy.save, without pickled objects", .file.display())]
    NpyHeader {
        /// The file (with the array's name, for .npz).
        file: PathBuf,
        /// The byte, from 0.
        byte: u64,
        /// What stands there, shortened.
        found: String,
        /// What should.
        expected: &'static str,
    },
    /// A file whose frames are of another shape than the sensor's.
    #[error("wrong shape of {}: {found}, expected {expected}\nhint: {hint}", .file.display())]
    FileShape {
        /// The file.
        file: PathBuf,
        /// Its shape, e.g. `(10, 128, 64)`, `128 rows x 64 columns`.
        found: String,
        /// The shape that is needed.
        expected: String,
        /// What is the matter with its shape.
        hint: ShapeFault,
    },
    /// A .npy array that ends early.
    #[error("{} is cut short in frame {frame}: {found} bytes of data found, {expected} expected\nhint: {hint}", .file.display())]
    NpyCutShort {
        /// The file.
        file: PathBuf,
        /// The frame that is not whole.
        frame: u64,
        /// Bytes of data there are.
        found: u64,
        /// Bytes of data the header promises.
        expected: u64,
        /// What to do.
        hint: &'static str,
    },
    /// A value of a frame that is not allowed in its file.
    #[error("{} in {}, frame {frame}, row {row}, column {column}: {found}, expected {minimum} to {maximum}\nhint: {hint}", value_words(*.found), .file.display())]
    Value {
        /// The file.
        file: PathBuf,
        /// The frame.
        frame: u64,
        /// The row in the file.
        row: usize,
        /// The column in the file.
        column: usize,
        /// The value.
        found: f64,
        /// The least allowed.
        minimum: f64,
        /// The most allowed.
        maximum: f64,
        /// What to do.
        hint: &'static str,
    },
    /// A value that the type of a .npy array cannot hold.
    #[error("{found} does not fit type {element} of {}: expected {minimum} to {maximum}, whole\nhint: write 8-byte floating point (`f8`) instead", .file.display())]
    DoesNotFit {
        /// The file.
        file: PathBuf,
        /// The value.
        found: f64,
        /// The type, as numpy writes it.
        element: &'static str,
        /// The least it holds.
        minimum: f64,
        /// The most it holds.
        maximum: f64,
    },
    /// Frames of two shapes in one file.
    #[error("frame {frame} has {} rows x {} columns, but {} holds frames of {} rows x {} columns\nhint: one file holds the frames of one sensor", .found.0, .found.1, .file.display(), .expected.0, .expected.1)]
    FrameShape {
        /// The file.
        file: PathBuf,
        /// The frame.
        frame: u64,
        /// Its rows and columns.
        found: (usize, usize),
        /// The rows and columns of the frames before it.
        expected: (usize, usize),
    },
    /// An array finished before or after as many frames as were announced.
    #[error("{} has {found} frames, {expected} announced\nhint: finish an array with as many frames as it was begun with", .file.display())]
    FrameCount {
        /// The file (with the array's name).
        file: PathBuf,
        /// Frames written.
        found: u64,
        /// Frames announced.
        expected: u64,
    },
    /// A file that is not a .npz archive.
    #[error("cannot read {} as an archive: {source}\nhint: write it with numpy.savez", .file.display())]
    Archive {
        /// The file.
        file: PathBuf,
        /// The archive reader's reason.
        source: zip::result::ZipError,
    },
    /// A .npz archive without that array.
    #[error("no array `{missing}` in {}: it has {}\nhint: name one of them", .file.display(), names_words(.found))]
    NoArray {
        /// The file.
        file: PathBuf,
        /// The name asked for.
        missing: String,
        /// The arrays there are.
        found: Vec<String>,
    },
    /// A recording that cannot be written on or read on.
    #[error("cannot go on in recording {} after {frames} frames: {source}\nhint: what is before that is whole; on a full disk make room; of a damaged file the rest can be recovered", .file.display())]
    Recording {
        /// The file.
        file: PathBuf,
        /// Frames until then.
        frames: u64,
        /// The reason.
        source: io::Error,
    },
    /// A recording whose writer was killed.
    #[error("recording {} has no end: it was cut off after {frames} frames, at byte {bytes}\nhint: what is there can be recovered", .file.display())]
    RecordingCut {
        /// The file.
        file: PathBuf,
        /// Whole frames in it.
        frames: u64,
        /// Bytes of the file.
        bytes: u64,
    },
    /// A recording whose file was damaged since; everything that is whole in it was given.
    #[error("recording {} is damaged: {what}\nhint: the rest can be recovered", .file.display())]
    RecordingDamaged {
        /// The file.
        file: PathBuf,
        /// What is missing.
        what: String,
    },
    /// A file of another kind.
    #[error("{} is not an MCAP file: it begins with {found}\nhint: a recording of text ends in .txt or .csv, an array in .npy", .file.display())]
    NotMcap {
        /// The file.
        file: PathBuf,
        /// Its first characters.
        found: String,
    },
    /// A message of a recording that is no frame.
    #[error("frame {frame} of {} cannot be read: {reason}\nhint: another program wrote it in another way", .file.display())]
    Message {
        /// The file.
        file: PathBuf,
        /// The frame.
        frame: u64,
        /// Why.
        reason: String,
    },
    /// A record of a recording that is larger than is read.
    #[error("a record or chunk of {} has {found} bytes, at most {limit} are read at once\nhint: `mcap compress --chunk-size` writes smaller ones", .file.display())]
    RecordSize {
        /// The file.
        file: PathBuf,
        /// Its bytes.
        found: u64,
        /// The most that are read.
        limit: u64,
    },
    /// Chunks packed in a way that is not read.
    #[error("the chunks of {} are packed with {found}, expected zstd or nothing\nhint: `mcap compress --compression zstd` writes them so", .file.display())]
    ChunkPacking {
        /// The file.
        file: PathBuf,
        /// The packing.
        found: String,
    },
    /// A recording of something else.
    #[error("no frames of counts in {}: it has {}\nhint: counts are `foxglove.Grid` messages, in recordings of this program on /taxel/counts", .file.display(), names_words(.found))]
    NoCounts {
        /// The file.
        file: PathBuf,
        /// The topics or fields there are.
        found: Vec<String>,
    },
    /// A recording of counts alone.
    #[error("no loads in {}: it holds counts alone", .file.display())]
    NoLoads {
        /// The file.
        file: PathBuf,
    },
    /// A format that is left out of this build.
    #[error("{}: this build has no {format}", .file.display())]
    NotBuilt {
        /// The file.
        file: PathBuf,
        /// The format.
        format: &'static str,
        /// The cargo feature that it needs.
        feature: &'static str,
    },
    /// What is wrong with a Parquet table.
    #[error(transparent)]
    Parquet(#[from] ParquetError),
    /// A .npz array packed in a way numpy never uses.
    #[error("cannot unpack `{array}` in {}: method {found}, expected 0 (stored) or 8 (deflated)\nhint: write it with numpy.savez or numpy.savez_compressed", .file.display())]
    Packing {
        /// The file.
        file: PathBuf,
        /// The array.
        array: String,
        /// The method.
        found: String,
    },
}
