//! The files that are written of a recording: numbers, marks, standard errors; or all of it in a recording or a table.

use std::path::{Path, PathBuf};
use std::time::SystemTime;

use taxel::{Counts, Frame, Newtons, Sensor};
use taxel_io::exports::{ExportFormat, ExportLosses, ExportWriter};
use taxel_io::npy::Element;
use taxel_io::{AtomicFile, McapWriter, ParquetWriter};

use super::{Converted, ErrorFrames, ErrorsWanted};
use crate::carry::{self, Carry, Clock, USUAL_RATE};
use crate::error::Error;
use crate::figures::FigureRow;
use crate::frames::{DisplayUnit, FrameReader, FrameWriter, Input, is_mcap, is_parquet};
use crate::standard_error::Part;
use crate::units::{InputUnit, Unit};

/// Which files are written of a recording.
#[derive(Debug, Clone, Default)]
pub struct Files {
    /// As which format of other programs the numbers are written, newtons; `None`: as their ending says.
    pub export_as: Option<ExportFormat>,
    /// The numbers: `.csv`, `.npy`, `.npz`, `-`; or `.mcap` and `.parquet`, with marks, times and counts.
    pub numbers: Option<PathBuf>,
    /// Whether a recording has the loads as images besides, which other programs know.
    pub images: bool,
    /// The marks alone, a code a taxel.
    pub marks: Option<PathBuf>,
    /// The standard error of each number.
    pub standard_errors: Option<PathBuf>,
    /// Whether what they are made of is written beside them.
    pub parts: bool,
    /// Half the width of each number's 95 % interval.
    pub half_widths: Option<PathBuf>,
    /// The figures of each frame, `.csv`,
    pub figures: Option<PathBuf>,
    /// and whether with what they are uncertain by.
    pub figure_errors: bool,
}

impl Files {
    /// Whether numbers, marks and counts go to one file, which holds newtons.
    pub fn is_together(&self) -> bool {
        let numbers = self.numbers.as_deref();
        numbers.is_some_and(|numbers| is_mcap(numbers) || is_parquet(numbers))
    }

    /// The format of other programs that the numbers are written in: as it is told, else as the ending of their file tells.
    pub fn export_format(&self) -> Option<ExportFormat> {
        self.export_as
            .or_else(|| ExportFormat::of_ending(self.numbers.as_deref()?))
    }

    /// What they need of how far to trust numbers.
    pub fn errors(&self) -> ErrorsWanted {
        ErrorsWanted {
            standard_errors: self.standard_errors.is_some(),
            half_widths: self.half_widths.is_some(),
            parts: self.parts && self.standard_errors.is_some(),
            marks: false,
        }
    }

    /// Where the parts of the standard errors go, if they are asked for: beside them, `se.npz` and `se.noise.npz`.
    pub fn part_files(&self) -> Vec<PathBuf> {
        let beside = |file: &PathBuf| {
            let ending = file.extension().unwrap_or_default().to_string_lossy();
            let name = |part: Part| file.with_extension(format!("{}.{ending}", part.word()));
            Part::ALL.map(name).to_vec()
        };
        let file = self.standard_errors.as_ref().filter(|_| self.parts);
        file.map(beside).unwrap_or_default()
    }
}

/// What is being written.
#[derive(Debug, Clone, Copy)]
pub struct Written<'a> {
    /// What it is made of.
    pub input: &'a Input,
    /// The sensor of it.
    pub sensor: &'a Sensor,
    /// The unit of the numbers.
    pub unit: Unit,
    /// Whether a recording's tare stays behind.
    pub no_tare: bool,
    /// How many frames there are, where that is known; `.npz` needs it.
    pub frames: Option<u64>,
    /// Whether a recording of the name is replaced once another is whole; else it is refused.
    pub replaces: bool,
}

/// What is written, frame by frame; nothing appears under its name before `commit`.
pub struct Outputs {
    numbers: Option<Numbers>,
    marks: Option<FrameWriter<DisplayUnit>>,
    errors: ErrorFiles,
    figures: Option<AtomicFile>,
    codes: Frame<DisplayUnit>,
}

/// Where the numbers go.
enum Numbers {
    /// Alone.
    Frames(FrameWriter<DisplayUnit>),
    /// With their marks, their times and their counts.
    Together(Box<Together>),
    /// As another program reads them.
    Export(Box<Export>),
}

/// A file for another program.
struct Export {
    writer: ExportWriter,
    loads: Frame<Newtons>,
    clock: Clock,
    place: u64,
}

