//! Quantiles of the normal distribution, of Student's t and of Fisher's F.

/// The value below which a standard normal number falls with probability `p`; to 1e-12.
pub fn normal_quantile(p: f64) -> f64 {
    // The normal distribution is Student's with infinitely many degrees of freedom.
    student_quantile(p, f64::INFINITY)
}

/// The value below which Student's t with `degrees` of freedom falls with probability `p`; relative error 1e-10.
pub fn student_quantile(p: f64, degrees: f64) -> f64 {
    if p < 0.5 {
        return -student_quantile(1.0 - p, degrees);
    }
    positive_quantile(p, |t| student_above(t, degrees))
}

/// The value below which Fisher's F with `degrees` of freedom above and `below` of them below falls with probability `p`; relative
/// error 1e-9.
pub(super) fn fisher_quantile(p: f64, degrees: f64, below: f64) -> f64 {
    let above = |f: f64| beta_share(below / (below + degrees * f), 0.5 * below, 0.5 * degrees);
    positive_quantile(p, above)
}

/// Where the probability `above` of something larger, which falls from x = 0 on, has come down to 1 − p.
fn positive_quantile(p: f64, above: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    while above(high) > 1.0 - p && high < f64::MAX {
        high *= 2.0;
    }
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if above(middle) > 1.0 - p {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// Probability that Student's t exceeds `t` ≥ 0.
fn student_above(t: f64, degrees: f64) -> f64 {
    if degrees.is_infinite() || degrees > 1e7 {
        // P(|Z| > z) = Q(1/2, z²/2), the upper incomplete gamma function.
        return 0.5 * gamma_above_half(0.5 * t * t);
    }
    0.5 * beta_share(degrees / (degrees + t * t), 0.5 * degrees, 0.5)
}

/// Q(1/2, x) = erfc(√x): a series for small x, a continued fraction (Lentz) for large.
fn gamma_above_half(x: f64) -> f64 {
    let root_pi = std::f64::consts::PI.sqrt();
    if x < 1.5 {
        let (mut term, mut sum, mut k) = (2.0, 2.0, 0.5);
        while term > 1e-17 * sum {
            k += 1.0;
            term *= x / k;
            sum += term;
        }
        return 1.0 - sum * (-x).exp() * x.sqrt() / root_pi;
    }
    let mut b = x + 0.5;
    let (mut c, mut d) = (1e300, 1.0 / b);
    let mut h = d;
    for i in 1..500 {
        let a = -f64::from(i) * (f64::from(i) - 0.5);
        b += 2.0;
        d = 1.0 / (a * d + b);
        c = b + a / c;
        h *= d * c;
        if (d * c - 1.0).abs() < 1e-15 {
            break;
        }
    }
    (-x).exp() * x.sqrt() / root_pi * h
}

/// The regularised incomplete beta function I_x(a, b).
///
/// Source: its continued fraction by Lentz's method; NIST Digital Library of Mathematical Functions, 8.17.22.
fn beta_share(x: f64, a: f64, b: f64) -> f64 {
    if x <= 0.0 || x >= 1.0 {
        return x.clamp(0.0, 1.0);
    }
    if x > (a + 1.0) / (a + b + 2.0) {
        return 1.0 - beta_share(1.0 - x, b, a);
    }
    let front =
        (ln_gamma(a + b) - ln_gamma(a) - ln_gamma(b) + a * x.ln() + b * (-x).ln_1p()).exp() / a;
    let (mut c, mut d) = (1.0, 1.0 / (1.0 - (a + b) * x / (a + 1.0)));
    let mut h = d;
    for i in 1..10_000 {
        let m = f64::from(i);
        let even = m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m));
        let odd = -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
        let mut change = 1.0;
        for step in [even, odd] {
            d = 1.0 / (1.0 + step * d);
            c = 1.0 + step / c;
            change *= d * c;
        }
        h *= change;
        if (change - 1.0).abs() < 1e-15 {
            break;
        }
    }
    front * h
}

