//! A diode in every driven line. The network behind them is linear, and since every row is held alike, all rows together tell
//! the driven diode's current: what it drops is measured.
//!
//! A linear scan at V_t gives, for the driven column c, readings L and their sum of currents I_L; seen from the diode the network is
//! V_t/I_L. So its current i solves V_t = n V_T ln(1 + i/I_s) + i V_t/I_L, and readings are L V_eff/V_t with V_eff = i V_t/I_L. Diodes that
//! are not driven leak the other way, I_s (1 − e^(−u_j/n V_T)) each, into drivers at ground; that is carried to
//! the rows by the same linear scan, by reciprocity.

use super::DiodeCircuit;
use super::branch::{Branch, Junction};
use super::per_column::PerColumn;
use crate::circuit::network::LinearPoint;
use crate::circuit::{LineEnds, NotPassive, OperatingPoint};

/// What finds the driven diodes' currents from readings.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct DrivenDiodes {
    junction: Junction,
    v_test_volts: f64,
    /// Amperes per volt read, of each row.
    amperes_per_volt: Vec<f64>,
    /// Volts of a row per volt read.
    row_per_volt: Vec<f64>,
}

/// Rounds in which the leaks of columns that are not driven are found, and to what of the smaller of I_s and the current.
const ROUNDS: usize = 200;
const ACCURACY: f64 = 1e-9;
/// What a diode leaves of V_t, at least: less is nothing, or noise.
const LEAST_SHARE: f64 = 1e-6;

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
    /// `Err`: a column whose current would drop all of V_t, ohms of the diode and what V_t allows.
    fn undo<'a>(
        &self,
        lifts: impl ExactSizeIterator<Item = &'a f64>,
        volts: &mut [f64],
    ) -> Result<(), Dropped> {
        let columns = lifts.len();
        for (column, lift) in lifts.enumerate() {
            let current = self.current(volts.iter().skip(column).step_by(columns).copied());
            let drop = self.junction.drop(current.max(0.0));
            let drive = self.v_test_volts + lift;
            if drop >= (1.0 - LEAST_SHARE) * drive {
                return Err(Dropped {
                    column,
                    ohms: drop / current,
                    limit_ohms: drive / current,
                });
            }
            let share = (drive - drop) / self.v_test_volts;
            for reading in volts.iter_mut().skip(column).step_by(columns) {
                *reading /= share;
            }
        }
        Ok(())
    }
}

/// A driven line whose diode would drop all of V_t.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Dropped {
    pub(crate) column: usize,
    pub(crate) ohms: f64,
    pub(crate) limit_ohms: f64,
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
    /// Between each driver that does not drive and its diode, ohms.
    rest_ohms: Vec<f64>,
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
            rest_ohms: circuit.rest_ohms.clone(),
        }
    }

    /// Readings as they would be without diodes, in the place of those with them. What columns that are not driven leak is taken to
    /// be as at the conductances that were set last, or nothing.
    ///
    /// # Errors
    /// A column whose current would drop all of V_t.
    pub(crate) fn undo(&self, leaks: bool, volts: &mut [f64]) -> Result<(), Dropped> {
        if !leaks {
            return self
                .diodes
                .undo(std::iter::repeat_n(&0.0, self.columns), volts);
        }
        for (taxel, volts) in volts.iter_mut().enumerate() {
            let share = self.shares[taxel % self.columns];
            *volts += self.scan[taxel] * share - self.volts[taxel];
        }
        self.diodes.undo(self.lifts.iter(), volts)
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

    /// The driven diode's current, what columns that are not driven leak meanwhile, and the rows' potentials then: one unknown after the
    /// other, each found for the others as they are. The network is passive and its currents rise with their voltages, so that this ends.
    fn leak(&mut self, siemens: &[f64], c: usize) {
        let (n, junction) = (self.columns, self.diodes.junction);
        let v_test = self.diodes.v_test_volts;
        let through = Branch::new(&junction, self.carried[c] / v_test);
        self.leaks.fill(0.0);
        self.rows.fill(0.0);
        let (mut lift, mut current) = (0.0, 0.0);
        for _ in 0..ROUNDS {
            let now = through.at(&junction, v_test + lift).amperes.max(0.0);
            let mut moved = (now - current).abs();
            self.add(c, now - current);
            current = now;
            lift = 0.0;
            for j in 0..n {
                if j == c || self.carried[j] <= 0.0 {
                    continue;
                }
                let Some(column) = self.column(siemens, j, c) else {
                    continue;
                };
                // Without its own leak the column stands higher, and its diode sees what it hangs on.
                let stands = column.stands + self.leaks[j] * column.own_ohms;
                let seen = Branch::new(&junction, 1.0 / (column.own_ohms + column.ohms));
                let leak = -seen.at(&junction, -stands).amperes;
                moved = moved.max((leak - self.leaks[j]).abs());
                self.add(j, self.leaks[j] - leak);
                self.leaks[j] = leak;
                // What leaves here raises the driven column as a current there raises this one.
                lift += leak * column.from_driven;
            }
            if moved <= ACCURACY * junction.saturation.min(current.max(f64::MIN_POSITIVE)) {
                break;
            }
        }
        self.lifts[c] = lift;
        self.shares[c] = if self.carried[c] > 0.0 && current > 0.0 {
            current / self.carried[c]
        } else {
            1.0
        };
    }

    /// A column that is not driven, with the rows as they are; nothing of one without taxels.
    fn column(&self, siemens: &[f64], j: usize, c: usize) -> Option<Hanging> {
        let n = self.columns;
        let (mut total, mut stands, mut own, mut from) = (0.0, 0.0, 0.0, 0.0);
        let rows = self.rows.iter().zip(&self.diodes.row_per_volt);
        for (r, (volts, per_volt)) in rows.enumerate() {
            let g = siemens[r * n + j].max(0.0);
            total += g;
            stands += g * volts;
            own += g * per_volt * self.scan[r * n + j];
            from += g * per_volt * self.scan[r * n + c];
        }
        (total > 0.0).then(|| Hanging {
            ohms: 1.0 / total + self.rest_ohms[j],
            stands: stands / total,
            own_ohms: own / (total * self.carried[j]),
            from_driven: if self.carried[c] > 0.0 {
                from / (total * self.carried[c])
            } else {
                0.0
            },
        })
    }

    /// Puts more current into a column: every row rises by what the linear scan says of it.
    fn add(&mut self, column: usize, amperes: f64) {
        if self.carried[column] <= 0.0 {
            return;
        }
        let n = self.columns;
        let share = amperes / self.carried[column];
        let scan = self.scan.iter().skip(column).step_by(n);
        let rows = self.rows.iter_mut().zip(&self.diodes.row_per_volt);
        for ((volts, per_volt), read) in rows.zip(scan) {
            *volts += per_volt * read * share;
        }
    }
}

/// What a column that is not driven hangs on.
struct Hanging {
    /// Of its taxels together, and of what its diode hangs on at the other side, ohms.
    ohms: f64,
    /// The mean of its rows' potentials, volts.
    stands: f64,
    /// What that rises by for one ampere into it, and for one into the driven column.
    own_ohms: f64,
    from_driven: f64,
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
