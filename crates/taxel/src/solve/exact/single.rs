//! The products of a round in single precision, which take half of the time.

use super::super::network::{LANES, take};
use super::state::unpack;
use taxel_linalg::{Number, View, ViewMut, multiply_lower, wide};

/// As in [`super::super::network::Network`], row-major. Under a sheet, only the products are done here.
pub(super) struct Single {
    m: usize,
    n: usize,
    /// K, ohms.
    pub(super) k: Vec<f32>,
    s: Vec<f32>,
    h: Vec<f32>,
    g: Vec<f32>,
    product: Vec<f32>,
    /// d, of one column each.
    d: Vec<f32>,
    /// One row of G.
    row: Vec<f32>,
}

impl Single {
    pub(super) fn new(m: usize, n: usize) -> Self {
        Self {
            m,
            n,
            k: vec![0.0; m * n],
            s: vec![0.0; m * m],
            h: vec![0.0; m * n],
            g: vec![0.0; m * n],
            product: vec![0.0; m * m],
            d: vec![0.0; n],
            row: vec![0.0; n],
        }
    }

    /// Takes another shape; allocates nothing when it is no larger than the one it was made for.
    pub(super) fn resize(&mut self, m: usize, n: usize) {
        (self.m, self.n) = (m, n);
        for rectangle in [&mut self.k, &mut self.h, &mut self.g] {
            rectangle.resize(m * n, 0.0);
        }
        for square in [&mut self.s, &mut self.product] {
            square.resize(m * m, 0.0);
        }
        self.d.resize(n, 0.0);
        self.row.resize(n, 0.0);
    }

    /// H ← S K, d ← g_c/(1 − ΣH), G ← H diag(d). The largest conductance and the largest change of one; nothing where a
    /// denominator is not positive. `is_diagonal`: nothing of S stands off its diagonal.
    pub(super) fn conductances(
        &mut self,
        packed: &[f64],
        is_diagonal: bool,
        g_c: &[f64],
        d: &mut [f64],
    ) -> Option<(f64, f64)> {
        let (m, n) = (self.m, self.n);
        if is_diagonal {
            self.scale_rows(packed);
        } else {
            unpack(packed, &mut self.s, m, |s| s as f32);
            f32::product(
                ViewMut::new(&mut self.h, m, n),
                View::new(&self.s, m, m),
                View::new(&self.k, m, n),
            );
        }
        self.columns(d);
        let columns = d.iter_mut().zip(&mut self.d).zip(g_c);
        for ((d, single), g_c) in columns {
            if *d <= 0.0 {
                return None;
            }
            *d = g_c / *d;
            *single = *d as f32;
        }
        Some(self.replace())
    }

    /// H ← S K, of a full S.
    pub(super) fn times_k(&mut self, s: &[f64], h: &mut [f64]) {
        let (m, n) = (self.m, self.n);
        narrow(&mut self.s, s);
        f32::product(
            ViewMut::new(&mut self.h, m, n),
            View::new(&self.s, m, m),
            View::new(&self.k, m, n),
        );
        widen(h, &self.h);
    }

    /// Takes G and H.
    pub(super) fn take(&mut self, g: &[f64], h: &[f64]) {
        narrow(&mut self.g, g);
        narrow(&mut self.h, h);
    }

    /// H ← diag(S) K.
    fn scale_rows(&mut self, packed: &[f64]) {
        let lines = self
            .h
            .chunks_exact_mut(self.n)
            .zip(self.k.chunks_exact(self.n));
        for (i, (h, k)) in lines.enumerate() {
            let s = packed[i * (i + 1) / 2 + i] as f32;
            h.iter_mut().zip(k).for_each(|(h, k)| *h = s * k);
        }
    }

    /// d ← 1 − ΣH, in double precision.
    fn columns(&self, d: &mut [f64]) {
        d.fill(1.0);
        wide(
            #[inline(always)]
            || {
                for line in self.h.chunks_exact(self.n) {
                    d.iter_mut()
                        .zip(line)
                        .for_each(|(d, h)| *d -= f64::from(*h));
                }
            },
        );
    }

    fn replace(&mut self) -> (f64, f64) {
        let (mut largest, mut change) = ([0f32; LANES], [0f32; LANES]);
        let n = self.n;
        let Self { g, h, d, row, .. } = self;
        wide(
            #[inline(always)]
            || {
                for (g, h) in g.chunks_exact_mut(n).zip(h.chunks_exact(n)) {
                    for ((row, h), d) in row.iter_mut().zip(h).zip(&*d) {
                        *row = h * d;
                    }
                    take(g, row, &mut largest, &mut change);
                }
            },
        );
        let most = |lanes: [f32; LANES]| f64::from(lanes.into_iter().fold(0f32, f32::max));
        // A value that is no number is not larger than anything: multiplying lets it through.
        let finite = d.iter().map(|d| f64::from(d * 0.0)).sum::<f64>();
        (most(largest), most(change) + finite)
    }

    /// The lower triangle of G Hᵀ.
    pub(super) fn product_into(&mut self, out: &mut [f64]) {
        let (m, n) = (self.m, self.n);
        multiply_lower(
            ViewMut::new(&mut self.product, m, m),
            View::new(&self.g, m, n),
            View::new(&self.h, m, n).transpose(),
        );
        widen(out, &self.product);
    }

    /// What the next round in double precision compares with.
    pub(super) fn conductances_into(&self, g: &mut [f64]) {
        widen(g, &self.g);
    }
}

fn narrow(out: &mut [f32], values: &[f64]) {
    wide(
        #[inline(always)]
        || {
            out.iter_mut()
                .zip(values)
                .for_each(|(out, value)| *out = *value as f32)
        },
    );
}

fn widen(out: &mut [f64], values: &[f32]) {
    wide(
        #[inline(always)]
        || {
            out.iter_mut()
                .zip(values)
                .for_each(|(out, value)| *out = f64::from(*value))
        },
    );
}
