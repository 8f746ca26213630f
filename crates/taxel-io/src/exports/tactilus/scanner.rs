//! JSON piece by piece: values are found by their quotes and brackets, and held one at a time. What is in them is for whoever asked.

use std::fs::File;
use std::io::{self, ErrorKind, Read, Seek, SeekFrom};
use std::path::Path;

/// Bytes of a read.
const READ: usize = 256 * 1024;
/// Bytes behind all that is held: whoever reads several at a time may look at them.
const SPARE: usize = 8;
/// A value that is held is at most so long: a frame of the largest array, each number with all its digits and its own line.
pub(super) const MAX_VALUE: usize = 16 << 20;

/// Why a file cannot be read on.
#[derive(Debug)]
pub(super) enum Fault {
    Io(io::Error),
    /// It ends too early.
    End,
    /// At a byte stands something else than is expected.
    Other {
        at: u64,
        expected: &'static str,
    },
    /// A value that begins at a byte is longer than [`MAX_VALUE`].
    Long {
        at: u64,
    },
}

/// A file of JSON, and as much of it as is looked at.
pub(super) struct Scanner {
    file: File,
    buffer: Vec<u8>,
    start: usize,
    end: usize,
    /// Where in the file the byte at `start` stands.
    at: u64,
}

impl Scanner {
    /// Opens a file; a byte-order mark, which JSON does not have and programs write, is passed over.
    pub(super) fn open(file: &Path) -> io::Result<Self> {
        let mut scanner = Self {
            file: File::open(file)?,
            buffer: vec![0; READ + SPARE],
            start: 0,
            end: 0,
            at: 0,
        };
        while scanner.end < 3 && scanner.fill()? {}
        if scanner.held().starts_with(b"\xEF\xBB\xBF") {
            scanner.skip(3);
        }
        Ok(scanner)
    }

    /// Where in the file the next byte stands.
    pub(super) fn at(&self) -> u64 {
        self.at
    }

    /// Goes to a byte of the file.
    pub(super) fn go_to(&mut self, at: u64) -> io::Result<()> {
        self.file.seek(SeekFrom::Start(at))?;
        (self.start, self.end, self.at) = (0, 0, at);
        Ok(())
    }

    fn held(&self) -> &[u8] {
        &self.buffer[self.start..self.end]
    }

    fn skip(&mut self, bytes: usize) {
        self.start += bytes;
        self.at += bytes as u64;
    }

