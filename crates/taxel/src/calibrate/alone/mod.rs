//! The most probable circuit and law.
//!
//! Presses made one at a time: nothing else stands on the array, so that a circuit and a law say what every taxel of
//! the frame must read, and they follow from the readings themselves, from any start. Presses in crowded frames are
//! conductances through the inverse, with the errors that noise gives them there: they join those made one at a time,
//! and stand alone on read-outs that no exact inverse helps.

mod crowd;
mod fit;
mod joint;
mod known;
mod lumped;
mod unknowns;
mod words;

use super::evidence::{Evidence, FEWEST_PRESSES};
use super::fit_law::LAWS;
use super::model::{no_fit, with_switches};
use super::outcome::{HeldOut, Outcome};
use super::priors::Beliefs;
use super::{LawChoice, Options, Suspect, suspects};
use crate::circuit::LinearCircuit;
use crate::crew::shared_out;
use crate::sensor::PerLine;
use crate::solve::Exact;
use crate::{Crew, Error, Sensor};
use crowd::{Crowd, Linear};
use fit::{Fitted, Readings, plain_law};
use joint::Joint;
use known::KnownFrames;
use unknowns::{Layout, Unknown};

/// A law with one number more must be this much likelier (minus twice the logarithm), one with three this much.
const GAIN: [f64; 2] = [9.0, 16.0];
/// A saturation is told when it is this many standard errors from none.
const TOLD: f64 = 3.0;
/// Crowded presses that a fit takes, times the taxels of a frame to the power of one and a half: what an inversion and an
/// adjoint cost grows so. The others judge the fit.
const MOST_WORK: f64 = 1.6e7;
/// An exact inverse leaves the adjoint alone.
const WITH_EXACT: f64 = 2.0;
/// It takes so many, however large the array.
const FEWEST_CROWDED: usize = 24;
/// Unloaded conductance that a crowd's fit starts from before it has seen any, siemens.
const ANY_G_ZERO: f64 = 1e-6;
/// With this many crowded presses and no fewer than the others, those tell the circuit.
const MANY_CROWDED: usize = 20;

/// The fit to labelled presses alone; nothing where uniform loads are there to tell more. With it, whether the presses
/// were made one at a time, so that nothing else is to be looked for.
pub(super) fn calibrate(
    sensor: &Sensor,
    evidence: &Evidence,
    options: &Options,
    crew: &dyn Crew,
    progress: &mut dyn FnMut(&str, f64),
) -> Option<(Result<Outcome, Error>, bool)> {
    if !evidence.levels.is_empty() {
        return None;
    }
    let mut known = KnownFrames::find(evidence, sensor.max_count());
    let (alone, crowded) = (known.presses(), known.crowded.len());
    let one_at_a_time = alone >= FEWEST_PRESSES && (alone >= crowded || crowded < MANY_CROWDED);
    if !one_at_a_time {
        known = known.all_crowded(evidence.presses.len());
    }
    let fit = Alone::new(sensor, evidence, options, crew).run(&known, progress);
    Some((fit, one_at_a_time))
}

/// Whether frames of a read-out are inverted exactly, whatever its switches are.
pub(super) fn has_exact_inverse(sensor: &Sensor) -> bool {
    let ohms = || PerLine::One(super::priors::USUAL_OHMS);
    LinearCircuit::from_sensor(&with_switches(sensor, ohms(), ohms()))
        .is_ok_and(|circuit| Exact::new(&circuit).is_some())
}

/// What a fit is made with.
struct Alone<'a> {
    sensor: &'a Sensor,
    evidence: &'a Evidence,
    options: &'a Options,
    crew: &'a dyn Crew,
    beliefs: Beliefs,
    /// What unloaded taxels of crowded frames seem to conduct, siemens.
    unloaded: f64,
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
}

impl<'a> Alone<'a> {
    fn new(
        sensor: &'a Sensor,
        evidence: &'a Evidence,
        options: &'a Options,
        crew: &'a dyn Crew,
    ) -> Self {
        Self {
            beliefs: Beliefs::of(sensor, options),
            unloaded: ANY_G_ZERO,
            sensor,
            evidence,
            options,
            crew,
        }
    }

