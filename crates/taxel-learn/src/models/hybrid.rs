//! Physics first, then a small network on what is left of the error.
//!
//! load = L + s(L) · y(features), L the load by the exact inverse, s(L) the error it typically has at that load. Every
//! network starts at y = 0, the physics itself, and is kept only where held-out presses gain by it.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use taxel::calibrate::LoadLaw;
use taxel::pipeline::FrameResult;
use taxel::solve::Raw;

use crate::network::{AdamSettings, Mlp, Trace};
use crate::scaler::Scaler;
use crate::train::{Go, Settings, Trainable, train};

use super::row_set::starting_at_nothing;

/// Numbers that the network sees of a taxel.
pub const FEATURES: usize = 10;
/// Loads below this are left to the physics, grams.
pub const LEAST_G: f32 = 2.0;
const HIDDEN: usize = 8;
/// Largest |y|: a correction beyond six typical errors is not one of what is left.
const MOST: f32 = 6.0;

/// What the physics says of a whole frame, and what the network sees of it.
#[derive(Debug, Clone, Default)]
pub struct Scene {
    rows: usize,
    columns: usize,
    /// Loads by the exact inverse, grams.
    pub loads_g: Vec<f32>,
    row_g: Vec<f32>,
    column_g: Vec<f32>,
    row_siemens: Vec<f64>,
    column_siemens: Vec<f64>,
    marked: Vec<bool>,
    siemens: Vec<f64>,
}

impl Scene {
    /// Looks at a solved frame: conductances, then loads, of every taxel.
    ///
    /// # Errors
    /// A sensor without a load law.
    pub fn look(&mut self, result: FrameResult<'_>) -> Result<(), taxel::Error> {
        let siemens = result.siemens;
        (self.rows, self.columns) = (siemens.rows(), siemens.columns());
        self.siemens.clear();
        self.siemens.extend_from_slice(siemens.values());
        let loads = result.newtons()?;
        self.loads_g.clear();
        self.loads_g.extend(
            loads
                .values()
                .iter()
                .map(|&n| taxel::frame::grams_from_newtons(n) as f32),
        );
        self.marked.clear();
        self.marked
            .extend(loads.marks().iter().map(|&m| m != taxel::Mark::Good));
        self.sum_lines();
        Ok(())
    }

    fn sum_lines(&mut self) {
        for (sums, lines) in [
            (&mut self.row_g, self.rows),
            (&mut self.column_g, self.columns),
        ] {
            sums.clear();
            sums.resize(lines, 0.0);
        }
        for (sums, lines) in [
            (&mut self.row_siemens, self.rows),
            (&mut self.column_siemens, self.columns),
        ] {
            sums.clear();
            sums.resize(lines, 0.0);
        }
        for row in 0..self.rows {
            for column in 0..self.columns {
                let at = row * self.columns + column;
                self.row_g[row] += self.loads_g[at];
                self.column_g[column] += self.loads_g[at];
                self.row_siemens[row] += self.siemens[at].max(0.0);
                self.column_siemens[column] += self.siemens[at].max(0.0);
            }
        }
    }

    /// Load and conductance, its standard error (first order: the converter's over what the lines let through), row
    /// and column sums, neighbours, marks around, the taxel's own gain.
    pub fn features(&self, row: usize, column: usize, physics: &Physics) -> [f32; FEATURES] {
        let at = row * self.columns + column;
        let load = self.loads_g[at];
        let scale = 1.0 / 100.0;
        let (mut near, mut far, mut marked) = (0.0, 0.0, 0.0);
        for r in row.saturating_sub(2)..(row + 3).min(self.rows) {
            for c in column.saturating_sub(2)..(column + 3).min(self.columns) {
                let away = r.abs_diff(row).max(c.abs_diff(column));
                let other = r * self.columns + c;
                match away {
                    0 => {}
                    1 => near += self.loads_g[other],
                    _ => far += self.loads_g[other],
                }
                marked += f32::from(u8::from(self.marked[other]));
            }
        }
        let through = (1.0 + physics.row_ohms * self.row_siemens[row])
            * (1.0 + physics.column_ohms * self.column_siemens[column]);
        let error = physics.siemens_per_count * through / self.siemens[at].abs().max(1e-9);
        [
            load * scale,
            (load * scale).max(0.0).sqrt(),
            (1.0 + load * scale).ln(),
            near * scale / 8.0,
            far * scale / 16.0,
            self.row_g[row] * scale / 20.0,
            self.column_g[column] * scale / 20.0,
            (error as f32).min(1.0),
            physics.gain(at),
            marked / 9.0,
        ]
    }
}

