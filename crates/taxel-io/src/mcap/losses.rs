//! What a recording says that it has not.

use std::collections::BTreeMap;

use mcap::records::Metadata;

use crate::extras::Losses;

/// Name of the metadata record.
pub(super) const NAME: &str = "taxel/losses";

impl Losses {
    pub(super) fn to_metadata(self) -> Metadata {
        let counts = self.counts().into_iter();
        Metadata {
            name: NAME.to_owned(),
            metadata: counts
                .map(|(key, count)| (key.to_owned(), count.to_string()))
                .collect(),
        }
    }

    /// Of a record of that name; a key that is missing, or no number, counts nothing.
    pub(super) fn from_metadata(metadata: &BTreeMap<String, String>) -> Self {
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
