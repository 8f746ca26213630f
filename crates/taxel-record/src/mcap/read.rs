//! Reading, a chunk at a time.

use std::collections::HashMap;
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use mcap::parse_record;
use mcap::records::Record;
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use prost::Message;
use taxel::{Counts, Frame};

use super::grid::{Grid, SCHEMA};
use super::index::Index;
use super::{COUNTS, EVENTS, METADATA};
use crate::error::Error;
use crate::source::{FrameSource, MAX_TAXELS, SkipLog, Skipped, fit_shape, open_file};
use crate::text::TextOptions;

/// The longest record believed: a length beyond it is damage, not data.
pub(super) const LONGEST_RECORD: usize = 1 << 28;

/// Something that happened during a recording.
#[derive(Debug, Clone, PartialEq)]
pub struct Event {
    /// When, by the host's clock.
    pub at: SystemTime,
    /// Seconds since the recording's first frame, by the same clock; negative before it.
    pub secs: f64,
    /// `tare`, `mark`, `device`.
    pub kind: String,
    /// What, in words.
    pub text: String,
}

/// Reads the counts of a recording. Of one that was cut off, everything up to there comes, then
/// [`Error::RecordingCut`].
pub struct McapReader {
    path: PathBuf,
    file: File,
    total: Option<u64>,
    bytes: u64,
    reader: LinearReader,
    index: Option<Index>,
    schemas: HashMap<u16, String>,
    topics: HashMap<u16, (String, u16)>,
    about: HashMap<String, String>,
    events: Vec<Happened>,
    /// Log time of the first frame.
    start: Option<u64>,
    /// The channel that carries the counts, once it is known.
    counts: Option<u16>,
    /// The next frame, read ahead to know its shape.
    ahead: Option<Ahead>,
    shape: (usize, usize),
    transpose: bool,
    maximum: f64,
    keep_going: bool,
    frames: u64,
    host: SystemTime,
    device: DeviceClock,
    skips: SkipLog,
    whole: bool,
    done: bool,
}

/// An event as the file has it.
struct Happened {
    log_time: u64,
    kind: String,
    text: String,
}

struct Ahead {
    grid: Grid,
    log_time: u64,
    publish_time: u64,
}

fn options() -> LinearReaderOptions {
    LinearReaderOptions::default()
        .with_skip_end_magic(true)
        .with_prevalidate_chunk_crcs(true)
        .with_record_length_limit(LONGEST_RECORD)
}

/// Device time from publish times: seconds since the first frame.
#[derive(Default)]
struct DeviceClock {
    first: Option<u64>,
}

impl McapReader {
    /// Opens a recording of the shape that `options` give.
    ///
    /// # Errors
    /// [`Error::Open`], [`Error::Recording`], [`Error::NoCounts`], [`Error::FrameShape`].
    pub fn open(path: impl AsRef<Path>, options: TextOptions) -> Result<Self, Error> {
        let mut reader = Self::open_any(path)?;
        reader.transpose = options.transpose;
        reader.maximum = options.max_count.unwrap_or(f64::MAX);
        reader.keep_going = options.keep_going;
        let (rows, columns) = reader.shape;
        let found = match options.transpose {
            true => (columns, rows),
            false => (rows, columns),
        };
        let expected = (options.rows, options.columns);
        if found != expected {
            return Err(Error::FrameShape {
                file: reader.path,
                frame: 0,
                found,
                expected,
            });
        }
        reader.shape = expected;
        Ok(reader)
    }

    /// Opens a recording, whatever its shape.
    ///
    /// # Errors
    /// As [`Self::open`].
    pub fn open_any(path: impl AsRef<Path>) -> Result<Self, Error> {
        let path = path.as_ref().to_owned();
        let (file, total) = open_file(&path)?;
        let mut reader = Self {
            path,
            file,
            total,
            bytes: 0,
            reader: LinearReader::new_with_options(options()),
            index: None,
            schemas: HashMap::new(),
            topics: HashMap::new(),
            about: HashMap::new(),
            events: Vec::new(),
            start: None,
            counts: None,
            ahead: None,
            shape: (0, 0),
            transpose: false,
            maximum: f64::MAX,
            keep_going: true,
            frames: 0,
            host: SystemTime::UNIX_EPOCH,
            device: DeviceClock::default(),
            skips: SkipLog::default(),
            whole: false,
            done: false,
        };
        reader.ahead = reader.read_grid()?;
        let Some(ahead) = &reader.ahead else {
            return Err(Error::NoCounts {
                file: reader.path.clone(),
                found: reader
                    .topics
                    .values()
                    .map(|(topic, _)| topic.clone())
                    .collect(),
            });
        };
        reader.start = Some(ahead.log_time);
        let (rows, columns) = (ahead.grid.rows(), ahead.grid.column_count as usize);
        let taxels = rows.saturating_mul(columns);
        if taxels == 0 || taxels > MAX_TAXELS {
            return Err(Error::Size {
                file: reader.path,
                rows,
                columns,
                limit: MAX_TAXELS,
            });
        }
        reader.shape = (rows, columns);
        if let (Some(counts), true) = (reader.counts, reader.total.is_some()) {
            let at = reader.file.stream_position();
            reader.index = Index::read(&mut reader.file, counts);
            at.and_then(|at| reader.file.seek(SeekFrom::Start(at)))
                .map_err(|source| Error::Read {
                    file: reader.path.clone(),
                    bytes: reader.bytes,
                    source,
                })?;
        }
        Ok(reader)
    }

