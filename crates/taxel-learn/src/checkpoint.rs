//! A training that can go on after an interruption.

use std::path::Path;

use crate::tensors::{self, Tensor};
use crate::train::{Checkpoint, Epoch};
use crate::{Error, Malformed};

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
        let bytes = tensors::read_file(path)?;
        Self::from_bytes(&bytes, training).map_err(|reason| Error::NotAModel {
            file: path.to_owned(),
            reason: reason.to_string(),
        })
    }

    /// A checkpoint of the same training from the bytes of its file.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn from_bytes(bytes: &[u8], training: &str) -> Result<Self, Malformed> {
        Self::parse(bytes, training).map_err(Malformed)
    }

    fn parse(bytes: &[u8], training: &str) -> Result<Self, String> {
        let (tensors, header) = tensors::from_bytes(bytes, "checkpoint")?;
        let header: Header = header
            .and_then(|json| serde_json::from_str(&json).ok())
            .ok_or("not a checkpoint")?;
        if header.training != training {
            return Err(format!(
                "a checkpoint of another training: {}, not {training}",
                header.training
            ));
        }
        let mut networks = Vec::new();
        while tensors
            .tensor(&format!("network.{}.parameters", networks.len()))
            .is_ok()
        {
            let mut parts: [Vec<f32>; 4] = Default::default();
            for at in 0..PARTS.len() {
                // All four are as long as the first.
                let expected = (at > 0).then_some(parts[0].len());
                let name = format!("network.{}.{}", networks.len(), PARTS[at]);
                parts[at] = tensors::numbers(&tensors, &name, expected)?;
                if PARTS[at] == "squares" && parts[at].iter().any(|&value| value < 0.0) {
                    return Err(format!("tensor `{name}` holds a square below 0"));
                }
            }
            networks.push(parts);
        }
        Ok(Self {
            epochs: header.epochs,
            networks,
            steps: header.steps,
        })
    }
    /// Whether it is of networks with these numbers of parameters.
    ///
    /// # Errors
    /// [`Error::Checkpoint`] with both numbers.
    pub fn check(&self, parameters: &[usize]) -> Result<(), Error> {
        let found: Vec<usize> = self.networks.iter().map(|parts| parts[0].len()).collect();
        if found == parameters {
            Ok(())
        } else {
            Err(Error::Checkpoint(format!(
                "its networks have {found:?} parameters, expected {parameters:?}"
            )))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn checkpoint(parts: [usize; 4]) -> Checkpoint {
        Checkpoint {
            epochs: Vec::new(),
            networks: vec![parts.map(|n| vec![0.5; n])],
            steps: 3,
        }
    }

    #[test]
    fn parts_of_other_lengths_are_refused_and_so_are_numbers_that_are_none() {
        let good = checkpoint([6; 4]);
        let back = Checkpoint::from_bytes(&good.to_bytes("t"), "t").unwrap();
        assert_eq!(back, good);
        back.check(&[6]).unwrap();
        let error = back.check(&[7]).unwrap_err().to_string();
        assert!(error.contains("[6] parameters, expected [7]"), "{error}");
        assert!(back.check(&[6, 6]).is_err());
        for at in 1..4 {
            let mut parts = [6; 4];
            parts[at] = 5;
            let error = Checkpoint::from_bytes(&checkpoint(parts).to_bytes("t"), "t");
            let error = error.unwrap_err().to_string();
            assert!(error.contains("has 5 numbers, expected 6"), "{error}");
        }
        let mut bad = good.clone();
        bad.networks[0][1][2] = f32::NAN;
        let error = Checkpoint::from_bytes(&bad.to_bytes("t"), "t")
            .unwrap_err()
            .to_string();
        assert!(error.contains("holds NaN"), "{error}");
        bad = good;
        bad.networks[0][2][0] = -1.0;
        let error = Checkpoint::from_bytes(&bad.to_bytes("t"), "t")
            .unwrap_err()
            .to_string();
        assert!(error.contains("below 0"), "{error}");
    }
}
