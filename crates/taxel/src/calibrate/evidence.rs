//! What there is to fit to, checked and screened: labelled presses and mean frames under uniform loads.

use std::collections::{BTreeMap, BTreeSet};

use super::noise;
use super::readable::readable;
use super::screening::lines_and_options;
use super::silent::mark_silent;
use super::{CalibrationData, PressLabel};
use crate::screen::{FrameScreen, Level, LineFaults};
use crate::{Counts, Error, Frame, Mark, Sensor};

/// Presses on fewer taxels than this say nothing of how taxels differ.
const MIN_PLACES: usize = 5;
/// Fewest presses that a fit is tried with.
pub(super) const MIN_PRESSES: usize = 8;

/// A mean frame under a uniform load.
#[derive(Debug, Clone)]
pub(super) struct LevelFrame {
    pub(super) counts: Frame<Counts>,
    pub(super) load_g: f64,
    /// Frames that went into the mean.
    pub(super) frames: usize,
    /// Median reading, counts.
    pub(super) typical_counts: f64,
}

/// Data that passed every check.
#[derive(Debug, Clone)]
pub(super) struct Evidence {
    /// One screened frame per press, in the order of `presses`.
    pub(super) frames: Vec<Frame<Counts>>,
    pub(super) presses: Vec<PressLabel>,
    /// Of each press its index in the data that were given.
    pub(super) origin: Vec<usize>,
    /// Ascending in load.
    pub(super) levels: Vec<LevelFrame>,
    pub(super) faults: LineFaults,
    pub(super) noise_counts: f64,
    pub(super) left_out: Vec<String>,
    /// What the labels look like.
    pub(super) warnings: Vec<String>,
    /// Share of readings stuck at an end of the converter.
    pub(super) stuck_share: f64,
    /// The lightest labelled load that reads the converter's ceiling, grams, where loads are what brings readings there.
    pub(super) least_at_ceiling_g: Option<f64>,
}

impl Evidence {
    pub(super) fn new(sensor: &Sensor, data: &CalibrationData) -> Result<Self, Error> {
        check(sensor, data)?;
        let (given, repeated) = merged(data)?;
        let (faults, mut options) = lines_and_options(sensor, data)?;
        let least_at_ceiling_g = least_load_at_ceiling(sensor, data, &given);
        options.ceiling_is_load |= least_at_ceiling_g.is_some();
        let (rows, columns) = (sensor.rows(), sensor.columns());
        let mut screen = FrameScreen::new(rows, columns, sensor.max_count(), &options);
        screen.set_lines(&faults);
        let mut stuck = 0;
        let mut readings = 0;
        let mut screened = |frame: &Frame<Counts>| {
            let mut marked = frame.clone();
            screen.mark(&mut marked)?;
            stuck += marked.count(Mark::Stuck);
            readings += marked.taxels();
            Ok::<_, Error>(marked)
        };
        let marked: Vec<Frame<Counts>> = data
            .frames
            .iter()
            .map(&mut screened)
            .collect::<Result<_, _>>()?;
        let mut uniform = Vec::new();
        for (frame, load_g) in &data.uniform {
            let mut marked = screened(frame)?;
            mark_silent(&mut marked, *load_g, &faults);
            uniform.push((marked, *load_g));
        }
        let (origin, left_out) = readable(&faults, data, &given, &marked)?;
        let presses: Vec<PressLabel> = origin.iter().map(|&i| data.presses[i]).collect();
        if presses.len() < MIN_PRESSES {
            return Err(Error::TooFewPresses {
                found: presses.len(),
                given: given.len(),
                needed: MIN_PRESSES,
            });
        }
        one_load(&presses)?;
        let noise_counts = noise_counts(sensor, faults.level, &uniform);
        Ok(Self {
            frames: presses.iter().map(|p| marked[p.frame].clone()).collect(),
            warnings: warnings(sensor, &presses, repeated),
            presses,
            origin,
            levels: levels(&uniform),
            faults,
            noise_counts,
            left_out,
            stuck_share: stuck as f64 / readings.max(1) as f64,
            least_at_ceiling_g,
        })
    }
}

impl Evidence {
    /// What was labelled, grams.
    pub(super) fn loads_g(&self) -> Vec<f64> {
        self.presses.iter().map(|press| press.load_g).collect()
    }

