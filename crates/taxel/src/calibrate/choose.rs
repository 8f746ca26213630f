//! The order of a calibration: a start, every switch apart, the effects of `effects.rs`, and once more with all.

use super::discrepancy::Judged;
use super::evaluate::Evaluator;
use super::evidence::Evidence;
use super::fit::{Effort, Fitted, Score, coarse, look_around, mean, refine, switches_by_ghosts};
use super::least_squares::median;
use super::lines::{LineSlopes, separate};
use super::model::{LawModel, Model, Unknown, no_fit};
use super::outcome::{HeldOut, Outcome};
use super::priors::Beliefs;
use super::terms::Hearing;
use super::together::Together;
use super::{Belief, CalibrationOptions, EffectFinding};
use crate::solve::Best;
use crate::{Error, Executor, Sensor};

/// Offsets below this many counts are taken for none.
pub(super) const MIN_OFFSET_COUNTS: f64 = 1.0;
/// Turns between mean and differences of the switches, at most, and the relative change that ends them.
const MAX_TURNS: usize = 5;
const SETTLED: f64 = 5e-3;
/// Presses that a start is sought with.
const START_PRESSES: usize = 50;
/// The search for the model, and the best so far.
pub(super) struct Search<'a> {
    pub(super) evaluator: Evaluator<'a>,
    pub(super) model: Model,
    pub(super) unknowns: Vec<Unknown>,
    pub(super) best: Option<(Fitted, Score)>,
    /// Everything fitted together, from there, where that is more probable.
    pub(super) together: Option<Together>,
    /// What may be wrong with it, in words.
    pub(super) doubts: Vec<String>,
    pub(super) findings: Vec<EffectFinding>,
    /// What was believed of each number fitted together, and what told it.
    pub(super) beliefs: Vec<Belief>,
    pub(super) laws: Vec<(String, f64)>,
    pub(super) law: String,
    pub(super) separated: bool,
    /// What a step of every switch apart is told by.
    line_slopes: Option<LineSlopes>,
    /// No taxel is ever unloaded, so that the presses must tell the switches.
    pub(super) by_presses: bool,
    /// What tells an unknown, where all are fitted together.
    pub(super) hearing: Hearing,
    pub(super) options: CalibrationOptions,
    pub(super) held_out: HeldOut,
    /// What presses of the folds were read as, where everything was fitted together.
    pub(super) judged: Vec<Judged>,
}

/// What a search is wanted for.
#[derive(Debug, Clone, Copy)]
pub(super) struct Wanted {
    /// One that finds no effect beside circuit and law is wanted for what it looked for alone, and not judged.
    pub(super) unless_plain: bool,
    /// Noise does not explain the presses without it, so that lines may resist.
    pub(super) lines: bool,
}

/// Everything found from crowded frames and uniform loads. It is judged by presses kept from a search of its own, so
/// that they took part neither in the fit nor in the choice of effects that they judge.
pub(super) fn search(
    sensor: &Sensor,
    evidence: &Evidence,
    options: &CalibrationOptions,
    executor: &dyn Executor,
    wanted: Wanted,
    progress: &mut dyn FnMut(&str, f64),
) -> Result<Outcome, Error> {
    let mut search = Search::new(sensor, evidence, options, executor)?;
    search.run(progress)?;
    if wanted.unless_plain && search.findings.iter().all(|f| !f.used) {
        return search.finish();
    }
    if wanted.lines && !wanted.unless_plain {
        search = search.or_with_lines(sensor, progress);
    }
    let folds = options.folds.max(2);
    let (seen, unseen) = evidence.split(folds);
    // A second search takes as long as the first: too long where no exact inverse helps.
    let sensor = &search.model.sensor;
    let slow = !matches!(Best::of(sensor)?, Best::Exact(_) | Best::Diodes(_));
    let held_out = if slow || seen.presses.len() < MIN_TO_CHOOSE {
        search.judged_by_folds()
    } else {
        progress("held-out presses", 0.7);
        let other = Search::new(sensor, &seen, options, executor).and_then(|mut other| {
            other.run(&mut |_, _| ())?;
            Ok(other.judge_unseen(&unseen, folds))
        });
        other.unwrap_or_else(|_| HeldOut {
            unjudged: unseen.presses.len(),
            ..HeldOut::default()
        })
    };
    search.held_out = held_out;
    search.finish()
}

/// Fewest presses that effects are chosen with, when others are kept from it.
const MIN_TO_CHOOSE: usize = 24;

impl<'a> Search<'a> {
    fn new(
        sensor: &Sensor,
        evidence: &'a Evidence,
        options: &CalibrationOptions,
        executor: &'a dyn Executor,
    ) -> Result<Self, Error> {
        Self::begin(sensor, evidence, options, executor, false)
    }

