//! `taxel simulate`: a virtual sensor, scanning given conductances exactly, or load patterns with all that a
//! real sensor adds.

mod pattern;
mod writer;

use std::path::{Path, PathBuf};

use clap::{ArgGroup, ValueEnum};
use taxel::circuit::{Circuit, OperatingPoint, SensorCircuit};
use taxel::{Frame, Sensor, Siemens, Volts};
use taxel_io::{FrameSource, ReadOptions};

use crate::error::Error;
use crate::progress::Progress;
use crate::{Exit, out};
use taxel_app::frames::{needs_frame_count, open_values, show};
use taxel_io::sensor_file;
use writer::Writer;

/// Record with a virtual sensor
///
/// With --conductance: reads R lines of C conductances (siemens) a frame and writes what the read-out gives,
/// exactly, without noise; numbers are written so that they read back exactly. With --pattern: loads go
/// through material, circuit, noise and converter to a recording of counts, the same for the same seed.
#[derive(Debug, clap::Args)]
#[command(group = ArgGroup::new("source").required(true))]
pub(crate) struct Args {
    /// Sensor file, or the name of a preset
    #[arg(long, value_name = "FILE|PRESET")]
    sensor: PathBuf,
    /// Conductances to scan, siemens (.csv, .npy, .npz, - for standard input)
    #[arg(long, value_name = "FILE", group = "source")]
    conductance: Option<PathBuf>,
    /// What presses on the array
    #[arg(long, value_enum, group = "source")]
    pattern: Option<pattern::Name>,
    /// What to write: V_out in volts (before any noise), or the converter's counts. Default: volts for
    /// --conductance, counts for --pattern
    #[arg(long, value_enum)]
    unit: Option<OutputUnit>,
    /// Where to write it (.txt, .csv, .npy, .npz; counts also .mcap, with the sensor); without it, numbers go to standard output
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// The file of conductances has rows and columns swapped
    #[arg(long, requires = "conductance")]
    transpose: bool,
    #[command(flatten)]
    drawn: pattern::Drawn,
}

/// What a simulated read-out gives.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum OutputUnit {
    /// V_out of the circuit
    Volts,
    /// What the converter makes of it
    Counts,
}

impl Args {
    fn output(&self) -> &Path {
        self.output.as_deref().unwrap_or(Path::new("-"))
    }
}

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<Exit, Error> {
    args.drawn.check_files(args)?;
    let sensor = sensor_file::load(&args.sensor)?;
    let (frames, what) = match (&args.conductance, args.pattern) {
        (Some(file), _) => (scan_file(args, &sensor, file)?, "scanned"),
        (None, Some(name)) => (pattern::record(args, &sensor, name)?, "simulated"),
        (None, None) => unreachable!("clap asks for one of them"),
    };
    if !out::is_stdout(args.output()) {
        out::note(&format!(
            "{frames} frames {what}, in {}",
            args.output().display()
        ));
    }
    Ok(Exit::Good)
}

/// Scans every frame of a file of conductances; gives back how many there were.
fn scan_file(args: &Args, sensor: &Sensor, file: &Path) -> Result<u64, Error> {
    let circuit =
        SensorCircuit::from_sensor(sensor).map_err(|source| taxel_app::Error::InFile {
            file: args.sensor.clone(),
            source,
        })?;
    let mut options = ReadOptions::of(sensor);
    options.transpose = args.transpose;
    let output = args.output();
    let frames = if needs_frame_count(output) {
        Some(count(file, options)?)
    } else {
        None
    };
    let unit = args.unit.unwrap_or(OutputUnit::Volts);
    let mut writer = Writer::create(output, sensor, unit, frames)?;
    let mut source = open_values::<Siemens>(file, options)?;
    let mut point = circuit.operating_point();
    let mut siemens = Frame::zeros(sensor.rows(), sensor.columns());
    let mut volts = siemens.map(|_, _| 0.0);
    let progress = Progress::new("scanning");
    let mut written = 0;
    while source.next_into(&mut siemens)? {
        for (taxel, conductance) in siemens.values_mut().iter_mut().enumerate() {
            if sensor.is_absent(taxel) {
                *conductance = 0.0;
            }
        }
        scan(&mut *point, &siemens, &mut volts, file)?;
        writer.write(&volts)?;
        written += 1;
        show(&source, &progress);
    }
    drop(progress);
    writer.commit()?;
    Ok(written)
}

/// Scans one frame; `file` is where its conductances come from.
fn scan(
    point: &mut dyn OperatingPoint,
    siemens: &Frame<Siemens>,
    volts: &mut Frame<Volts>,
    file: &Path,
) -> Result<(), Error> {
    point
        .set(siemens.values())
        .map_err(|source| Error::NotPassive {
            file: file.to_owned(),
            frame: siemens.sequence,
            source,
        })?;
    point.predict_into(volts.values_mut());
    volts.copy_meta_from(siemens);
    Ok(())
}

fn count(file: &Path, options: ReadOptions) -> Result<u64, Error> {
    let mut source = open_values::<Siemens>(file, options)?;
    let mut frame = Frame::zeros(options.rows, options.columns);
    let mut frames = 0;
    while source.next_into(&mut frame)? {
        frames += 1;
    }
    Ok(frames)
}
