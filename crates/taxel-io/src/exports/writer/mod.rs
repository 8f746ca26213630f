//! Loads written as other programs read them.
//!
//! | module | read by |
//! |---|---|
//! | [`tekscan`] | what reads Tekscan ASCII: pressures, kPa |
//! | [`rsscan`] | what reads RSscan text: newtons a taxel |
//! | [`xdf`] | what reads XDF (pyxdf, EEGLAB, MNE): newtons, with times, marks and the sensor file |
//! | `rosbag` of [`crate::mcap`] | `ros2 bag`, rosbags: loads and marks as images, the total as a wrench |
//! | [`plain`] | spreadsheets and statistics: a line a frame, a column a taxel, newtons |

mod plain;
mod rsscan;
mod tekscan;
mod xdf;

use std::path::Path;
use std::str::FromStr;

use taxel::metric::is_usable;
use taxel::{Frame, Mark, Newtons, Sensor};

use crate::atomic::AtomicFile;
use crate::error::Error;
use crate::mcap::RosbagWriter;
use crate::options::extension;

/// A format that other programs read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum ExportFormat {
    /// Tekscan ASCII, kPa.
    Tekscan,
    /// RSscan text, newtons.
    RsScan,
    /// XDF, newtons.
    Xdf,
    /// A bag of ROS 2, newtons.
    Ros2,
    /// A line a frame, a column a taxel, newtons.
    Table,
}

impl ExportFormat {
    /// All of them.
    pub const ALL: [Self; 5] = [
        Self::Tekscan,
        Self::RsScan,
        Self::Xdf,
        Self::Ros2,
        Self::Table,
    ];

    /// Its word.
    pub fn word(self) -> &'static str {
        match self {
            Self::Tekscan => "tekscan",
            Self::RsScan => "rsscan",
            Self::Xdf => "xdf",
            Self::Ros2 => "ros2",
            Self::Table => "table",
        }
    }

    /// The format that a file's ending tells: `.asf`, `.xdf`.
    pub fn of_ending(file: &Path) -> Option<Self> {
        match extension(file).as_str() {
            "asf" => Some(Self::Tekscan),
            "xdf" => Some(Self::Xdf),
            _ => None,
        }
    }
}

impl FromStr for ExportFormat {
    type Err = String;

    fn from_str(word: &str) -> Result<Self, String> {
        let known = Self::ALL.iter().find(|format| format.word() == word);
        known
            .copied()
            .ok_or_else(|| "must be tekscan, rsscan, xdf, ros2 or table".to_owned())
    }
}

/// What a format could not hold of what was written.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub struct ExportLosses {
    /// Loads below nothing, which is noise about an unloaded taxel, written as 0; and what they add up to, newtons.
    pub below_zero: u64,
    /// See [`Self::below_zero`].
    pub below_zero_newtons: f64,
    /// What all loads add up to, newtons.
    pub newtons: f64,
    /// Taxels that were not measured, written as 0.
    pub unmeasured: u64,
}

impl ExportLosses {
    /// What whoever reads the file has to know, one sentence each; nothing where it holds all.
    pub fn words(&self) -> Vec<String> {
        let mut words = Vec::new();
        if self.below_zero > 0 {
            let share =
                100.0 * self.below_zero_newtons.abs() / self.newtons.abs().max(f64::MIN_POSITIVE);
            words.push(format!(
                "{} loads below nothing were written as 0, since the format has none: sums of the file are {share:.2} % larger than those of the loads",
                self.below_zero
            ));
        }
        if self.unmeasured > 0 {
            words.push(format!(
                "{} taxels that were not measured were written as 0, since the format has no marks",
                self.unmeasured
            ));
        }
        words
    }
}

/// How one format is written.
trait Layout: Send {
    /// Everything that a frame of loads (newtons, at `secs`) adds to the file, behind what stands in `out` already.
    fn frame(&mut self, loads: &Frame<Newtons>, secs: f64, out: &mut Vec<u8>);

    /// What closes the file.
    fn end(&mut self, out: &mut Vec<u8>);
}

/// Writes loads as another program reads them.
pub struct ExportWriter {
    sink: Sink,
    /// Whether it has neither loads below nothing nor marks.
    is_poor: bool,
    losses: ExportLosses,
}

