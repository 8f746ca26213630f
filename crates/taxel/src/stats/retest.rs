//! How well a measurement repeats itself: persons measured in several sessions.

use super::student::{fisher_quantile, student_quantile};
use super::{Estimate, mean, standard_deviation};

/// Test against retest: how far a figure of one session can be told from that of another, and persons from each other.
///
/// ```
/// use taxel::stats::Retest;
///
/// let grips = [vec![77.1, 79.4], vec![102.5, 98.0], vec![64.2, 66.9]]; // a person each, a session each, N
/// let retest = Retest::of(&grips).unwrap();
/// assert!(retest.agreement.value > 0.97);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Retest {
    /// Persons.
    pub persons: usize,
    /// Sessions of each.
    pub sessions: usize,
    /// Mean over all.
    pub mean: f64,
    /// Intraclass correlation, absolute agreement of single sessions, sessions drawn at random: ICC(A,1), also called ICC(2,1).
    /// What sessions differ by on average counts as error.
    pub agreement: Estimate,
    /// Intraclass correlation, consistency of single sessions: ICC(C,1), also called ICC(3,1). A shift between sessions is
    /// forgiven.
    pub consistency: Estimate,
    /// Standard error of measurement, in the unit of the values: the standard deviation of one person's sessions, a shift
    /// between sessions counted.
    pub standard_error: f64,
    /// Minimal detectable change at 95 %, in the unit of the values: two sessions of a person that differ by less may be the
    /// same.
    pub detectable_change: f64,
    /// Second session less first.
    pub difference: Difference,
}

/// Differences of pairs, after Bland and Altman.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Difference {
    /// Their mean: the bias of the second against the first.
    pub mean: Estimate,
    /// Their standard deviation.
    pub deviation: f64,
    /// Limits of agreement: 95 % of differences lie between them, where they are normal.
    pub limits: [Estimate; 2],
}

/// Confidence of all intervals here.
const BELOW: f64 = 0.975;

impl Retest {
    /// Of a row a person, a value a session; `None` of fewer than three persons, of fewer than two sessions, of rows that are
    /// not equally long, and where nothing differs.
    ///
    /// Sources: McGraw and Wong, *Forming inferences about some intraclass correlation coefficients*, Psychological Methods 1:30,
    /// 1996 (cases 2 and 3, with their intervals); Weir, *Quantifying test-retest reliability using the intraclass correlation
    /// coefficient and the SEM*, J Strength Cond Res 19:231, 2005; [`Difference::of`].
    pub fn of(values: &[Vec<f64>]) -> Option<Self> {
        let (n, k) = (values.len(), values.first()?.len());
        if n < 3 || k < 2 || values.iter().any(|row| row.len() != k) {
            return None;
        }
        let squares = MeanSquares::of(values);
        if !(squares.persons > 0.0 && squares.error.is_finite()) {
            return None;
        }
        let pairs: Vec<(f64, f64)> = values.iter().map(|row| (row[0], row[1])).collect();
        let shift = ((squares.sessions - squares.error) / n as f64).max(0.0);
        let standard_error = (shift + squares.error).sqrt();
        Some(Self {
            persons: n,
            sessions: k,
            mean: squares.mean,
            agreement: squares.agreement(),
            consistency: squares.consistency(),
            standard_error,
            detectable_change: student_quantile(BELOW, f64::INFINITY)
                * 2f64.sqrt()
                * standard_error,
            difference: Difference::of(&pairs)?,
        })
    }
}

impl Difference {
    /// Of pairs (first, second): second less first. `None` of fewer than three.
    ///
    /// Source: Bland and Altman, *Measuring agreement in method comparison studies*, Stat Methods Med Res 8:135, 1999, with its
    /// approximate intervals of the limits.
    pub fn of(pairs: &[(f64, f64)]) -> Option<Self> {
        let differences: Vec<f64> = pairs.iter().map(|(first, second)| second - first).collect();
        let count = differences.len();
        if count < 3 {
            return None;
        }
        let n = count as f64;
        let bias = mean(differences.iter().copied())?;
        let deviation = standard_deviation(&differences)?;
        let z = student_quantile(BELOW, f64::INFINITY);
        let t = student_quantile(BELOW, n - 1.0);
        let around = |value: f64, half: f64| Estimate {
            value,
            interval: Some((value - half, value + half)),
            experiments: count,
        };
        let of_limit = t * deviation * (1.0 / n + z * z / (2.0 * (n - 1.0))).sqrt();
        Some(Self {
            mean: around(bias, t * deviation / n.sqrt()),
            deviation,
            limits: [-z, z].map(|z| around(bias + z * deviation, of_limit)),
        })
    }
}

