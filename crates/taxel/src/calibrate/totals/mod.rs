//! A calibration by known totals alone: a scale under the sensor, or a person's weight.
//!
//! The circuit is that of the sensor file, so that every frame is solved once. What is fitted is the load law: its factor and
//! exponent, such that the loads of all taxels sum to the total, relative to it. What an unloaded taxel conducts is told by frames
//! of the empty sensor, else by the unloaded taxels of the others.
//!
//! Most taxels of a frame carry nothing, and a sum has all of their noise. The law is odd about the unloaded conductance, so that
//! noise there adds up to nothing; cut off at zero it added 14 to 30 % to blobs on 16 × 16 taxels of 10 bits with half a count of
//! noise, 0.1 to 3 % on 32 × 32 of 12. Where lines are left open the inverse bends, and what noise adds to conductances by that
//! (4 to 12 % of the same totals) is taken off each frame before any law ([`crate::uncertainty::NoiseBias`] says how): 0.1 to 1.4 %
//! are left.

mod fit;
mod frames;
mod held_out;
mod law;
mod report;
mod unloaded;
mod write;

use super::{CalibrationOptions, LawChoice, Parameter, Suspect};
use crate::material::LoadLaw;
use crate::parallel::Executor;
use crate::stats::{mean, median};
use crate::{Counts, Error, Frame, Sensor};
use fit::Fitted;
use frames::{Frames, Solved};
use held_out::{HeldOut, Parts};
pub use report::{LeftOut, TotalsReport};
use unloaded::{ToldBy, Unloaded};

/// A total that is farther off than so many standard deviations, and than this share of it, is none of its frame,
const FAR: f64 = 6.0;
const FAR_SHARE: f64 = 0.25;
/// where no more than this share of the totals are.
const MOST_SUSPECTS: f64 = 0.2;
/// Noise that is a larger share of the middle total than this leaves nothing of it.
const MOST_NOISE: f64 = 0.5;

/// A frame whose load on the whole sensor is known.
#[derive(Debug, Clone, PartialEq)]
pub struct TotalLoad {
    /// What was read, counts.
    pub frame: Frame<Counts>,
    /// The load on all taxels together, grams; 0 for the empty sensor.
    pub load_g: f64,
    /// Frames that are held out together, such as a posture: what they are off by they may share.
    pub group: Option<String>,
}

/// A sensor with a law by known totals, and how good it is.
#[derive(Debug, Clone, PartialEq)]
pub struct TotalsCalibration {
    /// The sensor.
    pub sensor: Sensor,
    /// What was found.
    pub report: TotalsReport,
}

/// The load law by frames of known total load. `options`: the law is the power law (with gains, saturation, bend and spread of the
/// sensor file, where it has any), and `folds` are the stretches of frames that are held out where there is one load alone; its
/// switches are for presses.
///
/// # Errors
/// [`Error::MissingKey`] where the circuit is not known; [`Error::Shape`]; [`Error::NoTotalsLaw`] for totals that are no loads, none
/// above 0, and frames that no law explains.
pub fn calibrate_totals(
    sensor: &Sensor,
    totals: &[TotalLoad],
    options: &CalibrationOptions,
    executor: &dyn Executor,
    progress: &mut dyn FnMut(&str, f64),
) -> Result<TotalsCalibration, Error> {
    if !matches!(options.law, LawChoice::Auto | LawChoice::Power) {
        return Err(no_law(
            "a saturating law or a spline is not fitted to totals".to_owned(),
            "take `power` or `auto`; a saturation or bend that the sensor file has stays",
        ));
    }
    let before = sensor.material().map(|_| LoadLaw::from_sensor(sensor));
    let before = before.transpose()?;
    let forgets = sensor.material().is_some_and(|m| m.dynamic.is_some());
    let sensor = &sensor.edited(|spec| {
        (spec.uncertainty, spec.check) = (None, None);
        if let Some(material) = &mut spec.material {
            material.dynamic = None;
        }
    })?;
    progress("frames to conductances", 0.0);
    let frames = frames::solve(sensor, totals, executor)?;
    progress("law", 0.6);
    let bench = Bench::new(sensor, totals, &frames, options, executor)?;
    progress("held-out totals", 0.8);
    let held_out = held_out::judge(
        sensor,
        &bench.frames,
        &bench.noise_g,
        &bench.parts,
        executor,
    );
    progress("writing", 0.95);
    let mut report = bench.report(&frames, &held_out);
    if forgets {
        let gone = "creep and hysteresis of the sensor file are left out: single frames of known total do not tell them";
        report.warnings.push(gone.to_owned());
    }
    let law = bench.fitted.member().law;
    report.compare(&law, before.as_ref(), bench.usual_g());
    let floor_g = write::floor_g(&bench.fitted, &bench.frames, report.empty_g);
    let uncertainty = write::uncertainty(&held_out.judged, floor_g, options.label_share);
    if uncertainty.is_none() && report.held_out_mean_absolute_g.is_some() {
        let few = "too few loads or groups were held out for `[uncertainty]`: three or more tell what new totals are off by";
        report.warnings.push(few.to_owned());
    }
    let doubted = write::doubt_label_share(&held_out.judged, options.label_share);
    report.warnings.extend(doubted);
    let provenance = write::provenance(&report, options);
    let sensor = write::sensor(
        sensor,
        &bench.fitted,
        uncertainty,
        provenance,
        &frames.faults,
    )?;
    Ok(TotalsCalibration { sensor, report })
}

