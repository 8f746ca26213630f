//! A column's pages, read one by one within bounds: what a file claims of itself fills no memory before it is checked. The
//! crate does reserve as much as a packed page's header says, 2 GiB at most; what is unpacked into it is bounded here, and
//! memory that nothing is written to takes none of the machine's.

use std::fs::File;
use std::io::{BufReader, Read};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use parquet::basic::{Compression, Encoding};
use parquet::column::page::{Page, PageMetadata, PageReader};
use parquet::errors::{ParquetError, Result};
use parquet::file::metadata::ColumnChunkMetaData;
use parquet::file::reader::{ChunkReader, Length};
use parquet::file::serialized_reader::SerializedPageReader;
use prost::bytes::Bytes;

use crate::source::MAX_TAXELS;

/// Most bytes of a page, packed or not.
const MAX_PAGE_BYTES: u64 = 32 << 20;
/// Most numbers of a page: what tables of this program have, which begin a new group behind the row that reaches 2²⁰.
const MAX_PAGE_VALUES: usize = (1 << 20) + MAX_TAXELS;
/// Most numbers that are read for one row: its own, and the page in which it ends.
const MAX_ROW_VALUES: usize = MAX_TAXELS + MAX_PAGE_VALUES;

/// How many numbers were read since this was set to 0, which is done before every row.
pub(super) type Spent = Arc<AtomicUsize>;

/// Where a column's bytes come from.
struct Bounded {
    file: File,
    is_packed: bool,
}

impl Length for Bounded {
    fn len(&self) -> u64 {
        self.file.metadata().map_or(0, |about| about.len())
    }
}

impl ChunkReader for Bounded {
    type T = BufReader<File>;

    fn get_read(&self, start: u64) -> Result<Self::T> {
        self.file.get_read(start)
    }

    fn get_bytes(&self, start: u64, length: usize) -> Result<Bytes> {
        if length as u64 > MAX_PAGE_BYTES {
            return Err(too_large(length as u64));
        }
        let bytes = self.file.get_bytes(start, length)?;
        if self.is_packed && !bytes.is_empty() {
            check_unpacked(&bytes)?;
        }
        Ok(bytes)
    }
}

/// Refuses what unpacks to more than a page may have, whatever its header says.
///
/// The page is unpacked twice for it. The length that a frame of zstd tells would not do: zstd 1.5.7 compares it only with what
/// it has unpacked, at the end (`ZSTD_decompressFrame`), which may be all that the crate has reserved.
fn check_unpacked(bytes: &[u8]) -> Result<()> {
    let wrong = |_| {
        let words = "a page that is not packed with zstd as a whole";
        ParquetError::General(words.to_owned())
    };
    let unpacked = zstd::Decoder::with_buffer(bytes).map_err(wrong)?;
    let mut bounded = unpacked.take(MAX_PAGE_BYTES + 1);
    let length = std::io::copy(&mut bounded, &mut std::io::sink()).map_err(wrong)?;
    if length > MAX_PAGE_BYTES {
        return Err(too_large(length));
    }
    Ok(())
}

fn too_large(found: u64) -> ParquetError {
    ParquetError::General(format!(
        "a page of {found} bytes or more, at most {MAX_PAGE_BYTES} are read"
    ))
}

/// The pages of a column, each checked before its numbers are read.
pub(super) struct Pages {
    inner: SerializedPageReader<Bounded>,
    spent: Spent,
    /// Whether the column's lists, and its empty places, are told by levels.
    has_repetition: bool,
    has_definition: bool,
    /// Whether the numbers came that later pages may refer to.
    has_dictionary: bool,
}

impl Pages {
    /// Of the part of a column that `chunk` describes, `rows` rows.
    ///
    /// # Errors
    /// A place outside of the file, or packed in a way that is not read.
    pub(super) fn open(
        file: &File,
        chunk: &ColumnChunkMetaData,
        rows: usize,
        spent: Spent,
    ) -> Result<Self> {
        let begin = chunk.dictionary_page_offset();
        if begin.unwrap_or(0).min(chunk.data_page_offset()) < 0 || chunk.compressed_size() < 0 {
            let words = "a column that begins before the file does";
            return Err(ParquetError::General(words.to_owned()));
        }
        let is_packed = match chunk.compression() {
            Compression::UNCOMPRESSED => false,
            Compression::ZSTD(_) => true,
            other => {
                return Err(ParquetError::General(format!(
                    "packed with {other}, expected zstd or nothing"
                )));
            }
        };
        let bytes = Bounded {
            file: file.try_clone()?,
            is_packed,
        };
        let inner = SerializedPageReader::new(Arc::new(bytes), chunk, rows, None)?;
        let about = chunk.column_descr();
        Ok(Self {
            inner,
            spent,
            has_repetition: about.max_rep_level() > 0,
            has_definition: about.max_def_level() > 0,
            has_dictionary: false,
        })
    }

