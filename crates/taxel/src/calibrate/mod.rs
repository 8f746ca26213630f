//! The fit of everything that a parts list does not say: the circuit's unknowns and the laws of [`crate::material`].

mod along_lines;
mod answered;
mod at_once;
mod choose;
mod digits;
mod discrepancy;
mod dynamic;
mod effects;
mod equations;
mod evaluate;
mod even_loads;
mod evidence;
mod fit;
mod fit_law;
mod inverter;
mod judge;
mod least_squares;
mod levels;
mod lines;
mod model;
mod next_press;
mod noise;
mod outcome;
mod patch;
mod polish;
mod posterior;
mod presses;
mod priors;
mod readable;
mod report;
mod residuals;
mod scatter;
mod screening;
mod sheet_share;
mod silent;
mod suspects;
mod terms;
mod together;
mod told;
mod totals;
mod transfer;
mod uniform_loads;
mod words;
mod write;

pub use digits::{fixed, with_error};
pub use dynamic::{DynamicFit, LoadSeries, fit_dynamic};
pub use fit_law::{LawFit, fit_pairs, suspect_pairs};
pub use next_press::{MadePress, PlannedPress, PressPlan, PressReason};
pub use report::{CalibrationReport, EffectFinding, Parameter, Suspect};
pub use residuals::PressResidual;
pub use told::Belief;
pub use totals::{LeftOut, TotalLoad, TotalsCalibration, TotalsReport, calibrate_totals};
pub use uniform_loads::{UniformCalibration, UniformLaw, UniformReport, calibrate_uniform};

use crate::parallel::{Executor, Serial};
use crate::{Counts, Error, Frame, Sensor};

/// One labelled taxel: a known load on it in a frame of otherwise unknown loads.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PressLabel {
    /// Index into [`CalibrationData::frames`].
    pub frame: usize,
    /// Row of the taxel, from 0.
    pub row: usize,
    /// Column of the taxel, from 0.
    pub column: usize,
    /// Load, grams.
    pub load_g: f64,
}

/// What there is to fit to.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CalibrationData {
    /// The frames that presses point into.
    pub frames: Vec<Frame<Counts>>,
    /// Labelled presses.
    pub presses: Vec<PressLabel>,
    /// Frames under a uniform load, and the load on every taxel in grams.
    pub uniform: Vec<(Frame<Counts>, f64)>,
}

impl CalibrationData {
    /// The number that a frame has in its recording, by which whoever wrote the labels knows it; its place here where it has none.
    pub fn number_of(&self, frame: usize) -> usize {
        let told = self.frames.get(frame).map_or(0, |frame| frame.sequence);
        if told > 0 { told as usize } else { frame }
    }
}

/// Which load law to fit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum LawChoice {
    /// The power law, or another that explains the presses better by more than chance.
    #[default]
    Auto,
    /// Power law with offset.
    Power,
    /// Power law of a load that saturates.
    Saturating,
    /// Monotone spline.
    Spline,
}

/// What to fit, and how.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct CalibrationOptions {
    /// The load law.
    pub law: LawChoice,
    /// One switch resistance per line; otherwise only where uniform frames are there to tell them apart.
    pub per_line: bool,
    /// Fit the open-loop gain.
    pub open_loop_gain: bool,
    /// Fit the source resistor.
    pub r_source: bool,
    /// Look for resistance along the lines on arrays of any size, and where noise explains the presses.
    pub line_resistance: bool,
    /// What labelled loads themselves are off by, a share of the load: it is no fault of the sensor.
    pub label_share: f64,
    /// Folds of the cross-validation by press.
    pub folds: usize,
    /// Date for the provenance, ISO 8601.
    pub date: String,
    /// Names of the files, for the provenance.
    pub files: Vec<String>,
}

impl Default for CalibrationOptions {
    fn default() -> Self {
        Self {
            law: LawChoice::Auto,
            per_line: false,
            open_loop_gain: false,
            r_source: false,
            line_resistance: false,
            label_share: 0.0,
            folds: 5,
            date: String::new(),
            files: Vec::new(),
        }
    }
}

