//! Frames whose every load is known: labelled presses with nothing else on the array.

use std::f64::consts::PI;

use super::super::evidence::Evidence;
use super::super::least_squares::{median, robust_deviation};
use crate::circuit::ROUNDING_COUNTS;
use crate::{Counts, Frame, Mark};

/// A reading this many standard deviations from an unloaded one is loaded.
const LOADED_DEVIATIONS: f64 = 7.0;
/// What a press may shift on other lines than its own, as a share of what it reads itself: cross-talk of a circuit
/// that is not known yet, or a cover that carries a little.
const SHARE: f64 = 0.001;
/// Largest standard deviation believed of a reading, as a share of the converter's range, and as a multiple of what
/// the screen says: more is load.
const MAX_NOISE: (f64, f64) = (5e-4, 4.0);
/// No mean is believed to less than this, counts.
const MIN_MEAN_ERROR: f64 = 0.02;

/// A frame of which every load is known.
#[derive(Debug, Clone, Default)]
pub(super) struct KnownFrame {
    /// Its presses, as indices into the evidence's.
    pub(super) presses: Vec<usize>,
    /// Labelled rows and columns, each once, ascending.
    pub(super) rows: Vec<usize>,
    pub(super) columns: Vec<usize>,
    /// Of each press: its row and column as indices into those.
    pub(super) places: Vec<(usize, usize)>,
    /// What each labelled taxel reads, counts.
    pub(super) counts: Vec<f64>,
    /// Of each labelled row and column: the mean over its unloaded taxels of what they read over their usual, and
    /// how many there are.
    pub(super) on_rows: Vec<(f64, usize)>,
    pub(super) on_columns: Vec<(f64, usize)>,
}

impl KnownFrame {
    /// Presses at these places, nothing read yet.
    pub(super) fn placed(taxels: &[(usize, usize)]) -> Self {
        let sorted = |pick: &dyn Fn(&(usize, usize)) -> usize| {
            let mut lines: Vec<usize> = taxels.iter().map(pick).collect();
            lines.sort_unstable();
            lines.dedup();
            lines
        };
        let (rows, columns) = (sorted(&|t| t.0), sorted(&|t| t.1));
        let place = |t: &(usize, usize)| {
            let row = rows.partition_point(|&line| line < t.0);
            (row, columns.partition_point(|&line| line < t.1))
        };
        Self {
            places: taxels.iter().map(place).collect(),
            rows,
            columns,
            ..Self::default()
        }
    }

    fn crosses(&self, row: usize, column: usize) -> bool {
        self.rows.contains(&row) || self.columns.contains(&column)
    }
}

/// All known frames of a set, and what their unloaded taxels read.
#[derive(Debug, Clone)]
pub(super) struct KnownFrames {
    pub(super) frames: Vec<KnownFrame>,
    /// Mean reading of unloaded taxels, counts, and its standard error.
    pub(super) base_counts: f64,
    pub(super) base_error: f64,
    /// Standard deviation of a reading, counts.
    pub(super) noise_counts: f64,
    /// What the mean of however many readings may be off by, because they are whole counts.
    pub(super) rounding_counts: f64,
    /// Rows and columns that conduct.
    pub(super) live: (usize, usize),
    /// Presses of the evidence in no known frame.
    pub(super) crowded: Vec<usize>,
}

impl KnownFrames {
    /// The known frames of the evidence; presses in other frames are `crowded`.
    pub(super) fn find(evidence: &Evidence, max_count: f64) -> Self {
        let groups = grouped(evidence);
        let columns = evidence.frames.first().map_or(1, Frame::columns);
        let first = usual(evidence, &groups, columns, 0..groups.len());
        let most = (MAX_NOISE.0 * max_count).max(MAX_NOISE.1 * evidence.noise_counts);
        let noise = deviation(evidence, &groups, columns, &first).min(most.max(1.0));
        let quiet: Vec<usize> = (0..groups.len())
            .filter(|&i| {
                is_quiet(
                    &evidence.frames[groups[i].presses[0]],
                    &groups[i],
                    &first,
                    noise,
                )
            })
            .collect();
        let usual = usual(evidence, &groups, columns, quiet.iter().copied());
        let mut crowded = Vec::new();
        let mut frames = Vec::new();
        let mut noise = Moments::default();
        for (i, mut group) in groups.into_iter().enumerate() {
            if !quiet.contains(&i) {
                crowded.extend(&group.presses);
                continue;
            }
            let counts = &evidence.frames[group.presses[0]];
            group.counts = group
                .presses
                .iter()
                .map(|&p| counts.at(evidence.presses[p].row, evidence.presses[p].column))
                .collect();
            group.summarise(counts, &usual, &mut noise);
            frames.push(group);
        }
        crowded.sort_unstable();
        let known: Vec<f64> = usual.iter().copied().filter(|u| u.is_finite()).collect();
        let mut bases = Moments::default();
        known.iter().for_each(|&u| bases.add(u));
        let noise_counts = noise.deviation().max(ROUNDING_COUNTS);
        let rounding_counts = rounding_of_a_mean(noise_counts);
        Self {
            frames,
            base_counts: bases.mean(),
            base_error: (bases.deviation() / (known.len().max(1) as f64).sqrt())
                .max(rounding_counts),
            noise_counts,
            rounding_counts,
            live: live(evidence),
            crowded,
        }
    }

