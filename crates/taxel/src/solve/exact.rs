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

mod rounds;
mod single;
mod state;

use super::{Infeasible, Method, Outcome, Solver, Stop, noise_and_rounding_volts};
use crate::circuit::{LineEnds, LinearCircuit};
use crate::material::Sheet;
use crate::sensor::Sensor;
use crate::{Frame, Mark, Siemens, Volts};
pub(crate) use state::{SolverState, Start};
use taxel_linalg::{sum, wide};

/// The closed iteration for `tia-grounded-columns` without a source resistor.
#[derive(Debug, Clone, PartialEq)]
pub struct Exact {
    ends: LineEnds,
    sheet: Option<Sheet>,
    tolerance: f64,
    noise_siemens: f64,
}

/// What a stream leaves of its answer, as a share of the least standard error by noise and rounding, by an estimate that is [`rounds::SAFETY`]
/// times too large where rounds go as they usually do.
const NOISE_SHARE: f64 = 0.4;
/// Under a sheet a part of that: the couplings lag behind the rest, and estimates are too small by as much.
const SHEET_SHARE: f64 = 0.5;
/// No noise is so large that more than this share of the largest conductance may be left.
const MAX_TOLERANCE: f64 = 1e-4;

/// When an answer no longer changes: by less than this share of the largest conductance, or than so many siemens.
#[derive(Debug, Clone, Copy)]
pub(super) struct Accuracy {
    pub(super) share: f64,
    siemens: f64,
}

impl Accuracy {
    /// As a share of the largest conductance.
    pub(super) fn at(self, largest: f64) -> f64 {
        let by_noise = (self.siemens / largest).min(MAX_TOLERANCE);
        self.share.max(by_noise)
    }

    /// A part of it.
    fn part(self, part: f64) -> Self {
        Self {
            share: part * self.share,
            siemens: part * self.siemens,
        }
    }
}

/// Rows whose readings sum to less than this share of V_t carry no current worth a place in the network.
const WEAK_ROW: f64 = 1e-7;
const MIXING_DEPTH: usize = 4;
/// Where a conductance changes by less than this share of the largest, the fast iteration does the rest.
const HAND_OVER: f64 = 1e-2;
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
            noise_siemens: 0.0,
        })
    }

    /// The method for a sensor; none when its read-out has no closed iteration, or its recorder leaves readings out: this
    /// needs the value of each.
    pub(crate) fn from_sensor(sensor: &Sensor, circuit: &LinearCircuit) -> Option<Self> {
        let method = Self::new(circuit).filter(|_| sensor.converter().floor_count.is_none())?;
        let (noise_volts, rounding_volts) = noise_and_rounding_volts(sensor);
        let ends = circuit.ends();
        let rows = ends.row_selected.iter().zip(&ends.volts_per_volt);
        // A taxel alone on its lines has the smallest error: what loads its lines makes its reading smaller.
        let least = rows.map(|(g, volts)| g / (volts * ends.v_test_volts));
        let least = least.fold(f64::INFINITY, |least, x| least.min(x.abs()));
        let share = if method.sheet.is_some() {
            SHEET_SHARE * NOISE_SHARE
        } else {
            NOISE_SHARE
        };
        Some(Self {
            noise_siemens: share * least * noise_volts.hypot(rounding_volts),
            ..method
        })
    }

    /// Stops when no conductance is estimated to change by more than `tolerance` times the largest, whatever noise there is (otherwise
    /// 1e-9; for readings that a converter has rounded, a tenth of what its noise is worth). At 1e-6, 3 frames of 2160 missed it, all at 100 Ω and more, the worst by 2.5 times.
    pub fn with_tolerance(mut self, tolerance: f64) -> Self {
        (self.tolerance, self.noise_siemens) = (tolerance, 0.0);
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

    fn set_rounded(&mut self, is_rounded: bool) {
        self.state.is_rounded = is_rounded;
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
        state.follows = true;
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
            let sum = wide(
                #[inline(always)]
                || {
                    line.iter_mut().for_each(|value| *value *= scale);
                    sum(line)
                },
            );
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
        let columns = network.g_c.iter_mut().zip(&mut state.column_ohms);
        for ((g_c, ohms), &c) in columns.zip(&state.live.columns) {
            *g_c = ends.column_selected[c];
            *ohms = 1.0 / *g_c;
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
            let k = network.k[at * n..(at + 1) * n].iter_mut();
            let single = &mut state.single.k[at * n..(at + 1) * n];
            wide(
                #[inline(always)]
                || {
                    let ohms = &state.column_ohms;
                    for (((k, single), share), ohms) in k.zip(single).zip(line).zip(ohms) {
                        *k = beta * share * ohms;
                        *single = *k as f32;
                    }
                },
            );
            at += 1;
        }
        Ok(())
    }

    fn iterate(&self, state: &mut SolverState) -> Outcome {
        if state.network.m == 0 {
            return Outcome::new(Stop::Direct, 0, 0.0);
        }
        let accuracy = Accuracy {
            share: self.tolerance,
            siemens: if state.is_rounded {
                self.noise_siemens
            } else {
                0.0
            },
        };
        let fast = rounds::run(state, accuracy);
        if fast.stop.is_good() {
            state.slow = false;
            return fast;
        }
        let again = state.warm && state.slow;
        state.slow = true;
        let mut iterations = fast.iterations;
        let fine = accuracy.part(ROOT_SHARE);
        let rough = Accuracy {
            share: fine.share.max(HAND_OVER),
            ..fine
        };
        let (mut outcome, mut worst_column) = state.root.iterate(&mut state.network, rough, again);
        iterations += outcome.iterations;
        if outcome.stop.is_good() && rough.share > self.tolerance {
            state.take_s();
            let fast = rounds::run(state, accuracy);
            iterations += fast.iterations;
            if fast.stop.is_good() {
                return Outcome { iterations, ..fast };
            }
            (outcome, worst_column) = state.root.iterate(&mut state.network, fine, true);
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
