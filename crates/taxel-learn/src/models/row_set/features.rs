//! How a row set sees a reading, and what one calibration curve makes of it.

use taxel::stats::{Line, mean};

use crate::rows::Rows;

/// Features of one reading.
pub(super) const FEATURES: usize = 3;

/// How readings are seen: over the level of an unpressed taxel, linear, square root and logarithm.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct RowFeatures {
    /// Reading of an unpressed taxel, counts.
    pub dark_counts: f32,
    /// Typical reading of a pressed taxel over that, counts.
    pub bright_counts: f32,
    /// Typical load, grams: the unit of the loss.
    pub scale_g: f32,
    /// Of the one curve that suits all presses, load = factor · x^exponent with x over the level of an unpressed
    /// taxel in units of `bright_counts`: factor, grams.
    pub factor_g: f32,
    /// And exponent.
    pub exponent: f32,
}

impl RowFeatures {
    pub(super) fn of(rows: &Rows) -> Self {
        let mean = |v: &[f32]| v.iter().map(|&x| f64::from(x)).sum::<f64>() / v.len() as f64;
        let dark = rows.dark_counts();
        let bright = (mean(&rows.taxel) as f32 - dark).max(1.0);
        let logs: Vec<(f64, f64)> = rows
            .taxel
            .iter()
            .zip(&rows.load_g)
            .map(|(&x, &load)| (f64::from((x - dark) / bright), f64::from(load)))
            .filter(|(x, load)| *x > 0.02 && *load > 0.0)
            .map(|(x, load)| (x.ln(), load.ln()))
            .collect();
        let (exponent, ln_factor) = line(&logs);
        Self {
            dark_counts: dark,
            bright_counts: bright,
            scale_g: mean(&rows.load_g) as f32,
            factor_g: ln_factor.exp() as f32,
            exponent: exponent as f32,
        }
    }

    /// What the one curve makes of a reading, grams.
    pub(super) fn curve_g(&self, counts: f32) -> f32 {
        let x = (counts - self.dark_counts) / self.bright_counts;
        if x > 0.0 {
            self.factor_g * x.powf(self.exponent)
        } else {
            0.0
        }
    }

    pub(super) fn see(&self, counts: f32) -> [f32; FEATURES] {
        let x = ((counts - self.dark_counts) / self.bright_counts).max(-0.05);
        [x, (x + 0.05).sqrt(), (x + 0.051).ln() * 0.3]
    }
}

/// Slope and intercept of a straight line by least squares; slope 1 where nothing says otherwise.
fn line(points: &[(f64, f64)]) -> (f64, f64) {
    Line::fit(points).map_or_else(
        || {
            let rise = mean(points.iter().map(|(x, y)| y - x));
            (1.0, rise.unwrap_or(0.0))
        },
        |line| (line.slope, line.offset),
    )
}
