//! A hybrid's cross-validation: every network is trained without one part of the presses, and judged on it.

use std::ops::ControlFlow;

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::network::{AdamSettings, Mlp, Trace};
use crate::scaler::Scaler;
use crate::train::{Epoch, Settings, Trainable, train};

use super::super::row_set::starting_at_nothing;
use super::{CvResult, Example, FEATURES, Hybrid, HybridScratch, Member, Typical};

const HIDDEN: usize = 8;

/// A hybrid with what is known of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Trained {
    /// The networks, none where physics was better.
    pub model: Hybrid,
    /// What decided that.
    pub verdict: CvResult,
    /// For every example what the one network said that knows neither it nor any other press of its frame, grams; none
    /// where the training was stopped before. Only with these may an interval be set.
    pub out_of_fold_g: Vec<Option<f32>>,
    /// The last epoch of every network.
    pub epochs: Vec<Epoch>,
}

impl Hybrid {
    /// Trains by cross-validation over the presses in `folds` parts, and keeps the networks only if presses gain
    /// by more than two standard errors. Presses of one frame are in one part. What a network sees with (means and
    /// deviations of the features, the typical error) is from the presses that it is trained on, as its weights are.
    pub fn train(
        examples: &[Example],
        folds: usize,
        epochs: usize,
        seed: u64,
        progress: &mut dyn FnMut(f64) -> ControlFlow<()>,
    ) -> Trained {
        let (fold_of, folds) = parts(examples, folds);
        let settings = settings(epochs, seed);
        let mut trained = Trained {
            model: Self::default(),
            verdict: verdict(&[]),
            out_of_fold_g: vec![None; examples.len()],
            epochs: Vec::new(),
        };
        for fold in 0..folds {
            let train_on: Vec<Example> = examples
                .iter()
                .zip(&fold_of)
                .filter(|(_, at)| **at != fold)
                .map(|(example, _)| *example)
                .collect();
            let mut training = Training::new(&train_on, seed + fold as u64);
            let mut stopped = false;
            let history = train(&mut training, &settings, None, &mut |epoch, _| {
                let share = (fold as f64 + epoch.epoch as f64 / epochs as f64) / folds as f64;
                let go = progress(share);
                stopped |= go.is_break();
                go
            });
            let one = Self {
                members: vec![training.member],
            };
            for (i, example) in examples.iter().enumerate() {
                if fold_of[i] == fold {
                    let mut load = [example.physics_g];
                    one.correct(
                        &[example.features],
                        &mut load,
                        &mut HybridScratch::default(),
                    );
                    trained.out_of_fold_g[i] = Some(load[0]);
                }
            }
            trained.model.members.extend(one.members);
            trained.epochs.extend(history.last());
            if stopped {
                break;
            }
        }
        trained.test(examples);
        trained
    }
}

impl Trained {
    fn test(&mut self, examples: &[Example]) {
        let errors: Vec<(f64, f64)> = examples
            .iter()
            .zip(&self.out_of_fold_g)
            .filter_map(|(example, load)| {
                let off = |load: f32| f64::from((load - example.load_g).abs());
                load.map(|load| (off(example.physics_g), off(load)))
            })
            .collect();
        self.verdict = verdict(&errors);
        if !self.verdict.used {
            self.model.members.clear();
            self.epochs.clear();
        }
    }
}

/// The part of every example, by its frame, and how many parts there are; one frame cannot be cross-validated: none.
fn parts(examples: &[Example], folds: usize) -> (Vec<usize>, usize) {
    let mut frames: Vec<usize> = examples.iter().map(|e| e.frame).collect();
    frames.sort_unstable();
    frames.dedup();
    let folds = match frames.len() {
        0 | 1 => return (vec![0; examples.len()], 0),
        count => folds.min(count),
    };
    let part = |e: &Example| frames.partition_point(|&frame| frame < e.frame) % folds;
    (examples.iter().map(part).collect(), folds)
}

fn settings(epochs: usize, seed: u64) -> Settings {
    Settings {
        epochs,
        batch: 32,
        l2: 0.1,
        patience: epochs,
        stop_by_loss: true,
        anneal: true,
        seed,
        adam: AdamSettings {
            rate: 5e-3,
            ..AdamSettings::default()
        },
        ..Settings::default()
    }
}

