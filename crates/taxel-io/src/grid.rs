//! Frames as lines of numbers: the one core behind counts ([`crate::text`]) and values ([`crate::values`]).

mod blocks;
mod faults;
mod pieces;

use std::io::Read;
use std::path::{Path, PathBuf};

use taxel::{Frame, Mark};

use crate::error::Error;
use crate::integrity::Integrity;
use crate::lines::{Line, Lines};
use crate::number::{Rule, count_fields, count_numbers, is_blank, parse_line};
use crate::options::ReadOptions;
use crate::source::{MAX_TAXELS, SkipLog, Skipped, fit_shape};
use blocks::Plain;
pub(crate) use faults::shortened;

/// What stands before a frame's lines in the `.csv` form.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    Blank,
    Number,
    /// Words, in that many fields.
    Words(usize),
}

/// What is known about extra lines.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Extra {
    /// The first line will tell.
    Unknown,
    /// There was none before the first frame; blank lines may still part the frames.
    Bare,
    /// There was one before the first frame; the second frame tells whether every frame has one.
    First(Kind),
    /// Every frame has one, of this kind.
    Every(Kind),
    /// Every frame has one, because the caller says so, whatever it looks like.
    Told,
    /// There are none (any more).
    Never,
}

/// What was found where a frame should begin.
enum Start {
    End,
    Frame { time_secs: Option<f64> },
}

/// One frame read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Got {
    pub(crate) sequence: u64,
    pub(crate) time_secs: Option<f64>,
}

/// How far a frame has been read, so that its end can be found when it is broken.
#[derive(Default)]
struct Progress {
    lines: usize,
    /// Fields of the line before, when it was short: half a line torn in two.
    short: Option<usize>,
    /// Whether two lines were taken for halves of one.
    has_joined: bool,
    /// A line had numbers of no whole count of lines, or more than one was torn in two: it may be that all were cut off.
    is_torn: bool,
}

impl Progress {
    /// Whether a line of `fields` fields is the second half of the short one before it.
    fn is_half(&self, fields: usize, expected: usize) -> bool {
        let joins = |before: usize| before + fields == expected || before + fields == expected + 1;
        fields < expected && self.short.is_some_and(joins)
    }

    /// Counts a line: joined lines count as several, the two halves of one as one.
    fn count(&mut self, fields: usize, expected: usize) {
        if self.is_half(fields, expected) {
            self.join();
            return;
        }
        self.lines += fields.div_ceil(expected).max(1);
        self.is_torn |=
            self.short.is_some() || (fields > expected && !fields.is_multiple_of(expected));
        self.short = (fields < expected).then_some(fields);
    }

    /// The line is the second half of the short one before it.
    fn join(&mut self) {
        self.short = None;
        self.is_torn |= self.has_joined;
        self.has_joined = true;
    }

    /// Whether there were more or fewer lines than were counted, for all that is known.
    fn is_doubtful(&self) -> bool {
        self.is_torn || self.short.is_some()
    }
}

/// A stream of frames as lines of numbers.
pub(crate) struct Grid<R> {
    lines: Lines<R>,
    file: PathBuf,
    options: ReadOptions,
    rule: Rule,
    frame_lines: usize,
    line_numbers: usize,
    /// One line of a transposed file.
    column: Vec<f64>,
    extra: Extra,
    frame: u64,
    progress: Progress,
    /// Whether the line before was closed by a comma.
    commas: bool,
    skips: SkipLog,
    /// The first frame that may begin on another line than it should.
    doubtful: Option<u64>,
    done: bool,
    plain: Plain,
}

impl<R: Read> Grid<R> {
    pub(crate) fn new(
        reader: R,
        file: &Path,
        options: ReadOptions,
        rule: Rule,
    ) -> Result<Self, Error> {
        let ReadOptions { rows, columns, .. } = options;
        if !(1..=MAX_TAXELS).contains(&rows.saturating_mul(columns)) {
            let file = file.to_owned();
            return Err(Error::Size {
                file,
                rows,
                columns,
                limit: MAX_TAXELS,
            });
        }
        let (frame_lines, line_numbers) = if options.transpose {
            (columns, rows)
        } else {
            (rows, columns)
        };
        Ok(Self {
            lines: Lines::new(reader, line_limit(rows.max(columns))),
            file: file.to_owned(),
            options,
            rule,
            frame_lines,
            line_numbers,
            column: vec![0.0; if options.transpose { rows } else { 0 }],
            extra: match options.extra_line {
                Some(true) => Extra::Told,
                Some(false) => Extra::Never,
                None => Extra::Unknown,
            },
            frame: 0,
            progress: Progress::default(),
            commas: false,
            skips: SkipLog::default(),
            doubtful: None,
            done: false,
            plain: Plain::default(),
        })
    }

    pub(crate) fn bytes(&self) -> u64 {
        self.lines.bytes()
    }

    /// Bytes of a frame, on average so far.
    pub(crate) fn frame_bytes(&self) -> Option<u64> {
        let each = self.bytes().checked_div(self.frame);
        each.filter(|bytes| *bytes > 0)
    }

