//! The e-Cone's inverse: the network is known exactly but for the off-diagonal of one small matrix.
//!
//! With W = v_r/(g_c V_t) and rows that float when nothing is selected: β_r = 1/(W g_c)_r,
//! K = diag(β) W and P_rr = (β_r − 1)/g_in, exactly. What is left is S = P⁻¹, a fixed point of
//!
//! H = S K,  d_c = g_c/(1 − Σ_r H_rc),  S_ij ← −(H diag(d) Hᵀ)_ij,  S_ii such that (S⁻¹)_ii = P_rr.
//!
//! Under a continuous sheet diag(d) becomes tridiagonal and S gains the couplings of neighbouring rows; each round corrects
//! them, and with them H and d, before G follows. Mixed after Anderson, it takes five rounds at 10 Ω, and one or two more
//! under a sheet. Where it fails (50 Ω and more), the slower but sturdier iteration of `root.rs` takes over ([theory.md]).
//!
//! [theory.md]: https://github.com/taxel/taxel/blob/main/docs/theory.md

mod state;

use super::anderson::Anderson;
use super::network::Network;
use super::{Infeasible, Method, Outcome, Solver, Stop};
use crate::circuit::{LineEnds, LinearCircuit};
use crate::material::Sheet;
use crate::sensor::Sensor;
use crate::{Frame, Mark, Siemens, Volts};
pub(crate) use state::SolverState;
use state::unpack;
use taxel_linalg::{View, ViewMut, multiply_lower};

/// The closed iteration for `tia-grounded-columns` without a source resistor.
#[derive(Debug, Clone, PartialEq)]
pub struct Exact {
    ends: LineEnds,
    sheet: Option<Sheet>,
    tolerance: f64,
}

/// Rows whose readings sum to less than this share of V_t carry no current worth a place in the network.
const WEAK_ROW: f64 = 1e-7;
const MAX_FAST_ITERATIONS: u32 = 25;
const MIXING_DEPTH: usize = 3;
/// Where a conductance changes by less than this share of the largest, the fast iteration does the rest.
const HAND_OVER: f64 = 1e-2;
/// The rounds left change a conductance by about change × ratio/(1 − ratio) in all; how much more is allowed
/// for, since mixed steps are irregular.
const SAFETY: f64 = 4.0;
const SLOWEST: f64 = 0.9;
/// Under a sheet no ratio counts for less: in a steady stream mixing foresees most of a change at once, and what it has not
/// foreseen shrinks as slowly as ever (frames that stopped in the third round were off by 2e-8).
const LEAST_RATIO: f64 = 0.08;
/// The last change of the slow iteration, as a share of the tolerance: it contracts by a half and more.
const ROOT_SHARE: f64 = 0.2;

impl Exact {
    /// The method for a circuit; none when its read-out has no closed iteration.
    pub fn new(circuit: &LinearCircuit) -> Option<Self> {
        let ends = circuit.ends();
        let has_closed_form = ends.reads_current && ends.are_shares() && circuit.lines().is_none();
        has_closed_form.then(|| Self {
            ends: ends.clone(),
            sheet: circuit.sheet(),
            tolerance: 1e-9,
        })
    }

    /// The method for a sensor; none when its read-out has no closed iteration, or its recorder leaves readings out: this
    /// needs the value of each.
    pub(crate) fn from_sensor(sensor: &Sensor, circuit: &LinearCircuit) -> Option<Self> {
        Self::new(circuit).filter(|_| sensor.converter().floor_count.is_none())
    }

    /// Stops when no conductance is estimated to change by more than `tolerance` times the largest (1e-9
    /// otherwise). At 1e-6, 3 frames of 2160 missed it, all at 100 Ω and more, the worst by 2.5 times.
    pub fn with_tolerance(mut self, tolerance: f64) -> Self {
        self.tolerance = tolerance;
        self
    }
}

impl Method for Exact {
    fn name(&self) -> &'static str {
        "exact"
    }

    fn solver(&self) -> Box<dyn Solver> {
        Box::new(ExactSolver {
            state: self.state(),
            method: self.clone(),
        })
    }
}

struct ExactSolver {
    method: Exact,
    state: SolverState,
}

