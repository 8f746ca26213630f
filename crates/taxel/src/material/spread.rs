//! Mechanical spread: the cover hands a part of a taxel's load to its neighbours.

use taxel_linalg::wide;

/// A taxel keeps `1 − 2·row − 2·column − 4·diagonal` of its load; what would go beyond the edge is lost.
/// A pure 3×3 convolution, symmetric about both axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread {
    /// Share that each neighbour one row away takes.
    pub row: f64,
    /// Share that each neighbour one column away takes.
    pub column: f64,
    /// Share that each diagonal neighbour takes.
    pub diagonal: f64,
}

/// Rounds of refinement, two at a time. Where a tenth of the load leaves a round gains a factor 20, where a fifth does 8.
const MAX_ITERATIONS: usize = 60;
/// What is left of the largest load.
const TOLERANCE: f64 = 1e-9;

impl Spread {
    /// From sensor.toml's three shares.
    pub fn new([row, column, diagonal]: [f64; 3]) -> Self {
        Self {
            row,
            column,
            diagonal,
        }
    }

    /// What the taxel keeps.
    pub fn kept(&self) -> f64 {
        1.0 - 2.0 * (self.row + self.column) - 4.0 * self.diagonal
    }

    /// The loads that the taxels feel, from the loads put on them; row by row, any unit.
    pub fn apply(&self, columns: usize, loads: &[f64], effective: &mut [f64]) {
        wide(
            #[inline(always)]
            || self.rows(columns, loads, effective),
        );
    }

    #[inline(always)]
    fn rows(&self, columns: usize, loads: &[f64], effective: &mut [f64]) {
        let rows = loads.len() / columns;
        for (r, out) in effective.chunks_exact_mut(columns).enumerate() {
            let line = |r: usize| &loads[r * columns..(r + 1) * columns];
            if r > 0 && r + 1 < rows && columns > 2 {
                self.inner_row([line(r - 1), line(r), line(r + 1)], out);
            } else {
                let others = [r.checked_sub(1), Some(r + 1).filter(|&r| r < rows)];
                self.edge_row(line(r), others.into_iter().flatten().map(line), out);
            }
        }
    }

    /// A row with one on either side, in one go.
    #[inline(always)]
    fn inner_row(&self, [above, here, below]: [&[f64]; 3], out: &mut [f64]) {
        let n = out.len();
        let (spread, kept) = (*self, self.kept());
        let ends = [(0, 1), (n - 1, n - 2)];
        for (end, next) in ends {
            out[end] = kept * here[end]
                + spread.column * here[next]
                + spread.row * (above[end] + below[end])
                + spread.diagonal * (above[next] + below[next]);
        }
        let (a0, a1, a2) = (&above[..n - 2], &above[1..n - 1], &above[2..]);
        let (h0, h1, h2) = (&here[..n - 2], &here[1..n - 1], &here[2..]);
        let (b0, b1, b2) = (&below[..n - 2], &below[1..n - 1], &below[2..]);
        for (j, out) in out[1..n - 1].iter_mut().enumerate() {
            *out = spread.felt(
                kept,
                [a0[j], a1[j], a2[j]],
                [h0[j], h1[j], h2[j]],
                [b0[j], b1[j], b2[j]],
            );
        }
    }

    /// What a taxel feels that keeps so much, of the rows above, its own and below.
    #[inline(always)]
    fn felt(
        self,
        kept: f64,
        [a0, a1, a2]: [f64; 3],
        [h0, h1, h2]: [f64; 3],
        [b0, b1, b2]: [f64; 3],
    ) -> f64 {
        kept * h1
            + self.column * (h0 + h2)
            + self.row * (a1 + b1)
            + self.diagonal * ((a0 + a2) + (b0 + b2))
    }

