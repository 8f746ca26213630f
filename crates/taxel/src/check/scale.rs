//! The ratio of what is read to what is there, whatever single labels say.

use crate::stats::{median, robust_deviation, student_quantile};

/// A reading farther off than this many of the usual deviations counts less (Huber 1964: 95 % of the mean's efficiency).
const HUBER: f64 = 1.345;
const EFFICIENCY: f64 = 0.95;
/// What the sensor file states of deviations weighs as much as so many presses.
const STATED_WEIGHT: f64 = 8.0;
/// Degrees of freedom that a median deviation has of each value beyond the first: it is less sure than a standard one.
const DEVIATION_WEIGHT: f64 = 0.5;
/// A sensor that has not changed is taken for one that has with this probability.
const FALSE_ALARM: f64 = 0.01;

/// A known load and what was read of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Reading {
    pub(super) load_g: f64,
    pub(super) reads_g: f64,
    /// Standard error that is stated of what is read, grams: noise and model, not the fit;
    pub(super) sigma_g: f64,
    /// and the one of a reading of the load itself. What reads too little, as where a line came and went, is stated to be known
    /// too well.
    pub(super) expected_g: f64,
}

/// The scale of loads.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Scale {
    pub(super) value: f64,
    /// A pure number; infinite where nothing tells it.
    pub(super) standard_error: f64,
    /// Degrees of freedom of that error.
    degrees: f64,
    /// Usual deviation from the scale, in standard errors where they are stated, else a share.
    pub(super) spread: f64,
}

impl Scale {
    /// A Huber mean of the ratios. `stated`: the readings know their standard errors; otherwise their scatter tells it.
    pub(super) fn of(readings: &[Reading], stated: bool) -> Option<Self> {
        let ratios: Vec<f64> = readings.iter().map(|r| r.reads_g / r.load_g).collect();
        let sigma = |r: &Reading| {
            if stated {
                (r.sigma_g.max(r.expected_g) / r.load_g).max(1e-6)
            } else {
                1.0
            }
        };
        let sigmas: Vec<f64> = readings.iter().map(sigma).collect();
        let off = |middle: f64| {
            let each = ratios.iter().zip(&sigmas);
            each.map(move |(ratio, sigma)| (ratio - middle) / sigma)
        };
        let count = ratios.len() as f64;
        // The median leaves a deviation of few values too small.
        let spread = |middle: f64| robust_deviation(off(middle)) * count / (count - 0.8).max(0.2);
        let mut value = median(ratios.iter().copied())?;
        for _ in 0..50 {
            let usual = spread(value).max(1e-9);
            let (mut sum, mut weights) = (0.0, 0.0);
            for ((ratio, sigma), off) in ratios.iter().zip(&sigmas).zip(off(value)) {
                let weight = (HUBER * usual / off.abs()).min(1.0) / (sigma * sigma);
                sum += weight * ratio;
                weights += weight;
            }
            value = sum / weights;
        }
        let spread = spread(value);
        let own = DEVIATION_WEIGHT * (count - 1.0).max(0.0);
        let said = if stated { STATED_WEIGHT } else { 0.0 };
        let degrees = own + said;
        let usual = ((said + own * spread * spread) / degrees).sqrt();
        let information: f64 = sigmas.iter().map(|sigma| sigma.powi(-2)).sum();
        let error = usual / (EFFICIENCY * information).sqrt();
        Some(Self {
            value,
            standard_error: if degrees >= 1.0 { error } else { f64::INFINITY },
            degrees,
            spread,
        })
    }

    /// How far from 1 a scale may be by its own error and that of the fit.
    pub(super) fn within(&self, fit_share: f64) -> f64 {
        let probability = 1.0 - FALSE_ALARM / 2.0;
        let own = if self.degrees >= 1.0 {
            student_quantile(probability, self.degrees) * self.standard_error
        } else {
            f64::INFINITY
        };
        own.hypot(crate::stats::normal_quantile(probability) * fit_share)
    }
}

/// The probability of at least `least` misses among `count` where each is one with probability `miss`.
pub(super) fn binomial_at_least(least: usize, count: usize, miss: f64) -> f64 {
    let mut term = (1.0 - miss).powi(count as i32);
    let mut below = 0.0;
    for k in 0..least {
        below += term;
        term *= (count - k) as f64 / (k + 1) as f64 * miss / (1.0 - miss);
    }
    (1.0 - below).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reading(load_g: f64, ratio: f64) -> Reading {
        Reading {
            load_g,
            reads_g: ratio * load_g,
            sigma_g: 0.02 * load_g,
            expected_g: 0.02 * load_g,
        }
    }

    #[test]
    fn a_wrong_label_among_eight_moves_the_scale_by_less_than_its_error() {
        let good = [1.04, 1.06, 1.05, 1.03, 1.07, 1.05, 1.05];
        let mut readings: Vec<Reading> = good.iter().map(|&r| reading(200.0, r)).collect();
        readings.push(reading(200.0, 10.0));
        for stated in [true, false] {
            let scale = Scale::of(&readings, stated).unwrap();
            assert!(
                (scale.value - 1.05).abs() < scale.standard_error,
                "{scale:?}"
            );
        }
    }

    #[test]
    fn one_press_tells_a_scale_where_deviations_are_stated_and_none_otherwise() {
        let one = [reading(100.0, 1.1)];
        assert!((Scale::of(&one, true).unwrap().standard_error - 0.02).abs() < 0.002);
        assert!(Scale::of(&one, false).unwrap().within(0.0).is_infinite());
        assert_eq!(Scale::of(&[], true), None);
    }

    #[test]
    fn misses_of_twelve_are_those_of_the_table() {
        assert!((binomial_at_least(3, 12, 0.05) - 0.01957).abs() < 1e-4);
        assert!((binomial_at_least(4, 12, 0.05) - 0.00224).abs() < 1e-4);
        assert_eq!(binomial_at_least(0, 12, 0.05), 1.0);
    }

    /// A line came and went: next to nothing is read, and stated to be known very well.
    #[test]
    fn a_press_that_is_hardly_read_moves_it_no_more_than_another() {
        let good = [1.02, 1.03, 1.01, 1.04, 1.02, 1.0, 1.03];
        let mut readings: Vec<Reading> = good.iter().map(|&r| reading(200.0, r)).collect();
        readings.push(Reading {
            reads_g: 0.02,
            sigma_g: 0.01,
            ..reading(200.0, 1.0)
        });
        let scale = Scale::of(&readings, true).unwrap();
        assert!((scale.value - 1.02).abs() < 0.02, "{scale:?}");
    }
}
