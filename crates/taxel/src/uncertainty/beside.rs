//! What a taxel shares of the uncertainty of the loads around it.

use crate::Sensor;
use crate::material::Spread;

/// What of a heavy neighbour's uncertainty a taxel shares: a part of its load that stands elsewhere stands here. Measured on
/// simulated sensors whose loads spread: with nothing of it 2.8 % of unloaded taxels are outside their intervals.
const NEAR_SHARE: f64 = 0.06;

/// Finds, for every taxel of a frame, the load whose uncertainty it shares: a little of the heaviest of its eight neighbours
/// ([`NEAR_SHARE`]), and all that spreads here from them. The latter is undone, but the load that acts here was found with
/// it, and is off by a share of that.
pub(super) struct Beside {
    columns: usize,
    spread: Option<Spread>,
    sizes: Vec<f64>,
    /// The heaviest of a taxel and those beside it in its row.
    in_row: Vec<f64>,
    acting: Vec<f64>,
    found: Vec<f64>,
}

impl Beside {
    pub(super) fn new(sensor: &Sensor) -> Self {
        let taxels = || vec![0.0; sensor.rows() * sensor.columns()];
        let material = sensor.material();
        Self {
            columns: sensor.columns(),
            spread: material.and_then(|material| material.spread.map(Spread::new)),
            sizes: taxels(),
            in_row: taxels(),
            acting: taxels(),
            found: taxels(),
        }
    }

    /// In the unit of the loads.
    pub(super) fn of(&mut self, loads: &[f64]) -> &[f64] {
        self.find_heaviest(loads);
        if let Some(spread) = &self.spread {
            let kept = spread.kept();
            spread.apply(self.columns, loads, &mut self.acting);
            let acting = self.acting.iter().zip(loads);
            for (found, (acting, own)) in self.found.iter_mut().zip(acting) {
                let from_around = acting - kept * own;
                let near = NEAR_SHARE * *found;
                *found = (from_around * from_around + near * near).sqrt();
            }
        } else {
            self.found.iter_mut().for_each(|found| *found *= NEAR_SHARE);
        }
        &self.found
    }

    fn find_heaviest(&mut self, loads: &[f64]) {
        let n = self.columns;
        for (size, load) in self.sizes.iter_mut().zip(loads) {
            *size = load.abs();
        }
        let lines = self
            .sizes
            .chunks_exact(n)
            .zip(self.in_row.chunks_exact_mut(n));
        for ((sizes, in_row), found) in lines.zip(self.found.chunks_exact_mut(n)) {
            found.fill(0.0);
            raise(&mut found[1..], sizes);
            raise(found, &sizes[1..]);
            in_row.copy_from_slice(sizes);
            raise(in_row, found);
        }
        let rows = self.found.len() / n;
        for (r, found) in self.found.chunks_exact_mut(n).enumerate() {
            if let Some(above) = r.checked_sub(1) {
                raise(found, &self.in_row[above * n..r * n]);
            }
            if r + 1 < rows {
                raise(found, &self.in_row[(r + 1) * n..(r + 2) * n]);
            }
        }
    }
}

fn raise(most: &mut [f64], values: &[f64]) {
    for (most, value) in most.iter_mut().zip(values) {
        if *value > *most {
            *most = *value;
        }
    }
}

