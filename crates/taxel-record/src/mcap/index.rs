//! Where to find a second in a whole recording.

use std::fs::File;
use std::io::{Read, Seek};

use mcap::sans_io::summary_reader::{SummaryReadEvent, SummaryReader};

/// Where chunks are, from the end of a whole file.
pub(super) struct Index {
    pub start: u64,
    pub end: u64,
    pub frames: u64,
    pub chunks: Vec<Chunk>,
}

pub(super) struct Chunk {
    pub end: u64,
    pub offset: u64,
}

impl Index {
    /// Of a file that has one.
    pub fn read(file: &mut File, counts: u16) -> Option<Self> {
        let mut reader = SummaryReader::new();
        while let Some(event) = reader.next_event() {
            match event.ok()? {
                SummaryReadEvent::ReadRequest(wanted) => {
                    let count = file.read(reader.insert(wanted)).ok()?;
                    reader.notify_read(count);
                }
                SummaryReadEvent::SeekRequest(to) => reader.notify_seeked(file.seek(to).ok()?),
            }
        }
        let summary = reader.finish()?;
        let stats = summary.stats?;
        let chunks = summary.chunk_indexes.iter().map(|chunk| Chunk {
            end: chunk.message_end_time,
            offset: chunk.chunk_start_offset,
        });
        Some(Self {
            start: stats.message_start_time,
            end: stats.message_end_time,
            frames: stats.channel_message_counts.get(&counts).copied()?,
            chunks: chunks.collect(),
        })
    }

    pub fn secs(&self, at: u64) -> f64 {
        at.saturating_sub(self.start) as f64 * 1e-9
    }
}
