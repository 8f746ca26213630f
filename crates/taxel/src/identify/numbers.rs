//! A fitted read-out's numbers as its owner knows them.

use super::candidate::{Number, UNIT_OHMS};
use super::fit::Fitted;
use super::report::NumberFound;
use crate::sensor::Topology;

/// A logarithm that is surer than this tells a number.
const TOLD: f64 = 0.5;

/// The numbers that the frames tell, or do not.
pub(super) fn numbers_of(fit: &Fitted) -> Vec<NumberFound> {
    let candidate = &fit.candidate;
    let (unit, unit_ohms) = candidate.unit();
    let numbers = &fit.state.numbers;
    // What is not fitted adds to what is.
    let row_fitted = candidate.unknowns().contains(&Number::Row);
    let column_fitted = candidate.unknowns().contains(&Number::Column);
    let held = |fitted: bool, log: f64| if fitted { 0.0 } else { log.exp() };
    let in_series = 1.0 + held(row_fitted, numbers.row) + held(column_fitted, numbers.column);
    let known: Vec<(Option<Number>, f64)> = candidate
        .unknowns()
        .iter()
        .map(|&number| (Some(number), numbers.get(number).exp() / in_series))
        .chain([(
            None,
            in_series.recip() * (-fit.state.log_unpressed).exp() / UNIT_OHMS,
        )])
        .collect();
    let found = known.into_iter().enumerate().map(|(at, (number, value))| {
        let error = fit.errors.get(at).copied().unwrap_or(f64::INFINITY);
        let (unit, factor) = match number {
            Some(Number::Scale) => (String::new(), candidate.scale()),
            _ => unit_ohms.map_or((unit.to_owned(), 1.0), |ohms| ("ohms".to_owned(), ohms)),
        };
        NumberFound {
            name: name_of(number, candidate.topology),
            value: (error < TOLD).then_some(value * factor),
            standard_error: (error < TOLD).then_some(value * factor * error),
            unit,
        }
    });
    found.collect()
}

fn name_of(number: Option<Number>, topology: Topology) -> &'static str {
    match number {
        None => "an unpressed taxel",
        Some(Number::Column) => "R_c, the column's switch",
        Some(Number::Row) if topology.is_tia() => {
            "R_r + R_k/(1+A), the row's switch and the amplifier's input"
        }
        Some(Number::Row) => "R_r, the row's switch",
        Some(Number::Scale) if topology == Topology::DividerFloating => {
            "V_t / full scale, times R_p/(R_p+R_r+R_c)"
        }
        Some(Number::Scale) if topology == Topology::DividerVoltageFeedback => "V_t / full scale",
        Some(Number::Scale) => "V_t / full scale, times R_p/(R_p+R_r)",
    }
}
