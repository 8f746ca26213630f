//! A recording played as if it happened now: held, moved, faster or slower.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant, SystemTime};

use taxel::{Counts, Frame, Sensor};
use taxel_acquire::protocol::LinkStats;
use taxel_acquire::transport::{Receiver, State};
use taxel_io::{FrameSource, McapReader, ReadOptions, exports, open_counts, shape_of};
use taxel_server::DeviceState;

use super::curve::Recorded;
use super::source::FrameSink;
use crate::carry::USUAL_RATE;
use crate::error::Error;
use crate::frames::is_mcap;
use crate::simulated::simulated_caption;

/// Recorded seconds without a frame that are waited for; more is a clock that jumped.
const MAX_GAP: f64 = 10.0;
const LOOK: Duration = Duration::from_millis(20);

/// What the player is to do.
#[derive(Debug, Clone, Copy)]
pub(super) struct PlaybackRequest {
    pub(super) playing: bool,
    /// `None`: as fast as can be.
    pub(super) speed: Option<f64>,
    pub(super) seek: Option<f64>,
    /// Somebody has not seen the frame that is held.
    pub(super) again: bool,
}

/// A recording with an index of its times, or one that is read from its beginning on.
pub(super) enum PlaybackSource {
    Timed(Box<McapReader>),
    Plain {
        frames: Box<dyn FrameSource + Send>,
        /// Frames read.
        at: usize,
    },
}

/// A recording to be played.
pub(super) struct Player {
    path: PathBuf,
    options: ReadOptions,
    source: PlaybackSource,
    /// Seconds and frames, where they are known.
    extent: Option<(f64, u64)>,
    /// Of a plain recording that knows its times, the second of every frame.
    times: Option<Vec<f64>>,
    play: Arc<Mutex<PlaybackRequest>>,
}

/// What is shown, and how playing stands.
struct Showing {
    name: String,
    frame: Frame<Counts>,
    /// Second of the frame shown last, and its number.
    secs: f64,
    shown: u64,
    /// Second of a frame that is read but whose time has not come.
    read: Option<f64>,
    link_stats: LinkStats,
    /// Recorded seconds, and when they were played: reset whenever pace or place change.
    clock: Option<(f64, Instant)>,
    /// What was wished for before.
    before: PlaybackRequest,
    ended: bool,
    /// A frame of this place was shown.
    shown_one: bool,
}

/// A recording, from its beginning on.
///
/// # Errors
/// One that cannot be read.
pub(super) fn open(path: &Path, options: ReadOptions) -> Result<PlaybackSource, Error> {
    let timed = is_mcap(path);
    Ok(if timed {
        PlaybackSource::Timed(Box::new(McapReader::open(path, options)?))
    } else {
        PlaybackSource::Plain {
            frames: open_counts(path, options)?,
            at: 0,
        }
    })
}

impl PlaybackSource {
    /// The next frame, and its second.
    pub(super) fn next(&mut self, frame: &mut Frame<Counts>) -> Result<Option<f64>, Error> {
        Ok(match self {
            PlaybackSource::Timed(reader) => reader
                .next_into(frame)?
                .then(|| frame.time_secs.unwrap_or_default()),
            PlaybackSource::Plain { frames, at } => frames.next_into(frame)?.then(|| {
                let secs = second_of(frame, *at);
                *at += 1;
                frame.time_secs = Some(secs);
                secs
            }),
        })
    }

    /// What was taken off the frame that was read last, when it was recorded.
    pub(super) fn tare(&self) -> Option<&taxel_io::Tare> {
        match self {
            PlaybackSource::Timed(reader) => reader.tare().filter(|tare| !tare.is_undone()),
            PlaybackSource::Plain { .. } => None,
        }
    }
}

/// Seconds of all frames, where they know them, and how long it is in seconds and frames.
type Extent = (Option<Vec<f64>>, Option<(f64, u64)>);

/// How long a recording without an index is.
fn extent_of(path: &Path, options: ReadOptions) -> Result<Extent, Error> {
    let times = times_of(path, options)?;
    let extent = match &times {
        Some(times) => times.last().map(|last| (*last, times.len() as u64)),
        None => shape_of(path)?
            .frames
            .map(|frames| (frames as f64 / USUAL_RATE, frames)),
    };
    Ok((times, extent))
}

/// The second of every frame of a recording without an index; `None` where its frames know no time. Reads it through.
fn times_of(path: &Path, options: ReadOptions) -> Result<Option<Vec<f64>>, Error> {
    let mut frames = open_counts(path, options)?;
    let mut frame = Frame::zeros(options.rows, options.columns);
    let mut times = Vec::new();
    // What cannot be read is told when its time has come.
    while frames.next_into(&mut frame).unwrap_or(false) {
        if times.is_empty() && frame.time_secs.is_none() {
            return Ok(None);
        }
        times.push(second_of(&frame, times.len()));
    }
    Ok((!times.is_empty()).then_some(times))
}

