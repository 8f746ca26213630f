//! Bytes to frames of counts, without any input or output: whoever has bytes feeds them, in pieces of any size.
//!
//! | module | protocol |
//! |---|---|
//! | [`taxel1`] | `taxel-1`: binary, COBS and CRC-32, sequence number and device time |
//! | [`lines`] | text lines: a frame a line, or a row a line with its index |
//! | [`econe`] | the e-Cone's text: rows one after the other |
//! | [`row_text`] | text for people: a row a line behind `3:`, `Row 3:`, `R3` |
//! | [`flexitac`] | FlexiTac's bytes: a marker that the counts may repeat |
//! | [`wiresens`] | WiReSens' packets of some counts each |
//! | [`insole`] | the open insole's datagrams: the taxels there are, and which foot |
//! | [`auto`] | whichever of them the first bytes look like |
//!
//! [formats.md] describes them byte by byte.
//!
//! [formats.md]: https://github.com/taxel/taxel/blob/main/docs/formats.md

pub mod auto;
pub mod econe;
mod fields;
pub mod flexitac;
pub mod insole;
pub mod lines;
mod order;
pub mod row_text;
pub mod taxel1;
pub mod wiresens;

use std::fmt;
use std::time::Duration;

use taxel::{Counts, Frame, Sensor};

pub use insole::Foot;

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
    /// A frame of another length.
    Length {
        /// Bytes that came, marker and all.
        found: usize,
        /// Bytes that one of the sensor has.
        expected: usize,
        /// Taxels of the sensor.
        taxels: usize,
    },
    /// Counts of fewer bits than the converter's.
    Width {
        /// The largest that can come.
        found: u64,
        /// The converter's largest.
        expected: u64,
    },
    /// A packet of the other foot than the one that is listened to: left, right.
    Foot {
        /// Whose came.
        found: &'static str,
        /// Whose is listened to.
        expected: &'static str,
    },
    /// A row that the sensor does not have.
    Index {
        /// Its index, from 0 on.
        found: usize,
        /// Rows of the sensor.
        rows: usize,
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
            Self::Length {
                found,
                expected,
                taxels,
            } => write!(
                f,
                "frames of {found} bytes, but the sensor's {taxels} taxels make {expected}"
            ),
            Self::Width { found, expected } => write!(
                f,
                "counts of at most {found}, but the sensor's converter gives up to {expected}: its bits are those that are sent"
            ),
            Self::Foot { found, expected } => {
                write!(
                    f,
                    "frames of the {found} foot beside those of the {expected} one"
                )
            }
            Self::Index { found, rows } => write!(
                f,
                "a row with index {found}, but the sensor's {rows} rows count from 0 to {}",
                rows - 1
            ),
            Self::Rows { found, expected } => {
                write!(f, "a frame of {found} rows, but the sensor has {expected}")
            }
        }
    }
}

/// What a protocol needs to know of the sensor.
#[derive(Debug, Clone, PartialEq)]
pub struct Expected {
    /// Sensed lines.
    pub rows: usize,
    /// Driven lines.
    pub columns: usize,
    /// The converter's largest count.
    pub max_count: u64,
    /// Of every crossing, row by row, whether it has no taxel; empty where each has one.
    pub absent: Vec<bool>,
}

impl Expected {
    /// Frames of this sensor.
    pub fn of(sensor: &Sensor) -> Self {
        Self {
            rows: sensor.rows(),
            columns: sensor.columns(),
            max_count: sensor.max_count() as u64,
            absent: sensor.absent().to_vec(),
        }
    }

    /// Crossings, with a taxel or without.
    fn taxels(&self) -> usize {
        self.rows * self.columns
    }

    fn is_absent(&self, taxel: usize) -> bool {
        self.absent.get(taxel).copied().unwrap_or(false)
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
    /// Rows behind their index, as people read them.
    RowText,
    /// FlexiTac's bytes.
    FlexiTac,
    /// WiReSens' packets.
    WiReSens,
    /// The open insole's datagrams.
    Insole(Foot),
}

impl Protocol {
    /// Every protocol with its name in an address.
    pub const NAMES: [(&'static str, Protocol); 10] = [
        ("auto", Protocol::Auto),
        ("taxel-1", Protocol::Taxel1),
        ("lines", Protocol::Lines),
        ("econe-text", Protocol::EconeText),
        ("row-text", Protocol::RowText),
        ("flexitac", Protocol::FlexiTac),
        ("wiresens", Protocol::WiReSens),
        ("insole-udp", Protocol::Insole(Foot::First)),
        ("insole-udp-left", Protocol::Insole(Foot::Left)),
        ("insole-udp-right", Protocol::Insole(Foot::Right)),
    ];

    /// A decoder for it.
    pub fn decoder(self, expected: Expected) -> Box<dyn Decoder> {
        match self {
            Protocol::Auto => Box::new(auto::Auto::new(expected)),
            Protocol::Taxel1 => Box::new(taxel1::Taxel1::new(expected)),
            Protocol::Lines => Box::new(lines::Lines::new(expected)),
            Protocol::EconeText => Box::new(econe::EconeText::new(expected)),
            Protocol::RowText => Box::new(row_text::RowText::new(expected)),
            Protocol::FlexiTac => Box::new(flexitac::FlexiTac::new(expected)),
            Protocol::WiReSens => Box::new(wiresens::WiReSens::new(expected)),
            Protocol::Insole(foot) => Box::new(insole::Insole::new(expected, foot)),
        }
    }

    /// Whether only the ends of datagrams tell where its frames end.
    pub fn needs_datagrams(self) -> bool {
        matches!(self, Protocol::Insole(_))
    }
}

#[cfg(test)]
mod tests;
