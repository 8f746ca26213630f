//! A guided calibration while it happens: phases, the operator's steps, and what is shown of them.

use std::collections::VecDeque;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::SystemTime;

use taxel::calibrate::{MadePress, PressPlan};
use taxel::{Counts, Frame};
use taxel_server::{
    AskedPress, BadLines, CalibrationPhase, CalibrationSession, CalibrationStep, Refused, Reply,
    ResultFile, SeenPress, State, TakenPress,
};

use super::GuidedSettings;
use super::fits::{Evidence, Fits, judge};
use super::press_watch::{PressWatch, Pressing};
use super::record::{CalibrationRecord, KeptPress, read_mean};
use crate::error::Error;
use crate::session::{Guide, GuideStep, Session};
use crate::session_folder::{self, SessionRecord as _};

/// The fewest presses that anything is fitted to.
pub(super) const MIN_PRESSES: usize = 8;
/// The fewest after which it is said that they are enough.
const LEAST_PRESSES: usize = 20;

/// A phase, with what only it needs.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Phase {
    Empty,
    /// Read empty, or with other things on it.
    Reading,
    Others,
    Press,
    Elsewhere,
    /// Stands; the recording that goes on, by its name without ending.
    Taking(Pressing, String),
    Off(Pressing),
    Finishing,
    Done,
}

/// How it stands.
pub(super) struct Known {
    pub phase: Phase,
    pub record: CalibrationRecord,
    pub folder: PathBuf,
    /// The mean frame of each press of the record.
    pub frames: Vec<Arc<Frame<Counts>>>,
    pub asked: Option<AskedPress>,
    pub seen: Option<SeenPress>,
    /// To be pressed again: the others contradict the first time.
    pub again: VecDeque<AskedPress>,
    /// Taxels that the operator did not want to press.
    pub avoided: Vec<(usize, usize)>,
    pub others_lie: bool,
    pub is_resumed: bool,
    pub warnings: Vec<String>,
    pub trouble: String,
    pub files: Vec<String>,
    /// Why the result should not be used as it is.
    pub doubts: Vec<String>,
    /// Revision of the fit whose contradictions were looked at.
    pub looked_at: u64,
}

impl Known {
    /// Presses of single taxels that count.
    fn made(&self) -> Vec<MadePress> {
        let counting = self.record.presses.iter().filter(|press| press.counts());
        counting.filter_map(KeptPress::made).collect()
    }

    /// Presses of single taxels that count.
    pub(super) fn counting(&self) -> usize {
        self.made().len()
    }

    pub(super) fn evidence(&self) -> Evidence {
        Evidence {
            presses: self.record.presses.clone(),
            frames: self.frames.clone(),
        }
    }

    pub(super) fn write(&mut self) -> Result<(), Error> {
        self.record.write(&self.folder)
    }

    /// Whether what is asked for is a load on all taxels.
    pub(super) fn asks_for_even_load(&self) -> bool {
        let asked = self.asked.as_ref();
        asked.is_some_and(|asked| asked.row.is_none())
    }

    /// The even load that has not been laid yet.
    fn even_left(&self) -> Option<f64> {
        let is_laid = |load: f64| {
            let mut presses = self.record.presses.iter();
            presses.any(|press| press.taxel.is_none() && press.load_g == load)
        };
        let mut loads = self.record.even_g.iter().copied();
        loads.find(|load| !is_laid(*load))
    }
}

/// What viewers and the terminal talk to.
pub(super) struct Desk {
    pub(super) settings: GuidedSettings,
    plan: Mutex<PressPlan>,
    known: Mutex<Known>,
    pub(super) session: Mutex<Option<Session>>,
    watch: Mutex<PressWatch>,
    pub(super) fits: Fits,
}

