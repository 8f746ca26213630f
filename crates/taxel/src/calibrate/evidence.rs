//! What there is to fit to, checked and screened: labelled presses and mean frames under uniform loads.

use super::{Data, Press};
use crate::screen::{Axis, FrameScreen, Level, LineFaults, LineScreen, ScreenOptions};
use crate::{Counts, Error, Frame, Mark, Sensor};

/// Fewest presses that a fit is tried with.
pub(super) const FEWEST_PRESSES: usize = 8;

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
    pub(super) presses: Vec<Press>,
    /// Ascending in load.
    pub(super) levels: Vec<LevelFrame>,
    pub(super) faults: LineFaults,
    pub(super) noise_counts: f64,
    pub(super) left_out: Vec<String>,
    /// Share of readings stuck at an end of the converter.
    pub(super) stuck_share: f64,
}

impl Evidence {
    pub(super) fn new(sensor: &Sensor, data: &Data) -> Result<Self, Error> {
        check(sensor, data)?;
        let (rows, columns) = (sensor.rows(), sensor.columns());
        let options = ScreenOptions::from_sensor(sensor);
        let mut lines = LineScreen::new(rows, columns, sensor.max_count(), &options);
        for frame in data.frames.iter().chain(data.uniform.iter().map(|u| &u.0)) {
            lines.observe(frame)?;
        }
        let faults = lines.finish().with_declared(&sensor.screen);
        let mut screen = FrameScreen::new(rows, columns, sensor.max_count(), &options);
        screen.set_lines(&faults);
        let mut stuck = 0;
        let mut readings = 0;
        let mut screened = |frame: &Frame<Counts>| {
            let mut marked = frame.clone();
            screen.mark(&mut marked)?;
            stuck += marked.count(Mark::Stuck);
            readings += marked.values().len();
            Ok::<_, Error>(marked)
        };
        let marked: Vec<Frame<Counts>> = data
            .frames
            .iter()
            .map(&mut screened)
            .collect::<Result<_, _>>()?;
        let mut uniform = Vec::new();
        for (frame, load_g) in &data.uniform {
            uniform.push((screened(frame)?, *load_g));
        }
        let (presses, left_out) = readable(&faults, data, &marked)?;
        if presses.len() < FEWEST_PRESSES {
            return Err(Error::TooFewPresses {
                found: presses.len(),
                given: data.presses.len(),
                needed: FEWEST_PRESSES,
            });
        }
        let noise = faults.level.map_or(0.0, |level: Level| level.noise_counts);
        Ok(Self {
            frames: presses.iter().map(|p| marked[p.frame].clone()).collect(),
            presses,
            levels: levels(&uniform),
            faults,
            noise_counts: sensor.converter.noise_counts.unwrap_or(noise).max(0.3),
            left_out,
            stuck_share: stuck as f64 / readings.max(1) as f64,
        })
    }
}

impl Evidence {
    /// The same with at most this many presses, evenly chosen: enough for a start, and faster.
    pub(super) fn thinned(&self, most: usize) -> Self {
        let stride = self.presses.len().div_ceil(most).max(1);
        let which: Vec<usize> = (0..self.presses.len()).step_by(stride).collect();
        self.part(&which)
    }

    /// The same with some of the presses.
    pub(super) fn part(&self, which: &[usize]) -> Self {
        Self {
            frames: which.iter().map(|&i| self.frames[i].clone()).collect(),
            presses: which.iter().map(|&i| self.presses[i]).collect(),
            levels: self.levels.clone(),
            faults: self.faults.clone(),
            noise_counts: self.noise_counts,
            left_out: self.left_out.clone(),
            stuck_share: self.stuck_share,
        }
    }
}

fn check(sensor: &Sensor, data: &Data) -> Result<(), Error> {
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

/// The faults found, and those that the sensor file names.
fn readable(
    faults: &LineFaults,
    data: &Data,
    marked: &[Frame<Counts>],
) -> Result<(Vec<Press>, Vec<String>), Error> {
    let (mut kept, mut left_out) = (Vec::new(), Vec::new());
    for press in &data.presses {
        let dead = |axis, line| faults.dead(axis).any(|dead| dead == line);
        for (axis, line) in [(Axis::Row, press.row), (Axis::Column, press.column)] {
            if dead(axis, line) {
                return Err(Error::PressOnDeadLine {
                    row: press.row,
                    column: press.column,
                    frame: press.frame,
                    line: format!("{axis} {line}"),
                });
            }
        }
        match marked[press.frame].mark_at(press.row, press.column) {
            Mark::Good => kept.push(*press),
            mark => left_out.push(format!(
                "the press of {} g at row {}, column {} (frame {}): its reading is {}",
                press.load_g,
                press.row,
                press.column,
                press.frame,
                mark.word()
            )),
        }
    }
    Ok((kept, left_out))
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
            let mut counts = chosen[0].clone();
            for taxel in 0..counts.values().len() {
                let good: Vec<f64> = chosen
                    .iter()
                    .filter(|f| f.marks()[taxel] == Mark::Good)
                    .map(|f| f.values()[taxel])
                    .collect();
                if !good.is_empty() {
                    counts.values_mut()[taxel] = good.iter().sum::<f64>() / good.len() as f64;
                    counts.marks_mut()[taxel] = Mark::Good;
                }
            }
            LevelFrame {
                typical_counts: super::least_squares::median(counts.values()).max(1.0),
                counts,
                load_g,
                frames: chosen.len(),
            }
        })
        .collect()
}
