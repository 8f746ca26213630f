//! Which file it was: SHA-256, as `sha256sum` prints it.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use sha2::{Digest, Sha256};

use taxel_io::exports::file_of;

use crate::error::Error;
use crate::reporter::{Silent, Stage};

/// Bytes and SHA-256 of a file, read piece by piece.
///
/// # Errors
/// [`Error::Fingerprint`] when it cannot be read.
pub fn of_file(path: &Path) -> Result<(u64, String), Error> {
    of_file_shown(path, &Silent)
}

/// The same, and a stage hears of every piece.
///
/// # Errors
/// As of [`of_file`]; [`Error::Stopped`].
pub fn of_file_shown(path: &Path, stage: &dyn Stage) -> Result<(u64, String), Error> {
    let unread = |source| Error::Fingerprint {
        file: path.to_owned(),
        source,
    };
    let mut file = File::open(file_of(path)).map_err(unread)?;
    let mut hash = Sha256::new();
    let mut piece = vec![0; 1 << 16];
    let mut bytes = 0;
    loop {
        if stage.is_stopped() {
            return Err(Error::Stopped);
        }
        let read = file.read(&mut piece).map_err(unread)?;
        if read == 0 {
            break;
        }
        bytes += read as u64;
        hash.update(&piece[..read]);
        stage.step();
    }
    Ok((bytes, digits(&hash.finalize())))
}

/// SHA-256 of a text.
pub fn of_text(text: &str) -> String {
    digits(&Sha256::digest(text.as_bytes()))
}

fn digits(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}
