//! A recording played as if it happened now: held, moved, faster or slower.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant, SystemTime};

use taxel::{Counts, Frame, Sensor};
use taxel_acquire::protocol::LinkStats;
use taxel_acquire::transport::{Receiver, State};
use taxel_io::{FrameSource, McapReader, TextOptions, open_counts, shape_of};

use super::desk;
use super::source::Intake;
use crate::error::Error;
use crate::frames::is_mcap;

/// Frames a second of recordings that know no time.
const USUAL_RATE: f64 = 100.0;
/// Recorded seconds without a frame that are waited for; more is a clock that jumped.
const MAX_GAP: f64 = 10.0;
const LOOK: Duration = Duration::from_millis(20);

/// What the player is to do.
#[derive(Debug, Clone, Copy)]
pub(super) struct Play {
    pub(super) playing: bool,
    /// `None`: as fast as can be.
    pub(super) speed: Option<f64>,
    pub(super) seek: Option<f64>,
    /// Somebody has not seen the frame that is held.
    pub(super) again: bool,
}

/// A recording with times, or with none.
enum Reel {
    Timed(Box<McapReader>),
    Plain {
        frames: Box<dyn FrameSource + Send>,
        at: u64,
    },
}

/// A recording to be played.
pub(super) struct Player {
    path: PathBuf,
    options: TextOptions,
    reel: Reel,
    /// Seconds and frames, where they are known.
    extent: Option<(f64, u64)>,
    play: Arc<Mutex<Play>>,
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
    before: Play,
    ended: bool,
    /// A frame of this place was shown.
    shown_one: bool,
}

fn open(path: &Path, options: TextOptions) -> Result<Reel, Error> {
    let timed = is_mcap(path);
    Ok(if timed {
        Reel::Timed(Box::new(McapReader::open(path, options)?))
    } else {
        Reel::Plain {
            frames: open_counts(path, options)?,
            at: 0,
        }
    })
}

impl Player {
    /// `playing`: at once; else it is held at its first frame.
    pub(super) fn open(
        path: &Path,
        sensor: &Sensor,
        speed: Option<f64>,
        playing: bool,
    ) -> Result<Self, Error> {
        let mut options = TextOptions::of(sensor);
        options.keep_going = true;
        let reel = open(path, options)?;
        let extent = match &reel {
            Reel::Timed(reader) => reader.extent(),
            Reel::Plain { .. } => shape_of(path)?
                .frames
                .map(|frames| (frames as f64 / USUAL_RATE, frames)),
        };
        Ok(Self {
            path: path.to_owned(),
            options,
            reel,
            extent,
            play: Arc::new(Mutex::new(Play {
                playing,
                speed,
                seek: None,
                again: false,
            })),
        })
    }

    pub(super) fn play(&self) -> Arc<Mutex<Play>> {
        self.play.clone()
    }

    fn wishes(&self) -> Play {
        let mut play = self.play.lock().unwrap_or_else(PoisonError::into_inner);
        let wishes = *play;
        (play.seek, play.again) = (None, false);
        wishes
    }

    /// Plays until it is stopped; without viewers until the recording ends.
    pub(super) fn run(mut self, intake: &mut Intake) {
        let holds = intake.server.is_some();
        let name = self.path.display().to_string();
        intake.state(State::Live, &format!("playing {name}"));
        if !self.wishes().playing {
            set_word(intake, false, &name);
        }
        let mut showing = Showing {
            name,
            frame: Frame::zeros(self.options.rows, self.options.columns),
            secs: 0.0,
            shown: 0,
            read: None,
            link_stats: LinkStats::default(),
            clock: None,
            before: self.wishes(),
            ended: false,
            shown_one: false,
        };
        while !intake.stopped() {
            let wishes = self.obey(&mut showing, intake);
            // Held, it still shows the place that it was moved to.
            if showing.ended || (!wishes.playing && showing.shown_one) {
                if wishes.again && showing.read.is_none() {
                    intake.again(&showing.frame);
                }
                std::thread::sleep(LOOK);
                continue;
            }
            if showing.read.is_none() && !self.read_on(&mut showing, wishes, intake) {
                if holds {
                    continue;
                }
                return;
            }
            self.show_when_due(&mut showing, &wishes, intake);
        }
    }

    /// Does what viewers wish: another place, another pace. Gives what holds now.
    fn obey(&mut self, showing: &mut Showing, intake: &mut Intake) -> Play {
        let mut wishes = self.wishes();
        if showing.ended && wishes.playing {
            // Play at the end begins again.
            wishes.seek.get_or_insert(0.0);
        }
        if let Some(to) = wishes.seek {
            if let Err(error) = self.seek(to) {
                intake.state(State::Ended, &error.to_string());
            }
            if showing.ended {
                // It came to its end playing; moved away from there it goes on.
                wishes.playing = true;
                self.set_playing(true);
            }
            (showing.clock, showing.read) = (None, None);
            (showing.ended, showing.shown_one) = (false, false);
        }
        let before = showing.before;
        let changed = (wishes.playing, wishes.speed) != (before.playing, before.speed);
        showing.before = wishes;
        self.tell(intake, &wishes, showing.secs, showing.shown);
        if !showing.ended && (wishes.seek.is_some() || changed) {
            showing.clock = None;
            set_word(intake, wishes.playing, &showing.name);
            intake.tell();
        }
        wishes
    }

