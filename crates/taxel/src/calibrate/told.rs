//! What was believed of each number before the calibration, what is known of it now, and what told it.

use super::digits::with_error;
use super::effects::SPREAD;
use super::model::{Model, Unknown};
use super::priors::{
    ALIKE_WITHIN, BEND, CONTACT_FACTOR, LEVEL_SCALE, LINE_OHMS, SATURATION, SHEET_MICROSIEMENS,
    SPREAD_DIAGONAL, SPREAD_DIFFERENCE, SPREAD_SHARE, WITHIN,
};
use super::together::Together;
use serde::Serialize;
use std::fmt;

pub(super) const SHEET_CONTACT: &str = "sheet's contact factor";
/// Where more of the variance believed before is left than this, the evidence did not tell a number.
const UNTOLD: f64 = 0.5;

/// A number before and after a calibration.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Belief {
    /// What the number is.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// What was believed before: the most probable value, and a standard deviation (where `before_is_factor`, a factor). None
    /// where nothing was.
    pub before: Option<(f64, f64)>,
    /// Whether it was believed within a factor instead of a standard deviation.
    pub before_is_factor: bool,
    /// Value and standard error now.
    pub after: (f64, f64),
    /// Which part of what is known of it comes from where; the parts sum to 1. "Beliefs" are those about it and about all numbers
    /// that it depends on.
    pub told_by: Vec<(String, f64)>,
    /// Whether most of the variance believed before is left: the number is not told.
    pub untold: bool,
    /// What would tell it, where it is not told and no warning of its own says so.
    pub would_tell: Option<String>,
}

impl Belief {
    /// `shares`: parts of what is known, by where they come from.
    pub(super) fn new(
        (name, unit): (&str, &str),
        before: Option<Before>,
        after: (f64, f64),
        shares: &[(&str, f64)],
        would_tell: Option<&str>,
    ) -> Self {
        let untold = before.is_some_and(|before| before.variance_left(after) > UNTOLD);
        Self {
            name: name.to_owned(),
            unit: unit.to_owned(),
            before: before.map(|b| (b.mean, b.within)),
            before_is_factor: before.is_some_and(|b| b.is_factor),
            after,
            told_by: shares
                .iter()
                .filter(|share| share.1 > 0.0)
                .map(|(name, share)| ((*name).to_owned(), *share))
                .collect(),
            untold,
            would_tell: would_tell.filter(|_| untold).map(str::to_owned),
        }
    }

    /// What to say where it was not told.
    pub(super) fn warning(&self) -> Option<String> {
        let would_tell = self.would_tell.as_ref()?;
        Some(format!(
            "these presses hardly tell {}: before {}, now {}; {would_tell} would tell",
            self.name,
            self.then(),
            self.now()
        ))
    }

    fn then(&self) -> String {
        match self.before {
            None => "nothing".to_owned(),
            Some((mean, factor)) if self.before_is_factor => format!(
                "{}, within a factor {}",
                short(mean),
                (10.0 * factor).round() / 10.0
            ),
            Some((mean, deviation)) => format!("{} ± {}", short(mean), short(deviation)),
        }
    }

    fn now(&self) -> String {
        match with_error(self.after.0, Some(self.after.1)) {
            (value, Some(error)) => format!("{value} ± {error}"),
            (value, None) => value,
        }
    }
}

impl fmt::Display for Belief {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = match self.unit.as_str() {
            "" => self.name.clone(),
            unit => format!("{}, {unit}", self.name),
        };
        let parts = self.told_by.iter().filter(|part| part.1 >= 0.005);
        let parts: Vec<String> = parts
            .map(|(name, share)| format!("{name} {:.0} %", 100.0 * share))
            .collect();
        let (then, now) = (self.then(), self.now());
        write!(f, "{name:<34} {then:<24} {now:<18} {}", parts.join(", "))
    }
}

/// At most three digits, and no more than there are.
fn short(value: f64) -> String {
    let power = if value == 0.0 {
        0
    } else {
        value.abs().log10().floor() as i32
    };
    let unit = 10f64.powi(2 - power);
    format!("{}", (value * unit).round() / unit)
}

/// What was believed of a number.
#[derive(Debug, Clone, Copy)]
pub(super) struct Before {
    mean: f64,
    within: f64,
    is_factor: bool,
}

