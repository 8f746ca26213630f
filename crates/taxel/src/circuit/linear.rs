//! Every topology made of linear parts: one factorisation over the smaller side reads the whole scan.

use super::ends::LEAK_SIEMENS;
use super::{Circuit, LineEnds, NotPassive, OperatingPoint};
use crate::Error;
use crate::sensor::{Sensor, Topology};
use taxel_linalg::{Spd, View, ViewMut, mirror, multiply, multiply_lower, sum};

/// A sensor's circuit, ready to be solved for any conductances.
///
/// With d = g_cu + Gᵀ1, H = G diag(d)⁻¹, S = diag(G1 + g_ru) − H diag(d) Hᵀ:
/// P = S⁻¹, K = P H, Q_cc = 1/d_c + (HᵀK)_cc, and V_out of a taxel is a function of P_rr, Q_cc, K_rc
/// ([theory.md]). With fewer columns than rows, the same over columns.
///
/// [theory.md]: https://github.com/taxel/taxel/blob/main/docs/theory.md
#[derive(Debug, Clone, PartialEq)]
pub struct LinearCircuit {
    ends: LineEnds,
}

impl LinearCircuit {
    /// The circuit of a sensor.
    ///
    /// # Errors
    /// [`Error::MissingKey`] when a switch resistance is not known yet.
    pub fn from_sensor(sensor: &Sensor) -> Result<Self, Error> {
        Ok(Self::new(LineEnds::from_sensor(sensor)?))
    }

    /// A circuit from its line ends.
    pub fn new(ends: LineEnds) -> Self {
        Self { ends }
    }

    /// How its lines end.
    pub fn ends(&self) -> &LineEnds {
        &self.ends
    }

    /// The operating point as its own type, for callers that need no trait object.
    pub fn point(&self) -> LinearPoint {
        LinearPoint::new(self.ends.clone())
    }
}

impl Circuit for LinearCircuit {
    fn rows(&self) -> usize {
        self.ends.row_selected.len()
    }

    fn columns(&self) -> usize {
        self.ends.column_selected.len()
    }

    fn operating_point(&self) -> Box<dyn OperatingPoint> {
        Box::new(self.point())
    }
}

/// A [`LinearCircuit`] solved at one frame of conductances.
pub struct LinearPoint {
    pub(super) ends: LineEnds,
    /// Lines of the smaller side (m) and of the larger (n); matrices below are m×n or m×m, row-major.
    pub(super) small: usize,
    pub(super) large: usize,
    /// The smaller side is the columns.
    pub(super) transposed: bool,
    small_end: Vec<f64>,
    large_end: Vec<f64>,
    conductance: Vec<f64>,
    /// 1/d of each line of the larger side.
    pub(super) inverse_d: Vec<f64>,
    pub(super) h: Vec<f64>,
    pub(super) p: Vec<f64>,
    pub(super) k: Vec<f64>,
    pub(super) q: Vec<f64>,
    schur: Vec<f64>,
    /// Conductance of each line of the smaller side, with its end.
    totals: Vec<f64>,
    spd: Spd,
    pub(super) work: super::derivative::Work,
}

impl LinearPoint {
    fn new(ends: LineEnds) -> Self {
        let (rows, columns) = (ends.row_selected.len(), ends.column_selected.len());
        let transposed = columns < rows;
        let (small, large) = (rows.min(columns), rows.max(columns));
        let (small_end, large_end) = if transposed {
            (ends.column_unselected.clone(), ends.row_unselected.clone())
        } else {
            (ends.row_unselected.clone(), ends.column_unselected.clone())
        };
        Self {
            ends,
            small,
            large,
            transposed,
            small_end,
            large_end,
            conductance: vec![0.0; small * large],
            inverse_d: vec![0.0; large],
            h: vec![0.0; small * large],
            p: vec![0.0; small * small],
            k: vec![0.0; small * large],
            q: vec![0.0; large],
            schur: vec![0.0; small * small],
            totals: vec![0.0; small],
            spd: Spd::new(small),
            work: super::derivative::Work::new(small, large),
        }
    }

    fn floating(&self) -> bool {
        self.ends.topology == Topology::DividerFloating
    }

    /// 1/d from the conductances.
    fn set_columns(&mut self) -> Result<(), NotPassive> {
        let n = self.large;
        let g = &self.conductance;
        self.inverse_d.copy_from_slice(&self.large_end);
        for line in g.chunks_exact(n) {
            for (d, value) in self.inverse_d.iter_mut().zip(line) {
                *d += value;
            }
        }
        if self.floating() {
            // The leak of an open line matters only where nothing else holds the line.
            for d in &mut self.inverse_d {
                *d = if *d > 2.0 * LEAK_SIEMENS {
                    *d - LEAK_SIEMENS
                } else {
                    *d
                };
            }
        }
        if !self.inverse_d.iter().all(|&d| d > 0.0) {
            return Err(NotPassive);
        }
        for d in &mut self.inverse_d {
            *d = 1.0 / *d;
        }
        Ok(())
    }