/// ln Γ(x), x > 0; relative error 1e-14.
///
/// Source: Stirling's series after shifting x up; NIST Digital Library of Mathematical Functions, 5.11.1.
fn ln_gamma(x: f64) -> f64 {
    let (mut shifted, mut product) = (x, 1.0);
    while shifted < 15.0 {
        product *= shifted;
        shifted += 1.0;
    }
    let inverse = 1.0 / shifted;
    let square = inverse * inverse;
    let series = inverse
        * (1.0 / 12.0
            - square
                * (1.0 / 360.0
                    - square * (1.0 / 1260.0 - square * (1.0 / 1680.0 - square / 1188.0))));
    (shifted - 0.5) * shifted.ln() - shifted + 0.5 * (2.0 * std::f64::consts::PI).ln() + series
        - product.ln()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Regularised incomplete beta function inverted with 40 digits (mpmath); the last column is rounded from them.
    #[test]
    #[expect(
        clippy::excessive_precision,
        reason = "as computed, one digit more than a number holds"
    )]
    fn quantiles_are_those_of_a_computation_with_forty_digits() {
        for (p, degrees, value) in [
            (0.975, 1.0, 12.706_204_736_174_693),
            (0.975, 2.0, 4.302_652_729_749_461_8),
            (0.975, 10.0, 2.228_138_851_986_274_2),
            (0.975, 24.0, 2.063_898_561_628_025_4),
            (0.995, 30.0, 2.749_995_653_567_225),
            (0.95, 120.0, 1.657_650_899_355_235_2),
            (0.75, 4.0, 0.740_697_084_112_682_63),
            (0.9995, 3.0, 12.923_978_636_687_964),
            (0.6, 7.5, 0.262_501_898_804_294_65),
            (0.999_999, 5.0, 24.771_029_720_372_489),
            (0.51, 60.0, 0.025_173_641_480_054_985),
            (0.975, 1e3, 1.962_339_080_826_408_1),
            (0.975, 1e5, 1.959_987_707_534_609_3),
        ] {
            let found = student_quantile(p, degrees);
            let error = found / value - 1.0;
            assert!(error.abs() < 1e-10, "{p} {degrees}: {found}, {error:e} off");
            assert_eq!(student_quantile(1.0 - p, degrees).signum(), -1.0);
        }
    }

    /// As scipy 1.16 has them.
    #[test]
    fn so_are_those_of_fishers_f() {
        for (p, degrees, below, value) in [
            (0.975, 5.0, 15.0, 3.576_415_349_279_060_7),
            (0.975, 15.0, 5.0, 6.427_728_167_078_779),
            (0.975, 5.0, 4.79, 7.490_103_962_012_941),
            (0.975, 1.0, 9.3, 7.119_788_571_988_362),
            (0.95, 30.0, 29.0, 1.854_293_002_852_673_2),
            (0.975, 7.0, 0.9, 1_978.247_657_358_659_1),
            (0.025, 5.0, 15.0, 0.155_575_963_078_487_03),
        ] {
            let found = fisher_quantile(p, degrees, below);
            let error = found / value - 1.0;
            assert!(
                error.abs() < 1e-9,
                "{p} {degrees} {below}: {found}, {error:e} off"
            );
        }
    }

    #[test]
    #[expect(
        clippy::excessive_precision,
        reason = "as computed, one digit more than a number holds"
    )]
    fn so_are_those_of_the_normal_distribution() {
        for (p, value) in [
            (0.975, 1.959_963_984_540_053_9),
            (0.8, 0.841_621_233_572_914_36),
            (0.75, 0.674_489_750_196_081_74),
            (0.001, -3.090_232_306_167_813_5),
            (0.500_1, 0.000_250_662_830_088_007_49),
            (0.999_999_999, 5.997_807_019_601_637_4),
        ] {
            let error = normal_quantile(p) - value;
            assert!(error.abs() < 1e-12, "{p}: {error:e} off");
        }
    }
}
