//! `taxel train`: from labelled presses to a model that compensates.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::{Duration, Instant};

use clap::ValueEnum;
use taxel_learn::fit::{self, TrainingData};
use taxel_learn::models::paper_mlp::{COPIES, HIDDEN};
use taxel_learn::train::{Checkpoint, Epoch, Settings};
use taxel_learn::{Model, Split};

use crate::error::Error;
use crate::outputs::{Files, check_model_ending};
use crate::progress::{Progress, Terminal};
use crate::training_files::Sources;
use crate::{Exit, interrupt, out};
use taxel_app::executor::Threads;
use taxel_app::training_set::TrainingSet;
use taxel_io::sensor_file;

/// Train a network on labelled presses
///
/// Presses are split by press: most to train with, some to stop by and to set the uncertainty by, some to judge by;
/// copies are made inside the training part alone. Ctrl-C stops after the present epoch and keeps the best so far.
/// `taxel compensate --method MODEL` uses what is written; `taxel compare` says whether it is worth it.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// What to train
    #[arg(value_enum)]
    kind: Kind,
    /// Sensor file, or the name of a preset; `hybrid` needs a calibrated one
    #[arg(long, value_name = "FILE|PRESET")]
    sensor: PathBuf,
    #[command(flatten)]
    from: Sources,
    /// Where to write the model (safetensors)
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Most epochs; default 2000 for paper-mlp, 400 for row-set
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    epochs: Option<u64>,
    /// Shuffled copies of each press (paper-mlp)
    #[arg(long, value_name = "N", default_value_t = COPIES as u64, value_parser = clap::value_parser!(u64).range(1..=100_000))]
    copies: u64,
    /// Networks whose mean is taken (row-set)
    #[arg(long, value_name = "N", default_value_t = fit::MEMBERS as u64, value_parser = clap::value_parser!(u64).range(1..=100))]
    members: u64,
    /// Seed of everything that is drawn
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Share of the presses to stop by
    #[arg(long, value_name = "SHARE", default_value_t = 0.15)]
    check_share: f64,
    /// Share of the presses to judge by
    #[arg(long, value_name = "SHARE", default_value_t = 0.15)]
    test_share: f64,
    /// Go on from the checkpoint beside the output (paper-mlp)
    #[arg(long)]
    resume: bool,
    /// Print the model's card as JSON
    #[arg(long)]
    json: bool,
}

/// The models that can be trained.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Kind {
    /// The paper's: a taxel and its row in, four layers, rows shuffled
    PaperMlp,
    /// Sums over the row, so that its order cannot matter
    RowSet,
    /// The exact inverse, then a small network on what is left
    Hybrid,
}

/// How often a checkpoint is written.
const CHECKPOINT_EVERY: Duration = Duration::from_secs(20);

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<Exit, Error> {
    check_shares(args)?;
    let checkpoint = (args.kind == Kind::PaperMlp).then(|| checkpoint_of(&args.output));
    Files::default()
        .sensor(&args.sensor)
        .maybe_table("table of presses", args.from.presses.as_ref())
        .maybe_input("table of rows", args.from.rows.as_ref())
        .output("-o", &args.output)
        .maybe_output("the checkpoint of", checkpoint.as_ref())
        .check()?;
    check_model_ending("-o", &args.output)?;
    let sensor = sensor_file::load(&args.sensor)?;
    let training_set = TrainingSet::read(&args.from.files(), None, &sensor, &Terminal)?;
    let count = match args.kind {
        // Rows of the paper's table have no frame to invert.
        Kind::Hybrid => training_set.data.presses.len(),
        _ => training_set.rows.len(),
    };
    if args.kind == Kind::Hybrid && count == 0 {
        return Err(Error::Arguments {
            what: "hybrid needs whole frames, which --rows does not have".to_owned(),
            hint: "give --presses",
        });
    }
    let split = Split::new(count, args.check_share, args.test_share, args.seed);
    let training_data = TrainingData {
        sensor: &sensor,
        rows: &training_set.rows,
        split: &split,
        sources: training_set.sources.clone(),
    };
    interrupt::listen();
    let model = match args.kind {
        Kind::PaperMlp => paper_mlp(args, &training_data)?,
        Kind::RowSet => row_set(args, &training_data)?,
        Kind::Hybrid => {
            let progress = Progress::new("training");
            fit::hybrid(
                &training_data,
                &training_set.data.frames,
                &training_set.data.presses,
                args.seed,
                &mut |share| {
                    progress.set(share);
                    go()
                },
            )?
        }
    };
    out::file(&args.output, &model.to_bytes())?;
    if args.json {
        out::json(&model.card)?
    } else {
        out::result(&report(&model))?
    }
    out::note(&format!("wrote {}", args.output.display()));
    if interrupt::asked() {
        out::warn("stopped by Ctrl-C; the model is the best so far");
    }
    Ok(Exit::Good)
}

fn check_shares(args: &Args) -> Result<(), Error> {
    let shares = [args.check_share, args.test_share];
    if shares.iter().any(|s| !(0.0..=0.5).contains(s)) || args.check_share == 0.0 {
        return Err(Error::Arguments {
            what: format!(
                "--check-share {} and --test-share {}",
                args.check_share, args.test_share
            ),
            hint: "each is a share of the presses, up to 0.5, and the first more than 0",
        });
    }
    Ok(())
}

fn go() -> ControlFlow<()> {
    if interrupt::asked() {
        ControlFlow::Break(())
    } else {
        ControlFlow::Continue(())
    }
}

