//! From the fitted model to a sensor file and a report.

use super::choose::Search;
use super::discrepancy::{Judged, doubt_label_share};
use super::evidence::Evidence;
use super::fit::{Fitted, mean};
use super::model::{Model, Unknown, no_fit};
use super::outcome::{HeldOut, Outcome};
use super::residuals::residuals;
use super::{
    Belief, Calibration, CalibrationOptions, CalibrationReport, Parameter, even_loads, polish,
    suspects,
};
use crate::circuit::{Circuit, Converter, SensorCircuit};
use crate::material::LoadLaw;
use crate::screen::Axis;
use crate::sensor::{Bend, MaterialSpec, PerLine, PerTaxel, Provenance, SensorSpec, SheetSpec};
use crate::stats::quantile;
use crate::{Error, Frame, Sensor, Siemens};

/// Two fitted numbers whose estimates are correlated more than this can't be told apart.
const ALIKE: f64 = 0.98;
/// A load this many times the heaviest label may well come.
const ABOVE_LABELS: f64 = 1.2;
/// Decimals kept of per-taxel numbers.
const DIGITS: f64 = 1e6;

impl Search<'_> {
    /// The fit with its numbers and their errors.
    pub(super) fn finish(mut self) -> Result<Outcome, Error> {
        let uncertainty = self.uncertainty();
        let (found, _) = self
            .best
            .take()
            .ok_or_else(|| no_fit("nothing was fitted"))?;
        let model = self.model.clone();
        let law = self
            .evaluator
            .law(&model)
            .ok_or_else(|| no_fit("the fitted law is impossible"))?;
        let material = self.evaluator.material(&model);
        let mut warnings = std::mem::take(&mut self.doubts);
        self.warn(&found, &mut warnings);
        let factor = match &material {
            None => law.ln_scale[0].exp(),
            Some(material) => material.intercept.exp(),
        };
        let parameters = self.parameters(&found, &law, factor);
        let suspects = self.suspects(&model);
        let fitted = self.read_by_all(&model);
        Ok(Outcome {
            model,
            law,
            material,
            parameters,
            findings: self.findings.clone(),
            beliefs: self.beliefs.clone(),
            laws: self.laws.clone(),
            law_name: self.law.clone(),
            warnings,
            suspects,
            uncertainty,
            held_out: HeldOut {
                judged: self.judged.clone(),
                ..self.held_out.clone()
            },
            fitted,
            unexplained: false,
        })
    }

    /// What the fit of all presses reads of them, in the way that held-out ones were read.
    fn read_by_all(&mut self, model: &Model) -> Vec<Judged> {
        let Some(estimates) = self.evaluator.estimates(model) else {
            return Vec::new();
        };
        let says = if self.together.is_some() {
            polish::judged(&self.evaluator, &estimates)
        } else {
            estimates.iter().map(|says| Some(says.load_g)).collect()
        };
        self.readings(&says)
    }

    /// Labels that the fit reads otherwise.
    fn suspects(&mut self, model: &Model) -> Vec<super::Suspect> {
        let Some(estimates) = self.evaluator.estimates(model) else {
            return Vec::new();
        };
        let presses = self.evaluator.evidence.presses.iter().zip(&estimates);
        let labelled: Vec<(usize, f64, f64)> = presses
            .enumerate()
            .map(|(i, (press, says))| (i, press.load_g, says.load_g))
            .collect();
        let found = suspects::after(&labelled);
        if suspects::few(found.len(), labelled.len()) {
            found
        } else {
            Vec::new()
        }
    }

    /// Standard error of a fitted unknown: of everything fitted together, where that was kept.
    fn error_of(&self, fitted: &Fitted, unknown: Unknown) -> Option<f64> {
        match &self.together {
            Some(together) => together.error_of(unknown),
            None => fitted.error_of(unknown),
        }
    }

    /// The same of the fit that was kept.
    pub(super) fn found_error(&self, unknown: Unknown) -> Option<f64> {
        self.error_of(&self.best.as_ref()?.0, unknown)
    }

    fn correlation(&self, fitted: &Fitted, a: Unknown, b: Unknown) -> Option<f64> {
        match &self.together {
            Some(together) => together.correlation(a, b),
            None => fitted.correlation(a, b),
        }
    }

    /// The numbers of the sensor file that were fitted, and those that were held.
    fn parameters(&mut self, fitted: &Fitted, law: &LoadLaw, factor: f64) -> Vec<Parameter> {
        let g_zero_error = self.evaluator.g_zero_error(&self.model);
        let readout = self.model.sensor.readout();
        let number =
            |name: &str, value: f64, unknown, relative: f64, unit: &str, by: &str| match self
                .error_of(fitted, unknown)
            {
                Some(error) => Parameter::fitted(name, value, error * relative, unit),
                None => Parameter::held(name, value, by, unit),
            };
        let unloaded = "what unloaded taxels read";
        let levels = "equilibration";
        let mut sides = vec![
            ("readout.r_mux_column_ohms", Unknown::Columns),
            ("readout.r_mux_row_ohms", Unknown::Rows),
        ];
        if self.model.seeks_lines {
            sides.push(("readout.r_line_column_ohms", Unknown::ColumnLines));
            sides.push(("readout.r_line_row_ohms", Unknown::RowLines));
        }
        let (switches, lines) = (self.model.mean_ohms(), self.model.mean_line_ohms());
        let means = [switches.0, switches.1, lines.0, lines.1];
        // What lines resist is found as a logarithm.
        let relative = [1.0, 1.0, lines.0, lines.1];
        let sides = sides.into_iter().zip(means).zip(relative);
        let mut list: Vec<Parameter> = sides
            .map(|(((name, unknown), ohms), by)| number(name, ohms, unknown, by, "Ohm", unloaded))
            .collect();
        let file = "the sensor file";
        if self.unknowns.contains(&Unknown::OpenLoopGain) {
            let gain = readout.open_loop_gain().unwrap_or(0.0);
            let name = "readout.open_loop_gain";
            list.push(number(name, gain, Unknown::OpenLoopGain, gain, "", file));
        }
        if self.unknowns.contains(&Unknown::Source) {
            let ohms = readout.r_source_ohms;
            let name = "readout.r_source_ohms";
            list.push(number(name, ohms, Unknown::Source, ohms, "Ohm", file));
        }
        let (name, unit) = ("material.factor", "S/g^exponent");
        list.push(number(name, factor, Unknown::Factor, factor, unit, levels));
        let (name, exponent) = ("material.exponent", mean(&law.exponent));
        list.push(number(name, exponent, Unknown::Exponent, 1.0, "", levels));
        let name = "material.g_zero_siemens";
        list.push(match g_zero_error {
            Some(error) => Parameter::fitted(name, law.g_zero, error, "S"),
            None => Parameter::held(name, law.g_zero, "the quietest fifth of the taxels", "S"),
        });
        if let Some(half) = law.saturation_load_g {
            let relative = half / self.model.law.saturation.max(1e-9);
            let name = "material.saturation_load_g";
            let start = "the start";
            list.push(number(
                name,
                half,
                Unknown::Saturation,
                relative,
                "g",
                start,
            ));
        }
        list
    }

    fn warn(&self, fitted: &Fitted, warnings: &mut Vec<String>) {
        for (i, &a) in self.unknowns.iter().enumerate() {
            for &b in &self.unknowns[..i] {
                if let Some(r) = self.correlation(fitted, a, b)
                    && (r.abs() > ALIKE || !r.is_finite())
                {
                    warnings.push(format!(
                        "{} and {} can't be told apart by these presses (correlation {r:.3}): trust their combination, not each; presses in crowded frames would separate them",
                        name(b), name(a)
                    ));
                }
            }
        }
        if self.options.per_line && !self.separated {
            warnings.push(
                "one resistance per line was asked for, but only uniform frames at two levels or more can tell lines apart".to_owned(),
            );
        }
        if let Some(error) = self.error_of(fitted, Unknown::Saturation)
            && self.model.law.saturation < 2.0 * error
        {
            warnings.push(
                "these presses do not tell a saturation from none: a power law says as much with a number less".to_owned(),
            );
        }
    }
}

