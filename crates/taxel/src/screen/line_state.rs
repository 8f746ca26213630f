//! Is this line out in this very frame?

use super::{Axis, Level, LineFaults, ScreenOptions, together};
use crate::{Counts, Frame};

/// A line of fewer taxels has no readings to tell its own fault from that of a taxel.
const MIN_LINE: usize = 4;

/// What stands for a reading where there is no taxel: below every other.
const NOWHERE: f64 = f64::NEG_INFINITY;

/// Whether a reading is one.
#[inline(always)]
pub(super) fn is_there(reading: f64) -> bool {
    reading > NOWHERE
}

/// The greater of two readings, as one instruction: `f64::max` would look for NaN, of which there is none.
#[inline(always)]
pub(super) fn greater(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// The readings of one frame as lines along either axis, each line in one piece; [`NOWHERE`] where there is no taxel.
#[derive(Debug, Clone, Default)]
pub(super) struct FrameLines {
    rows: usize,
    columns: usize,
    by_row: Vec<f64>,
    by_column: Vec<f64>,
}

impl FrameLines {
    pub fn new(rows: usize, columns: usize) -> Self {
        Self {
            rows,
            columns,
            by_row: vec![0.0; rows * columns],
            by_column: vec![0.0; rows * columns],
        }
    }

    /// Takes the readings of a frame.
    pub fn take(&mut self, frame: &Frame<Counts>, options: &ScreenOptions) {
        self.by_row.copy_from_slice(frame.values());
        for (value, _) in self
            .by_row
            .iter_mut()
            .zip(&options.absent)
            .filter(|(_, absent)| **absent)
        {
            *value = NOWHERE;
        }
        for (row, values) in self.by_row.chunks_exact(self.columns).enumerate() {
            let places = self.by_column[row..].iter_mut().step_by(self.rows);
            for (place, value) in places.zip(values) {
                *place = *value;
            }
        }
    }

    /// Rows and columns.
    pub fn shape(&self) -> (usize, usize) {
        (self.rows, self.columns)
    }

    /// Row by row.
    pub fn by_row(&self) -> &[f64] {
        &self.by_row
    }

    pub fn along(&self, axis: Axis, options: &ScreenOptions) -> LineReadings<'_> {
        let (readings, count, length) = match axis {
            Axis::Row => (&self.by_row, self.rows, self.columns),
            Axis::Column => (&self.by_column, self.columns, self.rows),
        };
        LineReadings {
            readings,
            count,
            length,
            floating: options.floating,
        }
    }
}

/// The readings of one frame, seen as lines along one axis.
#[derive(Debug, Clone, Copy)]
pub(super) struct LineReadings<'a> {
    readings: &'a [f64],
    /// How many lines.
    pub count: usize,
    /// Readings on each.
    length: usize,
    floating: bool,
}

impl<'a> LineReadings<'a> {
    /// What a line reads; [`NOWHERE`] where there is no taxel.
    #[inline(always)]
    pub fn of_line(&self, line: usize) -> &'a [f64] {
        &self.readings[line * self.length..][..self.length]
    }

    /// The lines beside a line: one at the edge.
    pub fn beside(&self, line: usize) -> [Option<usize>; 2] {
        let after = Some(line + 1).filter(|&after| after < self.count);
        [line.checked_sub(1), after]
    }

    /// Taxels on a line.
    #[inline(always)]
    pub fn taxels(&self, line: usize) -> usize {
        let readings = self.of_line(line).iter();
        readings.filter(|reading| is_there(**reading)).count()
    }

    /// What may vouch for a load on a line. On an array with floating lines nothing does; a line at the edge has one
    /// side only, and nobody vouches for it.
    #[inline(always)]
    pub fn sides(&self, line: usize) -> Option<Sides<'a>> {
        if self.floating || line == 0 || line + 1 >= self.count {
            return None;
        }
        let last = self.count - 1;
        Some(Sides {
            before: [line - 1, line.saturating_sub(2)].map(|line| self.of_line(line)),
            after: [line + 1, (line + 2).min(last)].map(|line| self.of_line(line)),
        })
    }
}

