//! Lines that read nothing while the same load stands on every taxel: nothing else is as plain a fault.

use super::evidence::typical;
use super::{CalibrationData, PressLabel};
use crate::screen::{Axis, Level, LineFault, LineFaultKind, LineFaults};
use crate::sensor::ScreenSpec;
use crate::stats::median;
use crate::{Counts, Frame, Mark, Sensor};

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

    /// Lines that were silent: in all loaded frames dead, in some flickering; `usual_counts` is what the frames read.
    pub(super) fn faults(&self, usual_counts: f64) -> Vec<LineFault> {
        let lines = |axis, counts: &[usize]| {
            let silent = counts.iter().enumerate().filter(|(_, count)| **count > 0);
            let fault = silent.map(|(index, &count)| LineFault {
                axis,
                index,
                kind: if count == self.frames {
                    LineFaultKind::Dead
                } else {
                    LineFaultKind::Flickering
                },
                faulty: count as u64,
                tested: self.frames as u64,
                median_counts: 0.0,
                has_fallen: false,
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

/// Standard deviations of noise above the baseline up to which a reading is that of an unloaded taxel.
const UNLOADED_SIGMAS: f64 = 8.0;

/// Fewest frames under an even load in all of which a dead line is silent.
const MIN_SILENT: u64 = 2;

/// Adds lines that read nothing under an even load, in all frames or in some: no other load beside them tells as much. A line
/// on which a labelled press is read is not dead, but was not reached by the even load.
pub(super) fn add_silent(faults: &mut LineFaults, sensor: &Sensor, data: &CalibrationData) {
    let loaded = data.uniform.iter().filter(|(_, load_g)| *load_g > 0.0);
    let mut silent: Option<Silent> = None;
    let mut usual = Vec::new();
    for (frame, _) in loaded {
        let silent = silent.get_or_insert_with(|| Silent::new(frame.rows(), frame.columns()));
        usual.push(typical(frame));
        let mut looked_at = frame.clone();
        // A line without a taxel reads nothing, and is not dead.
        sensor.mark_absent(looked_at.marks_mut());
        silent.mark(&mut looked_at);
    }
    let usual_counts = crate::stats::median(usual).unwrap_or(0.0);
    let found = silent.map_or_else(Vec::new, |silent| silent.faults(usual_counts));
    for fault in found {
        let is_line = |known: &LineFault| (known.axis, known.index) == (fault.axis, fault.index);
        let is_known = |known: &LineFault| is_line(known) && known.kind != LineFaultKind::Suspect;
        let is_on = |press: &&PressLabel| match fault.axis {
            Axis::Row => press.row == fault.index,
            Axis::Column => press.column == fault.index,
        };
        let reads = |press: &PressLabel| {
            let counts = data.frames[press.frame].at(press.row, press.column);
            !is_unloaded(faults, counts)
        };
        let mut pressed = data.presses.iter().filter(is_on);
        let is_sure = fault.kind == LineFaultKind::Flickering
            || fault.tested >= MIN_SILENT && !pressed.any(reads);
        if is_sure && !faults.faults.iter().any(is_known) {
            // What was a suspicion is more than that now.
            faults.faults.retain(|known| !is_line(known));
            faults.faults.push(fault);
        }
    }
}

/// Whether a reading is one of an unloaded taxel.
pub(super) fn is_unloaded(faults: &LineFaults, counts: f64) -> bool {
    let most = |level: Level| level.baseline_counts + UNLOADED_SIGMAS * level.noise_counts;
    faults.level.is_some_and(|level| counts <= most(level))
}

/// Marks what stands on a line that comes and goes, and reads nothing under an even load.
pub(super) fn mark_silent(frame: &mut Frame<Counts>, load_g: f64, faults: &LineFaults) {
    if load_g <= 0.0 {
        return;
    }
    let mut looked_at = frame.clone();
    Silent::new(frame.rows(), frame.columns()).mark(&mut looked_at);
    let columns = frame.columns();
    for (taxel, silent) in looked_at.marks().iter().enumerate() {
        let (row, column) = (taxel / columns, taxel % columns);
        let mark = &mut frame.marks_mut()[taxel];
        if *silent == Mark::Open && *mark == Mark::Good && comes_and_goes(faults, row, column) {
            *mark = Mark::Flickering;
        }
    }
}

pub(super) fn comes_and_goes(faults: &LineFaults, row: usize, column: usize) -> bool {
    faults.flickering_rows().any(|line| line == row)
        || faults.flickering_columns().any(|line| line == column)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensor::{Population, preset};

    /// Column 0 has no taxel, column 3 reads nothing.
    #[test]
    fn a_line_without_a_taxel_is_not_dead() {
        let mat = preset("mat-16x16-cd4067").unwrap();
        let sensor = mat.edited(|spec| {
            let row = (0..16).map(|column| f64::from(u8::from(column > 0)));
            spec.array.population = Some(Population::Each(vec![row.collect(); 16]));
        });
        let sensor = sensor.unwrap();
        let mut frame = Frame::<Counts>::zeros(16, 16);
        for (at, value) in frame.values_mut().iter_mut().enumerate() {
            *value = if matches!(at % 16, 0 | 3) { 0.0 } else { 500.0 };
        }
        let data = CalibrationData {
            uniform: vec![(frame.clone(), 100.0), (frame, 200.0)],
            ..CalibrationData::default()
        };
        let mut faults = LineFaults::default();
        add_silent(&mut faults, &sensor, &data);
        let found: Vec<usize> = faults.dead(Axis::Column).collect();
        assert_eq!(found, [3]);
        assert_eq!(faults.faults.len(), 1);
    }
}
