//! `taxel simulate`: the scan of given conductances, exactly.

use std::path::{Path, PathBuf};

use clap::ValueEnum;
use taxel::circuit::{Circuit, Converter, LinearCircuit, OperatingPoint};
use taxel::{Counts, Frame, Sensor, Siemens, Volts};
use taxel_record::npy::Element;
use taxel_record::{FrameSource, TextOptions, TextWriter};

use crate::error::Error;
use crate::frames::{FrameWriter, needs_frame_count, open_values, show};
use crate::progress::Progress;
use crate::{Exit, out, sensor_file};

/// Scan given conductances with a virtual sensor
///
/// Reads R lines of C conductances (siemens) a frame and writes what the read-out gives: exactly, without
/// noise. Numbers are written so that they read back exactly.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Sensor file, or the name of a preset
    #[arg(long, value_name = "FILE|PRESET")]
    sensor: PathBuf,
    /// Conductances to scan, siemens (.csv, .npy, .npz, - for standard input)
    #[arg(long, value_name = "FILE")]
    conductance: PathBuf,
    /// What to write: V_out in volts, or the converter's counts
    #[arg(long, value_enum, default_value_t)]
    unit: OutputUnit,
    /// Where to write it; without it, numbers go to standard output
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// The file of conductances has rows and columns swapped
    #[arg(long)]
    transpose: bool,
}

/// What a simulated read-out gives.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
enum OutputUnit {
    /// V_out of the circuit
    #[default]
    Volts,
    /// What the converter makes of it
    Counts,
}

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<Exit, Error> {
    let sensor = sensor_file::load(&args.sensor)?;
    let circuit = LinearCircuit::from_sensor(&sensor).map_err(|source| Error::InFile {
        file: args.sensor.clone(),
        source,
    })?;
    let options = TextOptions {
        transpose: args.transpose,
        ..TextOptions::of(&sensor)
    };
    let file = &args.conductance;
    let output = args.output.as_deref().unwrap_or(Path::new("-"));
    let frames = match needs_frame_count(output) {
        true => Some(count(file, options)?),
        false => None,
    };
    let mut writer = Writer::create(output, &sensor, args.unit, frames)?;
    let mut source = open_values::<Siemens>(file, options)?;
    let mut point = circuit.operating_point();
    let mut siemens = Frame::zeros(sensor.rows(), sensor.columns());
    let mut volts = siemens.map(|_, _| 0.0);
    let progress = Progress::new("scanning");
    let mut written = 0;
    while source.next_into(&mut siemens)? {
        scan(&mut *point, &siemens, &mut volts, file)?;
        writer.write(&volts)?;
        written += 1;
        show(&source, &progress);
    }
    drop(progress);
    writer.commit()?;
    if !out::is_stdout(output) {
        out::note(&format!(
            "{written} frames scanned, in {}",
            output.display()
        ));
    }
    Ok(Exit::Good)
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
    volts.take_marks(siemens);
    Ok(())
}

fn count(file: &Path, options: TextOptions) -> Result<u64, Error> {
    let mut source = open_values::<Siemens>(file, options)?;
    let mut frame = Frame::zeros(options.rows, options.columns);
    let mut frames = 0;
    while source.next_into(&mut frame)? {
        frames += 1;
    }
    Ok(frames)
}

/// Volts, or what a converter makes of them, as text or as an array.
enum Writer {
    Volts(FrameWriter<Volts>),
    Text(TextWriter, Converter),
    Array(FrameWriter<Counts>, Converter),
}

impl Writer {
    fn create(
        file: &Path,
        sensor: &Sensor,
        unit: OutputUnit,
        frames: Option<u64>,
    ) -> Result<Self, Error> {
        let shape = (sensor.rows(), sensor.columns());
        let is_array = file
            .extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("npy") || e.eq_ignore_ascii_case("npz"));
        let converter = Converter::from_sensor(sensor);
        Ok(match (unit, is_array) {
            (OutputUnit::Volts, _) => {
                Self::Volts(FrameWriter::create(file, shape, Element::F8, frames)?)
            }
            (OutputUnit::Counts, false) => Self::Text(TextWriter::create(file)?, converter),
            (OutputUnit::Counts, true) => {
                let element = match sensor.converter.bits {
                    0..=16 => Element::U2,
                    _ => Element::U4,
                };
                let writer = FrameWriter::create(file, shape, element, frames)?;
                Self::Array(writer, converter)
            }
        })
    }

    fn write(&mut self, volts: &Frame<Volts>) -> Result<(), Error> {
        match self {
            Self::Volts(writer) => writer.write(volts),
            Self::Text(writer, converter) => Ok(writer.write(&converter.counts_from_volts(volts))?),
            Self::Array(writer, converter) => writer.write(&converter.counts_from_volts(volts)),
        }
    }

    fn commit(self) -> Result<(), Error> {
        match self {
            Self::Volts(writer) => writer.commit(),
            Self::Text(writer, _) => Ok(writer.commit()?),
            Self::Array(writer, _) => writer.commit(),
        }
    }
}
