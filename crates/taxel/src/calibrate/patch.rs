//! The taxels around a press: conductances cut out of a frame, and the loads that a model makes of them.

use super::model::Model;
use crate::material::{LoadLaw, Spread};
use crate::{Frame, Siemens};

/// Taxels around a labelled one that its spread is undone with, to each side.
const REACH: usize = 4;
const SIDE: usize = 2 * REACH + 1;
/// The labelled taxel's place in its patch.
const MIDDLE: usize = SIDE * SIDE / 2;
/// Places of a patch around its middle.
const NEIGHBOURS: [usize; 8] = {
    let (above, below) = (MIDDLE - SIDE, MIDDLE + SIDE);
    [
        above - 1,
        above,
        above + 1,
        MIDDLE - 1,
        MIDDLE + 1,
        below - 1,
        below,
        below + 1,
    ]
};

/// Row and column of a place of the patch around a taxel, where the array has one.
fn place((row, column): (usize, usize), k: usize, shape: [usize; 2]) -> Option<(usize, usize)> {
    let row = (row + k / SIDE).checked_sub(REACH)?;
    let column = (column + k % SIDE).checked_sub(REACH)?;
    (row < shape[0] && column < shape[1]).then_some((row, column))
}

/// Conductances around a taxel, SIDE×SIDE; not finite outside the array.
pub(super) fn cut_out(siemens: &Frame<Siemens>, middle: (usize, usize)) -> Vec<f64> {
    let shape = [siemens.rows(), siemens.columns()];
    (0..SIDE * SIDE)
        .map(|k| place(middle, k, shape).map_or(f64::NAN, |(r, c)| siemens.at(r, c)))
        .collect()
}

/// Loads around one press after the other.
pub(super) struct Patch {
    effective_g: [f64; SIDE * SIDE],
    loads_g: [f64; SIDE * SIDE],
    work: [f64; Spread::room(SIDE * SIDE, SIDE)],
    nowhere: [bool; SIDE * SIDE],
}

impl Default for Patch {
    fn default() -> Self {
        Self {
            effective_g: [0.0; SIDE * SIDE],
            loads_g: [0.0; SIDE * SIDE],
            work: [0.0; Spread::room(SIDE * SIDE, SIDE)],
            nowhere: [false; SIDE * SIDE],
        }
    }
}

impl Patch {
    /// Finds the loads put on the patch from its conductances; of the middle alone where that is all that matters. Beyond
    /// the edge and where no taxel is nothing lies: what spreads there is lost, as where frames are compensated.
    pub(super) fn find(
        &mut self,
        model: &Model,
        law: &LoadLaw,
        middle: (usize, usize),
        siemens: &[f64],
        is_all: bool,
    ) {
        let (sensor, shape) = (&model.sensor, [model.sensor.rows(), model.sensor.columns()]);
        for (k, &siemens) in siemens.iter().enumerate() {
            let taxel = place(middle, k, shape).map(|(r, c)| r * shape[1] + c);
            let taxel = taxel.filter(|&taxel| !sensor.is_absent(taxel));
            self.nowhere[k] = taxel.is_none();
            let taxel = taxel.filter(|_| is_all || k == MIDDLE);
            self.effective_g[k] = taxel.map_or(0.0, |t| law.grams_from_siemens(t, siemens));
        }
        let Some(spread) = model.spread else {
            self.loads_g = self.effective_g;
            return;
        };
        spread.undo(
            SIDE,
            &self.nowhere,
            &self.effective_g,
            &mut self.loads_g,
            &mut self.work,
        );
    }

    /// The load on the middle, grams.
    pub(super) fn load_g(&self) -> f64 {
        self.loads_g[MIDDLE]
    }

    /// The loads on it and as far as its neighbours' neighbours together, grams.
    pub(super) fn together_g(&self) -> f64 {
        let near = |k: &usize| {
            let (row, column) = (k / SIDE, k % SIDE);
            row.abs_diff(REACH) <= 2 && column.abs_diff(REACH) <= 2
        };
        let near = (0..SIDE * SIDE).filter(near).map(|k| self.loads_g[k]);
        near.filter(|load| load.is_finite()).sum()
    }

    /// The loads on its neighbours, grams, where there are taxels.
    pub(super) fn beside_g(&self) -> impl Iterator<Item = f64> {
        let there = NEIGHBOURS.into_iter().filter(|&k| !self.nowhere[k]);
        there.map(|k| self.loads_g[k])
    }
}
