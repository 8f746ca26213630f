//! Replacing what was not measured, where that is asked for.

use super::median;
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
/// [`Mark::Interpolated`]. Valid are good and saturated readings; repaired ones never serve to repair others, so
/// the order does not matter. Returns how many were replaced; with nothing valid in the whole frame, none.
///
/// `scratch` is cleared and its capacity reused; 8 values suffice in most frames.
pub fn repair<Q>(frame: &mut Frame<Q>, scratch: &mut Vec<f64>) -> usize {
    replace(frame, scratch, is_lost, Some(Mark::Interpolated))
}

/// The same for single readings alone (stuck, spikes): whole lines stay marked as they are, since their neighbours
/// say little of what lies along them.
pub fn repair_readings<Q>(frame: &mut Frame<Q>, scratch: &mut Vec<f64>) -> usize {
    replace(
        frame,
        scratch,
        |mark| matches!(mark, Mark::Stuck | Mark::Spike),
        Some(Mark::Interpolated),
    )
}

/// Gives single lost readings (stuck, spikes) the median of the valid ones around them, so that the rest of the
/// network can be solved as if they had been read. They keep their mark: this is no repair of the reading.
pub(crate) fn stand_in<Q>(frame: &mut Frame<Q>, scratch: &mut Vec<f64>) -> usize {
    fill(frame, scratch, |mark| {
        matches!(mark, Mark::Stuck | Mark::Spike)
    })
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
    let (rows, columns) = (frame.rows(), frame.columns());
    let mut repaired = 0;
    for row in 0..rows {
        for column in 0..columns {
            if !wanted(frame.mark_at(row, column)) {
                continue;
            }
            let farthest = rows.max(columns);
            let found = (1..farthest).find_map(|radius| {
                valid_within(frame, row, column, radius, scratch);
                median(scratch)
            });
            if let Some(value) = found {
                let i = row * columns + column;
                frame.values_mut()[i] = value;
                if let Some(mark) = mark {
                    frame.marks_mut()[i] = mark;
                }
                repaired += 1;
            }
        }
    }
    repaired
}

/// Valid readings at most `radius` away along either axis.
fn valid_within<Q>(
    frame: &Frame<Q>,
    row: usize,
    column: usize,
    radius: usize,
    values: &mut Vec<f64>,
) {
    values.clear();
    let last_row = (row + radius).min(frame.rows() - 1);
    let last_column = (column + radius).min(frame.columns() - 1);
    for r in row.saturating_sub(radius)..=last_row {
        for c in column.saturating_sub(radius)..=last_column {
            if matches!(frame.mark_at(r, c), Mark::Good | Mark::Saturated) {
                values.push(frame.at(r, c));
            }
        }
    }
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
    fn with_nothing_valid_nothing_is_made_up() {
        let mut frame = Frame::<Newtons>::filled(2, 2, 3.0);
        frame.marks_mut().fill(Mark::Open);
        assert_eq!(repair(&mut frame, &mut Vec::new()), 0);
        assert_eq!(frame.count(Mark::Open), 4);
    }
}