    /// The fit, its errors and what is to be said of it.
    fn run(
        mut self,
        known: &KnownFrames,
        progress: &mut dyn FnMut(&str, f64),
    ) -> Result<Outcome, Error> {
        progress("circuit and load law", 0.0);
        let mut suspects = self.gross(known)?;
        let mut kept = self.without(known, &suspects);
        let spare = self.spare(&mut kept);
        let mut chosen = self.choose(&kept, None)?;
        let everything: Vec<usize> = (0..self.evidence.presses.len()).collect();
        let mut estimates = self.read(&everything, chosen.fitted(), &chosen);
        let later: Vec<Suspect> = suspects::after(&self.labelled(&estimates, &suspects));
        if !later.is_empty() && suspects::few(later.len(), self.evidence.presses.len()) {
            suspects.extend(later.into_iter().map(|s| Suspect {
                left_out: true,
                ..s
            }));
            kept = kept.with(|p| suspects.iter().all(|s| s.press != p));
            chosen = self.choose(&kept, None)?;
            estimates = self.read(&everything, chosen.fitted(), &chosen);
        }
        for suspect in &mut suspects {
            if let Some(says) = estimates[suspect.press].filter(|says| says.is_finite()) {
                suspect.says_g = says;
            }
        }
        suspects.sort_by_key(|s| s.press);
        let (held_out, laws) = match spare.is_empty() {
            true => self.held_out(&kept, &chosen, progress),
            false => self.judged_by_spare(spare, &chosen),
        };
        self.outcome(&kept, &chosen, held_out, laws, suspects)
    }

    /// Labels that contradict the others before anything is fitted.
    fn gross(&mut self, known: &KnownFrames) -> Result<Vec<Suspect>, Error> {
        let readings = Readings::new(self.evidence, known, self.sensor);
        let apparent: Vec<(usize, f64, f64)> = match known.frames.is_empty() {
            true => self.through_the_inverse(known, &readings)?,
            false => {
                let apparent = readings.apparent(self.sensor).into_iter();
                apparent
                    .map(|(p, g)| (p, self.evidence.presses[p].load_g, g))
                    .collect()
            }
        };
        let suspects = suspects::gross(&apparent);
        match suspects::few(suspects.len(), apparent.len()) {
            true => Ok(suspects),
            false => Err(no_fit(&format!(
                "{} of {} labels contradict the others by a factor of 4 or more (are some in other units?)",
                suspects.len(),
                apparent.len()
            ))),
        }
    }

    fn without(&self, known: &KnownFrames, suspects: &[Suspect]) -> KnownFrames {
        known.with(|p| suspects.iter().all(|s| s.press != p))
    }

    /// Leaves crowded frames alone no more presses than a fit may take; the others, no more than those.
    fn spare(&self, known: &mut KnownFrames) -> Vec<usize> {
        let taxels = (self.sensor.rows() * self.sensor.columns()) as f64;
        let more = if has_exact_inverse(self.sensor) {
            WITH_EXACT
        } else {
            1.0
        };
        let most = ((more * MOST_WORK / taxels.powf(1.5)) as usize).max(FEWEST_CROWDED);
        if !known.frames.is_empty() || known.crowded.len() <= most {
            return Vec::new();
        }
        let stride = known.crowded.len().div_ceil(most);
        let all = std::mem::take(&mut known.crowded);
        let (kept, spare) = (0..all.len()).partition(|i| i % stride == 0);
        let named = |which: Vec<usize>| which.into_iter().map(|i| all[i]).collect::<Vec<_>>();
        known.crowded = named(kept);
        let mut spare = named(spare);
        spare.truncate(known.crowded.len());
        spare
    }

    /// Errors on presses that no fit has seen, and those of each law.
    fn judged_by_spare(&self, spare: Vec<usize>, chosen: &Chosen) -> (HeldOut, Vec<(String, f64)>) {
        let fold = self.judged(chosen, chosen, &spare);
        let laws = fold.laws.into_iter();
        let held = HeldOut {
            how: format!(
                "{} presses that neither fitted nor chose; a fit of this array takes no more than it did",
                spare.len()
            ),
            errors_g: fold.errors_g,
            unjudged: fold.unjudged,
        };
        (
            held,
            laws.map(|(name, e)| (name.to_owned(), super::fit::mean(&e)))
                .collect(),
        )
    }

    /// Label and estimate of every press that is not suspected yet.
    fn labelled(&self, estimates: &[Option<f64>], suspects: &[Suspect]) -> Vec<(usize, f64, f64)> {
        let presses = self.evidence.presses.iter().zip(estimates).enumerate();
        presses
            .filter(|(p, _)| suspects.iter().all(|s| s.press != *p))
            .filter_map(|(p, (press, says))| says.map(|says| (p, press.load_g, says)))
            .collect()
    }

