//! The most probable law and gain of every taxel behind readings under uniform loads, through a circuit that is known.
//!
//! G_lt = g_zero + gain_t · f(L_l), and every frame is scanned by the whole circuit: what readings of neighbours tell of a taxel and what
//! they do not comes out by itself. Gauss's and Newton's steps by conjugate gradients on J, which is never written down.

use taxel_linalg::dot;

use super::fitted::{Fitted, LAW, gather, spread};
use super::levels::Level;
use super::lines::{STEP, Switches, WITHIN};
use crate::Sensor;
use crate::circuit::{Circuit, OperatingPoint, SensorCircuit};
use crate::stats;

/// What taxels are believed to differ by, a share of the gain.
pub(super) const GAIN: f64 = 0.3;
/// What is believed of the exponent, and of 1/saturation, per kilogram.
const EXPONENT: (f64, f64) = (0.85, 0.2);
const SATURATION: f64 = 2.0;
/// Standard deviation of ln g_zero about what the lightest load reads.
const G_ZERO: f64 = 1.1;
/// Standard deviation of ln scale: nothing is believed of it.
const SCALE: f64 = 10.0;
/// Readings farther off than so many times the median are none of the load.
const FAR: f64 = 15.0;
const STEPS: usize = 25;
const HALVINGS: usize = 12;
/// Steps of the first turn that find the derivative by the switches anew; later turns do so once.
const FRESH: usize = 3;
/// Rounds in which what is left over tells the size of the errors.
const TURNS: usize = 8;
/// They end when that shrinks by less than this share.
const STEADY: f64 = 0.03;
const GRADIENTS: usize = 100;
const GRADIENT_ACCURACY: f64 = 1e-4;
/// Steps that change the loss by a smaller share are none.
const SETTLED: f64 = 1e-6;

/// Readings to be fitted, and the circuit that makes them.
pub(super) struct Fit<'a> {
    sensor: &'a Sensor,
    levels: Vec<&'a Level>,
    points: Vec<Box<dyn OperatingPoint>>,
    least_sigma_volts: f64,
    prior: Vec<(f64, f64)>,
    residuals: Vec<Vec<f64>>,
    /// Readings that take part.
    is_used: Vec<Vec<bool>>,
    work: [Vec<f64>; 2],
    switches: Switches,
    /// Whether the saturation stays at none in this step.
    is_pinned: bool,
    /// By each switch, under each load: volts of every taxel per unit of ln R.
    by_switch: Vec<Vec<f64>>,
}

impl<'a> Fit<'a> {
    pub(super) fn new(sensor: &'a Sensor, levels: Vec<&'a Level>, least_sigma_volts: f64) -> Self {
        let taxels = sensor.rows() * sensor.columns();
        let none = || vec![0.0; taxels];
        Self {
            sensor,
            switches: Switches::of(sensor, levels.len()),
            is_pinned: false,
            by_switch: levels.iter().map(|_| Vec::new()).collect(),
            points: Vec::new(),
            is_used: levels.iter().map(|level| level.is_good.clone()).collect(),
            residuals: levels.iter().map(|_| none()).collect(),
            levels,
            least_sigma_volts,
            prior: Vec::new(),
            work: [none(), none()],
        }
    }

    /// The most probable law, with or without a saturation. `apparent`: load and conductance that uniform arrays with these mean
    /// readings have. Nothing where no step leads anywhere.
    pub(super) fn run(&mut self, apparent: &[(f64, f64)], saturates: bool) -> Option<Fitted> {
        let mut fitted = self.start(apparent, saturates)?;
        let mut loss = self.evaluate(&fitted)?;
        for turn in 0..TURNS {
            for step in 0..STEPS {
                if step == 0 || (turn == 0 && step < FRESH) {
                    self.find_by_switch(&fitted)?;
                }
                let before = loss;
                loss = self.step(&mut fitted, loss)?;
                if before - loss <= SETTLED * before.abs().max(1.0) {
                    break;
                }
            }
            fitted.left_out = self.leave_out();
            let left = self.left_over().max(self.least_sigma_volts);
            let is_steady = left > (1.0 - STEADY) * fitted.sigma_volts;
            fitted.sigma_volts = left;
            if is_steady {
                break;
            }
            loss = self.evaluate(&fitted)?;
        }
        for number in 0..LAW {
            fitted.law_errors[number] = self.error_of(&fitted, number);
        }
        Some(fitted)
    }

