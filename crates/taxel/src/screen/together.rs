//! What the readings of a line say together, where unloaded taxels read so little that no single reading can fall from it.
//!
//! A taxel that reads two counts unloaded and none in this frame tells nothing; thirty of one line, all at once, do. A line whose
//! offset is low reads so all along: a line comes and goes only where it stood at the baseline just before it fell.

use super::line_state::{LineReadings, Thresholds, is_there};
use super::tally::{LineTally, Looked};
use super::{Axis, LineFault, LineFaultKind, ScreenOptions};

/// A line of fewer taxels has too few readings.
const MIN_LINE: usize = 4;
/// What reads nothing is below this many standard deviations of noise.
const NOTHING_SIGMAS: f64 = 4.0;
/// A mean is below the baseline if by this many of its standard deviations: lines differ a little, besides.
const BELOW_SIGMAS: f64 = 6.0;
/// A line has fallen where its mean is below this share of the baseline, and stands where it is above the other. Lines differ by
/// tenths; between the two nothing is said.
const FALLEN_SHARE: f64 = 0.25;
const STANDING_SHARE: f64 = 0.75;
/// Above this share of the baseline no reading counts for a line that stands, nor is a place unloaded.
const MOST_SHARE: f64 = 1.5;
/// Frames before a line that reads nothing in them is dead.
const MIN_FRAMES: u64 = 16;
/// Share of its length beside which a load must have lain: a line that reads nothing and was never pressed may have a low offset.
const COVERED_SHARE: f64 = 0.5;

/// What a recording says of a line.
#[derive(Debug, Clone, Default)]
pub(super) struct Stands {
    /// Frames that tell, and those of them in which it has fallen.
    tested: u64,
    fallen: u64,
    /// Frames in which it has fallen from where it stood in the frame before.
    drops: u64,
    /// Places beside which a load has lain while it had fallen.
    covered: Vec<bool>,
    /// Sums over these places and frames: readings, and how many.
    beside: (f64, u64),
}

/// Mean of the readings that count and how many there are.
fn mean(readings: impl Iterator<Item = f64>) -> (f64, usize) {
    let (sum, count) = readings.fold((0.0, 0), |(sum, count), reading| (sum + reading, count + 1));
    (sum / count.max(1) as f64, count)
}

impl Thresholds {
    /// Whether the readings of lines of this length tell together what one does not tell alone.
    pub(super) fn tell_together(&self, length: usize) -> bool {
        let noise = self.noise / (length.max(1) as f64).sqrt();
        self.floor.is_none() && (1.0 - FALLEN_SHARE) * self.least > BELOW_SIGMAS * noise
    }
}

/// Whether all readings of a line are next to nothing, [`Thresholds::tell_together`] given.
fn is_fallen(own: &[f64], thresholds: &Thresholds) -> bool {
    // A stray reading at the ceiling stands on a line that is out as well.
    let is_reading = |value: &f64| is_there(*value) & (*value < thresholds.ceiling);
    let readings = || own.iter().copied().filter(is_reading);
    let nothing = NOTHING_SIGMAS * thresholds.noise;
    // Of a line that stands the first few readings say so.
    if !readings().all(|value| value <= nothing) {
        return false;
    }
    let (mean, count) = mean(readings());
    let noise = thresholds.noise / (count.max(1) as f64).sqrt();
    count >= MIN_LINE
        && mean < FALLEN_SHARE * thresholds.least
        && thresholds.least - mean > BELOW_SIGMAS * noise
}

/// Whether a line reads what unloaded ones do, at taxels enough to tell: where the lines beside it do, since the foot of a load must
/// not stand for the baseline.
fn is_standing(line: usize, lines: &LineReadings, thresholds: &Thresholds) -> bool {
    let own = lines.of_line(line);
    let most = MOST_SHARE * thresholds.least;
    let beside = lines
        .beside(line)
        .map(|line| line.map(|line| lines.of_line(line)));
    let is_unloaded = |place: &usize| {
        let low = |line: &&[f64]| line[*place] <= most;
        is_there(own[*place]) && beside.iter().flatten().all(low)
    };
    let unloaded = (0..own.len()).filter(is_unloaded);
    let (mean, count) = mean(unloaded.map(|place| own[place].min(most)));
    count >= MIN_LINE && thresholds.tell_together(count) && mean > STANDING_SHARE * thresholds.least
}

/// Of a line that is known to come and go, where the baseline is too near 0 for a single reading to fall from it: whether all
/// of its readings together have, none of them above the noise of nothing; what a load does to other lines only raises them.
pub(super) fn has_fallen(own: &[f64], thresholds: &Thresholds) -> bool {
    let length = own.iter().filter(|value| is_there(**value)).count();
    thresholds.tell_together(length) && is_fallen(own, thresholds)
}

/// Adds what a frame says of all lines of an axis. Where half of them have fallen, it says nothing: that is no line's fault.
pub(super) fn observe(looked: &Looked, tallies: &mut [LineTally]) {
    let (lines, thresholds) = (&looked.lines, looked.thresholds);
    let length = lines.of_line(0).len();
    if !thresholds.tell_together(length) {
        return;
    }
    let is_fallen = |line: usize| is_fallen(lines.of_line(line), thresholds);
    if 2 * (0..lines.count).filter(|&line| is_fallen(line)).count() >= lines.count {
        return;
    }
    for (line, tally) in tallies.iter_mut().enumerate() {
        tally.stands.tested += 1;
        if is_fallen(line) {
            let before = looked.before.as_ref();
            let stood = before.is_some_and(|before| is_standing(line, before, thresholds));
            tally.stands.drops += u64::from(stood);
            tally.stands.fall(line, lines, thresholds);
        }
    }
}

impl Stands {
    pub(super) fn of_length(length: usize) -> Self {
        Self {
            covered: vec![false; length],
            ..Self::default()
        }
    }

    fn fall(&mut self, line: usize, lines: &LineReadings, thresholds: &Thresholds) {
        self.fallen += 1;
        for beside in lines.beside(line).into_iter().flatten() {
            for (covered, &value) in self.covered.iter_mut().zip(lines.of_line(beside)) {
                let is_load = (value > thresholds.really_loaded) & (value < thresholds.ceiling);
                *covered |= is_load;
                self.beside.0 += if is_load { value } else { 0.0 };
                self.beside.1 += u64::from(is_load);
            }
        }
    }

    /// What the line is, if its readings together tell it; `answers`: how many of its readings answered to a load, in any frame.
    pub(super) fn fault(
        &self,
        axis: Axis,
        index: usize,
        answers: u64,
        options: &ScreenOptions,
    ) -> Option<LineFault> {
        let covered = self.covered.iter().filter(|&&covered| covered).count() as f64;
        let is_dead = self.fallen >= MIN_FRAMES
            && self.fallen as f64 >= options.dead_share * self.tested as f64
            && answers * MIN_FRAMES <= self.fallen
            && covered >= COVERED_SHARE * self.covered.len() as f64;
        let kind = if is_dead {
            LineFaultKind::Dead
        } else {
            (self.drops >= options.flicker_frames).then_some(LineFaultKind::Flickering)?
        };
        Some(LineFault {
            axis,
            index,
            kind,
            faulty: self.fallen,
            tested: self.tested,
            median_counts: 0.0,
            next_to: self.beside.0 / self.beside.1.max(1) as f64,
            has_fallen: true,
        })
    }
}
