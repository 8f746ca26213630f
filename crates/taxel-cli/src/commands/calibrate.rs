//! `taxel calibrate`: from labelled presses to a sensor file with everything a parts list does not say.

mod series;

use std::path::{Path, PathBuf};
use std::time::SystemTime;

use clap::ValueEnum;
use taxel::Sensor;
use taxel::calibrate::{LawChoice, Options, fit_pairs};

use super::positive::positive;
use crate::crew::Threads;
use crate::error::Error;
use crate::live::time_stamp;
use crate::progress::Progress;
use crate::{Exit, out, presses, sensor_file};

/// Fit switch resistances and load law to labelled presses
///
/// Reads the parts list (sensor.toml) and presses of known load, and writes the sensor file with the fitted
/// numbers, their origin and their errors. The report goes to standard output. No frame is judged by a fit
/// that saw it: the errors reported are of presses held out. With --series, also what the material remembers: creep and
/// hysteresis.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Sensor file (the parts list), or the name of a preset
    #[arg(long, value_name = "FILE|PRESET")]
    sensor: PathBuf,
    /// Labelled presses: CSV with recording, frame, row, column (or taxel), load_g
    #[arg(long, value_name = "FILE", required_unless_present_any = ["pairs", "series"])]
    presses: Option<PathBuf>,
    /// Frames under the same load everywhere: CSV with recording, frame, load_g
    #[arg(long, value_name = "FILE", conflicts_with = "pairs")]
    equilibration: Option<PathBuf>,
    /// Fit the load law alone, to pairs of conductance (or resistance) and load
    #[arg(long, value_name = "FILE", conflicts_with = "presses")]
    pairs: Option<PathBuf>,
    /// Instead: a recording whose loads are known all the time, from rest; finds creep and hysteresis too
    #[arg(long, value_name = "FILE", requires = "loads", conflicts_with_all = ["presses", "pairs", "equilibration"])]
    series: Option<PathBuf>,
    /// The load of every taxel in every frame of the series, g
    #[arg(long, value_name = "FILE", requires = "series")]
    loads: Option<PathBuf>,
    /// Seconds between frames of the series, where it tells no times
    #[arg(long, value_name = "SECONDS", requires = "series", value_parser = positive)]
    period: Option<f64>,
    /// Lags (creep) to fit to the series
    #[arg(long, value_name = "N", default_value_t = 3, requires = "series", value_parser = clap::value_parser!(u8).range(0..=8))]
    lags: u8,
    /// Plays (hysteresis) to fit to the series
    #[arg(long, value_name = "N", default_value_t = 3, requires = "series", value_parser = clap::value_parser!(u8).range(0..=8))]
    plays: u8,
    /// Where to write the sensor with the best static law of the series, to compare with
    #[arg(long, value_name = "FILE", requires = "series")]
    static_output: Option<PathBuf>,
    /// Where to write the calibrated sensor
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// The load law; `auto` takes the one with the least error on held-out presses
    #[arg(long, value_enum, default_value_t)]
    law: Law,
    /// Fit one switch resistance per line, even without equilibration frames
    #[arg(long)]
    per_line: bool,
    /// Fit the amplifier's open-loop gain
    #[arg(long)]
    fit_gain: bool,
    /// Fit the source resistor
    #[arg(long)]
    fit_source: bool,
    /// Folds of the cross-validation by press
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u16).range(2..))]
    folds: u16,
    /// The recordings have rows and columns swapped
    #[arg(long)]
    transpose: bool,
    /// Print the report as JSON
    #[arg(long)]
    json: bool,
}

/// The words of `--law`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
enum Law {
    /// The best of the others on held-out presses
    #[default]
    Auto,
    /// Power law with offset
    Power,
    /// Power law of a load that saturates
    Saturating,
    /// Monotone spline
    Spline,
}

