//! Test against retest: what grip sessions of several persons tell of how well a grip repeats itself.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use taxel::frame::STANDARD_GRAVITY;
use taxel::stats::{Estimate, Retest};
use taxel_plot::report::{Figure, Report, Section, Table};
use taxel_plot::{Line, LineStyle, Picture, Series, cells};

use super::protocol::{Counts, Hand};
use super::record::GripRecord;
use super::results::{FILE as RESULTS, GripResults};
use super::table::unwritten;
use crate::error::Error;
use crate::session_folder;
use crate::text_file;

/// The longest results file, bytes.
const MAX: u64 = 16 << 20;
/// Folders are looked into so deep: a person's sessions, all persons, a study.
const DEPTH: usize = 4;

/// Sessions of several persons, and what they tell.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct RetestStudy {
    /// What forces are: `grip force` or `total normal force`.
    pub force: String,
    /// Sessions of each person that are compared.
    pub sessions: usize,
    /// What each person's hand came to, newtons, session by session.
    pub values: BTreeMap<Hand, BTreeMap<String, Vec<f64>>>,
    /// What cannot be compared, or only with doubt, in words.
    pub doubts: Vec<String>,
    /// How many of them, the first, say what was left out.
    left_out: usize,
    /// Whether a session was left out because it could not be read, or has no results.
    pub is_incomplete: bool,
}

/// A finished session.
struct Session {
    record: GripRecord,
    results: GripResults,
}

/// What counts of each session of each person, newtons.
type ByPerson<'a> = BTreeMap<String, Vec<(&'a Session, f64)>>;

impl RetestStudy {
    /// Of the folders of sessions, or folders that hold them; the first `sessions` sessions of each person.
    ///
    /// # Errors
    /// No session at all, sessions of different forces.
    pub fn of(folders: &[PathBuf], sessions: usize) -> Result<Self, Error> {
        let mut doubts = Vec::new();
        let (mut found, unread) = read_all(folders);
        let is_incomplete = !unread.is_empty();
        let why = unread.first().cloned();
        doubts.extend(unread);
        found.sort_by_key(|session| session.record.began_secs);
        let Some(first) = found.first() else {
            return Err(no_session(why));
        };
        let force = first.results.force.clone();
        if let Some(other) = found.iter().find(|session| session.results.force != force) {
            return Err(Error::Request {
                what: format!(
                    "sessions of {} tell the {force}, one of {} the {}",
                    first.record.person, other.record.person, other.results.force
                ),
                hint: "compare sessions on a handle with each other, and those on a mat with each other",
            });
        }
        let mut all: BTreeMap<Hand, ByPerson> = BTreeMap::new();
        for session in &found {
            for hand in &session.results.hands {
                let newtons = match session.record.protocol.result {
                    Counts::Mean => hand.mean.newtons,
                    Counts::Best => hand.best.newtons,
                };
                let persons = all.entry(hand.hand).or_default();
                let of_person = persons.entry(session.record.person.clone()).or_default();
                of_person.push((session, newtons));
            }
        }
        let mut few = Vec::new();
        for (hand, persons) in &mut all {
            few.extend(leave_out(*hand, persons, sessions));
        }
        let compared = all.values().flat_map(BTreeMap::values).flatten();
        let compared: Vec<&Session> = compared.map(|(session, _)| *session).collect();
        doubts.extend(few);
        let left_out = doubts.len();
        doubts.extend(differing(&compared));
        let newtons = |of: &Vec<(&Session, f64)>| of.iter().map(|one| one.1).collect();
        let of_hand = |persons: &ByPerson| {
            let each = persons.iter();
            each.map(|(person, of)| (person.clone(), newtons(of)))
                .collect()
        };
        let values = all.iter().map(|(hand, persons)| (*hand, of_hand(persons)));
        let values = values.collect();
        Ok(Self {
            force,
            sessions,
            values,
            doubts,
            left_out,
            is_incomplete,
        })
    }

    /// What each hand's sessions tell; `None` of fewer than three persons.
    pub fn of_hand(&self, hand: Hand) -> Option<Retest> {
        let persons = self.values.get(&hand)?;
        Retest::of(&persons.values().cloned().collect::<Vec<_>>())
    }

    /// Why nothing can be told of so many persons.
    fn too_little(&self, persons: usize) -> Error {
        let sessions = self.sessions;
        if persons >= 3 {
            return Error::Request {
                what: format!(
                    "the {persons} persons with {sessions} sessions of a hand are equally strong: what repeats cannot be told from what differs"
                ),
                hint: "were folders of one person copied?",
            };
        }
        let mut what = format!(
            "{persons} persons have {sessions} sessions of a hand; 3 are needed, and some dozens to tell much"
        );
        for doubt in &self.doubts[..self.left_out] {
            what += "; ";
            what += doubt.trim_end_matches('.');
        }
        Error::Request {
            what,
            hint: "give the folders of more persons, or fewer --sessions",
        }
    }

