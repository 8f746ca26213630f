//! Lines that may be dead: they read nothing at all, though the lines on both sides of them are loaded.
//!
//! Where an unloaded taxel reads next to nothing, a dead line under a load looks as a gap does that is as wide as one line, between
//! two feet, say. A line along nearly all of which a load was vouched for is dead ([`super::LineScreen`]). Of one under a part of
//! which a load lay, the loads beside it tell something: those of two fingers fall off towards the gap between them on both sides, those
//! of one contact that a dead line cuts do so on one side at the most. Two flat things with a gap between them tell nothing: only who
//! built the mat can. So the line is named, and nothing is marked.
//!
//! Where unloaded taxels read a little, the readings of the line together tell: one that reads as unloaded ones do is sound, and one
//! that reads far less is dead.

use super::line_state::{LineVerdict, is_there};
use super::tally::Looked;
use super::{Axis, Level, LineFault, LineFaultKind, ScreenOptions};

/// Places at which both sides are loaded before a frame tells of a line: a contact, and no stray reading.
const MIN_PLACES: u64 = 2;
/// Silent readings, over a recording, before a line is suspect.
const MIN_SILENT: u64 = 24;
/// Share of the places at which the loads fall off towards the line on both sides, below which it may cut a contact. Simulated mats of
/// 16 and 32 lines a side: at most 0.13 across a dead line (0.49 where lines are left open), 0.59 to 1 across gaps between fingers.
const MAX_GAP_SHARE: f64 = 0.5;
/// What unloaded taxels read is told from nothing by the mean of a line from so many of its standard deviations on …
const TOLD_SIGMAS: f64 = 6.0;
/// … and from this on, counts, with twice what noise that is cut off at 0 leaves of itself: 0.4 standard deviations.
const TOLD_COUNTS: f64 = 0.5;
const CUT_OFF_MEAN: f64 = 0.4;
/// From so many counts on every single reading tells, and a line that reads less than this share of it is dead: between loads it is
/// silent, and without one it has fallen.
const FALLEN_COUNTS: f64 = 2.0;
const FALLEN_SHARE: f64 = 0.25;
/// Silent readings for each that answers: a line that is touched now and then is sound, one that catches a spike is not.
const SILENT_FOR_EACH_ANSWER: u64 = 100;

/// What one frame tells of a line between two loaded ones.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Look {
    /// Places at which both sides are loaded, and those of them at which the line is silent.
    places: u64,
    silent: u64,
    /// Places at which the loads fall off towards the line, on both sides.
    gaps: u64,
    /// Sums over these places, counts.
    own_sum: f64,
    beside_sum: f64,
}

/// What a recording tells of a line's silence.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Silence {
    /// Frames in which both sides are loaded, and those of them in which the line is silent.
    frames: u64,
    silent_frames: u64,
    /// Readings that answer to a load, in any frame.
    answers: u64,
    sums: Look,
}

impl Silence {
    /// Adds a frame: how many readings of the line answer to a load, and what it tells if none does.
    pub(super) fn add(&mut self, answers: u64, look: Option<(Look, bool)>) {
        self.answers += answers;
        let Some((look, is_silent)) = look else {
            return;
        };
        self.frames += 1;
        self.silent_frames += u64::from(is_silent);
        self.sums.places += look.places;
        self.sums.silent += look.silent;
        self.sums.gaps += look.gaps;
        self.sums.own_sum += look.own_sum;
        self.sums.beside_sum += look.beside_sum;
    }

    /// Readings that answered to a load.
    pub(super) fn answers(&self) -> u64 {
        self.answers
    }

    /// Whether the line is suspect, or dead, with the evidence.
    pub(super) fn fault(
        &self,
        axis: Axis,
        index: usize,
        level: Option<Level>,
        options: &ScreenOptions,
    ) -> Option<LineFault> {
        let Look {
            places,
            silent,
            gaps,
            own_sum,
            beside_sum,
        } = self.sums;
        let is_suspect = silent >= MIN_SILENT
            && self.silent_frames as f64 >= options.dead_share * self.frames as f64
            && (gaps as f64) < MAX_GAP_SHARE * places as f64
            && SILENT_FOR_EACH_ANSWER * self.answers <= silent;
        let own = own_sum / places.max(1) as f64;
        let kind = kind_of(own, places, level, options).filter(|_| is_suspect)?;
        Some(LineFault {
            axis,
            index,
            kind,
            faulty: self.silent_frames,
            tested: self.frames,
            median_counts: own,
            has_fallen: kind == LineFaultKind::Dead,
            next_to: beside_sum / places as f64,
        })
    }
}

