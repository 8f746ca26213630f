//! How far are estimates from known loads?

use crate::metric::deviations;
use crate::stats::{Bootstrap, Estimate};

/// An estimate beside what is true, in the same unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pair {
    /// The known load.
    pub truth: f64,
    /// What the sensor says.
    pub estimate: f64,
}

/// Errors as [`crate::metric::Deviations`] defines them, in the unit of the loads, each over all readings with its interval over
/// experiments.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Accuracy {
    /// Readings.
    pub readings: usize,
    /// Mean error: positive where the sensor says too much.
    pub bias: Estimate,
    /// Mean absolute error.
    pub mean_absolute: Estimate,
    /// Root of the mean square error.
    pub root_mean_square: Estimate,
    /// 95th percentile of the absolute error.
    pub percentile_95: Estimate,
}

/// Judges estimates, grouped by experiment (a press). `None` without any.
pub fn accuracy(experiments: &[Vec<Pair>], bootstrap: &Bootstrap) -> Option<Accuracy> {
    let figures = |pairs: &[Pair]| {
        let all = deviations(pairs.iter().map(|pair| (pair.estimate, pair.truth)))?;
        Some([
            all.bias,
            all.mean_absolute,
            all.root_mean_square,
            all.percentile_95,
        ])
    };
    let [bias, mean_absolute, root_mean_square, percentile_95] =
        bootstrap.estimates(experiments, figures)?;
    Some(Accuracy {
        readings: experiments.iter().map(Vec::len).sum(),
        bias,
        mean_absolute,
        root_mean_square,
        percentile_95,
    })
}

/// The same by the range that the true load is in: from `edges[i]` to below `edges[i + 1]`; the last range has no end.
/// Ranges without readings are left out.
pub fn by_range(
    experiments: &[Vec<Pair>],
    edges: &[f64],
    bootstrap: &Bootstrap,
) -> Vec<((f64, f64), Accuracy)> {
    let range = |i: usize| (edges[i], edges.get(i + 1).copied().unwrap_or(f64::INFINITY));
    let of = |i: usize| {
        let (from, to) = range(i);
        let inside = |pair: &&Pair| (from..to).contains(&pair.truth);
        let groups: Vec<Vec<Pair>> = experiments
            .iter()
            .map(|group| group.iter().filter(inside).copied().collect())
            .collect();
        Some((range(i), accuracy(&groups, bootstrap)?))
    };
    (0..edges.len()).filter_map(of).collect()
}
