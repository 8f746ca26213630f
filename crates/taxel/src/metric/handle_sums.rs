//! Sums of a frame round a handle by its rings and by its lines, in one pass: all its figures are made of these.

use super::grip::{MeanDirection, Piece, each_piece, resultant};
use super::is_usable;
use super::sums::{LANES, each_eight, only};
use crate::frame::are_zeros;
use crate::sensor::{Handle, Rings};
use crate::{Frame, Newtons};

/// Rows, and columns, that there is room for; a frame of more is summed up figure by figure.
const MOST: usize = 256;

/// What the loads of each row, or of each column, add up to; of the taxels that count.
struct Axis<const N: usize> {
    /// All loads, newtons.
    all: [f64; N],
    /// Those above the threshold.
    touching: [f64; N],
    /// How many of these there are.
    touched: [f64; N],
    /// The largest load, 0 at least.
    most: [f64; N],
}

impl<const N: usize> Axis<N> {
    const NOTHING: Self = Self {
        all: [0.0; N],
        touching: [0.0; N],
        touched: [0.0; N],
        most: [0.0; N],
    };

    /// Adds eight loads to eight of its lines.
    #[inline(always)]
    fn add(&mut self, at: usize, loads: &[f64; LANES], threshold: f64) {
        let of = at..at + LANES;
        let (all, touching) = (&mut self.all[of.clone()], &mut self.touching[of.clone()]);
        let (touched, most) = (&mut self.touched[of.clone()], &mut self.most[of]);
        for lane in 0..LANES {
            let (load, is_touched) = (loads[lane], loads[lane] > threshold);
            all[lane] += load;
            touching[lane] += only(is_touched, load);
            touched[lane] += only(is_touched, 1.0);
            most[lane] = if load > most[lane] { load } else { most[lane] };
        }
    }

    /// One line becomes what eight places of it add up to, which are nothing again.
    fn gather(&mut self, line: usize, places: &mut Axis<LANES>) {
        self.all[line] = places.all.iter().sum();
        self.touching[line] = places.touching.iter().sum();
        self.touched[line] = places.touched.iter().sum();
        self.most[line] = places.most.iter().copied().fold(0.0, f64::max);
        *places = Axis::NOTHING;
    }
}

/// Sums of a frame round a handle.
pub(super) struct HandleSums<'a> {
    handle: &'a Handle,
    rings: Axis<MOST>,
    lines: Axis<MOST>,
}

impl<'a> HandleSums<'a> {
    /// `None` of a frame of loads below nothing alone, of one that is no number or of no taxel that counts, where what is not pressed counts as touched (what
    /// is 0 is left out here), and of more lines than there is room for.
    pub(super) fn of(
        loads: &Frame<Newtons>,
        handle: &'a Handle,
        threshold_newtons: f64,
    ) -> Option<Self> {
        let has_room = loads.rows() <= MOST && loads.columns() <= MOST;
        if !has_room || threshold_newtons.is_nan() || threshold_newtons < 0.0 {
            return None;
        }
        let (mut rows, mut columns) = (Axis::NOTHING, Axis::NOTHING);
        let (mut of_row, mut before) = (Axis::NOTHING, 0);
        let mut has_loads = false;
        each_eight(loads, |[row, column], eight| {
            if row != before {
                rows.gather(before, &mut of_row);
                before = row;
            }
            // Most of what a sensor shows is nothing.
            if !are_zeros(eight) {
                has_loads = true;
                columns.add(column, eight, threshold_newtons);
                of_row.add(0, eight, threshold_newtons);
            }
        });
        rows.gather(before, &mut of_row);
        let is_told = if has_loads {
            rows.most.iter().any(|&most| most > 0.0) && !rows.all.iter().any(|sum| sum.is_nan())
        } else {
            loads.marks().iter().any(|&mark| is_usable(mark))
        };
        let (rings, lines) = match handle.rings {
            Rings::Rows => (rows, columns),
            Rings::Columns => (columns, rows),
        };
        is_told.then_some(Self {
            handle,
            rings,
            lines,
        })
    }

    /// Sum of all loads, newtons.
    pub(super) fn total_newtons(&self) -> f64 {
        self.lines.all.iter().sum()
    }

    /// The largest load of each ring, newtons, and how many of its taxels are touched.
    pub(super) fn rings(&self) -> impl Iterator<Item = (usize, f64, f64)> {
        let rings = 0..self.handle.radii_mm.len();
        rings.map(|ring| (ring, self.rings.most[ring], self.rings.touched[ring]))
    }

    /// Directions and the force along them, piece by piece.
    pub(super) fn each_piece(&self, take: impl FnMut(&Piece)) {
        each_piece(|line| self.lines.all[line], self.handle, take);
    }

    /// As [`super::resultant_newtons`].
    pub(super) fn resultant_newtons(&self) -> [f64; 3] {
        resultant(|line| self.lines.all[line], self.handle)
    }

    /// As [`super::centre_on_handle_mm`].
    pub(super) fn centre_mm(&self) -> Option<[f64; 2]> {
        let (mut sum, mut x, mut y) = (0.0, 0.0, 0.0);
        let lines = self.handle.angles.len();
        for (line, &load) in self.lines.touching[..lines].iter().enumerate() {
            let (sin, cos) = self.handle.sin_cos(line);
            sum += load;
            (x, y) = (x + load * cos, y + load * sin);
        }
        let by_ring = self.rings.touching.iter().enumerate();
        let ring_sum = by_ring.map(|(ring, load)| load * ring as f64).sum();
        MeanDirection::of_sums(sum, [x, y], ring_sum, self.handle).map(|mean| mean.place_mm())
    }
}
