//! Recordings as MCAP: raw counts always, the rest on request. Opens in Foxglove unchanged.
//!
//! | topic | message | what |
//! |---|---|---|
//! | `/taxel/counts` | `foxglove.Grid` (protobuf) | counts, one `counts` a cell (uint16) |
//! | `/taxel/loads` | `foxglove.Grid` (protobuf) | `newtons` (float32) and `mark` (uint8) a cell |
//! | `/taxel/figures` | `taxel.FrameFigures` (JSON) | total force, peak, contact area, centre of pressure |
//! | `/taxel/loads/image` | `sensor_msgs/msg/Image` (CDR) | newtons, `32FC1`, NaN where nothing was measured; on request |
//! | `/taxel/marks/image` | `sensor_msgs/msg/Image` (CDR) | codes of the marks, `mono8`; with it |
//! | `/taxel/force` | `geometry_msgs/msg/WrenchStamped` (CDR) | the sum of the loads, along z; with it |
//! | `/taxel/events` | `taxel.Event` (JSON) | tare, marks set by hand, links lost and found |
//!
//! The log time of a message is the host's when the frame was complete; its publish time is the device's clock, set
//! to the host's at the first frame. The metadata record `taxel` holds the sensor file, the program's version and the
//! source; `taxel/losses` what was lost before the file ([`Losses`]); attachments `taxel/tare` what was taken off and
//! from which frame on ([`Tare`]).

mod chunk;
mod grid;
mod index;
mod loads;
mod parse;
mod read;
mod recover;
mod ros;
mod rosbag;
mod scan;
mod sought;
mod tail;
#[cfg(test)]
mod tests;
mod topics;
mod write;

pub use crate::event::Event;
use crate::event::nanos;
pub use crate::losses::Losses;
pub use crate::tare::Tare;
pub use loads::LoadsReader;
pub use read::McapReader;
pub use recover::{Recovered, recover};
pub(crate) use rosbag::RosbagWriter;
pub use write::{About, McapWriter};

/// Topic of the counts.
pub(crate) const COUNTS: &str = "/taxel/counts";
/// Topic of the loads.
const LOADS: &str = "/taxel/loads";
/// Topic of the loads as an image,
const LOADS_IMAGE: &str = "/taxel/loads/image";
/// of their marks,
const MARKS_IMAGE: &str = "/taxel/marks/image";
/// and of their sum.
const WRENCH: &str = "/taxel/force";
/// Topic of the figures.
const FIGURES: &str = "/taxel/figures";
/// Topic of the events.
const EVENTS: &str = "/taxel/events";
/// Name of the metadata record.
const METADATA: &str = "taxel";

const MAGIC: &[u8; 8] = b"\x89MCAP0\r\n";
/// DataEnd without a checksum, a footer without a summary, magic: what makes a file whole that has only chunks.
const PLAIN_END: &[u8; 50] = b"\x0f\x04\0\0\0\0\0\0\0\0\0\0\0\
    \x02\x14\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\
    \x89MCAP0\r\n";
