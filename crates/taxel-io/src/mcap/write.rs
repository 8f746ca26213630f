//! Writing, so that whatever happens the file can be read.

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant, SystemTime};

use mcap::records::{MessageHeader, Metadata};
use mcap::{Compression, WriteOptions, Writer};
use prost::Message;
use serde::Serialize;
use taxel::metric::FrameFigures;
use taxel::{Counts, Frame, Newtons, Sensor};

use super::grid::{Grid, Numeric};
use super::parse::seal;
use super::tail::{State, Tail};
use super::{
    COUNTS, EVENTS, FIGURES, LOADS, LOADS_IMAGE, Losses, MARKS_IMAGE, METADATA, Tare, WRENCH,
    nanos, ros, topics,
};
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

/// Figures as they stand in a message; a number that is none is null.
#[derive(Serialize)]
struct FiguresJson {
    total_force_newtons: f64,
    peak_kilopascals: f64,
    contact_area_mm2: f64,
    centre_row_mm: Option<f64>,
    centre_column_mm: Option<f64>,
    outlier_share: f64,
    measured_share: f64,
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
    /// What was lost so far, and what of it the file says already.
    losses: [Losses; 2],
    /// Of the file.
    state: Arc<State>,
    /// What it says about itself, to be said again: the format has no checksum for it.
    about: Metadata,
    chunks: u64,
    /// It appears only when it is whole.
    only_whole: bool,
    /// The frame of reference of images of the loads, where these are written.
    images: Option<String>,
}

impl About {
    fn to_metadata(&self) -> Metadata {
        let metadata = [
            ("sensor_toml", self.sensor.to_toml()),
            ("program", self.program.clone()),
            ("source", self.source.clone()),
        ];
        let owned = metadata.map(|(key, value)| (key.to_owned(), value));
        let mut metadata = BTreeMap::from(owned);
        seal(&mut metadata);
        Metadata {
            name: METADATA.to_owned(),
            metadata,
        }
    }
}

impl McapWriter {
    /// Begins a recording, which is there under its name from its first frame of counts on: without one it leaves
    /// nothing. An existing file is never overwritten.
    ///
    /// # Errors
    /// [`Error::Create`], [`Error::Write`].
    pub fn create(path: impl AsRef<Path>, about: &About) -> Result<Self, Error> {
        let path = path.as_ref().to_owned();
        Self::begin(Tail::straight(&path, u64::MAX)?, path, about)
    }

    /// Begins a recording that appears under its name only with [`Self::finish`]; let go before, it leaves nothing.
    /// For what can be done again, as a conversion.
    ///
    /// # Errors
    /// [`Error::Create`], [`Error::Write`].
    pub fn create_at_once(path: impl AsRef<Path>, about: &About) -> Result<Self, Error> {
        let path = path.as_ref().to_owned();
        let mut writer = Self::begin(Tail::once(&path)?, path, about)?;
        writer.only_whole = true;
        Ok(writer)
    }

    /// The same, in place of an older file of the name once it is whole. For what is made again from the same recording.
    ///
    /// # Errors
    /// As [`Self::create_at_once`].
    pub fn replace_at_once(path: impl AsRef<Path>, about: &About) -> Result<Self, Error> {
        let path = path.as_ref().to_owned();
        let mut writer = Self::begin(Tail::once_instead(&path)?, path, about)?;
        writer.only_whole = true;
        Ok(writer)
    }

    /// With the loads goes what ROS 2 and others know: loads and marks as images, the total as a wrench, in the frame of reference
    /// `frame_id`. As large again as the loads.
    #[must_use]
    pub fn with_images(mut self, frame_id: &str) -> Self {
        self.images = Some(frame_id.to_owned());
        self
    }

    pub(super) fn begin(tail: Tail, path: PathBuf, about: &About) -> Result<Self, Error> {
        let array = about.sensor.array();
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
            losses: [Losses::default(); 2],
            state: tail.state(),
            about: about.to_metadata(),
            chunks: 0,
            only_whole: false,
            images: None,
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
            writer.write_metadata(&recording.about)?;
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
        if self.frames == 1 && !self.only_whole {
            self.state.has_frames();
            return self.flush();
        }
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
        self.put(LOADS, frame.sequence, log_time, publish_time)?;
        let Some(frame_id) = self.images.take() else {
            return Ok(());
        };
        let written = self.write_images(frame, &frame_id, log_time, publish_time);
        self.images = Some(frame_id);
        written
    }

    fn write_images(
        &mut self,
        frame: &Frame<Newtons>,
        frame_id: &str,
        log_time: u64,
        publish_time: u64,
    ) -> Result<(), Error> {
        ros::loads_image(&mut self.message, frame, log_time, frame_id);
        self.put(LOADS_IMAGE, frame.sequence, log_time, publish_time)?;
        ros::marks_image(&mut self.message, frame, log_time, frame_id);
        self.put(MARKS_IMAGE, frame.sequence, log_time, publish_time)?;
        ros::total_wrench(&mut self.message, frame, log_time, frame_id);
        self.put(WRENCH, frame.sequence, log_time, publish_time)
    }