    /// The same with at most this many presses, evenly chosen: enough for a start, and faster.
    pub(super) fn thinned(&self, most: usize) -> Self {
        let stride = self.presses.len().div_ceil(most).max(1);
        let which: Vec<usize> = (0..self.presses.len()).step_by(stride).collect();
        self.part(&which)
    }

    /// The presses of all frames but every `folds`th, and those of every `folds`th.
    pub(super) fn split(&self, folds: usize) -> (Self, Self) {
        let mut frames: Vec<usize> = self.presses.iter().map(|p| p.frame).collect();
        frames.sort_unstable();
        frames.dedup();
        let unseen = |i: &usize| {
            let frame = self.presses[*i].frame;
            frames.partition_point(|&f| f < frame) % folds == folds - 1
        };
        let all = 0..self.presses.len();
        let (unseen, seen): (Vec<usize>, Vec<usize>) = all.partition(unseen);
        (self.part(&seen), self.part(&unseen))
    }

    /// The same with some of the presses.
    pub(super) fn part(&self, which: &[usize]) -> Self {
        Self {
            frames: which.iter().map(|&i| self.frames[i].clone()).collect(),
            presses: which.iter().map(|&i| self.presses[i]).collect(),
            origin: which.iter().map(|&i| self.origin[i]).collect(),
            warnings: self.warnings.clone(),
            levels: self.levels.clone(),
            faults: self.faults.clone(),
            noise_counts: self.noise_counts,
            left_out: self.left_out.clone(),
            stuck_share: self.stuck_share,
            least_at_ceiling_g: self.least_at_ceiling_g,
        }
    }
}

fn check(sensor: &Sensor, data: &CalibrationData) -> Result<(), Error> {
    let (rows, columns) = (sensor.rows(), sensor.columns());
    for frame in data.frames.iter().chain(data.uniform.iter().map(|u| &u.0)) {
        if (frame.rows(), frame.columns()) != (rows, columns) {
            return Err(Error::Shape {
                what: "calibration frame",
                expected: rows * columns,
                found: frame.values().len(),
                rows,
                columns,
            });
        }
    }
    for press in &data.presses {
        if press.row >= rows || press.column >= columns || press.frame >= data.frames.len() {
            return Err(Error::PressOutside {
                row: press.row,
                column: press.column,
                frame: press.frame,
                rows,
                columns,
                frames: data.frames.len(),
            });
        }
        if sensor.is_absent(press.row * columns + press.column) {
            return Err(Error::PressOnAbsent {
                row: press.row,
                column: press.column,
                frame: data.number_of(press.frame),
            });
        }
        if !press.load_g.is_finite() || press.load_g < 0.0 {
            return Err(Error::PressLoad {
                load_g: press.load_g,
                row: press.row,
                column: press.column,
            });
        }
    }
    Ok(())
}

/// Labels once each: the same one twice is no second press. With them, how many were repeated.
fn merged(data: &CalibrationData) -> Result<(Vec<usize>, usize), Error> {
    let mut first: BTreeMap<(usize, usize, usize), usize> = BTreeMap::new();
    let mut kept = Vec::new();
    for (i, press) in data.presses.iter().enumerate() {
        let before = *first
            .entry((press.frame, press.row, press.column))
            .or_insert(i);
        if before == i {
            kept.push(i);
        } else if data.presses[before].load_g != press.load_g {
            return Err(Error::PressTwice {
                row: press.row,
                column: press.column,
                frame: data.number_of(press.frame),
                first_g: data.presses[before].load_g,
                second_g: press.load_g,
            });
        }
    }
    let repeated = data.presses.len() - kept.len();
    Ok((kept, repeated))
}

/// Refuses presses of which no two loads differ by a twentieth.
fn one_load(presses: &[PressLabel]) -> Result<(), Error> {
    let loads = presses.iter().map(|p| p.load_g);
    let (least, most) = loads.fold((f64::INFINITY, 0.0), |(least, most), load| {
        (f64::min(least, load), f64::max(most, load))
    });
    if most > 1.05 * least {
        Ok(())
    } else {
        Err(Error::OneLoad {
            presses: presses.len(),
            load_g: most,
        })
    }
}

/// A pressure that no material of such a sensor bears, pascals.
const MAX_PASCALS: f64 = 1e8;
/// Heaviest of all presses below which grams are doubtful.
const MIN_GRAMS: f64 = 1.0;

