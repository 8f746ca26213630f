//! Files that are no text, known by their first bytes: archives, and sheets of a spreadsheet. What is in them would be read.

use std::path::Path;

use super::text_file::TextFile;
use super::{ExportAbout, Open, Parser};
use crate::error::{Error, ExportError, Place};

/// What a file is packed into.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Packed {
    /// gzip, one file.
    Gzip,
    /// zip: an archive, or a sheet.
    Zip,
    /// What older spreadsheets write.
    OldSheet,
}

impl Packed {
    /// What a file that begins with such bytes is packed into, if it is.
    pub(super) fn of(bytes: &[u8]) -> Option<Self> {
        [
            (&b"\x1F\x8B"[..], Self::Gzip),
            (b"PK\x03\x04", Self::Zip),
            (b"\xD0\xCF\x11\xE0", Self::OldSheet),
        ]
        .into_iter()
        .find_map(|(first, packed)| bytes.starts_with(first).then_some(packed))
    }

    /// What "opens" such a file.
    pub(super) fn refuse(self) -> Open {
        match self {
            Self::Gzip => |file| {
                let hint = "unpack it: `gunzip` gives the file that is in it";
                refused(file, "a file packed by gzip", hint)
            },
            Self::Zip => |file| {
                let hint = "unpack the archive; save a sheet (.xlsx) as text or CSV";
                refused(file, "an archive (zip) or a sheet (.xlsx)", hint)
            },
            Self::OldSheet => |file| {
                let hint =
                    "save it as text or CSV in the program that it is of, or in a spreadsheet";
                refused(file, "an old sheet (.xls)", hint)
            },
        }
    }
}

fn refused(
    file: &Path,
    found: &str,
    hint: &'static str,
) -> Result<(ExportAbout, Box<dyn Parser>), Error> {
    TextFile::open(file)?;
    Err(Error::Export(Box::new(ExportError::Line {
        format: "text",
        at: Place {
            file: file.to_owned(),
            line: 1,
            column: 1,
        },
        found: found.to_owned(),
        expected: "lines of text".to_owned(),
        hint,
    })))
}
