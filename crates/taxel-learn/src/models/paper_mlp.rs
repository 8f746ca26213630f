//! The paper's network: a taxel and its row's values in, its load out.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::network::{LineScratch, Mlp, Trace};
use crate::rows::{Rows, shuffled};
use crate::scaler::Scaler;
use crate::train::Trainable;

/// Hidden widths of the paper.
pub const HIDDEN: [usize; 3] = [160, 480, 240];
/// Whole rows go through the layers together, until they have this many taxels: what they leave between layers stays
/// in the processor's cache.
const CHUNK: usize = 192;
/// Shuffled copies of every press, of the paper.
pub const COPIES: usize = 100;

/// 1 + C → 160 → 480 → 240 → 1 over standardised counts; grams.
#[derive(Debug, Clone, PartialEq)]
pub struct PaperMlp {
    /// The layers.
    pub network: Mlp,
    /// Of the training part with its copies: the taxel, then its row.
    pub scaler: Scaler,
}

/// Memory of [`PaperMlp`] for one stream of frames.
#[derive(Debug, Clone, Default)]
pub struct PaperScratch {
    along: LineScratch,
    scaled: Vec<f32>,
    /// Per row: the first layer's sums with a taxel of nothing.
    starts: Vec<f32>,
    /// Row among those, the taxel's standardised count, and its place in the list.
    order: Vec<(usize, f32, usize)>,
    points: Vec<(usize, f32)>,
    loads: Vec<f32>,
}

impl PaperMlp {
    /// Columns of the array it is for.
    pub fn columns(&self) -> usize {
        self.network.widths()[0] - 1
    }

    /// Loads of some presses, grams, not clipped.
    pub fn estimate(&self, rows: &Rows) -> Vec<f64> {
        let mut inputs = Vec::with_capacity(rows.len() * (rows.columns + 1));
        for i in 0..rows.len() {
            let at = inputs.len();
            inputs.push(rows.taxel[i]);
            inputs.extend_from_slice(rows.row_of(i));
            self.scaler.scale(&mut inputs[at..]);
        }
        let mut trace = Trace::default();
        self.network.forward(&inputs, &mut trace);
        trace.output().iter().map(|&y| f64::from(y)).collect()
    }

    /// Loads (grams, not clipped) of the taxels listed (row, column), row by row, in that order, given a whole
    /// frame's counts (rows × columns). The taxels of a row differ in one input: what the first layer makes of the row
    /// is computed once, and the layers after it once for all taxels that light the same units.
    pub fn estimate_frame<'a>(
        &self,
        counts: &[f32],
        taxels: &[(usize, usize)],
        memory: &'a mut PaperScratch,
    ) -> &'a [f32] {
        let columns = self.columns();
        let width = self.network.widths()[1];
        let (weights, biases) = self.network.layer(0);
        let (own, of_row) = weights.split_at(width);
        memory.loads.clear();
        memory.loads.resize(taxels.len(), 0.0);
        let mut done = 0;
        while done < taxels.len() {
            memory.starts.clear();
            memory.order.clear();
            while memory.order.len() < CHUNK && done < taxels.len() {
                let row = taxels[done].0;
                let line = memory.starts.len() / width;
                let values = &counts[row * columns..(row + 1) * columns];
                memory.scaled.clear();
                memory.scaled.push(0.0);
                memory.scaled.extend_from_slice(values);
                self.scaler.scale(&mut memory.scaled);
                memory.starts.extend_from_slice(biases);
                let start = &mut memory.starts[line * width..];
                add_products(&memory.scaled[1..], of_row, start);
                let of_row = taxels[done..].iter().take_while(|taxel| taxel.0 == row);
                for &(_, column) in of_row {
                    let x = (values[column] - self.scaler.mean[0]) / self.scaler.deviation[0];
                    memory.order.push((line, x, done));
                    done += 1;
                }
            }
            memory
                .order
                .sort_unstable_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
            memory.points.clear();
            memory
                .points
                .extend(memory.order.iter().map(|&(line, x, _)| (line, x)));
            let (starts, points) = (&memory.starts, &memory.points);
            let loads = self
                .network
                .forward_along(starts, own, points, &mut memory.along);
            for (&(_, _, at), load) in memory.order.iter().zip(loads) {
                memory.loads[at] = *load;
            }
        }
        &memory.loads
    }
}

