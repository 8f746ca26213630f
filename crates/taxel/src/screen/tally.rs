//! What a recording says of each line, frame by frame.

use super::ScreenOptions;
use super::line_state::{LineReadings, LineVerdict, Thresholds, is_there};
use super::suspect::Silence;
use super::together::Stands;
use crate::stats::median_high;

/// A line falls silent when it read at least this share of the load beside it in the frame before …
const ANSWERED_SHARE: f64 = 0.3;
/// … and that load has changed by no more than this factor since: a hand that moves on changes both.
const STEADY_FACTOR: f64 = 1.5;

/// What is kept of one line over a recording.
#[derive(Debug, Clone, Default)]
pub(super) struct LineTally {
    pub(super) tested: u64,
    /// Frames in which it had fallen, or was at the ceiling.
    pub(super) fallen: u64,
    /// Frames in which only its silence tells, and of these the frames in which it fell silent under a steady load.
    pub(super) silent: u64,
    pub(super) fell_silent: u64,
    pub(super) supported_readings: u64,
    pub(super) silent_readings: u64,
    pub(super) fallen_share_when_in: f64,
    /// Frames in which it answered to a load.
    pub(super) answered: u64,
    /// Positions along it that were vouched for in some frame, and taxels there are.
    pub(super) covered: Vec<bool>,
    pub(super) taxels: usize,
    pub(super) median_sum: f64,
    pub(super) next_to_sum: f64,
    /// Whether it reads nothing beside loads.
    pub(super) silence: Silence,
    /// What its readings say together.
    pub(super) stands: Stands,
}

impl LineTally {
    pub(super) fn of_length(length: usize) -> Self {
        Self {
            covered: vec![false; length],
            stands: Stands::of_length(length),
            ..Self::default()
        }
    }

    pub(super) fn covered_share(&self) -> f64 {
        self.covered.iter().filter(|&&covered| covered).count() as f64 / self.taxels.max(1) as f64
    }
}

/// One frame, the one before it and what they are judged by, along one axis.
pub(super) struct Looked<'a> {
    pub(super) lines: LineReadings<'a>,
    pub(super) before: Option<LineReadings<'a>>,
    pub(super) thresholds: &'a Thresholds,
    pub(super) options: &'a ScreenOptions,
}

impl Looked<'_> {
    /// Adds the frame's verdict on a line to its tally.
    #[inline(always)]
    pub(super) fn tally(
        &self,
        line: usize,
        verdict: &LineVerdict,
        tally: &mut LineTally,
        scratch: &mut Vec<f64>,
    ) {
        tally.taxels = verdict.taxels;
        let few = (1.0 - self.options.line_share) / 2.0 * tally.taxels as f64;
        tally.answered += u64::from(verdict.responding as f64 > few);
        if !verdict.testable {
            return;
        }
        tally.tested += 1;
        tally.supported_readings += verdict.supported;
        tally.silent_readings += verdict.silent;
        if let Some(sides) = self.lines.sides(line).filter(|_| verdict.supported > 0) {
            let own = self.lines.of_line(line).iter();
            for (position, (covered, value)) in tally.covered.iter_mut().zip(own).enumerate() {
                let (_, is_real) = sides.load(position, self.thresholds);
                *covered |= is_real & is_there(*value);
            }
        }
        if !verdict.out {
            tally.fallen_share_when_in += verdict.fallen_share;
            return;
        }
        if verdict.only_silent {
            tally.silent += 1;
            tally.fell_silent += u64::from(self.fell_silent(line));
        } else {
            tally.fallen += 1;
        }
        let (own, next_to) = self.medians(line, verdict.only_silent, scratch);
        tally.median_sum += own;
        tally.next_to_sum += next_to;
    }

    /// Whether a line that is silent answered in the frame before, to much the same load beside it.
    fn fell_silent(&self, line: usize) -> bool {
        let (Some(before), Some(sides)) = (&self.before, self.lines.sides(line)) else {
            return false;
        };
        let Some(sides_before) = before.sides(line) else {
            return false;
        };
        let baseline = self.thresholds.baseline;
        let (mut supported, mut fell) = (0, 0);
        for position in self.positions(line) {
            let Some(now) = sides.real_load(position, self.thresholds) else {
                continue;
            };
            supported += 1;
            let steady = sides_before
                .real_load(position, self.thresholds)
                .map(|then| (then - baseline, (then - baseline) / (now - baseline)))
                .filter(|(_, change)| (1.0 / STEADY_FACTOR..=STEADY_FACTOR).contains(change));
            let answered = before.of_line(line)[position] - baseline;
            fell += u64::from(steady.is_some_and(|(then, _)| answered >= ANSWERED_SHARE * then));
        }
        fell as f64 >= self.options.line_share * supported as f64
    }

    /// Positions along a line at which there is a taxel.
    fn positions(&self, line: usize) -> impl Iterator<Item = usize> + use<'_> {
        let readings = self.lines.of_line(line).iter().enumerate();
        let there = readings.filter(|(_, reading)| is_there(**reading));
        there.map(|(position, _)| position)
    }

    /// Median readings of a line and of those beside it: where these carry a load, if that is what tells.
    fn medians(&self, line: usize, by_silence: bool, scratch: &mut Vec<f64>) -> (f64, f64) {
        let sides = self.lines.sides(line);
        let is_loaded = |position: usize| {
            let load = sides.and_then(|sides| sides.real_load(position, self.thresholds));
            load.is_some()
        };
        let mut median_of = |of_lines: [Option<usize>; 2]| {
            scratch.clear();
            for of in of_lines.into_iter().flatten() {
                let positions = self.positions(of);
                let counted = positions.filter(|&position| !by_silence || is_loaded(position));
                scratch.extend(counted.map(|position| self.lines.of_line(of)[position]));
            }
            median_high(scratch).unwrap_or(0.0)
        };
        let own = median_of([Some(line), None]);
        (own, median_of(self.lines.beside(line)))
    }
}
