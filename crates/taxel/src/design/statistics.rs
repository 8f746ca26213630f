//! How many experiments a statement needs: Student's t, and the normal distribution, without tables.

use super::Error;

/// More experiments than this are no plan.
const MOST: u64 = 100_000_000;

/// The number of repetitions after which the mean of a quantity that scatters by `spread` (standard deviation) is
/// known to ± `margin`, both in the same unit, with this `confidence` (0 to 1): the least n ≥ 2 with
/// t₍₁₊confidence₎⸝₂, n−1 · spread/√n ≤ margin.
///
/// Source: Student, "The probable error of a mean", Biometrika 6 (1908). Independent repetitions: ten readings of one
/// press are one.
///
/// # Errors
/// A margin or spread that is not above 0, a confidence outside of 0.5 to below 1, a number beyond any plan.
///
/// ```
/// use taxel::design::statistics::experiments_for_mean;
/// assert_eq!(experiments_for_mean(12.0, 5.0, 0.95)?, 25);
/// # Ok::<(), taxel::design::Error>(())
/// ```
pub fn experiments_for_mean(spread: f64, margin: f64, confidence: f64) -> Result<u64, Error> {
    Error::unless_positive(
        "the spread",
        spread,
        "the standard deviation of repetitions",
    )?;
    Error::unless_positive("the margin", margin, "how far off the mean may be")?;
    check_share("the confidence", confidence)?;
    let enough = |n: u64| {
        let t = student_quantile(0.5 * (1.0 + confidence), (n - 1) as f64);
        t * spread / (n as f64).sqrt() <= margin
    };
    let mut high = 2;
    while !enough(high) {
        high *= 2;
        if high > MOST {
            return Err(too_many(margin, spread));
        }
    }
    let mut low = high / 2;
    // enough() holds from the answer on: both factors fall as n grows.
    while low + 1 < high {
        let middle = low + (high - low) / 2;
        match enough(middle) {
            true => high = middle,
            false => low = middle,
        }
    }
    Ok(high)
}

/// The number of readings of *each* of two sensors after which shares of outliers `a` and `b` (0 to 1) are told apart
/// with this `confidence` and `power` (the chance to see the difference if it is there), two-sided:
/// n = ((z₍₁₊confidence₎⸝₂ √(2 p̄ q̄) + z_power √(a(1−a) + b(1−b))) / (a − b))².
///
/// Source: Fleiss, Levin and Paik, *Statistical Methods for Rates and Proportions*, 3rd ed. (2003), equation 4.14,
/// without the correction for continuity.
///
/// # Errors
/// Shares outside of 0 to 1 or alike, a confidence or power outside of 0.5 to below 1, a number beyond any plan.
///
/// ```
/// use taxel::design::statistics::readings_for_shares;
/// // The paper's Table IV: 22 % with bad connectors, 5 % after the repair. Its 100 readings were enough.
/// assert_eq!(readings_for_shares(0.22, 0.05, 0.95, 0.8)?, 63);
/// # Ok::<(), taxel::design::Error>(())
/// ```
pub fn readings_for_shares(a: f64, b: f64, confidence: f64, power: f64) -> Result<u64, Error> {
    if !(0.0..=1.0).contains(&a) || !(0.0..=1.0).contains(&b) || a == b {
        return Err(Error::new(
            format!(
                "shares of {} % and {} % cannot be told apart",
                100.0 * a,
                100.0 * b
            ),
            "two different shares from 0 to 100 %",
        ));
    }
    check_share("the confidence", confidence)?;
    check_share("the power", power)?;
    let mean = 0.5 * (a + b);
    let alike = (2.0 * mean * (1.0 - mean)).sqrt();
    let apart = (a * (1.0 - a) + b * (1.0 - b)).sqrt();
    let z = normal_quantile(0.5 * (1.0 + confidence)) * alike + normal_quantile(power) * apart;
    let n = (z / (a - b)).powi(2).ceil();
    match n <= MOST as f64 {
        true => Ok(n as u64),
        false => Err(too_many(a, b)),
    }
}

fn check_share(name: &str, value: f64) -> Result<(), Error> {
    match (0.5..1.0).contains(&value) {
        true => Ok(()),
        false => Err(Error::new(
            format!(
                "{name} is {} %, but must be from 50 to below 100 %",
                100.0 * value
            ),
            "95 is usual; certainty takes forever",
        )),
    }
}

fn too_many(a: f64, b: f64) -> Error {
    Error::new(
        format!("{a} and {b}: more than {MOST} experiments"),
        "a wider margin, or a larger difference",
    )
}

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
    let (mut low, mut high) = (0.0, 1.0);
    while student_above(high, degrees) > 1.0 - p {
        high *= 2.0;
    }
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        match student_above(middle, degrees) > 1.0 - p {
            true => low = middle,
            false => high = middle,
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

    #[test]
    fn quantiles_are_those_of_the_tables() {
        // By the incomplete beta function in 30 digits (mpmath); to three digits those of Abramowitz and Stegun, 26.10.
        for (p, degrees, value) in [
            (0.975, 1.0, 12.706_204_736_174_705),
            (0.975, 2.0, 4.302_652_729_749_464),
            (0.975, 10.0, 2.228_138_851_986_274_7),
            (0.975, 24.0, 2.063_898_561_628_026),
            (0.995, 30.0, 2.749_995_653_567_225_3),
            (0.95, 120.0, 1.657_650_899_355_235_6),
            (0.75, 4.0, 0.740_697_084_112_682_6),
        ] {
            let found: f64 = student_quantile(p, degrees);
            let error = (found / value - 1.0).abs();
            assert!(error < 1e-10, "{p} {degrees}: {found}");
        }
        assert!((normal_quantile(0.975) - 1.959_963_984_540_054).abs() < 1e-12);
        assert!((normal_quantile(0.8) - 0.841_621_233_572_914_3).abs() < 1e-12);
        assert!((normal_quantile(0.001) + 3.090_232_306_167_813).abs() < 1e-9);
        assert!((student_quantile(0.975, 1e6) - normal_quantile(0.975)).abs() < 1e-5);
    }

    #[test]
    fn one_experiment_fewer_is_not_enough() {
        for (spread, margin, confidence) in [(12.0, 5.0, 0.95), (1.0, 0.1, 0.99), (3.0, 9.0, 0.9)] {
            let n = experiments_for_mean(spread, margin, confidence).unwrap();
            let reach = |n: u64| {
                student_quantile(0.5 * (1.0 + confidence), (n - 1) as f64) * spread
                    / (n as f64).sqrt()
            };
            assert!(reach(n) <= margin, "{n}");
            assert!(n == 2 || reach(n - 1) > margin, "{n}");
        }
    }

    #[test]
    fn nonsense_is_refused_with_its_number() {
        let text = |result: Result<u64, Error>| result.unwrap_err().to_string();
        assert!(text(experiments_for_mean(0.0, 1.0, 0.95)).contains("the spread is 0"));
        assert!(text(experiments_for_mean(1.0, f64::NAN, 0.95)).contains("the margin is NaN"));
        assert!(text(experiments_for_mean(1.0, 1.0, 1.0)).contains("100 %"));
        assert!(text(experiments_for_mean(1e9, 1e-9, 0.95)).contains("more than"));
        assert!(text(readings_for_shares(0.2, 0.2, 0.95, 0.8)).contains("20 % and 20 %"));
        assert!(text(readings_for_shares(0.2, 1.2, 0.95, 0.8)).contains("120 %"));
    }
}
