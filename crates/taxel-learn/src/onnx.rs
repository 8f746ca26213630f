//! Fully connected networks in and out of ONNX: what scikit-learn (by skl2onnx) and PyTorch write, and what onnxruntime
//! reads. Only chains of Gemm, MatMul, Add, Sub, Mul, Div, Relu, Scaler and what leaves numbers alone (Identity, Cast, Flatten,
//! Reshape).
//!
//! ONNX is protocol buffers: `messages` has those that such a network needs.

mod messages;

use std::collections::BTreeMap;
use std::path::Path;
use std::rc::Rc;

use crate::models::paper_mlp::PaperMlp;
use crate::network::Mlp;
use crate::scaler::Scaler;
use crate::{Error, Malformed, tensors};
use messages::{Attribute, DOUBLE, FLOAT, Graph, Model, Node, OperatorSet, unpack, unpack_tensor};
use prost::Message;
use prost::bytes::Bytes;

/// Version of the operators written.
const OPSET: i64 = 13;
/// Version of the file format written.
const IR_VERSION: i64 = 8;
/// Most operators and constants that are read: a network has a few dozen, and one constant may stand in many of them.
const MAX_NODES: usize = 1000;
/// Most parts of a message: of a graph all operators, constants, inputs and outputs together.
const MAX_PARTS: usize = 8 * MAX_NODES;
/// Most parameters that a network may come to, however little of a file they take.
const MAX_PARAMETERS: usize = 8 << 20;

/// The model as an ONNX file: inputs are a taxel and its row in counts (n × (1 + C), float), the output its load in grams
/// (n × 1).
pub fn export(model: &PaperMlp) -> Vec<u8> {
    let network = &model.network;
    let width = network.widths()[0];
    let mut graph = Graph {
        name: "paper_mlp".to_owned(),
        ..Graph::default()
    };
    graph.push_node("Sub", &["readings", "mean"], "centred");
    graph.push_node("Div", &["centred", "deviation"], "layer_0_in");
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
        let to = if last {
            "load_g".to_owned()
        } else {
            format!("layer_{layer}_sum")
        };
        graph.push_node("Gemm", &[&from, &w, &b], &to);
        if !last {
            graph.push_node("Relu", &[&to], &format!("layer_{}_in", layer + 1));
        }
        tensors.push((
            w,
            network.widths()[layer..layer + 2].to_vec(),
            weights.to_vec(),
        ));
        tensors.push((b, vec![network.widths()[layer + 1]], biases.to_vec()));
    }
    for (name, shape, values) in &tensors {
        graph.push_tensor(name, shape, values);
    }
    graph.input.push(messages::value_info("readings", width));
    graph.output.push(messages::value_info("load_g", 1));
    let model = Model {
        ir_version: IR_VERSION,
        producer_name: "taxel".to_owned(),
        producer_version: env!("CARGO_PKG_VERSION").to_owned(),
        graph: Some(graph.encode_to_vec().into()),
        opset_import: vec![OperatorSet { version: OPSET }],
    };
    model.encode_to_vec()
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
    constants: BTreeMap<String, Rc<Constant>>,
    scale: Vec<f32>,
    shift: Vec<f32>,
    layers: Vec<(usize, usize, Vec<f32>, Vec<f32>)>,
    relu: Vec<bool>,
}

/// A network from an ONNX file.
///
/// # Errors
/// A file that cannot be read or is too large, and those of [`import`].
pub fn read(path: &Path) -> Result<PaperMlp, Error> {
    import(&tensors::read_file(path)?).map_err(|reason| Error::NotOnnx {
        file: path.to_owned(),
        reason: reason.to_string(),
    })
}

/// A network from the bytes of an ONNX file; the standardisation in front of it, if it has one, as its scaler.
///
/// # Errors
/// What is wrong with the file, or which operator is none of those that such a network needs.
pub fn import(bytes: &[u8]) -> Result<PaperMlp, Malformed> {
    parse(bytes).map_err(Malformed)
}

fn parse(bytes: &[u8]) -> Result<PaperMlp, String> {
    let model: Model = unpack(&Bytes::copy_from_slice(bytes), MAX_PARTS, "the file")?;
    let graph = model.graph.ok_or("no graph in the file: is it ONNX?")?;
    let graph: Graph = unpack(&graph, MAX_PARTS, "the graph")?;
    if graph.node.len().max(graph.initializer.len()) > MAX_NODES {
        return Err(format!(
            "more than {MAX_NODES} operators or constants; a fully connected network has a few dozen"
        ));
    }
    let mut reader = Reader::default();
    for tensor in &graph.initializer {
        let (name, constant) = read_tensor(tensor)?;
        reader.constants.insert(name, Rc::new(constant));
    }
    for node in &graph.node {
        reader.node(node)?;
    }
    reader.finish()
}

