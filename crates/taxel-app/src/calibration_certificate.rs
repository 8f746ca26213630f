//! The certificate of a calibration: one page that says how good it is, by what, and of which files.

use std::time::SystemTime;

use taxel::Sensor;
use taxel::calibrate::{Belief, Calibration, CalibrationReport, PressResidual, with_error};
use taxel::stats::mean;
use taxel_plot::cells;
use taxel_plot::report::{Figure, Report, Section, Table, number};

use crate::calibration_picture;
use crate::error::Error;
use crate::fingerprint;
use crate::session::time_stamp;
use crate::units::three_digits;

/// Loads are told one by one up to so many; more are put together in so many groups.
const MOST_LOADS: usize = 8;
const GROUPS: usize = 5;
/// Size of the pictures' plots, points: three stand side by side on A4.
pub const PICTURE: (f64, f64) = (150.0, 92.0);
/// Digits of a fingerprint that are shown: no two files of a person's have these in common.
const FINGERPRINT: usize = 16;
/// Doubts and warnings that are told, where the page has room for them.
const MOST_DOUBTS: usize = 6;

/// What a calibration does not know of itself.
#[derive(Debug, Clone, Default)]
#[non_exhaustive]
pub struct CalibrationOrigin {
    /// Where the frames came from, in words.
    pub source: String,
    /// No sensor was pressed.
    pub is_simulated: bool,
    /// Files by what they are, each with its SHA-256: the parts list, the presses.
    pub files: Vec<(String, String)>,
    /// More about the presses, in words; may be empty.
    pub presses: String,
    /// More pictures.
    pub figures: Vec<Figure>,
}

/// What stands at the foot of the paper.
pub fn footer(origin: &CalibrationOrigin) -> &'static str {
    if origin.is_simulated {
        "Taxel calibration. Simulated data: no sensor was pressed."
    } else {
        "Taxel calibration, made by the user of the sensor; traceable as far as the weights were."
    }
}

/// The certificate, with as many of the doubts and warnings as one sheet of paper has room for.
///
/// # Errors
/// [`Error::Plot`] should a picture not be encodable; a sensor without a load law.
pub fn of(calibration: &Calibration, origin: CalibrationOrigin) -> Result<Report, Error> {
    let footer = footer(&origin);
    let mut certificate = without_doubts(calibration, origin)?;
    let said = doubts(&calibration.report);
    for most in (0..=said.len().min(MOST_DOUBTS)).rev() {
        let mut some = said[..most].to_vec();
        let more = said.len() - most;
        if more > 0 {
            some.push(format!("The calibration's report has {more} more."));
        }
        if let Some(found) = certificate.sections.last_mut() {
            found.paragraphs = some;
        }
        if certificate.paper(footer)?.pages().len() == 1 {
            break;
        }
    }
    Ok(certificate)
}

/// The certificate but for doubts and warnings.
fn without_doubts(calibration: &Calibration, origin: CalibrationOrigin) -> Result<Report, Error> {
    let report = &calibration.report;
    let name = match calibration.sensor.name() {
        "" => "a sensor".to_owned(),
        name => name.to_owned(),
    };
    let about = about(calibration, &origin);
    let mut errors = Section {
        title: "How far off it is".to_owned(),
        paragraphs: vec![held_out(report)],
        ..Section::default()
    };
    errors.paragraphs.extend(stated(calibration));
    errors.tables.push(by_load(&calibration.residuals));
    let [residuals, law] = calibration_picture::small(calibration, PICTURE)?;
    errors.figures.push(Figure {
        caption:
            "What presses read, less their labels: red by fits without them, grey by the fit of all. Dashed: the stated 95 % interval, without noise."
                .to_owned(),
        picture: residuals,
    });
    errors.figures.push(Figure {
        caption: "What a taxel of middling gain conducts. Dashed: the stated interval, made wider where nobody would see it.".to_owned(),
        picture: law,
    });
    errors.figures.extend(origin.figures);
    let mut numbers = Section {
        title: "What was found".to_owned(),
        ..Section::default()
    };
    numbers.tables.push(parameters(report));
    Ok(Report {
        title: format!("Calibration of {name}"),
        about,
        sections: vec![errors, numbers],
    })
}

