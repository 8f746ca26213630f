//! Frames to lines of numbers: the one core behind the two text writers.

use std::ops::RangeInclusive;
use std::path::Path;

use taxel::{Counts, Frame};

use crate::atomic::AtomicFile;
use crate::error::Error;
use crate::grid::TIME_PREFIX;
use crate::number::push_number;

/// Whether a line stands before each frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ExtraLines {
    Every,
    Never,
}

/// Writes lines of numbers, one buffer kept between frames.
pub(crate) struct RowWriter {
    file: AtomicFile,
    extra: ExtraLines,
    closing_comma: bool,
    minimum: f64,
    maximum: f64,
    frames: u64,
    shape: Option<(usize, usize)>,
    text: Vec<u8>,
    /// A line of nothing, of the shape.
    zeros: Vec<u8>,
    number: zmij::Buffer,
}

impl RowWriter {
    pub(crate) fn create(
        path: &Path,
        extra: ExtraLines,
        closing_comma: bool,
        minimum: f64,
    ) -> Result<Self, Error> {
        Ok(Self {
            file: AtomicFile::create(path)?,
            extra,
            closing_comma,
            minimum,
            maximum: f64::MAX,
            frames: 0,
            shape: None,
            text: Vec::new(),
            zeros: Vec::new(),
            number: zmij::Buffer::new(),
        })
    }

    /// From here on infinite numbers are written too.
    pub(crate) fn allow_infinity(&mut self) {
        self.maximum = f64::INFINITY;
    }

    pub(crate) fn write<Q>(&mut self, frame: &Frame<Q>) -> Result<(), Error> {
        check_frame(
            frame,
            self.file.path(),
            self.frames,
            self.shape,
            self.minimum..=self.maximum,
        )?;
        if self.shape.is_none() {
            self.zeros = b"0,".repeat(frame.columns());
        }
        self.shape = Some((frame.rows(), frame.columns()));
        if self.extra == ExtraLines::Every {
            self.text.clear();
            if let Some(time) = frame.time_secs.filter(|time| time.is_finite()) {
                self.text.extend_from_slice(TIME_PREFIX.as_bytes());
                push_number(&mut self.text, &mut self.number, time);
            }
            self.text.push(b'\n');
            self.file.put(&self.text)?;
        }
        for row in frame.values().chunks_exact(frame.columns()) {
            self.text.clear();
            // Nearly all rows of marks, and many of loads.
            let bits = row.iter().fold(0, |bits, value| bits | value.to_bits());
            if bits == 0 {
                self.text.extend_from_slice(&self.zeros);
            } else {
                for value in row {
                    push_number(&mut self.text, &mut self.number, *value);
                    self.text.push(b',');
                }
            }
            if !self.closing_comma {
                self.text.pop();
            }
            self.text.push(b'\n');
            self.file.put(&self.text)?;
        }
        self.frames += 1;
        Ok(())
    }

    pub(crate) fn frames(&self) -> u64 {
        self.frames
    }

    pub(crate) fn commit(self) -> Result<(), Error> {
        self.file.commit()
    }
}

/// Refuses a frame whose counts are not all whole numbers of 16 bits; `hint` says where such a frame can go.
pub(crate) fn check_counts(
    frame: &Frame<Counts>,
    file: &Path,
    hint: &'static str,
) -> Result<(), Error> {
    let is_whole = |count: &f64| (0.0..=65535.0).contains(count) && count.fract() == 0.0;
    let Some(taxel) = frame.values().iter().position(|count| !is_whole(count)) else {
        return Ok(());
    };
    Err(Error::Value {
        file: file.to_owned(),
        frame: frame.sequence,
        row: taxel / frame.columns(),
        column: taxel % frame.columns(),
        found: frame.values()[taxel],
        minimum: 0.0,
        maximum: 65535.0,
        hint,
    })
}

/// Refuses a frame of another shape, or with a value that could not be read back.
pub(crate) fn check_frame<Q>(
    frame: &Frame<Q>,
    file: &Path,
    number: u64,
    expected: Option<(usize, usize)>,
    allowed: RangeInclusive<f64>,
) -> Result<(), Error> {
    let found = (frame.rows(), frame.columns());
    if let Some(expected) = expected.filter(|expected| *expected != found) {
        let file = file.to_owned();
        return Err(Error::FrameShape {
            file,
            frame: number,
            found,
            expected,
        });
    }
    let (least, most) = (*allowed.start(), *allowed.end());
    let is_allowed = |value: f64| (value >= least) & (value <= most);
    // Without branches, several at a time; which one it is, only where there is one.
    let all = frame.values().iter();
    if all.fold(true, |all, &value| all & is_allowed(value)) {
        return Ok(());
    }
    match frame.values().iter().position(|&v| !is_allowed(v)) {
        None => Ok(()),
        Some(i) => Err(Error::Value {
            file: file.to_owned(),
            frame: number,
            row: i / frame.columns(),
            column: i % frame.columns(),
            found: frame.values()[i],
            minimum: least,
            maximum: most,
            hint: "only numbers that can be read back are written; mark the taxel instead",
        }),
    }
}
