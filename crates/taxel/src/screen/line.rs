//! Line faults from a whole recording.

use std::fmt;

use super::line_test::{Lines, Thresholds, Verdict, judge};
use super::short::AlikePairs;
use super::{Axis, Level, LevelScreen, ScreenOptions, median};
use crate::sensor::ScreenSpec;
use crate::{Counts, Error, Frame};

/// Silent readings between loaded ones, over a recording, before silence counts for anything.
const FEWEST_SILENT: u64 = 20;

/// What is wrong with a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum LineFaultKind {
    /// Never says anything.
    Dead,
    /// Out in some frames, sound in others.
    Flickering,
    /// Reads as the next line does: `with` is that line.
    Shorted {
        /// The other line.
        with: usize,
    },
}

/// One faulty line, with the evidence for it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LineFault {
    /// Row or column.
    pub axis: Axis,
    /// Which one, from 0.
    pub index: usize,
    /// What is wrong with it.
    pub kind: LineFaultKind,
    /// Frames in which it was out. For shorted lines: readings that are alike.
    pub faulty: u64,
    /// Frames that could tell. For shorted lines: readings of which either line was loaded.
    pub tested: u64,
    /// Its median reading in the frames in which it was out (mean over these frames), counts.
    /// For shorted lines: nothing (0).
    pub median_counts: f64,
    /// The same of the lines beside it, counts. For shorted lines: the share of alike readings on the typical pair.
    pub beside: f64,
}

impl fmt::Display for LineFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { axis, index, .. } = self;
        let (faulty, tested) = (self.faulty, self.tested);
        match self.kind {
            LineFaultKind::Dead => write!(
                f,
                "{axis} {index} is dead: median {:.0} counts in {faulty} of {tested} frames; its neighbours {:.0}",
                self.median_counts, self.beside
            ),
            LineFaultKind::Flickering => write!(
                f,
                "{axis} {index} flickers: out in {faulty} of {tested} frames, median {:.0} counts there; its neighbours {:.0}",
                self.median_counts, self.beside
            ),
            LineFaultKind::Shorted { with } => write!(
                f,
                "{axis}s {index} and {with} are shorted: alike on {faulty} of {tested} loaded readings ({:.1} %); the typical pair {:.1} %",
                100.0 * faulty as f64 / tested.max(1) as f64,
                100.0 * self.beside
            ),
        }
    }
}

/// All line faults of a recording, and what they were found with.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LineFaults {
    /// The faults: rows first, then columns, each in order.
    pub faults: Vec<LineFault>,
    /// Baseline and noise of the recording, where they could be told.
    pub level: Option<Level>,
    /// Frames looked at.
    pub frames: u64,
    /// Frames left out because half of all rows or columns, or more, were out at once: no line's fault.
    pub blank_frames: u64,
}

impl LineFaults {
    /// These, and what a sensor file declares beside them.
    pub fn with_declared(mut self, spec: &ScreenSpec) -> Self {
        for fault in Self::from_spec(spec).faults {
            let known = |f: &LineFault| (f.axis, f.index) == (fault.axis, fault.index);
            if !self.faults.iter().any(known) {
                self.faults.push(fault);
            }
        }
        self
    }

    /// The faults that a sensor file declares, without evidence.
    pub fn from_spec(spec: &ScreenSpec) -> Self {
        let lists = [
            (Axis::Row, LineFaultKind::Dead, &spec.dead_rows),
            (Axis::Row, LineFaultKind::Flickering, &spec.flickering_rows),
            (Axis::Column, LineFaultKind::Dead, &spec.dead_columns),
            (
                Axis::Column,
                LineFaultKind::Flickering,
                &spec.flickering_columns,
            ),
        ];
        let declared = |axis, index, kind| LineFault {
            axis,
            index,
            kind,
            faulty: 0,
            tested: 0,
            median_counts: 0.0,
            beside: 0.0,
        };
        Self {
            faults: lists
                .iter()
                .flat_map(|(axis, kind, lines)| lines.iter().map(|&i| declared(*axis, i, *kind)))
                .collect(),
            ..Self::default()
        }
    }

    /// Lines of one axis with one kind of fault (both lines of a short).
    fn of(&self, axis: Axis, wanted: fn(LineFaultKind) -> bool) -> impl Iterator<Item = usize> {
        self.faults
            .iter()
            .filter(move |fault| fault.axis == axis && wanted(fault.kind))
            .map(|fault| fault.index)
    }