/// What the features need of the sensor.
#[derive(Debug, Clone, PartialEq)]
pub struct Physics {
    row_ohms: f64,
    column_ohms: f64,
    siemens_per_count: f64,
    ln_scale: Vec<f64>,
    mean_ln_scale: f64,
}

impl Physics {
    /// Of a calibrated sensor.
    pub fn of(sensor: &taxel::Sensor, law: &LoadLaw) -> Self {
        let readout = &sensor.readout;
        let mean = |list: &Option<taxel::sensor::PerLine>, lines| {
            list.as_ref().map_or(0.0, |list| list.mean(lines))
        };
        let lsb = taxel::circuit::Converter::from_sensor(sensor).lsb_volts();
        Self {
            row_ohms: mean(&readout.r_mux_row_ohms, sensor.rows()),
            column_ohms: mean(&readout.r_mux_column_ohms, sensor.columns()),
            siemens_per_count: Raw::from_sensor(sensor).siemens_from_volts(lsb).abs(),
            mean_ln_scale: law.ln_scale.iter().sum::<f64>() / law.ln_scale.len() as f64,
            ln_scale: law.ln_scale.clone(),
        }
    }

    /// ln of the taxel's gain over the mean.
    fn gain(&self, taxel: usize) -> f32 {
        match self.ln_scale.as_slice() {
            [_] => 0.0,
            each => (each[taxel] - self.mean_ln_scale) as f32,
        }
    }
}

/// A labelled press as the hybrid sees it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Example {
    /// What the network sees.
    pub features: [f32; FEATURES],
    /// Load by the physics, grams.
    pub physics_g: f32,
    /// True load, grams.
    pub load_g: f32,
}

/// The mean of a few small networks, each trained without one part of the presses; none where physics was better.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Hybrid {
    /// Of the features, over the training part.
    pub scaler: Scaler,
    /// s(L) at no load, and what it grows by per gram.
    pub typical: Typical,
    /// features → hidden → 1, each.
    pub networks: Vec<Mlp>,
}

/// The error that the physics typically has: floor + slope · load, grams.
#[derive(Debug, Clone, Copy, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Typical {
    /// At no load, grams.
    pub floor_g: f32,
    /// Per gram.
    pub slope: f32,
}

impl Typical {
    /// By the medians of the lighter and of the heavier half of the presses.
    fn fit(examples: &[Example]) -> Self {
        let mut sorted: Vec<(f32, f32)> = examples
            .iter()
            .map(|e| (e.physics_g, (e.physics_g - e.load_g).abs()))
            .collect();
        sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
        let middle = |half: &[(f32, f32)], of: fn(&(f32, f32)) -> f32| {
            let mut values: Vec<f32> = half.iter().map(of).collect();
            values.sort_by(f32::total_cmp);
            values.get(values.len() / 2).copied().unwrap_or(0.0)
        };
        let (light, heavy) = sorted.split_at(sorted.len() / 2);
        let (x0, x1) = (middle(light, |p| p.0), middle(heavy, |p| p.0));
        let (y0, y1) = (middle(light, |p| p.1), middle(heavy, |p| p.1));
        let slope = ((y1 - y0) / (x1 - x0).max(1.0)).max(0.0);
        Self {
            floor_g: (y0 - slope * x0).max(0.25 * y0).max(1e-4),
            slope,
        }
    }

    fn at(self, load_g: f32) -> f32 {
        self.floor_g + self.slope * load_g
    }
}

/// Memory of [`Hybrid`] for one stream of frames.
#[derive(Debug, Clone, Default)]
pub struct HybridMemory {
    inputs: Vec<f32>,
    sums: Vec<f32>,
    trace: Trace,
}

