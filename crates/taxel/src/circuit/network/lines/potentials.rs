//! φ_p(t): the potential across every taxel t for one ampere into port p. For a change V of the conductances
//! dZ_pq = −Σ_t V_t φ_p(t) φ_q(t), of every entry of the inverse port matrix.

use super::chains::Chains;
use super::sweep::Sweep;
use taxel_linalg::{View, ViewMut, multiply};

pub(super) struct Potentials {
    /// Lines along the sweep, and ports: those, then the chains.
    along: usize,
    ports: usize,
    /// Block by block, a line for each port with one value for each taxel of the block.
    pub(super) phi: Vec<f64>,
    /// Potentials of a block's nodes and of the next one's, a line for each port.
    here: Vec<f64>,
    next: Vec<f64>,
}

impl Potentials {
    pub(super) fn new(along: usize, chains: usize, size: usize) -> Self {
        let ports = along + chains;
        Self {
            along,
            ports,
            phi: vec![0.0; chains * ports * along],
            here: vec![0.0; ports * size],
            next: vec![0.0; ports * size],
        }
    }

    /// A block's potentials by the ports of the lines along the sweep, then by the chains'.
    pub(super) fn of_block(&self, block: usize) -> (&[f64], &[f64]) {
        let length = self.ports * self.along;
        let phi = &self.phi[block * length..(block + 1) * length];
        phi.split_at(self.along * self.along)
    }

    /// Takes a network as it was swept.
    pub(super) fn set(&mut self, sweep: &Sweep, chains: &Chains, conductance: &[f64]) {
        let (n, size, along) = (self.along, sweep.size, self.along);
        let (lines, ends) = self.here.split_at_mut(along * size);
        lines.copy_from_slice(&sweep.p[..along * size]);
        ends.copy_from_slice(&sweep.k);
        let blocks = self.phi.chunks_exact_mut(self.ports * n);
        for ((block, phi), g) in blocks.enumerate().zip(conductance.chunks_exact(n)) {
            if block > 0 && !sweep.is_one_block() {
                let (onward, beyond) = sweep.step(block);
                multiply(
                    ViewMut::new(&mut self.next, self.ports, size),
                    View::new(&self.here, self.ports, size),
                    View::new(onward, size, size).transpose(),
                );
                let added = self.next[(along + block) * size..].iter_mut();
                for (potential, beyond) in added.zip(beyond) {
                    *potential += beyond;
                }
                std::mem::swap(&mut self.here, &mut self.next);
            }
            chains.across((block, along + block), g, (&self.here, size), phi);
        }
    }
}