/// What a load is off by where its spread to the next rows, next columns and across the corners is off by `errors`, in the
/// unit of the loads: to first order a share that is too small leaves here what stands around, less what is taken from here.
pub(super) fn by_spread(errors: [f64; 3], loads: &[f64], columns: usize, taxel: usize) -> f64 {
    let (row, column) = ((taxel / columns) as isize, (taxel % columns) as isize);
    let rows = (loads.len() / columns) as isize;
    let at = |down: isize, right: isize| {
        let (r, c) = (row + down, column + right);
        let is_there = (0..rows).contains(&r) && (0..columns as isize).contains(&c);
        if is_there {
            loads[r as usize * columns + c as usize]
        } else {
            0.0
        }
    };
    let own = loads[taxel];
    let [to_row, to_column, across] = errors;
    let by_row = to_row * (at(-1, 0) + at(1, 0) - 2.0 * own);
    let by_column = to_column * (at(0, -1) + at(0, 1) - 2.0 * own);
    let around = at(-1, -1) + at(-1, 1) + at(1, -1) + at(1, 1);
    let by_corner = across * (around - 4.0 * own);
    (by_row * by_row + by_column * by_column + by_corner * by_corner).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensor::preset;

    #[test]
    fn it_is_a_little_of_the_heaviest_neighbour_and_what_spreads_here() {
        let mat = preset("mat-16x16-cd4067").unwrap();
        for shares in [None, Some([0.04, 0.03, 0.002])] {
            let sensor = mat.edited(|spec| spec.material.as_mut().unwrap().spread = shares);
            let load = |taxel: usize| ((taxel * taxel) % 37) as f64 * ((taxel % 5) as f64 - 1.0);
            let loads: Vec<f64> = (0..256).map(load).collect();
            let mut beside = Beside::new(&sensor.unwrap());
            beside.of(&vec![1e3; 256]);
            let found = beside.of(&loads);
            for (taxel, found) in found.iter().enumerate() {
                let near = |other: &usize| {
                    let apart = |axis: fn(usize) -> usize| axis(taxel).abs_diff(axis(*other));
                    let apart = (apart(|t| t / 16), apart(|t| t % 16));
                    apart.0 <= 1 && apart.1 <= 1 && apart != (0, 0)
                };
                let others: Vec<usize> = (0..256).filter(near).collect();
                let heaviest = others.iter().map(|&o| loads[o].abs()).fold(0.0, f64::max);
                let [row, column, corner] = shares.unwrap_or_default();
                let share =
                    |other: &usize| match (other / 16 == taxel / 16, other % 16 == taxel % 16) {
                        (true, _) => column,
                        (_, true) => row,
                        _ => corner,
                    };
                let spreads: f64 = others.iter().map(|o| share(o) * loads[*o]).sum();
                let expected = spreads.hypot(NEAR_SHARE * heaviest);
                assert!(
                    (found - expected).abs() < 1e-9,
                    "{taxel}: {found} {expected}"
                );
            }
        }
    }

    /// Against a spread that is undone with a share that is a little off: a lone load, an even contact, the edge.
    #[test]
    fn a_wrong_spread_leaves_what_it_says() {
        let (rows, columns) = (7, 8);
        let mut loads = vec![0.0; rows * columns];
        loads[2 * columns + 2] = 600.0;
        for row in 4..7 {
            for column in 4..8 {
                loads[row * columns + column] = 100.0;
            }
        }
        let truth = [0.004, 0.003, 0.001];
        let off = 5e-4;
        for which in 0..3 {
            let mut errors = [0.0; 3];
            errors[which] = off;
            let mut wrong = truth;
            wrong[which] += off;
            let (mut acting, mut found) = (loads.clone(), loads.clone());
            Spread::new(truth).apply(columns, &loads, &mut acting);
            let mut work = vec![0.0; Spread::room(loads.len(), columns)];
            Spread::new(wrong).undo(columns, &[], &acting, &mut found, &mut work);
            for taxel in 0..loads.len() {
                let says = by_spread(errors, &loads, columns, taxel);
                let is = (found[taxel] - loads[taxel]).abs();
                assert!(
                    (says - is).abs() < 0.03 * says.max(600.0 * off),
                    "{which} {taxel}: {says} {is}"
                );
            }
        }
        // A press that stands alone: 600 g · 0.0005 beside it, twice that on it.
        let says = |taxel| by_spread([off, 0.0, 0.0], &loads, columns, taxel);
        assert!(
            (says(columns + 2) - 0.3).abs() < 1e-12 && (says(2 * columns + 2) - 0.6).abs() < 1e-12
        );
    }
}
