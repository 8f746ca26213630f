//! `taxel identify`: which read-out explains recordings.

use std::path::PathBuf;

use taxel::identify::Verdict;
use taxel_app::executor::Threads;
use taxel_app::identify::IdentifyFiles;

use super::positive::lines;
use crate::error::Error;
use crate::outputs::Files;
use crate::progress::Terminal;
use crate::{Exit, out, recorded};

/// Tell which read-out explains recordings, and what to measure where several do
///
/// For a mat that was built or bought without a word of how its lines end. Some frames must be pressed in some places and
/// not in others. Each of the six read-outs is fitted to the most telling frames and ranked; likely numbers are told, and
/// what to measure with a multimeter where frames leave several. Of a sensor file shape, converter, V_t and resistor are
/// taken; its read-out is not believed. Exit code 3: none explains the frames, or they cannot tell.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Recordings (.mcap, .parquet, .txt, .csv, .npy, .npz) of one sensor
    #[arg(required = true, value_name = "RECORDING")]
    recordings: Vec<PathBuf>,
    /// What is known: sensor file, or the name of a preset; .mcap and .parquet bring their own
    #[arg(long, value_name = "FILE|PRESET")]
    sensor: Option<PathBuf>,
    /// Rows of a frame, where there is no sensor
    #[arg(long, value_name = "N", conflicts_with = "sensor", value_parser = lines)]
    rows: Option<usize>,
    /// Uniform loads: CSV with recording, frame, load_g, as `taxel calibrate` takes it
    #[arg(long, value_name = "FILE")]
    equilibration: Option<PathBuf>,
    /// The recordings have rows and columns swapped
    #[arg(long)]
    transpose: bool,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<Exit, Error> {
    let recordings = args.recordings.iter();
    recordings
        .fold(Files::default(), |all, file| all.input("recording", file))
        .maybe_sensor(args.sensor.as_ref())
        .maybe_table("table of uniform loads", args.equilibration.as_ref())
        .check()?;
    let carried = args.recordings.first().filter(|_| args.rows.is_none());
    let sensor = recorded::sensor(args.sensor.as_deref(), carried.map(PathBuf::as_path))?;
    if let Some((sensor, _)) = sensor
        .as_ref()
        .filter(|(sensor, _)| sensor.material().is_some())
    {
        recorded::needs_readings(sensor)?;
    }
    let mut files = IdentifyFiles::default();
    files.recordings.clone_from(&args.recordings);
    files.sensor = sensor.map(|(sensor, _)| sensor);
    files.rows = args.rows;
    files.equilibration.clone_from(&args.equilibration);
    files.transpose = args.transpose;
    let identified = files.identify(&Threads, &Terminal)?;
    for assumed in &identified.assumed {
        out::note(&format!("assumed: {assumed}"));
    }
    if !identified.is_whole {
        out::warn("recordings tell of frames that are missing");
    }
    let identification = &identified.identification;
    if args.json {
        out::json(&identified)?
    } else {
        out::result(&identification.to_string())?
    }
    let told = matches!(identification.verdict, Verdict::One | Verdict::Alike);
    Ok(if told && identified.is_whole {
        Exit::Good
    } else {
        Exit::DataLost
    })
}
