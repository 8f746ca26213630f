//! A round in single precision, which takes half of the time: products, couplings of a sheet, changes.

use super::super::network::{LANES, Network, finite, most, take};
use super::super::sideways::Tridiagonal;
use super::rounds::FLOOR;
use super::state::unpack;
use taxel_linalg::{Number, View, ViewMut, multiply_lower, wide};

/// As in [`Network`], row-major.
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
    /// Under a sheet T, and H T.
    tridiagonal: Tridiagonal<f32>,
    h_t: Vec<f32>,
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
            tridiagonal: Tridiagonal::new(m, n),
            h_t: vec![0.0; m * n],
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
        self.d.resize(n, 0.0);
        self.row.resize(n, 0.0);
        self.tridiagonal.resize(m, n);
    }

    /// H ← S K, d ← g_c/(1 − ΣH), G ← H diag(d); under a sheet couplings, H and d are brought nearer to each other as by
    /// [`Network::settle`], and G ← H T. Leaves d in the network. The largest conductance and the largest change of one;
    /// nothing where a denominator is not positive. `is_diagonal`: nothing of S stands off its diagonal.
    pub(super) fn conductances(
        &mut self,
        packed: &[f64],
        is_diagonal: bool,
        network: &mut Network,
    ) -> Option<(f64, f64)> {
        let (m, n) = (self.m, self.n);
        if let Some(sideways) = &mut network.sideways {
            sideways.take(&packed[m * (m + 1) / 2..]);
        }
        if is_diagonal {
            self.scale_rows(packed);
        } else {
            unpack(packed, &mut self.s, m, |s| s as f32);
            if let Some(sideways) = &network.sideways {
                sideways.couple_rows(&mut self.s);
            }
            f32::product(
                ViewMut::new(&mut self.h, m, n),
                View::new(&self.s, m, m),
                View::new(&self.k, m, n),
            );
        }
        self.columns(network)?;
        if network.sideways.is_some() {
            return self.settled(network);
        }
        for (single, d) in self.d.iter_mut().zip(&network.d) {
            *single = *d as f32;
        }
        Some(self.replace())
    }

    fn settled(&mut self, network: &mut Network) -> Option<(f64, f64)> {
        let sideways = network.sideways.as_mut()?;
        let matrix = &mut self.tridiagonal;
        matrix.set(&network.d, &sideways.now.large);
        matrix.times(&self.h, &mut self.h_t);
        sideways.find_next(matrix, &self.h_t, &self.h, &self.k);
        sideways.go_on(&mut self.h, &self.k);
        self.columns(network)?;
        let sideways = network.sideways.as_mut()?;
        self.tridiagonal.set(&network.d, &sideways.now.large);
        self.tridiagonal.times(&self.h, &mut self.h_t);
        let (mut largest, mut change) = ([0f32; LANES], [0f32; LANES]);
        let Self { g, h_t, .. } = self;
        wide(
            #[inline(always)]
            || take(g, h_t, &mut largest, &mut change),
        );
        Some((most(largest), most(change) + finite(&network.d)))
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

    /// d of the network, from H. Nothing where a denominator is not positive.
    fn columns(&self, network: &mut Network) -> Option<()> {
        let d = &mut network.d;
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
        (network.columns_from_headroom(FLOOR).0 > 0.0).then_some(())
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
        (most(largest), most(change) + finite(d))
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