    /// What the lines of the smaller side conduct in all, added to S's diagonal.
    fn complete_schur(&mut self) {
        let (m, n) = (self.small, self.large);
        let g = &self.conductance;
        for (i, line) in g.chunks_exact(n).enumerate() {
            let sum = sum(line);
            let total = if self.floating() && sum > LEAK_SIEMENS {
                sum
            } else {
                sum + self.small_end[i]
            };
            self.schur[i * m + i] += total;
            self.totals[i] = total;
        }
        if self.floating() {
            // Nothing is grounded, so S is singular along 1. Holding the mean potential, each line weighted by
            // its conductance, changes no resistance between lines and makes it regular. (Without the
            // weights, a line that hardly conducts would pull P up by orders of magnitude everywhere.)
            let inverse_sum = 1.0 / self.totals.iter().sum::<f64>();
            for i in 0..m {
                let weight = self.totals[i] * inverse_sum;
                for (value, total) in self.schur[i * m..=i * m + i].iter_mut().zip(&self.totals) {
                    *value += weight * total;
                }
            }
        }
    }

    /// One value per taxel, row by row, to m×n.
    pub(super) fn gather(
        transposed: bool,
        small: usize,
        large: usize,
        from: &[f64],
        to: &mut [f64],
    ) {
        if transposed {
            for (j, line) in from.chunks_exact(small).enumerate() {
                for (i, &value) in line.iter().enumerate() {
                    to[i * large + j] = value;
                }
            }
        } else {
            to.copy_from_slice(from);
        }
    }

    /// Calls `visit(index in m×n, index by taxel, row, column, p, q)` for every taxel.
    #[inline(always)]
    pub(super) fn each(&self, mut visit: impl FnMut(usize, usize, usize, usize, f64, f64)) {
        let (m, n) = (self.small, self.large);
        for i in 0..m {
            let diagonal = self.p[i * m + i];
            for j in 0..n {
                if self.transposed {
                    visit(i * n + j, j * m + i, j, i, self.q[j], diagonal)
                } else {
                    visit(i * n + j, i * n + j, i, j, diagonal, self.q[j])
                }
            }
        }
    }
}

impl OperatingPoint for LinearPoint {
    fn set(&mut self, siemens: &[f64]) -> Result<(), NotPassive> {
        let (m, n) = (self.small, self.large);
        assert_eq!(siemens.len(), m * n, "one conductance per taxel");
        Self::gather(self.transposed, m, n, siemens, &mut self.conductance);
        self.work.stale = true;
        self.set_columns()?;
        let g = &self.conductance;
        for (h, line) in self.h.chunks_exact_mut(n).zip(g.chunks_exact(n)) {
            for ((h, value), inverse_d) in h.iter_mut().zip(line).zip(&self.inverse_d) {
                *h = value * inverse_d;
            }
        }
        multiply_lower(
            ViewMut::new(&mut self.schur, m, m),
            View::new(g, m, n),
            View::new(&self.h, m, n).transpose(),
        );
        for value in &mut self.schur {
            *value = -*value;
        }
        self.complete_schur();
        if !self.spd.factorise(&self.schur) {
            return Err(NotPassive);
        }
        self.spd.inverse_into(&mut self.p);
        multiply(
            ViewMut::new(&mut self.k, m, n),
            View::new(&self.p, m, m),
            View::new(&self.h, m, n),
        );
        self.q.copy_from_slice(&self.inverse_d);
        for (h, k) in self.h.chunks_exact(n).zip(self.k.chunks_exact(n)) {
            for ((q, h), k) in self.q.iter_mut().zip(h).zip(k) {
                *q += h * k;
            }
        }
        Ok(())
    }

    fn predict_into(&self, volts: &mut [f64]) {
        if self.transposed {
            self.each(|at, taxel, row, column, p, q| {
                volts[taxel] = self.ends.volts(row, column, p, q, self.k[at]);
            });
            return;
        }
        let (m, n) = (self.small, self.large);
        let lines = volts.chunks_exact_mut(n).zip(self.k.chunks_exact(n));
        for (row, (out, k)) in lines.enumerate() {
            let p = self.p[row * m + row];
            self.ends.volts_of_row(row, p, &self.q, k, out);
        }
    }

    fn jvp_into(&mut self, direction: &[f64], out: &mut [f64]) {
        super::derivative::forward(self, direction, out);
    }

    fn vjp_into(&mut self, weights: &[f64], out: &mut [f64]) {
        super::derivative::adjoint(self, weights, out);
    }
}

/// Symmetric part of a row-major n×n matrix, in place.
pub(super) fn symmetrise(values: &mut [f64], n: usize) {
    for i in 0..n {
        for j in 0..i {
            values[i * n + j] = 0.5 * (values[i * n + j] + values[j * n + i]);
        }
    }
    mirror(values, n);
}
