//! What an unloaded taxel reads, and how much a reading varies by itself.

use taxel_linalg::wide;

use super::histogram::{BLOCK, Histogram, nearest};
use super::{ScreenOptions, check_shape};
use crate::circuit::ROUNDING_COUNTS;
use crate::{Counts, Error, Frame, Sensor};

/// Readings needed below the ceiling of unloaded ones before a baseline is stated.
const MIN_READINGS: u64 = 32;
/// Differences needed before the noise is taken from them.
const MIN_DIFFERENCES: u64 = 200;
/// Median of |z| for a standard normal z.
const MEDIAN_ABSOLUTE_NORMAL: f64 = 0.674_489_750_196_081_7;
/// Median of |max(0, z) − max(0, z')| for two standard normal numbers (by simulation).
const MEDIAN_DIFFERENCE_CUT_OFF: f64 = 0.395;
/// Differences of two readings are kept up to this many counts.
const DIFFERENCE_BINS: usize = 2048;
/// Once this many frames weigh in, all of them lose half of their weight: a baseline that drifts is followed.
const HALVED_AFTER_FRAMES: u64 = 1024;
/// What stands for a reading that says nothing: it is in no bin, and near to no baseline.
const LEFT_OUT: f64 = f64::INFINITY;
/// The most bins the readings are sorted into.
const MAX_BINS: f64 = 4096.0;

/// Baseline and noise of the unloaded taxels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Level {
    /// What an unloaded taxel reads: the mode of the unloaded readings, counts.
    pub baseline_counts: f64,
    /// Standard deviation of a reading's noise, counts.
    pub noise_counts: f64,
}

/// Estimates the [`Level`] of a stream of frames with state of constant size.
///
/// The baseline is the half-sample mode (Bickel and Frühwirth 2006, *Computational Statistics & Data Analysis*
/// 50:3500) of all readings near the floor. The noise is the smaller of two robust estimates, each
/// blind to one nuisance: the median distance of the readings below the baseline from it (loads and cross-talk
/// only raise readings; but the taxels' offsets differ), and the median absolute difference of
/// successive readings of unloaded taxels over √2 (offsets cancel; but cross-talk changes). Where the converter cuts
/// the noise off at 0, the same from what is left above; within a third then.
///
/// Frames lose half of their weight every 512 frames, so that a slow drift is followed. A frame of nothing but zeros says
/// nothing of a level: it comes from a read-out that does not answer, or from a converter that cuts all of it off.
#[derive(Debug, Clone)]
pub struct LevelScreen {
    rows: usize,
    columns: usize,
    bins: Histogram,
    width: f64,
    readings: u64,
    frames: u64,
    differences: Histogram,
    previous: Vec<f64>,
    has_previous: bool,
    fixed_baseline: Option<f64>,
    fixed_noise: Option<f64>,
    /// Crossings that read nothing of their own; empty where there are none.
    absent: Vec<bool>,
    /// The readings of the last frame that had some to be left out.
    kept: Vec<f64>,
    floor_count: f64,
    level: Option<Level>,
}

impl LevelScreen {
    /// For the frames of a sensor, as its `screen` says.
    pub fn from_sensor(sensor: &Sensor) -> Self {
        let options = ScreenOptions::from_sensor(sensor);
        Self::new(
            sensor.rows(),
            sensor.columns(),
            sensor.max_count(),
            &options,
        )
    }

    /// For frames of this shape and a converter whose largest count is `max_count`.
    pub fn new(rows: usize, columns: usize, max_count: f64, options: &ScreenOptions) -> Self {
        let ceiling = (options.unloaded_share_of_range * max_count)
            .max(32.0)
            .min(max_count / 2.0)
            .max(2.0);
        let width = (ceiling / MAX_BINS).ceil().max(1.0);
        Self {
            rows,
            columns,
            bins: Histogram::new((ceiling / width).ceil() as usize + 1, rows * columns),
            width,
            readings: 0,
            frames: 0,
            differences: Histogram::new(DIFFERENCE_BINS, rows * columns),
            previous: vec![0.0; rows * columns],
            has_previous: false,
            fixed_baseline: options.baseline_counts,
            fixed_noise: options.noise_counts,
            absent: options.absent.clone(),
            kept: Vec::with_capacity(rows * columns),
            floor_count: options.floor_count.unwrap_or(f64::NEG_INFINITY),
            level: None,
        }
    }