impl Export {
    fn write(&mut self, frame: &Converted) -> Result<(), Error> {
        self.loads.copy_meta_from(&frame.shown);
        let shown = frame.shown.values();
        self.loads.values_mut().copy_from_slice(shown);
        let secs = frame.time_secs();
        let secs = secs.unwrap_or_else(|| self.clock.secs(self.place));
        self.place += 1;
        Ok(self.writer.write(&self.loads, secs)?)
    }
}

/// A recording or a table.
struct Together {
    file: File,
    clock: Clock,
    recording: PathBuf,
    output: PathBuf,
    counts: Frame<Counts>,
    loads: Frame<Newtons>,
    place: u64,
}

enum File {
    Mcap(Box<McapWriter>, Carry),
    /// With counts, or loads alone.
    Parquet(Box<ParquetWriter>, bool),
}

impl Outputs {
    /// Begins them.
    ///
    /// # Errors
    /// What cannot be written, or not without the number of frames.
    pub fn create(files: &Files, of: Written) -> Result<Self, Error> {
        let shape = (of.sensor.rows(), of.sensor.columns());
        let create = |file: &Path, element| FrameWriter::create(file, shape, element, of.frames);
        let numbers = match &files.numbers {
            Some(file) if let Some(format) = files.export_format() => {
                Some(Numbers::Export(Box::new(Export {
                    writer: ExportWriter::create(file, format, of.sensor, of.frames)?,
                    loads: Frame::zeros(shape.0, shape.1),
                    clock: Clock::of(&of.input.file, USUAL_RATE),
                    place: 0,
                })))
            }
            Some(file) if files.is_together() => Some(Numbers::Together(Box::new(
                Together::create(file, of, files.images)?,
            ))),
            Some(file) => Some(Numbers::Frames(create(file, Element::F8)?)),
            None => None,
        };
        let marks = files.marks.as_deref();
        let figures = files.figures.as_deref();
        Ok(Self {
            numbers,
            marks: marks.map(|file| create(file, Element::U1)).transpose()?,
            errors: ErrorFiles::create(files, create)?,
            figures: figures
                .map(|file| begin(file, of.unit, files.figure_errors))
                .transpose()?,
            codes: Frame::zeros(shape.0, shape.1),
        })
    }

    /// Writes one frame to all of them.
    ///
    /// # Errors
    /// What cannot be written: a full disk, a number that the file does not hold.
    pub fn write(&mut self, frame: &Converted) -> Result<(), Error> {
        match &mut self.numbers {
            Some(Numbers::Frames(writer)) => writer.write(&frame.shown)?,
            Some(Numbers::Together(together)) => together.write(frame)?,
            Some(Numbers::Export(export)) => export.write(frame)?,
            None => {}
        }
        if let Some(marks) = &mut self.marks {
            let codes = self.codes.values_mut().iter_mut();
            for (code, mark) in codes.zip(frame.shown.marks()) {
                *code = mark.code().into();
            }
            marks.write(&self.codes)?;
        }
        self.errors.write(&frame.errors)?;
        if let (Some(file), Some(row)) = (&mut self.figures, &frame.figures) {
            file.put(row.line().as_bytes())?;
        }
        Ok(())
    }

    /// Finishes them and gives them their names; `reading` has been read to its end. What a format of other programs could not
    /// hold comes back.
    ///
    /// # Errors
    /// What cannot be written.
    pub fn commit(self, reading: &mut FrameReader) -> Result<ExportLosses, Error> {
        if let Some(figures) = self.figures {
            figures.commit()?;
        }
        if let Some(marks) = self.marks {
            marks.commit()?;
        }
        self.errors.commit()?;
        match self.numbers {
            Some(Numbers::Frames(writer)) => writer.commit()?,
            Some(Numbers::Together(together)) => together.commit(reading)?,
            Some(Numbers::Export(export)) => return Ok(export.writer.commit()?),
            None => {}
        }
        Ok(ExportLosses::default())
    }
}

/// The table of figures, with its heading.
fn begin(file: &Path, unit: Unit, with_errors: bool) -> Result<AtomicFile, Error> {
    let mut table = AtomicFile::create(file)?;
    table.put(FigureRow::heading(unit, with_errors).as_bytes())?;
    Ok(table)
}

/// Standard errors, their parts and intervals, as far as they are asked for.
struct ErrorFiles {
    errors: Option<FrameWriter<DisplayUnit>>,
    half_widths: Option<FrameWriter<DisplayUnit>>,
    parts: Vec<FrameWriter<DisplayUnit>>,
}

