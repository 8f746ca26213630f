//! Reading the loads of a recording.

use std::collections::HashSet;
use std::fs::File;
use std::path::{Path, PathBuf};

use mcap::records::Record;
use taxel::{Frame, Mark};

use super::LOADS;
use super::grid::Grid;
use super::parse::{self, Records};
use super::scan::{Found, MAX_RECORD, Scanner};
use super::sought;
use super::topics::topic_of;
use crate::error::Error;
use crate::integrity::{Damage, Integrity};
use crate::options::ReadOptions;
use crate::source::{FrameSource, Skipped, fill_marked, mark_of, open_file};

/// Reads the loads that were recorded beside the counts: newtons, with their marks, as they stand in the file (what a
/// tare took off is taken off).
///
/// What is missing is told by [`FrameSource::integrity`], and at the end by [`Error::RecordingDamaged`] where the options
/// do not accept it.
pub struct LoadsReader {
    path: PathBuf,
    scanner: Scanner<File>,
    /// The chunk that is being read, and how far.
    content: Option<(Vec<u8>, usize)>,
    /// The channels that carry loads, and all that were declared.
    loads: HashSet<u16>,
    known: HashSet<u16>,
    options: ReadOptions,
    frames: u64,
    start: Option<u64>,
    damage: Damage,
    done: bool,
}

/// A message of loads: when the device had it, and what.
struct Message {
    publish_time: u64,
    data: Vec<u8>,
}

impl LoadsReader {
    /// Opens a recording of the shape that `options` give.
    ///
    /// # Errors
    /// [`Error::Open`]. That it is no recording, or one without loads, is told with the first frame.
    pub fn open(path: impl AsRef<Path>, options: ReadOptions) -> Result<Self, Error> {
        let path = path.as_ref().to_owned();
        let (file, total) = open_file(&path)?;
        Ok(Self {
            path,
            scanner: Scanner::new(file, total),
            content: None,
            loads: HashSet::new(),
            known: HashSet::new(),
            options,
            frames: 0,
            start: None,
            damage: Damage::default(),
            done: false,
        })
    }

    /// The next message of loads in the chunk that is being read.
    fn next_in_chunk(&mut self) -> Option<Message> {
        let (content, mut at) = self.content.take()?;
        let mut message = None;
        while message.is_none() {
            let mut records = Records(&content[at..]);
            let (opcode, body) = records.next()?;
            at = content.len() - records.0.len();
            match parse::record(opcode, body) {
                Some(record) => message = self.take(record),
                None => self.damage.records += 1,
            }
        }
        self.content = Some((content, at));
        message
    }

    /// Reads on to the next message of loads; `None` at the end.
    fn next_message(&mut self) -> Result<Option<Message>, Error> {
        loop {
            if let Some(message) = self.next_in_chunk() {
                return Ok(Some(message));
            }
            let found = self.scanner.next().map_err(|source| Error::Read {
                file: self.path.clone(),
                bytes: self.scanner.position(),
                source,
            })?;
            let file = || self.path.clone();
            match found {
                Found::Chunk(content) => self.content = Some((content, 0)),
                Found::LostChunk => self.damage.chunks += 1,
                Found::Lost { bytes } => self.damage.bytes += bytes,
                Found::Unreadable => self.damage.records += 1,
                Found::Record(record) => {
                    if let Some(message) = self.take(record) {
                        return Ok(Some(message));
                    }
                }
                Found::End => return Ok(None),
                Found::Cut { bytes } => {
                    self.damage.cut = true;
                    self.damage.bytes += bytes;
                    return Ok(None);
                }
                Found::NotMcap => {
                    let found = sought::beginning(&self.path);
                    return Err(Error::NotMcap {
                        file: file(),
                        found,
                    });
                }
                Found::TooLarge { bytes: found } => {
                    let limit = MAX_RECORD as u64;
                    return Err(Error::RecordSize {
                        file: file(),
                        found,
                        limit,
                    });
                }
                Found::Packing(found) => {
                    return Err(Error::ChunkPacking {
                        file: file(),
                        found,
                    });
                }
            }
        }
    }

    fn take(&mut self, record: Record) -> Option<Message> {
        match record {
            Record::Channel(channel) => {
                self.known.insert(channel.id);
                if channel.topic == LOADS {
                    self.loads.insert(channel.id);
                }
            }
            Record::Message { header, data } => {
                // Where the record of its channel is lost, by what it holds.
                if self.known.insert(header.channel_id) && topic_of(&data) == Some(LOADS) {
                    self.loads.insert(header.channel_id);
                }
                if self.loads.contains(&header.channel_id) {
                    return Some(Message {
                        publish_time: header.publish_time,
                        data: data.into_owned(),
                    });
                }
            }
            _ => {}
        }
        None
    }

