//! How well the law of a sheet is known. Its two numbers are fitted; that they tell how any film conducts is believed.

use super::choose::Search;
use super::discrepancy::digits;
use super::model::Unknown;
use crate::sensor::SheetSpec;
use crate::{Frame, Mark, Siemens};

/// What is believed at most, a share of what the sheet conducts: sensors drawn by three other laws and fitted by this one leave 2 to 12 %
/// of what the sheet adds to a load (docs/uncertainty.md).
const BELIEVED: f64 = 0.1;
/// The step of the sheet's conduction that a derivative is taken from.
const STEP: f64 = 0.05;

impl Search<'_> {
    /// A share of what the sheet conducts, of a sensor that has one.
    pub(super) fn sheet_share(&mut self) -> Option<f64> {
        let sheet = self.model.sheet()?;
        let told = self.told_by_levels(sheet).unwrap_or(BELIEVED);
        Some(digits(told.min(BELIEVED)))
    }

    /// How far labels and uniform loads are apart, as far as that is known, in what the sheet adds to the latter. A press alone knows of
    /// no sheet, and a uniform load of little else that a press does not: a law that is wrong parts them.
    fn told_by_levels(&mut self, sheet: SheetSpec) -> Option<f64> {
        let together = self.together.as_ref()?;
        let error = together.error_of(Unknown::Factor)?;
        let apart = self.model.law.ln_factor.hypot(error);
        let law = self.evaluator.law(&self.model)?;
        let evidence = self.evaluator.evidence;
        let first = evidence.frames.len();
        let levels: Vec<usize> = (first..first + evidence.levels.len()).collect();
        let grams = |at: usize, siemens: &Frame<Siemens>| -> Vec<f64> {
            let marks = evidence.levels[at - first].counts.marks();
            let good =
                (siemens.values().iter().enumerate()).filter(|(t, _)| marks[*t] == Mark::Good);
            good.map(|(taxel, &value)| law.grams_from_siemens(taxel, value))
                .collect()
        };
        let mut more = self.model.clone();
        more.set_sheet(Some(sheet.conducting(1.0 + STEP)));
        let here = self.evaluator.invert(&self.model.sensor, &levels, grams)?;
        let there = self.evaluator.invert(&more.sensor, &levels, grams)?;
        let (mut added, mut sum) = (0.0, 0.0);
        for (here, there) in here.iter().flatten().zip(there.iter().flatten()) {
            added += (there - here).abs() / STEP;
            sum += here.abs();
        }
        (added > 0.0).then(|| apart * sum / added)
    }
}