fn about(calibration: &Calibration, origin: &CalibrationOrigin) -> Vec<(String, String)> {
    let sensor = &calibration.sensor;
    let report = &calibration.report;
    let date = sensor.provenance().map_or("", |p| p.date.as_str());
    let date = if date.is_empty() {
        time_stamp(SystemTime::now()).chars().take(10).collect()
    } else {
        date.to_owned()
    };
    let mut about = Vec::new();
    if origin.is_simulated {
        about.push((
            "Simulated data",
            "no sensor was pressed; a program drew it".to_owned(),
        ));
    }
    let (rows, columns) = (sensor.rows(), sensor.columns());
    about.push(("Date", date));
    let crossings = rows * columns;
    let taxels = (0..crossings)
        .filter(|&taxel| !sensor.is_absent(taxel))
        .count();
    let size = if taxels == crossings {
        format!("{rows} × {columns} taxels")
    } else {
        format!("{rows} × {columns} lines, {taxels} taxels")
    };
    about.push(("Sensor", format!("{} ({size})", sensor.name())));
    if let Some(bad) = bad_lines(sensor) {
        about.push(("Not measured", bad));
    }
    let mut presses = format!("{} used", report.presses);
    if !report.suspects.is_empty() {
        presses += &format!(", {} contradicted by the others", report.suspects.len());
    }
    if !origin.presses.is_empty() {
        presses += &format!("; {}", origin.presses);
    }
    about.push(("Presses", presses));
    if !origin.source.is_empty() {
        about.push(("Source", origin.source.clone()));
    }
    let short = |sha: &str| sha.chars().take(FINGERPRINT).collect::<String>();
    let sensor = (
        "calibrated sensor".to_owned(),
        fingerprint::of_text(&sensor.to_toml()),
    );
    let prints = origin.files.iter().chain([&sensor]);
    let prints = prints.map(|(what, sha)| format!("{what} {}…", short(sha)));
    about.push(("SHA-256", prints.collect::<Vec<_>>().join(", ")));
    about.push(("Program", format!("taxel {}", env!("CARGO_PKG_VERSION"))));
    let owned = about
        .into_iter()
        .map(|(what, said)| (what.to_owned(), said));
    owned.collect()
}

fn held_out(report: &CalibrationReport) -> String {
    match report.held_out_mean_absolute_g {
        Some(mean) => {
            let (mean, error) = with_error(mean, Some(report.held_out_standard_error_g));
            let error = error.map_or_else(String::new, |error| format!(" ± {error}"));
            format!(
                "Presses that took no part in the fit are {mean}{error} g off on average, 95 % of them within {} g ({} presses; {}).",
                three_digits(report.held_out_p95_g),
                report.held_out_presses,
                report.held_out
            )
        }
        None => "No fit could be made without some of the presses, so that nobody knows how far off it is.".to_owned(),
    }
}

/// What the sensor file states of new loads.
fn stated(calibration: &Calibration) -> Option<String> {
    let known = calibration.sensor.uncertainty()?;
    Some(format!(
        "The sensor file states of a new load F, with 95 %: ± {} g and {} % of F, and noise.",
        two_digits(known.factor_95 * known.model_floor_g),
        two_digits(100.0 * known.factor_95 * known.model_share.hypot(known.fit_share)),
    ))
}

/// Errors of held-out presses, load by load.
fn by_load(residuals: &[PressResidual]) -> Table {
    let mut held_out: Vec<&PressResidual> = residuals.iter().filter(|r| r.held_out).collect();
    held_out.sort_by(|a, b| a.load_g.total_cmp(&b.load_g));
    let mut table = Table::new(
        "Held-out presses by load: mean error (read − label), mean absolute error, and how many their stated 95 % intervals hold",
        &[
            "load, g",
            "presses",
            "mean error, g",
            "mean absolute, g",
            "mean absolute, %",
            "within",
        ],
    );
    for group in groups(&held_out) {
        let off = |r: &&PressResidual| r.estimate_g - r.load_g;
        let count = group.len();
        let within = group.iter().filter(|r| off(r).abs() <= r.half_width_95_g);
        let (low, high) = (group[0].load_g, group[count - 1].load_g);
        let load = if low == high {
            number(low)
        } else {
            format!("{} to {}", number(low), number(high))
        };
        let absolute = mean(group.iter().map(|r| off(r).abs()));
        let middle = mean(group.iter().map(|r| r.load_g));
        let percent = absolute.zip(middle).filter(|(_, g)| *g > 0.0);
        table.push(cells![
            load,
            count,
            mean(group.iter().map(off)).map(three_digits),
            absolute.map(three_digits),
            percent.map(|(off, g)| three_digits(100.0 * off / g)),
            format!("{} of {count}", within.count()),
        ]);
    }
    table
}

