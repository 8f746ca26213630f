//! Small files of text, read whole.

use std::path::Path;

use taxel_io::bounded;

use crate::error::Error;

/// The text of a file of at most `limit` bytes; `what` says what it is, as in "a protocol".
///
/// # Errors
/// A file that cannot be opened or read, is no text, or is longer.
pub fn read(file: &Path, what: &'static str, limit: u64) -> Result<String, Error> {
    let text = bounded::read_text(file, limit).map_err(|source| taxel_io::Error::Open {
        file: file.to_owned(),
        source,
    })?;
    text.ok_or_else(|| Error::TextLength {
        file: file.to_owned(),
        what,
        limit,
    })
}
