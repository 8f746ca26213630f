//! `taxel calibrate --totals`: the load law from what all taxels carry together.

use std::path::Path;

use taxel::Sensor;
use taxel::calibrate::{TotalLoad, TotalsReport, calibrate_totals};
use taxel_app::executor::Threads;
use taxel_app::presses;
use taxel_io::ReadOptions;

use super::{Args, options_of, refuse_what_needs_presses};
use crate::error::Error;
use crate::progress::{Progress, Terminal};
use crate::{Exit, out};

/// Fits and writes; the circuit stays as the sensor file has it.
pub(super) fn run(args: &Args, sensor: &Sensor, table: &Path) -> Result<Exit, Error> {
    let why = "known totals do not tell the circuit, nor single taxels";
    refuse_what_needs_presses(args, why)?;
    let mut options = ReadOptions::of(sensor);
    options.transpose = args.transpose;
    let read = presses::read_total_loads(table, options, &Terminal)?;
    let (lines, totals): (Vec<u64>, Vec<TotalLoad>) = read.into_iter().unzip();
    let progress = Progress::new("fitting");
    let mut show = |stage: &str, share| progress.stage(stage, share);
    let options = options_of(args, table);
    let found = calibrate_totals(sensor, &totals, &options, &Threads, &mut show);
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
    let exit = doubt(&found.report, table, &lines);
    out::note(&format!("wrote {}", args.output.display()));
    Ok(exit)
}

/// Names totals that took no part, by their lines, and says what speaks against using the fit.
fn doubt(report: &TotalsReport, table: &Path, lines: &[u64]) -> Exit {
    let at = |total: usize| format!("{}, line {}", table.display(), lines[total]);
    for out_of_fit in &report.left_out {
        out::warn(&format!("{}: {out_of_fit}", at(out_of_fit.total)));
    }
    for suspect in &report.suspects {
        let words = suspect
            .to_string()
            .replace("the other presses", "the other totals");
        out::warn(&format!("{}: {words}", at(suspect.press)));
    }
    for doubt in &report.doubts {
        out::warn(doubt);
    }
    let lost = report.left_out.len() + report.suspects.len() + report.doubts.len();
    if lost == 0 {
        Exit::Good
    } else {
        Exit::DataLost
    }
}