impl Solver for ExactSolver {
    fn solve_into(&mut self, volts: &Frame<Volts>, siemens: &mut Frame<Siemens>) -> Outcome {
        self.method.solve_with(volts, siemens, &mut self.state)
    }

    fn forget(&mut self) {
        self.state.forget();
    }
}

impl Exact {
    /// What [`Self::solve_with`] needs; it also serves the same sensor with other resistances.
    pub(crate) fn state(&self) -> SolverState {
        SolverState::new(
            self.ends.row_selected.len(),
            self.ends.column_selected.len(),
        )
    }

    /// [`Solver::solve_into`] from the state that another frame left.
    pub(crate) fn solve_with(
        &self,
        volts: &Frame<Volts>,
        siemens: &mut Frame<Siemens>,
        state: &mut SolverState,
    ) -> Outcome {
        let columns = self.ends.column_selected.len();
        assert_eq!(
            (volts.rows(), volts.columns()),
            (self.ends.row_selected.len(), columns),
            "the frame has the sensor's shape"
        );
        siemens.copy_meta_from(volts);
        let (others, another) = (state.live.update(volts), state.network.takes(self.sheet));
        if others || another {
            state.warm = false;
            state.strong_before.clear();
        }
        let (live_rows, n) = (state.live.rows.len(), state.live.columns.len());
        if live_rows == 0 || n == 0 {
            siemens.values_mut().fill(0.0);
            return Outcome::new(Stop::Direct, 0, 0.0);
        }
        let taxels = live_rows * n;
        state
            .live
            .gather(volts.values(), columns, &mut state.volts[..taxels]);
        if let Err(infeasible) = self.prepare(state, n) {
            siemens.values_mut().fill(0.0);
            state.warm = false;
            return Outcome::new(Stop::Infeasible(infeasible), 0, f64::INFINITY);
        }
        let outcome = self.iterate(state);
        state.warm = outcome.stop.is_good();
        self.collect(state, n);
        state
            .live
            .scatter(&state.siemens[..taxels], columns, siemens.values_mut());
        for (siemens, mark) in siemens.values.iter_mut().zip(&siemens.marks) {
            if *mark == Mark::Absent {
                *siemens = 0.0;
            }
        }
        outcome
    }

    /// From volts to K and P_rr of the rows that carry current.
    fn prepare(&self, state: &mut SolverState, n: usize) -> Result<(), Infeasible> {
        let ends = &self.ends;
        state.strong.clear();
        for (i, &r) in state.live.rows.iter().enumerate() {
            // volts ← the share of V_t on the selected row's line.
            let scale = 1.0 / (ends.volts_per_volt[r] * ends.v_test_volts);
            let line = &mut state.volts[i * n..(i + 1) * n];
            let mut sum = 0.0;
            for value in line.iter_mut() {
                *value *= scale;
                sum += *value;
            }
            if sum >= 1.0 {
                let ohms = 1.0 / ends.row_selected[r];
                return Err(Infeasible::row(r, ohms, sum));
            }
            state.share[i] = sum;
            state.strong.push(sum > WEAK_ROW);
        }
        let mut known = state.warm;
        if state.strong != state.strong_before {
            known = false;
            state.reshape(n);
        }
        let network = &mut state.network;
        // Each time, so that a state also serves the same sensor with other resistances.
        for (g_c, &c) in network.g_c.iter_mut().zip(&state.live.columns) {
            *g_c = ends.column_selected[c];
        }
        let mut at = 0;
        for (i, &r) in state.live.rows.iter().enumerate() {
            if !state.strong[i] {
                continue;
            }
            let beta = 1.0 / state.share[i];
            let p = (beta - 1.0) / ends.row_selected[r];
            state.stretch[at] = if known {
                (network.p[at] / p).sqrt()
            } else {
                1.0
            };
            network.p[at] = p;
            let line = &state.volts[i * n..(i + 1) * n];
            for ((k, share), g_c) in network.k[at * n..(at + 1) * n]
                .iter_mut()
                .zip(line)
                .zip(&network.g_c)
            {
                *k = beta * share / g_c;
            }
            at += 1;
        }
        Ok(())
    }

