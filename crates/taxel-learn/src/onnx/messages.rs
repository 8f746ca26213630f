//! The messages of ONNX that a fully connected network needs. Names, tags and types are those of onnx.proto
//! (<https://github.com/onnx/onnx/blob/main/onnx/onnx.proto>, Apache-2.0), typed by hand; every other field is passed over.
//!
//! Messages that a file may hold any number of stay packed until they are asked for: an empty operator takes two bytes of a
//! file and hundreds once it is unpacked.

use prost::Message;
use prost::bytes::{Buf, Bytes};
use prost::encoding::{DecodeContext, WireType, decode_key, decode_varint, skip_field};

/// `TensorProto.DataType`: 4-byte floating point.
pub(super) const FLOAT: i32 = 1;
/// `TensorProto.DataType`: 8-byte floating point.
pub(super) const DOUBLE: i32 = 11;
/// Most dimensions of a tensor.
const MAX_DIMENSIONS: usize = 8;
/// Most bytes of a number of seven bits a byte.
const MAX_NUMBER_BYTES: usize = 10;

/// `ModelProto`: the whole file.
#[derive(Clone, PartialEq, Message)]
pub(super) struct Model {
    #[prost(int64, tag = "1")]
    pub(super) ir_version: i64,
    #[prost(string, tag = "2")]
    pub(super) producer_name: String,
    #[prost(string, tag = "3")]
    pub(super) producer_version: String,
    /// A [`Graph`].
    #[prost(bytes = "bytes", optional, tag = "7")]
    pub(super) graph: Option<Bytes>,
    #[prost(message, repeated, tag = "8")]
    pub(super) opset_import: Vec<OperatorSet>,
}

/// `OperatorSetIdProto`.
#[derive(Clone, PartialEq, Message)]
pub(super) struct OperatorSet {
    #[prost(int64, tag = "2")]
    pub(super) version: i64,
}

/// `GraphProto`.
#[derive(Clone, PartialEq, Message)]
pub(super) struct Graph {
    /// Each a [`Node`].
    #[prost(bytes = "bytes", repeated, tag = "1")]
    pub(super) node: Vec<Bytes>,
    #[prost(string, tag = "2")]
    pub(super) name: String,
    /// Each a [`Tensor`].
    #[prost(bytes = "bytes", repeated, tag = "5")]
    pub(super) initializer: Vec<Bytes>,
    /// Each a [`ValueInfo`].
    #[prost(bytes = "bytes", repeated, tag = "11")]
    pub(super) input: Vec<Bytes>,
    /// Each a [`ValueInfo`].
    #[prost(bytes = "bytes", repeated, tag = "12")]
    pub(super) output: Vec<Bytes>,
}

/// `NodeProto`: an operator.
#[derive(Clone, PartialEq, Message)]
pub(super) struct Node {
    #[prost(string, repeated, tag = "1")]
    pub(super) input: Vec<String>,
    #[prost(string, repeated, tag = "2")]
    pub(super) output: Vec<String>,
    #[prost(string, tag = "3")]
    pub(super) name: String,
    #[prost(string, tag = "4")]
    pub(super) op_type: String,
    /// Each an [`Attribute`].
    #[prost(bytes = "bytes", repeated, tag = "5")]
    pub(super) attribute: Vec<Bytes>,
}

/// `AttributeProto`.
#[derive(Clone, PartialEq, Message)]
pub(super) struct Attribute {
    #[prost(string, tag = "1")]
    pub(super) name: String,
    #[prost(float, tag = "2")]
    pub(super) f: f32,
    #[prost(int64, tag = "3")]
    pub(super) i: i64,
    /// A [`Tensor`].
    #[prost(bytes = "bytes", optional, tag = "5")]
    pub(super) t: Option<Bytes>,
    #[prost(float, repeated, tag = "7")]
    pub(super) floats: Vec<f32>,
}

/// `TensorProto`.
#[derive(Clone, PartialEq, Message)]
pub(super) struct Tensor {
    #[prost(int64, repeated, packed = "false", tag = "1")]
    pub(super) dims: Vec<i64>,
    #[prost(int32, tag = "2")]
    pub(super) data_type: i32,
    #[prost(float, repeated, tag = "4")]
    pub(super) float_data: Vec<f32>,
    #[prost(string, tag = "8")]
    pub(super) name: String,
    #[prost(bytes = "bytes", optional, tag = "9")]
    pub(super) raw_data: Option<Bytes>,
    #[prost(double, repeated, tag = "10")]
    pub(super) double_data: Vec<f64>,
}

/// `ValueInfoProto`: an input or an output.
#[derive(Clone, PartialEq, Message)]
struct ValueInfo {
    #[prost(string, tag = "1")]
    name: String,
    #[prost(message, optional, tag = "2")]
    r#type: Option<Type>,
}

/// `TypeProto`.
#[derive(Clone, PartialEq, Message)]
struct Type {
    #[prost(message, optional, tag = "1")]
    tensor_type: Option<TensorType>,
}

