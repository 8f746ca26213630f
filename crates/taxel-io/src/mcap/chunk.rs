//! A chunk: what its header says, and what it holds if that is what was written.

use super::parse::{Fields, is_chunk_content};
use super::scan::{Found, MAX_RECORD};

/// Fixed part of a chunk's header, the word for its packing not counted.
const CHUNK_HEADER: usize = 40;

/// A chunk's own header.
pub(super) struct ChunkHeader<'a> {
    unpacked: usize,
    sum: u32,
    pub packing: &'a [u8],
    packed: usize,
}

impl<'a> ChunkHeader<'a> {
    pub fn read(body: &'a [u8]) -> Option<Self> {
        let mut fields = Fields(body);
        fields.skip(16)?;
        Some(Self {
            unpacked: fields.long()?,
            sum: fields.short()? as u32,
            packing: fields.text()?,
            packed: fields.long()?,
        })
    }

    pub fn head(&self) -> usize {
        CHUNK_HEADER + self.packing.len()
    }

    /// Bytes of the record, by the header.
    pub fn length(&self) -> Option<usize> {
        self.packed.checked_add(self.head())
    }

    /// What it holds, if that is what was written. The length that is stated may be what is damaged.
    pub fn unpack(&self, packed: &[u8]) -> Found {
        let content = match self.packing {
            b"" => Ok(packed.to_vec()),
            b"zstd" if self.unpacked <= MAX_RECORD => {
                unpack(packed, self.unpacked).or_else(|_| unpack(packed, MAX_RECORD))
            }
            b"zstd" => unpack(packed, MAX_RECORD),
            _ => return Found::LostChunk,
        };
        let content = match content {
            Ok(content) => content,
            Err(true) if self.unpacked > MAX_RECORD => {
                return Found::TooLarge {
                    bytes: self.unpacked as u64,
                };
            }
            Err(_) => return Found::LostChunk,
        };
        let right = match self.sum {
            // None was written; the length must do.
            0 => content.len() == self.unpacked,
            sum => crc32fast::hash(&content) == sum,
        };
        if right && is_chunk_content(&content) {
            Found::Chunk(content)
        } else {
            Found::LostChunk
        }
    }
}

/// What was packed, up to a length; else whether that was too short for it.
fn unpack(packed: &[u8], most: usize) -> Result<Vec<u8>, bool> {
    let mut content = Vec::with_capacity(most);
    let mut unpacker = zstd::bulk::Decompressor::new().map_err(|_| false)?;
    let unpacked = unpacker.decompress_to_buffer(packed, &mut content);
    match unpacked {
        Ok(_) => {
            content.shrink_to_fit();
            Ok(content)
        }
        Err(error) => Err(error.to_string().contains("too small")),
    }
}
