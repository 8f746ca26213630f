//! Single readings that cannot be trusted, frame by frame.

use super::line_state::{FrameLines, Thresholds, find_dropped};
use super::{Axis, Level, LevelScreen, LineFaults, ScreenOptions, SpaceSpikes, check_shape};
use crate::frame::{BLOCK, any_beyond, has_mark};
use crate::sensor::mark_absent;
use crate::stats::{SIGMA_PER_MAD, median_high};
use crate::{Counts, Error, Frame, Mark, Sensor};

/// A taxel that read at least this share of the range may be saturated in the next frame.
const OWN_SUPPORT_SHARE: f64 = 0.5;

/// Frames in a row at the ceiling that tell a press beyond it from a stray reading.
pub(super) const HELD_FRAMES: u8 = 3;

/// The valid readings around one taxel.
#[derive(Debug, Clone, Copy, Default)]
struct Around {
    values: [f64; 8],
    len: usize,
}

impl Around {
    fn of(frame: &Frame<Counts>, row: usize, column: usize) -> Self {
        let mut around = Self::default();
        for r in row.saturating_sub(1)..=(row + 1).min(frame.rows() - 1) {
            for c in column.saturating_sub(1)..=(column + 1).min(frame.columns() - 1) {
                if (r, c) != (row, column) && frame.mark_at(r, c).is_reading() {
                    around.values[around.len] = frame.at(r, c);
                    around.len += 1;
                }
            }
        }
        around
    }

    fn values(&self) -> &[f64] {
        &self.values[..self.len]
    }

    /// Whether all eight neighbours exceed `threshold`, the least of them by half as much as the most: the midst of one
    /// contact, where no hole is. Between the edges of several there may be one.
    fn surround_above(&self, baseline: f64, threshold: f64) -> bool {
        let heights = self.values().iter().map(|value| value - baseline);
        let (least, most) = heights.fold((f64::INFINITY, 0.0f64), |(least, most), height| {
            (least.min(height), most.max(height))
        });
        self.len == 8 && least > threshold && 2.0 * least >= most
    }
}

/// Marks the readings of a stream of frames, with state of constant size.
///
/// First crossings without a taxel; then, in this order, and never over a mark that is already there: readings on dead, shorted and (where out in this
/// frame) flickering lines; readings at either end of the converter, as stuck as saturated or as below
/// the floor; spikes, where asked for. Values are left as they are.
#[derive(Debug, Clone)]
pub struct FrameScreen {
    rows: usize,
    columns: usize,
    max_count: f64,
    options: ScreenOptions,
    levels: LevelScreen,
    lines: LineFaults,
    /// Taxels that were high, or saturated, in the frame before.
    was_high: Vec<bool>,
    /// Frames in a row that each taxel has stood at the ceiling.
    at_ceiling: Vec<u8>,
    /// Taxels that the whole recording tells to be pressed beyond the ceiling.
    held_at_ceiling: Vec<bool>,
    /// The frame's readings by line, where flickering lines are looked for.
    by_line: FrameLines,
    dropped: Vec<(Axis, usize)>,
    spikes: Vec<usize>,
}

impl FrameScreen {
    /// For the frames of a sensor, as its `screen` says; [`FrameScreen::set_lines`] says which of its lines are faulty.
    pub fn from_sensor(sensor: &Sensor) -> Self {
        let options = ScreenOptions::from_sensor(sensor);
        Self::new(
            sensor.rows(),
            sensor.columns(),
            sensor.max_count(),
            &options,
        )
    }

    /// For frames of this shape and a converter whose largest count is `max_count`.
    pub fn new(rows: usize, columns: usize, max_count: f64, options: &ScreenOptions) -> Self {
        Self {
            rows,
            columns,
            max_count,
            options: options.clone(),
            levels: LevelScreen::new(rows, columns, max_count, options),
            lines: LineFaults::default(),
            was_high: vec![false; rows * columns],
            at_ceiling: vec![0; rows * columns],
            held_at_ceiling: vec![false; rows * columns],
            by_line: FrameLines::new(rows, columns),
            dropped: Vec::with_capacity(rows + columns),
            spikes: Vec::with_capacity(rows * columns),
        }
    }

    /// Tells it which lines are faulty (from [`super::LineScreen`] or the sensor file). The level found with them, if
    /// any, is used until the stream has one of its own.
    pub fn set_lines(&mut self, faults: &LineFaults) {
        self.lines = faults.clone();
        self.held_at_ceiling.fill(false);
        for &taxel in &faults.held_at_ceiling {
            if let Some(held) = self.held_at_ceiling.get_mut(taxel) {
                *held = true;
            }
        }
    }

