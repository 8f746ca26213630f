//! What a fit hands over to be written down: one form for every way of fitting.

use super::discrepancy::Judged;
use super::evidence::{Evidence, UNIT_DOUBT};
use super::fit::{mean, standard_error};
use super::levels::TaxelMaterial;
use super::model::Model;
use super::{Belief, EffectFinding, Parameter, Suspect};
use crate::material::LoadLaw;
use crate::sensor::UncertaintySpec;

/// The name of what is said of resistance along the lines.
pub(super) const LINES: &str = "line resistance";
/// One fit is better than another when it is so by this many standard errors.
const BETTER: f64 = 2.0;

/// Errors on presses that did not fit what reads them, nor chose it but where `how` says so.
#[derive(Debug, Clone, Default)]
pub(super) struct HeldOut {
    /// Absolute error of each, grams.
    pub(super) errors_g: Vec<f64>,
    /// What each was read as.
    pub(super) judged: Vec<Judged>,
    /// Of each its index in the data that were given, where effects were chosen without it.
    pub(super) origin: Vec<usize>,
    /// Presses that could not be judged: the fit without them failed, or gave their frame no solution.
    pub(super) unjudged: usize,
    /// How they were split off.
    pub(super) how: String,
}

impl HeldOut {
    pub(super) fn mean(&self) -> Option<f64> {
        (!self.errors_g.is_empty()).then(|| mean(&self.errors_g))
    }

    pub(super) fn standard_error(&self) -> f64 {
        standard_error(&self.errors_g)
    }
}

/// A finished fit.
pub(super) struct Outcome {
    pub(super) model: Model,
    pub(super) law: LoadLaw,
    /// How taxels differ, where uniform loads tell.
    pub(super) material: Option<TaxelMaterial>,
    pub(super) parameters: Vec<Parameter>,
    pub(super) findings: Vec<EffectFinding>,
    /// What was believed of each number, and what told it.
    pub(super) beliefs: Vec<Belief>,
    /// Law and held-out mean absolute error, grams.
    pub(super) laws: Vec<(String, f64)>,
    pub(super) law_name: String,
    pub(super) warnings: Vec<String>,
    /// By their index in the evidence.
    pub(super) suspects: Vec<Suspect>,
    pub(super) held_out: HeldOut,
    /// What the fit reads of presses, its own and others.
    pub(super) fitted: Vec<Judged>,
    /// What loads are uncertain by beyond noise, where presses tell.
    pub(super) uncertainty: Option<UncertaintySpec>,
    /// More than noise is left, and effects beside circuit and law were not looked for.
    pub(super) unexplained: bool,
}

impl Outcome {
    /// Whether an effect beside circuit and law is in its model.
    pub(super) fn finds_something(&self) -> bool {
        self.findings.iter().any(|f| f.used)
    }

    /// What it says of resistance along the lines.
    pub(super) fn line_finding(&self) -> Option<EffectFinding> {
        self.findings.iter().find(|f| f.name == LINES).cloned()
    }

    /// Takes over what another fit says of that, where this one did not look for it.
    pub(super) fn take_line_finding(&mut self, other: Option<EffectFinding>) {
        if self.line_finding().is_some() {
            return;
        }
        self.findings.extend(other.map(|finding| EffectFinding {
            text: if finding.used {
                format!(
                    "{}; held-out presses are nearer without it, by what is used here",
                    finding.text
                )
            } else {
                finding.text
            },
            used: false,
            name: finding.name,
        }));
    }

    /// Whether its held-out presses are clearly nearer to their labels than another fit's.
    pub(super) fn is_better_than(&self, other: &Outcome) -> bool {
        let (Some(own), Some(others)) = (self.held_out.mean(), other.held_out.mean()) else {
            return false;
        };
        let error = self
            .held_out
            .standard_error()
            .hypot(other.held_out.standard_error());
        others - own > BETTER * error
    }

