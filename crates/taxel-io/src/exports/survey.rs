//! What a reading of an exported file from end to end finds of one of its sensors.

use super::cells::power_of_ten;
use super::pad::{Pad, Quantity, RawScale};
use super::zeros::sum_and_largest;
use super::{Chosen, ExportAbout, ParsedFrame, Parser};
use crate::error::Error;

/// Decimals that a count may stand for at most: with more, sums of numbers that were averaged would not fit a converter.
const MAX_DECIMALS: u8 = 6;
/// What converters of 16 bits count to, but for the end of their range.
const MOST_COUNTS: f64 = 65_535.0;
/// Bits of the converters that counts are taken to be of.
const BITS: [u32; 5] = [8, 12, 16, 24, 32];

/// What a reading of an exported file from end to end finds of one of its sensors.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Survey {
    /// Which of [`ExportAbout::pads`] it is.
    pub pad: usize,
    /// Frames of it.
    pub frames: u64,
    /// The largest number, in the file's unit.
    pub largest: f64,
    /// The heaviest frame: its position among those of this sensor, from 0, and the sum of its numbers.
    pub heaviest: Option<(u64, f64)>,
    /// The sum of all numbers.
    pub sum: f64,
    /// How much of the file's unit a count is; `None`: counts are the converter's raw ones.
    pub unit_per_count: Option<f64>,
    /// Bits of a converter that has all of its counts.
    pub bits: u32,
    /// Below which value, in the file's unit, it has written 0.
    pub threshold: Option<f64>,
    /// Whether raw counts stand behind all values, where the file's calibration promises them.
    pub has_raw: Option<bool>,
}

impl Survey {
    /// Reads all that is left of a file. What cannot be read is left out: whoever reads the frames tells of it.
    ///
    /// # Errors
    /// A file whose frames cannot be found any more.
    pub(super) fn of(
        about: &ExportAbout,
        chosen: Chosen,
        parser: &mut dyn Parser,
    ) -> Result<Self, Error> {
        let pad = chosen.pad;
        let mut survey = Self {
            pad,
            frames: 0,
            largest: 0.0,
            heaviest: None,
            sum: 0.0,
            unit_per_count: None,
            bits: 8,
            threshold: None,
            has_raw: about.pads[pad].raw.map(|_| true),
        };
        let own = &about.pads[pad];
        let mut frame = ParsedFrame::default();
        let mut decimals = 0;
        let mut failed = None;
        loop {
            match parser.next(&mut frame) {
                Ok(false) => break,
                Ok(true) if frame.pad == pad => survey.add(own, &frame, &mut decimals),
                Ok(true) => {}
                Err(error) if error.is_one_frame() => {
                    if parser.pad_of_error().is_none_or(|of| of == pad) {
                        failed.get_or_insert(error);
                    }
                    parser.skip_frame()?;
                }
                Err(error) => return Err(error),
            }
        }
        match failed {
            Some(error) if survey.frames == 0 => return Err(error),
            _ => {}
        }
        survey.choose_counts(own, decimals, chosen.raw);
        Ok(survey)
    }

    fn add(&mut self, pad: &Pad, frame: &ParsedFrame, decimals: &mut u8) {
        let position = self.frames;
        self.frames += 1;
        let (sum, largest) = sum_and_largest(&frame.values);
        self.sum += sum;
        let is_heavier = self.heaviest.is_none_or(|(_, most)| sum > most);
        if is_heavier {
            self.heaviest = Some((position, sum));
        }
        self.largest = self.largest.max(largest);
        if *decimals < frame.decimals {
            *decimals = needed_decimals(&frame.values, *decimals);
        }
        if let Some(raw) = pad.raw.filter(|_| self.has_raw == Some(true)) {
            let step = 1.0 / power_of_ten(frame.decimals);
            let is_raw = |value: &f64| *value == 0.0 || raw_count(raw, *value, step).is_ok();
            self.has_raw = Some(frame.values.iter().all(is_raw));
        }
    }

    fn choose_counts(&mut self, pad: &Pad, decimals: u8, raw: bool) {
        self.threshold = pad.threshold.map(|least| match pad.raw {
            Some(raw) => raw.factor * least.powf(raw.exponent),
            None => least,
        });
        if let Some(scale) = pad.raw.filter(|_| raw) {
            self.bits = bits_of(scale.max_count);
            return;
        }
        let largest = self.largest.max(pad.saturation.unwrap_or(0.0));
        let fits = |decimals: &u8| power_of_ten(*decimals) * largest < MOST_COUNTS;
        // With fractions of counts rather than with more bits than recordings and viewers have.
        let decimals = (0..=decimals).rev().find(fits).unwrap_or(0);
        let step = 1.0 / power_of_ten(decimals);
        let is_raw = pad.quantity == Quantity::Raw && decimals == 0;
        self.unit_per_count = (!is_raw).then_some(step);
        // Raw counts may reach their converter's end; a step above all others is none.
        let spare = if is_raw { 0.0 } else { 1.0 };
        self.bits = bits_of((largest / step).round() + spare);
    }
}

