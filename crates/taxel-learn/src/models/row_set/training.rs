//! A row set learns: its loss and the gradients of both networks.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::models::paper_mlp::{child_seed, half_mean_square, mean_absolute};
use crate::network::Mlp;
use crate::rows::Rows;
use crate::scaler::Scaler;
use crate::train::Trainable;

use super::features::{FEATURES, RowFeatures};
use super::{RowSet, RowSetScratch, factor};

/// Sums over the row.
const POOLED: usize = 32;

/// A network whose answer is nothing until it has learnt something.
pub(in crate::models) fn starting_at_nothing(mut network: Mlp) -> Mlp {
    let (weights, biases) = network.layer_mut(network.layers() - 1);
    weights.fill(0.0);
    biases.fill(0.0);
    network
}

/// A row set in training.
pub struct RowSetTraining<'a> {
    model: RowSet,
    train: &'a Rows,
    check: &'a Rows,
    rows: Vec<f32>,
    memory: RowSetScratch,
    loads: Vec<f32>,
    by_output: Vec<f32>,
    by_phi: Vec<f32>,
}

impl<'a> RowSetTraining<'a> {
    /// From the training part and the presses to stop by. `seed` draws the start.
    pub fn new(train: &'a Rows, check: &'a Rows, seed: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut draw = |widths: &[usize], relu_last| {
            let mut random = ChaCha8Rng::seed_from_u64(child_seed(&mut random));
            Mlp::new(widths, relu_last, &mut random)
        };
        let mut model = RowSet {
            eye: RowFeatures::of(train),
            phi: draw(&[FEATURES, POOLED, POOLED], true),
            scaler: Scaler::none(FEATURES + POOLED),
            rho: starting_at_nothing(draw(&[FEATURES + POOLED, 48, 32, 1], false)),
        };
        let mut memory = RowSetScratch::default();
        model.pool(&train.row, train.columns, &mut memory);
        model.run(train.taxel.iter().copied().zip(0..), &mut memory);
        model.scaler = Scaler::fit(&memory.inputs, FEATURES + POOLED);
        Self {
            model,
            train,
            check,
            rows: Vec::new(),
            memory: RowSetScratch::default(),
            loads: Vec::new(),
            by_output: Vec::new(),
            by_phi: Vec::new(),
        }
    }

    /// The model as it is now.
    pub fn finish(self) -> RowSet {
        self.model
    }
}

impl Trainable for RowSetTraining<'_> {
    fn networks(&mut self) -> Vec<&mut Mlp> {
        vec![&mut self.model.phi, &mut self.model.rho]
    }

    fn examples(&self) -> usize {
        self.train.len()
    }

    fn batch(&mut self, which: &[usize], gradients: &mut [Vec<f32>]) -> f64 {
        let columns = self.train.columns;
        self.rows.clear();
        for &i in which {
            self.rows.extend_from_slice(self.train.row_of(i));
        }
        let (model, memory) = (&self.model, &mut self.memory);
        model.pool(&self.rows, columns, memory);
        model.run(
            which
                .iter()
                .enumerate()
                .map(|(at, &i)| (self.train.taxel[i], at)),
            memory,
        );
        let scale = model.eye.scale_g;
        let loads = which.iter().map(|&i| self.train.load_g[i] / scale);
        self.loads.clear();
        self.loads.extend(
            memory
                .rho
                .output()
                .iter()
                .zip(which)
                .map(|(&y, &i)| model.eye.curve_g(self.train.taxel[i]) * factor(y) / scale),
        );
        let loss = half_mean_square(&self.loads, loads, &mut self.by_output);
        // dL/dy = L, where y is free.
        for ((by, load), y) in self
            .by_output
            .iter_mut()
            .zip(&self.loads)
            .zip(memory.rho.output())
        {
            *by *= if y.abs() < 3.0 { *load } else { 0.0 };
        }
        let [of_phi, of_rho] = gradients else {
            unreachable!("two networks have two gradients");
        };
        model.rho.backward(
            &memory.inputs,
            &self.by_output,
            &mut memory.rho,
            of_rho,
            true,
        );
        let width = model.pooled_width();
        let share = 8.0 / columns as f32;
        self.by_phi.clear();
        let deviations = &model.scaler.deviation[FEATURES..];
        for input in memory.rho.input_gradient().chunks_exact(FEATURES + width) {
            for _ in 0..columns {
                let by_sum = input[FEATURES..].iter().zip(deviations);
                self.by_phi.extend(by_sum.map(|(g, d)| share * g / d));
            }
        }
        model
            .phi
            .backward(&memory.seen, &self.by_phi, &mut memory.phi, of_phi, false);
        loss
    }

    fn check(&mut self) -> f64 {
        mean_absolute(&self.model.estimate(self.check), &self.check.load_g)
    }
}
