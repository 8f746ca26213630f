//! From a source to viewers and a file, while it happens.
//!
//!     source ──▶ recorder ──▶ file            one thread each; arrows are bounded queues
//!        └─────▶ engine ───▶ viewers
//!
//! A device never waits: the recorder's queue is long, and a disk that cannot keep up ends the recording, not the
//! reading; the engine takes the newest frames and leaves out what it has no time for.

mod desk;
mod details;
mod engine;
mod host;
mod newest;
mod player;
mod recorder;
mod source;

use std::path::PathBuf;
use std::sync::Arc;
use std::time::SystemTime;

use taxel::{Counts, Frame, Sensor};
use taxel_acquire::Address;
use taxel_acquire::transport::State;
use taxel_view::live::{Options as ServerOptions, Server};

use crate::error::Error;
use crate::unit::MethodName;
use desk::Desk;
use details::Details;
use engine::Engine;
use host::Bench;
pub(crate) use host::time_stamp;
use newest::Newest;
use recorder::Recorder;
pub(crate) use recorder::Wanted;

/// A frame of counts on its way.
#[derive(Clone)]
pub(crate) struct Arrived {
    frame: Arc<Frame<Counts>>,
    at: SystemTime,
}

/// What to run.
pub(crate) struct Options {
    pub(crate) address: Address,
    pub(crate) sensor: Sensor,
    /// Where the sensor comes from, for messages.
    pub(crate) sensor_file: PathBuf,
    pub(crate) method: MethodName,
    /// Where recordings go.
    pub(crate) folder: PathBuf,
    /// What is recorded beside the counts.
    pub(crate) wanted: Wanted,
    /// A recording to begin with.
    pub(crate) record: Option<PathBuf>,
    /// The server; none for a recording without viewers.
    pub(crate) server: Option<ServerOptions>,
}

/// A source, an engine, a recorder and a server at work. Dropped, all of them end, the recording whole.
pub(crate) struct Session {
    desk: Arc<Desk>,
    recorder: Arc<Recorder>,
    server: Option<Arc<Server>>,
    threads: Vec<std::thread::JoinHandle<()>>,
    incoming: Arc<Newest<Arrived>>,
    details: Arc<Details>,
}

impl Session {
    /// Starts everything.
    pub(crate) fn start(options: Options) -> Result<Self, Error> {
        let desk = Arc::new(Desk::new(&options));
        let incoming = Arc::new(Newest::new(engine::QUEUE));
        let recorder = Arc::new(Recorder::start(&options, desk.clone())?);
        let (controls, run) = source::prepare(&options)?;
        let (orders, taken) = std::sync::mpsc::channel();
        let details = Arc::new(Details::new(options.sensor_file.clone()));
        let mut engine = Engine::new(
            &options,
            desk.clone(),
            recorder.clone(),
            details.clone(),
            taken,
        )?;
        let bench = Arc::new(Bench::new(
            &options,
            desk.clone(),
            recorder.clone(),
            details.clone(),
            controls,
            orders,
        ));
        let server = match &options.server {
            None => None,
            Some(server) => {
                let address = server.address.clone();
                let started = Server::start(server, bench.clone());
                let started = started.map_err(|source| Error::Listen { address, source })?;
                Some(Arc::new(started))
            }
        };
        let mut threads = Vec::new();
        let spawn = |name: &str, run: Box<dyn FnOnce() + Send>| {
            std::thread::Builder::new()
                .name(name.to_owned())
                .spawn(run)
                .map_err(Error::Thread)
        };
        let (queue, with) = (incoming.clone(), server.clone());
        threads.push(spawn(
            "engine",
            Box::new(move || engine.run(&queue, with.as_deref())),
        )?);
        let worker = details.clone();
        threads.push(spawn("details", Box::new(move || worker.run()))?);
        if let Some(path) = &options.record {
            recorder.begin(path.clone())?;
        }
        let mut receiver = source::Intake {
            desk: desk.clone(),
            recorder: recorder.clone(),
            incoming: incoming.clone(),
            server: server.clone(),
            can_wait: matches!(
                options.address,
                Address::File { speed: None, .. }
                    | Address::Sim {
                        frames_per_second: None,
                        ..
                    }
            ),
        };
        threads.push(spawn("source", Box::new(move || run(&mut receiver)))?);
        Ok(Self {
            desk,
            recorder,
            server,
            threads,
            incoming,
            details,
        })
    }

    /// The address of the page.
    pub(crate) fn url(&self) -> Option<String> {
        self.server.as_ref().map(|server| server.url())
    }

    /// How the source stands, in words.
    pub(crate) fn state(&self) -> (State, String) {
        self.desk.device()
    }

    /// Frames received; lost, corrupt and repeated ones.
    pub(crate) fn tally(&self) -> taxel_acquire::protocol::Tally {
        self.desk.tally()
    }

    /// The recording as it stands: frames, bytes, and why it ended early, if it did.
    pub(crate) fn recording(&self) -> Option<desk::Recording> {
        self.desk.recording()
    }

    /// Begins a recording; it must not exist.
    pub(crate) fn record(&self, file: &std::path::Path) -> Result<(), Error> {
        self.recorder.begin(file.to_owned())
    }

    /// Ends the recording; the file is whole then.
    pub(crate) fn stop_recording(&self) {
        self.recorder.stop();
    }

    /// Ends everything and waits for the recording to be whole.
    pub(crate) fn end(&mut self) {
        self.desk.stop();
        self.incoming.close();
        self.details.close();
        self.recorder.finish();
        // Standard input may never say that it has ended: its thread goes with the program.
        let patience = std::time::Instant::now() + std::time::Duration::from_secs(2);
        for thread in self.threads.drain(..) {
            while !thread.is_finished() && std::time::Instant::now() < patience {
                std::thread::sleep(std::time::Duration::from_millis(5));
            }
            if thread.is_finished() {
                let _ = thread.join();
            }
        }
        self.server = None;
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        self.end();
    }
}
