//! Inverses of small symmetric positive definite matrices: the sweep operator (Goodnight 1979, "A Tutorial on the SWEEP
//! Operator"), two pivots at a time. For up to some 100 rows faster than a factor and its inverse, whose blocks are made for
//! large ones.

use pulp::{Simd, WithSimd};

/// Lines are filled up to a multiple of the widest vector.
const LANES: usize = 8;

/// Scratch of [`Swept::invert`].
pub(crate) struct Swept {
    /// The lower triangle, line by line, with an even number of lines.
    lower: Vec<f64>,
    rows: PivotRows,
}

/// What two pivots take from all lines: line i ← line i + f_i r + g_i q.
struct PivotRows {
    /// −(the first pivot's row); by symmetry also its column.
    f: Vec<f64>,
    /// The same of the second, after the first.
    g: Vec<f64>,
    r: Vec<f64>,
    q: Vec<f64>,
}

impl Swept {
    /// For up to n × n.
    pub(crate) fn new(n: usize) -> Self {
        let (even, stride) = padded(n);
        let line = || vec![0.0; stride];
        Self {
            lower: vec![0.0; even * stride],
            rows: PivotRows {
                f: line(),
                g: line(),
                r: line(),
                q: line(),
            },
        }
    }

    /// The whole inverse of a matrix of which the lower triangle is read, both row-major. False where it is not positive definite.
    pub(crate) fn invert(&mut self, n: usize, matrix: &[f64], out: &mut [f64]) -> bool {
        let most = matrix
            .iter()
            .step_by(n + 1)
            .fold(0.0, |a: f64, b| a.max(*b));
        if !most.is_normal() {
            return false;
        }
        // By a power of two, so without rounding: all pivots are below 1 (see `PivotRows::form`).
        let exponent = 2045_u64.saturating_sub(most.to_bits() >> 52).max(1);
        pulp::Arch::new().dispatch(Inversion {
            swept: self,
            n,
            matrix,
            out,
            scale: f64::from_bits(exponent << 52),
        })
    }
}

/// Lines, an even number, and numbers in a line.
fn padded(n: usize) -> (usize, usize) {
    (n.next_multiple_of(2), n.next_multiple_of(LANES))
}

struct Inversion<'a> {
    swept: &'a mut Swept,
    n: usize,
    matrix: &'a [f64],
    out: &'a mut [f64],
    scale: f64,
}

impl WithSimd for Inversion<'_> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> bool {
        let (n, scale) = (self.n, self.scale);
        let (even, stride) = padded(n);
        let lower = &mut self.swept.lower[..even * stride];
        let lines = lower.chunks_exact_mut(stride);
        for (i, (line, given)) in lines.zip(self.matrix.chunks_exact(n)).enumerate() {
            let (own, above) = line.split_at_mut(i + 1);
            for (value, given) in own.iter_mut().zip(given) {
                *value = given * scale;
            }
            above.fill(0.0);
        }
        if even > n {
            lower[n * stride..].fill(0.0);
            lower[n * stride + n] = 1.0;
        }
        let rows = &mut self.swept.rows;
        let mut is_definite = true;
        for pivot in (0..even).step_by(2) {
            is_definite &= rows.form(lower, stride, pivot);
            rows.sweep(simd, lower, stride);
            rows.settle(lower, stride, pivot);
        }
        for (i, line) in lower.chunks_exact(stride).take(n).enumerate() {
            for (j, value) in line[..=i].iter().enumerate() {
                let value = -value * scale;
                self.out[i * n + j] = value;
                self.out[j * n + i] = value;
            }
        }
        is_definite
    }
}

impl PivotRows {
    /// From the lines `pivot` and the next one. False where a pivot is not positive.
    #[inline(always)]
    fn form(&mut self, lower: &[f64], stride: usize, pivot: usize) -> bool {
        let (k, next) = (pivot, pivot + 1);
        let Self { f, g, r, q } = self;
        let (f, g) = (&mut f[..stride], &mut g[..stride]);
        f[lower.len() / stride..].fill(0.0);
        g[lower.len() / stride..].fill(0.0);
        // Left of the diagonal from the line, below it from the column.
        f[..=k].copy_from_slice(&lower[k * stride..][..=k]);
        g[..=next].copy_from_slice(&lower[next * stride..][..=next]);
        f[next] = g[k];
        for (j, line) in lower.chunks_exact(stride).enumerate().skip(next + 1) {
            (f[j], g[j]) = (line[k], line[next]);
        }
        let (first, below) = (f[k], f[next]);
        let inverse = 1.0 / first;
        for (r, f) in r.iter_mut().zip(f) {
            (*r, *f) = (*f * inverse, -*f);
        }
        // A pivot's column becomes itself over the pivot; x − x (1 − 1/p) says so without a branch, and loses nothing while p ≤ 1.
        r[k] = 1.0 - inverse;
        for (g, r) in g.iter_mut().zip(&*r) {
            *g = below * *r - *g;
        }
        g[k] = -below * inverse;
        let second = -g[next];
        let inverse = 1.0 / second;
        for (q, g) in q.iter_mut().zip(g) {
            *q = -*g * inverse;
        }
        q[next] = 1.0 - inverse;
        first > 0.0 && second > 0.0
    }

    #[inline(always)]
    fn sweep<S: Simd>(&self, simd: S, lower: &mut [f64], stride: usize) {
        let (r, _) = S::as_simd_f64s(&self.r);
        let (q, _) = S::as_simd_f64s(&self.q);
        let lines = lower.chunks_exact_mut(stride).zip(&self.f).zip(&self.g);
        for (i, ((line, f), g)) in lines.enumerate() {
            let (f, g) = (simd.splat_f64s(*f), simd.splat_f64s(*g));
            let (line, _) = S::as_mut_simd_f64s(line);
            let lower = &mut line[..i / S::F64_LANES + 1];
            // Fused where the processor does so at once: else that is a call for each number.
            for (value, (r, q)) in lower.iter_mut().zip(r.iter().zip(q)) {
                *value = simd.mul_add_e_f64s(g, *q, simd.mul_add_e_f64s(f, *r, *value));
            }
        }
    }

    /// The pivots' own lines.
    #[inline(always)]
    fn settle(&self, lower: &mut [f64], stride: usize, pivot: usize) {
        let next = pivot + 1;
        let (r, q) = (&self.r, &self.q);
        // Of a pivot's own place −1/p.
        let (first, second) = (r[pivot] - 1.0, q[next] - 1.0);
        let (lines, g) = (&mut lower[pivot * stride..], self.g[pivot]);
        for (value, (r, q)) in lines[..pivot].iter_mut().zip(r.iter().zip(q)) {
            *value = r + g * q;
        }
        lines[pivot] = first + g * q[pivot];
        let own = &mut lines[stride..];
        own[..next].copy_from_slice(&q[..next]);
        own[next] = second;
    }
}
