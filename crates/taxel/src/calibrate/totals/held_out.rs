//! Totals read by laws that were fitted without them.

use super::fit::{Fitted, run};
use super::frames::Solved;
use super::law::Member;
use crate::Sensor;
use crate::parallel::{Executor, par_map};
use crate::stats::mean;

/// Parts that totals are left out in, at most.
const MOST_FOLDS: usize = 40;

/// A held-out total.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Judged {
    /// The part that it was left out with.
    pub(super) fold: usize,
    pub(super) load_g: f64,
    /// What the law without its part reads, grams.
    pub(super) says_g: f64,
    /// What the mean of the other parts' totals is, grams.
    pub(super) guess_g: f64,
    /// Standard error by noise, grams.
    pub(super) noise_g: f64,
}

impl Judged {
    pub(super) fn error_g(&self) -> f64 {
        (self.says_g - self.load_g).abs()
    }

    pub(super) fn off(&self) -> f64 {
        self.says_g / self.load_g - 1.0
    }
}

/// What is left out together, and how that is said.
pub(super) struct Parts {
    /// Of each loaded frame, which part it is in.
    pub(super) of: Vec<usize>,
    pub(super) count: usize,
    pub(super) words: String,
}

/// Parts by the table's groups where it has any, else by load; of a single one, stretches of its frames. `group`: of each frame
/// that has one.
pub(super) fn parts(frames: &[&Solved], group: &[Option<&str>], blocks: usize) -> Parts {
    let has_groups = group.iter().any(Option::is_some);
    let key = |at: usize| match group[at] {
        Some(name) => (Some(name.to_owned()), 0),
        None => (None, frames[at].load_g.to_bits()),
    };
    let mut keys: Vec<_> = (0..frames.len()).map(key).collect();
    let each = keys.clone();
    keys.sort();
    keys.dedup();
    let (what, count) = if keys.len() > 1 {
        let what = if has_groups { "groups" } else { "loads" };
        (what, keys.len())
    } else {
        let count = blocks.min(frames.len());
        let of = (0..frames.len()).map(|at| at * count / frames.len());
        return Parts {
            of: of.collect(),
            count,
            words: format!("{count} stretches of frames, one after the other"),
        };
    };
    let folds = count.min(MOST_FOLDS);
    let of = each
        .iter()
        .map(|key| keys.partition_point(|k| k < key) % folds);
    let turns = if folds < count {
        format!("{count} {what} in {folds} parts")
    } else {
        format!("{count} {what}, one at a time")
    };
    Parts {
        of: of.collect(),
        count: folds,
        words: turns,
    }
}

/// What held-out totals say.
pub(super) struct HeldOut {
    pub(super) judged: Vec<Judged>,
    /// Totals whose fit failed.
    pub(super) unjudged: usize,
    /// ln factor and ln exponent without each part.
    pub(super) laws: Vec<[f64; 2]>,
}

/// Every part read by a fit without it. `frames`: the loaded ones, then those of no load, each with its standard error by noise.
pub(super) fn judge(
    sensor: &Sensor,
    frames: &[&Solved],
    noise_g: &[f64],
    parts: &Parts,
    executor: &dyn Executor,
) -> HeldOut {
    let loaded = parts.of.len();
    let one = |fold: usize| -> Option<(Vec<Judged>, usize, Option<[f64; 2]>)> {
        let is_kept = |at: &usize| parts.of.get(*at) != Some(&fold);
        let kept: Vec<usize> = (0..frames.len()).filter(is_kept).collect();
        let held: Vec<usize> = (0..loaded).filter(|at| !is_kept(at)).collect();
        let without: Vec<&Solved> = kept.iter().map(|&at| frames[at]).collect();
        let noise: Vec<f64> = kept.iter().map(|&at| noise_g[at]).collect();
        let others = kept.iter().filter(|at| **at < loaded);
        let guess = mean(others.map(|&at| frames[at].load_g));
        let (Some(guess_g), Some(fitted)) = (guess, run(sensor, &without, Some(&noise))) else {
            return Some((Vec::new(), held.len(), None));
        };
        let judged = held.iter().map(|&at| Judged {
            fold,
            load_g: frames[at].load_g,
            says_g: fitted.total_g(frames[at]),
            guess_g,
            noise_g: noise_g[at],
        });
        Some((judged.collect(), 0, Some(logarithms(&fitted))))
    };
    let folds = if parts.count > 1 { parts.count } else { 0 };
    let each = par_map(executor, (0..folds).collect(), one).unwrap_or_default();
    let mut found = HeldOut {
        judged: Vec::new(),
        unjudged: if folds == 0 { loaded } else { 0 },
        laws: Vec::new(),
    };
    for (judged, unjudged, law) in each {
        found.judged.extend(judged);
        found.unjudged += unjudged;
        found.laws.extend(law);
    }
    found
}

fn logarithms(fitted: &Fitted) -> [f64; 2] {
    let Member {
        factor, exponent, ..
    } = fitted.member();
    [factor.ln(), exponent.ln()]
}

/// Standard errors of ln factor and ln exponent over fits that each lack a part (jackknife): what all totals of a part are off by
/// together, the curvature takes for so many witnesses.
pub(super) fn jackknife(laws: &[[f64; 2]]) -> [f64; 2] {
    let folds = laws.len() as f64;
    [0, 1].map(|number| {
        let middle = mean(laws.iter().map(|law| law[number])).unwrap_or(0.0);
        let spread: f64 = laws.iter().map(|law| (law[number] - middle).powi(2)).sum();
        if laws.len() > 1 {
            (spread * (folds - 1.0) / folds).sqrt()
        } else {
            0.0
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Frame;

    fn of(loads: &[f64]) -> Vec<Solved> {
        let each = loads.iter().enumerate();
        each.map(|(total, load_g)| Solved {
            total,
            load_g: *load_g,
            siemens: Frame::zeros(2, 2),
            noise_siemens: 0.0,
            lost: 0,
        })
        .collect()
    }

    #[test]
    fn parts_are_groups_else_loads_else_stretches() {
        let frames = of(&[100.0, 200.0, 100.0, 300.0]);
        let frames: Vec<&Solved> = frames.iter().collect();
        let none = [None; 4];
        assert_eq!(parts(&frames, &none, 5).of, [0, 1, 0, 2]);
        let groups = [Some("b"), Some("a"), Some("a"), Some("b")];
        assert_eq!(parts(&frames, &groups, 5).of, [1, 0, 0, 1]);
        let alike = of(&[100.0; 6]);
        let alike: Vec<&Solved> = alike.iter().collect();
        assert_eq!(parts(&alike, &[None; 6], 3).of, [0, 0, 1, 1, 2, 2]);
        assert_eq!(parts(&alike[..1], &[None], 3).count, 1);
    }

    #[test]
    fn a_jackknife_of_means_is_the_standard_error() {
        let values: [f64; 5] = [1.0, 4.0, 2.0, 8.0, 5.0];
        let sum: f64 = values.iter().sum();
        let laws = values.map(|value| [(sum - value) / 4.0, 0.0]);
        let expected = crate::stats::standard_error(&values).unwrap();
        let [found, none] = jackknife(&laws);
        assert!((found - expected).abs() < 1e-12 && none == 0.0);
    }
}
