//! Presses in crowded frames. What else stands there is not known, so that each joins as the conductance which the
//! inverse gives its taxel, with the error that noise has there, and its derivative by the circuit's unknowns.
//!
//! One inverse and one solve with the adjoint tell all three: λ, the taxel's line of J⁻¹, gives σ_G = σ_V |λ| and
//! dG/dθ = −λ · ∂V/∂θ, where ∂V/∂θ is what the readings move by while all conductances stay.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use super::super::evidence::Evidence;
use super::super::inverter::{Inverter, Job, Start};
use super::super::least_squares::median;
use super::super::posterior::Parameter;
use super::known::rounding_of_a_mean;
use super::unknowns::Layout;
use crate::Executor;
use crate::circuit::ROUNDING_COUNTS;
use crate::circuit::{Circuit, Converter, SensorCircuit};
use crate::parallel::par_map;
use crate::stats::quantile;
use crate::uncertainty::{Known, influence_of, is_left_out};
use crate::{Frame, Sensor, Siemens};

/// Frames that one worker takes at a time.
const BATCH: usize = 4;
/// Accuracy of λ, of its norm.
const INFLUENCE: f64 = 1e-2;
/// Conductances of each frame that the unloaded ones are sought among.
const MAX_LOOKED_AT: usize = 256;
/// What light loads may shift the mean of unloaded conductances by, of their standard deviation.
const LEAN: f64 = 0.05;
/// An unloaded conductance is believed to this share at best: taxels differ.
const ALIKE: f64 = 0.01;

/// Crowded presses.
pub(super) struct Crowd<'a> {
    evidence: &'a Evidence,
    which: Vec<usize>,
    executor: &'a dyn Executor,
    noise_counts: f64,
    /// What the mean of however many readings may be off by, because they are whole counts.
    rounding_counts: f64,
    /// Of each press of the evidence, what its last inversion left.
    starts: Mutex<Vec<Option<Start>>>,
}

/// A crowded press about a circuit.
#[derive(Debug, Clone)]
pub(super) struct CrowdedPress {
    /// Its index in the evidence.
    pub(super) press: usize,
    /// What the inverse gives its taxel, and the standard error of that by noise.
    pub(super) siemens: f64,
    pub(super) error: f64,
    /// Its derivative by each unknown of the layout: 0 for those of the law.
    pub(super) slopes: Vec<f64>,
}

/// All crowded presses about a circuit.
#[derive(Debug, Clone)]
pub(super) struct Linear {
    /// The unknowns at which it holds.
    pub(super) at: Vec<f64>,
    pub(super) lines: Vec<CrowdedPress>,
    /// Presses whose frame has no solution there.
    pub(super) failed: usize,
    /// What unloaded taxels conduct, siemens, and the standard error of that.
    pub(super) unloaded: (f64, f64),
}

impl Linear {
    /// Conductance of a press at other unknowns, to first order.
    pub(super) fn siemens(&self, line: &CrowdedPress, at: &[f64]) -> f64 {
        let moved = line.slopes.iter().zip(at.iter().zip(&self.at));
        line.siemens
            + moved
                .map(|(slope, (to, from))| slope * (to - from))
                .sum::<f64>()
    }

    /// The same with the presses for which `keep` holds.
    pub(super) fn with(&self, keep: impl Fn(usize) -> bool) -> Self {
        let kept = self.lines.iter().filter(|line| keep(line.press));
        Self {
            lines: kept.cloned().collect(),
            ..self.clone()
        }
    }

    /// The same among the unknowns of another layout for the same circuit.
    pub(super) fn carried(&self, from: &Layout, to: &Layout) -> Self {
        let slope =
            |line: &CrowdedPress, unknown| from.position(unknown).map_or(0.0, |i| line.slopes[i]);
        let line = |line: &CrowdedPress| CrowdedPress {
            slopes: to.unknowns.iter().map(|&u| slope(line, u)).collect(),
            ..line.clone()
        };
        Self {
            at: to.take_over(from, &self.at),
            lines: self.lines.iter().map(line).collect(),
            ..self.clone()
        }
    }
}

