//! The exact derivative of the scan, matrix-free: the algorithm of `linear.rs` differentiated line by line,
//! forwards (J·v) and backwards (Jᵀ·w). A handful of m×m×n products each, as the scan itself.

use super::linear::{LinearPoint, symmetrise};
use taxel_linalg::{View, ViewMut, multiply, multiply_add};

/// Scratch and the partial derivatives of V_out by P_rr, Q_cc, K_rc.
pub(super) struct Work {
    pub(super) stale: bool,
    by_p: Vec<f64>,
    by_q: Vec<f64>,
    by_k: Vec<f64>,
    direction: Vec<f64>,
    a: Vec<f64>,
    b: Vec<f64>,
    c: Vec<f64>,
    square: Vec<f64>,
    square_too: Vec<f64>,
    along_small: Vec<f64>,
    along_large: Vec<f64>,
    along_large_too: Vec<f64>,
}

impl Work {
    pub(super) fn new(m: usize, n: usize) -> Self {
        let rectangle = || vec![0.0; m * n];
        Self {
            stale: true,
            by_p: rectangle(),
            by_q: rectangle(),
            by_k: rectangle(),
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

fn partials(point: &mut LinearPoint) {
    if !point.work.stale {
        return;
    }
    let mut work = std::mem::replace(&mut point.work, Work::new(0, 0));
    point.each(|at, _, row, column, p, q| {
        let (by_row, by_column, by_k) = point.ends.volts_partials(row, column, p, q, point.k[at]);
        (work.by_p[at], work.by_q[at]) = if point.transposed {
            (by_column, by_row)
        } else {
            (by_row, by_column)
        };
        work.by_k[at] = by_k;
    });
    work.stale = false;
    point.work = work;
}

/// From a direction to dd (`along_large`), dH (`a`) and dS (`square`).
fn schur_change(point: &mut LinearPoint, direction: &[f64]) {
    let (m, n) = (point.small, point.large);
    let LinearPoint {
        inverse_d,
        h,
        work: w,
        transposed,
        ..
    } = point;
    LinearPoint::gather(*transposed, m, n, direction, &mut w.direction);
    // dd (per line of the larger side) and the row sums of the direction.
    w.along_large.fill(0.0);
    for (i, line) in w.direction.chunks_exact(n).enumerate() {
        w.along_small[i] = line.iter().sum();
        for (sum, value) in w.along_large.iter_mut().zip(line) {
            *sum += value;
        }
    }
    // a = dH = (V − H dd)/d ; b = V − ½ H dd.
    for i in 0..m {
        for (j, inverse) in inverse_d.iter().enumerate() {
            let at = i * n + j;
            let moved = h[at] * w.along_large[j];
            w.a[at] = (w.direction[at] - moved) * inverse;
            w.b[at] = w.direction[at] - 0.5 * moved;
        }
    }
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
}

/// J·v.
pub(super) fn forward(point: &mut LinearPoint, direction: &[f64], out: &mut [f64]) {
    partials(point);
    schur_change(point, direction);
    let (m, n) = (point.small, point.large);
    let LinearPoint {
        inverse_d,
        h,
        p,
        k,
        work: w,
        transposed,
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
    // dQ = −dd/d² + Σ (dH K + H dK).
    for (sum, inverse) in w.along_large.iter_mut().zip(inverse_d.iter()) {
        *sum *= -inverse * inverse;
    }
    for at_line in 0..m {
        for j in 0..n {
            let at = at_line * n + j;
            w.along_large[j] += w.a[at] * k[at] + h[at] * w.c[at];
        }
    }
    for i in 0..m {
        for j in 0..n {
            let at = i * n + j;
            let taxel = if *transposed { j * m + i } else { at };
            out[taxel] = w.by_p[at] * w.along_small[i]
                + w.by_q[at] * w.along_large[j]
                + w.by_k[at] * w.c[at];
        }
    }
}

/// From weights to the gradients by P_rr (`along_small`), Q_cc (`along_large`), K (`a`), d
/// (`along_large_too`) and, as far as Q hangs on it, H (`b`).
fn gradients(point: &mut LinearPoint, weights: &[f64]) {
    let (m, n) = (point.small, point.large);
    let LinearPoint {
        inverse_d,
        h,
        k,
        work: w,
        transposed,
        ..
    } = point;
    LinearPoint::gather(*transposed, m, n, weights, &mut w.direction);
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
    for ((by_d, by_q), inverse) in w
        .along_large_too
        .iter_mut()
        .zip(&w.along_large)
        .zip(inverse_d.iter())
    {
        *by_d = -by_q * inverse * inverse;
    }
}

/// Jᵀ·w.
pub(super) fn adjoint(point: &mut LinearPoint, weights: &[f64], out: &mut [f64]) {
    partials(point);
    gradients(point, weights);
    let (m, n) = (point.small, point.large);
    let LinearPoint {
        inverse_d,
        h,
        p,
        k,
        work: w,
        transposed,
        ..
    } = point;
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
    // a ← (gradient by S) H; b ← gradient by H.
    multiply(
        ViewMut::new(&mut w.a, m, n),
        View::new(&w.square, m, m),
        View::new(h, m, n),
    );
    for i in 0..m {
        for (j, inverse) in inverse_d.iter().enumerate() {
            let at = i * n + j;
            w.b[at] += w.c[at];
            w.along_large_too[j] += h[at] * (w.a[at] - w.b[at] * inverse);
        }
    }
    for i in 0..m {
        for (j, inverse) in inverse_d.iter().enumerate() {
            let at = i * n + j;
            let taxel = if *transposed { j * m + i } else { at };
            out[taxel] =
                w.square[i * m + i] - 2.0 * w.a[at] + w.b[at] * inverse + w.along_large_too[j];
        }
    }
}