impl Desk {
    /// Finds what was left unfinished, or begins anew.
    pub(super) fn new(settings: GuidedSettings) -> Result<Self, Error> {
        let sensor = &settings.sensor;
        let in_file = |source| Error::InFile {
            file: settings.sensor_file.clone(),
            source,
        };
        let plan = PressPlan::new(sensor, &settings.loads_g).map_err(in_file)?;
        let source = settings.address.to_string();
        let mut record = CalibrationRecord::new(sensor, source, plan.loads_g(), &settings.even_g);
        let left = if settings.begin_anew {
            None
        } else {
            record.unfinished(&settings.folder)
        };
        let is_resumed = left.is_some();
        let folder = match left {
            Some((folder, left)) => {
                record = left;
                folder
            }
            None => session_folder::new_folder(&settings.folder, SystemTime::now())?,
        };
        let read = |press: &KeptPress| read_mean(&folder.join(&press.file), sensor).map(Arc::new);
        let frames: Result<Vec<_>, _> = record.presses.iter().map(read).collect();
        let mut known = Known {
            phase: Phase::Empty,
            frames: frames?,
            record,
            folder,
            asked: None,
            seen: None,
            again: VecDeque::new(),
            avoided: Vec::new(),
            others_lie: false,
            is_resumed,
            warnings: Vec::new(),
            trouble: String::new(),
            files: Vec::new(),
            doubts: Vec::new(),
            looked_at: 0,
        };
        known.write()?;
        let desk = Self {
            watch: Mutex::new(PressWatch::new(sensor)?),
            fits: Fits::new(sensor, settings.options.clone()),
            settings,
            plan: Mutex::new(plan),
            known: Mutex::new(known),
            session: Mutex::new(None),
        };
        desk.ask_for_fit();
        Ok(desk)
    }

    pub(super) fn known(&self) -> MutexGuard<'_, Known> {
        self.known.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn plan(&self) -> MutexGuard<'_, PressPlan> {
        self.plan.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// These lines are broken: nothing is asked for on them, and the fit leaves them alone.
    pub(super) fn set_dead_lines(&self, lines: &BadLines) {
        let edited = self.settings.sensor.edited(|spec| {
            let screen = &mut spec.screen;
            for (all, found) in [
                (&mut screen.dead_rows, &lines.rows),
                (&mut screen.dead_columns, &lines.columns),
            ] {
                all.extend(found);
                all.sort_unstable();
                all.dedup();
            }
        });
        let Ok(sensor) = edited else { return };
        // Where all is broken there is nothing to plan: the plan stays, and the warning is there.
        if let Ok(plan) = PressPlan::new(&sensor, &self.settings.loads_g) {
            *self.plan() = plan;
            self.fits.set_sensor(&sensor);
            self.watch().set_bad_lines(lines);
            let mut known = self.known();
            let is_dead = known.asked.as_ref().is_some_and(|asked| {
                let is_on = |line: Option<usize>, dead: &[usize]| {
                    line.is_some_and(|line| dead.contains(&line))
                };
                is_on(asked.row, &lines.rows) || is_on(asked.column, &lines.columns)
            });
            if is_dead && matches!(known.phase, Phase::Press | Phase::Elsewhere | Phase::Others) {
                self.ask_next(&mut known);
            }
        }
    }

    pub(super) fn session(&self) -> MutexGuard<'_, Option<Session>> {
        self.session.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn watch(&self) -> MutexGuard<'_, PressWatch> {
        self.watch.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Fits what there is, where that is enough.
    pub(super) fn ask_for_fit(&self) {
        let known = self.known();
        if known.counting() >= MIN_PRESSES {
            self.fits.ask(known.evidence());
        }
    }

    /// Chooses the next press, and what is to be done before it.
    pub(super) fn ask_next(&self, known: &mut Known) {
        let asked = match known.again.pop_front() {
            Some(again) => again,
            None => self.planned(known),
        };
        known.phase = match (asked.is_among_others, known.others_lie) {
            (true, false) => Phase::Others,
            (false, true) => Phase::Empty,
            _ => Phase::Press,
        };
        known.seen = None;
        known.asked = Some(asked);
    }