    /// Presses in known frames.
    pub(super) fn presses(&self) -> usize {
        self.frames.iter().map(|f| f.presses.len()).sum()
    }

    /// The same with every press counted as one of a crowded frame.
    pub(super) fn all_crowded(self, presses: usize) -> Self {
        Self {
            frames: Vec::new(),
            crowded: (0..presses).collect(),
            ..self
        }
    }

    /// The same with the frames of some presses alone; what unloaded taxels read stays.
    pub(super) fn with(&self, keep: impl Fn(usize) -> bool) -> Self {
        let all_kept = |f: &&KnownFrame| f.presses.iter().all(|&p| keep(p));
        Self {
            frames: self.frames.iter().filter(all_kept).cloned().collect(),
            crowded: self.crowded.iter().copied().filter(|&p| keep(p)).collect(),
            ..*self
        }
    }
}

/// What the mean of however many readings may be off by because they are whole counts, from their standard deviation with
/// rounding, counts. Noise of less than a count leaves readings on the same count: exp(−2π²σ²)/π (Widrow and Kollár,
/// Quantization Noise, 2008: the first harmonic of the rounding error).
pub(super) fn rounding_of_a_mean(noise_counts: f64) -> f64 {
    let before_rounding = (noise_counts.powi(2) - ROUNDING_COUNTS.powi(2)).max(0.0);
    let harmonic = (-2.0 * PI.powi(2) * before_rounding).exp() / PI;
    harmonic.max(MIN_MEAN_ERROR)
}

impl KnownFrame {
    fn summarise(&mut self, counts: &Frame<Counts>, usual: &[f64], noise: &mut Moments) {
        let columns = counts.columns();
        let mut on_rows = vec![Moments::default(); self.rows.len()];
        let mut on_columns = vec![Moments::default(); self.columns.len()];
        for (t, (&value, mark)) in counts.values().iter().zip(counts.marks()).enumerate() {
            if *mark != Mark::Good || !usual[t].is_finite() {
                continue;
            }
            let over = value - usual[t];
            let row = self.rows.iter().position(|&r| r == t / columns);
            let column = self.columns.iter().position(|&c| c == t % columns);
            match (row, column) {
                (Some(row), None) => on_rows[row].add(over),
                (None, Some(column)) => on_columns[column].add(over),
                (None, None) => noise.add(over),
                (Some(_), Some(_)) => {}
            }
        }
        let means = |all: Vec<Moments>| all.iter().map(|m| (m.mean(), m.count)).collect();
        self.on_rows = means(on_rows);
        self.on_columns = means(on_columns);
    }
}

/// Presses by the frame they are in.
fn grouped(evidence: &Evidence) -> Vec<KnownFrame> {
    let mut order: Vec<usize> = (0..evidence.presses.len()).collect();
    order.sort_by_key(|&p| (evidence.presses[p].frame, p));
    order
        .chunk_by(|&a, &b| evidence.presses[a].frame == evidence.presses[b].frame)
        .map(|group| {
            let taxels: Vec<(usize, usize)> = group
                .iter()
                .map(|&p| (evidence.presses[p].row, evidence.presses[p].column))
                .collect();
            KnownFrame {
                presses: group.to_vec(),
                ..KnownFrame::placed(&taxels)
            }
        })
        .collect()
}

/// What each taxel reads in the frames chosen that have no press on its lines: the median of many, and the mean of
/// what is near it. Lines of which one taxel is always labelled (strips) are judged by frames that press elsewhere.
fn usual(
    evidence: &Evidence,
    groups: &[KnownFrame],
    columns: usize,
    chosen: impl Iterator<Item = usize> + Clone,
) -> Vec<f64> {
    let taxels = evidence.frames.first().map_or(0, |f| f.values().len());
    let strip = columns == 1 || columns == taxels;
    let mut values = Vec::new();
    (0..taxels)
        .map(|t| {
            values.clear();
            for i in chosen.clone() {
                let group = &groups[i];
                let counts = &evidence.frames[group.presses[0]];
                let (row, column) = (t / columns, t % columns);
                let touched = if strip {
                    group.rows.contains(&row) && group.columns.contains(&column)
                } else {
                    group.crosses(row, column)
                };
                if !touched && counts.marks()[t] == Mark::Good {
                    values.push(counts.values()[t]);
                }
            }
            if values.is_empty() {
                return f64::NAN;
            }
            let middle = median(&values);
            let sizes: Vec<f64> = values.iter().map(|v| (v - middle).abs()).collect();
            let limit = (LOADED_DEVIATIONS * robust_deviation(&sizes)).max(2.0);
            let mut near = Moments::default();
            values
                .iter()
                .filter(|&&v| (v - middle).abs() <= limit)
                .for_each(|&v| near.add(v));
            near.mean()
        })
        .collect()
}

