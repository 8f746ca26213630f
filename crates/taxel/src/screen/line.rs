//! Line faults from a whole recording.

use taxel_linalg::wide;

use super::evidence::{LineEvidence, Tells};
use super::frame::HELD_FRAMES;
use super::line_state::{FrameLines, LineVerdict, Thresholds};
use super::short::{AlikePairs, Usual};
use super::suspect;
use super::tally::{LineTally, Looked};
use super::together;
use super::{Axis, Level, LevelScreen, LineFault, LineFaultKind, LineFaults, ScreenOptions};
use crate::{Counts, Error, Frame, Sensor};

/// Silent readings between loaded ones, over a recording, before silence counts for anything.
const MIN_SILENT: u64 = 20;
/// Share of a line's length that must have been vouched for, in one frame or another, before its silence alone makes it
/// dead: a gap between two fingers or soles follows a line for less.
const COVERED_SHARE: f64 = 0.9;
/// Counts by which a faulty line reads other than the lines beside it.
const MIN_DIFFERENCE: f64 = 2.0;

/// Finds line faults in a stream of frames with state of constant size.
///
/// A line is *out* in a frame when nearly all of its readings have fallen below what an unloaded taxel reads
/// (a dead line reads 0 and noise; a sound one the baseline), or when it is silent where the lines on both
/// sides carry a real load and responds nowhere. Out in all frames that can tell: dead; by silence alone only along half
/// of its length, and where it never answered. Out in some: flickering; by silence alone only where it answered in the
/// frame before and the load beside it has hardly changed.
/// Independently, two adjacent lines that read alike where other pairs do not are shorted.
/// Where unloaded taxels read so little that no reading can fall from it, those of a line fall together.
/// What reads nothing at all though both lines beside it are loaded, and is none of these, is suspect: a dead line, or a gap
/// as wide as one.
///
/// What it cannot tell: a line without a load beside it on an array whose baseline is 0; a line at the edge of such
/// an array (it has only one side); on an array with floating lines, anything but a fall below what the circuit says that
/// the empty array reads; lines of fewer than four taxels.
#[derive(Debug, Clone)]
pub struct LineScreen {
    options: ScreenOptions,
    max_count: f64,
    levels: LevelScreen,
    level: Option<Level>,
    rows: Vec<LineTally>,
    columns: Vec<LineTally>,
    row_pairs: AlikePairs,
    column_pairs: AlikePairs,
    scratch: Vec<f64>,
    frames: u64,
    blank_frames: u64,
    /// Frames of nothing but zeros: blank as well, where unloaded taxels read more.
    zero_frames: u64,
    /// Of the last frame taken in by [`Self::observe`].
    evidence: LineEvidence,
    /// Of the frame before that was not blank.
    previous: FrameLines,
    has_previous: bool,
    /// Whether any taxel stood at the ceiling in the frame before.
    any_at_ceiling: bool,
    at_ceiling: Vec<u8>,
    held: Vec<bool>,
}

impl LineScreen {
    /// For the frames of a sensor, as its `screen` says.
    pub fn from_sensor(sensor: &Sensor) -> Self {
        let options = ScreenOptions::from_sensor(sensor);
        Self::new(
            sensor.rows(),
            sensor.columns(),
            sensor.max_count(),
            &options,
        )
    }

    /// For frames of this shape and a converter whose largest count is `max_count`.
    pub fn new(rows: usize, columns: usize, max_count: f64, options: &ScreenOptions) -> Self {
        Self {
            options: options.clone(),
            max_count,
            levels: LevelScreen::new(rows, columns, max_count, options),
            level: None,
            rows: vec![LineTally::of_length(columns); rows],
            columns: vec![LineTally::of_length(rows); columns],
            row_pairs: AlikePairs::new(rows, columns),
            column_pairs: AlikePairs::new(columns, rows),
            scratch: Vec::with_capacity(2 * rows.max(columns)),
            frames: 0,
            blank_frames: 0,
            zero_frames: 0,
            evidence: LineEvidence::new(rows, columns, max_count, options),
            previous: FrameLines::new(rows, columns),
            has_previous: false,
            any_at_ceiling: false,
            at_ceiling: vec![0; rows * columns],
            held: vec![false; rows * columns],
        }
    }

