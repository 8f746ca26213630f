//! What happens by itself in a guided calibration: presses are seen, taken and kept, and asked for again where the others contradict
//! them.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use taxel_server::{BadLines, SeenPress};

use super::desk::{Desk, Known, Phase};
use super::operator::Operator;
use super::press_watch::Pressing;
use super::record::{CalibrationRecord, KeptPress, write_mean};
use super::results;
use crate::error::Error;

/// How often doubts are looked for.
const LOOK_EVERY: Duration = Duration::from_millis(500);
/// A line that is found faulty so often in a row is broken: 15 s, three surveys.
const BROKEN_LOOKS: u32 = 30;
/// A press that is asked for and not seen for so long is not seen by the sensor.
const UNSEEN: Duration = Duration::from_secs(12);
/// Two presses of one taxel with one load that rise by the same within this share agree.
const AGREE: f64 = 0.1;
/// A press that moves by more than this share while it is taken does not stand.
const MOVED: f64 = 0.1;
/// Without a frame for so long the source is said to be silent.
const SILENT: Duration = Duration::from_secs(2);

/// Moves a calibration on.
pub(super) struct Conductor {
    desk: Arc<Desk>,
    operator: Operator,
    looked: Instant,
    last: (Phase, usize),
    frames_seen: (u64, Instant),
    faults: LineWatch,
    waits_since: Instant,
}

impl Conductor {
    pub(super) fn new(desk: Arc<Desk>) -> Self {
        Self {
            desk,
            operator: Operator::default(),
            looked: Instant::now(),
            last: (Phase::Empty, usize::MAX),
            frames_seen: (0, Instant::now()),
            faults: LineWatch::default(),
            waits_since: Instant::now(),
        }
    }

    /// Does what is due. Called some tens of times a second.
    pub(super) fn tick(&mut self) {
        let phase = self.desk.known().phase.clone();
        let done = match phase {
            Phase::Reading => self.read_empty(),
            Phase::Press | Phase::Elsewhere => self.look_for_press(),
            Phase::Taking(press, name) => self.take(press, &name),
            Phase::Off(press) => self.wait_until_off(press),
            Phase::Finishing => self.finish(),
            _ => Ok(()),
        };
        if let Err(error) = done {
            self.desk.known().trouble = error.to_string();
        }
        self.look_for_contradictions();
        self.look();
        self.operator.act(&self.desk);
        self.tell();
    }

    /// Viewers are told at once what changes.
    fn tell(&mut self) {
        let now = {
            let known = self.desk.known();
            (known.phase.clone(), known.record.presses.len())
        };
        if now != self.last {
            self.last = now;
            if let Some(session) = self.desk.session().as_ref() {
                session.tell_viewers();
            }
        }
    }

    fn read_empty(&self) -> Result<(), Error> {
        let is_bare = !self.desk.known().others_lie;
        let read = self.desk.watch().read_empty(is_bare);
        if read < 1.0 {
            return Ok(());
        }
        let mut known = self.desk.known();
        let is_again = known.asked.as_ref().is_some_and(|asked| asked.is_again);
        if is_again || (is_bare && known.asked.is_some()) {
            known.phase = Phase::Press;
        } else {
            // Where to press among other things hangs on where these lie.
            self.desk.ask_next(&mut known);
        }
        Ok(())
    }

