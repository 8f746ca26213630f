//! What flows sideways in a continuous sheet, as an unknown of the e-Cone's inverse: the couplings of neighbouring rows and
//! columns, which hang on the conductances that they are needed for.
//!
//! Taking those of the last round is no contraction where pressed and unpressed taxels lie side by side: an unpressed
//! taxel answers a change of its lines' coupling, and the coupling answers the taxel (by 1/α). So each coupling is
//! corrected by how much of its change comes back: λ ← λ + (1 − κ)⁻¹(λ(G) − λ), κ = dλ(G)/dλ. A change δ of the coupling
//! between rows i and i + 1 takes δ (P G)_{i+1} from row i of G and δ (P G)_i from row i + 1 (the diagonal of S is known),
//! so that κ is tridiagonal; that between two columns moves H δ, which is little, and its own share is enough.
//!
//! The same changes are taken from H at once, so that what a round goes on with fits the couplings it found. Left to the next
//! round, as an entry of S, each change cost a product S K more: nine rounds or ten in place of seven.

use super::lines::LiveLines;
use crate::circuit::network::coupling::{self, Couplings, diagonal};
use crate::material::Sheet;
use taxel_linalg::{Number, dot, sum, wide};

/// Couplings on their way: present ones, and the next.
pub(super) struct Sideways {
    /// What the present round goes with.
    pub(super) now: Couplings,
    /// What it leads to, rows and then columns; once taken, the step there.
    pub(super) next: Vec<f64>,
    /// κ: what comes back to each coupling from itself, from the one before and from the one after.
    feedback: Vec<f64>,
    from_before: Vec<f64>,
    from_after: Vec<f64>,
    /// Rounds since something new began.
    rounds: u32,
}

/// T, and what goes over all taxels, in the precision of a round.
pub(super) struct Tridiagonal<T> {
    own: Vec<T>,
    chain: Vec<T>,
    /// P G of a row, of the one before it and of the one before that.
    pulls: [Vec<T>; 3],
    /// What flows between two rows, column by column, and its slopes by either.
    through: Vec<T>,
    by_above: Vec<T>,
    by_below: Vec<T>,
    /// Next couplings of rows and of columns, and what comes back to the latter.
    rows: Vec<T>,
    columns: Vec<T>,
    back: Vec<T>,
}

impl Sideways {
    pub(super) fn new(sheet: Sheet) -> Self {
        Self {
            now: Couplings::new(sheet, &[], &[]),
            next: Vec::new(),
            feedback: Vec::new(),
            from_before: Vec::new(),
            from_after: Vec::new(),
            rounds: 0,
        }
    }

    /// Takes rows and columns at these places, with nothing known of their couplings. Allocates nothing for no more of them
    /// than at first.
    pub(super) fn reshape(&mut self, rows: &[usize], columns: &[usize]) {
        self.now.reshape(rows, columns);
        let couplings = self.now.small.len() + self.now.large.len();
        for list in [&mut self.next, &mut self.feedback] {
            list.resize(couplings, 0.0);
        }
        for list in [&mut self.from_before, &mut self.from_after] {
            list.resize(self.now.small.len(), 0.0);
        }
    }

    /// The same for the live rows that are `strong`; `places` is room for them.
    pub(super) fn reshape_to(
        &mut self,
        live: &LiveLines,
        strong: &[bool],
        places: &mut Vec<usize>,
    ) {
        let rows = live.rows.iter().zip(strong);
        places.clear();
        places.extend(rows.filter(|row| *row.1).map(|row| *row.0));
        self.reshape(places, &live.columns);
    }

    /// Takes couplings as an iteration has mixed them, rows and then columns; mixing may overshoot.
    pub(super) fn take(&mut self, mixed: &[f64]) {
        let couplings = self.now.small.iter_mut().chain(&mut self.now.large);
        for (own, mixed) in couplings.zip(mixed) {
            *own = mixed.max(0.0);
        }
    }

    /// Takes the rows' couplings from S, of which they are no part as it is mixed.
    pub(super) fn couple_rows<T: Number>(&self, s: &mut [T]) {
        let m = self.now.small.len() + 1;
        for (i, coupling) in self.now.small.iter().enumerate() {
            s[i * m + i + 1] -= T::of(*coupling);
            s[(i + 1) * m + i] -= T::of(*coupling);
        }
    }

    /// Begins with another frame.
    pub(super) fn begin(&mut self) {
        self.rounds = 0;
    }

    /// Goes on with the next ones.
    pub(super) fn advance(&mut self) {
        let couplings = self.now.small.iter_mut().chain(&mut self.now.large);
        for (own, next) in couplings.zip(&self.next) {
            *own = *next;
        }
    }

