//! A diode in every taxel: each taxel's own path, undone in closed form, with what flows beside it from the last answer.
//!
//! i = I + X, V_c = U_c − (i + D)/g_cs, G = i/(V_c − v_r − n V_T ln(1 + i/I_s)): X and D hardly hang on G, so that a few rounds suffice.
//! Where rows are held alike, D is what the other rows of the column read.

use super::anderson::Anderson;
use super::gmres::largest;
use super::{Infeasible, Method, Outcome, Solver, Stop};
use crate::circuit::DiodeCircuit;
use crate::circuit::diode::Paths;
use crate::circuit::diode::taxel::Currents;
use crate::sensor::Sensor;
use crate::{Frame, Mark, Siemens, Volts};

/// Rounds at most: two to four are usual.
const ROUNDS: u32 = 60;
/// Where more leaks through Schottky diodes than unloaded taxels conduct, so many are not enough: then rounds are mixed.
const PLAIN_ROUNDS: u32 = 4;
const MIXED: usize = 5;
/// A change, of the largest conductance, that an answer may still have after the last round.
const GOOD_ENOUGH: f64 = 1e-6;

/// The inverse of a circuit with a diode per taxel.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct TaxelDiodes {
    paths: Paths,
    tolerance: f64,
    unloaded_siemens: f64,
}

impl TaxelDiodes {
    /// The method for a circuit whose diodes stand in taxels.
    pub(crate) fn new(sensor: &Sensor, circuit: &DiodeCircuit) -> Self {
        let paths = circuit.paths();
        Self {
            // All lines at once are found to a picovolt, which is this much of a small conductance.
            tolerance: if paths.is_grounded() { 1e-10 } else { 1e-8 },
            paths,
            unloaded_siemens: super::unloaded_siemens(sensor),
        }
    }

    /// Stops when no conductance changes by more than `tolerance` times the largest (1e-10 otherwise).
    pub(crate) fn with_tolerance(mut self, tolerance: f64) -> Self {
        self.tolerance = tolerance;
        self
    }

    /// Memory for a stream of frames.
    pub(crate) fn state(&self) -> SolverState {
        let taxels = self.paths.rows * self.paths.columns;
        let none = || vec![0.0; taxels];
        SolverState {
            currents: Currents::new(&self.paths),
            g: none(),
            image: none(),
            mixing: Anderson::new(MIXED, taxels),
            own: none(),
            row_volts: none(),
            drawn: vec![0.0; self.paths.columns],
        }
    }

    /// [`Solver::solve_into`] with memory of the caller's.
    pub(crate) fn solve_with(
        &self,
        volts: &Frame<Volts>,
        siemens: &mut Frame<Siemens>,
        state: &mut SolverState,
    ) -> Outcome {
        let (rows, columns) = (self.paths.rows, self.paths.columns);
        assert_eq!(
            (volts.rows(), volts.columns()),
            (rows, columns),
            "the frame has the sensor's shape"
        );
        siemens.copy_meta_from(volts);
        for (taxel, row_volts) in state.row_volts.iter_mut().enumerate() {
            *row_volts = volts.values()[taxel] / self.paths.ends.volts_per_volt[taxel / columns];
        }
        let outcome = self.iterate(volts.marks(), state);
        siemens.values_mut().copy_from_slice(&state.g);
        outcome
    }

    fn iterate(&self, marks: &[Mark], state: &mut SolverState) -> Outcome {
        let mut change = f64::INFINITY;
        state.mixing.restart();
        for round in 1..=ROUNDS {
            let before = change;
            let largest = match self.round(marks, state) {
                Ok(largest) => largest,
                Err(infeasible) => {
                    return Outcome::new(Stop::Infeasible(infeasible), round, f64::INFINITY);
                }
            };
            let moves = state.image.iter().zip(&state.g);
            change = moves.fold(0.0, |most, (a, b)| f64::max(most, (a - b).abs()));
            if !largest.is_finite() {
                return Outcome::new(Stop::Stalled, round, f64::INFINITY);
            }
            // Each plain round shortens the change by the same share: the next one's is foreseen.
            let is_plain = round <= PLAIN_ROUNDS;
            let left = if is_plain && before.is_finite() {
                change * (change / before).min(1.0)
            } else {
                change
            };
            if left <= self.tolerance * largest || change == 0.0 {
                state.g.copy_from_slice(&state.image);
                let residual = if largest > 0.0 { left / largest } else { 0.0 };
                return Outcome::new(Stop::Converged, round, residual);
            }
            if is_plain {
                state.g.copy_from_slice(&state.image);
            } else {
                state.mixing.advance(&mut state.g, &state.image);
            }
        }
        let most = largest(&state.g);
        // Rounds that no longer shorten what noise would hide are at their end.
        let stop = if change <= GOOD_ENOUGH * most {
            Stop::Converged
        } else {
            Stop::IterationLimit
        };
        Outcome::new(stop, ROUNDS, change / most)
    }

