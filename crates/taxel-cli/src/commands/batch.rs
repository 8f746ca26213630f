//! `taxel batch`: an archive of recordings to loads, figures and one table; again from where it was cut off.

use std::fmt;
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::ValueEnum;
use serde::Serialize;
use taxel::calibrate::with_error;
use taxel_io::{bounded, sensor_file};

use crate::error::Error;
use crate::outputs::Files;
use crate::{Exit, out};
use taxel_app::batch::{Batch, Done, Entry, LoadsFile, Settings, Shard, Status};
use taxel_app::batch::{manifest, summary};
use taxel_app::exported::NOISE_ALONE;
use taxel_app::figures::with_noise_alone;
use taxel_app::methods::MethodName;

/// The most bytes of a list of recordings: some hundred thousand.
const MAX_LIST: u64 = 1 << 26;

/// Work through an archive of recordings
///
/// Of each recording: loads and marks (.loads.parquet), figures over time (.figures.csv), and a line of summary.csv, its largest
/// force with half of its 95 % interval. Recordings are shared by all cores. What is there already of the same recording, program and settings is
/// kept: run it again to go on where it was cut off. A recording that is broken is named and does not stop the others; frames
/// that cannot be read are left out and counted. Exit code 3: something is broken or incomplete.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Recordings of counts (.mcap, .parquet, .txt, .csv, .npy, .npz)
    recordings: Vec<PathBuf>,
    /// File with a recording a line, or NUL between them, for more than fit on a command line (- for standard input)
    #[arg(long, value_name = "FILE")]
    list: Option<PathBuf>,
    /// Folder to write to; things of a recording lie in it under the recording's own path
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Sensor file, or the name of a preset, for all; without it .mcap and .parquet bring their own
    #[arg(long, value_name = "FILE|PRESET")]
    sensor: Option<PathBuf>,
    /// How loads are found: auto (what suits the read-out), exact, newton, raw (no compensation), or the file of
    /// a model that `taxel train` wrote
    #[arg(long, value_name = "NAME|MODEL", default_value_t)]
    method: MethodName,
    /// What loads and marks are written as, in newtons, with counts and times
    #[arg(long, value_enum, default_value_t)]
    loads: Loads,
    /// Half of the 95 % interval of every frame's figures: many times the work
    #[arg(long)]
    intervals: bool,
    /// Draw of each recording the frame with the largest force (.png)
    #[arg(long)]
    pictures: bool,
    /// Replace what was not measured by the median of its neighbours, and mark it interpolated
    #[arg(long, overrides_with = "no_repair")]
    repair: bool,
    /// Replace nothing, even if the sensor file asks for it
    #[arg(long)]
    no_repair: bool,
    /// Leave the recordings' tare on
    #[arg(long)]
    no_tare: bool,
    /// The recordings have rows and columns swapped
    #[arg(long)]
    transpose: bool,
    /// Keep in the header of what is written what a file of another program says of persons, and names of files; left out else
    #[arg(long)]
    with_names: bool,
    /// Only every n-th recording from the i-th on, for jobs side by side; then once without it for summary.csv
    #[arg(long, value_name = "I/N")]
    shard: Option<Shard>,
    /// Write no summary.csv and manifest.csv: for jobs side by side that know of their own recordings alone
    #[arg(long)]
    no_summary: bool,
    /// Threads that share the work, with the same results; as many as there are cores where it is not given
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Print what was done as JSON
    #[arg(long)]
    json: bool,
}

/// What loads are written as.
#[derive(Debug, Clone, Copy, Default, ValueEnum)]
enum Loads {
    /// A table of a line a frame
    #[default]
    Parquet,
    /// A recording
    Mcap,
    /// Not at all
    None,
}

