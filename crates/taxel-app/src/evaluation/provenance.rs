//! What a report rests on: the sensor, the program, the files with their fingerprints.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use taxel::sensor::{PerLine, PerTaxel, SensorSpec};
use taxel::{Frame, Sensor};
use taxel_io::{ReadOptions, open_counts};
use taxel_plot::cells;
use taxel_plot::report::{Section, Table, number};

use super::plan::Plan;
use super::regions;
use crate::calibration_age::calibration_history;
use crate::error::Error;
use crate::fingerprint;
use crate::reporter::Reporter;
use crate::session::time_stamp;

/// Hexadecimal digits of a fingerprint that are shown: enough to tell files apart, few enough to compare by eye.
const SHOWN: usize = 16;

/// Clocks that say less were never set: seconds of 2000-01-01 since 1970.
const NEVER_SET: Duration = Duration::from_secs(946_684_800);

/// Sensor, when its recordings were made, program, how intervals were made.
pub(super) fn about(plan: &Plan) -> Result<Vec<(String, String)>, Error> {
    let mut about = describe(&plan.sensor);
    about.extend(recorded(plan)?.map(|days| ("recorded".to_owned(), days)));
    about.push((
        "program".to_owned(),
        format!("taxel {}", env!("CARGO_PKG_VERSION")),
    ));
    let bootstrap = &plan.bootstrap;
    about.push((
        "intervals".to_owned(),
        format!(
            "{} %, {} bootstrap resamples of whole experiments, seed {}; none with fewer than three experiments",
            number(100.0 * bootstrap.confidence),
            bootstrap.resamples,
            bootstrap.seed
        ),
    ));
    Ok(about)
}

/// The day on which the plan's recordings were made, or the first and the last, by the clocks of those computers; `None` where no
/// recording tells. A day of the data and not of the report, which is the same on any day.
fn recorded(plan: &Plan) -> Result<Option<String>, Error> {
    let mut days = BTreeSet::new();
    for experiment in &plan.experiments {
        for (setting, wanted) in regions::wanted(plan, experiment)? {
            let own = experiment.settings.get(&setting);
            let (sensor, _) = plan.sensor_of(own.or(experiment.sensor.as_ref()))?;
            let begun = wanted.keys().filter_map(|file| begun(file, &sensor));
            let set = begun.filter(|begun| *begun >= SystemTime::UNIX_EPOCH + NEVER_SET);
            days.extend(set.map(|begun| {
                let mut day = time_stamp(begun);
                // The time of day follows the ten characters of the date.
                day.truncate(10);
                day
            }));
        }
    }
    let (Some(first), Some(last)) = (days.first(), days.last()) else {
        return Ok(None);
    };
    Ok(Some(if first == last {
        format!("{first} (UTC)")
    } else {
        format!("{first} to {last} (UTC)")
    }))
}

/// When the first frame of a recording came. What cannot be read is told where it is evaluated.
fn begun(file: &Path, sensor: &Sensor) -> Option<SystemTime> {
    let mut source = open_counts(file, ReadOptions::of(sensor)).ok()?;
    let mut frame = Frame::zeros(sensor.rows(), sensor.columns());
    source.next_into(&mut frame).ok()?.then_some(())?;
    source.host_time()
}

/// A sensor, line by line.
fn describe(sensor: &Sensor) -> Vec<(String, String)> {
    let spec = sensor.spec();
    let (array, converter) = (&spec.array, &spec.converter);
    let line = |what: &str, said: String| (what.to_owned(), said);
    let mut about = vec![
        line("sensor", spec.name.clone()),
        line(
            "array",
            format!(
                "{} rows × {} columns, pitch {} × {} mm, {} mm² a taxel",
                array.rows,
                array.columns,
                array.pitch_mm[0],
                array.pitch_mm[1],
                array.taxel_area_mm2
            ),
        ),
    ];
    if let Some(exported) = sensor.exported() {
        let program = &exported.program;
        let said = format!("as {program} has exported it: no cross-talk is removed");
        about.push(line("loads", said));
        about.push(line("a load is uncertain by", describe_doubt(sensor)));
        return about;
    }
    about.push(line("read-out", describe_readout(sensor)));
    about.push(line(
        "converter",
        format!(
            "{} bits, full scale {} V{}",
            converter.bits,
            number(converter.full_scale_volts),
            if converter.inverted { ", inverted" } else { "" }
        ),
    ));
    about.push(line("load law", describe_law(spec)));
    let history = calibration_history(sensor, None);
    about.extend(history.map(|history| line("calibration", history)));
    if spec.material.is_some() {
        about.push(line("a load is uncertain by", describe_doubt(sensor)));
    }
    about
}

