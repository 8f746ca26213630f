//! φ_p(t): the potential across every taxel t for one ampere into port p, and across every piece of a film. For a change V of the
//! conductances dZ_pq = −Σ_t V_t φ_p(t) φ_q(t), of every entry of the inverse port matrix.

use super::chains::Chains;
use super::sweep::Sweep;
use taxel_linalg::{View, ViewMut, multiply};

/// Kinds of what there is a potential across.
pub(super) const TAXELS: usize = 0;
pub(super) const ACROSS: usize = 1;
pub(super) const ONWARD: usize = 2;

pub(super) struct Potentials {
    /// Lines along the sweep, and ports: those, then the chains.
    along: usize,
    ports: usize,
    /// Of each kind, block by block, a line for each port with one value for each place of the block.
    phi: Vec<Vec<f64>>,
    /// Potentials of a block's nodes and of the next one's, a line for each port.
    here: Vec<f64>,
    next: Vec<f64>,
}

impl Potentials {
    /// `size`: nodes of a block; with a film twice as many as lines.
    pub(super) fn new(along: usize, chains: usize, size: usize) -> Self {
        let ports = along + chains;
        let kinds = if size > along { 3 } else { 1 };
        Self {
            along,
            ports,
            phi: vec![vec![0.0; chains * ports * along]; kinds],
            here: vec![0.0; ports * size],
            next: vec![0.0; ports * size],
        }
    }

    /// How many kinds there are.
    pub(super) fn kinds(&self) -> usize {
        self.phi.len()
    }

    /// A block's potentials by the ports of the lines along the sweep, then by the chains'.
    pub(super) fn of_block(&self, kind: usize, block: usize) -> (&[f64], &[f64]) {
        let length = self.ports * self.along;
        let phi = &self.phi[kind][block * length..(block + 1) * length];
        phi.split_at(self.along * self.along)
    }

    /// Takes a network as it was swept.
    pub(super) fn set(&mut self, sweep: &Sweep, chains: &Chains, conductance: &[f64]) {
        let (n, size) = (self.along, sweep.size);
        let (lines, ends) = self.here.split_at_mut(n * size);
        lines.copy_from_slice(&sweep.p[..n * size]);
        ends.copy_from_slice(&sweep.k);
        let length = self.ports * n;
        for (block, g) in conductance.chunks_exact(n).enumerate() {
            if block > 0 && !sweep.is_one_block() {
                self.advance(sweep, block);
            }
            let phi = &mut self.phi[TAXELS][block * length..(block + 1) * length];
            if size == n {
                chains.across((block, n + block), g, (&self.here, size), phi);
            } else {
                self.across_film(block);
            }
        }
    }

    /// From the potentials of the block before to a block's.
    fn advance(&mut self, sweep: &Sweep, block: usize) {
        let (n, size) = (self.along, sweep.size);
        let (onward, beyond) = sweep.step(block);
        multiply(
            ViewMut::new(&mut self.next, self.ports, size),
            View::new(&self.here, self.ports, size),
            View::new(onward, size, size).transpose(),
        );
        let added = self.next[(n + block) * size..].iter_mut();
        for (potential, beyond) in added.zip(beyond) {
            *potential += beyond;
        }
        if size > n {
            let length = self.ports * n;
            let phi = &mut self.phi[ONWARD][(block - 1) * length..block * length];
            let nodes = self
                .here
                .chunks_exact(size)
                .zip(self.next.chunks_exact(size));
            for (phi, (here, next)) in phi.chunks_exact_mut(n).zip(nodes) {
                for ((phi, here), next) in phi.iter_mut().zip(&here[n..]).zip(&next[n..]) {
                    *phi = here - next;
                }
            }
        }
        std::mem::swap(&mut self.here, &mut self.next);
    }

    /// Of a block that has the chain's nodes as well: across its taxels, and across the film between its lines.
    fn across_film(&mut self, block: usize) {
        let n = self.along;
        let length = self.ports * n;
        let range = block * length..(block + 1) * length;
        let (taxels, film) = self.phi.split_at_mut(ACROSS);
        let taxels = taxels[TAXELS][range.clone()].chunks_exact_mut(n);
        let film = film[0][range].chunks_exact_mut(n);
        for ((taxels, film), u) in taxels.zip(film).zip(self.here.chunks_exact(2 * n)) {
            let (lines, chain) = u.split_at(n);
            for i in 0..n {
                taxels[i] = lines[i] - chain[i];
                film[i] = lines.get(i + 1).map_or(0.0, |next| lines[i] - next);
            }
        }
    }
}
