//! Lines of an exported file: LF or CRLF or both, UTF-8 or Latin-1, with a byte-order mark or without.

use std::cell::Cell;
use std::io::{self, Cursor, Read};
use std::path::{Path, PathBuf};

use super::LOOKED_AT;
use super::cells::Separator;
use super::plain::{self, PlainLine};
use super::tabs::{TabbedCells, WithTabs};
use crate::error::{Error, ExportError, Place};
use crate::lines::{Line, Lines};
use crate::source::{Input, open_input};

/// The longest line, bytes: a frame of the largest array on one line, ten characters a number.
const MAX_LINE: usize = 4 << 20;

/// A file of lines, and the line read last.
pub(super) struct TextFile {
    file: PathBuf,
    lines: Lines<Input>,
    line: Line,
    total: Option<u64>,
    /// Whether decimals stand behind a comma; unknown before the first.
    comma: Cell<Option<bool>>,
    /// Whether the last line of those read has an end.
    is_closed: bool,
    /// Whether lines may stand between quotes as a whole.
    unquotes: bool,
}

impl TextFile {
    /// Opens it.
    pub(super) fn open(file: &Path) -> Result<Self, Error> {
        let (input, total) = open_input(file)?;
        let input = with_line_feeds(input).map_err(|source| Error::Read {
            file: file.to_owned(),
            bytes: 0,
            source,
        })?;
        Ok(Self {
            file: file.to_owned(),
            lines: Lines::new(input, MAX_LINE),
            line: Line::End,
            total,
            comma: Cell::new(None),
            is_closed: true,
            unquotes: false,
        })
    }

    /// The same, with tabs for another byte that parts its cells, and without the quotes that cells stand between.
    pub(super) fn open_with_tabs(file: &Path, part: u8) -> Result<Self, Error> {
        let mut text = Self::open(file)?;
        let (input, _) = open_input(file)?;
        let input = with_line_feeds(input).map_err(|source| Error::Read {
            file: file.to_owned(),
            bytes: 0,
            source,
        })?;
        let cells = TabbedCells::new(part);
        text.lines = Lines::new(Box::new(WithTabs { input, cells }), MAX_LINE);
        Ok(text)
    }

    /// Takes the quotes off lines that a spreadsheet has put between them as a whole: where it took each for one cell.
    pub(super) fn without_quotes(mut self) -> Self {
        self.unquotes = true;
        self
    }

    /// Reads the next line; false at the end.
    pub(super) fn advance(&mut self) -> Result<bool, Error> {
        self.line = self.lines.next().map_err(|source| Error::Read {
            file: self.file.clone(),
            bytes: self.lines.bytes(),
            source,
        })?;
        match self.line {
            Line::End => Ok(false),
            Line::TooLong { bytes } => Err(Error::LineLength {
                at: self.place(0),
                found: bytes,
                limit: self.lines.limit(),
            }),
            Line::Text { closed, from, .. } => {
                self.is_closed = closed;
                if self.unquotes
                    && let Some(length) = quoted_length(self.lines.text(self.line))
                {
                    let (from, to) = (from + 1, from + 1 + length);
                    self.line = Line::Text { from, to, closed };
                }
                Ok(true)
            }
        }
    }

    /// Whether the decimals of a number stand behind the same sign as those before it; a file that has both commas and points
    /// writes thousands.
    pub(super) fn has_one_point(&self, number: &[u8]) -> bool {
        let has_comma = number.contains(&b',');
        let known = self.comma.get().unwrap_or(has_comma);
        self.comma.set(Some(known));
        known == has_comma
    }

    /// An error where bytes `from..to` are a number with another decimal sign than those before it.
    pub(super) fn check_point(
        &self,
        format: &'static str,
        (from, to): (usize, usize),
    ) -> Result<(), Error> {
        let number = &self.line()[from..to];
        let is_number = number
            .iter()
            .all(|byte| byte.is_ascii_digit() || matches!(byte, b'.' | b',' | b'"' | b' ' | b'\t'));
        if !is_number || self.has_one_point(number) {
            return Ok(());
        }
        let found = format!("`{}`", crate::grid::shortened(number));
        let [own, other] = match self.comma.get() {
            Some(true) => ["comma", "point"],
            _ => ["point", "comma"],
        };
        let expected = format!("decimals behind a {own}, as in the lines before");
        let hint = match other {
            "comma" => "a comma that parts thousands; save it without them",
            _ => "a point that parts thousands; save it without them",
        };
        Err(self.wrong_at(from, format, found, expected, hint))
    }

    /// Whether the line read last is closed: the last of a file that was cut is not.
    pub(super) fn is_closed(&self) -> bool {
        self.is_closed
    }

    /// Has [`Self::advance`] read the last line once more.
    pub(super) fn unread(&mut self) {
        self.lines.unread();
    }

    /// The line read last.
    pub(super) fn line(&self) -> &[u8] {
        self.lines.text(self.line)
    }