/// The calibrated sensor and the report of a fit.
pub(super) fn calibration(
    mut outcome: Outcome,
    known: &Sensor,
    evidence: &Evidence,
    options: &CalibrationOptions,
) -> Result<Calibration, Error> {
    let unread = known.readout().unread_switches();
    outcome
        .parameters
        .retain(|parameter| !unread.contains(&parameter.name.as_str()));
    let found = outcome.model.sensor.edited(|spec| {
        write_found(spec, &outcome, evidence);
        spec.readout.forget_unread_switches();
    })?;
    let found = found.edited(|spec| {
        spec.screen.ceiling_is_load |= reads_ceiling(&found, ABOVE_LABELS * heaviest_g(evidence));
    })?;
    let residuals = residuals(&outcome, evidence);
    let doubted = doubt_label_share(&outcome.held_out.judged, options.label_share);
    outcome.warnings.extend(doubted);
    let report = report(outcome, known, &found, evidence);
    let provenance = provenance(&report, options);
    Ok(Calibration {
        sensor: found.edited(|spec| spec.provenance = Some(provenance))?,
        report,
        residuals,
    })
}

fn heaviest_g(evidence: &Evidence) -> f64 {
    evidence.loads_g().into_iter().fold(0.0, f64::max)
}

/// Whether a load on a taxel in the middle, alone, reads the converter's ceiling.
fn reads_ceiling(sensor: &Sensor, load_g: f64) -> bool {
    let counts = || -> Result<f64, Error> {
        let law = LoadLaw::from_sensor(sensor)?;
        let (rows, columns) = (sensor.rows(), sensor.columns());
        let middle = rows / 2 * columns + columns / 2;
        let mut siemens = Frame::<Siemens>::zeros(rows, columns);
        for (taxel, value) in siemens.values_mut().iter_mut().enumerate() {
            let load_g = if taxel == middle { load_g } else { 0.0 };
            *value = law.siemens_from_grams(taxel, load_g);
        }
        let volts = SensorCircuit::from_sensor(sensor)?.predict(&siemens);
        let volts = volts.map_err(|_| no_fit("the network of one press has no solution"))?;
        Ok(Converter::from_sensor(sensor).count_from_volt(volts.values()[middle]))
    };
    counts().is_ok_and(|counts| counts >= sensor.max_count())
}

