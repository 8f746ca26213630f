//! `taxel calibrate --equilibration` without presses: law and gains from the same load everywhere.

use std::path::Path;

use taxel::Sensor;
use taxel::calibrate::calibrate_uniform;
use taxel_app::executor::Threads;
use taxel_app::presses;
use taxel_io::ReadOptions;

use super::{Args, options_of, refuse_what_needs_presses};
use crate::error::Error;
use crate::progress::{Progress, Terminal};
use crate::{Exit, out};

/// Fits and writes; the circuit stays as the sensor file has it.
pub(super) fn run(args: &Args, sensor: &Sensor, table: &Path) -> Result<Exit, Error> {
    refuse_what_needs_presses(args, "uniform loads alone do not tell the circuit")?;
    let mut options = ReadOptions::of(sensor);
    options.transpose = args.transpose;
    let uniform = presses::read_uniform(table, options, &Terminal)?;
    let progress = Progress::new("fitting");
    let mut show = |stage: &str, share| progress.stage(stage, share);
    let options = options_of(args, table);
    let found = calibrate_uniform(sensor, &uniform, &options, &Threads, &mut show);
    drop(progress);
    let found = found.map_err(|source| taxel_app::Error::InFile {
        file: table.to_owned(),
        source,
    })?;
    out::file(&args.output, found.sensor.to_toml().as_bytes())?;
    if args.json {
        out::json(&found.report)?
    } else {
        out::result(&found.report.to_string())?
    }
    out::note(&format!("wrote {}", args.output.display()));
    Ok(if found.report.doubts.is_empty() {
        Exit::Good
    } else {
        Exit::DataLost
    })
}
