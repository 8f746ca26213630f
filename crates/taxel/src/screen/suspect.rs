//! Lines that may be dead: they read nothing at all, though the lines on both sides of them are loaded.
//!
//! Where an unloaded taxel reads next to nothing, a dead line under a load looks as a gap does that is as wide as one line, between
//! two feet, say. A line along nearly all of which a load was vouched for is dead ([`super::LineScreen`]); of one under a part of
//! which a load lay, only who built the mat can tell. So it is named, and nothing is marked.

use super::line_state::{LineVerdict, is_there};
use super::tally::Looked;
use super::{Axis, LineFault, LineFaultKind, ScreenOptions};

/// Places at which both sides are loaded before a frame tells of a line: a contact, and no stray reading.
const MIN_PLACES: u64 = 3;
/// Silent readings, over a recording, before a line is suspect.
const MIN_SILENT: u64 = 8;
/// Silent readings for each that answers: a line that is touched now and then is sound, one that catches a spike is not.
const SILENT_FOR_EACH_ANSWER: u64 = 100;

/// What one frame tells of a line between two loaded ones.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Look {
    /// Places at which both sides are loaded, and those of them at which the line is silent.
    places: u64,
    silent: u64,
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
        self.sums.own_sum += look.own_sum;
        self.sums.beside_sum += look.beside_sum;
    }

    /// Whether the line is suspect, with the evidence.
    pub(super) fn fault(
        &self,
        axis: Axis,
        index: usize,
        options: &ScreenOptions,
    ) -> Option<LineFault> {
        let Look {
            places,
            silent,
            own_sum,
            beside_sum,
        } = self.sums;
        let is_suspect = silent >= MIN_SILENT
            && self.silent_frames as f64 >= options.dead_share * self.frames as f64
            && SILENT_FOR_EACH_ANSWER * self.answers <= silent;
        is_suspect.then(|| LineFault {
            axis,
            index,
            kind: LineFaultKind::Suspect,
            faulty: self.silent_frames,
            tested: self.frames,
            median_counts: own_sum / places as f64,
            next_to: beside_sum / places as f64,
        })
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
    let sides = lines.of_line(before).iter().zip(lines.of_line(after));
    let mut look = Look::default();
    for (&own, (&before, &after)) in lines.of_line(line).iter().zip(sides) {
        let load = before.min(after);
        if !is_there(own) || load <= thresholds.really_loaded || load >= thresholds.ceiling {
            continue;
        }
        look.places += 1;
        look.silent += u64::from(own.max(least) <= thresholds.silence(load, options));
        look.own_sum += own;
        look.beside_sum += load;
    }
    look
}
