//! Block elimination from the far chain to the ends of the lines along the sweep ([theory.md]): the inverse port matrix of a
//! network of lines that resist, without a system of all its nodes.
//!
//! X is the admittance seen from a block's nodes away from the lines' ends, E the transfer from them to every chain end passed so
//! far, q the driven-point resistance of those. With a the conductances to the next block, D = (X + a)⁻¹, B = D E:
//! q += EᵀB, E ← a B, X ← a − a D a + N.
//!
//! [theory.md]: https://github.com/taxel/taxel/blob/main/docs/theory.md

use crate::circuit::NotPassive;
use taxel_linalg::{Spd, View, ViewMut, dot, mirror, multiply, multiply_add};

/// A segment with less than this is taken in the form that needs no conductance of it, ohms: the other loses ε·a a step.
const MIN_OHMS: f64 = 0.01;

/// What a chain adds to its block.
pub(super) trait Blocks {
    /// Adds a block's own admittance to the lower triangle, writes the transfer of its end, and gives what the end has by itself.
    fn add(&mut self, chain: usize, block: &mut [f64], transfer: &mut [f64]) -> f64;
}

pub(super) struct Sweep {
    /// Nodes of a block.
    pub(super) size: usize,
    pub(super) chains: usize,
    /// Of each node to its neighbour in the block before, block by block: conductance, infinite where nothing resists.
    pub(super) between: Vec<f64>,
    /// No segment resists so little that its conductance loses digits.
    is_plain: bool,
    /// Nothing but the chains resists: one block for all.
    only_chains: bool,
    /// Its lower triangle is what counts.
    x: Vec<f64>,
    d: Vec<f64>,
    square: Vec<f64>,
    /// S of the form without conductances, a node each.
    scale: Vec<f64>,
    spd: Spd,
    /// Eᵀ, a line for each chain.
    e: Vec<f64>,
    /// Driven-point resistance of each chain's end.
    pub(super) q: Vec<f64>,
    /// P of all nodes of the first block.
    pub(super) p: Vec<f64>,
    /// Kᵀ, a line for each chain.
    pub(super) k: Vec<f64>,
    /// From a block's potentials to the next one's, for each block but the first.
    onward: Vec<f64>,
    /// Bᵀ of each block but the first: what ends beyond add to its potentials.
    beyond: Vec<f64>,
}

impl Sweep {
    /// `between`: the conductances from each node of a block to the next block's; `is_fixed`: they do not change, and none is
    /// nothing.
    pub(super) fn new(
        chains: usize,
        between: &[f64],
        (only_chains, is_fixed): (bool, bool),
    ) -> Self {
        let size = between.len();
        let squares = if only_chains { 0 } else { chains };
        Self {
            size,
            chains,
            is_plain: is_fixed && between.iter().all(|a| *a <= 1.0 / MIN_OHMS),
            only_chains,
            between: between.repeat(chains),
            x: vec![0.0; size * size],
            d: vec![0.0; size * size],
            square: vec![0.0; size * size],
            scale: vec![0.0; size],
            spd: Spd::new(size),
            e: vec![0.0; chains * size],
            q: vec![0.0; chains],
            p: vec![0.0; size * size],
            k: vec![0.0; chains * size],
            onward: vec![0.0; squares * size * size],
            beyond: vec![0.0; squares * (squares + 1) / 2 * size],
        }
    }

    /// Whether all chains hang on one block.
    pub(super) fn is_one_block(&self) -> bool {
        self.only_chains
    }

    /// Where a block's Bᵀ begins: lines of its own chain and of all beyond.
    fn beyond_of(&self, block: usize) -> std::ops::Range<usize> {
        let after = self.chains - 1 - block;
        let first = after * (after + 1) / 2;
        first * self.size..(first + after + 1) * self.size
    }

    /// Of a block but the first: from the potentials of the block before to its own, and what the ends of its chain and of those
    /// beyond add.
    pub(super) fn step(&self, block: usize) -> (&[f64], &[f64]) {
        let square = self.size * self.size;
        let onward = &self.onward[block * square..(block + 1) * square];
        (onward, &self.beyond[self.beyond_of(block)])
    }

    /// Eliminates everything but the ports. `finish` adds what the lines end in to the first block.
    pub(super) fn run(
        &mut self,
        blocks: &mut impl Blocks,
        finish: impl FnOnce(&mut [f64]),
    ) -> Result<(), NotPassive> {
        let n = self.size;
        self.x.fill(0.0);
        for chain in (0..self.chains).rev() {
            if chain + 1 < self.chains && !self.only_chains {
                self.eliminate(chain + 1)?;
            }
            let own = &mut self.e[chain * n..(chain + 1) * n];
            self.q[chain] = blocks.add(chain, &mut self.x, own);
        }
        finish(&mut self.x);
        if !self.spd.invert(&self.x, &mut self.p) {
            return Err(NotPassive);
        }
        multiply(
            ViewMut::new(&mut self.k, self.chains, n),
            View::new(&self.e, self.chains, n),
            View::new(&self.p, n, n),
        );
        let lines = self.e.chunks_exact(n).zip(self.k.chunks_exact(n));
        for (q, (e, k)) in self.q.iter_mut().zip(lines) {
            *q += dot(e, k);
        }
        Ok(())
    }

