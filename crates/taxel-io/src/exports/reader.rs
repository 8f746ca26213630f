//! The frames of one sensor of an exported file, as counts.

use std::path::Path;

use taxel::frame::are_zeros;
use taxel::{Counts, Frame, Mark};

use super::cells::power_of_ten;
use super::pad::{Pad, Quantity, RawScale};
use super::survey::{self, Survey, rounded};
use super::{ExportAbout, ParsedFrame, Parser, choose, file_and_pad, format_of};
use crate::error::{Error, ExportError, other_shape};
use crate::integrity::Integrity;
use crate::options::ReadOptions;
use crate::source::{FrameSource, SkipLog, Skipped, fit_shape};

/// How the numbers of a file become counts.
#[derive(Debug, Clone, Copy)]
enum Counting {
    /// A count is so much of the file's unit.
    Steps(f64),
    /// The raw counts that the file's calibration was applied to.
    Raw(RawScale),
}

/// Reads the frames of one sensor of a file that another program has exported.
pub struct ExportReader {
    about: ExportAbout,
    parser: Box<dyn Parser>,
    pad: usize,
    counting: Counting,
    options: ReadOptions,
    parsed: ParsedFrame,
    counts: Vec<f64>,
    marks: Vec<Mark>,
    /// Whether any of them tells of saturation.
    has_saturated: bool,
    frame: u64,
    given: u64,
    first_number: Option<u64>,
    number: Option<u64>,
    /// Of the frame given last, its time and its place.
    secs: Option<f64>,
    secs_frame: u64,
    /// Whether the number of the frame given last is not above the one before it.
    is_anew: bool,
    /// Whether the parser stands behind the frame that it was asked for.
    is_behind: bool,
    reference_newtons: Option<f64>,
    integrity: Integrity,
    skips: SkipLog,
    done: bool,
}

impl ExportReader {
    /// Opens `FILE` or `FILE#SENSOR`; `None` where no other program has exported it. Counts are as large as
    /// [`ReadOptions::unit_per_count`] says; without it the converter's raw ones, where the file tells them exactly, else the
    /// smallest step that numbers in it are written with, for which it is read through.
    ///
    /// # Errors
    /// [`Error::Open`], [`Error::Export`], [`Error::FileShape`] where the sensor is of another shape.
    pub fn open(path: &Path, options: ReadOptions) -> Result<Option<Self>, Error> {
        let (file, name) = file_and_pad(path);
        let Some(open) = format_of(&file) else {
            return Ok(None);
        };
        let (about, mut parser) = open(&file)?;
        let chosen = choose(&file, &about, name.as_deref())?;
        let pad = &about.pads[chosen.pad];
        check_shape(path, pad, &options)?;
        let counting = match (options.unit_per_count, pad.raw) {
            (Some(unit), _) => Counting::Steps(unit),
            (None, Some(raw)) => Counting::Raw(raw),
            (None, None) if pad.quantity == Quantity::Raw => Counting::Steps(1.0),
            // The sensor is of a converter, and the numbers are not.
            (None, None) if options.max_count.is_some() => {
                return Err(Error::Export(Box::new(ExportError::NotCounts {
                    file,
                    unit: pad.unit.clone(),
                })));
            }
            (None, None) => {
                let found = Survey::of(&about, chosen, &mut *parser)?;
                (_, parser) = open(&file)?;
                Counting::Steps(found.unit_per_count.unwrap_or(1.0))
            }
        };
        Ok(Some(Self {
            parser,
            pad: chosen.pad,
            counting,
            options,
            parsed: ParsedFrame::default(),
            counts: vec![0.0; pad.rows * pad.columns],
            marks: vec![Mark::Good; pad.rows * pad.columns],
            has_saturated: false,
            frame: 0,
            given: 0,
            first_number: None,
            number: None,
            secs: None,
            secs_frame: 0,
            is_anew: false,
            is_behind: false,
            reference_newtons: None,
            integrity: Integrity::default(),
            skips: SkipLog::default(),
            done: false,
            about,
        }))
    }

    /// What the file says before its frames.
    pub fn about(&self) -> &ExportAbout {
        &self.about
    }

