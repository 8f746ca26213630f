//! What a calibration makes of postures that it has not seen, and intervals that are learnt without them.

use crate::law::{Fitted, Model};
use crate::recording::Posture;

/// Of a hundred intervals, five may miss.
const MISSES: f64 = 0.05;

/// Which postures are left out together.
#[derive(Clone, Copy)]
pub enum Leave {
    Posture,
    Pose,
    Family,
}

impl Leave {
    pub const ALL: [(Leave, &str); 3] = [
        (Leave::Posture, "one posture"),
        (Leave::Pose, "one pose, its three variations"),
        (Leave::Family, "one family of poses"),
    ];

    /// The postures of each group.
    pub fn groups(self, postures: &[Posture]) -> Vec<Vec<usize>> {
        let mut groups: Vec<(&str, Vec<usize>)> = Vec::new();
        for (index, posture) in postures.iter().enumerate() {
            let name = match self {
                Leave::Posture => &posture.name,
                Leave::Pose => posture.pose(),
                Leave::Family => posture.family(),
            };
            match groups.iter_mut().find(|(known, _)| *known == name) {
                Some((_, members)) => members.push(index),
                None => groups.push((name, vec![index])),
            }
        }
        groups.into_iter().map(|(_, members)| members).collect()
    }
}

/// One posture, by a calibration that has not seen its group.
pub struct Held {
    pub posture: usize,
    /// Shares of the weight.
    pub total: f64,
    /// Jackknife+ from the other groups (Barber, Candès, Ramdas, Tibshirani, Annals of Statistics 49:486, 2021).
    pub interval: (f64, f64),
    /// The coefficient of variation of its snapshots.
    pub within: f64,
    /// The last snapshot over the first.
    pub rise: f64,
    /// The place of the shape that was chosen.
    pub shape: usize,
}

pub fn held_out(model: &Model<'_>, postures: &[Posture], leave: Leave) -> Vec<Held> {
    let groups = leave.groups(postures);
    let mut held = Vec::new();
    for out in &groups {
        let fitted = model.fit(&without(&groups, &[out]));
        let intervals = intervals(model, &groups, out);
        for (&posture, interval) in out.iter().zip(intervals) {
            let (within, rise) = snapshots(model, &fitted, &postures[posture]);
            held.push(Held {
                posture,
                total: model.total(&fitted, posture),
                interval,
                within,
                rise,
                shape: fitted.shape,
            });
        }
    }
    held
}

fn without(groups: &[Vec<usize>], out: &[&[usize]]) -> Vec<usize> {
    let stay = groups
        .iter()
        .filter(|group| !out.contains(&group.as_slice()));
    stay.flatten().copied().collect()
}

fn snapshots(model: &Model<'_>, fitted: &Fitted, posture: &Posture) -> (f64, f64) {
    let totals = posture.snapshots.iter();
    let totals: Vec<f64> = totals.map(|one| model.total_of(fitted, one)).collect();
    (variation(&totals), totals[totals.len() - 1] / totals[0])
}

/// The intervals of the postures of a group: each other group is left out as well in turn, its errors are put about what
/// the calibration without both makes of these postures.
fn intervals(model: &Model<'_>, groups: &[Vec<usize>], out: &[usize]) -> Vec<(f64, f64)> {
    let mut lower = vec![Vec::new(); out.len()];
    let mut upper = lower.clone();
    for other in groups.iter().filter(|group| group.as_slice() != out) {
        let fitted = model.fit(&without(groups, &[out, other]));
        for &seen in other {
            let error = (model.total(&fitted, seen) - 1.0).abs();
            for (index, &posture) in out.iter().enumerate() {
                let total = model.total(&fitted, posture);
                lower[index].push(total - error);
                upper[index].push(total + error);
            }
        }
    }
    let ends = lower.iter_mut().zip(&mut upper);
    ends.map(|(lower, upper)| {
        lower.sort_by(f64::total_cmp);
        upper.sort_by(f64::total_cmp);
        let place = ((MISSES * (lower.len() + 1) as f64).floor() as usize).max(1);
        (lower[place - 1], upper[upper.len() - place])
    })
    .collect()
}

/// Standard deviation (n − 1) over the mean.
pub fn variation(values: &[f64]) -> f64 {
    let mean = taxel::stats::mean(values.iter().copied()).unwrap_or(f64::NAN);
    taxel::stats::standard_deviation(values).unwrap_or(f64::NAN) / mean
}
