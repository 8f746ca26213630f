//! From labelled presses to a model with its card.

use std::ops::ControlFlow;

use taxel::calibrate::PressLabel;
use taxel::material::LoadLaw;
use taxel::parallel::{Executor, par_map};
use taxel::pipeline::Pipeline;
use taxel::solve::default_method;
use taxel::stats::quantile;
use taxel::{Counts, Frame, Sensor};

use crate::model::{Card, Model, ModelKind, NOT_FOR, Source, TestErrors};
use crate::models::hybrid::{Example, FrameFeatures, Hybrid, MIN_G, Physics, Trained};
use crate::models::paper_mlp::{PaperMlp, PaperTraining};
use crate::models::row_set::{RowSet, RowSetTraining};
use crate::network::AdamSettings;
use crate::rows::{Rows, Split};
use crate::train::{Checkpoint, Epoch, EpochWatch, Settings, Trainable, train};
use crate::trust::{Familiar, Interval};
use crate::{Error, with_law};

/// Share of presses that an interval is to cover.
pub const LEVEL: f64 = 0.9;
/// Row sets whose mean is taken.
pub const MEMBERS: usize = 3;
/// Fewest presses to learn from: what is left of [`crate::rows::MIN_PRESSES`] when the usual shares are taken off.
const MIN_TO_LEARN: usize = 4;
/// Most memory that the copies of the presses may take, bytes.
const MAX_COPIES_BYTES: usize = 2 << 30;
/// Parts that a hybrid is cross-validated in.
const FOLDS: usize = 5;
/// Epochs of a hybrid's networks.
const HYBRID_EPOCHS: usize = 300;

/// What a model is trained with.
pub struct TrainingData<'a> {
    /// The sensor, as far as it is known.
    pub sensor: &'a Sensor,
    /// Presses, as rows of readings.
    pub rows: &'a Rows,
    /// Which are for what.
    pub split: &'a Split,
    /// Where they come from.
    pub sources: Vec<Source>,
}

/// Told of every epoch: which network, of how many, and how it went; may say stop. Called from any thread.
pub type Watch<'a> = &'a (dyn Fn(usize, usize, &Epoch) -> ControlFlow<()> + Sync);

/// How row sets are trained: longer than it seems to pay, with a falling rate.
pub fn row_set_settings() -> Settings {
    Settings {
        epochs: 400,
        batch: 64,
        l2: 1e-5,
        patience: 400,
        tolerance: 0.0,
        stop_by_loss: false,
        anneal: true,
        seed: 1,
        adam: AdamSettings {
            rate: 2e-3,
            ..AdamSettings::default()
        },
    }
}

/// Trains the paper's network.
///
/// # Errors
/// A split that leaves nothing to learn from or to stop by, more copies than memory, a checkpoint of another network.
pub fn paper_mlp(
    training_data: &TrainingData,
    settings: &Settings,
    hidden: &[usize],
    copies: usize,
    from: Option<&Checkpoint>,
    watch: &mut EpochWatch<'_>,
) -> Result<Model, Error> {
    let (train_on, check) = training_data.parts()?;
    room_for(&train_on, copies)?;
    let mut training = PaperTraining::new(&train_on, &check, hidden, copies, settings.seed);
    if let Some(from) = from {
        let sizes = training.networks();
        from.check(
            &sizes
                .iter()
                .map(|n| n.parameters().len())
                .collect::<Vec<_>>(),
        )?;
    }
    let history = train(&mut training, settings, from, watch);
    let model = training.finish();
    let tested = training_data.test(|rows| model.estimate(rows));
    let mut card = training_data.card(settings, copies, tested);
    card.epochs = history.last().copied().into_iter().collect();
    Ok(finish(card, ModelKind::PaperMlp(model)))
}

/// A network that was trained elsewhere, with a card: presses that it was not trained with set its threshold and its
/// interval, and judge it.
///
/// # Errors
/// A network for another number of columns.
pub fn adopt(training_data: &TrainingData, model: PaperMlp) -> Result<Model, Error> {
    if model.columns() != training_data.rows.columns {
        return Err(Error::Width {
            what: "the network".to_owned(),
            found: model.columns(),
            expected: training_data.rows.columns,
        });
    }
    let tested = training_data.test(|rows| model.estimate(rows));
    let card = training_data.card(&Settings::default(), 0, tested);
    Ok(finish(card, ModelKind::PaperMlp(model)))
}