    #[inline(always)]
    fn edge_row<'a>(&self, here: &[f64], others: impl Iterator<Item = &'a [f64]>, out: &mut [f64]) {
        let kept = self.kept();
        for (out, load) in out.iter_mut().zip(here) {
            *out = kept * load;
        }
        add_sides(out, here, self.column);
        for other in others {
            for (out, load) in out.iter_mut().zip(other) {
                *out += self.row * load;
            }
            add_sides(out, other, self.diagonal);
        }
    }

    /// The least and the largest eigenvalue that the convolution can have on any array, with whatever taxels missing: those of
    /// waves on an endless one.
    fn eigenvalues(&self) -> [f64; 2] {
        let (sides, corners) = (2.0 * (self.row + self.column), 4.0 * self.diagonal);
        let across = 2.0 * (self.row - self.column).abs();
        let all = [
            sides + corners,
            corners - sides,
            across - corners,
            -across - corners,
        ];
        let of = |most: fn(f64, f64) -> f64| self.kept() + all.into_iter().fold(all[0], most);
        [of(f64::min), of(f64::max)]
    }

    /// Numbers that [`Self::undo`] needs room for.
    pub const fn room(taxels: usize, columns: usize) -> usize {
        // What is left of a row, and loads twice, in a frame of nothing.
        columns + 2 * (taxels / columns + 2) * (columns + 2)
    }

    /// The loads put on the taxels, from those felt: the same equations solved to 1e-9 of the largest load, by Chebyshev's
    /// iteration. Where `absent` says so, row by row (empty: nowhere), there is no taxel: nothing lies there, and what would go
    /// there is lost. `work` is scratch, of [`Self::room`].
    ///
    /// # Panics
    /// When there is less room.
    pub fn undo(
        &self,
        columns: usize,
        absent: &[bool],
        effective: &[f64],
        loads: &mut [f64],
        work: &mut [f64],
    ) {
        let work = &mut work[..Self::room(effective.len(), columns)];
        work.fill(0.0);
        wide(
            #[inline(always)]
            || {
                if absent.is_empty() {
                    self.iterate::<false>(columns, absent, effective, loads, work);
                } else {
                    self.iterate::<true>(columns, absent, effective, loads, work);
                }
            },
        );
    }

    #[inline(always)]
    fn iterate<const SOME_ABSENT: bool>(
        &self,
        columns: usize,
        absent: &[bool],
        effective: &[f64],
        loads: &mut [f64],
        work: &mut [f64],
    ) {
        let enough = TOLERANCE * largest(effective);
        let [least, most] = self.eigenvalues();
        let least = least.max(LEAST_EIGENVALUE);
        let (middle, half) = ((most + least) / 2.0, (most - least) / 2.0);
        for (load, effective) in loads.iter_mut().zip(effective) {
            *load = effective / middle;
        }
        if SOME_ABSENT {
            clear(loads, absent);
        }
        if half <= f64::EPSILON {
            return;
        }
        let (left, framed) = work.split_at_mut(columns);
        let (now, before) = framed.split_at_mut(framed.len() / 2);
        for (r, loads) in loads.chunks_exact(columns).enumerate() {
            row_of(now, r, columns).copy_from_slice(loads);
        }
        let mut shares = Shares::new(middle / half, half);
        let mut is_after_first = false;
        for _ in 0..MAX_ITERATIONS / 2 {
            // Two rounds at once, the second a row behind, while the rows are at hand.
            let (first, second) = (shares.next(), shares.next());
            let (mut left_first, mut left_second) = (0f64, 0f64);
            let mut behind = None;
            for (r, effective) in effective.chunks_exact(columns).enumerate() {
                let there = absent.get(r * columns..(r + 1) * columns);
                let here = (r, effective, there.unwrap_or_default());
                let most = self.go::<SOME_ABSENT>(first, here, now, before, left);
                left_first = left_first.max(most);
                if let Some(here) = behind.replace(here) {
                    let most = self.go::<SOME_ABSENT>(second, here, before, now, left);
                    left_second = left_second.max(most);
                }
            }
            if let Some(here) = behind {
                let most = self.go::<SOME_ABSENT>(second, here, before, now, left);
                left_second = left_second.max(most);
            }
            is_after_first = left_first <= enough;
            if is_after_first || left_second <= enough {
                break;
            }
        }
        let found = if is_after_first { before } else { now };
        for (r, loads) in loads.chunks_exact_mut(columns).enumerate() {
            loads.copy_from_slice(row_of(found, r, columns));
        }
    }

    /// One row's loads from those `now` and those `before`, which they replace; the largest of what was left.
    #[inline(always)]
    fn go<const SOME_ABSENT: bool>(
        &self,
        [of_step, of_rest]: [f64; 2],
        (r, effective, absent): (usize, &[f64], &[bool]),
        now: &[f64],
        before: &mut [f64],
        left: &mut [f64],
    ) -> f64 {
        let columns = left.len();
        let felt = &now[r * (columns + 2)..][..3 * (columns + 2)];
        self.row_left(felt, effective, left);
        if SOME_ABSENT {
            clear(left, absent);
        }
        let here = &felt[columns + 3..][..columns];
        let each = row_of(before, r, columns).iter_mut().zip(here).zip(&*left);
        for ((before, now), left) in each {
            *before = now + (of_step * (now - *before) + of_rest * left);
        }
        largest(left)
    }

    /// What these loads leave of what a row feels; of the row before, itself and the next one, each with a place beyond its ends.
    #[inline(always)]
    fn row_left(&self, loads: &[f64], effective: &[f64], left: &mut [f64]) {
        let n = left.len();
        let (spread, kept) = (*self, self.kept());
        let from = |row: usize, at: usize| &loads[row * (n + 2) + at..][..n];
        let (a0, a1, a2) = (from(0, 0), from(0, 1), from(0, 2));
        let (h0, h1, h2) = (from(1, 0), from(1, 1), from(1, 2));
        let (b0, b1, b2) = (from(2, 0), from(2, 1), from(2, 2));
        let effective = &effective[..n];
        for j in 0..n {
            let felt = spread.felt(
                kept,
                [a0[j], a1[j], a2[j]],
                [h0[j], h1[j], h2[j]],
                [b0[j], b1[j], b2[j]],
            );
            left[j] = effective[j] - felt;
        }
    }
}