    /// A power law through the apparent conductances, alike for all taxels.
    fn start(&mut self, apparent: &[(f64, f64)], saturates: bool) -> Option<Fitted> {
        let loaded = || apparent.iter().filter(|(load, _)| *load > 0.0);
        let count = loaded().count() as f64;
        let ln_reference = loaded().map(|(load, _)| load.ln()).sum::<f64>() / count;
        let least = apparent.iter().map(|a| a.1).fold(f64::INFINITY, f64::min);
        // Most of what the lightest load reads is none, where nothing was unloaded.
        let has_empty = apparent.iter().any(|(load, _)| *load == 0.0);
        let g_zero = if has_empty { least } else { 0.1 * least };
        let ln = |g: f64| (g - g_zero).max(0.02 * g).ln();
        let scale = loaded().map(|(_, g)| ln(*g)).sum::<f64>() / count;
        let (mut xx, mut xy) = (0.0, 0.0);
        for (load, g) in loaded() {
            let x = load.ln() - ln_reference;
            xx += x * x;
            xy += x * (ln(*g) - scale);
        }
        let exponent = if xx > 0.0 {
            (xy / xx).clamp(0.2, 2.0)
        } else {
            EXPONENT.0
        };
        let taxels = self.sensor.rows() * self.sensor.columns();
        let mut at = vec![scale, exponent, g_zero.ln(), 0.0];
        let saturation = if saturates { SATURATION } else { 0.0 };
        self.prior = vec![
            (scale, SCALE),
            EXPONENT,
            (g_zero.ln(), G_ZERO),
            (0.0, saturation),
        ];
        self.prior.extend(std::iter::repeat_n((0.0, GAIN), taxels));
        self.prior
            .extend(std::iter::repeat_n((0.0, WITHIN), self.switches.count()));
        at.resize(LAW + taxels + self.switches.count(), 0.0);
        at.iter()
            .all(|x| x.is_finite())
            .then_some(Fitted {
                at,
                law_errors: [0.0; LAW],
                sigma_volts: f64::INFINITY,
                left_out: 0,
                ln_reference,
                saturates,
                taxels,
                switches: self.switches,
            })
            .map(|mut fitted| {
                // Before anything is fitted, all that is left over is error.
                self.evaluate(&fitted);
                fitted.sigma_volts = self.left_over().max(self.least_sigma_volts);
                fitted
            })
    }

    /// Scans every level and leaves what is measured beyond it; minus the logarithm of the posterior. Nothing where a network has
    /// no solution.
    fn evaluate(&mut self, fitted: &Fitted) -> Option<f64> {
        let mut sum = 0.0;
        if self.points.is_empty() || self.switches.count() > 0 {
            let circuit = SensorCircuit::from_sensor(&fitted.sensor(self.sensor)).ok()?;
            self.points.clear();
            let points = self.levels.iter().map(|_| circuit.operating_point());
            self.points.extend(points);
        }
        let readings = self.residuals.iter_mut().zip(&self.is_used);
        for ((level, point), (residuals, is_used)) in
            (self.levels.iter().zip(&mut self.points)).zip(readings)
        {
            let siemens = fitted.siemens(level);
            point.set(&siemens).ok()?;
            point.predict_into(residuals);
            let read = residuals.iter_mut().zip(&level.volts).zip(is_used);
            for ((residual, volts), is_used) in read {
                *residual = if *is_used { volts - *residual } else { 0.0 };
                sum += (*residual / fitted.sigma_volts).powi(2);
            }
        }
        let believed = fitted.at.iter().zip(&self.prior);
        let believed = believed.filter(|(_, (_, deviation))| *deviation > 0.0);
        let off = believed.map(|(x, (mean, deviation))| ((x - mean) / deviation).powi(2));
        let loss = 0.5 * (sum + off.sum::<f64>());
        loss.is_finite().then_some(loss)
    }