    fn fill<Q>(&mut self, message: &Message, frame: &mut Frame<Q>) -> Result<(), Error> {
        let (rows, columns) = (self.options.rows, self.options.columns);
        let wrong = |reason: String| Error::Message {
            file: self.path.clone(),
            frame: self.frames,
            reason,
        };
        let grid = Grid::read_from(&message.data).map_err(&wrong)?;
        grid.check_shape(
            (rows, columns),
            self.options.transpose,
            &self.path,
            self.frames,
        )?;
        let read = |name: &str| {
            let mut numbers = vec![0.0; rows * columns];
            let field = grid.field(name)?;
            grid.read(field, &mut numbers).then_some(numbers)
        };
        let newtons = read("newtons").ok_or_else(|| wrong("a grid without newtons".to_owned()))?;
        let codes = read("mark").unwrap_or_else(|| vec![0.0; rows * columns]);
        if let Some(code) = codes.iter().find(|code| mark_of(**code).is_none()) {
            let most = Mark::ALL.len() - 1;
            return Err(wrong(format!("mark {code}, expected 0 to {most}")));
        }
        let transpose = self.options.transpose;
        fill_marked(frame, (rows, columns), transpose, &newtons, &codes);
        let first = *self.start.get_or_insert(message.publish_time);
        let since = i128::from(message.publish_time) - i128::from(first);
        (frame.sequence, frame.time_secs) = (self.frames, Some(since as f64 * 1e-9));
        Ok(())
    }

    fn at_end(&self) -> Result<(), Error> {
        let file = self.path.clone();
        if !(self.damage.is_none() || self.options.accept_damage || self.options.keep_going) {
            let what = self.damage.words().join("; ");
            return Err(Error::RecordingDamaged { file, what });
        }
        match self.frames {
            0 => Err(Error::NoLoads { file }),
            _ => Ok(()),
        }
    }
}

impl<Q> FrameSource<Q> for LoadsReader {
    fn shape(&self) -> (usize, usize) {
        (self.options.rows, self.options.columns)
    }

    fn next_into(&mut self, frame: &mut Frame<Q>) -> Result<bool, Error> {
        if self.done {
            return Ok(false);
        }
        // Nothing follows an error.
        self.done = true;
        let Some(message) = self.next_message()? else {
            return self.at_end().map(|()| false);
        };
        self.fill(&message, frame)?;
        self.frames += 1;
        self.done = false;
        Ok(true)
    }

    fn skipped(&self) -> usize {
        0
    }
    fn skips(&self) -> &[Skipped] {
        &[]
    }
    fn bytes_read(&self) -> u64 {
        self.scanner.position()
    }
    fn bytes_total(&self) -> Option<u64> {
        self.scanner.total()
    }
    fn integrity(&self) -> Integrity {
        Integrity {
            damage: self.damage,
            ..Integrity::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mcap::grid::Numeric;
    use prost::Message as _;
    use taxel::Newtons;

    #[test]
    fn a_mark_that_is_not_known_is_an_error_and_never_good() {
        let file = tempfile::NamedTempFile::new().unwrap();
        let mut reader = LoadsReader::open(file.path(), ReadOptions::new(1, 2)).unwrap();
        let fields = [("newtons", Numeric::Float32), ("mark", Numeric::Uint8)];
        let mut read = |code: u8| {
            let mut grid = Grid::new(2, [1.0, 1.0], &fields);
            for (load, code) in [(1.5f32, 0), (2.5, code)] {
                grid.data.extend(load.to_le_bytes());
                grid.data.push(code);
            }
            let message = Message {
                publish_time: 0,
                data: grid.encode_to_vec(),
            };
            let mut frame = Frame::<Newtons>::zeros(1, 2);
            reader.fill(&message, &mut frame).map(|()| frame)
        };
        let frame = read(9).unwrap();
        assert_eq!(frame.values(), [1.5, 2.5]);
        assert_eq!(frame.marks(), [Mark::Good, Mark::Unfamiliar]);
        let error = read(12).unwrap_err();
        assert!(matches!(error, Error::Message { .. }), "{error:?}");
        let words = "cannot be read: mark 12, expected 0 to 11";
        assert!(error.to_string().contains(words), "{error}");
    }
}
