//! Fully connected networks in and out of ONNX: what scikit-learn (by skl2onnx) and PyTorch write, and what onnxruntime
//! reads. Only chains of Gemm, MatMul, Add, Sub, Mul, Div, Relu, Scaler and what leaves numbers alone (Identity, Cast, Flatten,
//! Reshape).
//!
//! ONNX is protocol buffers; the handful of fields that such a network needs are read and written here, field numbers
//! from onnx.proto (<https://github.com/onnx/onnx/blob/main/onnx/onnx.proto>).

mod wire;

use std::collections::BTreeMap;

use crate::models::paper_mlp::PaperMlp;
use crate::network::Mlp;
use crate::scaler::Scaler;
use wire::{Field, Writer, fields};

/// Version of the operators written.
const OPSET: u64 = 13;
const FLOAT: u64 = 1;
const DOUBLE: u64 = 11;

/// The model as an ONNX file: inputs are a taxel and its row in counts (n × (1 + C), float), the output its load in grams
/// (n × 1).
pub fn export(model: &PaperMlp) -> Vec<u8> {
    let network = &model.network;
    let width = network.widths()[0];
    let mut graph = Writer::default();
    graph.node("Sub", &["readings", "mean"], "centred");
    graph.node("Div", &["centred", "deviation"], "layer_0_in");
    let mut tensors = vec![
        ("mean".to_owned(), vec![width], model.scaler.mean.clone()),
        (
            "deviation".to_owned(),
            vec![width],
            model.scaler.deviation.clone(),
        ),
    ];
    for layer in 0..network.layers() {
        let last = layer + 1 == network.layers();
        let (weights, biases) = network.layer(layer);
        let (w, b) = (format!("weight_{layer}"), format!("bias_{layer}"));
        let from = format!("layer_{layer}_in");
        let to = match last {
            true => "load_g".to_owned(),
            false => format!("layer_{layer}_sum"),
        };
        graph.node("Gemm", &[&from, &w, &b], &to);
        if !last {
            graph.node("Relu", &[&to], &format!("layer_{}_in", layer + 1));
        }
        tensors.push((
            w,
            network.widths()[layer..layer + 2].to_vec(),
            weights.to_vec(),
        ));
        tensors.push((b, vec![network.widths()[layer + 1]], biases.to_vec()));
    }
    graph.text(2, "paper_mlp");
    for (name, shape, values) in &tensors {
        graph.message(5, &wire::tensor(name, shape, values));
    }
    graph.message(11, &wire::value_info("readings", width));
    graph.message(12, &wire::value_info("load_g", 1));
    let mut opset = Writer::default();
    opset.number(2, OPSET);
    let mut file = Writer::default();
    file.number(1, 8);
    file.text(2, "taxel");
    file.text(3, env!("CARGO_PKG_VERSION"));
    file.message(7, &graph);
    file.message(8, &opset);
    file.into_bytes()
}

/// A number or a list of them in the graph.
#[derive(Debug, Clone)]
struct Constant {
    shape: Vec<usize>,
    values: Vec<f32>,
}

/// What stands between two layers while the graph is read.
#[derive(Debug, Default)]
struct Reader {
    constants: BTreeMap<String, Constant>,
    scale: Vec<f32>,
    shift: Vec<f32>,
    layers: Vec<(usize, usize, Vec<f32>, Vec<f32>)>,
    relu: Vec<bool>,
}

/// A network from an ONNX file; the standardisation in front of it, if it has one, as its scaler.
///
/// # Errors
/// What is wrong with the file, or which operator is none of those that such a network needs, in words.
pub fn import(bytes: &[u8]) -> Result<PaperMlp, String> {
    let graph = fields(bytes)?
        .into_iter()
        .find_map(|field| match field {
            Field::Bytes(7, graph) => Some(graph),
            _ => None,
        })
        .ok_or("no graph in the file: is it ONNX?")?;
    let mut reader = Reader::default();
    let mut nodes = Vec::new();
    for field in fields(graph)? {
        match field {
            Field::Bytes(5, tensor) => {
                let (name, constant) = read_tensor(tensor)?;
                reader.constants.insert(name, constant);
            }
            Field::Bytes(1, node) => nodes.push(node),
            _ => {}
        }
    }
    for node in nodes {
        reader.node(node)?;
    }
    reader.finish()
}

fn read_tensor(bytes: &[u8]) -> Result<(String, Constant), String> {
    let (mut name, mut shape, mut kind) = (String::new(), Vec::new(), 0);
    let (mut raw, mut values): (Option<&[u8]>, Vec<f32>) = (None, Vec::new());
    for field in fields(bytes)? {
        match field {
            Field::Number(1, size) => shape.push(size as usize),
            Field::Bytes(1, packed) => {
                shape.extend(wire::packed(packed)?.into_iter().map(|n| n as usize));
            }
            Field::Number(2, number) => kind = number,
            Field::Bytes(4, packed) => values.extend(
                packed
                    .chunks_exact(4)
                    .map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])),
            ),
            Field::Bytes(8, text) => name = String::from_utf8_lossy(text).into_owned(),
            Field::Bytes(9, bytes) => raw = Some(bytes),
            Field::Bytes(10, packed) => values.extend(packed.chunks_exact(8).map(double)),
            _ => {}
        }
    }
    match (raw, kind) {
        (Some(raw), FLOAT) => values.extend(
            raw.chunks_exact(4)
                .map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])),
        ),
        (Some(raw), DOUBLE) => values.extend(raw.chunks_exact(8).map(double)),
        _ => {}
    }
    Ok((name, Constant { shape, values }))
}

