//! Frames as what they say of the circuit: counts of V_out, some of them bounds, with their noise.

use super::Known;
use crate::circuit::{Converter, ROUNDING_COUNTS};
use crate::screen::{Axis, LineScreen};
use crate::simulate::default_noise_counts;
use crate::{Counts, Error, Frame, Mark};

/// Frames that a fit takes at most, and taxels of all of them together, unless one frame has more.
const MOST_FRAMES: usize = 20;
const MOST_TAXELS: usize = 5120;
/// Fewest frames, however large the array is.
const FEWEST_FRAMES: usize = 2;
/// Estimated noise is believed up to this many times the usual one: changing loads look like noise, too.
const MOST_NOISE: f64 = 5.0;

/// What a reading says of V_out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Reading {
    /// It is this, but for noise.
    Is(f64),
    /// It is this or more.
    AtLeast(f64),
    /// It is this or less.
    AtMost(f64),
    /// Nothing: a dead line, or no taxel.
    Nothing,
}

impl Reading {
    /// Predicted less read, counts; 0 where a bound holds.
    pub(super) fn residual(self, predicted: f64) -> f64 {
        match self {
            Self::Is(value) => predicted - value,
            Self::AtLeast(value) => (predicted - value).min(0.0),
            Self::AtMost(value) => (predicted - value).max(0.0),
            Self::Nothing => 0.0,
        }
    }

    /// The number that stands there, or 0.
    pub(super) fn counts(self) -> f64 {
        match self {
            Self::Is(value) | Self::AtLeast(value) | Self::AtMost(value) => value,
            Self::Nothing => 0.0,
        }
    }
}

/// Frames to explain.
#[derive(Debug, Clone)]
pub(super) struct Readings {
    pub(super) columns: usize,
    pub(super) frames: Vec<Vec<Reading>>,
    /// Of every crossing, whether it has no taxel.
    pub(super) absent: Vec<bool>,
    /// Standard deviation of a reading, rounding included, counts.
    pub(super) sigma: f64,
}

impl Readings {
    /// The most telling ones of these frames.
    pub(super) fn new(known: &Known, frames: &[Frame<Counts>]) -> Result<Self, Error> {
        let mut all = Self::all(known, frames)?;
        all.frames = chosen(all.frames);
        Ok(all)
    }

    /// All of them.
    pub(super) fn all(known: &Known, frames: &[Frame<Counts>]) -> Result<Self, Error> {
        let sensor = &known.sensor;
        let converter = Converter::from_sensor(sensor);
        let per_count = converter.count_from_volt(1.0) - converter.count_from_volt(0.0);
        let mut screen = LineScreen::from_sensor(sensor);
        for frame in frames {
            screen.observe(frame)?;
        }
        let faults = screen.finish().with_declared(sensor.screen());
        let lost =
            |axis| -> Vec<usize> { faults.dead(axis).chain(faults.flickering(axis)).collect() };
        let (rows, columns) = (lost(Axis::Row), lost(Axis::Column));
        let width = sensor.columns();
        let absent: Vec<bool> = (0..sensor.rows() * width)
            .map(|at| {
                sensor.is_absent(at)
                    || rows.contains(&(at / width))
                    || columns.contains(&(at % width))
            })
            .collect();
        let usual = default_noise_counts(sensor.converter().bits);
        let estimated = screen.level().map_or(usual, |level| level.noise_counts);
        let noise = sensor.converter().noise_counts;
        let noise = noise.unwrap_or(estimated.clamp(usual, MOST_NOISE * usual));
        let all = frames.iter().map(|frame| {
            let volts = converter.volts_from_counts(frame);
            let each = volts.values().iter().zip(volts.marks()).zip(&absent);
            each.map(|((&volts, &mark), &absent)| {
                let counts = volts * per_count;
                match mark {
                    _ if absent => Reading::Nothing,
                    Mark::Good => Reading::Is(counts),
                    Mark::Saturated => Reading::AtLeast(counts),
                    Mark::BelowFloor => Reading::AtMost(counts),
                    _ => Reading::Nothing,
                }
            })
            .collect()
        });
        let all: Vec<Vec<Reading>> = all.collect();
        Ok(Self {
            columns: width,
            frames: all,
            absent,
            sigma: noise.hypot(ROUNDING_COUNTS),
        })
    }

    /// Readings that say something, bounds included.
    pub(super) fn count(&self) -> usize {
        let all = self.frames.iter().flatten();
        all.filter(|reading| **reading != Reading::Nothing).count()
    }

    /// Whether no frame says of any taxel that it is pressed: all of its readings are alike.
    pub(super) fn are_alike(&self) -> bool {
        self.frames.iter().all(|frame| {
            let said = frame.iter().filter(|reading| **reading != Reading::Nothing);
            let counts = said.map(|reading| reading.counts());
            let ends = counts.fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), now| {
                (least.min(now), most.max(now))
            });
            ends.1 - ends.0 <= 8.0 * self.sigma
        })
    }
}

/// The frame with the largest sum, then always the one that differs most from those chosen.
fn chosen(mut frames: Vec<Vec<Reading>>) -> Vec<Vec<Reading>> {
    let taxels = frames.first().map_or(1, Vec::len);
    let most = (MOST_TAXELS / taxels).clamp(FEWEST_FRAMES, MOST_FRAMES);
    let sum = |frame: &Vec<Reading>| frame.iter().map(|r| r.counts()).sum::<f64>();
    let distance = |a: &[Reading], b: &[Reading]| -> f64 {
        let pairs = a.iter().zip(b);
        pairs.map(|(a, b)| (a.counts() - b.counts()).abs()).sum()
    };
    let mut taken: Vec<Vec<Reading>> = Vec::new();
    let mut nearest = vec![f64::INFINITY; frames.len()];
    while taken.len() < most && !frames.is_empty() {
        let worth = |at: usize| {
            if taken.is_empty() {
                sum(&frames[at])
            } else {
                nearest[at]
            }
        };
        let best = (0..frames.len()).max_by(|&a, &b| worth(a).total_cmp(&worth(b)));
        let Some(best) = best.filter(|&at| worth(at) > 0.0) else {
            break;
        };
        nearest.swap_remove(best);
        let frame = frames.swap_remove(best);
        for (nearest, other) in nearest.iter_mut().zip(&frames) {
            *nearest = nearest.min(distance(&frame, other));
        }
        taken.push(frame);
    }
    taken
}
