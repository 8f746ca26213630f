//! Adam (Kingma and Ba 2015), with scikit-learn's defaults.

use super::Real;

/// Step and memory of Adam.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[non_exhaustive]
pub struct AdamSettings {
    /// Learning rate.
    pub rate: f64,
    /// Share of the mean gradient that is kept from step to step.
    pub keep_mean: f64,
    /// Share of the mean square that is kept.
    pub keep_square: f64,
    /// What keeps the division sane.
    pub epsilon: f64,
}

impl Default for AdamSettings {
    fn default() -> Self {
        Self {
            rate: 1e-3,
            keep_mean: 0.9,
            keep_square: 0.999,
            epsilon: 1e-8,
        }
    }
}

/// The optimiser's memory for one list of parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct Adam<T: Real = f32> {
    settings: AdamSettings,
    mean: Vec<T>,
    square: Vec<T>,
    steps: u64,
}

impl<T: Real> Adam<T> {
    /// For `count` parameters.
    pub fn new(settings: AdamSettings, count: usize) -> Self {
        Self {
            settings,
            mean: vec![T::default(); count],
            square: vec![T::default(); count],
            steps: 0,
        }
    }

    /// Means, squares and number of steps: what a checkpoint keeps.
    pub fn state(&self) -> (&[T], &[T], u64) {
        (&self.mean, &self.square, self.steps)
    }

    /// Sets them again.
    pub fn restore(&mut self, mean: &[T], square: &[T], steps: u64) {
        self.mean.copy_from_slice(mean);
        self.square.copy_from_slice(square);
        self.steps = steps;
    }

    /// Changes the learning rate.
    pub fn set_rate(&mut self, rate: f64) {
        self.settings.rate = rate;
    }

    /// One step down the gradient: p ← p − r m̂/(√v̂ + ε), in scikit-learn's form (ε beside the uncorrected √v).
    pub fn step(&mut self, parameters: &mut [T], gradient: &[T]) {
        self.steps += 1;
        let AdamSettings {
            rate,
            keep_mean,
            keep_square,
            epsilon,
        } = self.settings;
        let count = self.steps as f64;
        let rate = rate * (1.0 - keep_square.powf(count)).sqrt() / (1.0 - keep_mean.powf(count));
        let (rate, epsilon) = (T::of(rate), T::of(epsilon));
        let (a, one_a) = (T::of(keep_mean), T::of(1.0 - keep_mean));
        let (b, one_b) = (T::of(keep_square), T::of(1.0 - keep_square));
        let (mean, square) = (&mut self.mean[..], &mut self.square[..]);
        // The same loop, compiled for the machine's vectors.
        pulp::Arch::new().dispatch(
            #[inline(always)]
            || {
                for (((p, g), m), v) in parameters.iter_mut().zip(gradient).zip(mean).zip(square) {
                    *m = flushed(a * *m + one_a * *g);
                    *v = flushed(b * *v + one_b * *g * *g);
                    *p -= rate * *m / (v.root() + epsilon);
                }
            },
        );
    }
}

/// Zero for what is next to nothing: the memory of a silent unit fades into subnormal numbers, and arithmetic
/// with those is a hundred times slower.
#[inline(always)]
fn flushed<T: Real>(value: T) -> T {
    let least = T::of(1e-30);
    if value > least || value < -least {
        value
    } else {
        T::default()
    }
}
