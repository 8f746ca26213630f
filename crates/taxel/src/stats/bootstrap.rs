//! Intervals by resampling experiments.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::quantile_of_sorted;
use crate::parallel::Step;

/// A figure and how far to trust it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// The figure, from all experiments.
    pub value: f64,
    /// The interval that holds it at the confidence asked for; `None` with fewer than three experiments.
    pub interval: Option<(f64, f64)>,
    /// Experiments that it rests on.
    pub experiments: usize,
}

impl Estimate {
    /// A figure without an interval.
    pub fn alone(value: f64, experiments: usize) -> Self {
        Self {
            value,
            interval: None,
            experiments,
        }
    }

    /// The same in another unit, `factor` of which are one of this.
    pub fn times(self, factor: f64) -> Self {
        let scaled = self.interval.map(|(low, high)| {
            let (a, b) = (low * factor, high * factor);
            (a.min(b), a.max(b))
        });
        Self {
            value: self.value * factor,
            interval: scaled,
            experiments: self.experiments,
        }
    }
}

/// Percentile bootstrap over experiments: B. Efron, "Bootstrap Methods: Another Look at the Jackknife", 1979. With few
/// experiments its intervals are too narrow; below three there is none.
#[derive(Debug, Clone)]
pub struct Bootstrap {
    /// Fixes what is drawn.
    pub seed: u64,
    /// How often experiments are drawn anew.
    pub resamples: usize,
    /// Share of the draws that the interval holds.
    pub confidence: f64,
    /// Called before each draw.
    pub step: Step,
}

impl Default for Bootstrap {
    fn default() -> Self {
        Self {
            seed: 1,
            resamples: 2000,
            confidence: 0.95,
            step: Step::NONE,
        }
    }
}

impl Bootstrap {
    /// The fewest experiments that give an interval.
    pub const MIN_EXPERIMENTS: usize = 3;

    /// A figure of all readings, and its interval over the experiments that they come from. `None` where the readings
    /// do not give the figure; draws that do not give it are left out.
    pub fn estimate<T: Clone>(
        &self,
        experiments: &[Vec<T>],
        figure: impl Fn(&[T]) -> Option<f64>,
    ) -> Option<Estimate> {
        let [one] = self.estimates(experiments, |some| Some([figure(some)?]))?;
        Some(one)
    }

    /// Several figures of the same draws: what one of them costs to draw is paid once.
    pub fn estimates<T: Clone, const N: usize>(
        &self,
        experiments: &[Vec<T>],
        figures: impl Fn(&[T]) -> Option<[f64; N]>,
    ) -> Option<[Estimate; N]> {
        let all: Vec<T> = experiments.concat();
        let values = figures(&all)?;
        let filled: Vec<&Vec<T>> = experiments.iter().filter(|one| !one.is_empty()).collect();
        let count = filled.len();
        if count < Self::MIN_EXPERIMENTS {
            return Some(values.map(|value| Estimate::alone(value, count)));
        }
        let mut random = ChaCha8Rng::seed_from_u64(self.seed);
        let mut drawn = Vec::with_capacity(all.len());
        let mut draws: [Vec<f64>; N] = std::array::from_fn(|_| Vec::with_capacity(self.resamples));
        for _ in 0..self.resamples {
            self.step.done();
            drawn.clear();
            for _ in 0..count {
                drawn.extend_from_slice(filled[random.random_range(0..count)]);
            }
            for (draws, value) in draws.iter_mut().zip(figures(&drawn).into_iter().flatten()) {
                draws.extend(Some(value).filter(|value| value.is_finite()));
            }
        }
        let outside = (1.0 - self.confidence) / 2.0;
        let interval = |draws: &mut Vec<f64>| {
            draws.sort_by(f64::total_cmp);
            let at = |share| quantile_of_sorted(draws, share);
            at(outside).zip(at(1.0 - outside))
        };
        Some(std::array::from_fn(|i| Estimate {
            value: values[i],
            interval: interval(&mut draws[i]),
            experiments: count,
        }))
    }
}
