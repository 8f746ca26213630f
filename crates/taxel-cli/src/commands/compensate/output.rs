//! The files that `compensate` writes: numbers, marks, standard errors; or all of it in a recording or a table.

use std::path::{Path, PathBuf};
use std::time::SystemTime;

use taxel::{Counts, Frame, Newtons, Sensor};
use taxel_io::npy::Element;
use taxel_io::{AtomicFile, McapWriter, ParquetWriter};

use super::Args;
use crate::error::Error;
use crate::out;
use taxel_app::carry::{self, Carry, Clock, USUAL_RATE};
use taxel_app::figures::FigureRow;
use taxel_app::frames::{DisplayUnit, FrameReader, FrameWriter, is_mcap, is_parquet};
use taxel_app::standard_error::{Part, StandardErrors};
use taxel_app::units::{InputUnit, Unit};

/// What is written, frame by frame; nothing appears under its name before `commit`.
pub(super) struct Outputs {
    numbers: Numbers,
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
    Parquet(Box<ParquetWriter>),
}

impl Outputs {
    pub(super) fn create(args: &Args, sensor: &Sensor, frames: Option<u64>) -> Result<Self, Error> {
        let shape = (sensor.rows(), sensor.columns());
        let create = |file: &Path, element| FrameWriter::create(file, shape, element, frames);
        let numbers = args.output.as_deref().unwrap_or(Path::new("-"));
        let marks = marks_file(args);
        Ok(Self {
            numbers: if is_together(args) {
                Numbers::Together(Box::new(Together::create(args, numbers, sensor)?))
            } else {
                Numbers::Frames(create(numbers, Element::F8)?)
            },
            marks: marks.map(|file| create(&file, Element::U1)).transpose()?,
            errors: ErrorFiles::create(args, shape, frames)?,
            figures: args
                .figures
                .as_ref()
                .map(|file| begin(file, args))
                .transpose()?,
            codes: Frame::zeros(shape.0, shape.1),
        })
    }

    pub(super) fn write(
        &mut self,
        shown: &Frame<DisplayUnit>,
        reading: &mut FrameReader,
    ) -> Result<(), Error> {
        match &mut self.numbers {
            Numbers::Frames(writer) => writer.write(shown)?,
            Numbers::Together(together) => together.write(shown, reading)?,
        }
        if let Some(marks) = &mut self.marks {
            let codes = self.codes.values_mut().iter_mut();
            for (code, mark) in codes.zip(shown.marks()) {
                *code = mark.code().into();
            }
            marks.write(&self.codes)?;
        }
        Ok(())
    }

    pub(super) fn write_errors(&mut self, errors: &StandardErrors) -> Result<(), Error> {
        self.errors.write(errors)
    }

    pub(super) fn write_figures(&mut self, row: &FigureRow) -> Result<(), Error> {
        match &mut self.figures {
            Some(file) => Ok(file.put(row.line().as_bytes())?),
            None => Ok(()),
        }
    }

    pub(super) fn commit(self, reading: &mut FrameReader) -> Result<(), Error> {
        if let Some(figures) = self.figures {
            figures.commit()?;
        }
        if let Some(marks) = self.marks {
            marks.commit()?;
        }
        self.errors.commit()?;
        match self.numbers {
            Numbers::Frames(writer) => Ok(writer.commit()?),
            Numbers::Together(together) => together.commit(reading),
        }
    }
}

/// The table of figures, with its heading.
fn begin(file: &Path, args: &Args) -> Result<AtomicFile, Error> {
    let mut table = AtomicFile::create(file)?;
    table.put(FigureRow::heading(unit(args)).as_bytes())?;
    Ok(table)
}

/// Standard errors, their parts and intervals, as far as they are asked for.
struct ErrorFiles {
    errors: Option<FrameWriter<DisplayUnit>>,
    intervals: Option<FrameWriter<DisplayUnit>>,
    parts: Vec<(Part, FrameWriter<DisplayUnit>)>,
    room: Frame<DisplayUnit>,
}

impl ErrorFiles {
    fn create(args: &Args, shape: (usize, usize), frames: Option<u64>) -> Result<Self, Error> {
        let create = |file: &Path| {
            let writer = FrameWriter::create(file, shape, Element::F8, frames)?;
            Ok::<_, Error>(writer.allow_infinity())
        };
        let mut parts = Vec::new();
        for (part, file) in Part::ALL.into_iter().zip(part_files(args)) {
            parts.push((part, create(&file)?));
        }
        Ok(Self {
            errors: args.standard_error.as_deref().map(create).transpose()?,
            intervals: args.interval.as_deref().map(create).transpose()?,
            parts,
            room: Frame::zeros(shape.0, shape.1),
        })
    }

    fn write(&mut self, errors: &StandardErrors) -> Result<(), Error> {
        if let Some(writer) = &mut self.errors {
            writer.write(errors.last())?;
        }
        if let Some(writer) = &mut self.intervals {
            errors.half_widths_into(&mut self.room);
            writer.write(&self.room)?;
        }
        for (part, writer) in &mut self.parts {
            errors.part_into(*part, &mut self.room);
            writer.write(&self.room)?;
        }
        Ok(())
    }

    fn commit(self) -> Result<(), Error> {
        let parts = self.parts.into_iter().map(|(_, writer)| writer);
        for writer in self.errors.into_iter().chain(self.intervals).chain(parts) {
            writer.commit()?;
        }
        Ok(())
    }
}