    /// Takes one more frame in.
    ///
    /// # Errors
    /// [`Error::Shape`] for a frame of another shape.
    pub fn observe(&mut self, frame: &Frame<Counts>) -> Result<(), Error> {
        self.levels.observe(frame)?;
        let mut evidence = std::mem::take(&mut self.evidence);
        let found = evidence.find(frame, self.levels.level());
        if found.is_ok() {
            self.add(&mut evidence);
        }
        self.evidence = evidence;
        found
    }

    /// Room for what a frame by itself tells, for any thread to find.
    pub fn evidence(&self) -> LineEvidence {
        self.evidence.clone()
    }

    /// [`Self::observe`] of a frame whose evidence was found elsewhere, in the order of the frames; with the level that a
    /// [`LevelScreen`] has found in the frames up to it. What is left of the evidence is room for that of another frame.
    pub fn add(&mut self, evidence: &mut LineEvidence) {
        self.level = evidence.level;
        self.frames += 1;
        match evidence.tells {
            Tells::NotAsked => return,
            Tells::Zeros => {
                self.zero_frames += 1;
                return;
            }
            Tells::Blank | Tells::Lines => self.follow_ceiling(evidence),
        }
        if evidence.tells == Tells::Blank {
            self.blank_frames += 1;
            return;
        }
        wide(
            #[inline(always)]
            || self.tally(evidence),
        );
        std::mem::swap(&mut evidence.lines, &mut self.previous);
        self.has_previous = true;
    }

    /// Adds what the frame says of every line and of every two neighbours.
    #[inline(always)]
    fn tally(&mut self, evidence: &LineEvidence) {
        let thresholds = &evidence.thresholds;
        let (of_rows, of_columns) = evidence.verdicts.split_at(self.rows.len());
        for (axis, verdicts, tallies, pairs) in [
            (Axis::Row, of_rows, &mut self.rows, &mut self.row_pairs),
            (
                Axis::Column,
                of_columns,
                &mut self.columns,
                &mut self.column_pairs,
            ),
        ] {
            let looked = Looked {
                lines: evidence.lines.along(axis, &self.options),
                before: self
                    .has_previous
                    .then(|| self.previous.along(axis, &self.options)),
                thresholds,
                options: &self.options,
            };
            together::observe(&looked, tallies);
            for (line, (verdict, tally)) in verdicts.iter().zip(tallies).enumerate() {
                looked.tally(line, verdict, tally, &mut self.scratch);
                let look = suspect::look(&looked, verdicts, line);
                tally.silence.add(verdict.responding, look);
            }
            let (along, across) = match axis {
                Axis::Row => evidence.usual.split_at(of_rows.len()),
                Axis::Column => {
                    let (rows, columns) = evidence.usual.split_at(of_rows.len());
                    (columns, rows)
                }
            };
            let usual = Usual {
                lines: along,
                positions: across,
            };
            let tells = |pair: &[LineVerdict]| pair.iter().any(LineVerdict::may_carry);
            for (line, _) in verdicts
                .windows(2)
                .enumerate()
                .filter(|(_, pair)| tells(pair))
            {
                pairs.observe(&looked.lines, line, thresholds, &self.options, &usual);
            }
        }
    }

    /// Counts how long each taxel has stood at the ceiling.
    fn follow_ceiling(&mut self, evidence: &LineEvidence) {
        let any = evidence.any_at_ceiling;
        let was_any = std::mem::replace(&mut self.any_at_ceiling, any);
        if !any && !was_any {
            return;
        }
        let ceiling = evidence.thresholds.ceiling;
        let taxels = self.at_ceiling.iter_mut().zip(&mut self.held);
        for ((run, held), &value) in taxels.zip(evidence.lines.by_row()) {
            *run = if value >= ceiling {
                run.saturating_add(1)
            } else {
                0
            };
            *held |= *run >= HELD_FRAMES;
        }
    }

