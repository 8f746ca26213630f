//! Writing, so that whatever happens the file can be read.

use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime};

use mcap::records::{MessageHeader, Metadata};
use mcap::{Compression, WriteOptions, Writer};
use prost::Message;
use taxel::metric::Figures;
use taxel::{Counts, Frame, Newtons, Sensor};

use super::grid::{DESCRIPTOR, Grid, Numeric, SCHEMA};
use super::{COUNTS, EVENTS, FIGURES, LOADS, METADATA, PLAIN_END};
use crate::error::Error;
use crate::rows::check_counts;

/// A chunk is closed when it is this old: no more than this, and the time to write it, is lost with the program.
const FLUSH_EVERY: Duration = Duration::from_millis(500);
/// Or when it is this large: the file's index, which grows in memory with every chunk, stays small.
const CHUNK_BYTES: u64 = 1 << 23;

/// What a recording says about itself.
#[derive(Debug, Clone)]
pub struct About {
    /// The sensor; written as sensor.toml.
    pub sensor: Sensor,
    /// Name and version of the program.
    pub program: String,
    /// Where the frames come from.
    pub source: String,
}

/// A file that counts its bytes and knows up to where it is whole.
struct Tail {
    file: File,
    at: u64,
    room: u64,
}

impl Write for Tail {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.at + bytes.len() as u64 > self.room {
            return Err(io::ErrorKind::StorageFull.into());
        }
        let count = self.file.write(bytes)?;
        self.at += count as u64;
        Ok(count)
    }
    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

impl Seek for Tail {
    /// Tells where it is; the writer, told not to seek, asks for nothing else.
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        match to {
            SeekFrom::Current(0) => Ok(self.at),
            _ => Err(io::ErrorKind::NotSeekable.into()),
        }
    }
}

/// A recording being written. Chunks go to the file whole, every half second; a program that is killed loses what
/// came since, and [`super::recover`] makes the rest a whole file again.
pub struct McapWriter {
    path: PathBuf,
    writer: Option<Writer<Tail>>,
    counts: Grid,
    loads: Grid,
    topics: BTreeMap<&'static str, u16>,
    message: Vec<u8>,
    flushed: Instant,
    /// Up to where the file is whole and the frames until there, now and one chunk before.
    whole: [(u64, u64); 2],
    /// Device time zero on the host's clock, ns.
    anchor: Option<(i128, f64)>,
    frames: u64,
}

impl McapWriter {
    /// Begins a recording. An existing file is never overwritten.
    ///
    /// # Errors
    /// [`Error::Create`], [`Error::Write`].
    pub fn create(path: impl AsRef<Path>, about: &About) -> Result<Self, Error> {
        Self::begin(path.as_ref().to_owned(), about, u64::MAX)
    }

    /// `room`: bytes after which the disk is taken to be full.
    pub(super) fn begin(path: PathBuf, about: &About, room: u64) -> Result<Self, Error> {
        let file = OpenOptions::new().write(true).create_new(true).open(&path);
        let file = file.map_err(|source| Error::Create {
            file: path.clone(),
            source,
        })?;
        let tail = Tail { file, at: 0, room };
        let array = &about.sensor.array;
        let mut recording = Self {
            writer: None,
            counts: Grid::new(
                array.columns,
                array.pitch_mm,
                &[("counts", Numeric::Uint16)],
            ),
            loads: Grid::new(
                array.columns,
                array.pitch_mm,
                &[("newtons", Numeric::Float32), ("mark", Numeric::Uint8)],
            ),
            path,
            topics: BTreeMap::new(),
            message: Vec::new(),
            flushed: Instant::now(),
            whole: [(0, 0); 2],
            anchor: None,
            frames: 0,
        };
        let options = WriteOptions::new()
            .profile("taxel")
            .library(&about.program)
            .compression(Some(Compression::Zstd))
            .compression_level(1)
            .compression_threads(0)
            .chunk_size(Some(CHUNK_BYTES))
            .disable_seeking(true);
        let begun = options.create(tail).and_then(|mut writer| {
            let metadata = [
                ("sensor_toml", about.sensor.to_toml()),
                ("program", about.program.clone()),
                ("source", about.source.clone()),
            ];
            writer.write_metadata(&Metadata {
                name: METADATA.to_owned(),
                metadata: metadata
                    .into_iter()
                    .map(|(key, value)| (key.to_owned(), value))
                    .collect(),
            })?;
            Ok(writer)
        });
        match begun {
            Ok(writer) => recording.writer = Some(writer),
            Err(error) => return Err(recording.error(error)),
        }
        recording.flush()?;
        Ok(recording)
    }

