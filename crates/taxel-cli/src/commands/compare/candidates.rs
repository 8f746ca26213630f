//! Who takes part, each having learnt from the same presses.

use std::ops::ControlFlow;

use taxel::calibrate::{
    CalibrationData, CalibrationOptions, PressLabel, calibrate_with, fit_pairs,
};
use taxel::material::LoadLaw;
use taxel::pipeline::Pipeline;
use taxel::solve::{Raw, default_method};
use taxel::stats::median;
use taxel::{Counts, Frame, Newtons, Sensor};
use taxel_learn::benchmark::Scores;
use taxel_learn::fit::{self, TrainingData};
use taxel_learn::models::paper_mlp::HIDDEN;
use taxel_learn::train::Settings;
use taxel_learn::{Learned, Model, ModelKind, Rows, Split};

use super::{Args, grams};
use crate::error::Error;
use crate::{interrupt, out};
use taxel_app::executor::Threads;
use taxel_app::training_set::TrainingSet;

/// A frame and the loads that were on it.
pub(super) struct Known {
    pub(super) counts: Frame<Counts>,
    pub(super) truth: Frame<Newtons>,
}

/// A way from counts to loads.
pub(super) struct Candidate {
    pub(super) name: String,
    /// Presses it learnt from.
    pub(super) learnt_from: usize,
    /// For whole frames, where it can.
    pub(super) pipeline: Option<Pipeline>,
    /// With its held-out presses.
    pub(super) scores: Scores,
    /// What there is to say of it.
    pub(super) note: String,
}

/// Presses with frames that a calibration needs at least.
const MIN_FOR_PHYSICS: usize = 8;

/// What every candidate is given.
struct Ring<'a> {
    args: &'a Args,
    sensor: Sensor,
    training_set: &'a TrainingSet,
    split: &'a Split,
    /// Presses to learn from that have frames, and those to judge by.
    known: Vec<usize>,
    judged: Vec<usize>,
}

/// All that were not left out.
pub(super) fn all(
    args: &Args,
    sensor: &Sensor,
    training_set: &TrainingSet,
    split: &Split,
    show: &mut dyn FnMut(&str, f64),
) -> Result<Vec<Candidate>, Error> {
    let frames = training_set.data.presses.len();
    // After Ctrl-C nobody's turn comes: what has begun is thrown away.
    let wanted =
        |name: &str| !interrupt::asked() && !args.without.iter().any(|without| without == name);
    let with_frames =
        |which: &[usize]| -> Vec<usize> { which.iter().copied().filter(|&i| i < frames).collect() };
    let mut known = with_frames(&[&split.train[..], &split.check].concat());
    known.sort_unstable();
    let physics = frames > 0 && (wanted("exact") || wanted("hybrid"));
    let mut ring = Ring {
        args,
        sensor: sensor.clone(),
        training_set,
        split,
        known,
        judged: with_frames(&split.test),
    };
    let mut calibrated = None;
    if physics && ring.known.len() < MIN_FOR_PHYSICS {
        out::warn(&format!(
            "exact and hybrid left out: {} of the presses to learn from have whole frames, and a calibration needs {MIN_FOR_PHYSICS}",
            ring.known.len()
        ));
    } else if physics {
        show("exact", 0.0);
        let found = ring.calibrate(show)?;
        // Faulty lines are nobody's to estimate.
        ring.sensor = ring
            .sensor
            .edited(|spec| spec.screen = found.screen().clone())?;
        calibrated = Some(found);
    }
    let mut all = Vec::new();
    if frames > 0 {
        for name in ["none", "one curve"] {
            if wanted(name) {
                all.push(ring.curve(name)?);
            }
        }
    }
    for name in ["paper-mlp", "row-set"] {
        if wanted(name) {
            show(name, 0.4);
            all.push(ring.network(name, false)?);
        }
    }
    if args.leaky && !interrupt::asked() {
        show("paper-mlp, leaky", 0.6);
        all.push(ring.network("paper-mlp", true)?);
    }
    if let Some(calibrated) = calibrated {
        if wanted("exact") {
            let pipeline = Pipeline::new(&calibrated, default_method(&calibrated)?)?;
            all.push(ring.with_frames("exact", pipeline, String::new())?);
        }
        if wanted("hybrid") {
            show("hybrid", 0.9);
            all.push(ring.hybrid(&calibrated)?);
        }
    }
    Ok(all)
}

