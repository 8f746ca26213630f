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

/// What tells the unknowns that more than one kind of evidence could.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Told {
    /// Unloaded taxels tell the switches, else labelled loads do.
    pub(super) switches_by_unloaded: bool,
    /// Labelled loads tell the spread, where too few presses have nothing near them.
    pub(super) spread_by_presses: bool,
    /// Which evidence tells an unknown.
    pub(super) hearing: Hearing,
}

/// How much of the evidence tells an unknown.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) enum Hearing {
    /// One kind alone, its own.
    #[default]
    Own,
    /// Labelled loads and unloaded taxels; what surrounds presses tells of itself alone.
    AllOfPresses,
    /// All kinds.
    All,
}

/// What the unloaded taxels of a frame count for together, beside its press: they are many, and what a model lacks moves all
/// of them at once. What surrounds a press counts as the press does.
const BESIDE_A_PRESS: f64 = 0.1;

impl Told {
    /// How much of each kind of evidence an unknown hears; `each`: how many residuals of a kind a press has.
    pub(super) fn hears(self, unknown: Unknown, each: [f64; 3]) -> [f64; 3] {
        let own = MisfitTerm::of(unknown, self);
        let alone = MisfitTerm::ALL.map(|term| f64::from(u8::from(term == own)));
        match (self.hearing, self.counts(each)) {
            (Hearing::All, Some(counts)) => counts,
            (Hearing::AllOfPresses, Some([_, unloaded, presses]))
                if own != MisfitTerm::Surroundings =>
            {
                [0.0, unloaded, presses]
            }
            _ => alone,
        }
    }

    /// How much of each kind of evidence counts for one loss, where there is one.
    pub(super) fn counts(self, each: [f64; 3]) -> Option<[f64; 3]> {
        let [surroundings, unloaded, _] = each;
        (self.hearing != Hearing::Own).then(|| {
            [
                1.0 / surroundings.max(1.0),
                BESIDE_A_PRESS / unloaded.max(1.0),
                1.0,
            ]
        })
    }
}

impl MisfitTerm {
    pub(super) const ALL: [MisfitTerm; 3] = [
        MisfitTerm::Surroundings,
        MisfitTerm::Unloaded,
        MisfitTerm::Presses,
    ];

    /// What tells an unknown.
    pub(super) fn of(unknown: Unknown, told: Told) -> Self {
        match unknown {
            Unknown::SpreadRow | Unknown::SpreadColumn | Unknown::SpreadDiagonal
                if told.spread_by_presses =>
            {
                MisfitTerm::Presses
            }
            Unknown::SpreadRow
            | Unknown::SpreadColumn
            | Unknown::SpreadDiagonal
            | Unknown::CarryOver => MisfitTerm::Surroundings,
            Unknown::Offset => MisfitTerm::Unloaded,
            Unknown::Columns | Unknown::Rows | Unknown::ColumnLines | Unknown::RowLines
                if told.switches_by_unloaded =>
            {
                MisfitTerm::Unloaded
            }
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
