//! Which labelled presses can be read, and why the others cannot.

use super::silent::{comes_and_goes, is_unloaded};
use super::{CalibrationData, PressLabel};
use crate::screen::{Axis, LineFaults};
use crate::{Counts, Error, Frame, Mark};

/// A larger share of all presses on dead lines is no chance: labels are swapped, or the lines are not dead.
const MOST_ON_DEAD_LINES: f64 = 0.25;

/// The dead line that a press lies on.
fn dead_line(faults: &LineFaults, press: &PressLabel) -> Option<String> {
    let lines = [(Axis::Row, press.row), (Axis::Column, press.column)];
    let is_dead = |&(axis, line): &(Axis, usize)| faults.dead(axis).any(|dead| dead == line);
    let (axis, line) = lines.into_iter().find(is_dead)?;
    Some(format!("{axis} {line}"))
}

/// Refuses presses of which too many lie on dead lines.
fn few_on_dead_lines(
    faults: &LineFaults,
    data: &CalibrationData,
    given: &[usize],
) -> Result<(), Error> {
    let presses = given.iter().map(|&i| &data.presses[i]);
    let on_dead = presses.filter_map(|press| Some((press, dead_line(faults, press)?)));
    let on_dead: Vec<(&PressLabel, String)> = on_dead.collect();
    match on_dead.first() {
        Some((press, line)) if on_dead.len() as f64 > MOST_ON_DEAD_LINES * given.len() as f64 => {
            Err(Error::PressOnDeadLine {
                row: press.row,
                column: press.column,
                frame: data.number_of(press.frame),
                line: line.clone(),
                on_dead_lines: on_dead.len(),
                presses: given.len(),
            })
        }
        _ => Ok(()),
    }
}

impl PressLabel {
    /// What a report calls it.
    pub(super) fn name(&self, data: &CalibrationData) -> String {
        format!(
            "the press of {} g at row {}, column {} (frame {})",
            (1e4 * self.load_g).round() / 1e4,
            self.row,
            self.column,
            data.number_of(self.frame)
        )
    }
}

/// Those of the presses given that can be read, and why the others cannot.
pub(super) fn readable(
    faults: &LineFaults,
    data: &CalibrationData,
    given: &[usize],
    marked: &[Frame<Counts>],
) -> Result<(Vec<usize>, Vec<String>), Error> {
    few_on_dead_lines(faults, data, given)?;
    let (mut kept, mut left_out) = (Vec::new(), Vec::new());
    for &i in given {
        let press = &data.presses[i];
        let frame = &marked[press.frame];
        let named = press.name(data);
        if let Some(line) = dead_line(faults, press) {
            left_out.push(format!("{named}: {line} is dead"));
            continue;
        }
        match frame.mark_at(press.row, press.column) {
            Mark::Good if is_out(faults, press, frame.at(press.row, press.column)) => {
                left_out.push(format!(
                    "{named}: it reads nothing, and its line comes and goes"
                ));
            }
            Mark::Good => kept.push(i),
            mark => left_out.push(format!("{named}: its reading is {}", mark.word())),
        }
    }
    leave_out_beside_ceiling(data, marked, &mut kept, &mut left_out);
    Ok((kept, left_out))
}

/// Whether a press reads nothing on a line that comes and goes, and was out.
fn is_out(faults: &LineFaults, press: &PressLabel, counts: f64) -> bool {
    comes_and_goes(faults, press.row, press.column)
        && press.load_g > 0.0
        && is_unloaded(faults, counts)
}

/// Fewest presses that are enough without those beside readings at the ceiling.
const MIN_CLEAR: usize = 16;

/// Leaves out presses whose lines carry another reading at the converter's ceiling, where enough others are left: of what
/// presses there only a lower bound is known, and with it of what it does to its lines.
fn leave_out_beside_ceiling(
    data: &CalibrationData,
    marked: &[Frame<Counts>],
    kept: &mut Vec<usize>,
    left_out: &mut Vec<String>,
) {
    let is_clear = |&i: &usize| {
        let press = &data.presses[i];
        let lines = LinesAtCeiling::of(&marked[press.frame]);
        !lines.cross_at(press.row, press.column)
    };
    let clear: Vec<usize> = kept.iter().copied().filter(is_clear).collect();
    if clear.len() < MIN_CLEAR || clear.len() == kept.len() {
        return;
    }
    left_out.push(format!(
        "{} presses whose row or column carries another reading at the converter's ceiling",
        kept.len() - clear.len()
    ));
    *kept = clear;
}

/// The lines of a frame that carry a reading at the converter's ceiling.
pub(super) struct LinesAtCeiling {
    rows: Vec<bool>,
    columns: Vec<bool>,
}

impl LinesAtCeiling {
    pub(super) fn of(frame: &Frame<Counts>) -> Self {
        let mut lines = Self {
            rows: vec![false; frame.rows()],
            columns: vec![false; frame.columns()],
        };
        for (taxel, mark) in frame.marks().iter().enumerate() {
            if *mark == Mark::Saturated {
                lines.rows[taxel / frame.columns()] = true;
                lines.columns[taxel % frame.columns()] = true;
            }
        }
        lines
    }

    /// Whether one of them is a taxel's own.
    pub(super) fn cross_at(&self, row: usize, column: usize) -> bool {
        self.rows[row] || self.columns[column]
    }
}