fn double(bytes: &[u8]) -> f32 {
    let mut eight = [0; 8];
    eight.copy_from_slice(bytes);
    f64::from_le_bytes(eight) as f32
}

impl Reader {
    fn node(&mut self, bytes: &[u8]) -> Result<(), String> {
        let (mut inputs, mut operator, mut transposed) = (Vec::new(), String::new(), [false; 2]);
        let mut outputs = Vec::new();
        let mut factors = [1.0f32; 2];
        let mut constant = None;
        let mut scaler = [Vec::new(), Vec::new()];
        for field in fields(bytes)? {
            match field {
                Field::Bytes(1, name) => inputs.push(String::from_utf8_lossy(name).into_owned()),
                Field::Bytes(2, name) => outputs.push(String::from_utf8_lossy(name).into_owned()),
                Field::Bytes(4, name) => operator = String::from_utf8_lossy(name).into_owned(),
                Field::Bytes(5, attribute) => {
                    let found = wire::attribute(attribute)?;
                    match found.name.as_str() {
                        "transA" => transposed[0] = found.number != 0,
                        "transB" => transposed[1] = found.number != 0,
                        "alpha" => factors[0] = found.float,
                        "beta" => factors[1] = found.float,
                        "offset" => scaler[0] = found.floats,
                        "scale" => scaler[1] = found.floats,
                        "value" => constant = found.tensor.map(read_tensor).transpose()?,
                        _ => {}
                    }
                }
                _ => {}
            }
        }
        let known = |name: &String| self.constants.get(name).cloned();
        let second = inputs.get(1).and_then(known);
        let either = second.clone().or_else(|| inputs.first().and_then(known));
        let needs = || format!("operator {operator} without the constant it needs");
        match operator.as_str() {
            "Identity" | "Cast" | "Flatten" | "Reshape" | "Squeeze" | "Unsqueeze" => {
                // A constant may pass through as well.
                if let (Some(from), Some(to)) = (inputs.first().and_then(known), outputs.first()) {
                    self.constants.insert(to.clone(), from);
                }
            }
            "Constant" => {
                if let (Some((_, value)), Some(to)) = (constant, outputs.first()) {
                    self.constants.insert(to.clone(), value);
                }
            }
            // scikit-learn's StandardScaler: (x − offset) · scale.
            "Scaler" => {
                let [offset, scale] = scaler.map(|values| Constant {
                    shape: vec![values.len()],
                    values,
                });
                self.affine(None, Some(negated(offset)));
                self.affine(Some(scale), None);
            }
            "Sub" => self.affine(None, Some(negated(second.ok_or_else(needs)?))),
            "Div" => self.affine(Some(inverse(second.ok_or_else(needs)?)), None),
            "Mul" => self.affine(either, None),
            "Add" => self.affine(None, Some(either.ok_or_else(needs)?)),
            "Gemm" => {
                if transposed[0] || factors != [1.0, 1.0] {
                    return Err("a Gemm with transA, alpha or beta".to_owned());
                }
                let weights = second.ok_or_else(needs)?;
                let biases = inputs.get(2).and_then(known);
                self.layer(weights, biases, transposed[1])?;
            }
            "MatMul" => self.layer(second.ok_or_else(needs)?, None, false)?,
            "Relu" => match self.relu.last_mut() {
                Some(relu) => *relu = true,
                None => return Err("a Relu before the first layer".to_owned()),
            },
            other => {
                return Err(format!(
                    "operator {other}; a fully connected network has Gemm, MatMul, Add, Sub, Mul, Div, Relu"
                ));
            }
        }
        Ok(())
    }

    /// x ← x · scale + shift: in front of the layers, or the biases of the last one.
    fn affine(&mut self, scale: Option<Constant>, shift: Option<Constant>) {
        let spread = |constant: &Constant, n: usize| -> Vec<f32> {
            match constant.values.as_slice() {
                [one] => vec![*one; n],
                each => each.to_vec(),
            }
        };
        if let Some((_, fan_out, weights, biases)) = self.layers.last_mut() {
            if let Some(scale) = scale {
                let scale = spread(&scale, *fan_out);
                for row in weights.chunks_exact_mut(*fan_out) {
                    row.iter_mut().zip(&scale).for_each(|(w, s)| *w *= s);
                }
                biases.iter_mut().zip(&scale).for_each(|(b, s)| *b *= s);
            }
            if let Some(shift) = shift {
                let shift = spread(&shift, *fan_out);
                biases.iter_mut().zip(&shift).for_each(|(b, s)| *b += s);
            }
            return;
        }
        // In front of them: x · scale + shift.
        if let Some(factor) = scale {
            merge(&mut self.scale, &factor.values, 1.0, |a, b| a * b);
            merge(&mut self.shift, &factor.values, 0.0, |a, b| a * b);
        }
        if let Some(more) = shift {
            merge(&mut self.shift, &more.values, 0.0, |a, b| a + b);
        }
    }

