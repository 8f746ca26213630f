//! How everything stands: written by the threads that know, read by viewers and the command line.

use std::collections::{BTreeMap, VecDeque};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use serde::Serialize;
use taxel::stats::quantile_of_sorted;
use taxel_acquire::protocol::LinkStats;
use taxel_acquire::transport::State;

use super::SessionOptions;
use super::recorder::{Owner, SavedRecording};

/// A recording in progress, or ended by an error.
#[derive(Debug, Clone, Serialize, Default)]
pub struct Recording {
    pub name: String,
    pub frames: u64,
    pub bytes: u64,
    pub secs: f64,
    pub error: Option<String>,
    #[serde(skip)]
    pub(super) owner: Owner,
}

/// A file being played.
#[derive(Debug, Clone, Serialize, Default)]
pub(super) struct Player {
    pub(super) playing: bool,
    pub(super) speed: f64,
    pub(super) position_secs: f64,
    pub(super) duration_secs: f64,
    pub(super) frame: u64,
    pub(super) frames: u64,
}

#[derive(Debug, Clone, Serialize)]
struct Device {
    state: &'static str,
    text: String,
}

#[derive(Debug, Clone, Serialize, Default)]
struct Latency {
    median: f64,
    p99: f64,
}

#[derive(Debug, Clone, Serialize, Default)]
pub(super) struct Tare {
    pub(super) on: bool,
    pub(super) host_secs: f64,
}

#[derive(Debug, Clone, Serialize, Default)]
pub(super) struct BadLines {
    pub(super) rows: Vec<usize>,
    pub(super) columns: Vec<usize>,
}

/// The message `state`.
#[derive(Debug, Clone, Serialize)]
struct StateMessage {
    kind: &'static str,
    device: Device,
    frames_per_second: f64,
    frames: u64,
    lost: u64,
    corrupt: u64,
    repeated: u64,
    skipped: u64,
    latency_ms: Latency,
    clients: usize,
    tare: Tare,
    recording: Option<Recording>,
    method: String,
    player: Option<Player>,
    sliders: BTreeMap<&'static str, f64>,
    bad_lines: BadLines,
    #[serde(skip)]
    device_state: State,
    #[serde(skip)]
    link_stats: LinkStats,
    /// Newtons on the sensor, without any tare.
    #[serde(skip)]
    total: Option<f64>,
    #[serde(skip)]
    arrivals: VecDeque<Instant>,
    #[serde(skip)]
    delays_ms: VecDeque<f32>,
}

/// Delays that the median and the 99th percentile are of.
const DELAYS: usize = 1000;
/// Events that wait to be told; a recording played at full speed may have more.
const NEWS: usize = 1000;
/// The time that the frame rate is an average of.
const RATE_OVER: Duration = Duration::from_secs(1);

pub(super) struct SessionStatus {
    state: Mutex<StateMessage>,
    /// Messages that viewers have not had.
    news: Mutex<Vec<String>>,
    /// Lines for the command line.
    told: Mutex<Vec<String>>,
    /// Recordings that have ended.
    ended: Mutex<Vec<SavedRecording>>,
    stopped: AtomicBool,
}

impl SessionStatus {
    pub(super) fn new(options: &SessionOptions) -> Self {
        Self::waiting(&options.address.to_string())
    }

    /// Before anything has come from this address.
    pub(super) fn waiting(address: &str) -> Self {
        Self {
            state: Mutex::new(StateMessage {
                kind: "state",
                device: Device {
                    state: State::Waiting.word(),
                    text: format!("opening {address}"),
                },
                frames_per_second: 0.0,
                frames: 0,
                lost: 0,
                corrupt: 0,
                repeated: 0,
                skipped: 0,
                latency_ms: Latency::default(),
                clients: 0,
                tare: Tare::default(),
                recording: None,
                method: String::new(),
                player: None,
                sliders: BTreeMap::new(),
                bad_lines: BadLines::default(),
                device_state: State::Waiting,
                link_stats: LinkStats::default(),
                total: None,
                arrivals: VecDeque::new(),
                delays_ms: VecDeque::new(),
            }),
            news: Mutex::new(Vec::new()),
            told: Mutex::new(Vec::new()),
            ended: Mutex::new(Vec::new()),
            stopped: AtomicBool::new(false),
        }
    }

    /// Something happened now that viewers should hear of.
    pub(super) fn note(&self, text: &str) {
        let now = secs(SystemTime::now());
        let json = serde_json::json!({ "kind": "event", "host_secs": now, "text": text });
        let mut news = self.news.lock().unwrap_or_else(PoisonError::into_inner);
        if news.len() < NEWS {
            news.push(json.to_string());
        }
    }

