//! Ranges of values, and the power of ten that lets their labels fit.

/// Beyond this magnitude values are drawn as if they were this large.
const MAX_MAGNITUDE: f64 = 1e300;
/// Ranges narrower than this are treated as a single value.
const NARROWEST: f64 = 1e-290;

/// Units that take an SI prefix.
const PREFIXED_UNITS: [&str; 8] = ["V", "S", "N", "Pa", "Ω", "A", "W", "Hz"];
/// SI prefixes from 10⁻¹⁵ in steps of 10³.
const PREFIXES: [&str; 10] = ["f", "p", "n", "µ", "m", "", "k", "M", "G", "T"];

/// Lowest and highest of the finite `values`.
pub(crate) fn finite_range(values: impl IntoIterator<Item = f64>) -> Option<(f64, f64)> {
    values
        .into_iter()
        .filter(|v| v.is_finite())
        .fold(None, |range, v| match range {
            None => Some((v, v)),
            Some((low, high)) => Some((f64::min(low, v), f64::max(high, v))),
        })
}

/// The range made to begin or end at 0 where that widens it by little.
pub(crate) fn from_zero((low, high): (f64, f64)) -> (f64, f64) {
    const LITTLE: f64 = 0.05;
    if low > 0.0 && low <= LITTLE * high {
        (0.0, high)
    } else if high < 0.0 && high >= LITTLE * low {
        (low, 0.0)
    } else {
        (low, high)
    }
}

/// The range that covers both.
pub(crate) fn union(a: Option<(f64, f64)>, b: Option<(f64, f64)>) -> Option<(f64, f64)> {
    match (a, b) {
        (Some(a), Some(b)) => Some((a.0.min(b.0), a.1.max(b.1))),
        (one, other) => one.or(other),
    }
}

/// A range that can be drawn: finite, rising, wide enough. A single value becomes the range from 0 to it,
/// nothing (or only zeros) becomes 0 to 1.
pub(crate) fn drawable(range: Option<(f64, f64)>) -> (f64, f64) {
    let Some((a, b)) = range.filter(|(a, b)| a.is_finite() && b.is_finite()) else {
        return (0.0, 1.0);
    };
    let low = a.min(b).clamp(-MAX_MAGNITUDE, MAX_MAGNITUDE);
    let high = a.max(b).clamp(-MAX_MAGNITUDE, MAX_MAGNITUDE);
    let largest = low.abs().max(high.abs());
    if high - low > NARROWEST.max(1e-9 * largest) {
        (low, high)
    } else if largest < NARROWEST {
        (0.0, 1.0)
    } else {
        (low.min(0.0), high.max(0.0))
    }
}

/// A power of ten taken out of all numbers of an axis.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Scale {
    exponent: i32,
    /// The unit with its prefix or power, such as `nS` or `×10⁶ counts`.
    pub(crate) unit: String,
}

impl Scale {
    /// The scale for numbers up to `largest` of `unit`.
    pub(crate) fn new(unit: &str, (low, high): (f64, f64)) -> Scale {
        let largest = low.abs().max(high.abs());
        let exponent = if largest > 0.0 {
            ((largest.log10() + 1e-9) / 3.0).floor() as i32 * 3
        } else {
            0
        };
        let prefixed = PREFIXED_UNITS.contains(&unit);
        let plain = if prefixed { 0.1..1e3 } else { 1e-2..1e6 };
        if exponent == 0 || plain.contains(&largest) {
            return Scale {
                exponent: 0,
                unit: unit.to_owned(),
            };
        }
        let prefix = usize::try_from(exponent / 3 + 5)
            .ok()
            .and_then(|i| PREFIXES.get(i));
        let unit = match prefix {
            Some(prefix) if prefixed => format!("{prefix}{unit}"),
            _ => format!("×10{} {unit}", superscript(exponent))
                .trim_end()
                .to_owned(),
        };
        Scale { exponent, unit }
    }

    /// `value` as it stands at a tick.
    pub(crate) fn apply(&self, value: f64) -> f64 {
        if self.exponent < 0 {
            value * 10_f64.powi(-self.exponent)
        } else {
            value / 10_f64.powi(self.exponent)
        }
    }

    /// `quantity (unit)`, or the one of them that there is.
    pub(crate) fn label(&self, quantity: &str) -> String {
        match (quantity.is_empty(), self.unit.is_empty()) {
            (false, false) if quantity != self.unit => format!("{quantity} ({})", self.unit),
            (true, _) => self.unit.clone(),
            _ => quantity.to_owned(),
        }
    }
}

fn superscript(number: i32) -> String {
    const DIGITS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    let digits = number.unsigned_abs().to_string();
    let sign = if number < 0 { "⁻" } else { "" };
    digits.bytes().fold(sign.to_owned(), |text, digit| {
        text + &DIGITS[usize::from(digit - b'0')].to_string()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit(unit: &str, largest: f64) -> String {
        Scale::new(unit, (0.0, largest)).unit
    }

    #[test]
    fn units_take_the_prefix_of_their_size() {
        assert_eq!(unit("S", 1e-9), "nS");
        assert_eq!(unit("S", 4.2e-5), "µS");
        assert_eq!(unit("V", 0.4), "V");
        assert_eq!(unit("V", 0.04), "mV");
        assert_eq!(unit("Pa", 2.5e4), "kPa");
        assert_eq!(unit("S", 3e-20), "×10⁻²¹ S");
        assert_eq!(unit("counts", 65_535.0), "counts");
        assert_eq!(unit("counts", 2e6), "×10⁶ counts");
        assert_eq!(unit("", 2e6), "×10⁶");
        assert_eq!(unit("N", 0.0), "N");
    }

    #[test]
    fn a_scaled_value_is_what_the_label_says() {
        let scale = Scale::new("S", (0.0, 5e-9));
        assert!((scale.apply(5e-9) - 5.0).abs() < 1e-12);
        assert_eq!(scale.label("conductance"), "conductance (nS)");
        assert_eq!(scale.label(""), "nS");
    }

    #[test]
    fn every_range_becomes_drawable() {
        assert_eq!(drawable(None), (0.0, 1.0));
        assert_eq!(drawable(Some((0.0, 0.0))), (0.0, 1.0));
        assert_eq!(drawable(Some((5.0, 5.0))), (0.0, 5.0));
        assert_eq!(drawable(Some((-5.0, -5.0))), (-5.0, 0.0));
        assert_eq!(drawable(Some((f64::NAN, 1.0))), (0.0, 1.0));
        assert_eq!(drawable(Some((2.0, 1.0))), (1.0, 2.0));
        let (low, high) = drawable(Some((f64::MIN, f64::MAX)));
        assert!((high - low).is_finite());
    }

    #[test]
    fn a_range_that_ends_next_to_zero_ends_at_zero() {
        assert_eq!(from_zero((0.02, 4.4)), (0.0, 4.4));
        assert_eq!(from_zero((-4.4, -0.02)), (-4.4, 0.0));
        assert_eq!(from_zero((0.5, 4.4)), (0.5, 4.4));
        assert_eq!(from_zero((-0.02, 4.4)), (-0.02, 4.4));
    }

    #[test]
    fn what_is_not_finite_has_no_part_in_the_range() {
        assert_eq!(
            finite_range([f64::NAN, 2.0, f64::INFINITY, -1.0]),
            Some((-1.0, 2.0))
        );
        assert_eq!(finite_range([f64::NAN]), None);
    }
}
