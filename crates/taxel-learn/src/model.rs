//! A trained model: what it computes, and the card that says what it is.

use std::path::Path;

use sha2::{Digest, Sha256};
use taxel::Sensor;
use taxel::material::LoadLaw;
use taxel::stats::{mean, quantile, standard_error};

use crate::models::hybrid::{CvResult, Hybrid, Member, Typical};
use crate::models::paper_mlp::PaperMlp;
use crate::models::row_set::{RowFeatures, RowSet};
use crate::network::Mlp;
use crate::rows::Split;
use crate::scaler::Scaler;
use crate::tensors::{self, Tensor};
use crate::train::{Epoch, Settings};
use crate::trust::{Familiar, Interval};
use crate::{Error, Malformed};

/// What a model computes with.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum ModelKind {
    /// The paper's network.
    PaperMlp(PaperMlp),
    /// The mean of a few row sets.
    RowSet(Vec<RowSet>),
    /// The exact inverse, then a network on what is left.
    Hybrid(Hybrid),
}

impl ModelKind {
    /// The word for it.
    pub fn name(&self) -> &'static str {
        match self {
            ModelKind::PaperMlp(_) => "paper-mlp",
            ModelKind::RowSet(_) => "row-set",
            ModelKind::Hybrid(_) => "hybrid",
        }
    }
}

/// Errors on presses that no choice was made with.
#[derive(Debug, Clone, Copy, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct TestErrors {
    /// Presses.
    pub presses: usize,
    /// Mean absolute error, grams.
    pub mean_absolute_g: f64,
    /// Its standard error over presses, grams.
    pub standard_error_g: f64,
    /// Root mean square error, grams.
    pub root_mean_square_g: f64,
    /// Error that 95 % of the presses stay below, grams.
    pub p95_g: f64,
    /// Share of presses inside the interval.
    pub coverage: f64,
}

impl TestErrors {
    /// Of estimates (clipped at zero) and true loads, grams.
    pub fn new(estimates: &[f64], loads: &[f64], interval: &Interval) -> Self {
        let errors: Vec<f64> = estimates
            .iter()
            .zip(loads)
            .map(|(e, l)| (e.max(0.0) - l).abs())
            .collect();
        if errors.is_empty() {
            return Self::default();
        }
        let square = mean(errors.iter().map(|e| e * e));
        Self {
            presses: loads.len(),
            mean_absolute_g: mean(errors.iter().copied()).unwrap_or(0.0),
            standard_error_g: standard_error(&errors).unwrap_or(0.0),
            root_mean_square_g: square.unwrap_or(0.0).sqrt(),
            p95_g: quantile(errors, 0.95).unwrap_or(0.0),
            coverage: interval.coverage(estimates, loads),
        }
    }
}

/// A file that a model learnt from.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Source {
    /// Its name.
    pub name: String,
    /// SHA-256 of its content, hexadecimal; of models of version 0.1.0 and before it FNV-1a, 16 digits.
    pub fingerprint: String,
    /// Presses from it.
    pub presses: usize,
}

impl Source {
    /// The fingerprint of some bytes.
    pub fn fingerprint(bytes: &[u8]) -> String {
        let hash = Sha256::digest(bytes);
        hash.iter().map(|byte| format!("{byte:02x}")).collect()
    }
}

/// What a model is, what it was trained with, how good it is, and what it must not be used for.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Card {
    /// 1.
    pub format: u32,
    /// `paper-mlp`, `row-set` or `hybrid`.
    pub kind: String,
    /// Of the program that wrote it.
    pub program_version: String,
    /// Widths of every network, and whether its last layer has a ReLU.
    pub networks: Vec<(Vec<usize>, bool)>,
    /// Standardisation of inputs, one for each network (the row set: one for each pair).
    pub scalers: Vec<Scaler>,
    /// How row sets see readings.
    pub eyes: Vec<RowFeatures>,
    /// The sensor file, whole.
    pub sensor: String,
    /// Readings below this are no load, counts.
    pub threshold_counts: f64,
    /// What it learnt from.
    pub sources: Vec<Source>,
    /// Which presses were for what, in the order of the sources.
    pub split: Split,
    /// How it was trained.
    pub settings: Settings,
    /// Shuffled copies of each press.
    pub copies: usize,
    /// The last epoch of each network.
    pub epochs: Vec<Epoch>,
    /// How far to trust a load.
    pub interval: Interval,
    /// What inputs it knows.
    pub familiar: Familiar,
    /// Errors on presses that no choice was made with.
    pub held_out: TestErrors,
    /// The error that a hybrid's physics typically has, as each of its networks knows it.
    #[serde(default)]
    pub typicals: Vec<Typical>,
    /// What the cross-validation said of a hybrid.
    pub verdict: Option<CvResult>,
    /// What it must not be used for.
    pub not_for: Vec<String>,
}

/// A model with its card.
#[derive(Debug, Clone, PartialEq)]
pub struct Model {
    /// What it is.
    pub card: Card,
    /// What it computes with.
    pub kind: ModelKind,
}

