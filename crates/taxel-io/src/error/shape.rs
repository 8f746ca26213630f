//! Shapes that do not fit.

use std::fmt;
use std::path::Path;

use super::Error;

/// What is the matter with a frame's or a recording's shape; as text, a hint.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum ShapeFault {
    /// Rows and columns are swapped in the file.
    Swapped,
    /// They are not, and were to be read swapped.
    NotSwapped,
    /// It is another array's.
    OtherSensor,
    /// A line is torn or lost.
    Torn,
    /// A blank line stands between frames.
    BlankLines,
    /// An array of so many dimensions holds no frames.
    Dimensions,
    /// No frame lies together in it.
    FortranOrder,
}

impl fmt::Display for ShapeFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Swapped => "rows and columns are swapped in this file",
            Self::NotSwapped => "rows and columns are not swapped in this file",
            Self::OtherSensor => {
                "the recording is of another sensor; check rows and columns in the sensor file"
            }
            Self::Torn => "a line was torn or lost",
            Self::BlankLines => {
                "blank lines between frames are the .csv form; name the file .csv, or read it with an extra line"
            }
            Self::Dimensions => "reshape the array with numpy.reshape",
            Self::FortranOrder => {
                "write numpy.ascontiguousarray(frames): in Fortran order no frame lies together"
            }
        })
    }
}

/// A file that says of its own which shape its frames have, and it is not the sensor's.
pub(crate) fn other_shape(file: &Path, found: (usize, usize), expected: (usize, usize)) -> Error {
    let words = |(rows, columns): (usize, usize)| format!("{rows} rows x {columns} columns");
    Error::FileShape {
        file: file.to_owned(),
        found: words(found),
        expected: words(expected),
        hint: if found == (expected.1, expected.0) {
            ShapeFault::Swapped
        } else {
            ShapeFault::OtherSensor
        },
    }
}
