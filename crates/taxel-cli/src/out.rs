//! Standard output for results, standard error for everything else; neither panics when nobody reads.

use std::io::{self, Write};
use std::path::Path;

use serde::Serialize;

use taxel::solve::Outcome;
use taxel_app::chain::stop_words;
use taxel_io::AtomicFile;

use crate::error::Error;

/// Writes a result to standard output, with a line end.
pub(crate) fn result(text: &str) -> Result<(), Error> {
    let mut out = io::stdout().lock();
    out.write_all(text.trim_end().as_bytes())
        .and_then(|()| out.write_all(b"\n"))
        .and_then(|()| out.flush())
        .map_err(Error::Stdout)
}

/// Writes a result to standard output as JSON.
pub(crate) fn json(value: &impl Serialize) -> Result<(), Error> {
    result(&serde_json::to_string_pretty(value).expect("plain data"))
}

/// Writes a line for the user to standard error.
pub(crate) fn note(text: &str) {
    let _ = writeln!(io::stderr(), "{}", text.trim_end());
}

/// Writes a warning to standard error.
pub(crate) fn warn(text: &str) {
    note(&format!("warning: {text}"));
}

/// Whether this name stands for standard output.
pub(crate) fn is_stdout(path: &Path) -> bool {
    path.as_os_str() == "-" || path == Path::new("/dev/stdout")
}

/// Writes a whole file, or leaves what was there.
pub(crate) fn file(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    Ok(AtomicFile::write_whole(path, bytes)?)
}

/// Warns of a frame that came to no answer.
pub(crate) fn warn_unsolved(frame: u64, outcome: &Outcome) {
    if let (word, Some(why)) = stop_words(outcome) {
        warn(&format!("frame {frame}: {word}: {why}"));
    }
}