    fn iterate(&self, state: &mut SolverState) -> Outcome {
        if state.network.m == 0 {
            return Outcome::new(Stop::Direct, 0, 0.0);
        }
        let fast = self.fast(state);
        if fast.stop.is_good() {
            state.slow = false;
            return fast;
        }
        let again = state.warm && state.slow;
        state.slow = true;
        let mut iterations = fast.iterations;
        let rough = (ROOT_SHARE * self.tolerance).max(HAND_OVER);
        let (mut outcome, mut worst_column) = state.root.iterate(&mut state.network, rough, again);
        iterations += outcome.iterations;
        if outcome.stop.is_good() && rough > self.tolerance {
            state.take_s();
            let fast = self.fast(state);
            iterations += fast.iterations;
            if fast.stop.is_good() {
                return Outcome { iterations, ..fast };
            }
            let (root, fine) = (&mut state.root, ROOT_SHARE * self.tolerance);
            (outcome, worst_column) = root.iterate(&mut state.network, fine, true);
            iterations += outcome.iterations;
        }
        outcome.iterations = iterations;
        state.take_s();
        if let Some((denominator, at)) = worst_column {
            let column = state.live.columns[at];
            let ohms = 1.0 / self.ends.column_selected[column];
            outcome.stop = Stop::Infeasible(Infeasible {
                number: "r_mux_column_ohms",
                ohms,
                limit_ohms: ohms / (1.0 - denominator),
                line: format!("column {column}"),
            });
        }
        outcome
    }

    /// The fixed point in S; gives up (`Stalled`) as soon as it does not contract.
    fn fast(&self, state: &mut SolverState) -> Outcome {
        let SolverState {
            network,
            packed,
            image,
            triangle,
            diagonal,
            stretch,
            mixing,
            warm,
            ..
        } = state;
        let m = network.m;
        for (root, p) in diagonal.iter_mut().zip(&network.p) {
            *root = p.sqrt();
        }
        start(network, packed, mixing, warm.then_some(stretch), diagonal);
        if let Some(sideways) = &mut network.sideways {
            sideways.begin();
        }
        let (mut ratio_before, mut last_change) = (0f64, f64::INFINITY);
        for round in 1..=MAX_FAST_ITERATIONS {
            let stalled = Outcome::new(Stop::Stalled, round, last_change);
            unpack(packed, &mut network.s, m);
            network.take_couplings(&packed[m * (m + 1) / 2..]);
            let floor = f64::MIN_POSITIVE;
            if network.columns_from_s(floor).0 <= 0.0 || network.settle(floor) <= 0.0 {
                return stalled;
            }
            let (largest, change) = network.conductances();
            let change = change / largest;
            if !change.is_finite() || (round > 4 && change > 0.3) {
                return stalled;
            }
            // The first change is none of the iteration's; from the second on, their ratio says what is left.
            let ratio = match round {
                1 | 2 => 1.0,
                _ if network.sideways.is_some() => (change / last_change).max(LEAST_RATIO),
                _ => change / last_change,
            };
            let slower = ratio.max(ratio_before).min(SLOWEST);
            let left = SAFETY * change * slower / (1.0 - slower);
            if round > 1 && left <= self.tolerance {
                return Outcome::new(Stop::Converged, round, change);
            }
            ratio_before = if round < 3 { 0.0 } else { ratio };
            last_change = change;
            if !image_of(network, packed, image, diagonal, triangle) {
                return stalled;
            }
            mixing.advance(packed, image);
        }
        Outcome::new(Stop::IterationLimit, MAX_FAST_ITERATIONS, last_change)
    }

