//! The derivative of the scan, forwards and backwards, from the potentials across all taxels:
//!
//! dP_rr = −Σ_t V_t Φ_R[r,t]², dQ_cc = −Σ_t V_t Φ_C[c,t]², dK = −Φ_R diag(V) Φ_Cᵀ, and the same with weights the other way round.
//! Of a film its pieces count as taxels do.

use super::potentials::Potentials;
use crate::circuit::reading::Partials;
use taxel_linalg::{View, ViewMut, multiply, multiply_add};

/// Scratch, and the derivative of V_out by the driven-point resistances of both its lines and by what is between them; values
/// chain by chain.
#[derive(Default)]
pub(super) struct Work {
    pub(super) stale: bool,
    along: usize,
    chains: usize,
    /// By the line's along the sweep, the chain's, and between them.
    by_line: Vec<f64>,
    by_chain: Vec<f64>,
    by_both: Vec<f64>,
    /// Changes of the conductances, or weights of the readings.
    pub(super) direction: Vec<f64>,
    /// Changes of the readings.
    pub(super) out: Vec<f64>,
    /// Of each kind of what there is a potential across: changes of it, or the gradient by it.
    pub(super) kinds: Vec<Vec<f64>>,
    /// Changes of P_rr, Q_cc and K (a line for each chain), or weights of them.
    of_line: Vec<f64>,
    of_chain: Vec<f64>,
    of_both: Vec<f64>,
    weighted: Vec<f64>,
    square: Vec<f64>,
}

impl Work {
    pub(super) fn resize(&mut self, along: usize, chains: usize, kinds: usize) {
        (self.along, self.chains) = (along, chains);
        for list in [
            &mut self.by_line,
            &mut self.by_chain,
            &mut self.by_both,
            &mut self.direction,
            &mut self.out,
            &mut self.of_both,
        ] {
            list.resize(along * chains, 0.0);
        }
        self.kinds.resize_with(kinds, Vec::new);
        for kind in &mut self.kinds {
            kind.resize(along * chains, 0.0);
        }
        self.of_line.resize(along, 0.0);
        self.of_chain.resize(chains, 0.0);
        self.weighted.resize(along * along, 0.0);
        self.square.resize(along * along, 0.0);
    }

    pub(super) fn take(&mut self, at: usize, by: &Partials, transposed: bool) {
        (self.by_line[at], self.by_chain[at]) = if transposed {
            (by.q, by.p)
        } else {
            (by.p, by.q)
        };
        self.by_both[at] = by.k;
    }

    /// What the reading at a place moves by for a siemens more on a taxel across which its line has this potential, and its chain
    /// that.
    #[inline(always)]
    pub(super) fn slope(&self, at: usize, of_line: f64, of_chain: f64) -> f64 {
        -(self.by_line[at] * of_line * of_line
            + self.by_chain[at] * of_chain * of_chain
            + self.by_both[at] * of_line * of_chain)
    }

    /// `out` ← J of the changes of all kinds.
    pub(super) fn forward(&mut self, potentials: &Potentials) {
        self.of_line.fill(0.0);
        self.of_chain.fill(0.0);
        self.of_both.fill(0.0);
        let kinds = std::mem::take(&mut self.kinds);
        for (kind, changes) in kinds.iter().enumerate() {
            for (block, v) in changes.chunks_exact(self.along).enumerate() {
                if v.iter().any(|v| *v != 0.0) {
                    self.add_block(potentials.of_block(kind, block), v);
                }
            }
        }
        self.kinds = kinds;
        let n = self.along;
        for (at, out) in self.out.iter_mut().enumerate() {
            *out = self.by_line[at] * self.of_line[at % n]
                + self.by_chain[at] * self.of_chain[at / n]
                + self.by_both[at] * self.of_both[at];
        }
    }

    /// Adds what the changes in a block do to P_rr, Q_cc and K.
    fn add_block(&mut self, (of_lines, of_chains): (&[f64], &[f64]), v: &[f64]) {
        let n = self.along;
        let lines = of_lines.chunks_exact(n).zip(&mut self.of_line);
        for ((phi, change), weighted) in lines.zip(self.weighted.chunks_exact_mut(n)) {
            for ((weighted, phi), v) in weighted.iter_mut().zip(phi).zip(v) {
                *weighted = phi * v;
                *change -= *weighted * phi;
            }
        }
        for (phi, change) in of_chains.chunks_exact(n).zip(&mut self.of_chain) {
            for (phi, v) in phi.iter().zip(v) {
                *change -= phi * phi * v;
            }
        }
        multiply_add(
            ViewMut::new(&mut self.of_both, self.chains, n),
            View::new(of_chains, self.chains, n),
            View::new(&self.weighted, n, n).transpose(),
            -1.0,
        );
    }

    /// The gradients of Σ `direction` · V_out by all kinds.
    pub(super) fn adjoint(&mut self, potentials: &Potentials) {
        let n = self.along;
        self.of_line.fill(0.0);
        self.of_chain.fill(0.0);
        for (at, w) in self.direction.iter().enumerate() {
            self.of_line[at % n] += w * self.by_line[at];
            self.of_chain[at / n] += w * self.by_chain[at];
            self.of_both[at] = w * self.by_both[at];
        }
        let mut kinds = std::mem::take(&mut self.kinds);
        for (kind, gradient) in kinds.iter_mut().enumerate() {
            for (block, out) in gradient.chunks_exact_mut(n).enumerate() {
                self.gradient_of_block(potentials.of_block(kind, block), out);
            }
        }
        self.kinds = kinds;
    }

    fn gradient_of_block(&mut self, (of_lines, of_chains): (&[f64], &[f64]), out: &mut [f64]) {
        let n = self.along;
        // (wK Φ_C): of each line along the sweep, what the chains' potentials weigh.
        multiply(
            ViewMut::new(&mut self.square, n, n),
            View::new(&self.of_both, self.chains, n).transpose(),
            View::new(of_chains, self.chains, n),
        );
        out.fill(0.0);
        let lines = of_lines.chunks_exact(n).zip(self.square.chunks_exact(n));
        for ((phi, both), weight) in lines.zip(&self.of_line) {
            for ((out, phi), both) in out.iter_mut().zip(phi).zip(both) {
                *out -= phi * (weight * phi + both);
            }
        }
        for (phi, weight) in of_chains.chunks_exact(n).zip(&self.of_chain) {
            for (out, phi) in out.iter_mut().zip(phi) {
                *out -= weight * phi * phi;
            }
        }
    }
}