/// A fitted sensor and how good the fit is.
#[derive(Debug, Clone, PartialEq)]
pub struct Calibration {
    /// The sensor with the fitted numbers and their provenance.
    pub sensor: Sensor,
    /// What was found.
    pub report: CalibrationReport,
    /// What is read of presses: those held out by fits without them, and all by the fit of all.
    pub residuals: Vec<PressResidual>,
}

/// Noise is taken to be less than thought where it is by this factor.
const QUIETER: f64 = 0.9;
/// Effects beside circuit and law are looked for on no more taxels where no exact inverse helps: it would take minutes.
const MAX_SEARCHED_TAXELS: usize = 400;
/// Nor are uniform loads asked there, and of more taxels still where noise explains what they could be asked for.
const MAX_LEVELLED_TAXELS: usize = 1024;

/// Fits the circuit's unknowns and the load law to labelled presses, and what uniform frames can tell.
/// `progress` is called with the stage's name and the share done, 0 to 1.
///
/// # Errors
/// Too few presses, presses outside the array or on a dead line, two labels for one taxel of a frame, frames of the
/// wrong shape, no circuit that explains the frames.
pub fn calibrate(
    sensor: &Sensor,
    data: &CalibrationData,
    options: &CalibrationOptions,
    progress: &mut dyn FnMut(&str, f64),
) -> Result<Calibration, Error> {
    calibrate_with(sensor, data, options, &Serial, progress)
}

/// [`calibrate`] with a executor that frames are shared out to; the answer does not depend on its size.
///
/// # Errors
/// As [`calibrate`].
pub fn calibrate_with(
    sensor: &Sensor,
    data: &CalibrationData,
    options: &CalibrationOptions,
    executor: &dyn Executor,
    progress: &mut dyn FnMut(&str, f64),
) -> Result<Calibration, Error> {
    // A check is of the calibration before.
    let sensor = &sensor.edited(|spec| spec.check = None)?;
    let mut evidence = evidence::Evidence::new(sensor, data)?;
    let exact = presses::has_exact_inverse(sensor, options);
    if !exact && !evidence.levels.is_empty() {
        evidence = answered::answered(&evidence, sensor, data, executor).unwrap_or(evidence);
    }
    let plain = by_presses(sensor, &mut evidence, options, executor, progress);
    let of_lines = plain
        .0
        .as_ref()
        .ok()
        .and_then(outcome::Outcome::line_finding);
    let explained = plain.0.as_ref().is_ok_and(|plain| !plain.unexplained);
    let mut search = |unless_plain: bool| {
        let wanted = choose::Wanted {
            unless_plain,
            lines: !explained || options.line_resistance,
        };
        choose::search(sensor, &evidence, options, executor, wanted, progress)
    };
    let taxels = sensor.rows() * sensor.columns();
    let mut outcome = match plain {
        (plain, _) if !evidence.levels.is_empty() => {
            let search = match why_without_levels(options, explained, exact, taxels) {
                None => search(false).map_err(|error| error.to_string()),
                Some(why) => Err(why),
            };
            with_levels_or(plain, search, &evidence)?
        }
        (plain, true) => plain?,
        (plain, false) if exact => search_or(plain, search(explained))?,
        (plain, false) => {
            let plain = plain?;
            if plain.unexplained && taxels <= MAX_SEARCHED_TAXELS {
                search(false)
                    .ok()
                    .filter(|s| s.is_better_than(&plain))
                    .unwrap_or(plain)
            } else {
                plain
            }
        }
    };
    outcome.take_line_finding(of_lines);
    if options.open_loop_gain && !sensor.readout().has_amplifier() {
        outcome.warnings.push(format!(
            "{} has no amplifier, so that no gain was looked for",
            sensor.readout().topology.name()
        ));
    }
    write::calibration(outcome, sensor, &evidence, options)
}