/// When a frame was read: as it says, else by its number at the usual rate.
fn second_of(frame: &Frame<Counts>, number: usize) -> f64 {
    frame.time_secs.unwrap_or(number as f64 / USUAL_RATE)
}

impl Player {
    /// `playing`: at once; else it is held at its first frame. `is_shown`: to somebody who sees how long it is and moves in it.
    pub(super) fn open(
        path: &Path,
        sensor: &Sensor,
        speed: Option<f64>,
        playing: bool,
        is_shown: bool,
    ) -> Result<Self, Error> {
        let mut options = ReadOptions::of(sensor);
        options.keep_going = true;
        let source = open(path, options)?;
        let (times, extent) = match &source {
            PlaybackSource::Timed(reader) => (None, reader.extent()),
            // Read through once more, which a pipe cannot be, and only for who asks.
            PlaybackSource::Plain { .. } if is_shown && exports::file_of(path).is_file() => {
                extent_of(path, options)?
            }
            PlaybackSource::Plain { .. } => (None, None),
        };
        Ok(Self {
            path: path.to_owned(),
            options,
            source,
            extent,
            times,
            play: Arc::new(Mutex::new(PlaybackRequest {
                playing,
                speed,
                seek: None,
                again: false,
            })),
        })
    }

    pub(super) fn play(&self) -> Arc<Mutex<PlaybackRequest>> {
        self.play.clone()
    }

    /// The recording as it is read once more beside; `None` of a pipe, which cannot be.
    pub(super) fn recorded(&self) -> Option<Recorded> {
        let is_file = exports::file_of(&self.path).is_file();
        is_file.then(|| Recorded {
            path: self.path.clone(),
            options: self.options,
            frames: self.extent.map(|(_, frames)| frames),
            play: self.play.clone(),
        })
    }

    fn requested(&self) -> PlaybackRequest {
        let mut play = self.play.lock().unwrap_or_else(PoisonError::into_inner);
        let requested = *play;
        (play.seek, play.again) = (None, false);
        requested
    }

    /// Plays until it is stopped; without viewers until the recording ends.
    pub(super) fn run(mut self, sink: &mut FrameSink) {
        let holds = sink.server.is_some();
        let mut name = self.path.display().to_string();
        name += &simulated_caption(&self.path);
        // At once: nobody is told that it plays who asked for it held.
        set_word(sink, self.requested().playing, &name);
        let mut showing = Showing {
            name,
            frame: Frame::zeros(self.options.rows, self.options.columns),
            secs: 0.0,
            shown: 0,
            read: None,
            link_stats: LinkStats::default(),
            clock: None,
            before: self.requested(),
            ended: false,
            shown_one: false,
        };
        while !sink.stopped() {
            let requested = self.apply(&mut showing, sink);
            // Held, it still shows the place that it was moved to.
            if showing.ended || (!requested.playing && showing.shown_one) {
                if requested.again && showing.read.is_none() {
                    sink.again(&showing.frame);
                }
                std::thread::sleep(LOOK);
                continue;
            }
            if showing.read.is_none() && !self.read_on(&mut showing, requested, sink) {
                if holds {
                    continue;
                }
                return;
            }
            self.show_when_due(&mut showing, &requested, sink);
        }
    }

    /// Does what viewers wish: another place, another pace. Gives what holds now.
    fn apply(&mut self, showing: &mut Showing, sink: &mut FrameSink) -> PlaybackRequest {
        let mut requested = self.requested();
        if showing.ended && requested.playing {
            // Play at the end begins again.
            requested.seek.get_or_insert(0.0);
        }
        if let Some(to) = requested.seek {
            if let Err(error) = self.seek(to) {
                sink.state(State::Ended, &error.to_string());
            }
            if showing.ended {
                // It came to its end playing; moved away from there it goes on.
                requested.playing = true;
                self.set_playing(true);
            }
            (showing.clock, showing.read) = (None, None);
            (showing.ended, showing.shown_one) = (false, false);
        }
        let before = showing.before;
        let changed = (requested.playing, requested.speed) != (before.playing, before.speed);
        showing.before = requested;
        self.tell(sink, &requested, showing.secs, showing.shown);
        if !showing.ended && (requested.seek.is_some() || changed) {
            showing.clock = None;
            set_word(sink, requested.playing, &showing.name);
            sink.tell();
        }
        requested
    }

    /// Reads the next frame; false at the end, which is told.
    fn read_on(
        &mut self,
        showing: &mut Showing,
        mut requested: PlaybackRequest,
        sink: &mut FrameSink,
    ) -> bool {
        let why = match self.source.next(&mut showing.frame) {
            Ok(at) => {
                showing.read = at;
                format!("{} has ended", showing.name)
            }
            Err(error) => error.to_string(),
        };
        // Frames that cannot be read are left out, and told as a device's broken ones are.
        showing.link_stats.corrupt = self.skipped();
        sink.link_stats(showing.link_stats);
        if showing.read.is_some() {
            return true;
        }
        self.tell_events(sink);
        showing.ended = true;
        self.set_playing(false);
        requested.playing = false;
        self.tell(sink, &requested, showing.secs, showing.shown);
        sink.state(State::Ended, &why);
        false
    }