/// What a silent line is that reads so many counts in the mean of so many places: nothing but unloaded, dead, or either.
fn kind_of(
    own: f64,
    places: u64,
    level: Option<Level>,
    options: &ScreenOptions,
) -> Option<LineFaultKind> {
    let Some(level) = level else {
        return Some(LineFaultKind::Suspect);
    };
    let unloaded = if options.floating {
        let least = options.unloaded_counts.unwrap_or(0.0);
        least.min(level.baseline_counts)
    } else {
        level.baseline_counts
    };
    let noise = level.noise_counts;
    let told = unloaded > TOLD_SIGMAS * noise / (places as f64).sqrt()
        && unloaded > TOLD_COUNTS + 2.0 * CUT_OFF_MEAN * noise;
    let has_fallen = unloaded > FALLEN_COUNTS.max(TOLD_SIGMAS * noise);
    if has_fallen && own < FALLEN_SHARE * unloaded {
        Some(LineFaultKind::Dead)
    } else {
        (!told || own < unloaded / 2.0).then_some(LineFaultKind::Suspect)
    }
}

/// Looks at a line that answers nowhere, between two that do; and whether it is silent beside them. Of two silent lines side by
/// side each stands in for the other: then the next but one is looked at, on one side.
pub(super) fn look(looked: &Looked, verdicts: &[LineVerdict], line: usize) -> Option<(Look, bool)> {
    let of_line = verdicts[line];
    if of_line.responding > 0 || !of_line.judged {
        return None;
    }
    let is_loaded = |other: &usize| verdicts[*other].responding >= MIN_PLACES;
    let beyond = |near: usize, far: Option<usize>| {
        let is_silent = verdicts[near].judged && verdicts[near].responding == 0;
        far.filter(|_| is_silent).filter(is_loaded)
    };
    let after = Some(line + 1).filter(|&after| after < verdicts.len())?;
    let before = line.checked_sub(1)?;
    let (before, after) = match (is_loaded(&before), is_loaded(&after)) {
        (true, true) => (before, after),
        (true, false) => {
            let next = Some(after + 1).filter(|&next| next < verdicts.len());
            (before, beyond(after, next)?)
        }
        (false, true) => (beyond(before, before.checked_sub(1))?, after),
        (false, false) => return None,
    };
    let look = between(looked, line, [before, after]);
    let is_silent = look.silent as f64 >= looked.options.line_share * look.places as f64;
    (look.places >= MIN_PLACES).then_some((look, is_silent))
}

fn between(looked: &Looked, line: usize, [before, after]: [usize; 2]) -> Look {
    let Looked {
        lines,
        thresholds,
        options,
        ..
    } = looked;
    // A reading below the floor may be as much as that.
    let least = options.floor_count.unwrap_or(f64::NEG_INFINITY);
    let beyond = [
        before.checked_sub(1),
        Some(after + 1).filter(|&next| next < lines.count),
    ];
    let beyond = beyond.map(|beyond| beyond.map(|line| lines.of_line(line)));
    let sides = [lines.of_line(before), lines.of_line(after)];
    let mut look = Look::default();
    for (place, &own) in lines.of_line(line).iter().enumerate() {
        let load = sides[0][place].min(sides[1][place]);
        if !is_there(own) || load <= thresholds.really_loaded || load >= thresholds.ceiling {
            continue;
        }
        look.places += 1;
        look.silent += u64::from(own.max(least) <= thresholds.silence(load, options));
        let falls_off = |(near, far): (&&[f64], &Option<&[f64]>)| {
            far.is_some_and(|far| far[place] > near[place])
        };
        look.gaps += u64::from(sides.iter().zip(&beyond).all(falls_off));
        look.own_sum += own;
        look.beside_sum += load;
    }
    look
}
