//! The e-Cone's network as its inverse sees it: what a frame fixes, and what is iterated.

use super::sideways::{Sideways, Tridiagonal};
use crate::circuit::network::coupling::add_laplacian;
use crate::material::Sheet;
use taxel_linalg::{Number, Spd, View, ViewMut, multiply, wide};

/// A column conducts at least this share of its end: less is an estimate on its way, or noise.
const LEAST_COLUMN: f64 = 0.1;

/// Arrays over the rows that carry current (m) and the live columns (n), row-major.
pub(super) struct Network {
    pub(super) m: usize,
    pub(super) n: usize,
    /// K, ohms.
    pub(super) k: Vec<f64>,
    /// P_rr, ohms.
    pub(super) p: Vec<f64>,
    /// g_c, siemens.
    pub(super) g_c: Vec<f64>,
    pub(super) h: Vec<f64>,
    pub(super) d: Vec<f64>,
    pub(super) g: Vec<f64>,
    /// S, full and symmetric.
    pub(super) s: Vec<f64>,
    pub(super) product: Vec<f64>,
    pub(super) spd: Spd,
    /// Of a continuous sheet: the chain of the columns is added to diag(d), that of the rows to S.
    pub(super) sideways: Option<Sideways>,
    /// 1 − ΣH, and what the columns' chain takes from each.
    headroom: Vec<f64>,
    /// Under a sheet T, and H T.
    tridiagonal: Tridiagonal<f64>,
    h_t: Vec<f64>,
    taken: Vec<f64>,
}

impl Network {
    pub(super) fn new(m: usize, n: usize) -> Self {
        Self {
            m,
            n,
            k: vec![0.0; m * n],
            p: vec![0.0; m],
            g_c: vec![0.0; n],
            h: vec![0.0; m * n],
            d: vec![0.0; n],
            g: vec![0.0; m * n],
            s: vec![0.0; m * m],
            product: vec![0.0; m * m],
            spd: Spd::new(m),
            sideways: None,
            headroom: vec![0.0; n],
            tridiagonal: Tridiagonal::new(m, n),
            h_t: vec![0.0; m * n],
            taken: vec![0.0; n],
        }
    }

    /// Takes another shape; allocates nothing when it is no larger than the one it was made for.
    pub(super) fn resize(&mut self, m: usize, n: usize) {
        (self.m, self.n) = (m, n);
        for rectangle in [&mut self.k, &mut self.h, &mut self.g, &mut self.h_t] {
            rectangle.resize(m * n, 0.0);
        }
        for square in [&mut self.s, &mut self.product] {
            square.resize(m * m, 0.0);
        }
        self.p.resize(m, 0.0);
        self.g_c.resize(n, 0.0);
        for line in [&mut self.d, &mut self.headroom, &mut self.taken] {
            line.resize(n, 0.0);
        }
        self.spd.resize(m);
        self.tridiagonal.resize(m, n);
    }

    /// H ← S K, then d ← g_c/(1 − ΣH) with the denominator held above `floor`; under a sheet T (1 − ΣH) = g_c with the
    /// columns' chain in T. Returns the least denominator and its column.
    pub(super) fn columns_from_s(&mut self, floor: f64) -> (f64, usize) {
        let (m, n) = (self.m, self.n);
        multiply(
            ViewMut::new(&mut self.h, m, n),
            View::new(&self.s, m, m),
            View::new(&self.k, m, n),
        );
        self.columns_from_h(floor)
    }

    /// The same from an H that is there.
    pub(super) fn columns_from_h(&mut self, floor: f64) -> (f64, usize) {
        let n = self.n;
        self.d.fill(1.0);
        let (d, h) = (&mut self.d[..n], &self.h);
        wide(
            #[inline(always)]
            || {
                for line in h.chunks_exact(n) {
                    for (d, h) in d.iter_mut().zip(line) {
                        *d -= h;
                    }
                }
            },
        );
        let least = self.columns_from_headroom(floor);
        if let Some(sideways) = &self.sideways {
            self.tridiagonal.set(&self.d, &sideways.now.large);
        }
        least
    }

    /// The same where d is 1 − ΣH; T is not set.
    pub(super) fn columns_from_headroom(&mut self, floor: f64) -> (f64, usize) {
        if let Some(sideways) = &self.sideways {
            self.headroom.copy_from_slice(&self.d);
            self.taken.fill(0.0);
            add_laplacian(&sideways.now.large, &self.headroom, &mut self.taken);
        }
        let mut least = (f64::INFINITY, 0);
        for (c, (d, g_c)) in self.d.iter_mut().zip(&self.g_c).enumerate() {
            if *d < least.0 || !d.is_finite() {
                least = (*d, c);
            }
            *d = g_c / d.max(floor);
        }
        if self.sideways.is_some() {
            let columns = self.d.iter_mut().zip(&self.g_c);
            let columns = columns.zip(self.headroom.iter().zip(&self.taken));
            for ((d, g_c), (headroom, taken)) in columns {
                *d -= taken / headroom.max(floor);
                *d = d.max(LEAST_COLUMN * g_c);
            }
        }
        least
    }