    /// Appends the figures of a frame.
    ///
    /// # Errors
    /// As [`Self::write_counts`].
    pub fn write_figures(
        &mut self,
        figures: &FrameFigures,
        sequence: u64,
        at: SystemTime,
    ) -> Result<(), Error> {
        let json = FiguresJson {
            total_force_newtons: figures.total_force_newtons,
            peak_kilopascals: figures.peak_kilopascals,
            contact_area_mm2: figures.contact_area_mm2,
            centre_row_mm: figures.centre_mm.map(|centre| centre[0]),
            centre_column_mm: figures.centre_mm.map(|centre| centre[1]),
            outlier_share: figures.outlier_share,
            measured_share: figures.measured_share,
        };
        self.message.clear();
        // Numbers become numbers, and what is none becomes null; there is nothing that could fail.
        let _ = serde_json::to_writer(&mut self.message, &json);
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

    /// Says what was lost so far, all in all; it goes to the file with the next chunk, and the last word counts.
    pub fn set_losses(&mut self, losses: Losses) {
        self.losses[0] = losses;
    }

    /// Appends a tare, which applies to the frames that are written after it.
    ///
    /// # Errors
    /// As [`Self::write_counts`].
    pub fn write_tare(&mut self, tare: &Tare) -> Result<(), Error> {
        let mut writer = self.take_writer()?;
        let result = writer.attach(&tare.to_attachment());
        self.settle(writer, result)?;
        self.flush()
    }

    /// Closes the chunk if it is old enough: to be called now and then while nothing comes.
    ///
    /// # Errors
    /// As [`Self::write_counts`].
    pub fn flush_if_due(&mut self) -> Result<(), Error> {
        // What appears only when it is whole loses nothing with the program, and is the same however long it took.
        if !self.only_whole && self.flushed.elapsed() > FLUSH_EVERY {
            self.flush()
        } else {
            Ok(())
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
        let Some(mut writer) = self.writer.take() else {
            return Ok(());
        };
        let ended = writer.write_metadata(&self.about);
        match ended.and_then(|()| writer.finish()) {
            Ok(_) => writer.into_inner().finish(),
            Err(error) => Err(self.fail(writer, error)),
        }
    }

    pub(super) fn flush(&mut self) -> Result<(), Error> {
        self.flushed = Instant::now();
        let Some(mut writer) = self.writer.take() else {
            return Ok(());
        };
        let mut result = writer.flush();
        let [losses, told] = self.losses;
        if losses != told {
            result = result.and_then(|()| writer.write_metadata(&losses.to_metadata()));
        }
        if self.chunks == 1 {
            // Once more behind the first frames: if the beginning is damaged, the sensor is still known.
            result = result.and_then(|()| writer.write_metadata(&self.about));
        }
        self.settle(writer, result)?;
        self.losses[1] = losses;
        self.chunks += 1;
        let at = self.state.bytes();
        if at > self.whole[0].0 {
            self.whole = [(at, self.frames), self.whole[0]];
        }
        Ok(())
    }

    fn put(
        &mut self,
        topic: &'static str,
        sequence: u64,
        log_time: u64,
        publish_time: u64,
    ) -> Result<(), Error> {
        let mut writer = self.take_writer()?;
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

    fn take_writer(&mut self) -> Result<Writer<Tail>, Error> {
        let ended = || io::Error::from(io::ErrorKind::BrokenPipe).into();
        self.writer.take().ok_or_else(|| self.error(ended()))
    }

    /// The topic's channel, begun when it is first needed.
    fn channel(&mut self, writer: &mut Writer<Tail>, topic: &'static str) -> mcap::McapResult<u16> {
        if let Some(channel) = self.topics.get(topic) {
            return Ok(*channel);
        }
        let channel = topics::begin(writer, topic)?;
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
            Err(error) => Err(self.fail(writer, error)),
        }
    }

    /// Makes the file whole without the writer.
    fn fail(&mut self, writer: Writer<Tail>, error: mcap::McapError) -> Error {
        // Not just dropped: that would try to write the index once more. And by the file that is open: another may
        // have its name by now.
        let with_frames = self.whole.iter().filter(|(_, frames)| *frames > 0);
        let whole: Vec<(u64, u64)> = with_frames.copied().collect();
        let lengths: Vec<u64> = whole.iter().map(|(length, _)| *length).collect();
        match writer.into_inner().make_whole(&lengths) {
            Some(place) => self.frames = whole[place].1,
            // It never came to have its name.
            None if whole.is_empty() => self.frames = 0,
            None => {}
        }
        self.error(error)
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
            // Another file got the name between the beginning and the first frame.
            mcap::McapError::Io(source) if source.kind() == io::ErrorKind::AlreadyExists => {
                return Error::creating(&self.path, source);
            }
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
    /// A recording that is let go is finished: its frames are worth more than the reason. Not so one that can be made
    /// again.
    fn drop(&mut self) {
        let Some(mut writer) = self.writer.take() else {
            return;
        };
        if self.only_whole {
            drop(writer.into_inner());
            return;
        }
        let ended = writer.write_metadata(&self.about);
        if let Err(error) = ended.and_then(|()| writer.finish()) {
            self.fail(writer, error);
        }
    }
}