    /// Shows the frame that was read when its time has come, unless something else is wished for before that.
    fn show_when_due(
        &mut self,
        showing: &mut Showing,
        requested: &PlaybackRequest,
        sink: &mut FrameSink,
    ) {
        let Some(at) = showing.read else { return };
        if requested.playing && showing.shown_one && skips(sink, at - showing.secs) {
            showing.clock = None;
        }
        let (begun, since) = *showing.clock.get_or_insert((at, Instant::now()));
        if let Some(speed) = requested.speed {
            let due = since + Duration::from_secs_f64(((at - begun) / speed).max(0.0));
            while Instant::now() < due && !sink.stopped() && self.is_as(requested) {
                std::thread::sleep(LOOK.min(due.saturating_duration_since(Instant::now())));
            }
            if showing.shown_one && !self.is_as(requested) {
                // Not its time any more; it waits for what comes of the wish.
                return;
            }
        }
        self.tell_events(sink);
        self.tell_tare(sink);
        showing.link_stats.frames += 1;
        sink.frame(&showing.frame, SystemTime::now());
        sink.link_stats(showing.link_stats);
        (showing.secs, showing.shown) = (at, showing.frame.sequence);
        (showing.shown_one, showing.read) = (true, None);
    }

    fn set_playing(&self, playing: bool) {
        let mut play = self.play.lock().unwrap_or_else(PoisonError::into_inner);
        play.playing = playing;
    }

    /// Whether nobody has asked for anything else meanwhile.
    fn is_as(&self, requested: &PlaybackRequest) -> bool {
        let now = self.play.lock().unwrap_or_else(PoisonError::into_inner);
        now.seek.is_none() && now.playing == requested.playing && now.speed == requested.speed
    }

    fn tell(&self, sink: &FrameSink, requested: &PlaybackRequest, secs: f64, frame: u64) {
        let (duration_secs, frames) = self.extent.unwrap_or((secs, frame + 1));
        let mut player = taxel_server::Player::new(frames, duration_secs);
        player.playing = requested.playing;
        player.speed = requested.speed.unwrap_or(0.0);
        player.position_secs = secs;
        player.frame = frame;
        sink.status.set_player(player);
    }

    /// What happened when the frame shown next was recorded.
    fn tell_events(&mut self, sink: &FrameSink) {
        let PlaybackSource::Timed(reader) = &mut self.source else {
            return;
        };
        for event in reader.take_events() {
            sink.status.note(&event.text);
        }
    }

    /// What was taken off the frame shown next, when it was recorded.
    fn tell_tare(&self, sink: &mut FrameSink) {
        if let PlaybackSource::Plain { .. } = &self.source {
            return;
        }
        let known = sink.tare.as_ref().and_then(Option::as_deref);
        let tare = self.source.tare();
        if sink.tare.is_none() || known != tare {
            sink.tare = Some(tare.cloned().map(Arc::new));
        }
    }

    fn skipped(&self) -> u64 {
        let skipped = match &self.source {
            PlaybackSource::Timed(reader) => reader.skipped(),
            PlaybackSource::Plain { frames, .. } => frames.skipped(),
        };
        skipped as u64
    }

    /// By the index where there is one; else from the beginning on, frame by frame.
    fn seek(&mut self, to: f64) -> Result<(), Error> {
        if let PlaybackSource::Timed(reader) = &mut self.source
            && reader.seek(to)?
        {
            return Ok(());
        }
        self.source = open(&self.path, self.options)?;
        let mut frame = Frame::zeros(self.options.rows, self.options.columns);
        let before = match &self.times {
            Some(times) => times.partition_point(|secs| *secs < to),
            None => (to * USUAL_RATE) as usize,
        };
        for _ in 0..before {
            if self.source.next(&mut frame)?.is_none() {
                break;
            }
        }
        Ok(())
    }
}

fn set_word(sink: &mut FrameSink, playing: bool, name: &str) {
    let shown = if playing {
        DeviceState::Live
    } else {
        DeviceState::Paused
    };
    let text = format!("playing {name}");
    sink.state_shown(State::Live, shown, &text);
}

/// Whether the time to the next frame is not waited for: a device was away, or its clock jumped.
fn skips(sink: &FrameSink, secs: f64) -> bool {
    let skips = !(0.0..=MAX_GAP).contains(&secs);
    if skips {
        sink.status
            .note(&format!("{secs:.1} s in the recording are skipped"));
    }
    skips
}
