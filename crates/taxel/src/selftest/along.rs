//! Lines that break, or resist, somewhere along their length: what answers beyond the place, and what before it.

use super::classify::Classifier;
use super::quiet::median;
use super::response::{Answers, Response};
use super::{Fault, Place};
use crate::screen::Axis;
use crate::stats::Line;

/// Fewest taxels on either side of a place.
const FEWEST: usize = 3;
/// Fewest judged taxels of a line that may resist.
const FEWEST_JUDGED: usize = 8;
/// Share of the taxels of one side that may answer otherwise than the rest of it.
const EXCEPTIONS: f64 = 0.05;
/// A taxel is silent when it is so in this share of the frames that vouch for it, or has read no more than a part of what was
/// vouched for in all; it answers when it is silent in less than the third of these, and has read more.
const SILENT: f64 = 0.95;
const SILENT_PART: f64 = 0.1;
const ANSWERS: f64 = 0.5;
/// A line resists when ln of what it reads, of what the lines beside it do, falls by this: by a third. Taxels that differ by a
/// tenth make less than a third of that, and the ends of a hand less than a half.
const LEAST_FALL: f64 = 0.4;
/// … and by so many times what the usual line of the array falls by.
const TIMES_USUAL: f64 = 4.0;
/// … and by so many standard errors.
const SIGMAS: f64 = 6.0;
/// Conductances found by a circuit that is not the sensor's are off elsewhere too: beside a line that breaks others seem to fall by up
/// to a fourth of what it does. They are looked at again when it is repaired.
const BESIDE_LARGEST: f64 = 1.0 / 3.0;
/// … and so much that what is read falls along the line too: on sound mats it does by less than half of that, where a crack is worth
/// 1 kΩ by more.
const LEAST_IN_READINGS: f64 = 0.1;
/// What a step explains better than a slope by this factor in squares is a step.
const CLEARLY_A_STEP: f64 = 0.8;

/// A place along a line: the position of the last taxel before it and of the first beyond it.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Split {
    after: usize,
    before: usize,
}

/// How the readings of a line fall along it.
#[derive(Debug, Clone, Copy)]
struct Fall {
    split: Split,
    /// ln of the near side's mean over the far side's.
    size: f64,
    standard_error: f64,
    is_step: bool,
}

/// The same of a line.
#[derive(Debug, Clone, Copy)]
struct FallOfLine {
    axis: Axis,
    index: usize,
    fall: Fall,
}

/// What is seen of lines along their lengths.
#[derive(Debug, Clone, Default)]
pub(super) struct SeenAlong {
    in_readings: Vec<FallOfLine>,
    /// Which taxels answer with the circuit undone, where it was.
    conductances: Option<Response>,
}