    /// A search from a sensor. `seeks_lines`: what its lines resist along their length is a start, and to be found.
    pub(super) fn begin(
        sensor: &Sensor,
        evidence: &'a Evidence,
        options: &CalibrationOptions,
        executor: &'a dyn Executor,
        seeks_lines: bool,
    ) -> Result<Self, Error> {
        let few = evidence.thinned(START_PRESSES);
        let mut evaluator = Evaluator::new(&few, executor);
        let blank = Model {
            sensor: without_sheet(sensor),
            levelled: false,
            spread_is_believed: false,
            seeks_lines,
            spread: None,
            most_offset_counts: match evidence.faults.level {
                Some(level) => 0.95 * level.baseline_counts,
                None => 0.05 * sensor.max_count(),
            },
            beliefs: Beliefs::of(sensor, options),
            law: LawModel::blank(),
        };
        let model = coarse(&mut evaluator, &blank).ok_or_else(|| {
            no_fit(
                "every switch resistance from 0.5 to 400 Ohm leaves some frames without a solution",
            )
        })?;
        let mut model = feasible(&mut evaluator, model)
            .ok_or_else(|| no_fit("no switch resistance leaves every frame with a solution"))?;
        look_around(&mut evaluator, &model).ok_or_else(|| no_fit("a frame has no solution"))?;
        let mut unknowns = model.switches().to_vec();
        unknowns.push(Unknown::Factor);
        if evidence.levels.is_empty() {
            unknowns.push(Unknown::Exponent);
        }
        if options.open_loop_gain && sensor.readout().has_amplifier() {
            unknowns.push(Unknown::OpenLoopGain);
        }
        if options.r_source {
            unknowns.push(Unknown::Source);
            model.sensor.try_out(|spec| {
                spec.readout.r_source_ohms = spec.readout.r_source_ohms.max(1.0);
            });
        }
        Ok(Self {
            evaluator: Evaluator::new(evidence, executor),
            model,
            unknowns,
            best: None,
            together: None,
            doubts: Vec::new(),
            findings: Vec::new(),
            beliefs: Vec::new(),
            laws: Vec::new(),
            law: "power".to_owned(),
            separated: false,
            line_slopes: None,
            by_presses: false,
            hearing: Hearing::Own,
            options: options.clone(),
            held_out: HeldOut::default(),
            judged: Vec::new(),
        })
    }

    /// Levels tell lines apart only where at least two differ.
    pub(super) fn can_separate(&self) -> bool {
        self.evaluator.evidence.levels.len() >= 2
    }

    /// Circuit and law alone, and how far held-out presses are off with them, grams.
    pub(super) fn begin_with_circuit(
        &mut self,
        progress: &mut dyn FnMut(&str, f64),
    ) -> Result<f64, Error> {
        progress("circuit and load law", 0.0);
        self.start(progress)?;
        if self.model.seeks_lines
            && let Some(model) = with_solutions(&mut self.evaluator, self.model.clone())
        {
            // The start was found on a part of the presses.
            self.model = model;
        }
        self.look()?;
        // Uniform loads tie the loads' scale to the mean of the switches, so that presses hardly tell the two
        // apart; there the ghosts' word stands unless held-out presses gain by another.
        if self.can_separate() && !self.by_presses {
            let switches = self.model.switches();
            self.unknowns.retain(|u| !switches.contains(u));
        }
        self.fit_base(Effort::Full)?;
        self.score_held_out()?;
        Ok(self.error_g())
    }

    pub(super) fn run(&mut self, progress: &mut dyn FnMut(&str, f64)) -> Result<(), Error> {
        self.begin_with_circuit(progress)?;
        self.go_on(progress)
    }

    /// All else, from there: everything at once, or, where that says too little, from effects tried one after the other.
    pub(super) fn go_on(&mut self, progress: &mut dyn FnMut(&str, f64)) -> Result<(), Error> {
        if self.can_separate() && self.goes_together(progress)? {
            return Ok(());
        }
        self.look_beyond(progress)?;
        if self.findings.iter().any(|f| f.used) || self.law != "power" {
            // What one effect hid, another may now show.
            self.settle(progress, Effort::Rough)?;
            self.look_beyond(progress)?;
        }
        if self.can_separate() {
            self.settle(progress, Effort::Full)?;
        }
        self.doubt_offset()?;
        self.try_presses()?;
        self.try_laws(true)?;
        self.explains()?;
        self.polish(progress)
    }