/// Presses of one load each, or where there are many loads, as many to a group.
fn groups<'a, 'b>(sorted: &'b [&'a PressResidual]) -> Vec<&'b [&'a PressResidual]> {
    let of_load: Vec<_> = sorted.chunk_by(|a, b| a.load_g == b.load_g).collect();
    if of_load.len() <= MOST_LOADS {
        return of_load;
    }
    let size = sorted.len().div_ceil(GROUPS);
    sorted.chunks(size).collect()
}

/// An interval is not known to more.
fn two_digits(value: f64) -> String {
    let unit = 10f64.powf(value.abs().max(1e-4).log10().floor() - 1.0);
    number((value / unit).round() * unit)
}

fn parameters(report: &CalibrationReport) -> Table {
    let mut table = Table::new(
        "Numbers of the circuit and of the load law, with standard errors",
        &["number", "value", "unit", "told by"],
    );
    for parameter in &report.parameters {
        let (value, error) = with_error(parameter.value, parameter.standard_error);
        let value = match error {
            Some(error) => format!("{value} ± {error}"),
            None => value,
        };
        let told = match (&parameter.held, parameter.standard_error) {
            (Some(by), _) => format!("held: {by}"),
            (None, Some(_)) => told_by(report, &parameter.name),
            (None, None) => "not told".to_owned(),
        };
        table.push(cells![
            parameter.name.as_str(),
            value,
            parameter.unit.as_str(),
            told
        ]);
    }
    table
}

/// What a number rests on, the largest part first: on what was pressed, or on what was believed before. Of the two switches, whose sum
/// and ratio are told apart, what the worse known of these rests on.
fn told_by(report: &CalibrationReport, name: &str) -> String {
    let believed = |belief: &&Belief| {
        let switches = name.contains("r_mux_") && belief.name.ends_with("row switch");
        switches || name.ends_with(&format!(".{}", belief.name))
    };
    let beliefs_of = |belief: &Belief| {
        let own = belief.told_by.iter().find(|(by, _)| by == "beliefs");
        own.map_or(0.0, |(_, share)| *share)
    };
    let belief = report
        .beliefs
        .iter()
        .filter(believed)
        .max_by(|one, other| beliefs_of(one).total_cmp(&beliefs_of(other)));
    let Some(belief) = belief else {
        return "the fit".to_owned();
    };
    let mut parts = belief.told_by.clone();
    parts.retain(|(_, share)| *share >= 0.005);
    parts.sort_by(|one, other| other.1.total_cmp(&one.1));
    let each: Vec<String> = parts
        .iter()
        .map(|(by, share)| format!("{by} {:.0} %", 100.0 * share))
        .collect();
    each.join(", ")
}

/// Lines that the sensor file gives up, in words.
fn bad_lines(sensor: &Sensor) -> Option<String> {
    let screen = sensor.screen();
    let lines = |indices: &[usize], one: &str, many: &str, word: &str| {
        let each: Vec<String> = indices.iter().map(ToString::to_string).collect();
        let name = if each.len() == 1 { one } else { many };
        (!each.is_empty()).then(|| format!("{name} {} ({word})", each.join(", ")))
    };
    let all = [
        lines(&screen.dead_rows, "row", "rows", "dead"),
        lines(&screen.dead_columns, "column", "columns", "dead"),
        lines(
            &screen.flickering_rows,
            "row",
            "rows",
            "flickering: where out",
        ),
        lines(
            &screen.flickering_columns,
            "column",
            "columns",
            "flickering: where out",
        ),
    ];
    let all: Vec<String> = all.into_iter().flatten().collect();
    (!all.is_empty()).then(|| all.join("; "))
}

/// Why not to use it as it is, and what to know before trusting it.
fn doubts(report: &CalibrationReport) -> Vec<String> {
    let doubts = report
        .doubts
        .iter()
        .map(|text| format!("Do not use it as it is: {text}."));
    let warnings = report
        .warnings
        .iter()
        .map(|text| format!("To be known: {text}."));
    doubts.chain(warnings).collect()
}