    fn look_for_press(&self) -> Result<(), Error> {
        let is_even = self.desk.known().asks_for_even_load();
        let (single, evenly) = {
            let watch = self.desk.watch();
            let evenly = is_even.then(|| watch.loaded_evenly()).flatten();
            (watch.pressing(), evenly)
        };
        let mut known = self.desk.known();
        let Some(pressing) = evenly.or(single) else {
            known.seen = None;
            known.phase = Phase::Press;
            return Ok(());
        };
        let mut seen = SeenPress::new(pressing.row, pressing.column);
        if is_even {
            seen.is_there = evenly.is_some();
        } else {
            seen.is_there = known.asked.as_ref().is_some_and(|asked| {
                (asked.row, asked.column) == (Some(pressing.row), Some(pressing.column))
            });
        }
        seen.standing = 0.5 * pressing.standing.min(1.0);
        seen.problem = problem(&known, &seen, pressing, is_even);
        let is_standing = pressing.standing >= 1.0;
        let is_wrong = !seen.problem.is_empty();
        known.seen = Some(seen);
        if is_wrong {
            // While a weight is being laid it may pass over other taxels.
            if is_standing || known.phase == Phase::Elsewhere {
                known.phase = Phase::Elsewhere;
            }
            return Ok(());
        }
        known.phase = Phase::Press;
        if is_standing {
            drop(known);
            return self.begin_taking(pressing);
        }
        Ok(())
    }

    fn begin_taking(&self, pressing: Pressing) -> Result<(), Error> {
        let (name, file) = {
            let known = self.desk.known();
            let name = CalibrationRecord::free_name(&known.folder);
            let file = known.folder.join(format!("{name}.mcap"));
            (name, file)
        };
        if let Some(session) = self.desk.session().as_ref() {
            session.record(&file, None)?;
        }
        self.desk.watch().look_anew();
        self.desk.known().phase = Phase::Taking(pressing, name);
        Ok(())
    }

    fn take(&self, press: Pressing, name: &str) -> Result<(), Error> {
        let is_even = self.desk.known().asks_for_even_load();
        let (share, frame, now) = {
            let mut watch = self.desk.watch();
            let now = if is_even {
                watch.loaded_evenly()
            } else {
                watch.pressing()
            };
            let (share, frame) = watch.take(press.rise);
            (share, frame, now)
        };
        if let Some(seen) = &mut self.desk.known().seen {
            seen.standing = 0.5 + 0.5 * share;
        }
        let moved = now.is_some_and(|now| {
            let is_same = is_even || (now.row, now.column) == (press.row, press.column);
            !is_same || (now.rise - press.rise).abs() > MOVED * press.rise
        });
        // Right after it was told to look anew there is nothing to see.
        let is_gone = now.is_none() && share > 0.0;
        if moved || is_gone {
            self.stop_recording(name, false);
            let mut known = self.desk.known();
            known.phase = Phase::Press;
            return Ok(());
        }
        let Some(frame) = frame else { return Ok(()) };
        self.stop_recording(name, true);
        self.keep(press, name, frame)
    }

    /// Ends the recording of a press; one that did not stand is no recording.
    fn stop_recording(&self, name: &str, is_kept: bool) {
        if let Some(session) = self.desk.session().as_ref() {
            session.stop_recording();
        }
        if !is_kept {
            let file = self.desk.known().folder.join(format!("{name}.mcap"));
            let _ = std::fs::remove_file(file);
        }
    }

    fn keep(
        &self,
        press: Pressing,
        name: &str,
        frame: taxel::Frame<taxel::Counts>,
    ) -> Result<(), Error> {
        let mut known = self.desk.known();
        let file = format!("{name}.npy");
        write_mean(&known.folder.join(&file), &frame)?;
        let Some(asked) = known.asked.take() else {
            return Ok(());
        };
        let kept = KeptPress {
            taxel: asked.row.zip(asked.column),
            load_g: asked.load_g,
            is_among_others: asked.is_among_others,
            file,
            rise_siemens: press.rise,
            is_again: asked.is_again,
            left_out: String::new(),
        };
        if kept.is_again {
            decide_between(&mut known.record.presses, &kept);
        }
        known.record.presses.push(kept);
        known.frames.push(Arc::new(frame));
        known.trouble.clear();
        known.seen = None;
        known.phase = Phase::Off(press);
        known.write()?;
        drop(known);
        self.desk.ask_for_fit();
        Ok(())
    }

