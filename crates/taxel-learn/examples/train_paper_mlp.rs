//! Trains the paper's network and writes everything that another program needs to repeat it: inputs, loads, first
//! weights, the order of every epoch, and the losses. `bench/train.py` runs it beside scikit-learn and PyTorch.
//!
//!     cargo run --release -p taxel-learn --example train_paper_mlp -- ROWS.csv COLUMNS COPIES EPOCHS FOLDER

use std::error::Error;
use std::fs;
use std::ops::ControlFlow;
use std::path::Path;
use std::time::Instant;

use taxel_learn::models::paper_mlp::{HIDDEN, PaperTraining};
use taxel_learn::train::{Settings, Trainable, epoch_order, train};
use taxel_learn::{Rows, Split};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [table, columns, copies, epochs, folder] = arguments.as_slice() else {
        return Err("usage: train_paper_mlp ROWS.csv COLUMNS COPIES EPOCHS FOLDER".into());
    };
    let rows = Rows::read_csv(Path::new(table), columns.parse()?)?;
    let split = Split::new(rows.len(), 0.15, 0.15, 1);
    let (known, check) = (rows.part(&split.train), rows.part(&split.check));
    let mut settings = Settings::default();
    settings.epochs = epochs.parse()?;
    settings.patience = usize::MAX;
    let mut training = PaperTraining::new(&known, &check, &HIDDEN, copies.parse()?, settings.seed);
    let folder = Path::new(folder);
    fs::create_dir_all(folder)?;
    let save = |name: &str, bytes: Vec<u8>| fs::write(folder.join(name), bytes);
    let floats = |values: &[f32]| values.iter().flat_map(|v| v.to_le_bytes()).collect();
    save("inputs.f32", floats(training.inputs()))?;
    save("loads.f32", floats(&training.loads()))?;
    save("weights.f32", floats(training.networks()[0].parameters()))?;
    let mut orders = Vec::new();
    for epoch in 0..settings.epochs {
        for i in epoch_order(&settings, epoch, training.examples()) {
            orders.extend(u32::try_from(i)?.to_le_bytes());
        }
    }
    save("orders.u32", orders)?;
    let mut losses = String::new();
    let mut begun = Instant::now();
    train(&mut training, &settings, None, &mut |epoch, _| {
        losses += &format!("{} {}\n", epoch.loss, begun.elapsed().as_secs_f64());
        println!(
            "epoch {}: loss {:.4}, {:.2} s",
            epoch.epoch,
            epoch.loss,
            begun.elapsed().as_secs_f64()
        );
        begun = Instant::now();
        ControlFlow::Continue(())
    });
    fs::write(folder.join("losses.txt"), losses)?;
    time_frame(&training.finish(), &known);
    Ok(())
}

/// Times a frame of 64 rows in which 2000 taxels are pressed as those of the table are.
fn time_frame(model: &taxel_learn::models::paper_mlp::PaperMlp, rows: &Rows) {
    let mut counts: Vec<f32> = (0..64).flat_map(|i| rows.row_of(i).to_vec()).collect();
    let taxels: Vec<(usize, usize)> = (0..2000).map(|i| (i / 32, i % 32)).collect();
    for (i, (row, column)) in taxels.iter().enumerate() {
        counts[row * rows.columns + column] = rows.taxel[i % rows.len()];
    }
    let mut memory = Default::default();
    let mut times: Vec<f64> = (0..30)
        .map(|_| {
            let begun = Instant::now();
            model.estimate_frame(&counts, &taxels, &mut memory);
            1e3 * begun.elapsed().as_secs_f64()
        })
        .collect();
    times.sort_by(f64::total_cmp);
    println!("a frame with 2000 taxels pressed: {:.2} ms", times[15]);
}