    /// Goes on with the next couplings, and takes what those of the rows change from H.
    pub(super) fn go_on<T: Number>(&mut self, h: &mut [T], k: &[T]) {
        let n = self.now.large.len() + 1;
        let couplings = self.now.small.iter_mut().chain(&mut self.now.large);
        for (now, next) in couplings.zip(&mut self.next) {
            let before = *now;
            *now = next.max(0.0);
            *next = *now - before;
        }
        let steps = &self.next;
        let rows = self.now.small.len();
        wide(
            #[inline(always)]
            || {
                for (i, line) in h.chunks_exact_mut(n).enumerate() {
                    if let Some(before) = i.checked_sub(1) {
                        take_from(line, T::of(steps[before]), &k[before * n..i * n]);
                    }
                    if i < rows {
                        take_from(line, T::of(steps[i]), &k[(i + 1) * n..(i + 2) * n]);
                    }
                }
            },
        );
    }

    /// The next couplings, from G, H and K (m×n), with T as it is.
    pub(super) fn find_next<T: Number>(
        &mut self,
        matrix: &mut Tridiagonal<T>,
        g: &[T],
        h: &[T],
        k: &[T],
    ) {
        self.rounds += 1;
        if self.rounds > ROUNDS_OF_FEEDBACK {
            matrix.add_up_alone(self.now.sheet, g);
        } else {
            wide(
                #[inline(always)]
                || matrix.add_up(self, g, h, k),
            );
            self.factorise();
        }
        let (rows, columns) = self.next.split_at_mut(self.now.small.len());
        for (next, found) in [(&mut *rows, &matrix.rows), (&mut *columns, &matrix.columns)] {
            for (next, found) in next.iter_mut().zip(found) {
                *next = found.double();
            }
        }
        self.now.cut_sides(rows, columns);
        self.correct();
    }

    /// Factors 1 − κ: elimination along the rows' chain leaves its diagonal in `feedback`.
    fn factorise(&mut self) {
        for back in &mut self.feedback {
            *back = 1.0 - back.min(MAX_FEEDBACK);
        }
        for i in 1..self.now.small.len() {
            self.from_before[i] = -self.from_before[i] / self.feedback[i - 1];
            self.feedback[i] += self.from_before[i] * self.from_after[i - 1];
            self.feedback[i] = self.feedback[i].max(1.0 - MAX_FEEDBACK);
        }
    }

    /// next ← now + (1 − κ)⁻¹ (next − now).
    fn correct(&mut self) {
        let rows = self.now.small.len();
        let now = self.now.small.iter().chain(&self.now.large);
        for (next, now) in self.next.iter_mut().zip(now) {
            *next -= now;
        }
        for i in 1..rows {
            self.next[i] -= self.from_before[i] * self.next[i - 1];
        }
        for i in (0..rows).rev() {
            let after = if i + 1 < rows {
                self.from_after[i] * self.next[i + 1]
            } else {
                0.0
            };
            self.next[i] = (self.next[i] + after) / self.feedback[i];
        }
        for (next, left) in self.next[rows..].iter_mut().zip(&self.feedback[rows..]) {
            *next /= left;
        }
        let now = self.now.small.iter().chain(&self.now.large);
        for (next, now) in self.next.iter_mut().zip(now) {
            *next += now;
        }
    }
}

/// After so many rounds κ hardly changes any more.
const ROUNDS_OF_FEEDBACK: u32 = 2;
/// A change that comes back with its own sign is not taken to come back nearly whole.
const MAX_FEEDBACK: f64 = 0.5;

impl<T: Number> Tridiagonal<T> {
    /// For arrays of so many rows and columns that carry current.
    pub(super) fn new(rows: usize, columns: usize) -> Self {
        let line = || vec![T::default(); columns];
        Self {
            own: line(),
            chain: line(),
            pulls: [line(), line(), line()],
            through: line(),
            by_above: line(),
            by_below: line(),
            rows: vec![T::default(); rows],
            columns: line(),
            back: line(),
        }
    }

    /// Takes another shape; allocates nothing when it is no larger than the one it was made for.
    pub(super) fn resize(&mut self, rows: usize, columns: usize) {
        let between = columns.saturating_sub(1);
        let lines = [
            (&mut self.own, columns),
            (&mut self.chain, between),
            (&mut self.through, columns),
            (&mut self.by_above, columns),
            (&mut self.by_below, columns),
            (&mut self.rows, rows.saturating_sub(1)),
            (&mut self.columns, between),
            (&mut self.back, between),
        ];
        let pulls = self.pulls.iter_mut().map(|line| (line, columns));
        for (line, length) in lines.into_iter().chain(pulls) {
            line.clear();
            line.resize(length, T::default());
        }
    }

    /// T = diag(d) + the Laplacian of the columns' chain.
    pub(super) fn set(&mut self, d: &[f64], chain: &[f64]) {
        for (c, (own, d)) in self.own.iter_mut().zip(d).enumerate() {
            *own = T::of(d + diagonal(chain, c));
        }
        for (own, coupling) in self.chain.iter_mut().zip(chain) {
            *own = T::of(*coupling);
        }
    }

