//! Uniform loads at a few levels: one law per taxel, and every switch resistance apart.
//!
//! ln(G_l − g_zero) of a taxel is a + b·s(L_l), the same form for every taxel. What then still varies along
//! lines, from level to level, is the switches. Taxels differ at random in a (gain) and b (exponent), with
//! variances that are estimated; the switches follow by generalised least squares.

use taxel_linalg::{View, ViewMut, multiply, solve_symmetric};

use super::least_squares::{median, robust_deviation};

/// ln(G − g_zero) of every taxel at every level; not finite where a taxel was not read.
pub(super) struct Levels<'a> {
    /// One list per level.
    pub(super) ln_siemens: &'a [Vec<f64>],
    /// s of every taxel at every level: ln of the load that acts on it.
    pub(super) response: &'a [Vec<f64>],
    /// Standard deviation of each ln_siemens, by level.
    pub(super) noise: &'a [f64],
}

/// How taxels differ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TaxelMaterial {
    /// Mean of a.
    pub(super) intercept: f64,
    /// Mean of b.
    pub(super) exponent: f64,
    /// Standard deviation of a at the mean response.
    pub(super) gain_deviation: f64,
    /// Standard deviation of b.
    pub(super) exponent_deviation: f64,
}

/// Standard deviation of ln G that no noise explains: how well levels repeat.
const REPEAT: f64 = 3e-4;

