//! How many experiments a statement needs.

use super::Error;
use crate::stats::{normal_quantile, student_quantile};

/// More experiments than this are no plan.
const MAX: u64 = 100_000_000;

/// The number of repetitions after which the mean of a quantity that scatters by `standard_deviation` is
/// known to ± `margin`, both in the same unit, with this `confidence` (0 to 1): the least n ≥ 2 with
/// t₍₁₊confidence₎⸝₂, n−1 · standard_deviation/√n ≤ margin.
///
/// Source: Student, "The probable error of a mean", Biometrika 6 (1908). Independent repetitions: ten readings of one
/// press are one.
///
/// # Errors
/// A margin or standard deviation that is not above 0, a confidence outside of 0.5 to below 1, a number beyond any plan.
///
/// ```
/// use taxel::design::statistics::experiments_for_mean;
/// assert_eq!(experiments_for_mean(12.0, 5.0, 0.95)?, 25);
/// # Ok::<(), taxel::design::Error>(())
/// ```
pub fn experiments_for_mean(
    standard_deviation: f64,
    margin: f64,
    confidence: f64,
) -> Result<u64, Error> {
    Error::unless_positive(
        "the standard deviation",
        standard_deviation,
        "that of repetitions, in the unit of the margin",
    )?;
    Error::unless_positive("the margin", margin, "how far off the mean may be")?;
    check_share("the confidence", confidence)?;
    let enough = |n: u64| {
        let t = student_quantile(0.5 * (1.0 + confidence), (n - 1) as f64);
        t * standard_deviation / (n as f64).sqrt() <= margin
    };
    let mut high = 2;
    while !enough(high) {
        high *= 2;
        if high > MAX {
            return Err(too_many(margin, standard_deviation));
        }
    }
    let mut low = high / 2;
    // enough() holds from the answer on: both factors fall as n grows.
    while low + 1 < high {
        let middle = low + (high - low) / 2;
        if enough(middle) {
            high = middle
        } else {
            low = middle
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
    if n <= MAX as f64 {
        Ok(n as u64)
    } else {
        Err(too_many(a, b))
    }
}

fn check_share(name: &str, value: f64) -> Result<(), Error> {
    if (0.5..1.0).contains(&value) {
        Ok(())
    } else {
        Err(Error::new(
            format!(
                "{name} is {} %, but must be from 50 to below 100 %",
                100.0 * value
            ),
            "95 is usual; certainty takes forever",
        ))
    }
}

fn too_many(a: f64, b: f64) -> Error {
    Error::new(
        format!("{a} and {b}: more than {MAX} experiments"),
        "a wider margin, or a larger difference",
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_experiment_fewer_is_not_enough() {
        for (standard_deviation, margin, confidence) in
            [(12.0, 5.0, 0.95), (1.0, 0.1, 0.99), (3.0, 9.0, 0.9)]
        {
            let n = experiments_for_mean(standard_deviation, margin, confidence).unwrap();
            let reach = |n: u64| {
                student_quantile(0.5 * (1.0 + confidence), (n - 1) as f64) * standard_deviation
                    / (n as f64).sqrt()
            };
            assert!(reach(n) <= margin, "{n}");
            assert!(n == 2 || reach(n - 1) > margin, "{n}");
        }
    }

    #[test]
    fn nonsense_is_refused_with_its_number() {
        let text = |result: Result<u64, Error>| result.unwrap_err().to_string();
        assert!(text(experiments_for_mean(0.0, 1.0, 0.95)).contains("the standard deviation is 0"));
        assert!(text(experiments_for_mean(1.0, f64::NAN, 0.95)).contains("the margin is NaN"));
        assert!(text(experiments_for_mean(1.0, 1.0, 1.0)).contains("100 %"));
        assert!(text(experiments_for_mean(1e9, 1e-9, 0.95)).contains("more than"));
        assert!(text(readings_for_shares(0.2, 0.2, 0.95, 0.8)).contains("20 % and 20 %"));
        assert!(text(readings_for_shares(0.2, 1.2, 0.95, 0.8)).contains("120 %"));
    }
}
