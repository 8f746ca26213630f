//! Replacing what was not measured, where that is asked for.

use crate::frame::has_mark;
use crate::stats::median_high;
use crate::{Frame, Mark};

/// Whether a value is worth replacing: what was not measured. A saturated reading is a lower bound, and an
/// unresolved one an estimate with a large error: a guess from the neighbours is worse than either.
fn is_lost(mark: Mark) -> bool {
    matches!(
        mark,
        Mark::Open | Mark::Stuck | Mark::Spike | Mark::Flickering | Mark::Shorted
    )
}

/// Replaces each reading that is open, stuck, a spike, flickering or shorted by the median of the valid readings
/// around it (the 8 neighbours; where none is valid, the ring beyond, and so on) and marks it
/// [`Mark::Interpolated`]. Valid are good and saturated readings and those below the floor; repaired ones never serve to repair others, so
/// the order does not matter. Returns how many were replaced; with nothing valid in the whole frame, none.
///
/// `scratch` is cleared and its capacity reused: a number for each taxel and for each line, and those of one ring.
pub fn repair<Q>(frame: &mut Frame<Q>, scratch: &mut Vec<f64>) -> usize {
    replace(frame, scratch, is_lost, Some(Mark::Interpolated))
}

/// The same for single readings alone (stuck, spikes): whole lines stay marked as they are, since their neighbours
/// say little of what lies along them.
pub fn repair_readings<Q>(frame: &mut Frame<Q>, scratch: &mut Vec<f64>) -> usize {
    replace(frame, scratch, Mark::is_stray, Some(Mark::Interpolated))
}

/// Gives single lost readings (stuck, spikes) the median of the valid ones around them, so that the rest of the
/// network can be solved as if they had been read. They keep their mark: this is no repair of the reading.
pub(crate) fn stand_in<Q>(frame: &mut Frame<Q>, scratch: &mut Vec<f64>) -> usize {
    fill(frame, scratch, Mark::is_stray)
}

/// Gives the taxels whose mark is `wanted` the median of the valid ones around them; they keep their mark.
pub(crate) fn fill<Q>(
    frame: &mut Frame<Q>,
    scratch: &mut Vec<f64>,
    wanted: impl Fn(Mark) -> bool,
) -> usize {
    replace(frame, scratch, wanted, None)
}

fn replace<Q>(
    frame: &mut Frame<Q>,
    scratch: &mut Vec<f64>,
    wanted: impl Fn(Mark) -> bool,
    mark: Option<Mark>,
) -> usize {
    if !has_mark(&frame.marks, &wanted) {
        return 0;
    }
    let (rows, columns) = (frame.rows(), frame.columns());
    let sums = ValidSums::of(frame, scratch);
    // Without a single valid reading every search would look everywhere for nothing.
    if sums.within(scratch, 0, 0, rows.max(columns)) == 0.0 {
        return 0;
    }
    let mut repaired = 0;
    for row in 0..rows {
        for column in 0..columns {
            let i = row * columns + column;
            if !wanted(frame.marks[i]) {
                continue;
            }
            let radius = sums.nearest(scratch, row, column);
            if let Some(value) = median_on_ring(frame, row, column, radius, scratch) {
                frame.values[i] = value;
                if let Some(mark) = mark {
                    frame.marks[i] = mark;
                }
                repaired += 1;
            }
        }
    }
    repaired
}

fn is_valid(mark: Mark) -> bool {
    mark.is_reading()
}

/// How many valid readings lie within a square: sums over all rectangles from the first taxel on, so that a square costs
/// four look-ups however large it is. A frame that is lost nearly everywhere then takes no longer than another.
struct ValidSums {
    rows: usize,
    columns: usize,
}

impl ValidSums {
    /// Writes the sums to the front of `sums`, which is cleared first.
    fn of<Q>(frame: &Frame<Q>, sums: &mut Vec<f64>) -> Self {
        let (rows, columns) = (frame.rows(), frame.columns());
        sums.clear();
        sums.resize((rows + 1) * (columns + 1), 0.0);
        for row in 0..rows {
            let mut along = 0.0;
            for column in 0..columns {
                along += f64::from(u8::from(is_valid(frame.marks[row * columns + column])));
                sums[(row + 1) * (columns + 1) + column + 1] =
                    sums[row * (columns + 1) + column + 1] + along;
            }
        }
        Self { rows, columns }
    }

