//! Sums of a frame round a handle by its rings and by its lines, in one pass: all its figures are made of these.

use super::grip::{MeanDirection, Piece, each_piece};
use super::is_usable;
use super::sums::{LANES, counting, only};
use crate::frame::are_zeros;
use crate::sensor::{Handle, Rings};
use crate::{Frame, Mark, Newtons};

/// Rows, and columns, that there is room for; a frame of more is summed up figure by figure.
const MOST: usize = 256;

/// What the loads of each row, or of each column, add up to; of the taxels that count.
struct Axis {
    /// All loads, newtons.
    all: [f64; MOST],
    /// Those above the threshold.
    touching: [f64; MOST],
    /// How many of these there are.
    touched: [f64; MOST],
    /// The largest load, 0 at least.
    most: [f64; MOST],
}

impl Axis {
    const NOTHING: Self = Self {
        all: [0.0; MOST],
        touching: [0.0; MOST],
        touched: [0.0; MOST],
        most: [0.0; MOST],
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

    /// Line `to` becomes what eight places of it add up to.
    fn gather(&mut self, to: usize, other: &Eight) {
        self.all[to] = other.all.iter().sum();
        self.touching[to] = other.touching.iter().sum();
        self.touched[to] = other.touched.iter().sum();
        self.most[to] = other.most.iter().copied().fold(0.0, f64::max);
    }
}

/// The same of one row, at each place of eight.
#[derive(Default)]
struct Eight {
    all: [f64; LANES],
    touching: [f64; LANES],
    touched: [f64; LANES],
    most: [f64; LANES],
}

impl Eight {
    #[inline(always)]
    fn add(&mut self, loads: &[f64; LANES], threshold: f64) {
        for (lane, &load) in loads.iter().enumerate() {
            let is_touched = load > threshold;
            self.all[lane] += load;
            self.touching[lane] += only(is_touched, load);
            self.touched[lane] += only(is_touched, 1.0);
            let most = &mut self.most[lane];
            *most = if load > *most { load } else { *most };
        }
    }
}

/// Sums of a frame round a handle.
pub(super) struct HandleSums<'a> {
    handle: &'a Handle,
    rings: Axis,
    lines: Axis,
}

impl<'a> HandleSums<'a> {
    /// `None` of a frame of loads below nothing alone or of no taxel that counts, where what is not pressed counts as touched (what
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
        let mut has_loads = false;
        let width = loads.columns();
        let lines = loads.values().chunks_exact(width);
        let lines = lines.zip(loads.marks().chunks_exact(width));
        for (row, (values, marks)) in lines.enumerate() {
            let mut of_row = Eight::default();
            let mut add = |column: usize, loads: &[f64; LANES]| {
                // Most of what a sensor shows is nothing.
                if !are_zeros(loads) {
                    has_loads = true;
                    columns.add(column, loads, threshold_newtons);
                    of_row.add(loads, threshold_newtons);
                }
            };
            let (eights, last) = values.as_chunks::<LANES>();
            let (eight_marks, last_marks) = marks.as_chunks::<LANES>();
            let each = eights.iter().zip(eight_marks).enumerate();
            each.for_each(|(at, (values, marks))| add(LANES * at, &counting(values, marks)));
            // Behind the last column nothing presses.
            let (mut rest, mut rest_marks) = ([0.0; LANES], [Mark::Good; LANES]);
            rest[..last.len()].copy_from_slice(last);
            rest_marks[..last.len()].copy_from_slice(last_marks);
            if !last.is_empty() {
                add(width - last.len(), &counting(&rest, &rest_marks));
            }
            rows.gather(row, &of_row);
        }
        let is_told = if has_loads {
            rows.most.iter().any(|&most| most > 0.0)
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
        let (outward, along) = (self.handle.slope.cos(), self.handle.slope.sin());
        let mut sum = [0.0; 3];
        for (line, &load) in self.lines.all[..self.handle.angles.len()]
            .iter()
            .enumerate()
        {
            let (sin, cos) = self.handle.sin_cos(line);
            let force = [-load * outward * cos, -load * outward * sin, -load * along];
            (0..3).for_each(|axis| sum[axis] += force[axis]);
        }
        sum
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
