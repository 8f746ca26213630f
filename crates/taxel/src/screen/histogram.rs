//! How often each whole number was read, and what is in the middle.

use taxel_linalg::wide;

/// Numbers whose bins are found side by side.
pub(super) const BLOCK: usize = 512;
/// Tables that take numbers in turn: readings of one bin follow each other, and in one table each would wait for the last.
const TABLES: usize = 4;

/// Counts of whole numbers from 0 on.
#[derive(Debug, Clone)]
pub(super) struct Histogram {
    /// The last holds what is beyond all others, and says nothing.
    bins: Vec<u64>,
    /// The sum of all but that.
    held: u64,
    /// What has come since they were last settled, a table after the other; empty where numbers are too few for it.
    tables: Vec<u32>,
}

impl Histogram {
    /// So many bins, for so many numbers at a time.
    pub(super) fn new(bins: usize, numbers: usize) -> Self {
        let all = bins + 1;
        // All places of the tables are gone through when they are taken into the bins: not for a few numbers.
        let are_many = numbers >= TABLES * all / 2;
        Self {
            bins: vec![0; all],
            held: 0,
            tables: vec![0; if are_many { TABLES * all } else { 0 }],
        }
    }

    /// The bins.
    pub(super) fn counts(&self) -> &[u64] {
        &self.bins[..self.bins.len() - 1]
    }

    /// How many numbers are in them.
    pub(super) fn held(&self) -> u64 {
        self.held
    }

    /// The place of numbers that are not to be held.
    pub(super) fn beyond(&self) -> f64 {
        self.counts().len() as f64
    }

    /// Adds one at each of these places, [`Self::beyond`] the last of them; to be settled before anything is asked.
    pub(super) fn add(&mut self, places: &[u32]) {
        let all = self.bins.len();
        if self.tables.is_empty() {
            for &at in places {
                self.bins[at as usize] += 1;
            }
            return;
        }
        let (a, rest) = self.tables.split_at_mut(all);
        let (b, rest) = rest.split_at_mut(all);
        let (c, d) = rest.split_at_mut(all);
        let (fours, rest) = places.as_chunks::<TABLES>();
        for [at_a, at_b, at_c, at_d] in fours {
            a[*at_a as usize] += 1;
            b[*at_b as usize] += 1;
            c[*at_c as usize] += 1;
            d[*at_d as usize] += 1;
        }
        for &at in rest {
            a[at as usize] += 1;
        }
    }

    /// Takes all that was added into the bins.
    pub(super) fn settle(&mut self) {
        let Self { bins, held, tables } = self;
        wide(
            #[inline(always)]
            || {
                for table in tables.chunks_exact_mut(bins.len()) {
                    for (bin, new) in bins.iter_mut().zip(table) {
                        *bin += u64::from(*new);
                        *new = 0;
                    }
                }
                *held = bins[..bins.len() - 1].iter().sum();
            },
        );
    }

    /// Halves every count.
    pub(super) fn halve(&mut self) {
        for count in &mut self.bins {
            *count /= 2;
        }
        self.held = self.counts().iter().sum();
    }

    /// Halves the shortest interval that holds half of what is left until it is three bins wide; its centroid.
    pub(super) fn half_sample_mode(&self) -> f64 {
        let bins = self.counts();
        let (mut first, mut last) = (0, bins.len() - 1);
        let mut inside = self.held;
        while last - first > 2 {
            let (a, b) = shortest_half(bins, first, last, inside);
            if (a, b) == (first, last) {
                break;
            }
            (first, last) = (a, b);
            inside = bins[first..=last].iter().sum();
        }
        let mut weight = 0.0;
        let mut moment = 0.0;
        let reach = first.saturating_sub(1)..=(last + 1).min(bins.len() - 1);
        for i in reach {
            weight += bins[i] as f64;
            moment += i as f64 * bins[i] as f64;
        }
        moment / weight.max(1.0)
    }