/// Noise of a reading, counts: as the sensor file says, else the least that the frames tell.
fn noise_counts(sensor: &Sensor, level: Option<Level>, uniform: &[(Frame<Counts>, f64)]) -> f64 {
    let noise = level.map_or(0.0, |level| noise::without_rounding(level.noise_counts));
    let alike = noise::by_alike_frames(uniform, sensor.max_count());
    let found = alike.map_or(noise, |alike| alike.min(noise));
    let told = sensor.converter().noise_counts;
    told.unwrap_or(found).max(noise::LEAST)
}

/// What the labels look like as a whole: units, repetitions.
fn warnings(sensor: &Sensor, presses: &[PressLabel], repeated: usize) -> Vec<String> {
    let mut warnings = Vec::new();
    if repeated > 0 {
        warnings.push(format!(
            "{repeated} labels repeat another, with the same frame, taxel and load: each counts once"
        ));
    }
    let places: BTreeSet<(usize, usize)> = presses.iter().map(|p| (p.row, p.column)).collect();
    if places.len() < MIN_PLACES {
        warnings.push(format!(
            "all {} presses are on {} of {} taxels: how much others differ is not told, and intervals hold for these alone; press ten or more, spread over the array",
            presses.len(),
            places.len(),
            sensor.rows() * sensor.columns()
        ));
    }
    let heaviest = presses.iter().map(|p| p.load_g).fold(0.0, f64::max);
    let pascals = crate::frame::newtons_from_grams(heaviest) / sensor.array().taxel_area_mm2 * 1e6;
    if heaviest < MIN_GRAMS {
        warnings.push(format!(
            "{UNIT_DOUBT}the heaviest of all labels is {heaviest:.3} g; are these kg?"
        ));
    } else if pascals > MAX_PASCALS {
        warnings.push(format!(
            "{UNIT_DOUBT}the heaviest label, {heaviest:.0} g on a taxel of {} mm², is {:.0} MPa; are these mg?",
            sensor.array().taxel_area_mm2,
            pascals / 1e6
        ));
    }
    warnings
}

/// How a doubt about the unit of all labels begins.
pub(super) const UNIT_DOUBT: &str = "the unit of the labels is doubtful: ";

/// Fewest labelled presses at the converter's ceiling that are no chance.
const MIN_AT_CEILING: usize = 2;

/// The lightest labelled load that reads the converter's ceiling, where all that do are heavier than the middle of the others:
/// stuck readings would not mind the load.
fn least_load_at_ceiling(sensor: &Sensor, data: &CalibrationData, given: &[usize]) -> Option<f64> {
    let is_at_ceiling = |press: &&PressLabel| {
        let count = data.frames[press.frame].at(press.row, press.column);
        count >= sensor.max_count()
    };
    let presses = given.iter().map(|&i| &data.presses[i]);
    let (at, below): (Vec<&PressLabel>, Vec<&PressLabel>) = presses.partition(is_at_ceiling);
    let least = at.iter().map(|p| p.load_g).reduce(f64::min)?;
    let middle = crate::stats::median(below.iter().map(|p| p.load_g)).unwrap_or(0.0);
    (at.len() >= MIN_AT_CEILING && least > middle).then_some(least)
}

/// Mean frames by load. Frames in which a line was out load the others differently, so they only serve
/// where there is no other.
fn levels(uniform: &[(Frame<Counts>, f64)]) -> Vec<LevelFrame> {
    let mut loads: Vec<f64> = uniform
        .iter()
        .map(|u| u.1)
        .filter(|&load| load > 0.0)
        .collect();
    loads.sort_by(f64::total_cmp);
    loads.dedup();
    let out = |frame: &Frame<Counts>| frame.count(Mark::Flickering);
    loads
        .into_iter()
        .map(|load_g| {
            let frames = || uniform.iter().filter(move |u| u.1 == load_g).map(|u| &u.0);
            let least = frames().map(out).min().unwrap_or(0);
            let chosen: Vec<&Frame<Counts>> = frames().filter(|f| out(f) == least).collect();
            let counts = mean_frame(&chosen);
            LevelFrame {
                typical_counts: typical(&counts).max(1.0),
                counts,
                load_g,
                frames: chosen.len(),
            }
        })
        .collect()
}

