//! One round of the fixed point in the shares: products, and nothing else that costs; in single or double precision.

use super::super::anderson::{Anderson, Kept};
use super::MIXING_DEPTH;
use super::maxima::{Maxima, finite};
use super::sideways::{Lines, Sideways};
use taxel_linalg::{Number, View, ViewMut, dot, mirror, multiply_lower, wide};

/// How often couplings of a sheet and conductances follow each other between two products, at first and later.
const TURNS: [usize; 2] = [2, 1];

/// Over the rows that carry current (m) and the live columns (n), row-major.
pub(super) struct Shares<T> {
    m: usize,
    n: usize,
    /// K, ohms.
    pub(super) k: Vec<T>,
    /// g_c, siemens.
    pub(super) g_c: Vec<T>,
    /// The unknowns: T off its diagonal, or what is moved, whichever are the fewer.
    pub(super) point: Vec<T>,
    image: Vec<T>,
    pub(super) mixing: Anderson<T>,
    /// What other taxels make of a reading's share, M − K diag(g_c) = K (T − diag(g_c)), where T is the unknown.
    moved: Vec<T>,
    /// M.
    shares: Vec<T>,
    pub(super) g: Vec<T>,
    /// Σ_r G of every column.
    sums: Vec<T>,
    /// Of the shorter side: K Mᵀ; or T − diag(g_c), and then Mᵀ G.
    small: Vec<T>,
    product: Vec<T>,
    line: Vec<T>,
    lines: Lines<T>,
}

/// Whether the unknowns are those of the columns, T off its diagonal; otherwise they are the shares themselves.
fn is_by_columns(m: usize, n: usize) -> bool {
    n <= m
}

/// How many unknowns there are.
fn unknowns(m: usize, n: usize) -> usize {
    if is_by_columns(m, n) {
        n * n.saturating_sub(1) / 2
    } else {
        m * n
    }
}

impl<T: Kept> Shares<T> {
    pub(super) fn new(m: usize, n: usize) -> Self {
        // Lines may be left out later, and then the unknowns be the others.
        let most = m * n;
        let rectangle = || vec![T::default(); most];
        Self {
            m,
            n,
            k: rectangle(),
            g_c: vec![T::default(); n],
            point: rectangle(),
            image: rectangle(),
            mixing: Anderson::new(MIXING_DEPTH, most),
            moved: rectangle(),
            shares: rectangle(),
            g: rectangle(),
            sums: vec![T::default(); n],
            small: vec![T::default(); m.min(n) * m.min(n)],
            product: rectangle(),
            line: vec![T::default(); n],
            lines: Lines::new(n),
        }
    }

    /// Takes another shape; allocates nothing when it is no larger than the one it was made for.
    pub(super) fn resize(&mut self, m: usize, n: usize) {
        (self.m, self.n) = (m, n);
        for rectangle in [
            &mut self.k,
            &mut self.moved,
            &mut self.shares,
            &mut self.g,
            &mut self.product,
        ] {
            rectangle.resize(m * n, T::default());
        }
        for list in [&mut self.point, &mut self.image] {
            list.resize(unknowns(m, n), T::default());
        }
        self.mixing.resize(unknowns(m, n));
        self.small.resize(m.min(n) * m.min(n), T::default());
        for line in [&mut self.g_c, &mut self.sums, &mut self.line] {
            line.resize(n, T::default());
        }
        self.lines.resize(n);
    }

    /// Begins with nothing known: shares are those of the readings.
    pub(super) fn forget(&mut self) {
        self.point.fill(T::default());
        self.g.fill(T::default());
        self.mixing.restart();
    }

    /// M ← K diag(g_c) + what is moved, Λ_r ← 1/(P_rr − Σ K M), G ← Λ M. The largest conductance and the largest change of one;
    /// nothing where a row's denominator is not positive. `is_first`: nothing is known yet.
    pub(super) fn conductances(
        &mut self,
        p: &[f64],
        sideways: Option<&mut Sideways>,
        is_first: bool,
    ) -> Option<(f64, f64)> {
        if is_by_columns(self.m, self.n) {
            self.move_by_columns(is_first);
        }
        match sideways {
            None => self.spread(p),
            Some(sideways) => self.spread_in_a_sheet(p, sideways),
        }
    }

    /// Moved ← K (T − diag(g_c)).
    fn move_by_columns(&mut self, is_first: bool) {
        let (m, n) = (self.m, self.n);
        if is_first {
            self.moved.fill(T::default());
            return;
        }
        unpack(&self.point, &mut self.small, n);
        T::product(
            ViewMut::new(&mut self.moved, m, n),
            View::new(&self.k, m, n),
            View::new(&self.small, n, n),
        );
    }

    fn moved(&self) -> &[T] {
        if is_by_columns(self.m, self.n) {
            &self.moved
        } else {
            &self.point
        }
    }