    /// The next frame of this sensor, whatever is wrong with it.
    fn next_of_pad(&mut self) -> Result<bool, Error> {
        loop {
            self.is_behind = false;
            match self.parser.next(&mut self.parsed) {
                Ok(true) => {}
                Ok(false) => return Ok(false),
                Err(error) if error.is_one_frame() && self.is_of_another() => {
                    self.parser.skip_frame()?;
                    continue;
                }
                Err(error) => return Err(error),
            }
            self.is_behind = true;
            if self.parsed.pad == self.pad {
                self.count()?;
                return Ok(true);
            }
        }
    }

    /// Whether what the parser has failed at is known to be a frame of another sensor.
    fn is_of_another(&self) -> bool {
        self.parser
            .pad_of_error()
            .is_some_and(|pad| pad != self.pad)
    }

    /// Counts of the frame that was read.
    fn count(&mut self) -> Result<(), Error> {
        let raw = match self.counting {
            Counting::Steps(unit) => {
                counts_by(unit, &self.parsed.values, &mut self.counts);
                return Ok(());
            }
            Counting::Raw(raw) => raw,
        };
        let step = 1.0 / power_of_ten(self.parsed.decimals);
        for (count, &value) in self.counts.iter_mut().zip(&self.parsed.values) {
            *count = survey::raw_count(raw, value, step).map_err(|counts| {
                Error::Export(Box::new(ExportError::NotWhole {
                    at: self.parser.text().place(0),
                    value,
                    unit: self.about.pads[self.pad].unit.clone(),
                    counts,
                }))
            })?;
        }
        Ok(())
    }

    /// What the file says of each reading.
    fn mark(&mut self) {
        let pad = &self.about.pads[self.pad];
        let saturation = pad.saturation.unwrap_or(f64::INFINITY);
        let values = &self.parsed.values;
        let is_above = |any, value: &f64| any | (*value >= saturation);
        let is_saturated = pad.saturation.is_some() && values.iter().fold(false, is_above);
        // Of most frames every mark is that of the one before.
        if !is_saturated && !self.has_saturated && self.given > 0 {
            return;
        }
        self.has_saturated = is_saturated;
        for (mark, &value) in self.marks.iter_mut().zip(&self.parsed.values) {
            *mark = if value >= saturation {
                Mark::Saturated
            } else {
                Mark::Good
            };
        }
        for (mark, &is_absent) in self.marks.iter_mut().zip(&pad.absent) {
            if is_absent {
                *mark = Mark::Absent;
            }
        }
    }

    fn fill_transposed(&self, frame: &mut Frame<Counts>) {
        let pad = &self.about.pads[self.pad];
        for (at, (&count, &mark)) in self.counts.iter().zip(&self.marks).enumerate() {
            let to = (at % pad.columns) * pad.rows + at / pad.columns;
            frame.values_mut()[to] = count;
            frame.marks_mut()[to] = mark;
        }
    }

    fn fill(&mut self, frame: &mut Frame<Counts>) {
        self.mark();
        fit_shape(frame, self.options.rows, self.options.columns);
        if self.options.transpose {
            self.fill_transposed(frame);
        } else {
            frame.values_mut().copy_from_slice(&self.counts);
            frame.marks_mut().copy_from_slice(&self.marks);
        }
        frame.sequence = self.frame;
        let number = self.parsed.number.zip(self.first_number);
        let place = number.map_or(self.frame, |(number, first)| number.saturating_sub(first));
        let counted = self.about.secs_per_frame.map(|secs| secs * place as f64);
        frame.time_secs = self.parsed.secs.or(counted);
    }

    /// What the frame's own number tells of those before it.
    fn follow_number(&mut self) {
        let number = self.parsed.number;
        let both = self.number.zip(number);
        let gaps = &mut self.integrity.gaps;
        self.is_anew = both.is_some_and(|(before, now)| !gaps.add(before as u32, now as u32));
        self.first_number = self.first_number.or(number);
        self.number = number.or(self.number);
    }

    /// What the frame's time tells of those before it, where it has no number.
    fn follow_time(&mut self) {
        let is_numbered = self.parsed.number.is_some();
        if let (Some(before), Some(now), Some(step)) =
            (self.secs, self.parsed.secs, self.about.secs_per_frame)
            && !is_numbered
        {
            let left_out = (self.frame - self.secs_frame - 1) as f64;
            let steps = (now - before) / step - left_out;
            self.integrity.times.add(self.frame - 1, steps);
        }
        // Numbers tell what is missing; times of theirs that go back are told all the same.
        if is_numbered && !self.is_anew {
            self.integrity.times.add_times(self.secs, self.parsed.secs);
        }
        self.secs = self.parsed.secs;
        self.secs_frame = self.frame;
    }

