//! What presses on a sensor that nobody has calibrated yet, and whether it stands.
//!
//! Frames are gathered into blocks of a quarter of a second. What presses is what the readings, taken for conductances as they are,
//! rose by since the sensor was empty: the taxel that rose most. A press stands when the same taxel rose most in several blocks and by
//! the same; the mean of the blocks after that is what the calibration gets. A load on all taxels is told by the mean of all of them,
//! whose noise is so much smaller that a hundredth of a press is seen.

#[cfg(test)]
mod tests;

use std::collections::VecDeque;
use std::time::{Duration, SystemTime};

use taxel::pipeline::Pipeline;
use taxel::solve::Raw;
use taxel::stats::median;
use taxel::{Counts, Frame, Sensor};
use taxel_server::BadLines;

use crate::error::Error;

/// The time of a block, and the fewest frames in it.
const BLOCK: Duration = Duration::from_millis(250);
const MIN_FRAMES: usize = 2;
/// So many blocks alike stand; the material has crept most of its way by then.
const STANDING: usize = 4;
/// So many blocks are taken.
const TAKEN: usize = 4;
/// The sensor is read empty for so many.
const EMPTY: usize = 6;
/// A press that changes by more than this share between two blocks does not stand.
const STEADY: f64 = 0.03;
/// What rises by less than this many standard deviations of a block's mean is noise,
const ABOVE_NOISE: f64 = 12.0;
/// and what rises by less than this share of the largest rise so far is no press.
const ABOVE_PRESSES: f64 = 0.02;
/// What is left of a press when it was taken off, at the most, as a share of it.
const LEFT: f64 = 0.25;
/// Other things that are looked at, at the most, and how much each rises at the least, of the one that rises most.
const MOST_OTHERS: usize = 12;
const ANOTHER: f64 = 0.25;
/// A load on all is one where this share of the taxels rose by half of the mean rise.
const EVEN: f64 = 0.6;
/// At this share of the converter's range a reading is at its ceiling.
const CEILING: f64 = 0.995;

/// The mean of some frames.
#[derive(Debug, Clone)]
struct Block {
    counts: Vec<f64>,
    siemens: Vec<f64>,
    /// The highest single reading.
    highest: Vec<f64>,
    frames: usize,
}

impl Block {
    fn new(taxels: usize) -> Self {
        Self {
            counts: vec![0.0; taxels],
            siemens: vec![0.0; taxels],
            highest: vec![0.0; taxels],
            frames: 0,
        }
    }

    fn add(&mut self, counts: &Frame<Counts>, siemens: &[f64]) {
        self.frames += 1;
        let share = 1.0 / self.frames as f64;
        for (mean, value) in self.counts.iter_mut().zip(counts.values()) {
            *mean += share * (value - *mean);
        }
        for (mean, value) in self.siemens.iter_mut().zip(siemens) {
            *mean += share * (value - *mean);
        }
        for (highest, value) in self.highest.iter_mut().zip(counts.values()) {
            *highest = highest.max(*value);
        }
    }

    /// Adds all frames of another.
    fn join(&mut self, other: &Self) {
        let (mine, theirs) = (self.frames as f64, other.frames as f64);
        let share = theirs / (mine + theirs);
        for (mean, value) in self.counts.iter_mut().zip(&other.counts) {
            *mean += share * (value - *mean);
        }
        for (mean, value) in self.siemens.iter_mut().zip(&other.siemens) {
            *mean += share * (value - *mean);
        }
        for (highest, value) in self.highest.iter_mut().zip(&other.highest) {
            *highest = highest.max(*value);
        }
        self.frames += other.frames;
    }
}

/// What the sensor reads while nothing is pressed anew.
#[derive(Debug, Clone)]
struct Baseline {
    siemens: Vec<f64>,
    /// Standard deviation of a block's mean, typical of the taxels, siemens.
    noise: f64,
    /// Standard deviation of the mean over all taxels of a block, siemens.
    noise_of_all: f64,
}

/// What presses now.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Pressing {
    /// The taxel that rose most.
    pub row: usize,
    pub column: usize,
    /// How much its reading rose, siemens; of a load on all taxels, how much they rose on average.
    pub rise: f64,
    /// 0 to 1: how long it stands, of what is long enough.
    pub standing: f64,
    /// Its reading is at the converter's ceiling.
    pub is_saturated: bool,
}

