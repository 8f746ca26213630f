//! What several frames amount to, taxel by taxel: their mean, or the highest of each.

use taxel::{Frame, Mark};

use super::Job;
use super::collect::{Pass, each};
use super::draw::{COMPENSATED, RAW, is_lost};
use crate::error::Error;
use taxel_app::frames::DisplayUnit;

/// Sums, or the highest so far, of the frames of one stage.
struct Over {
    values: Frame<DisplayUnit>,
    counted: Vec<u32>,
    is_peak: bool,
}

impl Over {
    fn new(frame: &Frame<DisplayUnit>, is_peak: bool) -> Self {
        let mut values = Frame::zeros(frame.rows(), frame.columns());
        if is_peak {
            values.values_mut().fill(f64::NEG_INFINITY);
        }
        Self {
            counted: vec![0; frame.values().len()],
            values,
            is_peak,
        }
    }

    fn add(&mut self, frame: &Frame<DisplayUnit>) {
        let readings = frame.values().iter().zip(frame.marks());
        for (taxel, (&value, &mark)) in readings.enumerate() {
            // A frame without an answer has numbers, and says nothing.
            if is_lost(mark) || mark == Mark::Unresolved || !value.is_finite() {
                // Marked as it was, unless some frame knows more.
                if self.counted[taxel] == 0 {
                    self.values.marks_mut()[taxel] = mark;
                }
                continue;
            }
            let so_far = &mut self.values.values_mut()[taxel];
            *so_far = if self.is_peak {
                so_far.max(value)
            } else {
                *so_far + value
            };
            self.counted[taxel] += 1;
            let told = &mut self.values.marks_mut()[taxel];
            // What was a bound in one frame bounds what all amount to.
            if *told != Mark::Saturated {
                *told = mark;
            }
        }
    }

    fn finish(mut self) -> Frame<DisplayUnit> {
        for (value, &counted) in self.values.values_mut().iter_mut().zip(&self.counted) {
            if counted == 0 {
                *value = f64::NAN;
            } else if !self.is_peak {
                *value /= f64::from(counted);
            }
        }
        self.values
    }
}

/// The one map of each stage, with its title.
pub(super) fn maps(job: &Job<'_>) -> Result<Vec<(String, Frame<DisplayUnit>)>, Error> {
    let is_peak = job.args.peak;
    let mut stages: [Option<Over>; 2] = [None, None];
    let (mut first, mut last) = (None, 0);
    let seen = each(job, Pass::First, |number, now| {
        first.get_or_insert(number);
        last = number;
        for (over, frame) in stages.iter_mut().zip([now.raw, now.compensated]) {
            if let Some(frame) = frame {
                over.get_or_insert_with(|| Over::new(frame, is_peak))
                    .add(frame);
            }
        }
        Ok(())
    })?;
    let what = if is_peak {
        "highest of each taxel"
    } else {
        "mean of each taxel"
    };
    let range = format!("{what}, {seen} frames, {} to {last}", first.unwrap_or(0));
    let both = stages.iter().all(Option::is_some);
    let named = stages.into_iter().zip([RAW, COMPENSATED]);
    Ok(named
        .filter_map(|(over, word)| {
            let title = if both && !job.args.values {
                format!("{range}, {word}")
            } else {
                range.clone()
            };
            Some((title, over?.finish()))
        })
        .collect())
}