/// `TypeProto.Tensor`.
#[derive(Clone, PartialEq, Message)]
struct TensorType {
    #[prost(int32, tag = "1")]
    elem_type: i32,
    #[prost(message, optional, tag = "2")]
    shape: Option<Shape>,
}

/// `TensorShapeProto`.
#[derive(Clone, PartialEq, Message)]
struct Shape {
    #[prost(message, repeated, tag = "1")]
    dim: Vec<Dimension>,
}

/// `TensorShapeProto.Dimension`: a number, or a name where any number will do.
#[derive(Clone, PartialEq, Message)]
struct Dimension {
    #[prost(int64, optional, tag = "1")]
    dim_value: Option<i64>,
    #[prost(string, optional, tag = "2")]
    dim_param: Option<String>,
}

/// Unpacks a message of at most `most` fields.
///
/// # Errors
/// What is wrong with it, in words.
pub(super) fn unpack<M: Message + Default>(
    bytes: &Bytes,
    most: usize,
    what: &str,
) -> Result<M, String> {
    let mut count = 0;
    each_field(bytes, |_, _| {
        count += 1;
        if count > most {
            return Err(format!(
                "{what} has more than {most} parts; a fully connected network has a few dozen"
            ));
        }
        Ok(())
    })?;
    M::decode(bytes.clone()).map_err(|_| cut())
}

/// Unpacks a tensor, its numbers wherever they stand.
///
/// # Errors
/// What is wrong with it, in words.
pub(super) fn unpack_tensor(bytes: &Bytes) -> Result<Tensor, String> {
    let mut dimensions = 0;
    each_field(bytes, |tag, length| {
        if tag != 1 {
            return Ok(());
        }
        // Packed, ten bytes a number at most: what is longer is refused before memory is taken for it.
        if length > MAX_NUMBER_BYTES * MAX_DIMENSIONS {
            return Err(format!("a tensor of {length} bytes of dimensions"));
        }
        dimensions += 1;
        if dimensions > MAX_DIMENSIONS {
            return Err(format!(
                "a tensor of more than {MAX_DIMENSIONS} dimensions; weights have 2, biases 1"
            ));
        }
        Ok(())
    })?;
    let tensor = Tensor::decode(bytes.clone()).map_err(|_| cut())?;
    if tensor.dims.len() > MAX_DIMENSIONS {
        return Err(format!(
            "a tensor of {} dimensions; weights have 2, biases 1",
            tensor.dims.len()
        ));
    }
    Ok(tensor)
}

/// Shows the tag of every field of a message to `see`, and its length in bytes (0 where it is a number).
fn each_field(
    bytes: &Bytes,
    mut see: impl FnMut(u32, usize) -> Result<(), String>,
) -> Result<(), String> {
    let mut left: &[u8] = bytes;
    while left.has_remaining() {
        let (tag, kind) = decode_key(&mut left).map_err(|_| cut())?;
        let length = if kind == WireType::LengthDelimited {
            let mut ahead = left;
            usize::try_from(decode_varint(&mut ahead).map_err(|_| cut())?).map_err(|_| cut())?
        } else {
            0
        };
        see(tag, length)?;
        skip_field(kind, tag, &mut left, DecodeContext::default()).map_err(|_| cut())?;
    }
    Ok(())
}

fn cut() -> String {
    "not ONNX, or cut short".to_owned()
}

impl Graph {
    /// Appends an operator.
    pub(super) fn push_node(&mut self, operator: &str, inputs: &[&str], output: &str) {
        let node = Node {
            input: inputs.iter().map(|&input| input.to_owned()).collect(),
            output: vec![output.to_owned()],
            name: output.to_owned(),
            op_type: operator.to_owned(),
            attribute: Vec::new(),
        };
        self.node.push(node.encode_to_vec().into());
    }

    /// Appends a constant of 4-byte numbers.
    pub(super) fn push_tensor(&mut self, name: &str, shape: &[usize], values: &[f32]) {
        let raw: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        let tensor = Tensor {
            dims: shape.iter().map(|&size| size as i64).collect(),
            data_type: FLOAT,
            name: name.to_owned(),
            raw_data: Some(raw.into()),
            ..Tensor::default()
        };
        self.initializer.push(tensor.encode_to_vec().into());
    }
}

/// An input or output of any number of rows of `width` 4-byte numbers.
pub(super) fn value_info(name: &str, width: usize) -> Bytes {
    let any = Dimension {
        dim_param: Some("n".to_owned()),
        ..Dimension::default()
    };
    let fixed = Dimension {
        dim_value: Some(width as i64),
        ..Dimension::default()
    };
    let tensor_type = TensorType {
        elem_type: FLOAT,
        shape: Some(Shape {
            dim: vec![any, fixed],
        }),
    };
    let info = ValueInfo {
        name: name.to_owned(),
        r#type: Some(Type {
            tensor_type: Some(tensor_type),
        }),
    };
    info.encode_to_vec().into()
}