fn write_found(spec: &mut SensorSpec, outcome: &Outcome, evidence: &Evidence) {
    spec.converter.carry_over = spec.converter.carry_over.max(0.0);
    spec.converter.noise_counts = Some(round(evidence.noise_counts, 1e3));
    spec.material = Some(material(outcome, spec.array.columns));
    spec.uncertainty = (outcome.uncertainty).map(|told| told.of(spec.material.as_ref()));
    for list in [
        &mut spec.readout.r_mux_column_ohms,
        &mut spec.readout.r_mux_row_ohms,
        &mut spec.readout.r_line_column_ohms,
        &mut spec.readout.r_line_row_ohms,
    ] {
        if let Some(PerLine::Each(values)) = list {
            values.iter_mut().for_each(|v| *v = round(*v, DIGITS));
        }
    }
    let (faults, screen) = (&evidence.faults, &mut spec.screen);
    screen.dead_rows = faults.dead(Axis::Row).collect();
    screen.dead_columns = faults.dead(Axis::Column).collect();
    screen.flickering_rows = faults.flickering(Axis::Row).collect();
    screen.flickering_columns = faults.flickering(Axis::Column).collect();
    screen.ceiling_is_load |= evidence.least_at_ceiling_g.is_some();
    screen.repair |= evidence.stuck_share > 0.0 && evidence.stuck_share < 0.05;
}

fn report(
    outcome: Outcome,
    known: &Sensor,
    sensor: &Sensor,
    evidence: &Evidence,
) -> CalibrationReport {
    let mut doubts = outcome.doubts(evidence);
    if outcome.material.is_none() {
        doubts.extend(even_loads::doubt(sensor, evidence));
    }
    let held = &outcome.held_out;
    let mut report = CalibrationReport {
        presses: evidence.presses.len() - outcome.suspects.iter().filter(|s| s.left_out).count(),
        left_out: evidence.left_out.clone(),
        doubts,
        held_out: held.how.clone(),
        held_out_presses: held.errors_g.len(),
        held_out_unjudged: held.unjudged,
        held_out_mean_absolute_g: held.mean(),
        held_out_standard_error_g: held.standard_error(),
        held_out_p95_g: quantile(held.errors_g.iter().copied(), 0.95).unwrap_or(0.0),
        suspects: outcome.suspects,
        laws: outcome.laws,
        law: outcome.law_name,
        findings: outcome.findings,
        beliefs: outcome.beliefs,
        parameters: outcome.parameters,
        warnings: outcome.warnings,
    };
    let untold = report.beliefs.iter().filter_map(Belief::warning);
    report.warnings.extend(untold.collect::<Vec<_>>());
    for suspect in &mut report.suspects {
        suspect.press = evidence.origin[suspect.press];
    }
    let more = evidence
        .warnings
        .iter()
        .filter(|w| !report.doubts.contains(w));
    report.warnings.extend(more.cloned());
    if known.readout().has_amplifier() {
        report.warnings.push(
            "r_mux_row_ohms stands for itself plus what r_feedback_ohms/(1 + open_loop_gain) differs from the file: the two are one sum".to_owned(),
        );
    }
    if sensor.screen().repair && !known.screen().repair {
        report.warnings.push(format!(
            "{} % of the readings are stuck at an end of the converter; the sensor file asks for their repair (screen.repair), and they are marked `interpolated`",
            super::digits::with_error(100.0 * evidence.stuck_share, None).0
        ));
    }
    if sensor.screen().ceiling_is_load && !known.screen().ceiling_is_load {
        let loads = match evidence.least_at_ceiling_g {
            Some(least_g) => format!("labelled loads of {least_g:.0} g and more"),
            None => format!(
                "loads a fifth above the heaviest label, {:.0} g,",
                heaviest_g(evidence)
            ),
        };
        report.warnings.push(format!(
            "{loads} read the converter's ceiling: what reads it is a lower bound, marked `saturated`, and never taken for a stuck reading (screen.ceiling_is_load)"
        ));
    }
    for fault in &evidence.faults.faults {
        report.warnings.push(fault.to_string());
    }
    report
}

