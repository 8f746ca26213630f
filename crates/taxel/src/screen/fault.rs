//! What can be wrong with a line, in numbers and in words.

use std::fmt;

use super::{Axis, Level};
use crate::sensor::ScreenSpec;

/// What is wrong with a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
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
    /// Reads nothing though both lines beside it are loaded: a dead line, or a gap as wide as one, which its readings do not tell
    /// apart. Nothing is marked for it.
    Suspect,
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
    /// Frames that could tell; for suspect lines, those in which both lines beside it are loaded. For shorted lines: readings
    /// of which either line was loaded.
    pub tested: u64,
    /// Its median reading in the frames in which it was out (mean over these frames), counts.
    /// For shorted lines: nothing (0).
    pub median_counts: f64,
    /// Whether its readings have fallen below what unloaded taxels read, one by one or together; else its silence beside loads tells.
    pub has_fallen: bool,
    /// The same of the lines beside it, counts. For shorted lines: the share of alike readings on the typical pair.
    pub next_to: f64,
}

impl fmt::Display for LineFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { axis, index, .. } = self;
        let (faulty, tested) = (self.faulty, self.tested);
        match self.kind {
            LineFaultKind::Dead if tested == 0 => {
                write!(f, "{axis} {index} is dead, as the sensor file says")
            }
            LineFaultKind::Flickering if tested == 0 => {
                write!(f, "{axis} {index} flickers, as the sensor file says")
            }
            LineFaultKind::Dead => write!(
                f,
                "{axis} {index} is dead: median {:.0} counts in {faulty} of {tested} frames; its neighbours {:.0}",
                self.median_counts, self.next_to
            ),
            LineFaultKind::Flickering => write!(
                f,
                "{axis} {index} flickers: out in {faulty} of {tested} frames, median {:.0} counts there; its neighbours {:.0}",
                self.median_counts, self.next_to
            ),
            LineFaultKind::Suspect => write!(
                f,
                "{axis} {index} may be dead: it reads nothing, also in the {faulty} {} in which both lines beside it are loaded ({:.0} counts there)",
                if faulty == 1 { "frame" } else { "frames" },
                self.next_to
            ),
            LineFaultKind::Shorted { with } => write!(
                f,
                "{axis}s {index} and {with} are shorted: alike on {faulty} of {tested} loaded readings ({:.1} %); the typical pair {:.1} %",
                100.0 * faulty as f64 / tested.max(1) as f64,
                100.0 * self.next_to
            ),
        }
    }
}

/// All line faults of a recording, and what they were found with.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LineFaults {
    /// The faults: those that a sensor file declares, then those found; of each rows first, then columns, in order.
    pub faults: Vec<LineFault>,
    /// Baseline and noise of the recording, where they could be told.
    pub level: Option<Level>,
    /// Frames looked at.
    pub frames: u64,
    /// Frames left out because half of all rows or columns, or more, were out at once: no line's fault.
    pub blank_frames: u64,
    /// Taxels (row · columns + column) that stood at the converter's ceiling in three frames in a row, or in all:
    /// pressed beyond it, not stray readings.
    pub held_at_ceiling: Vec<usize>,
}

impl LineFaults {
    /// What a sensor file declares, first, and these where it says nothing of their line.
    pub fn with_declared(self, spec: &ScreenSpec) -> Self {
        let mut faults = Self::from_spec(spec).faults;
        let declared: Vec<_> = faults.iter().map(|f| (f.axis, f.index)).collect();
        let found = self.faults.into_iter();
        faults.extend(found.filter(|f| !declared.contains(&(f.axis, f.index))));
        Self { faults, ..self }
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
            has_fallen: false,
            next_to: 0.0,
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

    /// Lines that may be dead: nothing is marked for these.
    pub fn suspects(&self) -> impl Iterator<Item = &LineFault> {
        let faults = self.faults.iter();
        faults.filter(|fault| fault.kind == LineFaultKind::Suspect)
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

    /// Whether any line comes and goes.
    pub(super) fn has_flickering(&self) -> bool {
        let kinds = self.faults.iter().map(|fault| fault.kind);
        kinds
            .into_iter()
            .any(|kind| kind == LineFaultKind::Flickering)
    }

    /// Whether nothing was found.
    pub fn is_empty(&self) -> bool {
        self.faults.is_empty()
    }
}