impl Before {
    pub(super) fn within(mean: f64, deviation: f64) -> Self {
        Self {
            mean,
            within: deviation,
            is_factor: false,
        }
    }

    /// Part of the variance that is left; 1 where nothing is known of the error.
    fn variance_left(self, (value, error): (f64, f64)) -> f64 {
        let left = if self.is_factor {
            error / value.abs() / self.within.ln()
        } else {
            error / self.within
        };
        if left.is_finite() { left * left } else { 1.0 }
    }

    /// Of a logarithm.
    pub(super) fn within_factor((ln_mean, ln_factor): (f64, f64)) -> Self {
        Self {
            mean: ln_mean.exp(),
            within: ln_factor.exp(),
            is_factor: true,
        }
    }
}

/// Every unknown of a fit of everything together.
pub(super) fn of_together(found: &Together) -> Vec<Belief> {
    let shares = found.told_by();
    let unknowns = found.unknowns.iter().zip(shares);
    unknowns
        .map(|(&unknown, shares)| {
            let error = found.error_of(unknown).unwrap_or(f64::NAN);
            let says = Says::of(unknown, &found.model, error);
            let labels = if found.model.levelled {
                "labels and uniform loads"
            } else {
                "labels"
            };
            let names = ["beside lone presses", "unloaded taxels", labels, "beliefs"];
            let parts: Vec<(&str, f64)> = names.into_iter().zip(shares).collect();
            Belief::new(
                (&says.name, says.unit),
                says.before,
                says.after,
                &parts,
                Some(says.would_tell),
            )
        })
        .collect()
}

/// How an unknown is put into words.
struct Says {
    name: String,
    unit: &'static str,
    before: Option<Before>,
    after: (f64, f64),
    would_tell: &'static str,
}

impl Says {
    fn of(unknown: Unknown, model: &Model, error: f64) -> Self {
        let value = model.get(unknown);
        let (name, unit, would_tell) = words(unknown, model.levelled);
        let (column, row) = model.mean_ohms();
        let percent = 100.0;
        let after = match unknown {
            Unknown::Columns => (column, error),
            Unknown::Rows => (row, error),
            Unknown::ColumnLines
            | Unknown::RowLines
            | Unknown::OpenLoopGain
            | Unknown::Source
            | Unknown::SheetContact => (value.exp(), value.exp() * error),
            Unknown::Factor if model.levelled => {
                (percent * value.exp_m1(), percent * value.exp() * error)
            }
            Unknown::Factor => (value.exp(), value.exp() * error),
            Unknown::CarryOver
            | Unknown::SpreadRow
            | Unknown::SpreadColumn
            | Unknown::SpreadDiagonal => (percent * value, percent * error),
            _ => (value, error),
        };
        let name = match unknown {
            Unknown::Bend(knot) => {
                format!("{name} at {} g", short(model.law.knots[knot].exp()))
            }
            _ => name.to_owned(),
        };
        Self {
            name,
            unit,
            before: before(unknown, model),
            after,
            would_tell,
        }
    }
}

fn before(unknown: Unknown, model: &Model) -> Option<Before> {
    let percent = 100.0;
    let zero = |deviation: f64| Some(Before::within(0.0, deviation));
    let beliefs = &model.beliefs;
    match unknown {
        Unknown::Columns => Some(switch(beliefs.column_ohms, beliefs.row_ohms)),
        Unknown::Rows => Some(switch(beliefs.row_ohms, beliefs.column_ohms)),
        Unknown::ColumnLines | Unknown::RowLines => Some(Before::within_factor(LINE_OHMS)),
        Unknown::OpenLoopGain => beliefs.gain.map(Before::within_factor),
        Unknown::Source => beliefs.source.map(Before::within_factor),
        Unknown::Offset | Unknown::CarryOver => None,
        _ if SPREAD.contains(&unknown) && !model.spread_is_believed => None,
        Unknown::SpreadRow | Unknown::SpreadColumn => {
            zero(percent * SPREAD_SHARE.hypot(0.5 * SPREAD_DIFFERENCE))
        }
        Unknown::SpreadDiagonal => {
            zero(percent * (SPREAD_DIAGONAL.0 * SPREAD_SHARE).hypot(SPREAD_DIAGONAL.1))
        }
        Unknown::Sheet => zero(SHEET_MICROSIEMENS),
        Unknown::SheetContact => Some(Before::within_factor(CONTACT_FACTOR)),
        Unknown::Factor => model
            .levelled
            .then(|| Before::within(0.0, percent * LEVEL_SCALE)),
        Unknown::Exponent => Some(Before::within(beliefs.exponent.0, beliefs.exponent.1)),
        Unknown::Saturation => zero(SATURATION),
        Unknown::Bend(_) => zero(BEND),
    }
}

