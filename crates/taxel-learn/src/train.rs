//! One loop that trains every model: batches in a seeded order, Adam, stop, keep the best.

use std::ops::ControlFlow;

use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

use crate::network::{Adam, AdamSettings, Mlp};

/// What the loop needs of a model in training. Loads are in the model's own scale.
pub trait Trainable {
    /// The networks whose parameters are trained.
    fn networks(&mut self) -> Vec<&mut Mlp>;

    /// Examples an epoch has.
    fn examples(&self) -> usize;

    /// ½ mean squared error of some examples; adds its gradient, one list for each network.
    fn batch(&mut self, which: &[usize], gradients: &mut [Vec<f32>]) -> f64;

    /// Mean absolute error on presses kept aside for it, grams.
    fn check(&mut self) -> f64;
}

/// How to train.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[non_exhaustive]
pub struct Settings {
    /// Most epochs.
    pub epochs: usize,
    /// Examples a batch.
    pub batch: usize,
    /// L2 on the weights, per batch, as scikit-learn's alpha.
    pub l2: f64,
    /// Epochs without progress that end the training.
    pub patience: usize,
    /// What counts as progress: of the loss (scikit-learn's tol), or of the check's error in grams.
    pub tolerance: f64,
    /// Stop by the training loss, as scikit-learn does, or by the presses kept aside.
    pub stop_by_loss: bool,
    /// Let the learning rate fall to nothing along half a cosine.
    pub anneal: bool,
    /// Seed of the order of examples.
    pub seed: u64,
    /// The optimiser.
    pub adam: AdamSettings,
}

impl Default for Settings {
    /// scikit-learn's MLPRegressor.
    fn default() -> Self {
        Self {
            epochs: 2000,
            batch: 200,
            l2: 1e-4,
            patience: 10,
            tolerance: 1e-4,
            stop_by_loss: true,
            anneal: false,
            seed: 1,
            adam: AdamSettings::default(),
        }
    }
}

/// One epoch, as it ends.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Epoch {
    /// Number, from 1.
    pub epoch: usize,
    /// ½ mean squared error plus the penalty, in the model's own scale, mean over the epoch.
    pub loss: f64,
    /// Mean absolute error on the presses kept aside, grams.
    pub check_g: f64,
    /// Whether it is the best so far on them.
    pub best: bool,
}

/// What a training that was interrupted goes on from.
#[derive(Debug, Clone, PartialEq)]
pub struct Checkpoint {
    /// Epochs done.
    pub epochs: Vec<Epoch>,
    /// Per network: parameters, Adam's means and squares, and the best parameters so far.
    pub networks: Vec<[Vec<f32>; 4]>,
    /// Steps of Adam.
    pub steps: u64,
}

/// Sees every epoch, with what is needed to go on from it, and says whether to.
pub type EpochWatch<'a> = dyn FnMut(&Epoch, &dyn Fn() -> Checkpoint) -> ControlFlow<()> + 'a;

