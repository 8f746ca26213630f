//! The part of a taxel's reading that is its own: the switches and resistors in series with it.

use super::Infeasible;
use super::lines::LiveLines;
use crate::circuit::LineEnds;

/// The series path of each taxel that is its own: I = V_out/volts_per_ampere, y = I/(V_t − I·R).
pub(super) struct OwnPath {
    per_ampere: f64,
    v_test: f64,
    column_ohms: Vec<f64>,
    row_ohms: Vec<f64>,
}

impl OwnPath {
    pub(super) fn new(ends: &LineEnds) -> Self {
        let ohms = |g: &[f64]| g.iter().map(|g| 1.0 / g).collect();
        Self {
            per_ampere: 1.0 / ends.volts_per_ampere,
            v_test: ends.v_test_volts,
            column_ohms: ohms(&ends.column_selected),
            row_ohms: ohms(&ends.row_selected),
        }
    }

    /// y and dy/dV of every taxel, in place of its volts.
    pub(super) fn apparent(&self, volts: &mut [f64], slope: &mut [f64]) {
        let n = self.column_ohms.len();
        for ((line, slopes), row) in volts
            .chunks_exact_mut(n)
            .zip(slope.chunks_exact_mut(n))
            .zip(&self.row_ohms)
        {
            for ((value, slope), column) in line.iter_mut().zip(slopes).zip(&self.column_ohms) {
                let current = *value * self.per_ampere;
                let left = self.v_test - current * (row + column);
                *value = current / left;
                *slope = self.per_ampere * self.v_test / (left * left);
            }
        }
    }

    /// The line that draws more than its path lets through, if there is one: the ohms it allows. With `shares`
    /// (rows open, columns held) the readings of a row are shares of V_t and sum to less than one.
    pub(super) fn infeasible(
        &self,
        volts: &[f64],
        live: &LiveLines,
        shares: bool,
    ) -> Option<Infeasible> {
        let n = self.column_ohms.len();
        for (i, line) in volts.chunks_exact(n).enumerate() {
            let ohms = self.row_ohms[i];
            let sum = line.iter().sum::<f64>() * self.per_ampere * ohms / self.v_test;
            if shares && sum >= 1.0 {
                return Some(Infeasible::row(live.rows[i], ohms, sum));
            }
        }
        volts.iter().enumerate().find_map(|(i, v)| {
            let ohms = self.row_ohms[i / n] + self.column_ohms[i % n];
            let current = v * self.per_ampere;
            (current * ohms >= self.v_test).then(|| Infeasible {
                number: "r_mux_row_ohms + r_mux_column_ohms (with r_source_ohms and the row's end resistor)",
                ohms,
                limit_ohms: self.v_test / current,
                line: format!("the taxel at row {}, column {}", live.rows[i / n], live.columns[i % n]),
            })
        })
    }
}