/// One side's switches, of which sum and ratio to the other's are believed.
fn switch(own: f64, other: f64) -> Before {
    let share = other / (own + other);
    let (sum, ratio) = (WITHIN.ln(), share * ALIKE_WITHIN.ln());
    Before::within_factor((own.ln(), sum.hypot(ratio)))
}

/// Name, unit, and what would tell it.
fn words(unknown: Unknown, levelled: bool) -> (&'static str, &'static str, &'static str) {
    let crowded = "heavier presses, and two at once on one line, all labelled,";
    match unknown {
        Unknown::Columns => ("column switches", "Ohm", crowded),
        Unknown::Rows => ("row switches", "Ohm", crowded),
        Unknown::ColumnLines => (
            "columns, a pitch",
            "Ohm",
            "presses far from the columns' ends",
        ),
        Unknown::RowLines => ("rows, a pitch", "Ohm", "presses far from the rows' ends"),
        Unknown::OpenLoopGain => ("open-loop gain", "", "heavier presses"),
        Unknown::Source => (
            "source resistor",
            "Ohm",
            "heavier presses in crowded columns",
        ),
        Unknown::Offset => ("offset", "counts", "frames with unloaded taxels"),
        Unknown::CarryOver => ("memory of the scan", "%", "presses with nothing near them"),
        Unknown::SpreadRow => ("spread one row away", "%", "presses with nothing near them"),
        Unknown::SpreadColumn => (
            "spread one column away",
            "%",
            "presses with nothing near them",
        ),
        Unknown::SpreadDiagonal => (
            "spread across the corner",
            "%",
            "presses with nothing near them",
        ),
        Unknown::Sheet => (
            "sheet",
            "µS",
            "a uniform load, or labelled presses inside a contact,",
        ),
        Unknown::SheetContact => (SHEET_CONTACT, "", "uniform loads at more levels"),
        Unknown::Factor if levelled => (
            "labels beside uniform loads",
            "%",
            "more labelled presses, or labels that err less,",
        ),
        Unknown::Factor => ("factor of the law", "S/g^exponent", "more labelled presses"),
        Unknown::Exponent => ("exponent", "", "a wider range of loads"),
        Unknown::Saturation => ("1/saturation", "1/kg", "heavier presses"),
        Unknown::Bend(_) => ("bend of the law", "", "more presses near that load"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn belief(after: (f64, f64)) -> Belief {
        let before = Some(Before::within_factor((10f64.ln(), 3f64.ln())));
        let name = ("column switches", "Ohm");
        let parts = [
            ("unloaded taxels", 0.9),
            ("labels", 0.097),
            ("beliefs", 0.003),
        ];
        Belief::new(name, before, after, &parts, Some("heavier presses"))
    }

    #[test]
    fn a_number_that_evidence_tells_is_no_warning_and_one_that_it_does_not_is() {
        let told = belief((3.741, 0.221));
        assert_eq!(told.warning(), None);
        assert_eq!(
            told.to_string(),
            "column switches, Ohm               10, within a factor 3    3.74 ± 0.22        unloaded taxels 90 %, labels 10 %"
        );
        let untold = belief((12.0, 10.0));
        assert_eq!(
            untold.warning().unwrap(),
            "these presses hardly tell column switches: before 10, within a factor 3, now 12 ± 10; heavier presses would tell"
        );
        assert!(belief((12.0, f64::NAN)).untold);
    }

    #[test]
    fn short_numbers() {
        for (value, text) in [
            (0.0, "0"),
            (0.05025, "0.0503"),
            (69.99, "70"),
            (1234.0, "1230"),
        ] {
            assert_eq!(short(value), text);
        }
    }
}
