//! Lines that read nothing while the same load stands on every taxel: nothing else is as plain a fault.

use crate::screen::{Axis, LineFault, LineFaultKind};
use crate::sensor::ScreenSpec;
use crate::stats::median;
use crate::{Frame, Mark};

/// A line is silent whose median reading is less than this share of the frame's.
const SHARE: f64 = 0.1;

/// How often each line was silent.
pub(super) struct Silent {
    rows: Vec<usize>,
    columns: Vec<usize>,
    frames: usize,
}

impl Silent {
    pub(super) fn new(rows: usize, columns: usize) -> Self {
        Self {
            rows: vec![0; rows],
            columns: vec![0; columns],
            frames: 0,
        }
    }

    /// Marks every taxel of a silent line as open, in a frame under a load.
    pub(super) fn mark<Q>(&mut self, frame: &mut Frame<Q>) {
        let (rows, columns) = (frame.rows(), frame.columns());
        self.frames += 1;
        let line = |row: Option<usize>, column: Option<usize>| -> Option<f64> {
            let on = |taxel: &usize| {
                row.is_none_or(|row| taxel / columns == row)
                    && column.is_none_or(|column| taxel % columns == column)
            };
            let there = (0..rows * columns).filter(on);
            let there = there.filter(|&taxel| frame.marks()[taxel] != Mark::Absent);
            median(there.map(|taxel| frame.values()[taxel].abs()))
        };
        let Some(usual) = line(None, None) else {
            return;
        };
        let is_silent = |reads: Option<f64>| reads.is_some_and(|reads| reads < SHARE * usual);
        let silent_rows: Vec<usize> = (0..rows)
            .filter(|&r| is_silent(line(Some(r), None)))
            .collect();
        let silent_columns: Vec<usize> = (0..columns)
            .filter(|&c| is_silent(line(None, Some(c))))
            .collect();
        for &row in &silent_rows {
            self.rows[row] += 1;
        }
        for &column in &silent_columns {
            self.columns[column] += 1;
        }
        for (taxel, mark) in frame.marks_mut().iter_mut().enumerate() {
            let is_out = silent_rows.contains(&(taxel / columns))
                || silent_columns.contains(&(taxel % columns));
            if is_out && *mark != Mark::Absent {
                *mark = Mark::Open;
            }
        }
    }

    /// Adds them to what a sensor file says of its lines: silent in all loaded frames is dead, in some flickering.
    pub(super) fn declare(&self, screen: &mut ScreenSpec) {
        for (counts, dead, flickering) in [
            (
                &self.rows,
                &mut screen.dead_rows,
                &mut screen.flickering_rows,
            ),
            (
                &self.columns,
                &mut screen.dead_columns,
                &mut screen.flickering_columns,
            ),
        ] {
            for (line, &count) in counts.iter().enumerate().filter(|(_, count)| **count > 0) {
                let list = if count == self.frames {
                    &mut *dead
                } else {
                    &mut *flickering
                };
                list.push(line);
            }
            for list in [dead, flickering] {
                list.sort_unstable();
                list.dedup();
            }
        }
    }

    /// Lines that were silent in some loaded frames and not in all; `usual_counts` is what frames read when they were.
    pub(super) fn flickering(&self, usual_counts: f64) -> Vec<LineFault> {
        let lines = |axis, counts: &[usize]| {
            let some = |&(_, count): &(usize, &usize)| *count > 0 && *count < self.frames;
            let found = counts.iter().enumerate().filter(some);
            let fault = found.map(|(index, &count)| LineFault {
                axis,
                index,
                kind: LineFaultKind::Flickering,
                faulty: count as u64,
                tested: self.frames as u64,
                median_counts: 0.0,
                next_to: usual_counts,
            });
            fault.collect::<Vec<_>>()
        };
        [
            lines(Axis::Row, &self.rows),
            lines(Axis::Column, &self.columns),
        ]
        .concat()
    }

    /// What is to be said of them.
    pub(super) fn words(&self) -> Vec<String> {
        let axes = [("row", &self.rows), ("column", &self.columns)];
        let said = axes.into_iter().flat_map(|(axis, counts)| {
            let silent = counts.iter().enumerate().filter(|(_, count)| **count > 0);
            silent.map(move |(line, count)| {
                format!(
                    "{axis} {line} reads nothing in {count} of {} loaded frames",
                    self.frames
                )
            })
        });
        said.collect()
    }
}
