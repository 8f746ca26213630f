//! The header of a `.npy` array: magic, version, and a Python dictionary of three keys.

use std::io::{self, Read};
use std::path::{Path, PathBuf};

use super::element::Element;
use crate::error::Error;
use crate::grid::shortened;

/// The most bytes a header may have; numpy writes 128 and refuses above 10 000.
const HEADER_BYTES: u32 = 65_536;
const MAGIC: &[u8] = b"\x93NUMPY";

/// What the header says.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Header {
    pub(crate) element: Element,
    pub(crate) big_endian: bool,
    pub(crate) fortran_order: bool,
    pub(crate) shape: Vec<u64>,
    /// Bytes before the data.
    pub(crate) bytes: u64,
}

impl Header {
    /// Reads up to the first byte of data.
    pub(crate) fn read(input: &mut impl Read, file: &Path) -> Result<Self, Error> {
        let mut start = [0u8; 8];
        let held = fill(input, &mut start, file, 0)?;
        let wrong = |byte, found: &[u8], expected| Error::NpyHeader {
            file: file.to_owned(),
            byte,
            found: shortened(found),
            expected,
        };
        if held < 8 || &start[..6] != MAGIC {
            return Err(wrong(0, &start[..held], "\\x93NUMPY and a version"));
        }
        let width = match start[6] {
            1 => 2,
            2 | 3 => 4,
            version => {
                let found = version.to_string();
                return Err(wrong(6, found.as_bytes(), "version 1, 2 or 3"));
            }
        };
        let mut length = [0u8; 4];
        if fill(input, &mut length[..width], file, 8)? < width {
            return Err(wrong(8, b"", "the length of the header"));
        }
        let length = u32::from_le_bytes(length);
        if length > HEADER_BYTES {
            let found = length.to_string();
            return Err(wrong(
                8,
                found.as_bytes(),
                "a header of at most 65536 bytes",
            ));
        }
        let mut text = vec![0u8; length as usize];
        let held = fill(input, &mut text, file, 8 + width as u64)?;
        if held < text.len() {
            return Err(wrong(8 + width as u64, &text[..held], "the whole header"));
        }
        let scan = Scan {
            text: &text,
            at: 0,
            before: 8 + width as u64,
            file: file.to_owned(),
        };
        scan.header()
    }

    /// The header of an array of little-endian numbers in C order; always a multiple of 64 bytes, and of the
    /// same length for any number of frames.
    pub(crate) fn write(element: Element, shape: &[u64]) -> Vec<u8> {
        let numbers: Vec<String> = shape.iter().map(u64::to_string).collect();
        let order = if element.bytes() == 1 { '|' } else { '<' };
        let text = format!(
            "{{'descr': '{order}{}', 'fortran_order': False, 'shape': ({}), }}",
            element.name(),
            numbers.join(", "),
        );
        // Three numbers of 20 digits fit, so that the count of frames can be filled in later.
        let length = 192 - 10;
        let mut out = MAGIC.to_vec();
        out.extend_from_slice(&[1, 0]);
        out.extend_from_slice(&(length as u16).to_le_bytes());
        out.extend_from_slice(text.as_bytes());
        out.resize(192 - 1, b' ');
        out.push(b'\n');
        out
    }
}

/// Reads until `out` is full or the input ends; how many bytes there were. `before` it so many were read.
pub(crate) fn fill(
    input: &mut impl Read,
    out: &mut [u8],
    file: &Path,
    before: u64,
) -> Result<usize, Error> {
    let mut held = 0;
    while held < out.len() {
        match input.read(&mut out[held..]) {
            Ok(0) => break,
            Ok(n) => held += n,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(source) => {
                return Err(Error::Read {
                    file: file.to_owned(),
                    bytes: before + held as u64,
                    source,
                });
            }
        }
    }
    Ok(held)
}

/// A reader of the one dictionary that numpy writes.
struct Scan<'a> {
    text: &'a [u8],
    at: usize,
    before: u64,
    file: PathBuf,
}

