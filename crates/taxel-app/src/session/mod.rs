//! From a source to viewers and a file, while it happens.
//!
//! ```text
//! source ──▶ recorder ──▶ file            one thread each; arrows are bounded queues
//!    └─────▶ engine ───▶ viewers
//! ```
//!
//! A device never waits: the recorder's queue is long, and a disk that cannot keep up ends the recording, not the
//! reading; the engine takes the newest frames and leaves out what it has no time for.

mod controller;
mod curve;
mod details;
mod engine;
mod guide;
mod host_clock;
mod latest_queue;
mod pace;
mod player;
mod recorder;
mod sensor_facts;
mod sliders;
mod source;
mod status;
mod sync;

use std::path::PathBuf;
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::{Duration, Instant, SystemTime};

use taxel::metric::FrameFigures;
use taxel::sensor::Region;
use taxel::{Counts, Frame, Newtons, Sensor, Siemens};
use taxel_acquire::Address;
use taxel_acquire::simulated::{Person, Presser};
use taxel_acquire::transport::State;
use taxel_server::{BadLines, Options as ServerOptions, Server};

use crate::error::Error;
use crate::methods::MethodName;
use controller::LiveController;
pub use controller::time_stamp;
use curve::CurveFinder;
use details::Details;
use engine::Engine;
pub use guide::{Guide, GuideStep};
use host_clock::HostClock;
use latest_queue::LatestQueue;
use pace::Pace;
use recorder::Owner;
use recorder::Recorder;
pub use recorder::{RecordTopics, SavedRecording};
pub use status::Recording;
use status::SessionStatus;

/// Bits of a count in recordings and in what viewers get.
const MAX_BITS: u32 = 16;
/// Frames whose loads are wanted and that may wait for the engine, and the memory for them.
const MAX_WAITING: usize = 8192;
const MAX_WAITING_BYTES: usize = 64 << 20;

/// A frame of counts on its way.
#[derive(Clone)]
pub struct TimestampedFrame {
    frame: Arc<Frame<Counts>>,
    at: SystemTime,
    /// Of a recording: what was taken off when it was made.
    tare: Option<Option<Arc<taxel_io::Tare>>>,
}

/// What to run: [`SessionOptions::new`], and what is to be different.
#[non_exhaustive]
pub struct SessionOptions {
    /// Where frames come from.
    pub address: Address,
    /// The sensor that they are of.
    pub sensor: Sensor,
    /// Named parts of it that viewers are told of, where that are others than the sensor's own.
    pub regions: Option<Vec<Region>>,
    /// Where the sensor comes from, for messages.
    pub sensor_file: PathBuf,
    /// How loads are found.
    pub method: MethodName,
    /// Where viewers' recordings go.
    pub folder: PathBuf,
    /// What is recorded beside the counts.
    pub topics: RecordTopics,
    /// A recording to begin with.
    pub record: Option<PathBuf>,
    /// The most frames of that.
    pub max_frames: Option<u64>,
    /// A file is held at its first frame.
    pub held: bool,
    /// The server; none for a session without viewers.
    pub server: Option<ServerOptions>,
    /// Who leads through the session; while one does, viewers cannot change what is measured.
    pub guide: Option<Arc<dyn Guide>>,
    /// Called with every frame that is solved, on the engine's thread. One that takes longer than a frame lasts makes the
    /// engine leave frames out, never the recording.
    pub observer: Option<FrameObserver>,
    /// Called with every frame as it comes, on the source's thread: it must not wait.
    pub counts_observer: Option<CountsObserver>,
}

impl SessionOptions {
    /// A session that only reads: no viewers, no recording.
    pub fn new(address: Address, sensor: Sensor, sensor_file: impl Into<PathBuf>) -> Self {
        Self {
            address,
            sensor,
            regions: None,
            sensor_file: sensor_file.into(),
            method: MethodName::Auto,
            folder: PathBuf::from("recordings"),
            topics: RecordTopics::default(),
            record: None,
            max_frames: None,
            held: false,
            server: None,
            guide: None,
            observer: None,
            counts_observer: None,
        }
    }
}

