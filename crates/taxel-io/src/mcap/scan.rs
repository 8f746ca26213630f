//! The records of a file one by one, whatever happened to the file.
//!
//! A chunk is believed when its checksum is right; behind damage the next record is found by what it looks like. No
//! length is believed before the bytes are there, so that memory stays within [`MAX_RECORD`] and what it unpacks to.

use std::io::{self, Read};

use mcap::records::{Record, op};

use super::MAGIC;
use super::chunk::ChunkHeader;
use super::parse::{Fields, Fit, fit, record};

/// The longest record and the largest chunk that are read: thirty loads of the largest frame.
pub(super) const MAX_RECORD: usize = 32 << 20;
/// What is asked of the file at once.
const READ: usize = 64 << 10;
/// Bytes by which a record is known behind damage.
const SIGN: usize = 72;
/// Damaged places after which nothing more is looked for: a file of this program has none that a hundred do not tell.
const MAX_PLACES: u32 = 100_000;

/// What was found.
pub(super) enum Found {
    /// A record outside of chunks.
    Record(Record<'static>),
    /// A record whose fields make no sense, though their lengths do.
    Unreadable,
    /// A chunk's content, its checksum right.
    Chunk(Vec<u8>),
    /// A chunk that is lost: what it held does not fit its checksum.
    LostChunk,
    /// Bytes that belong to nothing.
    Lost { bytes: u64 },
    /// A chunk or message that is whole but larger than is read.
    TooLarge { bytes: u64 },
    /// Chunks packed in a way that is not read.
    Packing(String),
    /// Another kind of file.
    NotMcap,
    /// The end, after the data's own.
    End,
    /// The end of the file, but not of the data; so many bytes before it are a part of something.
    Cut { bytes: u64 },
}

/// Reads a file from its beginning, or from a record that was sought.
pub(super) struct Scanner<R> {
    input: R,
    total: Option<u64>,
    window: Vec<u8>,
    /// Where in the window the next record begins, and where in the file.
    from: usize,
    at: u64,
    /// Bytes that were given and are not yet passed.
    held: usize,
    ended: bool,
    begun: bool,
    /// The data section has come to its end, for certain.
    whole: bool,
    /// Behind a record that says that the data ends, as long as nothing speaks against it.
    data_end: Option<u64>,
    /// It has chunks.
    chunked: bool,
    places: u32,
    /// Over the data section so far; none where it was not read from its beginning.
    sum: Option<crc32fast::Hasher>,
    /// Whether the data section has the checksum that it should have, where it says one.
    pub sum_is_right: Option<bool>,
}

impl<R: Read> Scanner<R> {
    pub fn new(input: R, total: Option<u64>) -> Self {
        Self {
            input,
            total,
            window: Vec::new(),
            from: 0,
            at: 0,
            held: 0,
            ended: false,
            begun: false,
            whole: false,
            data_end: None,
            chunked: false,
            places: 0,
            sum: Some(crc32fast::Hasher::new()),
            sum_is_right: None,
        }
    }

    /// From a record that begins at `at`, where `input` was moved to.
    pub fn from_record(input: R, total: Option<u64>, at: u64) -> Self {
        Self {
            at,
            begun: true,
            sum: None,
            ..Self::new(input, total)
        }
    }

    pub fn input_mut(&mut self) -> &mut R {
        &mut self.input
    }

    /// Bytes of the file until the record given last.
    pub fn position(&self) -> u64 {
        self.at + self.held as u64
    }

    pub fn total(&self) -> Option<u64> {
        self.total
    }

    /// Whether the data section came to its end.
    pub fn is_whole(&self) -> bool {
        self.whole
    }

    /// The next that is found. After an end, the same end.
    pub fn next(&mut self) -> io::Result<Found> {
        let held = std::mem::take(&mut self.held);
        self.pass(held);
        if !self.begun {
            self.fill(MAGIC.len())?;
            let alike = self.bytes().iter().zip(MAGIC).filter(|(a, b)| a == b);
            // One byte of it may be damaged as any other.
            if alike.count() < MAGIC.len() - 1 {
                return Ok(Found::NotMcap);
            }
            self.pass(MAGIC.len());
            self.begun = true;
        }
        self.fill(9)?;
        let mut head = Fields(self.bytes().get(1..).unwrap_or_default());
        let (Some(&opcode), Some(length)) = (self.bytes().first(), head.long()) else {
            return Ok(self.end());
        };
        let fits = |total| self.at.saturating_add(length as u64) <= total;
        if !self.total.is_none_or(fits) {
            return self.lost();
        }
        if length > MAX_RECORD {
            return self.too_large(opcode, length);
        }
        self.fill(9 + length)?;
        if self.bytes().len() < 9 + length {
            return self.lost();
        }
        if opcode == op::CHUNK || self.is_chunk(length) {
            return self.chunk(length);
        }
        let body = &self.bytes()[9..9 + length];
        let good = match fit(opcode, body) {
            Fit::None => false,
            Fit::Exact => true,
            Fit::Loose => self.goes_on(9 + length)?,
        };
        if !good {
            self.lost()
        } else if opcode == op::FOOTER {
            self.footer(length)
        } else {
            Ok(self.record(opcode, length))
        }
    }

