//! Statistics: one definition of each for the whole workspace.
//!
//! Quantiles are type 7 of Hyndman and Fan (*Sample quantiles in statistical packages*, The American Statistician
//! 50:361, 1996): linear between order statistics, what R, numpy and spreadsheets give by default. The median of an even
//! number of values is the mean of the two in the middle; [`median_high`] is for those who ask what a reading was.
//!
//! ```
//! use taxel::stats::{median, quantile};
//!
//! assert_eq!(median([4.0, 1.0, 3.0, 2.0]), Some(2.5));
//! assert_eq!(quantile([1.0, 2.0, 3.0, 4.0], 0.25), Some(1.75));
//! assert_eq!(median([]), None);
//! ```

mod bootstrap;
mod line;
mod retest;
mod student;

pub use bootstrap::{Bootstrap, Estimate};
pub use line::Line;
pub use retest::{Difference, Retest};
pub use student::{normal_quantile, student_quantile};

/// The standard deviation of normal numbers over their median absolute deviation from the middle: 1/Φ⁻¹(3/4).
pub const SIGMA_PER_MAD: f64 = 1.482_602_218_505_602;

/// Mean; `None` of nothing.
pub fn mean(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let (mut sum, mut count) = (0.0, 0usize);
    for value in values {
        sum += value;
        count += 1;
    }
    (count > 0).then(|| sum / count as f64)
}

/// Standard deviation with n − 1; `None` of fewer than two.
pub fn standard_deviation(values: &[f64]) -> Option<f64> {
    let centre = mean(values.iter().copied())?;
    let squares: f64 = values.iter().map(|value| (value - centre).powi(2)).sum();
    (values.len() > 1).then(|| (squares / (values.len() - 1) as f64).sqrt())
}

/// Standard error of the mean: the standard deviation over √n; `None` of fewer than two.
pub fn standard_error(values: &[f64]) -> Option<f64> {
    Some(standard_deviation(values)? / (values.len() as f64).sqrt())
}

/// A standard deviation that outliers do not move: [`SIGMA_PER_MAD`] times the median of the absolute `deviations` from
/// what is usual; 0 of none.
pub fn robust_deviation(deviations: impl IntoIterator<Item = f64>) -> f64 {
    SIGMA_PER_MAD * median(deviations.into_iter().map(f64::abs)).unwrap_or(0.0)
}

/// The median; `None` of nothing. In the unit of the values.
pub fn median(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    median_in_place(&mut values.into_iter().collect::<Vec<f64>>())
}

/// The median of values that may be reordered; `None` of nothing.
pub fn median_in_place(values: &mut [f64]) -> Option<f64> {
    if values.is_empty() {
        return None;
    }
    let odd = values.len() % 2 == 1;
    let middle = values.len() / 2;
    let (below, &mut upper, _) = values.select_nth_unstable_by(middle, f64::total_cmp);
    let lower = if odd {
        upper
    } else {
        below.iter().copied().max_by(f64::total_cmp)?
    };
    Some(0.5 * lower + 0.5 * upper)
}

/// The median, or the upper one of the two in the middle: always one of the values, which may be reordered. `None` of
/// nothing.
pub fn median_high(values: &mut [f64]) -> Option<f64> {
    let middle = values.len() / 2;
    if values.is_empty() {
        return None;
    }
    Some(*values.select_nth_unstable_by(middle, f64::total_cmp).1)
}

/// The value that `share` (0 to 1) of the values stay below; `None` of nothing.
pub fn quantile(values: impl IntoIterator<Item = f64>, share: f64) -> Option<f64> {
    let mut sorted: Vec<f64> = values.into_iter().collect();
    sorted.sort_unstable_by(f64::total_cmp);
    quantile_of_sorted(&sorted, share)
}

/// The same of values that ascend already.
pub fn quantile_of_sorted(sorted: &[f64], share: f64) -> Option<f64> {
    let last = sorted.len().checked_sub(1)?;
    let position = share.clamp(0.0, 1.0) * last as f64;
    let below = position.floor() as usize;
    let above = (below + 1).min(last);
    // Two infinities have no difference.
    if sorted[above] == sorted[below] {
        return Some(sorted[below]);
    }
    Some(sorted[below] + (position - below as f64) * (sorted[above] - sorted[below]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians_of_odd_and_even_numbers() {
        assert_eq!(median([3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median([4.0, 1.0, 2.0, 3.0]), Some(2.5));
        assert_eq!(median([7.0]), Some(7.0));
        assert_eq!(median_in_place(&mut []), None);
        assert_eq!(median([f64::INFINITY, f64::INFINITY]), Some(f64::INFINITY));
        assert_eq!(median_high(&mut [4.0, 1.0, 2.0, 3.0]), Some(3.0));
        assert_eq!(median_high(&mut [3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median_high(&mut []), None);
    }

    #[test]
    fn scatter_by_hand() {
        // Squares about the mean 5: 9 1 1 1 0 0 4 16 = 32.
        let values = [2.0, 4.0, 4.0, 4.0, 5.0, 5.0, 7.0, 9.0];
        assert_eq!(mean(values), Some(5.0));
        let deviation = standard_deviation(&values).unwrap();
        assert!((deviation - (32.0f64 / 7.0).sqrt()).abs() < 1e-15);
        assert!((standard_error(&values).unwrap() - deviation / 8f64.sqrt()).abs() < 1e-15);
        assert_eq!((mean([]), standard_deviation(&[1.0])), (None, None));
        assert_eq!(robust_deviation([-1.0, 0.0, 3.0]), SIGMA_PER_MAD);
        assert_eq!(robust_deviation([]), 0.0);
        assert!((SIGMA_PER_MAD * normal_quantile(0.75) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn quantiles_are_those_of_r_and_numpy() {
        // numpy.quantile([15, 20, 35, 40, 50], [0, 0.05, 0.4, 0.95, 1])
        let values = [50.0, 20.0, 15.0, 40.0, 35.0];
        for (share, expected) in [
            (0.0, 15.0),
            (0.05, 16.0),
            (0.4, 29.0),
            (0.95, 48.0),
            (1.0, 50.0),
        ] {
            let found = quantile(values, share).unwrap();
            assert!((found - expected).abs() < 1e-12, "{share}: {found}");
        }
        assert_eq!(quantile([], 0.5), None);
        assert_eq!(quantile(values, 0.5), median(values));
    }
}
