//! What presses say of a fit of everything that has not seen them.

use super::{Together, longest, newton_step};
use crate::calibrate::evaluate::{Evaluator, PressEstimate};
use crate::calibrate::model::Model;

impl Together {
    /// What held-out presses are read as: the unknowns are fitted anew without each fold and judged on it. Presses of one
    /// frame stay together. Nothing where one of them has no solution.
    pub(in crate::calibrate) fn held_out(
        &self,
        evaluator: &mut Evaluator,
        folds: usize,
    ) -> Option<Vec<PressEstimate>> {
        let presses = evaluator.evidence.presses.clone();
        let folds = folds.clamp(2, presses.len());
        let mut found: Vec<Option<PressEstimate>> = vec![None; presses.len()];
        for fold in 0..folds {
            let held = |i: usize| presses[i].frame % folds == fold;
            // Only the held-out frames need another inversion.
            let which: Vec<usize> = (0..presses.len()).filter(|&i| held(i)).collect();
            let step = self.step_without(held)?;
            let part = evaluator.evidence.part(&which);
            let mut tester = evaluator.part(&part, &which, &self.model)?;
            // As far as its frames have a solution.
            let estimates =
                halves().find_map(|length| tester.estimates(&self.moved(&step, length)));
            evaluator.take_back(&which, tester);
            for (&i, estimate) in which.iter().zip(estimates?) {
                found[i] = Some(estimate);
            }
        }
        found.into_iter().collect()
    }

    /// The step to the model as it would be without the presses that `held` names: one from the common answer, where the
    /// problem is all but linear. Nothing where they leave none.
    fn step_without(&self, held: impl Fn(usize) -> bool) -> Option<Vec<f64>> {
        let step = |keep: &dyn Fn(usize, usize) -> bool| {
            let at = (&self.model, self.unknowns.as_slice());
            newton_step(at, &self.hears, &self.point, &self.slopes, keep)
        };
        let without = step(&|kind, i| !held(self.point.owners[kind][i]))?;
        // What all evidence together would still move is no matter of these presses.
        let with = step(&|_, _| true)?;
        let step: Vec<f64> = without.iter().zip(&with).map(|(a, b)| a - b).collect();
        let length = longest(&self.unknowns, &step);
        Some(step.iter().map(|step| length * step).collect())
    }

    /// The model after a part of a step; where no sensor has the value of an unknown, as near to it as one has.
    fn moved(&self, step: &[f64], part: f64) -> Model {
        let mut model = self.model.clone();
        for (&unknown, step) in self.unknowns.iter().zip(step) {
            let value = self.model.get(unknown);
            halves().find_map(|half| model.set(unknown, value + half * part * step));
        }
        model
    }
}

/// Parts of a step that is tried, each half of the one before.
fn halves() -> impl Iterator<Item = f64> {
    (0..5).map(|halvings| 0.5f64.powi(halvings))
}