    /// Baseline and noise so far.
    pub fn level(&self) -> Option<Level> {
        self.level
    }

    /// The faults in all frames seen. More frames can follow, and it can be asked again.
    pub fn finish(&self) -> LineFaults {
        let mut faults = Vec::new();
        for (axis, tallies, pairs) in [
            (Axis::Row, &self.rows, &self.row_pairs),
            (Axis::Column, &self.columns, &self.column_pairs),
        ] {
            for (index, tally) in tallies.iter().enumerate() {
                let fault = self.fault_of(axis, index, tally);
                let options = &self.options;
                let answers = tally.silence.answers();
                let fault = fault.or_else(|| tally.stands.fault(axis, index, answers, options));
                faults.extend(
                    fault.or_else(|| tally.silence.fault(axis, index, self.level, options)),
                );
            }
            faults.extend(
                pairs
                    .finish(&self.options)
                    .into_iter()
                    .map(|pair| LineFault {
                        axis,
                        index: pair.line,
                        kind: LineFaultKind::Shorted {
                            with: pair.line + 1,
                        },
                        faulty: pair.alike,
                        tested: pair.loaded,
                        median_counts: 0.0,
                        has_fallen: false,
                        next_to: pair.typical_share,
                    }),
            );
        }
        let falls = Thresholds::new(self.level, self.max_count, &self.options)
            .floor
            .is_some();
        let all_along = |run: u8| self.frames > 1 && u64::from(run) == self.frames;
        let held = self.held.iter().zip(&self.at_ceiling).enumerate();
        LineFaults {
            faults,
            level: self.level,
            frames: self.frames,
            blank_frames: self.blank_frames + if falls { self.zero_frames } else { 0 },
            held_at_ceiling: held
                .filter(|(_, (held, run))| **held || all_along(**run))
                .map(|(taxel, _)| taxel)
                .collect(),
        }
    }

    fn fault_of(&self, axis: Axis, index: usize, tally: &LineTally) -> Option<LineFault> {
        let options = &self.options;
        let is_most = |frames: u64| frames as f64 >= options.dead_share * tally.tested as f64;
        let silent_if_loaded = tally.supported_readings < MIN_SILENT
            || tally.silent_readings as f64 >= options.line_share * tally.supported_readings as f64;
        let never_answers = tally.silent_readings >= MIN_SILENT
            && tally.covered_share() >= COVERED_SHARE
            && tally.answered as f64 <= (1.0 - options.dead_share) * tally.tested as f64;
        let out = tally.fallen + tally.silent;
        let (kind, faulty) = if out == 0 {
            return None;
        } else if is_most(tally.fallen) && silent_if_loaded || is_most(out) && never_answers {
            (LineFaultKind::Dead, out)
        } else {
            // A line whose offset is low all along is fallen by half or more even where it is not out.
            let came_and_went = tally.fallen + tally.fell_silent;
            let frames_in = (tally.tested - out) as f64;
            let sound = tally.fallen_share_when_in / frames_in.max(1.0) < 0.3;
            let flickers = sound && frames_in > 0.0 && came_and_went >= options.flicker_frames;
            // Silence alone may be a gap between two loads: it takes more of it.
            let enough = tally.fallen > 0 || tally.silent_readings >= MIN_SILENT;
            (
                (flickers && enough).then_some(LineFaultKind::Flickering)?,
                came_and_went,
            )
        };
        let median_counts = tally.median_sum / out as f64;
        let next_to = tally.next_to_sum / out as f64;
        // What reads as its neighbours do, in the whole numbers that are printed, is no fault.
        let differs = (median_counts.round() - next_to.round()).abs() >= MIN_DIFFERENCE;
        differs.then_some(LineFault {
            axis,
            index,
            kind,
            faulty,
            tested: tally.tested,
            median_counts,
            // At the ceiling it has not.
            has_fallen: tally.fallen > tally.silent
                && self
                    .level
                    .is_some_and(|level| median_counts < level.baseline_counts),
            next_to,
        })
    }
}

#[cfg(test)]
pub(super) mod tests;
