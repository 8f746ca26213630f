//! Is this line out in this very frame?

use super::{Axis, Level, LineFaults, ScreenOptions};
use crate::{Counts, Frame};

/// A line of fewer taxels has no readings to tell its own fault from that of a taxel.
const MIN_LINE: usize = 4;

/// The readings of one frame, seen as lines along one axis.
#[derive(Debug, Clone, Copy)]
pub(super) struct LineReadings<'a> {
    values: &'a [f64],
    options: &'a ScreenOptions,
    /// How many lines.
    pub count: usize,
    /// Readings on each.
    pub length: usize,
    line_stride: usize,
    stride: usize,
}

impl<'a> LineReadings<'a> {
    pub fn of(frame: &'a Frame<Counts>, axis: Axis, options: &'a ScreenOptions) -> Self {
        let (rows, columns) = (frame.rows(), frame.columns());
        let (count, length, line_stride, stride) = match axis {
            Axis::Row => (rows, columns, columns, 1),
            Axis::Column => (columns, rows, 1, columns),
        };
        Self {
            values: frame.values(),
            options,
            count,
            length,
            line_stride,
            stride,
        }
    }

    pub fn at(&self, line: usize, position: usize) -> f64 {
        self.values[self.taxel(line, position)]
    }

    fn taxel(&self, line: usize, position: usize) -> usize {
        line * self.line_stride + position * self.stride
    }

    /// Whether there is a taxel.
    pub fn is_there(&self, line: usize, position: usize) -> bool {
        !self.options.is_absent(self.taxel(line, position))
    }

    /// The positions on a line at which there is a taxel.
    pub fn positions(self, line: usize) -> impl Iterator<Item = usize> + 'a {
        (0..self.length).filter(move |&position| self.is_there(line, position))
    }

    /// Taxels on a line.
    pub fn taxels(&self, line: usize) -> usize {
        if self.options.absent.is_empty() {
            self.length
        } else {
            self.positions(line).count()
        }
    }

    pub fn of_line(self, line: usize) -> impl Iterator<Item = f64> + 'a {
        self.positions(line)
            .map(move |position| self.at(line, position))
    }

    /// What a taxel reads; where there is none, nothing that a line could be judged by.
    fn beside(&self, line: usize, position: usize) -> f64 {
        if self.is_there(line, position) {
            self.at(line, position)
        } else {
            f64::NEG_INFINITY
        }
    }

    /// The reading beside a line that tells of a real load there, counts. On an array with floating lines none does.
    pub fn supported_load(
        &self,
        line: usize,
        position: usize,
        thresholds: &Thresholds,
        options: &ScreenOptions,
    ) -> Option<f64> {
        let real = |load: &f64| *load > thresholds.really_loaded && *load < thresholds.ceiling;
        if options.floating {
            None
        } else {
            self.supported(line, position).filter(real)
        }
    }

    /// The load that both sides of a line vouch for: the smaller of the two sides, each taken at its greater of
    /// the two nearest lines (so that a second bad line beside this one does not hide it). A line at the edge
    /// has one side only, and nobody vouches for it.
    fn supported(&self, line: usize, position: usize) -> Option<f64> {
        if line == 0 || line + 1 >= self.count {
            return None;
        }
        let mut before = self.beside(line - 1, position);
        if line >= 2 {
            before = before.max(self.beside(line - 2, position));
        }
        let mut after = self.beside(line + 1, position);
        if line + 2 < self.count {
            after = after.max(self.beside(line + 2, position));
        }
        Some(before.min(after))
    }
}

/// The level with its thresholds, in counts.
#[derive(Debug, Clone, Copy)]
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
        let least = if options.floating {
            options.unloaded_counts.unwrap_or(0.0).min(baseline)
        } else {
            baseline
        };
        // What is out reads 0 and half a bell of noise above it: it must fit below the floor.
        let far_enough =
            least >= (options.floor_sigmas + 2.0) * noise && least >= options.floor_counts;
        let fall = (options.floor_sigmas * noise).max(options.floor_share * least);
        Self {
            baseline,
            least,
            noise,
            floor: (level.is_some() && far_enough).then_some(least - fall),
            loaded: baseline + above,
            really_loaded: baseline + really,
            ceiling: max_count - options.end_counts,
        }
    }
}

impl Thresholds {
    /// What a line that says nothing may read beside this load, counts.
    pub fn silence(&self, load: f64, options: &ScreenOptions) -> f64 {
        let left = options.silent_share * (load - self.baseline);
        self.baseline + left.max(options.floor_sigmas * self.noise)
    }
}

/// What one frame says about one line.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct LineVerdict {
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

/// Judges one line: it is out when nearly all of its readings have fallen below what an unloaded taxel reads (where
/// there is something to fall from), or when it is silent at nearly all places where the lines on both sides carry a
/// real load and responds nowhere else; or when nearly all of its readings are at the ceiling and those beside it are
/// not. Of fewer than four readings no line can be told.
pub(super) fn classify(
    lines: &LineReadings<'_>,
    line: usize,
    thresholds: &Thresholds,
    options: &ScreenOptions,
) -> LineVerdict {
    let mut verdict = LineVerdict::default();
    let taxels = lines.taxels(line);
    if taxels < MIN_LINE {
        return verdict;
    }
    verdict.judged = true;
    let (mut fallen, mut ceiling) = (0u64, 0u64);
    // A reading below the floor may be as much as that.
    let bound = |value: f64| match options.floor_count {
        Some(floor) => value.max(floor),
        None => value,
    };
    for position in lines.positions(line) {
        let value = lines.at(line, position);
        fallen += u64::from(thresholds.floor.is_some_and(|floor| value < floor));
        verdict.responding += u64::from(value > thresholds.loaded && value < thresholds.ceiling);
        ceiling += u64::from(value >= thresholds.ceiling);
        if let Some(load) = lines.supported_load(line, position, thresholds, options) {
            verdict.supported += 1;
            verdict.silent += u64::from(bound(value) <= thresholds.silence(load, options));
        }
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

/// Whether a line beside this one is at the ceiling on more than half of its length as well.
fn next_to_at_ceiling(lines: &LineReadings<'_>, line: usize, thresholds: &Thresholds) -> bool {
    let full = |other: usize| {
        let at_end = lines.of_line(other).filter(|&v| v >= thresholds.ceiling);
        2 * at_end.count() > lines.taxels(other)
    };
    (line > 0 && full(line - 1)) || (line + 1 < lines.count && full(line + 1))
}

/// Which of the flickering lines in `faults` are out in this very frame, into `out` (cleared first; its capacity
/// is reused). `level` as from [`super::LevelScreen`]; without it only lines between loaded ones can be told.
pub fn lines_dropped(
    frame: &Frame<Counts>,
    faults: &LineFaults,
    level: Option<Level>,
    max_count: f64,
    options: &ScreenOptions,
    out: &mut Vec<(Axis, usize)>,
) {
    out.clear();
    let thresholds = Thresholds::new(level, max_count, options);
    for axis in Axis::BOTH {
        let lines = LineReadings::of(frame, axis, options);
        let indices = faults.flickering(axis).filter(|&line| line < lines.count);
        for line in indices {
            if classify(&lines, line, &thresholds, options).out {
                out.push((axis, line));
            }
        }
    }
}
