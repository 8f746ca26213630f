//! What can go wrong between frames and a picture, with both numbers in every message.

impl Error {
    /// How much a picture needs at its smallest, where that is what was refused.
    pub(crate) fn needed_area(&self) -> Option<u64> {
        match self {
            Error::NoRoom {
                needed_width,
                needed_height,
                ..
            } => Some(needed_width * needed_height),
            _ => None,
        }
    }
}

/// Everything this crate refuses to do, and why.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// Values or marks do not fill the array.
    #[error("{what}: {rows} rows x {columns} columns need {expected}, found {found}")]
    Shape {
        /// `values` or `marks`.
        what: &'static str,
        /// rows × columns.
        expected: usize,
        /// How many there were.
        found: usize,
        /// Rows of the array.
        rows: usize,
        /// Columns of the array.
        columns: usize,
    },
    /// A picture of nothing.
    #[error("{what}: needs at least 1 {of}, found 0")]
    Empty {
        /// What was to be drawn.
        what: &'static str,
        /// What it is drawn from.
        of: &'static str,
    },
    /// A line of a series has not one value per position.
    #[error("series, line `{name}`: {expected} positions need {expected} values, found {found}")]
    LineLength {
        /// The line's name.
        name: String,
        /// Number of positions on the x axis.
        expected: usize,
        /// Number of values of the line.
        found: usize,
    },
    /// A taxel that the array does not have.
    #[error(
        "series: row {row}, column {column} is outside of {rows} rows x {columns} columns\nhint: both count from 0"
    )]
    TaxelOutside {
        /// Row asked for.
        row: usize,
        /// Column asked for.
        column: usize,
        /// Rows of the array.
        rows: usize,
        /// Columns of the array.
        columns: usize,
    },
    /// Frames of a series differ in size.
    #[error(
        "series: frame {index} has {rows} rows x {columns} columns, the first has {first_rows} x {first_columns}"
    )]
    FrameShape {
        /// Position of the frame, from 0.
        index: usize,
        /// Its rows.
        rows: usize,
        /// Its columns.
        columns: usize,
        /// Rows of the first frame.
        first_rows: usize,
        /// Columns of the first frame.
        first_columns: usize,
    },
    /// A file name whose ending is no picture format.
    #[error("no picture format has the extension `{extension}`\nhint: known are {known}")]
    UnknownFormat {
        /// What the file name ends in, empty where it has no extension.
        extension: String,
        /// The extensions that would do.
        known: &'static str,
    },
    /// More pixels than a PNG is made with.
    #[error(
        "picture of {width} x {height} pixels is over the limit of {limit} pixels\nhint: draw fewer frames, ask for a smaller picture or fewer dots per inch, or write .svg"
    )]
    TooLarge {
        /// Width in pixels.
        width: u64,
        /// Height in pixels.
        height: u64,
        /// Most pixels allowed.
        limit: u64,
    },
    /// A size in which the plots and their labels have no room.
    #[error(
        "a picture of {width} x {height} {unit} has no room for its plots and labels: at their smallest they need {needed_width} x {needed_height}\nhint: ask for a larger picture, or for fewer dots per inch"
    )]
    NoRoom {
        /// `pixels` or `points`.
        unit: &'static str,
        /// Width asked for.
        width: u32,
        /// Height asked for.
        height: u32,
        /// Width that would do.
        needed_width: u64,
        /// Height that would do.
        needed_height: u64,
    },
    /// A `.pdf` was asked of a build without it.
    #[error(
        "this build has no PDF\nhint: write .svg or .png, or build taxel-plot with its feature `pdf`"
    )]
    NoPdf,
    /// The PDF could not be made.
    #[error("PDF could not be made: {message}")]
    Pdf {
        /// What stood in the way.
        message: String,
    },
    /// A report of more pages than are set.
    #[error(
        "report of more than {limit} pages is not set on paper\nhint: shorten its tables, or write .html"
    )]
    TooManyPages {
        /// Most pages allowed.
        limit: usize,
    },
    /// The rasteriser did not accept the picture.
    #[error("picture could not be rasterised: {message}")]
    Raster {
        /// The rasteriser's words.
        message: String,
    },
    /// A picture of a movie is not as large as the first.
    #[error(
        "movie: a picture has {width} x {height} pixels, the first has {first_width} x {first_height}"
    )]
    PictureSize {
        /// Its width in pixels.
        width: u64,
        /// Its height in pixels.
        height: u64,
        /// Width of the first.
        first_width: u64,
        /// Height of the first.
        first_height: u64,
    },
    /// A movie could not be encoded.
    #[error("GIF could not be encoded: {message}")]
    Gif {
        /// The encoder's words.
        message: String,
    },
    /// The pixels could not be encoded.
    #[error("PNG could not be encoded: {message}")]
    Png {
        /// The encoder's words.
        message: String,
    },
}