    /// Passes a block, with all beyond, on to the one before it.
    fn eliminate(&mut self, block: usize) -> Result<(), NotPassive> {
        let n = self.size;
        let between = block * n..(block + 1) * n;
        if self.is_plain {
            self.square.copy_from_slice(&self.x);
            for (i, a) in self.between[between.clone()].iter().enumerate() {
                self.square[i * n + i] += a;
            }
            if !self.spd.invert(&self.square, &mut self.d) {
                return Err(NotPassive);
            }
        } else {
            mirror(&mut self.x, n);
            self.invert_scaled(block)?;
        }
        let (ends, beyond) = (self.chains - block, self.beyond_of(block));
        let e = &mut self.e[block * n..];
        let beyond = &mut self.beyond[beyond];
        multiply(
            ViewMut::new(beyond, ends, n),
            View::new(e, ends, n),
            View::new(&self.d, n, n),
        );
        let lines = e.chunks_exact(n).zip(beyond.chunks_exact(n));
        for (q, (e, b)) in self.q[block..].iter_mut().zip(lines) {
            *q += dot(e, b);
        }
        let onward = &mut self.onward[block * n * n..(block + 1) * n * n];
        if self.is_plain {
            let a = &self.between[between];
            for (e, b) in e.chunks_exact_mut(n).zip(beyond.chunks_exact(n)) {
                for ((e, b), a) in e.iter_mut().zip(b).zip(a) {
                    *e = a * b;
                }
            }
            let lines = self.x.chunks_exact_mut(n).zip(self.d.chunks_exact(n));
            for (i, ((x, d), onward)) in lines.zip(onward.chunks_exact_mut(n)).enumerate() {
                for (((x, d), onward), a_j) in x.iter_mut().zip(d).zip(onward).zip(a) {
                    *onward = d * a_j;
                    *x = -a[i] * *onward;
                }
                x[i] += a[i];
            }
        } else {
            self.pass_on_mixed(block);
        }
        Ok(())
    }

    /// The same where some nodes are stiff: of these D a = 1 − D X, so that the conductance itself is not needed. C = D a, E ← a B or
    /// E − X B, X ← a (1 − C) or X C, node by node.
    fn pass_on_mixed(&mut self, block: usize) {
        let n = self.size;
        let (ends, beyond) = (self.chains - block, self.beyond_of(block));
        let between = &self.between[block * n..(block + 1) * n];
        let stiff = |a: f64| a > 1.0 / MIN_OHMS;
        multiply(
            ViewMut::new(&mut self.square, n, n),
            View::new(&self.d, n, n),
            View::new(&self.x, n, n),
        );
        let onward = &mut self.onward[block * n * n..(block + 1) * n * n];
        let lines = self.d.chunks_exact(n).zip(self.square.chunks_exact(n));
        for (i, (onward, (d, dx))) in onward.chunks_exact_mut(n).zip(lines).enumerate() {
            for (j, a) in between.iter().enumerate() {
                onward[j] = if stiff(*a) {
                    f64::from(u8::from(i == j)) - dx[j]
                } else {
                    d[j] * a
                };
            }
        }
        let (e, beyond) = (&mut self.e[block * n..], &self.beyond[beyond]);
        multiply_add(
            ViewMut::new(e, ends, n),
            View::new(beyond, ends, n),
            View::new(&self.x, n, n),
            -1.0,
        );
        for (e, b) in e.chunks_exact_mut(n).zip(beyond.chunks_exact(n)) {
            for ((e, b), a) in e.iter_mut().zip(b).zip(between) {
                if !stiff(*a) {
                    *e = a * b;
                }
            }
        }
        multiply(
            ViewMut::new(&mut self.square, n, n),
            View::new(&self.x, n, n),
            View::new(onward, n, n),
        );
        let lines = self.square.chunks_exact(n).zip(onward.chunks_exact(n));
        for (i, (x, (xc, c))) in self.x.chunks_exact_mut(n).zip(lines).enumerate() {
            let a = between[i];
            if stiff(a) {
                x.copy_from_slice(xc);
            } else {
                for (x, c) in x.iter_mut().zip(c) {
                    *x = -a * c;
                }
                x[i] += a;
            }
        }
    }

    /// D = (X + a)⁻¹ = S (S X S + a/(κ + a))⁻¹ S with S = (κ + a)^−½, κ of the size of X: also where a is 0 or infinite.
    fn invert_scaled(&mut self, block: usize) -> Result<(), NotPassive> {
        let n = self.size;
        let between = &self.between[block * n..(block + 1) * n];
        let trace: f64 = self.x.iter().step_by(n + 1).map(|x| x.abs()).sum();
        let kappa = (trace / n as f64).max(f64::MIN_POSITIVE);
        for (scale, a) in self.scale.iter_mut().zip(between) {
            *scale = if a.is_infinite() {
                0.0
            } else {
                1.0 / (kappa + a).sqrt()
            };
        }
        let lines = self.square.chunks_exact_mut(n).zip(self.x.chunks_exact(n));
        for (i, (out, x)) in lines.enumerate() {
            for ((out, x), s) in out.iter_mut().zip(x).zip(&self.scale) {
                *out = self.scale[i] * x * s;
            }
            let a = between[i];
            out[i] += if a.is_infinite() {
                1.0
            } else {
                a / (kappa + a)
            };
        }
        if !self.spd.invert(&self.square, &mut self.d) {
            return Err(NotPassive);
        }
        for (i, line) in self.d.chunks_exact_mut(n).enumerate() {
            for (d, s) in line.iter_mut().zip(&self.scale) {
                *d *= self.scale[i] * s;
            }
        }
        Ok(())
    }
}
