//! The exact derivative of the scan, matrix-free: the algorithm of `lumped.rs` differentiated line by line,
//! forwards (J·v) and backwards (Jᵀ·w). A handful of m×m×n products each, as the scan itself.

use super::coupling::add_laplacian;
use super::lumped::{LumpedPoint, SheetPoint, divide, symmetrise};
use crate::circuit::reading::Rest;
use taxel_linalg::{View, ViewMut, multiply, multiply_add};

/// Scratch and the partial derivatives of V_out by P_rr, Q_cc, K_rc.
pub(super) struct Work {
    pub(super) stale: bool,
    by_p: Vec<f64>,
    by_q: Vec<f64>,
    by_k: Vec<f64>,
    /// By the potentials of a line of the smaller side and of one of the larger; empty where they do not move.
    by_rest: Vec<[Rest; 2]>,
    direction: Vec<f64>,
    a: Vec<f64>,
    b: Vec<f64>,
    c: Vec<f64>,
    square: Vec<f64>,
    square_too: Vec<f64>,
    along_small: Vec<f64>,
    along_large: Vec<f64>,
    along_large_too: Vec<f64>,
    sheet: SheetWork,
}

/// What a sheet needs besides; empty without one.
#[derive(Default)]
struct SheetWork {
    /// T⁻¹, n×n.
    inverse: Vec<f64>,
    /// Of the couplings of the smaller and the larger side: their changes, or the gradient by them.
    small: Vec<f64>,
    large: Vec<f64>,
}

impl SheetWork {
    /// T⁻¹ at this point, in a place that is kept.
    fn set(&mut self, sheet: &SheetPoint, n: usize) {
        self.inverse.clear();
        self.inverse.resize(n * n, 0.0);
        self.inverse
            .iter_mut()
            .step_by(n + 1)
            .for_each(|x| *x = 1.0);
        sheet.chain.solve_rows(&mut self.inverse);
        self.small.resize(sheet.couplings.small.len(), 0.0);
        self.large.resize(sheet.couplings.large.len(), 0.0);
    }
}

impl Work {
    pub(super) fn new(m: usize, n: usize) -> Self {
        let rectangle = || vec![0.0; m * n];
        Self {
            stale: true,
            sheet: SheetWork::default(),
            by_p: rectangle(),
            by_q: rectangle(),
            by_k: rectangle(),
            by_rest: Vec::new(),
            direction: rectangle(),
            a: rectangle(),
            b: rectangle(),
            c: rectangle(),
            square: vec![0.0; m * m],
            square_too: vec![0.0; m * m],
            along_small: vec![0.0; m],
            along_large: vec![0.0; n],
            along_large_too: vec![0.0; n],
        }
    }
}

fn partials(point: &mut LumpedPoint) {
    if !point.work.stale {
        return;
    }
    let mut work = std::mem::replace(&mut point.work, Work::new(0, 0));
    if let Some(sheet) = &point.sheet {
        work.sheet.set(sheet, point.large);
    }
    if point.potentials.is_some() {
        let taxels = point.small * point.large;
        work.by_rest.resize(taxels, Default::default());
    }
    point.each_partial(|at, by| {
        (work.by_p[at], work.by_q[at]) = if point.transposed {
            (by.q, by.p)
        } else {
            (by.p, by.q)
        };
        work.by_k[at] = by.k;
        if let Some(rest) = work.by_rest.get_mut(at) {
            *rest = if point.transposed {
                [by.column, by.row]
            } else {
                [by.row, by.column]
            };
        }
    });
    work.stale = false;
    point.work = work;
}

