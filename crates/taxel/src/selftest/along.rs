//! Lines that break, or resist, somewhere along their length: what answers beyond the place, and what before it.

use super::classify::Classifier;
use super::quiet::median;
use super::response::Answers;
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

impl Classifier<'_> {
    /// Lines that are broken, then those that resist.
    pub(super) fn along_lines(&mut self) {
        for axis in Axis::BOTH {
            let lines = self.rubbed.response.lines(axis);
            for &index in &lines {
                if !self.is_explained(axis, index)
                    && let Some(split) = broken(&self.answers(axis, index))
                {
                    self.add_broken(axis, index, split);
                }
            }
            self.resisting_lines(axis, &lines);
        }
    }

    /// Whether it was found what is wrong along a line.
    pub(super) fn is_known_along(&self, axis: Axis, index: usize) -> bool {
        self.findings.iter().any(|finding| {
            let place = finding.place;
            matches!(place, Place::Along { axis: a, index: i, .. } if (a, i) == (axis, index))
        })
    }

    fn answers(&self, axis: Axis, index: usize) -> Vec<(usize, Answers)> {
        let response = &self.rubbed.response;
        response.answers_along(axis, index, &self.test.options)
    }

    fn add_broken(&mut self, axis: Axis, index: usize, split: Split) {
        let taxels = self.beyond(axis, index, split);
        let evidence = format!(
            "none of the {} taxels beyond responded; those before it did",
            taxels.len()
        );
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

    fn resisting_lines(&mut self, axis: Axis, lines: &[usize]) {
        let shares: Vec<Vec<(usize, f64)>> = lines
            .iter()
            .map(|&index| logs(&self.answers(axis, index)))
            .collect();
        let usual = usual_by_position(&shares);
        let falls: Vec<Option<Fall>> = shares
            .iter()
            .map(|shares| {
                let away = shares.iter().map(|&(at, ln)| (at, ln - usual[at]));
                fall_of(&away.collect::<Vec<_>>())
            })
            .collect();
        let mut sizes: Vec<f64> = falls.iter().flatten().map(|fall| fall.size).collect();
        let least = LEAST_FALL.max(TIMES_USUAL * median(&mut sizes));
        for (&index, fall) in lines.iter().zip(falls) {
            let clear =
                fall.filter(|fall| fall.size >= least && fall.size >= SIGMAS * fall.standard_error);
            if let Some(fall) = clear.filter(|_| !self.is_explained(axis, index)) {
                self.add_resisting(axis, index, fall);
            }
        }
    }

    fn add_resisting(&mut self, axis: Axis, index: usize, fall: Fall) {
        let percent = 100.0 * (-fall.size).exp();
        let fault = Fault::LineResists;
        if self.test.options.screen.floating {
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
        let evidence = format!(
            "beyond it reads {percent:.0} % of what it reads before it, beside its neighbours, {how}"
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
