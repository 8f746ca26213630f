//! A diode in every driven line. The network behind them is linear, and since every row is held alike, all rows together tell
//! the driven diode's current: what it drops is measured.
//!
//! A linear scan at V_t gives, for the driven column c, readings L and their sum of currents I_L; seen from the diode the network is
//! V_t/I_L. So i_c solves i + … : V_t = n V_T ln(1 + i/I_s) + i V_t/I_L, and readings are L V_eff/V_t with V_eff = i V_t/I_L. Diodes that
//! are not driven leak the other way, I_s (1 − e^(−u_j/n V_T)) each, into drivers at ground; that is carried to
//! the rows by the same linear scan, by reciprocity.

use super::DiodeCircuit;
use super::branch::{Branch, Junction};
use super::per_column::PerColumn;
use crate::circuit::network::LinearPoint;
use crate::circuit::{LineEnds, NotPassive, OperatingPoint};

/// What finds the driven diodes' currents from readings.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct DrivenDiodes {
    junction: Junction,
    v_test_volts: f64,
    /// Amperes per volt read, of each row.
    amperes_per_volt: Vec<f64>,
    /// Volts of a row per volt read.
    row_per_volt: Vec<f64>,
}

/// Rounds in which the leaks of columns that are not driven are found.
const ROUNDS: usize = 30;

impl DrivenDiodes {
    pub(super) fn new(ends: &LineEnds, junction: Junction) -> Self {
        let rows = ends.row_selected.iter().zip(&ends.volts_per_volt);
        Self {
            junction,
            v_test_volts: ends.v_test_volts,
            amperes_per_volt: rows.map(|(g, rho)| g / rho).collect(),
            row_per_volt: ends.volts_per_volt.iter().map(|rho| 1.0 / rho).collect(),
        }
    }

    /// The current into a column whose rows read this, amperes.
    fn current(&self, column: impl Iterator<Item = f64>) -> f64 {
        let each = column.zip(&self.amperes_per_volt);
        each.map(|(volts, per_volt)| volts * per_volt).sum()
    }

    /// Readings as they would be without diodes, in the place of those with them: each column's, over the share of V_t that its
    /// diode leaves. What a current less than nothing would drop is taken to be nothing. `lifts`: what leaks of other columns add
    /// to V_t, volts, as far as is known; what they take from readings has been put back.
    pub(crate) fn undo(&self, lifts: &[f64], volts: &mut [f64]) {
        let columns = lifts.len();
        for (c, lift) in lifts.iter().enumerate() {
            let current = self.current(volts.iter().skip(c).step_by(columns).copied());
            let left = self.v_test_volts + lift - self.junction.drop(current.max(0.0));
            // A diode that drops all of V_t lets nothing through: what is read then is no reading of this circuit.
            let share = (left / self.v_test_volts).max(1e-3);
            for reading in volts.iter_mut().skip(c).step_by(columns) {
                *reading /= share;
            }
        }
    }
}

/// A circuit with a diode per driven line, solved at one frame of conductances.
pub(crate) struct DrivenPoint {
    diodes: DrivenDiodes,
    columns: usize,
    linear: LinearPoint,
    /// The linear scan, then the whole one.
    scan: Vec<f64>,
    volts: Vec<f64>,
    /// Of the linear scan, what each column carries, amperes.
    carried: Vec<f64>,
    /// V_eff/V_t of each column.
    shares: Vec<f64>,
    /// What the leaks of other columns add to V_t, volts.
    lifts: Vec<f64>,
    derivative: PerColumn,
    moved: Vec<f64>,
    leaks: Vec<f64>,
    rows: Vec<f64>,
}

impl DrivenPoint {
    pub(crate) fn new(circuit: &DiodeCircuit) -> Self {
        let ends = circuit.linear().ends();
        let (rows, columns) = (ends.row_selected.len(), ends.column_selected.len());
        let none = || vec![0.0; rows * columns];
        Self {
            diodes: circuit.driven(),
            columns,
            linear: circuit.linear().point(),
            scan: none(),
            volts: none(),
            carried: vec![0.0; columns],
            shares: vec![0.0; columns],
            lifts: vec![0.0; columns],
            derivative: PerColumn::new(rows, columns),
            moved: none(),
            leaks: vec![0.0; columns],
            rows: vec![0.0; rows],
        }
    }

    /// What columns that are not driven leak at the conductances that were set: put back into readings, and what it adds to V_t of
    /// each column, volts.
    pub(crate) fn without_leaks(&self, volts: &mut [f64]) -> &[f64] {
        for (taxel, volts) in volts.iter_mut().enumerate() {
            let share = self.shares[taxel % self.columns];
            *volts += self.scan[taxel] * share - self.volts[taxel];
        }
        &self.lifts
    }