/// From a direction to dd (`along_large`), dH (`a`) and dS (`square`). With a sheet dT is the diagonal dd and the
/// Laplacian of the changes of the larger side's couplings.
fn schur_change(point: &mut LumpedPoint, direction: &[f64]) {
    let (m, n) = (point.small, point.large);
    let LumpedPoint {
        inverse_d,
        h,
        work: w,
        transposed,
        sheet,
        conductance,
        ..
    } = point;
    LumpedPoint::gather(*transposed, m, n, direction, &mut w.direction);
    // dd (per line of the larger side) and the row sums of the direction.
    w.along_large.fill(0.0);
    for (i, line) in w.direction.chunks_exact(n).enumerate() {
        w.along_small[i] = line.iter().sum();
        for (sum, value) in w.along_large.iter_mut().zip(line) {
            *sum += value;
        }
    }
    if let Some(sheet) = sheet {
        let (small, large) = (&mut w.sheet.small, &mut w.sheet.large);
        let couplings = &sheet.couplings;
        couplings.changes(conductance, &w.direction, small, large);
    }
    // a = dH = (V − H dT) T⁻¹ ; b = V − ½ H dT.
    for ((a, b), (h, v)) in (w.a.chunks_exact_mut(n).zip(w.b.chunks_exact_mut(n)))
        .zip(h.chunks_exact(n).zip(w.direction.chunks_exact(n)))
    {
        for ((moved, h), dd) in a.iter_mut().zip(h).zip(&w.along_large) {
            *moved = h * dd;
        }
        if sheet.is_some() {
            add_laplacian(&w.sheet.large, h, a);
        }
        for ((a, b), v) in a.iter_mut().zip(b).zip(v) {
            *b = v - 0.5 * *a;
            *a = v - *a;
        }
    }
    divide(sheet.as_ref(), inverse_d, &mut w.a);
    // square = dS = diag(V1) − (b Hᵀ + H bᵀ).
    multiply(
        ViewMut::new(&mut w.square_too, m, m),
        View::new(&w.b, m, n),
        View::new(h, m, n).transpose(),
    );
    for i in 0..m {
        for j in 0..m {
            w.square[i * m + j] = -(w.square_too[i * m + j] + w.square_too[j * m + i]);
        }
        w.square[i * m + i] += w.along_small[i];
    }
    if sheet.is_some() {
        for (i, change) in w.sheet.small.iter().enumerate() {
            let at = i * m + i;
            w.square[at] += change;
            w.square[at + 1] -= change;
            w.square[at + m] -= change;
            w.square[at + m + 1] += change;
        }
    }
}

/// −(T⁻¹ dT T⁻¹)_jj, in place of dd.
fn large_side_change(w: &mut Work, inverse_d: &[f64], sheet: bool) {
    if !sheet {
        for (sum, inverse) in w.along_large.iter_mut().zip(inverse_d) {
            *sum *= -inverse * inverse;
        }
        return;
    }
    let (dd, of_sheet) = (&w.along_large, &w.sheet);
    for (j, line) in of_sheet.inverse.chunks_exact(dd.len()).enumerate() {
        let own: f64 = line.iter().zip(dd).map(|(u, dd)| u * u * dd).sum();
        let between = line.windows(2).zip(&of_sheet.large);
        let along: f64 = between.map(|(u, c)| (u[0] - u[1]).powi(2) * c).sum();
        w.along_large_too[j] = -(own + along);
    }
    std::mem::swap(&mut w.along_large, &mut w.along_large_too);
}