    fn wait_until_off(&self, press: Pressing) -> Result<(), Error> {
        let columns = self.desk.settings.sensor.columns();
        let taxel = press.row * columns + press.column;
        let was_even = {
            let known = self.desk.known();
            let last = known.record.presses.last();
            last.is_some_and(|press| press.taxel.is_none())
        };
        let is_off = {
            let mut watch = self.desk.watch();
            if was_even {
                watch.is_evenly_off(press.rise)
            } else {
                watch.is_off(taxel, press.rise)
            }
        };
        if is_off {
            let mut known = self.desk.known();
            self.desk.ask_next(&mut known);
        }
        Ok(())
    }

    /// What a fit contradicts is asked for once more.
    fn look_for_contradictions(&self) {
        let Some(fit) = self.desk.fits.latest() else {
            return;
        };
        let mut known = self.desk.known();
        if known.looked_at == fit.revision {
            return;
        }
        known.looked_at = fit.revision;
        for (place, words) in fit.contradicted() {
            let Some(press) = known.record.presses.get(place) else {
                continue;
            };
            let mut again = press.asked();
            let is_same =
                |other: &KeptPress| other.taxel == press.taxel && other.load_g == press.load_g;
            let times = known.record.presses.iter().filter(|other| is_same(other));
            let waits = known.again.iter().any(|other| {
                (other.row, other.column, other.load_g) == (again.row, again.column, again.load_g)
            });
            // One at a time: the next fit may think otherwise of the others.
            if press.is_again || times.count() > 1 || waits || !known.again.is_empty() {
                continue;
            }
            again.is_again = true;
            again.why = format!("the first time it said {words}");
            known.again.push_back(again);
        }
    }

    /// Doubts, twice a second.
    fn look(&mut self) {
        if self.looked.elapsed() < LOOK_EVERY {
            return;
        }
        self.looked = Instant::now();
        let (lines, frames) = match self.desk.session().as_ref() {
            Some(session) => (session.bad_lines(), session.link_stats().frames),
            None => return,
        };
        if frames != self.frames_seen.0 {
            self.frames_seen = (frames, Instant::now());
        }
        if self.faults.see(&lines) {
            self.desk.set_dead_lines(&self.faults.dead);
            self.desk.ask_for_fit();
        }
        let warnings = self.warnings();
        self.desk.known().warnings = warnings;
    }

    /// What the operator should know.
    fn warnings(&mut self) -> Vec<String> {
        let mut warnings = Vec::new();
        if self.frames_seen.1.elapsed() > SILENT {
            warnings.push("no frames come: is the sensor connected?".to_owned());
        }
        let dead = &self.faults.dead;
        for (lines, one) in [(&dead.rows, "row"), (&dead.columns, "column")] {
            if let [first, ..] = lines.as_slice() {
                let more = lines.len() - 1;
                let more = if more == 0 {
                    String::new()
                } else {
                    format!(" and {more} more")
                };
                warnings.push(format!("{one} {first}{more}: dead or flickering, left out"));
            }
        }
        let known = self.desk.known();
        let waits = known.phase == Phase::Press && known.seen.is_none();
        if !waits {
            self.waits_since = Instant::now();
        } else if self.waits_since.elapsed() > UNSEEN {
            warnings.push(
                "nothing is seen to press; where the weight lies already, the taxel is dead: skip it"
                    .to_owned(),
            );
        }
        warnings
    }

    /// Writes the results, once all is fitted.
    fn finish(&self) -> Result<(), Error> {
        let Some(fit) = self.desk.fits.finished() else {
            return Ok(());
        };
        let (folder, record) = {
            let known = self.desk.known();
            (known.folder.clone(), known.record.clone())
        };
        let progress = self.desk.fits.progress();
        let written = results::write(&folder, &record, &fit, &progress, &self.desk.settings);
        let mut known = self.desk.known();
        match written {
            Ok(files) => {
                known.phase = Phase::Done;
                known.doubts = fit.doubts();
                known.files = files;
                known.record.is_finished = true;
                known.write()
            }
            Err(error) => {
                // More presses may help; what there is is kept.
                self.desk.ask_next(&mut known);
                Err(error)
            }
        }
    }
}

