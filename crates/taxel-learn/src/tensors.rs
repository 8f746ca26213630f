//! Lists of numbers in a safetensors file, with a JSON text beside them: models and checkpoints.

use std::io::Read;
use std::path::Path;

use safetensors::tensor::TensorView;
use safetensors::{Dtype, SafeTensors};

use crate::Error;

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

/// Largest model, checkpoint or network file that is read, bytes: eight million parameters, where the paper's network
/// has a quarter of a million. What is in a file takes a few times its size while it is read.
pub(crate) const MAX_BYTES: u64 = 32 << 20;

/// Longest description of what is in a file.
const MAX_HEADER_BYTES: u64 = 8 << 20;

/// Reads a file of at most [`MAX_BYTES`], whatever its length is said to be.
///
/// # Errors
/// A file that cannot be read or is larger.
pub(crate) fn read_file(path: &Path) -> Result<Vec<u8>, Error> {
    let failed = |source| Error::File {
        file: path.to_owned(),
        source,
    };
    let mut bytes = Vec::new();
    std::fs::File::open(path)
        .and_then(|file| file.take(MAX_BYTES + 1).read_to_end(&mut bytes))
        .map_err(failed)?;
    if bytes.len() as u64 > MAX_BYTES {
        Err(Error::TooLarge {
            file: path.to_owned(),
            most: MAX_BYTES >> 20,
        })
    } else {
        Ok(bytes)
    }
}

/// At most 80 characters of a text, with a sign that there is more.
pub(crate) fn shortened(text: &str) -> String {
    let mut shown: String = text.chars().take(80).collect();
    if shown.len() < text.len() {
        shown.push('…');
    }
    shown
}

/// The numbers of a tensor, of which there must be `expected` where that is given.
pub(crate) fn numbers(
    tensors: &SafeTensors,
    name: &str,
    expected: Option<usize>,
) -> Result<Vec<f32>, String> {
    let view = tensors
        .tensor(name)
        .map_err(|_| format!("no tensor `{name}`"))?;
    let found = view.data().len();
    if view.dtype() != Dtype::F32 || !found.is_multiple_of(4) {
        return Err(format!(
            "tensor `{name}` is of {:?}, but should be of F32",
            view.dtype()
        ));
    }
    if let Some(expected) = expected
        && found != 4 * expected
    {
        return Err(format!(
            "tensor `{name}` has {} numbers, expected {expected}",
            found / 4
        ));
    }
    let values: Vec<f32> = view
        .data()
        .chunks_exact(4)
        .map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]))
        .collect();
    match values.iter().find(|value| !value.is_finite()) {
        Some(bad) => Err(format!("tensor `{name}` holds {bad}")),
        None => Ok(values),
    }
}

/// The tensors of a file, and the text under `key`, if it has one.
pub(crate) fn from_bytes<'a>(
    bytes: &'a [u8],
    key: &str,
) -> Result<(SafeTensors<'a>, Option<String>), String> {
    // What a header holds that makes no sense is quoted whole, and may be megabytes.
    let wrong = |e: safetensors::SafeTensorError| {
        format!("not a safetensors file ({})", shortened(&e.to_string()))
    };
    // Names, shapes and the card: text that takes ten times its length once it is read.
    if let Some(head) = bytes.first_chunk::<8>() {
        let length = u64::from_le_bytes(*head);
        if length > MAX_HEADER_BYTES {
            return Err(format!(
                "not a safetensors file: a header of {length} bytes, at most {MAX_HEADER_BYTES}"
            ));
        }
    }
    let tensors = SafeTensors::deserialize(bytes).map_err(wrong)?;
    let (_, header) = SafeTensors::read_metadata(bytes).map_err(wrong)?;
    let text = header.metadata().as_ref().and_then(|m| m.get(key).cloned());
    Ok((tensors, text))
}
