//! What an unloaded taxel conducts: by frames of the empty sensor, else by the unloaded taxels of the others.

use super::frames::{Solved, counts};
use crate::Mark;
use crate::stats::{mean, median, robust_deviation};

/// A taxel is unloaded within so many of the deviations that those below the most frequent value have,
const NEAR: f64 = 3.0;
/// and where no neighbour is above so many.
const LOADED: f64 = 4.0;
/// Fewest unloaded taxels that tell, and the least share of a frame.
const LEAST: usize = 20;
const LEAST_SHARE: f64 = 0.1;
/// Turns in which the middle and its deviation settle.
const TURNS: usize = 5;
/// The standard error of a median over that of a mean, of a normal distribution.
const MEDIAN: f64 = 1.2533;

/// What told it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ToldBy {
    /// Frames of a total of 0.
    Empty,
    /// Unloaded taxels of loaded frames.
    Others,
    /// Nothing: that of the sensor file, or 0 S.
    Nothing,
}

/// The conductance of an unloaded taxel, siemens.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Unloaded {
    pub(super) siemens: f64,
    /// Standard error, siemens; infinite where one frame alone tells it.
    pub(super) standard_error: f64,
    pub(super) told_by: ToldBy,
}

impl Unloaded {
    /// By some frames. `otherwise`: what the sensor file says, siemens.
    pub(super) fn of(frames: &[&Solved], otherwise: f64) -> Self {
        let empty: Vec<f64> = frames.iter().filter_map(|frame| of_empty(frame)).collect();
        if !empty.is_empty() {
            return Self::middle(&empty, ToldBy::Empty);
        }
        let others: Vec<f64> = frames.iter().filter_map(|frame| of_loaded(frame)).collect();
        if others.is_empty() {
            return Self {
                siemens: otherwise,
                standard_error: f64::INFINITY,
                told_by: ToldBy::Nothing,
            };
        }
        Self::middle(&others, ToldBy::Others)
    }

    fn middle(each: &[f64], told_by: ToldBy) -> Self {
        let siemens = median(each.iter().copied()).unwrap_or(0.0);
        let spread = robust_deviation(each.iter().map(|g| g - siemens));
        let standard_error = if each.len() > 1 {
            MEDIAN * spread / (each.len() as f64).sqrt()
        } else {
            f64::INFINITY
        };
        Self {
            siemens,
            standard_error,
            told_by,
        }
    }
}

/// The mean over the taxels of an empty sensor: a sum is what is to be right.
pub(super) fn of_empty(frame: &Solved) -> Option<f64> {
    let each = frame.siemens.values().iter().zip(frame.siemens.marks());
    let measured = each.filter(|(_, mark)| **mark == Mark::Good);
    mean(measured.map(|(g, _)| *g)).filter(|_| frame.load_g == 0.0)
}

/// The mean over the taxels of a loaded frame that carry nothing, if enough of them do: those about the most frequent
/// conductance, with no heavier neighbour.
pub(super) fn of_loaded(frame: &Solved) -> Option<f64> {
    let (values, marks) = (frame.siemens.values(), frame.siemens.marks());
    let there = (0..values.len()).filter(|&t| counts(marks[t]));
    let mut sorted: Vec<f64> = there.clone().map(|t| values[t]).collect();
    sorted.sort_by(f64::total_cmp);
    let mut middle = most_frequent(&sorted)?;
    for _ in 0..TURNS {
        let below = sorted.iter().filter(|g| **g < middle).map(|g| g - middle);
        // A converter's steps leave many readings the same.
        let deviation = robust_deviation(below).max(frame.noise_siemens);
        let columns = frame.siemens.columns();
        let is_heavy = |t: usize| counts(marks[t]) && values[t] > middle + LOADED * deviation;
        let unloaded: Vec<f64> = there
            .clone()
            .filter(|&t| (values[t] - middle).abs() <= NEAR * deviation)
            .filter(|&t| !around(t, columns, values.len()).any(is_heavy))
            .map(|t| values[t])
            .collect();
        if unloaded.len() < LEAST || (unloaded.len() as f64) < LEAST_SHARE * sorted.len() as f64 {
            return None;
        }
        middle = mean(unloaded)?;
    }
    Some(middle)
}

/// The eight neighbours of a taxel.
fn around(taxel: usize, columns: usize, taxels: usize) -> impl Iterator<Item = usize> {
    let (row, column) = (taxel / columns, taxel % columns);
    let rows = row.saturating_sub(1)..(row + 2).min(taxels / columns);
    rows.flat_map(move |r| {
        (column.saturating_sub(1)..(column + 2).min(columns)).map(move |c| r * columns + c)
    })
    .filter(move |&other| other != taxel)
}

/// The middle of the shortest stretch that holds half of what the last held, down to a few values (half-sample mode: Robertson
/// and Cryer, *JASA* 69:1012, 1974).
fn most_frequent(sorted: &[f64]) -> Option<f64> {
    let mut part = sorted;
    while part.len() > 2 * LEAST {
        let half = part.len().div_ceil(2);
        let width = |from: &usize| part[from + half - 1] - part[*from];
        let from = (0..=part.len() - half).min_by(|a, b| width(a).total_cmp(&width(b)))?;
        part = &part[from..from + half];
    }
    median(part.iter().copied())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Frame;
    use crate::circuit::normal;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    fn frame(values: Vec<f64>, load_g: f64) -> Solved {
        Solved {
            total: 0,
            load_g,
            siemens: Frame::new(16, 16, values).unwrap(),
            noise_siemens: 0.0,
            lost: 0,
        }
    }

    #[test]
    fn unloaded_taxels_of_a_loaded_frame_say_what_the_empty_sensor_says() {
        for seed in 1..=3 {
            let mut random = ChaCha8Rng::seed_from_u64(seed);
            let drawn = |loaded: f64, random: &mut ChaCha8Rng| -> Vec<f64> {
                let of = |t: usize| (-((t / 16) as f64 - 8.0).powi(2) / 2.0).exp() * loaded;
                (0..256)
                    .map(|t| 1e-6 + of(t) + 2e-7 * normal(random))
                    .collect()
            };
            let frames: Vec<Solved> = (0..10)
                .map(|_| frame(drawn(1e-4, &mut random), 100.0))
                .collect();
            let all: Vec<&Solved> = frames.iter().collect();
            let found = Unloaded::of(&all, 0.0);
            assert_eq!(found.told_by, ToldBy::Others);
            assert!((found.siemens - 1e-6).abs() < 5e-8, "{found:?}");
            let empty = frame(drawn(0.0, &mut random), 0.0);
            let found = Unloaded::of(&[&empty, &frames[0]], 0.0);
            assert_eq!(found.told_by, ToldBy::Empty);
            assert!((found.siemens - 1e-6).abs() < 5e-8, "{found:?}");
        }
    }

    #[test]
    fn an_array_that_is_pressed_all_over_tells_nothing() {
        let mut random = ChaCha8Rng::seed_from_u64(1);
        let pressed: Vec<f64> = (0..256)
            .map(|t| 1e-5 * f64::from(t) * (1.0 + 0.1 * normal(&mut random)))
            .collect();
        let frames = [frame(pressed, 500.0)];
        let all: Vec<&Solved> = frames.iter().collect();
        let found = Unloaded::of(&all, 3e-6);
        // A ramp has no most frequent value: whatever is found has few taxels about it.
        assert!(
            found.told_by == ToldBy::Nothing || found.standard_error.is_infinite(),
            "{found:?}"
        );
    }
}
