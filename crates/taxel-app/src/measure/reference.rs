//! The force that a recording itself tells (of the program that exported it, or of another instrument) beside the one measured.

use serde::Serialize;

use super::Series;

/// Below this share of the largest force a ratio says nothing.
const LEAST_SHARE: f64 = 0.1;

/// How the total force compares with the one that the recording tells.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Reference {
    /// Frames with both.
    pub frames: u64,
    /// Mean of total less reference, newtons.
    pub mean_difference_n: f64,
    /// The largest of their differences, newtons.
    pub largest_difference_n: f64,
    /// Median of total over reference, where the reference is more than a tenth of its largest; a pure number.
    pub ratio: Option<f64>,
    /// The largest reference, newtons.
    pub largest_n: f64,
}

impl Reference {
    /// Of a series; `None` where its recording tells no force.
    pub(super) fn of(series: &Series) -> Option<Self> {
        let pairs = series.total.newtons.iter().zip(&series.reference_newtons);
        let both = pairs.filter(|(total, reference)| total.is_finite() && reference.is_finite());
        let both: Vec<(f64, f64)> = both
            .map(|(total, reference)| (*total, *reference))
            .collect();
        Self::of_pairs(&both)
    }

    /// Of totals and references, newtons; `None` of none.
    pub(crate) fn of_pairs(both: &[(f64, f64)]) -> Option<Self> {
        if both.is_empty() {
            return None;
        }
        let largest_n = both
            .iter()
            .map(|(_, reference)| *reference)
            .fold(0.0, f64::max);
        let differences = || both.iter().map(|(total, reference)| total - reference);
        let loaded = both
            .iter()
            .filter(|(_, reference)| *reference > LEAST_SHARE * largest_n);
        let ratios = loaded.map(|(total, reference)| total / reference);
        Some(Self {
            frames: both.len() as u64,
            mean_difference_n: differences().sum::<f64>() / both.len() as f64,
            largest_difference_n: differences().map(f64::abs).fold(0.0, f64::max),
            ratio: taxel::stats::median(ratios),
            largest_n,
        })
    }
}
