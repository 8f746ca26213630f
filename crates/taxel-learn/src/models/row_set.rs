//! A network that cannot know the order of a row: sums over the row's taxels, and the taxel itself.
//!
//! load = curve(x) · exp ρ(e(x), Σ_k φ(e(v_k))): one calibration curve, and what the row says about it. The sum of
//! embeddings is that of Zaheer et al., Deep Sets, 2017.

mod features;
mod training;

use crate::Malformed;
use crate::network::{Mlp, Trace};
use crate::rows::Rows;
use crate::scaler::Scaler;

use features::FEATURES;
pub use features::RowFeatures;
pub use training::RowSetTraining;
pub(super) use training::starting_at_nothing;

/// The factor that a network's output stands for: e^y, y held to ±3.
fn factor(y: f32) -> f32 {
    y.clamp(-3.0, 3.0).exp()
}

/// ρ over the taxel's features and the mean of φ over its row.
#[derive(Debug, Clone, PartialEq)]
pub struct RowSet {
    /// How readings are seen.
    pub eye: RowFeatures,
    /// Each reading of the row, to what is summed.
    pub phi: Mlp,
    /// Of what ρ takes in, over the training part before training.
    pub scaler: Scaler,
    /// The taxel's features and the sums, to its load.
    pub rho: Mlp,
}

/// Memory of one [`RowSet`] for one stream of frames.
#[derive(Debug, Clone, Default)]
pub struct RowSetScratch {
    seen: Vec<f32>,
    phi: Trace,
    rho: Trace,
    pooled: Vec<f32>,
    loads: Vec<f32>,
    inputs: Vec<f32>,
    known: Embeddings,
}

/// φ of the whole counts met so far: a converter gives few, so that a stream soon needs φ no more.
#[derive(Debug, Clone, Default)]
struct Embeddings {
    /// By count: one more than where its φ is in `values`, or 0.
    place: Vec<u32>,
    /// φ one after the other.
    values: Vec<f32>,
    /// Per reading of the frame: where its φ is in `values`.
    which: Vec<u32>,
}

/// Whole counts below this are remembered.
const REMEMBERED: f32 = 65536.0;

impl RowSet {
    fn pooled_width(&self) -> usize {
        *self.phi.widths().last().expect("a network has an output")
    }

    /// What is wrong with its shape, if anything.
    ///
    /// # Errors
    /// Which widths do not fit.
    pub fn check(&self) -> Result<(), Malformed> {
        let pooled = self.pooled_width();
        let fits = self.phi.widths()[0] == FEATURES
            && self.rho.widths()[0] == FEATURES + pooled
            && self.rho.widths().last() == Some(&1);
        if fits {
            Ok(())
        } else {
            Err(Malformed(format!(
                "a row-set of widths {:?} and {:?}",
                self.phi.widths(),
                self.rho.widths()
            )))
        }
    }

    /// φ over whole rows of a frame's readings, summed.
    fn pool_frame(&self, counts: &[f32], columns: usize, memory: &mut RowSetScratch) {
        let width = self.pooled_width();
        let Embeddings {
            place,
            values,
            which,
        } = &mut memory.known;
        let kept = values.len() / width;
        which.clear();
        memory.seen.clear();
        let see = |count: f32, seen: &mut Vec<f32>| {
            seen.extend_from_slice(&self.eye.see(count));
            (seen.len() / FEATURES + kept) as u32
        };
        let whole = |count: f32| (0.0..REMEMBERED).contains(&count) && count.fract() == 0.0;
        for &count in counts {
            let mut found = 0;
            if whole(count) {
                let at = count as usize;
                if place.len() <= at {
                    place.resize(at + 1, 0);
                }
                if place[at] == 0 {
                    place[at] = see(count, &mut memory.seen);
                }
                found = place[at];
            }
            which.push(found);
        }
        let keep = memory.seen.len() / FEATURES + kept;
        for (found, &count) in which.iter_mut().zip(counts) {
            if *found == 0 {
                *found = see(count, &mut memory.seen);
            }
        }
        self.phi.forward(&memory.seen, &mut memory.phi);
        values.extend_from_slice(memory.phi.output());
        memory.pooled.clear();
        memory.pooled.resize(counts.len() / columns * width, 0.0);
        let share = 8.0 / columns as f32;
        add_embeddings(&mut memory.pooled, which, values, width, share, columns);
        values.truncate(keep * width);
    }

    /// φ over whole rows of readings, summed.
    fn pool(&self, rows: &[f32], columns: usize, memory: &mut RowSetScratch) {
        memory.seen.clear();
        for &value in rows {
            memory.seen.extend_from_slice(&self.eye.see(value));
        }
        self.phi.forward(&memory.seen, &mut memory.phi);
        let width = self.pooled_width();
        memory.pooled.clear();
        memory.pooled.resize(rows.len() / columns * width, 0.0);
        let share = 8.0 / columns as f32;
        let (pooled, outputs) = (&mut memory.pooled, memory.phi.output());
        pulp::Arch::new().dispatch(
            #[inline(always)]
            || {
                for (sum, row) in pooled
                    .chunks_exact_mut(width)
                    .zip(outputs.chunks_exact(columns * width))
                {
                    for one in row.chunks_exact(width) {
                        for (sum, value) in sum.iter_mut().zip(one) {
                            *sum += share * value;
                        }
                    }
                }
            },
        );
    }

