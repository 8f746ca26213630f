//! What a fit of presses made one at a time says: its numbers with their errors, and what it cannot tell.

use super::super::discrepancy::{Beside, uncertainty};
use super::super::outcome::{HeldOut, Outcome};
use super::super::told::Before;
use super::super::{Belief, EffectFinding, LawChoice, Parameter, Suspect};
use super::fit::{Fitted, plain_law};
use super::known::KnownFrames;
use super::line_search::line_ohms;
use super::unknowns::Unknown;
use super::{Chosen, PressFit};
use crate::Error;
use crate::sensor::Topology;

/// A posterior this much of its prior has learnt nothing.
const UNTOLD: f64 = 0.5;

impl PressFit<'_> {
    pub(super) fn outcome(
        &self,
        known: &KnownFrames,
        chosen: &Chosen,
        held_out: HeldOut,
        laws: Vec<(String, f64)>,
        suspects: Vec<Suspect>,
    ) -> Result<Outcome, Error> {
        let (name, fitted) = &chosen.fits[chosen.at];
        let alone = known.presses();
        let outcome = Outcome {
            parameters: parameters(fitted),
            law: plain_law(&fitted.model),
            material: None,
            findings: findings(fitted, alone, known.crowded.len())
                .into_iter()
                .chain(self.line_finding(chosen))
                .collect(),
            beliefs: beliefs(fitted),
            unexplained: alone == 0 && fitted.share > 0.0,
            laws,
            law_name: (*name).to_owned(),
            warnings: self.warnings(fitted, alone),
            suspects,
            uncertainty: uncertainty(&held_out.judged, self.beside(fitted)),
            held_out,
            fitted: Vec::new(),
            model: fitted.model.clone(),
        };
        match outcome.against_guessing(self.evidence) {
            Some((found_g, blind_g)) if found_g >= 0.8 * blind_g && blind_g > 0.0 => {
                Err(Error::NothingLearnt { found_g, blind_g })
            }
            _ => Ok(outcome),
        }
    }

    /// No taxel is known to be unloaded in a crowd, but what no load conducts was fitted.
    fn beside(&self, fitted: &Fitted) -> Beside<'static> {
        let law = plain_law(&fitted.model);
        let error = law.g_zero * error_of_some(fitted, &[(Unknown::GZero, 1.0)]);
        let [up, down] = [1.0, -1.0].map(|sign| law.g_zero + sign * error);
        Beside {
            unloaded_g: &[],
            zero_g: Some((law.grams_from_siemens(0, up) - law.grams_from_siemens(0, down)) / 2.0),
            fit_share: 0.0,
            presses_share_it: true,
            label_share: self.options.label_share,
            inflation: 1.0,
        }
    }

    fn warnings(&self, fitted: &Fitted, alone: usize) -> Vec<String> {
        let mut warnings = Vec::new();
        let (column, row) = fitted.layout.ohms(&fitted.peak.at);
        let sum = column + row;
        let index = |u| fitted.layout.position(u);
        let topology = self.sensor.readout().topology;
        if let Some(split) = index(Unknown::Split)
            && self.sensor.readout().unread_switches().is_empty()
            && fitted.peak.error(split) > UNTOLD * fitted.layout.beliefs.ln_ratio().1
        {
            let error = index(Unknown::Sum).map_or(0.0, |i| sum * fitted.peak.error(i));
            let (total, error) = super::super::digits::with_error(sum, Some(error));
            let error = error.unwrap_or_default();
            warnings.push(match topology {
                Topology::DividerFloating => format!(
                    "column and row switch: only their sum, {total} ± {error} Ohm, matters to this read-out, and only it is told"
                ),
                _ => format!(
                    "column and row switch: {} tell their sum, {total} ± {error} Ohm, and hardly how it splits; that rests on {}. Two presses at once on one row (two of its columns), as heavy as they go and both labelled, would tell",
                    match alone {
                        0 => "these presses".to_owned(),
                        _ => format!("{alone} presses made one at a time"),
                    },
                    if self.sensor.readout().r_mux_column_ohms.is_some() {
"the sensor file's ratio"
} else {
"the belief that both are alike"
}
                ),
            });
        }
        if let Some(sum) = index(Unknown::Sum)
            && self.sensor.readout().unread_switches().len() < 2
            && fitted.peak.error(sum) > UNTOLD * fitted.layout.beliefs.ln_sum().1
        {
            warnings.push(
                "the switch resistances rest on what is believed beforehand, not on these presses: heavier presses would tell".to_owned(),
            );
        }
        if let Some(exponent) = index(Unknown::Exponent)
            && fitted.peak.error(exponent) > UNTOLD * fitted.layout.beliefs.exponent.1
        {
            warnings.push(
                "the exponent rests on what is believed beforehand (0.85 ± 0.2), not on these presses: label a wider range of loads".to_owned(),
            );
        }
        if self.options.law == LawChoice::Saturating
            && !super::is_determined(fitted, Unknown::Saturation)
        {
            warnings.push(
                "these presses do not tell a saturation from none: the law is a power law"
                    .to_owned(),
            );
        }
        if self.options.law == LawChoice::Spline && fitted.layout.law != LawChoice::Spline {
            warnings.push(
                "a spline needs loads that differ by a factor of 3 or more: the law is a power law"
                    .to_owned(),
            );
        }
        warnings
    }
}

