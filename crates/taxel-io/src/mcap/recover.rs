//! A recording whose writer was killed, or that was damaged since, made whole again.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::fs::File;
use std::io::{Seek, SeekFrom};
use std::path::Path;

use mcap::records::{MessageHeader, Record, Statistics};
use mcap::{Compression, McapResult, WriteOptions, Writer};

use super::index::Index;
use super::parse::{self, Records};
use super::scan::{Found, MAX_RECORD, Scanner};
use super::tail::Tail;
use super::topics::{self, topic_of};
use super::{COUNTS, sought};
use crate::error::Error;
use crate::source::open_file;

/// What was saved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Recovered {
    /// Messages of every topic.
    pub messages: u64,
    /// Frames of counts among them.
    pub frames: u64,
    /// Chunks that were damaged inside, and left out.
    pub chunks_lost: u64,
    /// Messages that the recording says it had, and that were not found.
    pub messages_lost: u64,
    /// Records that could not be understood, and left out.
    pub records_lost: u64,
    /// Bytes that belonged to nothing whole.
    pub bytes_lost: u64,
    /// The checksum over all of the old file's data did not fit.
    pub checksum_differs: bool,
    /// The recording had its end.
    pub was_whole: bool,
}

impl Recovered {
    /// Whether all that was recorded was saved.
    pub fn is_all(&self) -> bool {
        let saved = Self {
            messages: self.messages,
            frames: self.frames,
            was_whole: true,
            ..Self::default()
        };
        *self == saved
    }
}

/// Copies all that is whole in `from` to a new recording `to`, which appears once it is whole itself; where no message
/// is whole, not at all.
///
/// # Errors
/// [`Error::Open`], [`Error::NotMcap`] for something that never was a recording, [`Error::Exists`], [`Error::Create`],
/// [`Error::Write`] for a disk that is full; [`Error::RecordSize`], [`Error::ChunkPacking`] for recordings of others.
pub fn recover(from: impl AsRef<Path>, to: impl AsRef<Path>) -> Result<Recovered, Error> {
    let (from, to) = (from.as_ref(), to.as_ref());
    let (mut file, total) = open_file(from)?;
    let index = total.and_then(|total| Index::read(&mut file, total));
    let failed = |source| Error::Read {
        file: from.to_owned(),
        bytes: 0,
        source,
    };
    if total.is_some() {
        file.seek(SeekFrom::Start(0)).map_err(failed)?;
    }
    let mut scanner = Scanner::new(file, total);
    // Before anything is begun: is it a recording at all?
    let first = scanner.next().map_err(failed)?;
    if matches!(first, Found::NotMcap) {
        return Err(Error::NotMcap {
            file: from.to_owned(),
            found: sought::beginning(from),
        });
    }
    let writing = |error: mcap::McapError| Error::Write {
        file: to.to_owned(),
        bytes: 0,
        kept: None,
        source: match error {
            mcap::McapError::Io(source) => source,
            other => std::io::Error::other(other),
        },
    };
    let mut copy = Copy::new(Tail::once(to)?, index.as_ref()).map_err(writing)?;
    let about = sought::about(from, index.as_ref());
    copy.about(about).map_err(writing)?;
    copy_all(from, &mut scanner, first, &mut copy, writing)?;
    copy.saved.checksum_differs = scanner.sum_is_right == Some(false);
    copy.saved.was_whole = scanner.is_whole();
    copy.finish(to, index.map(|index| index.statistics))
}

fn copy_all(
    from: &Path,
    scanner: &mut Scanner<File>,
    first: Found,
    copy: &mut Copy,
    writing: impl Fn(mcap::McapError) -> Error,
) -> Result<(), Error> {
    let mut found = first;
    loop {
        match found {
            Found::Chunk(content) => {
                for (opcode, body) in Records(&content) {
                    match parse::record(opcode, body) {
                        Some(record) => copy.take(record).map_err(&writing)?,
                        None => copy.saved.records_lost += 1,
                    }
                }
            }
            Found::Record(record) => copy.take(record).map_err(&writing)?,
            Found::LostChunk => copy.saved.chunks_lost += 1,
            Found::Unreadable => copy.saved.records_lost += 1,
            Found::Lost { bytes } => copy.saved.bytes_lost += bytes,
            Found::Cut { bytes } => {
                copy.saved.bytes_lost += bytes;
                return Ok(());
            }
            Found::End | Found::NotMcap => return Ok(()),
            Found::TooLarge { bytes } => {
                return Err(Error::RecordSize {
                    file: from.to_owned(),
                    found: bytes,
                    limit: MAX_RECORD as u64,
                });
            }
            Found::Packing(found) => {
                return Err(Error::ChunkPacking {
                    file: from.to_owned(),
                    found,
                });
            }
        }
        found = scanner.next().map_err(|source| Error::Read {
            file: from.to_owned(),
            bytes: scanner.position(),
            source,
        })?;
    }
}

struct Copy {
    writer: Writer<Tail>,
    /// Schemas and channels of the old file, by the ids that the new one gives them.
    schemas: HashMap<u16, u16>,
    channels: HashMap<u16, (u16, bool)>,
    /// What channels are, of those that no message has yet come of.
    declared: HashMap<u16, mcap::records::Channel>,
    schema_records: HashMap<u16, (String, String, Vec<u8>)>,
    /// Metadata records that are in the new file already: some are said twice.
    said: HashSet<(String, BTreeMap<String, String>)>,
    saved: Recovered,
}