/// Watches the frames of a sensor.
pub(super) struct PressWatch {
    raw: Pipeline,
    columns: usize,
    /// Where nothing is to be seen: no taxel, or a faulty line.
    blind: Vec<bool>,
    sensor: Sensor,
    max_count: f64,
    baseline: Option<Baseline>,
    /// What the empty sensor read, siemens; empty before it was read.
    bare: Vec<f64>,
    /// The newest last.
    blocks: VecDeque<Block>,
    filling: Block,
    filling_since: Option<SystemTime>,
    /// The largest rise of a press that was taken.
    largest_rise: f64,
    /// Blocks since it was told to read anew.
    fresh: usize,
    /// What a quarter of a count is worth on an empty sensor, siemens.
    rounding: f64,
}

impl PressWatch {
    pub(super) fn new(sensor: &Sensor) -> Result<Self, Error> {
        let taxels = sensor.taxels();
        let mut raw = Pipeline::new(sensor, Box::new(Raw::from_sensor(sensor)))?;
        let rounding = 0.25 * siemens_of_a_count(sensor, &mut raw);
        Ok(Self {
            raw,
            rounding,
            columns: sensor.columns(),
            blind: blind_of(sensor, &BadLines::default()),
            sensor: sensor.clone(),
            max_count: sensor.max_count(),
            baseline: None,
            bare: Vec::new(),
            blocks: VecDeque::new(),
            filling: Block::new(taxels),
            filling_since: None,
            largest_rise: 0.0,
            fresh: 0,
        })
    }

    /// Looks away from lines that are faulty.
    pub(super) fn set_bad_lines(&mut self, lines: &BadLines) {
        self.blind = blind_of(&self.sensor, lines);
    }

    /// Takes in a frame.
    pub(super) fn see(&mut self, counts: &Frame<Counts>, at: SystemTime) {
        let Some(siemens) = self.raw.process(counts).siemens else {
            return;
        };
        let since = *self.filling_since.get_or_insert(at);
        self.filling.add(counts, siemens.values());
        let is_full = at.duration_since(since).unwrap_or(BLOCK) >= BLOCK;
        if !is_full || self.filling.frames < MIN_FRAMES {
            return;
        }
        let taxels = self.filling.counts.len();
        let full = std::mem::replace(&mut self.filling, Block::new(taxels));
        self.filling_since = None;
        self.blocks.push_back(full);
        if self.blocks.len() > EMPTY.max(STANDING + TAKEN) {
            self.blocks.pop_front();
        }
        self.fresh += 1;
    }

    /// What comes from now on is looked at by itself.
    pub(super) fn look_anew(&mut self) {
        self.fresh = 0;
    }

    /// The newest blocks, no older than when it was told to look anew.
    fn newest(&self, most: usize) -> impl Iterator<Item = &Block> {
        let count = most.min(self.fresh).min(self.blocks.len());
        self.blocks.range(self.blocks.len() - count..)
    }

    /// Takes what is read now for nothing, once it has stood still for long enough: 0 to 1, how far that is.
    ///
    /// `is_bare`: nothing lies on it, not even other things.
    pub(super) fn read_empty(&mut self, is_bare: bool) -> f64 {
        let blocks: Vec<&Block> = self.newest(EMPTY).collect();
        let Some((first, rest)) = blocks.split_first() else {
            return 0.0;
        };
        let noise = self.noise_of(&blocks);
        let steadiest = |block: &&&Block| {
            let moved = block.siemens.iter().zip(&first.siemens);
            let moved = moved.zip(&self.blind).filter(|(_, absent)| !**absent);
            let most = moved.map(|((a, b), _)| (a - b).abs()).fold(0.0, f64::max);
            most <= (ABOVE_NOISE * noise).max(ABOVE_PRESSES * self.largest_rise)
        };
        let steady = 1 + rest.iter().take_while(steadiest).count();
        if steady < blocks.len() {
            self.fresh = blocks.len() - steady;
            return 0.0;
        }
        if steady < EMPTY {
            return steady as f64 / EMPTY as f64;
        }
        let noise_of_all = self.noise_of_all(&blocks);
        let siemens = mean_of(&blocks).siemens;
        if is_bare {
            self.bare.clone_from(&siemens);
        }
        self.baseline = Some(Baseline {
            siemens,
            noise,
            noise_of_all,
        });
        1.0
    }

    /// Where other things lie: the taxels that rose most since the sensor was bare.
    pub(super) fn others(&self) -> Vec<(usize, usize)> {
        let Some(baseline) = &self.baseline else {
            return Vec::new();
        };
        let both = baseline.siemens.iter().zip(&self.bare).zip(&self.blind);
        let rises = both.map(|((now, bare), blind)| if *blind { 0.0 } else { now - bare });
        let mut rises: Vec<(f64, usize)> = rises.zip(0..).collect();
        rises.sort_by(|a, b| b.0.total_cmp(&a.0));
        let highest = rises.first().map_or(0.0, |first| first.0);
        let high = rises.iter().take(MOST_OTHERS);
        let high = high.filter(|(rise, _)| *rise > ANOTHER * highest && *rise > self.least_rise());
        high.map(|(_, taxel)| (taxel / self.columns, taxel % self.columns))
            .collect()
    }

