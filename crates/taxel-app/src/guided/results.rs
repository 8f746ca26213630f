//! What a guided calibration ends with: the calibrated sensor, its certificate, and tables that `taxel calibrate` finds the same from.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use taxel::calibrate::Calibration;
use taxel_io::{AtomicFile, Press};
use taxel_plot::report::Figure;
use taxel_plot::{Line, LineStyle, Series};
use taxel_server::HeldOutError;

use super::GuidedSettings;
use super::fits::Fit;
use super::record::CalibrationRecord;
use crate::calibration_certificate::{self, CalibrationOrigin, PICTURE};
use crate::error::Error;
use crate::{fingerprint, residuals};

/// Writes everything; the names of what is in the folder.
pub(super) fn write(
    folder: &Path,
    record: &CalibrationRecord,
    fit: &Fit,
    progress: &[HeldOutError],
    settings: &GuidedSettings,
) -> Result<Vec<String>, Error> {
    let found = fit.found.as_ref().map_err(|why| Error::Request {
        what: format!(
            "no calibration came of it: {}",
            why.lines().next().unwrap_or(why)
        ),
        hint: "more presses, on other taxels and with other loads; `u` takes a wrong one back",
    })?;
    let presses = table(record, true);
    let labelled = labelled(record, fit);
    let toml = found.sensor.to_toml();
    let origin = origin(record, found, progress, &presses)?;
    let footer = calibration_certificate::footer(&origin);
    let certificate = calibration_certificate::of(found, origin)?;
    let mut files = vec![
        ("certificate.html", certificate.html().into_bytes()),
        ("sensor.toml", toml.clone().into_bytes()),
        ("parts.toml", settings.sensor.to_toml().into_bytes()),
        ("presses.csv", presses.into_bytes()),
        (
            "residuals.csv",
            residuals::table(&found.residuals, &labelled).into_bytes(),
        ),
    ];
    if record.presses.iter().any(|press| press.taxel.is_none()) {
        files.push(("even.csv", table(record, false).into_bytes()));
    }
    match certificate.paper(footer)?.pdf() {
        Ok(pdf) => files.insert(0, ("certificate.pdf", pdf)),
        // A build without it writes the rest.
        Err(taxel_plot::Error::NoPdf) => {}
        Err(error) => return Err(error.into()),
    }
    for (name, bytes) in &files {
        AtomicFile::write_whole(folder.join(name), bytes)?;
    }
    AtomicFile::write_whole(&settings.output, toml.as_bytes())?;
    Ok(files.into_iter().map(|(name, _)| name.to_owned()).collect())
}

/// The presses that count, of single taxels or of even loads, as `taxel calibrate` reads them.
fn table(record: &CalibrationRecord, of_singles: bool) -> String {
    let counting = record.presses.iter().filter(|press| press.counts());
    let place = if of_singles { "row,column," } else { "" };
    let mut text = format!("recording,frame,{place}load_g\n");
    for press in counting.filter(|press| press.taxel.is_some() == of_singles) {
        let place = press.taxel.map(|(row, column)| format!("{row},{column},"));
        let place = place.unwrap_or_default();
        // To a String: nothing that could fail.
        let _ = writeln!(text, "{},0,{place}{}", press.file, press.load_g);
    }
    text
}

/// The presses of a fit, as if they had been read from a table.
fn labelled(record: &CalibrationRecord, fit: &Fit) -> Vec<Press> {
    let of = |place: &usize| {
        let press = &record.presses[*place];
        let (row, column) = press.taxel.unwrap_or_default();
        Press {
            recording: PathBuf::from(&press.file),
            frame: 0,
            row,
            column,
            load_g: press.load_g,
            replicate: None,
            contact_area_mm2: None,
            note: None,
            line: 0,
        }
    };
    fit.places.iter().map(of).collect()
}

fn origin(
    record: &CalibrationRecord,
    found: &Calibration,
    progress: &[HeldOutError],
    presses: &str,
) -> Result<CalibrationOrigin, Error> {
    let mut origin = CalibrationOrigin::default();
    origin.source.clone_from(&record.source);
    origin.is_simulated = record.is_simulated;
    origin.files = vec![
        ("parts list".to_owned(), record.parts_sha256.clone()),
        ("presses.csv".to_owned(), fingerprint::of_text(presses)),
    ];
    let counting = || record.presses.iter().filter(|press| press.counts());
    let others = counting().filter(|press| press.is_among_others).count();
    let even = counting().filter(|press| press.taxel.is_none()).count();
    let loads: Vec<String> = record.loads_g.iter().map(f64::to_string).collect();
    origin.presses = format!("with {} g", loads.join(", "));
    let mut left_out = BTreeMap::new();
    for press in record.presses.iter().filter(|press| !press.counts()) {
        *left_out.entry(press.left_out.as_str()).or_insert(0) += 1;
    }
    let others = [(others, "among other things"), (even, "even loads")].into_iter();
    for (count, what) in others.chain(left_out.into_iter().map(|(why, count)| (count, why))) {
        if count > 0 {
            origin.presses += &format!("; {count} {what}");
        }
    }
    let known = progress.iter().filter(|one| one.mean_absolute_g.is_some());
    if known.count() > 1 && found.report.held_out_mean_absolute_g.is_some() {
        origin.figures.push(error_by_presses(progress)?);
    }
    Ok(origin)
}

/// How the error fell.
fn error_by_presses(progress: &[HeldOutError]) -> Result<Figure, Error> {
    let known = || {
        let each = progress.iter();
        each.filter_map(|one| {
            Some((
                one.presses as f64,
                one.mean_absolute_g?,
                one.standard_error_g,
            ))
        })
    };
    let presses: Vec<f64> = known().map(|(presses, ..)| presses).collect();
    let shifted = |sign: f64| {
        known()
            .map(|(_, mean, error)| (mean + sign * error).max(0.0))
            .collect()
    };
    let lines = vec![
        Line::new("", shifted(0.0)).colour(3),
        Line::new("", shifted(1.0))
            .style(LineStyle::Dashed)
            .colour(0),
        Line::new("", shifted(-1.0))
            .style(LineStyle::Dashed)
            .colour(0),
    ];
    let series = Series::new("presses", presses, lines)?
        .quantity("mean absolute error")
        .unit("g")
        .size(PICTURE.0, PICTURE.1)
        .unnamed();
    Ok(Figure {
        caption: "The error of held-out presses while presses were made. Dashed: one standard error up and down.".to_owned(),
        picture: series.picture()?,
    })
}