    /// The derivative of every reading by every switch, by differences.
    fn find_by_switch(&mut self, fitted: &Fitted) -> Option<()> {
        let taxels = fitted.taxels;
        let circuit = |ln: &[f64]| {
            let moved = self.switches.applied(self.sensor, ln);
            let circuit = SensorCircuit::from_sensor(&moved).ok()?;
            Some(circuit.operating_point())
        };
        let mut here = circuit(fitted.lines())?;
        let mut volts = vec![0.0; taxels];
        for (by_switch, level) in self.by_switch.iter_mut().zip(&self.levels) {
            by_switch.resize(taxels * self.switches.count(), 0.0);
            let siemens = fitted.siemens(level);
            here.set(&siemens).ok()?;
            here.predict_into(&mut volts);
            for column in by_switch.chunks_exact_mut(taxels) {
                for (by, volts) in column.iter_mut().zip(&volts) {
                    *by = -volts / STEP;
                }
            }
        }
        let mut ln = fitted.lines().to_vec();
        for switch in 0..ln.len() {
            ln[switch] += STEP;
            let mut there = circuit(&ln)?;
            ln[switch] -= STEP;
            for (by_switch, level) in self.by_switch.iter_mut().zip(&self.levels) {
                there.set(&fitted.siemens(level)).ok()?;
                there.predict_into(&mut volts);
                let column = &mut by_switch[switch * taxels..(switch + 1) * taxels];
                for (by, volts) in column.iter_mut().zip(&volts) {
                    *by += volts / STEP;
                }
            }
        }
        Some(())
    }

    /// Root mean square of what is left of readings, volts.
    fn left_over(&self) -> f64 {
        let (mut sum, mut count) = (0.0, 0.0);
        for (is_used, residuals) in self.is_used.iter().zip(&self.residuals) {
            sum += residuals.iter().map(|r| r * r).sum::<f64>();
            count += is_used.iter().filter(|used| **used).count() as f64;
        }
        f64::sqrt(sum / f64::max(count, 1.0))
    }

    /// Leaves out readings that are far from the others' spread: stuck, spikes. How many.
    fn leave_out(&mut self) -> usize {
        let all = self
            .residuals
            .iter()
            .zip(&self.is_used)
            .flat_map(|(residuals, is_used)| {
                let used = residuals.iter().zip(is_used).filter(|(_, used)| **used);
                used.map(|(residual, _)| residual.abs())
            });
        let usual = stats::median(all)
            .unwrap_or(0.0)
            .max(self.least_sigma_volts);
        let mut count = 0;
        for (is_used, residuals) in self.is_used.iter_mut().zip(&mut self.residuals) {
            for (is_used, residual) in is_used.iter_mut().zip(residuals) {
                if *is_used && residual.abs() > FAR * usual {
                    (*is_used, *residual) = (false, 0.0);
                }
            }
        }
        for (is_used, level) in self.is_used.iter().zip(&self.levels) {
            let out = is_used.iter().zip(&level.is_good);
            count += out.filter(|(used, good)| **good && !**used).count();
        }
        count
    }

    /// One step, shortened until the loss falls; the loss after it.
    fn step(&mut self, fitted: &mut Fitted, loss: f64) -> Option<f64> {
        let gradient = self.gradient(fitted);
        let step = self.solve(fitted, &gradient);
        let before = fitted.at.clone();
        let mut length = 1.0;
        for _ in 0..HALVINGS {
            for (x, (before, step)) in fitted.at.iter_mut().zip(before.iter().zip(&step)) {
                *x = before + length * step;
            }
            fitted.at[3] = fitted.at[3].max(0.0);
            if let Some(now) = self.evaluate(fitted)
                && now < loss
            {
                return Some(now);
            }
            length *= 0.5;
        }
        fitted.at = before;
        self.evaluate(fitted)
    }