    /// Appends a frame of counts that was complete at `at`.
    ///
    /// # Errors
    /// [`Error::Write`]: the file is then whole up to the chunk before, and nothing more can be written.
    pub fn write_counts(&mut self, frame: &Frame<Counts>, at: SystemTime) -> Result<(), Error> {
        let log_time = nanos(at);
        let publish_time = self.device_nanos(frame.time_secs, log_time);
        self.counts.data.clear();
        check_counts(
            frame,
            &self.path,
            "MCAP recordings hold raw counts, whole numbers of up to 16 bits; averaged recordings keep their fractions in .npy",
        )?;
        for &count in frame.values() {
            self.counts.data.extend((count as u16).to_le_bytes());
        }
        self.counts.set_time(log_time);
        self.message.clear();
        self.counts.encode_raw(&mut self.message);
        self.put(COUNTS, frame.sequence, log_time, publish_time)?;
        self.frames += 1;
        self.flush_if_due()
    }

    /// Appends the loads of a frame.
    ///
    /// # Errors
    /// As [`Self::write_counts`].
    pub fn write_loads(&mut self, frame: &Frame<Newtons>, at: SystemTime) -> Result<(), Error> {
        let log_time = nanos(at);
        let publish_time = self.device_nanos(frame.time_secs, log_time);
        self.loads.data.clear();
        for (&load, mark) in frame.values().iter().zip(frame.marks()) {
            self.loads.data.extend((load as f32).to_le_bytes());
            self.loads.data.push(mark.code());
        }
        self.loads.set_time(log_time);
        self.message.clear();
        self.loads.encode_raw(&mut self.message);
        self.put(LOADS, frame.sequence, log_time, publish_time)
    }

    /// Appends the figures of a frame.
    ///
    /// # Errors
    /// As [`Self::write_counts`].
    pub fn write_figures(
        &mut self,
        figures: &Figures,
        sequence: u64,
        at: SystemTime,
    ) -> Result<(), Error> {
        let [down, across] = match figures.centre_mm {
            Some(centre) => centre.map(|mm| format!("{mm:.4}")),
            None => ["null".to_owned(), "null".to_owned()],
        };
        let json = format!(
            "{{\"total_force_newtons\":{:.5},\"peak_kilopascals\":{:.4},\"contact_area_mm2\":{:.2},\
             \"centre_row_mm\":{down},\"centre_column_mm\":{across},\"outlier_share\":{:.6}}}",
            figures.total_force_newtons,
            figures.peak_kilopascals,
            figures.contact_area_mm2,
            figures.outlier_share
        );
        self.message.clear();
        self.message.extend(json.as_bytes());
        let log_time = nanos(at);
        self.put(FIGURES, sequence, log_time, log_time)
    }

    /// Appends something that happened: `kind` in one word (`tare`, `mark`, `device`), and what in words.
    ///
    /// # Errors
    /// As [`Self::write_counts`].
    pub fn write_event(&mut self, kind: &str, text: &str, at: SystemTime) -> Result<(), Error> {
        let json = serde_json::json!({ "kind": kind, "text": text });
        self.message.clear();
        self.message.extend(json.to_string().as_bytes());
        let log_time = nanos(at);
        self.put(EVENTS, 0, log_time, log_time)?;
        self.flush_if_due()
    }

    /// Closes the chunk if it is old enough: to be called now and then while nothing comes.
    ///
    /// # Errors
    /// As [`Self::write_counts`].
    pub fn flush_if_due(&mut self) -> Result<(), Error> {
        match self.flushed.elapsed() > FLUSH_EVERY {
            true => self.flush(),
            false => Ok(()),
        }
    }

    /// Frames of counts so far.
    pub fn frames(&self) -> u64 {
        self.frames
    }

