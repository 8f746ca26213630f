//! ln and exp of many numbers at once, for loops in wide vectors: no branch, no table, no call.

use std::f64::consts::{LN_2, SQRT_2};

use taxel_linalg::mul_add;

/// 2⁵² and a half more: added to a number it leaves the nearest integer in the lowest bits.
const ROUNDING: f64 = 6_755_399_441_055_744.0;
const MANTISSA_BITS: u32 = 52;
const MANTISSA: u64 = (1 << MANTISSA_BITS) - 1;
const BIAS: u64 = 1023;
/// ln 2 in two parts, the first with so few bits that its products with exponents are exact.
const LN_2_HIGH: f64 = 0.693_147_180_369_123_8;
const LN_2_LOW: f64 = 1.908_214_929_270_587_7e-10;

/// ln m = 2f + f³ P(f²), the best polynomial of its degree: 5e-18 of its size off.
const LN_SERIES: [f64; 7] = [
    0.146_165_854_248_886_23,
    0.153_317_106_182_107_73,
    0.181_828_894_556_749_47,
    0.222_222_111_302_598_78,
    0.285_714_286_260_032_7,
    0.399_999_999_998_994_44,
    0.666_666_666_666_667,
];
/// eʳ = 1 + r + r² Q(r), the best polynomial of its degree: 2e-17 of its size off.
const EXP_SERIES: [f64; 10] = [
    2.510_038_549_551_032e-8,
    2.762_008_844_540_974_6e-7,
    2.755_726_845_999_706_4e-6,
    2.480_152_129_595_437_6e-5,
    0.000_198_412_698_630_536_18,
    0.001_388_888_891_721_371_7,
    0.008_333_333_333_330_062,
    0.041_666_666_666_624_13,
    0.166_666_666_666_666_69,
    0.500_000_000_000_000_1,
];

/// ln x of a positive, normal number, to 4e-16 of its size or of 1.
///
/// With x = 2ᵏ m, m from √½ to √2, and f = (m − 1)/(m + 1): ln x = k ln 2 + 2 atanh f.
#[inline(always)]
pub(crate) fn ln<const FUSED: bool>(x: f64) -> f64 {
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
    let series = f * square * polynomial::<FUSED, _>(&LN_SERIES, square);
    let small = mul_add::<FUSED>(k, LN_2_LOW, mul_add::<FUSED>(2.0, f, series));
    mul_add::<FUSED>(k, LN_2_HIGH, small)
}

/// eˣ of a number from −700 to 700 (beyond, of the nearer end), to 4e-16 of its size.
///
/// With x = k ln 2 + r, |r| ≤ ½ ln 2: 2ᵏ eʳ.
#[inline(always)]
pub(crate) fn exp<const FUSED: bool>(x: f64) -> f64 {
    let x = x.clamp(-700.0, 700.0);
    let rounded = mul_add::<FUSED>(x, 1.0 / LN_2, ROUNDING);
    let k = rounded - ROUNDING;
    let r = mul_add::<FUSED>(-k, LN_2_LOW, mul_add::<FUSED>(-k, LN_2_HIGH, x));
    let series = polynomial::<FUSED, _>(&EXP_SERIES, r);
    let series = 1.0 + mul_add::<FUSED>(r * r, series, r);
    let power = (rounded.to_bits().wrapping_add(BIAS)) << MANTISSA_BITS;
    series * f64::from_bits(power)
}

/// Its value at `x`, the highest coefficient first.
#[inline(always)]
fn polynomial<const FUSED: bool, const N: usize>(coefficients: &[f64; N], x: f64) -> f64 {
    let mut value = coefficients[0];
    for coefficient in &coefficients[1..] {
        value = mul_add::<FUSED>(value, x, *coefficient);
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;

    fn agree_with_the_systems<const FUSED: bool>() {
        let (mut worst_ln, mut worst_exp) = (0f64, 0f64);
        for i in 0..200_000 {
            let x = -690.0 + i as f64 * 0.0069;
            let value = x.exp();
            worst_exp = worst_exp.max((exp::<FUSED>(x) / value - 1.0).abs());
            let off = (ln::<FUSED>(value) - value.ln()).abs();
            worst_ln = worst_ln.max(off / value.ln().abs().max(1.0));
        }
        assert!(
            worst_ln < 4e-16 && worst_exp < 6e-16,
            "{worst_ln:e} {worst_exp:e}"
        );
        assert_eq!((ln::<FUSED>(1.0), exp::<FUSED>(0.0)), (0.0, 1.0));
        assert!(exp::<FUSED>(1e300).is_finite() && exp::<FUSED>(-1e300) > 0.0);
    }

    #[test]
    fn they_agree_with_the_systems() {
        agree_with_the_systems::<true>();
        agree_with_the_systems::<false>();
    }
}
