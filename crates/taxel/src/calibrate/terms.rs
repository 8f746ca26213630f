//! The kinds of evidence in crowded frames, and which unknown each of them tells.

use super::evaluate::{Evaluator, PressEstimate};
use super::model::Unknown;

/// Which evidence tells of an unknown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum MisfitTerm {
    /// What surrounds presses with nothing near them: spread and carry-over.
    Surroundings,
    /// Unloaded taxels: the converter's offset, and the switches where uniform loads tie the loads' scale to them.
    Unloaded,
    /// The labelled loads: law, sheet and circuit.
    Presses,
}

impl MisfitTerm {
    pub(super) const ALL: [MisfitTerm; 3] = [
        MisfitTerm::Surroundings,
        MisfitTerm::Unloaded,
        MisfitTerm::Presses,
    ];

    /// What tells an unknown; `by_ghosts`: unloaded taxels tell the switches.
    pub(super) fn of(unknown: Unknown, by_ghosts: bool) -> Self {
        match unknown {
            Unknown::SpreadRow
            | Unknown::SpreadColumn
            | Unknown::SpreadDiagonal
            | Unknown::CarryOver => MisfitTerm::Surroundings,
            Unknown::Offset => MisfitTerm::Unloaded,
            Unknown::Columns | Unknown::Rows if by_ghosts => MisfitTerm::Unloaded,
            _ => MisfitTerm::Presses,
        }
    }

    /// What it says of each press, grams; nothing where a model is perfect.
    pub(super) fn residuals(self, evaluator: &Evaluator, estimates: &[PressEstimate]) -> Vec<f64> {
        match self {
            MisfitTerm::Surroundings => estimates
                .iter()
                .flat_map(|e| e.neighbours_g.clone())
                .collect(),
            MisfitTerm::Unloaded => estimates.iter().flat_map(|e| e.ghosts_g.clone()).collect(),
            MisfitTerm::Presses => estimates
                .iter()
                .zip(&evaluator.evidence.presses)
                .map(|(e, p)| e.force_g - p.load_g)
                .collect(),
        }
    }

    /// Which press each residual belongs to.
    pub(super) fn owners(self, estimates: &[PressEstimate]) -> Vec<usize> {
        let count = |e: &PressEstimate| match self {
            MisfitTerm::Surroundings => e.neighbours_g.len(),
            MisfitTerm::Unloaded => e.ghosts_g.len(),
            MisfitTerm::Presses => 1,
        };
        estimates
            .iter()
            .enumerate()
            .flat_map(|(i, e)| vec![i; count(e)])
            .collect()
    }
}
