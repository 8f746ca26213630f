//! What one frame by itself tells of its lines.

use taxel_linalg::wide;

use super::level::reads_nothing;
use super::line_state::{FrameLines, LineVerdict, Thresholds, classify, is_there};
use super::{Axis, Level, ScreenOptions, check_shape};
use crate::stats::median_high;
use crate::{Counts, Error, Frame};

/// What a frame tells of lines.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) enum Tells {
    /// Another program has looked after the lines.
    #[default]
    NotAsked,
    /// Nothing: it is nothing but zeros.
    Zeros,
    /// Nothing: half of its lines are out, which is no line's fault.
    Blank,
    /// A verdict on each.
    Lines,
}

/// What one frame by itself tells of its lines, and room for that of the next: from [`super::LineScreen::evidence`]. Any
/// thread can find it; [`super::LineScreen::add`] takes it in, in the order of the frames.
#[derive(Debug, Clone, Default)]
pub struct LineEvidence {
    options: ScreenOptions,
    max_count: f64,
    scratch: Vec<f64>,
    pub(super) level: Option<Level>,
    pub(super) thresholds: Thresholds,
    pub(super) tells: Tells,
    pub(super) lines: FrameLines,
    /// Of the rows, then of the columns.
    pub(super) verdicts: Vec<LineVerdict>,
    pub(super) any_at_ceiling: bool,
    /// Of an array with floating lines: what every row, then every column, reads at most of its places, counts above
    /// the baseline.
    pub(super) usual: Vec<f64>,
}

impl LineEvidence {
    /// For frames of this shape and a converter whose largest count is `max_count`.
    pub(super) fn new(
        rows: usize,
        columns: usize,
        max_count: f64,
        options: &ScreenOptions,
    ) -> Self {
        Self {
            options: options.clone(),
            max_count,
            scratch: Vec::with_capacity(rows.max(columns)),
            lines: FrameLines::new(rows, columns),
            verdicts: Vec::with_capacity(rows + columns),
            usual: vec![0.0; rows + columns],
            ..Self::default()
        }
    }

    /// Looks at a frame, with the level that a [`super::LevelScreen`] has found in the frames up to it.
    ///
    /// # Errors
    /// [`Error::Shape`] for a frame of another shape.
    pub fn find(&mut self, frame: &Frame<Counts>, level: Option<Level>) -> Result<(), Error> {
        let (rows, columns) = self.lines.shape();
        check_shape("frame to screen", rows, columns, frame)?;
        self.level = level;
        self.tells = if self.options.exported {
            Tells::NotAsked
        } else if reads_nothing(frame.values()) {
            Tells::Zeros
        } else {
            self.thresholds = Thresholds::new(level, self.max_count, &self.options);
            self.lines.take(frame, &self.options);
            self.judge_lines()
        };
        Ok(())
    }

    fn judge_lines(&mut self) -> Tells {
        let thresholds = self.thresholds;
        if self.options.floating {
            self.find_usual(thresholds.baseline);
        }
        self.verdicts.clear();
        wide(
            #[inline(always)]
            || {
                let readings = self.lines.by_row().iter();
                let ceiling = thresholds.ceiling;
                self.any_at_ceiling = readings.fold(false, |any, &value| any | (value >= ceiling));
                for axis in Axis::BOTH {
                    let lines = self.lines.along(axis, &self.options);
                    for line in 0..lines.count {
                        let verdict = classify(&lines, line, &thresholds, &self.options);
                        self.verdicts.push(verdict);
                    }
                }
            },
        );
        let (of_rows, of_columns) = self.verdicts.split_at(self.lines.shape().0);
        let blank = |all: &[LineVerdict]| {
            let out = all.iter().filter(|v| v.out).count();
            out > 0 && 2 * out >= all.iter().filter(|v| v.judged).count()
        };
        if blank(of_rows) || blank(of_columns) {
            Tells::Blank
        } else {
            Tells::Lines
        }
    }

    /// Medians of all lines.
    fn find_usual(&mut self, baseline: f64) {
        let mut usual = self.usual.iter_mut();
        for axis in Axis::BOTH {
            let lines = self.lines.along(axis, &self.options);
            for (line, usual) in (0..lines.count).zip(&mut usual) {
                self.scratch.clear();
                let readings = lines.of_line(line).iter().copied();
                self.scratch
                    .extend(readings.filter(|reading| is_there(*reading)));
                *usual = median_high(&mut self.scratch).unwrap_or(0.0) - baseline;
            }
        }
    }
}
