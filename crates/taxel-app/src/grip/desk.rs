//! The grip session while it happens: phases, the operator's steps, and what each makes happen.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant, SystemTime};

use taxel::Sensor;
use taxel_acquire::Address;
use taxel_io::Tare;
use taxel_server::{
    GripPhase, GripSession, GripStep, GripTrial, Refused, Reply, ResultFile, State,
};

use super::protocol::{Hand, Planned, Protocol};
use super::record::{Attempt, GripRecord, Verdict, id_problem};
use super::results::force_of;
use super::watch::Watch;
use crate::error::Error;
use crate::session::{Guide, GuideStep, Session};
use crate::session_folder::{self, SessionRecord as _};

/// The longest note and reason.
const MAX_TEXT: usize = 500;

/// What the session is about, and where it is kept.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct GripSettings {
    /// Where frames come from.
    pub address: Address,
    /// The sensor,
    pub sensor: Sensor,
    /// and where that comes from.
    pub sensor_file: PathBuf,
    /// What is asked of the person.
    pub protocol: Protocol,
    /// Where the sessions of all persons are kept.
    pub folder: PathBuf,
    /// Whether one that was left unfinished is left alone.
    pub begin_anew: bool,
}

impl GripSettings {
    /// The usual protocol, kept below `grips`.
    pub fn new(address: Address, sensor: Sensor, sensor_file: impl Into<PathBuf>) -> Self {
        Self {
            address,
            sensor,
            sensor_file: sensor_file.into(),
            protocol: Protocol::default(),
            folder: PathBuf::from("grips"),
            begin_anew: false,
        }
    }
}

/// A phase, with what only it needs.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Phase {
    Setup,
    /// Asked for at that time, by a source that has given none yet.
    Zero(Option<SystemTime>),
    Ready,
    /// To its end; the recording that goes on, once it does.
    Countdown(Instant, Option<String>),
    Hold(Instant, String),
    /// The hand lets go; the recording goes on.
    LettingGo(Instant, String),
    Measuring,
    Review,
    Rest(Instant),
    Finishing,
    Done,
}

/// How it stands.
pub(super) struct Known {
    pub phase: Phase,
    pub record: GripRecord,
    pub folder: PathBuf,
    /// When each hand's last hold ended.
    pub rests_since: BTreeMap<Hand, Instant>,
    /// Whether a zero was taken since the program began.
    pub is_zeroed: bool,
    pub next_zero: NextZero,
    pub is_resumed: bool,
    pub trouble: String,
    pub warnings: Vec<String>,
    pub files: Vec<String>,
    /// The countdown or the hold is to end now.
    pub is_cancelled: bool,
}

impl Known {
    /// The first trial of the plan that has no attempt which counts.
    pub(super) fn next(&self) -> Option<(usize, Planned)> {
        let accepted = self.record.accepted();
        let place = accepted.iter().position(|(_, attempt)| attempt.is_none())?;
        Some((place, accepted[place].0))
    }

    /// The attempt that waits for a verdict.
    pub(super) fn open(&mut self) -> Option<&mut Attempt> {
        let attempts = self.record.attempts.iter_mut();
        attempts
            .rev()
            .find(|attempt| attempt.verdict == Verdict::Open)
    }

    /// Before the next trial: the zero first, where there is none yet.
    pub(super) fn before_a_trial(&self) -> Phase {
        if self.is_zeroed {
            Phase::Ready
        } else {
            Phase::Zero(None)
        }
    }

    /// After an attempt has its verdict: the hand that comes next rests as long as it must, the other one may grip meanwhile.
    pub(super) fn after_a_trial(&self) -> Phase {
        let Some((_, next)) = self.next() else {
            return Phase::Finishing;
        };
        let rest = Duration::from_secs_f64(self.record.protocol.rest_secs);
        match self.rests_since.get(&next.hand) {
            Some(&since) if since + rest > Instant::now() => Phase::Rest(since + rest),
            _ => self.before_a_trial(),
        }
    }

    /// The hand that grips has let go.
    pub(super) fn hold_ended(&mut self) {
        if let Some((_, planned)) = self.next() {
            self.rests_since.insert(planned.hand, Instant::now());
        }
    }

    pub(super) fn write(&mut self) -> Result<(), Error> {
        self.record.write(&self.folder)
    }

    /// Notes a zero that was taken.
    pub(super) fn has_zero(&mut self, zero: &Tare) {
        self.record.zeros_newtons.push(zero.loads.iter().sum());
        self.next_zero = NextZero::ByHand;
    }
}

/// When the zero is taken again.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum NextZero {
    /// When the operator asks for it.
    ByHand,
    /// By itself before the next trial, once nobody holds the handle.
    Due,
    /// So it was asked for at that time, and is being taken.
    Asked(SystemTime),
}

/// A grip session: what viewers and the terminal talk to.
pub(super) struct Desk {
    pub(super) settings: GripSettings,
    known: Mutex<Known>,
    /// Until the frames' own thread has begun.
    pub(super) session: Mutex<Option<Session>>,
    pub(super) watch: Arc<Watch>,
}