    /// Takes one more frame in.
    ///
    /// # Errors
    /// [`Error::Shape`] for a frame of another shape.
    pub fn observe(&mut self, frame: &Frame<Counts>) -> Result<(), Error> {
        check_shape("frame to screen", self.rows, self.columns, frame)?;
        if reads_nothing(frame.values()) {
            return Ok(());
        }
        let mut kept = std::mem::take(&mut self.kept);
        let values = self.without_left_out(frame.values(), &mut kept);
        if self.width == 1.0 {
            self.count(values, |value| value);
        } else {
            let width = self.width;
            self.count(values, |value| value / width);
        }
        self.frames += 1;
        if self.frames >= HALVED_AFTER_FRAMES {
            self.forget_half();
        }
        let rough = self.spread_level();
        if let Some((rough, _)) = rough {
            self.take_differences(values, rough);
        }
        self.previous.copy_from_slice(values);
        self.has_previous = true;
        self.level = rough.map(|(rough, cut_off)| self.refined(rough, cut_off));
        self.kept = kept;
        Ok(())
    }

    /// The values, [`LEFT_OUT`] for those that say nothing; how many do not goes to the readings.
    fn without_left_out<'a>(&mut self, values: &'a [f64], kept: &'a mut Vec<f64>) -> &'a [f64] {
        self.readings += values.len() as u64;
        if self.absent.is_empty() && self.floor_count == f64::NEG_INFINITY {
            return values;
        }
        kept.clear();
        kept.extend_from_slice(values);
        for (taxel, value) in kept.iter_mut().enumerate() {
            // What is written as nothing may be anything up to the floor.
            if self.absent.get(taxel) == Some(&true) || *value <= self.floor_count {
                *value = LEFT_OUT;
                self.readings -= 1;
            }
        }
        kept
    }

    /// Adds readings to the bins.
    fn count(&mut self, values: &[f64], place: impl Fn(f64) -> f64) {
        let (beyond, mut places) = (self.bins.beyond(), [0; BLOCK]);
        for values in values.chunks(BLOCK) {
            let (place, at) = (&place, &mut places);
            // Moved in, as below: what is borrowed might change with each place written, and is looked at again.
            wide(
                #[inline(always)]
                move || {
                    for (&value, at) in values.iter().zip(at) {
                        let place = place(if value > 0.0 { value } else { 0.0 });
                        *at = nearest(if place < beyond { place } else { beyond });
                    }
                },
            );
            self.bins.add(&places[..values.len()]);
        }
        self.bins.settle();
    }

    /// Baseline and noise so far. `None` while too few readings are unloaded to tell (a recording of
    /// presses that cover the whole array says nothing about its baseline).
    pub fn level(&self) -> Option<Level> {
        match (self.fixed_baseline, self.fixed_noise) {
            (Some(baseline_counts), Some(noise_counts)) => Some(Level {
                baseline_counts,
                noise_counts,
            }),
            _ => self.level,
        }
    }

    /// Halves the weight of everything seen so far.
    fn forget_half(&mut self) {
        self.bins.halve();
        self.differences.halve();
        self.readings /= 2;
        self.frames /= 2;
    }

    /// Differences to the frame before, of taxels that are unloaded in both.
    fn take_differences(&mut self, values: &[f64], rough: Level) {
        if !self.has_previous {
            return;
        }
        let reach = 8.0 * rough.noise_counts.max(1.0);
        let baseline = rough.baseline_counts;
        let (beyond, mut places) = (self.differences.beyond(), [0; BLOCK]);
        let pairs = values.chunks(BLOCK).zip(self.previous.chunks(BLOCK));
        for (now, before) in pairs {
            let at = &mut places;
            wide(
                #[inline(always)]
                move || {
                    for ((now, before), at) in now.iter().zip(before).zip(at) {
                        let far = |value: f64| (value - baseline).abs();
                        let is_one = (far(*now) <= reach) & (far(*before) <= reach);
                        let place = if is_one { (now - before).abs() } else { beyond };
                        *at = nearest(if place < beyond { place } else { beyond });
                    }
                },
            );
            self.differences.add(&places[..now.len()]);
        }
        self.differences.settle();
    }

