//! `taxel live` and `taxel view`: what happens on the sensor, in the browser.

use std::path::{Path, PathBuf};
use std::time::SystemTime;

use taxel::Sensor;
use taxel_acquire::Address;

use crate::error::Error;
use crate::{Exit, interrupt, out};
use taxel_app::calibration_age::calibration_history;
use taxel_app::exported::exported_words;
use taxel_app::measure::regions_of_file;
use taxel_app::methods::MethodName;
use taxel_app::sensor_source;
use taxel_app::session::{FrameObserver, RecordTopics, Session, SessionOptions};

const SIMULATED: &str = "sim:econe?hand";

/// Show a sensor live in the browser, compensated; record it
///
/// Without an address: a simulated e-Cone gripped by a moving hand. Frames are screened, compensated and shown as they
/// come; recordings go to --folder. Ctrl-C ends it, a recording in progress whole.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Where frames come from: serial:/dev/ttyACM0?baud=2000000, udp:0.0.0.0:9000, tcp:host:port, file:run.mcap,
    /// stdin:, sim:econe?hand
    #[arg(default_value = SIMULATED)]
    address: Address,
    #[command(flatten)]
    shown: Shown,
    /// Begin a recording at once, to this file
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
}

/// Play a recording in the browser
#[derive(Debug, clap::Args)]
pub(crate) struct ViewArgs {
    /// Recording (.mcap, .parquet, .txt, .csv, .npy, .npz)
    recording: PathBuf,
    #[command(flatten)]
    shown: Shown,
}

#[derive(Debug, clap::Args)]
struct Shown {
    /// Sensor file, or the name of a preset; simulated sensors and .mcap and .parquet bring their own
    #[arg(long, value_name = "FILE|PRESET")]
    sensor: Option<PathBuf>,
    /// File of named regions (.toml) that the page shows from the start; without it those of the sensor file
    #[arg(long, value_name = "FILE")]
    regions: Option<PathBuf>,
    /// How loads are found: auto, exact, newton, raw, or the file of a model that `taxel train` wrote
    #[arg(long, value_name = "NAME|MODEL", default_value_t)]
    method: MethodName,
    #[command(flatten)]
    access: super::access::Access,
    /// Where recordings go
    #[arg(long, value_name = "FOLDER", default_value = "recordings")]
    folder: PathBuf,
    /// Record the compensated loads and the figures beside the counts
    #[arg(long)]
    loads: bool,
    /// Record the loads as images and the total as a wrench besides, which ROS 2 and Rerun know
    #[arg(long, requires = "loads")]
    images: bool,
    /// Show the loads in Foxglove as well: it connects to ws://HOST:PORT (Open connection, Foxglove WebSocket)
    #[arg(long, value_name = "HOST:PORT", num_args = 0..=1, default_missing_value = "127.0.0.1:8765", require_equals = true)]
    foxglove: Option<String>,
}

/// Runs `taxel live`.
pub(crate) fn run(args: &Args) -> Result<Exit, Error> {
    if let Some(file) = &args.record {
        super::record::check_recording("--record", file)?;
    }
    show(&args.address, &args.shown, args.record.as_deref(), false)
}

/// Runs `taxel view`.
pub(crate) fn run_view(args: &ViewArgs) -> Result<Exit, Error> {
    let address = Address::File {
        path: args.recording.clone(),
        speed: Some(1.0),
    };
    show(&address, &args.shown, None, true)
}

/// A server for Foxglove; says where it listens.
#[cfg(feature = "foxglove")]
fn foxglove(address: &str, sensor: &Sensor) -> Result<FrameObserver, Error> {
    let (observer, port) = taxel_app::foxglove::foxglove(address, sensor)?;
    let host = address.rsplit_once(':').map_or(address, |(host, _)| host);
    out::note(&format!("Foxglove connects to ws://{host}:{port}"));
    if !matches!(host, "127.0.0.1" | "localhost" | "[::1]") {
        out::note("whoever reaches that port sees the loads: its protocol knows no token");
    }
    Ok(observer)
}

/// This build has none.
#[cfg(not(feature = "foxglove"))]
fn foxglove(address: &str, _: &Sensor) -> Result<FrameObserver, Error> {
    Err(Error::Arguments {
        what: format!("--foxglove={address}: this build has no Foxglove"),
        hint: "`cargo install --path crates/taxel-cli --features foxglove`",
    })
}

fn show(
    address: &Address,
    shown: &Shown,
    record: Option<&Path>,
    held: bool,
) -> Result<Exit, Error> {
    let (sensor, sensor_file) = sensor_source::of(address, shown.sensor.as_deref())?;
    let history = calibration_history(&sensor, Some(SystemTime::now()));
    interrupt::listen();
    let regions = shown.regions.as_ref();
    let regions = regions
        .map(|file| regions_of_file(file, &sensor))
        .transpose()?;
    let mut options = SessionOptions::new(address.clone(), sensor, sensor_file);
    options.regions = regions;
    options.method = shown.method.clone();
    options.folder = shown.folder.clone();
    options.topics = RecordTopics {
        loads: shown.loads,
        figures: shown.loads,
        images: shown.images,
    };
    options.server = Some(shown.access.server()?);
    options.record = record.map(Path::to_owned);
    options.held = held;
    if let Some(address) = &shown.foxglove {
        options.observer = Some(foxglove(address, &options.sensor)?);
    }
    let exported = exported_words(&options.sensor);
    let mut session = Session::start(options)?;
    if let Some(words) = exported {
        out::note(&words);
    }
    out::result(&session.urls().join("\n"))?;
    out::note(&format!("{address}; Ctrl-C ends it"));
    if let Some(history) = history {
        out::note(&format!("sensor: {history}"));
    }
    let mut told = String::new();
    while !interrupt::asked() {
        let (_, text) = session.state();
        if text != told {
            out::note(&text);
            told = text;
        }
        for line in session.take_messages() {
            out::note(&line);
        }
        std::thread::sleep(std::time::Duration::from_millis(100));
    }
    session.end();
    super::record::conclude(&session)
}
