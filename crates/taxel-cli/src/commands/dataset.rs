//! `taxel dataset`: labelled presses as the paper's table, or simulated frames with their loads in shards.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

use taxel::calibrate::{CalibrationData, PressLabel};
use taxel::parallel::par_map;
use taxel::simulate::{Pattern, VirtualSensor};
use taxel::{Counts, Frame};
use taxel_io::NpzWriter;
use taxel_io::npy::Element;

use crate::error::Error;
use crate::outputs::{Files, check_ending};
use crate::progress::{Progress, Terminal};
use crate::{Exit, out};
use taxel_app::executor::Threads;
use taxel_app::training_set::{TrainingFiles, TrainingSet};
use taxel_io::sensor_file;

/// Make a training set
///
/// From labelled presses: screens their frames, then writes the paper's table, one press a line: the taxel, the values
/// of its row, the load in grams; or, for an output ending in .npz, whole frames (`counts`, `row`, `column`, `load_g`,
/// one a press). With --simulate: frames of a virtual sensor and the load of every taxel, in shards
/// (shard-00000.npz with `counts` and `load_g`), the same for the same seed whatever the machine.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Sensor file, or the name of a preset; --simulate needs one with switches and material
    #[arg(long, value_name = "FILE|PRESET")]
    sensor: PathBuf,
    #[command(flatten)]
    from: MaybeSources,
    /// Simulate this many frames instead
    #[arg(long, value_name = "N", conflicts_with_all = ["presses", "rows"])]
    simulate: Option<u64>,
    /// What presses on the simulated array: blobs, hand, grip, regrip, fingers, feet, random, press, uniform
    #[arg(
        long,
        value_name = "NAME",
        default_value = "blobs",
        requires = "simulate"
    )]
    pattern: String,
    /// Frames a shard
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = clap::value_parser!(u64).range(1..))]
    shard: u64,
    /// Seed of everything that is drawn
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Where to write: a table (.csv), whole frames (.npz), or with --simulate a folder
    #[arg(short, long, value_name = "FILE|FOLDER")]
    output: PathBuf,
}

/// The same as elsewhere, none of which is needed for a simulation.
#[derive(Debug, clap::Args)]
struct MaybeSources {
    /// Labelled presses: CSV with recording, frame, row, column (or taxel), load_g
    #[arg(long, value_name = "FILE")]
    presses: Option<PathBuf>,
    /// Labelled rows, the paper's table, to be added
    #[arg(long, value_name = "FILE")]
    rows: Option<PathBuf>,
    /// The recordings have rows and columns swapped
    #[arg(long)]
    transpose: bool,
    /// Largest load believed, grams; beyond it a label is an error
    #[arg(long, value_name = "GRAMS", default_value_t = 10_000.0)]
    most_load: f64,
}

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<Exit, Error> {
    Files::default()
        .sensor(&args.sensor)
        .maybe_table("table of presses", args.from.presses.as_ref())
        .maybe_input("table of rows", args.from.rows.as_ref())
        .output("-o", &args.output)
        .check()?;
    check(args)?;
    let sensor = sensor_file::load(&args.sensor)?;
    if let Some(frames) = args.simulate {
        return simulate(args, &sensor, frames);
    }
    let from = TrainingFiles {
        presses: args.from.presses.clone(),
        rows: args.from.rows.clone(),
        transpose: args.from.transpose,
        max_load_g: args.from.most_load,
    };
    let training_set = TrainingSet::read(&from, None, &sensor, &Terminal)?;
    if is_archive(&args.output) {
        write_frames(&args.output, &training_set.data, &sensor)?;
        out::note(&format!(
            "{} presses with their frames, in {}",
            training_set.data.presses.len(),
            args.output.display()
        ));
        return Ok(Exit::Good);
    }
    out::file(&args.output, training_set.rows.to_csv().as_bytes())?;
    out::note(&format!(
        "{} presses, {} columns, in {}",
        training_set.rows.len(),
        sensor.columns() + 2,
        args.output.display()
    ));
    Ok(Exit::Good)
}

/// Refuses, before any work, what cannot be written.
fn check(args: &Args) -> Result<(), Error> {
    if args.simulate.is_some() {
        // A folder, of any name.
        return Ok(());
    }
    let hint = "a table is written as .csv, whole frames as .npz";
    check_ending("-o", &args.output, &["csv", "txt", "npz"], hint)?;
    match (&args.from.presses, &args.from.rows) {
        (None, None) => Err(Error::Arguments {
            what: "nothing to make a set from".to_owned(),
            hint: "give --presses, --rows, or --simulate",
        }),
        (None, Some(_)) if is_archive(&args.output) => Err(no_frames()),
        _ => Ok(()),
    }
}

