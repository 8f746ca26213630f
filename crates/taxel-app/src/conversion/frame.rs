//! One frame on its way: as it was read, with what stands beside it in its recording, and what became of it.

use std::sync::Arc;
use std::time::SystemTime;

use taxel::screen::FrameScreen;
use taxel::solve::Outcome;
use taxel::uncertainty::Bias;
use taxel::{Counts, Frame, Mark, Siemens, Volts};
use taxel_io::{Event, Tare};

use super::{FiguresWanted, Request};
use crate::error::Error;
use crate::figures::{FigureRow, RegionRow};
use crate::frames::{DisplayUnit, FrameReader};
use crate::reporter::Stage;

/// One frame of a recording, and what became of it.
pub struct Converted {
    pub(super) read: Read,
    /// The marks it came with, before any screen.
    read_marks: Vec<Mark>,
    /// Whether nothing before it counts.
    pub(super) is_first: bool,
    /// The number that the device gave it, where the recording knows it.
    pub device_number: Option<u64>,
    /// When the host had it, where the recording knows it.
    pub host_time: Option<SystemTime>,
    /// The force that the recording itself tells, newtons.
    pub reference_newtons: Option<f64>,
    /// What was taken off its loads while it was recorded.
    pub tare: Option<Arc<Tare>>,
    /// What happened between the frame before and this one.
    pub events: Vec<Event>,
    /// How the inverse went; `None` where there was none.
    pub outcome: Option<Outcome>,
    /// The numbers, in the unit asked for, with their marks.
    pub shown: Frame<DisplayUnit>,
    /// How far to trust them, as far as asked for.
    pub errors: ErrorFrames,
    /// Its figures, where asked for.
    pub figures: Option<FigureRow>,
    /// Those of its regions, in order.
    pub regions: Vec<RegionRow>,
    /// Its conductances, where figures were asked for without their errors, and an inverse can tell these.
    pub siemens: Option<Frame<Siemens>>,
    /// What noise has added to its loads, where figures were asked for without their errors.
    pub bias: Option<Bias>,
    pub(super) failed: Option<Error>,
}

/// How far to trust the numbers of a frame, in their unit; what was not asked for is not there.
#[derive(Debug, Clone, Default)]
pub struct ErrorFrames {
    /// Standard errors.
    pub standard_errors: Option<Frame<DisplayUnit>>,
    /// Halves of 95 % intervals.
    pub half_widths: Option<Frame<DisplayUnit>>,
    /// By noise, fit and model; none, or all three.
    pub parts: Vec<Frame<DisplayUnit>>,
}

/// A frame as it was read.
#[derive(Debug, Clone)]
pub(super) enum Read {
    /// With the marks of the screen.
    Counts(Frame<Counts>),
    Volts(Frame<Volts>),
    Siemens(Frame<Siemens>),
}

impl Converted {
    fn new(reading: &FrameReader, request: &Request) -> Self {
        let (rows, columns) = (request.sensor.rows(), request.sensor.columns());
        let zeros = || Frame::zeros(rows, columns);
        let wanted = request.errors;
        Self {
            read: match reading {
                FrameReader::Counts(..) => Read::Counts(Frame::zeros(rows, columns)),
                FrameReader::Volts(..) => Read::Volts(Frame::zeros(rows, columns)),
                FrameReader::Siemens(..) => Read::Siemens(Frame::zeros(rows, columns)),
            },
            read_marks: Vec::new(),
            is_first: false,
            device_number: None,
            host_time: None,
            reference_newtons: None,
            tare: None,
            events: Vec::new(),
            outcome: None,
            shown: zeros(),
            errors: ErrorFrames {
                standard_errors: wanted.standard_errors.then(zeros),
                half_widths: wanted.half_widths.then(zeros),
                parts: (0..if wanted.parts { 3 } else { 0 })
                    .map(|_| zeros())
                    .collect(),
            },
            figures: None,
            regions: Vec::new(),
            siemens: (request.figures == Some(FiguresWanted::Values) && request.method.inverts())
                .then(|| Frame::zeros(rows, columns)),
            bias: None,
            failed: None,
        }
    }

