//! Lists of numbers in a safetensors file, with a JSON text beside them: models and checkpoints.

use safetensors::tensor::TensorView;
use safetensors::{Dtype, SafeTensors};

/// A name, a shape, and the numbers.
pub(crate) type Tensor<'a> = (String, Vec<usize>, &'a [f32]);

/// The file, with `json` under `key` of its metadata.
pub(crate) fn to_bytes(tensors: &[Tensor], key: &str, json: String) -> Vec<u8> {
    let bytes: Vec<Vec<u8>> = tensors
        .iter()
        .map(|(_, _, values)| values.iter().flat_map(|v| v.to_le_bytes()).collect())
        .collect();
    let views = tensors.iter().zip(&bytes).map(|((name, shape, _), bytes)| {
        let view = TensorView::new(Dtype::F32, shape.clone(), bytes)
            .expect("as many bytes as the shape says");
        (name.as_str(), view)
    });
    let metadata = [(key.to_owned(), json)].into_iter().collect();
    safetensors::serialize(views, Some(metadata)).expect("tensors of one type")
}

/// The tensors of a file, and the text under `key`, if it has one.
pub(crate) fn from_bytes<'a>(
    bytes: &'a [u8],
    key: &str,
) -> Result<(SafeTensors<'a>, Option<String>), String> {
    let wrong = |e| format!("not a safetensors file ({e})");
    let tensors = SafeTensors::deserialize(bytes).map_err(wrong)?;
    let (_, header) = SafeTensors::read_metadata(bytes).map_err(wrong)?;
    let text = header.metadata().as_ref().and_then(|m| m.get(key).cloned());
    Ok((tensors, text))
}