/// What is called with every frame as it comes.
pub type CountsObserver = Box<dyn FnMut(&Frame<Counts>) + Send>;

/// What is called with every frame that is solved.
pub type FrameObserver = Box<dyn FnMut(&LiveFrame) + Send>;

/// A frame that was solved a moment ago.
#[non_exhaustive]
pub struct LiveFrame<'a> {
    /// As they came.
    pub counts: &'a Frame<Counts>,
    /// Conductances of the taxels, with marks; none where a learned model estimates the loads.
    pub siemens: Option<&'a Frame<Siemens>>,
    /// Loads, the tare taken off, with marks; none without a load law.
    pub loads: Option<&'a Frame<Newtons>>,
    /// Total force, peak pressure, contact area, centre of pressure; zeros without a load law.
    pub figures: &'a FrameFigures,
    /// Whether the inverse came to an answer.
    pub is_answer: bool,
    /// When the frame arrived.
    pub at: SystemTime,
}

/// Frames that may wait for the engine. Viewers want the newest; a recording without viewers wants the loads of every
/// frame, late ones too, as far as memory goes.
fn queue_of(options: &SessionOptions) -> usize {
    if options.server.is_some() || !options.topics.any() {
        return engine::QUEUE;
    }
    let bytes = 9 * options.sensor.rows() * options.sensor.columns();
    (MAX_WAITING_BYTES / bytes).clamp(engine::QUEUE, MAX_WAITING)
}

/// Refuses counts wider than what is recorded and sent.
fn check_bits(options: &SessionOptions) -> Result<(), Error> {
    let bits = options.sensor.converter().bits;
    if bits > MAX_BITS {
        Err(Error::TooManyBits {
            file: options.sensor_file.clone(),
            bits,
        })
    } else {
        Ok(())
    }
}

/// The server, where there is to be one.
fn serve(
    options: &SessionOptions,
    controller: Arc<LiveController>,
) -> Result<Option<Arc<Server>>, Error> {
    let Some(server) = &options.server else {
        return Ok(None);
    };
    let address = server.address.clone();
    let started = Server::start(server, controller);
    let started = started.map_err(|source| Error::Listen { address, source })?;
    Ok(Some(Arc::new(started)))
}

/// Whether the source holds what the disk has no time for: a pipe, and what gives frames as fast as they are taken.
fn waits_for_disk(address: &Address) -> bool {
    can_wait(address) || matches!(address, Address::Stdin { .. })
}

/// Whether the source gives frames as fast as they are taken: then it waits for the engine, and nothing is left out.
fn can_wait(address: &Address) -> bool {
    matches!(
        address,
        Address::File { speed: None, .. }
            | Address::Sim {
                frames_per_second: None,
                ..
            }
    )
}

/// Whether frames are measured as they come; those of files and of virtual sensors have times of their own.
fn is_device(address: &Address) -> bool {
    !matches!(address, Address::File { .. } | Address::Sim { .. })
}

fn spawn(name: &str, run: impl FnOnce() + Send + 'static) -> Result<JoinHandle<()>, Error> {
    std::thread::Builder::new()
        .name(name.to_owned())
        .spawn(run)
        .map_err(Error::Thread)
}

/// The address of another page of the same server.
pub(crate) fn page_url(url: &str, page: &str) -> String {
    match url.split_once('?') {
        Some((place, query)) => format!("{place}{page}?{query}"),
        None => format!("{url}{page}"),
    }
}

/// A source, an engine, a recorder and a server at work. Dropped, all of them end, the recording whole.
pub struct Session {
    status: Arc<SessionStatus>,
    recorder: Arc<Recorder>,
    server: Option<Arc<Server>>,
    source: Option<JoinHandle<()>>,
    threads: Vec<JoinHandle<()>>,
    finished: bool,
    incoming: Arc<LatestQueue<TimestampedFrame>>,
    details: Arc<Details>,
    controller: Arc<LiveController>,
    person: Option<Person>,
    presser: Option<Presser>,
}

