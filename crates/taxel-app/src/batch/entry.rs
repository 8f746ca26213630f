//! What a folder says of one recording: what it was, what was made of it and with what.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::UNIX_EPOCH;

use serde::{Deserialize, Serialize};
use taxel_io::AtomicFile;
use taxel_io::exports::file_of;

use super::row::Row;
use crate::error::Error;
use crate::fingerprint;
use crate::reporter::Until;

/// Ending of entries.
pub(super) const ENDING: &str = "entry.json";
/// The program that makes them.
pub(super) const PROGRAM: &str = concat!("taxel ", env!("CARGO_PKG_VERSION"));

/// How it went with a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Status {
    /// All of its frames have an answer.
    Done,
    /// Frames are missing, were left out, or have no answer or several.
    Incomplete,
    /// There is nothing of it.
    Broken,
}

impl Status {
    /// Its word.
    pub fn word(self) -> &'static str {
        match self {
            Status::Done => "done",
            Status::Incomplete => "incomplete",
            Status::Broken => "broken",
        }
    }
}

/// One recording, and what was made of it.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Entry {
    /// Its path, as it was given.
    pub recording: String,
    /// Its bytes.
    pub bytes: u64,
    /// When it was last changed, seconds since 1970.
    pub modified_secs: f64,
    /// SHA-256 of it; empty where it cannot be read.
    pub sha256: String,
    /// What it was worked through by,
    pub program: String,
    /// and what that was told.
    pub settings_sha256: String,
    /// How it went.
    pub status: Status,
    /// Why there is nothing of it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<String>,
    /// How long it took.
    pub seconds: f64,
    /// The files that were written, beside this entry.
    pub files: Vec<Written>,
    /// Its line of the summary; where it is broken, none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub row: Option<Row>,
}

/// A file that was written.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Written {
    /// What stands behind the recording's name in its own.
    pub ending: String,
    /// Its bytes.
    pub bytes: u64,
}

impl Entry {
    /// There is nothing of the recording after all.
    pub(super) fn break_off(&mut self, error: &Error) {
        (self.status, self.row) = (Status::Broken, None);
        self.error = Some(error.to_string());
    }

    /// Writes it beside what was made of the recording, whose files begin as `place` does.
    pub(super) fn write(&self, place: &Path) -> Result<(), Error> {
        let file = with_ending(place, ENDING);
        let folder = file.parent().expect("a file lies in a folder");
        fs::create_dir_all(folder).map_err(|source| Error::Folder {
            folder: folder.to_owned(),
            source,
        })?;
        let text = serde_json::to_vec_pretty(self).expect("numbers and words");
        Ok(AtomicFile::write_whole(&file, &text)?)
    }
}

/// A path as it stands in tables; what is no text in it as its bytes.
pub(super) fn words(path: &Path) -> String {
    match path.to_str() {
        Some(text) => text.to_owned(),
        None => format!("{path:?}"),
    }
}

/// `place` with something more behind it: a recording keeps its own ending.
pub(super) fn with_ending(place: &Path, ending: &str) -> PathBuf {
    let mut name = place.as_os_str().to_owned();
    name.push(".");
    name.push(ending);
    name.into()
}

/// Bytes of a file, and when it was last changed.
pub(super) fn about(recording: &Path) -> (u64, f64) {
    let Ok(about) = fs::metadata(file_of(recording)) else {
        return (0, 0.0);
    };
    let modified = about.modified().ok();
    let since = modified.and_then(|at| at.duration_since(UNIX_EPOCH).ok());
    (about.len(), since.map_or(0.0, |since| since.as_secs_f64()))
}

/// The entry at a place, whatever it says; `None` where there is none that can be understood.
pub(super) fn read(place: &Path) -> Option<Entry> {
    let text = fs::read(with_ending(place, ENDING)).ok()?;
    serde_json::from_slice(&text).ok()
}

/// The entry of a recording that needs no more work: the same file, the same program, the same settings, and all that was
/// written still there. What is broken is tried again: the disk may have been full. Not found where nobody wants it any more.
pub(super) fn found(
    place: &Path,
    recording: &Path,
    settings: &str,
    wanted: Until,
) -> Option<Entry> {
    let entry = read(place)?;
    let same = entry.program == PROGRAM && entry.settings_sha256 == settings;
    let there = entry.files.iter().all(|file| {
        let about = fs::metadata(with_ending(place, &file.ending));
        about.is_ok_and(|about| about.len() == file.bytes)
    });
    if !same || !there || entry.row.is_none() {
        return None;
    }
    let (bytes, modified_secs) = about(recording);
    // As copied files have other dates, the content counts where the date has changed.
    let is_same = entry.bytes == bytes
        && (entry.modified_secs == modified_secs
            || fingerprint::of_file_shown(recording, &wanted)
                .is_ok_and(|(_, sum)| sum == entry.sha256));
    is_same.then(|| Entry {
        recording: words(recording),
        ..entry
    })
}
