//! Noise of a reading: from frames that are alike, the same even load frame after frame, or from frames of presses by what a fit
//! leaves of taxels without load. By themselves frames of presses tell the ghosts of other loads with it where lines are left open.

use super::evidence::Evidence;
use super::inverter::{Inverter, Job};
use super::least_squares::robust_deviation;
use super::outcome::Outcome;
use crate::circuit::ROUNDING_COUNTS;
use crate::screen::Level;
use crate::uncertainty::StandardErrors;
use crate::{Counts, Frame, Mark};

/// Differences needed.
const MIN_DIFFERENCES: usize = 200;
/// Share of the differences that counts: the largest may be a line that flickers or a reading that sticks.
const KEPT: f64 = 0.98;
/// Standard deviation of a normal number over that of its part within that share.
const OF_WHOLE: f64 = 1.070;
/// Frames of presses that are looked at.
const MAX_FRAMES: usize = 32;
/// Standard deviations from nothing up to which a taxel may carry nothing; told by those that do.
const NEAR: f64 = 4.0;
/// Times that those farther off are left out.
const ROUNDS: usize = 3;
/// The least noise that a converter has, counts.
pub(super) const LEAST: f64 = 0.3;

/// Standard deviation of a reading without its rounding, counts, by frames of even loads (grams) in the order in which they
/// were taken; `None` where too few follow one of the same load with the same lines out.
pub(super) fn by_alike_frames(uniform: &[(Frame<Counts>, f64)], max_count: f64) -> Option<f64> {
    // Laid on again, a load lies elsewhere: only frames of one stretch are alike. And where lines are left open, one that is
    // out moves every other reading.
    let mut stretches: Vec<(&Frame<Counts>, usize, Vec<usize>)> = Vec::new();
    let mut before = (f64::NAN, 0);
    for (frame, load) in uniform {
        before = (*load, before.1 + usize::from(*load != before.0));
        stretches.push((frame, before.1, out(frame)));
    }
    stretches.sort_by(|a, b| (a.1, &a.2).cmp(&(b.1, &b.2)));
    let is_alike = |pair: &&[(&Frame<Counts>, usize, Vec<usize>)]| {
        (pair[0].1, &pair[0].2) == (pair[1].1, &pair[1].2)
    };
    let alike = stretches.windows(2).filter(is_alike);
    let is_told = |frame: &Frame<Counts>, at: usize| {
        let count = frame.values()[at];
        frame.marks()[at] == Mark::Good && count > 0.0 && count < max_count
    };
    let mut squares: Vec<f64> = alike
        .flat_map(|pair| {
            let (before, now) = (pair[0].0, pair[1].0);
            let taxels =
                (0..now.values().len()).filter(|&at| is_told(before, at) && is_told(now, at));
            taxels.map(|at| (now.values()[at] - before.values()[at]).powi(2))
        })
        .collect();
    if squares.len() < MIN_DIFFERENCES {
        return None;
    }
    squares.sort_unstable_by(f64::total_cmp);
    squares.truncate((KEPT * squares.len() as f64) as usize);
    let mean = squares.iter().sum::<f64>() / squares.len() as f64;
    Some(without_rounding((0.5 * mean).sqrt() * OF_WHOLE))
}

/// The same by frames of presses: how far taxels that carry nothing conduct something else than such ones do, by a fit of circuit
/// and law, beside how far noise moves them there. `None` where too few frames have a solution.
pub(super) fn by_unloaded(evidence: &Evidence, fit: &Outcome) -> Option<f64> {
    let sensor = &fit.model.sensor;
    let thought = evidence.noise_counts.hypot(ROUNDING_COUNTS);
    let level = Level {
        baseline_counts: 0.0,
        noise_counts: thought,
    };
    let mut errors = StandardErrors::new(sensor, Some(level)).ok()?;
    let stride = evidence.frames.len().div_ceil(MAX_FRAMES);
    let all = 0..evidence.frames.len();
    let mut jobs: Vec<Job> = all.step_by(stride).map(|i| (i, None)).collect();
    let far = Inverter::new(evidence, sensor)?.invert_each(&mut jobs, |i, siemens| {
        let marks = evidence.frames[i].marks();
        let mut own = marks.to_vec();
        let errors = errors.of_siemens(siemens, true, &mut own);
        let taxels = siemens.values().iter().zip(errors.values()).zip(marks);
        let good = taxels
            .enumerate()
            .filter(|(_, (_, mark))| **mark == Mark::Good);
        let far = good.map(|(at, ((siemens, error), _))| {
            (siemens - fit.law.siemens_from_grams(at, 0.0)).abs() / error
        });
        far.filter(|far| far.is_finite()).collect::<Vec<f64>>()
    });
    let mut far: Vec<f64> = far.into_iter().flatten().flatten().collect();
    for _ in 0..ROUNDS {
        let reach = NEAR * robust_deviation(&far);
        far.retain(|far| *far <= reach);
    }
    if far.len() < MIN_DIFFERENCES {
        return None;
    }
    Some(without_rounding(robust_deviation(&far) * thought).max(LEAST))
}

/// The part of a standard deviation of readings that is not rounding, counts.
pub(super) fn without_rounding(deviation: f64) -> f64 {
    (deviation * deviation - ROUNDING_COUNTS * ROUNDING_COUNTS)
        .max(0.0)
        .sqrt()
}

/// Taxels whose lines are out.
fn out(frame: &Frame<Counts>) -> Vec<usize> {
    let marks = frame.marks().iter().enumerate();
    let out = marks.filter(|(_, mark)| mark.is_out());
    out.map(|(taxel, _)| taxel).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    #[test]
    fn frames_of_one_load_tell_the_noise_whatever_the_loads_are() {
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(5);
        for sigma in [0.5, 2.0] {
            // Twelve even numbers make a normal one.
            let mut noise = || sigma * ((0..12).map(|_| random.random::<f64>()).sum::<f64>() - 6.0);
            let mut frame = |load: f64| {
                let values = (0..256).map(|at| (3.0 * load + f64::from(at) + noise()).round());
                (Frame::new(16, 16, values.collect()).unwrap(), load)
            };
            let loads = [50.0, 50.0, 50.0, 150.0, 150.0, 150.0, 50.0];
            let frames: Vec<_> = loads.into_iter().map(&mut frame).collect();
            let found = by_alike_frames(&frames, 1e4).unwrap();
            assert!((found / sigma - 1.0).abs() < 0.1, "{found} for {sigma}");
            let apart: Vec<_> = [50.0, 150.0, 300.0, 50.0]
                .into_iter()
                .map(&mut frame)
                .collect();
            assert_eq!(by_alike_frames(&apart, 1e4), None);
            // In every other frame a column is out, and all others read more.
            let shifted: Vec<_> = (0..6)
                .map(|turn| {
                    let (mut counts, load) = frame(100.0);
                    if turn % 2 == 1 {
                        counts
                            .values_mut()
                            .iter_mut()
                            .for_each(|count| *count += 20.0);
                        (0..16).for_each(|row| counts.marks_mut()[16 * row + 3] = Mark::Flickering);
                    }
                    (counts, load)
                })
                .collect();
            let found = by_alike_frames(&shifted, 1e4).unwrap();
            assert!((found / sigma - 1.0).abs() < 0.1, "{found} for {sigma}");
        }
    }
}