    /// Median of magnitudes (the first bin reaches from 0 to ½), interpolated within its bin.
    pub(super) fn interpolated_median(&self) -> f64 {
        let half = self.held as f64 / 2.0;
        let mut held = 0.0;
        for (i, &count) in self.counts().iter().enumerate() {
            let part = count as f64;
            if held + part >= half && part > 0.0 {
                let lower = (i as f64 - 0.5).max(0.0);
                return lower + (i as f64 + 0.5 - lower) * (half - held) / part;
            }
            held += part;
        }
        0.0
    }
}

/// The whole number nearest to one that is neither negative nor beyond 2⁵²: so many that its last binary digit is a one.
/// `round` is a call where the processor may be an old one, and takes several times as long.
#[inline(always)]
pub(super) fn nearest(number: f64) -> u32 {
    const ONES: f64 = 4_503_599_627_370_496.0;
    ((number + ONES).to_bits() - ONES.to_bits()) as u32
}

/// The shortest interval of bins in `first..=last` that holds at least half of the `inside` that all of them hold; of several,
/// the fullest.
fn shortest_half(bins: &[u64], first: usize, last: usize, inside: u64) -> (usize, usize) {
    let wanted = inside.div_ceil(2);
    let mut best = (first, last, 0);
    let mut start = first;
    let mut held = 0;
    // What is left from the first bin on with which an interval that ends beyond `end` is no longer than the best.
    let (mut next, mut left) = (first, inside);
    for end in first..=last {
        held += bins[end];
        while start < end && held - bins[start] >= wanted {
            held -= bins[start];
            start += 1;
        }
        let shorter = end - start < best.1 - best.0;
        let fuller = end - start == best.1 - best.0 && held > best.2;
        if held >= wanted && (shorter || fuller) {
            best = (start, end, held);
        }
        while next + (best.1 - best.0) <= end {
            left -= bins[next];
            next += 1;
        }
        if left < wanted {
            break;
        }
    }
    (best.0, best.1)
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    /// The same by looking at every interval.
    fn shortest_of_all(bins: &[u64]) -> (usize, usize) {
        let wanted = bins.iter().sum::<u64>().div_ceil(2);
        let mut best = (0, bins.len() - 1, 0);
        for end in 0..bins.len() {
            for start in 0..=end {
                let held = bins[start..=end].iter().sum();
                let (length, of_best) = (end - start, best.1 - best.0);
                let is_better = length < of_best || length == of_best && held > best.2;
                if held >= wanted && is_better {
                    best = (start, end, held);
                }
            }
        }
        (best.0, best.1)
    }

    #[test]
    fn the_shortest_half_is_that_of_all_intervals() {
        let mut random = ChaCha8Rng::seed_from_u64(5);
        for round in 0..600 {
            let length = 1 + round % 40;
            // Few of many, so that there are ties and holes.
            let most = [1, 3, 40][round % 3];
            let draw = |_| random.random_range(0..=most) * random.random_range(0..=1);
            let bins: Vec<u64> = (0..length).map(draw).collect();
            let found = shortest_half(&bins, 0, length - 1, bins.iter().sum());
            assert_eq!(found, shortest_of_all(&bins), "{bins:?}");
        }
    }

    #[test]
    fn what_is_beyond_the_bins_is_not_held() {
        // In tables, and straight into the bins.
        for numbers in [100, 1] {
            let mut histogram = Histogram::new(4, numbers);
            histogram.add(&[0, 3, 4, 4, 1]);
            histogram.settle();
            assert_eq!(
                (histogram.counts(), histogram.held()),
                (&[1, 1, 0, 1][..], 3)
            );
            histogram.add(&[0, 4]);
            histogram.settle();
            histogram.halve();
            assert_eq!(
                (histogram.counts(), histogram.held()),
                (&[1, 0, 0, 0][..], 1)
            );
        }
    }
}