    /// Dead lines of one axis, in order.
    pub fn dead(&self, axis: Axis) -> impl Iterator<Item = usize> {
        self.of(axis, |kind| kind == LineFaultKind::Dead)
    }

    /// Flickering lines of one axis, in order.
    pub fn flickering(&self, axis: Axis) -> impl Iterator<Item = usize> {
        self.of(axis, |kind| kind == LineFaultKind::Flickering)
    }

    /// Pairs of shorted lines of one axis, in order.
    pub fn shorted(&self, axis: Axis) -> impl Iterator<Item = (usize, usize)> {
        self.faults
            .iter()
            .filter(move |fault| fault.axis == axis)
            .filter_map(|fault| match fault.kind {
                LineFaultKind::Shorted { with } => Some((fault.index, with)),
                _ => None,
            })
    }

    /// Rows that say nothing.
    pub fn dead_rows(&self) -> impl Iterator<Item = usize> {
        self.dead(Axis::Row)
    }

    /// Columns that say nothing.
    pub fn dead_columns(&self) -> impl Iterator<Item = usize> {
        self.dead(Axis::Column)
    }

    /// Rows that come and go.
    pub fn flickering_rows(&self) -> impl Iterator<Item = usize> {
        self.flickering(Axis::Row)
    }

    /// Columns that come and go.
    pub fn flickering_columns(&self) -> impl Iterator<Item = usize> {
        self.flickering(Axis::Column)
    }

    /// Whether nothing was found.
    pub fn is_empty(&self) -> bool {
        self.faults.is_empty()
    }
}

/// What is kept of one line over a recording.
#[derive(Debug, Clone, Copy, Default)]
struct LineTally {
    tested: u64,
    out: u64,
    vouched: u64,
    silent: u64,
    fallen_share_when_in: f64,
    fallen_frames: u64,
    median_sum: f64,
    beside_sum: f64,
}

/// Finds line faults in a stream of frames with state of constant size.
///
/// A line is *out* in a frame when nearly all of its readings have fallen below what an unloaded taxel reads
/// (a dead line reads 0 and noise; a sound one the baseline), or when it is silent where the lines on both
/// sides are loaded and responds nowhere. Out in all frames that can tell: dead. Out in some: flickering.
/// Independently, two adjacent lines that read alike where other pairs do not are shorted.
///
/// What it cannot tell: a line without a load beside it on an array whose baseline is 0; a line at the edge of such
/// an array (it has only one side).
#[derive(Debug, Clone)]
pub struct LineScreen {
    options: ScreenOptions,
    max_count: f64,
    levels: LevelScreen,
    rows: Vec<LineTally>,
    columns: Vec<LineTally>,
    row_pairs: AlikePairs,
    column_pairs: AlikePairs,
    verdicts: Vec<Verdict>,
    scratch: Vec<f64>,
    frames: u64,
    blank_frames: u64,
}

impl LineScreen {
    /// For frames of this shape and a converter whose largest count is `max_count`.
    pub fn new(rows: usize, columns: usize, max_count: f64, options: &ScreenOptions) -> Self {
        Self {
            options: options.clone(),
            max_count,
            levels: LevelScreen::new(rows, columns, max_count, options),
            rows: vec![LineTally::default(); rows],
            columns: vec![LineTally::default(); columns],
            row_pairs: AlikePairs::new(rows),
            column_pairs: AlikePairs::new(columns),
            verdicts: Vec::with_capacity(rows + columns),
            scratch: Vec::with_capacity(2 * rows.max(columns)),
            frames: 0,
            blank_frames: 0,
        }
    }

