//! What happens by itself in a grip session: time passes, recordings begin and end, trials are measured.

use std::sync::Arc;
use std::time::{Duration, Instant, SystemTime};

use taxel_acquire::protocol::LinkStats;
use taxel_acquire::simulated::ToldGrip;
use taxel_io::Tare;

use super::attempt::{AttemptFile, GO, STOP};
use super::background::Background;
use super::desk::{Desk, Known, NextZero, Phase};
use super::protocol::Hand;
use super::record::{Attempt, GripRecord, Verdict};
use super::results;
use super::trial::MeasuredTrial;
use crate::error::Error;
use crate::session::Session;

/// After the signal to stop the recording goes on for this long: the hand lets go, and the zero is seen.
const LETTING_GO: Duration = Duration::from_millis(1500);
/// A zero that is not there by then will not come.
const ZERO_WITHIN: Duration = Duration::from_secs(10);
/// How often doubts are looked for.
const WATCH_EVERY: Duration = Duration::from_millis(500);
/// The left hand of a simulated person, as a share of the right one.
const LEFT_SHARE: f64 = 0.93;

/// Moves a session on.
pub(super) struct Conductor {
    desk: Arc<Desk>,
    /// When the source's troubles were counted from.
    before: LinkStats,
    watched: Instant,
    last: Phase,
    background: Background,
}

impl Conductor {
    pub(super) fn new(desk: Arc<Desk>) -> Self {
        let before = desk.session().as_ref().map(|session| session.link_stats());
        Self {
            desk,
            before: before.unwrap_or_default(),
            watched: Instant::now(),
            last: Phase::Setup,
            background: Background::default(),
        }
    }

    /// Does what is due. Called some tens of times a second.
    pub(super) fn tick(&mut self) {
        let phase = self.desk.known().phase.clone();
        let now = Instant::now();
        if matches!(phase, Phase::Review | Phase::Rest(_) | Phase::Ready) {
            self.background.go_on(&self.desk);
        }
        if phase == Phase::Ready {
            self.zero_by_itself();
        }
        let done = match phase {
            Phase::Zero(Some(asked)) => self.take_zero(asked),
            Phase::Countdown(until, None) => self.begin_recording(until),
            Phase::Countdown(..) | Phase::Hold(..) if self.desk.known().is_cancelled => {
                self.cancel()
            }
            Phase::Countdown(until, Some(recording)) if now >= until => self.go(recording),
            Phase::Hold(until, recording) if now >= until => self.stop(recording),
            Phase::LettingGo(until, recording) if now >= until => {
                self.keep(&recording, Verdict::Open)
            }
            Phase::Measuring => self.measure(),
            Phase::Rest(until) if now >= until => {
                let mut known = self.desk.known();
                known.phase = known.before_a_trial();
                Ok(())
            }
            Phase::Finishing => self.finish(),
            _ => Ok(()),
        };
        if let Err(error) = done {
            self.desk.known().trouble = error.to_string();
        }
        self.look(now);
        let phase = self.desk.known().phase.clone();
        if phase != self.last {
            self.last = phase;
            if let Some(session) = self.desk.session().as_ref() {
                session.tell_viewers();
            }
        }
    }

    /// Doubts, twice a second.
    fn look(&mut self, now: Instant) {
        if now - self.watched < WATCH_EVERY {
            return;
        }
        self.watched = now;
        let is_free = self.desk.known().phase == Phase::Ready;
        let warnings = match self.desk.session().as_ref() {
            Some(session) => self.desk.watch.warnings(session, is_free, &self.before),
            None => return,
        };
        self.desk.known().warnings = warnings;
    }

    /// Takes off what has drifted since the trial before, while the session is ready for the next. What is more than that stays, and is
    /// told as a doubt: the operator looks whether it is a hand.
    fn zero_by_itself(&self) {
        let next = self.desk.known().next_zero;
        match next {
            NextZero::ByHand => {}
            NextZero::Due => {
                let now = SystemTime::now();
                let session = self.desk.session();
                let take = |session: &Session| session.take_zero(false).is_ok();
                if self.desk.watch.is_free() && session.as_ref().is_some_and(take) {
                    self.desk.known().next_zero = NextZero::Asked(now);
                }
            }
            NextZero::Asked(at) => {
                if let Some(zero) = self.zero_since(at) {
                    let mut known = self.desk.known();
                    known.has_zero(&zero);
                    if let Err(error) = known.write() {
                        known.trouble = error.to_string();
                    }
                }
            }
        }
    }

    /// The zero, where it was taken since it was asked for.
    fn zero_since(&self, asked: SystemTime) -> Option<Tare> {
        let zero = self.desk.session().as_ref().and_then(Session::zero);
        zero.filter(|zero| zero.at >= asked)
    }

    /// Waits for the zero that was asked for.
    fn take_zero(&self, asked: SystemTime) -> Result<(), Error> {
        let taken = self.zero_since(asked);
        let mut known = self.desk.known();
        if let Some(zero) = taken {
            known.has_zero(&zero);
            known.is_zeroed = true;
            known.trouble.clear();
            known.phase = Phase::Ready;
            return known.write();
        }
        if asked.elapsed().unwrap_or_default() > ZERO_WITHIN {
            known.phase = Phase::Zero(None);
            return Err(Error::Request {
                what: format!(
                    "no frames came for {} s to take a zero from",
                    ZERO_WITHIN.as_secs()
                ),
                hint: "is the sensor connected?",
            });
        }
        Ok(())
    }

