//! What a recording says that it has not.

use std::collections::BTreeMap;

use mcap::records::Metadata;
use serde::Serialize;

/// Name of the metadata record.
pub(crate) const NAME: &str = "taxel/losses";

/// What was lost between the sensor and the file, counted while it was recorded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[non_exhaustive]
pub struct Losses {
    /// Frames that the device numbered and that never came.
    pub lost: u64,
    /// Packets or lines that came broken.
    pub corrupt: u64,
    /// Times that the device began to number its frames anew.
    pub restarts: u64,
    /// Times that the link was lost and found again.
    pub outages: u64,
    /// Lines or packets that were passed over, for they belonged to no frame.
    pub skipped: u64,
    /// Frames whose counts are in the file, but not the loads or figures that were asked for.
    pub left_out: u64,
    /// Packets of other senders than the one that is recorded.
    pub other_senders: u64,
}

impl Losses {
    /// Every count with its key in the file.
    pub fn counts(&self) -> [(&'static str, u64); 7] {
        [
            ("lost", self.lost),
            ("corrupt", self.corrupt),
            ("restarts", self.restarts),
            ("outages", self.outages),
            ("skipped", self.skipped),
            ("left_out", self.left_out),
            ("other_senders", self.other_senders),
        ]
    }

    /// Whether nothing was lost.
    pub fn is_none(&self) -> bool {
        self.counts().iter().all(|(_, count)| *count == 0)
    }

    /// What was lost, in words, one sentence a cause; empty where nothing was.
    pub fn words(&self) -> Vec<String> {
        let told = [
            (self.lost, "frame", "never came"),
            (self.corrupt, "packet or line", "came broken"),
            (self.restarts, "time", "the device began anew"),
            (self.outages, "time", "the link was lost"),
            (self.skipped, "line or packet", "belonged to no frame"),
            (self.left_out, "frame", "had no loads or figures in time"),
            (
                self.other_senders,
                "packet",
                "of other senders were left out",
            ),
        ];
        told.into_iter()
            .filter(|(count, _, _)| *count > 0)
            .map(|(count, what, how)| match count {
                1 => format!("1 {what} {}", how.replace(" were ", " was ")),
                _ => format!("{count} {} {how}", plural(what)),
            })
            .collect()
    }

    pub(crate) fn to_metadata(self) -> Metadata {
        let counts = self.counts().into_iter();
        Metadata {
            name: NAME.to_owned(),
            metadata: counts
                .map(|(key, count)| (key.to_owned(), count.to_string()))
                .collect(),
        }
    }

    /// Of a record of that name; a key that is missing, or no number, counts nothing.
    pub(crate) fn from_metadata(metadata: &BTreeMap<String, String>) -> Self {
        let count = |key: &str| {
            metadata
                .get(key)
                .and_then(|text| text.parse().ok())
                .unwrap_or(0)
        };
        Self {
            lost: count("lost"),
            corrupt: count("corrupt"),
            restarts: count("restarts"),
            outages: count("outages"),
            skipped: count("skipped"),
            left_out: count("left_out"),
            other_senders: count("other_senders"),
        }
    }
}

fn plural(what: &str) -> String {
    let words: Vec<String> = what.split(" or ").map(|word| format!("{word}s")).collect();
    words.join(" or ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_count_comes_back_and_is_said() {
        let losses = Losses {
            lost: 1,
            corrupt: 2,
            restarts: 3,
            outages: 4,
            skipped: 5,
            left_out: 6,
            other_senders: u64::MAX,
        };
        let metadata = losses.to_metadata();
        assert_eq!(Losses::from_metadata(&metadata.metadata), losses);
        let words = losses.words();
        assert_eq!(words.len(), 7);
        assert_eq!(words[0], "1 frame never came");
        assert_eq!(words[1], "2 packets or lines came broken");
        assert!(Losses::default().is_none() && Losses::default().words().is_empty());
    }
}