/// Of errors without and with the network, press by press, grams.
fn verdict(errors: &[(f64, f64)]) -> CvResult {
    let count = errors.len().max(1) as f64;
    let mean = errors.iter().map(|(a, b)| a - b).sum::<f64>() / count;
    let squares: f64 = errors.iter().map(|(a, b)| (a - b - mean).powi(2)).sum();
    let error = (squares / (count * (count - 1.0).max(1.0))).sqrt();
    CvResult {
        physics_g: errors.iter().map(|e| e.0).sum::<f64>() / count,
        hybrid_g: errors.iter().map(|e| e.1).sum::<f64>() / count,
        standard_errors: mean / error.max(1e-12),
        used: mean > 0.0 && mean > 2.0 * error,
    }
}

/// One network of a hybrid in training. The loss is Huber's, in typical errors: a press that went wrong must not
/// bend the rest.
struct Training<'a> {
    member: Member,
    examples: &'a [Example],
    inputs: Vec<f32>,
    /// What y should be: (true load − L)/s(L).
    wanted: Vec<f32>,
    batch: Vec<f32>,
    by_output: Vec<f32>,
    trace: Trace,
}

/// Where Huber's loss turns from square to straight.
const HUBER: f32 = 3.0;

impl<'a> Training<'a> {
    fn new(examples: &'a [Example], seed: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let flat: Vec<f32> = examples.iter().flat_map(|e| e.features).collect();
        let typical = Typical::fit(examples);
        let member = Member {
            scaler: Scaler::fit(&flat, FEATURES),
            typical,
            network: starting_at_nothing(Mlp::new(&[FEATURES, HIDDEN, 1], false, &mut random)),
        };
        Self {
            inputs: examples
                .iter()
                .flat_map(|e| member.scaled(&e.features))
                .collect(),
            wanted: examples
                .iter()
                .map(|e| (e.load_g - e.physics_g) / typical.at(e.physics_g))
                .collect(),
            member,
            examples,
            batch: Vec::new(),
            by_output: Vec::new(),
            trace: Trace::default(),
        }
    }
}