    /// Reads once more behind what is held; false at the end of the file.
    fn fill(&mut self) -> io::Result<bool> {
        self.buffer.copy_within(self.start..self.end, 0);
        (self.start, self.end) = (0, self.end - self.start);
        if self.buffer.len() - self.end < READ + SPARE {
            self.buffer.resize(self.end + READ + SPARE, 0);
        }
        let room = self.buffer.len() - SPARE;
        loop {
            match self.file.read(&mut self.buffer[self.end..room]) {
                Ok(read) => {
                    self.end += read;
                    return Ok(read > 0);
                }
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
    }

    /// The next byte that is no blank, which stays; `None` at the end.
    pub(super) fn peek(&mut self) -> Result<Option<u8>, Fault> {
        loop {
            let blanks = self
                .held()
                .iter()
                .take_while(|byte| byte.is_ascii_whitespace());
            let blanks = blanks.count();
            self.skip(blanks);
            if let Some(&byte) = self.held().first() {
                return Ok(Some(byte));
            }
            if !self.fill().map_err(Fault::Io)? {
                return Ok(None);
            }
        }
    }

    /// Goes past the next byte, which has to be this.
    pub(super) fn pass(&mut self, byte: u8, expected: &'static str) -> Result<(), Fault> {
        match self.peek()? {
            Some(next) if next == byte => {
                self.skip(1);
                Ok(())
            }
            Some(_) => Err(self.other(expected)),
            None => Err(Fault::End),
        }
    }

    /// That something else stands here.
    pub(super) fn other(&self, expected: &'static str) -> Fault {
        Fault::Other {
            at: self.at,
            expected,
        }
    }

    /// Goes to the next entry of a list or an object, or behind what closes it: whether there is one. `has_one`: one was before.
    pub(super) fn next_entry(&mut self, closes: u8, has_one: bool) -> Result<bool, Fault> {
        match self.peek()? {
            Some(byte) if byte == closes => {
                self.skip(1);
                Ok(false)
            }
            Some(_) if has_one => self.pass(b',', "`,` or the end").map(|()| true),
            Some(_) => Ok(true),
            None => Err(Fault::End),
        }
    }

    /// The key of an entry of an object, between its quotes, and goes behind its colon.
    pub(super) fn key(&mut self) -> Result<Vec<u8>, Fault> {
        if self.peek()? != Some(b'"') {
            return Err(self.other("a key between quotes"));
        }
        let key = self.value()?;
        let key = key[1..key.len() - 1].to_vec();
        self.pass(b':', "`:`")?;
        Ok(key)
    }

    /// The next value, whatever is in it, and goes behind it.
    pub(super) fn value(&mut self) -> Result<&[u8], Fault> {
        self.peek()?;
        let mut walk = Walk::default();
        let mut length = 0;
        loop {
            length += walk.go(&self.held()[length..]);
            if walk.is_done {
                break;
            }
            if length > MAX_VALUE {
                return Err(Fault::Long { at: self.at });
            }
            if !self.fill().map_err(Fault::Io)? {
                return Err(Fault::End);
            }
        }
        if length == 0 {
            return Err(self.other("a value"));
        }
        let from = self.start;
        self.skip(length);
        Ok(&self.buffer[from..from + length])
    }

    /// The same value once more, of so many bytes, with a few that stand behind it, whatever they are.
    pub(super) fn value_on(&self, length: usize) -> &[u8] {
        &self.buffer[self.start - length..self.start + SPARE]
    }

    /// Goes behind the next value, which may be as long as it likes.
    pub(super) fn skip_value(&mut self) -> Result<(), Fault> {
        self.peek()?;
        let mut walk = Walk::default();
        let begins = self.at;
        loop {
            let length = walk.go(self.held());
            self.skip(length);
            if walk.is_done {
                break;
            }
            if !self.fill().map_err(Fault::Io)? {
                return Err(Fault::End);
            }
        }
        if self.at == begins {
            return Err(self.other("a value"));
        }
        Ok(())
    }
}

/// Goes through a value to its end.
#[derive(Default)]
struct Walk {
    depth: usize,
    is_in_string: bool,
    /// Whether the byte before was a backslash.
    is_escaped: bool,
    has_begun: bool,
    is_done: bool,
}

impl Walk {
    /// How many of these bytes, which are the next ones, are of it.
    fn go(&mut self, bytes: &[u8]) -> usize {
        let mut at = 0;
        while at < bytes.len() && !self.is_done {
            at += if self.is_in_string {
                self.go_in_string(&bytes[at..])
            } else if self.depth > 0 {
                self.go_inside(&bytes[at..])
            } else {
                self.go_outside(&bytes[at..])
            };
        }
        at
    }

    /// A scalar, or the first byte of anything else.
    fn go_outside(&mut self, bytes: &[u8]) -> usize {
        match bytes[0] {
            b'"' if !self.has_begun => self.is_in_string = true,
            b'[' | b'{' if !self.has_begun => self.depth = 1,
            _ => {
                self.has_begun = true;
                let is_end = |byte: &u8| byte.is_ascii_whitespace() || b",:]}[{\"".contains(byte);
                let end = bytes.iter().position(is_end);
                self.is_done = end.is_some();
                return end.unwrap_or(bytes.len());
            }
        }
        self.has_begun = true;
        1
    }

    /// Up to the next quote or closing bracket within brackets: numbers, which are nearly all, have none of either.
    fn go_inside(&mut self, bytes: &[u8]) -> usize {
        let found = memchr::memchr3(b'"', b']', b'}', bytes);
        let plain = &bytes[..found.unwrap_or(bytes.len())];
        self.depth += memchr::memchr2_iter(b'[', b'{', plain).count();
        let Some(at) = found else {
            return bytes.len();
        };
        if bytes[at] == b'"' {
            self.is_in_string = true;
        } else {
            self.depth -= 1;
            self.is_done = self.depth == 0;
        }
        at + 1
    }

    fn go_in_string(&mut self, bytes: &[u8]) -> usize {
        if std::mem::take(&mut self.is_escaped) {
            return 1;
        }
        let Some(at) = memchr::memchr2(b'"', b'\\', bytes) else {
            return bytes.len();
        };
        if bytes[at] == b'\\' {
            self.is_escaped = true;
        } else {
            self.is_in_string = false;
            self.is_done = self.depth == 0;
        }
        at + 1
    }
}
