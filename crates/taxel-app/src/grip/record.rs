//! What is kept of a grip session: a folder with a recording a trial, and `session.json`, written anew after every step, so that a
//! crash loses no trial.

use std::path::{Path, PathBuf};
use std::time::SystemTime;

use serde::{Deserialize, Serialize};
use taxel_acquire::simulated::ToldGrip;
use taxel_server::GripMeasured;

use super::protocol::{Hand, Planned, Protocol};
use crate::error::Error;
use crate::session_folder::{self, SessionRecord, is_recent, since_1970};

/// The longest pseudonymous id.
const MAX_ID: usize = 40;

/// A grip session, as far as it has come.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[non_exhaustive]
pub struct GripRecord {
    version: u32,
    /// Pseudonymous id of the person.
    pub person: String,
    /// What the operator wants to remember.
    pub note: String,
    /// Which of the person's sessions in its folder, from 1.
    pub session: usize,
    /// When it began, seconds since 1970.
    pub began_secs: u64,
    /// When it was written last.
    pub written_secs: u64,
    /// The program that measured.
    pub program: String,
    /// Name of the sensor.
    pub sensor: String,
    /// Where frames came from.
    pub source: String,
    /// The seed of a simulated person; `None` of a real one.
    pub simulated_seed: Option<u64>,
    /// What it asks for.
    pub protocol: Protocol,
    /// Newtons that were taken off, each time the zero was taken.
    pub zeros_newtons: Vec<f64>,
    /// Every attempt that was recorded, in order.
    pub attempts: Vec<Attempt>,
    /// Whether the results are written.
    pub is_finished: bool,
}

/// One attempt at a trial.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Attempt {
    /// Which trial.
    #[serde(flatten)]
    pub planned: Planned,
    /// Its recording, in the session's folder.
    pub recording: String,
    /// What became of it.
    pub verdict: Verdict,
    /// What a simulated person was told to do: the truth can be told from it.
    pub told: Option<ToldGrip>,
    /// What it came to, once it was measured.
    pub measured: Option<GripMeasured>,
}

/// What the operator said of an attempt.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[allow(
    clippy::exhaustive_enums,
    reason = "an attempt counts, does not, or is not decided"
)]
pub enum Verdict {
    /// Nothing yet.
    Open,
    /// It counts.
    Accepted,
    /// It does not count, for this reason.
    Repeated(String),
}

/// What is wrong with an id; `None` where it will do.
pub fn id_problem(id: &str) -> Option<String> {
    if id.is_empty() {
        return Some("an id is needed: letters and digits, no name".to_owned());
    }
    let is_plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_');
    if let Some(other) = id.chars().find(|&c| !is_plain(c)) {
        return Some(format!(
            "the id has a {other:?}, expected letters, digits, - and _"
        ));
    }
    let length = id.chars().count();
    (length > MAX_ID).then(|| format!("the id has {length} characters, at most {MAX_ID}"))
}

impl SessionRecord for GripRecord {
    const OF: &str = "a grip session";
    const VERSION: u32 = 1;
    const HINT: &'static str =
        "`taxel grip` writes it; a folder of a grip session has it beside its recordings";

    fn version(&self) -> u32 {
        self.version
    }

    fn written_secs(&mut self) -> &mut u64 {
        &mut self.written_secs
    }
}

impl GripRecord {
    pub(super) fn new(person: &str, note: &str, protocol: &Protocol, at: SystemTime) -> Self {
        Self {
            version: Self::VERSION,
            person: person.to_owned(),
            note: note.to_owned(),
            session: 1,
            began_secs: since_1970(at),
            written_secs: since_1970(at),
            program: format!("taxel {}", env!("CARGO_PKG_VERSION")),
            sensor: String::new(),
            source: String::new(),
            simulated_seed: None,
            protocol: protocol.clone(),
            zeros_newtons: Vec::new(),
            attempts: Vec::new(),
            is_finished: false,
        }
    }

    /// Sessions of a person below `all`.
    pub(super) fn count(all: &Path, person: &str) -> usize {
        let folders = std::fs::read_dir(all.join(person));
        let folders = folders.into_iter().flatten().flatten();
        folders
            .filter(|entry| session_folder::is_session(&entry.path()))
            .count()
    }

    /// Where the sessions of a person stand below `all`, each in a folder of its own.
    pub(super) fn new_folder(all: &Path, person: &str, at: SystemTime) -> Result<PathBuf, Error> {
        session_folder::new_folder(&all.join(person), at)
    }

    /// The newest session of a person below `all` that was left unfinished not long ago, where there is one.
    pub(super) fn unfinished(all: &Path, person: &str, now: SystemTime) -> Option<(PathBuf, Self)> {
        let (folder, record) = Self::newest_first(&all.join(person)).next()?;
        let is_recent = is_recent(record.written_secs, since_1970(now));
        (!record.is_finished && is_recent && record.person == person).then_some((folder, record))
    }

