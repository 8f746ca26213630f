//! `taxel calibrate --series`: circuit, load law, creep and hysteresis from a recording whose loads are known all the time.

use std::path::Path;

use serde::Serialize;
use taxel::Grams;
use taxel::calibrate::{DynamicFit, LoadSeries, fit_dynamic};
use taxel::{Counts, Frame, Sensor};
use taxel_io::{FrameSource, ReadOptions, open_counts};

use super::Args;
use crate::error::Error;
use crate::progress::Progress;
use crate::{Exit, out};
use taxel_app::frames::{open_values, show};

/// The report.
#[derive(Debug, Serialize)]
struct Report {
    frames: usize,
    seconds: f64,
    taxels_fitted: usize,
    /// Root mean square of the residuals, in standard deviations of a reading.
    residual: f64,
    parameters: Vec<Parameter>,
}

#[derive(Debug, Serialize)]
struct Parameter {
    name: String,
    value: f64,
    /// Relative standard error; none for a number that was held.
    relative_error: Option<f64>,
}

/// Fits to the series and writes the sensor; on request the best static law with the same circuit, to compare with.
pub(super) fn run(
    args: &Args,
    sensor: &Sensor,
    recording: &Path,
    loads: &Path,
) -> Result<Exit, Error> {
    let mut options = ReadOptions::of(sensor);
    options.transpose = args.transpose;
    let frames = read_frames(recording, options)?;
    let truths = read_loads(loads, options)?;
    let secs = times(&frames, args.period, recording)?;
    let series = LoadSeries {
        secs: &secs,
        frames: &frames,
        loads: &truths,
    };
    let progress = Progress::new("fitting");
    let (lags, plays) = (args.lags.into(), args.plays.into());
    let mut stage = |name: &str, share| progress.stage(name, share);
    let found = fit_dynamic(sensor, &series, lags, plays, &mut stage).map_err(|source| {
        taxel_app::Error::InFile {
            file: recording.to_owned(),
            source,
        }
    })?;
    drop(progress);
    write(args, &found, recording, loads)?;
    let report = Report {
        frames: frames.len(),
        seconds: secs[secs.len() - 1] - secs[0],
        taxels_fitted: found.taxels,
        residual: found.residual,
        parameters: found
            .parameters
            .iter()
            .map(|(name, value, relative_error)| Parameter {
                name: name.clone(),
                value: *value,
                relative_error: Some(*relative_error).filter(|error| *error != 0.0),
            })
            .collect(),
    };
    if args.json {
        out::json(&report)?
    } else {
        out::result(&text(&report))?
    }
    out::note(&format!("wrote {}", args.output.display()));
    if sensor.uncertainty().is_some() {
        out::note(
            "the intervals of the sensor file are those of the law before, and were left out: with the new law noise is all that is known of its errors",
        );
    }
    Ok(Exit::Good)
}

fn write(args: &Args, found: &DynamicFit, recording: &Path, loads: &Path) -> Result<(), Error> {
    let signed = |sensor: &Sensor| {
        let mut provenance = taxel::sensor::Provenance::default();
        provenance.program = format!("taxel {}", env!("CARGO_PKG_VERSION"));
        provenance.date = super::today();
        provenance.data = [recording, loads]
            .map(|file| file.display().to_string())
            .to_vec();
        let mut spec = sensor.spec().clone();
        spec.provenance = Some(provenance);
        spec.to_toml()
    };
    if let Some(file) = &args.static_output {
        out::file(file, signed(&found.best_static).as_bytes())?;
        out::note(&format!(
            "wrote {}, without creep and hysteresis",
            file.display()
        ));
    }
    out::file(&args.output, signed(&found.sensor).as_bytes())
}

fn text(report: &Report) -> String {
    let mut text = format!(
        "{} frames, {:.1} s, {} taxels fitted; residual {:.2} standard deviations of a reading\n{:<22} {:>12} {:>16}\n",
        report.frames,
        report.seconds,
        report.taxels_fitted,
        report.residual,
        "",
        "value",
        "standard error"
    );
    for parameter in &report.parameters {
        let (name, value) = (&parameter.name, parameter.value);
        let error = match parameter.relative_error {
            Some(error) => format!("{:.2} %", 100.0 * error),
            None => "held".to_owned(),
        };
        text += &format!("{name:<22} {value:>12.4e} {error:>16}\n");
    }
    text
}

fn read_frames(file: &Path, options: ReadOptions) -> Result<Vec<Frame<Counts>>, Error> {
    let mut source = open_counts(file, options)?;
    let progress = Progress::new("reading");
    let mut frames = Vec::new();
    let mut frame = Frame::zeros(options.rows, options.columns);
    while source.next_into(&mut frame)? {
        frames.push(frame.clone());
        show(&source, &progress);
    }
    Ok(frames)
}

fn read_loads(file: &Path, mut options: ReadOptions) -> Result<Vec<Frame<Grams>>, Error> {
    options.max_count = None;
    let mut source = open_values::<Grams>(file, options)?;
    let mut loads = Vec::new();
    let mut frame = Frame::zeros(options.rows, options.columns);
    while source.next_into(&mut frame)? {
        loads.push(frame.clone());
    }
    Ok(loads)
}

/// The recording's own times, else those of the period.
fn times(frames: &[Frame<Counts>], period: Option<f64>, file: &Path) -> Result<Vec<f64>, Error> {
    let own: Option<Vec<f64>> = frames.iter().map(|frame| frame.time_secs).collect();
    let even = |period| (0..frames.len()).map(|n| n as f64 * period).collect();
    period.map(even).or(own).ok_or_else(|| Error::Arguments {
        what: format!("{} tells no times, and creep is about time", file.display()),
        hint: "--period takes the seconds between two frames",
    })
}