    /// The same, whose cells are parted so, to have its plain ones read.
    pub(super) fn plain(&self, separator: Separator) -> PlainLine<'_> {
        PlainLine {
            text: self.lines.text_on(self.line),
            length: self.line().len(),
            separator,
            point: plain::point_of(self.comma.get(), separator),
        }
    }

    /// Reads it where all of its cells are short whole numbers; false of every other line, and `out` may have lost what it held.
    pub(super) fn read_whole(&self, separator: Separator, out: &mut [f64]) -> bool {
        match separator {
            Separator::One(part) => self.lines.read_cells(self.line, part, out),
            Separator::Blanks => false,
        }
    }

    /// The same as text.
    pub(super) fn words(&self) -> String {
        text_of(self.line())
    }

    /// Its number, from 1; 0 before the first.
    pub(super) fn number(&self) -> u64 {
        self.lines.number()
    }

    /// Where byte `from` of it stands.
    pub(super) fn place(&self, from: usize) -> Place {
        Place {
            file: self.file.clone(),
            line: self.lines.number(),
            column: from as u64 + 1,
        }
    }

    /// Line `line`, from its beginning.
    pub(super) fn line_at(&self, line: u64) -> Place {
        Place {
            line,
            ..self.place(0)
        }
    }

    /// That something stands where its format has another.
    pub(super) fn wrong(
        &self,
        format: &'static str,
        expected: impl Into<String>,
        hint: &'static str,
    ) -> Error {
        let line = self.words();
        let found = match line.trim() {
            "" => "nothing".to_owned(),
            // It may tell of a person.
            line if has_words(line) => format!("a line of {} characters", line.chars().count()),
            line => format!("`{}`", crate::grid::shortened(line.as_bytes())),
        };
        self.wrong_at(0, format, found, expected, hint)
    }

    /// The same of byte `from` of the line.
    pub(super) fn wrong_at(
        &self,
        from: usize,
        format: &'static str,
        found: impl Into<String>,
        expected: impl Into<String>,
        hint: &'static str,
    ) -> Error {
        wrong_there(self.place(from), format, found, expected, hint)
    }

    /// The same of line `line`.
    pub(super) fn wrong_on(
        &self,
        line: u64,
        format: &'static str,
        found: impl Into<String>,
        expected: impl Into<String>,
        hint: &'static str,
    ) -> Error {
        wrong_there(self.line_at(line), format, found, expected, hint)
    }

    /// That the file ends, or another frame begins, within a frame.
    pub(super) fn cut(
        &self,
        format: &'static str,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> Error {
        Error::Export(Box::new(ExportError::Cut {
            format,
            at: self.place(0),
            found: found.into(),
            expected: expected.into(),
        }))
    }

    /// The name of the file.
    pub(super) fn file(&self) -> &Path {
        &self.file
    }

    /// Bytes read so far.
    pub(super) fn bytes(&self) -> u64 {
        self.lines.bytes()
    }

    /// Bytes of the whole; `None` of a pipe.
    pub(super) fn total(&self) -> Option<u64> {
        self.total
    }
}

/// That something else stands somewhere than is expected there.
fn wrong_there(
    at: Place,
    format: &'static str,
    found: impl Into<String>,
    expected: impl Into<String>,
    hint: &'static str,
) -> Error {
    Error::Export(Box::new(ExportError::Line {
        format,
        at,
        found: found.into(),
        expected: expected.into(),
        hint,
    }))
}

/// How long what stands between the quotes of a line is, which has no others; `None` of another line.
fn quoted_length(line: &[u8]) -> Option<usize> {
    let inside = line.strip_prefix(b"\"")?;
    let padding = inside.iter().rev();
    let padding = padding.take_while(|byte| matches!(byte, b',' | b';' | b'\t' | b' '));
    let inside = inside[..inside.len() - padding.count()].strip_suffix(b"\"")?;
    memchr::memchr(b'"', inside)
        .is_none()
        .then_some(inside.len())
}

/// Text of bytes that are UTF-8, or else Latin-1.
pub(super) fn text_of(bytes: &[u8]) -> String {
    match std::str::from_utf8(bytes) {
        Ok(text) => text.to_owned(),
        Err(_) => bytes.iter().map(|&byte| char::from(byte)).collect(),
    }
}

/// Whether a line has words beside those that a frame has.
fn has_words(line: &str) -> bool {
    let words = line.split(|c: char| !c.is_alphabetic());
    let mut others = words.filter(|word| {
        word.chars().count() > 2 && !["Frame", "Force", "nan", "NaN"].contains(word)
    });
    others.next().is_some()
}

/// Whether a line ends in a decimal sign, behind which digits are lost.
pub(super) fn ends_in_point(line: &[u8]) -> bool {
    matches!(line.trim_ascii_end().last(), Some(b'.' | b','))
}

/// Whether the lines of a file that begins so end with a carriage return alone.
pub(super) fn has_returns_only(beginning: &[u8]) -> bool {
    beginning.contains(&b'\r') && !beginning.contains(&b'\n')
}

/// The same input with line feeds where its lines end with a carriage return alone.
fn with_line_feeds(mut input: Input) -> io::Result<Input> {
    let mut beginning = Vec::new();
    (&mut input).take(LOOKED_AT).read_to_end(&mut beginning)?;
    let has_returns = has_returns_only(&beginning);
    let whole = Cursor::new(beginning).chain(input);
    if has_returns {
        Ok(Box::new(Replaced {
            input: whole,
            from: b'\r',
            to: b'\n',
        }))
    } else {
        Ok(Box::new(whole))
    }
}

/// Gives a byte for another.
struct Replaced<R> {
    input: R,
    from: u8,
    to: u8,
}

impl<R: Read> Read for Replaced<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let read = self.input.read(out)?;
        let found = out[..read].iter_mut().filter(|byte| **byte == self.from);
        found.for_each(|byte| *byte = self.to);
        Ok(read)
    }
}
