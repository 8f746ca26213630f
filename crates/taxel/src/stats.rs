//! Medians and quantiles: one definition for the whole workspace.
//!
//! Quantiles are type 7 of Hyndman and Fan (*Sample quantiles in statistical packages*, The American Statistician
//! 50:361, 1996): linear between order statistics, what R, numpy and spreadsheets give by default. The median of an even
//! number of values is the mean of the two in the middle. (The screen alone takes the upper one: it asks what a
//! reading was, and twice a frame.)
//!
//! ```
//! use taxel::stats::{median, quantile};
//!
//! assert_eq!(median([4.0, 1.0, 3.0, 2.0]), Some(2.5));
//! assert_eq!(quantile([1.0, 2.0, 3.0, 4.0], 0.25), Some(1.75));
//! assert_eq!(median([]), None);
//! ```

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
    let lower = match odd {
        true => upper,
        false => below.iter().copied().max_by(f64::total_cmp)?,
    };
    Some(0.5 * lower + 0.5 * upper)
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
    match sorted[above] == sorted[below] {
        // Two infinities have no difference.
        true => Some(sorted[below]),
        false => Some(sorted[below] + (position - below as f64) * (sorted[above] - sorted[below])),
    }
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
