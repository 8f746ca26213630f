//! Lines of no resistance: one factorisation over the smaller side reads the whole scan.
//!
//! With d = g_cu + Gᵀ1, H = G diag(d)⁻¹, S = diag(G1 + g_ru) − H diag(d) Hᵀ:
//! P = S⁻¹, K = P H, Q_cc = 1/d_c + (HᵀK)_cc, and V_out of a taxel is a function of P_rr, Q_cc, K_rc
//! ([theory.md]). With fewer columns than rows, the same over columns. A continuous sheet couples neighbouring lines:
//! their Laplacians are added to diag(d) and to S.
//!
//! [theory.md]: https://github.com/taxel/taxel/blob/main/docs/theory.md

use super::coupling::{Chain, Couplings, diagonal};
use super::rest::{Potentials, Solved};
use super::{LinearCircuit, SheetOver};
use crate::circuit::ends::{LEAK_SIEMENS, join_groups};
use crate::circuit::reading::{Blocks, Readings};
use crate::circuit::{NotPassive, OperatingPoint};
use taxel_linalg::{Spd, View, ViewMut, mirror, multiply, multiply_lower, sum};

/// A circuit of lines without resistance, solved at one frame of conductances.
pub(super) struct LumpedPoint {
    readings: Readings,
    pub(super) potentials: Option<Potentials>,
    /// Lines of the smaller side (m) and of the larger (n); matrices below are m×n or m×m, row-major.
    pub(super) small: usize,
    pub(super) large: usize,
    /// The smaller side is the columns.
    pub(super) transposed: bool,
    small_end: Vec<f64>,
    large_end: Vec<f64>,
    pub(super) conductance: Vec<f64>,
    pub(super) sheet: Option<SheetPoint>,
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

/// What a sheet adds at one frame of conductances: with the chain of the larger side, diag(d) is tridiagonal.
pub(super) struct SheetPoint {
    pub(super) couplings: Couplings,
    pub(super) chain: Chain,
    d: Vec<f64>,
}

impl SheetPoint {
    fn new(over: &SheetOver, transposed: bool) -> Self {
        let (small, large) = if transposed {
            (&over.columns, &over.rows)
        } else {
            (&over.rows, &over.columns)
        };
        Self {
            couplings: Couplings::new(over.sheet, small, large),
            chain: Chain::new(large.len()),
            d: vec![0.0; large.len()],
        }
    }
}

impl LumpedPoint {
    pub(super) fn new(circuit: &LinearCircuit) -> Self {
        let ends = &circuit.ends;
        let (rows, columns) = (ends.row_selected.len(), ends.column_selected.len());
        let transposed = columns < rows;
        let (small, large) = (rows.min(columns), rows.max(columns));
        let (small_end, large_end) = if transposed {
            (ends.column_unselected.clone(), ends.row_unselected.clone())
        } else {
            (ends.row_unselected.clone(), ends.column_unselected.clone())
        };
        Self {
            readings: Readings::new(ends),
            potentials: Potentials::new(ends, transposed),
            small,
            large,
            transposed,
            small_end,
            large_end,
            conductance: vec![0.0; small * large],
            sheet: circuit
                .sheet
                .as_ref()
                .map(|over| SheetPoint::new(over, transposed)),
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
        self.readings.is_floating()
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
        if let Some(sheet) = &mut self.sheet {
            sheet.d.copy_from_slice(&self.inverse_d);
        }
        for d in &mut self.inverse_d {
            *d = 1.0 / *d;
        }
        Ok(())
    }

    /// H = G T⁻¹, T the diagonal d with the couplings of the larger side.
    fn set_h(&mut self) -> Result<(), NotPassive> {
        let g = &self.conductance;
        if let Some(sheet) = &mut self.sheet {
            sheet.couplings.update(g);
            if !sheet.chain.factorise(&sheet.d, &sheet.couplings.large) {
                return Err(NotPassive);
            }
        }
        self.h.copy_from_slice(g);
        let Self {
            h,
            sheet,
            inverse_d,
            ..
        } = self;
        divide(sheet.as_ref(), inverse_d, h);
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
        if let Some(sheet) = &self.sheet {
            let chain = &sheet.couplings.small;
            for i in 0..m {
                self.schur[i * m + i] += diagonal(chain, i);
            }
            for (i, coupling) in chain.iter().enumerate() {
                self.schur[(i + 1) * m + i] -= coupling;
            }
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

    /// Calls `visit(index in m×n, index by taxel, row, column, blocks)` for every taxel.
    #[inline(always)]
    pub(super) fn each(&self, mut visit: impl FnMut(usize, usize, usize, usize, &Blocks)) {
        let (m, n) = (self.small, self.large);
        for i in 0..m {
            let diagonal = self.p[i * m + i];
            for j in 0..n {
                let at = i * n + j;
                let (p, q, taxel, row, column) = if self.transposed {
                    (self.q[j], diagonal, j * m + i, j, i)
                } else {
                    (diagonal, self.q[j], at, i, j)
                };
                let mut blocks = self.readings.blocks(p, q, self.k[at]);
                if let Some(potentials) = &self.potentials {
                    [blocks.row, blocks.column] = potentials.at(i, j);
                }
                visit(at, taxel, row, column, &blocks);
            }
        }
    }

    /// The derivative of every taxel's reading by the blocks: `take(index in m×n, partials)`.
    pub(super) fn each_partial(&self, mut take: impl FnMut(usize, &Blocks)) {
        self.each(|at, _, row, column, blocks| {
            take(at, &self.readings.partials(row, column, blocks));
        });
    }

    /// What applies the inverse of the whole nodal matrix.
    pub(super) fn solved<'a>(
        p: &'a [f64],
        h: &'a [f64],
        inverse_d: &'a [f64],
        sheet: &'a Option<SheetPoint>,
    ) -> Solved<'a> {
        Solved {
            p,
            h,
            inverse_d,
            sheet: sheet.as_ref(),
        }
    }
}

impl OperatingPoint for LumpedPoint {
    fn set(&mut self, siemens: &[f64]) -> Result<(), NotPassive> {
        let (m, n) = (self.small, self.large);
        assert_eq!(siemens.len(), m * n, "one conductance per taxel");
        Self::gather(self.transposed, m, n, siemens, &mut self.conductance);
        if self.floating() {
            join_groups(&mut self.conductance, n);
        }
        self.work.stale = true;
        self.set_columns()?;
        self.set_h()?;
        let g = &self.conductance;
        multiply_lower(
            ViewMut::new(&mut self.schur, m, m),
            View::new(g, m, n),
            View::new(&self.h, m, n).transpose(),
        );
        for value in &mut self.schur {
            *value = -*value;
        }
        self.complete_schur();
        if !self.spd.invert(&self.schur, &mut self.p) {
            return Err(NotPassive);
        }
        multiply(
            ViewMut::new(&mut self.k, m, n),
            View::new(&self.p, m, m),
            View::new(&self.h, m, n),
        );
        match &self.sheet {
            Some(sheet) => sheet.chain.inverse_diagonal_into(&mut self.q),
            None => self.q.copy_from_slice(&self.inverse_d),
        }
        for (h, k) in self.h.chunks_exact(n).zip(self.k.chunks_exact(n)) {
            for ((q, h), k) in self.q.iter_mut().zip(h).zip(k) {
                *q += h * k;
            }
        }
        if let Some(potentials) = &mut self.potentials {
            potentials.set(Self::solved(&self.p, &self.h, &self.inverse_d, &self.sheet));
        }
        Ok(())
    }