    /// The typical standard deviation of a block's mean, of the differences between blocks; of rounding at the least.
    fn noise_of(&self, blocks: &[&Block]) -> f64 {
        let steps = blocks.windows(2).flat_map(|pair| {
            let both = pair[0].siemens.iter().zip(&pair[1].siemens);
            both.zip(&self.blind)
                .filter(|(_, absent)| !**absent)
                .map(|((a, b), _)| (a - b).abs())
        });
        // Of a normal distribution the median of |a - b| is 0.954 standard deviations of a.
        let noise = median(steps).unwrap_or(0.0) / 0.954;
        noise.max(self.rounding)
    }

    /// The standard deviation of the mean over all taxels, from block to block; of rounding at the least, which differs from taxel to
    /// taxel.
    fn noise_of_all(&self, blocks: &[&Block]) -> f64 {
        let means = blocks.iter().map(|block| self.mean_of_all(&block.siemens));
        let means: Vec<f64> = means.collect();
        let steps = means.windows(2).map(|pair| (pair[0] - pair[1]).powi(2));
        // A difference of two has twice the variance of one.
        let variance = steps.sum::<f64>() / (2.0 * (means.len() - 1).max(1) as f64);
        let seeing = self.blind.iter().filter(|blind| !**blind).count();
        let rounding = self.rounding / (seeing.max(1) as f64).sqrt();
        variance.sqrt().max(rounding)
    }

    /// The mean over all taxels that are seen.
    fn mean_of_all(&self, values: &[f64]) -> f64 {
        let seen = values.iter().zip(&self.blind).filter(|(_, blind)| !**blind);
        let (sum, count) = seen.fold((0.0, 0), |(sum, count), (value, _)| {
            (sum + value, count + 1)
        });
        sum / f64::from(count.max(1))
    }

    /// How much each taxel rose since the sensor was empty, siemens; nothing of absent ones.
    fn rises(&self, block: &Block) -> Option<Vec<f64>> {
        let baseline = self.baseline.as_ref()?;
        let both = block.siemens.iter().zip(&baseline.siemens);
        let rises = both.zip(&self.blind);
        Some(
            rises
                .map(|((now, empty), absent)| if *absent { 0.0 } else { now - empty })
                .collect(),
        )
    }

    /// The least rise that is a press, siemens.
    fn least_rise(&self) -> f64 {
        let noise = self.baseline.as_ref().map_or(0.0, |b| b.noise);
        (ABOVE_NOISE * noise).max(ABOVE_PRESSES * self.largest_rise)
    }

    /// What presses one taxel more than the others; `None` where nothing does.
    pub(super) fn pressing(&self) -> Option<Pressing> {
        let noise = self.baseline.as_ref()?.noise;
        self.standing(noise, Self::most_risen, |taxel, before| taxel == before)
    }

    /// A load on all taxels; `None` where there is none. Which of them rises most may change.
    pub(super) fn loaded_evenly(&self) -> Option<Pressing> {
        let noise = self.baseline.as_ref()?.noise_of_all;
        self.standing(noise, Self::risen_evenly, |_, _| true)
    }

    /// What presses in the newest block, and for how many blocks the same has: a taxel and a rise by `look`, which changes by no more
    /// than what stands may.
    fn standing(
        &self,
        noise: f64,
        look: impl Fn(&Self, &Block) -> Option<(usize, f64)>,
        is_same: impl Fn(usize, usize) -> bool,
    ) -> Option<Pressing> {
        let blocks: Vec<&Block> = self.newest(STANDING).collect();
        let newest = blocks.last()?;
        let (taxel, rise) = look(self, newest)?;
        let wobble = (STEADY * rise).max(4.0 * noise);
        let same = blocks.iter().rev().skip(1).take_while(|block| {
            let before = look(self, block);
            before.is_some_and(|(at, by)| is_same(taxel, at) && (by - rise).abs() <= wobble)
        });
        Some(Pressing {
            row: taxel / self.columns,
            column: taxel % self.columns,
            rise,
            standing: (1 + same.count()) as f64 / STANDING as f64,
            is_saturated: newest.highest[taxel] >= CEILING * self.max_count,
        })
    }