impl From<Loads> for LoadsFile {
    fn from(loads: Loads) -> Self {
        match loads {
            Loads::Parquet => LoadsFile::Parquet,
            Loads::Mcap => LoadsFile::Mcap,
            Loads::None => LoadsFile::Nothing,
        }
    }
}

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<Exit, Error> {
    let all = recordings(args)?;
    let batch = Batch::new(settings(args)?, &args.out)?;
    let mine = match args.shard {
        Some(shard) => shard.part(&all),
        None => all.clone(),
    };
    let mut counted = Counted::new(args, mine.len());
    let tables = [&counted.summary, &counted.manifest];
    let tables: Vec<PathBuf> = tables.into_iter().flatten().cloned().collect();
    batch.check_names(&all, &tables)?;
    check_tables(args, &counted)?;
    let started = Instant::now();
    let mut entries = vec![None; mine.len()];
    batch.run(
        &mine,
        args.threads.map(usize::from),
        &|| false,
        |at, done| {
            counted.add(done);
            entries[at] = Some(done.entry.clone());
            if !args.json || !done.entry.is_whole() {
                out::note(&line(&counted, done));
            }
        },
    )?;
    if let (Some(lines), Some(files)) = (&counted.summary, &counted.manifest) {
        let entries: Vec<Entry> = entries.into_iter().flatten().collect();
        summary(lines, &entries)?;
        manifest(files, &entries)?;
    }
    counted.seconds = started.elapsed().as_secs_f64();
    if args.json {
        out::json(&counted)?;
    } else {
        out::note(&counted.to_string());
    }
    let is_whole = counted.incomplete == 0 && counted.broken == 0;
    Ok(if is_whole { Exit::Good } else { Exit::DataLost })
}

fn settings(args: &Args) -> Result<Settings, Error> {
    let sensor = match &args.sensor {
        Some(file) => Some((sensor_file::load(file)?, file.clone())),
        None => None,
    };
    let uncertain = sensor.as_ref().map(|(sensor, _)| sensor.uncertainty());
    if uncertain.is_some_and(|uncertainty| uncertainty.is_none()) {
        out::note(
            "noise only: the sensor file has no [uncertainty], which `taxel calibrate` writes, so that half-widths are too small",
        );
    }
    let mut settings = Settings::new(sensor);
    settings.method = args.method.clone();
    settings.loads = args.loads.into();
    settings.intervals = args.intervals;
    settings.pictures = args.pictures;
    settings.repair = (args.repair || args.no_repair).then_some(args.repair);
    settings.no_tare = args.no_tare;
    settings.transpose = args.transpose;
    settings.with_names = args.with_names;
    Ok(settings)
}

/// All recordings that are named, in order.
fn recordings(args: &Args) -> Result<Vec<PathBuf>, Error> {
    let mut all = args.recordings.clone();
    if let Some(list) = &args.list {
        // Standard input by its name in the system.
        let file = if out::is_stdout(list) {
            Path::new("/dev/stdin")
        } else {
            list
        };
        let text = bounded::read_text(file, MAX_LIST).map_err(|source| taxel_io::Error::Open {
            file: list.clone(),
            source,
        })?;
        let text = text.ok_or_else(|| taxel_app::Error::TextLength {
            file: list.clone(),
            what: "a list of recordings",
            limit: MAX_LIST,
        })?;
        // As editors and `find` write lists, also with `-print0`.
        let text = text.trim_start_matches('\u{feff}');
        let names = text
            .split(['\n', '\0'])
            .map(|name| name.trim_end_matches('\r'));
        all.extend(
            names
                .filter(|name| !name.trim().is_empty())
                .map(PathBuf::from),
        );
    }
    if all.is_empty() {
        return Err(Error::Arguments {
            what: "no recording is named".to_owned(),
            hint: "name files, or a file with a recording a line by --list",
        });
    }
    Ok(all)
}

/// Refuses to replace what is read beside the recordings.
fn check_tables(args: &Args, counted: &Counted) -> Result<(), Error> {
    let mut files = Files::default().maybe_sensor(args.sensor.as_ref());
    let (list, model) = (args.list.as_ref(), args.method.file());
    files = files
        .maybe_input("list", list)
        .maybe_input("model", model.as_ref());
    files
        .maybe_output("the summary", counted.summary.as_ref())
        .maybe_output("the manifest", counted.manifest.as_ref())
        .check()
}