/// The fewest bits of a converter that has a count.
fn bits_of(count: f64) -> u32 {
    let fits = |bits: &&u32| count <= (2f64).powi(**bits as i32) - 1.0;
    BITS.iter().find(fits).copied().unwrap_or(32)
}

/// Decimals that numbers need, at least so many: zeros that close them are none.
fn needed_decimals(values: &[f64], least: u8) -> u8 {
    let needs = |decimals: u8| {
        let power = power_of_ten(decimals);
        values.iter().all(|value| {
            let scaled = value * power;
            (scaled - rounded(scaled)).abs() < 1e-6 * (1.0 + scaled.abs() * 1e-6)
        })
    };
    (least..MAX_DECIMALS)
        .find(|&decimals| needs(decimals))
        .unwrap_or(MAX_DECIMALS)
}

/// How far the digits of a header allow a value to be off what its raw count stands for, a share of it: six of them.
const HEADER_SHARE: f64 = 2e-5;

/// The raw count that a value was written from, which is whole and the only one; `Err`: the count that it would be. `step`: how
/// finely values are written.
pub(super) fn raw_count(raw: RawScale, value: f64, step: f64) -> Result<f64, f64> {
    if value == 0.0 {
        return Ok(0.0);
    }
    // Most calibrations are of one point: a power of one would take most of the time of a reading.
    if raw.exponent == 1.0 {
        whole_count(raw, value, step, value / raw.factor, |count| {
            raw.factor * count
        })
    } else {
        let count = (value / raw.factor).powf(1.0 / raw.exponent);
        whole_count(raw, value, step, count, |count| {
            raw.factor * count.powf(raw.exponent)
        })
    }
}

/// The whole number that a count is near to, if the value that is `written` of it, and of it alone, is this one.
#[inline(always)]
fn whole_count(
    raw: RawScale,
    value: f64,
    step: f64,
    count: f64,
    written: impl Fn(f64) -> f64,
) -> Result<f64, f64> {
    let whole = rounded(count);
    let allowed = 0.501 * step + HEADER_SHARE * value;
    let is_it = (written(whole) - value).abs() <= allowed;
    let is_only_one = written(whole + 1.0) - written(whole) > step;
    // A ceiling that is written with other digits than its count gives.
    if is_it && is_only_one && (0.0..=raw.max_count).contains(&whole) {
        Ok(whole)
    } else {
        Err(count)
    }
}

/// The nearest whole number of one that is not negative, of two the larger; `round` is a call, which takes several times as
/// long.
#[inline(always)]
pub(super) fn rounded(number: f64) -> f64 {
    // A sum with it has no fraction. What is beyond it is of no converter.
    const ROUNDS: f64 = (1u64 << 52) as f64;
    let even = (number + ROUNDS) - ROUNDS;
    let up = if number - even == 0.5 { 1.0 } else { 0.0 };
    // Both are found, so that several numbers may be at once.
    if number < ROUNDS { even + up } else { number }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_rounded_as_the_standard_library_does() {
        let edges = [
            0.0,
            0.49999999999999994,
            0.5,
            1.5,
            2.5,
            3.5000000000000004,
            254.5,
            1e9 + 0.5,
            4503599627370495.5,
            1e300,
        ];
        for number in edges
            .into_iter()
            .chain((0..100_000).map(|n| f64::from(n) / 7.0))
        {
            assert_eq!(rounded(number), number.round(), "{number}");
        }
    }

    /// Scale, exponent and digits of calibrations that were met, and others: each raw count is found from what is written of it.
    #[test]
    fn raw_counts_are_found_exactly_or_not_at_all() {
        for (factor, exponent, decimals) in [
            (5.940115, 1.0, 0),
            (0.00660538, 1.25278, 4),
            (0.0132155, 1.25278, 3),
            (1.7, 0.9, 1),
        ] {
            let raw = RawScale {
                factor,
                exponent,
                max_count: 255.0,
            };
            let step = 1.0 / power_of_ten(decimals);
            for count in 0..=255u32 {
                let value = factor * f64::from(count).powf(exponent);
                let written = (value / step).round() * step;
                assert_eq!(
                    raw_count(raw, written, step),
                    Ok(f64::from(count)),
                    "{factor}"
                );
                if count > 2 {
                    let off =
                        written + 0.4 * (factor * f64::from(count + 1).powf(exponent) - value);
                    let told = raw_count(raw, off, step).unwrap_err();
                    assert!(
                        (told - f64::from(count) - 0.4).abs() < 0.2,
                        "{factor} {count}: {told}"
                    );
                }
            }
        }
        // Two counts that are written alike are told apart by nobody.
        let coarse = RawScale {
            factor: 0.3,
            exponent: 1.0,
            max_count: 255.0,
        };
        assert!(raw_count(coarse, 3.0, 1.0).is_err());
    }
}