fn is_archive(file: &Path) -> bool {
    file.extension()
        .is_some_and(|ending| ending.eq_ignore_ascii_case("npz"))
}

fn no_frames() -> Error {
    Error::Arguments {
        what: "rows of the paper's table have no frames".to_owned(),
        hint: "give --presses, or write a table (.csv)",
    }
}

/// One frame a press, and where and what the press was.
fn write_frames(file: &Path, data: &CalibrationData, sensor: &taxel::Sensor) -> Result<(), Error> {
    let presses = &data.presses;
    if presses.is_empty() {
        return Err(no_frames());
    }
    let mut set = NpzWriter::create(file)?;
    let count = Some(presses.len() as u64);
    set.begin_array(
        "counts",
        count,
        sensor.rows(),
        sensor.columns(),
        Element::U2,
    )?;
    for press in presses {
        set.write(&data.frames[press.frame])?;
    }
    let mut list = |name, element, values: Vec<f64>| -> Result<(), Error> {
        set.begin_array(name, None, 1, values.len(), element)?;
        let values = Frame::<Counts>::new(1, values.len(), values)?;
        Ok(set.write(&values)?)
    };
    let of = |number: fn(&PressLabel) -> f64| presses.iter().map(number).collect();
    list("row", Element::U2, of(|press| press.row as f64))?;
    list("column", Element::U2, of(|press| press.column as f64))?;
    list("load_g", Element::F8, of(|press| press.load_g))?;
    Ok(set.commit()?)
}

fn simulate(args: &Args, sensor: &taxel::Sensor, frames: u64) -> Result<Exit, Error> {
    let Some(pattern) = Pattern::named(&args.pattern) else {
        return Err(Error::Arguments {
            what: format!("no pattern `{}`", args.pattern),
            hint: "known: blobs, hand, grip, regrip, fingers, feet, random, press, uniform",
        });
    };
    let in_file = |source| taxel_app::Error::InFile {
        file: args.sensor.clone(),
        source,
    };
    let instrument = VirtualSensor::new(sensor, args.seed).map_err(in_file)?;
    fs::create_dir_all(&args.output).map_err(|source| taxel_learn::Error::File {
        file: args.output.clone(),
        source,
    })?;
    let shards: Vec<u64> = (0..frames.div_ceil(args.shard)).collect();
    let count = shards.len();
    let progress = Mutex::new(Progress::new("simulating"));
    let (done, failure) = (AtomicU64::new(0), Mutex::new(None));
    par_map(&Threads, shards, |shard| {
        let range = shard * args.shard..((shard + 1) * args.shard).min(frames);
        let length = range.end - range.start;
        let file = args.output.join(format!("shard-{shard:05}.npz"));
        let written = write_shard(&file, &instrument, &pattern, range, sensor);
        let so_far = done.fetch_add(length, Ordering::Relaxed) + length;
        if let Ok(progress) = progress.lock() {
            progress.set(so_far as f64 / frames as f64);
        }
        match written {
            Ok(()) => Some(()),
            Err(error) => {
                if let Ok(mut failure) = failure.lock() {
                    *failure = Some(error);
                }
                None
            }
        }
    });
    drop(progress);
    if let Ok(Some(error)) = failure.into_inner() {
        return Err(error);
    }
    out::note(&format!(
        "{frames} frames in {count} shards, in {}",
        args.output.display()
    ));
    Ok(Exit::Good)
}

fn write_shard(
    file: &Path,
    instrument: &VirtualSensor,
    pattern: &Pattern,
    frames: std::ops::Range<u64>,
    sensor: &taxel::Sensor,
) -> Result<(), Error> {
    let (rows, columns) = (sensor.rows(), sensor.columns());
    let count = Some(frames.end - frames.start);
    let mut shard = NpzWriter::create(file)?;
    let mut loads = Vec::new();
    shard.begin_array("counts", count, rows, columns, Element::U2)?;
    for (load, reading) in instrument.recording(pattern, frames) {
        shard.write(&reading.counts)?;
        loads.push(load);
    }
    shard.begin_array("load_g", count, rows, columns, Element::F4)?;
    for load in &loads {
        shard.write(load)?;
    }
    Ok(shard.commit()?)
}
