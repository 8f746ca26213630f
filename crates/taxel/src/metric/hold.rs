//! A force over time: where someone presses, how fast the force comes, how long it stands, and how it tires.

use std::ops::Range;

use crate::stats::{Line, mean, standard_deviation};

/// What counts as a hold.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct HoldOptions {
    /// A hold begins where the force rises above this, and ends where it falls below, newtons; `None`: a tenth of the largest
    /// force.
    pub threshold_newtons: Option<f64>,
    /// Length of the plateau, seconds. Of a hold of less than 8 s it is five eighths of the time above half of the peak.
    pub plateau_secs: f64,
    /// The shortest hold, seconds.
    pub min_secs: f64,
    /// A gap in a hold that is no end of it, seconds.
    pub max_gap_secs: f64,
}

impl Default for HoldOptions {
    /// Plateau of 5 s, as in an 8 s grip; holds of half a second or more, with gaps below 0.3 s.
    fn default() -> Self {
        Self {
            threshold_newtons: None,
            plateau_secs: 5.0,
            min_secs: 0.5,
            max_gap_secs: 0.3,
        }
    }
}

/// Where a force stands.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Plateau {
    /// Its first value,
    pub first: usize,
    /// and its last.
    pub last: usize,
    /// Mean force, newtons.
    pub mean: f64,
    /// Coefficient of variation: standard deviation over mean.
    pub variation: f64,
    /// Slope of the straight line through it, newtons a second: below 0 where the force tires.
    pub slope_per_sec: f64,
}

impl Plateau {
    /// Of all values of a force, one a second of `secs`; NaN of what they do not tell.
    pub fn of(secs: &[f64], newtons: &[f64]) -> Self {
        let middle = mean(newtons.iter().copied()).unwrap_or(f64::NAN);
        let points = secs.iter().zip(newtons);
        let points: Vec<(f64, f64)> = points.map(|(t, f)| (t - secs[0], *f)).collect();
        Self {
            first: 0,
            last: newtons.len().saturating_sub(1),
            mean: middle,
            variation: standard_deviation(newtons).unwrap_or(f64::NAN) / middle,
            slope_per_sec: Line::fit(&points).map_or(f64::NAN, |line| line.slope),
        }
    }
}

/// One hold of a force.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Hold {
    /// Place of its largest value.
    pub peak: usize,
    /// The largest force, newtons.
    pub peak_newtons: f64,
    /// From its beginning to its largest value, seconds.
    pub time_to_peak_secs: f64,
    /// Force over time, newton seconds, by the trapezoidal rule.
    pub impulse: f64,
    /// Mean rate from 10 to 90 % of the peak, newtons a second; `None` where the force is there from the beginning.
    pub loading_rate: Option<f64>,
}

/// The fewest values of a plateau.
pub const MIN_PLATEAU: usize = 5;
/// A hold as long as it is above this share of the peak; a plateau is no longer than [`PLATEAU_SHARE`] of that.
const HALF: f64 = 0.5;
const PLATEAU_SHARE: f64 = 0.625;
/// The largest force has to be this many times its error, else there is no hold.
const MIN_ERRORS: f64 = 3.0;

/// The holds of a force: ranges of values, in order. `secs` ascends, one a value; `half_width` is that of the 95 % interval of
/// the largest force (0 where nothing is known of it), below three of which nothing is held.
pub fn holds(
    secs: &[f64],
    newtons: &[f64],
    half_width: f64,
    options: &HoldOptions,
) -> Vec<Range<usize>> {
    let largest = newtons.iter().copied().fold(0.0, f64::max);
    let threshold = options.threshold_newtons.unwrap_or(0.1 * largest);
    if largest <= threshold || largest <= MIN_ERRORS * half_width {
        return Vec::new();
    }
    let mut found: Vec<Range<usize>> = Vec::new();
    for (at, force) in newtons.iter().enumerate() {
        if *force <= threshold {
            continue;
        }
        match found.last_mut() {
            Some(last) if secs[at] - secs[last.end - 1] <= options.max_gap_secs => {
                last.end = at + 1;
            }
            // Frames may be farther apart than a gap.
            Some(last) if last.end == at => last.end = at + 1,
            _ => found.push(at..at + 1),
        }
    }
    found.retain(|hold| secs[hold.end - 1] - secs[hold.start] >= options.min_secs);
    found
}

