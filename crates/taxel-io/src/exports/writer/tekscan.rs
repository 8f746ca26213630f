//! Tekscan ASCII: pressures on one sensel area, so that their sum times the area is the force.

use std::fmt::Write as _;

use taxel::frame::{Frame, Newtons};
use taxel::{Mark, Sensor};

use super::{Layout, push_decimal};

pub(super) struct Tekscan {
    /// The header, but for how far apart frames are.
    header: String,
    kilopascals_per_newton: f64,
    /// The first frame, which waits for the second to tell how far apart they are.
    first: Option<(Vec<u8>, f64)>,
    has_begun: bool,
    frames: u64,
}

impl Tekscan {
    pub(super) fn new(sensor: &Sensor, frames: Option<u64>) -> Self {
        let array = sensor.array();
        let [down, across] = array.pitch_mm;
        let mut header = format!(
            "DATA_TYPE MOVIE\r\nVERSION Taxel {}\r\nSENSOR_TYPE {}\r\nROWS {}\r\nCOLS {}\r\nROW_SPACING {down:?} mm\r\nCOL_SPACING {across:?} mm\r\nSENSEL_AREA {:?} mm2\r\nNOISE_THRESHOLD 0\r\n",
            env!("CARGO_PKG_VERSION"),
            one_word(sensor.name()),
            array.rows,
            array.columns,
            array.taxel_area_mm2
        );
        if let Some(frames) = frames {
            // To a String: nothing that could fail.
            let _ = write!(header, "START_FRAME 1\r\nEND_FRAME {frames}\r\n");
        }
        Self {
            header,
            kilopascals_per_newton: 1e3 / array.taxel_area_mm2,
            first: None,
            has_begun: false,
            frames: 0,
        }
    }

    /// The header, and the first frame if there is one.
    fn begin(&mut self, second_secs: Option<f64>, out: &mut Vec<u8>) {
        self.has_begun = true;
        let first = self.first.take();
        let step = second_secs
            .zip(first.as_ref())
            .map(|(second, (_, first))| second - first);
        out.extend_from_slice(self.header.as_bytes());
        if let Some(step) = step.filter(|step| *step > 0.0) {
            out.extend_from_slice(format!("SECONDS_PER_FRAME {step:?}\r\n").as_bytes());
        }
        out.extend_from_slice(
            b"UNITS KPa\r\nMIRROR_ROW 0\r\nMIRROR_COL 0\r\nASCII_DATA @@\r\n\r\n",
        );
        if let Some((frame, _)) = first {
            out.extend_from_slice(&frame);
        }
    }

    fn put(&mut self, loads: &Frame<Newtons>, secs: f64, out: &mut Vec<u8>) {
        self.frames += 1;
        out.extend_from_slice(format!("Frame {}, {secs:?}\r\n", self.frames).as_bytes());
        let rows = loads.values().chunks_exact(loads.columns());
        for (row, marks) in rows.zip(loads.marks().chunks_exact(loads.columns())) {
            for (at, (&load, mark)) in row.iter().zip(marks).enumerate() {
                if at > 0 {
                    out.push(b',');
                }
                match mark {
                    Mark::Absent => out.push(b'B'),
                    _ => push_decimal(out, self.kilopascals_per_newton * load),
                }
            }
            out.extend_from_slice(b"\r\n");
        }
        out.extend_from_slice(b"\r\n");
    }
}

/// A name without what a reader could take for another key or for a frame.
fn one_word(name: &str) -> String {
    let plain = |c: char| {
        if c.is_ascii_alphanumeric() || "-_.".contains(c) {
            c
        } else {
            '_'
        }
    };
    let word: String = name.chars().map(plain).collect();
    let word = word.replace("Frame", "frame").replace("UNITS", "units");
    if word.is_empty() {
        "taxel".to_owned()
    } else {
        word
    }
}

impl Layout for Tekscan {
    fn frame(&mut self, loads: &Frame<Newtons>, secs: f64, out: &mut Vec<u8>) {
        if !self.has_begun && self.first.is_none() {
            let mut first = Vec::new();
            self.put(loads, secs, &mut first);
            self.first = Some((first, secs));
            return;
        }
        if !self.has_begun {
            self.begin(Some(secs), out);
        }
        self.put(loads, secs, out);
    }

    fn end(&mut self, out: &mut Vec<u8>) {
        if !self.has_begun {
            self.begin(None, out);
        }
        out.extend_from_slice(b"@@\r\n");
    }
}