    fn layer(
        &mut self,
        weights: Constant,
        biases: Option<Constant>,
        transposed: bool,
    ) -> Result<(), String> {
        let [rows, columns] = weights.shape.as_slice() else {
            return Err(format!("weights of shape {:?}", weights.shape));
        };
        let (fan_in, fan_out) = match transposed {
            true => (*columns, *rows),
            false => (*rows, *columns),
        };
        if weights.values.len() != fan_in * fan_out {
            return Err(format!(
                "{} weights for {fan_in} x {fan_out}",
                weights.values.len()
            ));
        }
        if let Some((_, before, ..)) = self.layers.last()
            && *before != fan_in
        {
            return Err(format!(
                "a layer of {fan_in} inputs after one of {before} outputs"
            ));
        }
        let values = match transposed {
            false => weights.values,
            true => (0..fan_in * fan_out)
                .map(|i| weights.values[(i % fan_out) * fan_in + i / fan_out])
                .collect(),
        };
        let biases = match biases {
            Some(b) if b.values.len() == fan_out => b.values,
            Some(b) => return Err(format!("{} biases for {fan_out} outputs", b.values.len())),
            None => vec![0.0; fan_out],
        };
        self.layers.push((fan_in, fan_out, values, biases));
        self.relu.push(false);
        Ok(())
    }

    fn finish(self) -> Result<PaperMlp, String> {
        let Some((width, ..)) = self.layers.first() else {
            return Err("no layers".to_owned());
        };
        let width = *width;
        let count = self.layers.len();
        if self.relu[..count - 1].contains(&false) || self.relu[count - 1] {
            return Err("every layer but the last must have a Relu".to_owned());
        }
        let mut widths = vec![width];
        widths.extend(self.layers.iter().map(|l| l.1));
        let mut network = Mlp::zeros(&widths, false);
        for (i, (_, _, weights, biases)) in self.layers.iter().enumerate() {
            let (w, b) = network.layer_mut(i);
            w.copy_from_slice(weights);
            b.copy_from_slice(biases);
        }
        let spread = |values: &[f32], none: f32| match values {
            [] => vec![none; width],
            [one] => vec![*one; width],
            each => each.to_vec(),
        };
        let (scale, shift) = (spread(&self.scale, 1.0), spread(&self.shift, 0.0));
        if scale.len() != width || shift.len() != width {
            return Err(format!(
                "a standardisation of {} numbers before {width} inputs",
                scale.len()
            ));
        }
        // x · scale + shift = (x − mean)/deviation.
        Ok(PaperMlp {
            scaler: Scaler {
                mean: shift.iter().zip(&scale).map(|(t, s)| -t / s).collect(),
                deviation: scale.iter().map(|s| 1.0 / s).collect(),
            },
            network,
        })
    }
}

/// Combines lists element by element; a list of one stands for all.
fn merge(into: &mut Vec<f32>, with: &[f32], none: f32, f: impl Fn(f32, f32) -> f32) {
    if into.is_empty() {
        into.push(none);
    }
    let n = into.len().max(with.len());
    *into = (0..n)
        .map(|i| f(into[i.min(into.len() - 1)], with[i.min(with.len() - 1)]))
        .collect();
}

fn negated(mut constant: Constant) -> Constant {
    constant.values.iter_mut().for_each(|v| *v = -*v);
    constant
}

fn inverse(mut constant: Constant) -> Constant {
    constant.values.iter_mut().for_each(|v| *v = 1.0 / *v);
    constant
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn what_is_exported_is_imported_the_same() {
        let mut random = ChaCha8Rng::seed_from_u64(3);
        let model = PaperMlp {
            network: Mlp::new(&[9, 5, 4, 1], false, &mut random),
            scaler: Scaler {
                mean: (0..9).map(|i| 20.0 + i as f32).collect(),
                deviation: (0..9).map(|i| 1.0 + i as f32).collect(),
            },
        };
        let again = import(&export(&model)).unwrap();
        assert_eq!(again.network, model.network);
        for (a, b) in again.scaler.mean.iter().zip(&model.scaler.mean) {
            assert!((a - b).abs() < 1e-4);
        }
    }

    #[test]
    fn bytes_that_are_no_onnx_are_refused() {
        for bytes in [
            &b""[..],
            b"not onnx at all",
            &[0x3a, 0xff, 0xff, 0xff, 0xff, 0xff],
        ] {
            assert!(import(bytes).is_err());
        }
    }
}