/// Refuses copies that memory has no room for.
///
/// # Errors
/// [`Error::Copies`] with the numbers.
pub fn room_for(rows: &Rows, copies: usize) -> Result<(), Error> {
    let values = rows.columns + 2;
    let bytes = [copies, values, size_of::<f32>()]
        .into_iter()
        .fold(rows.len(), usize::saturating_mul);
    if bytes > MAX_COPIES_BYTES {
        Err(Error::Copies {
            presses: rows.len(),
            copies,
            values,
            found: bytes as u64 >> 20,
            most: MAX_COPIES_BYTES as u64 >> 20,
        })
    } else {
        Ok(())
    }
}

/// Trains `members` row sets, shared out to the executor.
///
/// # Errors
/// A split that leaves nothing to learn from or to stop by.
pub fn row_set(
    training_data: &TrainingData,
    settings: &Settings,
    members: usize,
    executor: &dyn Executor,
    watch: Watch,
) -> Result<Model, Error> {
    let (train_on, check) = training_data.parts()?;
    let trained = par_map(executor, (0..members).collect(), |member| {
        let own = Settings {
            seed: settings.seed.wrapping_add(1000 * member as u64),
            ..settings.clone()
        };
        let mut training = RowSetTraining::new(&train_on, &check, own.seed);
        let history = train(&mut training, &own, None, &mut |epoch, _| {
            watch(member, members, epoch)
        });
        Some((training.finish(), history.last().copied()))
    })
    .unwrap_or_default();
    let (models, last): (Vec<RowSet>, Vec<Option<Epoch>>) = trained.into_iter().unzip();
    let tested = training_data.test(|rows| mean_estimate(&models, rows));
    let mut card = training_data.card(settings, 1, tested);
    card.epochs = last.into_iter().flatten().collect();
    Ok(finish(card, ModelKind::RowSet(models)))
}

/// The mean of what some row sets say of presses, grams, not clipped.
pub fn mean_estimate(models: &[RowSet], rows: &Rows) -> Vec<f64> {
    let mut mean = vec![0.0; rows.len()];
    for model in models {
        for (sum, load) in mean.iter_mut().zip(model.estimate(rows)) {
            *sum += load / models.len() as f64;
        }
    }
    mean
}

