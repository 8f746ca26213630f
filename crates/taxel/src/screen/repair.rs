//! Replacing what was not measured, where that is asked for.

use std::ops::Range;

use crate::frame::has_mark;
use crate::sensor::Rings;
use crate::stats::median_high;
use crate::{Frame, Mark, Sensor};

/// Whether a value is worth replacing: what was not measured. A saturated reading is a lower bound, and an
/// unresolved one an estimate with a large error: a guess from the neighbours is worse than either.
fn is_lost(mark: Mark) -> bool {
    matches!(
        mark,
        Mark::Open | Mark::Stuck | Mark::Spike | Mark::Flickering | Mark::Shorted
    )
}

/// What lies beside what on an array, and room to look around in: of one sensor, used for one frame after the other.
#[derive(Debug, Clone, Default)]
pub struct Surroundings {
    /// How the rings of a handle run whose seam is closed.
    rings: Option<Rings>,
    scratch: Vec<f64>,
}

impl Surroundings {
    /// Of the taxels of a sensor: those of a handle whose seam is closed lie beside each other across it.
    pub fn of_sensor(sensor: &Sensor) -> Self {
        let (rows, columns) = (sensor.rows(), sensor.columns());
        Self {
            rings: sensor.closed_rings(),
            // A number for each taxel and for each line, and those of one ring.
            scratch: Vec::with_capacity((rows + 1) * (columns + 1) + 2 * (rows + columns)),
        }
    }
}

/// Replaces each reading that is open, stuck, a spike, flickering or shorted by the median of the valid readings
/// around it (the 8 neighbours; where none is valid, the ring beyond, and so on; across the seam of a handle whose rings
/// close) and marks it [`Mark::Interpolated`]. Valid are good and saturated readings and those below the floor; repaired
/// ones never serve to repair others, so the order does not matter. Returns how many were replaced; with nothing valid in
/// the whole frame, none.
pub fn repair<Q>(frame: &mut Frame<Q>, around: &mut Surroundings) -> usize {
    replace(frame, around, is_lost, Some(Mark::Interpolated))
}

/// The same for single readings alone (stuck, spikes): whole lines stay marked as they are, since their neighbours
/// say little of what lies along them.
pub fn repair_readings<Q>(frame: &mut Frame<Q>, around: &mut Surroundings) -> usize {
    replace(frame, around, Mark::is_stray, Some(Mark::Interpolated))
}

/// Gives single lost readings (stuck, spikes) the median of the valid ones around them, so that the rest of the
/// network can be solved as if they had been read. They keep their mark: this is no repair of the reading.
pub(crate) fn stand_in<Q>(frame: &mut Frame<Q>, around: &mut Surroundings) -> usize {
    fill(frame, around, Mark::is_stray)
}

/// Gives the taxels whose mark is `wanted` the median of the valid ones around them; they keep their mark.
pub(crate) fn fill<Q>(
    frame: &mut Frame<Q>,
    around: &mut Surroundings,
    wanted: impl Fn(Mark) -> bool,
) -> usize {
    replace(frame, around, wanted, None)
}

