//! Outliers by value alone: the paper's low and high threshold.

use crate::{Counts, Frame, Mark};

/// Readings below or above these are outliers. Without a threshold on one side, nothing is an outlier there.
///
/// The paper leaves readings near either end of the converter out of its training set and reports their share
/// over 100 readings (22 % with bad connectors, 5 % after the repair: its Table IV). The mask only counts;
/// it says nothing about why a reading is where it is, so it sets no [`crate::Mark`].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CountsMask {
    /// Lowest reading that is kept, counts.
    pub low_counts: Option<f64>,
    /// Highest reading that is kept, counts.
    pub high_counts: Option<f64>,
}

impl CountsMask {
    /// Whether a reading (counts) is kept.
    pub fn keeps(&self, counts: f64) -> bool {
        self.low_counts.is_none_or(|low| counts >= low)
            && self.high_counts.is_none_or(|high| counts <= high)
    }

    /// How many readings of a frame lie outside, on either side; of crossings marked absent none.
    pub fn count(&self, frame: &Frame<Counts>) -> MaskCount {
        let mut count = MaskCount::default();
        let there = frame.values().iter().zip(frame.marks());
        for (&value, _) in there.filter(|(_, mark)| **mark != Mark::Absent) {
            count.readings += 1;
            count.low += u64::from(self.low_counts.is_some_and(|low| value < low));
            count.high += u64::from(self.high_counts.is_some_and(|high| value > high));
        }
        count
    }
}

/// How many readings lie outside a [`CountsMask`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct MaskCount {
    /// Readings looked at.
    pub readings: u64,
    /// Below the low threshold.
    pub low: u64,
    /// Above the high threshold.
    pub high: u64,
}

impl MaskCount {
    /// Share of outliers, 0 to 1 (0 when nothing was looked at).
    pub fn share(&self) -> f64 {
        if self.readings == 0 {
            return 0.0;
        }
        (self.low + self.high) as f64 / self.readings as f64
    }

    /// The sum with another count.
    pub fn plus(self, other: Self) -> Self {
        Self {
            readings: self.readings + other.readings,
            low: self.low + other.low,
            high: self.high + other.high,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_sides_are_counted_and_the_ends_are_kept() {
        let mask = CountsMask {
            low_counts: Some(10.0),
            high_counts: Some(100.0),
        };
        let frame = Frame::<Counts>::new(1, 5, vec![9.0, 10.0, 50.0, 100.0, 101.0]).unwrap();
        let count = mask.count(&frame);
        assert_eq!((count.low, count.high, count.readings), (1, 1, 5));
        assert!((count.share() - 0.4).abs() < 1e-15);
        assert!(mask.keeps(10.0) && mask.keeps(100.0) && !mask.keeps(101.0));
    }

    #[test]
    fn no_threshold_keeps_everything() {
        let frame = Frame::<Counts>::new(1, 2, vec![0.0, 65_535.0]).unwrap();
        assert_eq!(CountsMask::default().count(&frame).share(), 0.0);
        assert_eq!(MaskCount::default().share(), 0.0);
    }
}