impl Desk {
    pub(super) fn new(settings: GripSettings) -> Self {
        let nobody = GripRecord::new("", "", &settings.protocol, SystemTime::now());
        let watch = Arc::new(Watch::new(&settings.sensor));
        Self {
            settings,
            known: Mutex::new(Known {
                phase: Phase::Setup,
                record: nobody,
                folder: PathBuf::new(),
                rests_since: BTreeMap::new(),
                is_zeroed: false,
                next_zero: NextZero::ByHand,
                is_resumed: false,
                trouble: String::new(),
                warnings: Vec::new(),
                files: Vec::new(),
                is_cancelled: false,
            }),
            session: Mutex::new(None),
            watch,
        }
    }

    pub(super) fn known(&self) -> MutexGuard<'_, Known> {
        self.known.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn session(&self) -> MutexGuard<'_, Option<Session>> {
        self.session.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn begin(&self, person: &str, note: &str) -> Result<Reply, Refused> {
        let (person, note) = (person.trim(), note.trim());
        if let Some(problem) = id_problem(person) {
            return Err(Refused::because(problem));
        }
        let mut known = self.known();
        if known.phase != Phase::Setup {
            return Err(Refused::because("a session goes on already"));
        }
        let (all, now) = (&self.settings.folder, SystemTime::now());
        let left = GripRecord::unfinished(all, person, now);
        let left = left.filter(|(_, record)| {
            !self.settings.begin_anew && record.protocol == self.settings.protocol
        });
        known.is_resumed = left.is_some();
        let begun = match left {
            Some(left) => left,
            None => self.new_record(person, note, now)?,
        };
        (known.folder, known.record) = begun;
        let written = known.write();
        written.map_err(|error| Refused::because(error.to_string()))?;
        let waits = known.open().is_some();
        known.phase = match known.next() {
            None => Phase::Finishing,
            Some(_) if waits => Phase::Measuring,
            Some(_) => known.before_a_trial(),
        };
        Ok(Reply::saying(if known.is_resumed {
            format!(
                "{} was left unfinished, and goes on",
                known.folder.display()
            )
        } else {
            format!("everything is kept in {}", known.folder.display())
        }))
    }

    fn new_record(
        &self,
        person: &str,
        note: &str,
        now: SystemTime,
    ) -> Result<(PathBuf, GripRecord), Refused> {
        let note: String = note.chars().take(MAX_TEXT).collect();
        let mut record = GripRecord::new(person, &note, &self.settings.protocol, now);
        record.sensor = self.settings.sensor.name().to_owned();
        record.session = 1 + GripRecord::count(&self.settings.folder, person);
        record.source = self.settings.address.to_string();
        record.simulated_seed = match &self.settings.address {
            Address::Sim { seed, .. } => Some(*seed),
            _ => None,
        };
        let folder = GripRecord::new_folder(&self.settings.folder, person, now);
        let folder = folder.map_err(|error| Refused::because(error.to_string()))?;
        Ok((folder, record))
    }

    fn zero(&self, force: bool) -> Result<Reply, Refused> {
        if !matches!(self.known().phase, Phase::Zero(_) | Phase::Ready) {
            return Err(Refused::because("the zero is taken before a trial"));
        }
        let asked = SystemTime::now();
        let session = self.session();
        let session = session
            .as_ref()
            .ok_or_else(|| Refused::because("it has not begun"))?;
        let text = session.take_zero(force).map_err(Refused::because)?;
        self.known().phase = Phase::Zero(Some(asked));
        Ok(Reply::saying(text))
    }

    fn start(&self) -> Result<Reply, Refused> {
        let mut known = self.known();
        if known.phase != Phase::Ready {
            return Err(Refused::because(
                "a trial is started when the session is ready for it",
            ));
        }
        let wait = Duration::from_secs_f64(known.record.protocol.countdown_secs);
        known.trouble.clear();
        known.is_cancelled = false;
        known.phase = Phase::Countdown(Instant::now() + wait, None);
        Ok(Reply::done())
    }

    fn cancel(&self) -> Result<Reply, Refused> {
        let mut known = self.known();
        if !matches!(known.phase, Phase::Countdown(..) | Phase::Hold(..)) {
            return Err(Refused::because("no trial goes on"));
        }
        known.is_cancelled = true;
        Ok(Reply::done())
    }

    /// Accepts the attempt, or repeats it for a reason.
    fn judge(&self, verdict: Verdict) -> Result<Reply, Refused> {
        let mut known = self.known();
        if known.phase != Phase::Review {
            return Err(Refused::because("no trial waits to be judged"));
        }
        let nothing = || Refused::because("no trial waits to be judged");
        let attempt = known.open().ok_or_else(nothing)?;
        if verdict == Verdict::Accepted && attempt.measured.is_none() {
            return Err(Refused::because(
                "there is nothing to accept: this trial could not be measured",
            ));
        }
        attempt.verdict = verdict;
        if let Err(error) = known.write() {
            // It counts when it is kept.
            if let Some(attempt) = known.record.attempts.last_mut() {
                attempt.verdict = Verdict::Open;
            }
            return Err(Refused::because(error.to_string()));
        }
        known.trouble.clear();
        known.phase = known.after_a_trial();
        Ok(Reply::done())
    }

