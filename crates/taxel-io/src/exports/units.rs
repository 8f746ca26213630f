//! Units of pressure, force, length and area, as programs write them.

use super::cells::number_and_rest;
use super::header::Pairs;
use super::pad::Quantity;
use super::text_file::TextFile;
use crate::error::{Error, ExportError};

/// Pascals in a pound-force per square inch.
const PSI: f64 = 6_894.757_293_168;
/// Newtons in a pound-force.
const POUND_FORCE: f64 = 4.448_221_615_260_5;
const STANDARD_GRAVITY: f64 = 9.80665;

/// What numbers in a unit are; `None` for a unit that is not known.
pub(super) fn quantity(unit: &str) -> Option<Quantity> {
    let word: String = unit
        .trim()
        .to_lowercase()
        .replace('²', "2")
        .chars()
        .filter(|c| !matches!(c, ' ' | '^' | '(' | ')' | '.'))
        .collect();
    Some(match word.as_str() {
        "raw" | "counts" | "digitaloutput" => Quantity::Raw,
        "pa" => Quantity::Pressure(1.0),
        "kpa" => Quantity::Pressure(1e3),
        "mpa" => Quantity::Pressure(1e6),
        "bar" => Quantity::Pressure(1e5),
        "mbar" | "hpa" => Quantity::Pressure(1e2),
        "psi" | "lb/in2" | "lbs/in2" | "poundforcepersquareinch" => Quantity::Pressure(PSI),
        "mmhg" => Quantity::Pressure(133.322_387_415),
        "n/cm2" => Quantity::Pressure(1e4),
        "n/mm2" => Quantity::Pressure(1e6),
        "g/cm2" | "gf/cm2" => Quantity::Pressure(10.0 * STANDARD_GRAVITY),
        "kg/cm2" | "kgf/cm2" | "kgs/cm2" => Quantity::Pressure(1e4 * STANDARD_GRAVITY),
        "n" | "newton" | "newtons" => Quantity::Force(1.0),
        "kg" | "kgs" | "kgf" => Quantity::Force(STANDARD_GRAVITY),
        "g" | "gf" => Quantity::Force(1e-3 * STANDARD_GRAVITY),
        "lb" | "lbs" | "lbf" => Quantity::Force(POUND_FORCE),
        _ => return None,
    })
}

/// The unit that a header says behind a key, and what it is. Nothing is guessed.
pub(super) fn unit_of(
    text: &TextFile,
    format: &'static str,
    pairs: &Pairs,
    key: &str,
) -> Result<(String, Quantity), Error> {
    let Some(unit) = pairs.get(key) else {
        let hint = "nothing is guessed: a wrong unit would be a wrong force";
        let expected = format!("a line `{key}`");
        return Err(text.wrong_at(0, format, "no unit in the header", expected, hint));
    };
    let unit = pairs
        .last_where(key, |unit| quantity(unit).is_some())
        .unwrap_or(unit);
    match quantity(unit) {
        Some(known) => Ok((unit.to_owned(), known)),
        None => {
            let at = text.line_at(pairs.line_of(key));
            let found = unit.to_owned();
            Err(Error::Export(Box::new(ExportError::Unit { at, found })))
        }
    }
}

/// That a header says something, on line `line`, whose unit is none of the `expected` ones.
pub(super) fn other_unit(
    text: &TextFile,
    format: &'static str,
    line: u64,
    found: &str,
    expected: &str,
) -> Error {
    text.wrong_on(
        line,
        format,
        format!("unknown unit `{found}`"),
        expected,
        "nothing is guessed: a wrong unit would be a wrong force, place or time",
    )
}

/// Millimetres in a unit of length; `None` of one that is not known.
pub(super) fn length_mm(unit: &str) -> Option<f64> {
    Some(match unit.trim().to_lowercase().as_str() {
        "mm" | "millimeter" | "millimetre" | "millimeters" | "millimetres" | "milimeters" => 1.0,
        "cm" | "centimeter" | "centimetre" | "centimeters" | "centimetres" => 10.0,
        "m" | "meter" | "metre" | "meters" | "metres" => 1000.0,
        "in" | "inch" | "inches" => 25.4,
        _ => return None,
    })
}

/// Millimetres of a length with its unit, as `0.127 centimeters`; of a number alone, centimetres where `usual_mm` is 10.
pub(super) fn millimetres(text: &str, usual_mm: Option<f64>) -> Option<f64> {
    let (value, unit) = number_and_rest(text)?;
    let unit_mm = match unit {
        "" => usual_mm?,
        unit => length_mm(unit)?,
    };
    Some(value * unit_mm).filter(|length| *length > 0.0)
}

/// Square millimetres of an area with its unit, as `0.016129 cm2`, `25 sq mm`, `2 square inches`.
pub(super) fn square_millimetres(text: &str) -> Option<f64> {
    let (value, unit) = number_and_rest(text)?;
    let unit = unit.to_lowercase().replace('²', "2");
    let is_part = |c: &char| !matches!(c, '^' | '.' | '(' | ')' | ' ' | '*' | '-');
    let unit: String = unit.chars().filter(is_part).collect();
    let before = unit
        .strip_prefix("square")
        .or_else(|| unit.strip_prefix("sq"));
    let behind = ["2", "squared", "sq"].map(|power| unit.strip_suffix(power));
    let length = before.or_else(|| behind.into_iter().flatten().next())?;
    let unit_mm = length_mm(length)?;
    Some(value * unit_mm * unit_mm).filter(|area| *area > 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn areas_however_their_unit_is_written() {
        for (text, expected) in [
            ("25 sq mm", 25.0),
            ("25 sq. mm", 25.0),
            ("25 mm^2", 25.0),
            ("25,8064 mm²", 25.8064),
            ("0.25 cm²", 25.0),
            ("0.25 sq cm", 25.0),
            ("0.25 cm sq", 25.0),
            ("0.04 in^2", 25.8064),
            ("0.04 sq in", 25.8064),
            ("0.04 square inches", 25.8064),
            ("2.5e-5 m2", 25.0),
        ] {
            let found = square_millimetres(text).unwrap_or(f64::NAN);
            assert!((found - expected).abs() < 1e-9, "{text}: {found}");
        }
        for text in ["25", "25 mm", "25 sq", "25 ell2", "0 mm2", "mm2"] {
            assert_eq!(square_millimetres(text), None, "{text}");
        }
    }
}