    fn planned(&self, known: &Known) -> AskedPress {
        let made = known.made();
        // Even loads when the law is known a little: they tell how taxels differ.
        if made.len() >= MIN_PRESSES
            && let Some(load_g) = known.even_left()
        {
            let mut asked = AskedPress::of_all(load_g);
            "the same load everywhere tells how taxels differ".clone_into(&mut asked.why);
            return asked;
        }
        let fit = self.fits.latest();
        let fitted = fit.as_ref().and_then(|fit| fit.found.as_ref().ok());
        let sensor = fitted.map(|found| &found.sensor);
        let others = self.watch().others();
        let planned = self.plan().next(&made, &known.avoided, sensor, &others);
        let press = planned.press;
        let mut asked = AskedPress::of_taxel(press.row, press.column, press.load_g);
        asked.is_among_others = press.is_among_others;
        asked.why = planned.reason.to_string();
        asked
    }

    fn ready(&self) -> Result<Reply, Refused> {
        let mut known = self.known();
        known.others_lie = match known.phase {
            Phase::Empty => false,
            Phase::Others => true,
            Phase::Off(_) => known.others_lie,
            _ => return Err(Refused::because("nothing waits for that")),
        };
        known.trouble.clear();
        known.phase = Phase::Reading;
        self.watch().look_anew();
        Ok(Reply::done())
    }

    fn here(&self) -> Result<Reply, Refused> {
        let mut known = self.known();
        let known = &mut *known;
        let (Phase::Elsewhere, Some(seen), Some(asked)) =
            (&known.phase, &known.seen, &mut known.asked)
        else {
            return Err(Refused::because("nothing stands elsewhere"));
        };
        if asked.row.is_none() {
            return Err(Refused::because("the whole sensor is to be loaded"));
        }
        (asked.row, asked.column) = (Some(seen.row), Some(seen.column));
        known.phase = Phase::Press;
        Ok(Reply::done())
    }

    fn skip(&self) -> Result<Reply, Refused> {
        let mut known = self.known();
        if !matches!(known.phase, Phase::Press | Phase::Elsewhere | Phase::Others) {
            return Err(Refused::because("no press is asked for"));
        }
        match known.asked.take() {
            Some(asked) => match asked.row.zip(asked.column) {
                Some(taxel) => known.avoided.push(taxel),
                None => known.record.even_g.retain(|load| *load != asked.load_g),
            },
            None => return Err(Refused::because("no press is asked for")),
        }
        self.ask_next(&mut known);
        Ok(Reply::done())
    }

    fn take_load(&self, load_g: f64) -> Result<Reply, Refused> {
        let mut known = self.known();
        let known = &mut *known;
        let loads = self.plan().loads_g().to_vec();
        if !loads.contains(&load_g) {
            return Err(Refused::because(format!(
                "{load_g} g is none of {loads:?} g"
            )));
        }
        match (&known.phase, &mut known.asked) {
            (Phase::Press | Phase::Elsewhere | Phase::Others, Some(asked))
                if asked.row.is_some() =>
            {
                asked.load_g = load_g;
                Ok(Reply::done())
            }
            _ => Err(Refused::because("no press of a taxel is asked for")),
        }
    }

    fn undo(&self) -> Result<Reply, Refused> {
        let mut known = self.known();
        if matches!(
            known.phase,
            Phase::Taking(..) | Phase::Finishing | Phase::Done
        ) {
            return Err(Refused::because("not now"));
        }
        let presses = known.record.presses.iter_mut().rev();
        let mut counting = presses.filter(|press| press.counts());
        let Some(last) = counting.next() else {
            return Err(Refused::because("there is no press to forget"));
        };
        "undone by the operator".clone_into(&mut last.left_out);
        let asked = last.asked();
        let written = known.write();
        written.map_err(|error| Refused::because(error.to_string()))?;
        known.again.push_front(asked);
        if matches!(known.phase, Phase::Press | Phase::Elsewhere | Phase::Others) {
            self.ask_next(&mut known);
        }
        drop(known);
        self.ask_for_fit();
        Ok(Reply::saying("the last press is forgotten"))
    }