    pub(crate) fn skips(&self) -> &SkipLog {
        &self.skips
    }

    pub(crate) fn integrity(&self) -> Integrity {
        let mut integrity = Integrity::default();
        integrity.damage.doubtful = self.doubtful.filter(|first| *first < self.frame);
        integrity
    }

    /// The next frame's values, row by row, or `None` at the end. `values` holds rows × columns.
    pub(crate) fn next(&mut self, values: &mut [f64]) -> Result<Option<Got>, Error> {
        self.check_stopped()?;
        while !self.done {
            self.progress = Progress::default();
            let first_line = self.lines.number() + 1;
            match self.one_frame(values) {
                Ok(None) => self.done = true,
                Ok(Some(time_secs)) => {
                    let sequence = self.frame;
                    self.frame += 1;
                    return Ok(Some(Got {
                        sequence,
                        time_secs,
                    }));
                }
                Err(error) if self.options.keep_going && error.is_one_frame() => {
                    let frame = self.frame;
                    self.skips.add(Skipped {
                        frame,
                        first_line: Some(first_line),
                        error,
                    });
                    self.frame += 1;
                    self.find_next_frame()?;
                    let is_parted = matches!(self.extra, Extra::Every(_));
                    if !is_parted && self.progress.is_doubtful() {
                        self.doubtful.get_or_insert(self.frame);
                    }
                }
                Err(error) => {
                    self.done = true;
                    return Err(error);
                }
            }
        }
        Ok(None)
    }

    /// The next frame, into `frame`, which is replaced when it has another shape.
    pub(crate) fn next_into<Q>(&mut self, frame: &mut Frame<Q>) -> Result<bool, Error> {
        fit_shape(frame, self.options.rows, self.options.columns);
        let Some(got) = self.next(frame.values_mut())? else {
            return Ok(false);
        };
        frame.marks_mut().fill(Mark::Good);
        frame.sequence = got.sequence;
        frame.time_secs = got.time_secs;
        Ok(true)
    }

    fn line(&mut self) -> Result<Line, Error> {
        let bytes = self.lines.bytes();
        let line = self.lines.next();
        line.map_err(|source| self.unreadable(bytes, source))
    }

    fn one_frame(&mut self, values: &mut [f64]) -> Result<Option<Option<f64>>, Error> {
        let time_secs = match self.start()? {
            Start::End => return Ok(None),
            Start::Frame { time_secs } => time_secs,
        };
        for k in 0..self.frame_lines {
            match self.line()? {
                Line::End => return Err(self.cut_short(1, "stopped")),
                Line::TooLong { bytes } => {
                    self.progress.lines += 1;
                    self.progress.is_torn = true;
                    let (at, limit) = (self.place(0), self.lines.limit());
                    return Err(Error::LineLength {
                        at,
                        found: bytes,
                        limit,
                    });
                }
                line @ Line::Text { closed, .. } => {
                    self.one_line(line, k, values)?;
                    let comma = self.lines.text(line).ends_with(b",");
                    if self.commas && !comma && !closed {
                        self.progress.lines -= 1;
                        return Err(self.cut_short(0, "stopped"));
                    }
                    self.commas = comma;
                }
            }
        }
        Ok(Some(time_secs))
    }

    /// Reads line `k` of a frame into its place.
    fn one_line(&mut self, line: Line, k: usize, values: &mut [f64]) -> Result<(), Error> {
        let text = self.lines.text(line);
        let n = self.line_numbers;
        let out = if self.options.transpose {
            &mut self.column[..]
        } else {
            &mut values[k * n..(k + 1) * n]
        };
        let most = self.rule.most();
        if !self.lines.read_plain(line, out, most)
            && let Err(fault) = parse_line(text, out, self.rule)
        {
            return Err(self.broken(line, fault));
        }
        self.progress.lines += 1;
        if self.options.transpose {
            let columns = self.options.columns;
            for (row, value) in self.column.iter().enumerate() {
                values[row * columns + k] = *value;
            }
        }
        Ok(())
    }

    /// Goes to the first line of the next frame; an extra line that names itself as one is left unread.
    fn find_next_frame(&mut self) -> Result<(), Error> {
        loop {
            let every = matches!(self.extra, Extra::Every(_));
            let enough = self.progress.lines >= self.frame_lines;
            if enough && !every {
                return self.skip_half();
            }
            match self.line()? {
                Line::End => return Ok(()),
                Line::TooLong { .. } => {
                    self.progress.lines += 1;
                    self.progress.is_torn = true;
                }
                line => {
                    let text = self.lines.text(line);
                    let begins = if enough {
                        self.kind_of(text).is_some()
                    } else {
                        self.begins_next(text)
                    };
                    if begins {
                        self.lines.unread();
                        return Ok(());
                    }
                    let fields = count_fields(text);
                    self.progress.count(fields, self.line_numbers);
                }
            }
        }
    }

