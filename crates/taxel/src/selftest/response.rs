//! Which taxels and lines answer when they are pressed.

use super::SelfTestOptions;
use crate::screen::Axis;

/// From where on a taxel is loaded, and up to where it is silent: above what it reads unloaded, taxel by taxel, in the unit
/// of what it is compared with.
#[derive(Debug, Clone, Default)]
pub(super) struct Limits {
    pub loaded: Vec<f64>,
    pub quiet: Vec<f64>,
    /// Taxels that vouch for nothing.
    pub masked: Vec<bool>,
}

/// Whether a taxel answered in the frames in which others vouch that it was pressed.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Answers {
    /// Frames in which they vouch.
    pub supported: u32,
    /// Of these, frames in which it was silent.
    pub silent: u32,
    /// Sum of the loads vouched for, in the unit of what is observed.
    expected: f64,
    /// Sum of what it read of them, each no more than was vouched for.
    given: f64,
}

impl Answers {
    fn add(&mut self, height: f64, supported: f64, quiet: f64, share: f64) {
        if supported > 0.0 && !height.is_nan() {
            self.supported += 1;
            self.silent += u32::from(height <= quiet.max(share * supported));
            self.expected += supported;
            self.given += height.clamp(0.0, supported);
        }
    }

    /// The part of the load vouched for that it read over all frames, 0 to 1. Cross-talk under a strong load exceeds a weak
    /// one in some frames; here the strong ones weigh more.
    pub fn given_share(&self) -> f64 {
        self.given / self.expected.max(f64::MIN_POSITIVE)
    }

    /// Share of silent frames, 0 to 1.
    pub fn silent_share(&self) -> f64 {
        f64::from(self.silent) / f64::from(self.supported.max(1))
    }
}

/// Follows the rubbed recording.
///
/// Vouching works as in [`crate::screen::LineScreen`]: a side vouches with the larger load of its two nearest taxels, so
/// that a second bad one beside the first does not hide it, and all sides must. For a line the sides are the lines
/// beside it; for a taxel all four (three at an edge). That a taxel comes and goes is harder to tell from a gap between two
/// fingers: there all eight taxels around it must be loaded, and at an edge it is not judged.
#[derive(Debug, Clone)]
pub(super) struct Response {
    rows: usize,
    columns: usize,
    /// By the taxels above and below, for rows, and to the left and right, for columns.
    pub across: [Vec<Answers>; 2],
    /// By all sides, for the taxel itself.
    pub around: Vec<Answers>,
    /// By all of the eight taxels around it.
    pub close: Vec<Answers>,
    /// Frames in which the taxel was loaded.
    pub loaded: Vec<u32>,
    /// Frames of the recording.
    pub frames: u64,
    /// Readings far above, and far below, what the taxel reads unloaded.
    pub moved: [u64; 2],
    load: Vec<f64>,
    absent: Vec<bool>,
}

impl Response {
    pub fn new(rows: usize, columns: usize, absent: &[bool]) -> Self {
        let taxels = rows * columns;
        let none = vec![Answers::default(); taxels];
        Self {
            rows,
            columns,
            across: [none.clone(), none.clone()],
            around: none.clone(),
            close: none,
            loaded: vec![0; taxels],
            frames: 0,
            moved: [0; 2],
            load: vec![0.0; taxels],
            absent: absent.to_vec(),
        }
    }

    /// Takes what every taxel reads above what it reads unloaded, row by row, in the unit of `limits`; NaN where a stray reading says
    /// nothing.
    pub fn observe(&mut self, heights: &[f64], limits: &Limits, options: &SelfTestOptions) {
        self.frames += 1;
        for (taxel, &height) in heights.iter().enumerate() {
            let is_load = height > limits.loaded[taxel] && !limits.masked[taxel];
            self.load[taxel] = if is_load { height } else { 0.0 };
            self.loaded[taxel] += u32::from(is_load);
            self.moved[0] += u64::from(is_load);
            let is_there = !self.is_absent(taxel);
            self.moved[1] += u64::from(is_there && height < -limits.loaded[taxel]);
        }
        let share = options.screen.silent_share;
        for (taxel, &height) in heights.iter().enumerate() {
            let quiet = limits.quiet[taxel];
            let (row, column) = (taxel / self.columns, taxel % self.columns);
            let sides = [
                self.side(row, self.rows, taxel, self.columns),
                self.side(column, self.columns, taxel, 1),
            ];
            for (answers, side) in self.across.iter_mut().zip(sides) {
                if let [Some(before), Some(after)] = side {
                    answers[taxel].add(height, before.min(after), quiet, share);
                }
            }
            let all = sides.into_iter().flatten().flatten();
            let mut supported = all.clone().fold(f64::INFINITY, f64::min);
            if all.count() < 3 && supported < options.corner_factor * limits.loaded[taxel] {
                supported = 0.0;
            }
            self.around[taxel].add(height, supported, quiet, share);
            let supported = self.close_load(row, column);
            self.close[taxel].add(height, supported, quiet, share);
        }
    }

