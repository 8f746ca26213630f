//! The most probable circuit and law.
//!
//! Presses made one at a time: nothing else stands on the array, so that a circuit and a law say what every taxel of
//! the frame must read, and they follow from the readings themselves, from any start. Presses in crowded frames are
//! conductances through the inverse, with the errors that noise gives them there: they join those made one at a time,
//! and stand alone on read-outs that no exact inverse helps.

mod crowd;
mod fit;
mod held_out;
mod joint;
mod known;
mod labels;
mod line_search;
mod lumped;
mod unknowns;
mod whole;
mod words;

use super::evidence::{Evidence, MIN_PRESSES};
use super::fit_law::LAWS;
use super::model::{no_fit, with_switches};
use super::outcome::Outcome;
use super::priors::Beliefs;
use super::{CalibrationOptions, LawChoice, Suspect, suspects};
use crate::circuit::LinearCircuit;
use crate::sensor::PerLine;
use crate::solve::Exact;
use crate::{Error, Executor, Sensor};
use crowd::{Crowd, Linear};
use fit::{Fitted, Readings, plain_law};
use held_out::judged;
use joint::Joint;
use known::KnownFrames;
use line_search::LineSearch;
use unknowns::{Layout, Unknown};

/// A law with one number more must be this much likelier (minus twice the logarithm), one with three this much.
const GAIN: [f64; 2] = [9.0, 16.0];
/// A saturation is told when it is this many standard errors from none.
const TOLD: f64 = 3.0;
/// Crowded presses that a fit takes, times the taxels of a frame to the power of one and a half: what an inversion and an
/// adjoint cost grows so. The others judge the fit.
const MAX_WORK: f64 = 1.0e7;
/// An exact inverse leaves the adjoint alone.
const WITH_EXACT: f64 = 3.2;
/// It takes so many, however large the array.
const MIN_CROWDED: usize = 24;
/// Unloaded conductance that a crowd's fit starts from before it has seen any, siemens.
const ANY_G_ZERO: f64 = 1e-6;
/// With this many crowded presses and no fewer than the others, those tell the circuit.
const MANY_CROWDED: usize = 20;

/// The fit to labelled presses alone. With it, whether they were made one at a time, so that nothing else is to be looked
/// for.
pub(super) fn calibrate(
    sensor: &Sensor,
    evidence: &Evidence,
    options: &CalibrationOptions,
    executor: &dyn Executor,
    progress: &mut dyn FnMut(&str, f64),
) -> (Result<Outcome, Error>, bool) {
    let mut known = KnownFrames::find(evidence, sensor.max_count());
    let (alone, crowded) = (known.presses(), known.crowded.len());
    // Where a recorder leaves out what unloaded taxels read, nobody knows that nothing else was pressed.
    let one_at_a_time = alone >= MIN_PRESSES
        && (alone >= crowded || crowded < MANY_CROWDED)
        && sensor.converter().floor_count.is_none();
    if !one_at_a_time {
        known = known.all_crowded(evidence.presses.len());
    }
    let fit = PressFit::new(sensor, evidence, options, executor).run(&known, progress);
    (fit, one_at_a_time)
}

/// Whether frames of a read-out are inverted exactly, whatever its switches are; a source resistor to be found is there.
pub(super) fn has_exact_inverse(sensor: &Sensor, options: &CalibrationOptions) -> bool {
    let ohms = || PerLine::One(super::priors::USUAL_OHMS);
    let mut sensor = with_switches(sensor, ohms(), ohms());
    if options.r_source {
        sensor.try_out(|spec| spec.readout.r_source_ohms = super::priors::USUAL_OHMS);
    }
    LinearCircuit::from_sensor(&sensor)
        .is_ok_and(|circuit| Exact::from_sensor(&sensor, &circuit).is_some())
}

/// What a fit is made with.
struct PressFit<'a> {
    sensor: &'a Sensor,
    evidence: &'a Evidence,
    options: &'a CalibrationOptions,
    executor: &'a dyn Executor,
    beliefs: Beliefs,
    /// What unloaded taxels of crowded frames seem to conduct, siemens.
    unloaded: f64,
    /// Whether lines are taken to resist, and what was found of that.
    with_lines: bool,
    lines: Option<LineSearch>,
    /// The one law that is fitted, while something else is tried.
    only: Option<LawChoice>,
    /// Conductances of crowded presses' frames by a first look, where Newton's method found them.
    first: Vec<Option<Vec<f64>>>,
}

/// Every law fitted, and which is chosen.
struct Chosen {
    fits: Vec<(&'static str, Fitted)>,
    at: usize,
    /// Conductances of crowded presses' frames, where Newton's method found them.
    ends: Vec<Option<Vec<f64>>>,
    /// Crowded frames alone: where they are linear for the first law.
    linear: Option<Linear>,
}

impl Chosen {
    fn fitted(&self) -> &Fitted {
        &self.fits[self.at].1
    }