    /// Baseline and noise in use: from the stream so far, else from the recording the line faults come from.
    pub fn level(&self) -> Option<Level> {
        self.levels.level().or(self.lines.level)
    }

    /// The flickering lines that were out in the last frame.
    pub fn dropped(&self) -> &[(Axis, usize)] {
        &self.dropped
    }

    /// Marks one frame, the next of the stream.
    ///
    /// # Errors
    /// [`Error::Shape`] for a frame of another shape.
    pub fn mark(&mut self, frame: &mut Frame<Counts>) -> Result<(), Error> {
        check_shape("frame to screen", self.rows, self.columns, frame)?;
        mark_absent(&self.options.absent, frame.marks_mut());
        if self.options.exported {
            self.mark_range(frame);
            return Ok(());
        }
        self.levels.observe(frame)?;
        let level = self.level();
        let thresholds = Thresholds::new(level, self.max_count, &self.options);
        self.mark_lines(frame, &thresholds);
        self.mark_ends(frame, &thresholds);
        if let Some(spikes) = self.options.space_spikes {
            self.mark_space_spikes(frame, &thresholds, &spikes);
        }
        self.remember_high(frame, thresholds.ceiling);
        Ok(())
    }

    /// The taxel's own past is better evidence than a neighbour: half of the range will do.
    fn remember_high(&mut self, frame: &Frame<Counts>, ceiling: f64) {
        let support = OWN_SUPPORT_SHARE * self.max_count;
        let lines = frame.values().chunks_exact(self.columns);
        let lines = lines.zip(frame.marks().chunks_exact(self.columns));
        for (high, (values, marks)) in self.was_high.chunks_exact_mut(self.columns).zip(lines) {
            let is_saturated = |mark| mark == Mark::Saturated;
            if !any_beyond(values, f64::NEG_INFINITY, support) && !has_mark(marks, is_saturated) {
                high.fill(false);
                continue;
            }
            for ((high, &value), mark) in high.iter_mut().zip(values).zip(marks) {
                *high = match mark {
                    Mark::Saturated => true,
                    Mark::Good => value >= support && value < ceiling,
                    _ => false,
                };
            }
        }
    }

    /// Saturated or below the floor, and nothing else: of numbers that another program has screened.
    fn mark_range(&self, frame: &mut Frame<Counts>) {
        let low = self.options.floor_count.unwrap_or(f64::NEG_INFINITY);
        let (values, marks) = frame.values_and_marks_mut();
        for (values, marks) in values.chunks(BLOCK).zip(marks.chunks_mut(BLOCK)) {
            // Hardly a reading stands at an end.
            if !any_beyond(values, low, self.max_count) {
                continue;
            }
            for (&value, mark) in values.iter().zip(marks) {
                if *mark != Mark::Good {
                    continue;
                }
                if value >= self.max_count {
                    *mark = Mark::Saturated;
                } else if self.options.is_below_floor(value) {
                    *mark = Mark::BelowFloor;
                }
            }
        }
    }

    fn mark_lines(&mut self, frame: &mut Frame<Counts>, thresholds: &Thresholds) {
        self.dropped.clear();
        if self.lines.has_flickering() {
            self.by_line.take(frame, &self.options);
            let (lines, dropped) = (&self.by_line, &mut self.dropped);
            find_dropped(lines, &self.lines, thresholds, &self.options, dropped);
        }
        for axis in Axis::BOTH {
            for line in self.lines.dead(axis) {
                mark_line(frame, axis, line, Mark::Open);
            }
            for (line, with) in self.lines.shorted(axis) {
                mark_line(frame, axis, line, Mark::Shorted);
                mark_line(frame, axis, with, Mark::Shorted);
            }
        }
        for &(axis, line) in &self.dropped {
            mark_line(frame, axis, line, Mark::Flickering);
        }
    }

    /// Stuck, saturated or below the floor, for every reading at either end of what is recorded.
    fn mark_ends(&mut self, frame: &mut Frame<Counts>, thresholds: &Thresholds) {
        let floor = self.options.floor_count.unwrap_or(f64::NEG_INFINITY);
        let low = self.options.end_counts.max(floor);
        for row in 0..self.rows {
            let line = row * self.columns..(row + 1) * self.columns;
            // On few rows does any reading stand at an end.
            if any_beyond(&frame.values()[line.clone()], low, thresholds.ceiling) {
                self.mark_ends_of_row(frame, row, thresholds);
            } else {
                self.at_ceiling[line].fill(0);
            }
        }
    }

