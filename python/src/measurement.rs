//! `taxel.measure`: forces of a recording over time, as `taxel measure` finds them.

use std::path::{Path, PathBuf};

use numpy::PyArray1;
use pyo3::prelude::*;
use taxel::sensor::Region;
use taxel_app::measure::{
    Measured, Measurement, Settings, TrialsBy, finds_regions, recording_regions_of_file,
};
use taxel_app::methods::MethodName;
use taxel_app::{Error, Silent, sensor_source};

use crate::errors;
use crate::interrupt::interruptible;
use crate::sensor::Sensor;

/// Columns by name; trials, and what happened to the frames, as JSON.
type Found<'py> = (Vec<(String, Bound<'py, PyArray1<f64>>)>, String, String);

/// Forces over time of a recording, with those of its trials and of what happened to its frames.
#[pyfunction]
#[pyo3(signature = (recording, sensor, *, regions, trials, trial_force, plateau, touched, intervals, zero, frames_per_second, method, repair, no_tare, transpose, keep_going, threads))]
#[allow(clippy::too_many_arguments)]
pub(crate) fn measure<'py>(
    py: Python<'py>,
    recording: PathBuf,
    sensor: Option<Sensor>,
    regions: Option<PathBuf>,
    trials: &str,
    trial_force: Option<f64>,
    plateau: f64,
    touched: f64,
    intervals: bool,
    zero: Option<[f64; 2]>,
    frames_per_second: Option<f64>,
    method: &str,
    repair: Option<bool>,
    no_tare: bool,
    transpose: bool,
    keep_going: bool,
    threads: Option<usize>,
) -> PyResult<Found<'py>> {
    let mut settings = Settings::default();
    settings.trials = trials.parse::<TrialsBy>().map_err(|words| {
        errors::other(format!(
            "trials {trials:?}: {words}\nhint: 'force' finds them"
        ))
    })?;
    for (name, number) in [
        ("trial_force", trial_force.unwrap_or(1.0)),
        ("plateau", plateau),
        ("touched", touched),
        ("frames_per_second", frames_per_second.unwrap_or(1.0)),
    ] {
        if !(number.is_finite() && number > 0.0) {
            return Err(errors::other(format!(
                "{name} is {number}\nhint: a number above 0"
            )));
        }
    }
    settings.hold.threshold_newtons = trial_force;
    settings.hold.plateau_secs = plateau;
    settings.touched_newtons = touched;
    settings.intervals = intervals;
    settings.zero = zero;
    settings.frames_per_second = frames_per_second;
    settings.method = method.parse::<MethodName>().map_err(errors::other)?;
    settings.repair = repair;
    settings.no_tare = no_tare;
    settings.transpose = transpose;
    settings.keep_going = keep_going;
    settings.threads = threads;
    settings.phalanges = regions.as_deref().and_then(finds_regions) == Some(true);
    let found = interruptible(py, |stop| {
        let (sensor, file) = match sensor {
            Some(sensor) => sensor.into_parts(),
            None => sensor_source::of_recording(&recording)?,
        };
        let mut measured = Measured {
            recording: &recording,
            sensor: &sensor,
            sensor_file: &file,
            regions: &[],
        };
        let own = own_regions(&measured, regions.as_deref(), &settings, &|| stop.is_set())?;
        measured.regions = &own;
        let found = measured.measure(&settings, &Silent, &|| stop.is_set())?;
        Ok(told(&found))
    })?;
    let (columns, trials, tally) = found.map_err(errors::of_app)?;
    let columns = columns.into_iter();
    let columns = columns.map(|(name, values)| (name, PyArray1::from_vec(py, values)));
    Ok((columns.collect(), trials, tally))
}

/// Regions that are found, of a file, or of the sensor.
fn own_regions(
    all: &Measured,
    word: Option<&Path>,
    settings: &Settings,
    is_stopped: &(dyn Fn() -> bool + Sync),
) -> Result<Vec<Region>, Error> {
    match word {
        None => Ok(all.sensor.regions().to_vec()),
        Some(word) if finds_regions(word).is_some() => {
            let found = all.find_regions(settings, &Silent, is_stopped)?;
            Ok(Region::of_recording(&found.regions, all.sensor)?)
        }
        Some(file) => recording_regions_of_file(file, all.sensor),
    }
}

fn told(found: &Measurement) -> (Vec<(String, Vec<f64>)>, String, String) {
    let columns = found.series.columns().into_iter();
    let json = |value: serde_json::Result<String>| value.expect("numbers and words");
    let tally = serde_json::to_value(&found.tally).map(|mut tally| {
        tally["saturated_frames"] = found.saturated_frames.into();
        tally["is_whole"] = found.is_whole().into();
        tally
    });
    (
        columns.map(|column| (column.name, column.values)).collect(),
        json(serde_json::to_string(&found.trials)),
        json(tally.and_then(|tally| serde_json::to_string(&tally))),
    )
}