impl Classifier<'_> {
    /// Lines that are broken, then those that resist.
    pub(super) fn along_lines(&mut self) {
        let rubbed = self.rubbed;
        let readings = &rubbed.response;
        self.seen.in_readings = Axis::BOTH.map(|axis| self.falls(axis, readings)).concat();
        let is_seen = |fall: &FallOfLine| fall.fall.size >= LEAST_IN_READINGS;
        if self.seen.in_readings.iter().any(is_seen) {
            self.seen.conductances = rubbed.undone(&self.test.options);
        }
        for axis in Axis::BOTH {
            for index in readings.lines(axis) {
                if !self.is_explained(axis, index)
                    && let Some(split) = broken(&self.answers(axis, index, self.along()))
                    && self.is_seen_in_readings(axis, index, split)
                {
                    self.add_broken(axis, index, split);
                }
            }
        }
        let falls = Axis::BOTH.map(|axis| self.falls(axis, self.along()));
        let sizes = falls.iter().flatten().map(|fall| fall.fall.size);
        let largest = sizes.fold(0.0, f64::max);
        for falls in &falls {
            self.resisting_lines(falls, largest);
        }
    }

    /// What tells of lines along their length: the circuit undone, where it is.
    fn along(&self) -> &Response {
        self.seen
            .conductances
            .as_ref()
            .unwrap_or(&self.rubbed.response)
    }

    /// Whether a line that falls somewhere with the circuit undone does so towards the same end in what is read, too: the circuit may be
    /// undone by a wrong one.
    fn is_seen_in_readings(&self, axis: Axis, index: usize, split: Split) -> bool {
        let is_forward = |split: Split| split.after < split.before;
        self.seen.conductances.is_none()
            || self.seen.in_readings.iter().any(|seen| {
                (seen.axis, seen.index) == (axis, index)
                    && seen.fall.size >= LEAST_IN_READINGS
                    && is_forward(seen.fall.split) == is_forward(split)
            })
    }

    /// Whether it was found what is wrong along a line.
    pub(super) fn is_known_along(&self, axis: Axis, index: usize) -> bool {
        self.findings.iter().any(|finding| {
            let place = finding.place;
            matches!(place, Place::Along { axis: a, index: i, .. } if (a, i) == (axis, index))
        })
    }

    fn answers(&self, axis: Axis, index: usize, response: &Response) -> Vec<(usize, Answers)> {
        response.answers_along(axis, index, &self.test.options)
    }

    fn add_broken(&mut self, axis: Axis, index: usize, split: Split) {
        let taxels = self.beyond(axis, index, split);
        let count = taxels.len();
        let evidence = match self.seen.conductances {
            Some(_) => format!(
                "the circuit undone, none of the {count} taxels beyond conducts; those before it do"
            ),
            None => format!("none of the {count} taxels beyond responded; those before it did"),
        };
        self.add(
            Fault::LineBroken,
            place(axis, index, split),
            taxels,
            evidence,
        );
    }

    /// The taxels of a line from the far side of a place on.
    fn beyond(&self, axis: Axis, index: usize, split: Split) -> Vec<usize> {
        let columns = self.test.columns;
        let is_beyond = |&taxel: &usize| {
            let position = match axis {
                Axis::Row => taxel % columns,
                Axis::Column => taxel / columns,
            };
            if split.before > split.after {
                position >= split.before
            } else {
                position <= split.before
            }
        };
        self.line(axis, index)
            .into_iter()
            .filter(is_beyond)
            .collect()
    }

    /// How the lines of an axis fall along their lengths, those that can be judged.
    fn falls(&self, axis: Axis, response: &Response) -> Vec<FallOfLine> {
        let lines = response.lines(axis);
        let shares: Vec<Vec<(usize, f64)>> = lines
            .iter()
            .map(|&index| logs(&self.answers(axis, index, response)))
            .collect();
        let usual = usual_by_position(&shares);
        let falls = lines.iter().zip(&shares).filter_map(|(&index, shares)| {
            let away = shares.iter().map(|&(at, ln)| (at, ln - usual[at]));
            let fall = fall_of(&away.collect::<Vec<_>>())?;
            Some(FallOfLine { axis, index, fall })
        });
        falls.collect()
    }

    /// Of the lines of one axis; `largest`: what any line of either axis falls by.
    fn resisting_lines(&mut self, falls: &[FallOfLine], largest: f64) {
        let mut sizes: Vec<f64> = falls.iter().map(|fall| fall.fall.size).collect();
        let usual = TIMES_USUAL * median(&mut sizes);
        let least = LEAST_FALL.max(usual).max(match self.seen.conductances {
            Some(_) => BESIDE_LARGEST * largest,
            None => 0.0,
        });
        for &FallOfLine { axis, index, fall } in falls {
            let is_clear = fall.size >= least && fall.size >= SIGMAS * fall.standard_error;
            if is_clear
                && !self.is_explained(axis, index)
                && self.is_seen_in_readings(axis, index, fall.split)
            {
                self.add_resisting(axis, index, fall);
            }
        }
    }

    fn add_resisting(&mut self, axis: Axis, index: usize, fall: Fall) {
        let percent = 100.0 * (-fall.size).exp();
        let fault = Fault::LineResists;
        if self.test.options.screen.floating && self.seen.conductances.is_none() {
            let evidence = format!(
                "one end reads {percent:.0} % of what the other does, beside its neighbours; where lines are left open the place cannot be told, nor a break from a crack"
            );
            let taxels = self.line(axis, index);
            self.add(fault, Place::Line { axis, index }, taxels, evidence);
            return;
        }
        let taxels = self.beyond(axis, index, fall.split);
        let how = if fall.is_step {
            "all at once"
        } else {
            "the farther the less"
        };
        let [undone, reads] = match self.seen.conductances {
            Some(_) => ["the circuit undone, ", "conducts"],
            None => ["", "reads"],
        };
        let evidence = format!(
            "{undone}beyond it {reads} {percent:.0} % of what it {reads} before it, beside its neighbours, {how}"
        );
        self.add(fault, place(axis, index, fall.split), taxels, evidence);
    }
}

