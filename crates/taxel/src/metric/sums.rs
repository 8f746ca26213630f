//! All sums of a frame in one pass, eight taxels at a time.

use super::is_usable;
use crate::frame::{all_good, are_zeros};
use crate::{Frame, Mark, Newtons};

/// Taxels that are looked at together.
pub(super) const LANES: usize = 8;
/// A bit for each mark by its code: whether a taxel with it counts.
const USABLE: u16 = {
    let (mut bits, mut at) = (0, 0);
    while at < Mark::ALL.len() {
        bits |= (is_usable(Mark::ALL[at]) as u16) << at;
        at += 1;
    }
    bits
};

/// What the loads of a frame add up to: as the functions of this module find one by one, bit for bit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Sums {
    /// Of the taxels that count, newtons.
    pub(super) total_newtons: f64,
    /// Whether any of them is not 0.
    has_loads: bool,
    /// The largest of them, at each place of the eight.
    most_newtons: [f64; LANES],
    /// Of the cells that are touched.
    pub(super) contact_area_mm2: f64,
    /// Loads that touch, by their row, by their column, and alone.
    by_row: f64,
    by_column: f64,
    touching: f64,
}

impl Sums {
    /// Of taxels that all have one cell and lie where their lines cross. `None` of a frame of loads below nothing alone, and where
    /// what is not pressed counts as touched: what is 0 is left out here, and would be seen there.
    pub(super) fn of(
        loads: &Frame<Newtons>,
        cell_mm2: f64,
        threshold_newtons: f64,
    ) -> Option<Self> {
        if threshold_newtons.is_nan() || threshold_newtons < 0.0 {
            return None;
        }
        let mut sums = Self {
            total_newtons: 0.0,
            has_loads: false,
            most_newtons: [0.0; LANES],
            contact_area_mm2: 0.0,
            by_row: 0.0,
            by_column: 0.0,
            touching: 0.0,
        };
        each_eight(loads, |at, eight| {
            sums.add(at, eight, cell_mm2, threshold_newtons);
        });
        let is_told = if sums.has_loads {
            sums.most_newtons() > 0.0 && !sums.total_newtons.is_nan()
        } else {
            // Of no taxels at all the sum is another zero.
            loads.marks().iter().any(|&mark| is_usable(mark))
        };
        is_told.then_some(sums)
    }

    #[inline(always)]
    fn add(
        &mut self,
        [row, column]: [usize; 2],
        loads: &[f64; LANES],
        cell_mm2: f64,
        threshold_newtons: f64,
    ) {
        // Most of what a mat shows is nothing.
        if are_zeros(loads) {
            return;
        }
        self.has_loads = true;
        let touching = loads.map(|load| only(load > threshold_newtons, load));
        let areas = loads.map(|load| only(load > threshold_newtons, cell_mm2));
        for (most, &load) in self.most_newtons.iter_mut().zip(loads) {
            *most = if load > *most { load } else { *most };
        }
        let row = row as f64;
        for (lane, &load) in loads.iter().enumerate() {
            self.total_newtons += load;
            self.contact_area_mm2 += areas[lane];
            self.by_row += touching[lane] * row;
            self.by_column += touching[lane] * (column + lane) as f64;
            self.touching += touching[lane];
        }
    }

    /// The largest load.
    pub(super) fn most_newtons(&self) -> f64 {
        self.most_newtons.iter().copied().fold(0.0, f64::max)
    }

    /// As [`super::centre_of_pressure_mm`].
    pub(super) fn centre_mm(&self, pitch_mm: [f64; 2]) -> Option<[f64; 2]> {
        (self.touching > 0.0).then(|| {
            [
                pitch_mm[0] * self.by_row / self.touching,
                pitch_mm[1] * self.by_column / self.touching,
            ]
        })
    }
}

/// Goes through a frame row by row, eight columns at a time: the row and the first column, and the loads of taxels that count, 0 of
/// the others. What is 0 all over may be beyond the last column.
#[inline(always)]
pub(super) fn each_eight(loads: &Frame<Newtons>, mut take: impl FnMut([usize; 2], &[f64; LANES])) {
    let columns = loads.columns();
    let lines = loads.values().chunks_exact(columns);
    let lines = lines.zip(loads.marks().chunks_exact(columns));
    for (row, (values, marks)) in lines.enumerate() {
        let (eights, last) = values.as_chunks::<LANES>();
        let (eight_marks, last_marks) = marks.as_chunks::<LANES>();
        let each = eights.iter().zip(eight_marks).enumerate();
        each.for_each(|(at, (values, marks))| take([row, LANES * at], &counting(values, marks)));
        // Behind the last column nothing presses.
        let (mut rest, mut rest_marks) = ([0.0; LANES], [Mark::Good; LANES]);
        rest[..last.len()].copy_from_slice(last);
        rest_marks[..last.len()].copy_from_slice(last_marks);
        take([row, columns - last.len()], &counting(&rest, &rest_marks));
    }
}

/// A number, or 0: without a branch, since loads on a mat are foreseen by nobody.
#[inline(always)]
pub(super) fn only(is_it: bool, number: f64) -> f64 {
    f64::from_bits(number.to_bits() & u64::from(is_it).wrapping_neg())
}

/// Loads of taxels that count, 0 of the others.
#[inline(always)]
fn counting(values: &[f64; LANES], marks: &[Mark; LANES]) -> [f64; LANES] {
    if all_good(marks) {
        return *values;
    }
    std::array::from_fn(|lane| only(USABLE >> marks[lane].code() & 1 == 1, values[lane]))
}
