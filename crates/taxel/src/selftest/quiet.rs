//! What every taxel reads without a load, and how much that varies.

use super::SelfTestOptions;
use super::thinned::Thinned;
use crate::circuit::ROUNDING_COUNTS;
use crate::stats::SIGMA_PER_MAD;
use crate::{Counts, Frame};

/// Frames kept for the medians. A longer recording is thinned evenly.
const KEPT: usize = 64;
/// Where this share of the readings is 0, the lower half of the noise is cut off.
const CUT_OFF_SHARE: f64 = 0.2;
/// Share of normal numbers below the mean and one standard deviation.
const UPPER_SHARE: f64 = 0.841_344_746;

/// Collects the empty recording in constant memory.
#[derive(Debug, Clone, Default)]
pub(super) struct Quiet {
    kept: Thinned<KEPT>,
}

/// The array without a load, taxel by taxel.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Unloaded {
    /// Median reading, counts.
    pub counts: Vec<f64>,
    /// Standard deviation of the noise, counts: from the median absolute deviation, or from the 84th percentile where that
    /// is more and the converter cuts the noise off at 0.
    pub noise: Vec<f64>,
    /// Reading above the baseline that is a load, counts.
    pub loaded: Vec<f64>,
    /// Taxels of which nothing can be told beside a short: see [`Quiet::unloaded`]; and crossings without a taxel.
    pub masked: Vec<bool>,
    /// Median over the taxels of `counts`, counts.
    pub typical_counts: f64,
    /// Mean over the taxels of `noise`, those left out that differ from the median by a factor of two, counts.
    pub typical_noise: f64,
    /// Standard deviation of `counts` over the taxels, from the median absolute deviation, counts.
    pub unevenness: f64,
    /// The converter's largest count.
    pub max_count: f64,
}

impl Unloaded {
    /// Whether a taxel's noise is far above that of the array.
    pub fn is_noisy(&self, taxel: usize, options: &SelfTestOptions) -> bool {
        let (noise, typical) = (self.noise[taxel], self.typical_noise);
        noise > options.noisy_factor * typical && noise > typical + options.noisy_counts
    }
}

impl Quiet {
    pub fn observe(&mut self, frame: &Frame<Counts>) {
        self.kept.observe(frame);
    }

    /// Medians. [`SelfTestOptions::shorted_share`] of the range without a load is a short: a taxel that is shorted ties its row to its
    /// column, which then read what the other one does, so that both are masked; a whole line at the end masks itself.
    pub fn unloaded(&self, columns: usize, max_count: f64, options: &SelfTestOptions) -> Unloaded {
        let screen = &options.screen;
        let kept = &self.kept.frames;
        let taxels = kept.first().map_or(0, Vec::len);
        let mut values = Vec::with_capacity(KEPT);
        let (mut counts, mut noise) = (Vec::with_capacity(taxels), Vec::with_capacity(taxels));
        for taxel in 0..taxels {
            values.clear();
            values.extend(kept.iter().map(|frame| f64::from(frame[taxel])));
            let middle = median(&mut values);
            let at_zero = values.iter().filter(|&&v| v < 0.5).count();
            let is_cut_off = at_zero as f64 >= CUT_OFF_SHARE * values.len() as f64;
            let above = if is_cut_off {
                upper(&mut values) - middle
            } else {
                0.0
            };
            for value in &mut values {
                *value = (*value - middle).abs();
            }
            counts.push(middle);
            let around = SIGMA_PER_MAD * median(&mut values);
            noise.push(around.max(above).max(ROUNDING_COUNTS));
        }
        let loaded = noise.iter().map(|&noise| {
            (screen.loaded_sigmas * noise).max(screen.loaded_share_of_range * max_count)
        });
        let there = |values: &[f64]| -> Vec<f64> {
            let values = values.iter().enumerate();
            let there = values.filter(|(taxel, _)| !screen.is_absent(*taxel));
            there.map(|(_, &value)| value).collect()
        };
        let mut off = there(&counts);
        let typical_counts = median(&mut off);
        for value in &mut off {
            *value = (*value - typical_counts).abs();
        }
        let is_absent = |taxel| screen.is_absent(taxel);
        let shorted = options.shorted_share * max_count;
        Unloaded {
            unevenness: SIGMA_PER_MAD * median(&mut off),
            loaded: loaded.collect(),
            masked: mask(&counts, columns, shorted, is_absent),
            typical_counts,
            typical_noise: typical(&there(&noise)),
            counts,
            noise,
            max_count,
        }
    }
}