    /// Reads the next frame; false at the end, which is told.
    fn read_on(&mut self, showing: &mut Showing, mut wishes: Play, intake: &mut Intake) -> bool {
        let why = match self.next(&mut showing.frame) {
            Ok(at) => {
                showing.read = at;
                format!("{} has ended", showing.name)
            }
            Err(error) => error.to_string(),
        };
        // Frames that cannot be read are left out, and told as a device's broken ones are.
        showing.link_stats.corrupt = self.skipped();
        intake.link_stats(showing.link_stats);
        if showing.read.is_some() {
            return true;
        }
        self.tell_events(intake);
        showing.ended = true;
        self.set_playing(false);
        wishes.playing = false;
        self.tell(intake, &wishes, showing.secs, showing.shown);
        intake.state(State::Ended, &why);
        false
    }

    /// Shows the frame that was read when its time has come, unless something else is wished for before that.
    fn show_when_due(&mut self, showing: &mut Showing, wishes: &Play, intake: &mut Intake) {
        let Some(at) = showing.read else { return };
        if wishes.playing && showing.shown_one && skips(intake, at - showing.secs) {
            showing.clock = None;
        }
        let (begun, since) = *showing.clock.get_or_insert((at, Instant::now()));
        if let Some(speed) = wishes.speed {
            let due = since + Duration::from_secs_f64(((at - begun) / speed).max(0.0));
            while Instant::now() < due && !intake.stopped() && self.is_as(wishes) {
                std::thread::sleep(LOOK.min(due.saturating_duration_since(Instant::now())));
            }
            if showing.shown_one && !self.is_as(wishes) {
                // Not its time any more; it waits for what comes of the wish.
                return;
            }
        }
        self.tell_events(intake);
        self.tell_tare(intake);
        showing.link_stats.frames += 1;
        intake.frame(&showing.frame, SystemTime::now());
        intake.link_stats(showing.link_stats);
        (showing.secs, showing.shown) = (at, showing.frame.sequence);
        (showing.shown_one, showing.read) = (true, None);
    }

    fn set_playing(&self, playing: bool) {
        let mut play = self.play.lock().unwrap_or_else(PoisonError::into_inner);
        play.playing = playing;
    }

    /// Whether nobody has asked for anything else meanwhile.
    fn is_as(&self, wishes: &Play) -> bool {
        let now = self.play.lock().unwrap_or_else(PoisonError::into_inner);
        now.seek.is_none() && now.playing == wishes.playing && now.speed == wishes.speed
    }

    fn tell(&self, intake: &Intake, wishes: &Play, secs: f64, frame: u64) {
        let (duration_secs, frames) = self.extent.unwrap_or((secs, frame + 1));
        intake.desk.set_player(desk::Player {
            playing: wishes.playing,
            speed: wishes.speed.unwrap_or(0.0),
            position_secs: secs,
            duration_secs,
            frame,
            frames,
        });
    }

    /// What happened when the frame shown next was recorded.
    fn tell_events(&mut self, intake: &Intake) {
        let Reel::Timed(reader) = &mut self.reel else {
            return;
        };
        for event in reader.take_events() {
            intake.desk.note(&event.text);
        }
    }

    /// What was taken off the frame shown next, when it was recorded.
    fn tell_tare(&self, intake: &mut Intake) {
        let Reel::Timed(reader) = &self.reel else {
            return;
        };
        let known = intake.tare.as_ref().and_then(Option::as_deref);
        let tare = reader.tare().filter(|tare| !tare.is_undone());
        if intake.tare.is_none() || known != tare {
            intake.tare = Some(tare.cloned().map(Arc::new));
        }
    }

    fn skipped(&self) -> u64 {
        let skipped = match &self.reel {
            Reel::Timed(reader) => reader.skipped(),
            Reel::Plain { frames, .. } => frames.skipped(),
        };
        skipped as u64
    }

    /// The next frame, and its second.
    fn next(&mut self, frame: &mut Frame<Counts>) -> Result<Option<f64>, Error> {
        Ok(match &mut self.reel {
            Reel::Timed(reader) => reader
                .next_into(frame)?
                .then(|| frame.time_secs.unwrap_or_default()),
            Reel::Plain { frames, at } => frames.next_into(frame)?.then(|| {
                *at += 1;
                let secs = (*at - 1) as f64 / USUAL_RATE;
                frame.time_secs = Some(secs);
                secs
            }),
        })
    }

    /// By the index where there is one; else from the beginning on, frame by frame.
    fn seek(&mut self, to: f64) -> Result<(), Error> {
        if let Reel::Timed(reader) = &mut self.reel
            && reader.seek(to)?
        {
            return Ok(());
        }
        self.reel = open(&self.path, self.options)?;
        let mut frame = Frame::zeros(self.options.rows, self.options.columns);
        for _ in 0..(to * USUAL_RATE) as u64 {
            if self.next(&mut frame)?.is_none() {
                break;
            }
        }
        Ok(())
    }
}

fn set_word(intake: &Intake, playing: bool, name: &str) {
    let word = if playing { "live" } else { "paused" };
    let text = format!("playing {name}");
    intake.desk.set_device_word(State::Live, word, &text);
}

/// Whether the time to the next frame is not waited for: a device was away, or its clock jumped.
fn skips(intake: &Intake, secs: f64) -> bool {
    let skips = !(0.0..=MAX_GAP).contains(&secs);
    if skips {
        intake
            .desk
            .note(&format!("{secs:.1} s in the recording are skipped"));
    }
    skips
}