    fn finish(&self) -> Result<Reply, Refused> {
        let mut known = self.known();
        if matches!(
            known.phase,
            Phase::Taking(..) | Phase::Finishing | Phase::Done
        ) {
            return Err(Refused::because("not now"));
        }
        let count = known.counting();
        if count < MIN_PRESSES {
            return Err(Refused::because(format!(
                "{count} presses were taken, and a calibration needs at least {MIN_PRESSES}"
            )));
        }
        known.trouble.clear();
        known.phase = Phase::Finishing;
        self.fits.ask(known.evidence());
        Ok(Reply::done())
    }

    /// Goes on.
    pub(super) fn go_on(&self, step: &CalibrationStep) -> Result<Reply, Refused> {
        match step {
            CalibrationStep::Ready => self.ready(),
            CalibrationStep::Here => self.here(),
            CalibrationStep::Skip => self.skip(),
            CalibrationStep::Load { load_g } => self.take_load(*load_g),
            CalibrationStep::Undo => self.undo(),
            CalibrationStep::Finish => self.finish(),
            _ => Err(Refused::because("this program does not know that step")),
        }
    }

    /// How it stands.
    pub(super) fn state(&self) -> CalibrationSession {
        let progress = self.fits.progress();
        let fit = self.fits.latest();
        let says = fit.map_or_else(Vec::new, |fit| fit.says());
        let (is_enough, advice) = judge(&progress, LEAST_PRESSES);
        let known = self.known();
        let taken = |(place, press): (usize, &KeptPress)| {
            let mut taken = TakenPress::new(press.asked());
            taken.left_out.clone_from(&press.left_out);
            let says = says.iter().find(|(of, _)| *of == place);
            taken.says_g = says.map(|(_, grams)| *grams);
            taken
        };
        let mut state = CalibrationSession::default();
        state.phase = match known.phase {
            Phase::Empty => CalibrationPhase::Empty,
            Phase::Reading => CalibrationPhase::Reading,
            Phase::Others => CalibrationPhase::Others,
            Phase::Press => CalibrationPhase::Press,
            Phase::Elsewhere => CalibrationPhase::Elsewhere,
            Phase::Taking(..) => CalibrationPhase::Taking,
            Phase::Off(_) => CalibrationPhase::Off,
            Phase::Finishing => CalibrationPhase::Finishing,
            Phase::Done => CalibrationPhase::Done,
        };
        state.asked.clone_from(&known.asked);
        state.seen.clone_from(&known.seen);
        state.presses = known.record.presses.iter().enumerate().map(taken).collect();
        state.progress = progress;
        state.is_enough = is_enough;
        state.advice = advice;
        state.least_presses = MIN_PRESSES;
        state.loads_g = self.plan().loads_g().to_vec();
        state.sensor.clone_from(&known.record.sensor);
        state.folder = known.folder.display().to_string();
        state.output = self.settings.output.display().to_string();
        state.warnings.clone_from(&known.warnings);
        state.doubts.clone_from(&known.doubts);
        state.trouble.clone_from(&known.trouble);
        state.is_resumed = known.is_resumed;
        state.is_simulated = known.record.is_simulated;
        state.files.clone_from(&known.files);
        state
    }
}

impl Guide for Desk {
    fn name(&self) -> &'static str {
        "a guided calibration"
    }

    fn tell(&self, state: &mut State) {
        state.calibration = Some(Box::new(self.state()));
    }

    fn step(&self, step: GuideStep) -> Result<Reply, Refused> {
        match step {
            GuideStep::Calibration(step) => self.go_on(&step),
            GuideStep::Grip(_) => Err(Refused::because("this is a guided calibration")),
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
