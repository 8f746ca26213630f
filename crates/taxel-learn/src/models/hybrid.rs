//! Physics first, then a small network on what is left of the error.
//!
//! load = L + s(L) · y(features), L the load by the exact inverse, s(L) the error it typically has at that load. Every
//! network starts at y = 0, the physics itself, and is kept only where held-out presses gain by it.

mod training;

use taxel::material::LoadLaw;
use taxel::pipeline::FrameResult;
use taxel::solve::Raw;
use taxel::stats::median;

use crate::network::{Mlp, Trace};
use crate::scaler::Scaler;

pub use training::Trained;

/// Numbers that the network sees of a taxel.
pub const FEATURES: usize = 10;
/// Loads below this are left to the physics, grams.
pub const MIN_G: f32 = 2.0;
/// Largest |y|: a correction beyond six typical errors is not one of what is left.
const MAX: f32 = 6.0;

/// What the physics says of a whole frame, and what the network sees of it.
#[derive(Debug, Clone, Default)]
pub struct FrameFeatures {
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

impl FrameFeatures {
    /// Looks at a solved frame: conductances, then loads, of every taxel.
    ///
    /// # Errors
    /// A sensor without a load law.
    pub fn look(&mut self, result: FrameResult<'_>) -> Result<(), taxel::Error> {
        let siemens = result.siemens.expect("a pipeline that solves");
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
        let readout = sensor.readout();
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
    /// The frame it is of: presses of one frame share its noise, and stay together in cross-validation.
    pub frame: usize,
}

/// The mean of a few small networks, each with what it learnt from one choice of presses; none where physics was
/// better.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Hybrid {
    /// One for each part of the presses that it was trained without.
    pub members: Vec<Member>,
}

/// One network, and how it sees features and loads: all of it from the same presses.
#[derive(Debug, Clone, PartialEq)]
pub struct Member {
    /// Of the features.
    pub scaler: Scaler,
    /// s(L).
    pub typical: Typical,
    /// features → hidden → 1.
    pub network: Mlp,
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
            median(half.iter().map(|pair| f64::from(of(pair)))).unwrap_or(0.0) as f32
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
pub struct HybridScratch {
    inputs: Vec<f32>,
    sums: Vec<f32>,
    trace: Trace,
}

/// What the cross-validation of a hybrid said.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct CvResult {
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
        memory: &mut HybridScratch,
    ) {
        if self.members.is_empty() {
            return;
        }
        memory.sums.clear();
        memory.sums.resize(features.len(), 0.0);
        for member in &self.members {
            memory.inputs.clear();
            for row in features {
                memory.inputs.extend(member.scaled(row));
            }
            member.network.forward(&memory.inputs, &mut memory.trace);
            let outputs = memory.trace.output().iter().zip(loads_g.iter());
            for (sum, (y, load)) in memory.sums.iter_mut().zip(outputs) {
                let correction = member.typical.at(*load) * y.clamp(-MAX, MAX);
                *sum += correction / self.members.len() as f32;
            }
        }
        for (load, sum) in loads_g.iter_mut().zip(&memory.sums) {
            if *load >= MIN_G {
                *load = (*load + sum).max(0.0);
            }
        }
    }
}

impl Member {
    /// Features as the network takes them in. Beyond what was seen the correction stays what it was at the edge.
    fn scaled(&self, features: &[f32; FEATURES]) -> [f32; FEATURES] {
        let mut scaled = *features;
        self.scaler.scale(&mut scaled);
        scaled.map(|x| x.clamp(-3.0, 3.0))
    }
}