impl ErrorFiles {
    fn create(
        files: &Files,
        create: impl Fn(&Path, Element) -> Result<FrameWriter<DisplayUnit>, Error>,
    ) -> Result<Self, Error> {
        let create = |file: &Path| create(file, Element::F8).map(|writer| writer.allow_infinity());
        let parts = files.part_files();
        let (errors, halves) = (&files.standard_errors, &files.half_widths);
        Ok(Self {
            errors: errors.as_deref().map(create).transpose()?,
            half_widths: halves.as_deref().map(create).transpose()?,
            parts: parts
                .iter()
                .map(|file| create(file))
                .collect::<Result<_, _>>()?,
        })
    }

    fn write(&mut self, errors: &ErrorFrames) -> Result<(), Error> {
        if let (Some(writer), Some(frame)) = (&mut self.errors, &errors.standard_errors) {
            writer.write(frame)?;
        }
        if let (Some(writer), Some(frame)) = (&mut self.half_widths, &errors.half_widths) {
            writer.write(frame)?;
        }
        for (writer, frame) in self.parts.iter_mut().zip(&errors.parts) {
            writer.write(frame)?;
        }
        Ok(())
    }

    fn commit(self) -> Result<(), Error> {
        let files = self.errors.into_iter().chain(self.half_widths);
        for writer in files.chain(self.parts) {
            writer.commit()?;
        }
        Ok(())
    }
}

impl Together {
    fn create(output: &Path, of: Written, images: bool) -> Result<Self, Error> {
        let (rows, columns) = (of.sensor.rows(), of.sensor.columns());
        let recording = &of.input.file;
        let file = if is_mcap(output) {
            let about = carry::about(of.sensor, recording);
            let carry = if of.no_tare {
                Carry::without_tare()
            } else {
                Carry::default()
            };
            let writer = if of.replaces {
                McapWriter::replace_at_once(output, &about)?
            } else {
                McapWriter::create_at_once(output, &about)?
            };
            let writer = if images {
                writer.with_images(of.sensor.name())
            } else {
                writer
            };
            File::Mcap(Box::new(writer), carry)
        } else {
            // What another program has found was no count, and may have fractions.
            let is_ours = of.sensor.exported().is_none();
            let has_counts = is_ours && of.input.unit == InputUnit::Counts;
            let writer = ParquetWriter::create_with_loads(output, of.sensor, has_counts)?;
            File::Parquet(Box::new(writer), has_counts)
        };
        Ok(Self {
            file,
            clock: Clock::of(recording, USUAL_RATE),
            recording: recording.clone(),
            output: output.to_owned(),
            counts: Frame::zeros(rows, columns),
            loads: Frame::zeros(rows, columns),
            place: 0,
        })
    }

    fn write(&mut self, frame: &Converted) -> Result<(), Error> {
        self.loads.copy_meta_from(&frame.shown);
        self.loads
            .values_mut()
            .copy_from_slice(frame.shown.values());
        let position = frame.sequence();
        let secs = frame.time_secs();
        let secs = secs.unwrap_or_else(|| self.clock.secs(self.place));
        self.place += 1;
        let has_counts = frame.counts_into(&mut self.counts);
        // The device's own: a gap in them is all that tells of frames that never came.
        let number = frame.device_number.unwrap_or(position);
        (self.counts.sequence, self.loads.sequence) = (number, number);
        (self.counts.time_secs, self.loads.time_secs) = (Some(secs), Some(secs));
        let host = self.clock.host(frame.host_time, secs)?;
        if let File::Mcap(writer, carry) = &mut self.file {
            carry.before_frame(writer, &frame.events, frame.tare.as_deref())?;
        }
        let written = self.put(has_counts, host);
        written.map_err(|error| match error {
            Error::Io(error) => carry::whole(&self.recording, &self.output, position, error),
            other => other,
        })
    }

    fn put(&mut self, has_counts: bool, host: SystemTime) -> Result<(), Error> {
        match &mut self.file {
            File::Mcap(writer, _) => {
                writer.write_counts(&self.counts, host)?;
                writer.write_loads(&self.loads, host)?;
            }
            File::Parquet(writer, keeps_counts) => {
                let counts = (has_counts && *keeps_counts).then_some(&self.counts);
                writer.write_loads(counts, &self.loads, host)?;
            }
        }
        Ok(())
    }

    fn commit(self, reading: &mut FrameReader) -> Result<(), Error> {
        let losses = reading.integrity().losses;
        match self.file {
            File::Mcap(mut writer, carry) => {
                if let FrameReader::Counts(source, _) = reading {
                    carry.end(&mut writer, &mut **source, losses)?;
                }
                writer.finish()?;
            }
            File::Parquet(writer, _) => writer.commit()?,
        }
        Ok(())
    }
}