fn no_law(reason: String, hint: &'static str) -> Error {
    Error::NoTotalsLaw { reason, hint }
}

/// A law fitted to all totals but for those that the others contradict.
struct Bench<'a> {
    /// Loaded frames that were fitted to, then those of the empty sensor.
    frames: Vec<&'a Solved>,
    /// Standard error of each total by noise, grams.
    noise_g: Vec<f64>,
    parts: Parts,
    fitted: Fitted,
    suspects: Vec<Suspect>,
}

impl<'a> Bench<'a> {
    fn new(
        sensor: &Sensor,
        totals: &[TotalLoad],
        frames: &'a Frames,
        options: &CalibrationOptions,
        executor: &dyn Executor,
    ) -> Result<Self, Error> {
        let all = frames.solved.iter();
        let (mut chosen, empty): (Vec<&Solved>, Vec<&Solved>) =
            all.partition(|frame| frame.load_g > 0.0);
        if chosen.is_empty() {
            return Err(nothing_loaded(totals, frames));
        }
        let with_empty = |loaded: &[&'a Solved]| [loaded, empty.as_slice()].concat();
        let failed = || {
            no_law(
                "no power law makes these totals of what the taxels conduct: loaded frames conduct no more than empty ones".to_owned(),
                "check that totals and frames are in the same order, topology, v_test_volts, resistors and `converter.inverted`",
            )
        };
        let first = fit::run(sensor, &with_empty(&chosen), None).ok_or_else(failed)?;
        let noise = |loaded: &[&'a Solved]| {
            let level = frames.faults.level;
            fit::noise_of_totals(sensor, &first, &with_empty(loaded), level, executor)
        };
        let mut noise_g = noise(&chosen).ok_or_else(failed)?;
        let again = |loaded: &[&'a Solved], noise_g: &[f64]| {
            fit::run(sensor, &with_empty(loaded), Some(noise_g)).ok_or_else(failed)
        };
        let mut fitted = again(&chosen, &noise_g)?;
        refuse_noise(&chosen, &noise_g)?;
        let suspects = suspects(&fitted, &chosen, &noise_g);
        if !suspects.is_empty() {
            let is_out = |total: usize| suspects.iter().any(|s| s.press == total);
            let kept = |at: &usize| *at >= chosen.len() || !is_out(chosen[*at].total);
            let kept: Vec<usize> = (0..noise_g.len()).filter(kept).collect();
            noise_g = kept.iter().map(|&at| noise_g[at]).collect();
            chosen.retain(|frame| !is_out(frame.total));
            fitted = again(&chosen, &noise_g)?;
        }
        let groups: Vec<Option<&str>> = (chosen.iter())
            .map(|frame| totals[frame.total].group.as_deref())
            .collect();
        Ok(Self {
            parts: held_out::parts(&chosen, &groups, options.folds.max(2)),
            frames: with_empty(&chosen),
            noise_g,
            fitted,
            suspects,
        })
    }

    fn loaded(&self) -> impl Iterator<Item = (&Solved, f64)> {
        let each = self.frames.iter().zip(&self.noise_g);
        each.take(self.parts.of.len()).map(|(f, n)| (*f, *n))
    }

    /// What a taxel carries where most of a total stands, grams.
    fn usual_g(&self) -> f64 {
        self.fitted.at[0].exp()
    }

    fn report(&self, frames: &Frames, held_out: &HeldOut) -> TotalsReport {
        let mut loads: Vec<f64> = self.loaded().map(|(frame, _)| frame.load_g).collect();
        loads.sort_by(f64::total_cmp);
        let totals = loads.len();
        let (least_g, most_g) = (loads[0], loads[totals - 1]);
        loads.dedup();
        let rms = |values: Vec<f64>| mean(values.iter().map(|x| x * x)).unwrap_or(0.0).sqrt();
        let left = |(frame, _): (&Solved, f64)| self.fitted.total_g(frame) / frame.load_g - 1.0;
        let noise = |(frame, noise): (&Solved, f64)| noise / frame.load_g;
        let mut report = TotalsReport {
            parameters: self.parameters(&held_out::jackknife(&held_out.laws)),
            totals,
            empty: self.frames.len() - totals,
            levels: loads.len(),
            least_g,
            most_g,
            unloaded_by: words_of(&self.fitted.unloaded),
            left_share: rms(self.loaded().map(left).collect()),
            noise_share: rms(self.loaded().map(noise).collect()),
            empty_g: self.empty_g(),
            held_out: self.parts.words.clone(),
            held_out_totals: 0,
            held_out_unjudged: held_out.unjudged,
            held_out_mean_absolute_g: None,
            held_out_standard_error_g: None,
            held_out_p95_g: None,
            held_out_mean_absolute_share: None,
            guessing_g: None,
            suspects: self.suspects.clone(),
            left_out: frames.left_out.clone(),
            doubts: Vec::new(),
            warnings: self.warnings(frames),
        };
        report.take_judged(&held_out.judged);
        report.judge();
        report
    }

    fn warnings(&self, frames: &Frames) -> Vec<String> {
        let faults = frames.faults.faults.iter();
        let mut warnings: Vec<String> = faults.map(ToString::to_string).collect();
        if !self.fitted.is_told {
            warnings.push(format!(
                "these totals do not tell the exponent, which is held at {:.3}: loads that differ, or one load on small and on large areas, would",
                self.fitted.member().exponent
            ));
        }
        if self.fitted.unloaded.told_by == ToldBy::Nothing {
            warnings.push(
                "nothing tells what an unloaded taxel conducts: a frame of the empty sensor (load_g 0) would".to_owned(),
            );
        }
        let lost = median(self.loaded().map(|(frame, _)| frame.lost as f64));
        if let Some(lost) = lost.filter(|lost| *lost > 0.0) {
            warnings.push(format!(
                "{lost} taxels of a frame have no reading: what stands there is taken to be what stands around them"
            ));
        }
        if frames.stride > 1 {
            warnings.push(format!(
                "every {}th frame took part: all of them would not fit in memory",
                frames.stride
            ));
        }
        warnings
    }

    /// What frames of the empty sensor sum to by what the others say of unloaded taxels, grams (rms).
    fn empty_g(&self) -> Option<f64> {
        let empty = &self.frames[self.parts.of.len()..];
        if empty.len() < 2 {
            return None;
        }
        let mut law = self.fitted.member().law;
        let squares = (0..empty.len()).map(|at| {
            let others = [&empty[..at], &empty[at + 1..]].concat();
            law.g_zero = Unloaded::of(&others, 0.0).siemens;
            self.fitted.family.total_g(&law, empty[at]).powi(2)
        });
        mean(squares).map(f64::sqrt)
    }

    fn parameters(&self, over_parts: &[f64; 2]) -> Vec<Parameter> {
        let member = self.fitted.member();
        let covariance = &self.fitted.covariance;
        let error = |number: usize| covariance[number][number].sqrt().max(over_parts[number]);
        let (factor, unloaded) = (member.factor, &self.fitted.unloaded);
        let exponent = if self.fitted.is_told {
            let error = member.exponent * error(1);
            Parameter::fitted("material.exponent", member.exponent, error, "")
        } else {
            let by = "totals do not tell it";
            Parameter::held("material.exponent", member.exponent, by, "")
        };
        let name = "material.g_zero_siemens";
        let g_zero = match unloaded.told_by {
            ToldBy::Nothing => {
                Parameter::held(name, unloaded.siemens, "totals do not tell it", "S")
            }
            _ => Parameter {
                standard_error: Some(unloaded.standard_error)
                    .filter(|error| error.is_finite() && *error > 0.0),
                ..Parameter::held(name, unloaded.siemens, "", "S")
            },
        };
        vec![
            Parameter::fitted("material.factor", factor, factor * error(0), "S/g^exponent"),
            exponent,
            Parameter {
                held: g_zero.held.clone().filter(|by| !by.is_empty()),
                ..g_zero
            },
        ]
    }
}

fn words_of(unloaded: &Unloaded) -> String {
    match unloaded.told_by {
        ToldBy::Empty => "by frames of the empty sensor".to_owned(),
        ToldBy::Others => "by those of the loaded frames; none of the empty sensor".to_owned(),
        ToldBy::Nothing => "as the sensor file has them, or 0 S".to_owned(),
    }
}

/// Refuses totals that noise alone would sum to.
fn refuse_noise(loaded: &[&Solved], noise_g: &[f64]) -> Result<(), Error> {
    let shares = loaded.iter().zip(noise_g);
    let share = median(shares.map(|(frame, noise)| noise / frame.load_g)).unwrap_or(0.0);
    if share <= MOST_NOISE {
        return Ok(());
    }
    Err(no_law(
        format!(
            "noise of the readings alone is {:.0} % of a total by the law that suits best, at most {:.0} % are taken: loaded frames conduct hardly more than empty ones",
            100.0 * share,
            100.0 * MOST_NOISE
        ),
        "check that totals and frames are in the same order; heavier loads tell more",
    ))
}

/// Totals that a fit to all contradicts.
fn suspects(fitted: &Fitted, loaded: &[&Solved], noise_g: &[f64]) -> Vec<Suspect> {
    let each = loaded.iter().zip(noise_g);
    let far = each.filter_map(|(frame, noise)| {
        let says_g = fitted.total_g(frame);
        let sigma = fitted.share.hypot(noise / frame.load_g);
        let off = (says_g / frame.load_g - 1.0).abs();
        (off > (FAR * sigma).max(FAR_SHARE)).then_some(Suspect {
            press: frame.total,
            load_g: frame.load_g,
            says_g,
            left_out: true,
        })
    });
    let far: Vec<Suspect> = far.collect();
    if far.len() as f64 <= MOST_SUSPECTS * loaded.len() as f64 {
        far
    } else {
        Vec::new()
    }
}

/// Why there is no loaded frame.
fn nothing_loaded(totals: &[TotalLoad], frames: &Frames) -> Error {
    let given = totals.iter().filter(|total| total.load_g > 0.0).count();
    if given == 0 {
        return no_law(
            format!("none of {} totals is above 0 g", totals.len()),
            "frames of the empty sensor tell what unloaded taxels conduct, and no law: put something of known weight on it",
        );
    }
    let why = frames.left_out.iter().find(|out| out.load_g > 0.0);
    no_law(
        format!(
            "none of {given} loaded frames can be read ({})",
            why.map_or("no reason known", |out| out.why.as_str())
        ),
        "check topology, v_test_volts, resistors, switches and `converter.inverted`; where lines are left open, a dead one that `[screen]` does not declare does this as well (`taxel selftest` finds it)",
    )
}
