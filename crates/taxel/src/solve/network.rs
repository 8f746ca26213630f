//! The e-Cone's network as its inverse sees it: what a frame fixes, and what is iterated.

use taxel_linalg::{Spd, View, ViewMut, multiply};

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
        self.p.resize(m, 0.0);
        self.g_c.resize(n, 0.0);
        self.d.resize(n, 0.0);
        self.spd.resize(m);
    }

    /// H ← S K, then d ← g_c/(1 − ΣH) with the denominator held above `floor`. Returns the least
    /// denominator and its column.
    pub(super) fn columns_from_s(&mut self, floor: f64) -> (f64, usize) {
        let (m, n) = (self.m, self.n);
        multiply(
            ViewMut::new(&mut self.h, m, n),
            View::new(&self.s, m, m),
            View::new(&self.k, m, n),
        );
        self.d.fill(1.0);
        for line in self.h.chunks_exact(n) {
            for (d, h) in self.d.iter_mut().zip(line) {
                *d -= h;
            }
        }
        let mut least = (f64::INFINITY, 0);
        for (c, (d, g_c)) in self.d.iter_mut().zip(&self.g_c).enumerate() {
            if *d < least.0 || !d.is_finite() {
                least = (*d, c);
            }
            *d = g_c / d.max(floor);
        }
        least
    }

    /// G ← H diag(d). Returns the largest conductance and the largest change of one.
    pub(super) fn conductances(&mut self) -> (f64, f64) {
        let n = self.n;
        let (mut largest, mut change) = ([0f64; LANES], [0f64; LANES]);
        for (g, h) in self.g.chunks_exact_mut(n).zip(self.h.chunks_exact(n)) {
            let chunks = g.chunks_mut(LANES).zip(h.chunks(LANES));
            for ((g, h), d) in chunks.zip(self.d.chunks(LANES)) {
                let lanes = largest.iter_mut().zip(&mut change);
                for (((g, h), d), (largest, change)) in g.iter_mut().zip(h).zip(d).zip(lanes) {
                    let value = h * d;
                    raise(largest, value.abs());
                    raise(change, (value - *g).abs());
                    *g = value;
                }
            }
        }
        let most = |lanes: [f64; LANES]| lanes.into_iter().fold(0f64, f64::max);
        // A value that is no number is not larger than anything: multiplying lets it through.
        let finite = self.d.iter().map(|d| d * 0.0).sum::<f64>();
        (most(largest), most(change) + finite)
    }
}

/// Maxima kept side by side, so that the compiler may use vectors.
const LANES: usize = 8;

#[inline(always)]
fn raise(most: &mut f64, value: f64) {
    *most = if value > *most { value } else { *most };
}