    /// Refuses what the crate takes for granted, and panics without.
    fn check(&mut self, page: &Page) -> Result<()> {
        let wrong = |words: String| Err(ParquetError::General(words));
        match page {
            Page::DictionaryPage { .. } => {
                self.has_dictionary = true;
                return Ok(());
            }
            Page::DataPage {
                rep_level_encoding,
                def_level_encoding,
                ..
            } => {
                // Of levels that are not there, older programs write any encoding.
                let repetition = self.has_repetition.then_some(rep_level_encoding);
                let definition = self.has_definition.then_some(def_level_encoding);
                let mut levels = repetition.into_iter().chain(definition);
                if let Some(found) = levels.find(|found| **found != Encoding::RLE) {
                    return wrong(format!("levels written as {found}, expected RLE"));
                }
            }
            Page::DataPageV2 {
                buf,
                rep_levels_byte_len,
                def_levels_byte_len,
                ..
            } => {
                let levels = u64::from(*rep_levels_byte_len) + u64::from(*def_levels_byte_len);
                if levels > buf.len() as u64 {
                    return wrong(format!(
                        "levels of {levels} bytes in a page of {}",
                        buf.len()
                    ));
                }
            }
        }
        if page.encoding() != Encoding::PLAIN && !self.has_dictionary {
            let found = page.encoding();
            return wrong(format!(
                "numbers written as {found}, but no dictionary before them"
            ));
        }
        Ok(())
    }
}

impl Iterator for Pages {
    type Item = Result<Page>;

    fn next(&mut self) -> Option<Self::Item> {
        self.get_next_page().transpose()
    }
}

impl PageReader for Pages {
    fn get_next_page(&mut self) -> Result<Option<Page>> {
        if self.spent.load(Ordering::Relaxed) > MAX_ROW_VALUES {
            return Err(ParquetError::General(format!(
                "a row of more than {MAX_TAXELS} numbers"
            )));
        }
        let page = loop {
            let Some(page) = self.inner.get_next_page()? else {
                return Ok(None);
            };
            // The crate takes an empty page, which pyarrow may write, for the end of the column.
            if page.num_values() > 0 || page.is_dictionary_page() {
                break page;
            }
        };
        let found = page.num_values() as usize;
        if found > MAX_PAGE_VALUES {
            return Err(ParquetError::General(format!(
                "a page of {found} numbers, at most {MAX_PAGE_VALUES} are read"
            )));
        }
        match page.encoding() {
            // What pyarrow, polars, DuckDB and this program write.
            Encoding::PLAIN | Encoding::PLAIN_DICTIONARY | Encoding::RLE_DICTIONARY => {}
            other => {
                return Err(ParquetError::General(format!(
                    "numbers written as {other}, expected PLAIN or RLE_DICTIONARY"
                )));
            }
        }
        self.check(&page)?;
        self.spent.fetch_add(found, Ordering::Relaxed);
        Ok(Some(page))
    }

    fn peek_next_page(&mut self) -> Result<Option<PageMetadata>> {
        self.inner.peek_next_page()
    }

    fn skip_next_page(&mut self) -> Result<()> {
        self.inner.skip_next_page()
    }

    fn at_record_boundary(&mut self) -> Result<bool> {
        self.inner.at_record_boundary()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_unpacks_to_more_than_a_page_is_refused_whatever_it_says() {
        let most = MAX_PAGE_BYTES as usize;
        let packed = |length: usize| zstd::bulk::compress(&vec![0; length], 1).unwrap();
        assert!(check_unpacked(&packed(most)).is_ok());
        let mut large = packed(most + 1);
        assert!(check_unpacked(&large).is_err());
        // Its length stands behind the magic, the description and the window; here it says one byte.
        assert_eq!(large[6..10], (MAX_PAGE_BYTES as u32 + 1).to_le_bytes());
        large[6..10].copy_from_slice(&1u32.to_le_bytes());
        assert!(check_unpacked(&large).is_err());
        // The same in two frames.
        assert!(check_unpacked(&[packed(1), packed(most)].concat()).is_err());
        assert!(check_unpacked(b"no zstd").is_err());
    }
}