/// J·v.
pub(super) fn forward(point: &mut LumpedPoint, direction: &[f64], out: &mut [f64]) {
    partials(point);
    schur_change(point, direction);
    let (m, n) = (point.small, point.large);
    let LumpedPoint {
        inverse_d,
        h,
        p,
        k,
        work: w,
        sheet,
        potentials,
        ..
    } = point;
    // c ← dK = P (dH − dS K).
    w.b.copy_from_slice(&w.a);
    multiply_add(
        ViewMut::new(&mut w.b, m, n),
        View::new(&w.square, m, m),
        View::new(k, m, n),
        -1.0,
    );
    multiply(
        ViewMut::new(&mut w.c, m, n),
        View::new(p, m, m),
        View::new(&w.b, m, n),
    );
    // dP_rr = −(P dS P)_rr.
    multiply(
        ViewMut::new(&mut w.square_too, m, m),
        View::new(p, m, m),
        View::new(&w.square, m, m),
    );
    for i in 0..m {
        let line = i * m..(i + 1) * m;
        w.along_small[i] = -w.square_too[line.clone()]
            .iter()
            .zip(&p[line])
            .map(|(a, b)| a * b)
            .sum::<f64>();
    }
    // dQ = −T⁻¹ dT T⁻¹ + Σ (dH K + H dK).
    large_side_change(w, inverse_d, sheet.is_some());
    for at_line in 0..m {
        for j in 0..n {
            let at = at_line * n + j;
            w.along_large[j] += w.a[at] * k[at] + h[at] * w.c[at];
        }
    }
    if let Some(potentials) = potentials {
        let solved = LumpedPoint::solved(p, h, inverse_d, sheet);
        let couplings = [&w.sheet.small[..], &w.sheet.large[..]];
        potentials.move_along(solved, &w.direction, couplings);
    }
    write_change(point, out);
}

/// Change of V_out from those of P_rr, Q_cc, K and the potentials.
fn write_change(point: &LumpedPoint, out: &mut [f64]) {
    let (m, n, w) = (point.small, point.large, &point.work);
    for i in 0..m {
        for j in 0..n {
            let at = i * n + j;
            let taxel = if point.transposed { j * m + i } else { at };
            out[taxel] = w.by_p[at] * w.along_small[i]
                + w.by_q[at] * w.along_large[j]
                + w.by_k[at] * w.c[at];
            if let Some(potentials) = &point.potentials {
                out[taxel] += potentials.change_of(at, &w.by_rest[at]);
            }
        }
    }
}

/// From weights to the gradients by P_rr (`along_small`), Q_cc (`along_large`), K (`a`), d
/// (`along_large_too`) and, as far as Q hangs on it, H (`b`).
fn gradients(point: &mut LumpedPoint, weights: &[f64]) {
    let (m, n) = (point.small, point.large);
    let LumpedPoint {
        inverse_d,
        h,
        k,
        work: w,
        transposed,
        sheet,
        ..
    } = point;
    LumpedPoint::gather(*transposed, m, n, weights, &mut w.direction);
    w.along_large.fill(0.0);
    for i in 0..m {
        let mut sum = 0.0;
        for j in 0..n {
            let at = i * n + j;
            sum += w.by_p[at] * w.direction[at];
            w.along_large[j] += w.by_q[at] * w.direction[at];
        }
        w.along_small[i] = sum;
    }
    for i in 0..m {
        for j in 0..n {
            let at = i * n + j;
            w.a[at] = w.by_k[at] * w.direction[at] + h[at] * w.along_large[j];
            w.b[at] = k[at] * w.along_large[j];
        }
    }
    if sheet.is_some() {
        large_side_gradient(w);
        return;
    }
    for ((by_d, by_q), inverse) in w
        .along_large_too
        .iter_mut()
        .zip(&w.along_large)
        .zip(inverse_d.iter())
    {
        *by_d = -by_q * inverse * inverse;
    }
}

/// The gradient by d (`along_large_too`) and by the couplings of the larger side, as far as Q hangs on T⁻¹ itself.
fn large_side_gradient(w: &mut Work) {
    w.along_large_too.fill(0.0);
    w.sheet.large.fill(0.0);
    let lines = w.sheet.inverse.chunks_exact(w.along_large.len());
    for (line, by_q) in lines.zip(&w.along_large) {
        for (by_d, u) in w.along_large_too.iter_mut().zip(line) {
            *by_d -= by_q * u * u;
        }
        for (by_coupling, u) in w.sheet.large.iter_mut().zip(line.windows(2)) {
            *by_coupling -= by_q * (u[0] - u[1]).powi(2);
        }
    }
}