/// Of every taxel the mean of what is good in frames of one load, without what is stuck in one of them.
pub(super) fn mean_frame<Q: Clone>(frames: &[&Frame<Q>]) -> Frame<Q> {
    let mut mean = frames[0].clone();
    let usual: Vec<f64> = frames.iter().map(|frame| typical(frame)).collect();
    let usual = super::least_squares::median(&usual);
    for taxel in 0..mean.values().len() {
        let good = frames.iter().filter(|f| f.marks()[taxel] == Mark::Good);
        let good: Vec<f64> = good.map(|f| f.values()[taxel]).collect();
        if let Some(reading) = mean_of_alike(&good, usual) {
            mean.values_mut()[taxel] = reading;
            mean.marks_mut()[taxel] = Mark::Good;
        }
    }
    mean
}

/// Readings of one load that are farther from their median, a share of it, are faults.
const REPEATS: f64 = 0.2;
/// Readings of one load that differ by more than this factor are not the same reading twice.
const DISAGREE: f64 = 2.0;

/// The mean of a taxel's readings under one load without those that are stuck in one frame. Where half of them are, nothing
/// lies in the middle, and that one counts which is nearest to what taxels usually read.
fn mean_of_alike(readings: &[f64], usual: f64) -> Option<f64> {
    let middle = crate::stats::median(readings.iter().copied())?;
    let near = |reading: &f64| (reading - middle).abs() <= REPEATS * middle.abs();
    if let Some(mean) = crate::stats::mean(readings.iter().copied().filter(near)) {
        return Some(mean);
    }
    let apart = |a: f64, b: f64| (a / b).max(f64::MIN_POSITIVE).ln().abs();
    let by_distance = |a: &f64, b: &f64| apart(*a, usual).total_cmp(&apart(*b, usual));
    let nearest = readings.iter().copied().min_by(by_distance)?;
    let agree = readings
        .iter()
        .all(|&reading| apart(reading, nearest) <= DISAGREE.ln());
    Some(if agree { middle } else { nearest })
}

/// Median reading of the taxels there are.
pub(super) fn typical<Q>(frame: &Frame<Q>) -> f64 {
    let there = frame.values().iter().zip(frame.marks());
    let there = there.filter(|(_, mark)| **mark != Mark::Absent);
    super::least_squares::median(&there.map(|(value, _)| *value).collect::<Vec<f64>>())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensor::preset;

    const SIDE: usize = 16;

    /// Presses on a mat with floating lines of which nothing but the parts is known; every sound reading is 14 to 17 counts or
    /// the press. `at_end`: these taxels of every frame read nothing.
    fn evidence(at_end: &[usize]) -> Evidence {
        let parts = preset("mat-16x16-cd4067").unwrap();
        let parts = parts.edited(|spec| spec.material = None).unwrap();
        let mut data = CalibrationData::default();
        for frame in 0..12 {
            let mut counts = Frame::<Counts>::zeros(SIDE, SIDE);
            for (taxel, value) in counts.values_mut().iter_mut().enumerate() {
                *value = 14.0 + ((taxel * 7 + frame * 3) % 4) as f64;
            }
            let (row, column) = (1 + frame, 2 + frame);
            counts.values_mut()[row * SIDE + column] = 200.0 + 20.0 * frame as f64;
            for &taxel in at_end {
                counts.values_mut()[taxel] = 0.0;
            }
            data.frames.push(counts);
            let load_g = 100.0 + 10.0 * frame as f64;
            data.presses.push(PressLabel {
                frame,
                row,
                column,
                load_g,
            });
        }
        Evidence::new(&parts, &data).unwrap()
    }

    #[test]
    fn a_reading_of_nothing_is_stuck_where_lines_are_open_and_no_other_reads_so_little() {
        let found = evidence(&[3, 250]);
        for frame in &found.frames {
            assert_eq!(frame.count(Mark::Stuck), 2);
            assert_eq!([frame.marks()[3], frame.marks()[250]], [Mark::Stuck; 2]);
        }
        // One reading in ten is no exception.
        let many: Vec<usize> = (0..SIDE * SIDE).step_by(10).collect();
        assert_eq!(evidence(&many).frames[0].count(Mark::Stuck), 0);
    }
}