fn read_tensor(bytes: &Bytes) -> Result<(String, Constant), String> {
    let tensor = unpack_tensor(bytes)?;
    let mut values = tensor.float_data;
    values.extend(tensor.double_data.iter().map(|&value| value as f32));
    match (&tensor.raw_data, tensor.data_type) {
        (Some(raw), FLOAT) => values.extend(
            raw.chunks_exact(4)
                .map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])),
        ),
        (Some(raw), DOUBLE) => values.extend(raw.chunks_exact(8).map(double)),
        _ => {}
    }
    // A size below 0 is none that a tensor has: as many as can be, which no list of numbers has.
    let size = |&size: &i64| usize::try_from(size).unwrap_or(usize::MAX);
    let shape = tensor.dims.iter().map(size).collect();
    Ok((tensor.name, Constant { shape, values }))
}

fn double(bytes: &[u8]) -> f32 {
    let mut eight = [0; 8];
    eight.copy_from_slice(bytes);
    f64::from_le_bytes(eight) as f32
}

/// What the attributes of an operator say, of all that are known here.
struct Attributes {
    /// `transA` and `transB`.
    transposed: [bool; 2],
    /// `alpha` and `beta`.
    factors: [f32; 2],
    constant: Option<(String, Constant)>,
    /// `offset` and `scale`.
    scaler: [Vec<f32>; 2],
}

impl Attributes {
    fn read(all: &[Bytes]) -> Result<Self, String> {
        let mut found = Self {
            transposed: [false; 2],
            factors: [1.0; 2],
            constant: None,
            scaler: [Vec::new(), Vec::new()],
        };
        for attribute in all {
            // Its parts are numbers, which take no more room unpacked.
            let attribute: Attribute = unpack(attribute, usize::MAX, "an attribute")?;
            match attribute.name.as_str() {
                "transA" => found.transposed[0] = attribute.i != 0,
                "transB" => found.transposed[1] = attribute.i != 0,
                "alpha" => found.factors[0] = attribute.f,
                "beta" => found.factors[1] = attribute.f,
                "offset" => found.scaler[0] = attribute.floats,
                "scale" => found.scaler[1] = attribute.floats,
                "value" => found.constant = attribute.t.as_ref().map(read_tensor).transpose()?,
                _ => {}
            }
        }
        Ok(found)
    }
}

impl Reader {
    fn node(&mut self, bytes: &Bytes) -> Result<(), String> {
        let Node {
            input: inputs,
            output: outputs,
            op_type,
            attribute,
            ..
        } = unpack(bytes, MAX_PARTS, "an operator")?;
        let operator = tensors::shortened(&op_type);
        let attributes = Attributes::read(&attribute)?;
        let (transposed, factors) = (attributes.transposed, attributes.factors);
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
                if let (Some((_, value)), Some(to)) = (attributes.constant, outputs.first()) {
                    self.constants.insert(to.clone(), Rc::new(value));
                }
            }
            // scikit-learn's StandardScaler: (x − offset) · scale.
            "Scaler" => {
                let [offset, scale] = attributes.scaler.map(|values| Constant {
                    shape: vec![values.len()],
                    values,
                });
                self.shift(&offset.values, |v| -v)?;
                self.scale(&scale.values, |v| v)?;
            }
            "Sub" => self.shift(&second.ok_or_else(needs)?.values, |v| -v)?,
            "Div" => self.scale(&second.ok_or_else(needs)?.values, |v| 1.0 / v)?,
            "Mul" => self.scale(&either.ok_or_else(needs)?.values, |v| v)?,
            "Add" => self.shift(&either.ok_or_else(needs)?.values, |v| v)?,
            "Gemm" if transposed[0] || factors != [1.0, 1.0] => {
                return Err("a Gemm with transA, alpha or beta".to_owned());
            }
            "Gemm" => {
                let weights = second.ok_or_else(needs)?;
                let biases = inputs.get(2).and_then(known);
                self.layer(&weights, biases.as_deref(), transposed[1])?;
            }
            "MatMul" => self.layer(&*second.ok_or_else(needs)?, None, false)?,
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