    /// The sensor file that the recording carries.
    pub fn sensor_toml(&self) -> Option<&str> {
        self.about.get("sensor_toml").map(String::as_str)
    }

    /// The program that wrote it, and its version.
    pub fn program(&self) -> Option<&str> {
        self.about.get("program").map(String::as_str)
    }

    /// How long the recording is, seconds, and its frames; `None` where it has no index (it was cut off).
    pub fn extent(&self) -> Option<(f64, u64)> {
        let index = self.index.as_ref()?;
        Some((index.secs(index.end), index.frames))
    }

    /// Goes to the first frame `secs` after the beginning; false where the recording has no index.
    ///
    /// # Errors
    /// [`Error::Read`].
    pub fn seek(&mut self, secs: f64) -> Result<bool, Error> {
        let Some(index) = &self.index else {
            return Ok(false);
        };
        let wanted = index.start.saturating_add((secs.max(0.0) * 1e9) as u64);
        let chunk = index.chunks.iter().find(|chunk| chunk.end >= wanted);
        let Some(offset) = chunk.or(index.chunks.last()).map(|chunk| chunk.offset) else {
            return Ok(false);
        };
        let share = index.secs(wanted) / index.secs(index.end).max(1e-9);
        self.frames = (share.min(1.0) * index.frames as f64) as u64;
        self.file
            .seek(SeekFrom::Start(offset))
            .map_err(|source| Error::Read {
                file: self.path.clone(),
                bytes: offset,
                source,
            })?;
        self.bytes = offset;
        self.reader = LinearReader::new_with_options(options().with_skip_start_magic(true));
        (self.whole, self.done) = (false, false);
        self.events.clear();
        loop {
            self.ahead = self.read_grid()?;
            match &self.ahead {
                Some(ahead) if ahead.log_time < wanted => {}
                _ => break,
            }
        }
        self.events.retain(|event| event.log_time >= wanted);
        Ok(true)
    }

    /// When the host had the frame read last.
    pub fn host_time(&self) -> SystemTime {
        self.host
    }

    /// Reads on to the next message of the counts; `None` at the end.
    fn read_grid(&mut self) -> Result<Option<Ahead>, Error> {
        loop {
            let found = match self.reader.next_event() {
                None => None,
                Some(Ok(LinearReadEvent::ReadRequest(wanted))) => {
                    // More than asked for would make small chunks one read each; less would be many.
                    let buffer = self.reader.insert(wanted.max(1 << 16));
                    let count = self.file.read(buffer).map_err(|source| Error::Read {
                        file: self.path.clone(),
                        bytes: self.bytes,
                        source,
                    })?;
                    self.bytes += count as u64;
                    self.reader.notify_read(count);
                    continue;
                }
                Some(Ok(LinearReadEvent::Record { data, opcode })) => {
                    match parse_record(opcode, data) {
                        Ok(record) => Some(Ok(record.into_owned())),
                        Err(error) => Some(Err(error)),
                    }
                }
                Some(Err(error)) => Some(Err(error)),
            };
            let record = match found {
                Some(Ok(record)) => record,
                // Behind the data there is only the index.
                _ if self.whole => return Ok(None),
                Some(Err(error @ mcap::McapError::BadMagic)) => return Err(self.damaged(&error)),
                // The reader gives up where a record is torn.
                Some(Err(_)) if Some(self.bytes) == self.total => return self.cut(),
                Some(Err(error)) => return Err(self.damaged(&error)),
                None => return self.cut(),
            };
            if let Some(ahead) = self.take(record)? {
                return Ok(Some(ahead));
            }
        }
    }

    /// The file ends before its end.
    fn cut(&mut self) -> Result<Option<Ahead>, Error> {
        Err(Error::RecordingCut {
            file: self.path.clone(),
            frames: self.frames,
            bytes: self.bytes,
        })
    }

    fn damaged(&self, error: &mcap::McapError) -> Error {
        Error::Recording {
            file: self.path.clone(),
            frames: self.frames,
            source: io::Error::new(io::ErrorKind::InvalidData, error.to_string()),
        }
    }

