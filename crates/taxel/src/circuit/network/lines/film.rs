//! A continuous sheet over lines that resist: a film between the nodes of neighbouring columns, and of neighbouring rows.
//!
//! Chains are then joined to each other, so that none can be eliminated by itself: a block has a node of every line along the sweep
//! and all nodes of its chain.

use super::sweep::Blocks;
use crate::material::Sheet;

/// A segment of a chain is taken to resist this at least, ohms a pitch, so that its conductance keeps its digits.
const MIN_OHMS: f64 = 1e-5;

pub(super) struct Film {
    sheet: Sheet,
    length: usize,
    /// Of every chain, from node to node, siemens.
    of_chain: Vec<f64>,
    end: Vec<f64>,
    g: Vec<f64>,
    /// Chain by chain: between a line along the sweep and the next one, and between a chain and the next one. Of the last 0.
    pub(super) across: Vec<f64>,
    pub(super) onward: Vec<f64>,
}

impl Film {
    pub(super) fn new(sheet: Sheet, length: usize, chain_ohms: &[f64]) -> Self {
        let taxels = || vec![0.0; length * chain_ohms.len()];
        let of_chain = chain_ohms.iter().map(|ohms| 1.0 / ohms.max(MIN_OHMS));
        Self {
            sheet,
            length,
            of_chain: of_chain.collect(),
            end: vec![0.0; chain_ohms.len()],
            g: taxels(),
            across: taxels(),
            onward: taxels(),
        }
    }

    /// Takes conductances of the taxels, chain by chain, and of the chains' ends.
    pub(super) fn set(&mut self, g: &[f64], end: &[f64]) {
        self.g.copy_from_slice(g);
        self.end.copy_from_slice(end);
        let sheet = self.sheet;
        for at in 0..g.len() {
            let (across, onward) = self.neighbours(at);
            let film = |other: Option<usize>| {
                other.map_or(0.0, |other| sheet.siemens_between(g[at], g[other]))
            };
            (self.across[at], self.onward[at]) = (film(across), film(onward));
        }
    }

    /// The taxel on the next line along the sweep, and that on the next chain.
    fn neighbours(&self, at: usize) -> (Option<usize>, Option<usize>) {
        let (n, all) = (self.length, self.g.len());
        let across = (at % n + 1 < n).then_some(at + 1);
        (across, (at + n < all).then_some(at + n))
    }

    /// From changes of the conductances to those of the film.
    pub(super) fn changes(&self, direction: &[f64], across: &mut [f64], onward: &mut [f64]) {
        for at in 0..direction.len() {
            let (beside, beyond) = self.neighbours(at);
            let change = |other: Option<usize>| {
                other.map_or(0.0, |other| {
                    let (own, others) = self.sheet.slopes(self.g[at], self.g[other]);
                    own * direction[at] + others * direction[other]
                })
            };
            (across[at], onward[at]) = (change(beside), change(beyond));
        }
    }

    /// Adds to the gradient by the conductances what comes through the film.
    pub(super) fn add_gradient(&self, across: &[f64], onward: &[f64], gradient: &mut [f64]) {
        for at in 0..gradient.len() {
            let (beside, beyond) = self.neighbours(at);
            for (other, by) in [(beside, across[at]), (beyond, onward[at])] {
                if let Some(other) = other {
                    let (own, others) = self.sheet.slopes(self.g[at], self.g[other]);
                    gradient[at] += by * own;
                    gradient[other] += by * others;
                }
            }
        }
    }
}

impl Blocks for Film {
    fn add(&mut self, chain: usize, block: &mut [f64], transfer: &mut [f64]) -> f64 {
        let (n, size) = (self.length, 2 * self.length);
        let wire = self.of_chain[chain];
        let mut join = |a: usize, b: usize, siemens: f64| {
            block[a * size + a] += siemens;
            block[b * size + b] += siemens;
            block[a.max(b) * size + a.min(b)] -= siemens;
        };
        for i in 0..n {
            let at = chain * n + i;
            join(i, n + i, self.g[at]);
            if i + 1 < n {
                join(i, i + 1, self.across[at]);
                join(n + i, n + i + 1, wire);
            }
        }
        block[n * size + n] += self.end[chain];
        transfer.fill(0.0);
        transfer[n] = 1.0;
        0.0
    }
}