/// What one hold amounts to, of which these are all values.
///
/// # Panics
/// When there are none, or not as many times as forces.
pub fn hold(secs: &[f64], newtons: &[f64]) -> Hold {
    let larger = |a: usize, b: usize| if newtons[b] > newtons[a] { b } else { a };
    let peak = (0..newtons.len())
        .reduce(larger)
        .expect("a hold has values");
    Hold {
        peak,
        peak_newtons: newtons[peak],
        time_to_peak_secs: secs[peak] - secs[0],
        impulse: impulse(secs, newtons),
        loading_rate: loading_rate(&secs[..=peak], &newtons[..=peak]),
    }
}

/// Force over time, newton seconds, by the trapezoidal rule.
pub fn impulse(secs: &[f64], newtons: &[f64]) -> f64 {
    let pairs = secs.windows(2).zip(newtons.windows(2));
    pairs
        .map(|(t, f)| (t[1] - t[0]) * (f[0] + f[1]) / 2.0)
        .sum()
}

/// Up to the peak, which is the last value.
fn loading_rate(secs: &[f64], newtons: &[f64]) -> Option<f64> {
    let peak = *newtons.last().filter(|peak| **peak > 0.0)?;
    // The last crossings before the peak, at their place between two values.
    let crossing = |level: f64| -> Option<f64> {
        let below = newtons.iter().rposition(|force| *force <= level)?;
        let share = (level - newtons[below]) / (newtons[below + 1] - newtons[below]);
        Some(secs[below] + share * (secs[below + 1] - secs[below]))
    };
    let (low, high) = (0.1 * peak, 0.9 * peak);
    let began = crossing(low).or_else(|| {
        // A hold begins at its threshold, mostly just above a tenth.
        (newtons[0] <= 0.2 * peak).then_some(secs[0])
    })?;
    let from = if crossing(low).is_some() {
        low
    } else {
        newtons[0]
    };
    let took = crossing(high)? - began;
    (took > 0.0).then(|| (high - from) / took)
}

