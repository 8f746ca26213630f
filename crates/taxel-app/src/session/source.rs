//! Where frames come from: a device, a file, a virtual sensor.

use std::path::Path;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant, SystemTime};

use taxel::simulate::Pattern;
use taxel::{Counts, Frame, Sensor};
use taxel_acquire::Address;
use taxel_acquire::protocol::{Expected, LinkStats, Protocol};
use taxel_acquire::simulated::{Person, Presser, Simulated, SimulationParameters};
use taxel_acquire::transport::{Receiver, State, receive};
use taxel_server::{DeviceState, Server};

use super::curve::CurveFinder;
use super::engine::{exact_name, gives_loads};
use super::host_clock::HostClock;
use super::latest_queue::LatestQueue;
use super::pace::{self, Pace};
use super::player::{PlaybackRequest, Player};
use super::recorder::Recorder;
use super::status::{SessionStatus, shown};
use super::{CountsObserver, SessionOptions, TimestampedFrame};
use crate::error::Error;
use crate::sensor_source;

/// What can be done with the source while it runs.
#[derive(Clone)]
pub(super) enum Controls {
    /// Nothing: a device.
    Device,
    /// Knobs of a virtual sensor.
    Simulation(Arc<Mutex<SimulationParameters>>),
    /// A file's player.
    Player(Arc<Mutex<PlaybackRequest>>),
}

type Run = Box<dyn FnOnce(&mut FrameSink) + Send>;

/// A source that is ready.
pub(super) struct Prepared {
    pub(super) controls: Controls,
    /// A simulated person, who can be told what to do.
    pub(super) person: Option<Person>,
    /// A simulated operator, who lays weights as told.
    pub(super) presser: Option<Presser>,
    /// Finds the whole of a recording that somebody looks at.
    pub(super) curve: Option<CurveFinder>,
    /// Runs until it is stopped.
    pub(super) run: Run,
}

/// Makes the source ready.
pub(super) fn prepare(options: &SessionOptions) -> Result<Prepared, Error> {
    let mut person = None;
    let mut presser = None;
    let mut curve = None;
    let (controls, run) = match &options.address {
        Address::Sim {
            sensor,
            pattern,
            frames_per_second,
            seed,
        } => {
            let pattern = Pattern::named(pattern).expect("the address was checked");
            let scanned = sensor_source::simulated(sensor, &options.sensor)?;
            let source = Simulated::new(&scanned, pattern, *seed, *frames_per_second)?;
            let parameters = source.parameters();
            person = source.person();
            presser = Some(source.presser());
            let run: Run = Box::new(move |sink| source.run(sink));
            (Controls::Simulation(parameters), run)
        }
        Address::File { path, speed } => {
            let is_shown = options.server.is_some();
            let player = Player::open(path, &options.sensor, *speed, !options.held, is_shown)?;
            curve = curve_finder(options, &player)?;
            let play = player.play();
            let run: Run = Box::new(move |sink| player.run(sink));
            (Controls::Player(play), run)
        }
        Address::Board { path } => (Controls::Device, board(path, &options.sensor)?),
        address => {
            let protocol = match address {
                Address::Serial { protocol, .. }
                | Address::Udp { protocol, .. }
                | Address::Tcp { protocol, .. }
                | Address::Stdin { protocol } => *protocol,
                _ => Protocol::Auto,
            };
            let expected = Expected::of(&options.sensor);
            let address = address.clone();
            let run: Run = Box::new(move |sink| {
                let mut decoder = protocol.decoder(expected);
                receive(&address, &mut *decoder, sink);
            });
            (Controls::Device, run)
        }
    };
    Ok(Prepared {
        controls,
        person,
        presser,
        curve,
        run,
    })
}

/// Who finds the whole of a recording, where somebody looks at it and it holds loads.
fn curve_finder(options: &SessionOptions, player: &Player) -> Result<Option<CurveFinder>, Error> {
    let is_shown = options.server.is_some() && gives_loads(&options.sensor, &options.method);
    let Some(recorded) = player.recorded().filter(|_| is_shown) else {
        return Ok(None);
    };
    let pipeline = options
        .method
        .pipeline(&options.sensor, &options.sensor_file)?;
    Ok(Some(CurveFinder {
        recorded,
        sensor: options.sensor.clone(),
        method: exact_name(&pipeline, &options.method),
        pipeline,
    }))
}

/// The longest description of a board, bytes.
#[cfg(feature = "rpi")]
const MAX_BOARD: u64 = 1 << 20;

/// This machine's own pins.
#[cfg(feature = "rpi")]
fn board(path: &Path, sensor: &Sensor) -> Result<Run, Error> {
    use taxel_acquire::scan::{config, rpi};

    let wrong = |reason| Error::Board {
        file: path.to_owned(),
        reason,
    };
    let text = taxel_io::bounded::read_text(path, MAX_BOARD);
    let text = text.map_err(|error| wrong(error.to_string()))?;
    let text = text.ok_or_else(|| wrong(format!("more than {MAX_BOARD} bytes")))?;
    let board = config::Board::from_toml(&text).map_err(|bad| wrong(bad.to_string()))?;
    let found = (
        usize::from(board.rows.count),
        usize::from(board.columns.count),
    );
    if found != (sensor.rows(), sensor.columns()) {
        return Err(wrong(format!(
            "{} rows x {} columns, but the sensor has {} x {}",
            found.0,
            found.1,
            sensor.rows(),
            sensor.columns()
        )));
    }
    Ok(Box::new(move |sink| rpi::receive(&board, sink)))
}