fn material(outcome: &Outcome, columns: usize) -> MaterialSpec {
    let (law, model) = (&outcome.law, &outcome.model);
    let each = |values: &[f64]| {
        PerTaxel::Each(
            values
                .chunks_exact(columns)
                .map(|row| row.iter().map(|v| round(*v, DIGITS)).collect())
                .collect(),
        )
    };
    let (factor, exponent, gain) = match &outcome.material {
        None => (law.ln_scale[0].exp(), PerTaxel::One(law.exponent[0]), None),
        Some(material) => {
            let gain: Vec<f64> = law
                .ln_scale
                .iter()
                .map(|s| (s - material.intercept).exp())
                .collect();
            let exponent = if model.law.own_exponents {
                each(&law.exponent)
            } else {
                PerTaxel::One(material.exponent)
            };
            (material.intercept.exp(), exponent, Some(each(&gain)))
        }
    };
    MaterialSpec {
        g_zero_siemens: law.g_zero,
        factor,
        exponent,
        gain,
        saturation_load_g: law.saturation_load_g,
        bend: law.bend.is_some().then(|| Bend {
            ln_load_g: model.law.knots.clone(),
            ln_siemens: model.law.bends.clone(),
        }),
        spread: model
            .spread
            .map(|s| [s.row, s.column, s.diagonal].map(|x| round(x.max(0.0), 1e7))),
        sheet: model.sheet().map(|sheet| {
            let digits = |value: f64| round(value, 1e3);
            SheetSpec::new(digits(sheet.resistance_ohms), digits(sheet.contact_factor))
        }),
        // Found from other data, with another static law.
        dynamic: None,
    }
}

fn provenance(report: &CalibrationReport, options: &CalibrationOptions) -> Provenance {
    let parameters = report.parameters.iter();
    Provenance {
        program: format!("taxel {}", env!("CARGO_PKG_VERSION")),
        date: options.date.clone(),
        data: options.files.clone(),
        presses: report.presses,
        cross_validated_error_g: report.held_out_mean_absolute_g.map(|g| round(g, 1e4)),
        cross_validation: Some(report.held_out.clone()),
        standard_errors: parameters
            .clone()
            .filter_map(|p| Some((p.name.clone(), p.standard_error?)))
            .collect(),
        held: parameters
            .filter_map(|p| Some((p.name.clone(), p.held.clone()?)))
            .collect(),
        findings: report
            .findings
            .iter()
            .map(|f| {
                let used = if f.used { "used" } else { "not used" };
                format!("{} ({used}): {}", f.name, f.text)
            })
            .collect(),
    }
}

fn name(unknown: Unknown) -> &'static str {
    match unknown {
        Unknown::Columns => "r_mux_column_ohms",
        Unknown::Rows => "r_mux_row_ohms",
        Unknown::ColumnLines => "r_line_column_ohms",
        Unknown::RowLines => "r_line_row_ohms",
        Unknown::OpenLoopGain => "open_loop_gain",
        Unknown::Source => "r_source_ohms",
        Unknown::Offset => "offset_volts",
        Unknown::CarryOver => "memory",
        Unknown::SpreadRow => "spread along columns",
        Unknown::SpreadColumn => "spread along rows",
        Unknown::SpreadDiagonal => "diagonal spread",
        Unknown::Sheet => "sheet.resistance_ohms",
        Unknown::SheetContact => "sheet.contact_factor",
        Unknown::Factor => "factor",
        Unknown::Exponent => "exponent",
        Unknown::Saturation => "saturation_load_g",
        Unknown::Bend(_) => "bend",
    }
}

fn round(value: f64, digits: f64) -> f64 {
    (value * digits).round() / digits
}