/// Where a force stands over a hold: the window of a length whose mean is largest. `None` of fewer than [`MIN_PLATEAU`] values.
pub fn plateau(secs: &[f64], newtons: &[f64], options: &HoldOptions) -> Option<Plateau> {
    let peak = newtons.iter().copied().reduce(f64::max)?;
    let above = |force: &f64| *force >= HALF * peak;
    let first = newtons.iter().position(above)?;
    let last = newtons.iter().rposition(above)?;
    let length = options
        .plateau_secs
        .min(PLATEAU_SHARE * (secs[last] - secs[first]));
    let (mut best, mut end, mut sum) = (None::<(f64, usize, usize)>, first, 0.0);
    // A clock that counts in small steps is not taken at its last digit.
    let slack = 1e-6 * length;
    for begin in first..=last {
        while end <= last && secs[end] - secs[begin] <= length + slack {
            sum += newtons[end];
            end += 1;
        }
        let reaches = secs[last] - secs[begin] >= length - slack;
        let mean = sum / (end - begin) as f64;
        if reaches && best.is_none_or(|best| mean > best.0) {
            best = Some((mean, begin, end - 1));
        }
        sum -= newtons[begin];
    }
    let (_, first, last) = best?;
    (last - first + 1 >= MIN_PLATEAU).then(|| Plateau {
        first,
        last,
        ..Plateau::of(&secs[first..=last], &newtons[first..=last])
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 100 values a second: nothing, half a second up to `top`, falling by `tires` a second for 8 s, gone at once.
    fn grip(top: f64, tires: f64) -> (Vec<f64>, Vec<f64>) {
        let secs: Vec<f64> = (0..1200).map(|i| f64::from(i) / 100.0).collect();
        let force = |t: &f64| match t - 1.0 {
            before if before < 0.0 => 0.0,
            rise if rise < 0.5 => top * rise / 0.5,
            held if held < 8.5 => top - tires * (held - 0.5),
            _ => 0.0,
        };
        let newtons = secs.iter().map(force).collect();
        (secs, newtons)
    }

    #[test]
    fn a_grip_by_hand() {
        let (secs, newtons) = grip(400.0, 4.0);
        let options = HoldOptions::default();
        let found = holds(&secs, &newtons, 1.0, &options);
        assert_eq!(found.len(), 1);
        let range = found[0].clone();
        let (secs, newtons) = (&secs[range.clone()], &newtons[range.clone()]);
        let hold = hold(secs, newtons);
        assert!((hold.peak_newtons - 400.0).abs() < 1e-9 && range.start + hold.peak == 150);
        // A tenth is passed 0.05 s after the beginning of the rise.
        assert!((hold.time_to_peak_secs - 0.45).abs() < 0.011);
        assert!((hold.loading_rate.unwrap() - 800.0).abs() < 1e-6);
        // The triangle without its first tenth, and 8 s falling to 368 N.
        let expected = 0.5 * 0.5 * 400.0 - 0.5 * 0.05 * 40.0 + 8.0 * 384.0;
        assert!(
            (hold.impulse / expected - 1.0).abs() < 2e-3,
            "{}",
            hold.impulse
        );
        let plateau = plateau(secs, newtons, &options).unwrap();
        // Where the force is largest: the first 5 s, though with some of the rise its mean may be as large.
        assert!((secs[plateau.last] - secs[plateau.first] - 5.0).abs() < 1e-6);
        assert!((plateau.mean - 390.0).abs() < 0.1);
        assert!((plateau.slope_per_sec + 4.0).abs() < 0.1, "{plateau:?}");
        assert!((plateau.variation - 20.0 / 12f64.sqrt() / 390.0).abs() < 1e-3);
    }

    #[test]
    fn three_trials_are_three_and_noise_is_none() {
        let (one, force) = grip(300.0, 0.0);
        let secs: Vec<f64> = (0..3600).map(|i| f64::from(i) / 100.0).collect();
        let three = [force.clone(), force.clone(), force.clone()].concat();
        let options = HoldOptions::default();
        assert_eq!(holds(&secs, &three, 2.0, &options).len(), 3);
        // A lost grip of a fifth of a second ends none; one of half a second does.
        let mut slip = force.clone();
        slip[500..520].fill(0.0);
        assert_eq!(holds(&one, &slip, 2.0, &options).len(), 1);
        slip[500..550].fill(0.0);
        assert_eq!(holds(&one, &slip, 2.0, &options).len(), 2);
        let noise: Vec<f64> = (0..1200)
            .map(|i| f64::from((i * 7919) % 13) / 13.0)
            .collect();
        assert_eq!(holds(&one, &noise, 0.5, &options), []);
        assert_eq!(holds(&[], &[], 0.0, &options), []);
    }

    #[test]
    fn a_short_hold_has_a_short_plateau_and_a_knock_none() {
        let secs: Vec<f64> = (0..100).map(|i| f64::from(i) / 50.0).collect();
        let newtons: Vec<f64> = (0..100)
            .map(|i| if (20..70).contains(&i) { 50.0 } else { 0.0 })
            .collect();
        let options = HoldOptions::default();
        let found = holds(&secs, &newtons, 0.1, &options);
        let range = found[0].clone();
        let held = hold(&secs[range.clone()], &newtons[range.clone()]);
        let steady = plateau(&secs[range.clone()], &newtons[range], &options).unwrap();
        let length = secs[steady.last] - secs[steady.first];
        assert!((0.58..0.62).contains(&length), "{length}");
        assert_eq!((steady.mean, steady.variation), (50.0, 0.0));
        // It was there from the first value on.
        assert_eq!(held.loading_rate, None);
        // Unloaded taxels read below nothing as often as above it.
        let unloaded = hold(&secs[..4], &[-0.3, -0.1, -0.2, -0.4]);
        assert_eq!((unloaded.peak, unloaded.loading_rate), (1, None));
        assert_eq!(plateau(&secs[..3], &[0.0, 9.0, 1.0], &options), None);
    }
}
