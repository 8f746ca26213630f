//! `taxel compare`: physics, networks, one curve and nothing, on the same held-out presses and frames.

mod candidates;
mod table;

use std::path::{Path, PathBuf};
use std::time::Instant;

use taxel::frame::{grams_from_newtons, newtons_from_grams};
use taxel::{Counts, Frame, Newtons, Sensor};
use taxel_io::{FrameSource, ReadOptions, open_counts};
use taxel_learn::Split;
use taxel_learn::benchmark::Scores;
use taxel_plot::Format;

use crate::error::Error;
use crate::outputs::{Files, check_ending};
use crate::progress::{Progress, Terminal};
use crate::training_files::Sources;
use crate::{Exit, interrupt, out};
use candidates::{Candidate, Known};
use table::Table;
use taxel_app::frames::open_values;
use taxel_app::training_set::TrainingSet;
use taxel_io::sensor_file;

/// Compare ways from counts to loads on your own data
///
/// Labelled presses are split by press; every way learns from the same part and is judged on the rest, and on whole
/// frames whose loads are known (--truth). None: a straight line through reading and load. One curve: the best load
/// law on readings as they are. Exact: the circuit fitted and undone. Hybrid: that and a network on what is left.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Recordings whose loads --truth gives
    recordings: Vec<PathBuf>,
    /// Loads of every taxel of the recordings, grams (.csv, .npy, .npz), one file a recording
    #[arg(long, value_name = "FILE", num_args = 1..)]
    truth: Vec<PathBuf>,
    /// Sensor file (the parts list), or the name of a preset
    #[arg(long, value_name = "FILE|PRESET")]
    sensor: PathBuf,
    #[command(flatten)]
    from: Sources,
    /// Frames under the same load everywhere, for the calibration
    #[arg(long, value_name = "FILE", requires = "presses")]
    equilibration: Option<PathBuf>,
    /// Share of the presses to judge by
    #[arg(long, value_name = "SHARE", default_value_t = 0.2)]
    test_share: f64,
    /// Learn from this many presses alone; several numbers give a learning curve
    #[arg(long, value_name = "N", value_delimiter = ',', value_parser = clap::value_parser!(u64).range(8..))]
    most_presses: Vec<u64>,
    /// Epochs of paper-mlp (its own rule would take up to 2000)
    #[arg(long, value_name = "N", default_value_t = 60, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    epochs: u64,
    /// Shuffled copies of each press for paper-mlp
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = clap::value_parser!(u64).range(1..=100_000))]
    copies: u64,
    /// Also paper-mlp with the paper's leaky split: copies of one press on both sides
    #[arg(long)]
    leaky: bool,
    /// Ways to leave out
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    without: Vec<String>,
    /// Seed of split and networks
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Where to write the table (.csv)
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Where to draw error against load (.png, .svg, .pdf)
    #[arg(long, value_name = "FILE")]
    figure: Option<PathBuf>,
    /// Print the table as JSON
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<Exit, Error> {
    check(args)?;
    let sensor = sensor_file::load(&args.sensor)?;
    let training_set = TrainingSet::read(
        &args.from.files(),
        args.equilibration.as_deref(),
        &sensor,
        &Terminal,
    )?;
    let whole = Split::new(training_set.rows.len(), 0.15, args.test_share, args.seed);
    let mut known = Vec::new();
    for (recording, truth) in args.recordings.iter().zip(&args.truth) {
        read_known(recording, truth, &sensor, &mut known)?;
    }
    interrupt::listen();
    let mut table = Table::new(args, &training_set, &whole, known.len());
    let all = whole.train.len() + whole.check.len();
    let sizes = if args.most_presses.is_empty() {
        vec![all]
    } else {
        args.most_presses.iter().map(|&n| n as usize).collect()
    };
    for size in sizes {
        let mut split = whole.clone();
        thin(&mut split, size);
        let progress = Progress::new("learning");
        out::note(&format!(
            "learning from {} presses; Ctrl-C stops",
            split.train.len() + split.check.len()
        ));
        let mut show = |name: &str, share: f64| progress.stage(name, share);
        let candidates = candidates::all(args, &sensor, &training_set, &split, &mut show)?;
        drop(progress);
        if interrupt::asked() {
            // Networks that learnt half as long as they should would stand beside ways that need no learning.
            out::warn(
                "stopped by Ctrl-C before every way had learnt: nothing is compared, nothing is written",
            );
            return Ok(Exit::DataLost);
        }
        for mut candidate in candidates {
            // Who had no more to learn from than before is the same as before.
            if !table.has(&candidate) {
                let scores = judge(&mut candidate, &known)?;
                table.add(&candidate, &scores);
            }
        }
    }
    write(args, &table)?;
    Ok(Exit::Good)
}

