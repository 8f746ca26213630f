//! Records from bytes that may lie: every length is held against the bytes there are before anything is believed.

use std::collections::BTreeMap;

use mcap::parse_record;
use mcap::records::{Record, op};

/// Key of a metadata record's own checksum: the format has none for them.
const CHECKSUM: &str = "crc32";

/// Whether the lengths inside of a record fit it, and whether bytes are left over that no field takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Fit {
    /// Every byte is taken.
    Exact,
    /// All fields are there; more follows, as later versions of the format may add.
    Loose,
    /// A length goes beyond the record, or the record is none of the format's.
    None,
}

/// How the fields of a record fit its bytes.
pub(super) fn fit(opcode: u8, body: &[u8]) -> Fit {
    let mut fields = Fields(body);
    let read = match opcode {
        op::HEADER => fields.texts(2),
        op::FOOTER => fields.skip(20),
        op::SCHEMA => fields.skip(2).and_then(|()| fields.texts(3)),
        op::CHANNEL => fields
            .skip(4)
            .and_then(|()| fields.texts(2))
            .and_then(|()| fields.map()),
        op::MESSAGE => fields.skip(22),
        op::MESSAGE_INDEX => fields.skip(2).and_then(|()| fields.array(16)),
        op::CHUNK_INDEX => fields
            .skip(32)
            .and_then(|()| fields.array(10))
            .and_then(|()| fields.skip(8))
            .and_then(|()| fields.texts(1))
            .and_then(|()| fields.skip(16)),
        op::ATTACHMENT => fields
            .skip(16)
            .and_then(|()| fields.texts(2))
            .and_then(|()| fields.long())
            .and_then(|length| fields.skip(length))
            .and_then(|()| fields.skip(4)),
        op::ATTACHMENT_INDEX => fields.skip(40).and_then(|()| fields.texts(2)),
        op::STATISTICS => fields.skip(42).and_then(|()| fields.array(10)),
        op::METADATA => fields.texts(1).and_then(|()| fields.map()),
        op::METADATA_INDEX => fields.skip(16).and_then(|()| fields.texts(1)),
        op::SUMMARY_OFFSET => fields.skip(17),
        op::DATA_END => fields.skip(4),
        0x80.. => Some(()),
        _ => None,
    };
    match (read, fields.0.len()) {
        (None, _) => Fit::None,
        (Some(()), 0) => Fit::Exact,
        (Some(()), _) => Fit::Loose,
    }
}

/// A record whose lengths fit; `None` for what is none.
pub(super) fn record(opcode: u8, body: &[u8]) -> Option<Record<'_>> {
    match fit(opcode, body) {
        Fit::None => None,
        Fit::Exact | Fit::Loose => parse_record(opcode, body).ok(),
    }
}

/// The records of a chunk, one behind the other: operation code and body.
pub(super) struct Records<'a>(pub &'a [u8]);

impl<'a> Iterator for Records<'a> {
    type Item = (u8, &'a [u8]);

    fn next(&mut self) -> Option<Self::Item> {
        let (&opcode, rest) = self.0.split_first()?;
        let mut fields = Fields(rest);
        let length = fields.long()?;
        let body = fields.0.get(..length)?;
        self.0 = &fields.0[length..];
        Some((opcode, body))
    }
}

/// Whether a chunk's content is records to its last byte, and none of them a chunk again.
pub(super) fn is_chunk_content(bytes: &[u8]) -> bool {
    let mut records = Records(bytes);
    let allowed = |opcode| matches!(opcode, op::SCHEMA | op::CHANNEL | op::MESSAGE | 0x80..);
    records.by_ref().all(|(opcode, _)| allowed(opcode)) && records.0.is_empty()
}

/// Adds a checksum of its own to a metadata record.
pub(super) fn seal(metadata: &mut BTreeMap<String, String>) {
    let sum = checksum(metadata);
    metadata.insert(CHECKSUM.to_owned(), format!("{sum:08x}"));
}

/// Whether a metadata record has no checksum, or the right one.
pub(super) fn is_sealed(metadata: &BTreeMap<String, String>) -> bool {
    metadata
        .get(CHECKSUM)
        .is_none_or(|sum| *sum == format!("{:08x}", checksum(metadata)))
}

fn checksum(metadata: &BTreeMap<String, String>) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    for (key, value) in metadata.iter().filter(|(key, _)| *key != CHECKSUM) {
        for text in [key, value] {
            hasher.update(&(text.len() as u64).to_le_bytes());
            hasher.update(text.as_bytes());
        }
    }
    hasher.finalize()
}

/// What is left of a record.
pub(super) struct Fields<'a>(pub &'a [u8]);

impl<'a> Fields<'a> {
    pub fn skip(&mut self, count: usize) -> Option<()> {
        self.0 = self.0.get(count..)?;
        Some(())
    }

    pub fn short(&mut self) -> Option<usize> {
        let (bytes, rest) = self.0.split_first_chunk::<4>()?;
        self.0 = rest;
        usize::try_from(u32::from_le_bytes(*bytes)).ok()
    }

    pub fn long(&mut self) -> Option<usize> {
        let (bytes, rest) = self.0.split_first_chunk::<8>()?;
        self.0 = rest;
        usize::try_from(u64::from_le_bytes(*bytes)).ok()
    }

    pub fn text(&mut self) -> Option<&'a [u8]> {
        let length = self.short()?;
        let text = self.0.get(..length)?;
        self.0 = &self.0[length..];
        Some(text)
    }

    fn texts(&mut self, count: usize) -> Option<()> {
        (0..count).try_for_each(|_| self.text().map(|_| ()))
    }

    /// Items of `size` bytes, behind their length in bytes.
    fn array(&mut self, size: usize) -> Option<()> {
        self.text()
            .filter(|items| items.len() % size == 0)
            .map(|_| ())
    }

    /// Pairs of texts, behind their length in bytes.
    fn map(&mut self) -> Option<()> {
        let mut pairs = Fields(self.text()?);
        while !pairs.0.is_empty() {
            pairs.texts(2)?;
        }
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_beyond_the_record_are_not_believed() {
        let header = b"\x05\0\0\0taxel\x00\0\0\0";
        assert_eq!(fit(op::HEADER, header), Fit::Exact);
        assert_eq!(fit(op::HEADER, &header[..12]), Fit::None);
        assert_eq!(
            fit(op::HEADER, b"\xff\xff\xff\xfftaxel\x00\0\0\0"),
            Fit::None
        );
        assert_eq!(fit(op::ATTACHMENT, &[0; 3]), Fit::None);
        assert_eq!(fit(op::MESSAGE, &[0; 23]), Fit::Loose);
        assert_eq!(fit(0x42, &[0; 23]), Fit::None);
        assert!(is_chunk_content(&[]));
        assert!(!is_chunk_content(&[5, 1, 0, 0]));
        // A chunk in a chunk is no recording, however deep.
        assert!(!is_chunk_content(&[6, 0, 0, 0, 0, 0, 0, 0, 0]));
    }

    #[test]
    fn a_sealed_record_shows_every_change() {
        let mut metadata = BTreeMap::from([("a".to_owned(), "bc".to_owned())]);
        assert!(is_sealed(&metadata));
        seal(&mut metadata);
        assert!(is_sealed(&metadata));
        metadata.insert("a".to_owned(), "bd".to_owned());
        assert!(!is_sealed(&metadata));
    }
}
