//! Does it matter how long the load has been there?

use super::power::golden;
use crate::stats::{Bootstrap, Estimate, Line, mean, standard_deviation};

/// A reading and when it was taken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimedReading {
    /// Seconds.
    pub secs: f64,
    /// In any unit.
    pub value: f64,
}

/// A constant and what creeps: value = start + Σ aᵢ·(1 − e^(−t/τᵢ)), t from the first reading.
#[derive(Debug, Clone, PartialEq)]
pub struct Exponentials {
    /// Value at the first reading, by the fit.
    pub start: f64,
    /// aᵢ, in the unit of the values, and τᵢ, seconds, ascending.
    pub terms: Vec<(f64, f64)>,
    /// Root of the mean square of what is left.
    pub residual: f64,
}

impl Exponentials {
    /// The fit's value `secs` after the first reading.
    pub fn at(&self, secs: f64) -> f64 {
        let each = self
            .terms
            .iter()
            .map(|(a, tau)| a * (1.0 - (-secs / tau).exp()));
        self.start + each.sum::<f64>()
    }
}

/// value = start + rise · ln(1 + t/1 s), t from the first reading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Logarithm {
    /// Value at the first reading, by the fit.
    pub start: f64,
    /// Per unit of the logarithm.
    pub rise: f64,
    /// Root of the mean square of what is left.
    pub residual: f64,
}

/// What holds of a constant load say.
#[derive(Debug, Clone, PartialEq)]
pub struct Creep {
    /// Holds.
    pub holds: usize,
    /// Mean length of a hold, seconds.
    pub secs: f64,
    /// Change over the hold, from its first tenth to its last, in % of the first; mean over holds.
    pub percent: Estimate,
    /// Slope of the last half of a hold, % of its mean an hour; mean over holds of a minute or more, `None` without any: what
    /// seconds do says nothing of an hour.
    pub drift_percent_per_hour: Option<Estimate>,
    /// Exponentials through each hold; of two where they leave clearly less than one.
    pub exponentials: Vec<Exponentials>,
    /// The logarithm through each hold.
    pub logarithms: Vec<Logarithm>,
}

/// The shortest time that says something of drift, seconds.
pub const MIN_DRIFT_SECS: f64 = 60.0;
/// The fewest readings of a hold that counts.
pub const MIN_READINGS: usize = 10;
/// Time constants looked at within the hold.
const TAUS: usize = 40;
/// Two exponentials must leave less than this share of what one leaves.
const CLEARLY_LESS: f64 = 0.9;

/// Judges holds of constant loads; those with fewer than ten readings do not count. `None` without any.
pub fn creep(holds: &[Vec<TimedReading>], bootstrap: &Bootstrap) -> Option<Creep> {
    let holds: Vec<&Vec<TimedReading>> = holds
        .iter()
        .filter(|hold| hold.len() >= MIN_READINGS)
        .collect();
    let each = |figure: fn(&[TimedReading]) -> Option<f64>| -> Vec<Vec<f64>> {
        holds
            .iter()
            .filter_map(|hold| Some(vec![figure(hold)?]))
            .collect()
    };
    let estimate = |figure| bootstrap.estimate(&each(figure), |some| mean(some.iter().copied()));
    Some(Creep {
        holds: holds.len(),
        secs: mean(holds.iter().filter_map(|hold| length(hold)))?,
        percent: estimate(percent)?,
        drift_percent_per_hour: estimate(drift),
        exponentials: holds.iter().filter_map(|hold| exponentials(hold)).collect(),
        logarithms: holds.iter().filter_map(|hold| logarithm(hold)).collect(),
    })
}

fn length(hold: &[TimedReading]) -> Option<f64> {
    Some(hold.last()?.secs - hold.first()?.secs).filter(|secs| *secs > 0.0)
}

fn percent(hold: &[TimedReading]) -> Option<f64> {
    let tenth = hold.len().div_ceil(10);
    let first = mean(hold[..tenth].iter().map(|r| r.value))?;
    let last = mean(hold[hold.len() - tenth..].iter().map(|r| r.value))?;
    (first != 0.0).then(|| 100.0 * (last - first) / first.abs())
}

fn drift(hold: &[TimedReading]) -> Option<f64> {
    length(hold).filter(|secs| *secs >= MIN_DRIFT_SECS)?;
    let half: Vec<_> = hold[hold.len() / 2..]
        .iter()
        .map(|r| (r.secs, r.value))
        .collect();
    let centre = mean(half.iter().map(|p| p.1))?;
    let line = Line::fit(&half)?;
    (centre != 0.0).then(|| 100.0 * 3600.0 * line.slope / centre.abs())
}