impl Ring<'_> {
    fn presses(&self, which: &[usize]) -> Vec<PressLabel> {
        which
            .iter()
            .map(|&i| self.training_set.data.presses[i])
            .collect()
    }

    /// Judges on held-out presses that have frames, and keeps the pipeline for whole frames.
    fn with_frames(
        &self,
        name: &str,
        mut pipeline: Pipeline,
        note: String,
    ) -> Result<Candidate, Error> {
        let mut scores = Scores::default();
        for press in self.presses(&self.judged) {
            pipeline.begin_anew();
            let result = pipeline.process(&self.training_set.data.frames[press.frame]);
            let at = press.row * self.sensor.columns() + press.column;
            scores.add_press(grams(result.newtons()?.values()[at]), press.load_g);
        }
        pipeline.begin_anew();
        Ok(Candidate {
            name: name.to_owned(),
            learnt_from: self.known.len(),
            pipeline: Some(pipeline),
            scores,
            note,
        })
    }

    /// A load law on readings as they are: a straight line, or the best that held-out presses find.
    fn curve(&self, name: &str) -> Result<Candidate, Error> {
        let raw = Raw::from_sensor(&self.sensor);
        let mut pipeline = Pipeline::new(&self.sensor, Box::new(raw.clone()))?;
        let mut pairs = Vec::new();
        for press in self.presses(&self.known) {
            let result = pipeline.process(&self.training_set.data.frames[press.frame]);
            pairs.push((
                result.siemens.expect("solved").at(press.row, press.column),
                press.load_g,
            ));
        }
        let law = match name {
            "none" => straight(&pairs),
            _ => fit_pairs(&pairs)
                .into_iter()
                .next()
                .map_or_else(|| straight(&pairs), |fit| fit.law),
        };
        let sensor = self.sensor.edited(|spec| {
            spec.material = Some(law.to_material());
            spec.check = None;
        })?;
        let pipeline = Pipeline::new(&sensor, Box::new(raw))?;
        self.with_frames(name, pipeline, String::new())
    }

    fn calibrate(&self, show: &mut dyn FnMut(&str, f64)) -> Result<Sensor, Error> {
        let data = CalibrationData {
            frames: self.training_set.data.frames.clone(),
            presses: self.presses(&self.known),
            uniform: self.training_set.data.uniform.clone(),
        };
        let options = CalibrationOptions::default();
        let found = calibrate_with(&self.sensor, &data, &options, &Threads, &mut |_, share| {
            show("exact", 0.3 * share);
        });
        Ok(found
            .map_err(|source| taxel_app::Error::InFile {
                file: self.args.from.presses.clone().unwrap_or_default(),
                source,
            })?
            .sensor)
    }

    fn network(&self, name: &str, leaky: bool) -> Result<Candidate, Error> {
        let (rows, split) = if leaky {
            fit::room_for(&self.training_set.rows, self.args.copies as usize)?;
            leaky_rows(
                &self.training_set.rows,
                self.split,
                self.args.copies as usize,
            )
        } else {
            (self.training_set.rows.clone(), self.split.clone())
        };
        let training_data = TrainingData {
            sensor: &self.sensor,
            rows: &rows,
            split: &split,
            sources: Vec::new(),
        };
        let model = self.train(name, leaky, &training_data)?;
        let judged = rows.part(&split.test);
        let estimates = match &model.kind {
            ModelKind::PaperMlp(model) => model.estimate(&judged),
            ModelKind::RowSet(members) => fit::mean_estimate(members, &judged),
            _ => Vec::new(),
        };
        let mut scores = Scores::default();
        for (estimate, load) in estimates.into_iter().zip(&judged.load_g) {
            scores.add_press(estimate, f64::from(*load));
        }
        let learnt_from = self.split.train.len() + self.split.check.len();
        let note = format!(
            "interval of {:.0} % covers {:.0} % of the held-out presses",
            100.0 * model.card.interval.level,
            100.0 * model.card.held_out.coverage
        );
        Ok(Candidate {
            name: if leaky {
                format!("{name}, leaky split")
            } else {
                name.to_owned()
            },
            learnt_from,
            // What the leaky split says is wrong; what the network does with frames is the same.
            pipeline: if leaky {
                None
            } else {
                Some(self.pipeline(model)?)
            },
            scores,
            note,
        })
    }

    fn train(&self, name: &str, leaky: bool, data: &TrainingData) -> Result<Model, Error> {
        if name == "paper-mlp" {
            let mut settings = Settings::default();
            settings.epochs = self.args.epochs as usize;
            settings.seed = self.args.seed;
            let copies = if leaky { 1 } else { self.args.copies as usize };
            let model = fit::paper_mlp(data, &settings, &HIDDEN, copies, None, &mut |_, _| go());
            return Ok(model?);
        }
        let mut settings = fit::row_set_settings();
        settings.seed = self.args.seed;
        let members = fit::MEMBERS;
        Ok(fit::row_set(
            data,
            &settings,
            members,
            &Threads,
            &|_, _, _| go(),
        )?)
    }

    fn pipeline(&self, model: Model) -> Result<Pipeline, Error> {
        let learned = Learned::new(model, &self.sensor)?;
        Ok(Pipeline::with_estimator(&self.sensor, Box::new(learned)))
    }

    fn hybrid(&self, calibrated: &Sensor) -> Result<Candidate, Error> {
        let presses = self.presses(&self.known);
        let rows = self.training_set.rows.part(&self.known);
        let split = Split {
            train: (0..presses.len()).collect(),
            ..Split::default()
        };
        let training_data = TrainingData {
            sensor: calibrated,
            rows: &rows,
            split: &split,
            sources: Vec::new(),
        };
        let frames = &self.training_set.data.frames;
        let model = fit::hybrid(
            &training_data,
            frames,
            &presses,
            self.args.seed,
            &mut |_| go(),
        )?;
        let note = model
            .card
            .verdict
            .as_ref()
            .map_or(String::new(), |verdict| {
                let used = if verdict.used { "used" } else { "not used" };
                format!(
                    "network {used}: cross-validation {:.3} g to {:.3} g ({:.1} standard errors)",
                    verdict.physics_g, verdict.hybrid_g, verdict.standard_errors
                )
            });
        let learned = Box::new(Learned::new(model, calibrated)?);
        let pipeline = Pipeline::with_estimator(calibrated, learned);
        self.with_frames("hybrid", pipeline, note)
    }
}

fn go() -> ControlFlow<()> {
    if interrupt::asked() {
        ControlFlow::Break(())
    } else {
        ControlFlow::Continue(())
    }
}

/// A straight line through no load and the presses: the median of conductance over load.
fn straight(pairs: &[(f64, f64)]) -> LoadLaw {
    let slopes = pairs
        .iter()
        .filter(|(g, load)| *g > 0.0 && *load > 0.0)
        .map(|(g, load)| g / load);
    LoadLaw::power(0.0, median(slopes).unwrap_or(1e-6), 1.0)
}

/// The paper's split: copies of every press are made first, then split as if they were presses of their own.
fn leaky_rows(rows: &Rows, split: &Split, copies: usize) -> (Rows, Split) {
    let which: Vec<usize> = [&split.train[..], &split.check, &split.test].concat();
    let copied = rows.part(&which).shuffled_copies(copies, 1);
    let count = copied.len();
    let share = |part: &[usize]| part.len() as f64 / which.len().max(1) as f64;
    let split = Split::new(count, share(&split.check), share(&split.test), 1);
    (copied, split)
}
