//! `taxel convert`: a recording in another format.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use taxel::{Counts, Frame, Sensor};
use taxel_record::mcap::About;
use taxel_record::npy::Element;
use taxel_record::{
    FrameSource, McapReader, McapWriter, NpyWriter, NpzWriter, ParquetWriter, TextOptions,
    TextWriter, open_counts,
};

use crate::error::Error;
use crate::progress::Progress;
use crate::{Exit, frames, live_sensor, out, sensor_file};

/// Write a recording in another format
///
/// Counts of .mcap, .txt, .csv, .npy and .npz to .mcap, .txt, .csv, .npy, .npz or .parquet (one row a frame: opens in
/// pandas, polars, DuckDB). Times and the sensor file are kept where the format has room for them. Exit code 3: frames
/// were left out.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Recording of counts
    recording: PathBuf,
    /// Where to write; its extension says the format
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Sensor file, or the name of a preset; MCAP recordings bring their own
    #[arg(long, value_name = "FILE|PRESET")]
    sensor: Option<PathBuf>,
    /// Frames a second of a recording that knows no time
    #[arg(long, value_name = "N", default_value_t = 100.0)]
    fps: f64,
    /// Leave out frames that cannot be read, instead of stopping at the first
    #[arg(long)]
    keep_going: bool,
    /// The recording has rows and columns swapped
    #[arg(long)]
    transpose: bool,
}

/// Frames, and the host's time where the recording knows it.
enum Source {
    Timed(Box<McapReader>),
    Plain(Box<dyn FrameSource + Send>),
}

impl Source {
    fn open(file: &Path, options: TextOptions) -> Result<Self, Error> {
        let timed = frames::is_mcap(file);
        Ok(match timed {
            true => Self::Timed(Box::new(McapReader::open(file, options)?)),
            false => Self::Plain(open_counts(file, options)?),
        })
    }

    fn frames(&mut self) -> &mut dyn FrameSource {
        match self {
            Source::Timed(reader) => &mut **reader,
            Source::Plain(source) => &mut **source,
        }
    }
}

enum Sink {
    Mcap(Box<McapWriter>),
    Text(Box<TextWriter>),
    Npy(Box<NpyWriter<Counts>>),
    Npz(Box<NpzWriter>),
    Parquet(Box<ParquetWriter>),
}

impl Sink {
    /// `element`: what arrays hold; raw counts are whole, averaged recordings are not.
    fn create(
        args: &Args,
        sensor: &Sensor,
        options: TextOptions,
        element: Element,
    ) -> Result<Self, Error> {
        let file = &args.output;
        let (rows, columns) = (sensor.rows(), sensor.columns());
        let extension = file
            .extension()
            .unwrap_or_default()
            .to_string_lossy()
            .to_ascii_lowercase();
        Ok(match extension.as_str() {
            "mcap" => Self::Mcap(Box::new(McapWriter::create(
                file,
                &About {
                    sensor: sensor.clone(),
                    program: format!("taxel {}", env!("CARGO_PKG_VERSION")),
                    source: format!("file:{}", args.recording.display()),
                },
            )?)),
            "parquet" => Self::Parquet(Box::new(ParquetWriter::create(file, sensor)?)),
            "npy" => Self::Npy(Box::new(NpyWriter::create(file, rows, columns, element)?)),
            "npz" => {
                let mut counting = Source::open(&args.recording, options)?;
                let mut frame = Frame::zeros(rows, columns);
                let mut count = 0;
                while counting.frames().next_into(&mut frame)? {
                    count += 1;
                }
                let mut writer = NpzWriter::create(file)?;
                writer.begin_array("frames", Some(count), rows, columns, element)?;
                Self::Npz(Box::new(writer))
            }
            "txt" | "csv" => Self::Text(Box::new(TextWriter::create(file)?)),
            _ => {
                return Err(Error::Arguments {
                    what: format!("cannot tell the format of {}", file.display()),
                    hint: "its name ends in .mcap, .txt, .csv, .npy, .npz or .parquet",
                });
            }
        })
    }

    fn write(&mut self, frame: &Frame<Counts>, host: SystemTime) -> Result<(), Error> {
        match self {
            Sink::Mcap(writer) => writer.write_counts(frame, host)?,
            Sink::Text(writer) => writer.write(frame)?,
            Sink::Npy(writer) => writer.write(frame)?,
            Sink::Npz(writer) => writer.write(frame)?,
            Sink::Parquet(writer) => writer.write(frame, host)?,
        }
        Ok(())
    }

    fn commit(self) -> Result<(), Error> {
        match self {
            Sink::Mcap(writer) => writer.finish()?,
            Sink::Text(writer) => writer.commit()?,
            Sink::Npy(writer) => writer.commit()?,
            Sink::Npz(writer) => writer.commit()?,
            Sink::Parquet(writer) => writer.commit()?,
        }
        Ok(())
    }
}

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<Exit, Error> {
    if !(args.fps > 0.0 && args.fps.is_finite()) {
        return Err(Error::Arguments {
            what: format!("--fps {}: no frame rate", args.fps),
            hint: "a number above 0",
        });
    }
    let sensor = match &args.sensor {
        Some(file) => sensor_file::load(file)?,
        None => live_sensor::of_recording(&args.recording)?.0,
    };
    let mut options = TextOptions::of(&sensor);
    options.keep_going = args.keep_going;
    options.transpose = args.transpose;
    let mut source = Source::open(&args.recording, options)?;
    let element = match source {
        Source::Timed(_) => Element::U2,
        Source::Plain(_) => Element::F8,
    };
    let mut sink = Sink::create(args, &sensor, options, element)?;
    // Of a recording without times only its file's date is known.
    let begun = fs::metadata(&args.recording)
        .and_then(|about| about.modified())
        .unwrap_or_else(|_| SystemTime::now());
    let progress = Progress::new("converting");
    let mut frame = Frame::zeros(sensor.rows(), sensor.columns());
    let mut count = 0u64;
    while source.frames().next_into(&mut frame)? {
        let secs = *frame.time_secs.get_or_insert(count as f64 / args.fps);
        let host = match &source {
            Source::Timed(reader) => reader.host_time(),
            Source::Plain(_) => begun + Duration::from_secs_f64(secs.max(0.0)),
        };
        sink.write(&frame, host)?;
        count += 1;
        frames::show(source.frames(), &progress);
    }
    drop(progress);
    sink.commit()?;
    let skipped = source.frames().skipped();
    for left_out in source.frames().skips() {
        out::warn(&left_out.error.to_string());
    }
    out::note(&format!("{}: {count} frames", args.output.display()));
    Ok(match skipped {
        0 => Exit::Good,
        _ => Exit::DataLost,
    })
}
