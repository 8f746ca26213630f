//! Does it matter whether the load grew or fell?

use crate::stats::{Bootstrap, Estimate, mean};

/// A reading under a known load, in the order in which they were taken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoopReading {
    /// In any unit.
    pub load: f64,
    /// In any unit.
    pub value: f64,
}

/// What loops of growing and falling load say.
#[derive(Debug, Clone, PartialEq)]
pub struct Hysteresis {
    /// Loops.
    pub loops: usize,
    /// Largest difference between the way down and the way up at one load, in % of the range of values, mean over loops.
    pub widest_percent: Estimate,
    /// The mean difference over the loads, in % of the range of values, mean over loops.
    pub mean_percent: Estimate,
    /// What stays after the way down at the lowest load, in % of the range of values, mean over loops; `None` where no
    /// loop comes back to its lowest load.
    pub zero_return_percent: Option<Estimate>,
}

/// Loads of a loop at which both ways are compared.
const STEPS: usize = 50;

/// Judges loops, each from its lowest load up and down again. Loops without a way up and a way down (fewer than two
/// different loads on either) do not count; `None` without any.
pub fn hysteresis(loops: &[Vec<LoopReading>], bootstrap: &Bootstrap) -> Option<Hysteresis> {
    let found: Vec<Vec<Width>> = loops
        .iter()
        .filter_map(|one| Some(vec![width(one)?]))
        .collect();
    let of =
        |which: fn(&Width) -> f64| bootstrap.estimate(&found, |some| mean(some.iter().map(which)));
    let returns: Vec<Vec<f64>> = found
        .iter()
        .filter_map(|one| Some(vec![one[0].zero_return?]))
        .collect();
    Some(Hysteresis {
        loops: found.len(),
        widest_percent: of(|width| width.widest)?,
        mean_percent: of(|width| width.mean)?,
        zero_return_percent: bootstrap.estimate(&returns, |some| mean(some.iter().copied())),
    })
}

/// Of one loop, % of its range of values.
#[derive(Clone, Copy)]
struct Width {
    widest: f64,
    mean: f64,
    zero_return: Option<f64>,
}

fn width(readings: &[LoopReading]) -> Option<Width> {
    let top = (0..readings.len()).max_by(|&a, &b| readings[a].load.total_cmp(&readings[b].load))?;
    let (up, down) = (branch(&readings[..=top]), branch(&readings[top..]));
    if up.len() < 2 || down.len() < 2 {
        return None;
    }
    let values = readings.iter().map(|r| r.value);
    let range = values.clone().fold(f64::MIN, f64::max) - values.fold(f64::MAX, f64::min);
    let low = up[0].0.max(down[0].0);
    let high = up.last()?.0.min(down.last()?.0);
    if range <= 0.0 || high <= low {
        return None;
    }
    let differences: Vec<f64> = (0..=STEPS)
        .map(|i| low + (high - low) * i as f64 / STEPS as f64)
        .map(|load| 100.0 * (between(&down, load) - between(&up, load)).abs() / range)
        .collect();
    let (first, last) = (readings.first()?, readings.last()?);
    Some(Width {
        widest: differences.iter().copied().fold(0.0, f64::max),
        mean: mean(differences.iter().copied())?,
        zero_return: (last.load == first.load).then(|| 100.0 * (last.value - first.value) / range),
    })
}

/// Mean value at every load, loads ascending.
fn branch(readings: &[LoopReading]) -> Vec<(f64, f64)> {
    let mut sorted = readings.to_vec();
    sorted.sort_by(|a, b| a.load.total_cmp(&b.load));
    let mut out: Vec<(f64, f64)> = Vec::new();
    for group in sorted.chunk_by(|a, b| a.load == b.load) {
        out.extend(mean(group.iter().map(|r| r.value)).map(|value| (group[0].load, value)));
    }
    out
}

/// Straight between neighbours.
fn between(points: &[(f64, f64)], x: f64) -> f64 {
    let above = points
        .partition_point(|p| p.0 < x)
        .clamp(1, points.len() - 1);
    let (a, b) = (points[above - 1], points[above]);
    a.1 + (x - a.0) / (b.0 - a.0) * (b.1 - a.1)
}