/// Trains the hybrid on presses with their whole frames. The sensor must be calibrated, on these presses or others (on
/// these, its dozen parameters have seen them: what that flatters is small beside a network's hundred).
/// Split parts `check` and `train` are both cross-validated over; `test` judges.
///
/// # Errors
/// A sensor that is not calibrated.
pub fn hybrid(
    training_data: &TrainingData,
    frames: &[Frame<Counts>],
    presses: &[PressLabel],
    seed: u64,
    progress: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> Result<Model, Error> {
    let sensor = with_law(training_data.sensor.clone());
    let examples = examples(&sensor, frames, presses)?;
    let mut known: Vec<usize> =
        [&training_data.split.train[..], &training_data.split.check].concat();
    known.sort_unstable();
    let known: Vec<Example> = known.iter().map(|&i| examples[i]).collect();
    let usable: Vec<Example> = known
        .iter()
        .filter(|e| e.physics_g >= MIN_G)
        .copied()
        .collect();
    let trained = Hybrid::train(&usable, FOLDS, HYBRID_EPOCHS, seed, progress);
    let interval = interval(&known, &trained);
    let model = trained.model;
    let estimate = |which: &[usize]| -> Vec<f64> {
        let features: Vec<_> = which.iter().map(|&i| examples[i].features).collect();
        let mut loads: Vec<f32> = which.iter().map(|&i| examples[i].physics_g).collect();
        model.correct(&features, &mut loads, &mut Default::default());
        loads.into_iter().map(f64::from).collect()
    };
    let loads = |which: &[usize]| -> Vec<f64> {
        which
            .iter()
            .map(|&i| f64::from(examples[i].load_g))
            .collect()
    };
    let settings = Settings {
        epochs: HYBRID_EPOCHS,
        seed,
        ..Settings::default()
    };
    let test = &training_data.split.test;
    let held_out = TestErrors::new(&estimate(test), &loads(test), &interval);
    let mut card = training_data.card(&settings, 1, (interval, held_out));
    card.threshold_counts = 0.0;
    card.verdict = Some(trained.verdict);
    card.epochs = trained.epochs;
    Ok(finish(card, ModelKind::Hybrid(model)))
}

/// The hybrid's interval, set by estimates of networks that did not know the press (nor its frame), not by those of the
/// networks trained with it: cross-validation+ (Barber, Candès, Ramdas and Tibshirani, *Predictive inference with the
/// jackknife+*, 2021) with the mean of the networks in place of each. Loads too small to correct, and all of them where
/// the networks are not used, are the physics'.
fn interval(known: &[Example], trained: &Trained) -> Interval {
    let mut out_of_fold = trained.out_of_fold_g.iter();
    let (mut estimates, mut loads) = (Vec::new(), Vec::new());
    for example in known {
        let apart = if example.physics_g >= MIN_G {
            out_of_fold.next().copied().flatten()
        } else {
            Some(example.physics_g)
        };
        let estimate = if trained.verdict.used {
            apart
        } else {
            Some(example.physics_g)
        };
        if let Some(estimate) = estimate {
            estimates.push(f64::from(estimate));
            loads.push(f64::from(example.load_g));
        }
    }
    Interval::fit(LEVEL, &estimates, &loads)
}

/// What the hybrid sees of every press.
fn examples(
    sensor: &Sensor,
    frames: &[Frame<Counts>],
    presses: &[PressLabel],
) -> Result<Vec<Example>, Error> {
    let law = LoadLaw::from_sensor(sensor)?;
    let physics = Physics::of(sensor, &law);
    let mut pipeline = Pipeline::new(sensor, default_method(sensor)?)?;
    let mut frame_features = FrameFeatures::default();
    let mut examples = Vec::with_capacity(presses.len());
    for press in presses {
        pipeline.begin_anew();
        frame_features.look(pipeline.process(&frames[press.frame]))?;
        examples.push(Example {
            features: frame_features.features(press.row, press.column, &physics),
            physics_g: frame_features.loads_g[press.row * sensor.columns() + press.column],
            load_g: press.load_g as f32,
            frame: press.frame,
        });
    }
    Ok(examples)
}

fn finish(card: Card, kind: ModelKind) -> Model {
    let mut model = Model { card, kind };
    model.describe();
    model
}

impl TrainingData<'_> {
    fn parts(&self) -> Result<(Rows, Rows), Error> {
        let (train, check) = (self.split.train.len(), self.split.check.len());
        if train < MIN_TO_LEARN || check == 0 {
            return Err(Error::Split {
                presses: train + check + self.split.test.len(),
                train,
                check,
                needed: MIN_TO_LEARN,
            });
        }
        Ok((
            self.rows.part(&self.split.train),
            self.rows.part(&self.split.check),
        ))
    }

    /// The interval that the presses to stop by set, and the errors on those to judge by.
    fn test(&self, estimate: impl Fn(&Rows) -> Vec<f64>) -> (Interval, TestErrors) {
        let doubles = |values: &[f32]| -> Vec<f64> { values.iter().map(|&v| v.into()).collect() };
        let check = self.rows.part(&self.split.check);
        let test = self.rows.part(&self.split.test);
        let interval = Interval::fit(LEVEL, &estimate(&check), &doubles(&check.load_g));
        let held_out = TestErrors::new(&estimate(&test), &doubles(&test.load_g), &interval);
        (interval, held_out)
    }

    fn card(
        &self,
        settings: &Settings,
        copies: usize,
        (interval, held_out): (Interval, TestErrors),
    ) -> Card {
        let familiar = Familiar::fit(self.rows);
        Card {
            format: 1,
            kind: String::new(),
            program_version: env!("CARGO_PKG_VERSION").to_owned(),
            networks: Vec::new(),
            scalers: Vec::new(),
            eyes: Vec::new(),
            sensor: self.sensor.to_toml(),
            threshold_counts: threshold(self.rows, f64::from(familiar.dark_counts)),
            sources: self.sources.clone(),
            split: self.split.clone(),
            settings: settings.clone(),
            copies,
            epochs: Vec::new(),
            held_out,
            interval,
            familiar,
            typicals: Vec::new(),
            verdict: None,
            not_for: NOT_FOR.iter().map(|&text| text.to_owned()).collect(),
        }
    }
}

/// A quarter of the way from an unpressed taxel's reading to that of the least loads labelled (their first
/// percentile), counts: below it a reading is none.
fn threshold(rows: &Rows, dark: f64) -> f64 {
    let pressed: Vec<f64> = rows
        .taxel
        .iter()
        .zip(&rows.load_g)
        .filter(|(_, load)| **load > 1.0)
        .map(|(&taxel, _)| f64::from(taxel))
        .collect();
    match quantile(pressed, 0.01) {
        Some(least) => dark + 0.25 * (least - dark).max(0.0),
        None => dark,
    }
}
