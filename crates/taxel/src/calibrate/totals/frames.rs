//! Frames under known totals, solved once: whatever the law, their conductances are these.

use super::{LeftOut, TotalLoad, no_law};
use crate::circuit::Converter;
use crate::parallel::{Executor, par_map};
use crate::pipeline::{Pipeline, Repair};
use crate::screen::{FrameScreen, LineFaults, LineScreen};
use crate::solve::default_method;
use crate::uncertainty::{least_error_siemens, noise_counts_of, take_off_siemens};
use crate::{Counts, Error, Frame, Mark, Sensor, Siemens};

/// Frames that one pipeline solves: how they are shared out does not hang on the number of threads.
pub(super) const TOGETHER: usize = 16;
/// Numbers that all frames may have together; of more, every so many frames are taken.
const MOST_NUMBERS: usize = 16_000_000;

/// A frame that is solved.
pub(super) struct Solved {
    /// Its place among the totals given.
    pub(super) total: usize,
    /// The load on the whole array, grams.
    pub(super) load_g: f64,
    /// Its conductances, without what noise adds to them in the mean.
    pub(super) siemens: Frame<Siemens>,
    /// Standard error of an unloaded taxel by noise and rounding at least, siemens.
    pub(super) noise_siemens: f64,
    /// Taxels whose readings are none: what stands there is taken to be what stands around them.
    pub(super) lost: usize,
}

/// All of them.
pub(super) struct Frames {
    pub(super) solved: Vec<Solved>,
    pub(super) left_out: Vec<LeftOut>,
    pub(super) faults: LineFaults,
    /// Every so many frames were taken.
    pub(super) stride: usize,
}

/// Whether a number of a frame takes part in its total.
pub(super) fn counts(mark: Mark) -> bool {
    matches!(mark, Mark::Good | Mark::Interpolated | Mark::Shorted)
}

/// Screens and solves every frame.
pub(super) fn solve(
    sensor: &Sensor,
    totals: &[TotalLoad],
    executor: &dyn Executor,
) -> Result<Frames, Error> {
    let mut lines = LineScreen::from_sensor(sensor);
    for total in totals {
        lines.observe(&total.frame)?;
        if !(total.load_g.is_finite() && total.load_g >= 0.0) {
            return Err(no_law(
                format!("a total of {} g is no load", total.load_g),
                "totals are grams on the whole array, 0 or more",
            ));
        }
    }
    let faults = lines.finish().with_declared(sensor.screen());
    let noise_counts = noise_counts_of(sensor, faults.level);
    let stride = (totals.len() * sensor.rows() * sensor.columns()).div_ceil(MOST_NUMBERS);
    let marked = screened(sensor, totals, &faults, stride.max(1))?;
    default_method(sensor)?;
    let groups: Vec<&[Screened]> = marked.chunks(TOGETHER).collect();
    let solved = par_map(executor, groups, |group| {
        let mut pipeline = Pipeline::new(sensor, default_method(sensor).ok()?).ok()?;
        pipeline.set_lines(&faults);
        pipeline.set_repair(Repair::Everything);
        let each = group.iter();
        Some(
            each.map(|one| solve_one(sensor, &mut pipeline, one, noise_counts))
                .collect::<Vec<_>>(),
        )
    });
    let all = solved.ok_or_else(|| {
        no_law(
            "the inverse of this circuit cannot be set up".to_owned(),
            "check the sensor file",
        )
    })?;
    let (mut solved, mut left_out) = (Vec::new(), Vec::new());
    for one in all.into_iter().flatten() {
        match one {
            Ok(frame) => solved.push(frame),
            Err(out) => left_out.push(out),
        }
    }
    Ok(Frames {
        solved,
        left_out,
        faults,
        stride: stride.max(1),
    })
}

/// A frame with its marks.
struct Screened {
    total: usize,
    load_g: f64,
    frame: Frame<Counts>,
}

fn screened(
    sensor: &Sensor,
    totals: &[TotalLoad],
    faults: &LineFaults,
    stride: usize,
) -> Result<Vec<Screened>, Error> {
    let mut screen = FrameScreen::from_sensor(sensor);
    screen.set_lines(faults);
    let chosen = totals.iter().enumerate().step_by(stride);
    let marked = chosen.map(|(at, total)| {
        let mut frame = total.frame.clone();
        screen.mark(&mut frame)?;
        // What is drawn for a frame hangs on its place alone.
        frame.sequence = at as u64;
        Ok(Screened {
            total: at,
            load_g: total.load_g,
            frame,
        })
    });
    marked.collect()
}

fn solve_one(
    sensor: &Sensor,
    pipeline: &mut Pipeline,
    one: &Screened,
    noise_counts: f64,
) -> Result<Solved, LeftOut> {
    let out = |why: String| LeftOut {
        total: one.total,
        load_g: one.load_g,
        why,
    };
    let saturated = one.frame.count(Mark::Saturated);
    if saturated > 0 {
        return Err(out(format!(
            "{saturated} taxels read the most that the converter can"
        )));
    }
    pipeline.begin_anew();
    let result = pipeline.process_screened(&one.frame);
    let (Some(siemens), true) = (result.siemens, result.outcome.is_answer()) else {
        return Err(out("no conductances explain its readings".to_owned()));
    };
    let mut siemens = siemens.clone();
    let sigma_volts = noise_counts * Converter::from_sensor(sensor).lsb_volts();
    if sensor.readout().has_open_columns() {
        let volts = result.volts.clone();
        if !take_off_siemens(pipeline, &volts, sigma_volts, &mut siemens) {
            return Err(out(
                "what noise adds to it cannot be told: readings a fifth of a standard deviation away have no answer"
                    .to_owned(),
            ));
        }
    }
    let lost = siemens.marks().iter().filter(|mark| is_lost(**mark));
    Ok(Solved {
        total: one.total,
        load_g: one.load_g,
        noise_siemens: least_error_siemens(sensor, sigma_volts, 0.0),
        lost: lost.count(),
        siemens,
    })
}

fn is_lost(mark: Mark) -> bool {
    !counts(mark) && !matches!(mark, Mark::Absent | Mark::BelowFloor) || mark == Mark::Interpolated
}
