//! How raw counts became the values of a file, as its header says it.

use super::super::cells::number_and_rest;
use super::super::header::Pairs;
use super::super::pad::{Pad, Quantity, RawScale};
use super::super::units::quantity;

/// The largest raw count: eight bits.
pub(super) const MAX_COUNT: f64 = 255.0;
/// Two scales that differ by less are one, rounded.
const SAME_SCALE: f64 = 0.02;

/// How raw counts became pressures, as the header says it.
pub(super) fn raw_scale(pairs: &Pairs, pad: &Pad) -> Option<RawScale> {
    let scaled = |factor: f64, exponent: f64| {
        Some(RawScale {
            factor,
            exponent,
            max_count: MAX_COUNT,
        })
    };
    let Quantity::Pressure(pascals) = pad.quantity else {
        return None;
    };
    // By the largest value, which has the unit with it: of both ways.
    let top = pairs.get("saturation_pressure").and_then(number_and_rest);
    let top = top.and_then(|(value, unit)| match quantity(unit) {
        Some(Quantity::Pressure(own)) => Some(value * own / pascals),
        _ => None,
    });
    if let Some(exponent) = pairs.positive("exponent") {
        // In the unit of the calibration, which the largest value tells.
        let factor = top.map(|top| top / MAX_COUNT.powf(exponent));
        return scaled(factor.or(pairs.positive("scale_factor"))?, exponent);
    }
    let by_point = || {
        let point = pairs.get("calibration_point_1")?;
        let (force, rest) = number_and_rest(point)?;
        let (unit, rest) = rest.strip_prefix('(')?.split_once(')')?;
        let (raw_sum, _) = number_and_rest(rest)?;
        let Some(Quantity::Force(newtons)) = quantity(unit) else {
            return None;
        };
        let square_metres = pad.area_mm2? * 1e-6;
        Some(force * newtons / (raw_sum * square_metres * pascals)).filter(|factor| *factor > 0.0)
    };
    let by_top = top.map(|top| top / MAX_COUNT);
    // The point is the measurement; where both are told and are not one scale, it is of another calibration than the values.
    let point =
        by_point().filter(|point| by_top.is_none_or(|top| (point / top - 1.0).abs() < SAME_SCALE));
    scaled(point.or(by_top)?, 1.0)
}

/// Where values say only that there was more, in the file's unit.
pub(super) fn saturation(pairs: &Pairs, pad: &Pad) -> Option<f64> {
    match (pad.quantity, pad.raw) {
        (Quantity::Raw, _) => Some(MAX_COUNT),
        (_, Some(raw)) => {
            // As values are written: rounded.
            let top = raw.factor * MAX_COUNT.powf(raw.exponent);
            let below = raw.factor * (MAX_COUNT - 1.0).powf(raw.exponent);
            Some(0.5 * (top + below))
        }
        _ => pairs.positive("saturation_pressure"),
    }
}