/// What the lines beside a line read: on each side the two nearest (so that a second bad line beside this one does not
/// hide the load), at the edge the one there is.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sides<'a> {
    before: [&'a [f64]; 2],
    after: [&'a [f64]; 2],
}

impl Sides<'_> {
    /// The load that both sides vouch for at a position, the smaller of the two, counts; and whether it is a real one.
    #[inline(always)]
    pub fn load(&self, position: usize, thresholds: &Thresholds) -> (f64, bool) {
        let before = greater(self.before[0][position], self.before[1][position]);
        let after = greater(self.after[0][position], self.after[1][position]);
        let load = if before < after { before } else { after };
        let real = (load > thresholds.really_loaded) & (load < thresholds.ceiling);
        (load, real)
    }

    /// On how many readings of the line between them both sides vouch for a real load, and how many of these are silent.
    #[inline(always)]
    fn look(&self, own: &[f64], thresholds: &Thresholds, options: &ScreenOptions) -> (u64, u64) {
        // Of one length, so that no place is looked up twice.
        let length = own.len();
        let sides = Sides {
            before: self.before.map(|line| &line[..length]),
            after: self.after.map(|line| &line[..length]),
        };
        // A reading below the floor may be as much as that.
        let least = options.floor_count.unwrap_or(NOWHERE);
        let (mut supported, mut silent) = (0, 0);
        for (position, &value) in own.iter().enumerate() {
            let (load, real) = sides.load(position, thresholds);
            let real = real & is_there(value);
            let is_silent = greater(value, least) <= thresholds.silence(load, options);
            supported += u64::from(real);
            silent += u64::from(real & is_silent);
        }
        (supported, silent)
    }

    /// The load, if it is a real one.
    pub fn real_load(&self, position: usize, thresholds: &Thresholds) -> Option<f64> {
        let (load, is_real) = self.load(position, thresholds);
        is_real.then_some(load)
    }
}

/// The level with its thresholds, in counts.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Thresholds {
    /// What an unloaded taxel reads, as far as is known (else 0).
    pub baseline: f64,
    /// What a sound taxel reads at least: the baseline, or less on an array with floating lines.
    pub least: f64,
    /// Standard deviation of noise (0 where nothing is known).
    pub noise: f64,
    /// Below this a reading has fallen off; `None` where the baseline is too near 0 to fall from it.
    pub floor: Option<f64>,
    /// Above this a reading is loaded.
    pub loaded: f64,
    /// Above this it carries a load that a line beside it can be judged by.
    pub really_loaded: f64,
    /// At or above this a reading is at the converter's ceiling.
    pub ceiling: f64,
}

impl Thresholds {
    pub fn new(level: Option<Level>, max_count: f64, options: &ScreenOptions) -> Self {
        let (baseline, noise) = level.map_or((0.0, 0.0), |level| {
            (level.baseline_counts, level.noise_counts)
        });
        let above = (options.loaded_sigmas * noise).max(options.loaded_share_of_range * max_count);
        let really = (options.real_load_sigmas * noise)
            .max(options.real_load_share_of_range * max_count)
            .max(above);
        // Before any frame has told a level, the circuit does.
        let by_circuit = options.unloaded_counts.filter(|_| options.floating);
        let least = match (by_circuit, level) {
            (Some(counts), None) => counts,
            (counts, Some(_)) if options.floating => counts.unwrap_or(0.0).min(baseline),
            _ => baseline,
        };
        // What is out reads 0 and half a bell of noise above it: it must fit below the floor.
        let far_enough =
            least >= (options.floor_sigmas + 2.0) * noise && least >= options.floor_counts;
        let fall = (options.floor_sigmas * noise).max(options.floor_share * least);
        Self {
            baseline,
            least,
            noise,
            floor: far_enough.then_some(least - fall),
            loaded: baseline + above,
            really_loaded: baseline + really,
            ceiling: max_count - options.end_counts,
        }
    }
}

impl Thresholds {
    /// What a line that says nothing may read beside this load, counts.
    #[inline(always)]
    pub fn silence(&self, load: f64, options: &ScreenOptions) -> f64 {
        let left = options.silent_share * (load - self.baseline);
        self.baseline + greater(left, options.floor_sigmas * self.noise)
    }
}

/// What one frame says about one line.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct LineVerdict {
    /// Taxels on it.
    pub taxels: usize,
    /// Whether the line has taxels enough to be judged.
    pub judged: bool,
    /// Whether this frame can tell.
    pub testable: bool,
    /// Whether the line is out: fallen, silent, or at the ceiling.
    pub out: bool,
    /// Out by its silence alone.
    pub only_silent: bool,
    /// Readings on which it answers to a load.
    pub responding: u64,
    /// Readings that both sides vouch a load for.
    pub supported: u64,
    /// Of these, silent ones.
    pub silent: u64,
    /// Share of the line's readings that have fallen below the baseline.
    pub fallen_share: f64,
}

impl LineVerdict {
    /// Whether any of its readings may be loaded and below the ceiling.
    pub fn may_carry(&self) -> bool {
        !self.judged || self.responding > 0
    }
}

