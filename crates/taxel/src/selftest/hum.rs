//! Mains hum in the empty recording.
//!
//! Taxel k of a frame that began at t_j is read at t_j + k/(rate · taxels): the readings are one long series in time, far
//! denser than the frames. Each frame is reduced to one complex number per mains frequency f,
//! Z_j = Σ_k (reading − what the taxel usually reads) e^(−2πi f k/(rate · taxels)), its mean over the frames is taken
//! off (what a taxel always reads, wherever it comes from), and |Σ_j Z_j e^(−2πi f t_j)|² is the periodogram of the whole
//! series at f (Lomb 1976, *Astrophysics and Space Science* 39:447). It is searched ±1 Hz about f, for clocks that
//! are off, and compared with its median over one alias band around f: the noise floor, at which it is exponentially
//! distributed.
//!
//! The sum within the frame is what tells frequencies apart that the frame rate alone folds onto each other.

use std::f64::consts::{LN_2, TAU};

use super::SelfTestOptions;
use super::quiet::median;
use crate::sensor::ScanOrder;
use crate::stats::SIGMA_PER_MAD;
use crate::{Counts, Frame};

/// The mains, and the double that rectifiers and lamps leave, hertz.
const FREQUENCIES: [f64; 4] = [50.0, 60.0, 100.0, 120.0];
/// How far the mains and the clock of the scan may be off together, hertz.
const REACH_HZ: f64 = 1.0;
/// Frames from which the usual reading of a taxel is taken before the search begins.
const WARM_UP: usize = 16;
/// Fewest frames of the search.
const MIN: usize = 32;
/// Most frames of the search: 5 MB.
const MAX: usize = 1 << 16;
/// Points of the alias band.
const BAND_POINTS: usize = 512;
/// A second peak below this share of the largest is an alias of it, not hum of its own.
const OWN_SHARE: f64 = 0.3;
/// Readings further than this many standard deviations from the usual one count as that far: faults are no hum.
const REACH_SIGMAS: f64 = 8.0;

/// Hum, or how little of it there can be.
#[derive(Debug, Clone, PartialEq)]
pub enum Hum {
    /// At these mains frequencies, the largest first.
    Found(Vec<Peak>),
    /// None; an amplitude above this one would have been found, counts.
    Below(f64),
    /// The frames have no times and no rate was given.
    Untimed,
    /// Why it cannot be judged.
    NotJudged(String),
}

/// A mains frequency at which the readings swing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Peak {
    /// Of the mains (50 or 60 Hz), or twice that, hertz.
    pub mains_hz: f64,
    /// Where the peak is, by the recording's clock, hertz.
    pub at_hz: f64,
    /// Amplitude, counts.
    pub amplitude_counts: f64,
    /// Probability that chance makes a peak as high.
    pub chance: f64,
}

/// Follows the empty recording.
#[derive(Debug, Clone)]
pub(super) struct HumSearch {
    order: ScanOrder,
    rate: Option<f64>,
    first: Vec<Vec<f32>>,
    first_times: Vec<f64>,
    seen: u64,
    untimed: bool,
    /// Usual reading of every taxel, and the reach.
    usual: Vec<f64>,
    reach: f64,
    /// Cosine and sine of every taxel's phase, one list per frequency.
    phases: Vec<Vec<[f64; 2]>>,
    /// Time, and one complex number per frequency.
    frames: Vec<(f64, [[f64; 2]; FREQUENCIES.len()])>,
}

impl HumSearch {
    pub fn new(options: &SelfTestOptions) -> Self {
        Self {
            order: options.scan_order,
            rate: options.frames_per_second,
            first: Vec::new(),
            first_times: Vec::new(),
            seen: 0,
            untimed: false,
            usual: Vec::new(),
            reach: 0.0,
            phases: Vec::new(),
            frames: Vec::new(),
        }
    }

    pub fn observe(&mut self, frame: &Frame<Counts>) {
        let time = match (frame.time_secs, self.rate) {
            (_, Some(rate)) => self.seen as f64 / rate,
            (Some(time), None) => time,
            (None, None) => {
                self.untimed = true;
                return;
            }
        };
        self.seen += 1;
        if self.phases.is_empty() {
            self.first
                .push(frame.values().iter().map(|&v| v as f32).collect());
            self.first_times.push(time);
            if self.first.len() == WARM_UP {
                self.warm_up(frame);
            }
            return;
        }
        if self.frames.len() < MAX {
            self.frames.push((time, self.reduce(frame)));
        }
    }

    /// The usual readings, and the phases at the rate seen so far.
    fn warm_up(&mut self, frame: &Frame<Counts>) {
        let taxels = frame.values().len();
        let mut spreads = Vec::with_capacity(taxels);
        self.usual = (0..taxels)
            .map(|taxel| {
                let mut values: Vec<f64> = self.first.iter().map(|f| f64::from(f[taxel])).collect();
                let usual = median(&mut values);
                for value in &mut values {
                    *value = (*value - usual).abs();
                }
                spreads.push(SIGMA_PER_MAD * median(&mut values));
                usual
            })
            .collect();
        self.reach = REACH_SIGMAS * median(&mut spreads).max(1.0);
        let span = self.first_times[WARM_UP - 1] - self.first_times[0];
        let period = match self.rate {
            Some(rate) => 1.0 / rate,
            None => span / (WARM_UP - 1) as f64,
        };
        self.first.clear();
        let (rows, columns) = (frame.rows(), frame.columns());
        let phase = |frequency: f64, taxel: usize| {
            let (row, column) = (taxel / columns, taxel % columns);
            let index = match self.order {
                ScanOrder::RowByRow => taxel,
                ScanOrder::ColumnByColumn => column * rows + row,
            };
            let angle = TAU * frequency * period * index as f64 / taxels as f64;
            [angle.cos(), -angle.sin()]
        };
        self.phases = FREQUENCIES
            .iter()
            .map(|&f| (0..taxels).map(|taxel| phase(f, taxel)).collect())
            .collect();
    }