    fn mark_ends_of_row(&mut self, frame: &mut Frame<Counts>, row: usize, thresholds: &Thresholds) {
        let options = &self.options;
        let fallen = thresholds.least - options.stuck_sigmas * thresholds.noise;
        let below_baseline = fallen > options.end_counts && thresholds.floor.is_some();
        let surround = options.stuck_surround_share * self.max_count;
        let support = options.saturated_support_share * self.max_count;
        for column in 0..self.columns {
            let i = row * self.columns + column;
            let value = frame.values()[i];
            let run = &mut self.at_ceiling[i];
            *run = if value >= thresholds.ceiling {
                run.saturating_add(1)
            } else {
                0
            };
            if frame.marks()[i] != Mark::Good {
                continue;
            }
            if value >= thresholds.ceiling {
                let around = Around::of(frame, row, column);
                let stands = *run >= HELD_FRAMES || self.held_at_ceiling[i];
                let plausible = options.ceiling_is_load
                    || stands
                    || self.was_high[i]
                    || is_supported(&around, support, thresholds);
                frame.marks_mut()[i] = if plausible {
                    Mark::Saturated
                } else {
                    Mark::Stuck
                };
            } else if options.is_below_floor(value) {
                frame.marks_mut()[i] = Mark::BelowFloor;
            } else if value <= options.end_counts
                && (below_baseline
                    || !options.floating
                        && Around::of(frame, row, column)
                            .surround_above(thresholds.baseline, surround))
            {
                frame.marks_mut()[i] = Mark::Stuck;
            }
        }
    }

    fn mark_space_spikes(
        &mut self,
        frame: &mut Frame<Counts>,
        thresholds: &Thresholds,
        spikes: &SpaceSpikes,
    ) {
        self.spikes.clear();
        for i in 0..frame.values().len() {
            if frame.marks()[i] != Mark::Good {
                continue;
            }
            let mut around = Around::of(frame, i / self.columns, i % self.columns);
            let len = around.len;
            let Some(middle) = median_high(&mut around.values[..len]).filter(|_| len >= 3) else {
                continue;
            };
            let mut spread = around.values;
            for value in &mut spread[..len] {
                *value = (*value - middle).abs();
            }
            let scale = SIGMA_PER_MAD * median_high(&mut spread[..len]).unwrap_or(0.0);
            let height = (middle - thresholds.baseline).max(0.0);
            let distance = (frame.values()[i] - middle).abs();
            if distance > spikes.sigmas * thresholds.noise + spikes.share * height
                && distance > spikes.sigmas * scale
            {
                self.spikes.push(i);
            }
        }
        for &i in &self.spikes {
            frame.marks_mut()[i] = Mark::Spike;
        }
    }
}

/// Whether the neighbourhood makes a reading at the ceiling plausible: one neighbour that is high but not at the
/// ceiling itself, or two that are at it (one alone may be another stuck reading).
fn is_supported(around: &Around, support: f64, thresholds: &Thresholds) -> bool {
    let at_ceiling = |v: &&f64| **v >= thresholds.ceiling;
    let high = around.values().iter().filter(|v| **v >= support);
    let full = high.clone().filter(at_ceiling).count();
    high.count() > full || full >= 2
}