/// What every card says.
pub const NOT_FOR: [&str; 3] = [
    "another sensor than the one it was trained on, or the same after a change of parts or material",
    "loads beyond those of its training presses: such estimates are marked unfamiliar",
    "diagnosis or any decision about a person",
];

impl Model {
    /// The sensor it was trained for, with a linear law of 1 µS a gram where none is known.
    ///
    /// # Errors
    /// A card whose sensor file is broken.
    pub fn sensor(&self) -> Result<Sensor, Error> {
        Ok(with_law(Sensor::from_toml(&self.card.sensor)?))
    }

    /// The networks, in the order of the file.
    fn networks(&self) -> Vec<&Mlp> {
        match &self.kind {
            ModelKind::PaperMlp(model) => vec![&model.network],
            ModelKind::RowSet(members) => members.iter().flat_map(|m| [&m.phi, &m.rho]).collect(),
            ModelKind::Hybrid(model) => model.members.iter().map(|m| &m.network).collect(),
        }
    }

    /// Brings the card's description of the networks up to date.
    pub fn describe(&mut self) {
        self.card.kind = self.kind.name().to_owned();
        self.card.networks = self
            .networks()
            .iter()
            .map(|n| (n.widths().to_vec(), n.relu_last()))
            .collect();
        self.card.typicals = match &self.kind {
            ModelKind::Hybrid(model) => model.members.iter().map(|m| m.typical).collect(),
            _ => Vec::new(),
        };
        (self.card.scalers, self.card.eyes) = match &self.kind {
            ModelKind::PaperMlp(model) => (vec![model.scaler.clone()], Vec::new()),
            ModelKind::RowSet(members) => members.iter().map(|m| (m.scaler.clone(), m.eye)).unzip(),
            ModelKind::Hybrid(model) => {
                let scalers = model.members.iter().map(|m| m.scaler.clone());
                (scalers.collect(), Vec::new())
            }
        };
    }

    /// The file: safetensors, with the card as JSON under `card`.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut all: Vec<Tensor> = Vec::new();
        for (i, network) in self.networks().into_iter().enumerate() {
            for layer in 0..network.layers() {
                let (weights, biases) = network.layer(layer);
                let widths = &network.widths()[layer..layer + 2];
                let name = format!("network.{i}.layer.{layer}");
                all.push((format!("{name}.weight"), widths.to_vec(), weights));
                all.push((format!("{name}.bias"), vec![widths[1]], biases));
            }
        }
        let card = serde_json::to_string(&self.card).expect("a card is plain data");
        tensors::to_bytes(&all, "card", card)
    }

    /// Reads a model file.
    ///
    /// # Errors
    /// A file that cannot be read, is no safetensors file, has no card, or whose tensors do not fit the card.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let bytes = tensors::read_file(path)?;
        Self::from_bytes(&bytes).map_err(|reason| Error::NotAModel {
            file: path.to_owned(),
            reason: reason.to_string(),
        })
    }

    /// A model from the bytes of its file.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, Malformed> {
        Self::parse(bytes).map_err(Malformed)
    }

    fn parse(bytes: &[u8]) -> Result<Self, String> {
        let (tensors, card) = tensors::from_bytes(bytes, "card")?;
        let card = card.ok_or("a safetensors file without a card")?;
        let card: Card = serde_json::from_str(&card).map_err(|error| {
            let why = tensors::shortened(&error.to_string());
            format!("its card cannot be read ({why})")
        })?;
        if card.format != 1 {
            return Err(format!("format {}, but this program reads 1", card.format));
        }
        let mut networks = Vec::new();
        for (i, (widths, relu_last)) in card.networks.iter().enumerate() {
            // Before memory is taken for it: a network is no larger than its file.
            let size = widths.windows(2).try_fold(0usize, |sum, w| {
                sum.checked_add(w[0].checked_add(1)?.checked_mul(w[1])?)
            });
            if widths.len() < 2 || widths.contains(&0) || size.is_none_or(|n| n > bytes.len() / 4) {
                return Err(format!("network {i} has widths {widths:?}"));
            }
            let mut network = Mlp::zeros(widths, *relu_last);
            for layer in 0..network.layers() {
                let (weights, biases) = network.layer_mut(layer);
                fill(
                    &tensors,
                    &format!("network.{i}.layer.{layer}.weight"),
                    weights,
                )?;
                fill(&tensors, &format!("network.{i}.layer.{layer}.bias"), biases)?;
            }
            networks.push(network);
        }
        let kind = assemble(&card, networks)?;
        Ok(Self { card, kind })
    }
}

/// A sensor with a linear law of 1 µS a gram where none is known: for a hybrid to correct, and to show raw readings
/// beside loads.
pub fn with_law(sensor: Sensor) -> Sensor {
    if sensor.material().is_some() {
        return sensor;
    }
    let law = LoadLaw::power(0.0, 1e-6, 1.0).to_material();
    let with_law = sensor.edited(|spec| spec.material = Some(law));
    with_law.expect("a microsiemens a gram is a law")
}