    fn run(&self, taxels: impl Iterator<Item = (f32, usize)>, memory: &mut RowSetScratch) {
        let width = self.pooled_width();
        memory.inputs.clear();
        for (taxel, row) in taxels {
            memory.inputs.extend_from_slice(&self.eye.see(taxel));
            memory
                .inputs
                .extend_from_slice(&memory.pooled[row * width..(row + 1) * width]);
        }
        let inputs = &mut memory.inputs;
        pulp::Arch::new().dispatch(
            #[inline(always)]
            || {
                for input in inputs.chunks_exact_mut(FEATURES + width) {
                    self.scaler.scale(input);
                }
            },
        );
        self.rho.forward(&memory.inputs, &mut memory.rho);
    }

    /// Loads of some presses, grams, not clipped.
    pub fn estimate(&self, rows: &Rows) -> Vec<f64> {
        let mut memory = RowSetScratch::default();
        self.pool(&rows.row, rows.columns, &mut memory);
        self.run(rows.taxel.iter().copied().zip(0..rows.len()), &mut memory);
        memory
            .rho
            .output()
            .iter()
            .zip(&rows.taxel)
            .map(|(&y, &x)| f64::from(self.eye.curve_g(x) * factor(y)))
            .collect()
    }

    /// Loads (grams) of the taxels listed (row, column), in that order, given
    /// a whole frame's counts (rows × columns). The memory must be this model's own.
    pub fn estimate_frame<'a>(
        &self,
        counts: &[f32],
        columns: usize,
        taxels: &[(usize, usize)],
        memory: &'a mut RowSetScratch,
    ) -> &'a [f32] {
        self.pool_frame(counts, columns, memory);
        let reading = |&(row, column): &(usize, usize)| (counts[row * columns + column], row);
        self.run(taxels.iter().map(reading), memory);
        memory.loads.clear();
        memory.loads.extend(
            memory
                .rho
                .output()
                .iter()
                .zip(taxels)
                .map(|(&y, at)| self.eye.curve_g(reading(at).0) * factor(y)),
        );
        &memory.loads
    }
}

/// Adds to each row's sum the embeddings of its readings, `share` of each.
fn add_embeddings(
    pooled: &mut [f32],
    which: &[u32],
    values: &[f32],
    width: usize,
    share: f32,
    columns: usize,
) {
    pulp::Arch::new().dispatch(
        #[inline(always)]
        move || {
            // Moved out, so that the closure can be called once only and its body is inlined where the vectors are wide.
            let pooled: &mut [f32] = { pooled };
            for (sum, row) in pooled
                .chunks_exact_mut(width)
                .zip(which.chunks_exact(columns))
            {
                for &found in row {
                    let at = (found as usize - 1) * width;
                    let embedding = &values[at..at + width];
                    for i in 0..width {
                        sum[i] += share * embedding[i];
                    }
                }
            }
        },
    );
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::train::{Trainable, assert_gradient};
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    fn rows(seed: u64) -> Rows {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut rows = Rows::new(6);
        for _ in 0..30 {
            let row: Vec<f64> = (0..6)
                .map(|_| 30.0 + 4000.0 * random.random::<f64>())
                .collect();
            rows.push(row[2], row.clone(), 100.0 + 300.0 * random.random::<f64>());
        }
        rows
    }

    #[test]
    fn gradients_agree_with_finite_differences() {
        let rows = rows(1);
        let mut training = RowSetTraining::new(&rows, &rows, 3);
        let which: Vec<usize> = (0..12).collect();
        assert_gradient(&mut training, &which, 0.02);
    }

    #[test]
    fn a_frame_gives_what_its_rows_give_whatever_came_before() {
        let rows = rows(4);
        let mut training = RowSetTraining::new(&rows, &rows, 3);
        for network in training.networks() {
            for (i, p) in network.parameters_mut().iter_mut().enumerate() {
                *p += 0.01 * ((i % 5) as f32 - 2.0);
            }
        }
        let model = training.finish();
        let mut memory = RowSetScratch::default();
        // Whole counts, counts between them, and one below nothing, in a stream of three frames.
        for frame in 0..3 {
            let counts: Vec<f32> = (0..12)
                .map(|i| match (i + frame) % 4 {
                    0 => (700 * i) as f32,
                    1 => 40.0,
                    2 => (300 * i) as f32 + 0.25,
                    _ => -3.0,
                })
                .collect();
            let taxels = [(0, 1), (0, 4), (1, 2)];
            let mut by_row = Rows::new(6);
            for &(row, column) in &taxels {
                let values = counts[row * 6..(row + 1) * 6].iter().map(|&v| f64::from(v));
                by_row.push(f64::from(counts[row * 6 + column]), values, 1.0);
            }
            let found = model.estimate_frame(&counts, 6, &taxels, &mut memory);
            for (found, expected) in found.iter().zip(model.estimate(&by_row)) {
                assert!((f64::from(*found) - expected).abs() < 1e-4 * expected.abs().max(1.0));
            }
        }
        assert!(memory.known.values.len() < 20 * model.pooled_width());
    }

    #[test]
    fn the_order_of_a_row_means_nothing() {
        let rows = rows(2);
        let mut training = RowSetTraining::new(&rows, &rows, 3);
        // Untrained ρ answers nothing; give it something to say.
        for network in training.networks() {
            for (i, p) in network.parameters_mut().iter_mut().enumerate() {
                *p += 0.01 * ((i % 7) as f32 - 3.0);
            }
        }
        let model = training.finish();
        let copies = rows.shuffled_copies(1, 9);
        assert_ne!(rows.row, copies.row);
        let (a, b) = (model.estimate(&rows), model.estimate(&copies));
        assert!(a.iter().any(|&load| (load - a[0]).abs() > 1.0));
        for (a, b) in a.iter().zip(&b) {
            assert!((a - b).abs() < 1e-4 * a.abs().max(1.0), "{a} {b}");
        }
    }
}