/// Marks the good readings of one line.
fn mark_line(frame: &mut Frame<Counts>, axis: Axis, line: usize, mark: Mark) {
    let (rows, columns) = (frame.rows(), frame.columns());
    let (count, first, stride, length) = match axis {
        Axis::Row => (rows, line * columns, 1, columns),
        Axis::Column => (columns, line, columns, rows),
    };
    if line >= count {
        return;
    }
    let marks = frame.marks_mut().iter_mut().skip(first).step_by(stride);
    for old in marks.take(length).filter(|old| **old == Mark::Good) {
        *old = mark;
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    use super::super::LineScreen;
    use super::super::line::tests::noise;
    use super::*;

    const FULL: f64 = 65_535.0;
    const N: usize = 16;

    fn quiet(random: &mut ChaCha8Rng) -> Frame<Counts> {
        let reading = |_| (25.0 + 3.0 * noise(random)).round();
        Frame::new(N, N, (0..N * N).map(reading).collect()).unwrap()
    }

    fn screen() -> FrameScreen {
        FrameScreen::new(N, N, FULL, &ScreenOptions::default())
    }

    fn marked(frame: &Frame<Counts>) -> Vec<(usize, Mark)> {
        let marks = frame.marks().iter().copied().enumerate();
        marks.filter(|(_, m)| *m != Mark::Good).collect()
    }

    #[test]
    fn isolated_presses_are_good_and_isolated_ends_are_stuck() {
        let mut random = ChaCha8Rng::seed_from_u64(1);
        let mut frame = quiet(&mut random);
        frame.values_mut()[100] = 35_000.0;
        frame.values_mut()[40] = FULL;
        frame.values_mut()[200] = 0.0;
        frame.values_mut()[0] = FULL - 1.0;
        let values = frame.values().to_vec();
        screen().mark(&mut frame).unwrap();
        let stuck = [(0, Mark::Stuck), (40, Mark::Stuck), (200, Mark::Stuck)];
        assert_eq!(marked(&frame), stuck);
        assert_eq!(frame.values(), values, "values are left as they are");
    }

    #[test]
    fn a_press_that_reaches_the_ceiling_is_saturated() {
        let mut random = ChaCha8Rng::seed_from_u64(2);
        let mut frame = quiet(&mut random);
        for (i, value) in [(100, FULL), (101, 50_000.0), (116, 44_000.0)] {
            frame.values_mut()[i] = value;
        }
        screen().mark(&mut frame).unwrap();
        assert_eq!(marked(&frame), [(100, Mark::Saturated)]);
    }

    #[test]
    fn a_single_taxel_that_rose_to_the_ceiling_in_the_stream_is_saturated_while_it_stays() {
        let mut random = ChaCha8Rng::seed_from_u64(3);
        let mut screen = screen();
        let mut marks = Vec::new();
        for value in [25.0, 40_000.0, FULL, FULL, 25.0, FULL, FULL] {
            let mut frame = quiet(&mut random);
            frame.values_mut()[77] = value;
            screen.mark(&mut frame).unwrap();
            marks.push(frame.marks()[77]);
        }
        use Mark::{Good, Saturated, Stuck};
        assert_eq!(
            marks,
            [Good, Good, Saturated, Saturated, Good, Stuck, Stuck]
        );
    }

    #[test]
    fn zeros_are_normal_where_an_unloaded_taxel_reads_zero() {
        let mut frame = Frame::<Counts>::zeros(N, N);
        screen().mark(&mut frame).unwrap();
        assert!(marked(&frame).is_empty());
        // … but not in the midst of a load.
        for i in [101, 102, 103, 117, 119, 133, 134, 135] {
            frame.values_mut()[i] = 6000.0;
        }
        screen().mark(&mut frame).unwrap();
        assert_eq!(marked(&frame), [(118, Mark::Stuck)]);
    }

    #[test]
    fn marks_that_are_there_stay() {
        let mut frame = Frame::<Counts>::filled(N, N, 25.0);
        frame.values_mut()[5] = FULL;
        frame.marks_mut()[5] = Mark::Open;
        screen().mark(&mut frame).unwrap();
        assert_eq!(marked(&frame), [(5, Mark::Open)]);
    }

    #[test]
    fn spikes_in_space_are_marked_only_where_asked_for() {
        let mut random = ChaCha8Rng::seed_from_u64(4);
        let options = ScreenOptions {
            space_spikes: Some(SpaceSpikes::default()),
            ..ScreenOptions::default()
        };
        let mut frame = quiet(&mut random);
        frame.values_mut()[100] = 3000.0;
        let mut same = frame.clone();
        screen().mark(&mut frame).unwrap();
        assert!(marked(&frame).is_empty());
        let mut screen = FrameScreen::new(N, N, FULL, &options);
        screen.mark(&mut same).unwrap();
        assert_eq!(marked(&same), [(100, Mark::Spike)]);
    }

    /// A board that is not up yet, or gone for most of a recording, says nothing of the level; the rest does.
    #[test]
    fn frames_of_zeros_are_stuck_wherever_in_a_recording_they_stand() {
        for zeros in [0..5, 20..25, 0..30] {
            let mut random = ChaCha8Rng::seed_from_u64(6);
            let frames: Vec<_> = (0..40)
                .map(|t| {
                    let sound = quiet(&mut random);
                    if zeros.contains(&t) {
                        Frame::zeros(N, N)
                    } else {
                        sound
                    }
                })
                .collect();
            let mut lines = LineScreen::new(N, N, FULL, &ScreenOptions::default());
            for frame in &frames {
                lines.observe(frame).unwrap();
            }
            let faults = lines.finish();
            assert_eq!(faults.blank_frames, zeros.len() as u64);
            let mut screen = screen();
            screen.set_lines(&faults);
            for (t, mut frame) in frames.into_iter().enumerate() {
                screen.mark(&mut frame).unwrap();
                let stuck = if zeros.contains(&t) { N * N } else { 0 };
                assert_eq!(marked(&frame).len(), stuck, "frame {t} of {zeros:?}");
            }
        }
    }

    /// Where lines float the circuit says what is too little to be a reading, before any frame does.
    #[test]
    fn a_stream_that_begins_with_zeros_is_stuck_where_the_circuit_says_so() {
        let sensor = crate::sensor::preset("mat-16x16-cd4067").unwrap();
        let mut screen = FrameScreen::from_sensor(&sensor);
        let mut frame = Frame::zeros(N, N);
        screen.mark(&mut frame).unwrap();
        assert_eq!(marked(&frame).len(), N * N);
    }
}
