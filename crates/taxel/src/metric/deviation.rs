//! How far estimates are from the truth.

use super::{same_shape, usable};
use crate::stats::quantile_of_sorted;
use crate::{Error, Frame};

/// Deviations e = estimate − truth over some taxels, in the unit of the two.
///
/// Source: usual definitions (Hyndman and Koehler, *Int. J. Forecasting* 22:679, 2006, for MAE and RMSE; the
/// percentile: [`crate::stats`]).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Deviations {
    /// How many values were compared.
    pub count: usize,
    /// Bias: mean of e.
    pub bias: f64,
    /// Mean absolute error: mean of |e|.
    pub mean_absolute: f64,
    /// Root mean square error: √(mean of e²).
    pub root_mean_square: f64,
    /// 95th percentile of |e|.
    pub percentile_95: f64,
    /// Largest |e|.
    pub largest: f64,
}

/// The deviations of pairs `(estimate, truth)`. `None` for no pairs at all.
pub fn deviations(pairs: impl IntoIterator<Item = (f64, f64)>) -> Option<Deviations> {
    let mut sum = 0.0;
    let mut sizes: Vec<f64> = Vec::new();
    for (estimate, truth) in pairs {
        sum += estimate - truth;
        sizes.push((estimate - truth).abs());
    }
    if sizes.is_empty() {
        return None;
    }
    sizes.sort_unstable_by(f64::total_cmp);
    let count = sizes.len();
    let mean = |total: f64| total / count as f64;
    Some(Deviations {
        count,
        bias: mean(sum),
        mean_absolute: mean(sizes.iter().sum()),
        root_mean_square: mean(sizes.iter().map(|e| e * e).sum()).sqrt(),
        percentile_95: quantile_of_sorted(&sizes, 0.95)?,
        largest: sizes[count - 1],
    })
}

/// The deviations over the taxels of one frame that count in the estimate and for which `chosen(taxel, truth)`
/// holds, taxel = row · columns + column: `|_, truth| truth > 0.0` for the loaded ones. For a whole recording chain the
/// pairs of its frames into [`deviations`]. `None` when nothing is chosen.
///
/// # Errors
/// [`Error::Shape`] when the two frames differ in shape.
pub fn deviations_of_frames<Q>(
    estimate: &Frame<Q>,
    truth: &Frame<Q>,
    chosen: impl Fn(usize, f64) -> bool,
) -> Result<Option<Deviations>, Error> {
    same_shape("truth to compare with", estimate, truth)?;
    let pairs = usable(estimate).map(|(i, value)| (i, value, truth.values()[i]));
    Ok(deviations(
        pairs
            .filter(|(i, _, truth)| chosen(*i, *truth))
            .map(|(_, estimate, truth)| (estimate, truth)),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Mark, Newtons};

    #[test]
    fn by_hand() {
        // e = 1, -2, 3, -4
        let d = deviations([(1.0, 0.0), (0.0, 2.0), (5.0, 2.0), (1.0, 5.0)]).unwrap();
        assert_eq!(
            (d.count, d.bias, d.mean_absolute, d.largest),
            (4, -0.5, 2.5, 4.0)
        );
        assert!((d.root_mean_square - 7.5_f64.sqrt()).abs() < 1e-12);
        // sorted 1 2 3 4, position 0.95·3 = 2.85: 3 + 0.85
        assert!((d.percentile_95 - 3.85).abs() < 1e-12);
        assert_eq!(deviations([]), None);
    }

    #[test]
    fn only_chosen_taxels_that_count() {
        let mut estimate = Frame::<Newtons>::new(1, 4, vec![1.0, 2.0, 9.0, 0.3]).unwrap();
        let truth = Frame::<Newtons>::new(1, 4, vec![1.5, 2.0, 3.0, 0.0]).unwrap();
        estimate.marks_mut()[2] = Mark::Stuck;
        let loaded = deviations_of_frames(&estimate, &truth, |_, t| t > 0.0)
            .unwrap()
            .unwrap();
        assert_eq!((loaded.count, loaded.mean_absolute), (2, 0.25));
        let none = deviations_of_frames(&estimate, &truth, |_, t| t > 100.0).unwrap();
        assert_eq!(none, None);
        assert!(deviations_of_frames(&estimate, &Frame::zeros(2, 2), |_, _| true).is_err());
    }
}