/// Judges one line: it is out when nearly all of its readings have fallen below what an unloaded taxel reads (where
/// there is something to fall from), or when it is silent at nearly all places where the lines on both sides carry a
/// real load and responds nowhere else; or when nearly all of its readings are at the ceiling and those beside it are
/// not. Of fewer than four readings no line can be told.
#[inline(always)]
pub(super) fn classify(
    lines: &LineReadings<'_>,
    line: usize,
    thresholds: &Thresholds,
    options: &ScreenOptions,
) -> LineVerdict {
    let taxels = lines.taxels(line);
    let mut verdict = LineVerdict {
        taxels,
        ..LineVerdict::default()
    };
    if taxels < MIN_LINE {
        return verdict;
    }
    verdict.judged = true;
    let own = lines.of_line(line);
    let floor = thresholds.floor.unwrap_or(NOWHERE);
    let (mut fallen, mut responding, mut ceiling) = (0u64, 0u64, 0u64);
    // Without branches, so that several readings are looked at at once.
    for &value in own {
        fallen += u64::from((value < floor) & is_there(value));
        responding += u64::from((value > thresholds.loaded) & (value < thresholds.ceiling));
        ceiling += u64::from(value >= thresholds.ceiling);
    }
    verdict.responding = responding;
    if let Some(sides) = lines.sides(line) {
        let (supported, silent) = sides.look(own, thresholds, options);
        (verdict.supported, verdict.silent) = (supported, silent);
    }
    let length = taxels as f64;
    let share = options.line_share;
    verdict.fallen_share = fallen as f64 / length;
    let enough_supported =
        verdict.supported as f64 >= (options.supported_share * length).max(MIN_LINE as f64);
    let silent = enough_supported
        && verdict.silent as f64 >= share * verdict.supported as f64
        && verdict.responding as f64 <= (1.0 - share) / 2.0 * length;
    verdict.testable = thresholds.floor.is_some() || enough_supported;
    let at_ceiling =
        ceiling as f64 >= share * length && !next_to_at_ceiling(lines, line, thresholds);
    let is_fallen = verdict.fallen_share >= share;
    verdict.out = is_fallen || silent || at_ceiling;
    verdict.only_silent = silent && !is_fallen && !at_ceiling;
    verdict.testable |= verdict.out;
    if at_ceiling {
        // Not silent, but no answer to the load beside it either.
        (verdict.supported, verdict.silent) = (0, 0);
    }
    verdict
}

/// What a line reads at a place; where there is no taxel, as where those of its neighbour stand in its gaps, the greater of the two
/// next to it.
fn reading_near(line: &[f64], place: usize) -> f64 {
    if is_there(line[place]) {
        return line[place];
    }
    let at = |place: Option<usize>| place.and_then(|place| line.get(place)).copied();
    let next = [at(place.checked_sub(1)), at(place.checked_add(1))];
    next.into_iter().flatten().fold(NOWHERE, greater)
}

/// Of a line that is known to come and go: whether the line before it or the one after carries a load at two places or more, and
/// it none at any of them. It may be in, and at the edge of a contact: then nothing is lost where it counts as out, since
/// nothing stands on it. No frame tells the two apart where an unloaded taxel reads as little as one that is out.
fn is_silent_beside_a_load(
    lines: &LineReadings<'_>,
    line: usize,
    thresholds: &Thresholds,
    options: &ScreenOptions,
) -> bool {
    let near = lines.beside(line);
    let (mut loaded, mut silent) = (0, 0);
    for (place, &own) in lines.of_line(line).iter().enumerate() {
        let beside = near
            .iter()
            .flatten()
            .map(|&line| reading_near(lines.of_line(line), place));
        let load = beside.fold(NOWHERE, greater);
        let is_load = (load > thresholds.really_loaded) & (load < thresholds.ceiling);
        loaded += u64::from(is_load & is_there(own));
        silent += u64::from(is_load & is_there(own) & (own <= thresholds.silence(load, options)));
    }
    loaded >= 2 && silent == loaded
}

/// Whether a line beside this one is at the ceiling on more than half of its length as well.
#[inline(always)]
fn next_to_at_ceiling(lines: &LineReadings<'_>, line: usize, thresholds: &Thresholds) -> bool {
    let full = |other: usize| {
        let of_line = lines.of_line(other).iter();
        let at_end = of_line.filter(|&&value| value >= thresholds.ceiling);
        2 * at_end.count() > lines.taxels(other)
    };
    (line > 0 && full(line - 1)) || (line + 1 < lines.count && full(line + 1))
}

/// Which of the flickering lines in `faults` are out in this very frame, appended to `out`. Without a level only lines between loaded ones can be told.
pub(super) fn find_dropped(
    frame: &FrameLines,
    faults: &LineFaults,
    thresholds: &Thresholds,
    options: &ScreenOptions,
    out: &mut Vec<(Axis, usize)>,
) {
    for axis in Axis::BOTH {
        let lines = frame.along(axis, options);
        let indices = faults.flickering(axis).filter(|&line| line < lines.count);
        for line in indices {
            let verdict = classify(&lines, line, thresholds, options);
            let is_silent = verdict.responding == 0
                && thresholds.floor.is_none()
                && is_silent_beside_a_load(&lines, line, thresholds, options);
            if verdict.out || is_silent || together::has_fallen(lines.of_line(line), thresholds) {
                out.push((axis, line));
            }
        }
    }
}
