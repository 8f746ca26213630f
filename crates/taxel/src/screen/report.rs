//! What the screen found, in numbers and in words.

use std::fmt;

use super::{CountsMask, LineFaults, MaskCount};
use crate::{Counts, Frame, Mark};

/// Counts of every mark over the frames of a recording, the mask's outliers, and the line faults.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ScreenReport {
    /// Frames added.
    pub frames: u64,
    /// Readings added, of taxels that there are.
    pub readings: u64,
    /// Readings by mark, in the order of [`Mark::ALL`].
    pub by_mark: [u64; Mark::ALL.len()],
    /// The mask counted with, and what it found, if one was asked for.
    pub mask: Option<(CountsMask, MaskCount)>,
    /// Line faults.
    pub lines: LineFaults,
}

impl ScreenReport {
    /// An empty report on a recording with these line faults.
    pub fn new(lines: LineFaults) -> Self {
        Self {
            lines,
            ..Self::default()
        }
    }

    /// The same, which also counts the outliers of a mask.
    pub fn with_mask(self, mask: CountsMask) -> Self {
        Self {
            mask: Some((mask, MaskCount::default())),
            ..self
        }
    }

    /// Adds a marked frame.
    pub fn add(&mut self, frame: &Frame<Counts>) {
        self.frames += 1;
        self.readings += frame.taxels() as u64;
        for mark in Mark::ALL {
            self.by_mark[mark.code() as usize] += frame.count(mark) as u64;
        }
        if let Some((mask, count)) = &mut self.mask {
            *count = count.plus(mask.count(frame));
        }
    }

    /// Readings with this mark.
    pub fn count(&self, mark: Mark) -> u64 {
        self.by_mark[mark.code() as usize]
    }

    /// Readings that are neither good nor below the floor, where an unloaded taxel reads.
    pub fn outliers(&self) -> u64 {
        self.readings - self.count(Mark::Good) - self.count(Mark::BelowFloor)
    }

    /// The outliers as a share of all readings, 0 to 1 (0 when nothing was added).
    pub fn outlier_share(&self) -> f64 {
        self.outliers() as f64 / self.readings.max(1) as f64
    }
}

impl fmt::Display for ScreenReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{} frames, {} readings", self.frames, self.readings)?;
        match self.lines.level {
            Some(level) => writeln!(
                f,
                "baseline {:.1} counts, noise {:.2} counts",
                level.baseline_counts, level.noise_counts
            )?,
            None => writeln!(f, "baseline unknown: too few unloaded readings")?,
        }
        let percent = |n: u64| 100.0 * n as f64 / self.readings.max(1) as f64;
        writeln!(
            f,
            "outliers {:.2} % ({} readings)",
            100.0 * self.outlier_share(),
            self.outliers()
        )?;
        for mark in Mark::ALL
            .into_iter()
            .filter(|&m| m != Mark::Good && m != Mark::Absent)
        {
            let count = self.count(mark);
            if count > 0 {
                writeln!(
                    f,
                    "  {:<13}{count:>9}  {:.2} %",
                    mark.word(),
                    percent(count)
                )?;
            }
        }
        if let Some((mask, count)) = &self.mask {
            writeln!(
                f,
                "outside the mask {:.2} %: {} below {}, {} above {}",
                100.0 * count.share(),
                count.low,
                threshold(mask.low_counts),
                count.high,
                threshold(mask.high_counts)
            )?;
        }
        if self.lines.is_empty() {
            writeln!(f, "no line fault")?;
        }
        for fault in &self.lines.faults {
            writeln!(f, "{fault}")?;
        }
        if self.lines.blank_frames > 0 {
            writeln!(
                f,
                "{} of {} frames have half of the array out at once: left out of the line faults",
                self.lines.blank_frames, self.lines.frames
            )?;
        }
        Ok(())
    }
}

fn threshold(counts: Option<f64>) -> String {
    counts.map_or_else(|| "no threshold".to_owned(), |c| format!("{c} counts"))
}
