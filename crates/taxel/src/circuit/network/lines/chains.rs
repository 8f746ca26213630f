//! Lines across the sweep: chains of nodes that resist from one to the next, each with a taxel to a line along the sweep and an
//! end at the first. No subtraction anywhere, so that resistances of any size keep their digits.

use crate::circuit::NotPassive;

/// All chains under one frame of conductances; values chain by chain, from the end away.
pub(super) struct Chains {
    length: usize,
    /// Conductance between a node and the one before it; infinite where nothing resists. Of the first nodes unused.
    before: Vec<f64>,
    /// Of each chain's end, siemens.
    end: Vec<f64>,
    /// Admittance of all from a node away from the end.
    far: Vec<f64>,
    /// What a node passes on of what the one before it has: b/(b + far).
    passes: Vec<f64>,
    /// 1/(far + b), and of the first node 1/(far + end).
    inverse_pivot: Vec<f64>,
    /// A row of T⁻¹ of one chain.
    inverse: Vec<f64>,
}

#[inline(always)]
fn in_series(a: f64, b: f64) -> f64 {
    if a.is_infinite() { b } else { a * b / (a + b) }
}

impl Chains {
    /// Chains of so many nodes; `ohms`: of each chain, from node to node.
    pub(super) fn new(length: usize, ohms: &[f64]) -> Self {
        let nodes = length * ohms.len();
        let before = ohms.iter().flat_map(|ohms| vec![1.0 / ohms; length]);
        Self {
            length,
            before: before.collect(),
            end: vec![0.0; ohms.len()],
            far: vec![0.0; nodes],
            passes: vec![1.0; nodes],
            inverse_pivot: vec![0.0; nodes],
            inverse: vec![0.0; length],
        }
    }

    /// Takes conductances of the taxels, chain by chain, and of the ends.
    pub(super) fn set(&mut self, conductance: &[f64], end: &[f64]) -> Result<(), NotPassive> {
        let n = self.length;
        self.end.copy_from_slice(end);
        for (chain, g) in conductance.chunks_exact(n).enumerate() {
            let nodes = chain * n..(chain + 1) * n;
            let before = &self.before[nodes.clone()];
            let far = &mut self.far[nodes.clone()];
            let passes = &mut self.passes[nodes.clone()];
            let pivots = &mut self.inverse_pivot[nodes];
            far[n - 1] = g[n - 1];
            for i in (1..n).rev() {
                let sum = before[i] + far[i];
                if sum.is_nan() || sum <= 0.0 {
                    return Err(NotPassive);
                }
                pivots[i] = 1.0 / sum;
                passes[i] = if before[i].is_infinite() {
                    1.0
                } else {
                    before[i] * pivots[i]
                };
                far[i - 1] = g[i - 1] + in_series(before[i], far[i]);
            }
            let sum = far[0] + end[chain];
            if sum.is_nan() || sum <= 0.0 {
                return Err(NotPassive);
            }
            pivots[0] = 1.0 / sum;
        }
        Ok(())
    }

    /// Driven-point resistance of a chain's end.
    pub(super) fn at_end(&self, chain: usize) -> f64 {
        self.inverse_pivot[chain * self.length]
    }

    /// Adds what a chain leaves of itself to the lower triangle of its block, N = diag(g) − diag(g) T⁻¹ diag(g), and writes what
    /// its end does to the block, h = g ∘ T⁻¹ e₀.
    pub(super) fn reduce(
        &mut self,
        chain: usize,
        size: usize,
        conductance: &[f64],
        (block, transfer): (&mut [f64], &mut [f64]),
    ) {
        let n = self.length;
        let nodes = chain * n..(chain + 1) * n;
        let (far, before) = (&self.far[nodes.clone()], &self.before[nodes.clone()]);
        let (passes, g) = (&self.passes[nodes.clone()], &conductance[nodes]);
        let mut back = self.end[chain];
        // Row i of the lower triangle of T⁻¹, from row i − 1.
        let row = &mut self.inverse;
        for i in 0..n {
            if i > 0 {
                back = in_series(before[i], back + g[i - 1]);
                for value in &mut row[..i] {
                    *value *= passes[i];
                }
            }
            row[i] = 1.0 / (far[i] + back);
            let line = &mut block[i * size..i * size + i + 1];
            for ((block, inverse), g_j) in line.iter_mut().zip(row.iter()).zip(g) {
                *block -= g[i] * inverse * g_j;
            }
            line[i] += g[i];
            transfer[i] = g[i] * row[0];
        }
    }