    fn reduce(&self, frame: &Frame<Counts>) -> [[f64; 2]; FREQUENCIES.len()] {
        let mut sums = [[0.0; 2]; FREQUENCIES.len()];
        for (taxel, (value, usual)) in frame.values().iter().zip(&self.usual).enumerate() {
            let off = (value - usual).clamp(-self.reach, self.reach);
            for (sum, phases) in sums.iter_mut().zip(&self.phases) {
                let [re, im] = phases[taxel];
                sum[0] += off * re;
                sum[1] += off * im;
            }
        }
        sums
    }

    pub fn finish(&self, taxels: usize, options: &SelfTestOptions) -> Hum {
        if self.untimed {
            return Hum::Untimed;
        }
        let frames = self.frames.len();
        if frames < MIN {
            return Hum::NotJudged(format!(
                "{frames} frames after the first {WARM_UP} of the empty recording; it takes {MIN}"
            ));
        }
        let duration = self.frames[frames - 1].0 - self.frames[0].0;
        let rate = (frames - 1) as f64 / duration;
        if !(rate.is_finite() && rate > 0.0) {
            return Hum::NotJudged(format!("the empty recording lasts {duration} s"));
        }
        let per_count = 2.0 / (frames * taxels) as f64;
        let (mut peaks, mut bounds, mut hidden) = (Vec::new(), Vec::new(), Vec::new());
        for (i, &mains_hz) in FREQUENCIES.iter().enumerate() {
            match self.search(i, rate, duration) {
                None => hidden.push(mains_hz),
                Some((at_hz, power, floor, trials)) => {
                    let chance = (trials * (-power / floor).exp()).min(1.0);
                    let amplitude_counts = per_count * power.sqrt();
                    let needed = floor * (trials / options.hum_probability).ln();
                    bounds.push((per_count * needed.sqrt()).max(options.hum_counts));
                    if chance < options.hum_probability && amplitude_counts >= options.hum_counts {
                        peaks.push(Peak {
                            mains_hz,
                            at_hz,
                            amplitude_counts,
                            chance,
                        });
                    }
                }
            }
        }
        peaks.sort_by(|a, b| b.amplitude_counts.total_cmp(&a.amplitude_counts));
        if let Some(largest) = peaks.first().map(|p| p.amplitude_counts) {
            peaks.retain(|peak| peak.amplitude_counts >= OWN_SHARE * largest);
            return Hum::Found(peaks);
        }
        if hidden.iter().any(|&f| f <= 60.0) {
            let hidden: Vec<String> = hidden.iter().map(f64::to_string).collect();
            return Hum::NotJudged(format!(
                "at {rate:.2} frames/s hum of {} Hz stands still; record at another rate",
                hidden.join(" and ")
            ));
        }
        Hum::Below(bounds.into_iter().fold(0.0, f64::max))
    }

    /// Frequency and power of the highest point near a mains frequency, the floor, and how many independent points were
    /// looked at. Nothing where the mains stand still from frame to frame.
    fn search(&self, which: usize, rate: f64, duration: f64) -> Option<(f64, f64, f64, f64)> {
        let centre = FREQUENCIES[which];
        let count = self.frames.len() as f64;
        let mean = [0, 1].map(|part| {
            let sum: f64 = self.frames.iter().map(|(_, z)| z[which][part]).sum();
            sum / count
        });
        // What drifts, or stands, is no hum.
        let near_standing = (3.0 / duration).max(0.2);
        let stands = |f: f64| (f - (f / rate).round() * rate).abs() < near_standing;
        if stands(centre) {
            return None;
        }
        let reach = REACH_HZ.min(rate / 8.0);
        let step = 0.25 / duration;
        let steps = (reach / step).floor() as i64;
        let mut best = (centre, 0.0);
        for frequency in (-steps..=steps).map(|i| centre + i as f64 * step) {
            let power = self.power(which, frequency, mean);
            if power > best.1 && !stands(frequency) {
                best = (frequency, power);
            }
        }
        let band =
            (0..BAND_POINTS).map(|i| centre + rate * ((i as f64 + 0.5) / BAND_POINTS as f64 - 0.5));
        let mut powers: Vec<f64> = band
            .filter(|&f| (f - centre).abs() > reach && !stands(f))
            .map(|f| self.power(which, f, mean))
            .collect();
        let floor = median(&mut powers) / LN_2;
        let trials = FREQUENCIES.len() as f64 * (2.0 * reach * duration).max(1.0);
        (floor > 0.0).then_some((best.0, best.1, floor, trials))
    }

    fn power(&self, which: usize, frequency: f64, mean: [f64; 2]) -> f64 {
        let begun = self.frames[0].0;
        let (mut re, mut im) = (0.0, 0.0);
        for (time, z) in &self.frames {
            let (sin, cos) = (TAU * frequency * (time - begun)).sin_cos();
            let (a, b) = (z[which][0] - mean[0], z[which][1] - mean[1]);
            re += a * cos + b * sin;
            im += b * cos - a * sin;
        }
        re * re + im * im
    }
}
