//! A training that can go on after an interruption.

use std::path::Path;

use crate::Error;
use crate::tensors::{self, Tensor};
use crate::train::{Checkpoint, Epoch};

const PARTS: [&str; 4] = ["parameters", "means", "squares", "best"];

/// What a checkpoint says beside its tensors.
#[derive(serde::Serialize, serde::Deserialize)]
struct Header {
    /// What the training must be the same in: kind, seed, data, settings.
    training: String,
    epochs: Vec<Epoch>,
    steps: u64,
}

impl Checkpoint {
    /// The file: safetensors, with the history as JSON. `training` says what it is of.
    pub fn to_bytes(&self, training: &str) -> Vec<u8> {
        let header = Header {
            training: training.to_owned(),
            epochs: self.epochs.clone(),
            steps: self.steps,
        };
        let mut all: Vec<Tensor> = Vec::new();
        for (i, parts) in self.networks.iter().enumerate() {
            for (name, values) in PARTS.iter().zip(parts) {
                all.push((format!("network.{i}.{name}"), vec![values.len()], values));
            }
        }
        let json = serde_json::to_string(&header).expect("plain data");
        tensors::to_bytes(&all, "checkpoint", json)
    }

    /// Reads a checkpoint of the same training.
    ///
    /// # Errors
    /// A file that cannot be read, is none, or is of another training.
    pub fn read(path: &Path, training: &str) -> Result<Self, Error> {
        let bytes = std::fs::read(path).map_err(|source| Error::File {
            file: path.to_owned(),
            source,
        })?;
        let wrong = |reason: String| Error::NotAModel {
            file: path.to_owned(),
            reason,
        };
        let (tensors, header) = tensors::from_bytes(&bytes, "checkpoint").map_err(wrong)?;
        let header: Header = header
            .and_then(|json| serde_json::from_str(&json).ok())
            .ok_or_else(|| wrong("not a checkpoint".to_owned()))?;
        if header.training != training {
            return Err(wrong(format!(
                "a checkpoint of another training: {}, not {training}",
                header.training
            )));
        }
        let mut networks = Vec::new();
        while tensors
            .tensor(&format!("network.{}.parameters", networks.len()))
            .is_ok()
        {
            let mut parts: [Vec<f32>; 4] = Default::default();
            for (name, part) in PARTS.iter().zip(&mut parts) {
                let view = tensors
                    .tensor(&format!("network.{}.{name}", networks.len()))
                    .map_err(|e| wrong(e.to_string()))?;
                *part = view
                    .data()
                    .chunks_exact(4)
                    .map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]))
                    .collect();
            }
            networks.push(parts);
        }
        Ok(Self {
            epochs: header.epochs,
            networks,
            steps: header.steps,
        })
    }
}
