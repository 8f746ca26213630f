//! What makes GMRES short on lines that resist: the derivative among the taxels of each row, and of each column, inverted exactly and
//! applied one after the other. Along a line that resists neighbours share much of their path, and little with all others.

use crate::circuit::network::LinesPoint;
use taxel_linalg::LuBlocks;

/// rows⁻¹ ∘ (1 + μ) ∘ columns⁻¹ of J̃ = diag(weight) dV/dG + diag μ; of one frame, kept for those that follow.
pub(super) struct Preconditioner {
    lines: LuBlocks,
    chains: LuBlocks,
    /// 1 + μ, chain by chain.
    between: Vec<f64>,
    weight: Vec<f64>,
    shift: Vec<f64>,
    held: Vec<f64>,
    x: Vec<f64>,
    line: Vec<f64>,
}

impl Preconditioner {
    pub(super) fn new(point: &LinesPoint) -> Self {
        let (along, chains) = (point.arrangement().along, point.arrangement().chains);
        let taxels = || vec![0.0; along * chains];
        Self {
            lines: LuBlocks::new(chains, along),
            chains: LuBlocks::new(along, chains),
            between: taxels(),
            weight: taxels(),
            shift: taxels(),
            held: taxels(),
            x: taxels(),
            line: vec![0.0; chains],
        }
    }

    /// Takes J̃ at a point: weight and μ of every taxel, and which are no unknowns. False where a part of it is singular.
    pub(super) fn set(
        &mut self,
        point: &mut LinesPoint,
        (weight, shift): (&[f64], &[f64]),
        held: &[f64],
    ) -> bool {
        let arrangement = point.arrangement();
        arrangement.gather(weight, &mut self.weight);
        arrangement.gather(shift, &mut self.shift);
        arrangement.gather(held, &mut self.held);
        let (n, chains) = (arrangement.along, arrangement.chains);
        for (between, shift) in self.between.iter_mut().zip(&self.shift) {
            *between = 1.0 + shift;
        }
        point.along_lines_into(self.lines.matrices_mut());
        point.along_chains_into(self.chains.matrices_mut());
        let mut is_regular = true;
        for line in 0..n {
            let at = |chain: usize| chain * n + line;
            self.complete(line, true, at);
            is_regular &= self.lines.factorise(line);
        }
        for chain in 0..chains {
            let at = |line: usize| chain * n + line;
            self.complete(chain, false, at);
            is_regular &= self.chains.factorise(chain);
        }
        is_regular
    }

    /// From dV/dG to J̃ of one line or chain, whose taxels' places are `at`; of those that are no unknowns the identity.
    fn complete(&mut self, which: usize, is_line: bool, at: impl Fn(usize) -> usize) {
        let blocks = if is_line {
            &mut self.lines
        } else {
            &mut self.chains
        };
        let matrix = blocks.matrix_mut(which);
        let size = matrix.len().isqrt();
        for (j, column) in matrix.chunks_exact_mut(size).enumerate() {
            let column_held = self.held[at(j)];
            for (i, value) in column.iter_mut().enumerate() {
                let place = at(i);
                *value *= self.weight[place];
                if column_held + self.held[place] > 0.0 {
                    *value = 0.0;
                }
            }
            column[j] = if column_held > 0.0 {
                1.0
            } else {
                column[j] + self.shift[at(j)]
            };
        }
    }

    /// out ← M⁻¹ v, one value a taxel, row by row.
    pub(super) fn apply(&mut self, point: &LinesPoint, v: &[f64], out: &mut [f64]) {
        let arrangement = point.arrangement();
        let n = arrangement.along;
        arrangement.gather(v, &mut self.x);
        for (chain, x) in self.x.chunks_exact_mut(n).enumerate() {
            self.chains.solve(chain, x);
        }
        for (x, between) in self.x.iter_mut().zip(&self.between) {
            *x *= between;
        }
        for line in 0..n {
            for (chain, value) in self.line.iter_mut().enumerate() {
                *value = self.x[chain * n + line];
            }
            self.lines.solve(line, &mut self.line);
            for (chain, value) in self.line.iter().enumerate() {
                self.x[chain * n + line] = *value;
            }
        }
        arrangement.scatter(&self.x, out);
    }
}
