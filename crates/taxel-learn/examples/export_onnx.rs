//! Exports a network of the paper's shape and what it says of a few inputs, for `testdata/onnx/check.py`.
//!
//!     cargo run --release -p taxel-learn --example export_onnx -- FOLDER

use std::error::Error;
use std::fs;
use std::path::PathBuf;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use taxel_learn::models::paper_mlp::PaperMlp;
use taxel_learn::network::Mlp;
use taxel_learn::scaler::Scaler;
use taxel_learn::{Rows, onnx};

fn main() -> Result<(), Box<dyn Error>> {
    let folder = PathBuf::from(std::env::args().nth(1).ok_or("usage: export_onnx FOLDER")?);
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let mut rows = Rows::new(128);
    for _ in 0..50 {
        let row: Vec<f64> = (0..128)
            .map(|_| 40_000.0 * random.random::<f64>())
            .collect();
        rows.push(row[7], row.clone(), 0.0);
    }
    let inputs: Vec<f32> = (0..rows.len())
        .flat_map(|i| [&[rows.taxel[i]], rows.row_of(i)].concat())
        .collect();
    let model = PaperMlp {
        network: Mlp::drawn(&[129, 160, 480, 240, 1], false, 5),
        scaler: Scaler::fit(&inputs, 129),
    };
    let outputs: Vec<f32> = model.estimate(&rows).iter().map(|&y| y as f32).collect();
    let bytes =
        |values: &[f32]| -> Vec<u8> { values.iter().flat_map(|v| v.to_le_bytes()).collect() };
    fs::create_dir_all(&folder)?;
    fs::write(folder.join("ours.onnx"), onnx::export(&model))?;
    fs::write(folder.join("inputs.f32"), bytes(&inputs))?;
    fs::write(folder.join("outputs.f32"), bytes(&outputs))?;
    Ok(())
}
