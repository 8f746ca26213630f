//! XDF (github.com/sccn/xdf, specification 1.0): chunks of a length, a tag and content; XML headers; little-endian samples.
//!
//! Stream 1 has the loads, a channel a taxel, row by row, in newtons (NaN: not measured); stream 2 a text for each frame with marks.

use std::fmt::Write as _;

use taxel::frame::{Frame, Newtons};
use taxel::metric::is_usable;
use taxel::{Mark, Sensor};

use super::Layout;

const LOADS: u32 = 1;
const MARKS: u32 = 2;
const FILE_HEADER: u16 = 1;
const STREAM_HEADER: u16 = 2;
const SAMPLES: u16 = 3;
const STREAM_FOOTER: u16 = 6;

pub(super) struct Xdf {
    /// What stands before the frames, until it is written.
    head: Option<Vec<u8>>,
    streams: [Stream; 2],
    content: Vec<u8>,
}

/// What a stream's last chunk tells.
#[derive(Default, Clone, Copy)]
struct Stream {
    samples: u64,
    secs: Option<(f64, f64)>,
}

impl Stream {
    fn add(&mut self, secs: f64) {
        self.samples += 1;
        self.secs = Some((self.secs.map_or(secs, |(first, _)| first), secs));
    }
}

impl Xdf {
    pub(super) fn new(sensor: &Sensor) -> Self {
        let mut head = b"XDF:".to_vec();
        chunk(
            &mut head,
            FILE_HEADER,
            b"<?xml version=\"1.0\"?><info><version>1.0</version></info>",
        );
        for (id, xml) in [(LOADS, loads_header(sensor)), (MARKS, marks_header(sensor))] {
            let content = [&id.to_le_bytes()[..], xml.as_bytes()].concat();
            chunk(&mut head, STREAM_HEADER, &content);
        }
        Self {
            head: Some(head),
            streams: [Stream::default(); 2],
            content: Vec::new(),
        }
    }
}

impl Layout for Xdf {
    fn frame(&mut self, loads: &Frame<Newtons>, secs: f64, out: &mut Vec<u8>) {
        if let Some(head) = self.head.take() {
            out.extend_from_slice(&head);
        }
        self.content.clear();
        begin_samples(&mut self.content, LOADS, secs);
        for (&load, mark) in loads.values().iter().zip(loads.marks()) {
            let value = if is_usable(*mark) {
                load as f32
            } else {
                f32::NAN
            };
            self.content.extend_from_slice(&value.to_le_bytes());
        }
        chunk(out, SAMPLES, &self.content);
        self.streams[0].add(secs);
        let text = marks_of(loads);
        if !text.is_empty() {
            self.content.clear();
            begin_samples(&mut self.content, MARKS, secs);
            length(&mut self.content, text.len() as u64);
            self.content.extend_from_slice(text.as_bytes());
            chunk(out, SAMPLES, &self.content);
            self.streams[1].add(secs);
        }
    }

    fn end(&mut self, out: &mut Vec<u8>) {
        if let Some(head) = self.head.take() {
            out.extend_from_slice(&head);
        }
        for (id, stream) in [LOADS, MARKS].into_iter().zip(self.streams) {
            let (first, last) = stream.secs.unwrap_or_default();
            let xml = format!(
                "<?xml version=\"1.0\"?><info><first_timestamp>{first}</first_timestamp><last_timestamp>{last}</last_timestamp><sample_count>{}</sample_count><clock_offsets></clock_offsets></info>",
                stream.samples
            );
            let content = [&id.to_le_bytes()[..], xml.as_bytes()].concat();
            chunk(out, STREAM_FOOTER, &content);
        }
    }
}

/// One sample with its time.
fn begin_samples(content: &mut Vec<u8>, stream: u32, secs: f64) {
    content.extend_from_slice(&stream.to_le_bytes());
    length(content, 1);
    content.push(8);
    content.extend_from_slice(&secs.to_le_bytes());
}

/// A number of things, with the number of its bytes before it.
fn length(out: &mut Vec<u8>, count: u64) {
    match (u8::try_from(count), u32::try_from(count)) {
        (Ok(count), _) => out.extend_from_slice(&[1, count]),
        (_, Ok(count)) => {
            out.push(4);
            out.extend_from_slice(&count.to_le_bytes());
        }
        _ => {
            out.push(8);
            out.extend_from_slice(&count.to_le_bytes());
        }
    }
}

fn chunk(out: &mut Vec<u8>, tag: u16, content: &[u8]) {
    length(out, content.len() as u64 + 2);
    out.extend_from_slice(&tag.to_le_bytes());
    out.extend_from_slice(content);
}

/// What is not good in a frame: `r3c4 stuck, r3c5 stuck`.
fn marks_of(loads: &Frame<Newtons>) -> String {
    let mut text = String::new();
    for (at, mark) in loads.marks().iter().enumerate() {
        if !matches!(mark, Mark::Good | Mark::Absent) {
            let comma = if text.is_empty() { "" } else { ", " };
            let (row, column) = (at / loads.columns(), at % loads.columns());
            // To a String: nothing that could fail.
            let _ = write!(text, "{comma}r{row}c{column} {}", mark.word());
        }
    }
    text
}

fn stream_header(sensor: &Sensor, kind: &str, channels: usize, format: &str, desc: &str) -> String {
    format!(
        "<?xml version=\"1.0\"?><info><name>{}</name><type>{kind}</type><channel_count>{channels}</channel_count><nominal_srate>0</nominal_srate><channel_format>{format}</channel_format><created_at>0</created_at><desc>{desc}</desc></info>",
        escaped(sensor.name())
    )
}

fn loads_header(sensor: &Sensor) -> String {
    let (rows, columns) = (sensor.rows(), sensor.columns());
    let mut desc = String::from("<channels>");
    let [down, across] = sensor.array().pitch_mm;
    for at in 0..rows * columns {
        let (row, column) = (at / columns, at % columns);
        let [x, y] = match sensor.positions() {
            Some(places) => places[at],
            None => [across * column as f64, down * row as f64],
        };
        // To a String: nothing that could fail.
        let _ = write!(
            desc,
            "<channel><label>r{row}c{column}</label><unit>N</unit><type>Force</type><location><X>{x}</X><Y>{y}</Y></location></channel>"
        );
    }
    let _ = write!(
        desc,
        "</channels><encoding><width>{columns}</width><height>{rows}</height><color_format>GRAY</color_format></encoding><acquisition><manufacturer>Taxel</manufacturer><model>{}</model></acquisition><taxel>{}</taxel>",
        escaped(sensor.name()),
        escaped(&sensor.to_toml())
    );
    stream_header(sensor, "Pressure", rows * columns, "float32", &desc)
}

fn marks_header(sensor: &Sensor) -> String {
    stream_header(sensor, "Markers", 1, "string", "")
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}
