//! `taxel info`: what is in a recording.

mod exported;
mod report;

use std::path::{Path, PathBuf};

use taxel::screen::{FrameScreen, LineScreen, ScreenOptions, ScreenReport};
use taxel::{Frame, Sensor};
use taxel_io::{FrameSource, ReadOptions, exports, open_counts, shape_of};

use super::positive::lines;
use crate::error::Error;
use crate::outputs::{Files, check_ending};
use crate::progress::Progress;
use crate::{Exit, out, recorded};
use report::{Range, Report};
use taxel_app::frames::{open_shown, show};

/// Summarise a recording
///
/// Shape, frames, range, baseline and noise, the share of outliers, faulty lines. Without a sensor the shape
/// comes from the file: columns from its first line, rows from --rows, from its extra lines or its header.
/// Exit code 3: frames were left out, or the recording tells of frames that are missing.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Recording (.mcap, .parquet, .txt, .csv, .npy, .npz; with a sensor also - for standard input)
    recording: PathBuf,
    /// Sensor file, or the name of a preset; .mcap and .parquet bring their own
    #[arg(long, value_name = "FILE|PRESET")]
    sensor: Option<PathBuf>,
    /// Rows of a frame, where there is no sensor
    #[arg(long, value_name = "N", conflicts_with = "sensor", value_parser = lines)]
    rows: Option<usize>,
    /// The file holds values, not counts; do not screen. Of .mcap and .parquet: their loads, newtons
    #[arg(long)]
    values: bool,
    /// Leave out frames that cannot be read, instead of stopping at the first
    #[arg(long)]
    keep_going: bool,
    /// The recording has rows and columns swapped
    #[arg(long)]
    transpose: bool,
    /// Show, and keep in the sensor file that is written, what a file of another program says of persons, and names of files; left
    /// out else
    #[arg(long)]
    with_names: bool,
    /// Where to write the sensor file that the recording carries (.toml), to be looked at and changed
    #[arg(long, value_name = "FILE")]
    write_sensor: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<Exit, Error> {
    check(args)?;
    let carried = (args.rows.is_none() && !args.values).then_some(args.recording.as_path());
    // A file of another program is read through for what a count is, and for its sensor: once.
    let survey = exports::survey(&args.recording)?;
    let given = args.sensor.as_deref();
    let found = match (&survey, carried) {
        (Some((about, survey)), Some(file)) if given.is_none() => {
            Some(recorded::exported_sensor(file, about, survey)?)
        }
        _ => recorded::sensor(given, carried)?,
    };
    let (sensor, from) = found.unzip();
    let (options, rows_known) = options(args, sensor.as_ref())?;
    let mut report = Report::new(&args.recording, options.rows, options.columns, rows_known);
    report.sensor = from.map(|file| file.display().to_string());
    report.add_export(survey, args.with_names);
    let file = &args.recording;
    if args.values {
        let mut source = open_shown(file, options)?;
        pass(&mut source, options, "reading", |frame| {
            report.range.add(frame);
            Ok(())
        })?;
        report.add_skips(source.skipped(), source.skips());
        report.add_integrity(source.integrity());
    } else {
        counts(file, options, sensor.as_ref(), &mut report)?;
    }
    report.finish();
    for skipped in &report.skipped {
        out::warn(skipped);
    }
    write_sensor(args, sensor.as_ref())?;
    if args.json {
        out::json(&report)?
    } else {
        out::result(&report.to_string())?
    }
    Ok(if report.skipped_frames == 0 && report.missing.is_empty() {
        Exit::Good
    } else {
        Exit::DataLost
    })
}

/// Refuses, before any work, what cannot be written.
fn check(args: &Args) -> Result<(), Error> {
    if let Some(file) = &args.write_sensor {
        let hint = "sensor files are TOML";
        check_ending("--write-sensor", file, &["toml"], hint)?;
    }
    Files::default()
        .input("recording", &args.recording)
        .maybe_sensor(args.sensor.as_ref())
        .maybe_output("--write-sensor", args.write_sensor.as_ref())
        .check()
}

