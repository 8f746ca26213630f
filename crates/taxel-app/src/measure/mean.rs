//! The mean of a recording's loads, by a pass of its own.

use taxel::metric::is_usable;
use taxel::{Frame, Mark, Newtons};

use super::{Measured, Settings};
use crate::conversion::{Conversion, Converted};
use crate::error::Error;
use crate::line_survey::Survey;
use crate::reporter::Reporter;

impl Measured<'_> {
    /// Mean load of every taxel, newtons, from and to so many seconds since the first frame; marked absent where none was read.
    ///
    /// # Errors
    /// As [`Measured::measure`].
    pub fn mean_map(
        &self,
        settings: &Settings,
        window: [f64; 2],
        reporter: &dyn Reporter,
        is_stopped: &(dyn Fn() -> bool + Sync),
    ) -> Result<Frame<Newtons>, Error> {
        let survey = self.survey(settings, reporter)?;
        let (map, _) = self.mean_loads(settings, Some(window), &survey, reporter, is_stopped)?;
        Ok(map)
    }

    /// Mean load of every taxel, newtons, over the frames with an answer, of some seconds since the first frame or of all; marked
    /// absent where none was read. With how many frames there were. `survey`: what a first pass has found.
    pub(super) fn mean_loads(
        &self,
        settings: &Settings,
        window: Option<[f64; 2]>,
        survey: &Survey,
        reporter: &dyn Reporter,
        is_stopped: &(dyn Fn() -> bool + Sync),
    ) -> Result<(Frame<Newtons>, u64), Error> {
        let mut mean = Mean::new(self.sensor.rows(), self.sensor.columns());
        self.look_at_loads(settings, survey, reporter, is_stopped, |frame, since| {
            let is_within = window
                .is_none_or(|[from, to]| since.is_some_and(|since| (from..=to).contains(&since)));
            if is_within && frame.is_answer() {
                mean.add(frame);
            }
        })?;
        Ok(mean.finish())
    }

    /// A pass over all frames for their loads alone; `take` has each with its seconds since the first, where times are told.
    ///
    /// # Errors
    /// As [`Measured::measure`]; a recording that can be read once only.
    pub(super) fn look_at_loads(
        &self,
        settings: &Settings,
        survey: &Survey,
        reporter: &dyn Reporter,
        is_stopped: &(dyn Fn() -> bool + Sync),
        mut take: impl FnMut(&Converted, Option<f64>),
    ) -> Result<(), Error> {
        let input = self.input(settings);
        if !input.can_be_read_twice() {
            return Err(Error::Request {
                what: format!("{} can be read once only", self.recording.display()),
                hint: "regions and a zero are found in a first pass over all frames: keep the recording in a file",
            });
        }
        let no_figures = Measured {
            regions: &[],
            ..*self
        };
        let mut request = no_figures.request(settings, is_stopped, false);
        request.figures = None;
        let conversion = Conversion::new(request, survey)?;
        let mut reading = input.open()?;
        let stage = reporter.stage("looking at all frames");
        let mut origin = None;
        conversion.run(&mut reading, &*stage, |frame| {
            let secs = settings.secs_of(frame);
            let origin = *origin.get_or_insert(settings.origin(secs));
            let since = secs.zip(origin).map(|(secs, origin)| secs - origin);
            take(frame, since);
            Ok(())
        })
    }
}

/// Sums and counts of every taxel.
pub(super) struct Mean {
    sums: Frame<Newtons>,
    counts: Vec<u32>,
    frames: u64,
}

impl Mean {
    pub(super) fn new(rows: usize, columns: usize) -> Self {
        let mut sums = Frame::zeros(rows, columns);
        sums.marks_mut().fill(Mark::Absent);
        Self {
            sums,
            counts: vec![0; rows * columns],
            frames: 0,
        }
    }

    pub(super) fn add(&mut self, frame: &Converted) {
        self.frames += 1;
        let each = frame.shown.values().iter().zip(frame.shown.marks());
        for (taxel, (load, mark)) in each.enumerate() {
            if is_usable(*mark) {
                self.sums.values_mut()[taxel] += load;
                self.sums.marks_mut()[taxel] = Mark::Good;
                self.counts[taxel] += 1;
            }
        }
    }

    /// The mean of each, marked absent where none was read, and of how many frames.
    pub(super) fn finish(mut self) -> (Frame<Newtons>, u64) {
        let each = self.sums.values_mut().iter_mut().zip(&self.counts);
        each.for_each(|(sum, count)| *sum /= f64::from(*count).max(1.0));
        (self.sums, self.frames)
    }
}