/// Lines that were found faulty for so long that they are taken to be broken: a hand on the sensor may look like a fault for a while.
#[derive(Default)]
struct LineWatch {
    looks: BTreeMap<(bool, usize), u32>,
    dead: BadLines,
}

impl LineWatch {
    /// Looks once more; whether there are more broken lines than before.
    fn see(&mut self, lines: &BadLines) -> bool {
        let rows = lines.rows.iter().map(|&row| (true, row));
        let all: Vec<_> = rows
            .chain(lines.columns.iter().map(|&column| (false, column)))
            .collect();
        self.looks
            .retain(|line, looks| *looks >= BROKEN_LOOKS || all.contains(line));
        for line in all {
            *self.looks.entry(line).or_insert(0) += 1;
        }
        let broken = self
            .looks
            .iter()
            .filter(|(_, looks)| **looks >= BROKEN_LOOKS);
        let (rows, columns): (Vec<_>, Vec<_>) =
            broken.map(|(line, _)| *line).partition(|line| line.0);
        let index = |lines: Vec<(bool, usize)>| lines.into_iter().map(|line| line.1).collect();
        let dead = BadLines::new(index(rows), index(columns));
        std::mem::replace(&mut self.dead, dead.clone()) != dead
    }
}

/// What is wrong with a press; empty where nothing is.
fn problem(known: &Known, seen: &SeenPress, pressing: Pressing, is_even: bool) -> String {
    if is_even {
        return if seen.is_there {
            String::new()
        } else {
            format!(
                "row {}, column {} is pressed, not the whole sensor",
                seen.row, seen.column
            )
        };
    }
    let Some((row, column)) = known.asked.as_ref().and_then(|a| a.row.zip(a.column)) else {
        return String::new();
    };
    if !seen.is_there {
        return format!(
            "row {}, column {} is pressed most, not row {row}, column {column}",
            seen.row, seen.column
        );
    }
    if pressing.is_saturated {
        return "its reading is at the converter's ceiling: take a lighter load".to_owned();
    }
    String::new()
}

/// Of a press that was contradicted and the same once more: where they differ, the first did not stand as it should. Where they
/// agree, both stay: then it is the taxel that differs, and the fit says so.
fn decide_between(presses: &mut [KeptPress], again: &KeptPress) {
    let is_first = |press: &&mut KeptPress| {
        press.counts() && press.taxel == again.taxel && press.load_g == again.load_g
    };
    let Some(first) = presses.iter_mut().find(is_first) else {
        return;
    };
    let apart = (first.rise_siemens - again.rise_siemens).abs();
    if apart > AGREE * again.rise_siemens.max(first.rise_siemens) {
        "pressed again, and read otherwise".clone_into(&mut first.left_out);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn press(rise_siemens: f64) -> KeptPress {
        KeptPress {
            taxel: Some((3, 5)),
            load_g: 200.0,
            is_among_others: false,
            file: "press-001.npy".to_owned(),
            rise_siemens,
            is_again: false,
            left_out: String::new(),
        }
    }

    #[test]
    fn of_two_presses_that_differ_the_second_counts_and_of_two_that_agree_both() {
        let mut presses = vec![press(1.3e-4)];
        decide_between(&mut presses, &press(1e-4));
        assert!(!presses[0].counts());
        let mut presses = vec![press(1.05e-4)];
        decide_between(&mut presses, &press(1e-4));
        assert!(presses[0].counts());
        let mut other = vec![KeptPress {
            load_g: 100.0,
            ..press(1.3e-4)
        }];
        decide_between(&mut other, &press(1e-4));
        assert!(other[0].counts());
    }
}
