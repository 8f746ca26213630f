//! What the whole of a recording looks like, found beside playing it: a viewer sees it before anything was played.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use taxel::metric::FrameFigures;
use taxel::pipeline::Pipeline;
use taxel::screen::LineScreen;
use taxel::{Counts, Frame, Newtons, Sensor};
use taxel_io::{ReadOptions, Tare};
use taxel_server::Curve;

use super::player::{PlaybackRequest, open};
use crate::error::Error;
use crate::tare;
use crate::units::Unit;

/// Points of a curve, at the most.
const MOST_POINTS: u64 = 2000;
/// While it is played, a point is found in one part of the time of so many more.
const REST_WHILE_PLAYED: u32 = 9;

/// A recording that is read beside the one that plays it.
pub(super) struct Recorded {
    pub(super) path: PathBuf,
    pub(super) options: ReadOptions,
    /// How many there are, where that is known before they were counted.
    pub(super) frames: Option<u64>,
    /// What the one that plays it is to do.
    pub(super) play: Arc<Mutex<PlaybackRequest>>,
}

impl Recorded {
    fn is_played(&self) -> bool {
        let play = self.play.lock().unwrap_or_else(PoisonError::into_inner);
        play.playing
    }

    /// Gives all frames, or every so many-th of a long recording, with their seconds and what was taken off them. Of one that is passed
    /// over it gives the frame alone, to who asks for `all`. Says whether it came to the end before it was stopped.
    fn each(
        &self,
        is_stopped: &dyn Fn() -> bool,
        all: bool,
        mut take: impl FnMut(&Frame<Counts>, Option<f64>, Option<&Tare>),
    ) -> Result<bool, Error> {
        let every = self
            .frames
            .map_or(1, |frames| frames.div_ceil(MOST_POINTS).max(1));
        let mut source = open(&self.path, self.options)?;
        let mut frame = Frame::zeros(self.options.rows, self.options.columns);
        let mut number = 0;
        while let Some(secs) = source.next(&mut frame)? {
            if is_stopped() {
                return Ok(false);
            }
            let is_point = number % every == 0;
            if is_point || all {
                let begun = Instant::now();
                take(&frame, is_point.then_some(secs), source.tare());
                // Whoever plays it meanwhile comes first.
                let rest = if self.is_played() {
                    REST_WHILE_PLAYED
                } else {
                    1
                };
                std::thread::sleep(begun.elapsed() * rest);
            }
            number += 1;
        }
        Ok(true)
    }
}

/// Finds it.
pub(super) struct CurveFinder {
    pub(super) recorded: Recorded,
    pub(super) sensor: Sensor,
    pub(super) pipeline: Pipeline,
    /// The pipeline's method, as viewers know it.
    pub(super) method: String,
}

impl CurveFinder {
    /// `None` where it was stopped, or where there are no loads.
    ///
    /// # Errors
    /// A recording that cannot be read.
    pub(super) fn find(mut self, is_stopped: &dyn Fn() -> bool) -> Result<Option<Curve>, Error> {
        let mut screen = LineScreen::from_sensor(&self.sensor);
        let mut seen = 0;
        let was_seen = self.recorded.each(is_stopped, false, |frame, _, _| {
            // A frame that does not fit is told when it is played.
            let _ = screen.observe(frame);
            seen += 1;
        })?;
        self.recorded.frames.get_or_insert(seen);
        self.pipeline.set_lines(&screen.finish());
        let mut loads = Frame::zeros(self.sensor.rows(), self.sensor.columns());
        let mut curve = Curve::default();
        curve.method.clone_from(&self.method);
        let Self {
            recorded,
            sensor,
            pipeline,
            method,
        } = &mut self;
        let is_raw = method == "raw";
        // A law with creep or hysteresis hangs on all frames before.
        let all = pipeline.remembers();
        let was_found = was_seen
            && recorded.each(is_stopped, all, |frame, secs, tare| {
                let zeros = tare.and_then(|tare| {
                    tare::zeros(tare, is_raw, Unit::Newtons, frame.values().len())
                });
                let figures = figures(pipeline, sensor, frame, zeros, &mut loads);
                if let Some((figures, secs)) = figures.zip(secs) {
                    curve.secs.push(secs);
                    curve.total_newtons.push(figures[0] as f32);
                    curve.peak_kilopascals.push(figures[1] as f32);
                    curve.contact_area_mm2.push(figures[2] as f32);
                }
            })?;
        Ok((was_found && !curve.secs.is_empty()).then_some(curve))
    }
}

/// Total force, highest pressure and contact area of a frame, not a number where it has no answer; `None` without loads.
fn figures(
    pipeline: &mut Pipeline,
    sensor: &Sensor,
    frame: &Frame<Counts>,
    zeros: Option<&[f64]>,
    loads: &mut Frame<Newtons>,
) -> Option<[f64; 3]> {
    let result = pipeline.process(frame);
    loads.clone_from(result.loads?);
    if !result.outcome.is_answer() {
        return Some([f64::NAN; 3]);
    }
    for (load, zero) in loads.values_mut().iter_mut().zip(zeros.unwrap_or_default()) {
        *load -= zero;
    }
    let figures = FrameFigures::of(loads, sensor);
    Some([
        figures.total_force_newtons,
        figures.peak_kilopascals,
        figures.contact_area_mm2,
    ])
}
