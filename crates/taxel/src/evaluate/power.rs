//! A power law through readings.

use crate::stats::Line;

/// value = offset + factor · x^exponent, x ≥ 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Power {
    /// Value at x = 0.
    pub offset: f64,
    /// Value per unit of x^exponent.
    pub factor: f64,
    /// A pure number.
    pub exponent: f64,
    /// Root of the mean square of what is left, in the unit of the values.
    pub residual: f64,
}

/// Exponents that are believed.
const EXPONENTS: (f64, f64) = (0.1, 4.0);

impl Power {
    /// Least squares: for each exponent offset and factor are linear; the exponent by golden section. `None` with
    /// fewer than three different x, or with one below zero.
    pub fn fit(points: &[(f64, f64)]) -> Option<Self> {
        let mut places: Vec<f64> = points.iter().map(|p| p.0).collect();
        places.sort_by(f64::total_cmp);
        places.dedup();
        if places.len() < 3 || places[0] < 0.0 {
            return None;
        }
        let with = |exponent: f64| -> Option<Self> {
            let bent: Vec<_> = points.iter().map(|p| (p.0.powf(exponent), p.1)).collect();
            let line = Line::fit(&bent)?;
            let squares: f64 = bent.iter().map(|p| (p.1 - line.at(p.0)).powi(2)).sum();
            Some(Self {
                offset: line.offset,
                factor: line.slope,
                exponent,
                residual: (squares / bent.len() as f64).sqrt(),
            })
        };
        let cost = |log: f64| with(log.exp()).map_or(f64::INFINITY, |power| power.residual);
        // A coarse look first: the cost may have more than one valley.
        let (low, high) = (EXPONENTS.0.ln(), EXPONENTS.1.ln());
        let step = (high - low) / 40.0;
        let best = (0..=40)
            .map(|i| low + f64::from(i) * step)
            .min_by(|a, b| cost(*a).total_cmp(&cost(*b)))?;
        with(golden(cost, (best - step).max(low), (best + step).min(high)).exp())
    }

    /// The law's value; x ≥ 0.
    pub fn at(&self, x: f64) -> f64 {
        self.offset + self.factor * x.powf(self.exponent)
    }

    /// The x at which the law is `rise` above its value at 0; `None` where it never is.
    pub fn x_of_rise(&self, rise: f64) -> Option<f64> {
        let ratio = rise / self.factor;
        (ratio >= 0.0 && ratio.is_finite()).then(|| ratio.powf(1.0 / self.exponent))
    }
}

/// Where a function with one valley between `low` and `high` is least, to 1e-9.
pub(super) fn golden(cost: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    let share = (5f64.sqrt() - 1.0) / 2.0;
    let mut inner = (high - share * (high - low), low + share * (high - low));
    let mut costs = (cost(inner.0), cost(inner.1));
    while high - low > 1e-9 {
        if costs.0 <= costs.1 {
            high = inner.1;
            inner = (high - share * (high - low), inner.0);
            costs = (cost(inner.0), costs.0);
        } else {
            low = inner.0;
            inner = (inner.1, low + share * (high - low));
            costs = (costs.1, cost(inner.1));
        }
    }
    (low + high) / 2.0
}
