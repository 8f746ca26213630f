//! `taxel convert`: a recording in another format.

use std::path::{Path, PathBuf};
use std::time::SystemTime;

use taxel::{Counts, Frame, Sensor};
use taxel_io::npy::Element;
use taxel_io::{
    FrameSource, McapReader, McapWriter, NpyWriter, NpzWriter, ParquetWriter, ReadOptions,
    TextWriter, open_counts,
};

use super::positive::positive;
use crate::error::Error;
use crate::outputs::{Files, check_ending};
use crate::progress::Progress;
use crate::{Exit, out, recorded};
use taxel_app::carry::{Carry, Clock, USUAL_RATE};
use taxel_app::{carry, frames, sensor_source};
use taxel_io::sensor_file;

/// What can be written.
const ENDINGS: [&str; 6] = ["mcap", "txt", "csv", "npy", "npz", "parquet"];

/// Write a recording in another format
///
/// Counts of .mcap, .parquet, .txt, .csv, .npy and .npz to any of them; .parquet is one row a frame and opens in
/// pandas, polars, DuckDB. Times and the sensor file are kept where the format has room for them. Exit code 3: frames
/// were left out, or the recording tells of frames that are missing.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Recording of counts
    recording: PathBuf,
    /// Where to write; its extension says the format
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Sensor file, or the name of a preset; .mcap and .parquet bring their own
    #[arg(long, value_name = "FILE|PRESET")]
    sensor: Option<PathBuf>,
    /// Frames a second of a recording that knows no time
    #[arg(long, aliases = ["fps", "rate"], value_name = "RATE", default_value_t = USUAL_RATE, value_parser = positive)]
    frames_per_second: f64,
    /// Leave out frames that cannot be read, instead of stopping at the first
    #[arg(long)]
    keep_going: bool,
    /// The recording has rows and columns swapped
    #[arg(long)]
    transpose: bool,
    /// Keep in the header of what is written what a file of another program says of persons, and names of files; left out else
    #[arg(long)]
    with_names: bool,
}

/// Frames, and the host's time where the recording knows it.
enum Source {
    Timed(Box<McapReader>),
    Plain(Box<dyn FrameSource + Send>),
}

impl Source {
    fn open(file: &Path, options: ReadOptions) -> Result<Self, Error> {
        let timed = frames::is_mcap(file);
        Ok(if timed {
            Self::Timed(Box::new(McapReader::open(file, options)?))
        } else {
            Self::Plain(open_counts(file, options)?)
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
        options: ReadOptions,
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
            "mcap" => Self::Mcap(Box::new(McapWriter::create_at_once(
                file,
                &carry::about(sensor, &args.recording),
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
            // Checked before: everything else is text.
            _ => Self::Text(Box::new(TextWriter::create(file)?)),
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

/// Refuses, before any work, what cannot be written.
fn check(args: &Args) -> Result<(), Error> {
    check_ending(
        "-o",
        &args.output,
        &ENDINGS,
        "the ending says the format; .parquet is one row a frame",
    )?;
    let files = Files::default()
        .input("recording", &args.recording)
        .maybe_sensor(args.sensor.as_ref());
    files.output("-o", &args.output).check()
}

/// Raw counts of up to 16 bits is what recordings and tables hold.
fn check_bits(args: &Args, sensor: &Sensor) -> Result<(), Error> {
    let ending = args.output.extension().unwrap_or_default();
    let limited = ending.eq_ignore_ascii_case("mcap") || ending.eq_ignore_ascii_case("parquet");
    if limited {
        Ok(carry::check_bits(&args.output, sensor)?)
    } else {
        Ok(())
    }
}

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<Exit, Error> {
    check(args)?;
    let sensor = match &args.sensor {
        Some(file) => sensor_file::load(file)?,
        None => sensor_source::of_recording(&args.recording)?.0,
    };
    let sensor = recorded::named(sensor, &args.recording, args.with_names)?;
    check_bits(args, &sensor)?;
    let mut options = ReadOptions::of(&sensor);
    options.keep_going = args.keep_going;
    options.accept_damage = true;
    options.transpose = args.transpose;
    let mut source = Source::open(&args.recording, options)?;
    let element = match source {
        Source::Timed(_) => Element::U2,
        Source::Plain(_) => Element::F8,
    };
    let mut sink = Sink::create(args, &sensor, options, element)?;
    let clock = Clock::of(&args.recording, args.frames_per_second);
    let progress = Progress::new("converting");
    let mut frame = Frame::zeros(sensor.rows(), sensor.columns());
    let mut count = 0u64;
    let mut carry = Carry::default();
    while source.frames().next_into(&mut frame)? {
        let secs = *frame.time_secs.get_or_insert(clock.secs(count));
        let host = clock.host(source.frames().host_time(), secs)?;
        let position = frame.sequence;
        if let Some(number) = source.frames().device_number() {
            // The device's own: a gap in them is all that tells of frames that never came.
            frame.sequence = number;
        }
        if let Sink::Mcap(writer) = &mut sink {
            carry.before(writer, source.frames())?;
        }
        sink.write(&frame, host).map_err(|error| match error {
            Error::Io(error) => carry::whole(&args.recording, &args.output, position, error).into(),
            other => other,
        })?;
        count += 1;
        frames::show(source.frames(), &progress);
    }
    drop(progress);
    let integrity = source.frames().integrity();
    if let Sink::Mcap(writer) = &mut sink {
        carry.end(writer, source.frames(), integrity.losses)?;
    }
    sink.commit()?;
    let is_missing = recorded::tell_missing(&args.recording, &integrity);
    let skipped = source.frames().skipped();
    for left_out in source.frames().skips() {
        out::warn(&left_out.error.to_string());
    }
    out::note(&format!("wrote {}: {count} frames", args.output.display()));
    Ok(if skipped == 0 && !is_missing {
        Exit::Good
    } else {
        Exit::DataLost
    })
}
