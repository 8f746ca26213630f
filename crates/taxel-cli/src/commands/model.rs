//! `taxel model`: what a model is, and the way in and out by ONNX.

use std::path::{Path, PathBuf};

use clap::Subcommand;
use taxel_learn::fit::{self, TrainingData};
use taxel_learn::{Model, ModelKind, Split, onnx};

use crate::error::Error;
use crate::outputs::{Files, check_ending, check_model_ending};
use crate::progress::Terminal;
use crate::training_files::Sources;
use crate::{Exit, out};
use taxel_app::training_set::TrainingSet;
use taxel_io::sensor_file;

/// Show a model's card, or exchange it through ONNX
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Debug, Subcommand)]
enum Verb {
    /// Print a model's card as JSON: what it is, what it learnt from, how good it is, what it is not for
    Show {
        /// The model
        model: PathBuf,
    },
    /// Write a paper-mlp as ONNX: readings in counts in (taxel, then its row), load in grams out
    Export {
        /// The model
        model: PathBuf,
        /// Where to write (.onnx)
        #[arg(short, long, value_name = "FILE")]
        output: PathBuf,
    },
    /// Take in a fully connected network from scikit-learn or PyTorch
    ///
    /// Its inputs must be a taxel and its row in counts, standardised inside or not at all; its output grams. The
    /// presses, which it must not have been trained with, set its threshold and interval, and judge it.
    Import(Import),
}

#[derive(Debug, clap::Args)]
struct Import {
    /// The network (.onnx)
    network: PathBuf,
    /// Sensor file, or the name of a preset
    #[arg(long, value_name = "FILE|PRESET")]
    sensor: PathBuf,
    #[command(flatten)]
    from: Sources,
    /// Where to write the model (safetensors)
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
}

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<Exit, Error> {
    match &args.verb {
        Verb::Show { model } => out::json(&Model::read(model)?.card)?,
        Verb::Export { model, output } => {
            Files::default()
                .input("MODEL", model)
                .output("-o", output)
                .check()?;
            check_ending("-o", output, &["onnx"], "a model is exported as ONNX")?;
            let read = Model::read(model)?;
            let ModelKind::PaperMlp(network) = &read.kind else {
                return Err(Error::Arguments {
                    what: format!("{} is a {}", model.display(), read.kind.name()),
                    hint: "only a paper-mlp is one chain of layers, as ONNX has it here",
                });
            };
            write(output, &onnx::export(network))?;
        }
        Verb::Import(import) => adopt(import)?,
    }
    Ok(Exit::Good)
}

fn adopt(args: &Import) -> Result<(), Error> {
    Files::default()
        .input("NETWORK", &args.network)
        .sensor(&args.sensor)
        .maybe_table("table of presses", args.from.presses.as_ref())
        .maybe_input("table of rows", args.from.rows.as_ref())
        .output("-o", &args.output)
        .check()?;
    check_model_ending("-o", &args.output)?;
    let sensor = sensor_file::load(&args.sensor)?;
    let training_set = TrainingSet::read(&args.from.files(), None, &sensor, &Terminal)?;
    let network = onnx::read(&args.network)?;
    let split = Split::new(training_set.rows.len(), 0.5, 0.5, 1);
    let training_data = TrainingData {
        sensor: &sensor,
        rows: &training_set.rows,
        split: &split,
        sources: training_set.sources.clone(),
    };
    let model = fit::adopt(&training_data, network)?;
    let held = &model.card.held_out;
    write(&args.output, &model.to_bytes())?;
    out::result(&format!(
        "held-out presses ({}): {:.3} ± {:.3} g mean absolute error",
        held.presses, held.mean_absolute_g, held.standard_error_g
    ))
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    out::file(path, bytes)?;
    out::note(&format!("wrote {}", path.display()));
    Ok(())
}