/// A circuit, and the same with one unknown moved by a step.
struct Circuits {
    here: SensorCircuit,
    moved: Vec<Option<(SensorCircuit, f64)>>,
}

impl Circuits {
    fn new(layout: &Layout, at: &[f64], parameters: &[Parameter]) -> Option<Self> {
        let circuit = |at: &[f64]| SensorCircuit::from_sensor(&layout.model(at)?.sensor).ok();
        let one = |(i, unknown): (usize, &super::Unknown)| {
            if !unknown.moves_circuit() {
                return Some(None);
            }
            let mut there = at.to_vec();
            there[i] += parameters[i].step;
            Some(Some((circuit(&there)?, parameters[i].step)))
        };
        let moved = layout.unknowns.iter().enumerate().map(one);
        Some(Self {
            moved: moved.collect::<Option<_>>()?,
            here: circuit(at)?,
        })
    }

    /// The line of a press in a frame whose conductances are these.
    fn line(
        &self,
        press: usize,
        taxel: usize,
        frame: &Frame<Siemens>,
        sigma_volts: f64,
    ) -> Option<CrowdedPress> {
        let siemens = frame.values();
        let is_known: Vec<bool> = frame.marks().iter().map(|m| is_left_out(*m)).collect();
        let mut volts = vec![0.0; siemens.len()];
        let mut there = vec![0.0; siemens.len()];
        let mut point = self.here.operating_point();
        point.set(siemens).ok()?;
        point.predict_into(&mut volts);
        let mut known = Known {
            point: &mut *point,
            is_known: &is_known,
            moved: &mut vec![0.0; siemens.len()],
        };
        let influence = influence_of(&mut known, siemens.len(), taxel, INFLUENCE);
        let mut slopes = Vec::with_capacity(self.moved.len());
        for moved in &self.moved {
            let Some((circuit, step)) = moved else {
                slopes.push(0.0);
                continue;
            };
            let mut point = circuit.operating_point();
            point.set(siemens).ok()?;
            point.predict_into(&mut there);
            let over = influence.iter().zip(there.iter().zip(&volts));
            slopes.push(-over.map(|(l, (to, from))| l * (to - from)).sum::<f64>() / step);
        }
        let norm = influence.iter().map(|l| l * l).sum::<f64>().sqrt();
        let line = CrowdedPress {
            press,
            siemens: siemens[taxel],
            error: sigma_volts * norm,
            slopes,
        };
        let finite = line.error.is_finite() && line.slopes.iter().all(|s| s.is_finite());
        finite.then_some(line)
    }
}

impl<'a> Crowd<'a> {
    pub(super) fn new(evidence: &'a Evidence, which: &[usize], executor: &'a dyn Executor) -> Self {
        Self {
            evidence,
            which: which.to_vec(),
            executor,
            noise_counts: evidence.noise_counts.hypot(ROUNDING_COUNTS),
            rounding_counts: rounding_of_a_mean(evidence.noise_counts),
            starts: Mutex::new(evidence.presses.iter().map(|_| None).collect()),
        }
    }

    /// Starts its inversions where another's ended, if any have.
    pub(super) fn near(self, ends: &[Option<Vec<f64>>]) -> Self {
        let mut starts = self.starts;
        let all = starts.get_mut().unwrap_or_else(PoisonError::into_inner);
        for (start, end) in all.iter_mut().zip(ends) {
            *start = end.clone().map(Start::Siemens);
        }
        Self { starts, ..self }
    }

    /// Where its inversions ended, of each press of the evidence.
    pub(super) fn ends(&self) -> Vec<Option<Vec<f64>>> {
        let starts = self.starts.lock().unwrap_or_else(PoisonError::into_inner);
        let end = |start: &Option<Start>| Some(start.as_ref()?.siemens()?.to_vec());
        starts.iter().map(end).collect()
    }

