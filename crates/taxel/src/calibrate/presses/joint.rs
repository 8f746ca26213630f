//! The most probable circuit and law for presses in crowded frames, with those made one at a time where there are some.
//!
//! A Gauss–Newton iteration of two levels: conductances that the inverse gives are taken as linear in the circuit's
//! unknowns about a point, the most probable point is found with that, and they are computed anew there.

use super::super::least_squares::{robust_deviation, weights};
use super::super::posterior::{HUBER, Peak, most_probable, prior_loss};
use super::crowd::{Crowd, CrowdedPress, Linear};
use super::fit::{Fitted, Readings, STARTS_OHMS, law_at, least_share, plain_law};
use super::unknowns::{Layout, Unknown};
use crate::material::LoadLaw;

/// Times that everything is made linear anew: on the way, and where a start is judged.
const MAX_ITERATIONS: usize = 10;
const START_ITERATIONS: usize = 3;
/// Presses that a start is judged by.
const START_PRESSES: usize = 24;
/// How far a circuit's unknown (a logarithm) is let go from where it was made linear.
const TRUST: f64 = 0.5;
/// Part of a standard error that a step may be off by, and gain of the loss, that end the search.
const SETTLED: f64 = 0.02;
/// What lines may resist a pitch where a search for that begins, ohms.
const STARTS_LINE_OHMS: [f64; 4] = [0.4, 2.0, 8.0, 30.0];
/// What a frame without a solution counts for, beyond what the others do.
const FAILED: f64 = 9.0;

/// Everything that is fitted to.
pub(super) struct Joint<'a> {
    pub(super) readings: &'a Readings<'a>,
    pub(super) crowd: &'a Crowd<'a>,
}

