//! What happened to a recording on its way, counted: answers, marks, frames that are missing.

use std::collections::BTreeMap;

use serde::Serialize;
use taxel::frame::are_zeros;
use taxel::solve::Outcome;
use taxel::{Frame, Mark};
use taxel_io::{Integrity, Skipped};

use super::Converted;
use crate::chain::stop_words;
use crate::figures::FigureRow;
use crate::frames::{DisplayUnit, FrameReader};
use crate::units::Unit;

/// How many frames are named one by one.
pub const NAMED: usize = 10;
/// Loads of which more than this share lies below nothing, and one of them by so many newtons, are of another circuit.
const BELOW_SHARE: f64 = 0.9;
const BELOW_NEWTONS: f64 = 0.5;

/// Why the inverse stops with an answer.
const ANSWERS: [&str; 2] = ["direct", "converged"];

/// A recording's frames, counted by what became of them.
#[derive(Debug, Serialize)]
#[non_exhaustive]
pub struct Tally {
    /// Frames that were read.
    pub frames: u64,
    /// Frames by why the inverse stopped.
    pub stops: BTreeMap<&'static str, u64>,
    /// Frames that another set of conductances explains as well.
    pub ambiguous_frames: u64,
    /// The first frames without an answer.
    pub unsolved: Vec<NamedFrame>,
    /// Frames left out because they could not be read.
    pub skipped_frames: usize,
    /// The first of them.
    pub skipped: Vec<NamedFrame>,
    /// What the recording tells of frames that are missing.
    pub missing: Vec<String>,
    /// Readings of taxels that there are, over all frames.
    #[serde(skip)]
    taxels: u64,
    /// Those that are uncertain by more than themselves, in frames with an answer: read all the same, and in every sum.
    #[serde(skip)]
    uncertain: u64,
    /// Share of the taxels, over all frames, whose own reading stands behind their number, be it a bound, 0 to 1.
    pub measured_share: f64,
    /// Frames in which no taxel was measured.
    #[serde(skip_serializing_if = "are_none")]
    pub unmeasured_frames: u64,
    /// Share of the readings that are below what the recorder keeps, 0 to 1.
    #[serde(skip_serializing_if = "is_nothing")]
    pub below_floor_share: f64,
    /// Whether nearly all loads lie below nothing, which no load does.
    pub loads_below_nothing: bool,
    #[serde(skip)]
    loads: Option<Loads>,
    /// Taxels by mark, over all frames.
    pub marks: BTreeMap<&'static str, u64>,
    /// The figures of the frame with the largest total force, where figures were asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub heaviest_frame: Option<FigureRow>,
}

/// A frame and what happened to it.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct NamedFrame {
    /// Its position in the recording, from 0.
    pub frame: u64,
    /// What happened.
    pub why: String,
}

/// Sums that are added to at once, each of every eighth load.
const LANES: usize = 8;

/// Sums of measured loads above and below nothing, sizes, and the one farthest below.
#[derive(Debug, Default)]
struct Loads {
    above: [f64; LANES],
    below: [f64; LANES],
    lowest: [f64; LANES],
    /// What the lowest must be beyond.
    limit: f64,
}

impl Loads {
    /// Those of a frame that were measured.
    fn add(&mut self, frame: &Frame<DisplayUnit>) {
        let (values, last) = frame.values().as_chunks::<LANES>();
        let (marks, last_marks) = frame.marks().as_chunks::<LANES>();
        for (values, marks) in values.iter().zip(marks) {
            // Most of what a mat shows is nothing.
            if are_zeros(values) {
                continue;
            }
            self.add_measured(values, marks);
        }
        let (mut values, mut marks) = ([0.0; LANES], [Mark::Good; LANES]);
        values[..last.len()].copy_from_slice(last);
        marks[..last.len()].copy_from_slice(last_marks);
        self.add_measured(&values, &marks);
    }

    /// Without a branch, since loads on a mat are foreseen by nobody, and several at a time.
    #[inline(always)]
    fn add_measured(&mut self, values: &[f64; LANES], marks: &[Mark; LANES]) {
        for lane in 0..LANES {
            let is_good = u64::from(marks[lane] == Mark::Good).wrapping_neg();
            let load = f64::from_bits(values[lane].to_bits() & is_good);
            self.above[lane] += if load > 0.0 { load } else { 0.0 };
            let below = if load < 0.0 { load } else { 0.0 };
            self.below[lane] -= below;
            let lowest = self.lowest[lane];
            self.lowest[lane] = if below < lowest { below } else { lowest };
        }
    }

    fn are_below_nothing(&self) -> bool {
        let [above, below] = [&self.above, &self.below].map(|lanes| lanes.iter().sum::<f64>());
        let lowest = self.lowest.iter().copied().fold(0.0, f64::min);
        below > BELOW_SHARE * (above + below) && lowest < -self.limit
    }
}

impl Tally {
    /// Whether what was not measured was filled in from its neighbours.
    pub fn is_interpolated(&self) -> bool {
        self.marks.contains_key(Mark::Interpolated.word())
    }

    /// Of no frames so far, whose numbers are in `unit`.
    pub fn new(unit: Unit, taxel_area_mm2: f64) -> Self {
        let loads = unit.is_load().then(|| Loads {
            limit: unit.of_newtons(BELOW_NEWTONS, taxel_area_mm2),
            ..Loads::default()
        });
        Self {
            frames: 0,
            stops: BTreeMap::new(),
            ambiguous_frames: 0,
            unsolved: Vec::new(),
            skipped_frames: 0,
            skipped: Vec::new(),
            missing: Vec::new(),
            taxels: 0,
            uncertain: 0,
            measured_share: 0.0,
            unmeasured_frames: 0,
            below_floor_share: 0.0,
            loads_below_nothing: false,
            loads,
            marks: BTreeMap::new(),
            heaviest_frame: None,
        }
    }

