//! The e-Cone's inverse: the network is known exactly but for one small matrix, which products alone bring.
//!
//! With W = v_r/(g_c V_t) and rows that float when nothing is selected: β_r = 1/(W g_c)_r, K = diag(β) W and
//! P_rr = (β_r − 1)/g_in, exactly. A row that floats shares what it conducts among its taxels, G = Λ M. With D = diag(g_c + Gᵀ1) and
//! T = D − GᵀΛ⁻¹G, the network as its columns see it, M = K T and P = Λ⁻¹ + K T Kᵀ, so that the fixed point is
//!
//! Λ_r = 1/(P_rr − Σ_c K_rc M_rc),  G = Λ M,  M ← K D − K Mᵀ G.
//!
//! It begins with T = diag(g_c), where shares are those of the readings. Of tall arrays T is the unknown, its rows summing to g_c. Under a
//! continuous sheet Λ and D become tridiagonal; the diagonal of Λ⁻¹ still tells Λ ([`sideways`]). Mixed after Anderson, it
//! takes five rounds at 10 Ω, ten at 100 Ω ([theory.md]).
//!
//! [theory.md]: https://github.com/taxel/taxel/blob/main/docs/theory.md

mod limit;
mod maxima;
mod rounds;
mod shares;
mod sideways;
mod state;

use super::{Infeasible, Method, Outcome, Solver, Stop, noise_and_rounding_volts};
use crate::circuit::{LineEnds, LinearCircuit};
use crate::frame::clear_where;
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
/// Under a sheet a part of that: what its couplings leave is in no change of the shares.
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
}

/// Rows whose readings sum to less than this share of V_t carry no current worth a place in the network.
const WEAK_ROW: f64 = 1e-7;
const MIXING_DEPTH: usize = 4;

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
        let (others, another) = (state.live.update(volts), state.takes(self.sheet));
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
        let outcome = self.iterate(state, n);
        state.warm = outcome.stop.is_good();
        state.follows = true;
        self.collect(state, n);
        state
            .live
            .scatter(&state.siemens[..taxels], columns, siemens.values_mut());
        clear_where(&mut siemens.values, &siemens.marks, |mark| {
            mark == Mark::Absent
        });
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
        if state.strong != state.strong_before {
            state.reshape(n);
        }
        // Each time, so that a state also serves the same sensor with other resistances.
        let columns =
            (state.full.g_c.iter_mut().zip(&mut state.half.g_c)).zip(&mut state.column_ohms);
        for (((g_c, single), ohms), &c) in columns.zip(&state.live.columns) {
            *g_c = ends.column_selected[c];
            *single = *g_c as f32;
            *ohms = 1.0 / *g_c;
        }
        let mut at = 0;
        for (i, &r) in state.live.rows.iter().enumerate() {
            if !state.strong[i] {
                continue;
            }
            let beta = 1.0 / state.share[i];
            state.p[at] = (beta - 1.0) / ends.row_selected[r];
            let line = &state.volts[i * n..(i + 1) * n];
            let k = state.full.k[at * n..(at + 1) * n].iter_mut();
            let single = &mut state.half.k[at * n..(at + 1) * n];
            let ohms = &state.column_ohms;
            wide(
                #[inline(always)]
                || {
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

    fn iterate(&self, state: &mut SolverState, n: usize) -> Outcome {
        if state.p.is_empty() {
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
        let mut outcome = rounds::run(state, accuracy, rounds::ALL_THE_WAY);
        if !outcome.stop.is_good() && state.warm {
            // What the frame before left may be what leads nowhere.
            state.warm = false;
            outcome = rounds::run(state, accuracy, rounds::ALL_THE_WAY);
        }
        if !outcome.stop.is_good() {
            state.warm = false;
            outcome = rounds::run(state, accuracy, rounds::WITH_CARE);
        }
        if !outcome.stop.is_good() {
            if let Some(infeasible) = limit::find(state, n) {
                outcome.stop = Stop::Infeasible(infeasible);
            }
            // What rounds leave that led nowhere is no answer.
            state.full.g.fill(0.0);
        }
        outcome
    }

    /// The rows that carry current to their places, and the rest to first order in their conductance:
    /// G_r = g_in (w_r D − w_r Gᵀ Λ⁻¹ G).
    fn collect(&self, state: &mut SolverState, n: usize) {
        let known = &state.full.g;
        let mut at = 0;
        for (i, &r) in state.live.rows.iter().enumerate() {
            let out = &mut state.siemens[i * n..(i + 1) * n];
            if state.strong[i] {
                out.copy_from_slice(&known[at * n..(at + 1) * n]);
                at += 1;
                continue;
            }
            let ohms = &state.column_ohms;
            for ((out, share), ohms) in out.iter_mut().zip(&state.volts[i * n..]).zip(ohms) {
                *out = share * ohms;
            }
            let lines = known.chunks_exact(n);
            for (pull, g) in state.along_rows.iter_mut().zip(lines) {
                let total: f64 = g.iter().sum();
                let along: f64 = g.iter().zip(out.iter()).map(|(g, w)| g * w).sum();
                // None of a frame that has no answer.
                *pull = if total > 0.0 { along / total } else { 0.0 };
            }
            let g_in = self.ends.row_selected[r];
            let between = state.sideways.as_ref().filter(|_| !known.is_empty());
            let between = between.map_or(&[][..], |s| &s.now.large);
            let mut before = 0.0;
            for j in 0..n {
                let column = known[j.min(known.len())..].iter().step_by(n);
                let (mut total, mut pulled) = (1.0 / ohms[j], 0.0);
                for (g, pull) in column.zip(&state.along_rows) {
                    total += g;
                    pulled += pull * g;
                }
                let w = out[j];
                let mut value = w * total - pulled;
                if let Some(coupling) = j.checked_sub(1).and_then(|j| between.get(j)) {
                    value += coupling * (w - before);
                }
                if let Some(coupling) = between.get(j) {
                    value += coupling * (w - out[j + 1]);
                }
                (out[j], before) = (g_in * value, w);
            }
        }
    }
}