fn place(axis: Axis, index: usize, Split { after, before }: Split) -> Place {
    Place::Along {
        axis,
        index,
        after,
        before,
    }
}

/// Cross-talk under a strong load may exceed a weak one in some frames: then the sum over all tells.
fn is_silent(answers: &Answers) -> bool {
    answers.silent_share() >= SILENT || answers.given_share() <= SILENT_PART
}

fn is_sound(answers: &Answers) -> bool {
    answers.silent_share() < ANSWERS && answers.given_share() > SILENT_PART
}

/// Where a line breaks: everything judged on one side is silent, up to the end, and everything on the other answers.
fn broken(answers: &[(usize, Answers)]) -> Option<Split> {
    let silent: Vec<bool> = answers
        .iter()
        .map(|(_, answers)| is_silent(answers))
        .collect();
    let sound: Vec<bool> = answers
        .iter()
        .map(|(_, answers)| is_sound(answers))
        .collect();
    let count = answers.len();
    let wrong = |which: &[bool]| which.iter().filter(|is| !**is).count();
    let is_but_for_few = |which: &[bool]| {
        which.len() >= FEWEST && wrong(which) as f64 <= EXCEPTIONS * which.len() as f64
    };
    let splits = FEWEST..(count + 1).saturating_sub(FEWEST);
    let best = splits
        .flat_map(|at| {
            let far_last = (&sound[..at], &silent[at..], (at - 1, at));
            let far_first = (&sound[at..], &silent[..at], (at, at - 1));
            [far_last, far_first]
        })
        .filter(|(near, far, _)| is_but_for_few(near) && is_but_for_few(far))
        .min_by_key(|(near, far, _)| wrong(near) + wrong(far))?;
    let (after, before) = best.2;
    Some(Split {
        after: answers[after].0,
        before: answers[before].0,
    })
}

/// ln of the part of what the lines beside it vouched for that each taxel read.
fn logs(answers: &[(usize, Answers)]) -> Vec<(usize, f64)> {
    let share = |answers: &Answers| answers.given_share().max(1e-3).ln();
    answers
        .iter()
        .map(|(at, answers)| (*at, share(answers)))
        .collect()
}

/// The median over all lines at each position along them; 0 where none was judged.
fn usual_by_position(lines: &[Vec<(usize, f64)>]) -> Vec<f64> {
    let last = lines.iter().flatten().map(|(at, _)| *at).max();
    (0..=last.unwrap_or(0))
        .map(|position| {
            let here = lines.iter().flatten().filter(|(at, _)| *at == position);
            let mut here: Vec<f64> = here.map(|(_, ln)| *ln).collect();
            if here.is_empty() {
                0.0
            } else {
                median(&mut here)
            }
        })
        .collect()
}

/// The step that explains best how a line's readings go along it, with a size above nothing towards whichever end.
fn fall_of(shares: &[(usize, f64)]) -> Option<Fall> {
    if shares.len() < FEWEST_JUDGED {
        return None;
    }
    let mean = |part: &[(usize, f64)]| part.iter().map(|s| s.1).sum::<f64>() / part.len() as f64;
    let squares = |part: &[(usize, f64)]| {
        let middle = mean(part);
        part.iter().map(|s| (s.1 - middle).powi(2)).sum::<f64>()
    };
    let (at, left) = (FEWEST..=shares.len() - FEWEST)
        .map(|at| (at, squares(&shares[..at]) + squares(&shares[at..])))
        .min_by(|a, b| a.1.total_cmp(&b.1))?;
    let (first, last) = (mean(&shares[..at]), mean(&shares[at..]));
    let variance = left / (shares.len() - 2) as f64;
    let (here, there) = (shares[at - 1].0, shares[at].0);
    let (after, before) = if first > last {
        (here, there)
    } else {
        (there, here)
    };
    let points: Vec<(f64, f64)> = shares.iter().map(|&(at, ln)| (at as f64, ln)).collect();
    Some(Fall {
        split: Split { after, before },
        size: (first - last).abs(),
        standard_error: (variance * (1.0 / at as f64 + 1.0 / (shares.len() - at) as f64)).sqrt(),
        is_step: left < CLEARLY_A_STEP * squares_about_a_slope(&points),
    })
}

/// What a straight line leaves, in squares; everything where there is none.
fn squares_about_a_slope(points: &[(f64, f64)]) -> f64 {
    Line::fit(points).map_or(f64::INFINITY, |line| {
        points.iter().map(|&(x, y)| (y - line.at(x)).powi(2)).sum()
    })
}