/// Where an unfinished training is kept, beside its model.
fn checkpoint_of(output: &Path) -> PathBuf {
    let mut name = output.as_os_str().to_owned();
    name.push(".checkpoint");
    PathBuf::from(name)
}

fn paper_mlp(args: &Args, training_data: &TrainingData) -> Result<Model, Error> {
    let mut settings = Settings::default();
    settings.seed = args.seed;
    settings.epochs = args.epochs.map_or(settings.epochs, |n| n as usize);
    let next_to = checkpoint_of(&args.output);
    // Epochs may be added to a training; nothing else may change.
    let fingerprints: Vec<&str> = training_data
        .sources
        .iter()
        .map(|s| s.fingerprint.as_str())
        .collect();
    let training = format!(
        "paper-mlp, {} copies, seed {}, shares {} and {}, data {}",
        args.copies,
        args.seed,
        args.check_share,
        args.test_share,
        fingerprints.join("+")
    );
    let from = if args.resume {
        Some(Checkpoint::read(&next_to, &training)?)
    } else {
        None
    };
    let mut teller = Teller::new(settings.epochs);
    let mut written = Instant::now();
    let mut failure = None;
    let model = fit::paper_mlp(
        training_data,
        &settings,
        &HIDDEN,
        args.copies as usize,
        from.as_ref(),
        &mut |epoch, checkpoint| {
            teller.tell(epoch);
            if written.elapsed() > CHECKPOINT_EVERY || interrupt::asked() {
                written = Instant::now();
                if let Err(error) = out::file(&next_to, &checkpoint().to_bytes(&training)) {
                    failure = Some(error);
                    return ControlFlow::Break(());
                }
            }
            go()
        },
    )?;
    match failure {
        Some(error) => Err(error),
        None => {
            if !interrupt::asked() && next_to.exists() {
                // It has served; a stale one would only be mistaken for a newer training's.
                let _ = std::fs::remove_file(&next_to);
            }
            Ok(model)
        }
    }
}

fn row_set(args: &Args, training_data: &TrainingData) -> Result<Model, Error> {
    let mut settings = fit::row_set_settings();
    settings.seed = args.seed;
    settings.epochs = args.epochs.map_or(settings.epochs, |n| n as usize);
    let teller = Mutex::new(Teller::new(settings.epochs));
    Ok(fit::row_set(
        training_data,
        &settings,
        args.members as usize,
        &Threads,
        &|member, _, epoch| {
            if member == 0
                && let Ok(mut teller) = teller.lock()
            {
                teller.tell(epoch);
            }
            go()
        },
    )?)
}

/// Tells of epochs: a bar on a terminal, a line every tenth of the way elsewhere.
struct Teller {
    progress: Progress,
    epochs: usize,
    started: Instant,
    first: Option<usize>,
}

impl Teller {
    fn new(epochs: usize) -> Self {
        Self {
            progress: Progress::new("training"),
            epochs,
            started: Instant::now(),
            first: None,
        }
    }

    fn tell(&mut self, epoch: &Epoch) {
        let first = *self.first.get_or_insert(epoch.epoch);
        let done = epoch.epoch - first + 1;
        let left = self.started.elapsed().as_secs_f64() / done as f64
            * (self.epochs.saturating_sub(epoch.epoch)) as f64;
        let text = format!(
            "epoch {}, loss {:.4}, {:.2} g",
            epoch.epoch, epoch.loss, epoch.check_g
        );
        self.progress
            .stage(&text, epoch.epoch as f64 / self.epochs as f64);
        if !self.progress.is_shown() && epoch.epoch.is_multiple_of((self.epochs / 10).max(1)) {
            out::note(&format!(
                "epoch {} of {}: loss {:.4}, {:.3} g on presses kept aside, about {left:.0} s left",
                epoch.epoch, self.epochs, epoch.loss, epoch.check_g
            ));
        }
    }
}

fn report(model: &Model) -> String {
    let card = &model.card;
    let held = &card.held_out;
    let epochs = card.epochs.iter().map(|e| e.epoch).max().unwrap_or(0);
    let mut text = if card.networks.is_empty() {
        format!("{}: no network, the physics alone\n", card.kind)
    } else {
        format!("{}, {epochs} epochs\n", card.kind)
    };
    if held.presses > 0 {
        text += &format!(
            "held-out presses ({}): {:.3} ± {:.3} g mean absolute error, {:.3} g root mean square, {:.3} g at the 95th percentile\n",
            held.presses,
            held.mean_absolute_g,
            held.standard_error_g,
            held.root_mean_square_g,
            held.p95_g
        );
        text += &format!(
            "interval of {:.0} % ({}, set by {} presses): ±{:.2} g at 50 g, ±{:.2} g at 300 g; covers {:.0} % of the held-out presses\n",
            100.0 * card.interval.level,
            match card.verdict {
                Some(_) => "cross-validation+",
                None => "split conformal",
            },
            card.interval.presses,
            card.interval.half_width_g(50.0),
            card.interval.half_width_g(300.0),
            100.0 * held.coverage
        );
    }
    if let Some(verdict) = &card.verdict {
        text += &format!(
            "cross-validation: physics {:.3} g, with the network {:.3} g ({:.1} standard errors): {}\n",
            verdict.physics_g,
            verdict.hybrid_g,
            verdict.standard_errors,
            if verdict.used {
                "the network is used"
            } else {
                "the network is not used, this model is the physics alone"
            }
        );
    }
    for not_for in &card.not_for {
        text += &format!("not for: {not_for}\n");
    }
    text
}
