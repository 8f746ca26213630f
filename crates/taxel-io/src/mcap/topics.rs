//! What a message is, by its channel; and by itself where the record of the channel is lost.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::io::{Seek, Write};

use mcap::records::{Channel, Record};
use mcap::{McapResult, Writer};

use super::grid::{DESCRIPTOR, Grid, SCHEMA};
use super::{COUNTS, EVENTS, FIGURES, LOADS, LOADS_IMAGE, MARKS_IMAGE, WRENCH, ros};

const FIGURES_SCHEMA: &str = r#"{"title":"taxel.FrameFigures","type":"object","properties":{"total_force_newtons":{"type":"number"},"peak_kilopascals":{"type":"number"},"contact_area_mm2":{"type":"number"},"centre_row_mm":{"type":["number","null"]},"centre_column_mm":{"type":["number","null"]},"outlier_share":{"type":"number"},"measured_share":{"type":"number"}}}"#;
const EVENT_SCHEMA: &str = r#"{"title":"taxel.Event","type":"object","properties":{"kind":{"type":"string"},"text":{"type":"string"}}}"#;
/// Topics that a message for something else names.
const NAMED: usize = 20;

/// Which channel carries what.
#[derive(Debug, Clone, Default)]
pub(super) struct Topics {
    /// Whether a schema is that of grids.
    grids: HashMap<u16, bool>,
    events: HashSet<u16>,
    /// The channel that carries the counts, and whether it has the name for them.
    counts: Option<(u16, bool)>,
    names: Vec<String>,
    known: HashSet<u16>,
}

impl Topics {
    /// Takes a record of a schema or a channel; others say nothing.
    pub fn take(&mut self, record: &Record) {
        match record {
            Record::Schema { header, .. } => {
                self.grids.insert(header.id, header.name == SCHEMA);
            }
            Record::Channel(channel) => self.take_channel(channel),
            _ => {}
        }
    }

    fn take_channel(&mut self, channel: &Channel) {
        if self.known.insert(channel.id) && self.names.len() < NAMED {
            self.names.push(channel.topic.chars().take(100).collect());
        }
        let grid = self.grids.get(&channel.schema_id) == Some(&true);
        let own = channel.topic == COUNTS;
        let first = self.counts.is_none();
        if grid && channel.message_encoding == "protobuf" && (own || first) {
            self.counts = Some((channel.id, own));
        }
        if channel.topic == EVENTS {
            self.events.insert(channel.id);
        }
    }

    /// Of a message whose channel is unknown: by what it holds.
    pub fn meet(&mut self, channel: u16, data: &[u8]) {
        if self.known.contains(&channel) {
            return;
        }
        match topic_of(data) {
            Some(COUNTS) => self.counts = Some((channel, true)),
            Some(EVENTS) => {
                self.events.insert(channel);
            }
            _ => {}
        }
        self.known.insert(channel);
    }

    pub fn counts(&self) -> Option<u16> {
        self.counts.map(|(channel, _)| channel)
    }

    /// Whether the counts are in this program's own topic.
    pub fn is_own(&self) -> bool {
        self.counts.is_some_and(|(_, own)| own)
    }

    pub fn is_event(&self, channel: u16) -> bool {
        self.events.contains(&channel)
    }

    /// The names there are, for messages.
    pub fn names(&self) -> Vec<String> {
        self.names.clone()
    }
}

/// The topic of this program's messages that such a message is of.
pub(super) fn topic_of(data: &[u8]) -> Option<&'static str> {
    if data.first() == Some(&b'{') {
        let has = |key: &[u8]| memchr::memmem::find(&data[..data.len().min(4096)], key).is_some();
        return match () {
            () if has(b"\"kind\"") => Some(EVENTS),
            () if has(b"\"total_force_newtons\"") => Some(FIGURES),
            () => None,
        };
    }
    let grid = Grid::read_from(data).ok()?;
    let named = |name: &str| grid.fields.iter().any(|field| field.name == name);
    match () {
        () if named("counts") => Some(COUNTS),
        () if named("newtons") => Some(LOADS),
        () => None,
    }
}

/// How a message of ROS 2 is told: its name, the encoding and the text of its schema, its own encoding.
fn ros_message(
    (name, schema): (&'static str, &'static str),
) -> (&'static str, &'static str, &'static [u8], &'static str) {
    (name, "ros2msg", schema.as_bytes(), "cdr")
}

/// Begins one of this program's topics in a file.
pub(super) fn begin<W: Write + Seek>(writer: &mut Writer<W>, topic: &str) -> McapResult<u16> {
    let (name, encoding, schema, message) = match topic {
        COUNTS | LOADS => (SCHEMA, "protobuf", DESCRIPTOR, "protobuf"),
        LOADS_IMAGE | MARKS_IMAGE => ros_message(ros::IMAGE),
        WRENCH => ros_message(ros::WRENCH),
        FIGURES => (
            "taxel.Figures",
            "jsonschema",
            FIGURES_SCHEMA.as_bytes(),
            "json",
        ),
        _ => ("taxel.Event", "jsonschema", EVENT_SCHEMA.as_bytes(), "json"),
    };
    let schema = writer.add_schema(name, encoding, schema)?;
    writer.add_channel(schema, topic, message, &BTreeMap::new())
}
