//! The parts of the derivative that an inverse is begun with: a taxel's own, those of one line, those of one chain.

use super::LinesPoint;
use super::arrangement::Arrangement;
use super::potentials::TAXELS;

impl LinesPoint {
    /// How the taxels lie.
    pub(crate) fn arrangement(&self) -> &Arrangement {
        &self.arrangement
    }

    /// ∂V_out/∂G of every taxel by its own conductance, volts per siemens, one value a taxel, row by row.
    pub(crate) fn own_slopes_into(&mut self, out: &mut [f64]) {
        self.needs_potentials();
        let Some(potentials) = &self.potentials else {
            return;
        };
        let n = self.arrangement.along;
        for chain in 0..self.arrangement.chains {
            let (of_lines, of_chains) = potentials.of_block(TAXELS, chain);
            let of_chain = &of_chains[chain * n..(chain + 1) * n];
            for line in 0..n {
                let at = chain * n + line;
                let slope = self
                    .work
                    .slope(at, of_lines[line * n + line], of_chain[line]);
                out[self.arrangement.taxel_of[at]] = slope;
            }
        }
    }

    /// Of every line along the sweep ∂V_out/∂G among its own taxels: a matrix each, column by column, in the order of the chains.
    pub(crate) fn along_lines_into(&mut self, out: &mut [f64]) {
        self.needs_potentials();
        let Some(potentials) = &self.potentials else {
            return;
        };
        let (n, chains) = (self.arrangement.along, self.arrangement.chains);
        for by in 0..chains {
            let (of_lines, of_chains) = potentials.of_block(TAXELS, by);
            for (chain, of_chain) in of_chains.chunks_exact(n).enumerate() {
                for (line, of_chain) in of_chain.iter().enumerate() {
                    let own = of_lines[line * n + line];
                    let at = chain * n + line;
                    out[(line * chains + by) * chains + chain] =
                        self.work.slope(at, own, *of_chain);
                }
            }
        }
    }

    /// Of every chain the same: a matrix each, column by column, in the order of the lines.
    pub(crate) fn along_chains_into(&mut self, out: &mut [f64]) {
        self.needs_potentials();
        let Some(potentials) = &self.potentials else {
            return;
        };
        let n = self.arrangement.along;
        for (chain, out) in out.chunks_exact_mut(n * n).enumerate() {
            let (of_lines, of_chains) = potentials.of_block(TAXELS, chain);
            let of_chain = &of_chains[chain * n..(chain + 1) * n];
            for (line, of_line) in of_lines.chunks_exact(n).enumerate() {
                let at = chain * n + line;
                for (by, (of_line, of_chain)) in of_line.iter().zip(of_chain).enumerate() {
                    out[by * n + line] = self.work.slope(at, *of_line, *of_chain);
                }
            }
        }
    }
}