impl Session {
    /// Starts everything.
    ///
    /// # Errors
    /// A sensor or a method that makes no sense, a source that cannot be opened, a recording that exists, an address that
    /// cannot be listened on.
    pub fn start(mut options: SessionOptions) -> Result<Self, Error> {
        check_bits(&options)?;
        let observer = options.observer.take();
        let status = Arc::new(SessionStatus::new(&options));
        let incoming = Arc::new(LatestQueue::new(queue_of(&options)));
        let recorder = Arc::new(Recorder::start(
            &options,
            status.clone(),
            waits_for_disk(&options.address),
        )?);
        let source::Prepared {
            controls,
            person,
            presser,
            curve,
            run,
        } = source::prepare(&options)?;
        let (commands, taken) = std::sync::mpsc::channel();
        let details = Arc::new(Details::new(options.sensor_file.clone()));
        let mut engine = Engine::new(
            &options,
            status.clone(),
            recorder.clone(),
            details.clone(),
            taken,
            observer,
        )?;
        let controller = Arc::new(LiveController::new(
            &options,
            status.clone(),
            recorder.clone(),
            details.clone(),
            controls,
            commands,
        ));
        let server = serve(&options, controller.clone())?;
        let (queue, with, worker) = (incoming.clone(), server.clone(), details.clone());
        // From here on what has begun ends with it, also where the rest fails.
        let mut session = Self {
            status,
            recorder: recorder.clone(),
            server,
            source: None,
            threads: Vec::new(),
            finished: false,
            incoming,
            details,
            controller,
            person,
            presser,
        };
        let engine = spawn("engine", move || engine.run(&queue, with.as_deref()))?;
        session.threads.push(engine);
        let details = spawn("details", move || worker.run())?;
        session.threads.push(details);
        if let Some(path) = &options.record {
            recorder.begin(path.clone(), Owner::Operator, options.max_frames)?;
        }
        session.find_curve(curve)?;
        let mut receiver = session.sink(&options.address, options.counts_observer.take());
        session.source = Some(spawn("source", move || run(&mut receiver))?);
        Ok(session)
    }

    /// Finds the whole of the recording that is played, and tells viewers.
    fn find_curve(&mut self, finder: Option<CurveFinder>) -> Result<(), Error> {
        let Some((server, finder)) = self.server.clone().zip(finder) else {
            return Ok(());
        };
        let (status, controller) = (self.status.clone(), self.controller.clone());
        let find = move || {
            // What cannot be read is told when it is played.
            if let Ok(Some(curve)) = finder.find(&|| status.is_stopped()) {
                controller.set_curve(curve);
                server.tell_curve();
            }
        };
        self.threads.push(spawn("curve", find)?);
        Ok(())
    }

    /// Where the source's frames go.
    fn sink(
        &self,
        address: &Address,
        counts_observer: Option<CountsObserver>,
    ) -> source::FrameSink {
        source::FrameSink {
            status: self.status.clone(),
            recorder: self.recorder.clone(),
            incoming: self.incoming.clone(),
            server: self.server.clone(),
            reported: Default::default(),
            clock: None,
            tare: None,
            can_wait: can_wait(address),
            host_clock: HostClock::start(is_device(address)),
            pace: is_device(address).then(Pace::default),
            counts_observer,
        }
    }

    /// The addresses of the page.
    pub fn urls(&self) -> Vec<String> {
        self.server
            .as_ref()
            .map_or_else(Vec::new, |server| server.urls())
    }

    /// Shows what another session shows beside its own: gives the addresses of the page that has both.
    pub fn show_beside(&self, other: &Self) -> Vec<String> {
        let Some((own, others)) = self.server.as_ref().zip(other.server.as_ref()) else {
            return Vec::new();
        };
        own.show_beside(others);
        let urls = own.urls();
        urls.iter().map(|url| page_url(url, "beside")).collect()
    }

