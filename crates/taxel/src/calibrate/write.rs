//! From the fitted model to a sensor file and a report.

use super::choose::Search;
use super::fit::{mean, standard_error};
use super::model::{Unknown, no_fit};
use super::{Calibration, Options, Parameter, Report};
use crate::screen::Axis;
use crate::sensor::{Bend, Material, PerLine, PerTaxel, Provenance};
use crate::stats::quantile;
use crate::{Error, Sensor};

/// Two fitted numbers whose estimates are correlated more than this can't be told apart.
const ALIKE: f64 = 0.98;
/// Decimals kept of per-taxel numbers.
const DIGITS: f64 = 1e6;

impl Search<'_> {
    /// The sensor with everything that was fitted, and the report.
    pub(super) fn finish(
        mut self,
        known: &Sensor,
        options: &Options,
    ) -> Result<Calibration, Error> {
        let (fitted, score) = self
            .best
            .take()
            .ok_or_else(|| no_fit("nothing was fitted"))?;
        let model = self.model.clone();
        let law = self
            .evaluator
            .law(&model)
            .ok_or_else(|| no_fit("the fitted law is impossible"))?;
        let material = self.evaluator.material(&model);
        let evidence = self.evaluator.evidence;
        let mut sensor = model.sensor.clone();
        sensor.converter.memory = sensor.converter.memory.max(0.0);
        sensor.converter.noise_counts = Some(round(evidence.noise_counts, 1e3));
        let (columns, rows) = (sensor.columns(), sensor.rows());
        let each = |values: &[f64]| {
            PerTaxel::Each(
                values
                    .chunks_exact(columns)
                    .map(|row| row.iter().map(|v| round(*v, DIGITS)).collect())
                    .collect(),
            )
        };
        let (factor, exponent, gain) = match &material {
            None => (law.ln_scale[0].exp(), PerTaxel::One(law.exponent[0]), None),
            Some(material) => {
                let gain: Vec<f64> = law
                    .ln_scale
                    .iter()
                    .map(|s| (s - material.intercept).exp())
                    .collect();
                let exponent = match model.law.own_exponents {
                    true => each(&law.exponent),
                    false => PerTaxel::One(material.exponent),
                };
                (material.intercept.exp(), exponent, Some(each(&gain)))
            }
        };
        sensor.material = Some(Material {
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
            // Found from other data, with another static law.
            dynamic: None,
        });
        for list in [
            &mut sensor.readout.r_mux_column_ohms,
            &mut sensor.readout.r_mux_row_ohms,
        ] {
            if let Some(PerLine::Each(values)) = list {
                values.iter_mut().for_each(|v| *v = round(*v, DIGITS));
            }
        }
        let lines = |axis, dead| -> Vec<usize> {
            match dead {
                true => evidence.faults.dead(axis).collect(),
                false => evidence.faults.flickering(axis).collect(),
            }
        };
        sensor.screen.dead_rows = lines(Axis::Row, true);
        sensor.screen.dead_columns = lines(Axis::Column, true);
        sensor.screen.flickering_rows = lines(Axis::Row, false);
        sensor.screen.flickering_columns = lines(Axis::Column, false);

        let mut report = Report {
            presses: evidence.presses.len(),
            left_out: evidence.left_out.clone(),
            folds: options.folds,
            held_out_mean_absolute_g: score.mean_error(),
            held_out_standard_error_g: standard_error(&score.errors_g),
            held_out_p95_g: quantile(score.errors_g.iter().copied(), 0.95).unwrap_or(0.0),
            laws: self.laws.clone(),
            law: self.law.clone(),
            findings: self.findings.clone(),
            ..Report::default()
        };
        let error = |u| fitted.error_of(u).unwrap_or(0.0);
        let mut put = |name: &str, value: f64, standard_error: f64, unit: &str| {
            report.parameters.push(Parameter {
                name: name.to_owned(),
                value,
                standard_error,
                unit: unit.to_owned(),
            });
        };
        let mean_ohms = |list: &Option<PerLine>, n| list.as_ref().map_or(0.0, |l| l.mean(n));
        let column = mean_ohms(&sensor.readout.r_mux_column_ohms, columns);
        let row = mean_ohms(&sensor.readout.r_mux_row_ohms, rows);
        put(
            "readout.r_mux_column_ohms",
            column,
            error(Unknown::Columns),
            "Ohm",
        );
        put("readout.r_mux_row_ohms", row, error(Unknown::Rows), "Ohm");
        if options.open_loop_gain {
            let gain = sensor.readout.open_loop_gain.unwrap_or(0.0);
            put(
                "readout.open_loop_gain",
                gain,
                gain * error(Unknown::OpenLoopGain),
                "",
            );
        }
        if options.r_source {
            let ohms = sensor.readout.r_source_ohms;
            put(
                "readout.r_source_ohms",
                ohms,
                ohms * error(Unknown::Source),
                "Ohm",
            );
        }
        put(
            "material.factor",
            factor,
            factor * error(Unknown::Factor),
            "S/g^exponent",
        );
        put(
            "material.exponent",
            mean(&law.exponent),
            error(Unknown::Exponent),
            "",
        );
        put("material.g_zero_siemens", law.g_zero, 0.0, "S");
        if let Some(half) = law.saturation_load_g {
            let relative = error(Unknown::Saturation) / model.law.saturation.max(1e-9);
            put("material.saturation_load_g", half, half * relative, "g");
        }
        self.warn(&fitted, known, &mut report);
        sensor.screen.repair |= evidence.stuck_share > 0.0 && evidence.stuck_share < 0.05;
        if sensor.screen.repair && !known.screen.repair {
            report.warnings.push(format!(
                "{:.2} % of the readings are stuck at an end of the converter; the sensor file asks for their repair (screen.repair), and they are marked `interpolated`",
                100.0 * evidence.stuck_share
            ));
        }
        for fault in &evidence.faults.faults {
            report.warnings.push(fault.to_string());
        }
        sensor.provenance = Some(Provenance {
            program: format!("taxel {}", env!("CARGO_PKG_VERSION")),
            date: options.date.clone(),
            data: options.files.clone(),
            presses: report.presses,
            cross_validated_error_g: Some(round(report.held_out_mean_absolute_g, 1e4)),
            cross_validation: Some(format!("{} folds, split by frame", options.folds)),
            standard_errors: report
                .parameters
                .iter()
                .map(|p| (p.name.clone(), p.standard_error))
                .collect(),
            findings: report
                .findings
                .iter()
                .map(|f| {
                    format!(
                        "{} ({}): {}",
                        f.name,
                        if f.used { "used" } else { "not used" },
                        f.text
                    )
                })
                .collect(),
        });
        Ok(Calibration {
            sensor: sensor.checked()?,
            report,
        })
    }

    fn warn(&self, fitted: &super::fit::Fitted, known: &Sensor, report: &mut Report) {
        for (i, &a) in self.unknowns.iter().enumerate() {
            for &b in &self.unknowns[..i] {
                if let Some(r) = fitted.correlation(a, b)
                    && (r.abs() > ALIKE || !r.is_finite())
                {
                    report.warnings.push(format!(
                        "{} and {} can't be told apart by these presses (correlation {r:.3}): trust their combination, not each; presses in crowded frames would separate them",
                        name(b), name(a)
                    ));
                }
            }
        }
        if self.options.per_line && !self.separated {
            report.warnings.push(
                "one resistance per line was asked for, but only uniform frames at two levels or more (--equilibration) can tell lines apart".to_owned(),
            );
        }
        if known.readout.topology.is_tia() {
            report.warnings.push(
                "r_mux_row_ohms stands for itself plus what r_feedback_ohms/(1 + open_loop_gain) differs from the file: the two are one sum".to_owned(),
            );
        }
    }
}

fn name(unknown: Unknown) -> &'static str {
    match unknown {
        Unknown::Columns => "r_mux_column_ohms",
        Unknown::Rows => "r_mux_row_ohms",
        Unknown::OpenLoopGain => "open_loop_gain",
        Unknown::Source => "r_source_ohms",
        Unknown::Offset => "offset_volts",
        Unknown::Memory => "memory",
        Unknown::SpreadRow => "spread along columns",
        Unknown::SpreadColumn => "spread along rows",
        Unknown::SpreadDiagonal => "diagonal spread",
        Unknown::Factor => "factor",
        Unknown::Exponent => "exponent",
        Unknown::Saturation => "saturation_load_g",
        Unknown::Bend(_) => "bend",
    }
}

fn round(value: f64, digits: f64) -> f64 {
    (value * digits).round() / digits
}
