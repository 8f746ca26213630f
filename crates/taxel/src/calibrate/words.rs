//! What a fit of everything together says of the effects beyond the circuit.

use super::EffectFinding;
use super::choose::Search;
use super::digits::fixed;
use super::effects::SPREAD;
use super::model::{Model, Unknown};
use super::polish::MIN_ALONE;
use super::together::Together;
use super::told;
use crate::sensor::ScanOrder;

impl Search<'_> {
    /// What was believed of every number, and what told it: of what stays by the last fit, of what went by the one before.
    pub(super) fn tell_beliefs(&mut self, first: &Together, last: &Together) {
        let mut beliefs = told::of_together(last);
        for gone in told::of_together(first) {
            // How contacts share the current of a sheet that is none is nothing to know.
            let is_known = beliefs.iter().any(|kept| kept.name == gone.name);
            if !is_known && gone.name != told::SHEET_CONTACT {
                beliefs.push(gone);
            }
        }
        self.beliefs = beliefs;
    }

    /// What was found of spread, carry-over, offset and sheet, with its error, and whether it stays.
    pub(super) fn words(
        &self,
        found: &Together,
        looked_for: &[Unknown],
        stays: [bool; 4],
    ) -> Vec<EffectFinding> {
        let error = |u: Unknown| found.error_of(u).unwrap_or(f64::NAN);
        let pm = |u: Unknown, factor: f64| {
            format!(
                "{} ± {:.2}",
                fixed(factor * found.model.get(u), 2),
                factor * error(u)
            )
        };
        let kept = found.model.spread.map_or(1.0, |spread| spread.kept());
        let order = match found.model.sensor.converter().scan_order {
            ScanOrder::RowByRow => "row by row",
            ScanOrder::ColumnByColumn => "column by column",
        };
        let texts = [
            (
                Unknown::SpreadRow,
                "spread",
                format!(
                    "neighbours take {} % of a load (one row away {} %, one column {} %, diagonal {} %), from {}",
                    fixed(100.0 * (1.0 - kept), 1),
                    pm(SPREAD[0], 100.0),
                    pm(SPREAD[1], 100.0),
                    pm(SPREAD[2], 100.0),
                    match self.alone() {
                        alone if alone >= MIN_ALONE => format!("{alone} presses"),
                        alone => format!("labels alone: {alone} presses have nothing near them"),
                    }
                ),
            ),
            (
                Unknown::CarryOver,
                "memory of the scan",
                format!(
                    "a reading keeps {} % of the one before, scanned {order}",
                    pm(Unknown::CarryOver, 100.0)
                ),
            ),
            (
                Unknown::Offset,
                "offset",
                format!("{} counts", pm(Unknown::Offset, 1.0)),
            ),
            (
                Unknown::Sheet,
                "sheet",
                sheet_words(&found.model, error(Unknown::Sheet)),
            ),
        ];
        let texts = texts.into_iter().zip(stays);
        texts
            .filter(|((unknown, ..), _)| looked_for.contains(unknown))
            .map(|((_, name, text), used)| EffectFinding {
                name: name.to_owned(),
                used,
                text,
            })
            .collect()
    }
}

fn sheet_words(model: &Model, error: f64) -> String {
    let conducts = model.get(Unknown::Sheet);
    let film = format!("the film conducts {conducts:.0} ± {error:.0} µS between neighbours");
    match model.sheet().filter(|_| conducts > 1.0) {
        Some(sheet) => format!(
            "{film} ({:.1} kΩ), contact factor {:.1}; told by uniform loads, which come out {:+.1} % off the labels' scale",
            sheet.resistance_ohms / 1e3,
            sheet.contact_factor,
            100.0 * (model.law.ln_factor.exp() - 1.0)
        ),
        None => film,
    }
}