    /// The taxel that rose most, where that is a press.
    fn most_risen(&self, block: &Block) -> Option<(usize, f64)> {
        let (taxel, rise) = most(&self.rises(block)?)?;
        (rise > self.least_rise()).then_some((taxel, rise))
    }

    /// The taxel that rose most, and by how much all rose on average, siemens, where that is a load on all of them.
    fn risen_evenly(&self, block: &Block) -> Option<(usize, f64)> {
        let rises = self.rises(block)?;
        let mean = self.mean_of_all(&rises);
        let noise = self.baseline.as_ref()?.noise_of_all;
        let seen = || rises.iter().zip(&self.blind).filter(|(_, blind)| !**blind);
        let risen = seen().filter(|(rise, _)| **rise > 0.5 * mean).count();
        let is_even = risen as f64 >= EVEN * seen().count() as f64;
        let (taxel, _) = most(&rises)?;
        (is_even && mean > ABOVE_NOISE * noise).then_some((taxel, mean))
    }

    /// The mean of the frames since it was told to look anew: 0 to 1, how many of those needed are there, and at 1 the frame.
    pub(super) fn take(&mut self, rise: f64) -> (f64, Option<Frame<Counts>>) {
        if self.fresh < TAKEN {
            return (self.fresh as f64 / TAKEN as f64, None);
        }
        let blocks: Vec<&Block> = self.newest(TAKEN).collect();
        let mean = mean_of(&blocks);
        self.largest_rise = self.largest_rise.max(rise);
        let rows = mean.counts.len() / self.columns;
        let mut frame = Frame::zeros(rows, self.columns);
        frame.values_mut().copy_from_slice(&mean.counts);
        (1.0, Some(frame))
    }

    /// Whether a press that rose so much at a taxel is off; then what is read now is nothing anew: zeros drift.
    pub(super) fn is_off(&mut self, taxel: usize, rise: f64) -> bool {
        let left = (LEFT * rise).max(self.least_rise());
        self.is_gone(|watch, block| {
            watch
                .rises(block)
                .is_some_and(|rises| rises[taxel] <= left && rises.iter().all(|r| *r <= left))
        })
    }

    /// Whether a load on all taxels that rose so much on average is off; then what is read now is nothing anew.
    pub(super) fn is_evenly_off(&mut self, rise: f64) -> bool {
        let noise = self.baseline.as_ref().map_or(0.0, |b| b.noise_of_all);
        let left = (LEFT * rise).max(ABOVE_NOISE * noise);
        self.is_gone(|watch, block| {
            let rises = watch.rises(block);
            rises.is_some_and(|rises| watch.mean_of_all(&rises) <= left)
        })
    }

    /// Whether the newest blocks are those of a load that is gone; then they are the zero.
    fn is_gone(&mut self, of_block: impl Fn(&Self, &Block) -> bool) -> bool {
        const BLOCKS: usize = 2;
        let blocks: Vec<&Block> = self.newest(BLOCKS).collect();
        if blocks.len() < BLOCKS || !blocks.iter().all(|block| of_block(self, block)) {
            return false;
        }
        let newest = blocks[BLOCKS - 1].siemens.clone();
        if let Some(baseline) = &mut self.baseline {
            baseline.siemens = newest;
        }
        true
    }
}

/// What a count is worth on an empty sensor, siemens.
fn siemens_of_a_count(sensor: &Sensor, raw: &mut Pipeline) -> f64 {
    let mut read = |count: f64| {
        let mut counts = Frame::zeros(sensor.rows(), sensor.columns());
        counts.values_mut().fill(count);
        let siemens = raw.process(&counts).siemens;
        siemens.map_or(0.0, |siemens| {
            median(siemens.values().iter().copied()).unwrap_or(0.0)
        })
    };
    (read(2.0) - read(1.0)).abs()
}

fn blind_of(sensor: &Sensor, lines: &BadLines) -> Vec<bool> {
    let columns = sensor.columns();
    let is_blind = |taxel: usize| {
        sensor.is_absent(taxel)
            || lines.rows.contains(&(taxel / columns))
            || lines.columns.contains(&(taxel % columns))
    };
    (0..sensor.taxels()).map(is_blind).collect()
}

/// The largest of these, and where it stands.
fn most(rises: &[f64]) -> Option<(usize, f64)> {
    let each = rises.iter().copied().enumerate();
    each.max_by(|a, b| a.1.total_cmp(&b.1))
}

fn mean_of(blocks: &[&Block]) -> Block {
    let mut mean = Block::new(blocks[0].counts.len());
    for block in blocks {
        mean.join(block);
    }
    mean
}
