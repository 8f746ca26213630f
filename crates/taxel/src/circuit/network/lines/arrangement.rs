//! How an array lies for the sweep: which side's lines are chains, and from which end the others are counted.
//!
//! Chains are lines across the sweep, eliminated one after the other; what is left of each is a block, a node of every line along
//! the sweep. Both are counted from the ends of the other side's lines.

use super::LineResistance;
use super::resistance::resist;
use crate::sensor::LineEnd;

pub(crate) struct Arrangement {
    /// Lines along the sweep.
    pub(crate) along: usize,
    /// Chains across it.
    pub(crate) chains: usize,
    /// The lines along the sweep are the columns.
    pub(super) transposed: bool,
    /// Only chains resist: nothing is to be swept.
    pub(super) only_chains: bool,
    /// Each line along the sweep and each chain by its number in the array.
    pub(super) line_of: Vec<usize>,
    pub(super) chain_of: Vec<usize>,
    /// The taxel of each place, chain by chain.
    pub(super) taxel_of: Vec<usize>,
}

impl Arrangement {
    pub(super) fn new(lines: &LineResistance) -> Self {
        let (rows, columns) = lines.shape();
        let (of_rows, of_columns) = (resist(lines.row_ohms()), resist(lines.column_ohms()));
        let only_chains = of_rows != of_columns;
        // A side that resists alone is eliminated; else the sweep has as few lines along it as can be.
        let transposed = if only_chains { of_rows } else { columns < rows };
        Self::swept(lines, only_chains, transposed)
    }

    /// Of a sweep along the columns, or along the rows.
    pub(super) fn swept(lines: &LineResistance, only_chains: bool, transposed: bool) -> Self {
        let (rows, columns) = lines.shape();
        let (row_end, column_end) = lines.ends();
        let numbers = |count: usize, end: LineEnd| -> Vec<usize> {
            match end {
                LineEnd::First => (0..count).collect(),
                LineEnd::Last => (0..count).rev().collect(),
            }
        };
        // Rows end at a column: those are counted from there.
        let (row_of, column_of) = (numbers(rows, column_end), numbers(columns, row_end));
        let (line_of, chain_of) = if transposed {
            (column_of, row_of)
        } else {
            (row_of, column_of)
        };
        let taxel = |(chain, line): (usize, usize)| {
            let (row, column) = if transposed {
                (chain, line)
            } else {
                (line, chain)
            };
            row * columns + column
        };
        let places = chain_of
            .iter()
            .flat_map(|&chain| line_of.iter().map(move |&line| (chain, line)));
        Self {
            along: line_of.len(),
            chains: chain_of.len(),
            transposed,
            only_chains,
            taxel_of: places.map(taxel).collect(),
            line_of,
            chain_of,
        }
    }

    /// A number of each row and of each column, as of each line along the sweep and of each chain.
    pub(super) fn sides(&self, rows: &[f64], columns: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let (along, across) = if self.transposed {
            (columns, rows)
        } else {
            (rows, columns)
        };
        (
            self.line_of.iter().map(|&line| along[line]).collect(),
            self.chain_of.iter().map(|&chain| across[chain]).collect(),
        )
    }

    /// Row and column of a line along the sweep and a chain.
    #[inline(always)]
    pub(super) fn place(&self, line: usize, chain: usize) -> (usize, usize) {
        let (line, chain) = (self.line_of[line], self.chain_of[chain]);
        if self.transposed {
            (chain, line)
        } else {
            (line, chain)
        }
    }

    /// One value a taxel, row by row, to one a place, chain by chain.
    pub(crate) fn gather(&self, from: &[f64], to: &mut [f64]) {
        for (to, &taxel) in to.iter_mut().zip(&self.taxel_of) {
            *to = from[taxel];
        }
    }

    /// And back.
    pub(crate) fn scatter(&self, from: &[f64], to: &mut [f64]) {
        for (from, &taxel) in from.iter().zip(&self.taxel_of) {
            to[taxel] = *from;
        }
    }
}