    /// All of it, to read.
    ///
    /// # Errors
    /// Fewer than three persons with as many sessions, for every hand; a picture that cannot be drawn.
    pub fn report(&self) -> Result<Report, Error> {
        let hands: Vec<(Hand, Retest)> = self
            .values
            .keys()
            .filter_map(|&hand| Some((hand, self.of_hand(hand)?)))
            .collect();
        if hands.is_empty() {
            let most = self.values.values().map(BTreeMap::len).max().unwrap_or(0);
            return Err(self.too_little(most));
        }
        let mut section = Section {
            title: format!("Test against retest: {}", self.force),
            ..Section::default()
        };
        section.paragraphs.clone_from(&self.doubts);
        section.tables.push(self.table(&hands));
        section.tables.push(differences(&hands));
        for (hand, retest) in &hands {
            section.figures.push(Figure {
                caption: format!(
                    "Bland–Altman, {} hand: second session less first over their mean, with the bias (solid) and the limits of agreement (dashed).",
                    hand.word()
                ),
                picture: self.picture(*hand, retest)?,
            });
        }
        Ok(Report {
            title: "Grip sessions compared".to_owned(),
            about: vec![(
                "Program".to_owned(),
                format!("taxel {}", env!("CARGO_PKG_VERSION")),
            )],
            sections: vec![section],
        })
    }

    fn table(&self, hands: &[(Hand, Retest)]) -> Table {
        let mut table = Table::new(
            "ICC(A,1): absolute agreement; ICC(C,1): consistency (McGraw and Wong 1996); SEM: standard error of measurement, a shift between sessions counted; MDC: smallest change between two sessions that is one, at 95 %",
            &[
                "hand", "persons", "sessions", "mean, N", "ICC(A,1)", "ICC(C,1)", "SEM, N",
                "SEM, kg", "MDC, N", "MDC, kg",
            ],
        );
        for (hand, retest) in hands {
            let kilograms = |newtons: f64| format!("{:.2}", newtons / STANDARD_GRAVITY);
            table.push(cells![
                hand.word(),
                retest.persons,
                retest.sessions,
                format!("{:.1}", retest.mean),
                shown(retest.agreement, 3),
                shown(retest.consistency, 3),
                format!("{:.2}", retest.standard_error),
                kilograms(retest.standard_error),
                format!("{:.2}", retest.detectable_change),
                kilograms(retest.detectable_change),
            ]);
        }
        table
    }

    fn picture(&self, hand: Hand, retest: &Retest) -> Result<Picture, Error> {
        let pairs: Vec<(f64, f64)> = self.values[&hand]
            .values()
            .map(|values| (0.5 * (values[0] + values[1]), values[1] - values[0]))
            .collect();
        let (mean, difference): (Vec<f64>, Vec<f64>) = pairs.into_iter().unzip();
        let ends = [
            mean.iter().copied().fold(f64::INFINITY, f64::min),
            mean.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        ];
        let level = |value: f64, style: LineStyle| {
            let line = Line::new("", vec![value; 2]).over(ends.to_vec());
            line.style(style).colour(7)
        };
        let [low, high] = retest.difference.limits;
        let lines = vec![
            level(retest.difference.mean.value, LineStyle::Solid),
            level(low.value, LineStyle::Dashed),
            level(high.value, LineStyle::Dashed),
            Line::new("", difference)
                .over(mean)
                .style(LineStyle::Points)
                .colour(0),
        ];
        let series = Series::new("mean of both sessions (N)", Vec::new(), lines)?;
        let series = series.quantity("second less first").unit("N");
        Ok(series.size(230.0, 150.0).picture()?)
    }

    /// A line a person, hand and session, for other programs.
    ///
    /// # Errors
    /// None that data could cause.
    pub fn csv(&self) -> Result<Vec<u8>, Error> {
        let mut out = csv::Writer::from_writer(Vec::new());
        out.write_record(["person", "hand", "session", "newtons"])
            .map_err(unwritten)?;
        for (hand, persons) in &self.values {
            for (person, values) in persons {
                for (session, newtons) in values.iter().enumerate() {
                    let line = [
                        person.clone(),
                        hand.word().to_owned(),
                        (session + 1).to_string(),
                        newtons.to_string(),
                    ];
                    out.write_record(line).map_err(unwritten)?;
                }
            }
        }
        out.into_inner().map_err(unwritten)
    }
}