/// The two-way analysis of variance, one value a cell.
struct MeanSquares {
    n: f64,
    k: f64,
    mean: f64,
    persons: f64,
    sessions: f64,
    error: f64,
}

impl MeanSquares {
    fn of(values: &[Vec<f64>]) -> Self {
        let (n, k) = (values.len() as f64, values[0].len() as f64);
        let all = values.iter().flatten().sum::<f64>() / (n * k);
        let of_person = |row: &Vec<f64>| row.iter().sum::<f64>() / k;
        let of_session = |j: usize| values.iter().map(|row| row[j]).sum::<f64>() / n;
        let sessions: Vec<f64> = (0..values[0].len()).map(of_session).collect();
        let between_persons = values
            .iter()
            .map(|row| (of_person(row) - all).powi(2))
            .sum::<f64>();
        let between_sessions = sessions
            .iter()
            .map(|mean| (mean - all).powi(2))
            .sum::<f64>();
        let rest = |row: &Vec<f64>| -> f64 {
            let person = of_person(row);
            let cells = row.iter().zip(&sessions);
            cells
                .map(|(value, session)| (value - person - session + all).powi(2))
                .sum()
        };
        let rest = values.iter().map(rest).sum::<f64>();
        Self {
            n,
            k,
            mean: all,
            persons: k * between_persons / (n - 1.0),
            sessions: n * between_sessions / (k - 1.0),
            error: rest / ((n - 1.0) * (k - 1.0)),
        }
    }

    fn agreement(&self) -> Estimate {
        let Self {
            n,
            k,
            persons,
            sessions,
            error,
            ..
        } = *self;
        let value = (persons - error) / (persons + (k - 1.0) * error + k / n * (sessions - error));
        let a = k * value / (n * (1.0 - value));
        let b = 1.0 + k * value * (n - 1.0) / (n * (1.0 - value));
        let (of_sessions, of_error) = (a * sessions, b * error);
        let degrees = (of_sessions + of_error).powi(2)
            / (of_sessions.powi(2) / (k - 1.0) + of_error.powi(2) / ((n - 1.0) * (k - 1.0)));
        let spread = k * sessions + (k * n - k - n) * error;
        let below = fisher_quantile(BELOW, n - 1.0, degrees);
        let above = fisher_quantile(BELOW, degrees, n - 1.0);
        let low = n * (persons - below * error) / (below * spread + n * persons);
        let high = n * (above * persons - error) / (spread + n * above * persons);
        self.estimate(value, low, high)
    }

    fn consistency(&self) -> Estimate {
        let Self {
            n,
            k,
            persons,
            error,
            ..
        } = *self;
        let value = (persons - error) / (persons + (k - 1.0) * error);
        let ratio = persons / error;
        let rest = (n - 1.0) * (k - 1.0);
        let low = ratio / fisher_quantile(BELOW, n - 1.0, rest);
        let high = ratio * fisher_quantile(BELOW, rest, n - 1.0);
        let of = |ratio: f64| (ratio - 1.0) / (ratio + k - 1.0);
        self.estimate(value, of(low), of(high))
    }