    /// The same with at most so many presses, evenly chosen.
    pub(super) fn thinned(&self, most: usize) -> Self {
        let stride = self.which.len().div_ceil(most).max(1);
        let which: Vec<usize> = self.which.iter().copied().step_by(stride).collect();
        Self::new(self.evidence, &which, self.executor).near(&self.ends())
    }

    /// Whether a press of the evidence is one of its own.
    pub(super) fn has(&self, press: usize) -> bool {
        self.which.binary_search(&press).is_ok()
    }

    pub(super) fn label_g(&self, line: &CrowdedPress) -> f64 {
        self.evidence.presses[line.press].load_g
    }

    /// Labels of all its presses, grams.
    pub(super) fn loads_g(&self) -> Vec<f64> {
        let loads = self.which.iter().map(|&p| self.evidence.presses[p].load_g);
        loads.collect()
    }

    /// Every press about a point of a layout. Nothing where the point is impossible, or leaves more than a fifth of the
    /// frames without a solution.
    pub(super) fn linear(&self, layout: &Layout, at: &[f64]) -> Option<Linear> {
        let parameters = layout.parameters_at(at);
        let circuits = Circuits::new(layout, at, &parameters)?;
        let sensor = layout.model(at)?.sensor;
        let sigma_volts = self.noise_counts * Converter::from_sensor(&sensor).lsb_volts();
        let look = |p: usize, siemens: &Frame<Siemens>| {
            let press = &self.evidence.presses[p];
            let taxel = press.row * sensor.columns() + press.column;
            let line = circuits.line(p, taxel, siemens, sigma_volts)?;
            let stride = siemens.taxels().div_ceil(MAX_LOOKED_AT);
            let pairs = siemens.values().iter().zip(siemens.marks());
            let unknown = pairs.filter(|(_, mark)| !is_left_out(**mark));
            let some: Vec<f64> = unknown.map(|(g, _)| *g).step_by(stride).collect();
            Some((line, some))
        };
        let seen = self.inverted(&sensor, self.which.len() / 5, look)?;
        let (mut lines, mut conductances) = (Vec::new(), Vec::new());
        for (line, some) in seen.into_iter().flatten() {
            lines.push(line);
            conductances.extend(some);
        }
        let failed = self.which.len() - lines.len();
        let noise = median(&lines.iter().map(|l| l.error).collect::<Vec<f64>>());
        let rounding = self.rounding_counts * noise / self.noise_counts;
        let (g_zero, error) = unloaded(conductances, noise);
        Some(Linear {
            unloaded: (g_zero, error.hypot(rounding)),
            at: at.to_vec(),
            lines,
            failed,
        })
    }

    /// What each press's taxel conducts with a sensor's circuit; nothing where its frame has no solution.
    pub(super) fn siemens(&self, sensor: &Sensor) -> Vec<Option<f64>> {
        let look = |p: usize, siemens: &Frame<Siemens>| {
            let press = &self.evidence.presses[p];
            Some(siemens.at(press.row, press.column))
        };
        let all = self.inverted(sensor, self.which.len(), look);
        all.unwrap_or_else(|| vec![None; self.which.len()])
    }

    /// What is seen in the conductances of each press's frame; nothing of those without a solution, and nothing at all
    /// where more have none than may: the others need no look then.
    fn inverted<T: Send>(
        &self,
        sensor: &Sensor,
        most_failed: usize,
        look: impl Fn(usize, &Frame<Siemens>) -> Option<T> + Sync,
    ) -> Option<Vec<Option<T>>> {
        let inverter = Inverter::new(self.evidence, sensor)?;
        let failed = AtomicUsize::new(0);
        let batches: Vec<Vec<Job>> = self.which.chunks(BATCH).map(|b| self.jobs(b)).collect();
        let done = par_map(self.executor, batches, |mut batch| {
            let seen: Vec<Option<T>> = inverter
                .invert_each(&mut batch, &look)
                .into_iter()
                .map(Option::flatten)
                .collect();
            let without = seen.iter().filter(|seen| seen.is_none()).count();
            let all = without + failed.fetch_add(without, Ordering::Relaxed);
            (all <= most_failed).then_some((seen, batch))
        })?;
        let mut all = Vec::with_capacity(self.which.len());
        for (seen, batch) in done {
            self.keep(batch);
            all.extend(seen);
        }
        Some(all)
    }