/// What the cross-validation of a hybrid said.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Verdict {
    /// Mean absolute error of the physics on the presses, grams.
    pub physics_g: f64,
    /// Of the hybrid on presses its network had not seen, grams.
    pub hybrid_g: f64,
    /// What the network gains, press by press, in standard errors.
    pub standard_errors: f64,
    /// Whether the network is used.
    pub used: bool,
}

impl Hybrid {
    /// Corrects loads by the physics, grams, given what the network sees of each.
    pub fn correct(
        &self,
        features: &[[f32; FEATURES]],
        loads_g: &mut [f32],
        memory: &mut HybridMemory,
    ) {
        if self.networks.is_empty() {
            return;
        }
        memory.inputs.clear();
        for row in features {
            let mut scaled = *row;
            self.scaler.scale(&mut scaled);
            // Beyond what was seen the correction stays what it was at the edge.
            memory.inputs.extend(scaled.map(|x| x.clamp(-3.0, 3.0)));
        }
        memory.sums.clear();
        memory.sums.resize(features.len(), 0.0);
        for network in &self.networks {
            network.forward(&memory.inputs, &mut memory.trace);
            for (sum, y) in memory.sums.iter_mut().zip(memory.trace.output()) {
                *sum += y.clamp(-MOST, MOST) / self.networks.len() as f32;
            }
        }
        for (load, sum) in loads_g.iter_mut().zip(&memory.sums) {
            if *load >= LEAST_G {
                *load = (*load + self.typical.at(*load) * sum).max(0.0);
            }
        }
    }

    /// Trains by cross-validation over the presses in `folds` parts, and keeps the networks only if presses gain
    /// by more than two standard errors. `estimates` of the second answer are on presses not seen.
    pub fn train(
        examples: &[Example],
        folds: usize,
        epochs: usize,
        seed: u64,
        progress: &mut dyn FnMut(f64) -> Go,
    ) -> (Self, Verdict) {
        let flat: Vec<f32> = examples.iter().flat_map(|e| e.features).collect();
        let scaler = Scaler::fit(&flat, FEATURES);
        let typical = Typical::fit(examples);
        let mut networks = Vec::new();
        let mut gains = Vec::new();
        let (mut of_physics, mut of_hybrid) = (0.0, 0.0);
        for fold in 0..folds {
            let train_on: Vec<Example> = part(examples, |i| i % folds != fold);
            let held: Vec<Example> = part(examples, |i| i % folds == fold);
            let mut training = Training::new(&scaler, typical, &train_on, seed + fold as u64);
            let settings = Settings {
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
            };
            let mut stopped = false;
            train(&mut training, &settings, None, &mut |epoch, _| {
                let share = (fold as f64 + epoch.epoch as f64 / epochs as f64) / folds as f64;
                let go = progress(share);
                stopped |= go == Go::Stop;
                go
            });
            let one = Self {
                scaler: scaler.clone(),
                typical,
                networks: vec![training.network],
            };
            let features: Vec<[f32; FEATURES]> = held.iter().map(|e| e.features).collect();
            let mut loads: Vec<f32> = held.iter().map(|e| e.physics_g).collect();
            one.correct(&features, &mut loads, &mut HybridMemory::default());
            for (example, load) in held.iter().zip(loads) {
                let physics = f64::from((example.physics_g - example.load_g).abs());
                let hybrid = f64::from((load - example.load_g).abs());
                of_physics += physics;
                of_hybrid += hybrid;
                gains.push(physics - hybrid);
            }
            networks.extend(one.networks);
            if stopped {
                break;
            }
        }
        let count = gains.len().max(1) as f64;
        let mean = gains.iter().sum::<f64>() / count;
        let error = (gains.iter().map(|g| (g - mean).powi(2)).sum::<f64>()
            / (count * (count - 1.0).max(1.0)))
        .sqrt();
        let verdict = Verdict {
            physics_g: of_physics / count,
            hybrid_g: of_hybrid / count,
            standard_errors: mean / error.max(1e-12),
            used: mean > 0.0 && mean > 2.0 * error,
        };
        if !verdict.used {
            networks.clear();
        }
        (
            Self {
                scaler,
                typical,
                networks,
            },
            verdict,
        )
    }
}

fn part(examples: &[Example], keep: impl Fn(usize) -> bool) -> Vec<Example> {
    examples
        .iter()
        .enumerate()
        .filter(|(i, _)| keep(*i))
        .map(|(_, e)| *e)
        .collect()
}

