//! A trained model in a pipeline: loads straight from a scan.

use taxel::circuit::Converter;
use taxel::estimate::LoadEstimator;
use taxel::frame::newtons_from_grams;
use taxel::material::LoadLaw;
use taxel::pipeline::Pipeline;
use taxel::solve::{Outcome, Stop, default_method};
use taxel::{Frame, Mark, Newtons, Sensor, Volts};

use crate::Error;
use crate::model::{Model, ModelKind, with_law};
use crate::models::hybrid::{FEATURES, FrameFeatures, HybridScratch, MIN_G, Physics};
use crate::models::paper_mlp::PaperScratch;
use crate::models::row_set::RowSetScratch;

/// A model as a [`LoadEstimator`].
pub struct Learned {
    known: Known,
    buffers: Buffers,
    /// The physics that a hybrid corrects.
    pipeline: Option<Pipeline>,
}

/// What does not change from frame to frame.
struct Known {
    model: Model,
    columns: usize,
    converter: Converter,
    physics: Option<Physics>,
}

#[derive(Default)]
struct Buffers {
    counts: Vec<f32>,
    taxels: Vec<(usize, usize)>,
    loads: Vec<f32>,
    member: Vec<f32>,
    paper: PaperScratch,
    row_sets: Vec<RowSetScratch>,
    hybrid: HybridScratch,
    features: Vec<[f32; FEATURES]>,
    frame_features: FrameFeatures,
}

impl Learned {
    /// For frames of `sensor`, which must have the shape and the parts of the model's own. What a calibration finds
    /// (switches, gain, material) may differ.
    ///
    /// # Errors
    /// Another shape, read-out or converter; for a hybrid a sensor that is not calibrated.
    pub fn new(model: Model, sensor: &Sensor) -> Result<Self, Error> {
        let own = model.sensor()?;
        if (own.rows(), own.columns()) != (sensor.rows(), sensor.columns()) {
            return Err(Error::Shape {
                model: (own.rows(), own.columns()),
                sensor: (sensor.rows(), sensor.columns()),
            });
        }
        if let ModelKind::PaperMlp(network) = &model.kind
            && network.columns() != sensor.columns()
        {
            return Err(Error::Width {
                what: "the network".to_owned(),
                found: network.columns(),
                expected: sensor.columns(),
            });
        }
        same_parts(&own, sensor)?;
        let mut learned = Self {
            known: Known {
                columns: sensor.columns(),
                converter: Converter::from_sensor(sensor),
                physics: None,
                model,
            },
            buffers: Buffers::default(),
            pipeline: None,
        };
        if let ModelKind::Hybrid(_) = learned.known.model.kind {
            // As in training, the network corrects a law of its own where the sensor has none.
            let sensor = with_law(sensor.clone());
            learned.known.physics = Some(Physics::of(&sensor, &LoadLaw::from_sensor(&sensor)?));
            learned.pipeline = Some(Pipeline::new(&sensor, default_method(&sensor)?)?);
        }
        Ok(learned)
    }

    /// The model.
    pub fn model(&self) -> &Model {
        &self.known.model
    }
}

impl Known {
    /// Loads of the listed taxels by a network over rows, grams; `counts` are the frame's.
    fn by_rows(&self, buffers: &mut Buffers) {
        let columns = self.columns;
        buffers.loads.clear();
        buffers.loads.resize(buffers.taxels.len(), 0.0);
        match &self.model.kind {
            ModelKind::PaperMlp(model) => {
                let loads =
                    model.estimate_frame(&buffers.counts, &buffers.taxels, &mut buffers.paper);
                buffers.loads.copy_from_slice(loads);
            }
            ModelKind::RowSet(members) => {
                buffers
                    .row_sets
                    .resize_with(members.len(), Default::default);
                for (member, own) in members.iter().zip(&mut buffers.row_sets) {
                    let loads =
                        member.estimate_frame(&buffers.counts, columns, &buffers.taxels, own);
                    for (sum, load) in buffers.loads.iter_mut().zip(loads) {
                        *sum += load / members.len() as f32;
                    }
                }
            }
            ModelKind::Hybrid(_) => {}
        }
    }

