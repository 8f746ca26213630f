//! A source of frames: what every reader of recordings is.

use std::fs::{self, File};
use std::io::{self, Read};
use std::marker::PhantomData;
use std::ops::Range;
use std::path::Path;
use std::time::SystemTime;

use taxel::{Counts, Executor, Frame, Mark};

use crate::error::Error;
use crate::event::Event;
use crate::integrity::Integrity;
use crate::tare::Tare;

/// The most taxels a frame may have: 2¹⁸, as of 512 x 512 or 4096 x 64 lines. A command holds up to eighty numbers a
/// taxel while it solves a frame, and stays below 256 MiB.
pub const MAX_TAXELS: usize = 1 << 18;

/// How many skipped frames are remembered with their reasons; all are counted.
pub const SKIPS_REMEMBERED: usize = 100;

/// A stream of frames of quantity `Q`.
pub trait FrameSource<Q = Counts> {
    /// Rows and columns of every frame.
    fn shape(&self) -> (usize, usize);

    /// Reads the next frame into `frame`, without allocating (a `frame` of another shape is replaced).
    /// False at the end; `frame` then still holds what it held.
    ///
    /// # Errors
    /// What is wrong with the frame or its file; the values of `frame` are then undefined. Nothing follows
    /// an error: further calls give false.
    fn next_into(&mut self, frame: &mut Frame<Q>) -> Result<bool, Error>;

    /// Reads frames on as whole counts of 16 bits, row by row behind `out`: at most so many, as long as they are written plainly
    /// and there is nothing to say of any, be it its time or a mark. Their positions; of frames of another kind none, which
    /// [`Self::next_into`] reads. Of most formats no frame is plain.
    ///
    /// # Errors
    /// A file that cannot be read on.
    fn next_counts(
        &mut self,
        most: usize,
        out: &mut Vec<u16>,
        executor: &dyn Executor,
    ) -> Result<Range<u64>, Error> {
        let _ = (most, out, executor);
        Ok(0..0)
    }

    /// How many frames `keep_going` has left out so far.
    fn skipped(&self) -> usize;

    /// The first [`SKIPS_REMEMBERED`] frames left out, with their reasons.
    fn skips(&self) -> &[Skipped];

    /// Bytes of the file read so far, for progress bars.
    fn bytes_read(&self) -> u64;

    /// Bytes of the whole file; `None` for a pipe or a device.
    fn bytes_total(&self) -> Option<u64>;

    /// What happened during the recording up to the frame read last, since this was asked before; of files that
    /// know no events, nothing.
    fn take_events(&mut self) -> Vec<Event> {
        Vec::new()
    }

    /// What is known to be missing from what was read; complete at the end.
    fn integrity(&self) -> Integrity {
        Integrity::default()
    }

    /// What is to be taken off the loads of the frame read last, as it was while it was recorded.
    fn tare(&self) -> Option<&Tare> {
        None
    }

    /// The number that the device gave the frame read last, where the file knows it.
    fn device_number(&self) -> Option<u64> {
        None
    }

    /// When the host had the frame read last, where the file knows it.
    fn host_time(&self) -> Option<SystemTime> {
        None
    }

    /// The force that the file itself says acts in the frame read last, newtons: of another program, or another instrument.
    fn reference_newtons(&self) -> Option<f64> {
        None
    }

    /// The frames one by one, each newly allocated.
    fn frames(self) -> Frames<Self, Q>
    where
        Self: Sized,
    {
        Frames {
            source: self,
            quantity: PhantomData,
        }
    }
}

impl<Q, S: FrameSource<Q> + ?Sized> FrameSource<Q> for Box<S> {
    fn shape(&self) -> (usize, usize) {
        (**self).shape()
    }
    fn next_into(&mut self, frame: &mut Frame<Q>) -> Result<bool, Error> {
        (**self).next_into(frame)
    }
    fn next_counts(
        &mut self,
        most: usize,
        out: &mut Vec<u16>,
        executor: &dyn Executor,
    ) -> Result<Range<u64>, Error> {
        (**self).next_counts(most, out, executor)
    }
    fn skipped(&self) -> usize {
        (**self).skipped()
    }
    fn skips(&self) -> &[Skipped] {
        (**self).skips()
    }
    fn bytes_read(&self) -> u64 {
        (**self).bytes_read()
    }
    fn bytes_total(&self) -> Option<u64> {
        (**self).bytes_total()
    }
    fn take_events(&mut self) -> Vec<Event> {
        (**self).take_events()
    }
    fn integrity(&self) -> Integrity {
        (**self).integrity()
    }
    fn tare(&self) -> Option<&Tare> {
        (**self).tare()
    }
    fn device_number(&self) -> Option<u64> {
        (**self).device_number()
    }
    fn host_time(&self) -> Option<SystemTime> {
        (**self).host_time()
    }
    fn reference_newtons(&self) -> Option<f64> {
        (**self).reference_newtons()
    }
}