fn fill(tensors: &safetensors::SafeTensors, name: &str, values: &mut [f32]) -> Result<(), String> {
    values.copy_from_slice(&tensors::numbers(tensors, name, Some(values.len()))?);
    Ok(())
}

/// The scaler of a card's network, which takes so many numbers.
fn scaler(card: &Card, at: usize, width: usize) -> Result<Scaler, String> {
    match card.scalers.get(at) {
        Some(s) if s.mean.len() == width && s.deviation.len() == width => {
            if s.deviation.iter().all(|&d| d != 0.0) {
                Ok(s.clone())
            } else {
                Err(format!("the scaler of network {at} divides by 0"))
            }
        }
        _ => Err(format!("no scaler of {width} numbers for network {at}")),
    }
}

/// Numbers that a network takes and gives.
fn widths(network: &Mlp) -> (usize, usize) {
    (
        network.widths()[0],
        network.widths().last().copied().unwrap_or(0),
    )
}

fn assemble(card: &Card, networks: Vec<Mlp>) -> Result<ModelKind, String> {
    match card.kind.as_str() {
        "paper-mlp" => {
            let [network] = <[Mlp; 1]>::try_from(networks)
                .map_err(|n| format!("a paper-mlp has 1 network, not {}", n.len()))?;
            if network.widths()[0] < 2 || widths(&network).1 != 1 {
                return Err(format!("a paper-mlp of widths {:?}", network.widths()));
            }
            let scaler = scaler(card, 0, network.widths()[0])?;
            Ok(ModelKind::PaperMlp(PaperMlp { network, scaler }))
        }
        "row-set" => assemble_row_set(card, networks),
        "hybrid" => assemble_hybrid(card, networks),
        other => Err(format!(
            "an unknown kind of model, `{}`",
            tensors::shortened(other)
        )),
    }
}

fn assemble_row_set(card: &Card, networks: Vec<Mlp>) -> Result<ModelKind, String> {
    let mut members = Vec::new();
    let mut networks = networks.into_iter();
    while let (Some(phi), Some(rho)) = (networks.next(), networks.next()) {
        let at = members.len();
        let member = RowSet {
            eye: *card.eyes.get(at).ok_or("a row-set without its eye")?,
            scaler: scaler(card, at, rho.widths()[0])?,
            phi,
            rho,
        };
        member.check().map_err(|bad| bad.to_string())?;
        members.push(member);
    }
    if members.is_empty() {
        return Err("a row-set without networks".to_owned());
    }
    Ok(ModelKind::RowSet(members))
}

fn assemble_hybrid(card: &Card, networks: Vec<Mlp>) -> Result<ModelKind, String> {
    let features = crate::models::hybrid::FEATURES;
    if let Some(odd) = networks.iter().find(|n| widths(n) != (features, 1)) {
        return Err(format!("a hybrid of widths {:?}", odd.widths()));
    }
    let members = networks.into_iter().enumerate().map(|(at, network)| {
        let typical = card
            .typicals
            .get(at)
            .ok_or("a hybrid of a former version, whose interval was too narrow: train it again")?;
        Ok(Member {
            scaler: scaler(card, at, features)?,
            typical: *typical,
            network,
        })
    });
    Ok(ModelKind::Hybrid(Hybrid {
        members: members.collect::<Result<_, String>>()?,
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file with this card and no tensors.
    fn file(card: &str) -> Vec<u8> {
        tensors::to_bytes(&[], "card", card.to_owned())
    }

    #[test]
    fn a_fingerprint_is_the_sum_that_sha256sum_prints() {
        let abc = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(Source::fingerprint(b"abc"), abc);
    }

    #[test]
    fn a_network_larger_than_its_file_is_refused_before_memory_is_taken() {
        let rows = {
            let mut rows = crate::Rows::new(4);
            (0..20).for_each(|i| rows.push(f64::from(i), [1.0, 2.0, 3.0, f64::from(i)], 5.0));
            rows
        };
        let split = Split::new(20, 0.2, 0.2, 1);
        let sensor = taxel::sensor::preset("mat-16x16-cd4067").unwrap();
        let training_data = crate::fit::TrainingData {
            sensor: &sensor,
            rows: &rows,
            split: &split,
            sources: Vec::new(),
        };
        let network = PaperMlp {
            network: Mlp::zeros(&[5, 3, 1], false),
            scaler: Scaler::none(5),
        };
        let model = crate::fit::adopt(&training_data, network).unwrap();
        assert_eq!(Model::from_bytes(&model.to_bytes()).unwrap(), model);
        let mut card = model.card.clone();
        for widths in [
            vec![5, 1 << 40, 1],
            vec![usize::MAX, usize::MAX],
            vec![5],
            vec![],
        ] {
            card.networks = vec![(widths, false)];
            let error = Model::from_bytes(&file(&serde_json::to_string(&card).unwrap()));
            assert!(
                error
                    .unwrap_err()
                    .to_string()
                    .contains("network 0 has widths")
            );
        }
        // A network for 4 columns on a sensor of 16.
        let error = crate::Learned::new(model, &sensor).err().unwrap();
        assert!(error.to_string().contains("4 values a row"), "{error}");
    }
}
