//! How everything stands: written by the threads that know, read by viewers and the command line.

use std::collections::{BTreeMap, VecDeque};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use taxel::stats::quantile_of_sorted;
use taxel_acquire::protocol::LinkStats;
use taxel_acquire::transport::State;
use taxel_server::{
    BadLines, DeviceState, DeviceStatus, Event, FileFacts, Latency, Player, RecordingStatus,
    State as StateMessage, TareStatus,
};

use super::SessionOptions;
use super::recorder::{Owner, SavedRecording};

/// A recording in progress, or ended by an error.
#[derive(Debug, Clone, Default)]
pub struct Recording {
    /// Its file's name.
    pub name: String,
    /// Frames written.
    pub frames: u64,
    /// Bytes written.
    pub bytes: u64,
    /// Since it began, s.
    pub secs: f64,
    /// Why it has ended early, if it has.
    pub error: Option<String>,
    pub(super) owner: Owner,
}

impl Recording {
    /// As viewers see it.
    fn message(&self) -> RecordingStatus {
        let mut status = RecordingStatus::new(self.name.clone());
        status.frames = self.frames;
        status.bytes = self.bytes;
        status.secs = self.secs;
        status.error = self.error.clone();
        status
    }
}

/// What is known.
#[derive(Debug)]
struct Known {
    /// As viewers see it, but for what is worked out when they ask.
    message: StateMessage,
    recording: Option<Recording>,
    device: State,
    link_stats: LinkStats,
    /// Newtons on the sensor, without any tare.
    total: Option<f64>,
    arrivals: VecDeque<Instant>,
    delays_ms: VecDeque<f32>,
}

/// Delays that the median and the 99th percentile are of.
const DELAYS: usize = 1000;
/// Events that wait to be told; a recording played at full speed may have more.
const NEWS: usize = 1000;
/// The time that the frame rate is an average of.
const RATE_OVER: Duration = Duration::from_secs(1);

pub(super) struct SessionStatus {
    state: Mutex<Known>,
    /// Messages that viewers have not had.
    news: Mutex<Vec<Event>>,
    /// Lines for the command line.
    messages: Mutex<Vec<String>>,
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
        let mut message = StateMessage::default();
        message.device = DeviceStatus::new(DeviceState::Waiting, format!("opening {address}"));
        Self {
            state: Mutex::new(Known {
                message,
                recording: None,
                device: State::Waiting,
                link_stats: LinkStats::default(),
                total: None,
                arrivals: VecDeque::new(),
                delays_ms: VecDeque::new(),
            }),
            news: Mutex::new(Vec::new()),
            messages: Mutex::new(Vec::new()),
            ended: Mutex::new(Vec::new()),
            stopped: AtomicBool::new(false),
        }
    }

    /// Something happened now that viewers should hear of.
    pub(super) fn note(&self, text: &str) {
        let now = secs(SystemTime::now());
        let mut news = self.news.lock().unwrap_or_else(PoisonError::into_inner);
        if news.len() < NEWS {
            news.push(Event::new(now, text));
        }
    }

    /// What was noted since this was asked last.
    pub(super) fn take_news(&self) -> Vec<Event> {
        std::mem::take(&mut *self.news.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Something that the command line should say.
    pub(super) fn tell(&self, text: String) {
        let mut messages = self.messages.lock().unwrap_or_else(PoisonError::into_inner);
        if messages.len() < NEWS {
            messages.push(text);
        }
    }

    /// What the command line has not said yet.
    pub(super) fn take_messages(&self) -> Vec<String> {
        std::mem::take(&mut *self.messages.lock().unwrap_or_else(PoisonError::into_inner))
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

    fn lock(&self) -> MutexGuard<'_, Known> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn stop(&self) {
        self.stopped.store(true, Ordering::Relaxed);
    }

    pub(super) fn is_stopped(&self) -> bool {
        self.stopped.load(Ordering::Relaxed)
    }

    /// The message `state`, with what only the caller knows.
    pub(super) fn state(&self, clients: usize) -> StateMessage {
        let mut status = self.lock();
        let mut delays: Vec<f64> = status.delays_ms.iter().map(|&d| d.into()).collect();
        delays.sort_by(f64::total_cmp);
        let at = |share| quantile_of_sorted(&delays, share).unwrap_or(0.0);
        let mut message = status.message.clone();
        message.clients = clients;
        message.frames_per_second = rate(&mut status.arrivals);
        message.latency_ms = Latency::new(at(0.5), at(0.99));
        message.recording = status.recording.as_ref().map(Recording::message);
        message
    }

    pub(super) fn set_device(&self, state: State, shown: DeviceState, text: &str) {
        let mut status = self.lock();
        status.device = state;
        status.message.device = DeviceStatus::new(shown, text);
    }

    pub(super) fn device(&self) -> (State, String) {
        let status = self.lock();
        (status.device, status.message.device.text.clone())
    }

    pub(super) fn arrived(&self) {
        let mut status = self.lock();
        status.message.frames += 1;
        status.arrivals.push_back(Instant::now());
        // Counted exactly up to here; beyond, the rate is that of the newest.
        if status.arrivals.len() > 4096 {
            status.arrivals.pop_front();
        }
    }

    pub(super) fn set_link_stats(&self, link_stats: LinkStats) {
        let mut status = self.lock();
        status.link_stats = link_stats;
        status.message.lost = link_stats.lost;
        status.message.corrupt = link_stats.corrupt;
        status.message.repeated = link_stats.repeated;
    }

    pub(super) fn link_stats(&self) -> LinkStats {
        self.lock().link_stats
    }

    pub(super) fn skipped(&self) -> u64 {
        self.lock().message.skipped
    }

    pub(super) fn skip(&self) {
        self.lock().message.skipped += 1;
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
        self.lock().message.method = name;
    }

    pub(super) fn set_tare(&self, on: bool) {
        self.lock().message.tare = TareStatus::new(on, secs(SystemTime::now()));
    }

    pub(super) fn set_recording(&self, recording: Option<Recording>) {
        self.lock().recording = recording;
    }

    pub(super) fn recording(&self) -> Option<Recording> {
        self.lock().recording.clone()
    }

    /// What a viewer of a file must know of it.
    pub(super) fn file(&self) -> Option<FileFacts> {
        let player = self.lock().message.player?;
        Some(FileFacts::new(player.frames, player.duration_secs))
    }

    pub(super) fn set_player(&self, player: Player) {
        self.lock().message.player = Some(player);
    }

    pub(super) fn set_sliders(&self, sliders: BTreeMap<String, f64>) {
        self.lock().message.sliders = sliders;
    }

    pub(super) fn set_bad_lines(&self, lines: BadLines) {
        self.lock().message.bad_lines = lines;
    }

    pub(super) fn frames_per_second(&self) -> f64 {
        rate(&mut self.lock().arrivals)
    }
}

/// A device's state as viewers see it.
pub(super) fn shown(state: State) -> DeviceState {
    match state {
        State::Live => DeviceState::Live,
        State::Waiting => DeviceState::Waiting,
        State::Lost => DeviceState::Lost,
        State::Ended => DeviceState::Ended,
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
