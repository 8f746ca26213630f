//! How far an estimate can be trusted: an interval from presses kept aside, and whether the input is like any
//! that was trained with.

use taxel::stats::median;

/// Half-width of an interval around an estimate: quantile · (floor + share · load), by split conformal prediction
/// (Lei et al., Distribution-free predictive inference for regression, 2018) on presses kept aside.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Interval {
    /// Share of presses that it is to cover.
    pub level: f64,
    /// What a load of zero is uncertain by, before the quantile, grams.
    pub floor_g: f64,
    /// The score that `level` of the presses kept aside stayed below.
    pub quantile: f64,
    /// Presses it was set by.
    pub presses: usize,
}

/// What half-widths grow by with the load.
const SHARE: f64 = 0.1;

impl Interval {
    /// From estimates and true loads of presses that the model was not trained with, grams.
    pub fn fit(level: f64, estimates: &[f64], loads: &[f64]) -> Self {
        let typical = median(loads.iter().copied()).unwrap_or(1.0).max(1.0);
        let mut interval = Self {
            level,
            floor_g: SHARE * typical * 0.25,
            quantile: 0.0,
            presses: loads.len(),
        };
        let mut scores: Vec<f64> = estimates
            .iter()
            .zip(loads)
            .map(|(e, l)| (e.max(0.0) - l).abs() / interval.scale(*e))
            .collect();
        scores.sort_by(f64::total_cmp);
        // The order statistic that the proof of coverage needs, not a quantile between two.
        let rank = ((scores.len() + 1) as f64 * level).ceil() as usize;
        interval.quantile = match scores.get(rank.saturating_sub(1)) {
            Some(score) => *score,
            // Too few presses for the level: the worst, and half of it again.
            None => 1.5 * scores.last().copied().unwrap_or(f64::INFINITY),
        };
        interval
    }

    fn scale(&self, estimate_g: f64) -> f64 {
        self.floor_g + SHARE * estimate_g.max(0.0)
    }

    /// Half-width around an estimate, grams.
    pub fn half_width_g(&self, estimate_g: f64) -> f64 {
        self.quantile * self.scale(estimate_g)
    }

    /// Share of presses whose load is inside.
    pub fn coverage(&self, estimates: &[f64], loads: &[f64]) -> f64 {
        let inside = estimates
            .iter()
            .zip(loads)
            .filter(|(e, l)| (e.max(0.0) - **l).abs() <= self.half_width_g(**e))
            .count();
        inside as f64 / loads.len().max(1) as f64
    }
}

/// Numbers that an input is judged by: the taxel's reading, its row's sum, largest value and number of values above
/// a tenth of that, counts.
pub const SUMMARY: usize = 4;

/// A row of readings in three numbers: sum, largest, number above a tenth of that.
fn summary(row: &[f32], dark: f32) -> [f32; SUMMARY - 1] {
    let (mut sum, mut most) = (0.0, 0f32);
    for value in row {
        sum += value - dark;
        most = most.max(value - dark);
    }
    let pressed = row.iter().filter(|&v| v - dark > 0.1 * most).count();
    [sum, most, pressed as f32]
}

/// The range of the training inputs.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Familiar {
    /// Reading of an unpressed taxel, counts.
    pub dark_counts: f32,
    /// Least of each number of the summary.
    pub least: [f32; SUMMARY],
    /// Largest.
    pub most: [f32; SUMMARY],
}

/// How far beyond the range is still familiar, in widths of the range.
const MARGIN: f32 = 0.1;

impl Familiar {
    /// The range of some presses.
    pub fn fit(rows: &crate::Rows) -> Self {
        let dark_counts = rows.dark_counts();
        let mut range = Self {
            dark_counts,
            least: [f32::INFINITY; SUMMARY],
            most: [f32::NEG_INFINITY; SUMMARY],
        };
        for i in 0..rows.len() {
            let [sum, most, pressed] = summary(rows.row_of(i), dark_counts);
            let seen = [rows.taxel[i] - dark_counts, sum, most, pressed];
            for ((least, most), x) in range.least.iter_mut().zip(&mut range.most).zip(seen) {
                *least = least.min(x);
                *most = most.max(x);
            }
        }
        range
    }

    /// Whether a row is like those of the training.
    pub fn knows_row(&self, row: &[f32]) -> bool {
        let seen = summary(row, self.dark_counts);
        seen.into_iter()
            .enumerate()
            .all(|(i, x)| self.is_inside(i + 1, x))
    }

    /// Whether a taxel's reading is.
    pub fn knows_taxel(&self, counts: f32) -> bool {
        self.is_inside(0, counts - self.dark_counts)
    }

    fn is_inside(&self, i: usize, x: f32) -> bool {
        let (least, most) = (self.least[i], self.most[i]);
        let margin = MARGIN * (most - least);
        (least - margin..=most + margin).contains(&x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    #[test]
    fn an_interval_covers_what_it_says_on_other_presses() {
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(4);
        let mut draw = |n: usize| -> (Vec<f64>, Vec<f64>) {
            (0..n)
                .map(|_| {
                    let load = 600.0 * random.random::<f64>();
                    let noise = (random.random::<f64>() + random.random::<f64>() - 1.0)
                        * (3.0 + 0.1 * load);
                    (load + noise, load)
                })
                .unzip()
        };
        let (estimates, loads) = draw(400);
        let interval = Interval::fit(0.9, &estimates, &loads);
        let (estimates, loads) = draw(4000);
        let coverage = interval.coverage(&estimates, &loads);
        // Three standard deviations of a quantile from 400 presses: 0.045.
        assert!((coverage - 0.9).abs() < 0.045, "{coverage}");
    }
}