/// sums += x W for one row x.
fn add_products(x: &[f32], weights: &[f32], sums: &mut [f32]) {
    let width = sums.len();
    pulp::Arch::new().dispatch(
        #[inline(always)]
        || {
            for (x, weights) in x.iter().zip(weights.chunks_exact(width)) {
                for (sum, weight) in sums.iter_mut().zip(weights) {
                    *sum += x * weight;
                }
            }
        },
    );
}

/// The paper's network in training.
pub struct PaperTraining<'a> {
    model: PaperMlp,
    train: &'a Rows,
    check: &'a Rows,
    copies: usize,
    /// Examples, drawn and scaled once: (1 + C) values each.
    inputs: Vec<f32>,
    batch: Vec<f32>,
    by_output: Vec<f32>,
    trace: Trace,
}

impl<'a> PaperTraining<'a> {
    /// From the training part and the presses to stop by. `seed` draws the start and the copies.
    pub fn new(
        train: &'a Rows,
        check: &'a Rows,
        hidden: &[usize],
        copies: usize,
        seed: u64,
    ) -> Self {
        let width = train.columns + 1;
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut inputs = vec![0.0; train.len() * copies * width];
        for (example, input) in inputs.chunks_exact_mut(width).enumerate() {
            let press = example % train.len();
            input[0] = train.taxel[press];
            shuffled(train.row_of(press), &mut input[1..], &mut random);
        }
        let scaler = Scaler::fit(&inputs, width);
        for input in inputs.chunks_exact_mut(width) {
            scaler.scale(input);
        }
        let widths: Vec<usize> = [&[width], hidden, &[1]].concat();
        let network = Mlp::new(&widths, false, &mut ChaCha8Rng::from_rng(&mut random));
        Self {
            model: PaperMlp { network, scaler },
            train,
            check,
            copies,
            inputs,
            batch: Vec::new(),
            by_output: Vec::new(),
            trace: Trace::default(),
        }
    }

    /// Every example, standardised: the taxel, then its row in some order.
    pub fn inputs(&self) -> &[f32] {
        &self.inputs
    }

    /// The load of every example, grams.
    pub fn loads(&self) -> Vec<f32> {
        (0..self.examples())
            .map(|i| self.train.load_g[i % self.train.len()])
            .collect()
    }

    /// The model as it is now.
    pub fn finish(self) -> PaperMlp {
        self.model
    }
}

impl Trainable for PaperTraining<'_> {
    fn networks(&mut self) -> Vec<&mut Mlp> {
        vec![&mut self.model.network]
    }

    fn examples(&self) -> usize {
        self.train.len() * self.copies
    }

    fn batch(&mut self, which: &[usize], gradients: &mut [Vec<f32>]) -> f64 {
        let width = self.train.columns + 1;
        self.batch.clear();
        for &example in which {
            self.batch
                .extend_from_slice(&self.inputs[example * width..(example + 1) * width]);
        }
        self.model.network.forward(&self.batch, &mut self.trace);
        let loads = which
            .iter()
            .map(|i| self.train.load_g[i % self.train.len()]);
        let loss = half_mean_square(self.trace.output(), loads, &mut self.by_output);
        self.model.network.backward(
            &self.batch,
            &self.by_output,
            &mut self.trace,
            &mut gradients[0],
            false,
        );
        loss
    }

    fn check(&mut self) -> f64 {
        mean_absolute(&self.model.estimate(self.check), &self.check.load_g)
    }
}

/// ½ mean (y − t)², and its gradient by y.
pub(crate) fn half_mean_square(
    outputs: &[f32],
    targets: impl Iterator<Item = f32>,
    by_output: &mut Vec<f32>,
) -> f64 {
    let count = outputs.len() as f32;
    let mut sum = 0.0;
    by_output.clear();
    for (y, t) in outputs.iter().zip(targets) {
        sum += f64::from(y - t).powi(2);
        by_output.push((y - t) / count);
    }
    0.5 * sum / f64::from(count)
}

/// Mean absolute error of estimates clipped at zero, grams.
pub(crate) fn mean_absolute(estimates: &[f64], loads: &[f32]) -> f64 {
    let sum: f64 = estimates
        .iter()
        .zip(loads)
        .map(|(e, l)| (e.max(0.0) - f64::from(*l)).abs())
        .sum();
    sum / loads.len().max(1) as f64
}

/// Draws a seed for a part of a model from another.
pub(crate) fn child_seed(random: &mut ChaCha8Rng) -> u64 {
    random.random()
}