    fn spread(&mut self, p: &[f64]) -> Option<(f64, f64)> {
        let n = self.n;
        let by_columns = is_by_columns(self.m, n);
        let moved = if by_columns { &self.moved } else { &self.point };
        let (g, sums, line) = (&mut self.g, &mut self.sums, &mut self.line);
        let rows = (self.k.chunks_exact(n)).zip(moved.chunks_exact(n));
        let rows = rows.zip(self.shares.chunks_exact_mut(n).zip(g.chunks_exact_mut(n)));
        let (g_c, mut maxima) = (&self.g_c, Maxima::default());
        let is_good = wide(
            #[inline(always)]
            || {
                sums.fill(T::default());
                for (((k, moved), (shares, g)), p) in rows.zip(p) {
                    let left = share_out(T::of(*p), k, moved, g_c, shares);
                    if left.is_none_or_less() {
                        return false;
                    }
                    let total = T::of(1.0) / left;
                    for ((value, share), sum) in line.iter_mut().zip(&*shares).zip(&mut *sums) {
                        *value = total * *share;
                        *sum += *value;
                    }
                    maxima.take(g, line);
                }
                true
            },
        );
        is_good.then(|| maxima.found(finite(&self.sums)))
    }

    /// The same where Λ has the couplings of a sheet beside its diagonal, which hang on G.
    fn spread_in_a_sheet(&mut self, p: &[f64], sideways: &mut Sideways) -> Option<(f64, f64)> {
        let n = self.n;
        for (r, p) in p.iter().enumerate() {
            let line = r * n..(r + 1) * n;
            let moved = if is_by_columns(self.m, n) {
                &self.moved[line.clone()]
            } else {
                &self.point[line.clone()]
            };
            let (k, g_c) = (&self.k[line.clone()], &self.g_c);
            let shares = &mut self.shares[line];
            let left = wide(
                #[inline(always)]
                || share_out(T::of(*p), k, moved, g_c, shares),
            );
            if left.is_none_or_less() {
                return None;
            }
            sideways.set_left(r, left.double());
        }
        for _ in 0..TURNS[usize::from(sideways.is_late)] {
            self.pass_through(sideways);
            sideways.advance(&self.product, &self.shares, &mut self.lines);
        }
        self.pass_through(sideways);
        let (g, product, sums) = (&mut self.g, &self.product, &mut self.sums);
        let mut maxima = Maxima::default();
        wide(
            #[inline(always)]
            || {
                sums.fill(T::default());
                for (g, line) in g.chunks_exact_mut(n).zip(product.chunks_exact(n)) {
                    for (sum, value) in sums.iter_mut().zip(line) {
                        *sum += *value;
                    }
                    maxima.take(g, line);
                }
            },
        );
        Some(maxima.found(finite(&self.sums)))
    }

    /// Product ← Λ M with the couplings as they are.
    fn pass_through(&mut self, sideways: &mut Sideways) {
        sideways.pass_through();
        let (product, shares, n) = (&mut self.product, &self.shares, self.n);
        wide(
            #[inline(always)]
            || {
                for (r, out) in product.chunks_exact_mut(n).enumerate() {
                    sideways.row_of(r, shares, out);
                }
            },
        );
    }

    /// Goes on with the next unknowns: K D − (K Mᵀ) G without K diag(g_c), or D − Mᵀ G off its diagonal; `part` of the way there.
    pub(super) fn advance(&mut self, sideways: Option<&Sideways>, part: f64) {
        let between = sideways.map_or(&[][..], |sideways| &sideways.now.large);
        if is_by_columns(self.m, self.n) {
            self.image_by_columns(between);
        } else {
            self.image_by_rows(between);
        }
        if part < 1.0 {
            let part = T::of(part);
            for (image, point) in self.image.iter_mut().zip(&self.point) {
                *image = *point + part * (*image - *point);
            }
        }
        self.mixing.advance(&mut self.point, &self.image);
    }

    /// Takes back what mixing made of the last step. False where it made nothing.
    pub(super) fn retreat(&mut self) -> bool {
        self.mixing.retreat(&mut self.point)
    }

    fn image_by_columns(&mut self, between: &[f64]) {
        let (m, n) = (self.m, self.n);
        multiply_lower(
            ViewMut::new(&mut self.small, n, n),
            View::new(&self.shares, m, n).transpose(),
            View::new(&self.g, m, n),
        );
        let mut at = 0;
        for i in 1..n {
            let image = &mut self.image[at..at + i];
            for (image, product) in image.iter_mut().zip(&self.small[i * n..]) {
                *image = T::default() - *product;
            }
            if let Some(coupling) = between.get(i - 1) {
                image[i - 1] -= T::of(*coupling);
            }
            at += i;
        }
    }