    /// The conductances that follow from what flows beside the taxels with those before; the largest of them.
    fn round(&self, marks: &[Mark], state: &mut SolverState) -> Result<f64, Infeasible> {
        state.currents.set(&self.paths, &state.g, true);
        self.own_currents(marks, state);
        let mut largest = 0f64;
        for (taxel, &mark) in marks.iter().enumerate() {
            let found = match mark {
                mark if mark.is_out() => 0.0,
                Mark::BelowFloor => self.unloaded_siemens,
                _ => self.siemens(taxel, state)?,
            };
            // No number is larger than none: adding nothing of it lets it through.
            largest = largest.max(found.abs()) + 0.0 * found;
            state.image[taxel] = found;
        }
        Ok(largest)
    }

    /// i of every taxel, and where rows are held alike their sum over each column.
    fn own_currents(&self, marks: &[Mark], state: &mut SolverState) {
        let columns = self.paths.columns;
        state.drawn.fill(0.0);
        for (taxel, &mark) in marks.iter().enumerate() {
            if mark.is_out() {
                state.own[taxel] = 0.0;
                continue;
            }
            if mark == Mark::BelowFloor {
                state.own[taxel] = self.unloaded(taxel, state.own[taxel]);
                state.drawn[taxel % columns] += state.own[taxel];
                continue;
            }
            let v_row = state.row_volts[taxel];
            let into_end = self.paths.ends.row_selected[taxel / columns] * v_row;
            let left = state
                .currents
                .left(&self.paths, taxel, v_row, state.own[taxel]);
            state.own[taxel] = into_end + left.amperes;
            state.drawn[taxel % columns] += state.own[taxel];
        }
    }

    /// What an unloaded taxel carries, amperes, from what it was taken to carry.
    fn unloaded(&self, taxel: usize, amperes: f64) -> f64 {
        let (ends, g) = (&self.paths.ends, self.unloaded_siemens);
        let (row, column) = (taxel / self.paths.columns, taxel % self.paths.columns);
        let ohms = 1.0 / ends.row_selected[row] + 1.0 / ends.column_selected[column];
        let over = self.paths.drives[column] - self.paths.junction.drop(amperes);
        (g * over / (1.0 + g * ohms)).max(0.0)
    }

    /// The conductance of a taxel by its own path.
    fn siemens(&self, taxel: usize, state: &SolverState) -> Result<f64, Infeasible> {
        let (paths, column) = (&self.paths, taxel % self.paths.columns);
        let (i, v_row) = (state.own[taxel], state.row_volts[taxel]);
        let (u, g_cs) = (paths.drives[column], paths.ends.column_selected[column]);
        let v_column = if paths.rows_alike {
            u - state.drawn[column] / g_cs
        } else {
            let (source, ohms) = state.currents.source(paths, taxel);
            source - ohms * i
        };
        let beside = state.currents.left(paths, taxel, v_row, i).volts;
        let left = v_column + beside - v_row - i * paths.along(taxel) - paths.junction.drop(i);
        if left > 1e-6 * u {
            return Ok(i / left);
        }
        Err(Infeasible {
            number: "the path of a taxel (its diode at readout.diode, switches, resistor, lines)",
            ohms: (u - left) / i,
            limit_ohms: u / i,
            line: format!("row {} at column {column}", taxel / paths.columns),
        })
    }
}

impl Method for TaxelDiodes {
    fn name(&self) -> &'static str {
        "diodes"
    }

    fn solver(&self) -> Box<dyn Solver> {
        Box::new(DiodeSolver {
            state: self.state(),
            method: self.clone(),
        })
    }
}

struct DiodeSolver {
    method: TaxelDiodes,
    state: SolverState,
}

/// What a stream of frames keeps.
pub(crate) struct SolverState {
    currents: Currents,
    g: Vec<f64>,
    /// What a round makes of g.
    image: Vec<f64>,
    mixing: Anderson,
    /// i, amperes.
    own: Vec<f64>,
    row_volts: Vec<f64>,
    /// Of each column, the sum of i.
    drawn: Vec<f64>,
}

impl Solver for DiodeSolver {
    fn solve_into(&mut self, volts: &Frame<Volts>, siemens: &mut Frame<Siemens>) -> Outcome {
        self.method.solve_with(volts, siemens, &mut self.state)
    }

    fn forget(&mut self) {
        self.state.g.fill(0.0);
        self.state.own.fill(0.0);
    }
}