/// Refuses what cannot be compared, before any work.
fn check(args: &Args) -> Result<(), Error> {
    if args.recordings.len() != args.truth.len() {
        return Err(Error::Arguments {
            what: format!(
                "{} recordings, but {} files of --truth",
                args.recordings.len(),
                args.truth.len()
            ),
            hint: "one file of loads for each recording, in the same order",
        });
    }
    if !(0.0..=0.9).contains(&args.test_share) {
        return Err(Error::Arguments {
            what: format!("--test-share {}", args.test_share),
            hint: "a share of the presses, 0 to 0.9",
        });
    }
    let recordings = args.recordings.iter().chain(&args.truth);
    recordings
        .fold(Files::default(), |files, file| {
            files.input("recording", file)
        })
        .sensor(&args.sensor)
        .maybe_table("table of uniform loads", args.equilibration.as_ref())
        .maybe_table("table of presses", args.from.presses.as_ref())
        .maybe_input("table of rows", args.from.rows.as_ref())
        .maybe_output("-o", args.output.as_ref())
        .maybe_output("--figure", args.figure.as_ref())
        .check()?;
    if let Some(file) = &args.output {
        check_ending("-o", file, &["csv"], "the table is written as CSV")?;
    }
    let figure = args.figure.as_ref().map(Format::from_extension);
    figure.transpose()?;
    Ok(())
}

/// The table and the figure, where they are wanted.
fn write(args: &Args, table: &Table) -> Result<(), Error> {
    if let Some(file) = &args.output {
        table.write_csv(file)?;
    }
    if let Some(file) = &args.figure {
        table.draw(file)?;
    }
    if args.json {
        out::json(table)?
    } else {
        out::result(&table.to_string())?
    }
    for file in [&args.output, &args.figure].into_iter().flatten() {
        out::note(&format!("wrote {}", file.display()));
    }
    Ok(())
}

/// Leaves the given number of presses to learn from; the same share of them as before to stop by.
fn thin(split: &mut Split, most: usize) {
    let all = split.train.len() + split.check.len();
    if most >= all {
        return;
    }
    let check = (most * split.check.len()).div_ceil(all.max(1));
    split.check.truncate(check);
    split.train.truncate(most - check);
}

/// Judges on whole frames; presses were judged when it learnt.
fn judge(candidate: &mut Candidate, known: &[Known]) -> Result<Scores, Error> {
    let mut scores = std::mem::take(&mut candidate.scores);
    let Some(pipeline) = &mut candidate.pipeline else {
        return Ok(scores);
    };
    // The first frame pays for what is drawn up once.
    if let Some(first) = known.first() {
        pipeline.process(&first.counts);
        pipeline.begin_anew();
    }
    for one in known {
        let begun = Instant::now();
        let loads: &Frame<Newtons> = pipeline.process(&one.counts).newtons()?;
        let seconds = begun.elapsed().as_secs_f64();
        scores.add_frame(loads, &one.truth, seconds)?;
    }
    Ok(scores)
}

fn read_known(
    recording: &Path,
    truth: &Path,
    sensor: &Sensor,
    known: &mut Vec<Known>,
) -> Result<(), Error> {
    let options = ReadOptions::of(sensor);
    let mut counts_of = open_counts(recording, options)?;
    let mut loads_of = open_values::<Newtons>(truth, options)?;
    let mut counts = Frame::<Counts>::zeros(sensor.rows(), sensor.columns());
    let mut loads = Frame::<Newtons>::zeros(sensor.rows(), sensor.columns());
    let mut at = 0u64;
    loop {
        match (
            counts_of.next_into(&mut counts)?,
            loads_of.next_into(&mut loads)?,
        ) {
            (true, true) => known.push(Known {
                counts: counts.clone(),
                truth: loads.map(|_, grams| newtons_from_grams(grams)),
            }),
            (false, false) => break,
            (more_counts, _) => {
                return Err(taxel_app::Error::NoFrame {
                    asked_by: "--truth".to_owned(),
                    file: if more_counts { truth } else { recording }.to_owned(),
                    wanted: at,
                    found: at,
                }
                .into());
            }
        }
        at += 1;
    }
    Ok(())
}

/// A load in grams, never below zero.
fn grams(newtons: f64) -> f64 {
    grams_from_newtons(newtons).max(0.0)
}