    /// Press, label and what its taxel conducts over an unloaded one, for presses in crowded frames alone, by the
    /// switches that are believed in or the first others that leave frames a solution.
    fn through_the_inverse(
        &mut self,
        known: &KnownFrames,
        readings: &Readings,
    ) -> Result<Vec<(usize, f64, f64)>, Error> {
        let crowd = Crowd::new(self.evidence, &known.crowded, self.crew);
        let joint = Joint {
            readings,
            crowd: &crowd,
        };
        let loads = crowd.loads_g();
        let layout = Layout::new(
            self.sensor,
            self.beliefs,
            LawChoice::Power,
            &loads,
            ANY_G_ZERO,
        );
        let layout = layout.ok_or_else(|| no_fit("no label is above nothing"))?;
        let linear = joint.first(&layout).ok_or_else(|| {
            no_fit("no switch resistance leaves four frames of five with a solution")
        })?;
        if linear.unloaded.0 > 0.0 {
            self.unloaded = linear.unloaded.0;
        }
        Ok(joint.pairs(&linear))
    }

    /// Every law that is asked for, fitted to these frames, and the one that they choose. Crowded frames alone may go on
    /// from another choice.
    fn choose(&self, known: &KnownFrames, from: Option<&Chosen>) -> Result<Chosen, Error> {
        let readings = Readings::new(self.evidence, known, self.sensor);
        let mut crowd = Crowd::new(self.evidence, &known.crowded, self.crew);
        if let Some(from) = from {
            crowd = crowd.near(&from.ends);
        }
        let joint = Joint {
            readings: &readings,
            crowd: &crowd,
        };
        let crowded = known.frames.is_empty();
        let (loads, g_zero) = match crowded {
            true => (crowd.loads_g(), self.unloaded),
            false => {
                let presses = known.frames.iter().flat_map(|f| &f.presses);
                let loads = presses.map(|&p| self.evidence.presses[p].load_g).collect();
                (loads, readings.g_zero(self.sensor))
            }
        };
        let failed = || {
            no_fit(match crowded {
                true => "the presses' conductances through the inverse fit no circuit and law",
                false => "the readings of presses made one at a time fit no circuit",
            })
        };
        let mut chosen: Option<Chosen> = None;
        let mut linear: Option<Linear> = None;
        for (choice, name) in LAWS {
            let wanted = self.options.law == choice;
            if choice != LawChoice::Power && !wanted && self.options.law != LawChoice::Auto {
                continue;
            }
            let layout = Layout::new(self.sensor, self.beliefs, choice, &loads, g_zero);
            let Some(layout) = layout else { continue };
            let before = chosen.as_ref().map(Chosen::fitted);
            let power = chosen.as_ref().map(|c| &c.fits[0].1);
            let fitted = match crowded {
                false => readings.fit(&layout, power),
                true => {
                    let about = match (power, &linear) {
                        (Some(power), Some(linear)) => {
                            Some((linear.carried(&power.layout, &layout), power.share))
                        }
                        _ => match from.and_then(|f| Some((f.linear.as_ref()?, f.fits[0].1.share)))
                        {
                            Some((near, share)) => {
                                let kept = |p| known.crowded.binary_search(&p).is_ok();
                                Some((near.with(kept), share))
                            }
                            None => joint.start(&layout).map(|linear| (linear, 0.0)),
                        },
                    };
                    let found = about.and_then(|(about, share)| joint.fit(&layout, about, share));
                    found.map(|(fitted, at)| {
                        linear.get_or_insert(at);
                        fitted
                    })
                }
            };
            let Some(fitted) = fitted else {
                continue;
            };
            let gain = before.map_or(f64::INFINITY, |b| b.loss - fitted.loss);
            // A saturation that cannot be told from none would only blur the switches, asked for or not.
            let enough = match choice {
                LawChoice::Saturating => {
                    (wanted || gain > GAIN[0]) && told(&fitted, Unknown::Saturation)
                }
                LawChoice::Spline => wanted || gain > GAIN[1],
                _ => true,
            };
            let chosen = chosen.get_or_insert_with(|| Chosen {
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
        let mut chosen = chosen.ok_or_else(failed)?;
        let at = chosen.at;
        if !crowded && !known.crowded.is_empty() {
            let alone = chosen.fitted();
            let about = crowd.linear(&alone.layout, &alone.peak.at);
            let found = about.and_then(|about| joint.fit(&alone.layout, about, alone.share));
            if let Some((fitted, _)) = found {
                // What the crowd adds is no reason for another law: that was chosen by the others alone.
                let loss = alone.loss;
                chosen.fits[at].1 = Fitted { loss, ..fitted };
            }
        }
        chosen.linear = linear;
        chosen.ends = crowd.ends();
        Ok(chosen)
    }

    /// What a fit reads from presses through the inverse, grams; nothing where a frame has no solution. `near` knows
    /// about what their frames conduct.
    fn read(&self, which: &[usize], fitted: &Fitted, near: &Chosen) -> Vec<Option<f64>> {
        let law = plain_law(&fitted.model);
        let presses = Crowd::new(self.evidence, which, self.crew).near(&near.ends);
        let siemens = presses.siemens(&fitted.model.sensor).into_iter();
        siemens
            .map(|g| Some(law.grams_from_siemens(0, g?)))
            .collect()
    }

    /// Errors on presses that neither fitted nor chose: each fold is read by a fit and a choice made without it. With
    /// them, those of each law.
    fn held_out(
        &self,
        known: &KnownFrames,
        chosen: &Chosen,
        progress: &mut dyn FnMut(&str, f64),
    ) -> (HeldOut, Vec<(String, f64)>) {
        let presses = &self.evidence.presses;
        let mut used: Vec<usize> = known
            .frames
            .iter()
            .flat_map(|f| f.presses.clone())
            .collect();
        used.extend(&known.crowded);
        let mut frames: Vec<usize> = used.iter().map(|&p| presses[p].frame).collect();
        frames.sort_unstable();
        frames.dedup();
        let folds = self.options.folds.clamp(2, frames.len().max(2));
        let fold_of = |p: usize| frames.partition_point(|&f| f < presses[p].frame) % folds;
        progress("held-out presses", 0.5);
        let judged = shared_out(self.crew, (0..folds).collect(), |fold| {
            let held = used.iter().copied().filter(|&p| fold_of(p) == fold);
            Some(self.judge(&known.with(|p| fold_of(p) != fold), held.collect(), chosen))
        });
        let mut held = HeldOut {
            how: format!(
                "{folds} folds, split by press; each judged by a fit and a choice of law made without it"
            ),
            ..HeldOut::default()
        };
        let mut laws: Vec<(String, Vec<f64>)> = Vec::new();
        for fold in judged.unwrap_or_default() {
            held.unjudged += fold.unjudged;
            held.errors_g.extend(&fold.errors_g);
            for (name, errors) in fold.laws {
                match laws.iter_mut().find(|(known, _)| known == name) {
                    Some((_, all)) => all.extend(errors),
                    None => laws.push((name.to_owned(), errors)),
                }
            }
        }
        let means = laws
            .into_iter()
            .map(|(name, e)| (name, super::fit::mean(&e)));
        (held, means.collect())
    }

    /// Errors on the presses of one fold, by a fit and a choice made from the others.
    fn judge(&self, others: &KnownFrames, held: Vec<usize>, near: &Chosen) -> Fold {
        match self.choose(others, Some(near)) {
            Ok(chosen) => self.judged(&chosen, near, &held),
            Err(_) => Fold {
                unjudged: held.len(),
                ..Fold::default()
            },
        }
    }

    /// Errors of every law's fit on presses that it has not seen.
    fn judged(&self, chosen: &Chosen, near: &Chosen, held: &[usize]) -> Fold {
        let mut fold = Fold::default();
        for (at, (name, fitted)) in chosen.fits.iter().enumerate() {
            let read = self.read(held, fitted, near);
            let errors: Vec<f64> = held
                .iter()
                .zip(&read)
                .filter_map(|(&p, says)| {
                    Some((says.as_ref()? - self.evidence.presses[p].load_g).abs())
                })
                .collect();
            if at == chosen.at {
                fold.unjudged = held.len() - errors.len();
                fold.errors_g.clone_from(&errors);
            }
            fold.laws.push((name, errors));
        }
        fold
    }
}

/// Errors on one fold, grams: of the law chosen, and of each.
#[derive(Default)]
struct Fold {
    errors_g: Vec<f64>,
    unjudged: usize,
    laws: Vec<(&'static str, Vec<f64>)>,
}

/// Whether an unknown is told apart from nothing.
fn told(fitted: &Fitted, unknown: Unknown) -> bool {
    let at = fitted.layout.position(unknown);
    at.is_some_and(|i| fitted.peak.at[i] > TOLD * fitted.peak.error(i))
}