    /// Position of the frame in its recording, from 0.
    pub fn sequence(&self) -> u64 {
        match &self.read {
            Read::Counts(frame) => frame.sequence,
            Read::Volts(frame) => frame.sequence,
            Read::Siemens(frame) => frame.sequence,
        }
    }

    /// Device time, seconds, where the recording knows it.
    pub fn time_secs(&self) -> Option<f64> {
        match &self.read {
            Read::Counts(frame) => frame.time_secs,
            Read::Volts(frame) => frame.time_secs,
            Read::Siemens(frame) => frame.time_secs,
        }
    }

    /// Whether the frame came to an answer, or needed none.
    pub fn is_answer(&self) -> bool {
        self.outcome.as_ref().is_none_or(Outcome::is_answer)
    }

    /// The counts as they were read, into `counts`; false where it was not counts that were read.
    pub fn counts_into(&self, counts: &mut Frame<Counts>) -> bool {
        let Read::Counts(read) = &self.read else {
            return false;
        };
        counts.copy_meta_from(read);
        counts.values_mut().copy_from_slice(read.values());
        counts.marks_mut().copy_from_slice(&self.read_marks);
        true
    }
}

/// Frames that one worker goes through.
pub(super) struct Block {
    frames: Vec<Converted>,
    len: usize,
}

impl Block {
    pub(super) fn new(reading: &FrameReader, request: &Request, frames: usize) -> Self {
        let frame = |_| Converted::new(reading, request);
        Self {
            frames: (0..frames).map(frame).collect(),
            len: 0,
        }
    }

    pub(super) fn converted_mut(&mut self) -> &mut [Converted] {
        &mut self.frames[..self.len]
    }
}

/// Reads frames into blocks, and screens them, which goes by those before.
pub(super) struct Reader<'a> {
    reading: &'a mut FrameReader,
    screen: FrameScreen,
    /// After how many frames one is the first again; `None`: there is one first.
    each: Option<usize>,
    frames: usize,
    tare: Option<Arc<Tare>>,
    /// Why there are no more.
    pub(super) failed: Option<Error>,
}

impl<'a> Reader<'a> {
    pub(super) fn new(
        reading: &'a mut FrameReader,
        screen: FrameScreen,
        each: Option<usize>,
    ) -> Self {
        Self {
            reading,
            screen,
            each,
            frames: 0,
            tare: None,
            failed: None,
        }
    }

    /// As many frames as fit in; false where there are none left, or none can be read.
    pub(super) fn fill(&mut self, block: &mut Block, stage: &dyn Stage) -> bool {
        block.len = 0;
        while self.failed.is_none() && block.len < block.frames.len() {
            match self.reading.advance() {
                Ok(true) => self.take(&mut block.frames[block.len]),
                Ok(false) => break,
                Err(error) => {
                    self.failed = Some(error);
                    break;
                }
            }
            block.len += 1;
        }
        self.reading.show(stage);
        block.len > 0
    }

    /// The frame read last.
    fn take(&mut self, to: &mut Converted) {
        to.is_first = match self.each {
            Some(each) => self.frames.is_multiple_of(each),
            None => self.frames == 0,
        };
        self.frames += 1;
        match (&mut *self.reading, &mut to.read) {
            (FrameReader::Counts(source, frame), Read::Counts(read)) => {
                std::mem::swap(frame, read);
                to.read_marks.clear();
                to.read_marks.extend_from_slice(read.marks());
                let marked = self.screen.mark(read);
                marked.expect("a reader's frames have the sensor's shape");
                to.device_number = source.device_number();
                to.host_time = source.host_time();
                to.reference_newtons = source.reference_newtons();
                to.events = source.take_events();
                if source.tare() != self.tare.as_deref() {
                    self.tare = source.tare().cloned().map(Arc::new);
                }
                to.tare.clone_from(&self.tare);
            }
            (FrameReader::Volts(_, frame), Read::Volts(read)) => std::mem::swap(frame, read),
            (FrameReader::Siemens(_, frame), Read::Siemens(read)) => std::mem::swap(frame, read),
            _ => unreachable!("a block is made for what its reader reads"),
        }
    }
}