impl Joint<'_> {
    /// The most probable model of a layout, from where the crowd is linear, and where it is linear then.
    pub(super) fn fit(
        &self,
        layout: &Layout,
        linear: Linear,
        share: f64,
    ) -> Option<(Fitted, Linear)> {
        let (linear, share) = self.settle(layout, linear, share, MAX_ITERATIONS)?;
        Some((self.finish(layout, &linear, share)?, linear))
    }

    /// The crowd about the best of several starts.
    pub(super) fn start(&self, layout: &Layout) -> Option<Linear> {
        let few = self
            .crowd
            .thinned(START_PRESSES.min(self.crowd.loads_g().len() / 2));
        let rough = Joint {
            readings: self.readings,
            crowd: &few,
        };
        let believed = layout.beliefs.ln_sum().0.exp();
        let mut best: Option<(f64, Vec<f64>)> = None;
        let sums = std::iter::once(believed).chain(STARTS_OHMS);
        let starts: Vec<(f64, f64)> = match layout.position(Unknown::LineRow) {
            None => sums.map(|sum| (sum, 0.0)).collect(),
            // What lines resist moves frames more than switches do.
            Some(_) => STARTS_LINE_OHMS.map(|line| (believed, line)).to_vec(),
        };
        for start in starts {
            let settled = rough
                .begin(layout, start)
                .and_then(|linear| rough.settle(layout, linear, 0.0, START_ITERATIONS));
            let Some((linear, share)) = settled else {
                continue;
            };
            let loss = rough.loss(layout, &linear, share)?;
            if best.as_ref().is_none_or(|b| loss < b.0) {
                best = Some((loss, linear.at));
            }
            // Where noise explains all that is left, no other start can say more; but of lines that resist much too little, noise
            // makes so much of conductances that it explains anything.
            if share == 0.0 && layout.position(Unknown::LineRow).is_none() {
                break;
            }
        }
        self.crowd.linear(layout, &best?.1)
    }

    /// The crowd about the first sum of the switches that leaves it solutions.
    pub(super) fn first(&self, layout: &Layout) -> Option<Linear> {
        let believed = layout.beliefs.ln_sum().0.exp();
        let mut starts = std::iter::once(believed).chain(STARTS_OHMS);
        starts.find_map(|sum_ohms| self.begin(layout, (sum_ohms, STARTS_LINE_OHMS[0])))
    }

    /// The crowd about a sum of the switches and a resistance of the lines, with the power law that suits it.
    fn begin(&self, layout: &Layout, (sum_ohms, line_ohms): (f64, f64)) -> Option<Linear> {
        let mut start: Vec<f64> = layout
            .parameters(sum_ohms, -13.0, layout.beliefs.exponent.0)
            .iter()
            .map(|p| p.start)
            .collect();
        for unknown in [Unknown::LineRow, Unknown::LineColumn] {
            if let Some(i) = layout.position(unknown) {
                start[i] = line_ohms.ln();
            }
        }
        let mut linear = self.crowd.linear(layout, &start)?;
        let pairs: Vec<(f64, f64)> = self
            .pairs(&linear)
            .into_iter()
            .map(|p| (p.1, p.2))
            .collect();
        let (scale, exponent) = law_at(&pairs, 0.0, layout);
        for (unknown, value) in [
            (Unknown::Scale, scale),
            (Unknown::Exponent, exponent),
            (Unknown::GZero, linear.unloaded.0.max(1e-12).ln()),
        ] {
            if let Some(i) = layout.position(unknown) {
                linear.at[i] = value;
            }
        }
        Some(linear)
    }

    /// Press, label and conductance over an unloaded taxel's of all that are above it.
    pub(super) fn pairs(&self, linear: &Linear) -> Vec<(usize, f64, f64)> {
        let lines = linear.lines.iter();
        lines
            .map(|l| {
                (
                    l.press,
                    self.crowd.label_g(l),
                    l.siemens - linear.unloaded.0,
                )
            })
            .filter(|p| p.1 > 0.0 && p.2 > 0.0)
            .collect()
    }

    /// Goes on from where the crowd is linear until it no longer moves. With it, the share of a reading that the model
    /// is off by.
    fn settle(
        &self,
        layout: &Layout,
        mut linear: Linear,
        mut share: f64,
        iterations: usize,
    ) -> Option<(Linear, f64)> {
        for _ in 0..iterations {
            let peak = self.peak(layout, &linear, share, Some(TRUST))?;
            if self.alone() == 0 {
                share = self.share(layout, &linear, &peak.at)?;
            }
            if self.is_near(layout, &linear, &peak) {
                break;
            }
            let before = self.loss(layout, &linear, share)?;
            let mut to = peak.at.clone();
            let mut next = None;
            for _ in 0..4 {
                next = self.crowd.linear(layout, &to).filter(|next| {
                    self.loss(layout, next, share)
                        .is_some_and(|l| l <= before + SETTLED)
                });
                if next.is_some() {
                    break;
                }
                for (to, from) in to.iter_mut().zip(&linear.at) {
                    *to = 0.5 * (*to + from);
                }
            }
            let Some(next) = next else { break };
            linear = next;
        }
        Some((linear, share))
    }

    /// Whether what a line misses from its middle to the peak, the square of a small logarithm, is little beside the
    /// peak's standard errors.
    fn is_near(&self, layout: &Layout, linear: &Linear, peak: &Peak) -> bool {
        let mut moves = (0..peak.at.len()).filter(|&i| layout.unknowns[i].moves_circuit());
        moves.all(|i| (peak.at[i] - linear.at[i]).powi(2) < SETTLED * peak.error(i))
    }

    fn finish(&self, layout: &Layout, linear: &Linear, share: f64) -> Option<Fitted> {
        let peak = self.peak(layout, linear, share, None)?;
        let law = self.law(layout, &linear.at)?;
        let errors = linear.lines.iter();
        let spread = errors.map(|l| 2.0 * self.error(&law, linear, l, share).ln());
        Some(Fitted {
            loss: peak.loss() + spread.sum::<f64>() + FAILED * linear.failed as f64,
            model: layout.model(&peak.at)?,
            layout: layout.clone(),
            share,
            peak,
        })
    }

    /// Presses made one at a time.
    fn alone(&self) -> usize {
        self.readings.known.frames.len()
    }

    fn law(&self, layout: &Layout, at: &[f64]) -> Option<LoadLaw> {
        Some(plain_law(&layout.model(at)?))
    }

    /// Standard deviation of a press's conductance about what its label makes it: of noise, and of a share of the label.
    fn error(&self, law: &LoadLaw, linear: &Linear, line: &CrowdedPress, share: f64) -> f64 {
        let pressed = law.siemens_from_grams(0, self.crowd.label_g(line)) - linear.unloaded.0;
        line.error.hypot(share * pressed)
    }

    /// Residuals of the crowd in standard deviations. Errors are those at the point where it is linear.
    fn residuals(
        &self,
        layout: &Layout,
        linear: &Linear,
        share: f64,
        at: &[f64],
    ) -> Option<Vec<f64>> {
        let (law, here) = (self.law(layout, at)?, self.law(layout, &linear.at)?);
        let mut all: Vec<f64> = linear
            .lines
            .iter()
            .map(|line| {
                let wanted = law.siemens_from_grams(0, self.crowd.label_g(line));
                (linear.siemens(line, at) - wanted) / self.error(&here, linear, line, share)
            })
            .collect();
        let (unloaded, error) = linear.unloaded;
        all.push((law.g_zero - unloaded) / error);
        all.iter().all(|r| r.is_finite()).then_some(all)
    }

    /// The most probable point while the crowd is linear; `trust` keeps it near.
    fn peak(
        &self,
        layout: &Layout,
        linear: &Linear,
        share: f64,
        trust: Option<f64>,
    ) -> Option<Peak> {
        most_probable(&layout.parameters_at(&linear.at), |at| {
            let mut all = self.residuals(layout, linear, share, at)?;
            if self.alone() > 0 {
                all.extend(self.readings.residuals(&layout.model(at)?, share)?);
            }
            if let Some(trust) = trust {
                let moves = (0..at.len()).filter(|&i| layout.unknowns[i].moves_circuit());
                all.extend(moves.map(|i| (at[i] - linear.at[i]) / trust));
            }
            Some(all)
        })
    }

    /// Minus twice the logarithm of the posterior where the crowd is linear.
    fn loss(&self, layout: &Layout, linear: &Linear, share: f64) -> Option<f64> {
        let at = &linear.at;
        let mut all = self.residuals(layout, linear, share, at)?;
        let law = self.law(layout, at)?;
        let errors = linear.lines.iter();
        let spread: f64 = errors
            .map(|l| 2.0 * self.error(&law, linear, l, share).ln())
            .sum();
        let lines = linear.lines.len().max(1) as f64;
        // Frames without a solution count as the others do, and for being so.
        let missing = (lines + linear.failed as f64) / lines;
        if self.alone() > 0 {
            all.extend(self.readings.residuals(&layout.model(at)?, share)?);
        }
        let prior = prior_loss(&layout.parameters_at(at), at);
        Some(weights(&all, HUBER).1 + prior + spread * missing + FAILED * linear.failed as f64)
    }

    /// The share of a label's conductance that makes the crowd's residuals as large as they should be; 0 where noise does.
    fn share(&self, layout: &Layout, linear: &Linear, at: &[f64]) -> Option<f64> {
        let presses = linear.lines.len();
        let freedom =
            presses.saturating_sub(layout.unknowns.len()).max(1) as f64 / presses.max(1) as f64;
        let size = |share: f64| -> Option<f64> {
            let all = self.residuals(layout, linear, share, at)?;
            Some(robust_deviation(&all[..presses]) / freedom.sqrt())
        };
        least_share(size)
    }
}