    fn image_by_rows(&mut self, between: &[f64]) {
        let (m, n) = (self.m, self.n);
        multiply_lower(
            ViewMut::new(&mut self.small, m, m),
            View::new(&self.k, m, n),
            View::new(&self.shares, m, n).transpose(),
        );
        mirror(&mut self.small, m);
        T::product(
            ViewMut::new(&mut self.product, m, n),
            View::new(&self.small, m, m),
            View::new(&self.g, m, n),
        );
        let own = &mut self.line;
        own.copy_from_slice(&self.sums);
        for (j, coupling) in between.iter().enumerate() {
            own[j] += T::of(*coupling);
            own[j + 1] += T::of(*coupling);
        }
        let rows = self.k.chunks_exact(n).zip(self.product.chunks_exact(n));
        let rows = rows.zip(self.image.chunks_exact_mut(n));
        wide(
            #[inline(always)]
            || {
                for ((k, product), image) in rows {
                    for (((image, k), product), own) in
                        image.iter_mut().zip(k).zip(product).zip(&*own)
                    {
                        *image = *k * *own - *product;
                    }
                    for (j, coupling) in between.iter().enumerate() {
                        let coupling = T::of(*coupling);
                        image[j] -= coupling * k[j + 1];
                        image[j + 1] -= coupling * k[j];
                    }
                }
            },
        );
    }
}

impl Shares<f64> {
    /// Goes on where rounds in single precision have come to, without what their mixing has learnt: its last steps may be digits' noise.
    pub(super) fn take(&mut self, from: &Shares<f32>) {
        copy(&mut self.point, &from.point, |x| f64::from(*x));
        copy(&mut self.g, &from.g, |x| f64::from(*x));
        self.mixing.restart();
    }

    /// G from what rounds in single precision have moved, the rest of the way in double precision.
    pub(super) fn finish(
        &mut self,
        from: &Shares<f32>,
        p: &[f64],
        sideways: Option<&mut Sideways>,
    ) {
        let moved = if is_by_columns(self.m, self.n) {
            &mut self.moved
        } else {
            &mut self.point
        };
        copy(moved, from.moved(), |x| f64::from(*x));
        let _ = match sideways {
            None => self.spread(p),
            Some(sideways) => self.spread_in_a_sheet(p, sideways),
        };
    }
}

impl Shares<f32> {
    /// Keeps where rounds in double precision have come to, for the next frame.
    pub(super) fn keep(&mut self, from: &Shares<f64>) {
        copy(&mut self.point, &from.point, |x| *x as f32);
        self.keep_conductances(from);
    }

    /// Takes other rows of as many columns, keeping what is known of those that were there. False where that serves nothing.
    pub(super) fn carry_over(
        &mut self,
        before: &[bool],
        now: &[bool],
        [m_before, m]: [usize; 2],
        n: usize,
    ) -> bool {
        match (is_by_columns(m_before, n), is_by_columns(m, n)) {
            // What columns know of each other hangs on no row's place.
            (true, true) => return true,
            (false, false) => {}
            _ => return false,
        }
        self.image.clear();
        self.image.resize(m * n, 0.0);
        let (mut from, mut to) = (0, 0);
        for (was, is) in before.iter().zip(now) {
            if *was && *is {
                self.image[to..to + n].copy_from_slice(&self.point[from..from + n]);
            }
            from += n * usize::from(*was);
            to += n * usize::from(*is);
        }
        std::mem::swap(&mut self.image, &mut self.point);
        true
    }

    /// Keeps the answer, for the next frame.
    pub(super) fn keep_conductances(&mut self, from: &Shares<f64>) {
        copy(&mut self.g, &from.g, |x| *x as f32);
    }
}

fn copy<A, B>(to: &mut [A], from: &[B], of: impl Fn(&B) -> A) {
    wide(
        #[inline(always)]
        || {
            for (to, from) in to.iter_mut().zip(from) {
                *to = of(from);
            }
        },
    );
}

/// M of one row, and what is left of its P_rr.
#[inline(always)]
fn share_out<T: Number>(p: T, k: &[T], moved: &[T], g_c: &[T], shares: &mut [T]) -> T {
    for (((share, k), moved), g_c) in shares.iter_mut().zip(k).zip(moved).zip(g_c) {
        *share = *k * *g_c + *moved;
    }
    p - dot(k, shares)
}

trait Denominator {
    /// Not above 0, or no number.
    fn is_none_or_less(&self) -> bool;
}

impl<T: Number> Denominator for T {
    #[inline(always)]
    fn is_none_or_less(&self) -> bool {
        self.partial_cmp(&T::default()) != Some(std::cmp::Ordering::Greater)
    }
}

/// T − diag(g_c) of its packed lower triangle without the diagonal: its rows sum to 0.
fn unpack<T: Number>(packed: &[T], full: &mut [T], n: usize) {
    full.iter_mut()
        .step_by(n + 1)
        .for_each(|x| *x = T::default());
    let mut at = 0;
    for i in 1..n {
        for j in 0..i {
            let value = packed[at];
            full[i * n + j] = value;
            full[j * n + i] = value;
            full[i * n + i] -= value;
            full[j * n + j] -= value;
            at += 1;
        }
    }
}