    /// Adds one more law's fit, and takes it where it says enough more than the one taken so far.
    fn add(
        all: &mut Option<Self>,
        (choice, name): (LawChoice, &'static str),
        wanted: bool,
        fitted: Fitted,
    ) {
        let before = all.as_ref().map(Self::fitted);
        let gain = before.map_or(f64::INFINITY, |b| b.loss - fitted.loss);
        let enough = is_enough(choice, wanted, gain, &fitted);
        let chosen = all.get_or_insert_with(|| Self {
            fits: Vec::new(),
            at: 0,
            ends: Vec::new(),
            linear: None,
        });
        if enough {
            chosen.at = chosen.fits.len();
        }
        chosen.fits.push((name, fitted));
    }

    /// Adds what a few crowded presses tell to a fit of presses made one at a time.
    fn join(&mut self, joint: &Joint) {
        let alone = self.fitted();
        let about = joint.crowd.linear(&alone.layout, &alone.peak.at);
        let found = about.and_then(|about| joint.fit(&alone.layout, about, alone.share));
        if let Some((fitted, _)) = found {
            // What the crowd adds is no reason for another law: that was chosen by the others alone.
            let loss = alone.loss;
            self.fits[self.at].1 = Fitted { loss, ..fitted };
        }
    }
}

impl<'a> PressFit<'a> {
    fn new(
        sensor: &'a Sensor,
        evidence: &'a Evidence,
        options: &'a CalibrationOptions,
        executor: &'a dyn Executor,
    ) -> Self {
        Self {
            beliefs: Beliefs::of(sensor, options),
            unloaded: ANY_G_ZERO,
            with_lines: false,
            lines: None,
            only: None,
            first: Vec::new(),
            sensor,
            evidence,
            options,
            executor,
        }
    }

    /// The fit, its errors and what is to be said of it.
    fn run(
        mut self,
        known: &KnownFrames,
        progress: &mut dyn FnMut(&str, f64),
    ) -> Result<Outcome, Error> {
        progress("circuit and load law", 0.0);
        let (mut kept, mut spare) = self.spare(known);
        // Presses that neither fit nor judge would cost an inversion each.
        let mut looked_at = kept.clone();
        looked_at.crowded.extend(&spare);
        let mut suspects = self.gross(&looked_at)?;
        let good = |suspects: &[Suspect], p: usize| suspects.iter().all(|s| s.press != p);
        kept = kept.with(|p| good(&suspects, p));
        spare.retain(|&p| good(&suspects, p));
        let looked_at: Vec<usize> = if spare.is_empty() {
            (0..self.evidence.presses.len()).collect()
        } else {
            looked_at.crowded
        };
        let mut chosen = self.choose(&kept, None)?;
        self.look_for_lines(&kept, &mut chosen, progress);
        let mut estimates = self.read_all(&looked_at, &chosen);
        let mut later: Vec<Suspect> = suspects::after(&self.labelled(&estimates, &suspects));
        later.retain(|suspect| self.is_beyond_noise(suspect.press, &chosen));
        if !later.is_empty() && suspects::few(later.len(), self.evidence.presses.len()) {
            suspects.extend(later.into_iter().map(|s| Suspect {
                left_out: true,
                ..s
            }));
            kept = kept.with(|p| good(&suspects, p));
            spare.retain(|&p| good(&suspects, p));
            chosen = self.choose(&kept, None)?;
            estimates = self.read_all(&looked_at, &chosen);
        }
        for suspect in &mut suspects {
            if let Some(says) = estimates[suspect.press].filter(|says| says.is_finite()) {
                suspect.says_g = says;
            }
        }
        suspects.sort_by_key(|s| s.press);
        let (held_out, laws) = if spare.is_empty() {
            self.held_out(&kept, &chosen, progress)
        } else {
            self.judged_by_spare(spare, &chosen)
        };
        let mut outcome = self.outcome(&kept, &chosen, held_out, laws, suspects)?;
        let read = estimates.iter().enumerate();
        outcome.fitted = read
            .filter_map(|(p, says_g)| {
                let (sensor, law) = (&outcome.model.sensor, &outcome.law);
                Some(judged(self.evidence, sensor, law, p, (*says_g)?))
            })
            .collect();
        Ok(outcome)
    }

    /// Leaves crowded frames alone no more presses than a fit may take; the others, no more than those, judge it.
    fn spare(&self, known: &KnownFrames) -> (KnownFrames, Vec<usize>) {
        let taxels = (self.sensor.rows() * self.sensor.columns()) as f64;
        let more = if !self.with_lines && has_exact_inverse(self.sensor, self.options) {
            WITH_EXACT
        } else {
            1.0
        };
        let most = ((more * MAX_WORK / taxels.powf(1.5)) as usize).max(MIN_CROWDED);
        if !known.frames.is_empty() || known.crowded.len() <= most {
            return (known.clone(), Vec::new());
        }
        let stride = known.crowded.len().div_ceil(most);
        let numbered = known.crowded.iter().copied().enumerate();
        let (kept, spare): (Vec<_>, Vec<_>) = numbered.partition(|(i, _)| i % stride == 0);
        let presses = |which: Vec<(usize, usize)>| which.into_iter().map(|(_, p)| p);
        let kept: Vec<usize> = presses(kept).collect();
        let spare = presses(spare).take(kept.len()).collect();
        (known.with(|p| kept.binary_search(&p).is_ok()), spare)
    }