    /// Tries every effect that is not in the model yet.
    fn look_beyond(&mut self, progress: &mut dyn FnMut(&str, f64)) -> Result<(), Error> {
        progress("offset", 0.2);
        self.try_offset()?;
        progress("spread", 0.3);
        self.try_spread()?;
        progress("exponents", 0.4);
        self.try_exponents()?;
        progress("load law", 0.5);
        self.try_laws(false)?;
        progress("memory of the scan", 0.6);
        self.try_carry_over()
    }

    /// The same where lines are sought: effects tried one by one lead such a fit astray, since spread is taken for lines and switches.
    pub(super) fn finish_with_lines(
        &mut self,
        progress: &mut dyn FnMut(&str, f64),
    ) -> Result<(), Error> {
        if !self.can_separate() {
            return self.go_on(progress);
        }
        self.explains()?;
        self.polish_with_lines(progress)
    }

    /// Whether an effect is in the model.
    pub(super) fn uses(&self, name: &str) -> bool {
        self.findings.iter().any(|f| f.used && f.name == name)
    }

    /// Refuses a fit that says no more about held-out presses than their median would.
    pub(super) fn explains(&self) -> Result<(), Error> {
        let loads = self.evaluator.evidence.loads_g();
        let middle = median(&loads);
        let blind = mean(&loads.iter().map(|l| (l - middle).abs()).collect::<Vec<_>>());
        let found = self.error_g();
        if found < 0.8 * blind {
            Ok(())
        } else {
            Err(Error::NothingLearnt {
                found_g: found,
                blind_g: blind,
            })
        }
    }

    /// Everything once more, now that the model has all its parts.
    fn settle(&mut self, progress: &mut dyn FnMut(&str, f64), effort: Effort) -> Result<(), Error> {
        if self.can_separate() {
            self.separate_all(progress);
        }
        self.look()?;
        if self.can_separate() && !self.by_presses {
            let with_offset = self.model.sensor.converter().offset_volts != 0.0;
            if let Some((model, _)) =
                switches_by_ghosts(&mut self.evaluator, &self.model, with_offset)
            {
                self.model = model;
            }
        }
        self.fit_base(effort)?;
        self.score_held_out()
    }

    /// Whether the presses give better switches than the ghosts do.
    fn try_presses(&mut self) -> Result<(), Error> {
        let switches = self.model.switches();
        if switches.iter().all(|u| self.unknowns.contains(u)) {
            return Ok(());
        }
        let model = self.model.clone();
        let Some((fitted, score, gain, errors)) = self.attempt(&model, switches) else {
            return Ok(());
        };
        let used = super::effects::is_better(gain, errors);
        self.note(
            "switches by presses",
            used,
            super::effects::gained(gain, errors),
        );
        if used {
            self.accept(fitted, score);
        }
        Ok(())
    }

    /// A first circuit and law, and every switch apart, from a part of the presses. Mean and differences of the
    /// switches depend on each other, and both on what counts as unloaded: in turn.
    fn start(&mut self, progress: &mut dyn FnMut(&str, f64)) -> Result<(), Error> {
        let few = self.evaluator.evidence.thinned(START_PRESSES);
        let failed = || no_fit("the fit of circuit and load law did not converge");
        let mut before = self.model.mean_ohms();
        let mut offset_error = f64::INFINITY;
        for turn in 0..MAX_TURNS {
            let mut evaluator = Evaluator::new(&few, self.evaluator.executor);
            look_around(&mut evaluator, &self.model).ok_or_else(failed)?;
            if !evaluator.has_unloaded() {
                // Nothing is ever unloaded: the presses must do.
                self.by_presses = true;
                break;
            }
            let ghosts = switches_by_ghosts(&mut evaluator, &self.model, turn > 1);
            let Some((model, error)) = ghosts else {
                self.by_presses = true;
                break;
            };
            self.model = model;
            offset_error = error;
            let law: Vec<Unknown> = self
                .unknowns
                .iter()
                .copied()
                .filter(|u| !u.moves_frames())
                .collect();
            self.model = refine(&mut evaluator, &self.model, &law, Effort::Rough)
                .ok_or_else(failed)?
                .model;
            let now = self.model.mean_ohms();
            let moved = (now.0 / before.0 - 1.0)
                .abs()
                .max((now.1 / before.1 - 1.0).abs());
            before = now;
            if turn > 2 && moved < SETTLED {
                break;
            }
            if self.can_separate() {
                self.separate_with(&mut evaluator, progress);
            }
        }
        let offset = self.model.get(Unknown::Offset).abs();
        if offset < MIN_OFFSET_COUNTS || offset < 3.0 * offset_error {
            self.model.set(Unknown::Offset, 0.0);
        }
        if self.by_presses && self.can_separate() {
            for _ in 0..3 {
                let mut evaluator = Evaluator::new(&few, self.evaluator.executor);
                self.separate_with(&mut evaluator, progress);
                self.model = refine(&mut evaluator, &self.model, &self.unknowns, Effort::Full)
                    .ok_or_else(failed)?
                    .model;
            }
        }
        Ok(())
    }

