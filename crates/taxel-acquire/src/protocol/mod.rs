//! Bytes to frames of counts, without any input or output: whoever has bytes feeds them, in pieces of any size.
//!
//! | module | protocol |
//! |---|---|
//! | [`taxel1`] | `taxel-1`: binary, COBS and CRC-32, sequence number and device time |
//! | [`lines`] | text lines: a frame a line, or a row a line with its index |
//! | [`econe`] | the e-Cone's text: rows one after the other |
//! | [`auto`] | whichever of them the first bytes look like |
//!
//! [formats.md] describes them byte by byte.
//!
//! [formats.md]: https://github.com/taxel/taxel/blob/main/docs/formats.md

pub mod auto;
pub mod econe;
mod fields;
pub mod lines;
mod order;
pub mod taxel1;

use std::fmt;
use std::time::Duration;

use taxel::{Counts, Frame, Sensor};

/// Frames and what became of them.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct LinkStats {
    /// Whole frames handed on.
    pub frames: u64,
    /// Frames that never came, by their sequence numbers.
    pub lost: u64,
    /// Frames that came broken.
    pub corrupt: u64,
    /// Frames that came again, or too late.
    pub repeated: u64,
    /// Times the device began to count anew.
    pub restarts: u64,
    /// Lines that are no frame and no try at one: comments, greetings.
    pub passed_over: u64,
    /// Times that the link broke or the device fell silent, and came back.
    pub outages: u64,
    /// Packets of other senders or other sensors.
    pub strangers: u64,
}

impl LinkStats {
    /// What came after `before`.
    pub fn since(&self, before: &Self) -> Self {
        self.with(before, u64::saturating_sub)
    }

    /// Both together.
    pub fn and(&self, other: &Self) -> Self {
        self.with(other, u64::saturating_add)
    }

    fn with(&self, other: &Self, both: impl Fn(u64, u64) -> u64) -> Self {
        Self {
            frames: both(self.frames, other.frames),
            lost: both(self.lost, other.lost),
            corrupt: both(self.corrupt, other.corrupt),
            repeated: both(self.repeated, other.repeated),
            restarts: both(self.restarts, other.restarts),
            passed_over: both(self.passed_over, other.passed_over),
            outages: both(self.outages, other.outages),
            strangers: both(self.strangers, other.strangers),
        }
    }

    /// What went wrong, each with its count, in words: `3 lost`, `1 restart of the device`. Lines passed over are no
    /// trouble.
    pub fn troubles(&self) -> Vec<String> {
        let named = [
            (self.lost, "lost", "lost"),
            (self.corrupt, "corrupt", "corrupt"),
            (self.repeated, "repeated", "repeated"),
            (
                self.restarts,
                "restart of the device",
                "restarts of the device",
            ),
            (self.outages, "outage", "outages"),
            (self.strangers, "from another sender", "from other senders"),
        ];
        let found = named.into_iter().filter(|(count, ..)| *count > 0);
        found
            .map(|(count, one, many)| format!("{count} {}", if count == 1 { one } else { many }))
            .collect()
    }
}

/// Why something that came was no frame.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum FrameFault {
    /// Checksum, framing or packing.
    Broken {
        /// What, in words.
        what: &'static str,
    },
    /// A frame of another array.
    Shape {
        /// Rows and columns that came.
        found: (usize, usize),
        /// Rows and columns of the sensor.
        expected: (usize, usize),
    },
    /// A line with another number of fields than a frame or a row has.
    Fields {
        /// Numbers on the line.
        found: usize,
        /// Columns of the sensor.
        columns: usize,
        /// Taxels of the sensor.
        taxels: usize,
    },
    /// A count that the converter cannot give.
    Range {
        /// The count.
        found: u64,
        /// The converter's largest.
        largest: u64,
    },
    /// Another version of `taxel-1`.
    Version {
        /// The version that came.
        found: u8,
    },
    /// A packet of another sensor than the one that is listened to.
    Sensor {
        /// Its id.
        found: u16,
        /// The id that is listened to.
        expected: u16,
    },
    /// A frame that ended before its last row.
    Rows {
        /// Rows that came.
        found: usize,
        /// Rows of the sensor.
        expected: usize,
    },
}

