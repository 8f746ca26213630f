//! What flows sideways in a continuous sheet: couplings of neighbouring rows and columns that hang on the conductances, which
//! hang on them. No product of matrices is needed to bring the two together, so that they are before every one of these.

use crate::circuit::network::coupling::{Couplings, diagonal};
use crate::material::Sheet;
use taxel_linalg::{Number, sum, wide};

/// A change that comes back with its own sign is not taken to come back nearly whole.
const MAX_FEEDBACK: f64 = 0.5;

/// Couplings on their way.
pub(super) struct Sideways {
    /// Those of rows are `small`, those of columns `large`.
    pub(super) now: Couplings,
    /// P_rr − Σ K M, the diagonal of Λ⁻¹: ohms.
    left: Vec<f64>,
    /// λ s of each pair of rows, s of Λ⁻¹ beside its diagonal; and its slope by λ, ohms.
    through: Vec<f64>,
    slope: Vec<f64>,
    found_rows: Vec<f64>,
    found_columns: Vec<f64>,
    /// What comes back to a coupling of rows of a change of it.
    back: Vec<f64>,
    /// Whether couplings have come near to where they lead.
    pub(super) is_late: bool,
}

impl Sideways {
    pub(super) fn new(sheet: Sheet) -> Self {
        Self {
            now: Couplings::new(sheet, &[], &[]),
            left: Vec::new(),
            through: Vec::new(),
            slope: Vec::new(),
            found_rows: Vec::new(),
            found_columns: Vec::new(),
            back: Vec::new(),
            is_late: false,
        }
    }

    /// Takes rows and columns at these places, with nothing known of their couplings. Allocates nothing for no more of them
    /// than at first.
    pub(super) fn reshape(&mut self, rows: &[usize], columns: &[usize]) {
        self.now.reshape(rows, columns);
        self.left.resize(rows.len(), 0.0);
        let pairs = self.now.small.len();
        for list in [
            &mut self.through,
            &mut self.slope,
            &mut self.found_rows,
            &mut self.back,
        ] {
            list.resize(pairs, 0.0);
        }
        self.found_columns.resize(self.now.large.len(), 0.0);
    }

    /// Begins with nothing known.
    pub(super) fn forget(&mut self) {
        self.now.small.fill(0.0);
        self.now.large.fill(0.0);
    }

    /// What is left of a row's P_rr without what flows through columns.
    pub(super) fn set_left(&mut self, row: usize, left: f64) {
        self.left[row] = left;
    }

    /// λ s of all pairs. Λ is tridiagonal; two neighbours' entries of its inverse are tied by q q' − s² = s/λ, q being the diagonal.
    pub(super) fn pass_through(&mut self) {
        for (i, coupling) in self.now.small.iter().enumerate() {
            let both = 4.0 * self.left[i] * self.left[i + 1] * coupling;
            let root = (1.0 + both * coupling).sqrt();
            self.through[i] = 0.5 * (root - 1.0);
            self.slope[i] = 0.5 * both / root;
        }
    }

    /// Λ_rr.
    pub(super) fn total(&self, row: usize) -> f64 {
        (1.0 + diagonal(&self.through, row)) / self.left[row]
    }

    /// out ← row r of Λ M.
    #[inline(always)]
    pub(super) fn row_of<T: Number>(&self, r: usize, shares: &[T], out: &mut [T]) {
        let n = out.len();
        let line = |r: usize| &shares[r * n..(r + 1) * n];
        let total = T::of(self.total(r));
        for (out, share) in out.iter_mut().zip(line(r)) {
            *out = total * *share;
        }
        let mut take = |coupling: f64, neighbour: &[T]| {
            let coupling = T::of(coupling);
            for (out, share) in out.iter_mut().zip(neighbour) {
                *out -= coupling * *share;
            }
        };
        if let Some(before) = r.checked_sub(1) {
            take(self.now.small[before], line(before));
        }
        if let Some(coupling) = self.now.small.get(r) {
            take(*coupling, line(r + 1));
        }
    }

    /// Goes on with the couplings that follow from G = Λ M. A change of a coupling of two rows changes both rows of G, and these the
    /// coupling: each is corrected by how much of its change comes back. Those of columns change G only through M.
    pub(super) fn advance<T: Number>(&mut self, g: &[T], shares: &[T], lines: &mut Lines<T>) {
        let n = lines.flow.len();
        wide(
            #[inline(always)]
            || self.find(g, shares, lines),
        );
        for (found, sum) in self.found_columns.iter_mut().zip(&lines.columns[..n - 1]) {
            *found = sum.double();
        }
        self.now
            .cut_sides(&mut self.found_rows, &mut self.found_columns);
        for ((now, found), back) in self
            .now
            .small
            .iter_mut()
            .zip(&self.found_rows)
            .zip(&self.back)
        {
            *now += (found - *now) / (1.0 - back.min(MAX_FEEDBACK));
            *now = now.max(0.0);
        }
        self.now.large.copy_from_slice(&self.found_columns);
    }

    #[inline(always)]
    fn find<T: Number>(&mut self, g: &[T], shares: &[T], lines: &mut Lines<T>) {
        let n = lines.flow.len();
        let sheet = self.now.sheet;
        let (contact, none) = (T::of(sheet.contact_factor), T::default());
        lines.columns.fill(T::default());
        for row in g.chunks_exact(n) {
            for ((sum, a), b) in lines.columns.iter_mut().zip(row).zip(&row[1..]) {
                *sum += sheet.between(*a, *b);
            }
        }
        for i in 0..self.found_rows.len() {
            let (above, below) = (i * n..(i + 1) * n, (i + 1) * n..(i + 2) * n);
            let (g_a, g_b) = (&g[above.clone()], &g[below.clone()]);
            let (m_a, m_b) = (&shares[above], &shares[below]);
            let own_a = T::of(self.slope[i] / self.left[i]);
            let own_b = T::of(self.slope[i] / self.left[i + 1]);
            let (flow, back) = (&mut lines.flow[..n], &mut lines.back[..n]);
            for j in 0..n {
                let (a, b) = sheet.clipped(g_a[j], g_b[j]);
                let inverse = T::of(1.0) / sheet.beneath(a, b);
                let (share_a, share_b) = (a * inverse, b * inverse);
                flow[j] = a * share_b;
                // Noise puts taxels that nothing presses below 0, where what flows does not hang on them.
                let slope_a = if g_a[j] > none {
                    share_b * share_b
                } else {
                    none
                };
                let slope_b = if g_b[j] > none {
                    share_a * share_a
                } else {
                    none
                };
                back[j] = contact
                    * (slope_a * (own_a * m_a[j] - m_b[j]) + slope_b * (own_b * m_b[j] - m_a[j]));
            }
            self.found_rows[i] = sum(flow).double();
            self.back[i] = sum(back).double();
        }
    }
}

/// Room for what goes over one row.
pub(super) struct Lines<T> {
    flow: Vec<T>,
    back: Vec<T>,
    columns: Vec<T>,
}

impl<T: Number> Lines<T> {
    pub(super) fn new(n: usize) -> Self {
        let line = || vec![T::default(); n];
        Self {
            flow: line(),
            back: line(),
            columns: line(),
        }
    }

    pub(super) fn resize(&mut self, n: usize) {
        for line in [&mut self.flow, &mut self.back, &mut self.columns] {
            line.resize(n, T::default());
        }
    }
}