impl Levels<'_> {
    fn taxels(&self) -> usize {
        self.ln_siemens[0].len()
    }

    fn variance(&self, level: usize) -> f64 {
        self.noise[level].powi(2) + REPEAT * REPEAT
    }

    /// Own intercept (at the taxel's mean response) and slope of a taxel by weighted least squares, the mean
    /// response, and the variances of the two. Nothing for a taxel that was not read at every level.
    fn own_line(&self, taxel: usize) -> Option<[f64; 5]> {
        let (mut w, mut wx, mut wy) = (0.0, 0.0, 0.0);
        for l in 0..self.ln_siemens.len() {
            let (x, y) = (self.response[l][taxel], self.ln_siemens[l][taxel]);
            if !y.is_finite() || !x.is_finite() {
                return None;
            }
            let weight = 1.0 / self.variance(l);
            w += weight;
            wx += weight * x;
            wy += weight * y;
        }
        let (mx, my) = (wx / w, wy / w);
        let (mut xx, mut xy) = (0.0, 0.0);
        for l in 0..self.ln_siemens.len() {
            let x = self.response[l][taxel] - mx;
            xx += x * x / self.variance(l);
            xy += x * (self.ln_siemens[l][taxel] - my) / self.variance(l);
        }
        if xx > 1e-9 {
            Some([my, xy / xx, mx, 1.0 / w, 1.0 / xx])
        } else {
            Some([my, 0.0, mx, 1.0 / w, f64::INFINITY])
        }
    }

    /// Means and spread of gain and exponent over all taxels, by robust moments. With `own_exponents` false
    /// every taxel has the mean exponent.
    pub(super) fn material(&self, own_exponents: bool) -> Option<TaxelMaterial> {
        let lines: Vec<[f64; 5]> = (0..self.taxels())
            .filter_map(|t| self.own_line(t))
            .collect();
        if lines.len() < 4 {
            return None;
        }
        let slopes: Vec<f64> = lines
            .iter()
            .filter(|l| l[4].is_finite())
            .map(|l| l[1])
            .collect();
        let exponent = if slopes.is_empty() {
            1.0
        } else {
            median(&slopes)
        };
        let noise: Vec<f64> = lines
            .iter()
            .filter(|l| l[4].is_finite())
            .map(|l| l[4])
            .collect();
        let slope_deviation =
            robust_deviation(&slopes.iter().map(|s| s - exponent).collect::<Vec<_>>());
        let from_noise = median(&noise);
        let exponent_deviation = if own_exponents {
            (slope_deviation.powi(2) - from_noise).max(0.0).sqrt()
        } else {
            0.0
        };
        let intercepts: Vec<f64> = lines.iter().map(|l| l[0] - exponent * l[2]).collect();
        let intercept = median(&intercepts);
        let gain_deviation =
            robust_deviation(&intercepts.iter().map(|a| a - intercept).collect::<Vec<_>>());
        Some(TaxelMaterial {
            intercept,
            exponent,
            gain_deviation: gain_deviation.max(1e-3),
            exponent_deviation,
        })
    }

    /// Best estimates of ln scale and exponent of every taxel: its own line, drawn towards the mean as far as
    /// its noise demands (best linear unbiased prediction, Henderson 1975). Unread taxels get the means.
    pub(super) fn per_taxel(&self, material: &TaxelMaterial) -> (Vec<f64>, Vec<f64>) {
        let mut scale = vec![material.intercept; self.taxels()];
        let mut exponent = vec![material.exponent; self.taxels()];
        for taxel in 0..self.taxels() {
            let Some([y, slope, x, y_variance, slope_variance]) = self.own_line(taxel) else {
                continue;
            };
            let prior = material.exponent_deviation.powi(2);
            let trust = if prior > 0.0 {
                prior / (prior + slope_variance)
            } else {
                0.0
            };
            let own = if slope_variance.is_finite() {
                material.exponent + trust * (slope - material.exponent)
            } else {
                material.exponent
            };
            let mean = material.intercept + material.exponent * x;
            let prior =
                material.gain_deviation.powi(2) + material.exponent_deviation.powi(2) * x * x;
            let at_mean = mean + prior / (prior + y_variance) * (y - mean);
            exponent[taxel] = own;
            scale[taxel] = at_mean - own * x;
        }
        (scale, exponent)
    }

    /// One step of generalised least squares for line parameters: `slopes[i][l][taxel]` is the derivative of
    /// ln_siemens by parameter i; `prior` gives each parameter's wanted step and standard deviation; `groups`
    /// say which parameters' mean is held to the mean wanted step, and how well.
    pub(super) fn line_step(
        &self,
        slopes: &[Vec<Vec<f64>>],
        material: &TaxelMaterial,
        prior: &[(f64, f64)],
        groups: &[(Vec<usize>, f64)],
    ) -> Option<Vec<f64>> {
        let (levels, lines) = (self.ln_siemens.len(), slopes.len());
        // Free: every line, and the mean of every level (the material's law, and the loads' scale).
        let size = lines + levels;
        let (design, wanted) = self.line_equations(slopes, material)?;
        let rows = wanted.len();
        let design = View::new(&design, rows, size);
        let wanted = View::new(&wanted, rows, 1);
        let (mut normal, mut right) = (vec![0.0; size * size], vec![0.0; size]);
        multiply(
            ViewMut::new(&mut normal, size, size),
            design.transpose(),
            design,
        );
        multiply(
            ViewMut::new(&mut right, size, 1),
            design.transpose(),
            wanted,
        );
        for (i, &(step, deviation)) in prior.iter().enumerate() {
            let weight = 1.0 / (deviation * deviation);
            normal[i * size + i] += weight;
            right[i] += weight * step;
        }
        for (group, deviation) in groups {
            let n = group.len() as f64;
            let weight = 1.0 / (deviation * deviation * n * n);
            let mean: f64 = group.iter().map(|&i| prior[i].0).sum();
            for &i in group {
                right[i] += weight * mean;
                for &j in group {
                    normal[i * size + j] += weight;
                }
            }
        }
        for l in 0..levels {
            normal[(lines + l) * (size + 1)] += 1e-6;
        }
        let mut step = solve_symmetric(&normal, &right)?;
        step.truncate(lines);
        Some(step)
    }

    /// The equations of [`Self::line_step`], whitened: rows of (lines, levels), one after another, and their right sides;
    /// nothing without any.
    fn line_equations(
        &self,
        slopes: &[Vec<Vec<f64>>],
        material: &TaxelMaterial,
    ) -> Option<(Vec<f64>, Vec<f64>)> {
        let (levels, lines) = (self.ln_siemens.len(), slopes.len());
        let size = lines + levels;
        let centre: Vec<f64> = (0..levels)
            .map(|l| {
                let values: Vec<f64> = self
                    .residuals(l, material)
                    .filter(|r| r.is_finite())
                    .collect();
                median(&values)
            })
            .collect();
        let mut design = Vec::new();
        let mut wanted = Vec::new();
        let limit = self.outlier_limit(material, &centre);
        for taxel in 0..self.taxels() {
            let residual: Vec<f64> = (0..levels)
                .map(|l| self.residual(l, taxel, material) - centre[l])
                .collect();
            if residual.iter().any(|r| !r.is_finite() || r.abs() > limit) {
                continue;
            }
            let whitening = self.whitening(taxel, material)?;
            for (row, weights) in whitening.iter().enumerate() {
                let mut y = 0.0;
                let mut line = vec![0.0; size];
                for l in 0..=row {
                    let w = weights[l];
                    y += w * residual[l];
                    for (i, slope) in slopes.iter().enumerate() {
                        line[i] -= w * slope[l][taxel];
                    }
                    line[lines + l] += w;
                }
                design.extend(line);
                wanted.push(y);
            }
        }
        (!wanted.is_empty()).then_some((design, wanted))
    }

    fn residual(&self, level: usize, taxel: usize, material: &TaxelMaterial) -> f64 {
        self.ln_siemens[level][taxel]
            - material.intercept
            - material.exponent * self.response[level][taxel]
    }

    fn residuals<'b>(
        &'b self,
        level: usize,
        material: &'b TaxelMaterial,
    ) -> impl Iterator<Item = f64> + 'b {
        (0..self.taxels()).map(move |t| self.residual(level, t, material))
    }

    fn outlier_limit(&self, material: &TaxelMaterial, centre: &[f64]) -> f64 {
        let all: Vec<f64> = centre
            .iter()
            .enumerate()
            .flat_map(|(l, centre)| self.residuals(l, material).map(move |r| r - centre))
            .filter(|r| r.is_finite())
            .collect();
        5.0 * robust_deviation(&all)
    }

    /// Inverse Cholesky factor of a taxel's covariance: noise, gain, exponent.
    fn whitening(&self, taxel: usize, material: &TaxelMaterial) -> Option<Vec<Vec<f64>>> {
        let levels = self.ln_siemens.len();
        let mean = (0..levels).map(|l| self.response[l][taxel]).sum::<f64>() / levels as f64;
        let mut lower = vec![vec![0.0; levels]; levels];
        for i in 0..levels {
            for j in 0..=i {
                let (x, y) = (
                    self.response[i][taxel] - mean,
                    self.response[j][taxel] - mean,
                );
                let mut covariance =
                    material.gain_deviation.powi(2) + material.exponent_deviation.powi(2) * x * y;
                if i == j {
                    covariance += self.variance(i);
                }
                let known: f64 = (0..j).map(|k| lower[i][k] * lower[j][k]).sum();
                let left = covariance - known;
                lower[i][j] = if i != j {
                    left / lower[j][j]
                } else if left > 0.0 {
                    left.sqrt()
                } else {
                    return None;
                };
            }
        }
        let mut inverse = vec![vec![0.0; levels]; levels];
        for i in 0..levels {
            let (known, rest) = inverse.split_at_mut(i);
            rest[0][i] = 1.0 / lower[i][i];
            for (k, row) in known.iter().enumerate() {
                for (value, factor) in rest[0].iter_mut().zip(&row[..=k]) {
                    *value -= lower[i][k] * factor / lower[i][i];
                }
            }
        }
        Some(inverse)
    }
}