impl From<Law> for LawChoice {
    fn from(law: Law) -> Self {
        match law {
            Law::Auto => LawChoice::Auto,
            Law::Power => LawChoice::Power,
            Law::Saturating => LawChoice::Saturating,
            Law::Spline => LawChoice::Spline,
        }
    }
}

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<Exit, Error> {
    let sensor = sensor_file::load(&args.sensor)?;
    if let (Some(recording), Some(loads)) = (&args.series, &args.loads) {
        return series::run(args, &sensor, recording, loads);
    }
    let Some(table) = &args.presses else {
        return run_pairs(args, sensor);
    };
    let data = presses::read(
        table,
        args.equilibration.as_deref(),
        args.transpose,
        &sensor,
    )?;
    let names = [Some(table), args.equilibration.as_ref()];
    let options = Options {
        law: args.law.into(),
        per_line: args.per_line,
        open_loop_gain: args.fit_gain,
        r_source: args.fit_source,
        folds: args.folds.into(),
        date: today(),
        files: names
            .iter()
            .flatten()
            .map(|f| f.display().to_string())
            .collect(),
    };
    let progress = Progress::new("fitting");
    let mut show = |stage: &str, share| progress.stage(stage, share);
    let calibration = taxel::calibrate::calibrate_with(
        &sensor, &data, &options, &Threads, &mut show,
    )
    .map_err(|source| Error::InFile {
        file: table.clone(),
        source,
    })?;
    drop(progress);
    out::file(&args.output, calibration.sensor.to_toml().as_bytes())?;
    match args.json {
        true => out::json(&calibration.report)?,
        false => out::result(&calibration.report.to_string())?,
    }
    out::note(&format!("wrote {}", args.output.display()));
    Ok(Exit::Good)
}

/// One load law in the report of `--pairs`.
#[derive(Debug, serde::Serialize)]
struct LawLine {
    law: &'static str,
    held_out_mean_absolute_g: f64,
    held_out_root_mean_square_g: f64,
    chosen: bool,
}

/// The load law alone, from plain pairs; the circuit stays as the sensor file has it.
fn run_pairs(args: &Args, mut sensor: Sensor) -> Result<Exit, Error> {
    let table = args.pairs.as_deref().unwrap_or(Path::new(""));
    let pairs = taxel_record::read_pairs(table)?;
    let fits = fit_pairs(&pairs);
    let wanted = match args.law {
        Law::Auto => None,
        Law::Power => Some("power"),
        Law::Saturating => Some("saturating"),
        Law::Spline => Some("spline"),
    };
    let chosen = fits
        .iter()
        .find(|fit| wanted.is_none_or(|name| name == fit.name))
        .ok_or_else(|| Error::InFile {
            file: table.to_owned(),
            source: taxel::Error::NoFit {
                reason: format!("{} pairs do not settle a load law", pairs.len()),
            },
        })?;
    sensor.material = Some(chosen.law.to_material());
    out::file(&args.output, sensor.to_toml().as_bytes())?;
    let lines: Vec<LawLine> = fits
        .iter()
        .map(|fit| LawLine {
            law: fit.name,
            held_out_mean_absolute_g: fit.held_out_mean_absolute_g,
            held_out_root_mean_square_g: fit.held_out_root_mean_square_g,
            chosen: fit.name == chosen.name,
        })
        .collect();
    if args.json {
        out::json(&lines)?;
    } else {
        let mut text = format!(
            "{} pairs; errors of loads left out one at a time, g\n{:<12} {:>14} {:>16}\n",
            pairs.len(),
            "law",
            "mean absolute",
            "root mean square"
        );
        for line in &lines {
            let mark = if line.chosen { "  <- chosen" } else { "" };
            text.push_str(&format!(
                "{:<12} {:>14.3} {:>16.3}{mark}\n",
                line.law, line.held_out_mean_absolute_g, line.held_out_root_mean_square_g
            ));
        }
        out::result(&text)?;
    }
    out::note(&format!("wrote {}", args.output.display()));
    Ok(Exit::Good)
}

/// The date in UTC, ISO 8601.
fn today() -> String {
    let mut stamp = time_stamp(SystemTime::now());
    // The time of day follows the ten characters of the date.
    stamp.truncate(10);
    stamp
}