/// Jᵀ·w.
pub(super) fn adjoint(point: &mut LumpedPoint, weights: &[f64], out: &mut [f64]) {
    partials(point);
    gradients(point, weights);
    let (m, n) = (point.small, point.large);
    let LumpedPoint { p, k, work: w, .. } = point;
    // c = P · (gradient by K): joins the gradient by H; with −c Kᵀ − P diag(by P) P it is the one by S.
    multiply(
        ViewMut::new(&mut w.c, m, n),
        View::new(p, m, m),
        View::new(&w.a, m, n),
    );
    for i in 0..m {
        for j in 0..m {
            w.square_too[i * m + j] = p[i * m + j] * w.along_small[j];
        }
    }
    multiply(
        ViewMut::new(&mut w.square, m, m),
        View::new(&w.square_too, m, m),
        View::new(p, m, m),
    );
    multiply_add(
        ViewMut::new(&mut w.square, m, m),
        View::new(&w.c, m, n),
        View::new(k, m, n).transpose(),
        1.0,
    );
    for value in &mut w.square {
        *value = -*value;
    }
    symmetrise(&mut w.square, m);
    through_h(point);
    let LumpedPoint {
        work: w,
        transposed,
        ..
    } = point;
    if *transposed {
        for (at, value) in w.c.iter().enumerate() {
            out[(at % n) * m + at / n] = *value;
        }
    } else {
        out.copy_from_slice(&w.c);
    }
}

/// From the gradients by S, H and d to that by the conductances (`c`).
fn through_h(point: &mut LumpedPoint) {
    let (m, n) = (point.small, point.large);
    let LumpedPoint {
        inverse_d,
        h,
        p,
        work: w,
        sheet,
        conductance,
        potentials,
        ..
    } = point;
    // a ← (gradient by S) H; b ← (gradient by H) T⁻¹.
    multiply(
        ViewMut::new(&mut w.a, m, n),
        View::new(&w.square, m, m),
        View::new(h, m, n),
    );
    for (b, c) in w.b.iter_mut().zip(&w.c) {
        *b += c;
    }
    divide(sheet.as_ref(), inverse_d, &mut w.b);
    for i in 0..m {
        for j in 0..n {
            let at = i * n + j;
            w.along_large_too[j] += h[at] * (w.a[at] - w.b[at]);
        }
    }
    for i in 0..m {
        for j in 0..n {
            let at = i * n + j;
            w.c[at] = w.square[i * m + i] - 2.0 * w.a[at] + w.b[at] + w.along_large_too[j];
        }
    }
    if sheet.is_some() {
        coupling_gradient(w, h, m, n);
    }
    if let Some(potentials) = potentials {
        let solved = LumpedPoint::solved(p, h, inverse_d, sheet);
        let couplings = [&mut w.sheet.small[..], &mut w.sheet.large[..]];
        let weights = (&w.direction[..], &w.by_rest[..]);
        potentials.add_gradient(solved, weights, &mut w.c, couplings);
    }
    if let Some(sheet) = sheet {
        let (small, large) = (&w.sheet.small, &w.sheet.large);
        let couplings = &sheet.couplings;
        couplings.add_gradient(conductance, small, large, &mut w.c);
    }
}

/// The gradient by the couplings of both sides: that by S and by T, through their Laplacians.
fn coupling_gradient(w: &mut Work, h: &[f64], m: usize, n: usize) {
    let s = &w.square;
    for (i, by_coupling) in w.sheet.small.iter_mut().enumerate() {
        let at = i * m + i;
        *by_coupling = s[at] + s[at + m + 1] - 2.0 * s[at + 1];
    }
    for i in 0..m {
        for (j, by_coupling) in w.sheet.large.iter_mut().enumerate() {
            let at = i * n + j;
            let by_t = |at: usize| w.a[at] - w.b[at];
            *by_coupling += (h[at] - h[at + 1]) * (by_t(at) - by_t(at + 1));
        }
    }
}
