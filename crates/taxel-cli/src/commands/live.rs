//! `taxel live` and `taxel view`: what happens on the sensor, in the browser.

use std::path::{Path, PathBuf};
use std::time::SystemTime;

use taxel::Sensor;
use taxel_acquire::Address;

use crate::error::Error;
use crate::{Exit, interrupt, out, recorded};
use taxel_app::calibration_age::calibration_history;
use taxel_app::exported::exported_words;
use taxel_app::measure::{recording_regions_of_file, regions_of_file};
use taxel_app::methods::MethodName;
use taxel_app::sensor_source;
use taxel_app::session::{FrameObserver, RecordTopics, Session, SessionOptions};
use taxel_server::{Options as ServerOptions, random_token};

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
    /// A second recording beside the first, on a page of its own: one scale of colours, one axis of time, both played together
    #[arg(long, value_name = "FILE")]
    beside: Option<PathBuf>,
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
    /// Keep in the header of what is recorded what a file of another program says of persons, and names of files; left out else
    #[arg(long)]
    with_names: bool,
    /// Show the loads in Foxglove as well: it connects to ws://HOST:PORT (Open connection, Foxglove WebSocket)
    #[arg(long, value_name = "HOST:PORT", num_args = 0..=1, default_missing_value = "127.0.0.1:8765", require_equals = true)]
    foxglove: Option<String>,
}

/// Runs `taxel live`.
pub(crate) fn run(args: &Args) -> Result<Exit, Error> {
    if let Some(file) = &args.record {
        super::record::check_recording("--record", file)?;
    }
    let record = args.record.as_deref();
    show(begin(&args.address, &args.shown, record, false)?, None)
}

/// Runs `taxel view`.
pub(crate) fn run_view(args: &ViewArgs) -> Result<Exit, Error> {
    let played = |path: &PathBuf| Address::File {
        path: path.clone(),
        speed: Some(1.0),
    };
    let Some(beside) = &args.beside else {
        return show(
            begin(&played(&args.recording), &args.shown, None, true)?,
            None,
        );
    };
    let (address, second) = (played(&args.recording), played(beside));
    if let Some(file) = &args.shown.regions {
        // Regions that move are of one recording.
        regions_of_file(file, &sensor_of(&address, &args.shown)?)?;
    }
    let sensors = [&address, &second].map(|address| sensor_of(address, &args.shown));
    let [first, other] = sensors;
    can_be_beside(&args.recording, &first?, beside, &other?)?;
    let first = begin(&address, &args.shown, None, true)?;
    let second = begin_beside(&second, &args.shown)?;
    show(first, Some(second))
}

/// Loads are compared with loads: one scale of colours has one unit.
fn can_be_beside(
    first: &Path,
    sensor: &Sensor,
    second: &Path,
    other: &Sensor,
) -> Result<(), Error> {
    let has_loads = |sensor: &Sensor| sensor.material().is_some() || sensor.exported().is_some();
    if has_loads(sensor) == has_loads(other) {
        return Ok(());
    }
    let (with, without) = if has_loads(sensor) {
        (first, second)
    } else {
        (second, first)
    };
    Err(Error::Arguments {
        what: format!(
            "--beside: {} has loads, and the sensor of {} has no load law ([material])",
            with.display(),
            without.display()
        ),
        hint: "--sensor takes one sensor file for both",
    })
}

fn sensor_of(address: &Address, shown: &Shown) -> Result<Sensor, Error> {
    Ok(sensor_source::of(address, shown.sensor.as_deref())?.0)
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

/// A session that has begun, and what is to be said of it.
struct Begun {
    session: Session,
    address: String,
    exported: Option<String>,
    history: Option<String>,
}

fn begin(
    address: &Address,
    shown: &Shown,
    record: Option<&Path>,
    held: bool,
) -> Result<Begun, Error> {
    let mut options = options(address, shown)?;
    options.server = Some(shown.access.server()?);
    options.record = record.map(Path::to_owned);
    options.held = held;
    if let Some(address) = &shown.foxglove {
        options.observer = Some(foxglove(address, &options.sensor)?);
    }
    started(address, options)
}

/// The same for what stands beside. Its server is reached by way of the first one's page; alone it knows only whoever guesses its
/// token.
fn begin_beside(address: &Address, shown: &Shown) -> Result<Begun, Error> {
    let mut options = options(address, shown)?;
    let mut server = ServerOptions::new("127.0.0.1:0");
    server.token = Some(random_token());
    options.server = Some(server);
    options.held = true;
    started(address, options)
}

fn started(address: &Address, options: SessionOptions) -> Result<Begun, Error> {
    Ok(Begun {
        address: address.to_string(),
        exported: exported_words(&options.sensor),
        history: calibration_history(&options.sensor, Some(SystemTime::now())),
        session: Session::start(options)?,
    })
}

fn options(address: &Address, shown: &Shown) -> Result<SessionOptions, Error> {
    let (sensor, sensor_file) = sensor_source::of(address, shown.sensor.as_deref())?;
    let sensor = recorded::named_of(address, sensor, shown.with_names)?;
    interrupt::listen();
    let regions = shown.regions.as_ref();
    let regions = regions
        .map(|file| match address {
            Address::File { .. } => recording_regions_of_file(file, &sensor),
            _ => regions_of_file(file, &sensor),
        })
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
    Ok(options)
}

/// Shows it until Ctrl-C, with what stands beside.
fn show(first: Begun, beside: Option<Begun>) -> Result<Exit, Error> {
    let urls = match &beside {
        Some(beside) => first.session.show_beside(&beside.session),
        None => first.session.urls(),
    };
    let mut all: Vec<Begun> = [Some(first), beside].into_iter().flatten().collect();
    all.iter()
        .filter_map(|begun| begun.exported.as_ref())
        .for_each(|words| out::note(words));
    out::result(&urls.join("\n"))?;
    let addresses: Vec<&str> = all.iter().map(|begun| begun.address.as_str()).collect();
    out::note(&format!("{}; Ctrl-C ends it", addresses.join(" beside ")));
    for history in all.iter().filter_map(|begun| begun.history.as_ref()) {
        out::note(&format!("sensor: {history}"));
    }
    let mut told = vec![String::new(); all.len()];
    while !interrupt::asked() {
        for (begun, told) in all.iter().zip(&mut told) {
            let (_, text) = begun.session.state();
            if text != *told {
                out::note(&text);
                *told = text;
            }
            for line in begun.session.take_messages() {
                out::note(&line);
            }
        }
        std::thread::sleep(std::time::Duration::from_millis(100));
    }
    all.iter_mut().for_each(|begun| begun.session.end());
    super::record::conclude(&all[0].session)
}