fn findings(fitted: &Fitted, alone: usize, crowded: usize) -> Vec<EffectFinding> {
    let beyond = 100.0 * fitted.share;
    let text = match (alone, crowded) {
        (_, 0) => format!("{alone} presses made one at a time; fitted to what the converter reads"),
        (0, _) => format!(
            "{crowded} presses in crowded frames; fitted to what the inverse gives their taxels, with the noise it has there"
        ),
        _ => format!(
            "{alone} presses made one at a time, fitted to what the converter reads, and {crowded} in crowded frames, by the inverse"
        ),
    };
    vec![
        EffectFinding {
            name: "presses".to_owned(),
            used: true,
            text,
        },
        EffectFinding {
            name: "scatter of readings".to_owned(),
            used: fitted.share > 0.0,
            text: format!(
                "{beyond:.2} % of a press beyond its noise: taxels that differ, labels, places"
            ),
        },
    ]
}

/// Standard error of a weighted sum of unknowns.
fn error_of(fitted: &Fitted, weights: &[f64]) -> f64 {
    let mut sum = 0.0;
    for (a, line) in weights.iter().zip(&fitted.peak.covariance) {
        for (b, covariance) in weights.iter().zip(line) {
            sum += a * b * covariance;
        }
    }
    f64::max(sum, 0.0).sqrt()
}

/// The same of a few unknowns.
fn error_of_some(fitted: &Fitted, list: &[(Unknown, f64)]) -> f64 {
    let weigh = |u: &Unknown| list.iter().find(|w| w.0 == *u).map_or(0.0, |w| w.1);
    let weights: Vec<f64> = fitted.layout.unknowns.iter().map(weigh).collect();
    error_of(fitted, &weights)
}

/// What lines resist, where that was fitted.
fn line_parameters(fitted: &Fitted) -> impl Iterator<Item = Parameter> + '_ {
    let names = [
        (Unknown::LineRow, "readout.r_line_row_ohms"),
        (Unknown::LineColumn, "readout.r_line_column_ohms"),
    ];
    names.into_iter().filter_map(|(unknown, name)| {
        let (ohms, error) = line_ohms(fitted, unknown)?;
        Some(Parameter::fitted(name, ohms, error, "Ohm"))
    })
}

/// The diodes' I_s, where there are any.
fn diode_parameter(fitted: &Fitted) -> Option<Parameter> {
    let diode = fitted.model.sensor.readout().diode?;
    fitted.layout.position(Unknown::DiodeSaturation)?;
    let amperes = diode.saturation_amperes;
    let error = amperes * error_of_some(fitted, &[(Unknown::DiodeSaturation, 1.0)]);
    let name = "readout.diode.saturation_amperes";
    Some(Parameter::fitted(name, amperes, error, "A"))
}

