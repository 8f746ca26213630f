//! A recording whose writer was killed, made whole again.

use std::collections::HashMap;
use std::fs::{File, OpenOptions};
use std::io::{BufWriter, Read};
use std::path::Path;

use mcap::read::ChunkReader;
use mcap::records::Record;
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::{Compression, McapResult, WriteOptions, Writer, parse_record};

use super::MAGIC;
use super::read::LONGEST_RECORD;
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
    /// Bytes at the end that belonged to nothing whole.
    pub bytes_lost: u64,
    /// The recording had its end: nothing was missing.
    pub was_whole: bool,
}

/// Copies all that is whole in `from` to a new recording `to`.
///
/// # Errors
/// [`Error::Open`], [`Error::Create`], [`Error::Recording`] for something that never was a recording, or a disk that
/// is full.
pub fn recover(from: impl AsRef<Path>, to: impl AsRef<Path>) -> Result<Recovered, Error> {
    let (from, to) = (from.as_ref(), to.as_ref());
    let (mut file, total) = open_file(from)?;
    let mut magic = [0; 8];
    let count = read_up_to(&mut file, &mut magic).map_err(|source| Error::Read {
        file: from.to_owned(),
        bytes: 0,
        source,
    })?;
    if &magic[..count] != MAGIC {
        return Err(Error::Recording {
            file: from.to_owned(),
            frames: 0,
            source: std::io::Error::new(
                std::io::ErrorKind::InvalidData,
                "it does not begin as an MCAP file does",
            ),
        });
    }
    let output = OpenOptions::new().write(true).create_new(true).open(to);
    let output = output.map_err(|source| Error::Create {
        file: to.to_owned(),
        source,
    })?;
    let failed = |error: mcap::McapError| Error::Recording {
        file: to.to_owned(),
        frames: 0,
        source: std::io::Error::other(error.to_string()),
    };
    let mut copy = Copy::new(output).map_err(failed)?;
    let options = LinearReaderOptions::default()
        .with_skip_start_magic(true)
        .with_skip_end_magic(true)
        .with_emit_chunks(true)
        .with_record_length_limit(LONGEST_RECORD);
    let mut reader = LinearReader::new_with_options(options);
    let (mut read, mut whole) = (magic.len() as u64, magic.len() as u64);
    while let Some(event) = reader.next_event() {
        match event {
            Ok(LinearReadEvent::ReadRequest(wanted)) => {
                let count = file
                    .read(reader.insert(wanted))
                    .map_err(|source| Error::Read {
                        file: from.to_owned(),
                        bytes: read,
                        source,
                    })?;
                read += count as u64;
                reader.notify_read(count);
            }
            Ok(LinearReadEvent::Record { data, opcode }) => {
                whole += data.len() as u64 + 9;
                if let Ok(record) = parse_record(opcode, data) {
                    copy.take(record).map_err(failed)?;
                }
            }
            // Torn here; what follows cannot be told apart.
            Err(_) => break,
        }
    }
    let mut saved = copy.finish().map_err(failed)?;
    if !saved.was_whole {
        saved.bytes_lost = total.unwrap_or(read).saturating_sub(whole);
    }
    Ok(saved)
}

fn read_up_to(file: &mut File, bytes: &mut [u8]) -> std::io::Result<usize> {
    let mut count = 0;
    while count < bytes.len() {
        match file.read(&mut bytes[count..])? {
            0 => break,
            more => count += more,
        }
    }
    Ok(count)
}

struct Copy {
    writer: Writer<BufWriter<File>>,
    /// Schemas and channels of the old file, by the ids that the new one gives them.
    schemas: HashMap<u16, u16>,
    channels: HashMap<u16, (u16, bool)>,
    saved: Recovered,
}

impl Copy {
    fn new(output: File) -> McapResult<Self> {
        let writer = WriteOptions::new()
            .profile("taxel")
            .compression(Some(Compression::Zstd))
            .compression_level(1)
            .compression_threads(0)
            .create(BufWriter::new(output))?;
        Ok(Self {
            writer,
            schemas: HashMap::new(),
            channels: HashMap::new(),
            saved: Recovered::default(),
        })
    }

    fn take(&mut self, record: Record) -> McapResult<()> {
        match record {
            Record::Chunk { header, data } => {
                // A chunk counts as a whole: records of a damaged one cannot be believed.
                let records: McapResult<Vec<Record>> =
                    ChunkReader::new(header, &data).and_then(|chunk| chunk.collect());
                match records {
                    Ok(records) => {
                        for record in records {
                            self.take(record)?;
                        }
                    }
                    Err(_) => self.saved.chunks_lost += 1,
                }
            }
            Record::Schema { header, data } => {
                let id = self
                    .writer
                    .add_schema(&header.name, &header.encoding, &data)?;
                self.schemas.insert(header.id, id);
            }
            Record::Channel(channel) => {
                let schema = self.schemas.get(&channel.schema_id).copied().unwrap_or(0);
                let id = self.writer.add_channel(
                    schema,
                    &channel.topic,
                    &channel.message_encoding,
                    &channel.metadata,
                )?;
                let counts = channel.topic == super::COUNTS;
                self.channels.insert(channel.id, (id, counts));
            }
            Record::Message { mut header, data } => {
                if let Some((id, counts)) = self.channels.get(&header.channel_id) {
                    header.channel_id = *id;
                    self.writer.write_to_known_channel(&header, &data)?;
                    self.saved.messages += 1;
                    self.saved.frames += u64::from(*counts);
                }
            }
            Record::Metadata(metadata) => self.writer.write_metadata(&metadata)?,
            Record::Attachment { header, data, .. } => {
                self.writer.attach(&mcap::Attachment {
                    log_time: header.log_time,
                    create_time: header.create_time,
                    name: header.name,
                    media_type: header.media_type,
                    data,
                })?;
            }
            Record::DataEnd(_) => self.saved.was_whole = true,
            _ => {}
        }
        Ok(())
    }

    fn finish(mut self) -> McapResult<Recovered> {
        self.writer.finish()?;
        let file = self.writer.into_inner().into_inner();
        let file = file.map_err(std::io::IntoInnerError::into_error)?;
        file.sync_all()?;
        Ok(self.saved)
    }
}
