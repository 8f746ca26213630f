//! What is read at a place that is sought: a second, the sensor of a recording whose beginning is lost, a tare.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

use mcap::records::Record;

use super::index::Index;
use super::read::McapReader;
use super::scan::{Found, Scanner};
use super::{METADATA, parse};
use crate::error::Error;
use crate::source::open_file;
use crate::tare::{self, Tare};

impl McapReader {
    /// Goes to the first frame `secs` after the beginning; false where the recording has no index.
    ///
    /// # Errors
    /// [`Error::Read`].
    pub fn seek(&mut self, secs: f64) -> Result<bool, Error> {
        let (Some(index), Some(counts)) = (&self.index, self.topics.counts()) else {
            return Ok(false);
        };
        let begin = index.statistics.message_start_time;
        let wanted = begin.saturating_add((secs.max(0.0) * 1e9) as u64);
        let later = index
            .chunks
            .iter()
            .position(|chunk| chunk.message_end_time >= wanted);
        let Some(place) = later.or(index.chunks.len().checked_sub(1)) else {
            return Ok(false);
        };
        let offset = index.chunks[place].chunk_start_offset;
        let file = self.scanner.input_mut();
        let before = index.messages_before(file, counts, place);
        let tares = index.attachments.iter().rev();
        let tare = tares
            .filter(|(name, at)| name == tare::NAME && *at < offset)
            .find_map(|(_, at)| tare_at(file, *at));
        let share = index.secs(wanted) / index.secs(index.statistics.message_end_time).max(1e-9);
        let guess = share.min(1.0) * index.messages(counts).unwrap_or(0) as f64;
        let failed = |source| Error::Read {
            file: self.path.clone(),
            bytes: offset,
            source,
        };
        let mut file = file.try_clone().map_err(failed)?;
        file.seek(SeekFrom::Start(offset)).map_err(failed)?;
        self.scanner = Scanner::from_record(file, self.scanner.total(), offset);
        self.frames = before.unwrap_or(guess as u64);
        self.tare = tare;
        self.forget_place();
        loop {
            self.ahead = self.read_grid()?;
            match &self.ahead {
                Some(ahead) if ahead.log_time < wanted => self.frames += 1,
                _ => break,
            }
        }
        self.events.retain(|event| event.log_time >= wanted);
        Ok(true)
    }
}

fn tare_at(file: &mut File, at: u64) -> Option<Tare> {
    match record_at(file, at)? {
        Record::Attachment { header, data, .. } => Tare::from_attachment(header.log_time, &data),
        _ => None,
    }
}

fn record_at(file: &mut File, at: u64) -> Option<Record<'static>> {
    file.seek(SeekFrom::Start(at)).ok()?;
    match Scanner::from_record(file, None, at).next() {
        Ok(Found::Record(record)) => Some(record),
        _ => None,
    }
}

/// What a recording says about itself, wherever it does: by its index, else by looking through all of it.
pub(super) fn about(path: &Path, index: Option<&Index>) -> BTreeMap<String, String> {
    let Ok((mut file, total)) = open_file(path) else {
        return BTreeMap::new();
    };
    if total.is_none() {
        // A pipe cannot be read twice.
        return BTreeMap::new();
    }
    let indexed = index.map(|index| index.metadata.as_slice());
    let indexed = indexed.unwrap_or_default().iter();
    for (_, at) in indexed.filter(|(name, _)| name == METADATA) {
        if let Some(found) = record_at(&mut file, *at).and_then(about_of) {
            return found;
        }
    }
    if file.seek(SeekFrom::Start(0)).is_err() {
        return BTreeMap::new();
    }
    let mut scanner = Scanner::new(file, total);
    loop {
        match scanner.next() {
            Ok(Found::Record(record)) => {
                if let Some(found) = about_of(record) {
                    return found;
                }
            }
            Ok(Found::Chunk(_) | Found::LostChunk | Found::Lost { .. } | Found::Unreadable) => {}
            _ => return BTreeMap::new(),
        }
    }
}

/// Of a record that says it, and is as it was written.
pub(super) fn about_of(record: Record) -> Option<BTreeMap<String, String>> {
    match record {
        Record::Metadata(found) if found.name == METADATA && parse::is_sealed(&found.metadata) => {
            Some(found.metadata)
        }
        _ => None,
    }
}

/// The first characters of a file that is something else, for a message.
pub(super) fn beginning(path: &Path) -> String {
    let mut bytes = Vec::new();
    let read = File::open(path).and_then(|file| file.take(16).read_to_end(&mut bytes));
    match read {
        Ok(0) => "nothing".to_owned(),
        Ok(_) => format!("`{}`", bytes.escape_ascii()),
        Err(_) => "something else".to_owned(),
    }
}
