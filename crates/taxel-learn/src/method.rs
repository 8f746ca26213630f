//! A trained model where a physical inverse would stand: the same trait.

use taxel::circuit::Converter;
use taxel::material::LoadLaw;
use taxel::pipeline::Pipeline;
use taxel::solve::{Method, Outcome, Scratch, Stop, default_method};
use taxel::{Frame, Mark, Sensor, Siemens, Volts};

use crate::Error;
use crate::model::{Model, ModelKind, with_law};
use crate::models::hybrid::{FEATURES, FrameFeatures, HybridMemory, MIN_G, Physics};
use crate::models::paper_mlp::PaperMemory;
use crate::models::row_set::RowSetMemory;

/// A model as a [`Method`]: loads, carried as the conductances that the sensor's load law gives them.
pub struct Learned {
    model: Model,
    sensor: Sensor,
    converter: Converter,
    law: LoadLaw,
    physics: Option<Physics>,
}

struct Memory {
    counts: Vec<f32>,
    taxels: Vec<(usize, usize)>,
    loads: Vec<f32>,
    member: Vec<f32>,
    paper: PaperMemory,
    row_sets: Vec<RowSetMemory>,
    hybrid: HybridMemory,
    features: Vec<[f32; FEATURES]>,
    frame_features: FrameFeatures,
    pipeline: Option<Pipeline>,
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
        let sensor = with_law(sensor.clone());
        let law = LoadLaw::from_sensor(&sensor)?;
        let physics = match model.kind {
            ModelKind::Hybrid(_) => {
                // Tells of a missing circuit now, not at the first frame.
                default_method(&sensor)?;
                Some(Physics::of(&sensor, &law))
            }
            _ => None,
        };
        Ok(Self {
            converter: Converter::from_sensor(&sensor),
            model,
            law,
            physics,
            sensor,
        })
    }

    /// The model.
    pub fn model(&self) -> &Model {
        &self.model
    }

    fn pipeline(&self) -> Option<Pipeline> {
        self.physics.as_ref()?;
        let method = default_method(&self.sensor).ok()?;
        Pipeline::new(&self.sensor, method).ok()
    }

    /// Loads of the listed taxels by a network over rows, grams; `counts` are the frame's.
    fn by_rows(&self, memory: &mut Memory) {
        let columns = self.sensor.columns();
        memory.loads.clear();
        memory.loads.resize(memory.taxels.len(), 0.0);
        match &self.model.kind {
            ModelKind::PaperMlp(model) => {
                let loads = model.estimate_frame(&memory.counts, &memory.taxels, &mut memory.paper);
                memory.loads.copy_from_slice(loads);
            }
            ModelKind::RowSet(members) => {
                memory.row_sets.resize_with(members.len(), Default::default);
                for (member, own) in members.iter().zip(&mut memory.row_sets) {
                    let loads = member.estimate_frame(&memory.counts, columns, &memory.taxels, own);
                    for (sum, load) in memory.loads.iter_mut().zip(loads) {
                        *sum += load / members.len() as f32;
                    }
                }
            }
            ModelKind::Hybrid(_) => {}
        }
    }

    /// Loads of the listed taxels by the physics and the network on what is left, grams.
    fn by_physics(&self, volts: &Frame<Volts>, memory: &mut Memory) -> Outcome {
        let (ModelKind::Hybrid(hybrid), Some(physics)) = (&self.model.kind, &self.physics) else {
            return Outcome::new(Stop::Direct, 0, 0.0);
        };
        let Memory {
            pipeline: Some(pipeline),
            ..
        } = memory
        else {
            return Outcome::new(Stop::Stalled, 0, 0.0);
        };
        let result = pipeline.process_volts(volts);
        let outcome = result.outcome.clone();
        if memory.frame_features.look(result).is_err() {
            return Outcome::new(Stop::Stalled, 0, 0.0);
        }
        memory.taxels.clear();
        memory.features.clear();
        let columns = self.sensor.columns();
        for (at, &load) in memory.frame_features.loads_g.iter().enumerate() {
            if load >= MIN_G {
                memory.taxels.push((at / columns, at % columns));
            }
        }
        memory.member.clear();
        for &(row, column) in &memory.taxels {
            memory
                .features
                .push(memory.frame_features.features(row, column, physics));
            memory
                .member
                .push(memory.frame_features.loads_g[row * columns + column]);
        }
        hybrid.correct(&memory.features, &mut memory.member, &mut memory.hybrid);
        memory.loads.clone_from(&memory.frame_features.loads_g);
        for (&(row, column), &load) in memory.taxels.iter().zip(&memory.member) {
            memory.loads[row * columns + column] = load;
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
            ("readout.topology", readout.topology.name().to_owned()),
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

impl Method for Learned {
    fn name(&self) -> &'static str {
        self.model.kind.name()
    }

    fn gives_loads(&self) -> bool {
        true
    }

    fn scratch(&self) -> Scratch {
        Scratch::new(Memory {
            counts: Vec::new(),
            taxels: Vec::new(),
            loads: Vec::new(),
            member: Vec::new(),
            paper: PaperMemory::default(),
            row_sets: Vec::new(),
            hybrid: HybridMemory::default(),
            features: Vec::new(),
            frame_features: FrameFeatures::default(),
            pipeline: self.pipeline(),
        })
    }

    fn solve_into(
        &self,
        volts: &Frame<Volts>,
        siemens: &mut Frame<Siemens>,
        scratch: &mut Scratch,
    ) -> Outcome {
        let cold = scratch.take_cold();
        let memory: &mut Memory = scratch.get();
        if let (true, Some(pipeline)) = (cold, &mut memory.pipeline) {
            pipeline.begin_anew();
        }
        siemens.copy_meta_from(volts);
        let columns = self.sensor.columns();
        memory.counts.clear();
        let counts = |volts: f64| self.converter.count_from_volt(volts) as f32;
        memory
            .counts
            .extend(volts.values().iter().map(|&v| counts(v)));
        let outcome = match &self.model.kind {
            ModelKind::Hybrid(_) => {
                let outcome = self.by_physics(volts, memory);
                for (taxel, (g, &load)) in siemens
                    .values_mut()
                    .iter_mut()
                    .zip(&memory.loads)
                    .enumerate()
                {
                    *g = self.law.siemens_from_grams(taxel, f64::from(load));
                }
                outcome
            }
            _ => {
                let threshold = self.model.card.threshold_counts as f32;
                memory.taxels.clear();
                for (at, &count) in memory.counts.iter().enumerate() {
                    if count >= threshold {
                        memory.taxels.push((at / columns, at % columns));
                    }
                }
                self.by_rows(memory);
                siemens.values_mut().fill(self.law.g_zero);
                for (&(row, column), &load) in memory.taxels.iter().zip(&memory.loads) {
                    let at = row * columns + column;
                    let load = f64::from(load.max(0.0));
                    siemens.values_mut()[at] = self.law.siemens_from_grams(at, load);
                }
                Outcome::new(Stop::Direct, 0, 0.0)
            }
        };
        self.mark_unfamiliar(memory, siemens);
        outcome
    }
}

impl Learned {
    /// Marks estimates from inputs unlike those of the training.
    fn mark_unfamiliar(&self, memory: &Memory, siemens: &mut Frame<Siemens>) {
        if matches!(&self.model.kind, ModelKind::Hybrid(hybrid) if hybrid.members.is_empty()) {
            return;
        }
        let columns = self.sensor.columns();
        let familiar = &self.model.card.familiar;
        let mut row_seen = (usize::MAX, true);
        for &(row, column) in &memory.taxels {
            let at = row * columns + column;
            if row_seen.0 != row {
                let values = &memory.counts[row * columns..(row + 1) * columns];
                row_seen = (row, familiar.knows_row(values));
            }
            let known = row_seen.1 && familiar.knows_taxel(memory.counts[at]);
            let mark = &mut siemens.marks_mut()[at];
            if !known && *mark == Mark::Good {
                *mark = Mark::Unfamiliar;
            }
        }
    }
}