    /// Baseline from the mode, noise from the spread below it; and whether the noise is cut off at 0.
    fn spread_level(&self) -> Option<(Level, bool)> {
        let (bins, unloaded) = (self.bins.counts(), self.bins.held());
        if unloaded < MIN_READINGS || (unloaded as f64) < 0.05 * self.readings as f64 {
            return None;
        }
        let mode = settled_mode(bins, self.bins.half_sample_mode());
        // A mode at the upper end is the foot of a hill of loaded readings, not a baseline.
        if mode > 0.9 * (bins.len() - 1) as f64 {
            return None;
        }
        let cut_off = is_cut_off(bins, mode);
        let noise = self.fixed_noise.unwrap_or_else(|| {
            let wide = if cut_off {
                spread(bins, 0.0, Side::AboveCut)
            } else {
                spread(bins, mode, Side::Below)
            };
            wide * self.width
        });
        let level = Level {
            baseline_counts: self.fixed_baseline.unwrap_or(mode * self.width),
            noise_counts: noise.max(ROUNDING_COUNTS),
        };
        Some((level, cut_off))
    }

    /// The smaller of the two noise estimates.
    fn refined(&self, rough: Level, cut_off: bool) -> Level {
        if self.fixed_noise.is_some() || self.differences.held() < MIN_DIFFERENCES {
            return rough;
        }
        let median_of_one = if cut_off {
            MEDIAN_DIFFERENCE_CUT_OFF
        } else {
            MEDIAN_ABSOLUTE_NORMAL * std::f64::consts::SQRT_2
        };
        let from_differences = self.differences.interpolated_median() / median_of_one;
        Level {
            noise_counts: rough
                .noise_counts
                .min(from_differences)
                .max(ROUNDING_COUNTS),
            ..rough
        }
    }
}

/// Whether a frame is nothing but zeros.
pub(super) fn reads_nothing(values: &[f64]) -> bool {
    values.iter().all(|&value| value <= 0.0)
}

/// Moves a rough mode to the centroid of the readings within one standard deviation of it, three times:
/// the half-sample mode alone wanders on a flat top.
fn settled_mode(bins: &[u64], rough: f64) -> f64 {
    let mut mode = rough;
    for _ in 0..3 {
        let reach = spread(bins, mode, Side::Below).max(1.0);
        let first = (mode - reach).round().max(0.0) as usize;
        let last = ((mode + reach).round() as usize).min(bins.len() - 1);
        let held = |i: usize| bins[i] as f64;
        let weight: f64 = (first..=last).map(held).sum();
        if weight == 0.0 {
            return rough;
        }
        mode = (first..=last).map(|i| i as f64 * held(i)).sum::<f64>() / weight;
    }
    mode
}

/// One side of a mode.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Side {
    Below,
    /// Above, where bin 0 holds all that was cut off below: it is taken to be as full as bin 1.
    AboveCut,
}

/// Standard deviation, in bins, from the median distance of the readings on one side of `mode`. Only those within
/// three and a half standard deviations count (not dead lines, loads, or readings stuck at 0); the reach grows
/// from the nearest fifth of the readings until it agrees with itself.
fn spread(bins: &[u64], mode: f64, side: Side) -> f64 {
    let all = bins.len() as f64 + 1.0;
    let mut reach = (2.0 * distance(bins, mode, side, all, 0.2)).max(1.5);
    let mut spread = 0.0;
    for _ in 0..12 {
        spread = distance(bins, mode, side, reach, 0.5) / MEDIAN_ABSOLUTE_NORMAL;
        let next = (3.5 * spread).max(1.5);
        if (next - reach).abs() < 0.01 * reach {
            break;
        }
        reach = next;
    }
    spread
}

/// The distance from `mode` within which `fraction` of the readings on one side lie that are at most `reach` away.
fn distance(bins: &[u64], mode: f64, side: Side, reach: f64, fraction: f64) -> f64 {
    // Bin i reaches from i − ½ to i + ½; of it counts what is between 0 and `reach` away.
    let ends_of = |i: usize| {
        let centre = match side {
            Side::Below => mode - i as f64,
            Side::AboveCut => i as f64 - mode,
        };
        ((centre - 0.5).max(0.0), (centre + 0.5).min(reach))
    };
    let part_of = |i: usize| {
        let (near, far) = ends_of(i);
        let cut = side == Side::AboveCut && i == 0 && bins.len() > 1;
        bins[if cut { 1 } else { i }] as f64 * (far - near).clamp(0.0, 1.0)
    };
    // Only bins that reach into that stretch are looked at.
    let (first, last) = match side {
        Side::Below => ((mode - reach).floor().max(0.0), mode.ceil()),
        Side::AboveCut => (0.0, (mode + reach).ceil()),
    };
    let (first, last) = (first as usize, (last as usize).min(bins.len() - 1));
    let wanted = (first..=last).map(part_of).sum::<f64>() * fraction;
    let mut held = 0.0;
    for step in 0..=last - first {
        let i = match side {
            Side::Below => last - step,
            Side::AboveCut => first + step,
        };
        let part = part_of(i);
        if part > 0.0 && held + part >= wanted {
            let (near, far) = ends_of(i);
            return near + (far - near) * (wanted - held) / part;
        }
        held += part;
    }
    0.0
}