/// Half of a load's 95 % interval, as far as the sensor file tells.
fn describe_doubt(sensor: &Sensor) -> String {
    if let Some(exported) = sensor.exported() {
        return format!(
            "nobody knows what: {} has found the loads",
            exported.program
        );
    }
    let Some(stated) = sensor.uncertainty() else {
        return "noise only: the sensor file has no [uncertainty]".to_owned();
    };
    let half = |load_g| number(stated.factor_95 * stated.beyond_noise_g(load_g));
    format!(
        "± {} g at 50 g, ± {} g at 300 g (95 %, by {} presses), and the noise of its reading",
        half(50.0),
        half(300.0),
        stated.presses
    )
}

fn describe_readout(sensor: &Sensor) -> String {
    let (array, readout) = (sensor.array(), &sensor.spec().readout);
    let table = &sensor.readout().table;
    let mut parts = vec![
        sensor.readout().words(),
        format!("V_test {} V", number(readout.v_test_volts)),
    ];
    let optional = [
        ("R_k", readout.r_feedback_ohms, " Ω"),
        ("pull-down", readout.r_pull_down_ohms, " Ω"),
        ("gain", readout.open_loop_gain, ""),
    ];
    for (name, value, unit) in optional {
        parts.extend(value.map(|value| format!("{name} {}{unit}", number(value))));
    }
    if table.driven.is_switched() {
        let ohms = switches(readout.r_mux_column_ohms.as_ref(), array.columns);
        parts.push(format!("column switches {ohms}"));
    }
    if table.sensed.is_switched() {
        let ohms = switches(readout.r_mux_row_ohms.as_ref(), array.rows);
        parts.push(format!("row switches {ohms}"));
    }
    for (side, ohms, lines) in [
        ("rows", &readout.r_line_row_ohms, array.rows),
        ("columns", &readout.r_line_column_ohms, array.columns),
    ] {
        if let Some(ohms) = ohms {
            let along = switches(Some(ohms), lines);
            parts.push(format!("{side} {along} a pitch"));
        }
    }
    if readout.r_source_ohms > 0.0 {
        parts.push(format!("R_v {} Ω", number(readout.r_source_ohms)));
    }
    parts.join(", ")
}

fn describe_law(spec: &SensorSpec) -> String {
    let Some(material) = &spec.material else {
        return "none: no loads".to_owned();
    };
    let exponent = match &material.exponent {
        PerTaxel::One(exponent) => number(*exponent),
        _ => "its taxel's exponent".to_owned(),
    };
    let mut law = format!(
        "G = {} S + {} S · (load in g)^{exponent}",
        number(material.g_zero_siemens),
        number(material.factor),
    );
    for (there, words) in [
        (material.gain.is_some(), ", a gain for each taxel"),
        (material.bend.is_some(), ", bent"),
        (material.saturation_load_g.is_some(), ", saturating"),
        (material.spread.is_some(), ", with spread to neighbours"),
        (material.dynamic.is_some(), ", with creep and hysteresis"),
    ] {
        law += if there { words } else { "" };
    }
    law
}

fn switches(values: Option<&PerLine>, lines: usize) -> String {
    let Some(values) = values else {
        return "unknown".to_owned();
    };
    let each: Vec<f64> = (0..lines).map(|i| values.at(i)).collect();
    let (least, most) = each
        .iter()
        .fold((f64::MAX, f64::MIN), |(a, b), &v| (a.min(v), b.max(v)));
    if least == most {
        format!("{} Ω", number(least))
    } else {
        format!("{} to {} Ω", number(least), number(most))
    }
}

/// The files, named as the plan names them, with their fingerprints.
pub(super) fn data(
    plan: &Plan,
    files: &BTreeSet<PathBuf>,
    reporter: &dyn Reporter,
) -> Result<Section, Error> {
    let mut table = Table::new("", &["file", "bytes", "SHA-256, first 16 digits"]);
    let folder = plan.folder();
    let mut files = files.clone();
    files.insert(plan.sensor_file.clone());
    // A preset's name is no file.
    let files: BTreeSet<PathBuf> = files
        .iter()
        .map(|file| taxel_io::exports::file_of(file))
        .collect();
    let stage = reporter.stage("fingerprints");
    for file in files.iter().filter(|file| file.exists()) {
        let (bytes, digits) = fingerprint::of_file_shown(file, &*stage)?;
        let name = file.strip_prefix(folder).unwrap_or(file);
        table.push(cells![
            name.display().to_string(),
            bytes,
            digits[..SHOWN].to_owned()
        ]);
    }
    Ok(Section {
        title: "Data".to_owned(),
        paragraphs: vec![
            "The same files with the same plan and program give this report again, byte for byte."
                .to_owned(),
        ],
        tables: vec![table],
        figures: Vec::new(),
    })
}