/// "0.984 (0.909 to 0.997)".
fn shown(estimate: Estimate, decimals: usize) -> String {
    let number = |value: f64| format!("{value:.decimals$}").replace('-', "\u{2212}");
    let value = number(estimate.value);
    match estimate.interval {
        Some((low, high)) => format!("{value} ({} to {})", number(low), number(high)),
        None => value,
    }
}

fn differences(hands: &[(Hand, Retest)]) -> Table {
    let mut table = Table::new(
        "Second session less first, N, with 95 % intervals (Bland and Altman 1999)",
        &[
            "hand",
            "bias",
            "standard deviation",
            "lower limit",
            "upper limit",
        ],
    );
    for (hand, retest) in hands {
        let difference = retest.difference;
        let [low, high] = difference.limits;
        table.push(cells![
            hand.word(),
            shown(difference.mean, 2),
            format!("{:.2}", difference.deviation),
            shown(low, 2),
            shown(high, 2),
        ]);
    }
    table
}

/// What sessions differ by although they should not, in words.
fn differing(sessions: &[&Session]) -> Vec<String> {
    let mut doubts = Vec::new();
    let mut differ = |what: &str, of: &dyn Fn(&Session) -> String| {
        let mut values: Vec<String> = sessions.iter().map(|session| of(session)).collect();
        values.sort();
        values.dedup();
        if values.len() > 1 {
            doubts.push(format!("Sessions differ in {what}: {}.", values.join("; ")));
        }
    };
    differ("the sensor", &|session| session.results.sensor.clone());
    differ("what is simulated", &|session| {
        let simulated = session.results.is_simulated;
        if simulated { "simulated" } else { "measured" }.to_owned()
    });
    differ("the protocol", &|session| {
        let protocol = &session.record.protocol;
        let (trials, hold) = (protocol.trials, protocol.hold_secs);
        let counts = match protocol.result {
            Counts::Mean => "mean",
            Counts::Best => "best",
        };
        format!("{}, {counts} of {trials} trials, {hold} s", protocol.name)
    });
    differ("how many trials a hand were made", &|session| {
        let hands = &session.results.hands;
        let made = hands.iter().map(|hand| hand.trials.len()).min();
        made.unwrap_or(0).to_string()
    });
    if !sessions.is_empty() && sessions.iter().all(|session| session.results.is_simulated) {
        doubts.push("Simulated data: no person gripped.".to_owned());
    }
    doubts
}

/// Keeps the first sessions of each person of whom there are enough; the others in words.
fn leave_out(hand: Hand, persons: &mut ByPerson, sessions: usize) -> Option<String> {
    let few = persons.iter().filter(|(_, of)| of.len() < sessions);
    let few: Vec<&str> = few.map(|(person, _)| person.as_str()).collect();
    let words = (!few.is_empty()).then(|| {
        format!(
            "left out, with fewer than {sessions} sessions of the {} hand: {}",
            hand.word(),
            few.join(", ")
        )
    });
    persons.retain(|_, of| of.len() >= sessions);
    persons.values_mut().for_each(|of| of.truncate(sessions));
    words
}

/// Nothing is left to compare; `why`: what was wrong with the first folder or session that was left out.
fn no_session(why: Option<String>) -> Error {
    let why = why.map_or_else(String::new, |why| format!(": {why}"));
    Error::Request {
        what: format!("no finished grip session in the folders given{why}"),
        hint: "`taxel grip` keeps sessions below its --folder; one that is finished has a results.json",
    }
}

/// All finished sessions below the folders, and what of them could not be read, in words.
fn read_all(folders: &[PathBuf]) -> (Vec<Session>, Vec<String>) {
    let (mut sessions, mut unread) = (Vec::new(), Vec::new());
    let mut places: Vec<PathBuf> = Vec::new();
    for folder in folders {
        if let Err(error) = look_into(folder, DEPTH, &mut places) {
            unread.push(format!("{}: {error}", folder.display()));
        }
    }
    places.sort();
    places.dedup();
    for place in places {
        match read(&place) {
            Ok(Some(session)) => sessions.push(session),
            Ok(None) => unread.push(format!("{} is not finished: left out", place.display())),
            Err(error) => unread.push(error.to_string()),
        }
    }
    (sessions, unread)
}

/// Folders of sessions in a folder and below it.
fn look_into(folder: &Path, depth: usize, places: &mut Vec<PathBuf>) -> std::io::Result<()> {
    let entries = std::fs::read_dir(folder)?;
    if session_folder::is_session(folder) {
        places.push(folder.canonicalize()?);
        return Ok(());
    }
    for entry in entries {
        let entry = entry?;
        if depth > 1 && entry.file_type()?.is_dir() {
            look_into(&entry.path(), depth - 1, places)?;
        }
    }
    Ok(())
}

