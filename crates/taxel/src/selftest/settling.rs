//! Does a reading keep a share of the one before?
//!
//! In the scan a taxel follows its neighbour, and a hand loads neighbours alike: what a taxel shares with its
//! predecessor is mostly the hand. Comparing it with what it shares with its successor does not help, since the covariance
//! with the taxel before, summed over all taxels, *is* the covariance with the taxel after. So only the pairs
//! at which the scan jumps are looked at: the last taxel of one line and the first of the next, which lie at opposite edges.
//! There the first taxel of line i should know of the last one of line i − 1, and not of that of line i + 1, which is as far
//! away and loaded in the same manner. The share kept is the difference of the two coefficients in
//!
//! ```text
//! first(i) = a + b₁ · last(i − 1) + b₂ · last(i) + b₃ · last(i + 1),        share = b₁ − b₃
//! ```
//!
//! (heights above the baseline; least squares over frames and lines in which nothing lies beside the first taxels).
//! Cross-talk along the line, and a load that reaches over the whole width, are in b₂ or in both b₁ and b₃. The standard
//! error is that of a jackknife over eight blocks of lines (Efron and Stein 1981, *Annals of Statistics* 9:586), as frames
//! of one rub are no independent draws.

use super::SelfTestOptions;
use super::quiet::Unloaded;
use crate::sensor::ScanOrder;
use crate::{Counts, Frame};

const UNKNOWNS: usize = 4;
const BLOCKS: usize = 8;
/// Loaded predecessors that a block needs to have a say.
const MIN: u64 = 20;
/// Blocks that must have a say.
const MIN_BLOCKS: usize = 4;

/// The share of its predecessor that a reading keeps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settling {
    /// The order of the scan in which it was found largest against its error.
    pub order: ScanOrder,
    /// The share, 0 to 1 (noise makes it negative).
    pub share: f64,
    /// Its standard error.
    pub standard_error: f64,
    /// Readings that followed a loaded one and could tell.
    pub readings: u64,
}

/// The sums of a least-squares fit.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    normal: [[f64; UNKNOWNS]; UNKNOWNS],
    right: [f64; UNKNOWNS],
    squares: f64,
    samples: u64,
    loaded: u64,
}

impl Sums {
    fn add(&mut self, x: [f64; UNKNOWNS], y: f64) {
        for i in 0..UNKNOWNS {
            for j in 0..UNKNOWNS {
                self.normal[i][j] += x[i] * x[j];
            }
            self.right[i] += x[i] * y;
        }
        self.squares += y * y;
        self.samples += 1;
    }

    fn plus(&self, other: &Self, sign: f64) -> Self {
        let mut sum = *self;
        for i in 0..UNKNOWNS {
            for j in 0..UNKNOWNS {
                sum.normal[i][j] += sign * other.normal[i][j];
            }
            sum.right[i] += sign * other.right[i];
        }
        sum
    }

    /// b₁ − b₃; nothing where the loads do not tell them apart.
    fn share(&self) -> Option<f64> {
        let solution = solve(self.normal, self.right)?;
        Some(solution[1] - solution[3])
    }
}

/// Follows the rubbed recording in one scan order.
#[derive(Debug, Clone)]
struct Wraps {
    order: ScanOrder,
    blocks: [Sums; BLOCKS],
}

/// Follows the rubbed recording in both orders.
#[derive(Debug, Clone)]
pub(super) struct CarryOver {
    wraps: [Wraps; 2],
}

impl CarryOver {
    pub fn new() -> Self {
        let of = |order| Wraps {
            order,
            blocks: [Sums::default(); BLOCKS],
        };
        Self {
            wraps: [of(ScanOrder::RowByRow), of(ScanOrder::ColumnByColumn)],
        }
    }

    pub fn observe(
        &mut self,
        frame: &Frame<Counts>,
        unloaded: &Unloaded,
        options: &SelfTestOptions,
    ) {
        for wraps in &mut self.wraps {
            wraps.observe(frame, unloaded, options);
        }
    }

    /// The order with the clearer share; nothing where neither can be judged.
    pub fn finish(&self) -> Option<Settling> {
        let clarity = |s: &Settling| s.share / s.standard_error;
        let found = self.wraps.iter().filter_map(Wraps::finish);
        found.max_by(|a, b| clarity(a).total_cmp(&clarity(b)))
    }
}