    fn jobs(&self, which: &[usize]) -> Vec<Job> {
        let mut starts = self.starts.lock().unwrap_or_else(PoisonError::into_inner);
        let mut start = |p: usize| match &starts[p] {
            // It stays: where too many fail, nothing comes back.
            Some(Start::Siemens(siemens)) => Some(Start::Siemens(siemens.clone())),
            _ => starts[p].take(),
        };
        which.iter().copied().map(|p| (p, start(p))).collect()
    }

    fn keep(&self, jobs: Vec<Job>) {
        let mut starts = self.starts.lock().unwrap_or_else(PoisonError::into_inner);
        for (p, start) in jobs {
            starts[p] = start;
        }
    }
}

/// The conductance about which most lie, and its standard error: that of unloaded taxels, wherever they are. Found from
/// below, where no load reaches; `noise` is the least that they scatter by, else one of a few whole counts is all.
fn unloaded(mut siemens: Vec<f64>, noise: f64) -> (f64, f64) {
    siemens.retain(|g| g.is_finite());
    siemens.sort_by(f64::total_cmp);
    let mut centre = quantile(siemens.iter().copied(), 0.2).unwrap_or(0.0);
    let (mut deviation, mut near) = (0.0, 1);
    for _ in 0..100 {
        let below = siemens.partition_point(|g| *g < centre);
        let squares = siemens[..below].iter().map(|g| (g - centre).powi(2));
        deviation = (squares.sum::<f64>() / below.max(1) as f64)
            .sqrt()
            .max(noise);
        let from = siemens.partition_point(|g| *g < centre - 2.5 * deviation);
        let to = siemens.partition_point(|g| *g <= centre + 2.5 * deviation);
        if from >= to {
            break;
        }
        near = to - from;
        // Not the median: of whole counts that is one of a few.
        let mean = siemens[from..to].iter().sum::<f64>() / near as f64;
        if (mean - centre).abs() <= 1e-6 * deviation {
            break;
        }
        centre = mean;
    }
    // Loads too light to be told from noise lean on the mean from above, however many there are.
    let lean = LEAN * deviation;
    let error = (deviation / (near as f64).sqrt()).hypot(lean);
    (centre, error.hypot(ALIKE * centre).max(1e-15))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn most_of_a_frame_is_unloaded_though_much_of_it_is_not() {
        let noise =
            |i: usize| f64::from((i as u32).wrapping_mul(2_654_435_761) >> 8) / 2f64.powi(24) - 0.5;
        let siemens: Vec<f64> = (0..4000)
            .map(|i| {
                1e-6 + 1e-5 * noise(i)
                    + if i % 5 < 2 {
                        1e-4 * f64::from((i % 97) as u32) / 97.0
                    } else {
                        0.0
                    }
            })
            .collect();
        let (centre, error) = unloaded(siemens, 0.0);
        assert!((centre - 1e-6).abs() < 1.5 * error, "{centre} ± {error}");
        assert!(error < 1e-6, "{error}");
        assert!((unloaded(vec![2e-6; 50], 0.0).0 - 2e-6).abs() < 1e-18);
        // Noise that rounds to no count, now and then to one, seldom to two.
        let few: Vec<f64> = (0..1000)
            .map(|i| 1e-6 * f64::from(u8::from(i % 5 == 0)))
            .collect();
        assert!((unloaded(few, 4e-7).0 - 2e-7).abs() < 1e-9);
        assert_eq!(unloaded(Vec::new(), 0.0).0, 0.0);
    }
}