    /// Loads of the listed taxels by the physics and the network on what is left, grams.
    fn by_physics(
        &self,
        volts: &Frame<Volts>,
        pipeline: &mut Pipeline,
        buffers: &mut Buffers,
    ) -> Outcome {
        let (ModelKind::Hybrid(hybrid), Some(physics)) = (&self.model.kind, &self.physics) else {
            return Outcome::new(Stop::Direct, 0, 0.0);
        };
        let result = pipeline.process_volts(volts);
        let outcome = result.outcome.clone();
        if buffers.frame_features.look(result).is_err() {
            return Outcome::new(Stop::Stalled, 0, 0.0);
        }
        buffers.taxels.clear();
        buffers.features.clear();
        let columns = self.columns;
        for (at, &load) in buffers.frame_features.loads_g.iter().enumerate() {
            if load >= MIN_G {
                buffers.taxels.push((at / columns, at % columns));
            }
        }
        buffers.member.clear();
        for &(row, column) in &buffers.taxels {
            buffers
                .features
                .push(buffers.frame_features.features(row, column, physics));
            buffers
                .member
                .push(buffers.frame_features.loads_g[row * columns + column]);
        }
        hybrid.correct(&buffers.features, &mut buffers.member, &mut buffers.hybrid);
        buffers.loads.clone_from(&buffers.frame_features.loads_g);
        for (&(row, column), &load) in buffers.taxels.iter().zip(&buffers.member) {
            buffers.loads[row * columns + column] = load;
        }
        outcome
    }
}

/// Refuses a sensor that reads the same loads as other counts, by what an owner knows of it.
fn same_parts(own: &Sensor, other: &Sensor) -> Result<(), Error> {
    let parts = |sensor: &Sensor| {
        let (readout, converter) = (sensor.readout(), sensor.converter());
        let number = |value: Option<f64>| value.map_or("absent".to_owned(), |v| v.to_string());
        [
            ("readout.topology", readout.words()),
            ("readout.v_test_volts", readout.v_test_volts.to_string()),
            ("readout.r_feedback_ohms", number(readout.r_feedback_ohms())),
            (
                "readout.r_pull_down_ohms",
                number(readout.r_pull_down_ohms()),
            ),
            ("converter.bits", converter.bits.to_string()),
            (
                "converter.full_scale_volts",
                converter.full_scale_volts.to_string(),
            ),
            ("converter.inverted", converter.inverted.to_string()),
        ]
    };
    let differs = parts(own)
        .into_iter()
        .zip(parts(other))
        .find(|(a, b)| a != b);
    match differs {
        Some(((key, model), (_, sensor))) => Err(Error::OtherSensor { key, model, sensor }),
        None => Ok(()),
    }
}

impl LoadEstimator for Learned {
    fn name(&self) -> &'static str {
        self.known.model.kind.name()
    }

    fn estimate_into(&mut self, volts: &Frame<Volts>, loads: &mut Frame<Newtons>) -> Outcome {
        let (known, buffers) = (&self.known, &mut self.buffers);
        loads.copy_meta_from(volts);
        buffers.counts.clear();
        let counts = |volts: f64| known.converter.count_from_volt(volts) as f32;
        buffers
            .counts
            .extend(volts.values().iter().map(|&v| counts(v)));
        let outcome = if let Some(pipeline) = &mut self.pipeline {
            let outcome = known.by_physics(volts, pipeline, buffers);
            for (load, &grams) in loads.values_mut().iter_mut().zip(&buffers.loads) {
                *load = newtons_from_grams(f64::from(grams));
            }
            outcome
        } else {
            let threshold = known.model.card.threshold_counts as f32;
            let columns = known.columns;
            buffers.taxels.clear();
            for (at, &count) in buffers.counts.iter().enumerate() {
                if count >= threshold {
                    buffers.taxels.push((at / columns, at % columns));
                }
            }
            known.by_rows(buffers);
            loads.values_mut().fill(0.0);
            for (&(row, column), &grams) in buffers.taxels.iter().zip(&buffers.loads) {
                let load = newtons_from_grams(f64::from(grams.max(0.0)));
                loads.values_mut()[row * columns + column] = load;
            }
            Outcome::new(Stop::Direct, 0, 0.0)
        };
        known.mark_unfamiliar(buffers, loads.marks_mut());
        outcome
    }

    fn forget(&mut self) {
        if let Some(pipeline) = &mut self.pipeline {
            pipeline.begin_anew();
        }
    }
}

impl Known {
    /// Marks estimates from inputs unlike those of the training.
    fn mark_unfamiliar(&self, buffers: &Buffers, marks: &mut [Mark]) {
        if matches!(&self.model.kind, ModelKind::Hybrid(hybrid) if hybrid.members.is_empty()) {
            return;
        }
        let columns = self.columns;
        let familiar = &self.model.card.familiar;
        let mut row_seen = (usize::MAX, true);
        for &(row, column) in &buffers.taxels {
            let at = row * columns + column;
            if row_seen.0 != row {
                let values = &buffers.counts[row * columns..(row + 1) * columns];
                row_seen = (row, familiar.knows_row(values));
            }
            let known = row_seen.1 && familiar.knows_taxel(buffers.counts[at]);
            if !known && marks[at] == Mark::Good {
                marks[at] = Mark::Unfamiliar;
            }
        }
    }
}
