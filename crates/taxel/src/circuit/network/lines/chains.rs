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
    /// T⁻¹ of one chain.
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
            inverse: vec![0.0; length * length],
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

    /// Adds what a chain leaves of itself to its block, N = diag(g) − diag(g) T⁻¹ diag(g), and writes what its end does to
    /// the block, h = g ∘ T⁻¹ e₀.
    pub(super) fn reduce(
        &mut self,
        chain: usize,
        conductance: &[f64],
        block: &mut [f64],
        transfer: &mut [f64],
    ) {
        let n = self.length;
        let nodes = chain * n..(chain + 1) * n;
        let (far, before) = (&self.far[nodes.clone()], &self.before[nodes.clone()]);
        let (passes, g) = (&self.passes[nodes.clone()], &conductance[nodes]);
        let mut back = self.end[chain];
        for i in 0..n {
            if i > 0 {
                back = in_series(before[i], back + g[i - 1]);
            }
            let line = &mut self.inverse[i * n..(i + 1) * n];
            let mut value = 1.0 / (far[i] + back);
            line[i] = value;
            for j in i + 1..n {
                value *= passes[j];
                line[j] = value;
            }
        }
        for (i, line) in self.inverse.chunks_exact(n).enumerate() {
            block[i * n + i] += g[i];
            for j in i..n {
                let taken = g[i] * line[j] * g[j];
                block[i * n + j] -= taken;
                if j > i {
                    block[j * n + i] -= taken;
                }
            }
        }
        for ((transfer, g), inverse) in transfer.iter_mut().zip(g).zip(&self.inverse) {
            *transfer = g * inverse;
        }
    }

    /// values ← T⁻¹ values of a chain.
    #[inline(always)]
    pub(super) fn solve(&self, chain: usize, values: &mut [f64]) {
        let nodes = chain * self.length..(chain + 1) * self.length;
        let passes = &self.passes[nodes.clone()];
        let pivots = &self.inverse_pivot[nodes];
        for i in (1..values.len()).rev() {
            values[i - 1] += passes[i] * values[i];
        }
        values[0] *= pivots[0];
        for i in 1..values.len() {
            values[i] = values[i] * pivots[i] + passes[i] * values[i - 1];
        }
    }
}

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
            chains.reduce(0, &g, &mut block, &mut transfer);
            for (i, line) in chains.inverse.clone().chunks_exact(4).enumerate() {
                for (j, &inverse) in line.iter().enumerate().skip(i) {
                    let mut column = [0.0; 4];
                    column[j] = 1.0;
                    chains.solve(0, &mut column);
                    assert!(
                        (column[i] - inverse).abs() <= 1e-13 * inverse,
                        "{ohms} {i} {j}"
                    );
                }
            }
            assert_eq!(chains.at_end(0), chains.inverse[0]);
        }
    }
}
