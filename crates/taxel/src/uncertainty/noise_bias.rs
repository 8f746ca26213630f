//! What noise adds to loads in the mean: the inverse bends, and a sum over many taxels does not average that out.
//!
//! Where lines are left open each reading goes through all taxels, and the loads found are a curved function x(y) of the
//! readings. Noise of variance σ² then moves their mean by ½ σ² Σ ∂²x/∂y_j²: nothing beside the scatter of one taxel, but of
//! one sign at all loaded ones. A hand on 16 × 16 taxels of 10 bits with half a count of noise sums to 9 % too much.
//!
//! Source: second-order propagation of errors; the sum over j by random signs, Hutchinson, *Communications in Statistics* 19:433
//! (1990), with differences of the whole inverse in place of its second derivative.

use super::load::noise_counts_of;
use crate::circuit::Converter;
use crate::pipeline::Pipeline;
use crate::screen::Level;
use crate::{Frame, Newtons, Sensor, Siemens, Volts};

/// Draws a frame: two tell how far they are apart.
pub const DRAWS: usize = 2;
/// Steps of the differences, standard deviations of a reading: large beside what an inverse leaves, small beside its bends.
const STEP: f64 = 0.2;

/// What noise adds to the loads of frames of one sensor.
pub struct NoiseBias {
    pipeline: Pipeline,
    sigma_volts: f64,
    volts: Frame<Volts>,
    bias: Bias,
    /// Square of what noise moves each load by, newtons², by the draws of a frame.
    noise: Vec<f64>,
}

/// What noise has added to each load of a frame, newtons, by two draws; their mean is the estimate, and of a sum alone it is
/// worth something.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Bias {
    /// By each draw, of every taxel.
    pub draws: [Vec<f64>; DRAWS],
    /// What the bends at loads that may be none would add, newtons, and nothing at all others: in no draw, but readings of one
    /// voltage are all rounded to the same side, and the loads may be off by as much.
    pub resting: Vec<f64>,
    /// Standard error of all of it, as a share: what the noise's variance is uncertain by.
    pub share: f64,
}

impl Bias {
    /// What noise has added to the sum of all loads, newtons.
    pub fn of_sum(&self) -> f64 {
        self.draws.iter().flatten().sum::<f64>() / DRAWS as f64
    }
}

/// Standard deviations of a load from nothing, below which it may be none: a law bends to either side there, and what noise
/// adds to taxels without load is nothing in the mean.
const RESTING: f64 = 2.0;
/// So many times what differences tell the bend at nothing may add: no power of a load has a second derivative there.
const SHARPER: f64 = 1.5;
/// Of a noise that the sensor file tells.
const TOLD_SHARE: f64 = 0.1;
/// Of one that was found in the recording: where loads move from frame to frame it is found too large.
const FOUND_SHARE: f64 = 0.5;

impl NoiseBias {
    /// For frames of a sensor that come to loads by `pipeline`, of which this has one of its own; `level`: what a recording
    /// says of its noise. `None` where it is nothing worth the work: lines are not left open, or loads hang on the frames
    /// before.
    pub fn new(sensor: &Sensor, pipeline: Pipeline, level: Option<Level>) -> Option<Self> {
        let is_bent = sensor.readout().has_open_columns() && sensor.exported().is_none();
        let (rows, columns) = (sensor.rows(), sensor.columns());
        let is_able = pipeline.has_siemens() && pipeline.has_loads() && !pipeline.remembers();
        (is_bent && is_able).then(|| Self {
            pipeline,
            sigma_volts: noise_counts_of(sensor, level)
                * Converter::from_sensor(sensor).lsb_volts(),
            volts: Frame::zeros(rows, columns),
            noise: vec![0.0; rows * columns],
            bias: Bias {
                draws: [vec![0.0; rows * columns], vec![0.0; rows * columns]],
                resting: vec![0.0; rows * columns],
                share: match sensor.converter().noise_counts {
                    Some(_) => TOLD_SHARE,
                    None => FOUND_SHARE,
                },
            },
        })
    }

