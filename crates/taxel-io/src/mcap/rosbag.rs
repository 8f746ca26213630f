//! A bag of ROS 2: an MCAP file of its profile that holds what ROS knows and nothing else, for `ros2 bag` and rosbags, which read no
//! file with other messages in it.

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};

use mcap::records::MessageHeader;
use mcap::{Compression, WriteOptions, Writer};
use taxel::{Frame, Newtons};

use super::tail::Tail;
use super::{LOADS_IMAGE, MARKS_IMAGE, WRENCH, ros};
use crate::error::Error;

/// Of the channels, what rosbag2 keeps with each: no requests for quality of service.
const QOS: (&str, &str) = ("offered_qos_profiles", "");

/// Loads and marks as images, the total as a wrench. The file appears with [`RosbagWriter::finish`].
pub(crate) struct RosbagWriter {
    path: PathBuf,
    writer: Writer<Tail>,
    channels: [u16; 3],
    frame_id: String,
    message: Vec<u8>,
    frames: u64,
}

impl RosbagWriter {
    /// Begins the file; `frame_id` names the frame of reference.
    pub(crate) fn create(path: &Path, frame_id: &str) -> Result<Self, Error> {
        let options = WriteOptions::new()
            .profile("ros2")
            .library(concat!("taxel ", env!("CARGO_PKG_VERSION")))
            .compression(Some(Compression::Zstd))
            .compression_level(1)
            .compression_threads(0)
            .disable_seeking(true);
        let begun = options.create(Tail::once(path)?);
        let mut writer = begun.map_err(|error| failed(path, 0, error))?;
        let channels = channels(&mut writer).map_err(|error| failed(path, 0, error))?;
        Ok(Self {
            path: path.to_owned(),
            writer,
            channels,
            frame_id: frame_id.to_owned(),
            message: Vec::new(),
            frames: 0,
        })
    }

    /// Appends a frame that was read at so many nanoseconds.
    pub(crate) fn write(&mut self, loads: &Frame<Newtons>, nanos: u64) -> Result<(), Error> {
        let encode = [ros::loads_image, ros::marks_image, ros::total_wrench];
        for (channel_id, encode) in self.channels.into_iter().zip(encode) {
            encode(&mut self.message, loads, nanos, &self.frame_id);
            let header = MessageHeader {
                channel_id,
                sequence: self.frames as u32,
                log_time: nanos,
                publish_time: nanos,
            };
            let written = self.writer.write_to_known_channel(&header, &self.message);
            written.map_err(|error| failed(&self.path, self.frames, error))?;
        }
        self.frames += 1;
        Ok(())
    }

    /// Writes the index and gives the file its name.
    pub(crate) fn finish(mut self) -> Result<(), Error> {
        let ended = self.writer.finish();
        ended.map_err(|error| failed(&self.path, self.frames, error))?;
        self.writer.into_inner().finish()
    }
}

fn channels(writer: &mut Writer<Tail>) -> mcap::McapResult<[u16; 3]> {
    let image = writer.add_schema(ros::IMAGE.0, "ros2msg", ros::IMAGE.1.as_bytes())?;
    let wrench = writer.add_schema(ros::WRENCH.0, "ros2msg", ros::WRENCH.1.as_bytes())?;
    let about = BTreeMap::from([(QOS.0.to_owned(), QOS.1.to_owned())]);
    let mut channel = |schema, topic| writer.add_channel(schema, topic, "cdr", &about);
    Ok([
        channel(image, LOADS_IMAGE)?,
        channel(image, MARKS_IMAGE)?,
        channel(wrench, WRENCH)?,
    ])
}

fn failed(path: &Path, frames: u64, error: mcap::McapError) -> Error {
    let source = match error {
        mcap::McapError::Io(source) => source,
        other => io::Error::other(other),
    };
    Error::Recording {
        file: path.to_owned(),
        frames,
        source,
    }
}