/// What presses alone tell, with the noise that they leave; and whether they stand alone.
fn by_presses(
    sensor: &Sensor,
    evidence: &mut evidence::Evidence,
    options: &CalibrationOptions,
    executor: &dyn Executor,
    progress: &mut dyn FnMut(&str, f64),
) -> (Result<outcome::Outcome, Error>, bool) {
    let plain = presses::calibrate(sensor, evidence, options, executor, progress);
    let Some(noise) = quieter(sensor, evidence, &plain.0) else {
        return plain;
    };
    evidence.noise_counts = noise;
    presses::calibrate(sensor, evidence, options, executor, progress)
}

/// Noise of a reading by what a fit leaves of frames of presses, counts, where it is so much less than what differs from one to
/// the next that the fit would be another. Where lines are left open, that has the ghosts of other loads in it.
fn quieter(
    sensor: &Sensor,
    evidence: &evidence::Evidence,
    plain: &Result<outcome::Outcome, Error>,
) -> Option<f64> {
    let is_asked = sensor.readout().has_open_columns() && sensor.converter().noise_counts.is_none();
    let plain = plain.as_ref().ok().filter(|_| is_asked)?;
    let noise = noise::by_unloaded(evidence, plain)?;
    (noise < QUIETER * evidence.noise_counts).then_some(noise)
}

/// Why uniform loads are not asked, if they are not. `explained`: noise is all that the presses leave without them.
fn why_without_levels(
    options: &CalibrationOptions,
    explained: bool,
    exact: bool,
    taxels: usize,
) -> Option<String> {
    if explained && (options.r_source || options.open_loop_gain) {
        // A search with them takes such a number for what the switches are, and is sure of it.
        return Some("presses alone explain a circuit with what was asked for".to_owned());
    }
    let most = if explained {
        MAX_SEARCHED_TAXELS
    } else {
        MAX_LEVELLED_TAXELS
    };
    (!exact && taxels > most)
        .then(|| format!("a fit with them would take minutes ({taxels} taxels, no exact inverse)"))
}

/// Uniform loads tell what presses can't, and the search alone asks them. Where it ends clearly worse than the presses
/// without them, or nowhere, it lost its way.
fn with_levels_or(
    plain: Result<outcome::Outcome, Error>,
    search: Result<outcome::Outcome, String>,
    evidence: &evidence::Evidence,
) -> Result<outcome::Outcome, Error> {
    let (mut plain, why) = match (plain, search) {
        (Ok(plain), Ok(search)) if plain.is_better_than(&search) => {
            let mean = |of: &outcome::Outcome| of.held_out.mean().unwrap_or(f64::NAN);
            let (with, without) = (mean(&search), mean(&plain));
            let why =
                format!("held-out presses are {with:.3} g off with them, {without:.3} g without");
            (plain, why)
        }
        (Ok(plain), Err(why)) => (plain, why),
        (_, Ok(search)) => return Ok(search),
        (Err(error), Err(_)) => return Err(error),
    };
    let levels = evidence.levels.len();
    plain.warnings.push(format!(
        "the uniform loads ({levels} levels) took no part in the fit, so that taxels are taken to be alike: {why}"
    ));
    Ok(plain)
}

/// A search that found no effect beside circuit and law says no more than the most probable ones, where noise explains
/// what these leave; it chooses laws by few presses.
fn search_or(
    plain: Result<outcome::Outcome, Error>,
    search: Result<outcome::Outcome, Error>,
) -> Result<outcome::Outcome, Error> {
    match (plain, search) {
        (Ok(plain), Ok(search))
            if (plain.unexplained || search.finds_something())
                && search.held_out.mean().is_some()
                && !plain.is_better_than(&search) =>
        {
            Ok(search)
        }
        (Ok(mut plain), Ok(search)) => {
            // What was looked for in vain is worth knowing, where nothing is known of it.
            let known: Vec<String> = plain.findings.iter().map(|f| f.name.clone()).collect();
            let more = search.findings.into_iter();
            plain
                .findings
                .extend(more.filter(|finding| !known.contains(&finding.name)));
            Ok(plain)
        }
        (Ok(plain), Err(_)) if !plain.unexplained => Ok(plain),
        // How far off held-out presses are says more than where the search lost its way.
        (Err(plain @ Error::NothingLearnt { .. }), Err(_)) => Err(plain),
        (_, search) => search,
    }
}