/// Robust standard deviation of readings about their usual, off the labelled lines.
fn deviation(evidence: &Evidence, groups: &[KnownFrame], columns: usize, usual: &[f64]) -> f64 {
    // The quieter half of the frames: the others may be crowded.
    let mut each: Vec<f64> = groups
        .iter()
        .map(|group| {
            let counts = &evidence.frames[group.presses[0]];
            let over: Vec<f64> = (0..usual.len())
                .filter(|&t| counts.marks()[t] == Mark::Good && usual[t].is_finite())
                .filter(|&t| !group.crosses(t / columns, t % columns))
                .map(|t| (counts.values()[t] - usual[t]).abs())
                .collect();
            robust_deviation(&over)
        })
        .collect();
    each.sort_by(f64::total_cmp);
    each.get(each.len() / 4)
        .copied()
        .unwrap_or(0.0)
        .max(ROUNDING_COUNTS)
}

/// Whether nothing but the labelled taxels is loaded: all others read as usual, those on a labelled line alike.
fn is_quiet(counts: &Frame<Counts>, group: &KnownFrame, usual: &[f64], noise: f64) -> bool {
    let columns = counts.columns();
    let over = |t: usize| counts.values()[t] - usual[t];
    let most = group
        .places
        .iter()
        .map(|p| counts.at(group.rows[p.0], group.columns[p.1]))
        .fold(0.0, f64::max);
    let limit = LOADED_DEVIATIONS * noise + 1.0 + SHARE * most;
    let good = |t: &usize| counts.marks()[*t] == Mark::Good && usual[*t].is_finite();
    let labelled = |t: usize| {
        let here = (t / columns, t % columns);
        let taxel = |p: &(usize, usize)| (group.rows[p.0], group.columns[p.1]) == here;
        group.places.iter().any(taxel)
    };
    let (mut inside, mut outside) = (0usize, 0usize);
    for t in (0..usual.len()).filter(good) {
        if !group.crosses(t / columns, t % columns) {
            inside += 1;
            outside += usize::from(over(t).abs() > limit);
        }
    }
    // A stray reading is a fault of the reading, not a load: loads come with a whole contact or not at all.
    if outside * 200 > inside {
        return false;
    }
    let alike = |line: Vec<usize>| {
        let values: Vec<f64> = line.iter().map(|&t| over(t)).collect();
        let middle = median(&values);
        let limit = limit + 0.2 * middle.abs();
        values.iter().all(|v| (v - middle).abs() <= limit)
    };
    let rows = group.rows.iter().all(|&row| {
        let line = (row * columns..(row + 1) * columns).filter(good);
        alike(
            line.filter(|&t| !labelled(t) && !group.columns.contains(&(t % columns)))
                .collect(),
        )
    });
    let columns_alike = group.columns.iter().all(|&column| {
        let line = (column..usual.len()).step_by(columns).filter(good);
        alike(
            line.filter(|&t| !labelled(t) && !group.rows.contains(&(t / columns)))
                .collect(),
        )
    });
    rows && columns_alike
}

/// Rows and columns that are not dead.
fn live(evidence: &Evidence) -> (usize, usize) {
    use crate::screen::Axis;
    let (rows, columns) = evidence
        .frames
        .first()
        .map_or((1, 1), |f| (f.rows(), f.columns()));
    let dead = |axis| evidence.faults.dead(axis).count();
    (
        rows.saturating_sub(dead(Axis::Row)).max(1),
        columns.saturating_sub(dead(Axis::Column)).max(1),
    )
}

/// Count, mean and squares of a list as it comes.
#[derive(Debug, Clone, Copy, Default)]
struct Moments {
    count: usize,
    sum: f64,
    squares: f64,
}

impl Moments {
    fn add(&mut self, value: f64) {
        self.count += 1;
        self.sum += value;
        self.squares += value * value;
    }

    fn mean(&self) -> f64 {
        self.sum / self.count.max(1) as f64
    }

    fn deviation(&self) -> f64 {
        let n = self.count.max(1) as f64;
        (self.squares / n - self.mean().powi(2)).max(0.0).sqrt()
    }
}
