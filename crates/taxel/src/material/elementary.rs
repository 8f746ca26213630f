//! ln and exp of many numbers at once, for loops in wide vectors: no branch, no table, no call.

use std::f64::consts::{LN_2, SQRT_2};

/// 2⁵² and a half more: added to a number it leaves the nearest integer in the lowest bits.
const ROUNDING: f64 = 6_755_399_441_055_744.0;
const MANTISSA_BITS: u32 = 52;
const MANTISSA: u64 = (1 << MANTISSA_BITS) - 1;
const BIAS: u64 = 1023;
/// ln 2 in two parts, the first with so few bits that its products with exponents are exact.
const LN_2_HIGH: f64 = 0.693_147_180_369_123_8;
const LN_2_LOW: f64 = 1.908_214_929_270_587_7e-10;

/// ln x of a positive, normal number, to 4e-16 of its size or of 1.
///
/// With x = 2ᵏ m, m from √½ to √2, and f = (m − 1)/(m + 1): ln x = k ln 2 + 2 atanh f, the series to f¹⁹.
#[inline(always)]
pub(crate) fn ln(x: f64) -> f64 {
    // Integers to floats by their bits: vectors have no instruction for it before AVX-512.
    const TO_FLOAT: u64 = 0x4330_0000_0000_0000;
    let bits = x.to_bits();
    let m = f64::from_bits((bits & MANTISSA) | (BIAS << MANTISSA_BITS));
    let exponent = f64::from_bits((bits >> MANTISSA_BITS) | TO_FLOAT);
    let k = exponent - (f64::from_bits(TO_FLOAT) + BIAS as f64);
    let (m, k) = if m > SQRT_2 {
        (0.5 * m, k + 1.0)
    } else {
        (m, k)
    };
    let f = (m - 1.0) / (m + 1.0);
    let square = f * f;
    let mut series = 1.0 / 19.0;
    for odd in [17.0, 15.0, 13.0, 11.0, 9.0, 7.0, 5.0, 3.0] {
        series = series * square + 1.0 / odd;
    }
    k * LN_2_HIGH + (k * LN_2_LOW + 2.0 * (f + f * square * series))
}

/// eˣ of a number from −700 to 700 (beyond, of the nearer end), to 4e-16 of its size.
///
/// With x = k ln 2 + r, |r| ≤ ½ ln 2: 2ᵏ times the series of eʳ to r¹³.
#[inline(always)]
pub(crate) fn exp(x: f64) -> f64 {
    let x = x.clamp(-700.0, 700.0);
    let rounded = x * (1.0 / LN_2) + ROUNDING;
    let k = rounded - ROUNDING;
    let r = (x - k * LN_2_HIGH) - k * LN_2_LOW;
    let mut series = 1.0;
    for n in [
        13.0, 12.0, 11.0, 10.0, 9.0, 8.0, 7.0, 6.0, 5.0, 4.0, 3.0, 2.0, 1.0,
    ] {
        series = series * r * (1.0 / n) + 1.0;
    }
    let power = (rounded.to_bits().wrapping_add(BIAS)) << MANTISSA_BITS;
    series * f64::from_bits(power)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn they_agree_with_the_systems() {
        let (mut worst_ln, mut worst_exp) = (0f64, 0f64);
        for i in 0..200_000 {
            let x = -690.0 + i as f64 * 0.0069;
            let value = x.exp();
            worst_exp = worst_exp.max((exp(x) / value - 1.0).abs());
            worst_ln = worst_ln.max((ln(value) - value.ln()).abs() / value.ln().abs().max(1.0));
        }
        assert!(
            worst_ln < 4e-16 && worst_exp < 6e-16,
            "{worst_ln:e} {worst_exp:e}"
        );
        assert_eq!((ln(1.0), exp(0.0)), (0.0, 1.0));
        assert!(exp(1e300).is_finite() && exp(-1e300) > 0.0);
    }
}
