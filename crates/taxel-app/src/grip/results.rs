//! What a session amounts to: numbers of every trial, of every hand, and the files that hold them.

use std::path::Path;

use serde::{Deserialize, Serialize};
use taxel::{Frame, Newtons, Sensor};
use taxel_io::AtomicFile;

use super::attempt::{AttemptFile, principal, strongest};
use super::page;
use super::protocol::Hand;
use super::record::{Attempt, GripRecord};
use crate::error::Error;
use crate::figures::Figure;
use crate::measure::{ForceOverTime, Measurement, Trial};

/// Standard gravity, m/s²: what makes kilograms of newtons.
pub(super) const GRAVITY: f64 = 9.80665;

/// What a grip session amounts to.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[non_exhaustive]
pub struct GripResults {
    /// Version of this file.
    pub version: u32,
    /// Pseudonymous id of the person.
    pub person: String,
    /// When the session began, seconds since 1970.
    pub began_secs: u64,
    /// Name of the sensor.
    pub sensor: String,
    /// What forces are: `grip force` or `total normal force`.
    pub force: String,
    /// Frames came from a simulated sensor.
    pub is_simulated: bool,
    /// Right, then left; those that gripped.
    pub hands: Vec<HandResult>,
}

/// What one hand amounts to.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[non_exhaustive]
pub struct HandResult {
    /// Which.
    pub hand: Hand,
    /// The largest force of its trials.
    pub best: Force,
    /// The mean of its trials' largest forces.
    pub mean: Force,
    /// Standard deviation of its trials' largest forces, newtons.
    pub spread_newtons: Option<f64>,
    /// Its trials.
    pub trials: Vec<TrialResult>,
}

/// A force with half of its 95 % interval, newtons.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Force {
    /// The force.
    pub newtons: f64,
    /// Half the width of its interval; `None` where nothing bounds it.
    pub half_width_95_newtons: Option<f64>,
}

/// What one trial amounts to.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[non_exhaustive]
pub struct TrialResult {
    /// Which of the hand's trials, from 1.
    pub number: usize,
    /// Its recording, beside this file.
    pub recording: String,
    /// The largest force.
    pub max: Force,
    /// The largest total normal force.
    pub total: Force,
    /// Mean over the plateau.
    pub plateau: Option<Force>,
    /// Coefficient of variation over it, %.
    pub variation_percent: Option<f64>,
    /// Change of the force over it, % a second: below 0 where the hand tires.
    pub slope_percent_per_s: Option<f64>,
    /// From the beginning of the grip to the largest force, seconds.
    pub time_to_peak_s: f64,
    /// Mean rate from 10 to 90 % of the largest force, newtons a second.
    pub rate_n_per_s: Option<f64>,
    /// Force over time, newton seconds.
    pub impulse_n_s: f64,
    /// Highest pressure, kPa.
    pub peak_kpa: f64,
    /// Area touched, mm².
    pub area_mm2: f64,
    /// Length of the path of the centre of pressure over the plateau, mm.
    pub centre_path_mm: Option<f64>,
    /// Parts of the hand, or contacts: name, and share of the total force over the plateau, 0 to 1.
    pub shares: Vec<(String, f64)>,
    /// What makes it doubtful, in words.
    pub doubts: Vec<String>,
    /// Of a simulated person: the largest force that there truly was, newtons.
    pub true_max_newtons: Option<f64>,
}

/// A trial with its curves, for pictures.
pub(super) struct Drawn {
    pub result: TrialResult,
    /// Seconds since the grip began, and newtons.
    pub curve: (Vec<f64>, Vec<f64>),
    /// Mean loads over the plateau.
    pub map: Option<Frame<Newtons>>,
    /// Centre of pressure over the plateau, mm: across the columns and across the rows.
    pub path: (Vec<f64>, Vec<f64>),
}

impl From<&Figure> for Force {
    fn from(figure: &Figure) -> Self {
        let half = figure.half_width_95();
        Self {
            newtons: figure.value,
            half_width_95_newtons: half.filter(|half| half.is_finite()),
        }
    }
}

impl Force {
    /// The mean of several: what their errors have in common is not averaged out.
    fn mean(forces: &[Self]) -> Self {
        let count = forces.len() as f64;
        let halves: Option<Vec<f64>> = forces.iter().map(|f| f.half_width_95_newtons).collect();
        Self {
            newtons: forces.iter().map(|force| force.newtons).sum::<f64>() / count,
            half_width_95_newtons: halves.map(|halves| halves.iter().sum::<f64>() / count),
        }
    }
}