    fn record(&mut self, opcode: u8, length: usize) -> Found {
        self.held = 9 + length;
        match opcode {
            op::DATA_END if !self.whole => self.data_end(length),
            op::MESSAGE | op::MESSAGE_INDEX | op::ATTACHMENT | op::METADATA => self.data_goes_on(),
            _ => {}
        }
        if opcode == op::MESSAGE && self.chunked {
            // Where messages are in chunks, one outside is another record whose code was changed.
            return Found::Unreadable;
        }
        match record(opcode, &self.bytes()[9..9 + length]) {
            Some(record) => Found::Record(record.into_owned()),
            None => Found::Unreadable,
        }
    }

    /// A record that says that the data ends here: certain where its checksum fits all that came, else once the footer
    /// agrees.
    fn data_end(&mut self, length: usize) {
        let stated = Fields(&self.bytes()[9..]).short().unwrap_or_default() as u32;
        let sum = self.sum.clone().map(crc32fast::Hasher::finalize);
        self.sum_is_right = sum.filter(|_| stated != 0).map(|sum| sum == stated);
        self.whole = self.sum_is_right == Some(true);
        self.data_end = Some(self.at + (9 + length) as u64);
    }

    /// What said that the data ends was out of place.
    fn data_goes_on(&mut self) {
        if !self.whole {
            (self.data_end, self.sum_is_right) = (None, None);
        }
    }

    /// A footer counts only as the last record of the file, and where the data ends as it says; or where damage before
    /// it, which was told, may have taken the data's end.
    fn footer(&mut self, length: usize) -> io::Result<Found> {
        let end = 9 + length + MAGIC.len();
        self.fill(end + 1)?;
        let bytes = self.bytes();
        let is_last = bytes.len() == end && bytes.ends_with(MAGIC);
        let start = Fields(&bytes[9..]).long().map(|start| start as u64);
        let agrees = self.data_end.is_some_and(|data_end| {
            start == Some(data_end) || start == Some(0) && data_end == self.at
        });
        if is_last && (agrees || self.places > 0) {
            self.whole = true;
        }
        if !self.whole {
            return self.lost();
        }
        if self.bytes().len() > end {
            self.behind(end)
        } else {
            Ok(self.end())
        }
    }

    /// What follows the end of the file belongs to nothing.
    fn behind(&mut self, end: usize) -> io::Result<Found> {
        self.pass(end);
        let mut bytes = 0;
        loop {
            self.fill(READ)?;
            let passed = self.bytes().len();
            if passed == 0 {
                return Ok(Found::Lost { bytes });
            }
            self.pass(passed);
            bytes += passed as u64;
        }
    }

    /// Whether what follows may be a record, or nothing does.
    fn goes_on(&mut self, length: usize) -> io::Result<bool> {
        self.fill(length + 9)?;
        Ok(match &self.bytes()[length..] {
            [] => true,
            [1..=0x0f | 0x80.., head @ ..] => match (Fields(head).long(), self.total) {
                (Some(next), Some(total)) => {
                    (self.at + length as u64).saturating_add(next as u64) < total
                }
                (next, None) => next.is_some(),
                (None, _) => false,
            },
            _ => false,
        })
    }

    /// Whether the record looks like a chunk, whatever its operation code says.
    fn is_chunk(&self, length: usize) -> bool {
        let header = ChunkHeader::read(&self.bytes()[9..9 + length]);
        header.is_some_and(|header| header.length() == Some(length) && header.packing == b"zstd")
    }

    fn chunk(&mut self, length: usize) -> io::Result<Found> {
        let body = &self.bytes()[9..9 + length];
        let Some(header) = ChunkHeader::read(body).filter(|h| h.length() == Some(length)) else {
            return self.lost();
        };
        if header.packing == b"lz4" {
            return Ok(Found::Packing("lz4".to_owned()));
        }
        let found = header.unpack(&body[header.head()..]);
        self.data_goes_on();
        self.chunked = true;
        self.held = 9 + length;
        Ok(found)
    }