    /// Every law that is asked for, fitted to these frames, and the one that they choose. Crowded frames alone may go on
    /// from another choice.
    fn choose(&self, known: &KnownFrames, from: Option<&Chosen>) -> Result<Chosen, Error> {
        let readings = Readings::new(self.evidence, known, self.sensor);
        let ends = from.map_or(&self.first, |from| &from.ends);
        let crowd = Crowd::new(self.evidence, &known.crowded, self.executor).near(ends);
        let joint = Joint {
            readings: &readings,
            crowd: &crowd,
        };
        let crowded = known.frames.is_empty();
        let (loads, g_zero) = if crowded {
            (crowd.loads_g(), self.unloaded)
        } else {
            let presses = known.frames.iter().flat_map(|f| &f.presses);
            let loads = presses.map(|&p| self.evidence.presses[p].load_g).collect();
            (loads, readings.g_zero(self.sensor))
        };
        let failed = || {
            no_fit(if crowded {
                "the presses' conductances through the inverse fit no circuit and law"
            } else {
                "the readings of presses made one at a time fit no circuit"
            })
        };
        let mut chosen: Option<Chosen> = None;
        let mut linear: Option<Linear> = None;
        for (choice, name) in LAWS {
            let wanted = self.options.law == choice;
            if choice != LawChoice::Power && !wanted && self.options.law != LawChoice::Auto {
                continue;
            }
            if self.only.is_some_and(|only| only != choice) {
                continue;
            }
            let layout = Layout::new(self.sensor, self.beliefs, choice, &loads, g_zero);
            let Some(mut layout) = layout else { continue };
            if self.with_lines {
                layout = layout.with_lines();
            }
            let power = chosen.as_ref().map(|c| &c.fits[0].1);
            let fitted = if crowded {
                let about = self.about(&joint, &layout, power.zip(linear.as_ref()), from);
                let found = about.and_then(|(about, share)| joint.fit(&layout, about, share));
                found.map(|(fitted, at)| {
                    linear.get_or_insert(at);
                    fitted
                })
            } else {
                readings.fit(&layout, power)
            };
            if let Some(fitted) = fitted {
                Chosen::add(&mut chosen, (choice, name), wanted, fitted);
            }
        }
        let mut chosen = chosen.ok_or_else(failed)?;
        if !crowded && !known.crowded.is_empty() {
            chosen.join(&joint);
        }
        chosen.linear = linear;
        chosen.ends = crowd.ends();
        Ok(chosen)
    }

    /// Where a crowd's fit of a law begins, and the share of a label's conductance that it leaves: at the power law's
    /// end; for the power law itself at another choice's, or at the best of several starts.
    fn about(
        &self,
        joint: &Joint,
        layout: &Layout,
        power: Option<(&Fitted, &Linear)>,
        from: Option<&Chosen>,
    ) -> Option<(Linear, f64)> {
        if let Some((power, linear)) = power {
            return Some((linear.carried(&power.layout, layout), power.share));
        }
        match from.and_then(|f| Some((f.linear.as_ref()?, &f.fits[0].1))) {
            // Where the power law has no fit here, this is another law's.
            Some((near, fit)) => Some((
                near.with(|p| joint.crowd.has(p))
                    .carried(&fit.layout, layout),
                fit.share,
            )),
            None => joint.start(layout).map(|linear| (linear, 0.0)),
        }
    }

    /// What a fit reads from presses through the inverse, grams; nothing where a frame has no solution. `near` knows
    /// about what their frames conduct.
    fn read(&self, which: &[usize], fitted: &Fitted, near: &Chosen) -> Vec<Option<f64>> {
        let law = plain_law(&fitted.model);
        let presses = Crowd::new(self.evidence, which, self.executor).near(&near.ends);
        let siemens = presses.siemens(&fitted.model.sensor).into_iter();
        siemens
            .map(|g| Some(law.grams_from_siemens(0, g?)))
            .collect()
    }

    /// What the chosen fit reads from presses, at their places among all of the evidence.
    fn read_all(&self, which: &[usize], chosen: &Chosen) -> Vec<Option<f64>> {
        let mut all = vec![None; self.evidence.presses.len()];
        for (&p, says) in which.iter().zip(self.read(which, chosen.fitted(), chosen)) {
            all[p] = says;
        }
        all
    }
}

/// Whether a law is so much likelier than the one before that its numbers are worth having. A saturation that cannot be
/// told from none would only blur the switches, asked for or not.
fn is_enough(choice: LawChoice, wanted: bool, gain: f64, fitted: &Fitted) -> bool {
    match choice {
        LawChoice::Saturating => {
            (wanted || gain > GAIN[0]) && is_determined(fitted, Unknown::Saturation)
        }
        LawChoice::Spline => wanted || gain > GAIN[1],
        _ => true,
    }
}

/// Whether an unknown is told apart from nothing.
fn is_determined(fitted: &Fitted, unknown: Unknown) -> bool {
    let at = fitted.layout.position(unknown);
    at.is_some_and(|i| fitted.peak.at[i] > TOLD * fitted.peak.error(i))
}