enum Sink {
    /// Bytes one after the other.
    Stream {
        file: AtomicFile,
        layout: Box<dyn Layout>,
        bytes: Vec<u8>,
    },
    Bag(Box<RosbagWriter>),
}

impl ExportWriter {
    /// Begins the file, which appears with [`ExportWriter::commit`]. `frames`: how many there will be, where that is known.
    ///
    /// # Errors
    /// [`Error::Create`].
    pub fn create(
        file: &Path,
        format: ExportFormat,
        sensor: &Sensor,
        frames: Option<u64>,
    ) -> Result<Self, Error> {
        let layout: Option<Box<dyn Layout>> = match format {
            ExportFormat::Tekscan => Some(Box::new(tekscan::Tekscan::new(sensor, frames))),
            ExportFormat::RsScan => Some(Box::new(rsscan::RsScan::default())),
            ExportFormat::Xdf => Some(Box::new(xdf::Xdf::new(sensor))),
            ExportFormat::Table => Some(Box::new(plain::Plain::new(sensor))),
            ExportFormat::Ros2 => None,
        };
        Ok(Self {
            sink: match layout {
                Some(layout) => Sink::Stream {
                    file: AtomicFile::create(file)?,
                    layout,
                    bytes: Vec::new(),
                },
                None => Sink::Bag(Box::new(RosbagWriter::create(file, sensor.name())?)),
            },
            is_poor: matches!(format, ExportFormat::Tekscan | ExportFormat::RsScan),
            losses: ExportLosses::default(),
        })
    }

    /// Appends a frame of loads, read at so many seconds.
    ///
    /// # Errors
    /// [`Error::Write`].
    pub fn write(&mut self, loads: &Frame<Newtons>, secs: f64) -> Result<(), Error> {
        if self.is_poor {
            self.count_losses(loads);
        }
        match &mut self.sink {
            Sink::Stream {
                file,
                layout,
                bytes,
            } => {
                bytes.clear();
                layout.frame(loads, secs, bytes);
                file.put(bytes)
            }
            Sink::Bag(bag) => bag.write(loads, (1e9 * secs.max(0.0)).round() as u64),
        }
    }

    fn count_losses(&mut self, loads: &Frame<Newtons>) {
        for (&load, &mark) in loads.values().iter().zip(loads.marks()) {
            self.losses.newtons += load;
            if load < 0.0 {
                self.losses.below_zero += 1;
                self.losses.below_zero_newtons += load;
            }
            let is_there = mark != Mark::Absent;
            self.losses.unmeasured += u64::from(is_there && !is_usable(mark));
        }
    }

    /// Finishes the file and gives it its name; what it could not hold.
    ///
    /// # Errors
    /// [`Error::Write`].
    pub fn commit(self) -> Result<ExportLosses, Error> {
        match self.sink {
            Sink::Stream {
                mut file,
                mut layout,
                mut bytes,
            } => {
                bytes.clear();
                layout.end(&mut bytes);
                file.put(&bytes)?;
                file.commit()?;
            }
            Sink::Bag(bag) => bag.finish()?,
        }
        Ok(self.losses)
    }
}

/// Ten thousandths: the last decimal that is written of a load or a pressure.
const PARTS: f64 = 1e4;

/// Appends a number of 0 or more (what is below is 0) with at most four decimals, and no zeros that say nothing.
fn push_decimal(out: &mut Vec<u8>, value: f64) {
    let parts = (value.max(0.0) * PARTS).round() as u64;
    let mut buffer = itoa::Buffer::new();
    out.extend_from_slice(buffer.format(parts / 10_000).as_bytes());
    let mut rest = parts % 10_000;
    if rest == 0 {
        return;
    }
    let mut digits = 4;
    while rest.is_multiple_of(10) {
        rest /= 10;
        digits -= 1;
    }
    out.push(b'.');
    let text = buffer.format(rest);
    out.resize(out.len() + digits - text.len(), b'0');
    out.extend_from_slice(text.as_bytes());
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn decimals_read_back(parts in 0u64..10_000_000_000) {
            let value = parts as f64 / PARTS;
            let mut text = Vec::new();
            push_decimal(&mut text, value);
            let text = String::from_utf8(text).unwrap();
            prop_assert_eq!(text.parse::<f64>().unwrap(), value);
            prop_assert!(!text.contains('.') || !text.ends_with('0'), "{}", text);
        }
    }
}
