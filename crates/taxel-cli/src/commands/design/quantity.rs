//! Numbers with units on the command line: `2k`, `0.2MPa`, `132g`, `500..3000`.

/// Resistance; a bare number is in ohms.
pub(crate) const OHMS: [(&str, f64); 6] = [
    ("", 1.0),
    ("ohm", 1.0),
    ("k", 1e3),
    ("kohm", 1e3),
    ("M", 1e6),
    ("m", 1e-3),
];
/// Frequency; a bare number is in hertz.
pub(crate) const HERTZ: [(&str, f64); 6] = [
    ("", 1.0),
    ("Hz", 1.0),
    ("kHz", 1e3),
    ("MHz", 1e6),
    ("M", 1e6),
    ("GHz", 1e9),
];
/// Voltage; a bare number is in volts.
pub(crate) const VOLTS: [(&str, f64); 4] = [("", 1.0), ("V", 1.0), ("mV", 1e-3), ("uV", 1e-6)];
/// Current; a bare number is in amperes.
pub(crate) const AMPERES: [(&str, f64); 4] = [("", 1.0), ("A", 1.0), ("mA", 1e-3), ("uA", 1e-6)];
/// Capacitance; a unit must be said.
pub(crate) const FARADS: [(&str, f64); 3] = [("pF", 1e-12), ("nF", 1e-9), ("uF", 1e-6)];
/// Weight; a bare number is in grams.
pub(crate) const GRAMS: [(&str, f64); 3] = [("", 1.0), ("g", 1.0), ("kg", 1e3)];
/// A share; a bare number is in percent.
pub(crate) const PERCENT: [(&str, f64); 2] = [("", 0.01), ("%", 0.01)];
/// Force, in newtons; a unit must be said.
pub(crate) const NEWTONS: [(&str, f64); 4] = [
    ("N", 1.0),
    ("mN", 1e-3),
    ("g", taxel::frame::STANDARD_GRAVITY / 1000.0),
    ("kg", taxel::frame::STANDARD_GRAVITY),
];
/// Pressure, in megapascals; a unit must be said.
pub(crate) const MEGAPASCALS: [(&str, f64); 5] = [
    ("MPa", 1.0),
    ("kPa", 1e-3),
    ("Pa", 1e-6),
    ("bar", 0.1),
    ("N/mm2", 1.0),
];

/// A finite number in one of these units.
pub(crate) fn parse(text: &str, units: &[(&str, f64)]) -> Result<f64, String> {
    let text = text.trim();
    let known = || {
        let words = units.iter().map(|(word, _)| *word);
        let words: Vec<&str> = words.filter(|word| !word.is_empty()).collect();
        words.join(", ")
    };
    let is_number =
        |end: &usize| text.is_char_boundary(*end) && text[..*end].parse::<f64>().is_ok();
    let Some(end) = (1..=text.len()).rev().find(is_number) else {
        return Err(format!(
            "no number\nhint: a number and a unit ({})",
            known()
        ));
    };
    let number: f64 = text[..end].parse().unwrap_or(f64::NAN);
    let word = text[end..].trim();
    let Some((_, scale)) = units.iter().find(|(unit, _)| *unit == word) else {
        let what = match word {
            "" => "a number without a unit".to_owned(),
            word => format!("unknown unit `{word}`"),
        };
        return Err(format!("{what}\nhint: known: {}", known()));
    };
    if number.is_finite() {
        Ok(scaled(number, *scale))
    } else {
        Err(format!("{number} is no quantity\nhint: a finite number"))
    }
}

/// Divided by whole numbers instead of multiplied by what they make of 1: 95 % are 0.95 and not 0.9500000000000001.
fn scaled(number: f64, scale: f64) -> f64 {
    let divisor = (1.0 / scale).round();
    if divisor > 1.0 && (divisor * scale - 1.0).abs() < 1e-12 {
        number / divisor
    } else {
        number * scale
    }
}

/// `FROM..TO` in ohms.
pub(crate) fn ohm_range(text: &str) -> Result<(f64, f64), String> {
    let Some((from, to)) = text.split_once("..") else {
        return Err(
            "one number is no range\nhint: from full load to the lightest, like 500..3000".into(),
        );
    };
    let (from, to) = (parse(from, &OHMS)?, parse(to, &OHMS)?);
    if from > 0.0 && from < to {
        Ok((from, to))
    } else {
        Err(format!(
            "from {from} to {to} Ω\nhint: both above 0, and the smaller first: pressing lowers the resistance"
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_units() {
        assert_eq!(parse("2k", &OHMS), Ok(2000.0));
        assert_eq!(parse(" 2.2e3 ohm", &OHMS), Ok(2200.0));
        assert_eq!(parse("300pF", &FARADS), Ok(300e-12));
        assert_eq!(parse("0.2MPa", &MEGAPASCALS), Ok(0.2));
        assert_eq!(parse("95", &PERCENT), Ok(0.95));
        assert_eq!(
            parse("1000 g", &NEWTONS),
            Ok(taxel::frame::STANDARD_GRAVITY)
        );
        assert_eq!(ohm_range("500..3k"), Ok((500.0, 3000.0)));
    }

    #[test]
    fn nonsense_is_refused_and_what_is_known_is_named() {
        assert!(
            parse("5 parsecs", &GRAMS)
                .unwrap_err()
                .contains("known: g, kg")
        );
        assert!(
            parse("300", &FARADS)
                .unwrap_err()
                .contains("without a unit")
        );
        assert!(
            parse("inf", &OHMS).is_err() && parse("µ", &OHMS).is_err() && parse("", &OHMS).is_err()
        );
        for range in ["3000..500", "0..5", "7", "a..b", "5..5"] {
            assert!(ohm_range(range).unwrap_err().contains("hint: "), "{range}");
        }
    }
}
