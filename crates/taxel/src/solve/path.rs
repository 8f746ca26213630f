//! The part of a taxel's reading that is its own: the switches and resistors in series with it.

use super::Infeasible;
use super::lines::LiveLines;
use crate::circuit::LineEnds;

/// The series path of each taxel that is its own: with V_out = ρ v_r and the row's end as U_r behind R_r,
/// I = (v_r − U_r)/R_r; with the column's as U_c behind R_c, y = I/(U_c − U_r − I (R_r + R_c)). Where other lines than the
/// selected column lead to V_t, not all of I is the taxel's: then y = I/(U_c − U_r).
pub(super) struct OwnPath {
    rows: Vec<Row>,
    /// R_c; 0 (like R_r) where I is not the taxel's own.
    column_ohms: Vec<f64>,
    /// U_c.
    drives: Vec<f64>,
    series: bool,
}

/// A row's end.
struct Row {
    ohms: f64,
    open_volts: f64,
    /// U_r/R_r.
    amperes_at_rest: f64,
    amperes_per_volt: f64,
}

impl Row {
    #[inline(always)]
    fn amperes(&self, volts: f64) -> f64 {
        volts * self.amperes_per_volt - self.amperes_at_rest
    }
}

impl OwnPath {
    pub(super) fn new(ends: &LineEnds) -> Self {
        let (v_test, to_v_test) = (ends.v_test_volts, &ends.to_v_test);
        let series = !ends.is_driven_elsewhere();
        let ohms = |g: &f64| if series { 1.0 / g } else { 0.0 };
        let row = |((g, from), rho): ((&f64, &f64), &f64)| Row {
            ohms: ohms(g),
            open_volts: v_test * from / g,
            amperes_at_rest: v_test * from,
            amperes_per_volt: g / rho,
        };
        let rows = ends.row_selected.iter().zip(&to_v_test.row_selected);
        let columns = ends.column_selected.iter();
        let columns = columns.zip(&to_v_test.column_selected);
        Self {
            rows: rows.zip(&ends.volts_per_volt).map(row).collect(),
            column_ohms: ends.column_selected.iter().map(ohms).collect(),
            drives: columns.map(|(g, from)| v_test * from / g).collect(),
            series,
        }
    }

    /// y and dy/dV of every taxel, in place of its volts.
    pub(super) fn apparent(&self, volts: &mut [f64], slope: &mut [f64]) {
        let n = self.column_ohms.len();
        for ((line, slopes), row) in volts
            .chunks_exact_mut(n)
            .zip(slope.chunks_exact_mut(n))
            .zip(&self.rows)
        {
            let columns = self.column_ohms.iter().zip(&self.drives);
            for ((value, slope), (ohms, drive)) in line.iter_mut().zip(slopes).zip(columns) {
                let (amperes, between) = (row.amperes(*value), drive - row.open_volts);
                let left = between - amperes * (row.ohms + ohms);
                *value = amperes / left;
                *slope = row.amperes_per_volt * between / (left * left);
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
        if !self.series {
            return None;
        }
        for (i, line) in volts.chunks_exact(n).enumerate() {
            let row = &self.rows[i];
            let shares_of_line = line.iter().zip(&self.drives);
            let sum: f64 = shares_of_line
                .map(|(volts, drive)| row.amperes(*volts) * row.ohms / drive)
                .sum();
            if shares && sum >= 1.0 {
                return Some(Infeasible::row(live.rows[i], row.ohms, sum));
            }
        }
        volts.iter().enumerate().find_map(|(i, v)| {
            let (row, drive) = (&self.rows[i / n], self.drives[i % n]);
            let ohms = row.ohms + self.column_ohms[i % n];
            let (amperes, between) = (row.amperes(*v), drive - row.open_volts);
            (amperes * ohms >= between).then(|| Infeasible {
                number: "r_mux_row_ohms + r_mux_column_ohms (with r_source_ohms and the row's end resistor)",
                ohms,
                limit_ohms: between / amperes,
                line: format!("the taxel at row {}, column {}", live.rows[i / n], live.columns[i % n]),
            })
        })
    }
}
