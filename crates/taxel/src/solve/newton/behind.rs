//! Newton's method behind a diode in every driven line.

use super::{Newton, SolverState};
use crate::circuit::diode::{DrivenDiodes, DrivenPoint};
use crate::circuit::{DiodeCircuit, OperatingPoint};
use crate::solve::Outcome;
use crate::{Frame, Siemens, Volts};

/// What a stream of frames keeps of driven lines' diodes.
pub(super) struct Behind {
    point: DrivenPoint,
    /// Readings as they would be without diodes.
    volts: Frame<Volts>,
    siemens: Vec<f64>,
    lifts: Vec<f64>,
}

impl Behind {
    pub(super) fn new(circuit: &DiodeCircuit, volts: &Frame<Volts>) -> Self {
        Self {
            point: DrivenPoint::new(circuit),
            siemens: vec![0.0; volts.values().len()],
            lifts: vec![0.0; volts.columns()],
            volts: volts.clone(),
        }
    }
}

impl Newton {
    /// The same behind driven lines' diodes: first as if no diode leaked, then with the leaks that follow from the answer.
    pub(super) fn solve_behind(
        &self,
        diodes: &DrivenDiodes,
        behind: &mut Behind,
        volts: &Frame<Volts>,
        siemens: &mut Frame<Siemens>,
        (state, near): (&mut SolverState, Option<&[f64]>),
    ) -> Outcome {
        behind.volts.copy_meta_from(volts);
        behind.volts.values_mut().copy_from_slice(volts.values());
        behind.lifts.fill(0.0);
        diodes.undo(&behind.lifts, behind.volts.values_mut());
        let first = self.solve_linear(&behind.volts, siemens, state, near);
        for (passive, g) in behind.siemens.iter_mut().zip(siemens.values()) {
            *passive = g.max(0.0);
        }
        if !first.is_answer() || behind.point.set(&behind.siemens).is_err() {
            return first;
        }
        behind.volts.values_mut().copy_from_slice(volts.values());
        let lifts = behind.point.without_leaks(behind.volts.values_mut());
        diodes.undo(lifts, behind.volts.values_mut());
        self.solve_linear(&behind.volts, siemens, state, None)
    }
}