    /// A record beyond what is read: passed over where it is of no use, refused where it is whole, else damage.
    fn too_large(&mut self, opcode: u8, length: usize) -> io::Result<Found> {
        self.fill(SIGN)?;
        let coherent = match opcode {
            op::CHUNK => {
                let body = self.bytes().get(9..).unwrap_or_default();
                ChunkHeader::read(body).and_then(|header| header.length()) == Some(length)
            }
            _ => false,
        };
        if coherent {
            self.held = 9;
            return Ok(Found::TooLarge {
                bytes: length as u64,
            });
        }
        if opcode == op::ATTACHMENT && self.total.is_some() {
            let mut left = 9 + length;
            while left > 0 {
                self.fill(left.min(READ))?;
                let passed = self.bytes().len().min(left);
                if passed == 0 {
                    break;
                }
                self.pass(passed);
                left -= passed;
            }
            return self.next();
        }
        self.lost()
    }

    /// Goes on to the next record that can be told from damage.
    fn lost(&mut self) -> io::Result<Found> {
        if self.whole {
            // Behind the data there is only the index.
            return Ok(self.end());
        }
        self.places += 1;
        let mut bytes = 0;
        let mut step = 1;
        loop {
            self.pass(step);
            bytes += step as u64;
            self.fill(READ)?;
            let window = self.bytes();
            let last = if self.ended {
                window.len()
            } else {
                window.len().saturating_sub(SIGN)
            };
            let found = (0..last).find(|&i| is_sign(&window[i..]));
            match found {
                Some(i) if self.places < MAX_PLACES => {
                    self.pass(i);
                    return Ok(Found::Lost {
                        bytes: bytes + i as u64,
                    });
                }
                _ if self.ended => {
                    let rest = self.bytes().len();
                    self.pass(rest);
                    return Ok(Found::Cut {
                        bytes: bytes + rest as u64,
                    });
                }
                _ => step = last,
            }
        }
    }

    fn end(&mut self) -> Found {
        if self.whole {
            Found::End
        } else {
            Found::Cut {
                bytes: self.bytes().len() as u64,
            }
        }
    }

    fn bytes(&self) -> &[u8] {
        &self.window[self.from..]
    }

    /// Leaves bytes behind.
    fn pass(&mut self, count: usize) {
        let count = count.min(self.window.len() - self.from);
        if let Some(sum) = &mut self.sum {
            sum.update(&self.window[self.from..self.from + count]);
        }
        self.from += count;
        self.at += count as u64;
    }

    /// Has at least `count` bytes ready, or all that there are.
    fn fill(&mut self, count: usize) -> io::Result<()> {
        if self.bytes().len() >= count || self.ended {
            return Ok(());
        }
        self.window.drain(..self.from);
        self.from = 0;
        // What a large record took is given back.
        self.window.shrink_to(count.max(4 * READ));
        while self.window.len() < count && !self.ended {
            let had = self.window.len();
            // Twice as much at most: a length is no reason to take memory, bytes are.
            let wanted = (count - had).clamp(READ, had.max(READ));
            self.window.resize(had + wanted, 0);
            let read = loop {
                match self.input.read(&mut self.window[had..]) {
                    Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                    other => break other,
                }
            };
            self.window.truncate(had + *read.as_ref().unwrap_or(&0));
            self.ended = read? == 0;
        }
        Ok(())
    }
}

/// Whether a record begins here that can be told from anything else: its lengths agree with each other, or it has a
/// name of this program's.
fn is_sign(bytes: &[u8]) -> bool {
    let mut fields = Fields(bytes.get(1..).unwrap_or_default());
    let Some(length) = fields.long() else {
        return false;
    };
    if length > MAX_RECORD {
        return false;
    }
    let body = fields.0;
    let named = |text: Option<&[u8]>| text.is_some_and(|text| text.starts_with(b"taxel"));
    match bytes[0] {
        op::CHUNK => ChunkHeader::read(body).is_some_and(|header| {
            header.length() == Some(length) && [&b""[..], b"zstd", b"lz4"].contains(&header.packing)
        }),
        op::MESSAGE_INDEX => {
            let mut fields = Fields(body);
            let array = fields.skip(2).and_then(|()| fields.short());
            array.is_some_and(|array| array % 16 == 0 && array + 6 == length)
        }
        op::METADATA => named(Fields(body).text()),
        op::ATTACHMENT => {
            let mut fields = Fields(body);
            named(fields.skip(16).and_then(|()| fields.text()))
        }
        op::DATA_END => {
            length == 4 && matches!(body.get(4), Some(2..=4 | 8 | 0xa | 0xb | 0xd | 0xe))
        }
        op::FOOTER => length == 20,
        _ => false,
    }
}