    /// Counts one frame.
    pub fn add(&mut self, frame: &Converted) {
        let outcome = frame.outcome.as_ref();
        let is_answer = outcome.is_none_or(|outcome| self.add_outcome(frame.sequence(), outcome));
        self.add_numbers(&frame.shown, is_answer);
        let force = |row: &FigureRow| row.total_force.value;
        let before = self.heaviest_frame.as_ref().map(force);
        let heavier = frame
            .figures
            .filter(|row| before.is_none_or(|before| force(row) > before));
        if heavier.is_some() {
            self.heaviest_frame = heavier;
        }
    }

    /// Whether it is one with an answer.
    fn add_outcome(&mut self, frame: u64, outcome: &Outcome) -> bool {
        let (word, why) = stop_words(outcome);
        *self.stops.entry(word).or_default() += 1;
        self.ambiguous_frames += u64::from(outcome.ambiguous);
        if let Some(why) = why.filter(|_| self.unsolved.len() < NAMED) {
            self.unsolved.push(NamedFrame { frame, why });
        }
        ANSWERS.contains(&word)
    }

    fn add_numbers(&mut self, frame: &Frame<DisplayUnit>, is_answer: bool) {
        self.frames += 1;
        if let Some(loads) = &mut self.loads {
            loads.add(frame);
        }
        let counts = frame.count_marks();
        self.taxels += counts.taxels() as u64;
        if is_answer {
            self.uncertain += counts.of(Mark::Unresolved) as u64;
        }
        let measured = Mark::ALL.into_iter().filter(|mark| mark.is_measured());
        let nothing = measured.map(|mark| counts.of(mark)).sum::<usize>() == 0;
        self.unmeasured_frames += u64::from(nothing);
        for mark in Mark::ALL {
            let count = counts.of(mark) as u64;
            if count > 0 && mark != Mark::Absent {
                *self.marks.entry(mark.word()).or_default() += count;
            }
        }
    }

    /// All frames were read: what was left out of them, and shares of the whole.
    pub fn finish(&mut self, reading: &FrameReader) {
        let (count, first) = reading.skips();
        self.add_skips(count, first);
        let integrity: Integrity = reading.integrity();
        self.missing = integrity.words();
        let of = |mark: Mark| self.marks.get(mark.word()).copied().unwrap_or(0) as f64;
        let readings = Mark::ALL.into_iter().filter(|mark| mark.is_reading());
        let taxels = self.taxels.max(1) as f64;
        self.measured_share = (readings.map(of).sum::<f64>() + self.uncertain as f64) / taxels;
        self.below_floor_share = of(Mark::BelowFloor) / taxels;
        self.loads_below_nothing = self.loads.as_ref().is_some_and(Loads::are_below_nothing);
    }

    fn add_skips(&mut self, count: usize, first: &[Skipped]) {
        self.skipped_frames = count;
        let named = first.iter().take(NAMED).map(|skipped| NamedFrame {
            frame: skipped.frame,
            why: skipped.error.to_string(),
        });
        self.skipped = named.collect();
    }

    /// Frames whose inverse came to no answer.
    pub fn unsolved_frames(&self) -> u64 {
        let stops = self.stops.iter();
        stops
            .filter(|(word, _)| !ANSWERS.contains(word))
            .map(|(_, n)| n)
            .sum()
    }

    /// Whether nothing was left out, every frame has one answer, and something was measured, and no less than nothing.
    pub fn is_whole(&self) -> bool {
        let all = self.skipped_frames == 0 && self.missing.is_empty();
        let measured = self.frames == 0 || self.measured_share > 0.0;
        let solved = self.unsolved_frames() == 0 && self.ambiguous_frames == 0;
        all && measured && solved && !self.loads_below_nothing
    }
}

fn are_none(frames: &u64) -> bool {
    *frames == 0
}

fn is_nothing(share: &f64) -> bool {
    *share == 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Frames of few loads and many, above and below nothing, with marks and of sizes that do not end with a block.
    #[test]
    fn sums_are_those_of_one_load_after_the_other() {
        let (mut found, [mut above, mut below, mut lowest]) = (Loads::default(), [0f64; 3]);
        for seed in 0..300usize {
            let mut frame = Frame::<DisplayUnit>::zeros(3, 1 + seed % 29);
            let (values, marks) = frame.values_and_marks_mut();
            for (at, (value, mark)) in values.iter_mut().zip(marks).enumerate() {
                let drawn = (at * 7919 + seed * 104_729) % 1009;
                if drawn % 8 < seed % 9 {
                    *value = drawn as f64 / 77.0 - [0.0, 3.0][seed % 2];
                }
                *mark = Mark::ALL[if drawn.is_multiple_of(5) {
                    drawn % 12
                } else {
                    0
                }];
                if *mark == Mark::Good {
                    above += value.max(0.0);
                    below -= value.min(0.0);
                    lowest = lowest.min(*value);
                }
            }
            found.add(&frame);
            let sum = |lanes: &[f64]| lanes.iter().sum::<f64>();
            for (found, plain) in [(sum(&found.above), above), (sum(&found.below), below)] {
                assert!((found - plain).abs() <= 1e-13 * plain, "frame {seed}");
            }
            let found = found.lowest.iter().copied().fold(0.0, f64::min);
            assert_eq!(found, lowest, "frame {seed}");
        }
        assert!(lowest < 0.0 && above > below);
    }
}