impl Wraps {
    fn observe(&mut self, frame: &Frame<Counts>, unloaded: &Unloaded, options: &SelfTestOptions) {
        let (rows, columns) = (frame.rows(), frame.columns());
        let (lines, length) = match self.order {
            ScanOrder::RowByRow => (rows, columns),
            ScanOrder::ColumnByColumn => (columns, rows),
        };
        // The first taxel, its neighbour and the last one must be three.
        if lines < 3 || length < 4 {
            return;
        }
        let taxel = |line: usize, position: usize| match self.order {
            ScanOrder::RowByRow => line * columns + position,
            ScanOrder::ColumnByColumn => position * columns + line,
        };
        let height = |taxel: usize| frame.values()[taxel] - unloaded.counts[taxel];
        let ceiling = unloaded.max_count - options.screen.end_counts;
        for line in 1..lines - 1 {
            let lasts = [line - 1, line, line + 1].map(|line| taxel(line, length - 1));
            let x = lasts.map(height);
            let first = taxel(line, 0);
            let loads = lasts.map(|last| height(last) > unloaded.loaded[last]);
            let at_end = |taxel: usize| frame.values()[taxel] >= ceiling;
            let next_to = [line - 1, line, line + 1].map(|line| taxel(line, 1));
            let masked = lasts.iter().chain([&first]).any(|&t| unloaded.masked[t]);
            let next_to_free = !masked && next_to.iter().all(|&t| height(t) <= unloaded.loaded[t]);
            // A reading that keeps more than half of the one before is stuck, or loaded itself.
            let largest = x.iter().copied().fold(0.0, f64::max);
            let plausible = height(first) <= 0.5 * largest + unloaded.loaded[first];
            if !loads.contains(&true)
                || lasts.iter().any(|&last| at_end(last))
                || at_end(first)
                || !next_to_free
                || !plausible
            {
                continue;
            }
            let block = &mut self.blocks[line * BLOCKS / lines];
            block.add([1.0, x[0], x[1], x[2]], height(first));
            block.loaded += u64::from(loads[0]);
        }
    }

    fn finish(&self) -> Option<Settling> {
        let enough = |block: &&Sums| block.loaded >= MIN;
        let blocks: Vec<&Sums> = self.blocks.iter().filter(enough).collect();
        if blocks.len() < MIN_BLOCKS {
            return None;
        }
        let mut all = Sums::default();
        let mut readings = 0;
        for block in &blocks {
            all = all.plus(block, 1.0);
            all.squares += block.squares;
            all.samples += block.samples;
            readings += block.loaded;
        }
        let share = all.share()?;
        let without: Option<Vec<f64>> = blocks
            .iter()
            .map(|block| all.plus(block, -1.0).share())
            .collect();
        let without = without?;
        let count = without.len() as f64;
        let mean = without.iter().sum::<f64>() / count;
        let spread: f64 = without.iter().map(|b| (b - mean).powi(2)).sum();
        let jackknife = ((count - 1.0) / count * spread).sqrt();
        Some(Settling {
            order: self.order,
            share,
            // Eight blocks may agree by chance, but not beyond what the residual allows.
            standard_error: jackknife.max(least_error(&all)?).max(f64::MIN_POSITIVE),
            readings,
        })
    }
}

/// The standard error of b₁ − b₃ if every reading were an independent draw.
fn least_error(all: &Sums) -> Option<f64> {
    let solution = solve(all.normal, all.right)?;
    let explained: f64 = solution.iter().zip(&all.right).map(|(b, r)| b * r).sum();
    let freedom = all.samples.saturating_sub(UNKNOWNS as u64).max(1) as f64;
    let variance = ((all.squares - explained) / freedom).max(0.0);
    let contrast = [0.0, 1.0, 0.0, -1.0];
    let column = solve(all.normal, contrast)?;
    Some((variance * (column[1] - column[3]).max(0.0)).sqrt())
}

/// Gaussian elimination with row pivoting, of a matrix first scaled to a unit diagonal; nothing if it is singular.
fn solve(mut a: [[f64; UNKNOWNS]; UNKNOWNS], mut b: [f64; UNKNOWNS]) -> Option<[f64; UNKNOWNS]> {
    let scale: [f64; UNKNOWNS] = std::array::from_fn(|i| a[i][i].sqrt());
    if scale.iter().any(|s| s.is_nan() || *s <= 0.0) {
        return None;
    }
    for i in 0..UNKNOWNS {
        for j in 0..UNKNOWNS {
            a[i][j] /= scale[i] * scale[j];
        }
        b[i] /= scale[i];
    }
    for column in 0..UNKNOWNS {
        let pivot = (column..UNKNOWNS).max_by(|&i, &j| {
            let size = |row: usize| a[row][column].abs();
            size(i).total_cmp(&size(j))
        })?;
        if a[pivot][column].abs() < 1e-10 {
            return None;
        }
        a.swap(pivot, column);
        b.swap(pivot, column);
        for row in column + 1..UNKNOWNS {
            let factor = a[row][column] / a[column][column];
            let above = a[column];
            for (value, above) in a[row].iter_mut().zip(above).skip(column) {
                *value -= factor * above;
            }
            b[row] -= factor * b[column];
        }
    }
    for row in (0..UNKNOWNS).rev() {
        let known: f64 = (row + 1..UNKNOWNS).map(|k| a[row][k] * b[k]).sum();
        b[row] = (b[row] - known) / a[row][row];
    }
    Some(std::array::from_fn(|i| b[i] / scale[i]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn four_equations_are_solved_and_singular_ones_refused() {
        let a = [
            [4.0, 1.0, 0.5, 0.0],
            [1.0, 3.0, 0.2, 0.1],
            [0.5, 0.2, 2.0, 0.3],
            [0.0, 0.1, 0.3, 5.0],
        ];
        let wanted = [1.0, -2.0, 3.0, 0.5];
        let b = std::array::from_fn(|i| (0..4).map(|j| a[i][j] * wanted[j]).sum());
        let found = solve(a, b).unwrap();
        for (found, wanted) in found.into_iter().zip(wanted) {
            assert!((found - wanted).abs() < 1e-12);
        }
        assert_eq!(solve([[1.0; 4]; 4], [1.0; 4]), None);
    }
}