    /// Makes the next frame the first.
    pub fn begin_anew(&mut self) {
        self.pipeline.begin_anew();
    }

    /// What noise has added to the loads of a frame. `None` where an inverse nearby comes to no answer.
    ///
    /// # Panics
    /// When a frame's shape is not the sensor's.
    pub fn of(&mut self, volts: &Frame<Volts>, loads: &Frame<Newtons>) -> Option<&Bias> {
        self.noise.fill(0.0);
        for draw in 0..DRAWS {
            self.bias.draws[draw].fill(0.0);
            for sign in [1.0, -1.0] {
                self.volts.copy_meta_from(volts);
                let each = self.volts.values_mut().iter_mut().zip(volts.values());
                for (taxel, (moved, read)) in each.enumerate() {
                    let toss = toss(volts.sequence, draw, taxel);
                    *moved = read + sign * toss * STEP * self.sigma_volts;
                }
                let result = self.pipeline.process_volts(&self.volts);
                let found = result.loads.filter(|_| result.outcome.is_answer())?;
                let sums = self.bias.draws[draw].iter_mut().zip(&mut self.noise);
                let moves = found.values().iter().zip(loads.values());
                for ((sum, square), (moved, load)) in sums.zip(moves) {
                    *sum += (moved - load) / (2.0 * STEP * STEP);
                    *square += ((moved - load) / STEP).powi(2) / (2 * DRAWS) as f64;
                }
            }
        }
        self.take_off_resting(loads);
        Some(&self.bias)
    }

    /// Moves what the draws say of loads that may be none from them to what is uncertain.
    fn take_off_resting(&mut self, loads: &Frame<Newtons>) {
        let Bias { draws, resting, .. } = &mut self.bias;
        let each = loads.values().iter().zip(&self.noise).enumerate();
        for (taxel, (load, square)) in each {
            resting[taxel] = 0.0;
            if load.powi(2) < RESTING.powi(2) * square {
                for draw in &mut *draws {
                    resting[taxel] += SHARPER / DRAWS as f64 * std::mem::take(&mut draw[taxel]);
                }
            }
        }
    }
}

/// Takes what noise of `sigma_volts` adds to the conductances of a frame in the mean off them. `pipeline` is of the frame's sensor,
/// `volts` what it solved; it is left at another frame. Whether there was an answer on both sides of every draw: otherwise nothing
/// is taken off.
pub(crate) fn take_off_siemens(
    pipeline: &mut Pipeline,
    volts: &Frame<Volts>,
    sigma_volts: f64,
    siemens: &mut Frame<Siemens>,
) -> bool {
    let mut moved = volts.clone();
    let mut added = vec![0.0; siemens.values().len()];
    for draw in 0..DRAWS {
        for sign in [1.0, -1.0] {
            let each = moved.values_mut().iter_mut().zip(volts.values());
            for (taxel, (moved, read)) in each.enumerate() {
                *moved = read + sign * toss(volts.sequence, draw, taxel) * STEP * sigma_volts;
            }
            let result = pipeline.process_volts(&moved);
            let Some(found) = result.siemens.filter(|_| result.outcome.is_answer()) else {
                return false;
            };
            let each = found.values().iter().zip(siemens.values());
            for (added, (there, here)) in added.iter_mut().zip(each) {
                *added += (there - here) / (2.0 * STEP * STEP * DRAWS as f64);
            }
        }
    }
    for (siemens, added) in siemens.values_mut().iter_mut().zip(added) {
        *siemens -= added;
    }
    true
}

/// 1 or −1, the same for a frame and a taxel whoever asks.
fn toss(sequence: u64, draw: usize, taxel: usize) -> f64 {
    // SplitMix64, Steele, Lea and Flood, OOPSLA 2014.
    let at = (sequence * DRAWS as u64 + draw as u64).wrapping_mul(0x1_0000_0000) ^ taxel as u64;
    let mut z = at.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    if (z ^ (z >> 31)) & 1 == 0 { 1.0 } else { -1.0 }
}
