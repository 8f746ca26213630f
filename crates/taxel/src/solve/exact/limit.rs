//! Why a frame has no answer: which share of the columns' resistances would leave it one.

use super::super::Infeasible;
use super::Accuracy;
use super::rounds;
use super::state::SolverState;

/// Coarse is enough to see whether there is an answer.
const COARSE: Accuracy = Accuracy {
    share: 1e-4,
    siemens: 0.0,
};
/// A half of a half …: below a 64th it is not the columns' resistances that are wrong.
const HALVINGS: u32 = 6;
/// The limit is known within the 16th part of an octave.
const BISECTIONS: u32 = 4;

/// The largest share of the columns' resistances with which rounds lead to an answer, and the column that conducts most there. None where no
/// share does.
pub(super) fn find(state: &mut SolverState, n: usize) -> Option<Infeasible> {
    let mut at = 1.0;
    let mut try_share = |state: &mut SolverState, share: f64| {
        scale(state, share / at);
        at = share;
        state.warm = false;
        let outcome = rounds::run(state, COARSE, rounds::WITH_CARE);
        state.warm = false;
        outcome.stop.is_good().then(|| fullest_column(state, n))
    };
    let mut good = None;
    let mut share = 1.0;
    for _ in 0..HALVINGS {
        share *= 0.5;
        good = try_share(state, share).map(|column| (share, column));
        if good.is_some() {
            break;
        }
    }
    let (mut share, mut column) = good?;
    let mut step = 2f64;
    for _ in 0..BISECTIONS {
        step = step.sqrt();
        if let Some(fullest) = try_share(state, share * step) {
            (share, column) = (share * step, fullest);
        }
    }
    let ohms = state.column_ohms[column];
    Some(Infeasible {
        number: "r_mux_column_ohms",
        ohms,
        limit_ohms: ohms * share,
        line: format!("column {}", state.live.columns[column]),
    })
}

/// Columns' resistances times `factor`: K = diag(β) W with 1/g_c in W.
fn scale(state: &mut SolverState, factor: f64) {
    for k in &mut state.full.k {
        *k *= factor;
    }
    for g_c in &mut state.full.g_c {
        *g_c /= factor;
    }
    for (single, k) in state.half.k.iter_mut().zip(&state.full.k) {
        *single = *k as f32;
    }
    for (single, g_c) in state.half.g_c.iter_mut().zip(&state.full.g_c) {
        *single = *g_c as f32;
    }
}

/// The live column whose taxels conduct most for what it ends in.
fn fullest_column(state: &SolverState, n: usize) -> usize {
    let total = |j: usize| -> f64 { state.full.g.iter().skip(j).step_by(n).sum() };
    let share = |j: &usize| total(*j) / state.full.g_c[*j];
    (0..n)
        .max_by(|a, b| share(a).total_cmp(&share(b)))
        .unwrap_or_default()
}