fn parameters(fitted: &Fitted) -> Vec<Parameter> {
    let (layout, peak) = (&fitted.layout, &fitted.peak);
    let (column, row) = layout.ohms(&peak.at);
    let share = column / (column + row);
    let ohms = |name, ohms, split| {
        let relative = error_of_some(fitted, &[(Unknown::Sum, 1.0), (Unknown::Split, split)]);
        Parameter::fitted(name, ohms, ohms * relative, "Ohm")
    };
    let one = |unknown| error_of_some(fitted, &[(unknown, 1.0)]);
    let law = plain_law(&fitted.model);
    let mut list = vec![
        ohms("readout.r_mux_column_ohms", column, 1.0 - share),
        ohms("readout.r_mux_row_ohms", row, -share),
    ];
    let readout = fitted.model.sensor.readout();
    if layout.position(Unknown::Gain).is_some() {
        let gain = readout.open_loop_gain().unwrap_or_default();
        list.push(Parameter::fitted(
            "readout.open_loop_gain",
            gain,
            gain * one(Unknown::Gain),
            "",
        ));
    }
    if layout.position(Unknown::Source).is_some() {
        let ohms = readout.r_source_ohms;
        list.push(Parameter::fitted(
            "readout.r_source_ohms",
            ohms,
            ohms * one(Unknown::Source),
            "Ohm",
        ));
    }
    list.extend(diode_parameter(fitted));
    list.extend(line_parameters(fitted));
    let factor = law.ln_scale[0].exp();
    let factor_error = factor * error_of(fitted, &layout.ln_factor_weights());
    let exponent_error = one(Unknown::Exponent);
    let zero_error = law.g_zero * one(Unknown::GZero);
    let law_of = Parameter::fitted;
    list.extend([
        law_of("material.factor", factor, factor_error, "S/g^exponent"),
        law_of("material.exponent", law.exponent[0], exponent_error, ""),
        law_of("material.g_zero_siemens", law.g_zero, zero_error, "S"),
    ]);
    if let (Some(half), Some(i)) = (law.saturation_load_g, layout.position(Unknown::Saturation)) {
        let relative = peak.error(i) / peak.at[i];
        list.push(Parameter::fitted(
            "material.saturation_load_g",
            half,
            half * relative,
            "g",
        ));
    }
    list
}

/// Name and unit of what lines and diodes are, and what would tell it.
fn of_parts(unknown: Unknown) -> ((&'static str, &'static str), &'static str) {
    match unknown {
        Unknown::LineRow => (("rows, a pitch", "Ohm"), "presses far from the rows' ends"),
        Unknown::LineColumn => (
            ("columns, a pitch", "Ohm"),
            "presses far from the columns' ends",
        ),
        _ => (
            ("diodes' I_s", "A"),
            "the diodes' data sheet and temperature",
        ),
    }
}

/// What was believed of every unknown, and what told it.
fn beliefs(fitted: &Fitted) -> Vec<Belief> {
    let (layout, peak) = (&fitted.layout, &fitted.peak);
    let parameters = layout.parameters_at(&peak.at);
    let told = (0..parameters.len()).filter(|&i| !matches!(layout.unknowns[i], Unknown::Scale));
    told.map(|i| {
        let believed = peak.share_of_beliefs(i, &parameters);
        let parts = [("presses", 1.0 - believed), ("beliefs", believed)];
        let (value, error) = (peak.at[i], peak.error(i));
        let prior = parameters[i].prior;
        let plain = || prior.map(|(mean, deviation)| Before::within(mean, deviation));
        let logarithm = || prior.map(Before::within_factor);
        let factor = (value.exp(), value.exp() * error);
        let of =
            |name, before, after, would_tell| Belief::new(name, before, after, &parts, would_tell);
        // Of the first three and the exponent other warnings say more.
        match layout.unknowns[i] {
            Unknown::Sum => of(("column + row switch", "Ohm"), logarithm(), factor, None),
            Unknown::Split => of(("column / row switch", ""), logarithm(), factor, None),
            Unknown::GZero => of(("unloaded conductance", "S"), logarithm(), factor, None),
            Unknown::Exponent => of(("exponent", ""), plain(), (value, error), None),
            Unknown::Gain => of(
                ("open-loop gain", ""),
                logarithm(),
                factor,
                Some("heavier presses"),
            ),
            Unknown::Source => of(
                ("source resistor", "Ohm"),
                logarithm(),
                factor,
                Some("heavier presses in crowded columns"),
            ),
            Unknown::LineRow | Unknown::LineColumn | Unknown::DiodeSaturation => {
                let (name, would_tell) = of_parts(layout.unknowns[i]);
                of(name, logarithm(), factor, Some(would_tell))
            }
            Unknown::Saturation => of(
                ("1/saturation", "1/kg"),
                plain(),
                (value, error),
                Some("heavier presses"),
            ),
            Unknown::Bend(_) | Unknown::Scale => of(
                ("bend of the law", ""),
                plain(),
                (value, error),
                Some("more presses over the range of loads"),
            ),
        }
    })
    .collect()
}
