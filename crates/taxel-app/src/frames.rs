//! Frames in and out of files, whatever the quantity and the format.

use std::fs;
use std::path::{Path, PathBuf};

use taxel::{Counts, Frame, Sensor, Siemens, Volts};
use taxel_io::npy::Element;
use taxel_io::{
    FrameSource, Integrity, LoadsReader, NpyOptions, NpyReader, NpyWriter, NpzWriter,
    ParquetReader, ReadOptions, Skipped, Tare, ValuesReader, ValuesWriter, exports, extension,
    open_counts,
};

use crate::error::{Error, remedy};
use crate::reporter::{Reporter, Stage};
use crate::units::InputUnit;

/// Numbers in the unit that the user asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DisplayUnit;

/// A file of frames, and how to read it.
#[derive(Debug, Clone)]
pub struct Input {
    /// The file; `-` is standard input.
    pub file: PathBuf,
    /// What its numbers are.
    pub unit: InputUnit,
    /// Shape, range, and what to do about a frame that cannot be read.
    pub options: ReadOptions,
}

impl Input {
    /// Frames of a sensor.
    pub fn new(file: &Path, unit: InputUnit, sensor: &Sensor) -> Self {
        Self {
            file: file.to_owned(),
            unit,
            options: ReadOptions::of(sensor),
        }
    }

    /// Opens it.
    pub fn open(&self) -> Result<FrameReader, Error> {
        let (file, options) = (&self.file, self.options);
        if self.unit != InputUnit::Counts && carries_sensor(file) {
            return Err(Error::Request {
                what: format!("{} holds counts, no volts or siemens", file.display()),
                hint: remedy::READ_AS_COUNTS,
            });
        }
        let (rows, columns) = (options.rows, options.columns);
        Ok(match self.unit {
            InputUnit::Counts => {
                FrameReader::Counts(open_counts(file, options)?, Frame::zeros(rows, columns))
            }
            InputUnit::Volts => {
                FrameReader::Volts(open_values(file, options)?, Frame::zeros(rows, columns))
            }
            InputUnit::Siemens => {
                FrameReader::Siemens(open_values(file, options)?, Frame::zeros(rows, columns))
            }
        })
    }

    /// Whether it can be read a second time: a file, no pipe.
    pub fn can_be_read_twice(&self) -> bool {
        let file = exports::file_of(&self.file);
        file.as_os_str() != "-" && fs::metadata(file).is_ok_and(|about| about.is_file())
    }

    /// Reads it through for the number of its frames.
    pub fn count_frames(&self, reporter: &dyn Reporter) -> Result<u64, Error> {
        let mut reading = self.open()?;
        let stage = reporter.stage("counting frames");
        let mut frames = 0;
        while reading.advance()? {
            if stage.is_stopped() {
                return Err(Error::Stopped);
            }
            frames += 1;
            reading.show(&*stage);
        }
        Ok(frames)
    }
}

/// A source of numbers as they are, whatever they are: of `.csv` or `.npy`, or the loads of a recording, newtons.
pub fn open_shown(
    file: &Path,
    options: ReadOptions,
) -> Result<Box<dyn FrameSource<DisplayUnit> + Send>, Error> {
    if is_mcap(file) {
        return Ok(Box::new(LoadsReader::open(file, options)?));
    }
    if is_parquet(file) {
        return Ok(Box::new(ParquetReader::open_loads(file, options)?));
    }
    open_values(file, options)
}

/// A source of numbers that are no counts, `.csv` or `.npy`.
pub fn open_values<Q: Send + 'static>(
    file: &Path,
    options: ReadOptions,
) -> Result<Box<dyn FrameSource<Q> + Send>, Error> {
    if carries_sensor(file) {
        return Err(Error::Request {
            what: format!(
                "{} is a recording of counts, where a file of values is expected",
                file.display()
            ),
            hint: remedy::COMPENSATE,
        });
    }
    Ok(if is_array(file) {
        Box::new(NpyReader::open_values(file, NpyOptions::from(options))?)
    } else {
        Box::new(ValuesReader::open(file, options)?)
    })
}

/// An open file and the frame read last.
pub enum FrameReader {
    /// What the converter gave.
    Counts(Box<dyn FrameSource + Send>, Frame<Counts>),
    /// What the circuit gave.
    Volts(Box<dyn FrameSource<Volts> + Send>, Frame<Volts>),
    /// What an inverse gave.
    Siemens(Box<dyn FrameSource<Siemens> + Send>, Frame<Siemens>),
}

impl FrameReader {
    /// Reads the next frame; false at the end.
    pub fn advance(&mut self) -> Result<bool, Error> {
        Ok(match self {
            FrameReader::Counts(source, frame) => source.next_into(frame)?,
            FrameReader::Volts(source, frame) => source.next_into(frame)?,
            FrameReader::Siemens(source, frame) => source.next_into(frame)?,
        })
    }

    /// Position of the frame read last in its recording, from 0.
    pub fn sequence(&self) -> u64 {
        match self {
            FrameReader::Counts(_, frame) => frame.sequence,
            FrameReader::Volts(_, frame) => frame.sequence,
            FrameReader::Siemens(_, frame) => frame.sequence,
        }
    }