#[cfg(not(feature = "rpi"))]
fn board(path: &Path, _: &Sensor) -> Result<Run, Error> {
    Err(Error::Board {
        file: path.to_owned(),
        reason: "this program was built without the pins of a Linux board".to_owned(),
    })
}

/// Takes frames in: to the recorder, then to the engine; a device's wait for neither.
pub(super) struct FrameSink {
    pub(super) status: Arc<SessionStatus>,
    pub(super) recorder: Arc<Recorder>,
    pub(super) incoming: Arc<LatestQueue<TimestampedFrame>>,
    pub(super) server: Option<Arc<Server>>,
    /// The source has no pace of its own: it waits rather than lose a frame.
    pub(super) can_wait: bool,
    /// What has been reported of what went wrong, and when.
    pub(super) reported: (LinkStats, Option<Instant>),
    /// The device's time, of the last frame.
    pub(super) clock: Option<f64>,
    /// Of a recording: what was taken off the frame that comes.
    pub(super) tare: Option<Option<Arc<taxel_io::Tare>>>,
    /// This computer's clocks.
    pub(super) host_clock: HostClock,
    /// Of a device: how many frames a second are usual.
    pub(super) pace: Option<Pace>,
    /// Who gets every frame as it comes.
    pub(super) counts_observer: Option<CountsObserver>,
}

/// A device's clock that goes on by more than this between two frames has jumped, seconds.
const MAX_STEP: f64 = 3600.0;

/// What goes wrong is told this often.
const LOSSES_EVERY: Duration = Duration::from_secs(1);

impl FrameSink {
    /// A frame that was shown before, for those who have come since.
    pub(super) fn again(&self, frame: &Frame<Counts>) {
        self.incoming.push(TimestampedFrame {
            frame: Arc::new(frame.clone()),
            at: SystemTime::now(),
            tare: self.tare.clone(),
        });
    }

    /// Notes in the recording a device's clock that jumps.
    fn look_at_clock(&mut self, frame: &Frame<Counts>) {
        let Some(secs) = frame.time_secs else { return };
        if let Some(last) = self.clock.replace(secs)
            && !(0.0..=MAX_STEP).contains(&(secs - last))
        {
            let text = format!("the device's clock jumps from {last:.3} s to {secs:.3} s");
            self.recorder.event("clock", &text);
        }
    }

    /// Notes in the recording, and says, a wall clock that was set.
    fn look_at_host_clock(&mut self, at: SystemTime, now: Instant) {
        if let Some(words) = self.host_clock.jump(at, now) {
            self.recorder.event("clock", &words);
            self.status.tell(words);
        }
    }

    /// Notes in the recording, and says, that frames come more slowly than they did.
    fn look_at_pace(&mut self, now: Instant) {
        let Some(pace) = &mut self.pace else { return };
        if let Some(words) = pace.look(now, pace::throttled) {
            self.recorder.event("device", &words);
            self.status.note(&words);
            self.status.tell(words);
        }
    }

    /// Notes in the recording, about when, what went wrong since the last note.
    fn tell_losses(&mut self, link_stats: LinkStats, now: bool) {
        let (reported, at) = self.reported;
        if !now && at.is_some_and(|at| at.elapsed() < LOSSES_EVERY) {
            return;
        }
        let troubles = link_stats.since(&reported).troubles();
        if !troubles.is_empty() {
            self.recorder.event("loss", &troubles.join(", "));
            self.reported = (link_stats, Some(Instant::now()));
        }
    }

    /// How the source stands, and the more exact word that viewers read.
    pub(super) fn state_shown(&mut self, state: State, shown: DeviceState, text: &str) {
        let (before, _) = self.status.device();
        self.status.set_device(state, shown, text);
        if before != state {
            self.recorder.event("device", text);
            self.tell();
        }
        if state == State::Ended {
            self.tell_losses(self.status.link_stats(), true);
        }
    }

    pub(super) fn tell(&self) {
        if let Some(server) = &self.server {
            server.tell_state();
        }
    }
}

impl Receiver for FrameSink {
    fn frame(&mut self, frame: &Frame<Counts>, at: SystemTime) {
        let (mut frame, now) = (frame.clone(), Instant::now());
        self.look_at_clock(&frame);
        // Of a device without a clock: differences between times must not change where the wall clock is set.
        frame.time_secs = frame.time_secs.or(self.host_clock.secs(now));
        if let Some(observer) = &mut self.counts_observer {
            observer(&frame);
        }
        let arrived = TimestampedFrame {
            frame: Arc::new(frame),
            at,
            tare: self.tare.clone(),
        };
        self.status.arrived();
        self.look_at_host_clock(at, now);
        self.look_at_pace(now);
        self.recorder.counts(&arrived);
        if self.can_wait {
            return self.incoming.push_waiting(arrived);
        }
        if self.incoming.push(arrived) {
            self.status.skip();
        }
    }

    fn state(&mut self, state: State, text: &str) {
        self.state_shown(state, shown(state), text);
    }

    fn link_stats(&mut self, link_stats: LinkStats) {
        self.status.set_link_stats(link_stats);
        self.tell_losses(link_stats, self.stopped());
    }

    fn stopped(&self) -> bool {
        self.status.is_stopped()
    }
}
