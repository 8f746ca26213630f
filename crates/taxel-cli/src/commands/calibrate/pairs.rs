//! `taxel calibrate --pairs`: the load law alone, from plain pairs of conductance and load.

use std::path::Path;

use serde::Serialize;
use taxel::Sensor;
use taxel::calibrate::{CalibrationReport, LawFit, Parameter, Suspect, fit_pairs, suspect_pairs};
use taxel::stats::{mean, median};

use super::{Args, Law};
use crate::error::Error;
use crate::{Exit, out};

/// One load law in the report.
#[derive(Debug, Serialize)]
struct LawLine<'a> {
    law: &'static str,
    held_out_mean_absolute_g: f64,
    held_out_root_mean_square_g: f64,
    chosen: bool,
    parameters: &'a [Parameter],
}

/// A law that says less of loads left out than this share of what their median does is none.
const BLIND: f64 = 0.8;

/// Fits and writes; the circuit stays as the sensor file has it.
pub(super) fn run(args: &Args, sensor: Sensor) -> Result<Exit, Error> {
    let table = args.pairs.as_deref().unwrap_or(Path::new(""));
    let read = taxel_io::read_pairs_by_line(table)?;
    let all: Vec<(f64, f64)> = read.iter().map(|(_, pair)| *pair).collect();
    let suspects = suspect_pairs(&all);
    let suspected = |i: usize| suspects.iter().any(|s| s.press == i);
    let kept: Vec<(f64, f64)> = (0..all.len())
        .filter(|&i| !suspected(i))
        .map(|i| all[i])
        .collect();
    let fits = fit_pairs(&kept);
    let wanted = match args.law {
        Law::Auto => None,
        Law::Power => Some("power"),
        Law::Saturating => Some("saturating"),
        Law::Spline => Some("spline"),
    };
    let failed = |reason: String| -> Error {
        taxel_app::Error::InFile {
            file: table.to_owned(),
            source: taxel::Error::NoLaw { reason },
        }
        .into()
    };
    let chosen = fits
        .iter()
        .find(|fit| wanted.is_none_or(|name| name == fit.name))
        .ok_or_else(|| failed(format!("{} pairs do not settle one", kept.len())))?;
    let blind = guessing(&kept);
    let error = chosen.held_out_mean_absolute_g;
    if error.is_nan() || error >= BLIND * blind {
        return Err(failed(format!(
            "loads left out are {error:.1} g off on average, and guessing their median would be {blind:.1} g off"
        )));
    }
    let sensor = with_law(&sensor, chosen).map_err(|error| {
        let error = error.to_string();
        let what = error.lines().next().unwrap_or_default();
        failed(format!(
            "what fits best is no law of a taxel ({what}); are the columns of conductance and load swapped, or in other units?"
        ))
    })?;
    out::file(&args.output, sensor.to_toml().as_bytes())?;
    show(args, &fits, chosen, kept.len())?;
    for suspect in &suspects {
        let line = read[suspect.press].0;
        let suspect = Suspect {
            left_out: true,
            ..suspect.clone()
        };
        out::warn(&format!("{}, line {line}: {suspect}", table.display()));
    }
    out::note(&format!("wrote {}", args.output.display()));
    Ok(if suspects.is_empty() {
        Exit::Good
    } else {
        Exit::DataLost
    })
}

/// The sensor with a new law; what an earlier calibration said of loads is no longer of it.
fn with_law(sensor: &Sensor, chosen: &LawFit) -> Result<Sensor, taxel::Error> {
    sensor.edited(|spec| {
        spec.material = Some(chosen.law.to_material());
        spec.uncertainty = None;
        spec.check = None;
    })
}

/// Mean distance of the loads from their median, grams.
fn guessing(pairs: &[(f64, f64)]) -> f64 {
    let loads = || pairs.iter().map(|p| p.1);
    let middle = median(loads()).unwrap_or(0.0);
    mean(loads().map(|load| (load - middle).abs())).unwrap_or(0.0)
}

fn show(args: &Args, fits: &[LawFit], chosen: &LawFit, pairs: usize) -> Result<(), Error> {
    let lines: Vec<LawLine> = fits
        .iter()
        .map(|fit| LawLine {
            law: fit.name,
            held_out_mean_absolute_g: fit.held_out_mean_absolute_g,
            held_out_root_mean_square_g: fit.held_out_root_mean_square_g,
            chosen: fit.name == chosen.name,
            parameters: &fit.parameters,
        })
        .collect();
    if args.json {
        return out::json(&lines);
    }
    let mut text = format!(
        "{}\n{pairs} pairs; errors of loads left out of the fit, g\n{:<12} {:>14} {:>16}\n",
        CalibrationReport::table(&chosen.parameters),
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
    out::result(&text)
}
