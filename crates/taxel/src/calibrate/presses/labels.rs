//! Labels that the other presses contradict: before anything is fitted, and by what a fit reads.

use super::super::model::no_fit;
use super::super::{LawChoice, Suspect, suspects};
use super::crowd::Crowd;
use super::fit::{Readings, plain_law};
use super::joint::Joint;
use super::known::KnownFrames;
use super::unknowns::Layout;
use super::{ANY_G_ZERO, Chosen, PressFit};
use crate::Error;

/// Standard errors of noise that a conductance is above an unloaded one, before it can contradict a label.
const CLEAR: f64 = 8.0;
/// Standard errors that a label is off by, before it is left out.
const BEYOND: f64 = 6.0;

impl PressFit<'_> {
    /// Labels that contradict the others before anything is fitted.
    pub(super) fn gross(&mut self, known: &KnownFrames) -> Result<Vec<Suspect>, Error> {
        let readings = Readings::new(self.evidence, known, self.sensor);
        let (apparent, clear) = if known.frames.is_empty() {
            // Presses that do not stand out of noise there are left out before.
            (self.through_the_inverse(known, &readings)?, None)
        } else {
            let apparent = readings.apparent(self.sensor).into_iter();
            let labelled = apparent.map(|(p, g)| (p, self.evidence.presses[p].load_g, g));
            let clear = readings.apparent_noise(self.sensor, CLEAR);
            (labelled.collect(), Some(clear))
        };
        let suspects = suspects::gross(&apparent, clear);
        if suspects::few(suspects.len(), apparent.len()) {
            Ok(suspects)
        } else {
            Err(no_fit(&format!(
                "{} of {} labels contradict the others by a factor of 4 or more (are some in other units?)",
                suspects.len(),
                apparent.len()
            )))
        }
    }

    /// Press, label and what its taxel conducts over an unloaded one, for presses in crowded frames alone, by the
    /// switches that are believed in or the first others that leave frames a solution.
    fn through_the_inverse(
        &mut self,
        known: &KnownFrames,
        readings: &Readings,
    ) -> Result<Vec<(usize, f64, f64)>, Error> {
        let crowd = Crowd::new(self.evidence, &known.crowded, self.executor);
        let joint = Joint {
            readings,
            crowd: &crowd,
        };
        let loads = crowd.loads_g();
        let layout = Layout::new(
            self.sensor,
            self.beliefs,
            LawChoice::Power,
            &loads,
            ANY_G_ZERO,
        );
        let layout = layout.ok_or_else(|| no_fit("no label is above nothing"))?;
        let mut linear = joint.first(&layout).ok_or_else(|| {
            no_fit("no switch resistance leaves four frames of five with a solution")
        })?;
        if linear.unloaded.0 > 0.0 {
            self.unloaded = linear.unloaded.0;
        }
        // A conductance that noise may have made contradicts no label.
        let unloaded = linear.unloaded.0;
        linear
            .lines
            .retain(|line| line.siemens - unloaded > CLEAR * line.error);
        let pairs = joint.pairs(&linear);
        self.first = crowd.ends();
        Ok(pairs)
    }

    /// Label and estimate of every press that is not suspected yet.
    pub(super) fn labelled(
        &self,
        estimates: &[Option<f64>],
        suspects: &[Suspect],
    ) -> Vec<(usize, f64, f64)> {
        let presses = self.evidence.presses.iter().zip(estimates).enumerate();
        presses
            .filter(|(p, _)| suspects.iter().all(|s| s.press != *p))
            .filter_map(|(p, (press, says))| says.map(|says| (p, press.load_g, says)))
            .collect()
    }

    /// Whether noise can't be why a fit reads a press otherwise. That of a crowded frame is larger the more stands beside
    /// the press; of presses that did not fit it is not known, and nothing is lost by them.
    pub(super) fn is_beyond_noise(&self, press: usize, chosen: &Chosen) -> bool {
        let Some(linear) = &chosen.linear else {
            return true;
        };
        let fitted = chosen.fitted();
        let wanted =
            plain_law(&fitted.model).siemens_from_grams(0, self.evidence.presses[press].load_g);
        let scatter = fitted.share * (wanted - linear.unloaded.0);
        let line = linear.lines.iter().find(|line| line.press == press);
        line.is_some_and(|l| (l.siemens - wanted).abs() > BEYOND * l.error.hypot(scatter))
    }
}
