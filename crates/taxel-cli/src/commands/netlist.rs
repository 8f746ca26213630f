//! `taxel netlist`: the circuit for ngspice or LTspice, so that anybody can check us.

use std::path::{Path, PathBuf};

use taxel::circuit::netlist::{Selection, netlist};
use taxel::{Frame, Sensor, Siemens};
use taxel_io::{AtomicFile, FrameSource, ReadOptions};

use super::taxel_address::TaxelAddress;
use crate::error::Error;
use crate::out::warn_unsolved;
use crate::outputs::Files;
use crate::progress::Terminal;
use crate::{Exit, out, recorded};
use taxel_app::chain::Chain;
use taxel_app::frames::{DisplayUnit, Input, open_values};
use taxel_app::line_survey::Survey;
use taxel_app::methods::MethodName;
use taxel_app::units::{InputUnit, Unit};

/// Conductance of an unloaded taxel where the sensor file has no load law, siemens.
const UNLOADED_SIEMENS: f64 = 1e-6;

/// Write a sensor's circuit as a SPICE netlist
///
/// Any SPICE finds the operating point of the selected taxel; `ngspice -b` also runs the whole scan. The
/// taxels have the given conductances, or those behind a frame of a recording, or none is loaded.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Recording of counts whose conductances to take
    #[arg(conflicts_with = "conductance")]
    recording: Option<PathBuf>,
    /// Sensor file, or the name of a preset; .mcap and .parquet bring their own
    #[arg(long, value_name = "FILE|PRESET")]
    sensor: Option<PathBuf>,
    /// Conductances of the taxels, siemens: R lines of C numbers a frame
    #[arg(long, value_name = "FILE")]
    conductance: Option<PathBuf>,
    /// Which frame of the file, from 0
    #[arg(long, value_name = "N", default_value_t = 0)]
    frame: u64,
    /// The taxel to read
    #[arg(long, value_name = "ROW,COLUMN|C7", default_value = "0,0")]
    taxel: TaxelAddress,
    /// Read every taxel, one after the other (a script for ngspice)
    #[arg(long, conflicts_with = "taxel")]
    scan: bool,
    /// Where to write it; without it, standard output
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<Exit, Error> {
    Files::default()
        .maybe_input("recording", args.recording.as_ref())
        .maybe_sensor(args.sensor.as_ref())
        .maybe_input("file of conductances", args.conductance.as_ref())
        .maybe_output("-o", args.output.as_ref())
        .check()?;
    let recording = args.recording.as_deref();
    let (sensor, sensor_file) = recorded::needed_sensor(args.sensor.as_deref(), recording)?;
    let (rows, columns) = (sensor.rows(), sensor.columns());
    let (row, column) = args.taxel.place(sensor.array().labels.as_deref())?;
    if row >= rows || column >= columns {
        return Err(Error::TaxelOutside {
            option: "--taxel",
            row,
            column,
            rows,
            columns,
        });
    }
    let siemens = conductances(args, &sensor, &sensor_file)?;
    let selection = if args.scan {
        Selection::Scan
    } else {
        Selection::Taxel { row, column }
    };
    let text =
        netlist(&sensor, &siemens, selection).map_err(|source| taxel_app::Error::InFile {
            file: sensor_file.clone(),
            source,
        })?;
    match &args.output {
        Some(output) => {
            let mut file = AtomicFile::create(output)?;
            file.put(text.as_bytes())?;
            file.commit()?;
            out::note(&format!("wrote {}", output.display()));
        }
        None => out::result(&text)?,
    }
    Ok(Exit::Good)
}

fn conductances(args: &Args, sensor: &Sensor, from: &Path) -> Result<Frame<Siemens>, Error> {
    let (rows, columns) = (sensor.rows(), sensor.columns());
    if let Some(file) = &args.conductance {
        let mut source = open_values::<Siemens>(file, ReadOptions::of(sensor))?;
        let mut frame = Frame::zeros(rows, columns);
        let mut read = 0;
        while source.next_into(&mut frame)? {
            if read == args.frame {
                return Ok(frame);
            }
            read += 1;
        }
        return Err(no_frame(args, file, read));
    }
    if let Some(file) = &args.recording {
        return behind_counts(args, sensor, from, file);
    }
    let unloaded = sensor.material().map(|m| m.g_zero_siemens);
    let unloaded = unloaded.filter(|&g| g > 0.0).unwrap_or(UNLOADED_SIEMENS);
    Ok(Frame::filled(rows, columns, unloaded))
}

/// The conductances behind a frame of a recording; what noise makes negative is 0.
fn behind_counts(
    args: &Args,
    sensor: &Sensor,
    from: &Path,
    file: &Path,
) -> Result<Frame<Siemens>, Error> {
    let input = Input::new(file, InputUnit::Counts, sensor);
    let mut chain = Chain::new(sensor, from, &MethodName::Auto, Unit::Siemens)?;
    chain.set_lines(&Survey::of(&input, sensor, &Terminal, None)?.faults);
    let mut reading = input.open()?;
    let mut read = 0;
    while reading.advance()? {
        if read == args.frame {
            if let Some(outcome) = chain.take(&reading)? {
                warn_unsolved(read, &outcome);
            }
            let mut shown = Frame::<DisplayUnit>::zeros(sensor.rows(), sensor.columns());
            chain.show_into(&mut shown)?;
            return Ok(shown.map(|_, siemens| siemens.max(0.0)));
        }
        read += 1;
    }
    Err(no_frame(args, file, read))
}

fn no_frame(args: &Args, file: &Path, found: u64) -> Error {
    taxel_app::Error::NoFrame {
        asked_by: "--frame".to_owned(),
        file: file.to_owned(),
        wanted: args.frame,
        found,
    }
    .into()
}