    /// The rows that carry current to their places, and the rest to first order in their conductance:
    /// H_r = g_in (w_r − (w_r Gᵀ) Λ⁻¹ H).
    fn collect(&self, state: &mut SolverState, n: usize) {
        let network = &state.network;
        let mut at = 0;
        for (i, &r) in state.live.rows.iter().enumerate() {
            let out = &mut state.siemens[i * n..(i + 1) * n];
            if state.strong[i] {
                out.copy_from_slice(&network.g[at * n..(at + 1) * n]);
                at += 1;
                continue;
            }
            for ((out, share), g_c) in out.iter_mut().zip(&state.volts[i * n..(i + 1) * n]).zip(
                state
                    .live
                    .columns
                    .iter()
                    .map(|&c| self.ends.column_selected[c]),
            ) {
                *out = share / g_c;
            }
            let lines = network.g.chunks_exact(n);
            for (pull, g) in state.along_rows.iter_mut().zip(lines) {
                let total: f64 = g.iter().sum();
                let along: f64 = g.iter().zip(out.iter()).map(|(g, w)| g * w).sum();
                *pull = along / total;
            }
            for (pull, h) in state.along_rows.iter().zip(network.h.chunks_exact(n)) {
                for (out, h) in out.iter_mut().zip(h) {
                    *out -= pull * h;
                }
            }
            let g_in = self.ends.row_selected[r];
            let chain = network.sideways.as_ref().filter(|_| network.m > 0);
            let (chain, mut before) = (chain.map_or(&[][..], |s| &s.now.large), 0.0);
            for j in 0..n {
                let d = match network.m {
                    0 => self.ends.column_selected[state.live.columns[j]],
                    _ => network.d[j],
                };
                // H T, T tridiagonal under a sheet.
                let h = out[j];
                let mut value = h * d;
                if let Some(coupling) = j.checked_sub(1).and_then(|j| chain.get(j)) {
                    value += coupling * (h - before);
                }
                if let Some(coupling) = chain.get(j) {
                    value += coupling * (h - out[j + 1]);
                }
                (out[j], before) = (g_in * value, h);
            }
        }
    }
}

/// The first S: the previous frame's, scaled to this one's P_rr, or diag(1/P_rr); and the weights that make its entries comparable.
fn start(
    network: &mut Network,
    packed: &mut [f64],
    mixing: &mut Anderson,
    stretch: Option<&mut Vec<f64>>,
    root_p: &[f64],
) {
    let m = network.m;
    match stretch {
        Some(_) => mixing.resume(),
        None => mixing.restart(),
    }
    let weights = mixing.weights_mut();
    let mut at = 0;
    for i in 0..m {
        for j in 0..=i {
            weights[at] = root_p[i] * root_p[j];
            let kept = match &stretch {
                Some(stretch) => packed[at] * stretch[i] * stretch[j],
                None => 0.0,
            };
            packed[at] = if i == j && kept == 0.0 {
                1.0 / network.p[i]
            } else {
                kept
            };
            at += 1;
        }
    }
    // Couplings are small beside what columns and rows conduct: as much as resistances of one size make comparable.
    let ohms = root_p.iter().map(|root| root * root).sum::<f64>() / m as f64;
    weights[at..].fill(ohms);
    if stretch.is_none() {
        network.g.fill(0.0);
        packed[at..].fill(0.0);
    }
}

/// The next S, packed, from the conductances of the present one. False when it is not positive definite.
fn image_of(
    network: &mut Network,
    packed: &[f64],
    image: &mut [f64],
    diagonal: &mut [f64],
    triangle: &mut [f64],
) -> bool {
    let m = network.m;
    let (g, h) = (
        View::new(&network.g, m, network.n),
        View::new(&network.h, m, network.n),
    );
    multiply_lower(ViewMut::new(&mut network.product, m, m), g, h.transpose());
    let now = network.sideways.as_ref().map(|s| &s.now);
    if let Some(now) = now {
        let (rows, columns) = image[m * (m + 1) / 2..].split_at_mut(now.small.len());
        rows.copy_from_slice(&now.small);
        columns.copy_from_slice(&now.large);
    }
    for i in 0..m {
        let (low, at) = (i * m, i * (i + 1) / 2);
        for j in 0..i {
            image[at + j] = -network.product[low + j];
            network.product[low + j] = image[at + j];
        }
        if let (Some(now), Some(before)) = (now, i.checked_sub(1)) {
            network.product[low + before] -= now.small[before];
        }
        image[at + i] = packed[at + i];
        network.product[low + i] = packed[at + i];
    }
    if !network.spd.factorise(&network.product) {
        return false;
    }
    network.spd.inverse_diagonal_into(diagonal, triangle);
    for i in 0..m {
        let found = diagonal[i];
        // 1/found is the Schur complement of S_ii, so this makes it 1/P_rr if no other entry moves.
        image[i * (i + 1) / 2 + i] += 1.0 / network.p[i] - 1.0 / found;
    }
    true
}