    /// Where the posterior rises.
    fn gradient(&mut self, fitted: &Fitted) -> Vec<f64> {
        let mut gradient: Vec<f64> = (fitted.at.iter().zip(&self.prior))
            .map(|(x, (mean, deviation))| {
                if *deviation > 0.0 {
                    (mean - x) / (deviation * deviation)
                } else {
                    0.0
                }
            })
            .collect();
        let weight = fitted.sigma_volts.powi(-2);
        for l in 0..self.levels.len() {
            let [by_siemens, _] = &mut self.work;
            self.points[l].vjp_into(&self.residuals[l], by_siemens);
            gather(fitted, self.levels[l], by_siemens, weight, &mut gradient);
            let lines = &mut gradient[LAW + fitted.taxels..];
            let by_switch = self.by_switch[l].chunks_exact(fitted.taxels);
            for (out, column) in lines.iter_mut().zip(by_switch) {
                *out += weight * dot(column, &self.residuals[l]);
            }
        }
        // No saturation at all is an end of its range.
        self.is_pinned = fitted.at[3] == 0.0 && gradient[3] <= 0.0;
        self.hold(fitted, &mut gradient);
        gradient
    }

    /// The curvature of the loss along a direction.
    fn curve(&mut self, fitted: &Fitted, along: &[f64]) -> Vec<f64> {
        let mut out: Vec<f64> = (along.iter().zip(&self.prior))
            .map(|(x, (_, deviation))| {
                if *deviation > 0.0 {
                    x / (deviation * deviation)
                } else {
                    0.0
                }
            })
            .collect();
        let weight = fitted.sigma_volts.powi(-2);
        for l in 0..self.levels.len() {
            let level = self.levels[l];
            let [siemens, volts] = &mut self.work;
            spread(fitted, level, along, siemens);
            self.points[l].jvp_into(siemens, volts);
            let by_switch = || self.by_switch[l].chunks_exact(fitted.taxels);
            for (moved, column) in along[LAW + fitted.taxels..].iter().zip(by_switch()) {
                for (volts, by) in volts.iter_mut().zip(column) {
                    *volts += moved * by;
                }
            }
            for (volts, is_used) in volts.iter_mut().zip(&self.is_used[l]) {
                *volts = if *is_used { *volts } else { 0.0 };
            }
            let lines = &mut out[LAW + fitted.taxels..];
            for (out, column) in lines.iter_mut().zip(by_switch()) {
                *out += weight * dot(column, volts);
            }
            self.points[l].vjp_into(volts, siemens);
            gather(fitted, level, siemens, weight, &mut out);
        }
        self.hold(fitted, &mut out);
        out
    }

    /// What is no unknown does not move.
    fn hold(&self, fitted: &Fitted, values: &mut [f64]) {
        if !fitted.saturates || self.is_pinned {
            values[3] = 0.0;
        }
    }

    /// Conjugate gradients, in units of what is believed.
    fn solve(&mut self, fitted: &Fitted, right: &[f64]) -> Vec<f64> {
        let unit = |i: usize| self.prior[i].1.min(1.0);
        let units: Vec<f64> = (0..right.len()).map(unit).collect();
        let mut x = vec![0.0; right.len()];
        let mut left: Vec<f64> = right.iter().zip(&units).map(|(r, u)| r * u).collect();
        let mut along = left.clone();
        let mut size = dot(&left, &left);
        let wanted = GRADIENT_ACCURACY.powi(2) * size;
        for _ in 0..GRADIENTS {
            if size <= wanted || size == 0.0 {
                break;
            }
            let direction: Vec<f64> = along.iter().zip(&units).map(|(a, u)| a * u).collect();
            let mut curved = self.curve(fitted, &direction);
            for (curved, unit) in curved.iter_mut().zip(&units) {
                *curved *= unit;
            }
            let length = size / dot(&along, &curved);
            for ((x, left), (along, curved)) in
                x.iter_mut().zip(&mut left).zip(along.iter().zip(&curved))
            {
                *x += length * along;
                *left -= length * curved;
            }
            let next = dot(&left, &left);
            let share = next / size;
            for (along, left) in along.iter_mut().zip(&left) {
                *along = left + share * *along;
            }
            size = next;
        }
        x.iter().zip(&units).map(|(x, u)| x * u).collect()
    }

    /// Standard error of a number of the law as it is reported, by the inverse of the curvature.
    fn error_of(&mut self, fitted: &Fitted, number: usize) -> f64 {
        let mut by = fitted.by_unknowns(number);
        self.hold(fitted, &mut by);
        dot(&self.solve(fitted, &by), &by).max(0.0).sqrt()
    }
}