/// The session in a folder; `None` of one that is not finished.
fn read(folder: &Path) -> Result<Option<Session>, Error> {
    let record = GripRecord::read(folder)?;
    let file = folder.join(RESULTS);
    if !record.is_finished || !file.exists() {
        return Ok(None);
    }
    let text = text_file::read(&file, "results of a grip session", MAX)?;
    let results = serde_json::from_str(&text).map_err(|error| Error::Request {
        what: format!("{}: {error}", file.display()),
        hint: "`taxel grip` writes it",
    })?;
    Ok(Some(Session { record, results }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grip::Protocol;
    use crate::session_folder::SessionRecord as _;

    /// A finished session in a folder of its own.
    fn finished(all: &Path, person: &str, day: u64, newtons: [f64; 2]) -> PathBuf {
        let at = std::time::UNIX_EPOCH + std::time::Duration::from_secs(86_400 * day);
        let mut record = GripRecord::new(person, "", &Protocol::default(), at);
        let folder = GripRecord::new_folder(all, person, at).unwrap();
        record.is_finished = true;
        record.write(&folder).unwrap();
        let hand = |hand: &str, newtons: f64| {
            let force = serde_json::json!({"newtons": newtons, "half_width_95_newtons": null});
            serde_json::json!({"hand": hand, "best": force, "mean": force, "spread_newtons": null, "trials": []})
        };
        let results = serde_json::json!({
            "version": 1, "person": person, "began_secs": 86_400 * day, "sensor": "e-Cone", "force": "grip force",
            "intervals": "noise alone", "is_simulated": false,
            "hands": [hand("right", newtons[0]), hand("left", newtons[1])],
        });
        std::fs::write(folder.join(RESULTS), results.to_string()).unwrap();
        folder
    }

    #[test]
    fn sessions_are_found_and_compared_person_by_person() {
        let all = tempfile::tempdir().unwrap();
        let grips = [[77.1, 79.4], [102.5, 98.0], [64.2, 66.9], [88.8, 85.1]];
        for (number, grips) in grips.iter().enumerate() {
            // Later sessions first: their dates put them in order.
            for session in [1, 0] {
                let right = grips[session];
                let day = 20_000 + 7 * session as u64;
                finished(all.path(), &format!("P{number}"), day, [right, 0.9 * right]);
            }
        }
        finished(all.path(), "P9", 20_000, [50.0, 45.0]);
        let study = RetestStudy::of(&[all.path().to_owned()], 2).unwrap();
        assert_eq!(study.values[&Hand::Right]["P1"], [102.5, 98.0]);
        assert!(!study.is_incomplete && study.doubts.iter().any(|doubt| doubt.ends_with("P9")));
        let retest = study.of_hand(Hand::Right).unwrap();
        assert_eq!((retest.persons, retest.sessions), (4, 2));
        let left = study.of_hand(Hand::Left).unwrap();
        assert!((left.standard_error / retest.standard_error - 0.9).abs() < 1e-9);
        let text = study.report().unwrap().sections[0].to_string();
        assert!(
            text.contains("ICC(A,1)") && text.contains("right"),
            "{text}"
        );
        let csv = String::from_utf8(study.csv().unwrap()).unwrap();
        assert_eq!(csv.lines().count(), 17);
        assert_eq!(csv.lines().nth(2), Some("P0,right,2,79.4"));
        // Nobody has three.
        let none = RetestStudy::of(&[all.path().to_owned()], 3).unwrap();
        let why = none.report().unwrap_err().to_string();
        assert!(why.contains("0 persons have 3 sessions"), "{why}");
    }

    #[test]
    fn what_is_not_finished_or_broken_is_named() {
        let all = tempfile::tempdir().unwrap();
        let folders: Vec<PathBuf> = (0..3)
            .map(|day| finished(all.path(), "P1", 20_000 + day, [70.0, 60.0]))
            .collect();
        std::fs::remove_file(folders[0].join(RESULTS)).unwrap();
        std::fs::write(folders[1].join(RESULTS), "{").unwrap();
        let study = RetestStudy::of(&[all.path().to_owned()], 1).unwrap();
        assert!(study.is_incomplete);
        assert!(
            study
                .doubts
                .iter()
                .any(|doubt| doubt.contains("not finished"))
        );
        assert!(
            study
                .doubts
                .iter()
                .any(|doubt| doubt.contains("results.json"))
        );
        let nothing = RetestStudy::of(&[folders[0].clone()], 2).unwrap_err();
        assert!(nothing.to_string().contains("no finished grip session"));
    }
}
