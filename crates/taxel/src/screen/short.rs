//! Lines shorted together read alike, frame after frame.

use super::ScreenOptions;
use super::line_test::{Lines, Thresholds};

/// How alike the readings of each pair of adjacent lines are, over a recording.
#[derive(Debug, Clone)]
pub(super) struct AlikePairs {
    loaded: Vec<u64>,
    alike: Vec<u64>,
}

/// Two lines that read alike.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct AlikePair {
    pub line: usize,
    pub alike: u64,
    pub loaded: u64,
    pub typical_share: f64,
}

impl AlikePairs {
    pub fn new(lines: usize) -> Self {
        let pairs = lines.saturating_sub(1);
        Self {
            loaded: vec![0; pairs],
            alike: vec![0; pairs],
        }
    }

    /// Compares line `line` with the next one wherever either is loaded and neither is at the ceiling.
    pub fn observe(
        &mut self,
        lines: &Lines<'_>,
        line: usize,
        thresholds: &Thresholds,
        options: &ScreenOptions,
    ) {
        for position in 0..lines.length {
            let (a, b) = (lines.at(line, position), lines.at(line + 1, position));
            let higher = a.max(b);
            if higher <= thresholds.loaded || higher >= thresholds.ceiling {
                continue;
            }
            let tolerance = 4.0 * thresholds.noise
                + options.short_tolerance_share * (higher - thresholds.baseline);
            // A load centred between the two lines makes them alike, and the lines beyond them as well: it
            // says nothing.
            if line > 0 && line + 2 < lines.count {
                let beyond = (lines.at(line - 1, position), lines.at(line + 2, position));
                if (beyond.0 - beyond.1).abs() <= 4.0 * tolerance {
                    continue;
                }
            }
            self.loaded[line] += 1;
            self.alike[line] += u64::from((a - b).abs() <= tolerance);
        }
    }

    /// The pairs that are alike nearly everywhere although the typical pair of this recording is not: a load that
    /// is the same everywhere, or an array whose lines are all one through its own cross-talk, is no short.
    pub fn finish(&self, options: &ScreenOptions) -> Vec<AlikePair> {
        let share = |i: usize| self.alike[i] as f64 / self.loaded[i].max(1) as f64;
        let enough = |i: &usize| self.loaded[*i] >= options.short_readings;
        let mut shares: Vec<f64> = (0..self.loaded.len()).filter(enough).map(share).collect();
        let typical_share = super::median(&mut shares).unwrap_or(1.0);
        if shares.len() < 3 || typical_share > options.short_share / 2.0 {
            return Vec::new();
        }
        (0..self.loaded.len())
            .filter(enough)
            .filter(|&i| share(i) >= options.short_share)
            .map(|line| AlikePair {
                line,
                alike: self.alike[line],
                loaded: self.loaded[line],
                typical_share,
            })
            .collect()
    }
}