/// Measures what counts, with its uncertainty, and writes results and page into the session's folder; their names.
///
/// # Errors
/// A recording that cannot be read, a disk that does not take what is written.
pub fn write(
    folder: &Path,
    record: &GripRecord,
    sensor: &Sensor,
    sensor_file: &Path,
) -> Result<Vec<String>, Error> {
    let mut hands = Vec::new();
    for hand in [Hand::Right, Hand::Left] {
        let mut trials = Vec::new();
        for attempt in record.of_hand(hand) {
            let file = AttemptFile {
                recording: &folder.join(&attempt.recording),
                sensor,
                sensor_file,
                protocol: &record.protocol,
            };
            trials.push(measure(&file, attempt, record)?);
        }
        if !trials.is_empty() {
            hands.push((hand, trials));
        }
    }
    let results = GripResults {
        version: 1,
        person: record.person.clone(),
        began_secs: record.began_secs,
        sensor: record.sensor.clone(),
        force: force_of(sensor).to_owned(),
        is_simulated: record.simulated_seed.is_some(),
        hands: hands
            .iter()
            .map(|(hand, drawn)| of_hand(*hand, drawn))
            .collect(),
    };
    let report = page::report(record, &results, &hands, sensor)?;
    let json = serde_json::to_string_pretty(&results).expect("plain data is JSON");
    let mut files = vec![
        ("page.html", report.html().into_bytes()),
        ("results.csv", table(&results)?),
        ("results.json", json.into_bytes()),
    ];
    // A build without PDF writes the rest.
    if let Ok(pdf) = report.paper(page::FOOTER)?.pdf() {
        files.insert(1, ("page.pdf", pdf));
    }
    for (name, bytes) in &files {
        AtomicFile::write_whole(folder.join(name), bytes)?;
    }
    Ok(files.into_iter().map(|(name, _)| name.to_owned()).collect())
}

/// What forces are spoken of.
pub(super) fn force_of(sensor: &Sensor) -> &'static str {
    match sensor.handle() {
        Some(_) => "grip force",
        None => "total normal force",
    }
}

fn of_hand(hand: Hand, drawn: &[Drawn]) -> HandResult {
    let trials: Vec<TrialResult> = drawn.iter().map(|drawn| drawn.result.clone()).collect();
    let forces: Vec<Force> = trials.iter().map(|trial| trial.max).collect();
    let newtons: Vec<f64> = forces.iter().map(|force| force.newtons).collect();
    let larger = |a: Force, b: Force| if b.newtons > a.newtons { b } else { a };
    HandResult {
        hand,
        best: forces
            .iter()
            .copied()
            .reduce(larger)
            .expect("a hand that gripped"),
        mean: Force::mean(&forces),
        spread_newtons: taxel::stats::standard_deviation(&newtons).filter(|_| newtons.len() > 1),
        trials,
    }
}

fn measure(file: &AttemptFile<'_>, attempt: &Attempt, record: &GripRecord) -> Result<Drawn, Error> {
    let regions = file.regions();
    let measurement = file.measurement(&regions, true)?;
    let trial = strongest(&measurement).ok_or_else(|| Error::Request {
        what: format!("{}: nobody pressed", file.recording.display()),
        hint: "was another sensor file given than when it was recorded?",
    })?;
    let force = principal(trial);
    let plateau = force.plateau.as_ref();
    let series = &measurement.series;
    let newtons = series.grip.as_ref().unwrap_or(&series.total);
    let since: Vec<f64> = series.secs.iter().map(|secs| secs - trial.from_s).collect();
    let steady = plateau.map_or([trial.from_s, trial.to_s], |p| [p.from_s, p.to_s]);
    let within = |secs: &f64| (steady[0]..=steady[1]).contains(secs);
    let path = series
        .secs
        .iter()
        .zip(series.contact.x_mm.iter().zip(&series.contact.y_mm));
    let path = path
        .filter(|(secs, _)| within(secs))
        .map(|(_, (x, y))| (*x, *y));
    let simulated = attempt.told.zip(record.simulated_seed);
    Ok(Drawn {
        result: TrialResult {
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
            doubts: file.doubts(&measurement, trial),
            true_max_newtons: simulated.map(|(told, seed)| {
                true_max(file.sensor, &measurement, trial, |secs| {
                    told.loads(file.sensor.array(), seed, secs)
                })
            }),
        },
        curve: (since, newtons.newtons.clone()),
        map: file.map(steady).ok(),
        path: path.unzip(),
    })
}

