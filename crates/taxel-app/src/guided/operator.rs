//! A simulated operator: lays on a simulated sensor what is asked for. Now and then it errs, as people do: on the taxel beside, or
//! with another weight than it says.

use std::time::{Duration, Instant};

use taxel_acquire::simulated::LaidLoads;
use taxel_server::{AskedPress, CalibrationStep};

use super::desk::{Desk, Known, Phase};

/// Every so many presses the operator lays the weight on the taxel beside first,
const MISSES_EVERY: usize = 7;
/// and every so many takes a weight that is so much heavier than it should be.
const ERRS_EVERY: usize = 11;
const ERROR: f64 = 1.4;
/// A mistake is seen after a while.
const SEEN_AFTER: Duration = Duration::from_millis(1200);
/// Other things are laid and taken off in so long.
const ARRANGES_IN: Duration = Duration::from_millis(900);

/// What the operator does at the moment.
#[derive(Default)]
pub(super) struct Operator {
    /// Phase, presses so far, and what is asked for.
    doing: Option<(Phase, usize, Option<AskedPress>)>,
    since: Option<Instant>,
    is_corrected: bool,
    has_begun: bool,
    /// How often other things were laid: each time they lie elsewhere.
    arrangement: usize,
}

impl Operator {
    /// Acts on the simulated sensor; on another nothing.
    pub(super) fn act(&mut self, desk: &Desk) {
        let presser = match desk.session().as_ref() {
            Some(session) => session.presser().cloned(),
            None => None,
        };
        let Some(presser) = presser else { return };
        let known = desk.known();
        let presses = known.record.presses.len();
        let now = (simple(&known.phase), presses, known.asked.clone());
        let is_new = self.doing.as_ref() != Some(&now);
        if is_new {
            self.is_corrected = false;
            self.since = Some(Instant::now());
            if known.phase == Phase::Others {
                self.arrangement += 1;
            }
            presser.lay(self.laid(&known, desk, false));
            self.doing = Some(now);
        }
        let waited = self.since.map_or(Duration::ZERO, |since| since.elapsed());
        if known.phase == Phase::Elsewhere && !self.is_corrected && waited > SEEN_AFTER {
            self.is_corrected = true;
            presser.lay(self.laid(&known, desk, true));
        }
        self.has_begun |= known.phase == Phase::Reading;
        // The first time a person says that the sensor is empty.
        let arranges = match known.phase {
            Phase::Empty => self.has_begun,
            Phase::Others => true,
            _ => false,
        };
        drop(known);
        if arranges && waited > ARRANGES_IN {
            let _ = desk.go_on(&CalibrationStep::Ready);
        }
    }

    /// What lies on the sensor in a phase.
    fn laid(&self, known: &Known, desk: &Desk, is_corrected: bool) -> LaidLoads {
        let sensor = &desk.settings.sensor;
        let (rows, columns) = (sensor.rows(), sensor.columns());
        let asked = known.asked.as_ref();
        let others = known.others_lie || known.phase == Phase::Others;
        let mut taxels = Vec::new();
        if others {
            let heaviest = known.record.loads_g.iter().copied().fold(0.0, f64::max);
            taxels.extend(other_things(self.arrangement, (rows, columns), heaviest));
            // Where something is to be pressed, nothing else lies.
            let taxel = asked.and_then(|asked| asked.row.zip(asked.column));
            taxels.retain(|(row, column, _)| Some((*row, *column)) != taxel);
        }
        let Some(asked) = asked.filter(|_| simple(&known.phase) == Phase::Press) else {
            return LaidLoads::on_taxels(taxels);
        };
        let Some((row, column)) = asked.row.zip(asked.column) else {
            return LaidLoads::even(asked.load_g);
        };
        let number = known.record.presses.len();
        let misses = number % MISSES_EVERY == MISSES_EVERY - 1 && !is_corrected;
        let beside = if column + 1 < columns {
            column + 1
        } else {
            column - 1
        };
        let errs = number % ERRS_EVERY == ERRS_EVERY - 1 && !asked.is_again;
        taxels.push((
            row,
            if misses { beside } else { column },
            asked.load_g * if errs { ERROR } else { 1.0 },
        ));
        LaidLoads::on_taxels(taxels)
    }
}

/// Elsewhere is the same press.
fn simple(phase: &Phase) -> Phase {
    match phase {
        Phase::Elsewhere | Phase::Taking(..) => Phase::Press,
        other => other.clone(),
    }
}

/// Where other things lie.
fn other_things(
    arrangement: usize,
    (rows, columns): (usize, usize),
    heaviest_g: f64,
) -> impl Iterator<Item = (usize, usize, f64)> {
    const THINGS: usize = 6;
    (0..THINGS).map(move |thing| {
        let step = arrangement * THINGS + thing;
        // Irrational steps: spread over the sensor, and never twice the same.
        let part = |by: f64| (step as f64 * by).fract();
        let row = (part(0.618_034) * rows as f64) as usize;
        let column = (part(0.754_878) * columns as f64) as usize;
        (row, column, heaviest_g * (0.4 + 0.6 * part(0.569_840)))
    })
}