    fn predict_into(&self, volts: &mut [f64]) {
        if self.transposed || self.potentials.is_some() {
            self.each(|_, taxel, row, column, blocks| {
                volts[taxel] = self.readings.volts(row, column, blocks);
            });
            return;
        }
        let (m, n) = (self.small, self.large);
        let lines = volts.chunks_exact_mut(n).zip(self.k.chunks_exact(n));
        for (row, (out, k)) in lines.enumerate() {
            let p = self.p[row * m + row];
            self.readings.volts_of_row(row, p, &self.q, k, out);
        }
    }

    fn jvp_into(&mut self, direction: &[f64], out: &mut [f64]) {
        super::derivative::forward(self, direction, out);
    }

    fn vjp_into(&mut self, weights: &[f64], out: &mut [f64]) {
        super::derivative::adjoint(self, weights, out);
    }
}

/// rows ← rows T⁻¹, m×n.
pub(super) fn divide(sheet: Option<&SheetPoint>, inverse_d: &[f64], rows: &mut [f64]) {
    if let Some(sheet) = sheet {
        return sheet.chain.solve_rows(rows);
    }
    for line in rows.chunks_exact_mut(inverse_d.len()) {
        for (value, inverse) in line.iter_mut().zip(inverse_d) {
            *value *= inverse;
        }
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