    /// What the end of the file tells.
    fn finish(&mut self) {
        self.done = true;
        let read = self.given + self.skips.count as u64;
        // A recording of nothing is none.
        self.integrity.damage.cut = self.parser.is_cut() || read == 0;
        let told = self.about.frames.unwrap_or(read);
        let missing = told.saturating_sub(read);
        self.integrity.damage.surplus = read.saturating_sub(told);
        // Numbers and times that are missing are told of already.
        let by_place = self.integrity.gaps.missing + self.integrity.times.missing;
        self.integrity.damage.frames = missing.saturating_sub(by_place);
    }
}

/// Counts of a frame's numbers, of which one is so much of their unit.
fn counts_by(unit: f64, values: &[f64], counts: &mut [f64]) {
    let count = |(count, value): (&mut f64, &f64)| *count = whole_where_near(value / unit);
    let (eights, rest) = values.as_chunks::<8>();
    let (counts, last) = counts[..values.len()].as_chunks_mut::<8>();
    for (counts, eight) in counts.iter_mut().zip(eights) {
        // Most of what a mat shows is nothing.
        if are_zeros(eight) && unit > 0.0 {
            counts.fill(0.0);
        } else {
            counts.iter_mut().zip(eight).for_each(count);
        }
    }
    last.iter_mut().zip(rest).for_each(count);
}

/// A number that is whole but for how it was divided.
fn whole_where_near(count: f64) -> f64 {
    let whole = rounded(count);
    if (count - whole).abs() <= 1e-9 * (1.0 + whole.abs()) {
        whole
    } else {
        count
    }
}

fn check_shape(path: &Path, pad: &Pad, options: &ReadOptions) -> Result<(), Error> {
    let (rows, columns) = if options.transpose {
        (options.columns, options.rows)
    } else {
        (options.rows, options.columns)
    };
    if (pad.rows, pad.columns) == (rows, columns) {
        return Ok(());
    }
    Err(other_shape(path, (pad.rows, pad.columns), (rows, columns)))
}

impl FrameSource<Counts> for ExportReader {
    fn shape(&self) -> (usize, usize) {
        (self.options.rows, self.options.columns)
    }

    fn next_into(&mut self, frame: &mut Frame<Counts>) -> Result<bool, Error> {
        while !self.done {
            let first_line = self.parser.text().number() + 1;
            match self.next_of_pad() {
                Ok(true) => {
                    self.follow_number();
                    self.follow_time();
                    self.fill(frame);
                    self.reference_newtons = self.parsed.reference_newtons;
                    self.frame += 1;
                    self.given += 1;
                    return Ok(true);
                }
                Ok(false) => self.finish(),
                Err(error) if self.options.keep_going && error.is_one_frame() => {
                    self.skips.add(Skipped {
                        frame: self.frame,
                        first_line: Some(first_line),
                        error,
                    });
                    self.frame += 1;
                    if !self.is_behind {
                        self.parser.skip_frame()?;
                    }
                }
                Err(error) => {
                    self.done = true;
                    return Err(error);
                }
            }
        }
        Ok(false)
    }

    fn skipped(&self) -> usize {
        self.skips.count
    }

    fn skips(&self) -> &[Skipped] {
        &self.skips.first
    }

    fn bytes_read(&self) -> u64 {
        self.parser.text().bytes()
    }

    fn bytes_total(&self) -> Option<u64> {
        self.parser.text().total()
    }

    fn integrity(&self) -> Integrity {
        self.integrity.clone()
    }

    fn device_number(&self) -> Option<u64> {
        self.parsed.number
    }

    fn reference_newtons(&self) -> Option<f64> {
        self.reference_newtons
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_of_a_frame_are_those_of_each_number() {
        for length in 0..60 {
            let value = |at: usize| match (at / 9 + length) % 3 {
                0 => 0.01 * ((at * 7919) % 5000) as f64,
                _ => 0.0,
            };
            let values: Vec<f64> = (0..length).map(value).collect();
            let mut counts = vec![-1.0; length];
            for unit in [0.01, 1.0, 0.7] {
                counts_by(unit, &values, &mut counts);
                let each = values.iter().map(|value| whole_where_near(value / unit));
                assert!(
                    counts
                        .iter()
                        .map(|n| n.to_bits())
                        .eq(each.map(f64::to_bits))
                );
            }
        }
    }
}