/// How far it is.
#[derive(Debug, Serialize)]
struct Counted {
    recordings: usize,
    /// All frames have an answer; of these found done already.
    done: usize,
    done_before: usize,
    incomplete: usize,
    broken: usize,
    frames: u64,
    seconds: f64,
    summary: Option<PathBuf>,
    manifest: Option<PathBuf>,
}

impl Counted {
    fn new(args: &Args, recordings: usize) -> Self {
        let name = |table: &str| {
            let name = match args.shard {
                Some(shard) => format!("{table}-{}.csv", shard.word()),
                None => format!("{table}.csv"),
            };
            (!args.no_summary).then(|| args.out.join(name))
        };
        Self {
            recordings,
            done: 0,
            done_before: 0,
            incomplete: 0,
            broken: 0,
            frames: 0,
            seconds: 0.0,
            summary: name("summary"),
            manifest: name("manifest"),
        }
    }

    fn add(&mut self, done: &Done) {
        match done.entry.status {
            Status::Done => self.done += 1,
            Status::Incomplete => self.incomplete += 1,
            Status::Broken => self.broken += 1,
        }
        if done.again {
            self.frames += done.entry.row.as_ref().map_or(0, |row| row.frames);
        } else {
            self.done_before += 1;
        }
    }

    fn so_far(&self) -> usize {
        self.done + self.incomplete + self.broken
    }
}

/// What is told of one recording.
fn line(counted: &Counted, done: &Done) -> String {
    let Entry {
        recording,
        status,
        error,
        row,
        ..
    } = &done.entry;
    let place = format!(
        "{}/{} {recording}: {}",
        counted.so_far(),
        counted.recordings,
        status.word()
    );
    if let Some(error) = error {
        return format!("{place}: {error}");
    }
    if !done.again {
        return format!("{place} before");
    }
    let Some(row) = row else { return place };
    let force = row.peak_force_n.map(|force| {
        let half = row.peak_force_half_width_n.filter(|half| *half > 0.0);
        match half.filter(|_| row.half_widths_of == NOISE_ALONE) {
            Some(half) => {
                let (force, half) = with_noise_alone(force, half);
                format!(", at most {force} ± {half} N (noise alone)")
            }
            None => {
                let (force, half) = with_error(force, row.peak_force_half_width_n);
                let half = half.map(|half| format!(" ± {half}")).unwrap_or_default();
                format!(", at most {force}{half} N")
            }
        }
    });
    let tare = row.tare_n.map(|tare| {
        let (tare, _) = with_error(tare, None);
        format!(", a tare of {tare} N taken off")
    });
    let mut lost = String::new();
    for (count, what) in [
        (row.skipped_frames, "left out"),
        (row.unsolved_frames, "without an answer"),
        (row.ambiguous_frames, "ambiguous"),
    ] {
        if count > 0 {
            lost += &format!(", {count} {what}");
        }
    }
    if !row.missing.is_empty() {
        lost += &format!(", {}", row.missing);
    }
    format!(
        "{place}, {} frames{}{}{lost}",
        row.frames,
        force.unwrap_or_default(),
        tare.unwrap_or_default()
    )
}

impl fmt::Display for Counted {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} recordings: {} done", self.recordings, self.done)?;
        for (count, what) in [
            (self.incomplete, "incomplete"),
            (self.broken, "broken"),
            (self.done_before, "of them done before"),
        ] {
            if count > 0 {
                write!(f, ", {count} {what}")?;
            }
        }
        write!(
            f,
            "; {} frames in {:.2} s, {:.1} frames/s",
            self.frames,
            self.seconds,
            self.frames as f64 / self.seconds.max(1e-9)
        )?;
        for file in [&self.summary, &self.manifest].into_iter().flatten() {
            write!(f, "\nwrote {}", file.display())?;
        }
        Ok(())
    }
}
