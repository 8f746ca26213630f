//! Readings at the ends of the converter, and readings that never change.

use crate::{Counts, Frame, Mark};

/// What is kept of one taxel over both recordings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct EndTally {
    /// Smallest reading, counts.
    pub least: f64,
    /// Largest reading, counts.
    pub most: f64,
    /// Readings at the upper end.
    pub high: u32,
    /// Readings at the lower end.
    pub low: u32,
    /// Readings of the rubbed recording at either end without a reason (no load around them, or far below the baseline).
    pub stuck: u32,
}

impl EndTally {
    /// Whether every reading was the same.
    pub fn is_constant(&self) -> bool {
        self.least == self.most
    }
}

/// Counts them taxel by taxel.
#[derive(Debug, Clone)]
pub(super) struct Ends {
    pub taxels: Vec<EndTally>,
    pub frames: u32,
    max_count: f64,
    end_counts: f64,
}

impl Ends {
    pub fn new(taxels: usize, max_count: f64, end_counts: f64) -> Self {
        let none = EndTally {
            least: f64::INFINITY,
            most: f64::NEG_INFINITY,
            high: 0,
            low: 0,
            stuck: 0,
        };
        Self {
            taxels: vec![none; taxels],
            frames: 0,
            max_count,
            end_counts,
        }
    }

    /// Takes a frame: of the rubbed recording, one that [`crate::screen::FrameScreen`] has marked.
    pub fn observe(&mut self, frame: &Frame<Counts>) {
        self.frames = self.frames.saturating_add(1);
        let readings = frame.values().iter().zip(frame.marks());
        for (taxel, (&value, &mark)) in self.taxels.iter_mut().zip(readings) {
            taxel.least = taxel.least.min(value);
            taxel.most = taxel.most.max(value);
            taxel.high += u32::from(value >= self.max_count - self.end_counts);
            taxel.low += u32::from(value <= self.end_counts);
            taxel.stuck += u32::from(mark == Mark::Stuck);
        }
    }

    /// Share of a line's taxels that are at the upper end (`high`) or the lower one in at least `share` of the frames.
    pub fn line_share(&self, taxels: impl Iterator<Item = usize>, high: bool, share: f64) -> f64 {
        let wanted = share * f64::from(self.frames);
        let (mut all, mut at_end) = (0usize, 0usize);
        for taxel in taxels {
            let tally = &self.taxels[taxel];
            let count = if high { tally.high } else { tally.low };
            all += 1;
            at_end += usize::from(f64::from(count) >= wanted);
        }
        at_end as f64 / all.max(1) as f64
    }
}