    /// out ← rows T.
    pub(super) fn times(&self, rows: &[T], out: &mut [T]) {
        let n = self.own.len();
        wide(
            #[inline(always)]
            || {
                for (row, out) in rows.chunks_exact(n).zip(out.chunks_exact_mut(n)) {
                    times(&self.own, &self.chain, row, out);
                }
            },
        );
    }

    /// The couplings under G as if all lines were joined.
    fn add_up_alone(&mut self, sheet: Sheet, g: &[T]) {
        wide(
            #[inline(always)]
            || {
                let Self {
                    through,
                    rows,
                    columns,
                    ..
                } = self;
                coupling::add_up(sheet, g, through, rows, columns);
            },
        );
    }

    /// The same, and how much of a change of them comes back.
    #[inline(always)]
    fn add_up(&mut self, couplings: &mut Sideways, g: &[T], h: &[T], k: &[T]) {
        let n = self.own.len();
        let sheet = couplings.now.sheet;
        self.columns.fill(T::default());
        self.back.fill(T::default());
        let (back_row, back_column) = couplings.feedback.split_at_mut(self.rows.len());
        for (i, (g_line, h_line)) in g.chunks_exact(n).zip(h.chunks_exact(n)).enumerate() {
            add_along(sheet, g_line, h_line, &mut self.columns, &mut self.back);
            self.pulls.rotate_right(1);
            let k_line = &k[i * n..(i + 1) * n];
            times(&self.own, &self.chain, k_line, &mut self.pulls[0]);
            let [pull, above, farther] = &self.pulls;
            // The lines still hold the two rows before.
            if let Some(pair) = i.checked_sub(2) {
                couplings.from_after[pair] = -dot(&self.by_below, pull).double();
            }
            if let Some(pair) = i.checked_sub(1) {
                let slopes = [&mut self.by_above[..], &mut self.by_below[..]];
                across(
                    sheet,
                    &g[pair * n..i * n],
                    g_line,
                    &mut self.through,
                    slopes,
                );
                self.rows[pair] = sum(&self.through);
                let back = dot(&self.by_above, pull) + dot(&self.by_below, above);
                back_row[pair] = -back.double();
                couplings.from_before[pair] = -dot(&self.by_above, farther).double();
            }
        }
        for (feedback, back) in back_column.iter_mut().zip(&self.back) {
            *feedback = back.double();
        }
    }
}

#[inline(always)]
fn take_from<T: Number>(line: &mut [T], step: T, other: &[T]) {
    for (x, other) in line.iter_mut().zip(other) {
        *x -= step * *other;
    }
}

/// Adds what flows between the neighbours of one row, and how much of a change of it comes back, column by column.
#[inline(always)]
fn add_along<T: Number>(sheet: Sheet, g: &[T], h: &[T], through: &mut [T], back: &mut [T]) {
    let n = through.len();
    let (g_a, g_b, h_a, h_b) = (&g[..n], &g[1..=n], &h[..n], &h[1..=n]);
    let back = &mut back[..n];
    for j in 0..n {
        let (flows, by_a, by_b) = flow(sheet, g_a[j], g_b[j]);
        through[j] += flows;
        back[j] += (by_a - by_b) * (h_a[j] - h_b[j]);
    }
}

/// What flows between the neighbours of two rows.
#[inline(always)]
fn across<T: Number>(
    sheet: Sheet,
    above: &[T],
    below: &[T],
    through: &mut [T],
    slopes: [&mut [T]; 2],
) {
    let n = through.len();
    let (above, below) = (&above[..n], &below[..n]);
    let [by_above, by_below] = slopes.map(|slope| &mut slope[..n]);
    for j in 0..n {
        (through[j], by_above[j], by_below[j]) = flow(sheet, above[j], below[j]);
    }
}

/// ℓ of two neighbours and its slopes by both. A conductance below 0 has the slope of one at 0: it is noise, or on its way.
#[inline(always)]
fn flow<T: Number>(sheet: Sheet, a: T, b: T) -> (T, T, T) {
    let (a, b) = sheet.clipped(a, b);
    let inverse = T::of(1.0) / sheet.beneath(a, b);
    let (share_a, share_b) = (a * inverse, b * inverse);
    let contact = T::of(sheet.contact_factor);
    (
        a * share_b,
        contact * share_b * share_b,
        contact * share_a * share_a,
    )
}

#[inline(always)]
fn times<T: Number>(own: &[T], chain: &[T], row: &[T], out: &mut [T]) {
    for ((out, x), own) in out.iter_mut().zip(row).zip(own) {
        *out = *x * *own;
    }
    for ((out, x), coupling) in out[1..].iter_mut().zip(row).zip(chain) {
        *out -= *coupling * *x;
    }
    for ((out, x), coupling) in out.iter_mut().zip(&row[1..]).zip(chain) {
        *out -= *coupling * *x;
    }
}
