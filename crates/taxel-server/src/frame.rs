//! A frame on its way to viewers.

use std::sync::OnceLock;
use std::time::{SystemTime, UNIX_EPOCH};

use axum::body::Bytes;

/// Version of the binary message.
const VERSION: u8 = 2;
const HEADER: usize = 68;

/// What viewers see of one frame. On the wire it is bytes, laid out as docs/formats.md says; `decodeFrame` in the page's
/// `wire.js` reads them.
#[derive(Debug, Clone, Default)]
#[non_exhaustive]
pub struct FrameMessage {
    /// Sensed lines.
    pub rows: usize,
    /// Driven lines.
    pub columns: usize,
    /// Loads are newtons; else conductances in siemens.
    pub is_load: bool,
    /// A tare is taken off.
    pub is_tared: bool,
    /// `loads` are by the method `raw`: no cross-talk is removed.
    pub is_raw: bool,
    /// Counts up by one a frame.
    pub sequence: u64,
    /// Device time, s.
    pub device_secs: Option<f64>,
    /// When the frame was complete.
    pub at: Option<SystemTime>,
    /// Total force, newtons.
    pub total_newtons: f64,
    /// The largest grip force along any direction, newtons; `None` of a sensor that is no handle.
    pub grip_newtons: Option<f64>,
    /// Peak pressure, kPa.
    pub peak_kilopascals: f64,
    /// Contact area, mm².
    pub contact_area_mm2: f64,
    /// Centre of pressure in rows and columns.
    pub centre: Option<[f64; 2]>,
    /// Share of the taxels that do not count.
    pub outlier_share: f64,
    /// Frames a second of the source.
    pub frames_per_second: f64,
    /// Counts, row by row.
    pub counts: Vec<u16>,
    /// Loads by the load law on readings as they are.
    pub raw: Vec<f32>,
    /// Loads with the cross-talk removed.
    pub loads: Vec<f32>,
    /// Codes of the marks.
    pub marks: Vec<u8>,
}

/// A frame that is put into bytes when the first viewer takes it, once for all of them.
pub(crate) struct Sent {
    message: FrameMessage,
    bytes: OnceLock<Bytes>,
}

impl Sent {
    pub(crate) fn new(message: FrameMessage) -> Self {
        Self {
            message,
            bytes: OnceLock::new(),
        }
    }

    pub(crate) fn bytes(&self) -> Bytes {
        self.bytes
            .get_or_init(|| self.message.encode(SystemTime::now()))
            .clone()
    }
}

impl FrameMessage {
    /// A frame of `rows` × `columns` taxels, all of them 0.
    pub fn new(rows: usize, columns: usize) -> Self {
        let taxels = rows * columns;
        Self {
            rows,
            columns,
            counts: vec![0; taxels],
            raw: vec![0.0; taxels],
            loads: vec![0.0; taxels],
            marks: vec![0; taxels],
            ..Self::default()
        }
    }

    /// The message's bytes; its age is that at `now`.
    pub(crate) fn encode(&self, now: SystemTime) -> Bytes {
        let taxels = self.counts.len();
        let mut out = Vec::with_capacity(HEADER + 11 * taxels + 2);
        let flags =
            u16::from(self.is_load) | u16::from(self.is_tared) << 1 | u16::from(self.is_raw) << 2;
        out.extend([1, VERSION]);
        out.extend((self.rows as u16).to_le_bytes());
        out.extend((self.columns as u16).to_le_bytes());
        out.extend(flags.to_le_bytes());
        out.extend(self.sequence.to_le_bytes());
        out.extend(self.device_secs.unwrap_or(f64::NAN).to_le_bytes());
        let since = |at: SystemTime| at.duration_since(UNIX_EPOCH).unwrap_or_default();
        let host_secs = self.at.map_or(f64::NAN, |at| since(at).as_secs_f64());
        out.extend(host_secs.to_le_bytes());
        let age = self.at.and_then(|at| now.duration_since(at).ok());
        let [down, across] = self.centre.unwrap_or([f64::NAN; 2]);
        for number in [
            self.total_newtons,
            self.peak_kilopascals,
            self.contact_area_mm2,
            down,
            across,
            self.outlier_share,
            age.map_or(f64::NAN, |age| 1e3 * age.as_secs_f64()),
            self.frames_per_second,
            self.grip_newtons.unwrap_or(f64::NAN),
        ] {
            out.extend((number as f32).to_le_bytes());
        }
        debug_assert_eq!(out.len(), HEADER);
        out.extend(self.counts.iter().flat_map(|count| count.to_le_bytes()));
        out.resize(out.len().next_multiple_of(4), 0);
        for values in [&self.raw, &self.loads] {
            out.extend(values.iter().flat_map(|value| value.to_le_bytes()));
        }
        out.extend(&self.marks);
        out.into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_message_is_laid_out_as_described() {
        let message = FrameMessage {
            rows: 1,
            columns: 3,
            is_load: true,
            is_raw: true,
            sequence: 7,
            counts: vec![1, 2, 65535],
            raw: vec![0.5, 1.0, 1.5],
            loads: vec![0.25, 0.5, 0.75],
            marks: vec![0, 3, 9],
            total_newtons: 1.5,
            grip_newtons: Some(1.25),
            ..FrameMessage::default()
        };
        let bytes = message.encode(UNIX_EPOCH);
        assert_eq!(bytes.len(), 68 + 6 + 2 + 12 + 12 + 3);
        assert_eq!(&bytes[..8], [1, 2, 1, 0, 3, 0, 5, 0]);
        assert_eq!(bytes[8], 7);
        assert!(f64::from_le_bytes(bytes[16..24].try_into().unwrap()).is_nan());
        assert_eq!(&bytes[32..36], 1.5f32.to_le_bytes());
        assert_eq!(&bytes[64..68], 1.25f32.to_le_bytes());
        assert_eq!(&bytes[72..74], [255, 255]);
        assert_eq!(&bytes[76..80], 0.5f32.to_le_bytes());
        assert_eq!(&bytes[88..92], 0.25f32.to_le_bytes());
        assert_eq!(&bytes[100..], [0, 3, 9]);
    }
}