    /// Under a sheet: brings the couplings, H and d nearer to where they agree, without another product S K. The change δ of
    /// the coupling of rows i and i + 1, which is an entry of S off its diagonal, takes δ K_{i+1} from row i of H
    /// and δ K_i from row i + 1. Returns the least denominator, which is above all without a sheet: then nothing happens.
    pub(super) fn settle(&mut self, floor: f64) -> f64 {
        let Some(sideways) = &mut self.sideways else {
            return f64::INFINITY;
        };
        let matrix = &mut self.tridiagonal;
        matrix.times(&self.h, &mut self.h_t);
        sideways.find_next(matrix, &self.h_t, &self.h, &self.k);
        sideways.go_on(&mut self.h, &self.k);
        self.columns_from_h(floor).0
    }

    /// G ← H diag(d) (H T under a sheet). Returns the largest conductance and the largest change of one.
    pub(super) fn conductances(&mut self) -> (f64, f64) {
        let n = self.n;
        let is_chained = self.sideways.is_some();
        if is_chained {
            self.tridiagonal.times(&self.h, &mut self.h_t);
        }
        let (g, d, row) = (&mut self.g, &self.d, &mut self.headroom[..n]);
        let lines = if is_chained { &self.h_t } else { &self.h };
        let (mut largest, mut change) = ([0f64; LANES], [0f64; LANES]);
        wide(
            #[inline(always)]
            || {
                for (g, line) in g.chunks_exact_mut(n).zip(lines.chunks_exact(n)) {
                    if is_chained {
                        take(g, line, &mut largest, &mut change);
                        continue;
                    }
                    for ((row, h), d) in row.iter_mut().zip(line).zip(d) {
                        *row = h * d;
                    }
                    take(g, row, &mut largest, &mut change);
                }
            },
        );
        (most(largest), most(change) + finite(&self.d))
    }

    /// The couplings that follow from G.
    pub(super) fn advance_couplings(&mut self) {
        if let Some(sideways) = &mut self.sideways {
            sideways.find_next(&mut self.tridiagonal, &self.g, &self.h, &self.k);
            sideways.advance();
        }
    }
}

impl Network {
    /// Takes a sheet, or its absence. True when it had none before, or has none now: then [`Sideways::reshape`] is due.
    pub(super) fn takes(&mut self, sheet: Option<Sheet>) -> bool {
        match (&mut self.sideways, sheet) {
            (Some(sideways), Some(sheet)) => sideways.now.sheet = sheet,
            (None, None) => {}
            (sideways, sheet) => {
                *sideways = sheet.map(Sideways::new);
                return true;
            }
        }
        false
    }

    /// Takes couplings as an iteration mixed them; those of the rows into S.
    pub(super) fn take_couplings(&mut self, mixed: &[f64]) {
        if let Some(sideways) = &mut self.sideways {
            sideways.take(mixed);
            sideways.couple_rows(&mut self.s);
        }
    }

    /// How many couplings there are.
    pub(super) fn couplings(&self) -> usize {
        self.sideways.as_ref().map_or(0, |s| s.next.len())
    }
}

/// Maxima kept side by side, so that the compiler may use vectors.
pub(super) const LANES: usize = 8;

/// Puts a line of new values in the place of `g`, and raises the largest of them and the largest change.
#[inline(always)]
pub(super) fn take<T: Number>(
    g: &mut [T],
    line: &[T],
    largest: &mut [T; LANES],
    change: &mut [T; LANES],
) {
    let (g, g_rest) = g.as_chunks_mut::<LANES>();
    let (line, rest) = line.as_chunks::<LANES>();
    for (g, line) in g.iter_mut().zip(line) {
        for i in 0..LANES {
            raise(&mut largest[i], line[i].size());
            raise(&mut change[i], (line[i] - g[i]).size());
        }
        *g = *line;
    }
    for (g, value) in g_rest.iter_mut().zip(rest) {
        raise(&mut largest[0], value.size());
        raise(&mut change[0], (*value - *g).size());
        *g = *value;
    }
}

/// The largest of maxima that were kept side by side.
pub(super) fn most<T: Number>(lanes: [T; LANES]) -> f64 {
    lanes.into_iter().map(T::double).fold(0.0, f64::max)
}

/// 0, or what is no number where one of these is none: that is not larger than anything, and multiplying lets it through.
pub(super) fn finite<T: Number>(values: &[T]) -> f64 {
    values.iter().map(|value| value.double() * 0.0).sum()
}

#[inline(always)]
fn raise<T: PartialOrd>(most: &mut T, value: T) {
    if value > *most {
        *most = value;
    }
}