fn replace<Q>(
    frame: &mut Frame<Q>,
    around: &mut Surroundings,
    wanted: impl Fn(Mark) -> bool,
    mark: Option<Mark>,
) -> usize {
    if !has_mark(&frame.marks, &wanted) {
        return 0;
    }
    let Surroundings { rings, scratch } = around;
    let rings = *rings;
    let (rows, columns) = (frame.rows(), frame.columns());
    let sums = ValidSums::of(frame, scratch);
    let place = |row: usize, column: usize| Place {
        row: OnAxis::at(row, rows, rings == Some(Rings::Columns)),
        column: OnAxis::at(column, columns, rings == Some(Rings::Rows)),
    };
    // Without a single valid reading every search would look everywhere for nothing.
    if sums.within(scratch, &place(0, 0), rows.max(columns)) == 0.0 {
        return 0;
    }
    let mut repaired = 0;
    for row in 0..rows {
        for column in 0..columns {
            let i = row * columns + column;
            if !wanted(frame.marks[i]) {
                continue;
            }
            let place = place(row, column);
            let radius = sums.nearest(scratch, &place);
            if let Some(value) = median_around(frame, &place, radius, scratch) {
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
    fn within(&self, sums: &[f64], place: &Place, radius: usize) -> f64 {
        let at = |row: usize, column: usize| sums[row * (self.columns + 1) + column];
        let mut valid = 0.0;
        for rows in place.row.within(radius) {
            for columns in place.column.within(radius) {
                valid += at(rows.end, columns.end)
                    - at(rows.start, columns.end)
                    - at(rows.end, columns.start)
                    + at(rows.start, columns.start);
            }
        }
        valid
    }

    /// The least radius (1 or more) within which there is a valid reading; there must be one.
    fn nearest(&self, sums: &[f64], place: &Place) -> usize {
        let (mut none, mut some) = (0, self.rows.max(self.columns));
        while some - none > 1 {
            let middle = none.midpoint(some);
            if self.within(sums, place, middle) > 0.0 {
                some = middle
            } else {
                none = middle
            }
        }
        some
    }
}

/// A taxel along one axis.
#[derive(Debug, Clone, Copy)]
struct OnAxis {
    at: usize,
    lines: usize,
    /// Whether the last line is beside the first.
    closes: bool,
}

impl OnAxis {
    fn at(at: usize, lines: usize, closes: bool) -> Self {
        Self { at, lines, closes }
    }

    /// The lines at most `radius` away: in one piece, or in two across a seam.
    fn within(self, radius: usize) -> [Range<usize>; 2] {
        let Self { at, lines, closes } = self;
        let (first, end) = (at.saturating_sub(radius), (at + radius + 1).min(lines));
        if !closes {
            return [first..end, 0..0];
        }
        if 2 * radius + 1 >= lines {
            return [0..lines, 0..0];
        }
        let before = radius.saturating_sub(at);
        let after = (at + radius + 1).saturating_sub(lines);
        if before > 0 {
            [0..end, lines - before..lines]
        } else {
            [0..after, first..end]
        }
    }

    /// The lines just `radius` away.
    fn away(self, radius: usize) -> [Option<usize>; 2] {
        let Self { at, lines, closes } = self;
        if !closes {
            let after = Some(at + radius).filter(|&after| after < lines);
            return [at.checked_sub(radius), after];
        }
        if 2 * radius > lines {
            return [None; 2];
        }
        let after = (at + radius) % lines;
        let before = (at + lines - radius) % lines;
        [Some(before), Some(after).filter(|&after| after != before)]
    }
}

/// A taxel and what its lines are beside.
#[derive(Debug, Clone, Copy)]
struct Place {
    row: OnAxis,
    column: OnAxis,
}

/// The median of the valid readings exactly `radius` away. `scratch` keeps what is in it: readings come behind.
fn median_around<Q>(
    frame: &Frame<Q>,
    place: &Place,
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
    for row in place.row.away(radius).into_iter().flatten() {
        for column in place.column.within(radius).into_iter().flatten() {
            see(row, column);
        }
    }
    for column in place.column.away(radius).into_iter().flatten() {
        for row in place.row.within(radius - 1).into_iter().flatten() {
            see(row, column);
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
        assert_eq!(repair(&mut frame, &mut Surroundings::default()), 1);
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
        assert_eq!(repair(&mut frame, &mut Surroundings::default()), 9);
        assert!(frame.values().iter().all(|&v| v == 2.0));
    }

    #[test]
    fn lower_bounds_and_good_readings_stay() {
        let mut frame = Frame::<Newtons>::filled(2, 2, 3.0);
        frame.marks_mut()[0] = Mark::Saturated;
        frame.marks_mut()[1] = Mark::Unresolved;
        let before = frame.clone();
        assert_eq!(repair(&mut frame, &mut Surroundings::default()), 0);
        assert_eq!(frame, before);
    }

    #[test]
    fn the_nearest_ring_with_a_valid_reading_is_taken_wherever_it_lies() {
        // Only the last taxel of a long strip, and of a square, is valid.
        for (rows, columns) in [(1, 50), (50, 1), (33, 40)] {
            let mut frame = Frame::<Newtons>::filled(rows, columns, 7.0);
            frame.marks_mut().fill(Mark::Stuck);
            *frame.marks_mut().last_mut().unwrap() = Mark::Good;
            let repaired = repair(&mut frame, &mut Surroundings::default());
            assert_eq!(repaired, rows * columns - 1);
            assert!(frame.values().iter().all(|&v| v == 7.0));
        }
    }

    /// By walking all taxels, and the shorter way round.
    fn by_walking(frame: &Frame<Newtons>, rings: Option<Rings>, taxel: usize) -> f64 {
        let (rows, columns) = (frame.rows(), frame.columns());
        let apart = |a: usize, b: usize, lines: usize, closes: bool| {
            let straight = a.abs_diff(b);
            straight.min(if closes { lines - straight } else { straight })
        };
        let away = |other: usize| {
            let of = |i: usize| (i / columns, i % columns);
            let ((r, c), (s, d)) = (of(taxel), of(other));
            let along = apart(r, s, rows, rings == Some(Rings::Columns));
            along.max(apart(c, d, columns, rings == Some(Rings::Rows)))
        };
        let valid = || (0..rows * columns).filter(|&other| frame.marks()[other] == Mark::Good);
        let nearest = valid().map(away).min().unwrap();
        let around = valid().filter(|&other| away(other) == nearest);
        median_high(&mut around.map(|i| frame.values()[i]).collect::<Vec<_>>()).unwrap()
    }

    #[test]
    fn what_lies_beside_the_seam_of_a_closed_handle_is_repaired_from_both_of_its_sides() {
        use rand::{RngExt, SeedableRng};
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(3);
        let all = [None, Some(Rings::Rows), Some(Rings::Columns)];
        for (round, (rows, columns)) in [(7, 12), (12, 7), (4, 4), (5, 2), (2, 5), (9, 9)]
            .into_iter()
            .cycle()
            .take(60)
            .enumerate()
        {
            let values = (0..rows * columns).map(|_| random.random()).collect();
            let mut frame = Frame::<Newtons>::new(rows, columns, values).unwrap();
            let lost = [0.1, 0.5, 0.95][round % 3];
            for mark in frame.marks_mut() {
                if random.random::<f64>() < lost {
                    *mark = Mark::Stuck;
                }
            }
            frame.marks_mut()[round % (rows * columns)] = Mark::Good;
            let rings = all[round / 6 % 3];
            let mut repaired = frame.clone();
            let mut around = Surroundings {
                rings,
                ..Surroundings::default()
            };
            repair(&mut repaired, &mut around);
            for (i, mark) in frame.marks().iter().enumerate() {
                if *mark == Mark::Stuck {
                    assert_eq!(repaired.values()[i], by_walking(&frame, rings, i));
                }
            }
        }
    }

    #[test]
    fn with_nothing_valid_nothing_is_made_up() {
        let mut frame = Frame::<Newtons>::filled(2, 2, 3.0);
        frame.marks_mut().fill(Mark::Open);
        assert_eq!(repair(&mut frame, &mut Surroundings::default()), 0);
        assert_eq!(frame.count(Mark::Open), 4);
    }
}