impl Copy {
    fn new(output: Tail, index: Option<&Index>) -> McapResult<Self> {
        let writer = WriteOptions::new()
            .profile("taxel")
            .compression(Some(Compression::Zstd))
            .compression_level(1)
            .compression_threads(0)
            .disable_seeking(true)
            .create(output)?;
        let mut copy = Self {
            writer,
            schemas: HashMap::new(),
            channels: HashMap::new(),
            declared: HashMap::new(),
            schema_records: HashMap::new(),
            said: HashSet::new(),
            saved: Recovered::default(),
        };
        for record in index.into_iter().flat_map(|index| &index.declared) {
            copy.declare(record);
        }
        Ok(copy)
    }

    /// What the recording says about itself comes first, wherever it was found.
    fn about(&mut self, about: BTreeMap<String, String>) -> McapResult<()> {
        if about.is_empty() {
            Ok(())
        } else {
            self.metadata(mcap::records::Metadata {
                name: super::METADATA.to_owned(),
                metadata: about,
            })
        }
    }

    fn metadata(&mut self, metadata: mcap::records::Metadata) -> McapResult<()> {
        let fresh = (metadata.name.clone(), metadata.metadata.clone());
        if self.said.insert(fresh) {
            self.writer.write_metadata(&metadata)
        } else {
            Ok(())
        }
    }

    /// Remembers what a schema or a channel is.
    fn declare(&mut self, record: &Record) {
        match record {
            Record::Schema { header, data } => {
                let schema = (
                    header.name.clone(),
                    header.encoding.clone(),
                    data.clone().into_owned(),
                );
                self.schema_records.insert(header.id, schema);
            }
            Record::Channel(channel) => {
                self.declared.insert(channel.id, channel.clone());
            }
            _ => {}
        }
    }

    fn take(&mut self, record: Record) -> McapResult<()> {
        match record {
            Record::Schema { .. } | Record::Channel(_) => self.declare(&record),
            Record::Message { header, data } => self.message(header, &data)?,
            Record::Metadata(metadata) if !parse::is_sealed(&metadata.metadata) => {
                self.saved.records_lost += 1;
            }
            Record::Metadata(metadata) => self.metadata(metadata)?,
            Record::Attachment { header, data, .. } => {
                self.writer.attach(&mcap::Attachment {
                    log_time: header.log_time,
                    create_time: header.create_time,
                    name: header.name,
                    media_type: header.media_type,
                    data,
                })?;
            }
            _ => {}
        }
        Ok(())
    }

    fn message(&mut self, mut header: MessageHeader, data: &[u8]) -> McapResult<()> {
        let Some((id, counts)) = self.channel(header.channel_id, data)? else {
            self.saved.records_lost += 1;
            return Ok(());
        };
        header.channel_id = id;
        self.writer.write_to_known_channel(&header, data)?;
        self.saved.messages += 1;
        self.saved.frames += u64::from(counts);
        Ok(())
    }

    /// The new file's channel for one of the old file: as it was declared, else by what its messages hold.
    fn channel(&mut self, old: u16, data: &[u8]) -> McapResult<Option<(u16, bool)>> {
        if let Some(known) = self.channels.get(&old) {
            return Ok(Some(*known));
        }
        let found = match self.declared.get(&old).cloned() {
            Some(channel) => {
                let schema = self.schema(channel.schema_id)?;
                let (encoding, metadata) = (&channel.message_encoding, &channel.metadata);
                let id = self
                    .writer
                    .add_channel(schema, &channel.topic, encoding, metadata)?;
                (id, channel.topic == COUNTS)
            }
            None => match topic_of(data) {
                Some(topic) => (topics::begin(&mut self.writer, topic)?, topic == COUNTS),
                None => return Ok(None),
            },
        };
        self.channels.insert(old, found);
        Ok(Some(found))
    }

    fn schema(&mut self, old: u16) -> McapResult<u16> {
        if let Some(&id) = self.schemas.get(&old) {
            return Ok(id);
        }
        let Some((name, encoding, data)) = self.schema_records.get(&old) else {
            return Ok(0);
        };
        let id = self.writer.add_schema(name, encoding, data)?;
        self.schemas.insert(old, id);
        Ok(id)
    }

    /// Ends the new file and holds it against what the old one says of itself.
    fn finish(mut self, to: &Path, stated: Option<Statistics>) -> Result<Recovered, Error> {
        if let Some(stated) = stated {
            self.saved.messages_lost = stated.message_count.saturating_sub(self.saved.messages);
        }
        if self.saved.messages == 0 {
            // Let go, it leaves nothing. Taken out first: a writer that is dropped ends its file.
            drop(self.writer.into_inner());
            return Ok(self.saved);
        }
        let ended = self.writer.finish();
        ended.map_err(|error| Error::Write {
            file: to.to_owned(),
            bytes: 0,
            kept: None,
            source: std::io::Error::other(error),
        })?;
        self.writer.into_inner().finish()?;
        Ok(self.saved)
    }
}