/// Whether the converter cuts the noise of unloaded taxels off at 0: a baseline so near to 0 that more readings are at
/// 0 than at the baseline, and that the two are one hill.
fn is_cut_off(bins: &[u64], mode: f64) -> bool {
    let at_mode = (mode.round() as usize).min(bins.len() - 1);
    at_mode == 0 || (bins[0] > bins[at_mode] && mode < 2.0 * spread(bins, mode, Side::Below))
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    use super::super::line::tests::noise;
    use super::*;

    fn level_of(baseline: f64, sigma: f64, frames: usize, loaded: impl Fn(usize) -> f64) -> Level {
        let mut random = ChaCha8Rng::seed_from_u64(11);
        let mut screen = LevelScreen::new(32, 32, 65_535.0, &ScreenOptions::default());
        for _ in 0..frames {
            let values = (0..1024)
                .map(|i| {
                    (baseline + sigma * noise(&mut random) + loaded(i))
                        .round()
                        .max(0.0)
                })
                .collect();
            screen
                .observe(&Frame::new(32, 32, values).unwrap())
                .unwrap();
        }
        screen.level().unwrap()
    }

    #[test]
    fn baseline_and_noise_are_found_within_a_tenth() {
        for (baseline, sigma) in [(25.0, 3.0), (50.0, 3.0), (400.0, 12.0), (1000.0, 40.0)] {
            let level = level_of(baseline, sigma, 10, |_| 0.0);
            assert!(
                (level.baseline_counts - baseline).abs() < 0.6 * sigma,
                "{level:?}"
            );
            assert!((level.noise_counts / sigma - 1.0).abs() < 0.1, "{level:?}");
        }
    }

    #[test]
    fn noise_that_is_cut_off_at_zero_is_found_within_a_fifth() {
        for sigma in [2.0, 3.0, 10.0] {
            let level = level_of(0.0, sigma, 10, |_| 0.0);
            assert!(level.baseline_counts < 0.5 * sigma, "{level:?}");
            assert!((level.noise_counts / sigma - 1.0).abs() < 0.2, "{level:?}");
        }
    }

    #[test]
    fn loads_on_two_thirds_of_the_array_do_not_matter() {
        let level = level_of(25.0, 3.0, 5, |i| {
            if i % 3 == 0 {
                0.0
            } else {
                (i * 37 % 9000) as f64
            }
        });
        assert!((level.baseline_counts - 25.0).abs() < 1.5, "{level:?}");
        assert!((level.noise_counts - 3.0).abs() < 0.5, "{level:?}");
    }

    #[test]
    fn an_array_that_is_pressed_everywhere_has_no_baseline() {
        let mut screen = LevelScreen::new(8, 8, 65_535.0, &ScreenOptions::default());
        screen.observe(&Frame::filled(8, 8, 9000.0)).unwrap();
        assert_eq!(screen.level(), None);
    }

    #[test]
    fn a_noiseless_frame_has_the_noise_of_its_quantisation() {
        let mut screen = LevelScreen::new(8, 8, 255.0, &ScreenOptions::default());
        screen.observe(&Frame::filled(8, 8, 7.0)).unwrap();
        let level = screen.level().unwrap();
        assert!((level.baseline_counts - 7.0).abs() < 1e-12);
        assert!(level.noise_counts < 0.8);
    }

    #[test]
    fn numbers_given_are_kept() {
        let options = ScreenOptions {
            baseline_counts: Some(100.0),
            noise_counts: Some(2.0),
            ..ScreenOptions::default()
        };
        let screen = LevelScreen::new(4, 4, 1023.0, &options);
        assert_eq!(screen.level().unwrap().baseline_counts, 100.0);
    }
}