/// Where the parts of the standard errors go, if they are asked for: beside them, `se.npz` and `se.noise.npz`.
pub(super) fn part_files(args: &Args) -> Vec<PathBuf> {
    let beside = |file: &PathBuf| {
        let ending = file.extension().unwrap_or_default().to_string_lossy();
        let name = |part: Part| file.with_extension(format!("{}.{ending}", part.word()));
        Part::ALL.map(name).to_vec()
    };
    let file = args.standard_error.as_ref().filter(|_| args.parts);
    file.map(beside).unwrap_or_default()
}

impl Together {
    fn create(args: &Args, output: &Path, sensor: &Sensor) -> Result<Self, Error> {
        let (rows, columns) = (sensor.rows(), sensor.columns());
        let file = if is_mcap(output) {
            let about = carry::about(sensor, &args.recording);
            let carry = if args.no_tare {
                Carry::without_tare()
            } else {
                Carry::default()
            };
            File::Mcap(Box::new(McapWriter::create_at_once(output, &about)?), carry)
        } else {
            let has_counts = args.input_unit == InputUnit::Counts;
            let writer = ParquetWriter::create_with_loads(output, sensor, has_counts)?;
            File::Parquet(Box::new(writer))
        };
        Ok(Self {
            file,
            clock: Clock::of(&args.recording, USUAL_RATE),
            recording: args.recording.clone(),
            output: output.to_owned(),
            counts: Frame::zeros(rows, columns),
            loads: Frame::zeros(rows, columns),
            place: 0,
        })
    }

    fn write(
        &mut self,
        shown: &Frame<DisplayUnit>,
        reading: &mut FrameReader,
    ) -> Result<(), Error> {
        self.loads.copy_meta_from(shown);
        self.loads.values_mut().copy_from_slice(shown.values());
        let position = reading.sequence();
        self.loads.sequence = position;
        let secs = reading.time_secs();
        let secs = secs.unwrap_or_else(|| self.clock.secs(self.place));
        self.loads.time_secs = Some(secs);
        self.place += 1;
        let written = match reading {
            FrameReader::Counts(source, counts) => {
                self.counts.clone_from(counts);
                // The device's own: a gap in them is all that tells of frames that never came.
                let number = source.device_number().unwrap_or(position);
                (self.counts.sequence, self.loads.sequence) = (number, number);
                self.counts.time_secs = Some(secs);
                let host = self.clock.host(&**source, secs)?;
                if let File::Mcap(writer, carry) = &mut self.file {
                    carry.before(writer, &mut **source)?;
                }
                self.put(true, host)
            }
            FrameReader::Volts(..) | FrameReader::Siemens(..) => {
                let host = self.clock.after(secs)?;
                self.put(false, host)
            }
        };
        written.map_err(|error| match error {
            Error::Io(error) => carry::whole(&self.recording, &self.output, position, error).into(),
            other => other,
        })
    }

    fn put(&mut self, has_counts: bool, host: SystemTime) -> Result<(), Error> {
        match &mut self.file {
            File::Mcap(writer, _) => {
                writer.write_counts(&self.counts, host)?;
                writer.write_loads(&self.loads, host)?;
            }
            File::Parquet(writer) => {
                let counts = has_counts.then_some(&self.counts);
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
            File::Parquet(writer) => writer.commit()?,
        }
        Ok(())
    }
}

/// Whether numbers, marks and counts go to one file.
fn is_together(args: &Args) -> bool {
    let output = args.output.as_deref();
    output.is_some_and(|output| is_mcap(output) || is_parquet(output))
}

/// Whether the output holds raw counts.
pub(super) fn holds_counts(args: &Args) -> bool {
    is_together(args) && args.input_unit == InputUnit::Counts
}

/// The unit of what is written.
pub(super) fn unit(args: &Args) -> Unit {
    if is_together(args) {
        Unit::Newtons
    } else {
        args.unit
    }
}

/// Refuses what a recording or a table cannot hold.
pub(super) fn check(args: &Args) -> Result<(), Error> {
    let Some(output) = args.output.as_deref().filter(|_| is_together(args)) else {
        return Ok(());
    };
    if !matches!(args.unit, Unit::Grams | Unit::Newtons) {
        return Err(Error::Arguments {
            what: format!(
                "{} holds loads in newtons, not {}",
                output.display(),
                args.unit.word()
            ),
            hint: "leave --unit out, or write .csv, .npy or .npz",
        });
    }
    if is_mcap(output) && args.input_unit != InputUnit::Counts {
        return Err(Error::Arguments {
            what: format!(
                "{} would be a recording without the raw counts, which {} does not hold",
                output.display(),
                args.recording.display()
            ),
            hint: "write .parquet, .csv, .npy or .npz",
        });
    }
    Ok(())
}

/// Where the marks go: where the user says, else beside the numbers, unless they are in one file with them.
pub(super) fn marks_file(args: &Args) -> Option<PathBuf> {
    let next_to = || {
        let output = args.output.as_ref()?;
        let is_file = !out::is_stdout(output) && !output.starts_with("/dev");
        (is_file && !is_together(args)).then(|| output.with_extension("marks.csv"))
    };
    args.marks.clone().or_else(next_to)
}
