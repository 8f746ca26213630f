//! The tare as a part of a recording: what was taken off, and from when on.

use std::time::{Duration, SystemTime};

use mcap::Attachment;

/// Name of the attachment.
pub(crate) const NAME: &str = "taxel/tare";
const MEDIA_TYPE: &str = "application/json";

/// What each taxel shows without load, taken off from a frame on; or that nothing is taken off any more.
#[derive(Debug, Clone, PartialEq)]
pub struct Tare {
    /// The device's number of the first frame that it applies to.
    pub from_sequence: u64,
    /// When it was taken, by the host's clock.
    pub at: SystemTime,
    /// Unit of the numbers: `N`, or `S` where the sensor has no load law.
    pub unit: String,
    /// What is taken off the compensated numbers, a taxel each, row by row; empty: nothing any more.
    pub loads: Vec<f64>,
    /// What is taken off the numbers that are not compensated; empty where that is unknown.
    pub raw: Vec<f64>,
}

impl Tare {
    /// That nothing is taken off from that frame on.
    pub fn undone(from_sequence: u64, at: SystemTime) -> Self {
        Self {
            from_sequence,
            at,
            unit: "N".to_owned(),
            loads: Vec::new(),
            raw: Vec::new(),
        }
    }

    /// Whether it takes nothing off.
    pub fn is_undone(&self) -> bool {
        self.loads.is_empty()
    }

    pub(crate) fn to_attachment(&self) -> Attachment<'static> {
        let log_time = crate::event::nanos(self.at);
        let json = serde_json::json!({
            "from_sequence": self.from_sequence,
            "unit": self.unit,
            "loads": self.loads,
            "raw": self.raw,
        });
        Attachment {
            log_time,
            create_time: log_time,
            name: NAME.to_owned(),
            media_type: MEDIA_TYPE.to_owned(),
            data: json.to_string().into_bytes().into(),
        }
    }

    /// Of an attachment's data; `None` where it is no tare.
    pub(crate) fn from_attachment(log_time: u64, data: &[u8]) -> Option<Self> {
        let json: serde_json::Value = serde_json::from_slice(data).ok()?;
        let numbers = |key: &str| -> Option<Vec<f64>> {
            json[key].as_array()?.iter().map(|n| n.as_f64()).collect()
        };
        Some(Self {
            from_sequence: json["from_sequence"].as_u64()?,
            at: SystemTime::UNIX_EPOCH + Duration::from_nanos(log_time),
            unit: json["unit"].as_str()?.to_owned(),
            loads: numbers("loads")?,
            raw: numbers("raw")?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tare_comes_back_to_the_last_digit() {
        let at = SystemTime::UNIX_EPOCH + Duration::from_nanos(1_795_000_000_123_456_789);
        let tare = Tare {
            from_sequence: 4_294_967_299,
            at,
            unit: "N".to_owned(),
            loads: vec![0.1 + 0.2, -1e-300, 3.0],
            raw: vec![1.0 / 3.0; 3],
        };
        for tare in [tare, Tare::undone(7, at)] {
            let attached = tare.to_attachment();
            let back = Tare::from_attachment(attached.log_time, &attached.data);
            assert_eq!(back.as_ref(), Some(&tare));
        }
        assert_eq!(Tare::from_attachment(0, b"{\"loads\": 3}"), None);
    }
}