fn share(force: &ForceOverTime) -> Option<(String, f64)> {
    Some((force.name.clone(), force.share?))
}

/// The largest force that there truly was in the frames of a trial, newtons.
fn true_max(
    sensor: &Sensor,
    measurement: &Measurement,
    trial: &Trial,
    pressed: impl Fn(f64) -> Frame<taxel::Grams>,
) -> f64 {
    let series = &measurement.series;
    let times = series
        .secs
        .iter()
        .filter(|secs| (trial.from_s..=trial.to_s).contains(*secs));
    let force = |secs: &f64| {
        let loads = pressed(series.first_secs + secs);
        let newtons = loads
            .values()
            .iter()
            .map(|g| taxel::frame::newtons_from_grams(*g));
        let loads = Frame::new(loads.rows(), loads.columns(), newtons.collect());
        let loads: Frame<Newtons> = loads.expect("as many as there were");
        match sensor.handle() {
            Some(handle) => taxel::metric::grip_force(&loads, handle).newtons,
            None => taxel::metric::total_force_newtons(&loads),
        }
    };
    times.map(force).fold(0.0, f64::max)
}

/// A line a trial, for statistics.
fn table(results: &GripResults) -> Result<Vec<u8>, Error> {
    let mut parts: Vec<&str> = Vec::new();
    let trials = results.hands.iter().flat_map(|hand| &hand.trials);
    for (name, _) in trials.flat_map(|trial| &trial.shares) {
        if !parts.contains(&name.as_str()) {
            parts.push(name);
        }
    }
    let mut out = csv::Writer::from_writer(Vec::new());
    let head = [
        "person",
        "began_secs",
        "hand",
        "trial",
        "max_n",
        "max_error_n",
        "max_kg",
        "total_n",
        "total_error_n",
        "plateau_n",
        "plateau_error_n",
        "variation_percent",
        "slope_percent_per_s",
        "time_to_peak_s",
        "rate_n_per_s",
        "impulse_n_s",
        "peak_kpa",
        "area_mm2",
        "centre_path_mm",
        "true_max_n",
        "recording",
        "doubts",
    ];
    let head = head.iter().map(|name| (*name).to_owned());
    let shares = parts
        .iter()
        .map(|part| format!("share_{}", part.replace(' ', "_")));
    let written = out.write_record(head.chain(shares));
    written.map_err(|error| unwritten(&error))?;
    let number = |value: Option<f64>| value.map_or_else(String::new, |value| value.to_string());
    for hand in &results.hands {
        for trial in &hand.trials {
            let plateau = trial.plateau;
            let fields = [
                results.person.clone(),
                results.began_secs.to_string(),
                hand.hand.word().to_owned(),
                trial.number.to_string(),
                trial.max.newtons.to_string(),
                number(trial.max.half_width_95_newtons),
                (trial.max.newtons / GRAVITY).to_string(),
                trial.total.newtons.to_string(),
                number(trial.total.half_width_95_newtons),
                number(plateau.map(|plateau| plateau.newtons)),
                number(plateau.and_then(|plateau| plateau.half_width_95_newtons)),
                number(trial.variation_percent),
                number(trial.slope_percent_per_s),
                trial.time_to_peak_s.to_string(),
                number(trial.rate_n_per_s),
                trial.impulse_n_s.to_string(),
                trial.peak_kpa.to_string(),
                trial.area_mm2.to_string(),
                number(trial.centre_path_mm),
                number(trial.true_max_newtons),
                trial.recording.clone(),
                trial.doubts.join("; "),
            ];
            let share = |part: &&str| {
                let mut shares = trial.shares.iter();
                number(
                    shares
                        .find(|(name, _)| name == part)
                        .map(|(_, share)| *share),
                )
            };
            let written = out.write_record(fields.into_iter().chain(parts.iter().map(share)));
            written.map_err(|error| unwritten(&error))?;
        }
    }
    out.into_inner().map_err(|error| Error::Request {
        what: error.to_string(),
        hint: "the table could not be written",
    })
}

fn unwritten(error: &csv::Error) -> Error {
    Error::Request {
        what: error.to_string(),
        hint: "the table could not be written",
    }
}