/// The value that 16 of 100 exceed: one standard deviation above the middle, also where the lower half is cut off at 0.
fn upper(values: &mut [f64]) -> f64 {
    let at = (UPPER_SHARE * values.len() as f64) as usize;
    if at < values.len() {
        *values.select_nth_unstable_by(at, f64::total_cmp).1
    } else {
        0.0
    }
}

/// The deviations are multiples of half a count times 1.48, and so is their median; the mean is not.
fn typical(noise: &[f64]) -> f64 {
    let middle = median(&mut noise.to_vec());
    let usual = noise
        .iter()
        .filter(|&&n| (middle / 2.0..=2.0 * middle).contains(&n));
    let (sum, count) = usual.fold((0.0, 0.0), |(sum, count), n| (sum + n, count + 1.0));
    (sum / f64::max(count, 1.0)).max(ROUNDING_COUNTS)
}

/// The lines of taxels that read `shorted` counts or more; of lines that do so over more than half of their length, those
/// alone. And the crossings that carry no taxel.
fn mask(
    counts: &[f64],
    columns: usize,
    shorted: f64,
    is_absent: impl Fn(usize) -> bool,
) -> Vec<bool> {
    let rows = counts.len() / columns.max(1);
    let is_shorted = |taxel: usize| !is_absent(taxel) && counts[taxel] >= shorted;
    let is_whole = |taxels: &mut dyn Iterator<Item = usize>| {
        let (all, shorted) = taxels
            .filter(|&taxel| !is_absent(taxel))
            .fold((0, 0), |(all, shorted), taxel| {
                (all + 1, shorted + usize::from(is_shorted(taxel)))
            });
        2 * shorted > all
    };
    let row = |r: usize| is_whole(&mut (0..columns).map(|c| r * columns + c));
    let column = |c: usize| is_whole(&mut (0..rows).map(|r| r * columns + c));
    let whole_rows: Vec<bool> = (0..rows).map(row).collect();
    let whole_columns: Vec<bool> = (0..columns).map(column).collect();
    let (mut bad_rows, mut bad_columns) = (whole_rows.clone(), whole_columns.clone());
    for taxel in (0..counts.len()).filter(|&taxel| is_shorted(taxel)) {
        let (row, column) = (taxel / columns, taxel % columns);
        if !whole_rows[row] && !whole_columns[column] {
            bad_rows[row] = true;
            bad_columns[column] = true;
        }
    }
    let line = |taxel: usize| {
        bad_rows[taxel / columns] || bad_columns[taxel % columns] || is_absent(taxel)
    };
    (0..counts.len()).map(line).collect()
}

/// The median of `values`, which are reordered; 0 of none.
pub(super) fn median(values: &mut [f64]) -> f64 {
    crate::stats::median_in_place(values).unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_short_masks_its_row_and_column_and_a_line_at_the_end_itself() {
        let mut counts = vec![0.0; 20];
        counts[7] = 900.0;
        let masked = |counts: &[f64]| -> Vec<usize> {
            let masked = mask(counts, 5, 700.0, |_| false);
            (0..20).filter(|&taxel| masked[taxel]).collect()
        };
        assert_eq!(masked(&counts), [2, 5, 6, 7, 8, 9, 12, 17]);
        counts[5..10].fill(900.0);
        assert_eq!(masked(&counts), [5, 6, 7, 8, 9]);
    }

    #[test]
    fn a_long_recording_is_thinned_evenly() {
        let mut quiet = Quiet::default();
        for k in 0..1000 {
            quiet.observe(&Frame::filled(1, 1, f64::from(k)));
        }
        assert!((33..=KEPT).contains(&quiet.kept.frames.len()));
        let unloaded = quiet.unloaded(1, 65_535.0, &SelfTestOptions::default());
        assert!((unloaded.counts[0] - 500.0).abs() < 20.0);
    }
}
