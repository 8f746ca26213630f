//! All that is known of one trial, with its uncertainty: some seconds of work, done while the person rests.

use std::path::Path;

use taxel::{Frame, Grams, Newtons, Sensor};
use taxel_acquire::simulated::ToldGrip;

use super::attempt::{AttemptFile, principal, strongest};
use super::record::{Attempt, GripRecord};
use super::results::{Force, TrialResult};
use crate::error::Error;
use crate::measure::{ForceOverTime, Measurement, Trial};

/// A trial, with its curves for pictures.
pub(super) struct MeasuredTrial {
    pub result: TrialResult,
    /// From the beginning of the grip to its end, seconds.
    pub held_secs: f64,
    /// Seconds since the grip began, and newtons.
    pub curve: (Vec<f64>, Vec<f64>),
    /// Mean loads over the plateau.
    pub map: Option<Frame<Newtons>>,
    /// Centre of pressure over the plateau, mm: across the columns and across the rows.
    pub path: (Vec<f64>, Vec<f64>),
}

impl MeasuredTrial {
    /// Of an attempt of a session that is kept in `folder`.
    ///
    /// # Errors
    /// A recording that cannot be read, or in which nobody pressed.
    pub(super) fn of(
        folder: &Path,
        attempt: &Attempt,
        record: &GripRecord,
        sensor: &Sensor,
        sensor_file: &Path,
    ) -> Result<Self, Error> {
        let file = AttemptFile {
            recording: &folder.join(&attempt.recording),
            sensor,
            sensor_file,
            protocol: &record.protocol,
        };
        let measurement = file.measurement(&file.regions(), true)?;
        let trial = strongest(&measurement).ok_or_else(|| Error::Request {
            what: format!("{}: nobody pressed", file.recording.display()),
            hint: "was another sensor file given than when it was recorded?",
        })?;
        let plateau = principal(trial).plateau.as_ref();
        let steady = plateau.map_or([trial.from_s, trial.to_s], |p| [p.from_s, p.to_s]);
        let series = &measurement.series;
        let newtons = series.grip.as_ref().unwrap_or(&series.total);
        let since = series.secs.iter().map(|secs| secs - trial.from_s);
        let mut result = result_of(&file, attempt, &measurement, trial);
        let told = attempt.told.zip(record.simulated_seed);
        result.true_max_newtons = told.map(|(told, seed)| true_max(sensor, told, seed));
        Ok(Self {
            result,
            held_secs: trial.to_s - trial.from_s,
            curve: (since.collect(), newtons.newtons.clone()),
            map: file.map(steady).ok(),
            path: path(&measurement, steady),
        })
    }
}

fn result_of(
    file: &AttemptFile<'_>,
    attempt: &Attempt,
    measurement: &Measurement,
    trial: &Trial,
) -> TrialResult {
    let force = principal(trial);
    let plateau = force.plateau.as_ref();
    TrialResult {
        number: attempt.planned.number,
        recording: attempt.recording.clone(),
        max: Force::from(&force.peak_n),
        total: Force::from(&trial.forces[0].peak_n),
        plateau: plateau.map(|plateau| Force::from(&plateau.mean_n)),
        variation_percent: plateau.map(|plateau| plateau.variation_percent),
        slope_percent_per_s: plateau.map(|plateau| plateau.slope_percent_per_s),
        time_to_peak_s: force.time_to_peak_s,
        rate_n_per_s: force.loading_rate_n_per_s,
        impulse_n_s: force.impulse_n_s.value,
        peak_kpa: trial.peak_kpa,
        area_mm2: trial.area_mm2,
        centre_path_mm: trial.centre_path_mm,
        shares: trial.forces.iter().filter_map(share).collect(),
        doubts: file.doubts(measurement, trial),
        true_max_newtons: None,
    }
}

/// The centre of pressure over some seconds, mm.
fn path(measurement: &Measurement, [from, to]: [f64; 2]) -> (Vec<f64>, Vec<f64>) {
    let series = &measurement.series;
    let centres = series.contact.x_mm.iter().zip(&series.contact.y_mm);
    let timed = series.secs.iter().zip(centres);
    let within = timed.filter(|(secs, _)| (from..=to).contains(*secs));
    within.map(|(_, (x, y))| (*x, *y)).unzip()
}

fn share(force: &ForceOverTime) -> Option<(String, f64)> {
    Some((force.name.clone(), force.share?))
}

/// The largest force that a simulated person truly exerted, newtons.
fn true_max(sensor: &Sensor, told: ToldGrip, seed: u64) -> f64 {
    let force = |loads: Frame<Grams>| {
        let grams = loads.values().iter();
        let newtons = grams.map(|grams| taxel::frame::newtons_from_grams(*grams));
        let loads = Frame::new(loads.rows(), loads.columns(), newtons.collect());
        let loads: Frame<Newtons> = loads.expect("as many as there were");
        match sensor.handle() {
            Some(handle) => taxel::metric::grip_force(&loads, handle).newtons,
            None => taxel::metric::total_force_newtons(&loads),
        }
    };
    let pressed = told.all_loads(sensor.array(), seed);
    pressed.map(force).fold(0.0, f64::max)
}
