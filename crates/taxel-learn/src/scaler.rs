//! Mean and standard deviation of every input, from the training part alone; kept with the model.

/// Standardises inputs: (x − mean)/deviation.
#[derive(Debug, Clone, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Scaler {
    /// Mean of each input.
    pub mean: Vec<f32>,
    /// Standard deviation of each input; 1 where it does not vary.
    pub deviation: Vec<f32>,
}

impl Scaler {
    /// From rows of `width` inputs (population standard deviation, as scikit-learn's StandardScaler).
    pub fn fit(inputs: &[f32], width: usize) -> Self {
        let count = (inputs.len() / width).max(1) as f64;
        let (mut sum, mut square) = (vec![0f64; width], vec![0f64; width]);
        for row in inputs.chunks_exact(width) {
            for (s, x) in sum.iter_mut().zip(row) {
                *s += f64::from(*x);
            }
        }
        sum.iter_mut().for_each(|s| *s /= count);
        for row in inputs.chunks_exact(width) {
            for ((s, x), m) in square.iter_mut().zip(row).zip(&sum) {
                *s += (f64::from(*x) - m).powi(2);
            }
        }
        Self {
            mean: sum.iter().map(|&m| m as f32).collect(),
            deviation: square
                .iter()
                .map(|s| match (s / count).sqrt() {
                    d if d > 1e-9 => d as f32,
                    _ => 1.0,
                })
                .collect(),
        }
    }

    /// One that changes nothing.
    pub fn none(width: usize) -> Self {
        Self {
            mean: vec![0.0; width],
            deviation: vec![1.0; width],
        }
    }

    /// Scales one row of inputs in place.
    #[inline(always)]
    pub fn scale(&self, row: &mut [f32]) {
        for ((x, m), d) in row.iter_mut().zip(&self.mean).zip(&self.deviation) {
            *x = (*x - m) / d;
        }
    }
}
