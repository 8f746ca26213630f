//! How one map is to be moved to lie on another.

use crate::metric::is_usable;
use crate::sensor::Rings;
use crate::{Frame, Mark, Newtons, Sensor};

/// How one map is to be moved to lie on another.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shift {
    grid: Grid,
    /// Rows and columns.
    by: [isize; 2],
    /// Of the maps once they lie on each other, −1 to 1.
    pub(super) correlation: f64,
}

impl Shift {
    /// The shift by whole lines with the largest correlation; across a closed seam it goes on. Found in maps of fewer, broader lines
    /// first, then line by line around it.
    pub(super) fn between(from: &Frame<Newtons>, to: &Frame<Newtons>, sensor: &Sensor) -> Self {
        let grid = Grid::of(sensor);
        let broad = grid.lines.map(|lines| lines.div_ceil(MAX_COARSE_LINES));
        let fine = [from, to].map(|map| Map::of(map, grid));
        let coarse = fine.each_ref().map(|map| map.broadened(broad));
        let all = coarse[0].grid.lines.map(|lines| lines as isize - 1);
        let (found, _) = coarse[0].best_shift(&coarse[1], [0, 0], all);
        let about = [0, 1].map(|axis| found[axis] * broad[axis] as isize);
        let (by, correlation) = fine[0].best_shift(&fine[1], about, broad.map(|b| b as isize));
        Self {
            grid,
            by,
            correlation,
        }
    }

    /// Where a taxel comes to lie; `None`: off the array.
    pub(super) fn moved(&self, taxel: usize) -> Option<usize> {
        self.grid.moved(taxel, self.by)
    }
}

/// Rows and columns of a map, and along which of them it goes on across a closed seam.
#[derive(Debug, Clone, Copy)]
struct Grid {
    lines: [usize; 2],
    wraps: [bool; 2],
}

impl Grid {
    fn of(sensor: &Sensor) -> Self {
        let closed = sensor.closed_rings();
        Self {
            lines: [sensor.rows(), sensor.columns()],
            wraps: [Rings::Columns, Rings::Rows].map(|rings| closed == Some(rings)),
        }
    }

    /// Where a taxel comes to lie that is moved by so many rows and columns; `None`: off the array.
    fn moved(&self, taxel: usize, by: [isize; 2]) -> Option<usize> {
        let at = [taxel / self.lines[1], taxel % self.lines[1]];
        let step = |axis: usize| -> Option<usize> {
            let (to, all) = (at[axis] as isize + by[axis], self.lines[axis] as isize);
            ((0..all).contains(&to) || self.wraps[axis]).then(|| to.rem_euclid(all) as usize)
        };
        Some(step(0)? * self.lines[1] + step(1)?)
    }
}

/// A taxel takes part above this share of the heaviest.
const TOUCHED: f64 = 0.05;
/// Lines of the maps that a shift is looked for in first, at the most.
const MAX_COARSE_LINES: usize = 32;

/// Loads of a map, none below nothing, row by row.
struct Map {
    grid: Grid,
    loads: Vec<f64>,
}

impl Map {
    fn of(map: &Frame<Newtons>, grid: Grid) -> Self {
        let each = map.values().iter().zip(map.marks());
        let load = |(load, mark): (&f64, &Mark)| if is_usable(*mark) { load.max(0.0) } else { 0.0 };
        Self {
            grid,
            loads: each.map(load).collect(),
        }
    }

    /// The same with so many rows and columns taken together.
    fn broadened(&self, [down, across]: [usize; 2]) -> Self {
        let own = self.grid.lines;
        let lines = [own[0].div_ceil(down), own[1].div_ceil(across)];
        let mut loads = vec![0.0; lines[0] * lines[1]];
        for (taxel, load) in self.loads.iter().enumerate() {
            let (row, column) = (taxel / own[1], taxel % own[1]);
            loads[row / down * lines[1] + column / across] += load;
        }
        Self {
            grid: Grid { lines, ..self.grid },
            loads,
        }
    }

    /// The shift of this map that correlates most with another, of those up to `within` lines from `about`; of shifts as good the
    /// smallest. With that correlation.
    fn best_shift(&self, to: &Self, about: [isize; 2], within: [isize; 2]) -> ([isize; 2], f64) {
        let highest = self.loads.iter().copied().fold(0.0, f64::max);
        let each = self.loads.iter().copied().enumerate();
        let touched: Vec<(usize, f64)> =
            each.filter(|(_, load)| *load > TOUCHED * highest).collect();
        let own: f64 = touched.iter().map(|(_, load)| load * load).sum();
        let other: f64 = to.loads.iter().map(|load| load * load).sum();
        let norm = (own * other).sqrt().max(f64::MIN_POSITIVE);
        let far = |shift: [isize; 2]| shift[0].abs() + shift[1].abs();
        let mut best = ([0, 0], f64::NEG_INFINITY);
        for rows in about[0] - within[0]..=about[0] + within[0] {
            for columns in about[1] - within[1]..=about[1] + within[1] {
                let shift = [rows, columns];
                let there = |taxel: usize| Some(to.loads[self.grid.moved(taxel, shift)?]);
                let both = touched
                    .iter()
                    .filter_map(|(taxel, load)| Some(load * there(*taxel)?));
                let correlation = both.sum::<f64>() / norm;
                let is_as_good = correlation > best.1 - 1e-9 && far(shift) < far(best.0);
                if correlation > best.1 + 1e-9 || is_as_good {
                    best = (shift, correlation);
                }
            }
        }
        best
    }
}