    /// The simulated person who grips, where the source has one.
    pub fn person(&self) -> Option<&Person> {
        self.person.as_ref()
    }

    /// The simulated operator who lays weights on the sensor, where the source is simulated.
    pub fn presser(&self) -> Option<&Presser> {
        self.presser.as_ref()
    }

    /// Takes the mean of the next frames for nothing; [`Session::zero`] gives it when it is there. `force`: though there is load on
    /// the sensor.
    ///
    /// # Errors
    /// How much load there is, in words.
    pub fn take_zero(&self, force: bool) -> Result<String, String> {
        let done = self.controller.tare(force);
        done.map(|reply| reply.text)
            .map_err(|refused| refused.to_string())
    }

    /// What is taken off every taxel, and since when; `None` where nothing is.
    pub fn zero(&self) -> Option<taxel_io::Tare> {
        self.recorder.taken_off()
    }

    /// Notes something that happens now in the recording, where there is one.
    pub fn mark(&self, text: &str) {
        self.recorder.event("mark", text);
    }

    /// Tells all viewers how things stand now. Not to be called by a guide that is being asked.
    pub fn tell_viewers(&self) {
        if let Some(server) = &self.server {
            server.tell_state();
        }
    }

    /// Lines that are dead or flicker, of those looked at so far.
    pub fn bad_lines(&self) -> BadLines {
        self.status.state(0).bad_lines
    }

    /// Frames a second of the source.
    pub fn frames_per_second(&self) -> f64 {
        self.status.frames_per_second()
    }

    /// How the source stands, in words.
    pub fn state(&self) -> (State, String) {
        self.status.device()
    }

    /// Whether the source has ended and all that came of it was solved, and shown to the observer.
    pub fn has_ended(&self) -> bool {
        self.state().0 == State::Ended && self.incoming.is_idle()
    }

    /// Frames that the engine had no time for.
    pub fn left_out(&self) -> u64 {
        self.status.skipped()
    }

    /// Frames received; lost, corrupt and repeated ones.
    pub fn link_stats(&self) -> taxel_acquire::protocol::LinkStats {
        self.status.link_stats()
    }

    /// The recording as it stands: frames, bytes, and why it ended early, if it did.
    pub fn recording(&self) -> Option<Recording> {
        self.recorder.check();
        self.status.recording()
    }

    /// Lines that the command line should say: recordings that begin and end, devices.
    pub fn take_messages(&self) -> Vec<String> {
        self.status.take_messages()
    }

    /// Recordings that have ended.
    pub fn ended(&self) -> Vec<SavedRecording> {
        self.status.ended()
    }

    /// Begins a recording of at most `most` frames; it must not exist.
    pub fn record(&self, file: &std::path::Path, most: Option<u64>) -> Result<(), Error> {
        self.recorder.begin(file.to_owned(), Owner::Operator, most)
    }

    /// Ends the recording and gives what is in it, when the file is closed.
    pub fn stop_recording(&self) -> Option<SavedRecording> {
        self.recorder.stop()
    }

    /// Ends everything and waits for the recording to be whole: first the source, then the engine when it has had
    /// every frame that waits, then the recorder.
    pub fn end(&mut self) {
        self.status.stop();
        // Standard input may never say that it has ended: its thread goes with the program.
        if let Some(source) = self.source.take() {
            let patience = Instant::now() + Duration::from_secs(2);
            while !source.is_finished() && Instant::now() < patience {
                std::thread::sleep(Duration::from_millis(5));
            }
            if source.is_finished() {
                let _ = source.join();
            }
        }
        self.incoming.close();
        self.details.close();
        for thread in self.threads.drain(..) {
            if thread.join().is_err() {
                self.status
                    .tell("error: a thread failed; what it did is missing".to_owned());
            }
        }
        if !std::mem::replace(&mut self.finished, true) {
            self.recorder.finish();
        }
        self.server = None;
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        self.end();
    }
}
