//! Presses in crowded frames that join those made one at a time: as loads, through the inverse.

use super::super::evaluate::Evaluator;
use super::super::evidence::Evidence;
use super::super::model::Model;
use super::super::posterior::most_probable;
use super::fit::{Fitted, Readings, plain_law};
use crate::Crew;
use crate::circuit::{Converter, LinearCircuit};
use crate::solve::standard_error_of;

/// Smallest standard error of a load, grams.
const LEAST_GRAMS: f64 = 1e-3;

/// Crowded presses.
pub(super) struct Crowd<'a> {
    evidence: &'a Evidence,
    which: &'a [usize],
    crew: &'a dyn Crew,
}

/// A press of the crowd that has a solution, and the standard error of its load by the noise alone, grams.
pub(super) type Scales = Vec<(usize, f64)>;

impl<'a> Crowd<'a> {
    pub(super) fn new(evidence: &'a Evidence, which: &'a [usize], crew: &'a dyn Crew) -> Self {
        Self {
            evidence,
            which,
            crew,
        }
    }

    /// The most probable model of both, from that of the presses made one at a time. Nothing where no crowded frame
    /// has a solution.
    pub(super) fn fit(&self, readings: &Readings, alone: &Fitted) -> Option<Fitted> {
        let scales = self.scales(&alone.model, readings.known.noise_counts);
        if scales.is_empty() {
            return None;
        }
        let layout = &alone.layout;
        let mut evaluator = Evaluator::new(self.evidence, self.crew);
        let mut last: Option<(Vec<u64>, Vec<f64>)> = None;
        let peak = most_probable(&layout.parameters_at(&alone.peak.at), |at| {
            let model = layout.model(at)?;
            let mut all = readings.residuals(&model, alone.share)?;
            let siemens = self.siemens(&mut evaluator, &model, &scales, &mut last)?;
            let law = plain_law(&model);
            for ((p, error), g) in scales.iter().zip(siemens) {
                let label = self.evidence.presses[*p].load_g;
                let error = error.hypot(alone.share * label).max(LEAST_GRAMS);
                all.push((law.grams_from_siemens(0, g) - label) / error);
            }
            all.iter().all(|r| r.is_finite()).then_some(all)
        })?;
        Some(Fitted {
            model: layout.model(&peak.at)?,
            loss: alone.loss,
            peak,
            ..alone.clone()
        })
    }

    /// Conductances of the labelled taxels, computed anew when the circuit moved.
    fn siemens(
        &self,
        evaluator: &mut Evaluator,
        model: &Model,
        scales: &Scales,
        last: &mut Option<(Vec<u64>, Vec<f64>)>,
    ) -> Option<Vec<f64>> {
        let key = super::super::evaluate::key(&model.sensor);
        if let Some((known, siemens)) = last
            && *known == key
        {
            return Some(siemens.clone());
        }
        let which: Vec<usize> = scales.iter().map(|s| s.0).collect();
        let evidence = self.evidence;
        let siemens = evaluator.invert(&model.sensor, &which, |i, siemens| {
            siemens.at(evidence.presses[i].row, evidence.presses[i].column)
        })?;
        *last = Some((key, siemens.clone()));
        Some(siemens)
    }

    /// Presses whose frame has a solution, and the standard error of each load.
    fn scales(&self, model: &Model, noise_counts: f64) -> Scales {
        let Ok(circuit) = LinearCircuit::from_sensor(&model.sensor) else {
            return Vec::new();
        };
        let volts = noise_counts * Converter::from_sensor(&model.sensor).lsb_volts();
        let law = plain_law(model);
        let evidence = self.evidence;
        let mut evaluator = Evaluator::new(evidence, self.crew);
        let mut scales = Scales::new();
        for &p in self.which {
            let press = evidence.presses[p];
            let taxel = press.row * model.sensor.columns() + press.column;
            let error = evaluator.invert(&model.sensor, &[p], |_, siemens| {
                let mut point = circuit.point();
                let error = standard_error_of(&mut point, siemens.values(), taxel, volts).ok()?;
                // At the label: what is read there may be nothing at all, where the law is steep.
                let slope =
                    law.grams_per_siemens(taxel, law.siemens_from_grams(taxel, press.load_g));
                Some(error * slope.abs())
            });
            if let Some(Some(error)) = error
                .map(|mut e| e.swap_remove(0))
                .filter(|e| e.is_some_and(f64::is_finite))
            {
                scales.push((p, error));
            }
        }
        scales
    }
}