    /// The larger load of the two nearest taxels before and after `taxel`, which is at `position` of `length`.
    fn side(
        &self,
        position: usize,
        length: usize,
        taxel: usize,
        stride: usize,
    ) -> [Option<f64>; 2] {
        let before = (position >= 1).then(|| {
            let near = self.load[taxel - stride];
            if position >= 2 {
                near.max(self.load[taxel - 2 * stride])
            } else {
                near
            }
        });
        let after = (position + 1 < length).then(|| {
            let near = self.load[taxel + stride];
            if position + 2 < length {
                near.max(self.load[taxel + 2 * stride])
            } else {
                near
            }
        });
        [before, after]
    }

    /// The least load of the eight taxels around one; nothing at an edge.
    fn close_load(&self, row: usize, column: usize) -> f64 {
        let inside = |at: usize, count: usize| at >= 1 && at + 1 < count;
        if !inside(row, self.rows) || !inside(column, self.columns) {
            return 0.0;
        }
        let mut least = f64::INFINITY;
        for r in row - 1..=row + 1 {
            for c in column - 1..=column + 1 {
                if (r, c) != (row, column) {
                    least = least.min(self.load[r * self.columns + c]);
                }
            }
        }
        least
    }

    /// Whether there is no taxel at a crossing.
    pub fn is_absent(&self, taxel: usize) -> bool {
        self.absent.get(taxel).copied().unwrap_or(false)
    }

    /// The lines of an axis that have a taxel.
    pub fn lines(&self, axis: Axis) -> Vec<usize> {
        let count = match axis {
            Axis::Row => self.rows,
            Axis::Column => self.columns,
        };
        let has_taxel = |&index: &usize| self.line(axis, index).next().is_some();
        (0..count).filter(has_taxel).collect()
    }

    /// The taxels of a line.
    pub fn line(&self, axis: Axis, index: usize) -> impl Iterator<Item = usize> + '_ {
        let (rows, columns) = (self.rows, self.columns);
        let (first, stride, length) = match axis {
            Axis::Row => (index * columns, 1, columns),
            Axis::Column => (index, columns, rows),
        };
        let crossings = (0..length).map(move |position| first + position * stride);
        crossings.filter(|&taxel| !self.is_absent(taxel))
    }

    /// How a line as a whole answered the lines beside it, and at how many of its positions they vouched often enough.
    fn answers_of(&self, axis: Axis, index: usize, options: &SelfTestOptions) -> (Answers, usize) {
        let of_axis = &self.across[usize::from(axis == Axis::Column)];
        let (mut all, mut judged) = (Answers::default(), 0);
        for taxel in self.line(axis, index) {
            let answers = of_axis[taxel];
            judged += usize::from(answers.supported >= options.supported_frames);
            all.supported += answers.supported;
            all.silent += answers.silent;
        }
        (all, judged)
    }

    /// How each taxel of a line answered the lines beside it, where these vouched often enough; by its position along it.
    pub fn answers_along(
        &self,
        axis: Axis,
        index: usize,
        options: &SelfTestOptions,
    ) -> Vec<(usize, Answers)> {
        let of_axis = &self.across[usize::from(axis == Axis::Column)];
        let position = |taxel: usize| match axis {
            Axis::Row => taxel % self.columns,
            Axis::Column => taxel / self.columns,
        };
        let line = self.line(axis, index);
        let judged = line.filter(|&taxel| of_axis[taxel].supported >= options.supported_frames);
        judged
            .map(|taxel| (position(taxel), of_axis[taxel]))
            .collect()
    }

    /// Share of the readings on a line that the lines beside it vouch for and that are silent, 0 to 1.
    pub fn silent_share(&self, axis: Axis, index: usize, options: &SelfTestOptions) -> f64 {
        self.answers_of(axis, index, options).0.silent_share()
    }

    /// Whether a line never answered although those beside it did, over enough of its length.
    pub fn is_open(&self, axis: Axis, index: usize, options: &SelfTestOptions) -> bool {
        let (all, judged) = self.answers_of(axis, index, options);
        let positions = self.line(axis, index).count();
        let enough = (options.line_tested_share * positions as f64).max(4.0);
        judged as f64 >= enough && all.silent_share() >= options.open_share
    }

    /// Whether no taxel of a line was ever loaded.
    pub fn never_loaded(&self, axis: Axis, index: usize) -> bool {
        self.line(axis, index).all(|taxel| self.loaded[taxel] == 0)
    }

    /// Share of a line's taxels that were loaded at least once.
    pub fn reached(&self, axis: Axis, index: usize) -> f64 {
        let (mut all, mut reached) = (0usize, 0usize);
        for taxel in self.line(axis, index) {
            all += 1;
            reached += usize::from(self.loaded[taxel] > 0);
        }
        reached as f64 / all.max(1) as f64
    }
}
