//! A diode in every taxel, its anode at the column: hardly any current finds another way than through the taxel itself.
//!
//! What is left of cross-talk is small, or shared: rows that nobody reads float up to the driven column and leak through reverse diodes
//! into the other columns; the row that is read leaks to them as well; and where all rows are held alike, all of the
//! driven column's taxels share what its switch drops. So each taxel has its own path, with two currents beside it: X leaves
//! the row for other columns, D leaves the driven column for other rows:
//!
//! i = I + X, V_c = U_c − (i + D)/g_cs, V_c − v_r = i/g + n V_T ln(1 + i/I_s), with v_r and I = g_rs v_r what is read.
//!
//! [`grounded`] finds X and D where unselected columns are held at ground, row by row; [`whole`] for any ends, by
//! Newton's method on all lines at once.

pub(crate) mod currents;
mod grounded;
mod leaks;
mod whole;

use super::DiodeCircuit;
use super::branch::Junction;
use super::per_column::PerColumn;
use crate::circuit::network::LineResistance;
use crate::circuit::{LineEnds, NotPassive, OperatingPoint};
pub(crate) use currents::Currents;

/// With a larger I_s (power Schottky diodes) what is left out of the quick scheme is 5e-4 of the signal; below, 1e-6.
const STRONG_AMPERES: f64 = 1e-6;

/// The circuit's numbers as this module needs them.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Paths {
    pub(crate) rows: usize,
    pub(crate) columns: usize,
    pub(crate) junction: Junction,
    pub(crate) ends: LineEnds,
    /// U_c, volts: where a driven column would stand without a load.
    pub(crate) drives: Vec<f64>,
    /// Whether rows end alike, selected or not: then all of a driven column's taxels are read at one potential of it.
    pub(crate) rows_alike: bool,
    along: Option<Along>,
}

/// What lines resist on the way to a taxel.
#[derive(Debug, Clone, PartialEq)]
struct Along {
    /// Of the row and of the column together, ohms.
    ohms: Vec<f64>,
    /// Of the row alone, from its end, and of the column alone.
    row_ohms: Vec<f64>,
    column_ohms: Vec<f64>,
}

impl Paths {
    pub(crate) fn new(ends: &LineEnds, junction: Junction, lines: Option<&LineResistance>) -> Self {
        let (rows, columns) = (ends.row_selected.len(), ends.column_selected.len());
        let drive = |(to, all): (&f64, &f64)| ends.v_test_volts * to / all;
        let drives = ends.to_v_test.column_selected.iter();
        Self {
            rows,
            columns,
            junction,
            drives: drives.zip(&ends.column_selected).map(drive).collect(),
            // What a follower repeats moves with the row that is selected.
            rows_alike: ends.row_selected == ends.row_unselected && !ends.has_followers(),
            along: lines.map(|lines| {
                let taxels = (0..rows).flat_map(|r| (0..columns).map(move |c| (r, c)));
                let row_ohms: Vec<f64> = (taxels.clone())
                    .map(|(r, c)| lines.to_row_end(r, c))
                    .collect();
                let column_ohms: Vec<f64> =
                    taxels.map(|(r, c)| lines.to_column_end(r, c)).collect();
                let both = row_ohms.iter().zip(&column_ohms);
                Along {
                    ohms: both.map(|(row, column)| row + column).collect(),
                    row_ohms,
                    column_ohms,
                }
            }),
            ends: ends.clone(),
        }
    }

    /// What lines resist on the way to a taxel, ohms.
    #[inline]
    pub(crate) fn along(&self, taxel: usize) -> f64 {
        self.along.as_ref().map_or(0.0, |along| along.ohms[taxel])
    }

    /// A taxel in series with the lines that lead to it, siemens.
    #[inline]
    fn with_lines(&self, taxel: usize, siemens: f64) -> f64 {
        siemens / (1.0 + siemens.abs() * self.along(taxel))
    }

    /// Whether columns that are not selected are held at ground, each, and diodes leak so little that they stay there: then rows can be
    /// taken one by one. (Lines that resist are worked out for that alone.)
    pub(crate) fn is_grounded(&self) -> bool {
        if self.junction.saturation > STRONG_AMPERES && self.along.is_none() {
            return false;
        }
        let held = |siemens: &f64| *siemens > 1e3 * crate::circuit::ends::LEAK_SIEMENS;
        let ends = &self.ends;
        ends.column_unselected.iter().all(held) && !ends.has_followers()
    }
}

/// A circuit with a diode per taxel, solved at one frame of conductances.
pub(super) struct TaxelPoint {
    paths: Paths,
    currents: Currents,
    volts: Vec<f64>,
    derivative: PerColumn,
}

impl TaxelPoint {
    pub(super) fn new(circuit: &DiodeCircuit) -> Self {
        let paths = circuit.paths();
        let taxels = paths.rows * paths.columns;
        Self {
            currents: Currents::new(&paths),
            volts: vec![0.0; taxels],
            derivative: PerColumn::new(paths.rows, paths.columns),
            paths,
        }
    }

    /// Readings and their derivative, from currents that are known. What leaks is taken not to change with a taxel.
    fn read(&mut self, siemens: &[f64]) {
        let Self {
            paths,
            currents,
            volts,
            derivative,
        } = self;
        let n = paths.columns;
        let junction = &paths.junction;
        for c in 0..n {
            let g_cs = paths.ends.column_selected[c];
            let mut shared = g_cs;
            for r in 0..paths.rows {
                let taxel = r * n + c;
                let (g_end, rho) = (paths.ends.row_selected[r], paths.ends.volts_per_volt[r]);
                let (i, v_row) = (currents.own[taxel], currents.row_volts[taxel]);
                volts[taxel] = rho * v_row;
                let g = siemens[taxel].abs();
                let series = paths.along(taxel) + 1.0 / g_end + junction.drop_slope(i);
                let over = if i == 0.0 {
                    currents.column_volts[taxel] - v_row
                } else {
                    i.abs() / g
                };
                let alone =
                    1.0 / (1.0 + g * (series + if paths.rows_alike { 0.0 } else { 1.0 / g_cs }));
                let at = rho / g_end * alone;
                derivative.diagonal[taxel] = at * over;
                derivative.left[taxel] = 0.0;
                derivative.right[taxel] = 0.0;
                if paths.rows_alike {
                    shared += g * alone;
                    derivative.left[taxel] = at * g;
                    derivative.right[taxel] = over * alone;
                }
            }
            if paths.rows_alike {
                for right in derivative.right.iter_mut().skip(c).step_by(n) {
                    *right /= -shared;
                }
            }
        }
    }
}

impl OperatingPoint for TaxelPoint {
    fn set(&mut self, siemens: &[f64]) -> Result<(), NotPassive> {
        if siemens.iter().any(|g| !g.is_finite()) {
            return Err(NotPassive);
        }
        self.currents.set(&self.paths, siemens, false);
        self.currents.solve_own(&self.paths, siemens);
        self.read(siemens);
        Ok(())
    }

    fn predict_into(&self, volts: &mut [f64]) {
        volts.copy_from_slice(&self.volts);
    }

    fn jvp_into(&mut self, direction: &[f64], out: &mut [f64]) {
        self.derivative.times(direction, out);
    }

    fn vjp_into(&mut self, weights: &[f64], out: &mut [f64]) {
        self.derivative.transposed_times(weights, out);
    }
}