    /// x ← x · factors: in front of the layers, or of what the last one gives. Each factor is `of` a value.
    fn scale(&mut self, values: &[f32], of: fn(f32) -> f32) -> Result<(), String> {
        let Some((_, fan_out, weights, biases)) = self.layers.last_mut() else {
            merge(&mut self.scale, values, 1.0, |a, b| a * of(b))?;
            return merge(&mut self.shift, values, 0.0, |a, b| a * of(b));
        };
        // After a Relu a factor would have to go into the next layer, and a negative one would not be the same.
        if self.relu.last() == Some(&true) {
            return Err("a factor after a Relu".to_owned());
        }
        let factors = one_each(values, *fan_out)?;
        for row in weights.chunks_exact_mut(*fan_out) {
            row.iter_mut().zip(&factors).for_each(|(w, &v)| *w *= of(v));
        }
        biases
            .iter_mut()
            .zip(&factors)
            .for_each(|(b, &v)| *b *= of(v));
        Ok(())
    }

    /// x ← x + shifts: in front of the layers, or the biases of the last one. Each shift is `of` a value.
    fn shift(&mut self, values: &[f32], of: fn(f32) -> f32) -> Result<(), String> {
        let Some((_, fan_out, _, biases)) = self.layers.last_mut() else {
            return merge(&mut self.shift, values, 0.0, |a, b| a + of(b));
        };
        if self.relu.last() == Some(&true) {
            return Err("a number added after a Relu".to_owned());
        }
        let shifts = one_each(values, *fan_out)?;
        biases
            .iter_mut()
            .zip(&shifts)
            .for_each(|(b, &v)| *b += of(v));
        Ok(())
    }

    fn layer(
        &mut self,
        weights: &Constant,
        biases: Option<&Constant>,
        transposed: bool,
    ) -> Result<(), String> {
        let [rows, columns] = weights.shape.as_slice() else {
            return Err(format!("weights of shape {:?}", weights.shape));
        };
        let (fan_in, fan_out) = if transposed {
            (*columns, *rows)
        } else {
            (*rows, *columns)
        };
        if fan_in.checked_mul(fan_out) != Some(weights.values.len()) || weights.values.is_empty() {
            return Err(format!(
                "{} weights for {fan_in} x {fan_out}",
                weights.values.len()
            ));
        }
        let parameters: usize = self.layers.iter().map(|l| l.2.len()).sum();
        if parameters + weights.values.len() > MAX_PARAMETERS {
            return Err(format!("more than {MAX_PARAMETERS} weights"));
        }
        if let Some((_, before, ..)) = self.layers.last()
            && *before != fan_in
        {
            return Err(format!(
                "a layer of {fan_in} inputs after one of {before} outputs"
            ));
        }
        let values = if transposed {
            (0..fan_in * fan_out)
                .map(|i| weights.values[(i % fan_out) * fan_in + i / fan_out])
                .collect()
        } else {
            weights.values.clone()
        };
        let biases = match biases {
            Some(b) if b.values.len() == fan_out => b.values.clone(),
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
        if width < 2 || widths[count] != 1 {
            return Err(format!(
                "{width} inputs and {} outputs; a taxel and its row come in, one load goes out",
                widths[count]
            ));
        }
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
        let scaler = Scaler {
            mean: shift.iter().zip(&scale).map(|(t, s)| -t / s).collect(),
            deviation: scale.iter().map(|s| 1.0 / s).collect(),
        };
        let all = [network.parameters(), &scaler.mean, &scaler.deviation].concat();
        match all.iter().find(|value| !value.is_finite()) {
            Some(bad) => Err(format!("a network that holds {bad}")),
            None => Ok(PaperMlp { network, scaler }),
        }
    }
}

/// Combines lists element by element; a list of one stands for all.
fn merge(
    into: &mut Vec<f32>,
    with: &[f32],
    none: f32,
    f: impl Fn(f32, f32) -> f32,
) -> Result<(), String> {
    if into.is_empty() {
        into.push(none);
    }
    let n = into.len().max(with.len());
    if with.is_empty()
        || [into.len(), with.len()]
            .iter()
            .any(|&len| len != 1 && len != n)
    {
        return Err(format!(
            "a standardisation of {} numbers after one of {}",
            with.len(),
            into.len()
        ));
    }
    *into = (0..n)
        .map(|i| f(into[i.min(into.len() - 1)], with[i.min(with.len() - 1)]))
        .collect();
    Ok(())
}

/// As many numbers as a layer has outputs; one stands for all.
fn one_each(values: &[f32], outputs: usize) -> Result<Vec<f32>, String> {
    match values {
        [one] => Ok(vec![*one; outputs]),
        each if each.len() == outputs => Ok(each.to_vec()),
        each => Err(format!("{} numbers for {outputs} outputs", each.len())),
    }
}

#[cfg(test)]
mod tests;