/// The frames of a source, as an iterator; ends after the first error.
#[derive(Debug)]
pub struct Frames<S, Q = Counts> {
    source: S,
    quantity: PhantomData<Q>,
}

impl<S, Q> Frames<S, Q> {
    /// The source, to ask what it skipped.
    pub fn source(&self) -> &S {
        &self.source
    }
}

impl<S: FrameSource<Q>, Q> Iterator for Frames<S, Q> {
    type Item = Result<Frame<Q>, Error>;

    fn next(&mut self) -> Option<Self::Item> {
        let (rows, columns) = self.source.shape();
        let mut frame = Frame::zeros(rows, columns);
        match self.source.next_into(&mut frame) {
            Ok(true) => Some(Ok(frame)),
            Ok(false) => None,
            Err(error) => Some(Err(error)),
        }
    }
}

/// A frame that `keep_going` left out.
#[derive(Debug)]
pub struct Skipped {
    /// Its position in the recording, from 0.
    pub frame: u64,
    /// The first line read for it in a text file, from 1.
    pub first_line: Option<u64>,
    /// Why.
    pub error: Error,
}

/// The frames left out so far.
#[derive(Debug, Default)]
pub(crate) struct SkipLog {
    pub(crate) count: usize,
    pub(crate) first: Vec<Skipped>,
}

impl SkipLog {
    pub(crate) fn add(&mut self, skipped: Skipped) {
        self.count += 1;
        if self.first.len() < SKIPS_REMEMBERED {
            self.first.push(skipped);
        }
    }
}

/// Gives a frame the shape of its source.
pub(crate) fn fit_shape<Q>(frame: &mut Frame<Q>, rows: usize, columns: usize) {
    if (frame.rows(), frame.columns()) != (rows, columns) {
        *frame = Frame::zeros(rows, columns);
    }
}

/// Fills a frame of `shape`, rows and columns, with the numbers and the marks of a file, as [`mark_of`] says of each code; with
/// no codes every taxel is good. `transpose`: the file has its columns as rows.
pub(crate) fn fill_marked<Q>(
    frame: &mut Frame<Q>,
    shape: (usize, usize),
    transpose: bool,
    numbers: &[f64],
    codes: &[f64],
) {
    let (rows, columns) = shape;
    fit_shape(frame, rows, columns);
    for place in 0..rows * columns {
        let from = if transpose {
            (place % columns) * rows + place / columns
        } else {
            place
        };
        frame.values_mut()[place] = numbers[from];
        let mark = codes.get(from).and_then(|code| mark_of(*code));
        frame.marks_mut()[place] = mark.unwrap_or(Mark::Good);
    }
}

/// The mark of a code, if it is one.
pub(crate) fn mark_of(code: f64) -> Option<Mark> {
    // What is no whole number, or is out of range, becomes the code of another and is found out by it.
    let mark = Mark::ALL.get(code as usize)?;
    (f64::from(mark.code()) == code).then_some(*mark)
}

/// Where the bytes of a file come from.
pub type Input = Box<dyn Read + Send>;

/// Opens a file to be read (`-`: standard input), with its size where it has one.
pub(crate) fn open_input(path: &Path) -> Result<(Input, Option<u64>), Error> {
    if path.as_os_str() == "-" {
        return Ok((Box::new(io::stdin()), None));
    }
    let (file, total) = open_file(path)?;
    Ok((Box::new(file), total))
}

/// Opens a file that must be able to seek, or not.
pub(crate) fn open_file(path: &Path) -> Result<(File, Option<u64>), Error> {
    let failed = |source| Error::Open {
        file: path.to_owned(),
        source,
    };
    let about = fs::metadata(path).map_err(failed)?;
    if about.is_dir() {
        return Err(failed(io::ErrorKind::IsADirectory.into()));
    }
    let file = File::open(path).map_err(failed)?;
    Ok((file, about.is_file().then_some(about.len())))
}
