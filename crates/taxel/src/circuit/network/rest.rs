//! Where lines stand when nothing is selected, of read-outs that hold them elsewhere than at ground: u in volts, and w per
//! volt of the follower. Both are the inverse nodal matrix times a source, Z s; its change is −Z dY (Z s).

use super::coupling::add_laplacian;
use super::lumped::{SheetPoint, divide};
use crate::circuit::LineEnds;
use crate::circuit::reading::Rest;
use taxel_linalg::dot;

/// A value of every line of the smaller side, and of every line of the larger.
type Sides = [Vec<f64>; 2];

/// The parts of a solved network that apply its inverse.
#[derive(Clone, Copy)]
pub(super) struct Solved<'a> {
    /// P of the smaller side, m×m, and H, m×n.
    pub(super) p: &'a [f64],
    pub(super) h: &'a [f64],
    pub(super) inverse_d: &'a [f64],
    pub(super) sheet: Option<&'a SheetPoint>,
}

impl Solved<'_> {
    /// out ← Z source: P (s + H l), then T⁻¹ l + Hᵀ of that. Uses up the source.
    fn apply(&self, source: &mut Sides, out: &mut Sides) {
        let n = self.inverse_d.len();
        let [small, large] = source;
        for (small, h) in small.iter_mut().zip(self.h.chunks_exact(n)) {
            *small += dot(h, large);
        }
        for (out, p) in out[0].iter_mut().zip(self.p.chunks_exact(small.len())) {
            *out = dot(p, small);
        }
        divide(self.sheet, self.inverse_d, large);
        out[1].copy_from_slice(large);
        let [small, large] = out;
        for (small, h) in small.iter().zip(self.h.chunks_exact(n)) {
            for (large, h) in large.iter_mut().zip(h) {
                *large += h * small;
            }
        }
    }
}

/// One source at rest and what it does.
struct Kind {
    /// Its part of a derivative.
    of: fn(&Rest) -> f64,
    source: Sides,
    /// Z s.
    at: Sides,
    /// Its change along a direction, or what the gradient by it makes of Z.
    change: Sides,
}

impl Kind {
    fn new(source: Sides, of: fn(&Rest) -> f64) -> Self {
        Self {
            of,
            at: source.clone(),
            change: source.clone(),
            source,
        }
    }
}

/// The potentials of a circuit at one frame of conductances.
pub(super) struct Potentials {
    volts: Kind,
    follows: Kind,
    transposed: bool,
    work: Sides,
}

impl Potentials {
    /// None where all lines at rest stand at ground, or all where the follower does.
    pub(super) fn new(ends: &LineEnds, transposed: bool) -> Option<Self> {
        if !ends.have_potentials() {
            return None;
        }
        let sides = |rows: Vec<f64>, columns: Vec<f64>| {
            if transposed {
                [columns, rows]
            } else {
                [rows, columns]
            }
        };
        let (v_test, from, follow) = (ends.v_test_volts, &ends.to_v_test, &ends.to_follower);
        let amperes = |siemens: &[f64]| siemens.iter().map(|siemens| v_test * siemens).collect();
        let volts = sides(
            amperes(&from.row_unselected),
            amperes(&from.column_unselected),
        );
        let work = volts.clone();
        Some(Self {
            volts: Kind::new(volts, |by| by.volts),
            follows: Kind::new(
                sides(
                    follow.row_unselected.clone(),
                    follow.column_unselected.clone(),
                ),
                |by| by.follows,
            ),
            transposed,
            work,
        })
    }

    /// Takes a network as it was solved.
    pub(super) fn set(&mut self, solved: Solved) {
        for kind in [&mut self.volts, &mut self.follows] {
            for (work, source) in self.work.iter_mut().zip(&kind.source) {
                work.copy_from_slice(source);
            }
            solved.apply(&mut self.work, &mut kind.at);
        }
    }

    /// Of a line of the smaller side and one of the larger, row first.
    pub(super) fn at(&self, small: usize, large: usize) -> [Rest; 2] {
        let rest = |side: usize, line: usize| Rest {
            volts: self.volts.at[side][line],
            follows: self.follows.at[side][line],
        };
        let (small, large) = (rest(0, small), rest(1, large));
        if self.transposed {
            [large, small]
        } else {
            [small, large]
        }
    }

    /// What the potentials' change along a direction (m×n, and of the couplings of both sides) does to a reading is then
    /// [`Self::change_of`].
    pub(super) fn move_along(
        &mut self,
        solved: Solved,
        direction: &[f64],
        [of_small, of_large]: [&[f64]; 2],
    ) {
        let n = solved.inverse_d.len();
        for kind in [&mut self.volts, &mut self.follows] {
            let [small, large] = &mut self.work;
            small.fill(0.0);
            large.fill(0.0);
            let [at_small, at_large] = &kind.at;
            // −dY (Z s).
            for ((small, at), line) in
                (small.iter_mut().zip(at_small)).zip(direction.chunks_exact(n))
            {
                for ((large, far), change) in large.iter_mut().zip(at_large).zip(line) {
                    let flow = change * (far - at);
                    *small += flow;
                    *large -= flow;
                }
            }
            if solved.sheet.is_some() {
                for (chain, at, out) in [(of_small, at_small, small), (of_large, at_large, large)] {
                    out.iter_mut().for_each(|x| *x = -*x);
                    add_laplacian(chain, at, out);
                    out.iter_mut().for_each(|x| *x = -*x);
                }
            }
            solved.apply(&mut self.work, &mut kind.change);
        }
    }

    /// The change of a taxel's reading by that of the potentials: `by` is its derivative by those of its line of the smaller
    /// and of the larger side.
    pub(super) fn change_of(&self, at: usize, by: &[Rest; 2]) -> f64 {
        let (i, j) = (at / self.volts.at[1].len(), at % self.volts.at[1].len());
        let (volts, follows) = (&self.volts.change, &self.follows.change);
        by[0].volts * volts[0][i]
            + by[1].volts * volts[1][j]
            + by[0].follows * follows[0][i]
            + by[1].follows * follows[1][j]
    }

    /// Adds to the gradient by the conductances (m×n), and by the couplings of both sides, what comes through the potentials
    /// of `weights` (m×n), by the derivatives `by` of the readings.
    pub(super) fn add_gradient(
        &mut self,
        solved: Solved,
        (weights, by): (&[f64], &[[Rest; 2]]),
        gradient: &mut [f64],
        [of_small, of_large]: [&mut [f64]; 2],
    ) {
        let n = solved.inverse_d.len();
        for kind in [&mut self.volts, &mut self.follows] {
            let of = kind.of;
            let [small, large] = &mut self.work;
            small.fill(0.0);
            large.fill(0.0);
            for (at, (weight, by)) in weights.iter().zip(by).enumerate() {
                small[at / n] += weight * of(&by[0]);
                large[at % n] += weight * of(&by[1]);
            }
            solved.apply(&mut self.work, &mut kind.change);
            let (lambda, at) = (&kind.change, &kind.at);
            for (i, line) in gradient.chunks_exact_mut(n).enumerate() {
                for (j, gradient) in line.iter_mut().enumerate() {
                    *gradient -= (lambda[0][i] - lambda[1][j]) * (at[0][i] - at[1][j]);
                }
            }
            for (side, chain) in [&mut *of_small, &mut *of_large].into_iter().enumerate() {
                let pairs = lambda[side].windows(2).zip(at[side].windows(2));
                for (gradient, (lambda, at)) in chain.iter_mut().zip(pairs) {
                    *gradient -= (lambda[0] - lambda[1]) * (at[0] - at[1]);
                }
            }
        }
    }
}