/// Writes the sensor file, where that was asked for.
fn write_sensor(args: &Args, sensor: Option<&Sensor>) -> Result<(), Error> {
    let Some(file) = &args.write_sensor else {
        return Ok(());
    };
    let Some(sensor) = sensor else {
        return Err(Error::Arguments {
            what: format!("{} carries no sensor file", args.recording.display()),
            hint: ".mcap and .parquet carry one, and exports of other programs stand for one",
        });
    };
    let sensor = recorded::named(sensor.clone(), &args.recording, args.with_names)?;
    out::file(file, sensor.to_toml().as_bytes())?;
    out::note(&format!("wrote {}", file.display()));
    Ok(())
}

/// How to read the file, and whether its rows are known.
fn options(args: &Args, sensor: Option<&Sensor>) -> Result<(ReadOptions, bool), Error> {
    let (mut options, known) = match sensor {
        Some(sensor) => (ReadOptions::of(sensor), true),
        None => {
            let guess = shape_of(&args.recording)?;
            let rows = args.rows.or(guess.rows);
            let columns = guess.columns.unwrap_or(1);
            let mut options = ReadOptions::new(rows.unwrap_or(1), columns);
            if args.transpose {
                (options.rows, options.columns) = (options.columns, options.rows);
            }
            (options, rows.is_some())
        }
    };
    options.keep_going = args.keep_going;
    options.accept_damage = true;
    options.transpose = args.transpose;
    Ok((options, known))
}

/// Two passes over a file, for faulty lines and then for single readings; one over a pipe, and over what another program has
/// exported. Without a sensor one more before them, for the converter's range.
fn counts(
    file: &Path,
    mut options: ReadOptions,
    sensor: Option<&Sensor>,
    report: &mut Report,
) -> Result<(), Error> {
    if options.max_count.is_none() {
        let mut range = Range::default();
        let mut source = open_counts(file, options)?;
        pass(&mut source, options, "range", |frame| {
            range.add(frame);
            Ok(())
        })?;
        options.max_count = Some(report.assume_bits(range.most()));
    }
    let max_count = options.max_count.unwrap_or(f64::MAX);
    let (rows, columns) = (options.rows, options.columns);
    let screen_options = sensor.map_or_else(ScreenOptions::default, ScreenOptions::from_sensor);
    let mut lines = LineScreen::new(rows, columns, max_count, &screen_options);
    let mut single = FrameScreen::new(rows, columns, max_count, &screen_options);
    let mask = screen_options.mask;
    let mut screened = ScreenReport::default();
    if mask.low_counts.is_some() || mask.high_counts.is_some() {
        screened = screened.with_mask(mask);
    }
    let mut source = open_counts(file, options)?;
    let once = source.bytes_total().is_none();
    // What another program has screened is not screened again.
    let known = report.rows_known && !report.is_exported();
    pass(&mut source, options, "looking for line faults", |frame| {
        if let Some(sensor) = sensor {
            sensor.mark_absent(frame.marks_mut());
        }
        report.range.add(frame);
        if known {
            lines.observe(frame)?;
        }
        if once && known {
            single.mark(frame)?;
            screened.add(frame);
        }
        Ok(())
    })?;
    report.add_skips(source.skipped(), source.skips());
    report.add_events(source.take_events());
    report.add_integrity(source.integrity());
    if !known {
        return Ok(());
    }
    screened.lines = lines.finish();
    if let Some(sensor) = sensor {
        screened.lines = screened.lines.with_declared(sensor.screen());
    }
    if !once {
        single.set_lines(&screened.lines);
        let mut source = open_counts(file, options)?;
        pass(&mut source, options, "screening", |frame| {
            single.mark(frame)?;
            screened.add(frame);
            Ok(())
        })?;
    }
    report.screen(&screened);
    Ok(())
}

/// Shows every frame of a source to `see`.
fn pass<Q>(
    source: &mut impl FrameSource<Q>,
    options: ReadOptions,
    name: &str,
    mut see: impl FnMut(&mut Frame<Q>) -> Result<(), Error>,
) -> Result<(), Error> {
    let mut frame = Frame::<Q>::zeros(options.rows, options.columns);
    let progress = Progress::new(name);
    while source.next_into(&mut frame)? {
        see(&mut frame)?;
        show(source, &progress);
    }
    Ok(())
}