    /// Goes past the second half of a frame's last line, where that was torn in two.
    fn skip_half(&mut self) -> Result<(), Error> {
        if self.progress.short.is_none() {
            return Ok(());
        }
        let line = self.line()?;
        if let Line::Text { .. } = line {
            let fields = count_fields(self.lines.text(line));
            if fields > 0 && self.progress.is_half(fields, self.line_numbers) {
                self.progress.join();
                return Ok(());
            }
        }
        self.lines.unread();
        Ok(())
    }

    /// Whether a line inside a frame is the extra line of the next one.
    fn begins_next(&self, text: &[u8]) -> bool {
        let Extra::Every(kind) = self.extra else {
            return false;
        };
        self.kind_of(text) == Some(kind)
    }

    fn kind_of(&self, text: &[u8]) -> Option<Kind> {
        kind_of(text, self.line_numbers, self.frame_lines)
    }

    fn start(&mut self) -> Result<Start, Error> {
        let line = self.line()?;
        if line == Line::End {
            if self.frame == 0 {
                return Err(self.empty());
            }
            return Ok(Start::End);
        }
        let is_text = matches!(line, Line::Text { .. });
        let blank = is_text && is_blank(self.lines.text(line));
        if blank && self.rest_is_blank()? {
            return if self.frame == 0 {
                Err(self.empty())
            } else {
                Ok(Start::End)
            };
        }
        let kind = match (blank, is_text) {
            (true, _) => Some(Kind::Blank),
            (_, true) => self.kind_of(self.lines.text(line)),
            _ => None,
        };
        // A blank line is gone with those after it; any other can still be read.
        let time_secs = if blank {
            None
        } else {
            time_of(self.lines.text(line)).map_err(|found| Error::Time {
                at: self.place(TIME_PREFIX.len()),
                found,
            })?
        };
        self.extra = match (self.extra, kind) {
            (Extra::Told, _) => Extra::Told,
            (Extra::Unknown, Some(kind)) => Extra::First(kind),
            (Extra::First(_), Some(kind)) => Extra::Every(kind),
            (Extra::Every(kind), Some(_)) => Extra::Every(kind),
            (Extra::Bare, Some(Kind::Blank)) => Extra::Every(Kind::Blank),
            (Extra::Every(_), None) => return Err(self.no_extra_line()),
            (Extra::Never, Some(Kind::Blank)) => return Err(self.blank_inside()),
            (bare, _) => {
                let first = bare == Extra::Unknown;
                self.extra = if first { Extra::Bare } else { Extra::Never };
                self.lines.unread();
                return Ok(Start::Frame { time_secs: None });
            }
        };
        Ok(Start::Frame { time_secs })
    }

    /// After a blank line: reads the blank ones that follow; true at the end, else the next is unread.
    fn rest_is_blank(&mut self) -> Result<bool, Error> {
        loop {
            match self.line()? {
                Line::End => return Ok(true),
                line @ Line::Text { .. } if is_blank(self.lines.text(line)) => {}
                _ => {
                    self.lines.unread();
                    return Ok(false);
                }
            }
        }
    }
}

/// Bytes of the longest line that `numbers` numbers may take, with room for a header.
pub(crate) fn line_limit(numbers: usize) -> usize {
    numbers.saturating_mul(64).max(4096)
}

/// Which kind of extra line this is; `None` for a line of a frame, whole or broken.
pub(crate) fn kind_of(text: &[u8], line_numbers: usize, frame_lines: usize) -> Option<Kind> {
    if is_blank(text) {
        return Some(Kind::Blank);
    }
    let fields = count_fields(text);
    let numbers = count_numbers(text);
    if numbers == 0 {
        return Some(Kind::Words(fields));
    }
    let like_a_row = fields == line_numbers
        || (fields == frame_lines && frame_lines > 1)
        || (numbers > 1 && 2 * numbers >= line_numbers);
    if like_a_row {
        return None;
    }
    Some(if numbers == fields {
        Kind::Number
    } else {
        Kind::Words(fields)
    })
}

/// The prefix of the time stamp that [`crate::TextWriter`] writes; others have no known unit.
pub(crate) const TIME_PREFIX: &str = "time_secs=";

/// Seconds beyond which a time is none: three hundred years.
const MAX_SECS: f64 = 1e10;

/// The time on an extra line, `None` where it has none; and what stands there where that is no time.
fn time_of(text: &[u8]) -> Result<Option<f64>, String> {
    let Some(digits) = text.strip_prefix(TIME_PREFIX.as_bytes()) else {
        return Ok(None);
    };
    let digits = digits.strip_suffix(b",").unwrap_or(digits);
    match fast_float2::parse::<f64, _>(digits) {
        Ok(secs) if secs.abs() <= MAX_SECS => Ok(Some(secs)),
        _ => Err(shown(digits)),
    }
}

/// What stands in a file, shortened for a message.
fn shown(bytes: &[u8]) -> String {
    String::from_utf8_lossy(&bytes[..bytes.len().min(24)]).into_owned()
}