    fn skip_rest(&self) -> Result<Reply, Refused> {
        let mut known = self.known();
        if !matches!(known.phase, Phase::Rest(_)) {
            return Err(Refused::because("nobody rests"));
        }
        known.phase = known.before_a_trial();
        Ok(Reply::done())
    }

    fn finish(&self) -> Result<Reply, Refused> {
        let mut known = self.known();
        match known.phase {
            Phase::Setup | Phase::Finishing | Phase::Done => {
                Err(Refused::because("no session goes on"))
            }
            Phase::Countdown(..) | Phase::Hold(..) | Phase::LettingGo(..) | Phase::Measuring => {
                Err(Refused::because("a trial goes on: cancel it first"))
            }
            _ if known.record.accepted().iter().all(|(_, a)| a.is_none()) => Err(Refused::because(
                "no trial has been accepted: there is nothing to write",
            )),
            _ => {
                known.phase = Phase::Finishing;
                Ok(Reply::done())
            }
        }
    }
}

impl Desk {
    /// How it stands.
    pub(super) fn state(&self) -> GripSession {
        let known = self.known();
        let protocol = &known.record.protocol;
        let (phase, until, lasts) = match &known.phase {
            Phase::Setup => (GripPhase::Setup, None, None),
            Phase::Zero(_) => (GripPhase::Zero, None, None),
            Phase::Ready => (GripPhase::Ready, None, None),
            Phase::Countdown(until, _) => {
                let lasts = protocol.countdown_secs;
                (GripPhase::Countdown, Some(*until), Some(lasts))
            }
            Phase::Hold(until, _) => (GripPhase::Hold, Some(*until), Some(protocol.hold_secs)),
            Phase::LettingGo(..) | Phase::Measuring => (GripPhase::Measuring, None, None),
            Phase::Review => (GripPhase::Review, None, None),
            Phase::Rest(until) => (GripPhase::Rest, Some(*until), Some(protocol.rest_secs)),
            Phase::Finishing => (GripPhase::Finishing, None, None),
            Phase::Done => (GripPhase::Done, None, None),
        };
        let trial = |(planned, attempt): &(Planned, Option<&Attempt>)| {
            let mut shown = GripTrial::planned(planned.hand.shown(), planned.number);
            shown.repeats = known.record.repeats(*planned);
            let measured = attempt.and_then(|attempt| attempt.measured.as_ref());
            shown.accepted = measured.cloned();
            shown
        };
        let now = Instant::now();
        let mut state = GripSession::default();
        state.phase = phase;
        state.remaining_secs = until.map(|until| (until - now).as_secs_f64());
        state.lasts_secs = lasts;
        state.person.clone_from(&known.record.person);
        state.folder = known.folder.display().to_string();
        state.trial = known.next().map(|(place, _)| place);
        state.trials = known.record.accepted().iter().map(trial).collect();
        let open = known.record.attempts.iter().rev();
        let open = open
            .clone()
            .find(|attempt| attempt.verdict == Verdict::Open);
        let measured = open.and_then(|attempt| attempt.measured.as_ref());
        state.measured = measured.cloned();
        state.protocol = protocol.shown(force_of(&self.settings.sensor));
        state.warnings.clone_from(&known.warnings);
        state.trouble.clone_from(&known.trouble);
        state.is_resumed = known.is_resumed;
        state.is_simulated = matches!(self.settings.address, Address::Sim { .. });
        state.files.clone_from(&known.files);
        state
    }

    pub(super) fn go_on(&self, step: GripStep) -> Result<Reply, Refused> {
        match step {
            GripStep::Begin { person, note } => self.begin(&person, &note),
            GripStep::Zero { force } => self.zero(force),
            GripStep::Start => self.start(),
            GripStep::Cancel => self.cancel(),
            GripStep::Accept => self.judge(Verdict::Accepted),
            GripStep::Repeat { reason } => {
                let reason: String = reason.trim().chars().take(MAX_TEXT).collect();
                if reason.is_empty() {
                    return Err(Refused::because("a trial is repeated for a reason"));
                }
                self.judge(Verdict::Repeated(reason))
            }
            GripStep::SkipRest => self.skip_rest(),
            GripStep::Finish => self.finish(),
            _ => Err(Refused::because("this program does not know that step")),
        }
    }
}

impl Guide for Desk {
    fn name(&self) -> &'static str {
        "a grip session"
    }

    fn tell(&self, state: &mut State) {
        state.grip = Some(Box::new(self.state()));
    }

    fn step(&self, step: GuideStep) -> Result<Reply, Refused> {
        match step {
            GuideStep::Grip(step) => self.go_on(step),
            _ => Err(Refused::because("this is a grip session")),
        }
    }

    fn result_file(&self, name: &str) -> Option<ResultFile> {
        let file = {
            let known = self.known();
            let listed = known.files.iter().find(|file| *file == name)?;
            known.folder.join(listed)
        };
        session_folder::result_file(&file)
    }
}