impl<'a> Scan<'a> {
    fn header(mut self) -> Result<Header, Error> {
        let (mut descr, mut order, mut shape) = (None, None, None);
        self.need(b"{", "a dictionary")?;
        while !self.take(b"}") {
            let key = self.quoted()?;
            self.need(b":", "a colon")?;
            match key {
                b"descr" => descr = Some(self.descr()?),
                b"fortran_order" => order = Some(self.truth()?),
                b"shape" => shape = Some(self.numbers()?),
                _ => return Err(self.wrong("the keys descr, fortran_order, shape")),
            }
            if !self.take(b",") {
                self.need(b"}", "a comma or the end of the dictionary")?;
                break;
            }
        }
        let Some(((element, big_endian), fortran_order, shape)) =
            descr.zip(order).zip(shape).map(|((d, o), s)| (d, o, s))
        else {
            return Err(self.wrong("the keys descr, fortran_order, shape"));
        };
        Ok(Header {
            element,
            big_endian,
            fortran_order,
            shape,
            bytes: self.before + self.text.len() as u64,
        })
    }

    fn space(&mut self) {
        while matches!(self.text.get(self.at), Some(b' ' | b'\n' | b'\t' | b'\r')) {
            self.at += 1;
        }
    }

    fn take(&mut self, what: &[u8]) -> bool {
        self.space();
        let found = self.text[self.at..].starts_with(what);
        if found {
            self.at += what.len();
        }
        found
    }

    fn need(&mut self, what: &[u8], words: &'static str) -> Result<(), Error> {
        if self.take(what) {
            Ok(())
        } else {
            Err(self.wrong(words))
        }
    }

    fn wrong(&self, expected: &'static str) -> Error {
        let rest = &self.text[self.at.min(self.text.len())..];
        Error::NpyHeader {
            file: self.file.clone(),
            byte: self.before + self.at as u64,
            found: shortened(&rest[..rest.len().min(16)]),
            expected,
        }
    }

    fn quoted(&mut self) -> Result<&'a [u8], Error> {
        self.space();
        let quote = match self.text.get(self.at) {
            Some(quote @ (b'\'' | b'"')) => *quote,
            _ => return Err(self.wrong("a quoted word")),
        };
        let from = self.at + 1;
        match memchr::memchr(quote, &self.text[from..]) {
            Some(length) => {
                self.at = from + length + 1;
                Ok(&self.text[from..from + length])
            }
            None => Err(self.wrong("a quoted word")),
        }
    }

    fn descr(&mut self) -> Result<(Element, bool), Error> {
        const TYPES: &str = "one of f8 f4 i1 u1 i2 u2 i4 u4 i8 u8";
        self.space();
        let at = self.at;
        let Ok(word) = self.quoted() else {
            self.at = at;
            return Err(self.wrong(TYPES));
        };
        let (order, name) = match word.split_first() {
            Some((order @ (b'<' | b'>' | b'=' | b'|'), name)) => (*order, name),
            _ => (b'=', word),
        };
        let big = order == b'>' || (order == b'=' && cfg!(target_endian = "big"));
        match Element::named(name) {
            Some(element) => Ok((element, big)),
            None => {
                self.at = at;
                Err(self.wrong(TYPES))
            }
        }
    }

    fn truth(&mut self) -> Result<bool, Error> {
        if self.take(b"True") {
            return Ok(true);
        }
        self.need(b"False", "True or False").map(|()| false)
    }

    fn numbers(&mut self) -> Result<Vec<u64>, Error> {
        self.need(b"(", "a shape")?;
        let mut numbers = Vec::new();
        while !self.take(b")") {
            self.space();
            let digits = self.text[self.at..]
                .iter()
                .take_while(|b| b.is_ascii_digit())
                .count();
            let word = std::str::from_utf8(&self.text[self.at..self.at + digits]);
            let Some(number) = word.ok().and_then(|word| word.parse().ok()) else {
                return Err(self.wrong("a number"));
            };
            if numbers.len() == 32 {
                return Err(self.wrong("at most 32 dimensions"));
            }
            numbers.push(number);
            self.at += digits;
            if !self.take(b",") {
                self.need(b")", "a comma or the end of the shape")?;
                break;
            }
        }
        Ok(numbers)
    }
}
