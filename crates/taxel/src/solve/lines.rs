//! Which lines take part: a line whose every taxel is marked open (or flickering: out in
//! this frame) or absent conducts nothing and is left out.

use std::iter::StepBy;
use std::ops::Range;

use crate::circuit::LinearCircuit;
use crate::frame::has_mark;
use crate::{Frame, Mark};

/// The rows and columns that take part in a frame.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct LiveLines {
    pub(super) rows: Vec<usize>,
    pub(super) columns: Vec<usize>,
    row_open: Vec<bool>,
    column_open: Vec<bool>,
}

impl LiveLines {
    /// Takes all lines.
    pub(super) fn take_all(&mut self, rows: usize, columns: usize) {
        self.rows = (0..rows).collect();
        self.columns = (0..columns).collect();
    }

    /// Reads the lines off a frame's marks; true when they are others than before.
    pub(super) fn update<Q>(&mut self, frame: &Frame<Q>) -> bool {
        let (rows, columns) = (frame.rows(), frame.columns());
        let has_all = self.rows.len() == rows && self.columns.len() == columns;
        if has_all && !has_mark(frame.marks(), Mark::is_out) {
            return false;
        }
        self.row_open.clear();
        self.row_open.resize(rows, true);
        self.column_open.clear();
        self.column_open.resize(columns, true);
        for (r, line) in frame.marks().chunks_exact(columns).enumerate() {
            for (c, &mark) in line.iter().enumerate() {
                if !mark.is_out() {
                    self.row_open[r] = false;
                    self.column_open[c] = false;
                }
            }
        }
        let same = |kept: &[usize], open: &[bool]| {
            kept.iter()
                .copied()
                .eq((0..open.len()).filter(|&i| !open[i]))
        };
        if same(&self.rows, &self.row_open) && same(&self.columns, &self.column_open) {
            return false;
        }
        let live = |kept: &mut Vec<usize>, open: &[bool]| {
            kept.clear();
            kept.extend((0..open.len()).filter(|&i| !open[i]));
        };
        live(&mut self.rows, &self.row_open);
        live(&mut self.columns, &self.column_open);
        true
    }

    /// The values of the taxels that take part, line by line.
    pub(super) fn gather<T: Copy>(&self, from: &[T], columns: usize, to: &mut [T]) {
        if self.columns.len() == columns && self.rows.len() * columns == from.len() {
            to.copy_from_slice(from);
            return;
        }
        for (&r, line) in self
            .rows
            .iter()
            .zip(to.chunks_exact_mut(self.columns.len()))
        {
            for (&c, value) in self.columns.iter().zip(line) {
                *value = from[r * columns + c];
            }
        }
    }

    /// Values back to their taxels; those that took no part get 0.
    pub(super) fn scatter(&self, from: &[f64], columns: usize, to: &mut [f64]) {
        if self.columns.len() == columns && self.rows.len() * columns == to.len() {
            to.copy_from_slice(from);
            return;
        }
        to.fill(0.0);
        for (&r, line) in self.rows.iter().zip(from.chunks_exact(self.columns.len())) {
            for (&c, value) in self.columns.iter().zip(line) {
                to[r * columns + c] = *value;
            }
        }
    }

    /// The places of every row's taxels among those that take part, then of every column's.
    pub(super) fn lines(&self) -> impl Iterator<Item = StepBy<Range<usize>>> + use<> {
        let (m, n) = (self.rows.len(), self.columns.len());
        let rows = (0..m).map(move |r| (r * n..(r + 1) * n).step_by(1));
        rows.chain((0..n).map(move |c| (c..m * n).step_by(n)))
    }

    /// The circuit of the lines that take part.
    pub(super) fn circuit(&self, all: &LinearCircuit) -> LinearCircuit {
        all.of_lines(&self.rows, &self.columns)
    }
}