/// Trains a model; it ends with its best parameters on the presses kept aside (with `stop_by_loss`: its last).
/// `watch` is told of every epoch, with what is needed to go on from it.
///
/// # Panics
/// With a checkpoint of other networks: [`Checkpoint::check`] tells.
pub fn train(
    model: &mut impl Trainable,
    settings: &Settings,
    from: Option<&Checkpoint>,
    watch: &mut EpochWatch<'_>,
) -> Vec<Epoch> {
    let counts: Vec<usize> = model
        .networks()
        .iter()
        .map(|n| n.parameters().len())
        .collect();
    let mut optimisers: Vec<Adam> = counts
        .iter()
        .map(|&n| Adam::new(settings.adam, n))
        .collect();
    let mut gradients: Vec<Vec<f32>> = counts.iter().map(|&n| vec![0.0; n]).collect();
    let mut kept = parameters_of(model);
    let mut history: Vec<Epoch> = Vec::new();
    if let Some(from) = from {
        history.clone_from(&from.epochs);
        resume(model, &mut optimisers, from);
        kept = from.networks.iter().map(|m| m[3].clone()).collect();
    }
    while history.len() < settings.epochs && !has_stalled(&history, settings) {
        let number = history.len();
        let order = epoch_order(settings, number, model.examples());
        if settings.anneal {
            let rate = annealed_rate(settings, number);
            optimisers.iter_mut().for_each(|o| o.set_rate(rate));
        }
        let mut sum = 0.0;
        for which in order.chunks(settings.batch) {
            sum += step(model, which, settings.l2, &mut gradients, &mut optimisers)
                * which.len() as f64;
        }
        let check_g = model.check();
        let least = history
            .iter()
            .map(|e| e.check_g)
            .fold(f64::INFINITY, f64::min);
        let epoch = Epoch {
            epoch: number + 1,
            loss: sum / order.len().max(1) as f64,
            check_g,
            best: check_g < least,
        };
        history.push(epoch);
        let now = parameters_of(model);
        if epoch.best || settings.stop_by_loss {
            kept.clone_from(&now);
        }
        let checkpoint = || checkpoint_of(&history, &now, &optimisers, &kept);
        if watch(&epoch, &checkpoint).is_break() || !epoch.loss.is_finite() {
            break;
        }
    }
    for (network, kept) in model.networks().into_iter().zip(&kept) {
        network.parameters_mut().copy_from_slice(kept);
    }
    history
}

/// Sets networks and optimisers to what a checkpoint kept.
fn resume(model: &mut impl Trainable, optimisers: &mut [Adam], from: &Checkpoint) {
    let networks = model.networks().into_iter().zip(optimisers);
    for ((network, optimiser), state) in networks.zip(&from.networks) {
        network.parameters_mut().copy_from_slice(&state[0]);
        optimiser.restore(&state[1], &state[2], from.steps);
    }
}

/// The rate of an epoch (from 0) that falls along a half cosine, to a hundredth at least.
fn annealed_rate(settings: &Settings, epoch: usize) -> f64 {
    let share = epoch as f64 / settings.epochs as f64;
    let rate = settings.adam.rate * 0.5 * (1.0 + (std::f64::consts::PI * share).cos());
    rate.max(settings.adam.rate * 1e-2)
}

/// What is needed to go on: parameters as they are (`now`) and the best so far (`kept`), network by network.
fn checkpoint_of(
    history: &[Epoch],
    now: &[Vec<f32>],
    optimisers: &[Adam],
    kept: &[Vec<f32>],
) -> Checkpoint {
    let networks = now.iter().zip(optimisers).zip(kept);
    Checkpoint {
        epochs: history.to_vec(),
        networks: networks
            .map(|((now, optimiser), kept)| {
                let (mean, square, _) = optimiser.state();
                [now.clone(), mean.to_vec(), square.to_vec(), kept.clone()]
            })
            .collect(),
        steps: optimisers.first().map_or(0, |o| o.state().2),
    }
}

/// The order of the examples in an epoch (from 0). It depends on nothing before it, so that a resumed training is the
/// same.
pub fn epoch_order(settings: &Settings, epoch: usize, examples: usize) -> Vec<usize> {
    let seed = settings
        .seed
        .wrapping_mul(0x9e37_79b9_7f4a_7c15)
        .wrapping_add(epoch as u64);
    let mut order: Vec<usize> = (0..examples).collect();
    order.shuffle(&mut ChaCha8Rng::seed_from_u64(seed));
    order
}

fn parameters_of(model: &mut impl Trainable) -> Vec<Vec<f32>> {
    model
        .networks()
        .iter()
        .map(|n| n.parameters().to_vec())
        .collect()
}