    /// Without an interval where sessions agree to the last digit.
    fn estimate(&self, value: f64, low: f64, high: f64) -> Estimate {
        Estimate {
            value,
            interval: (low.is_finite() && high.is_finite()).then_some((low, high)),
            experiments: self.n as usize,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(found: f64, wanted: f64) {
        assert!((found - wanted).abs() < 1e-9, "{found} instead of {wanted}");
    }

    /// Ratings of Shrout and Fleiss (1979); the values are those of pingouin 0.5, unrounded.
    #[test]
    fn intraclass_correlations_are_those_of_an_independent_program() {
        let ratings = [
            [9.0, 2.0, 5.0, 8.0],
            [6.0, 1.0, 3.0, 2.0],
            [8.0, 4.0, 6.0, 8.0],
            [7.0, 1.0, 2.0, 6.0],
            [10.0, 5.0, 6.0, 9.0],
            [6.0, 2.0, 4.0, 7.0],
        ];
        let retest = Retest::of(&ratings.map(Vec::from)).unwrap();
        close(retest.agreement.value, 0.289_763_779_527_559_16);
        close(
            retest.agreement.interval.unwrap().0,
            0.018_786_513_374_712_06,
        );
        close(
            retest.agreement.interval.unwrap().1,
            0.761_084_369_648_952_7,
        );
        close(retest.consistency.value, 0.714_840_714_840_715_4);
        close(
            retest.consistency.interval.unwrap().0,
            0.342_464_765_033_926_14,
        );
        close(
            retest.consistency.interval.unwrap().1,
            0.945_858_259_955_359_7,
        );
        let grips = [
            [77.1, 79.4],
            [102.5, 98.0],
            [64.2, 66.9],
            [88.8, 85.1],
            [120.3, 118.8],
            [71.7, 75.5],
            [95.0, 93.2],
        ];
        let retest = Retest::of(&grips.map(Vec::from)).unwrap();
        close(retest.agreement.value, 0.985_772_137_226_969_2);
        close(
            retest.agreement.interval.unwrap().0,
            0.921_580_165_900_008_8,
        );
        close(
            retest.agreement.interval.unwrap().1,
            0.997_532_219_620_709_4,
        );
        close(retest.difference.mean.value, -0.385_714_285_714_284_07);
        close(retest.difference.deviation, 3.301_731_147_660_054_6);
        // Without a shift between sessions their error is the differences' over √2, and the change that shows is 1.96 of these.
        let error = retest.difference.deviation / 2f64.sqrt();
        assert!(
            (retest.standard_error / error - 1.0).abs() < 0.1,
            "{retest:?}"
        );
        close(
            retest.detectable_change / retest.standard_error,
            1.959_963_984_540_054 * 2f64.sqrt(),
        );
    }

    /// Intervals cover what they say: of 2,000 studies of 12 persons about 95 %.
    #[test]
    fn intervals_hold_what_they_say_how_often() {
        use rand::{Rng, SeedableRng};
        let random = &mut rand_chacha::ChaCha8Rng::seed_from_u64(7);
        let mut normal = || -> f64 {
            let uniform = || (random.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
            let twelve: Vec<f64> = std::iter::repeat_with(uniform).take(12).collect();
            twelve.iter().sum::<f64>() - 6.0
        };
        let (persons, error) = (20.0, 6.0);
        let truth = persons * persons / (persons * persons + error * error);
        let mut held = [0; 3];
        let studies = 2000;
        for _ in 0..studies {
            let row = |_| {
                let strength = persons * normal();
                vec![strength + error * normal(), strength + error * normal()]
            };
            let values: Vec<Vec<f64>> = (0..12).map(row).collect();
            let retest = Retest::of(&values).unwrap();
            let holds = |estimate: Estimate, truth: f64| {
                let (low, high) = estimate.interval.unwrap();
                usize::from((low..=high).contains(&truth))
            };
            held[0] += holds(retest.agreement, truth);
            held[1] += holds(retest.difference.mean, 0.0);
            held[2] += holds(retest.difference.limits[1], 1.96 * error * 2f64.sqrt());
        }
        for (held, (low, high)) in
            held.into_iter()
                .zip([(0.93, 0.98), (0.935, 0.965), (0.91, 0.965)])
        {
            let share = held as f64 / f64::from(studies);
            assert!((low..=high).contains(&share), "{share}");
        }
    }

    #[test]
    fn what_cannot_be_told_is_not() {
        assert_eq!(Retest::of(&[]), None);
        assert_eq!(Retest::of(&[vec![1.0, 2.0], vec![3.0, 4.0]]), None);
        assert_eq!(Retest::of(&[vec![1.0], vec![3.0], vec![2.0]]), None);
        assert_eq!(
            Retest::of(&[vec![1.0, 2.0], vec![3.0], vec![2.0, 2.0]]),
            None
        );
        assert_eq!(
            Retest::of(&[vec![1.0, 1.0], vec![1.0, 1.0], vec![1.0, 1.0]]),
            None
        );
        let same = Retest::of(&[vec![1.0, 1.0], vec![2.0, 2.0], vec![3.0, 3.0]]).unwrap();
        close(same.agreement.value, 1.0);
        assert!(same.standard_error < 1e-9);
    }
}
