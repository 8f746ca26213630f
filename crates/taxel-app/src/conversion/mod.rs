//! A recording through screen, inverse and load law: its frames shared by all cores, and handed on in order.

mod frame;
mod worker;

pub mod files;
pub mod tally;

use std::path::Path;

use taxel::Sensor;
use taxel::screen::FrameScreen;
use taxel::sensor::Region;

use crate::chain::Chain;
use crate::error::Error;
use crate::executor::cores;
use crate::frames::FrameReader;
use crate::in_order::in_order;
use crate::line_survey::Survey;
use crate::methods::MethodName;
use crate::reporter::Stage;
use crate::units::Unit;
use frame::{Block, Reader};
pub use frame::{Converted, ErrorFrames};
use worker::{Converting, Worker};

/// Frames that an inverse goes through from one to the next, at most; then it begins anew. So frames do not hang on who
/// solved those before, and numbers not on how many cores there are.
const BLOCK_FRAMES: usize = 32;
/// Numbers of a block, at most.
const BLOCK_NUMBERS: usize = 1 << 19;
/// The same of a block that no other thread waits for: what was read into it is still near the processor when it is worked on.
const NEAR_NUMBERS: usize = 1 << 15;

/// Frames of so many taxels each that make a block.
pub fn block_frames(taxels: usize) -> usize {
    (BLOCK_NUMBERS / taxels).clamp(1, BLOCK_FRAMES)
}

/// What is to be made of each frame of a recording.
#[derive(Clone, Copy)]
pub struct Request<'a> {
    /// The sensor, and where it comes from.
    pub sensor: &'a Sensor,
    /// Its file.
    pub sensor_file: &'a Path,
    /// How loads are found.
    pub method: &'a MethodName,
    /// The unit of the numbers.
    pub unit: Unit,
    /// Whether what was not measured is replaced; `None`: as the sensor file says.
    pub repair: Option<bool>,
    /// What is wanted of how far to trust each number.
    pub errors: ErrorsWanted,
    /// Whether total force, area and centre are wanted. Only of loads.
    pub figures: Option<FiguresWanted>,
    /// Load above which a taxel counts as touched in them, newtons,
    pub touched_newtons: f64,
    /// and the regions that have figures of their own.
    pub regions: &'a [Region],
    /// Whether what was taken off the loads while they were recorded is left on.
    pub no_tare: bool,
    /// What is taken off every load besides, newtons.
    pub zeros: Option<&'a [f64]>,
    /// Threads, at most; `None`: one for each core.
    pub threads: Option<usize>,
    /// Whether each frame is handed on before the next one is read: of a pipe, whose next frame may take its time.
    pub promptly: bool,
    /// Whether nobody wants it any more: asked before every frame, and then it ends with [`Error::Stopped`].
    pub is_stopped: &'a (dyn Fn() -> bool + Sync),
}

/// Which figures of frames are wanted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FiguresWanted {
    /// Their values; and the conductances of each frame, so that errors can be had of those that matter.
    Values,
    /// Their values and what these are uncertain by.
    WithErrors,
}

impl Request<'_> {
    /// Whether it can be done, before a recording is looked at.
    ///
    /// # Errors
    /// What the unit needs is not known of the sensor; a method that does not suit it, or does not give the unit.
    pub fn check(&self) -> Result<(), Error> {
        Chain::new(self.sensor, self.sensor_file, self.method, self.unit).map(drop)
    }
}

/// What is wanted of how far to trust each number.
#[derive(Debug, Clone, Copy, Default)]
pub struct ErrorsWanted {
    /// Its standard error.
    pub standard_errors: bool,
    /// Half the width of its 95 % interval.
    pub half_widths: bool,
    /// What its standard error is made of.
    pub parts: bool,
    /// Whether a good taxel that is uncertain by more than itself is marked, be its error kept or not.
    pub marks: bool,
}

impl ErrorsWanted {
    fn any(self) -> bool {
        self.standard_errors || self.half_widths || self.parts || self.marks
    }
}

/// A recording on its way to numbers.
pub struct Conversion<'a> {
    request: Request<'a>,
    survey: &'a Survey,
    first: Worker,
}

impl<'a> Conversion<'a> {
    /// Prepares what a request needs, with what a first pass has found in the recording.
    ///
    /// # Errors
    /// As [`Request::check`]; errors of numbers that cannot be found.
    pub fn new(request: Request<'a>, survey: &'a Survey) -> Result<Self, Error> {
        let first = Worker::new(&request, &survey.faults)?;
        Ok(Self {
            request,
            survey,
            first,
        })
    }

    /// The method's name.
    pub fn method_name(&self) -> &'static str {
        self.first.chain.method_name()
    }

    /// Standard deviation of a reading that standard errors are found with, counts, where they are.
    pub fn noise_counts(&self) -> Option<f64> {
        self.first.noise_counts()
    }

    /// As many as are asked for, and no more than there are blocks of `each` frames.
    fn threads(&self, each: usize) -> usize {
        let blocks = self
            .survey
            .frames
            .map(|frames| frames.div_ceil(each as u64));
        let most = blocks.and_then(|blocks| usize::try_from(blocks).ok());
        let threads = self.request.threads.unwrap_or_else(cores);
        threads.min(most.unwrap_or(threads)).max(1)
    }

    /// All frames that are left to read, in order; `take` has each with what became of it.
    ///
    /// # Errors
    /// A frame that cannot be read, when all before it were handed on; what `take` says; [`Error::Stopped`].
    pub fn run(
        self,
        reading: &mut FrameReader,
        stage: &dyn Stage,
        mut take: impl FnMut(&mut Converted) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let Request {
            sensor, promptly, ..
        } = self.request;
        let remembers = self.first.chain.remembers();
        let taxels = sensor.rows() * sensor.columns();
        let each = block_frames(taxels);
        let threads = if remembers || promptly {
            1
        } else {
            self.threads(each)
        };
        let faults = &self.survey.faults;
        let mut workers = vec![self.first];
        while workers.len() < threads {
            workers.push(Worker::new(&self.request, faults)?);
        }
        let (held, room) = match threads {
            _ if promptly => (1, 1),
            1 => (1, (NEAR_NUMBERS / taxels).clamp(1, each)),
            _ => (threads + 2, each),
        };
        let block = || Block::new(reading, &self.request, room);
        let memory = (0..held).map(|_| block()).collect();
        let mut screen = FrameScreen::from_sensor(sensor);
        screen.set_lines(&faults.clone().with_declared(sensor.screen()));
        let mut reader = Reader::new(reading, screen, (!remembers).then_some(each));
        let work = Converting {
            request: &self.request,
        };
        in_order(
            &work,
            &mut workers,
            memory,
            |block| Ok(reader.fill(block, stage)),
            |block| {
                block.converted_mut().iter_mut().try_for_each(|frame| {
                    frame.failed.take().map_or(Ok(()), Err)?;
                    take(frame)
                })
            },
        )?;
        reader.failed.map_or(Ok(()), Err)
    }
}