    /// What must be said before this fit is trusted: reasons why it is none, or not quite one.
    pub(super) fn doubts(&self, evidence: &Evidence) -> Vec<String> {
        let unit = evidence
            .warnings
            .iter()
            .filter(|w| w.starts_with(UNIT_DOUBT));
        let mut doubts: Vec<String> = unit.cloned().collect();
        for p in &self.parameters {
            if p.standard_error.is_some_and(|e| !e.is_finite()) || !p.value.is_finite() {
                doubts.push(format!(
                    "nothing tells {}: label presses of other loads, on other lines, and some two at a time",
                    p.name
                ));
            }
        }
        let lines = evidence
            .frames
            .first()
            .map_or(0, |f| f.rows() + f.columns());
        let flickering = [crate::screen::Axis::Row, crate::screen::Axis::Column]
            .iter()
            .map(|&axis| evidence.faults.flickering(axis).count())
            .sum::<usize>();
        if 2 * flickering > lines {
            doubts.push(format!(
                "{flickering} of {lines} lines come and go in these frames: that is no fault of single joints; look at the supply, the converter and the topology of the sensor file before this calibration is used"
            ));
        }
        if self.held_out.mean().is_none() {
            doubts.push("no held-out press could be judged, so that nothing says how good this fit is: label more presses, and check labels and topology".to_owned());
        }
        if let Some((found, blind)) = self.against_guessing(evidence)
            && found > 0.5 * blind
        {
            doubts.push(format!(
                "held-out presses are {found:.1} g off on average, and guessing their median would be {blind:.1} g off: little was learnt; label more presses, and check labels and topology"
            ));
        }
        doubts
    }

    /// Mean error of held-out presses, and what guessing the median load would give, grams.
    pub(super) fn against_guessing(&self, evidence: &Evidence) -> Option<(f64, f64)> {
        let suspected = |p: &usize| self.suspects.iter().any(|s| s.press == *p && s.left_out);
        let loads: Vec<f64> = (0..evidence.presses.len())
            .filter(|p| !suspected(p))
            .map(|p| evidence.presses[p].load_g)
            .collect();
        let middle = super::least_squares::median(&loads);
        let off: Vec<f64> = loads.iter().map(|l| (l - middle).abs()).collect();
        Some((self.held_out.mean()?, mean(&off)))
    }
}

#[cfg(test)]
mod tests {
    use super::super::{CalibrationData, CalibrationOptions, presses};
    use super::*;
    use crate::parallel::Serial;
    use crate::screen::{Axis, LineFault, LineFaultKind};
    use crate::sensor::preset;
    use crate::simulate::{VirtualSensor, labelled_presses};

    /// A fit of a sound 8 × 8 sensor, and what it was fitted to.
    fn sound() -> (Outcome, Evidence) {
        let sensor = preset("mat-32x32-adg732")
            .unwrap()
            .edited(|spec| {
                (spec.array.rows, spec.array.columns) = (8, 8);
            })
            .unwrap();
        let real = VirtualSensor::new(&sensor, 1).unwrap();
        let data: CalibrationData = labelled_presses(&real, 30);
        let evidence = Evidence::new(&sensor, &data).unwrap();
        let options = CalibrationOptions::default();
        let (fit, _) = presses::calibrate(&sensor, &evidence, &options, &Serial, &mut |_, _| ());
        (fit.unwrap(), evidence)
    }

    #[test]
    fn a_fit_that_tells_nothing_never_ends_well() {
        let (mut fit, mut evidence) = sound();
        assert_eq!(fit.doubts(&evidence), Vec::<String>::new());

        let good = fit.parameters[0].clone();
        for bad in [f64::INFINITY, f64::NAN] {
            fit.parameters[0].standard_error = Some(bad);
            let doubts = fit.doubts(&evidence).join("\n");
            assert!(doubts.contains("nothing tells readout.r_mux"), "{doubts}");
        }
        fit.parameters[0] = good;

        let judged = std::mem::take(&mut fit.held_out);
        let doubts = fit.doubts(&evidence).join("\n");
        assert!(
            doubts.contains("no held-out press could be judged"),
            "{doubts}"
        );
        fit.held_out = judged;

        for (faulty, doubted) in [(8, false), (9, true)] {
            let line = |i: usize| LineFault {
                axis: if i < 8 { Axis::Row } else { Axis::Column },
                index: i % 8,
                kind: LineFaultKind::Flickering,
                faulty: 10,
                tested: 30,
                median_counts: 0.0,
                has_fallen: false,
                next_to: 100.0,
            };
            evidence.faults.faults = (0..faulty).map(line).collect();
            let doubts = fit.doubts(&evidence).join("\n");
            assert_eq!(
                doubts.contains("come and go"),
                doubted,
                "{faulty}: {doubts}"
            );
        }
    }
}