/// One batch: loss with its penalty, gradient, step.
fn step(
    model: &mut impl Trainable,
    which: &[usize],
    l2: f64,
    gradients: &mut [Vec<f32>],
    optimisers: &mut [Adam],
) -> f64 {
    gradients.iter_mut().for_each(|g| g.fill(0.0));
    let mut loss = model.batch(which, gradients);
    let share = (l2 / which.len() as f64) as f32;
    for ((network, gradient), optimiser) in
        model.networks().into_iter().zip(gradients).zip(optimisers)
    {
        if share > 0.0 {
            for range in network.weight_ranges() {
                let weights = &network.parameters()[range.clone()];
                for (g, w) in gradient[range].iter_mut().zip(weights) {
                    *g += share * w;
                }
                loss += 0.5 * f64::from(share) * squares(weights);
            }
        }
        optimiser.step(network.parameters_mut(), gradient);
    }
    loss
}

/// Σ x², in lanes so that the compiler may use vectors.
fn squares(values: &[f32]) -> f64 {
    let mut lanes = [0f32; 16];
    let mut sum = 0.0;
    for block in values.chunks(4096) {
        lanes.fill(0.0);
        for chunk in block.chunks(16) {
            for (lane, value) in lanes.iter_mut().zip(chunk) {
                *lane += value * value;
            }
        }
        sum += lanes.iter().map(|&lane| f64::from(lane)).sum::<f64>();
    }
    sum
}

/// Whether the last `patience` epochs brought no progress.
fn has_stalled(history: &[Epoch], settings: &Settings) -> bool {
    let value = |e: &Epoch| {
        if settings.stop_by_loss {
            e.loss
        } else {
            e.check_g
        }
    };
    let mut best = f64::INFINITY;
    let mut without = 0;
    for epoch in history {
        if value(epoch) > best - settings.tolerance {
            without += 1
        } else {
            without = 0
        }
        best = best.min(value(epoch));
    }
    without > settings.patience
}

/// For the tests of every model: the gradient of a batch against central differences, along random directions.
#[cfg(test)]
pub(crate) fn assert_gradient(model: &mut impl Trainable, which: &[usize], tolerance: f64) {
    use rand::RngExt;
    let mut random = ChaCha8Rng::seed_from_u64(17);
    let sizes: Vec<usize> = model
        .networks()
        .iter()
        .map(|n| n.parameters().len())
        .collect();
    let zeros = || -> Vec<Vec<f32>> { sizes.iter().map(|&n| vec![0.0; n]).collect() };
    // Away from the start, where outputs are zero and hide what is in front of them.
    for network in model.networks() {
        for p in network.parameters_mut() {
            *p += 0.05 * (random.random::<f32>() - 0.5);
        }
    }
    let mut gradients = zeros();
    model.batch(which, &mut gradients);
    for part in 0..sizes.len() {
        let direction: Vec<f32> = (0..sizes[part])
            .map(|_| random.random::<f32>() - 0.5)
            .collect();
        let along: f64 = gradients[part]
            .iter()
            .zip(&direction)
            .map(|(g, d)| f64::from(g * d))
            .sum();
        let step = 1e-3f32;
        let mut loss_at = |by: f32| -> f64 {
            for (p, d) in model.networks()[part]
                .parameters_mut()
                .iter_mut()
                .zip(&direction)
            {
                *p += by * d;
            }
            model.batch(which, &mut zeros())
        };
        let above = loss_at(step);
        let below = loss_at(-2.0 * step);
        loss_at(step);
        let difference = (above - below) / (2.0 * f64::from(step));
        // What a direction drawn at random has along it: a kink inside the step counts against that, and not against
        // the little that this one direction may happen to have.
        let square = |values: &[f32]| values.iter().map(|v| f64::from(v * v)).sum::<f64>();
        let typical =
            (square(&gradients[part]) * square(&direction) / direction.len() as f64).sqrt();
        assert!(
            (difference - along).abs() < tolerance * along.abs().max(typical),
            "network {part}: {difference} by differences, {along} by the gradient"
        );
    }
}