    fn begin_recording(&self, until: Instant) -> Result<(), Error> {
        let (path, name) = {
            let known = self.desk.known();
            let (_, planned) = known.next().expect("a trial is left");
            let name = GripRecord::free_name(&known.folder, planned);
            (known.folder.join(&name), name)
        };
        let begun = match self.desk.session().as_ref() {
            Some(session) => {
                if let Some(person) = session.person() {
                    person.rest();
                }
                session.record(&path, None)
            }
            None => Ok(()),
        };
        self.desk.known().phase = match begun {
            Ok(()) => Phase::Countdown(until, Some(name)),
            Err(_) => Phase::Ready,
        };
        begun
    }

    fn go(&self, recording: String) -> Result<(), Error> {
        let (hold, told) = {
            let known = self.desk.known();
            let hold = known.record.protocol.hold_secs;
            (Duration::from_secs_f64(hold), told(&known))
        };
        if let Some(session) = self.desk.session().as_ref() {
            session.mark(GO);
            if let Some(person) = session.person() {
                person.grip(told);
            }
        }
        self.desk.known().phase = Phase::Hold(Instant::now() + hold, recording);
        Ok(())
    }

    fn stop(&self, recording: String) -> Result<(), Error> {
        if let Some(session) = self.desk.session().as_ref() {
            session.mark(STOP);
        }
        let mut known = self.desk.known();
        known.hold_ended();
        known.phase = Phase::LettingGo(Instant::now() + LETTING_GO, recording);
        Ok(())
    }

    fn cancel(&self) -> Result<(), Error> {
        let (phase, was_held) = {
            let mut known = self.desk.known();
            known.is_cancelled = false;
            let was_held = matches!(known.phase, Phase::Hold(..));
            if was_held {
                known.hold_ended();
            }
            (known.phase.clone(), was_held)
        };
        let (Phase::Countdown(_, Some(recording)) | Phase::Hold(_, recording)) = phase else {
            self.desk.known().phase = Phase::Ready;
            return Ok(());
        };
        let reason = Verdict::Repeated("cancelled by the operator".to_owned());
        let kept = self.keep(&recording, reason);
        let mut known = self.desk.known();
        known.phase = if was_held {
            known.after_a_trial()
        } else {
            Phase::Ready
        };
        kept
    }

    /// Ends the recording and keeps the attempt.
    fn keep(&self, recording: &str, verdict: Verdict) -> Result<(), Error> {
        let (saved, told) = match self.desk.session().as_ref() {
            Some(session) => {
                let saved = session.stop_recording();
                let told = session.person().and_then(|person| {
                    let told = person.told();
                    person.rest();
                    told
                });
                (saved, told)
            }
            None => (None, None),
        };
        let mut known = self.desk.known();
        let (_, planned) = known.next().expect("a trial is left");
        let error = saved.as_ref().and_then(|saved| saved.error.clone());
        if saved.as_ref().is_none_or(|saved| saved.frames == 0) {
            known.phase = Phase::Ready;
            return Err(Error::Request {
                what: error.unwrap_or_else(|| "no frame came during the trial".to_owned()),
                hint: "nothing was recorded: is the sensor connected?",
            });
        }
        known.record.attempts.push(Attempt {
            planned,
            recording: recording.to_owned(),
            verdict,
            told,
            measured: None,
        });
        known.phase = Phase::Measuring;
        known.next_zero = if known.record.protocol.zero_before_trials {
            NextZero::Due
        } else {
            NextZero::ByHand
        };
        known.write()?;
        match error {
            Some(why) => Err(Error::Request {
                what: format!("the recording ended before its time: {why}"),
                hint: "repeat the trial",
            }),
            None => Ok(()),
        }
    }

    /// Measures the attempt that waits, with no lock held.
    fn measure(&self) -> Result<(), Error> {
        let (folder, recording, protocol) = {
            let mut known = self.desk.known();
            let recording = known.open().map(|attempt| attempt.recording.clone());
            let Some(recording) = recording else {
                known.phase = known.before_a_trial();
                return Ok(());
            };
            (
                known.folder.clone(),
                recording,
                known.record.protocol.clone(),
            )
        };
        let settings = &self.desk.settings;
        let looked = AttemptFile {
            recording: &folder.join(recording),
            sensor: &settings.sensor,
            sensor_file: &settings.sensor_file,
            protocol: &protocol,
        }
        .look();
        let mut known = self.desk.known();
        known.phase = Phase::Review;
        let measured = looked?;
        if let Some(attempt) = known.open() {
            attempt.measured = Some(measured);
        }
        known.write()
    }

    fn finish(&mut self) -> Result<(), Error> {
        let (folder, record) = {
            let known = self.desk.known();
            (known.folder.clone(), known.record.clone())
        };
        let settings = &self.desk.settings;
        let (sensor, sensor_file) = (&settings.sensor, &settings.sensor_file);
        let written = results::write(&folder, &record, sensor, |attempt| {
            self.background.measured(attempt, || {
                MeasuredTrial::of(&folder, attempt, &record, sensor, sensor_file)
            })
        });
        let mut known = self.desk.known();
        known.phase = Phase::Done;
        known.files = written?;
        known.record.is_finished = true;
        known.write()
    }
}

/// More attempts than a session has: those of two sessions differ.
const SESSION: usize = 1000;

/// What a simulated person is told: each attempt has an effort of its own, and the left hand is the weaker one.
fn told(known: &Known) -> ToldGrip {
    let hand = known.next().map(|(_, planned)| planned.hand);
    let strength = if hand == Some(Hand::Left) {
        LEFT_SHARE
    } else {
        1.0
    };
    let before = SESSION * known.record.session.saturating_sub(1);
    let attempt = (before + known.record.attempts.len()) as u64;
    ToldGrip::new(attempt, known.record.protocol.hold_secs, strength)
}
