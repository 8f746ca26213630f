//! Reading, a chunk at a time.

mod frames;

use std::collections::{BTreeMap, HashMap};
use std::fs::File;
use std::io::{Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use mcap::records::Record;
use serde::Deserialize;

use super::grid::Grid;
use super::index::Index;
use super::parse::{self, Records};
use super::scan::{Found, MAX_RECORD, Scanner};
use super::topics::Topics;
use super::{METADATA, sought};
use crate::error::{Error, other_shape};
use crate::integrity::{Damage, Gaps, TimeGaps};
use crate::losses::{self, Losses};
use crate::options::ReadOptions;
use crate::source::{MAX_TAXELS, SkipLog, open_file};
use crate::tare::{self, Tare};

/// The longest event, its longest text, and how many wait to be taken: more is no note of a person.
const EVENT_BYTES: usize = 64 << 10;
const EVENT_TEXT: usize = 4 << 10;
const EVENTS_WAITING: usize = 10_000;

/// Reads the counts of a recording. A damaged chunk costs its own frames; what is missing is told by
/// [`crate::FrameSource::integrity`], and at the end by [`Error::RecordingDamaged`] where the options do not accept it. Of a
/// recording that was cut off, everything up to there comes, then [`Error::RecordingCut`].
pub struct McapReader {
    pub(super) path: PathBuf,
    pub(super) scanner: Scanner<File>,
    /// The chunk that is being read, and how far.
    content: Option<(Vec<u8>, usize)>,
    pub(super) index: Option<Index>,
    pub(super) topics: Topics,
    about: BTreeMap<String, String>,
    pub(super) events: Vec<Happened>,
    /// Log time of the first frame.
    start: Option<u64>,
    /// The next frame, read ahead to know its shape.
    pub(super) ahead: Option<Ahead>,
    shape: (usize, usize),
    options: ReadOptions,
    /// Position of the next frame.
    pub(super) frames: u64,
    host: SystemTime,
    number: Option<u32>,
    device: DeviceClock,
    skips: SkipLog,
    pub(super) tare: Option<Tare>,
    losses: Losses,
    gaps: Gaps,
    /// When the frame before was published, and what such times tell.
    published: Option<u64>,
    times: TimeGaps,
    damage: Damage,
    lost: LostFrames,
    /// It was read from its beginning on, and so can be held against what it says of itself.
    in_full: bool,
    messages: u64,
    done: bool,
}

/// An event as the file has it.
pub(super) struct Happened {
    pub(super) log_time: u64,
    kind: String,
    text: String,
}

pub(super) struct Ahead {
    grid: Result<Grid, String>,
    pub(super) log_time: u64,
    publish_time: u64,
    number: u32,
}

/// Device time from publish times: seconds since the first frame.
#[derive(Default)]
struct DeviceClock {
    first: Option<u64>,
}

/// Frames of chunks that are lost, counted by the indexes that follow each chunk.
#[derive(Default)]
struct LostFrames {
    /// The chunk before was lost.
    after_lost: bool,
    /// Channels whose index has come since the last chunk.
    indexed: Vec<u16>,
    /// By channel, of those not yet counted.
    waiting: HashMap<u16, u64>,
}

impl LostFrames {
    fn chunk(&mut self, is_lost: bool) {
        self.after_lost = is_lost;
        self.indexed.clear();
    }

    fn index(&mut self, channel: u16, messages: usize) {
        // A second index of a channel is that of a chunk that was not even seen.
        if self.after_lost || self.indexed.contains(&channel) {
            *self.waiting.entry(channel).or_default() += messages as u64;
        }
        self.indexed.push(channel);
    }
}

#[derive(Deserialize)]
struct EventJson {
    #[serde(default)]
    kind: String,
    #[serde(default)]
    text: String,
}

impl McapReader {
    /// Opens a recording of the shape that `options` give.
    ///
    /// # Errors
    /// [`Error::Open`], [`Error::NotMcap`], [`Error::NoCounts`], [`Error::FileShape`]; [`Error::RecordingDamaged`] where no
    /// frame is left.
    pub fn open(path: impl AsRef<Path>, options: ReadOptions) -> Result<Self, Error> {
        let mut reader = Self::open_any(path)?;
        reader.options = options;
        let (rows, columns) = reader.shape;
        let found = if options.transpose {
            (columns, rows)
        } else {
            (rows, columns)
        };
        let expected = (options.rows, options.columns);
        if found != expected {
            return Err(other_shape(&reader.path, found, expected));
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
        let (mut file, total) = open_file(&path)?;
        let index = match total {
            Some(total) => Index::read(&mut file, total),
            None => None,
        };
        if total.is_some() {
            file.seek(SeekFrom::Start(0))
                .map_err(|source| Error::Read {
                    file: path.clone(),
                    bytes: 0,
                    source,
                })?;
        }
        let mut options = ReadOptions::new(1, 1);
        options.keep_going = true;
        let mut reader = Self {
            path,
            scanner: Scanner::new(file, total),
            content: None,
            topics: index
                .as_ref()
                .map(|index| index.topics.clone())
                .unwrap_or_default(),
            index,
            about: BTreeMap::new(),
            events: Vec::new(),
            start: None,
            ahead: None,
            shape: (0, 0),
            options,
            frames: 0,
            host: SystemTime::UNIX_EPOCH,
            number: None,
            device: DeviceClock::default(),
            skips: SkipLog::default(),
            tare: None,
            losses: Losses::default(),
            gaps: Gaps::default(),
            published: None,
            times: TimeGaps::default(),
            damage: Damage::default(),
            lost: LostFrames::default(),
            in_full: true,
            messages: 0,
            done: false,
        };
        reader.begin()?;
        Ok(reader)
    }

    /// Reads on to the first frame, for its shape.
    fn begin(&mut self) -> Result<(), Error> {
        self.ahead = self.read_grid()?;
        let Some(ahead) = &self.ahead else {
            return Err(self.no_frame());
        };
        self.start = Some(ahead.log_time);
        let (rows, columns) = match &ahead.grid {
            Ok(grid) => (grid.rows(), grid.column_count as usize),
            Err(_) => (0, 0),
        };
        let taxels = rows.saturating_mul(columns);
        if taxels == 0 || taxels > MAX_TAXELS {
            return Err(Error::Size {
                file: self.path.clone(),
                rows,
                columns,
                limit: MAX_TAXELS,
            });
        }
        self.shape = (rows, columns);
        if self.about.is_empty() {
            self.about = sought::about(&self.path, self.index.as_ref());
        }
        Ok(())
    }

    /// Why there is none.
    fn no_frame(&self) -> Error {
        let file = self.path.clone();
        if self.damage.cut {
            let bytes = self.scanner.position();
            return Error::RecordingCut {
                file,
                frames: 0,
                bytes,
            };
        }
        // Of another program's recording, damaged or not, the topics that it has say more.
        if self.topics.counts().is_some() && !self.damage.is_none() {
            let what = format!("{}; no frame is left", self.damage.words().join("; "));
            return Error::RecordingDamaged { file, what };
        }
        Error::NoCounts {
            file,
            found: self.topics.names(),
        }
    }

    /// The sensor file that the recording carries.
    pub fn sensor_toml(&self) -> Option<&str> {
        self.about.get("sensor_toml").map(String::as_str)
    }

    /// The program that wrote it, and its version.
    pub fn program(&self) -> Option<&str> {
        self.about.get("program").map(String::as_str)
    }

    /// Where its frames came from: the address of a sensor, as the program was given it.
    pub fn source(&self) -> Option<&str> {
        self.about.get("source").map(String::as_str)
    }

    /// How long the recording is, seconds, and its frames; `None` where it has no index (it was cut off).
    pub fn extent(&self) -> Option<(f64, u64)> {
        let index = self.index.as_ref()?;
        let frames = index.messages(self.topics.counts()?)?;
        Some((index.secs(index.statistics.message_end_time), frames))
    }

    /// When the host had the frame read last.
    pub fn host_time(&self) -> SystemTime {
        self.host
    }

    /// The number that the device gave the frame read last, of 32 bits; `None` in recordings of other programs.
    pub fn device_number(&self) -> Option<u32> {
        self.number.filter(|_| self.topics.is_own())
    }

    /// What was lost while it was recorded, as far as it was read.
    pub fn losses(&self) -> &Losses {
        &self.losses
    }

    /// After a jump: nothing of the old place counts any more.
    pub(super) fn forget_place(&mut self) {
        (self.content, self.number, self.done) = (None, None, false);
        self.lost = LostFrames::default();
        self.in_full = false;
        self.damage.cut = false;
        self.events.clear();
    }

    /// Reads on to the next message of the counts; `None` at the end.
    pub(super) fn read_grid(&mut self) -> Result<Option<Ahead>, Error> {
        loop {
            if let Some((content, mut at)) = self.content.take() {
                let mut records = Records(&content[at..]);
                if let Some((opcode, body)) = records.next() {
                    at = content.len() - records.0.len();
                    let ahead = match parse::record(opcode, body) {
                        Some(record) => self.take(record),
                        None => {
                            self.damage.records += 1;
                            None
                        }
                    };
                    self.content = Some((content, at));
                    if ahead.is_some() {
                        return Ok(ahead);
                    }
                }
                continue;
            }
            let found = self.scanner.next().map_err(|source| Error::Read {
                file: self.path.clone(),
                bytes: self.scanner.position(),
                source,
            })?;
            match self.take_found(found)? {
                Step::On => {}
                Step::Frame(ahead) => return Ok(Some(ahead)),
                Step::End => return Ok(None),
            }
        }
    }

    fn take_found(&mut self, found: Found) -> Result<Step, Error> {
        match found {
            Found::Chunk(content) => {
                self.lost.chunk(false);
                self.content = Some((content, 0));
            }
            Found::LostChunk => {
                self.lost.chunk(true);
                self.damage.chunks += 1;
                self.number = None;
            }
            Found::Lost { bytes } => {
                self.damage.bytes += bytes;
                self.number = None;
            }
            Found::Unreadable => self.damage.records += 1,
            Found::Record(Record::MessageIndex(index)) => {
                self.lost.index(index.channel_id, index.records.len());
            }
            Found::Record(record) => {
                if let Some(ahead) = self.take(record) {
                    return Ok(Step::Frame(ahead));
                }
            }
            Found::NotMcap => {
                return Err(Error::NotMcap {
                    file: self.path.clone(),
                    found: sought::beginning(&self.path),
                });
            }
            Found::TooLarge { bytes } => {
                return Err(Error::RecordSize {
                    file: self.path.clone(),
                    found: bytes,
                    limit: MAX_RECORD as u64,
                });
            }
            Found::Packing(found) => {
                return Err(Error::ChunkPacking {
                    file: self.path.clone(),
                    found,
                });
            }
            Found::End => {
                self.compare();
                return Ok(Step::End);
            }
            Found::Cut { bytes } => {
                self.damage.cut = true;
                self.damage.bytes += bytes;
                return Ok(Step::End);
            }
        }
        Ok(Step::On)
    }

    /// Holds what was found against what the file says of itself.
    fn compare(&mut self) {
        self.count_lost();
        if !self.in_full {
            return;
        }
        self.damage.checksum = self.scanner.sum_is_right == Some(false);
        let counts = self.topics.counts();
        let stated = self.index.as_ref().zip(counts);
        if let Some(stated) = stated.and_then(|(index, counts)| index.messages(counts)) {
            self.damage.frames = stated.saturating_sub(self.messages);
        }
    }

    /// Frames of lost chunks keep their places.
    fn count_lost(&mut self) {
        let waiting = self
            .topics
            .counts()
            .map(|counts| self.lost.waiting.remove(&counts));
        if let Some(frames) = waiting.flatten() {
            self.frames += frames;
            self.damage.frames += frames;
        }
    }

    fn take(&mut self, record: Record) -> Option<Ahead> {
        self.topics.take(&record);
        match record {
            Record::Metadata(metadata) if !parse::is_sealed(&metadata.metadata) => {
                self.damage.records += 1;
            }
            Record::Metadata(metadata) if metadata.name == METADATA => {
                self.about = metadata.metadata;
            }
            Record::Metadata(metadata) if metadata.name == losses::NAME => {
                self.losses = Losses::from_metadata(&metadata.metadata);
            }
            Record::Attachment { header, data, .. } if header.name == tare::NAME => {
                match Tare::from_attachment(header.log_time, &data) {
                    Some(tare) => self.tare = Some(tare),
                    None => self.damage.records += 1,
                }
            }
            Record::Message { header, data } => {
                self.topics.meet(header.channel_id, &data);
                if Some(header.channel_id) == self.topics.counts() {
                    self.messages += 1;
                    return Some(Ahead {
                        grid: Grid::read_from(&data),
                        log_time: header.log_time,
                        publish_time: header.publish_time,
                        number: header.sequence,
                    });
                }
                if self.topics.is_event(header.channel_id) {
                    self.take_event(header.log_time, &data);
                }
            }
            _ => {}
        }
        None
    }

    fn take_event(&mut self, log_time: u64, data: &[u8]) {
        let json = match data.len() {
            0..=EVENT_BYTES => serde_json::from_slice::<EventJson>(data).ok(),
            _ => None,
        };
        let Some(json) = json else {
            self.damage.records += 1;
            return;
        };
        if self.events.len() < EVENTS_WAITING {
            let short = |text: String| text.chars().take(EVENT_TEXT).collect();
            self.events.push(Happened {
                log_time,
                kind: short(json.kind),
                text: short(json.text),
            });
        }
    }
}

// One at a time, on the stack: a box would be an allocation a frame.
#[allow(clippy::large_enum_variant)]
enum Step {
    On,
    Frame(Ahead),
    End,
}