    fn take(&mut self, record: Record) -> Result<Option<Ahead>, Error> {
        match record {
            Record::Schema { header, .. } => {
                self.schemas.insert(header.id, header.name);
            }
            Record::Channel(channel) => {
                let grid = self
                    .schemas
                    .get(&channel.schema_id)
                    .is_some_and(|name| name == SCHEMA);
                let own = channel.topic == COUNTS;
                if grid && channel.message_encoding == "protobuf" && (own || self.counts.is_none())
                {
                    self.counts = Some(channel.id);
                }
                self.topics
                    .insert(channel.id, (channel.topic, channel.schema_id));
            }
            Record::Metadata(metadata) if metadata.name == METADATA => {
                self.about.extend(metadata.metadata);
            }
            Record::DataEnd(_) => self.whole = true,
            Record::Message { header, data } if Some(header.channel_id) == self.counts => {
                let grid = Grid::decode(&*data).map_err(|error| Error::Recording {
                    file: self.path.clone(),
                    frames: self.frames,
                    source: io::Error::new(io::ErrorKind::InvalidData, error),
                })?;
                return Ok(Some(Ahead {
                    grid,
                    log_time: header.log_time,
                    publish_time: header.publish_time,
                }));
            }
            Record::Message { header, data } => {
                let topic = self.topics.get(&header.channel_id);
                if topic.is_some_and(|(topic, _)| topic == EVENTS) {
                    self.take_event(header.log_time, &data);
                }
            }
            _ => {}
        }
        Ok(None)
    }

    fn take_event(&mut self, log_time: u64, data: &[u8]) {
        let Ok(json) = serde_json::from_slice::<serde_json::Value>(data) else {
            return;
        };
        let word = |key: &str| json[key].as_str().unwrap_or_default().to_owned();
        self.events.push(Happened {
            log_time,
            kind: word("kind"),
            text: word("text"),
        });
    }

    /// Puts a message into `frame`.
    fn fill(&mut self, ahead: &Ahead, frame: &mut Frame<Counts>) -> Result<(), Error> {
        let (rows, columns) = self.shape;
        let found = (ahead.grid.rows(), ahead.grid.column_count as usize);
        let expected = match self.transpose {
            true => (columns, rows),
            false => (rows, columns),
        };
        let field = ahead.grid.field("counts");
        if found != expected {
            return Err(Error::FrameShape {
                file: self.path.clone(),
                frame: self.frames,
                found,
                expected,
            });
        }
        fit_shape(frame, rows, columns);
        let read = field.is_some_and(|field| ahead.grid.read(field, frame.values_mut()));
        if !read {
            return Err(Error::NoCounts {
                file: self.path.clone(),
                found: ahead.grid.fields.iter().map(|f| f.name.clone()).collect(),
            });
        }
        if self.transpose {
            let swapped = frame.values().to_vec();
            for (i, value) in frame.values_mut().iter_mut().enumerate() {
                *value = swapped[(i % columns) * rows + i / columns];
            }
        }
        for (i, &value) in frame.values().iter().enumerate() {
            if !(0.0..=self.maximum).contains(&value) {
                return Err(Error::Value {
                    file: self.path.clone(),
                    frame: self.frames,
                    row: i / columns,
                    column: i % columns,
                    found: value,
                    minimum: 0.0,
                    maximum: self.maximum,
                    hint: "the recording is of another converter; check bits in the sensor file",
                });
            }
        }
        frame.marks_mut().fill(taxel::Mark::Good);
        frame.sequence = self.frames;
        let first = *self.device.first.get_or_insert(ahead.publish_time);
        // As whole numbers: since 1970 there are more nanoseconds than a float can tell apart.
        let since = i128::from(ahead.publish_time) - i128::from(first);
        frame.time_secs = Some(since as f64 * 1e-9);
        self.host = SystemTime::UNIX_EPOCH + Duration::from_nanos(ahead.log_time);
        Ok(())
    }
}

impl FrameSource<Counts> for McapReader {
    fn shape(&self) -> (usize, usize) {
        self.shape
    }

    fn next_into(&mut self, frame: &mut Frame<Counts>) -> Result<bool, Error> {
        while !self.done {
            let ahead = match self.ahead.take() {
                Some(ahead) => Ok(Some(ahead)),
                None => self.read_grid(),
            };
            let error = match ahead {
                Ok(None) => {
                    self.done = true;
                    return Ok(false);
                }
                Ok(Some(ahead)) => match self.fill(&ahead, frame) {
                    Ok(()) => {
                        self.frames += 1;
                        return Ok(true);
                    }
                    Err(error) => {
                        self.frames += 1;
                        error
                    }
                },
                Err(error) => {
                    self.done = true;
                    error
                }
            };
            if !self.keep_going {
                self.done = true;
                return Err(error);
            }
            self.skips.add(Skipped {
                frame: self.frames,
                first_line: None,
                error,
            });
        }
        Ok(false)
    }

    fn take_events(&mut self) -> Vec<Event> {
        let start = self.start.unwrap_or_default();
        let events = self.events.drain(..).map(|event| Event {
            at: SystemTime::UNIX_EPOCH + Duration::from_nanos(event.log_time),
            secs: (i128::from(event.log_time) - i128::from(start)) as f64 * 1e-9,
            kind: event.kind,
            text: event.text,
        });
        events.collect()
    }
    fn skipped(&self) -> usize {
        self.skips.count
    }
    fn skips(&self) -> &[Skipped] {
        &self.skips.first
    }
    fn bytes_read(&self) -> u64 {
        self.bytes
    }
    fn bytes_total(&self) -> Option<u64> {
        self.total
    }
}