    /// Valid readings at most `radius` away along either axis.
    fn within(&self, sums: &[f64], row: usize, column: usize, radius: usize) -> f64 {
        let (top, left) = (row.saturating_sub(radius), column.saturating_sub(radius));
        let bottom = (row + radius + 1).min(self.rows);
        let right = (column + radius + 1).min(self.columns);
        let at = |row: usize, column: usize| sums[row * (self.columns + 1) + column];
        at(bottom, right) - at(top, right) - at(bottom, left) + at(top, left)
    }

    /// The least radius (1 or more) within which there is a valid reading; there must be one.
    fn nearest(&self, sums: &[f64], row: usize, column: usize) -> usize {
        let (mut none, mut some) = (0, self.rows.max(self.columns));
        while some - none > 1 {
            let middle = none.midpoint(some);
            if self.within(sums, row, column, middle) > 0.0 {
                some = middle
            } else {
                none = middle
            }
        }
        some
    }
}

/// The median of the valid readings exactly `radius` away. `scratch` keeps what is in it: readings come behind.
fn median_on_ring<Q>(
    frame: &Frame<Q>,
    row: usize,
    column: usize,
    radius: usize,
    scratch: &mut Vec<f64>,
) -> Option<f64> {
    let before = scratch.len();
    let mut see = |row: usize, column: usize| {
        let i = row * frame.columns() + column;
        if is_valid(frame.marks[i]) {
            scratch.push(frame.values[i]);
        }
    };
    let last_row = (row + radius).min(frame.rows() - 1);
    let (left, right) = (
        column.saturating_sub(radius),
        (column + radius).min(frame.columns() - 1),
    );
    for r in row.saturating_sub(radius)..=last_row {
        if r.abs_diff(row) == radius {
            (left..=right).for_each(|c| see(r, c));
            continue;
        }
        if column >= radius {
            see(r, column - radius);
        }
        if column + radius < frame.columns() {
            see(r, column + radius);
        }
    }
    let value = median_high(&mut scratch[before..]);
    scratch.truncate(before);
    value
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Newtons, Siemens};

    #[test]
    fn a_stuck_reading_becomes_the_median_of_its_neighbours_and_says_so() {
        let values = vec![1.0, 2.0, 3.0, 4.0, 99.0, 5.0, 6.0, 7.0, 8.0];
        let mut frame = Frame::<Siemens>::new(3, 3, values).unwrap();
        frame.marks_mut()[4] = Mark::Stuck;
        assert_eq!(repair(&mut frame, &mut Vec::new()), 1);
        assert_eq!(frame.at(1, 1), 5.0);
        assert_eq!(frame.mark_at(1, 1), Mark::Interpolated);
        assert_eq!(frame.count(Mark::Good), 8);
    }

    #[test]
    fn a_hole_three_wide_is_filled_from_the_ring_beyond() {
        let mut frame = Frame::<Newtons>::filled(5, 5, 2.0);
        for r in 1..4 {
            for c in 1..4 {
                frame.values_mut()[r * 5 + c] = 1e6;
                frame.marks_mut()[r * 5 + c] = Mark::Flickering;
            }
        }
        assert_eq!(repair(&mut frame, &mut Vec::new()), 9);
        assert!(frame.values().iter().all(|&v| v == 2.0));
    }

    #[test]
    fn lower_bounds_and_good_readings_stay() {
        let mut frame = Frame::<Newtons>::filled(2, 2, 3.0);
        frame.marks_mut()[0] = Mark::Saturated;
        frame.marks_mut()[1] = Mark::Unresolved;
        let before = frame.clone();
        assert_eq!(repair(&mut frame, &mut Vec::new()), 0);
        assert_eq!(frame, before);
    }

    #[test]
    fn the_nearest_ring_with_a_valid_reading_is_taken_wherever_it_lies() {
        // Only the last taxel of a long strip, and of a square, is valid.
        for (rows, columns) in [(1, 50), (50, 1), (33, 40)] {
            let mut frame = Frame::<Newtons>::filled(rows, columns, 7.0);
            frame.marks_mut().fill(Mark::Stuck);
            *frame.marks_mut().last_mut().unwrap() = Mark::Good;
            let repaired = repair(&mut frame, &mut Vec::new());
            assert_eq!(repaired, rows * columns - 1);
            assert!(frame.values().iter().all(|&v| v == 7.0));
        }
    }

    #[test]
    fn with_nothing_valid_nothing_is_made_up() {
        let mut frame = Frame::<Newtons>::filled(2, 2, 3.0);
        frame.marks_mut().fill(Mark::Open);
        assert_eq!(repair(&mut frame, &mut Vec::new()), 0);
        assert_eq!(frame.count(Mark::Open), 4);
    }
}