    /// Device time of the frame read last, seconds, where the recording knows it.
    pub fn time_secs(&self) -> Option<f64> {
        match self {
            FrameReader::Counts(_, frame) => frame.time_secs,
            FrameReader::Volts(_, frame) => frame.time_secs,
            FrameReader::Siemens(_, frame) => frame.time_secs,
        }
    }

    /// How many frames were left out, and the first of them.
    pub fn skips(&self) -> (usize, &[Skipped]) {
        match self {
            FrameReader::Counts(source, _) => (source.skipped(), source.skips()),
            FrameReader::Volts(source, _) => (source.skipped(), source.skips()),
            FrameReader::Siemens(source, _) => (source.skipped(), source.skips()),
        }
    }

    /// What is known to be missing.
    pub fn integrity(&self) -> Integrity {
        match self {
            FrameReader::Counts(source, _) => source.integrity(),
            FrameReader::Volts(source, _) => source.integrity(),
            FrameReader::Siemens(source, _) => source.integrity(),
        }
    }

    /// What was taken off the loads of the frame read last, while it was recorded.
    pub fn tare(&self) -> Option<&Tare> {
        match self {
            FrameReader::Counts(source, _) => source.tare(),
            FrameReader::Volts(..) | FrameReader::Siemens(..) => None,
        }
    }

    /// Tells how much was read.
    pub fn show(&self, stage: &dyn Stage) {
        match self {
            FrameReader::Counts(source, _) => show(source, stage),
            FrameReader::Volts(source, _) => show(source, stage),
            FrameReader::Siemens(source, _) => show(source, stage),
        }
    }
}

/// Tells how much of a source was read.
pub fn show<Q>(source: &(impl FrameSource<Q> + ?Sized), stage: &dyn Stage) {
    stage.set_bytes(source.bytes_read(), source.bytes_total());
}

/// A file that frames are written to: text, `.npy`, `.npz` by its extension. It appears when committed.
pub enum FrameWriter<Q> {
    /// Lines of numbers.
    Text(Box<ValuesWriter<Q>>),
    /// An array.
    Npy(Box<NpyWriter<Q>>),
    /// An archive with one array, `frames`.
    Npz(Box<NpzWriter>),
}

impl<Q> FrameWriter<Q> {
    /// Begins the file for frames of `shape`. An archive is begun with the number of its frames.
    pub fn create(
        file: &Path,
        shape: (usize, usize),
        element: Element,
        frames: Option<u64>,
    ) -> Result<Self, Error> {
        let (rows, columns) = shape;
        Ok(match extension(file).as_str() {
            "npy" => Self::Npy(Box::new(NpyWriter::create(file, rows, columns, element)?)),
            "npz" => {
                let Some(frames) = frames else {
                    return Err(Error::Request {
                        what: format!(
                            "{} needs the number of frames before the first, which a pipe does not tell",
                            file.display()
                        ),
                        hint: "write .npy, or read from a file",
                    });
                };
                let mut writer = NpzWriter::create(file)?;
                writer.begin_array("frames", Some(frames), rows, columns, element)?;
                Self::Npz(Box::new(writer))
            }
            _ => Self::Text(Box::new(ValuesWriter::create(file)?)),
        })
    }

    /// The same, but infinite numbers are written too: standard errors of what nothing bounds.
    pub fn allow_infinity(self) -> Self {
        match self {
            Self::Text(writer) => Self::Text(Box::new(writer.allow_infinity())),
            Self::Npy(writer) => Self::Npy(Box::new(writer.allow_infinity())),
            Self::Npz(writer) => Self::Npz(Box::new(writer.allow_infinity())),
        }
    }

    /// Appends a frame.
    pub fn write(&mut self, frame: &Frame<Q>) -> Result<(), Error> {
        match self {
            Self::Text(writer) => writer.write(frame)?,
            Self::Npy(writer) => writer.write(frame)?,
            Self::Npz(writer) => writer.write(frame)?,
        }
        Ok(())
    }

    /// Finishes the file and gives it its name.
    pub fn commit(self) -> Result<(), Error> {
        match self {
            Self::Text(writer) => writer.commit()?,
            Self::Npy(writer) => writer.commit()?,
            Self::Npz(writer) => writer.commit()?,
        }
        Ok(())
    }
}

/// Endings of the files of numbers that a [`FrameWriter`] writes.
pub const NUMBERS: [&str; 4] = ["csv", "txt", "npy", "npz"];

/// Whether a file of this name is an array of numpy.
pub fn is_array(file: &Path) -> bool {
    matches!(extension(file).as_str(), "npy" | "npz")
}

/// Whether a file of this name is a recording with times and its sensor.
pub fn is_mcap(file: &Path) -> bool {
    extension(file) == "mcap"
}

/// Whether a file of this name is a table of one row a frame.
pub fn is_parquet(file: &Path) -> bool {
    extension(file) == "parquet"
}

/// Whether a file may carry the sensor that it is of: by its name, or since another program has exported it.
pub fn carries_sensor(file: &Path) -> bool {
    is_mcap(file) || is_parquet(file) || exports::is_export(file)
}

/// Whether a file of this name needs the number of frames before the first.
pub fn needs_frame_count(file: &Path) -> bool {
    extension(file) == "npz"
}