impl Trainable for Training<'_> {
    fn networks(&mut self) -> Vec<&mut Mlp> {
        vec![&mut self.member.network]
    }

    fn examples(&self) -> usize {
        self.examples.len()
    }

    fn batch(&mut self, which: &[usize], gradients: &mut [Vec<f32>]) -> f64 {
        self.batch.clear();
        for &i in which {
            self.batch
                .extend_from_slice(&self.inputs[i * FEATURES..(i + 1) * FEATURES]);
        }
        self.member.network.forward(&self.batch, &mut self.trace);
        let count = which.len() as f32;
        let mut loss = 0.0;
        self.by_output.clear();
        for (&i, y) in which.iter().zip(self.trace.output()) {
            let off = y - self.wanted[i];
            let held = off.clamp(-HUBER, HUBER);
            loss += f64::from(held * (off - 0.5 * held));
            self.by_output.push(held / count);
        }
        self.member.network.backward(
            &self.batch,
            &self.by_output,
            &mut self.trace,
            &mut gradients[0],
            false,
        );
        loss / f64::from(count)
    }

    fn check(&mut self) -> f64 {
        self.member.network.forward(&self.inputs, &mut self.trace);
        let errors = self
            .trace
            .output()
            .iter()
            .zip(&self.wanted)
            .zip(self.examples)
            .map(|((y, wanted), e)| {
                f64::from((y - wanted).abs() * self.member.typical.at(e.physics_g))
            });
        errors.sum::<f64>() / self.examples.len() as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::train::assert_gradient;
    use crate::trust::Interval;
    use rand::RngExt;

    /// Presses, three a frame, whose physics is off by `bias` of the load, and by up to `noise` grams.
    fn examples(count: usize, bias: f32, noise: f32, seed: u64) -> Vec<Example> {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        (0..count)
            .map(|i| {
                let load_g = 20.0 + 400.0 * random.random::<f32>();
                let off = noise * (2.0 * random.random::<f32>() - 1.0);
                let physics_g = load_g * (1.0 + bias) + off;
                let mut features = [0.0; FEATURES];
                features.fill_with(|| random.random::<f32>());
                features[0] = physics_g / 100.0;
                Example {
                    features,
                    physics_g,
                    load_g,
                    frame: i / 3,
                }
            })
            .collect()
    }

    fn loads(examples: &[Example]) -> Vec<f64> {
        examples.iter().map(|e| e.load_g.into()).collect()
    }

    fn estimates(model: &Hybrid, examples: &[Example]) -> Vec<f64> {
        let features: Vec<_> = examples.iter().map(|e| e.features).collect();
        let mut loads: Vec<f32> = examples.iter().map(|e| e.physics_g).collect();
        model.correct(&features, &mut loads, &mut HybridScratch::default());
        loads.into_iter().map(f64::from).collect()
    }

    #[test]
    fn gradients_agree_with_finite_differences() {
        let examples = examples(120, 0.02, 0.5, 8);
        let mut training = Training::new(&examples, 2);
        let which: Vec<usize> = (0..40).collect();
        assert_gradient(&mut training, &which, 0.02);
    }

    #[test]
    fn physics_that_is_right_is_left_alone_and_a_bias_is_learnt() {
        let found = Hybrid::train(&examples(120, 0.0, 0.5, 8), 5, 60, 1, &mut |_| {
            ControlFlow::Continue(())
        });
        assert!(!found.verdict.used, "{:?}", found.verdict);
        assert!(found.model.members.is_empty());
        let found = Hybrid::train(&examples(120, 0.03, 0.5, 8), 5, 200, 1, &mut |_| {
            ControlFlow::Continue(())
        });
        let verdict = &found.verdict;
        assert!(verdict.used, "{verdict:?}");
        assert!(verdict.hybrid_g < 0.5 * verdict.physics_g, "{verdict:?}");
        assert_eq!((found.model.members.len(), found.epochs.len()), (5, 5));
    }

    /// Nothing that is known of a press, or of another of its frame, reaches the estimate that its interval is set by:
    /// no weight, no mean of a feature, no typical error.
    #[test]
    fn an_out_of_fold_estimate_knows_nothing_of_its_own_frame() {
        let before = examples(36, 0.03, 4.0, 5);
        let mut after = before.clone();
        for example in after.iter_mut().filter(|e| e.frame == 4) {
            example.load_g *= 3.0;
        }
        let run = |examples: &[Example]| {
            Hybrid::train(examples, 5, 20, 1, &mut |_| ControlFlow::Continue(()))
        };
        let (a, b) = (run(&before).out_of_fold_g, run(&after).out_of_fold_g);
        let same = |i: &usize| a[*i] == b[*i];
        let own: Vec<usize> = (0..36).filter(|&i| before[i].frame == 4).collect();
        assert_eq!(own.len(), 3);
        assert!(own.iter().all(same));
        assert!(!(0..36).all(|i| same(&i)), "labels must matter to others");
        assert!(a.iter().all(Option::is_some));
    }

    /// Presses that nothing was trained with are inside the interval as often as it says. Few presses and a network
    /// that can follow their noise: set by the errors on the training presses it would cover 6 % fewer.
    #[test]
    fn the_interval_covers_what_it_says_on_presses_that_are_new() {
        let (mut inside, mut by_training) = (0.0, 0.0);
        const TRIALS: u64 = 12;
        for trial in 0..TRIALS {
            let known = examples(60, 0.1, 12.0, 100 + trial);
            let new = examples(1500, 0.1, 12.0, 900 + trial);
            let found = Hybrid::train(&known, 5, 400, trial, &mut |_| ControlFlow::Continue(()));
            assert!(found.verdict.used, "{:?}", found.verdict);
            let apart: Vec<f64> = found
                .out_of_fold_g
                .iter()
                .map(|g| g.unwrap().into())
                .collect();
            let on_new = estimates(&found.model, &new);
            let coverage = |estimates: &[f64]| {
                Interval::fit(0.9, estimates, &loads(&known)).coverage(&on_new, &loads(&new))
            };
            inside += coverage(&apart) / TRIALS as f64;
            by_training += coverage(&estimates(&found.model, &known)) / TRIALS as f64;
        }
        // One quantile from 60 presses scatters by 0.038, the mean of 12 by 0.011.
        assert!((0.88..0.96).contains(&inside), "{inside}");
        assert!(by_training < inside - 0.02, "{by_training} {inside}");
    }
}