    /// Every switch apart, and every line that resists, by all evidence; not where that leaves a frame without a solution.
    pub(super) fn separate_all(&mut self, progress: &mut dyn FnMut(&str, f64)) {
        let before = self.model.clone();
        let mut evaluator = Evaluator::new(self.evaluator.evidence, self.evaluator.executor);
        std::mem::swap(&mut evaluator, &mut self.evaluator);
        self.separate_with(&mut evaluator, progress);
        std::mem::swap(&mut evaluator, &mut self.evaluator);
        if self.evaluator.estimates(&self.model).is_none() {
            self.model = before;
        }
    }

    /// The same by an evaluator's evidence.
    pub(super) fn separate_with(
        &mut self,
        evaluator: &mut Evaluator,
        progress: &mut dyn FnMut(&str, f64),
    ) {
        progress("every switch apart", 0.1);
        if let Some(model) = separate(evaluator, &self.model, &mut self.line_slopes) {
            self.model = model;
            self.separated = true;
        }
    }

    /// Fits the present unknowns from the present model.
    pub(super) fn fit_base(&mut self, effort: Effort) -> Result<(), Error> {
        let fitted = refine(&mut self.evaluator, &self.model, &self.unknowns, effort)
            .ok_or_else(|| no_fit("the fit of circuit and load law did not converge"))?;
        self.model = fitted.model.clone();
        self.best = Some((fitted, Score::default()));
        Ok(())
    }

    pub(super) fn look(&mut self) -> Result<(), Error> {
        look_around(&mut self.evaluator, &self.model)
            .ok_or_else(|| no_fit("a frame has no solution"))
    }

    pub(super) fn score_held_out(&mut self) -> Result<(), Error> {
        let folds = self.options.folds;
        if let Some((fitted, score)) = &mut self.best {
            *score = fitted
                .cross_validate(&mut self.evaluator, folds)
                .ok_or_else(|| no_fit("cross-validation met a frame without a solution"))?;
        }
        Ok(())
    }

    /// Fits a changed model with more unknowns. The gain on held-out presses (grams, standard errors).
    pub(super) fn attempt(
        &mut self,
        model: &Model,
        more: &[Unknown],
    ) -> Option<(Fitted, Score, f64, f64)> {
        let mut unknowns = self.unknowns.clone();
        unknowns.extend(more.iter().filter(|u| !self.unknowns.contains(u)));
        let fitted = refine(&mut self.evaluator, model, &unknowns, Effort::Rough)?;
        let score = fitted.cross_validate(&mut self.evaluator, self.options.folds)?;
        let (gain, errors) = self.best.as_ref()?.1.worse_than(&score);
        Some((fitted, score, gain, errors))
    }

    pub(super) fn accept(&mut self, fitted: Fitted, score: Score) {
        self.model = fitted.model.clone();
        self.unknowns = fitted.unknowns.clone();
        self.best = Some((fitted, score));
    }

    pub(super) fn note(&mut self, name: &str, used: bool, text: String) {
        self.findings.retain(|f| f.name != name);
        self.findings.push(EffectFinding {
            name: name.to_owned(),
            used,
            text,
        });
    }
}

/// A model under which every frame has a solution: the start was chosen on a part of them, and too large a
/// resistance is what makes frames infeasible.
fn feasible(evaluator: &mut Evaluator, mut model: Model) -> Option<Model> {
    if !evaluator.evidence.levels.is_empty() {
        // From here on the levels give the law; the factor is that of their loads.
        model.law.ln_factor = 0.0;
    }
    with_solutions(evaluator, model)
}

/// A model with smaller switches, where they leave some frame without a solution.
fn with_solutions(evaluator: &mut Evaluator, mut model: Model) -> Option<Model> {
    for _ in 0..40 {
        if evaluator.estimates(&model).is_some() {
            return Some(model);
        }
        for (unknown, list) in [
            (
                Unknown::Columns,
                model.sensor.readout().r_mux_column_ohms.clone(),
            ),
            (Unknown::Rows, model.sensor.readout().r_mux_row_ohms.clone()),
        ] {
            model.set(unknown, -0.15 * list?.at(0))?;
        }
    }
    None
}

/// The sensor under a cut sheet: what an earlier calibration found is no start.
fn without_sheet(sensor: &Sensor) -> Sensor {
    let mut sensor = sensor.clone();
    sensor.try_out(|spec| {
        if let Some(material) = &mut spec.material {
            material.sheet = None;
        }
    });
    sensor
}
