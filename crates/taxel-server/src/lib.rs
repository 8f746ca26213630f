#![doc = include_str!("../README.md")]
//!
//! It knows nothing of sensors: a [`ViewerBackend`] says what is to be seen and does what viewers ask. In reading order: a
//! [`ViewerBackend`] says and does, a [`Server`] listens, a [`Message`] and a [`FrameMessage`] go out, a [`Command`] comes in.

mod assets;
mod client;
mod command;
mod connections;
#[cfg(feature = "foxglove")]
mod foxglove;
mod frame;
mod guard;
mod messages;
mod serve;

use std::io;
use std::net::{IpAddr, SocketAddr, ToSocketAddrs};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, OnceLock};

use tokio::sync::{Semaphore, broadcast, oneshot, watch};

#[cfg(feature = "foxglove")]
pub use self::foxglove::FoxgloveServer;
pub use command::{CalibrationStep, Command, GripStep, Watched};
pub use frame::FrameMessage;
use frame::Sent;
pub use guard::{random_token, token_problem};
pub use messages::{
    Answer, AskedPress, BadLines, CalibrationPhase, CalibrationSession, Curve, Details,
    DeviceState, DeviceStatus, Event, ExportedFacts, FigureDetails, FileFacts, GripHand,
    GripMeasured, GripPhase, GripProtocol, GripSession, GripTrial, HandleFacts, HeldOutError,
    Hello, Latency, MarkMeaning, Message, PROTOCOL, Player, RecordingStatus, Refused, RegionFacts,
    RegionWindow, Reply, SeenPress, SensorFacts, Severity, Slider, SliderKind, SourceFacts,
    SourceKind, State, TakenPress, TareStatus, TaxelDetails, mark_meanings,
};

/// Whether a text is a request that a viewer may make. For the fuzz targets.
#[doc(hidden)]
pub fn is_request(text: &str) -> bool {
    command::parse(text).is_ok()
}

/// What the server shows, and who does what viewers ask for.
pub trait ViewerBackend: Send + Sync + 'static {
    /// What a viewer must know first.
    fn hello(&self) -> Hello;
    /// How things stand; `viewers` look at the moment.
    fn state(&self, viewers: usize) -> State;
    /// What happened since this was asked last, for all viewers.
    fn news(&self) -> Vec<Event>;
    /// Details of what a viewer watches, asked for twice a second while it does.
    fn details(&self, watched: &Watched) -> Details;
    /// The whole of the recording that is played, once it is known: told to every viewer who comes, and to all when
    /// [`Server::tell_curve`] is called.
    fn curve(&self) -> Option<Curve> {
        None
    }
    /// A viewer has come. It gets no frame of before: a source that is held shows its frame again.
    fn joined(&self) {}
    /// Does what a viewer asks. May take its time: it holds up the viewer that asks alone.
    ///
    /// # Errors
    /// Why not, in words for the viewer.
    fn command(&self, command: Command) -> Result<Reply, Refused>;
    /// A file of results, by its name; `None` where there is none of that name.
    fn result_file(&self, name: &str) -> Option<ResultFile> {
        let _ = name;
        None
    }
}

/// A file that the page offers.
#[derive(Debug, Clone)]
pub struct ResultFile {
    /// What is in it,
    pub bytes: Vec<u8>,
    /// and what kind of thing that is, as browsers name it: `application/pdf`.
    pub kind: &'static str,
}

/// Where to listen, and who may look.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Options {
    /// `127.0.0.1:8432`; port 0 for any.
    pub address: String,
    /// What a viewer must know; `None` only on loopback.
    pub token: Option<String>,
}

impl Options {
    /// Listens at `address`, without a token.
    pub fn new(address: impl Into<String>) -> Options {
        Options {
            address: address.into(),
            token: None,
        }
    }
}

/// The most viewers at once.
pub const MAX_VIEWERS: usize = 32;
/// Messages that wait for a slow viewer before it loses some.
const TEXTS: usize = 64;

/// What all connections share.
struct Shared {
    backend: Arc<dyn ViewerBackend>,
    token: Option<String>,
    address: SocketAddr,
    frames: watch::Sender<Option<Arc<Sent>>>,
    texts: broadcast::Sender<Arc<str>>,
    viewers: Arc<Semaphore>,
    /// Viewers that are ready for a frame.
    waiting: AtomicUsize,
    /// What is shown beside it on the page for two.
    beside: OnceLock<Arc<Shared>>,
}

impl Shared {
    fn state(&self) -> String {
        let viewers = MAX_VIEWERS - self.viewers.available_permits();
        let state = self.backend.state(viewers);
        Message::State(Box::new(state)).to_json()
    }

    /// News and how things stand, to all viewers.
    fn tell_all(&self) {
        for event in self.backend.news() {
            let _ = self.texts.send(Message::Event(event).to_json().into());
        }
        if self.texts.receiver_count() > 0 {
            let _ = self.texts.send(self.state().into());
        }
    }
}

/// A server at work. Dropped, it closes all connections.
pub struct Server {
    shared: Arc<Shared>,
    stop: Option<oneshot::Sender<()>>,
    thread: Option<std::thread::JoinHandle<()>>,
}