/// One network of a hybrid in training. The loss is Huber's, in typical errors: a press that went wrong must not
/// bend the rest.
struct Training<'a> {
    network: Mlp,
    examples: &'a [Example],
    inputs: Vec<f32>,
    /// What y should be: (true load − L)/s(L).
    wanted: Vec<f32>,
    typical: Typical,
    batch: Vec<f32>,
    by_output: Vec<f32>,
    trace: Trace,
}

/// Where Huber's loss turns from square to straight.
const HUBER: f32 = 3.0;

impl<'a> Training<'a> {
    fn new(scaler: &Scaler, typical: Typical, examples: &'a [Example], seed: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut inputs = Vec::with_capacity(examples.len() * FEATURES);
        for example in examples {
            let mut row = example.features;
            scaler.scale(&mut row);
            inputs.extend(row.map(|x| x.clamp(-3.0, 3.0)));
        }
        Self {
            network: starting_at_nothing(Mlp::new(&[FEATURES, HIDDEN, 1], false, &mut random)),
            wanted: examples
                .iter()
                .map(|e| (e.load_g - e.physics_g) / typical.at(e.physics_g))
                .collect(),
            examples,
            inputs,
            typical,
            batch: Vec::new(),
            by_output: Vec::new(),
            trace: Trace::default(),
        }
    }
}

impl Trainable for Training<'_> {
    fn networks(&mut self) -> Vec<&mut Mlp> {
        vec![&mut self.network]
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
        self.network.forward(&self.batch, &mut self.trace);
        let count = which.len() as f32;
        let mut loss = 0.0;
        self.by_output.clear();
        for (&i, y) in which.iter().zip(self.trace.output()) {
            let off = y - self.wanted[i];
            let held = off.clamp(-HUBER, HUBER);
            loss += f64::from(held * (off - 0.5 * held));
            self.by_output.push(held / count);
        }
        self.network.backward(
            &self.batch,
            &self.by_output,
            &mut self.trace,
            &mut gradients[0],
            false,
        );
        loss / f64::from(count)
    }

    fn check(&mut self) -> f64 {
        self.network.forward(&self.inputs, &mut self.trace);
        let errors = self
            .trace
            .output()
            .iter()
            .zip(&self.wanted)
            .zip(self.examples)
            .map(|((y, wanted), e)| f64::from((y - wanted).abs() * self.typical.at(e.physics_g)));
        errors.sum::<f64>() / self.examples.len() as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::train::assert_gradient;
    use rand::RngExt;

    /// Presses whose physics is off by `bias` of the load, and by noise.
    fn examples(bias: f32) -> Vec<Example> {
        let mut random = ChaCha8Rng::seed_from_u64(8);
        (0..120)
            .map(|_| {
                let load_g = 20.0 + 400.0 * random.random::<f32>();
                let physics_g = load_g * (1.0 + bias) + random.random::<f32>() - 0.5;
                let mut features = [0.0; FEATURES];
                features.fill_with(|| random.random::<f32>());
                features[0] = physics_g / 100.0;
                Example {
                    features,
                    physics_g,
                    load_g,
                }
            })
            .collect()
    }

    #[test]
    fn gradients_agree_with_finite_differences() {
        let examples = examples(0.02);
        let flat: Vec<f32> = examples.iter().flat_map(|e| e.features).collect();
        let scaler = Scaler::fit(&flat, FEATURES);
        let mut training = Training::new(&scaler, Typical::fit(&examples), &examples, 2);
        let which: Vec<usize> = (0..40).collect();
        assert_gradient(&mut training, &which, 0.02);
    }

    #[test]
    fn physics_that_is_right_is_left_alone_and_a_bias_is_learnt() {
        let (_, verdict) = Hybrid::train(&examples(0.0), 5, 60, 1, &mut |_| Go::On);
        assert!(!verdict.used, "{verdict:?}");
        let (model, verdict) = Hybrid::train(&examples(0.03), 5, 200, 1, &mut |_| Go::On);
        assert!(verdict.used, "{verdict:?}");
        assert!(verdict.hybrid_g < 0.5 * verdict.physics_g, "{verdict:?}");
        assert_eq!(model.networks.len(), 5);
    }
}