    /// What was noted since this was asked last.
    pub(super) fn take_news(&self) -> Vec<String> {
        std::mem::take(&mut *self.news.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Something that the command line should say.
    pub(super) fn tell(&self, text: String) {
        let mut told = self.told.lock().unwrap_or_else(PoisonError::into_inner);
        if told.len() < NEWS {
            told.push(text);
        }
    }

    /// What the command line has not said yet.
    pub(super) fn take_messages(&self) -> Vec<String> {
        std::mem::take(&mut *self.told.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// A recording has ended, well or not.
    pub(super) fn saved(&self, saved: SavedRecording) {
        let word = if saved.error.is_some() { "error: " } else { "" };
        self.tell(format!("{word}{}", saved.words()));
        // A page shows why one ended that nobody ended; one that ended well it shows no more.
        let mut status = self.lock();
        status.recording = saved.error.is_some().then(|| Recording {
            name: saved.path.display().to_string(),
            frames: saved.frames,
            error: saved.error.clone(),
            ..status.recording.take().unwrap_or_default()
        });
        drop(status);
        let mut ended = self.ended.lock().unwrap_or_else(PoisonError::into_inner);
        ended.push(saved);
    }

    /// Recordings that have ended.
    pub(super) fn ended(&self) -> Vec<SavedRecording> {
        self.ended
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .clone()
    }

    fn lock(&self) -> MutexGuard<'_, StateMessage> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn stop(&self) {
        self.stopped.store(true, Ordering::Relaxed);
    }

    pub(super) fn is_stopped(&self) -> bool {
        self.stopped.load(Ordering::Relaxed)
    }

    /// The message `state`, with what only the caller knows.
    pub(super) fn json(&self, clients: usize) -> String {
        let mut status = self.lock();
        status.clients = clients;
        status.frames_per_second = rate(&mut status.arrivals);
        let mut delays: Vec<f64> = status.delays_ms.iter().map(|&d| d.into()).collect();
        delays.sort_by(f64::total_cmp);
        let at = |share| quantile_of_sorted(&delays, share).unwrap_or(0.0);
        status.latency_ms = Latency {
            median: at(0.5),
            p99: at(0.99),
        };
        serde_json::to_string(&*status).expect("plain data")
    }

    pub(super) fn set_device(&self, state: State, text: &str) {
        self.set_device_word(state, state.word(), text);
    }

    pub(super) fn set_device_word(&self, state: State, word: &'static str, text: &str) {
        let mut status = self.lock();
        status.device_state = state;
        status.device = Device {
            state: word,
            text: text.to_owned(),
        };
    }

    pub(super) fn device(&self) -> (State, String) {
        let status = self.lock();
        (status.device_state, status.device.text.clone())
    }

    pub(super) fn arrived(&self) {
        let mut status = self.lock();
        status.frames += 1;
        status.arrivals.push_back(Instant::now());
        // Counted exactly up to here; beyond, the rate is that of the newest.
        if status.arrivals.len() > 4096 {
            status.arrivals.pop_front();
        }
    }

    pub(super) fn set_link_stats(&self, link_stats: LinkStats) {
        let mut status = self.lock();
        status.link_stats = link_stats;
        status.lost = link_stats.lost;
        status.corrupt = link_stats.corrupt;
        status.repeated = link_stats.repeated;
    }

    pub(super) fn link_stats(&self) -> LinkStats {
        self.lock().link_stats
    }

    pub(super) fn skip(&self) {
        self.lock().skipped += 1;
    }

    pub(super) fn add_delay(&self, at: SystemTime) {
        let delay = at.elapsed().unwrap_or_default();
        let mut status = self.lock();
        status.delays_ms.push_back(1e3 * delay.as_secs_f32());
        if status.delays_ms.len() > DELAYS {
            status.delays_ms.pop_front();
        }
    }

    pub(super) fn set_total(&self, newtons: Option<f64>) {
        self.lock().total = newtons;
    }

    pub(super) fn total(&self) -> Option<f64> {
        self.lock().total
    }

    pub(super) fn set_method(&self, name: String) {
        self.lock().method = name;
    }

    pub(super) fn set_tare(&self, on: bool) {
        self.lock().tare = Tare {
            on,
            host_secs: secs(SystemTime::now()),
        };
    }

    pub(super) fn set_recording(&self, recording: Option<Recording>) {
        self.lock().recording = recording;
    }

    pub(super) fn recording(&self) -> Option<Recording> {
        self.lock().recording.clone()
    }

    /// What a viewer of a file must know of it.
    pub(super) fn file(&self) -> Option<serde_json::Value> {
        let status = self.lock();
        let player = status.player.as_ref()?;
        Some(serde_json::json!({ "frames": player.frames, "duration_secs": player.duration_secs }))
    }

    pub(super) fn set_player(&self, player: Player) {
        self.lock().player = Some(player);
    }

    pub(super) fn set_sliders(&self, sliders: BTreeMap<&'static str, f64>) {
        self.lock().sliders = sliders;
    }

    pub(super) fn set_bad_lines(&self, lines: BadLines) {
        self.lock().bad_lines = lines;
    }

    pub(super) fn frames_per_second(&self) -> f64 {
        rate(&mut self.lock().arrivals)
    }
}

/// Frames in the last second; of few of them, by the time between.
fn rate(arrivals: &mut VecDeque<Instant>) -> f64 {
    let now = Instant::now();
    while arrivals
        .front()
        .is_some_and(|first| now - *first > RATE_OVER)
    {
        arrivals.pop_front();
    }
    match (arrivals.front(), arrivals.back()) {
        (Some(first), Some(last)) if last > first => {
            (arrivals.len() - 1) as f64 / (*last - *first).as_secs_f64()
        }
        _ => arrivals.len() as f64,
    }
}

/// Seconds since 1970.
pub(super) fn secs(at: SystemTime) -> f64 {
    at.duration_since(UNIX_EPOCH)
        .unwrap_or_default()
        .as_secs_f64()
}