impl Server {
    /// Begins to listen.
    ///
    /// # Errors
    /// What the system says; [`io::ErrorKind::PermissionDenied`] for an address beyond loopback without a token.
    pub fn start(options: &Options, backend: Arc<dyn ViewerBackend>) -> io::Result<Self> {
        let address = options.address.to_socket_addrs()?.next();
        let address = address
            .ok_or_else(|| io::Error::new(io::ErrorKind::NotFound, "the address leads nowhere"))?;
        if !address.ip().is_loopback() && options.token.is_none() {
            return Err(io::Error::new(
                io::ErrorKind::PermissionDenied,
                "beyond this machine only with a token",
            ));
        }
        if let Some(problem) = options.token.as_deref().and_then(token_problem) {
            return Err(io::Error::new(io::ErrorKind::InvalidInput, problem));
        }
        let listener = std::net::TcpListener::bind(address)?;
        listener.set_nonblocking(true)?;
        let shared = Arc::new(Shared {
            backend,
            token: options.token.clone(),
            address: listener.local_addr()?,
            frames: watch::Sender::new(None),
            texts: broadcast::Sender::new(TEXTS),
            viewers: Arc::new(Semaphore::new(MAX_VIEWERS)),
            waiting: AtomicUsize::new(0),
            beside: OnceLock::new(),
        });
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_io()
            .enable_time()
            .build()?;
        let (stop, stopped) = oneshot::channel();
        let with = shared.clone();
        let thread = std::thread::Builder::new()
            .name("viewer".to_owned())
            .spawn(move || runtime.block_on(serve::serve(listener, with, stopped)))?;
        Ok(Self {
            shared,
            stop: Some(stop),
            thread: Some(thread),
        })
    }

    /// Where it listens.
    pub fn address(&self) -> SocketAddr {
        self.shared.address
    }

    /// The addresses of the page, with the token: where it listens, or, where that is everywhere, those under which
    /// this machine may be reached, its own last.
    pub fn urls(&self) -> Vec<String> {
        let places = places_of(self.shared.address);
        let url = |place: &SocketAddr| match &self.shared.token {
            None => format!("http://{place}/"),
            Some(token) => format!("http://{place}/?token={token}"),
        };
        places.iter().map(url).collect()
    }

    /// Shows what another server shows beside this one's own, on the page `/beside`: whoever may look here may look there. The
    /// first one stays.
    pub fn show_beside(&self, other: &Self) {
        let _ = self.shared.beside.set(other.shared.clone());
    }

    /// Whether a viewer is ready for a frame.
    pub fn is_awaited(&self) -> bool {
        self.shared.waiting.load(Ordering::Relaxed) > 0
    }

    /// Hands the newest frame to those who are ready for one.
    pub fn publish(&self, frame: FrameMessage) {
        self.shared
            .frames
            .send_replace(Some(Arc::new(Sent::new(frame))));
    }

    /// Tells all viewers the whole of the recording that is played.
    pub fn tell_curve(&self) {
        if let Some(curve) = self.shared.backend.curve() {
            let _ = self
                .shared
                .texts
                .send(Message::Curve(curve).to_json().into());
        }
    }

    /// Tells all viewers how things stand now, beside the twice a second that they hear it anyway.
    pub fn tell_state(&self) {
        self.shared.tell_all();
    }
}

/// Where a server can be reached.
fn places_of(address: SocketAddr) -> Vec<SocketAddr> {
    if !address.ip().is_unspecified() {
        return vec![address];
    }
    let v4 = address.is_ipv4();
    let own = if v4 {
        IpAddr::from([127, 0, 0, 1])
    } else {
        IpAddr::from([0, 0, 0, 0, 0, 0, 0, 1])
    };
    let mut found: Vec<IpAddr> = NETWORKS.iter().filter_map(|there| way_to(there)).collect();
    // A server on every IPv6 address is mostly reached by IPv4 too; the other way round it is not.
    found.retain(|ip| !ip.is_loopback() && (ip.is_ipv4() || !v4));
    found.sort_unstable();
    found.dedup();
    found.push(own);
    let at = |ip| SocketAddr::new(ip, address.port());
    found.into_iter().map(at).collect()
}

/// Addresses in the usual private networks, and one beyond: this machine's own address on the way there is one under
/// which it is known there.
const NETWORKS: [&str; 5] = [
    "192.0.2.1:9",
    "10.255.255.254:9",
    "172.31.255.254:9",
    "192.168.255.254:9",
    "[2001:db8::1]:9",
];

/// The address that this machine would send from. Nothing is sent.
fn way_to(there: &str) -> Option<IpAddr> {
    let any = if there.starts_with('[') {
        "[::]:0"
    } else {
        "0.0.0.0:0"
    };
    let socket = std::net::UdpSocket::bind(any).ok()?;
    socket.connect(there).ok()?;
    socket.local_addr().ok().map(|address| address.ip())
}

impl Drop for Server {
    fn drop(&mut self) {
        if let Some(stop) = self.stop.take() {
            let _ = stop.send(());
        }
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

#[cfg(test)]
mod tests;
