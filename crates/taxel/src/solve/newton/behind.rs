//! Newton's method behind a diode in every driven line.

use super::{Newton, SolverState};
use crate::circuit::diode::{DrivenPoint, Dropped};
use crate::circuit::{DiodeCircuit, OperatingPoint};
use crate::solve::{Infeasible, Outcome, Stop};
use crate::{Frame, Siemens, Volts};

/// Rounds in which leaks and answer are brought together: two with silicon, more where Schottky diodes are warm; and how near.
const LEAK_ROUNDS: u32 = 30;
const LEAK_TOLERANCE: f64 = 1e-7;

/// What a stream of frames keeps of driven lines' diodes.
pub(super) struct Behind {
    point: DrivenPoint,
    /// Readings as they would be without diodes.
    volts: Frame<Volts>,
    siemens: Vec<f64>,
    /// Whether `point` is that of an answer, and `siemens` its conductances.
    is_warm: bool,
}

impl Behind {
    /// Makes the next solve start cold.
    pub(super) fn forget(&mut self) {
        self.is_warm = false;
    }

    pub(super) fn new(circuit: &DiodeCircuit, volts: &Frame<Volts>) -> Self {
        Self {
            point: DrivenPoint::new(circuit),
            siemens: vec![0.0; volts.values().len()],
            is_warm: false,
            volts: volts.clone(),
        }
    }
}

impl Newton {
    /// The same behind driven lines' diodes: first as if no diode leaked, then with the leaks that follow from the answer.
    pub(super) fn solve_behind(
        &self,
        behind: &mut Behind,
        volts: &Frame<Volts>,
        siemens: &mut Frame<Siemens>,
        (state, near): (&mut SolverState, Option<&[f64]>),
    ) -> Outcome {
        behind.volts.copy_meta_from(volts);
        let mut leaks = std::mem::take(&mut behind.is_warm);
        if !leaks {
            behind.siemens.fill(f64::INFINITY);
        }
        let mut rounds = 0;
        let mut near = near;
        let mut change = f64::INFINITY;
        for _ in 0..LEAK_ROUNDS {
            behind.volts.values_mut().copy_from_slice(volts.values());
            if let Err(dropped) = behind.point.undo(leaks, behind.volts.values_mut()) {
                siemens.values_mut().fill(0.0);
                return Outcome::new(Stop::Infeasible(infeasible(dropped)), rounds, f64::INFINITY);
            }
            let outcome = self.solve_linear(&behind.volts, siemens, state, near.take());
            rounds += outcome.iterations;
            let mut most = 0f64;
            change = 0.0;
            for (passive, g) in behind.siemens.iter_mut().zip(siemens.values()) {
                change = f64::max(change, (g.max(0.0) - *passive).abs());
                most = most.max(g.abs());
                *passive = g.max(0.0);
            }
            change /= most.max(f64::MIN_POSITIVE);
            let is_last = change <= LEAK_TOLERANCE.max(self.tolerance);
            if !outcome.is_answer() || is_last {
                // What leaks at an answer is a start for the next frame.
                behind.is_warm = is_last && outcome.is_answer();
                let iterations = rounds;
                return Outcome {
                    iterations,
                    ..outcome
                };
            }
            if behind.point.set(&behind.siemens).is_err() {
                return Outcome::new(Stop::Stalled, rounds, change);
            }
            leaks = true;
        }
        Outcome::new(Stop::IterationLimit, rounds, change)
    }
}

/// Why a frame has no answer whose driven line drops all of V_t.
fn infeasible(dropped: Dropped) -> Infeasible {
    Infeasible {
        number: "the diode of a driven line (readout.diode)",
        ohms: dropped.ohms,
        limit_ohms: dropped.limit_ohms,
        line: format!("column {}", dropped.column),
    }
}
