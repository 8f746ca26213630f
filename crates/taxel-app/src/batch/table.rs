//! All recordings of an archive in two tables: what came of them, and how.

use std::path::Path;

use taxel_io::AtomicFile;

use super::entry::{Entry, Status};
use super::row::Row;
use crate::error::Error;

/// A line a recording: what came of it. The same for the same recordings, program and settings, byte for byte.
///
/// # Errors
/// A file that cannot be written.
pub fn summary(file: &Path, entries: &[Entry]) -> Result<(), Error> {
    let names: Vec<String> = Row::default()
        .cells()
        .into_iter()
        .map(|(name, _)| name)
        .collect();
    let mut heading = vec!["recording".to_owned(), "status".to_owned()];
    heading.extend(names.iter().cloned());
    heading.push("error".to_owned());
    let lines = entries.iter().map(|entry| {
        let mut line = vec![entry.recording.clone(), entry.status.word().to_owned()];
        match &entry.row {
            Some(row) => line.extend(row.cells().into_iter().map(|(_, cell)| cell)),
            None => line.extend(names.iter().map(|_| String::new())),
        }
        // In one line: what is told of a recording is its line.
        line.push(
            entry
                .error
                .as_deref()
                .unwrap_or_default()
                .replace('\n', "; "),
        );
        line
    });
    write(file, heading, lines)
}

/// A line a recording: which file it was, what it was worked through with, how long that took.
///
/// # Errors
/// A file that cannot be written.
pub fn manifest(file: &Path, entries: &[Entry]) -> Result<(), Error> {
    let heading = [
        "recording",
        "bytes",
        "sha256",
        "program",
        "settings_sha256",
        "status",
        "seconds",
    ];
    let lines = entries.iter().map(|entry| {
        vec![
            entry.recording.clone(),
            entry.bytes.to_string(),
            entry.sha256.clone(),
            entry.program.clone(),
            entry.settings_sha256.clone(),
            entry.status.word().to_owned(),
            format!("{:.3}", entry.seconds),
        ]
    });
    write(file, heading.map(str::to_owned).into(), lines)
}

fn write(
    file: &Path,
    heading: Vec<String>,
    lines: impl Iterator<Item = Vec<String>>,
) -> Result<(), Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for line in std::iter::once(heading).chain(lines) {
        // Into memory: nothing that could fail.
        let _ = writer.write_record(&line);
    }
    let bytes = writer.into_inner().expect("it is written into memory");
    Ok(AtomicFile::write_whole(file, &bytes)?)
}

impl Entry {
    /// Whether all of its frames have an answer.
    pub fn is_whole(&self) -> bool {
        self.status == Status::Done
    }
}