    fn drive(&mut self, siemens: &[f64], c: usize) {
        self.leak(siemens, c);
        let (n, diodes) = (self.columns, &self.diodes);
        let v_test = diodes.v_test_volts;
        let (carried, share) = (self.carried[c], self.shares[c]);
        // dV = s dL − L/V_t · (slope of the drop) di, and all of i comes from the readings: one share a column.
        let slope = diodes.junction.drop_slope(carried * share) / v_test;
        let scale = 1.0 + slope * carried;
        let column = self.scan.iter().skip(c).step_by(n);
        for (r, (volts, per_volt)) in column.zip(&diodes.amperes_per_volt).enumerate() {
            let taxel = r * n + c;
            self.derivative.diagonal[taxel] = share;
            self.derivative.left[taxel] = -volts * slope / scale;
            self.derivative.right[taxel] = per_volt * share;
        }
        let rows = self.rows.iter().zip(&diodes.row_per_volt);
        for (out, (volts, per_volt)) in self.volts.iter_mut().skip(c).step_by(n).zip(rows) {
            *out = volts / per_volt;
        }
    }

    /// The driven diode's current, what columns that are not driven leak meanwhile, and the rows' potentials then.
    fn leak(&mut self, siemens: &[f64], c: usize) {
        let (n, junction) = (self.columns, self.diodes.junction);
        let v_test = self.diodes.v_test_volts;
        let through = Branch::new(&junction, self.carried[c] / v_test);
        self.leaks.fill(0.0);
        let mut lift = 0.0;
        for _ in 0..ROUNDS {
            let current = through.at(&junction, v_test + lift).amperes;
            self.shares[c] = if current > 0.0 {
                current / self.carried[c]
            } else {
                1.0
            };
            self.rows_while_leaking(c);
            let mut moved = 0f64;
            lift = 0.0;
            for j in (0..n).filter(|&j| j != c) {
                let (mut stands, mut total) = (0.0, 0.0);
                for (line, volts) in siemens.chunks_exact(n).zip(&self.rows) {
                    let g = line[j].max(0.0);
                    stands += g * volts;
                    total += g;
                }
                if total == 0.0 {
                    continue;
                }
                let volts = stands / total;
                // The diode in series with the taxels that the column hangs on.
                let leak = -Branch::new(&junction, total).at(&junction, -volts).amperes;
                moved = moved.max((leak - self.leaks[j]).abs());
                self.leaks[j] = leak;
                // What leaves here raises the driven column as a current there raises this one.
                lift += if current > 0.0 {
                    leak * volts / current
                } else {
                    0.0
                };
            }
            if moved <= 1e-9 * junction.saturation {
                break;
            }
        }
        self.lifts[c] = lift;
    }

    /// Potentials of the rows' ends, with the leaks as they are: each takes from a row what a current into its column would bring.
    fn rows_while_leaking(&mut self, c: usize) {
        let n = self.columns;
        for (r, (rows, per_volt)) in self
            .rows
            .iter_mut()
            .zip(&self.diodes.row_per_volt)
            .enumerate()
        {
            let line = &self.scan[r * n..(r + 1) * n];
            let each = line.iter().zip(&self.leaks).zip(&self.carried);
            let taken: f64 = each
                .filter(|((_, leak), carried)| **leak != 0.0 && **carried > 0.0)
                .map(|((volts, leak), carried)| volts * leak / carried)
                .sum();
            *rows = per_volt * (line[c] * self.shares[c] - taken);
        }
    }
}

impl OperatingPoint for DrivenPoint {
    fn set(&mut self, siemens: &[f64]) -> Result<(), NotPassive> {
        self.linear.set(siemens)?;
        self.linear.predict_into(&mut self.scan);
        for c in 0..self.columns {
            let column = self.scan.iter().skip(c).step_by(self.columns);
            self.carried[c] = self.diodes.current(column.copied());
        }
        for c in 0..self.columns {
            self.drive(siemens, c);
        }
        Ok(())
    }

    fn predict_into(&self, volts: &mut [f64]) {
        volts.copy_from_slice(&self.volts);
    }

    fn jvp_into(&mut self, direction: &[f64], out: &mut [f64]) {
        self.linear.jvp_into(direction, &mut self.moved);
        self.derivative.times(&self.moved, out);
    }

    fn vjp_into(&mut self, weights: &[f64], out: &mut [f64]) {
        self.derivative.transposed_times(weights, &mut self.moved);
        self.linear.vjp_into(&self.moved, out);
    }
}