fn logarithm(hold: &[TimedReading]) -> Option<Logarithm> {
    let first = hold.first()?.secs;
    let points: Vec<_> = hold
        .iter()
        .map(|r| ((1.0 + r.secs - first).ln(), r.value))
        .collect();
    let line = Line::fit(&points)?;
    Some(Logarithm {
        start: line.offset,
        rise: line.slope,
        residual: root_mean_square(points.iter().map(|p| p.1 - line.at(p.0)))?,
    })
}

/// One exponential, or two: every pair of time constants of a geometric row between two readings' distance and the
/// hold's length, with the amplitudes by least squares.
fn exponentials(hold: &[TimedReading]) -> Option<Exponentials> {
    let secs = length(hold)?;
    let least = (secs / (hold.len() - 1) as f64).max(1e-3 * secs);
    let taus: Vec<f64> = (0..TAUS)
        .map(|i| least * (secs / least).powf(i as f64 / (TAUS - 1) as f64))
        .collect();
    let better = |a: &Exponentials, b: &Exponentials| a.residual.total_cmp(&b.residual);
    let one = taus
        .iter()
        .filter_map(|&tau| with(hold, &[tau]))
        .min_by(better)?;
    // Between the steps of the row: what a coarse time constant leaves would be taken for a second term.
    let ratio = (secs / least).ln() / (TAUS - 1) as f64;
    let cost = |log: f64| with(hold, &[log.exp()]).map_or(f64::INFINITY, |fit| fit.residual);
    let near = one.terms[0].1.ln();
    let one = with(hold, &[golden(cost, near - ratio, near + ratio).exp()]).unwrap_or(one);
    let pairs = (0..TAUS).flat_map(|i| (i + 3..TAUS).map(move |j| (i, j)));
    let two = pairs
        .filter_map(|(i, j)| with(hold, &[taus[i], taus[j]]))
        .min_by(better);
    let values: Vec<f64> = hold.iter().map(|r| r.value).collect();
    // Where nothing is left, nothing can be told apart.
    let nothing = 1e-9 * standard_deviation(&values)?;
    Some(match two {
        Some(two) if one.residual > nothing && two.residual < CLEARLY_LESS * one.residual => two,
        _ => one,
    })
}

/// Amplitudes for given time constants: normal equations of at most three unknowns.
fn with(hold: &[TimedReading], taus: &[f64]) -> Option<Exponentials> {
    let first = hold.first()?.secs;
    let n = taus.len() + 1;
    let mut normal = [[0.0; 4]; 3];
    let row = |reading: &TimedReading| {
        let mut row = [1.0, 0.0, 0.0];
        for (cell, tau) in row[1..].iter_mut().zip(taus) {
            *cell = 1.0 - (-(reading.secs - first) / tau).exp();
        }
        row
    };
    for reading in hold {
        let row = row(reading);
        for i in 0..n {
            for j in 0..n {
                normal[i][j] += row[i] * row[j];
            }
            normal[i][3] += row[i] * reading.value;
        }
    }
    let answer = solve(&mut normal, n)?;
    let fit = |reading: &TimedReading| {
        let row = row(reading);
        (0..n).map(|i| row[i] * answer[i]).sum::<f64>()
    };
    Some(Exponentials {
        start: answer[0],
        terms: taus
            .iter()
            .enumerate()
            .map(|(i, &tau)| (answer[i + 1], tau))
            .collect(),
        residual: root_mean_square(hold.iter().map(|r| r.value - fit(r)))?,
    })
}

/// Gauss with pivots; `None` where the unknowns cannot be told apart.
fn solve(rows: &mut [[f64; 4]; 3], n: usize) -> Option<[f64; 3]> {
    for i in 0..n {
        let pivot = (i..n).max_by(|&a, &b| rows[a][i].abs().total_cmp(&rows[b][i].abs()))?;
        rows.swap(i, pivot);
        if rows[i][i].abs() < 1e-9 * rows[0][0].abs() {
            return None;
        }
        let top = rows[i];
        for (j, row) in rows.iter_mut().enumerate().take(n) {
            if j != i {
                let share = row[i] / top[i];
                for (cell, above) in row.iter_mut().zip(top) {
                    *cell -= share * above;
                }
            }
        }
    }
    let mut out = [0.0; 3];
    for i in 0..n {
        out[i] = rows[i][3] / rows[i][i];
    }
    Some(out)
}

fn root_mean_square(values: impl Iterator<Item = f64>) -> Option<f64> {
    mean(values.map(|value| value * value)).map(f64::sqrt)
}
