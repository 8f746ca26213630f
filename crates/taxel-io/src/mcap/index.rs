//! What a whole file says at its end: where everything is, and how much of it there is.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};

use mcap::records::{ChunkIndex, Record, Statistics, op};

use super::MAGIC;
use super::parse::{Fields, Records, record};
use super::topics::Topics;

/// The largest index that is read: that of a recording of weeks.
const MAX_INDEX: u64 = 64 << 20;
/// A footer's record and the magic behind it.
const END: u64 = 9 + 20 + 8;

/// The index of a whole file; believed only as a whole.
pub(super) struct Index {
    pub statistics: Statistics,
    pub topics: Topics,
    /// Records of schemas and channels.
    pub declared: Vec<Record<'static>>,
    /// In the order of the file.
    pub chunks: Vec<ChunkIndex>,
    /// Where metadata records of a name lie.
    pub metadata: Vec<(String, u64)>,
    /// Where attachments of a name lie.
    pub attachments: Vec<(String, u64)>,
}

impl Index {
    /// Of a file that has one; where the file stands then is not said.
    pub fn read(file: &mut File, total: u64) -> Option<Self> {
        let footer_at = total.checked_sub(END)?;
        let end = read_at(file, footer_at, END as usize)?;
        let mut fields = Fields(&end);
        if end[0] != op::FOOTER || !end.ends_with(MAGIC) {
            return None;
        }
        fields.skip(9)?;
        let start = fields.long()? as u64;
        fields.skip(8)?;
        let stated = fields.short()? as u32;
        let length = footer_at.checked_sub(start)?;
        if start == 0 || length > MAX_INDEX {
            return None;
        }
        let bytes = read_at(file, start, length as usize)?;
        let mut sum = crc32fast::Hasher::new();
        sum.update(&bytes);
        sum.update(&end[..25]);
        if stated != 0 && stated != sum.finalize() {
            return None;
        }
        Self::of_records(&bytes)
    }

    fn of_records(bytes: &[u8]) -> Option<Self> {
        let mut index = Self {
            statistics: Statistics::default(),
            topics: Topics::default(),
            declared: Vec::new(),
            chunks: Vec::new(),
            metadata: Vec::new(),
            attachments: Vec::new(),
        };
        let mut has_statistics = false;
        let mut records = Records(bytes);
        for (opcode, body) in records.by_ref() {
            let found = record(opcode, body)?;
            index.topics.take(&found);
            match found {
                Record::Statistics(statistics) => {
                    (index.statistics, has_statistics) = (statistics, true);
                }
                Record::ChunkIndex(chunk) => index.chunks.push(chunk),
                Record::MetadataIndex(at) => index.metadata.push((at.name, at.offset)),
                Record::AttachmentIndex(at) => index.attachments.push((at.name, at.offset)),
                Record::Schema { .. } | Record::Channel(_) => {
                    index.declared.push(found.into_owned())
                }
                _ => {}
            }
        }
        index.chunks.sort_by_key(|chunk| chunk.chunk_start_offset);
        (records.0.is_empty() && has_statistics).then_some(index)
    }

    /// Seconds from the first message to a time.
    pub fn secs(&self, at: u64) -> f64 {
        at.saturating_sub(self.statistics.message_start_time) as f64 * 1e-9
    }

    /// Messages of a channel in the whole file.
    pub fn messages(&self, channel: u16) -> Option<u64> {
        let counts = &self.statistics.channel_message_counts;
        counts.get(&channel).copied()
    }

    /// Messages of a channel before a chunk; `None` where the file does not say it.
    pub fn messages_before(&self, file: &mut File, channel: u16, chunk: usize) -> Option<u64> {
        let mut messages = 0;
        for chunk in &self.chunks[..chunk] {
            let Some(&at) = chunk.message_index_offsets.get(&channel) else {
                continue;
            };
            let bytes = read_at(file, at, 15)?;
            let mut fields = Fields(&bytes);
            if bytes[0] != op::MESSAGE_INDEX {
                return None;
            }
            fields.skip(11)?;
            messages += fields.short()? as u64 / 16;
        }
        Some(messages)
    }
}

/// Bytes of a file; `None` where it has no such.
fn read_at(file: &mut File, at: u64, length: usize) -> Option<Vec<u8>> {
    file.seek(SeekFrom::Start(at)).ok()?;
    let mut bytes = Vec::new();
    let read: io::Result<usize> = file.take(length as u64).read_to_end(&mut bytes);
    (read.ok()? == length).then_some(bytes)
}