    /// Bytes of the file so far.
    pub fn bytes(&self) -> u64 {
        self.whole[0].0
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Writes the index and closes the file.
    ///
    /// # Errors
    /// As [`Self::write_counts`].
    pub fn finish(mut self) -> Result<(), Error> {
        self.flush()?;
        if let Some(mut writer) = self.writer.take() {
            let result = writer.finish().map(|_| ());
            self.settle(writer, result)?;
        }
        Ok(())
    }

    pub(super) fn flush(&mut self) -> Result<(), Error> {
        self.flushed = Instant::now();
        if let Some(mut writer) = self.writer.take() {
            let result = writer.flush();
            self.settle(writer, result)?;
            let at = self.position();
            if at > self.whole[0].0 {
                self.whole = [(at, self.frames), self.whole[0]];
            }
        }
        Ok(())
    }

    fn position(&self) -> u64 {
        std::fs::metadata(&self.path).map_or(self.whole[0].0, |about| about.len())
    }

    fn put(
        &mut self,
        topic: &'static str,
        sequence: u64,
        log_time: u64,
        publish_time: u64,
    ) -> Result<(), Error> {
        let Some(mut writer) = self.writer.take() else {
            return Err(self.error(io::Error::from(io::ErrorKind::BrokenPipe).into()));
        };
        let result = self.channel(&mut writer, topic).and_then(|channel_id| {
            let header = MessageHeader {
                channel_id,
                sequence: sequence as u32,
                log_time,
                publish_time,
            };
            writer.write_to_known_channel(&header, &self.message)
        });
        self.settle(writer, result)
    }

    /// The topic's channel, begun when it is first needed.
    fn channel(&mut self, writer: &mut Writer<Tail>, topic: &'static str) -> mcap::McapResult<u16> {
        if let Some(channel) = self.topics.get(topic) {
            return Ok(*channel);
        }
        let (name, encoding, schema, message) = match topic {
            COUNTS | LOADS => (SCHEMA, "protobuf", DESCRIPTOR, "protobuf"),
            FIGURES => (
                "taxel.Figures",
                "jsonschema",
                FIGURES_SCHEMA.as_bytes(),
                "json",
            ),
            _ => ("taxel.Event", "jsonschema", EVENT_SCHEMA.as_bytes(), "json"),
        };
        let schema = writer.add_schema(name, encoding, schema)?;
        let channel = writer.add_channel(schema, topic, message, &BTreeMap::new())?;
        self.topics.insert(topic, channel);
        Ok(channel)
    }

    /// Keeps the writer if all went well; else makes the file whole without it.
    fn settle(&mut self, writer: Writer<Tail>, result: mcap::McapResult<()>) -> Result<(), Error> {
        match result {
            Ok(()) => {
                self.writer = Some(writer);
                Ok(())
            }
            Err(error) => {
                // Not just dropped: that would try to write the index once more.
                drop(writer.into_inner());
                self.make_whole();
                Err(self.error(error))
            }
        }
    }

    /// Cuts off what was half written and ends the file after the last chunk; on a full disk after the one before,
    /// whose room the end then takes.
    fn make_whole(&mut self) {
        for (whole, frames) in self.whole {
            let ended = OpenOptions::new()
                .write(true)
                .open(&self.path)
                .and_then(|mut file| {
                    file.set_len(whole)?;
                    file.seek(SeekFrom::End(0))?;
                    file.write_all(PLAIN_END)?;
                    file.sync_all()
                });
            if ended.is_ok() {
                self.frames = frames;
                return;
            }
        }
    }

    /// The device's clock on the host's: set at the first frame, and again when the device's clock falls back.
    fn device_nanos(&mut self, time_secs: Option<f64>, log_time: u64) -> u64 {
        let Some(secs) = time_secs else {
            return log_time;
        };
        let device = (secs * 1e9).round() as i128;
        let anchor = match self.anchor {
            Some((anchor, last)) if secs >= last => anchor,
            _ => i128::from(log_time) - device,
        };
        self.anchor = Some((anchor, secs));
        (anchor + device).clamp(0, i128::from(u64::MAX)) as u64
    }

    fn error(&self, error: mcap::McapError) -> Error {
        let source = match error {
            mcap::McapError::Io(source) => source,
            other => io::Error::other(other),
        };
        Error::Recording {
            file: self.path.clone(),
            frames: self.frames,
            source,
        }
    }
}

impl Drop for McapWriter {
    /// A recording that is let go is finished: its frames are worth more than the reason.
    fn drop(&mut self) {
        if let Some(mut writer) = self.writer.take()
            && writer.finish().is_err()
        {
            drop(writer.into_inner());
            self.make_whole();
        }
    }
}

fn nanos(at: SystemTime) -> u64 {
    at.duration_since(SystemTime::UNIX_EPOCH)
        .map_or(0, |since| since.as_nanos() as u64)
}

const FIGURES_SCHEMA: &str = r#"{"title":"taxel.Figures","type":"object","properties":{"total_force_newtons":{"type":"number"},"peak_kilopascals":{"type":"number"},"contact_area_mm2":{"type":"number"},"centre_row_mm":{"type":["number","null"]},"centre_column_mm":{"type":["number","null"]},"outlier_share":{"type":"number"}}}"#;
const EVENT_SCHEMA: &str = r#"{"title":"taxel.Event","type":"object","properties":{"kind":{"type":"string"},"text":{"type":"string"}}}"#;