impl fmt::Display for FrameFault {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Broken { what } => write!(f, "a broken frame: {what}"),
            Self::Shape { found, expected } => write!(
                f,
                "frames of {} x {} taxels, but the sensor has {} x {}",
                found.0, found.1, expected.0, expected.1
            ),
            Self::Fields {
                found,
                columns,
                taxels,
            } => write!(
                f,
                "a line of {found} numbers, but a row has {columns} (with its index {}), a frame {taxels}",
                columns + 1
            ),
            Self::Range { found, largest } => {
                write!(
                    f,
                    "a count of {found}, but the converter's largest is {largest}"
                )
            }
            Self::Version { found } => {
                write!(f, "taxel-{found}, but this program reads taxel-1")
            }
            Self::Sensor { found, expected } => {
                write!(
                    f,
                    "frames of sensor {found} beside those of sensor {expected}"
                )
            }
            Self::Rows { found, expected } => {
                write!(f, "a frame of {found} rows, but the sensor has {expected}")
            }
        }
    }
}

/// What a protocol needs to know of the sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Expected {
    /// Sensed lines.
    pub rows: usize,
    /// Driven lines.
    pub columns: usize,
    /// The converter's largest count.
    pub max_count: u64,
}

impl Expected {
    /// Frames of this sensor.
    pub fn of(sensor: &Sensor) -> Self {
        Self {
            rows: sensor.rows(),
            columns: sensor.columns(),
            max_count: sensor.max_count() as u64,
        }
    }

    fn taxels(&self) -> usize {
        self.rows * self.columns
    }

    fn frame(&self) -> Frame<Counts> {
        Frame::zeros(self.rows, self.columns)
    }
}

/// Bytes in, frames out. No bytes make it panic or take more memory than a frame needs.
pub trait Decoder: Send {
    /// Takes the next bytes; hands on every frame that they complete. Its sequence number counts on through restarts
    /// of the device; its time is the device's, where it tells.
    fn feed(&mut self, bytes: &[u8], take: &mut dyn FnMut(&Frame<Counts>));

    /// The link broke, or was silent for long: what has begun will not be completed, and counts as a broken frame.
    fn forget(&mut self);

    /// What is fed next came as a datagram of its own, so long after the one before. Datagrams can be lost: one that is
    /// late does not go on with the frame that was begun.
    fn datagram(&mut self, _after: Duration) {}

    /// What has come so far.
    fn link_stats(&self) -> LinkStats;

    /// The last thing that was no frame.
    fn last_fault(&self) -> Option<&FrameFault>;

    /// The protocol's name.
    fn name(&self) -> &'static str;
}

/// Which protocol a device speaks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Protocol {
    /// What the first bytes look like.
    #[default]
    Auto,
    /// `taxel-1`.
    Taxel1,
    /// Text lines.
    Lines,
    /// The e-Cone's text.
    EconeText,
}

impl Protocol {
    /// Every protocol with its name in an address.
    pub const NAMES: [(&'static str, Protocol); 4] = [
        ("auto", Protocol::Auto),
        ("taxel-1", Protocol::Taxel1),
        ("lines", Protocol::Lines),
        ("econe-text", Protocol::EconeText),
    ];

    /// A decoder for it.
    pub fn decoder(self, expected: Expected) -> Box<dyn Decoder> {
        match self {
            Protocol::Auto => Box::new(auto::Auto::new(expected)),
            Protocol::Taxel1 => Box::new(taxel1::Taxel1::new(expected)),
            Protocol::Lines => Box::new(lines::Lines::new(expected)),
            Protocol::EconeText => Box::new(econe::EconeText::new(expected)),
        }
    }
}

#[cfg(test)]
mod tests;