    /// Of a session's folder.
    ///
    /// # Errors
    /// A file that is not there, or is none of these.
    pub fn read(folder: &Path) -> Result<Self, Error> {
        SessionRecord::read(folder)
    }

    /// The attempt that counts for each trial of the plan, in its order.
    pub fn accepted(&self) -> Vec<(Planned, Option<&Attempt>)> {
        let of = |planned: &Planned| {
            let mut attempts = self.attempts.iter();
            attempts
                .find(|attempt| attempt.planned == *planned && attempt.verdict == Verdict::Accepted)
        };
        let plan = self.protocol.plan();
        plan.iter().map(|planned| (*planned, of(planned))).collect()
    }

    /// How often a trial was repeated.
    pub(super) fn repeats(&self, planned: Planned) -> usize {
        let repeated = |attempt: &&Attempt| {
            attempt.planned == planned && matches!(attempt.verdict, Verdict::Repeated(_))
        };
        self.attempts.iter().filter(repeated).count()
    }

    /// A name that no recording in the folder has, of one more attempt.
    pub(super) fn free_name(folder: &Path, planned: Planned) -> String {
        let stem = format!("{}-{}", planned.hand.word(), planned.number);
        let names = (1..).map(|attempt| match attempt {
            1 => format!("{stem}.mcap"),
            n => format!("{stem}-attempt-{n}.mcap"),
        });
        let mut free = names.filter(|name| !folder.join(name).exists());
        free.next().expect("numbers do not end")
    }

    /// Attempts of a hand that count, in order.
    pub fn of_hand(&self, hand: Hand) -> impl Iterator<Item = &Attempt> {
        self.accepted()
            .into_iter()
            .filter(move |(planned, _)| planned.hand == hand)
            .filter_map(|(_, attempt)| attempt)
    }
}

#[cfg(test)]
mod tests {
    use std::time::UNIX_EPOCH;

    use super::*;

    fn attempt(planned: Planned, verdict: Verdict) -> Attempt {
        Attempt {
            planned,
            recording: "right-1.mcap".to_owned(),
            verdict,
            told: Some(ToldGrip::new(1, 8.0, 0.93)),
            measured: None,
        }
    }

    #[test]
    fn a_session_is_found_again_as_it_was_left() {
        let all = tempfile::tempdir().unwrap();
        let now = UNIX_EPOCH + std::time::Duration::from_secs(1_795_255_200);
        let protocol = Protocol::default();
        let plan = protocol.plan();
        let mut record = GripRecord::new("P01", "glove", &protocol, now);
        let folder = GripRecord::new_folder(all.path(), "P01", now).unwrap();
        assert_ne!(
            GripRecord::new_folder(all.path(), "P01", now).unwrap(),
            folder
        );
        let slipped = Verdict::Repeated("slipped".to_owned());
        record.attempts.push(attempt(plan[0], slipped));
        record.attempts.push(attempt(plan[0], Verdict::Accepted));
        record.write(&folder).unwrap();
        let soon = SystemTime::now();
        // The newest folder holds no session, so that it is passed over.
        let (found, read) = GripRecord::unfinished(all.path(), "P01", soon).unwrap();
        assert_eq!(found, folder);
        assert_eq!(
            serde_json::to_string(&read).unwrap(),
            serde_json::to_string(&record).unwrap()
        );
        assert_eq!(read.repeats(plan[0]), 1);
        let accepted: Vec<bool> = read.accepted().iter().map(|(_, a)| a.is_some()).collect();
        assert_eq!(accepted, [true, false, false, false, false, false]);
        assert_eq!(read.of_hand(Hand::Left).count(), 0);
        // A day later, of another person, or finished, there is nothing to go on with.
        let later = soon + std::time::Duration::from_secs(86_400);
        assert!(GripRecord::unfinished(all.path(), "P01", later).is_none());
        assert!(GripRecord::unfinished(all.path(), "P02", soon).is_none());
        record.is_finished = true;
        record.write(&folder).unwrap();
        assert!(GripRecord::unfinished(all.path(), "P01", soon).is_none());
        assert_eq!(GripRecord::count(all.path(), "P01"), 1);
        assert_eq!(GripRecord::count(all.path(), "P02"), 0);
    }

    #[test]
    fn names_of_recordings_are_free_and_ids_stay_in_their_folder() {
        let folder = tempfile::tempdir().unwrap();
        let planned = Protocol::default().plan()[1];
        let first = GripRecord::free_name(folder.path(), planned);
        assert_eq!(first, "left-1.mcap");
        std::fs::write(folder.path().join(first), "").unwrap();
        let second = GripRecord::free_name(folder.path(), planned);
        assert_eq!(second, "left-1-attempt-2.mcap");
        for id in ["", "../x", "A B", "J. Doe", "é", &"x".repeat(41)] {
            assert!(id_problem(id).is_some(), "{id}");
        }
        assert_eq!(id_problem("P-01_b"), None);
    }
}