    /// Takes one more frame in.
    ///
    /// # Errors
    /// [`Error::Shape`] for a frame of another shape.
    pub fn observe(&mut self, frame: &Frame<Counts>) -> Result<(), Error> {
        self.levels.observe(frame)?;
        self.frames += 1;
        let thresholds = Thresholds::new(self.levels.level(), self.max_count, &self.options);
        self.verdicts.clear();
        for axis in Axis::BOTH {
            let lines = Lines::of(frame, axis);
            for line in 0..lines.count {
                self.verdicts
                    .push(judge(&lines, line, &thresholds, &self.options));
            }
        }
        let (of_rows, of_columns) = self.verdicts.split_at(self.rows.len());
        let blank = |all: &[Verdict]| 2 * all.iter().filter(|v| v.out).count() >= all.len();
        if blank(of_rows) || blank(of_columns) {
            self.blank_frames += 1;
            return Ok(());
        }
        for (axis, verdicts, tallies) in [
            (Axis::Row, of_rows, &mut self.rows),
            (Axis::Column, of_columns, &mut self.columns),
        ] {
            let lines = Lines::of(frame, axis);
            tally(&lines, verdicts, tallies, &mut self.scratch);
        }
        for (axis, pairs) in [
            (Axis::Row, &mut self.row_pairs),
            (Axis::Column, &mut self.column_pairs),
        ] {
            let lines = Lines::of(frame, axis);
            for line in 0..lines.count.saturating_sub(1) {
                pairs.observe(&lines, line, &thresholds, &self.options);
            }
        }
        Ok(())
    }

    /// Baseline and noise so far.
    pub fn level(&self) -> Option<Level> {
        self.levels.level()
    }

    /// The faults in all frames seen. More frames can follow, and it can be asked again.
    pub fn finish(&self) -> LineFaults {
        let mut faults = Vec::new();
        for (axis, tallies, pairs) in [
            (Axis::Row, &self.rows, &self.row_pairs),
            (Axis::Column, &self.columns, &self.column_pairs),
        ] {
            for (index, tally) in tallies.iter().enumerate() {
                faults.extend(self.fault_of(axis, index, tally));
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
                        beside: pair.typical_share,
                    }),
            );
        }
        LineFaults {
            faults,
            level: self.levels.level(),
            frames: self.frames,
            blank_frames: self.blank_frames,
        }
    }

    fn fault_of(&self, axis: Axis, index: usize, tally: &LineTally) -> Option<LineFault> {
        if tally.out == 0 {
            return None;
        }
        let options = &self.options;
        // Silence alone may be a gap between two loads: it takes more of it.
        let only_silent = tally.fallen_frames == 0 && tally.vouched > 0;
        if only_silent && (tally.silent < FEWEST_SILENT || tally.out < options.flicker_frames) {
            return None;
        }
        let silent_if_loaded = tally.vouched < FEWEST_SILENT
            || tally.silent as f64 >= options.line_share * tally.vouched as f64;
        let kind = if tally.out as f64 >= options.dead_share * tally.tested as f64 {
            silent_if_loaded.then_some(LineFaultKind::Dead)?
        } else {
            // A line whose offset is low all along is fallen by half or more even where it is not out.
            let frames_in = (tally.tested - tally.out) as f64;
            let sound = tally.fallen_share_when_in / frames_in < 0.3;
            (sound && tally.out >= options.flicker_frames).then_some(LineFaultKind::Flickering)?
        };
        Some(LineFault {
            axis,
            index,
            kind,
            faulty: tally.out,
            tested: tally.tested,
            median_counts: tally.median_sum / tally.out as f64,
            beside: tally.beside_sum / tally.out as f64,
        })
    }
}

/// Adds one frame's verdicts to the tallies of the lines along one axis.
fn tally(
    lines: &Lines<'_>,
    verdicts: &[Verdict],
    tallies: &mut [LineTally],
    scratch: &mut Vec<f64>,
) {
    for (line, (verdict, tally)) in verdicts.iter().zip(tallies).enumerate() {
        if !verdict.testable {
            continue;
        }
        tally.tested += 1;
        tally.vouched += verdict.vouched;
        tally.silent += verdict.silent;
        if !verdict.out {
            tally.fallen_share_when_in += verdict.fallen_share;
            continue;
        }
        tally.out += 1;
        tally.fallen_frames += u64::from(verdict.fallen_share > 0.5);
        scratch.clear();
        scratch.extend(lines.of_line(line));
        tally.median_sum += median(scratch).unwrap_or(0.0);
        scratch.clear();
        if line > 0 {
            scratch.extend(lines.of_line(line - 1));
        }
        if line + 1 < lines.count {
            scratch.extend(lines.of_line(line + 1));
        }
        tally.beside_sum += median(scratch).unwrap_or(0.0);
    }
}

#[cfg(test)]
pub(super) mod tests;