/// How far Chebyshev's iteration goes, round by round: a share of the last step, and of what is left.
struct Shares {
    sigma: f64,
    half: f64,
    rho: f64,
}

impl Shares {
    fn new(sigma: f64, half: f64) -> Self {
        let rho = 1.0 / sigma;
        Self { sigma, half, rho }
    }

    #[inline(always)]
    fn next(&mut self) -> [f64; 2] {
        let next = 1.0 / (2.0 * self.sigma - self.rho);
        let shares = [next * self.rho, 2.0 * next / self.half];
        self.rho = next;
        shares
    }
}

/// Row `r` of loads in a frame of nothing.
#[inline(always)]
fn row_of(framed: &mut [f64], r: usize, columns: usize) -> &mut [f64] {
    &mut framed[(r + 1) * (columns + 2) + 1..][..columns]
}

/// The largest size; what is no number is none.
#[inline(always)]
fn largest(values: &[f64]) -> f64 {
    let mut most = [0f64; LANES];
    let (chunks, rest) = values.as_chunks::<LANES>();
    for chunk in chunks {
        for lane in 0..LANES {
            let size = chunk[lane].abs();
            most[lane] = if size > most[lane] { size } else { most[lane] };
        }
    }
    most.into_iter()
        .chain(rest.iter().map(|value| value.abs()))
        .fold(0.0, f64::max)
}

/// Maxima kept side by side, so that the compiler may use vectors.
const LANES: usize = 16;
/// Where half of a load leaves to all sides alike a wave of the finest kind is not felt at all; it is held to so little.
const LEAST_EIGENVALUE: f64 = 1e-3;

/// Nothing lies where there is no taxel.
#[inline(always)]
fn clear(values: &mut [f64], absent: &[bool]) {
    for (value, absent) in values.iter_mut().zip(absent) {
        *value = if *absent { 0.0 } else { *value };
    }
}

#[inline(always)]
fn add_sides(out: &mut [f64], from: &[f64], share: f64) {
    let n = out.len();
    for (out, load) in out[1..].iter_mut().zip(&from[..n - 1]) {
        *out += share * load;
    }
    for (out, load) in out[..n - 1].iter_mut().zip(&from[1..]) {
        *out += share * load;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn undo_undoes_and_the_middle_keeps_its_total() {
        let spread = Spread::new([0.06, 0.05, 0.004]);
        let (rows, columns) = (7, 9);
        let mut loads = vec![0.0; rows * columns];
        loads[3 * columns + 4] = 100.0;
        let (mut effective, mut back) = (loads.clone(), loads.clone());
        let mut work = vec![0.0; Spread::room(loads.len(), columns)];
        spread.apply(columns, &loads, &mut effective);
        assert!((effective.iter().sum::<f64>() - 100.0).abs() < 1e-12);
        assert!((effective[2 * columns + 4] - 6.0).abs() < 1e-12);
        assert!((effective[3 * columns + 5] - 5.0).abs() < 1e-12);
        assert!((effective[2 * columns + 3] - 0.4).abs() < 1e-12);
        spread.undo(columns, &[], &effective, &mut back, &mut work);
        for (back, load) in back.iter().zip(&loads) {
            assert!((back - load).abs() < 1e-6);
        }
    }

    #[test]
    fn nothing_is_handed_to_or_taken_from_where_no_taxel_is() {
        let spread = Spread::new([0.06, 0.05, 0.004]);
        let (rows, columns) = (6, 5);
        let absent: Vec<bool> = (0..rows * columns).map(|t| t % 4 == 1).collect();
        let there = |t: usize| if absent[t] { 0.0 } else { 10.0 + t as f64 };
        let loads: Vec<f64> = (0..rows * columns).map(there).collect();
        let (mut effective, mut back) = (loads.clone(), loads.clone());
        let mut work = vec![0.0; Spread::room(loads.len(), columns)];
        spread.apply(columns, &loads, &mut effective);
        spread.undo(columns, &absent, &effective, &mut back, &mut work);
        for (back, load) in back.iter().zip(&loads) {
            assert!((back - load).abs() < 1e-6, "{back} {load}");
        }
    }

    #[test]
    fn a_single_line_spreads_along_itself() {
        let spread = Spread::new([0.1, 0.1, 0.0]);
        let mut effective = vec![0.0; 3];
        spread.apply(1, &[0.0, 1.0, 0.0], &mut effective);
        assert_eq!(effective, [0.1, 0.6, 0.1]);
        spread.apply(3, &[0.0, 1.0, 0.0], &mut effective);
        assert_eq!(effective, [0.1, 0.6, 0.1]);
    }
}