    /// From potentials u of a block's nodes, a line for each port, to those across the chain's taxels of conductances g,
    /// u − T⁻¹(g ∘ u); of the chain's own port −T⁻¹ e₀ besides.
    pub(super) fn across(
        &self,
        (chain, own): (usize, usize),
        g: &[f64],
        (potentials, size): (&[f64], usize),
        out: &mut [f64],
    ) {
        let n = self.length;
        let (mut ports, mut first) = (out.chunks_exact_mut(PORTS * n), 0);
        let mut us = potentials.chunks_exact(PORTS * size);
        for (out, u) in (&mut ports).zip(&mut us) {
            self.across_some::<PORTS>((chain, own.wrapping_sub(first)), g, (u, size), out);
            first += PORTS;
        }
        let rest = us.remainder().chunks_exact(size);
        for (out, u) in ports.into_remainder().chunks_exact_mut(n).zip(rest) {
            self.across_some::<1>((chain, own.wrapping_sub(first)), g, (u, size), out);
            first += 1;
        }
    }

    /// Several ports at once: within one each value waits for the one before it.
    #[inline(always)]
    fn across_some<const COUNT: usize>(
        &self,
        (chain, own): (usize, usize),
        g: &[f64],
        (u, size): (&[f64], usize),
        out: &mut [f64],
    ) {
        let n = self.length;
        let nodes = chain * n..(chain + 1) * n;
        let passes = &self.passes[nodes.clone()];
        let pivots = &self.inverse_pivot[nodes];
        let mut w = [0.0; COUNT];
        for i in (0..n).rev() {
            let passed = if i + 1 < n { passes[i + 1] } else { 0.0 };
            for (p, w) in w.iter_mut().enumerate() {
                *w = u[p * size + i] * g[i] + passed * *w;
                out[p * n + i] = *w;
            }
        }
        if own < COUNT {
            w[own] += 1.0;
            out[own * n] = w[own];
        }
        let mut before = [0.0; COUNT];
        for i in 0..n {
            let passed = if i > 0 { passes[i] } else { 0.0 };
            for (p, before) in before.iter_mut().enumerate() {
                *before = out[p * n + i] * pivots[i] + passed * *before;
                out[p * n + i] = u[p * size + i] - *before;
            }
        }
    }
}

/// Ports whose chains are solved side by side.
const PORTS: usize = 8;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chain_solved_is_its_inverse() {
        for ohms in [0.0, 1e-9, 3.0, 1e6] {
            let g = [1e-3, 0.0, 2e-3, 5e-4];
            let mut chains = Chains::new(4, &[ohms]);
            chains.set(&g, &[0.1]).unwrap();
            let (mut block, mut transfer) = ([0.0; 16], [0.0; 4]);
            chains.reduce(0, 4, &g, (&mut block, &mut transfer));
            // Ports that hold one node each at 1 V, and the chain's own: what flows, −N and −h.
            let mut ports = [0.0; 40];
            for i in 0..4 {
                ports[i * 4 + i] = 1.0;
            }
            let mut out = [0.0; 40];
            chains.across((0, 9), &g, (&ports, 4), &mut out);
            for i in 0..4 {
                for j in 0..=i {
                    let flows = g[j] * out[i * 4 + j];
                    assert!(
                        (flows - block[i * 4 + j]).abs() <= 1e-12 * g[2],
                        "{ohms} {i} {j}"
                    );
                }
                let flows = -g[i] * out[36 + i];
                assert!((flows - transfer[i]).abs() <= 1e-12, "{ohms} {i}");
            }
            assert_eq!(chains.at_end(0), -out[36]);
        }
    }
}
