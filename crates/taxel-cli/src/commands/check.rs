//! `taxel check`: whether a calibrated sensor still is what it was.

use std::path::PathBuf;

use taxel::check::{CheckReport, check, checked};
use taxel::frame::grams_from_newtons;
use taxel::sensor::Verdict;

use super::calibrate::today;
use crate::error::Error;
use crate::outputs::{Files, check_sensor_ending};
use crate::progress::Terminal;
use crate::{Exit, out, recorded};
use taxel_app::check::CheckFiles;

/// Tell whether a calibrated sensor still is what it was
///
/// Reads a few known loads of the day, and says how much more or less the sensor reads than when it was calibrated,
/// whether its stated 95 % intervals still hold, and a verdict: good, rescaled (another scale, and all is well with it) or
/// recalibrate. With -o a sensor file with the day's scale is written, unless the verdict is recalibrate. Exit code 3:
/// recalibrate, or loads were left out.
#[derive(Debug, clap::Args)]
#[command(group(clap::ArgGroup::new("known").required(true).multiple(true).args(["presses", "total", "empty"])))]
pub(crate) struct Args {
    /// The calibrated sensor file
    #[arg(long, value_name = "FILE|PRESET")]
    sensor: PathBuf,
    /// Labelled presses: CSV with recording, frame, row, column (or taxel), load_g; 5 to 12 are usual
    #[arg(long, value_name = "FILE")]
    presses: Option<PathBuf>,
    /// A recording under one known load on the whole array, such as 812.5N or 640g
    #[arg(long, num_args = 2, value_names = ["LOAD", "RECORDING"], action = clap::ArgAction::Append)]
    total: Vec<String>,
    /// A recording with nothing on the array
    #[arg(long, value_name = "RECORDING")]
    empty: Vec<PathBuf>,
    /// Where to write the sensor file with the day's scale
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// The recordings have rows and columns swapped
    #[arg(long)]
    transpose: bool,
    /// Print the report as JSON
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<Exit, Error> {
    let mut files = CheckFiles::default();
    files.presses.clone_from(&args.presses);
    files.totals = totals(&args.total)?;
    files.empty.clone_from(&args.empty);
    files.transpose = args.transpose;
    let recordings = files.totals.iter().map(|(_, file)| file);
    let recordings = recordings.chain(&files.empty);
    recordings
        .fold(Files::default(), |all, file| all.input("recording", file))
        .sensor(&args.sensor)
        .maybe_table("table of presses", args.presses.as_ref())
        .maybe_output("-o", args.output.as_ref())
        .check()?;
    if let Some(output) = &args.output {
        check_sensor_ending("-o", output)?;
    }
    let (sensor, file) = recorded::needed_sensor(Some(&args.sensor), None)?;
    recorded::needs_readings(&sensor)?;
    for (_, recording) in &files.totals {
        recorded::doubt_other_sensor(recording, &sensor, &file);
    }
    let (data, lines) = files.read(&sensor, &Terminal)?;
    let in_file = |source| taxel_app::Error::InFile {
        file: file.clone(),
        source,
    };
    let report = check(&sensor, &data).map_err(in_file)?;
    if args.json {
        out::json(&report)?
    } else {
        out::result(&report.to_string())?
    }
    name_contradictions(args, &report, &lines);
    match &args.output {
        Some(output) if report.verdict == Verdict::Recalibrate => out::warn(&format!(
            "{} is not written: {}",
            output.display(),
            if report.scale.is_some() {
                "no scale makes this sensor what it was"
            } else {
                "no load tells a scale"
            }
        )),
        Some(output) => {
            let today = checked(&sensor, &report, &today()).map_err(in_file)?;
            out::file(output, today.to_toml().as_bytes())?;
            out::note(&format!("wrote {}", output.display()));
        }
        None => {}
    }
    let good = report.verdict != Verdict::Recalibrate && report.left_out.is_empty();
    Ok(if good { Exit::Good } else { Exit::DataLost })
}

/// Names presses that the others contradict, by their lines.
fn name_contradictions(args: &Args, report: &CheckReport, lines: &[u64]) {
    let Some(table) = &args.presses else { return };
    for press in &report.contradictions {
        out::warn(&format!(
            "{}, line {}: {} g, where {:.4} g are read with the day's scale",
            table.display(),
            lines[press.press],
            press.load_g,
            press.reads_g
        ));
    }
}

/// Pairs of a load, in grams then, and a recording.
fn totals(words: &[String]) -> Result<Vec<(f64, PathBuf)>, Error> {
    words
        .chunks_exact(2)
        .map(|pair| Ok((grams(&pair[0])?, PathBuf::from(&pair[1]))))
        .collect()
}

fn grams(text: &str) -> Result<f64, Error> {
    let units = [("kg", 1000.0), ("g", 1.0), ("N", grams_from_newtons(1.0))];
    let number = |text: &str| text.trim().parse().ok().filter(|x: &f64| *x > 0.0);
    let found = units.iter().find_map(|(unit, grams)| {
        let value = number(text.strip_suffix(unit)?)?;
        Some(grams * value).filter(|grams| grams.is_finite())
    });
    found.ok_or_else(|| Error::Arguments {
        what: format!("`{text}` is no load above 0 with a unit"),
        hint: "write 812.5N, 640g or 82.9kg",
    })
}

#[cfg(test)]
mod tests {
    use super::grams;

    #[test]
    fn a_load_has_a_unit() {
        assert_eq!(grams("640g").unwrap(), 640.0);
        assert_eq!(grams("0.64 kg").unwrap(), 640.0);
        assert!((grams("9.80665N").unwrap() - 1000.0).abs() < 1e-9);
        for bad in ["640", "-1N", "g", "infkg", "NaNg"] {
            assert!(grams(bad).is_err(), "{bad}");
        }
    }
}
