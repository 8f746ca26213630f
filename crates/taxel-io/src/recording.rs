//! Recordings of any format, by the extension of their name.

use std::path::Path;

use crate::error::{Error, Place};
use crate::exports::{self, ExportReader};
use crate::grid::{Kind, kind_of};
use crate::lines::{Line, Lines};
use crate::mcap::McapReader;
use crate::npy::{NpyOptions, NpyReader, layout_of};
use crate::number::{count_fields, is_blank};
use crate::options::{ReadOptions, extension};
use crate::parquet::{self, ParquetReader};
use crate::source::{FrameSource, open_input};
use crate::text::TextReader;

/// Opens a recording of counts: `.txt`, `.csv`, `.npy`, `.npz` (its first array), `.mcap`, `.parquet`; what another program has
/// exported ([`exports`]), by its content; `-` is text on standard input.
///
/// # Errors
/// [`Error::Open`], [`Error::UnknownFormat`], and for arrays all that their header can be wrong in.
pub fn open_counts(
    path: impl AsRef<Path>,
    options: ReadOptions,
) -> Result<Box<dyn FrameSource + Send>, Error> {
    let path = path.as_ref();
    if let Some(reader) = ExportReader::open(path, options)? {
        return Ok(Box::new(reader));
    }
    Ok(match format_of(path)? {
        Format::Text => Box::new(TextReader::open(path, options)?),
        Format::Array => Box::new(NpyReader::open(path, NpyOptions::from(options))?),
        Format::Mcap => Box::new(McapReader::open(path, options)?),
        Format::Parquet => Box::new(ParquetReader::open_counts(path, options)?),
    })
}

enum Format {
    Text,
    Array,
    Mcap,
    Parquet,
}

fn format_of(path: &Path) -> Result<Format, Error> {
    match extension(path).as_str() {
        "txt" | "csv" => Ok(Format::Text),
        "npy" | "npz" => Ok(Format::Array),
        "mcap" => Ok(Format::Mcap),
        "parquet" => Ok(Format::Parquet),
        _ if path.as_os_str() == "-" || path == Path::new("/dev/stdin") => Ok(Format::Text),
        other => Err(Error::UnknownFormat {
            file: path.to_owned(),
            extension: match other {
                "" => String::new(),
                other => format!(".{other}"),
            },
        }),
    }
}

/// The sensor file that a recording carries: `.mcap` and `.parquet` may, and what another program has exported stands for one; the
/// others never do.
///
/// # Errors
/// [`Error::Open`], and all that the end of such a file can be wrong in.
pub fn sensor_toml_of(path: impl AsRef<Path>) -> Result<Option<String>, Error> {
    let path = path.as_ref();
    // By what is in it, whatever it is called.
    if let Some(spec) = exports::sensor_of(path)? {
        return Ok(Some(spec.to_toml()));
    }
    match extension(path).as_str() {
        "mcap" => Ok(McapReader::open_any(path)?.sensor_toml().map(str::to_owned)),
        "parquet" => parquet::sensor_toml_of(path),
        _ => Ok(None),
    }
}

/// What a file says about its shape without a sensor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ShapeGuess {
    /// Rows of a frame: exact for arrays, .mcap and .parquet (unknown for another program's table); for text only where
    /// extra lines part the frames.
    pub rows: Option<usize>,
    /// Columns of a frame: as the rows; for text the numbers on the first line of numbers.
    pub columns: Option<usize>,
    /// Frames: exact for arrays and .parquet, else unknown.
    pub frames: Option<u64>,
    /// Whether a text file has an extra line before its first frame.
    pub extra_line: Option<bool>,
}

/// Looks at the beginning of a recording for its shape.
///
/// # Errors
/// [`Error::Open`], [`Error::UnknownFormat`], [`Error::Empty`], and all that an array's header can be wrong in.
pub fn shape_of(path: impl AsRef<Path>) -> Result<ShapeGuess, Error> {
    let path = path.as_ref();
    match format_of(path)? {
        Format::Array => {
            let layout = layout_of(path)?;
            Ok(ShapeGuess {
                rows: Some(layout.rows),
                columns: Some(layout.columns),
                frames: Some(layout.frames),
                extra_line: None,
            })
        }
        Format::Mcap => {
            let (rows, columns) = McapReader::open_any(path)?.shape();
            Ok(ShapeGuess {
                rows: Some(rows),
                columns: Some(columns),
                ..ShapeGuess::default()
            })
        }
        Format::Parquet => {
            let (shape, frames) = parquet::shape_of(path)?;
            Ok(ShapeGuess {
                rows: shape.map(|(rows, _)| rows),
                columns: shape.map(|(_, columns)| columns),
                frames: Some(frames),
                extra_line: None,
            })
        }
        Format::Text => shape_of_text(path),
    }
}

/// The longest line and the most lines looked at for a shape.
const LINE_BYTES: usize = 1 << 20;
const LINES: usize = 1 << 16;

fn shape_of_text(path: &Path) -> Result<ShapeGuess, Error> {
    let mut lines = Lines::new(open_input(path)?.0, LINE_BYTES);
    let mut guess = ShapeGuess::default();
    let mut rows = 0;
    let mut first = None;
    for number in 0..LINES {
        let line = lines.next().map_err(|source| Error::Read {
            file: path.to_owned(),
            bytes: lines.bytes(),
            source,
        })?;
        if line == Line::End {
            break;
        }
        let text = lines.text(line);
        if first.is_none() && !is_blank(text) {
            first = Some((
                lines.number(),
                String::from_utf8_lossy(text).chars().count(),
                text.contains(&b','),
            ));
        }
        let extra = match guess.columns {
            None => is_blank(text) || kind_of(text, usize::MAX, 0).is_some_and(looks_extra),
            Some(columns) => kind_of(text, columns, 0).is_some(),
        };
        if number == 0 {
            guess.extra_line = Some(extra);
        }
        match (extra, guess.columns) {
            (true, None) => {}
            (true, Some(_)) => {
                guess.rows = Some(rows).filter(|_| guess.extra_line == Some(true));
                break;
            }
            (false, None) => {
                guess.columns = Some(count_fields(text)).filter(|n| *n > 0);
                rows += 1;
            }
            (false, Some(1)) if number == 1 && count_fields(text) > 1 => {
                // The number alone on the first line was a time stamp.
                guess.columns = Some(count_fields(text));
                guess.extra_line = Some(true);
            }
            (false, Some(_)) => rows += 1,
        }
    }
    if guess.columns.is_none() {
        return Err(no_numbers(path, first));
    }
    Ok(guess)
}

/// No line of the file is one of numbers; `first` is the first that is not blank: its number, its characters, and whether it has a
/// comma.
fn no_numbers(path: &Path, first: Option<(u64, usize, bool)>) -> Error {
    let file = path.to_owned();
    let Some((line, characters, has_comma)) = first else {
        return Error::Empty {
            file,
            what: "line of numbers",
            found: 0,
        };
    };
    Error::NoNumbers {
        at: Place {
            file,
            line,
            column: 1,
        },
        hint: if has_comma {
            "frames of counts as text are lines of numbers and nothing else"
        } else {
            "numbers of a frame are separated by commas; `tr -s ' \\t' ','` puts them in"
        },
        characters,
    }
}

/// Before the number of columns is known, words are no line of a frame.
fn looks_extra(kind: Kind) -> bool {
    matches!(kind, Kind::Blank | Kind::Words(_))
}
