//! What there is to fit to: readings under every load, and the lines that are out.

use super::super::evidence::mean_frame;
use super::super::noise::without_rounding;
use super::super::silent::Silent;
use super::no_law;
use crate::circuit::Converter;
use crate::screen::{FrameScreen, LineFaults, LineScreen};
use crate::stats;
use crate::{Counts, Error, Frame, Mark, Sensor, Volts};

/// Fewest loads that a law is fitted to.
const MIN_LEVELS: usize = 4;
/// The heaviest load reads so many times what the lightest does, at least.
const RISE: f64 = 1.05;

/// Readings under one load.
pub(super) struct Level {
    pub(super) load_g: f64,
    pub(super) volts: Vec<f64>,
    pub(super) is_good: Vec<bool>,
    /// Whether a taxel conducts: it is there, and its lines are not out in these frames.
    pub(super) conducts: Vec<bool>,
    pub(super) frame: Frame<Volts>,
}

/// Lines that are out.
pub(super) struct Faults {
    pub(super) lines: LineFaults,
    pub(super) silent: Silent,
}

/// Standard deviation of a reading before it is rounded, counts.
pub(super) fn noise_counts(sensor: &Sensor, faults: &LineFaults) -> f64 {
    let told = sensor.converter().noise_counts;
    told.unwrap_or(
        faults
            .level
            .map_or(0.0, |level| without_rounding(level.noise_counts)),
    )
}

/// Frames of one load become one level, ascending: the mean of what is good.
pub(super) fn levels(
    sensor: &Sensor,
    uniform: &[(Frame<Counts>, f64)],
) -> Result<(Vec<Level>, Faults), Error> {
    let mut lines = LineScreen::from_sensor(sensor);
    for (frame, load_g) in uniform {
        lines.observe(frame)?;
        if !(load_g.is_finite() && *load_g >= 0.0) {
            return Err(no_law(
                format!("a uniform load of {load_g} g is none"),
                "loads are grams on each taxel, 0 or more",
            ));
        }
    }
    let faults = lines.finish().with_declared(sensor.screen());
    let mut screen = FrameScreen::from_sensor(sensor);
    screen.set_lines(&faults);
    let converter = Converter::from_sensor(sensor);
    let mut silent = Silent::new(sensor.rows(), sensor.columns());
    let mut by_load: Vec<(f64, Vec<Frame<Volts>>)> = Vec::new();
    let mut sorted: Vec<&(Frame<Counts>, f64)> = uniform.iter().collect();
    sorted.sort_by(|a, b| a.1.total_cmp(&b.1));
    for (frame, load_g) in sorted {
        let mut marked = frame.clone();
        screen.mark(&mut marked)?;
        let mut volts = marked.map(|_, _| 0.0);
        converter.volts_from_counts_into(&marked, &mut volts);
        if *load_g > 0.0 {
            silent.mark(&mut volts);
        }
        match by_load.last_mut() {
            Some((load, frames)) if load == load_g => frames.push(volts),
            _ => by_load.push((*load_g, vec![volts])),
        }
    }
    let loaded = by_load.iter().filter(|(load, _)| *load > 0.0).count();
    if loaded < MIN_LEVELS {
        return Err(no_law(
            format!(
                "{loaded} uniform loads above nothing are too few: {MIN_LEVELS} or more tell a law"
            ),
            "frames of one load count once, however many there are",
        ));
    }
    let lines = faults;
    let levels: Vec<Level> = by_load.into_iter().map(level).collect();
    do_rise(&levels)?;
    Ok((levels, Faults { lines, silent }))
}

/// Refuses readings that do not rise with the load.
fn do_rise(levels: &[Level]) -> Result<(), Error> {
    let reads = |level: &Level| {
        let good = level.volts.iter().zip(&level.is_good);
        stats::median(
            good.filter(|(_, good)| **good)
                .map(|(volts, _)| volts.abs()),
        )
    };
    let mut loaded = levels.iter().filter(|level| level.load_g > 0.0);
    let (Some(least), Some(most)) = (loaded.next(), loaded.next_back()) else {
        return Ok(());
    };
    let (low, high) = (reads(least).unwrap_or(0.0), reads(most).unwrap_or(0.0));
    if high > RISE * low {
        return Ok(());
    }
    Err(no_law(
        format!(
            "readings do not rise with the load: in the middle {low:.4} V at {} g, {high:.4} V at {} g",
            least.load_g, most.load_g
        ),
        "are loads and frames in the same order, and is `converter.inverted` right? Readings at an end of the converter do not rise either",
    ))
}

/// The mean of the frames in which the fewest lines are out.
fn level((load_g, mut frames): (f64, Vec<Frame<Volts>>)) -> Level {
    let out = |frame: &Frame<Volts>| frame.count(Mark::Flickering);
    let fewest = frames.iter().map(out).min();
    frames.retain(|frame| Some(out(frame)) == fewest);
    let frame = mean_frame(&frames.iter().collect::<Vec<_>>());
    Level {
        load_g,
        volts: frame.values().to_vec(),
        is_good: frame.marks().iter().map(|m| *m == Mark::Good).collect(),
        conducts: frame.marks().iter().map(|m| !m.is_out()).collect(),
        frame,
    }
}
