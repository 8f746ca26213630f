//! What kind of error it is.

use std::io;

use super::{Error, ExportError, ParquetError};

impl Error {
    /// For a new file that cannot be begun.
    pub(crate) fn creating(file: &std::path::Path, source: io::Error) -> Self {
        let file = file.to_owned();
        match source.kind() {
            io::ErrorKind::AlreadyExists => Self::Exists { file },
            _ => Self::Create { file, source },
        }
    }

    /// Whether `keep_going` may leave out the frame and read on (the data is at fault, not the file system).
    pub fn is_one_frame(&self) -> bool {
        if let Error::Export(error) = self {
            return matches!(
                **error,
                ExportError::Line { .. }
                    | ExportError::Cut { .. }
                    | ExportError::Sum { .. }
                    | ExportError::NotWhole { .. }
            );
        }
        matches!(
            self,
            Error::CutShort { .. }
                | Error::NoExtraLine { .. }
                | Error::LineShape { .. }
                | Error::LineLength { .. }
                | Error::Word { .. }
                | Error::NotFinite { .. }
                | Error::Negative { .. }
                | Error::Time { .. }
                | Error::TooLarge { .. }
                | Error::NpyCutShort { .. }
                | Error::Value { .. }
                | Error::Message { .. }
                | Error::Parquet(ParquetError::RowLength { .. } | ParquetError::MarkCode { .. })
                | Error::RecordingCut { .. }
                | Error::RecordingDamaged { .. }
        )
    }
}
